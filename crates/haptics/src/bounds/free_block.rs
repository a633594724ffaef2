//! Stability of a free handle and a free block that swing against each other on the coupling.
//!
//! The force of a sample acts over the coming period, on average T/2 plus the delay late. Against a stuck block the handle
//! has all of its damping: K (T/2 + d) < B + b. Against a sliding block it has less of b and more of B; for small T, with
//! s = M/(m + M):
//!
//! K (T/2 + d) < B/s + b s
//!
//! which can be smaller than B + b, down to 2√(Bb). At the other end of the spectrum a block of [thesis, eq. 4.22 to 4.24]
//! reverses every period if KT² + 2BT (1 + M/m) > 4M: of the two terms in [thesis, eq. 4.35] only the damping depends on the
//! compliance of the handle. This module approximates neither. The characteristic polynomial is in δ = z − 1, where all terms
//! are positive and nothing cancels, then in s = δ/(2 + δ) for Routh's conditions. `f32` is sufficient.
//!
//! Units are T and m, as in delay.rs. With the handle's transfer functions X/F = n_x/(z (δ + ℓ) δ) and
//! V/F = n_v/(z (δ + ℓ)), ℓ = 1 − E, and ρ = m/M:
//!
//! z δ² (δ + ℓ) + K (δ n_x + ρ P_K z (δ + ℓ)) + B (δ² n_v + ρ δ P_B z (δ + ℓ)) = 0
//!
//! with P_K = z, P_B = 1 for a block stepped by [thesis, eq. 4.22 to 4.24], and P_K = (1 + δ/2)², P_B = 1 + δ/2 for a coupling
//! in the middle of the period (stopping force).

use super::delay::Free;
use friction::Scalar;

/// A free handle and a free block.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FreeBlock<S> {
    /// Mass of the handle m, kg.
    pub device_mass: S,
    /// Viscous damping of the handle b, N·s/m. Above zero.
    pub device_damping: S,
    /// Control period T, s.
    pub period: S,
    /// Delay from sample to force, s. At most one period.
    pub delay: S,
    /// Mass of the block M, kg.
    pub mass: S,
    /// Whether the block is that of the stopping-force renderer. If not, that of [thesis, eq. 4.22 to 4.24].
    pub midpoint: bool,
}

/// Coefficients of 1, δ, … δ⁴.
type Polynomial<S> = [S; 5];

fn times<S: Scalar>(a: &Polynomial<S>, b: &[S]) -> Polynomial<S> {
    let mut product = [S::zero(); 5];
    for (i, &x) in a.iter().enumerate() {
        for (into, &y) in product.iter_mut().skip(i).zip(b) {
            *into += x * y;
        }
    }
    product
}

impl<S: Scalar> FreeBlock<S> {
    /// Characteristic polynomial as [constant part, part of K, part of B].
    fn parts(&self) -> [Polynomial<S>; 3] {
        let (zero, one, half) = (S::zero(), S::one(), S::lit(0.5));
        let x = self.device_damping * self.period / self.device_mass;
        let d = (self.delay / self.period).clamp(zero, one);
        let (old, new) = (Free::over(d, x), Free::over(one - d, x));
        let alpha = old.alpha + old.e * new.alpha;
        let lost = x * alpha;
        // effect of the force from its sample on, and of its rest in the next period
        let (gamma, beta) = (new.gamma, new.beta);
        let gamma_both = gamma + old.gamma * new.e;
        let beta_both = beta + old.beta + old.gamma * new.alpha;
        let free = [lost, one + lost, one, zero, zero]; // z (δ + ℓ)
        let rho = self.device_mass / self.mass;
        let (pull, drag): ([S; 3], [S; 2]) = if self.midpoint {
            ([one, one, half * half], [one, half])
        } else {
            ([one, one, zero], [one, zero])
        };
        let mut stiffness = times(&free, &pull).map(|c| rho * c);
        let mut damping = times(&times(&free, &drag), &[zero, rho]);
        let handle = [alpha * gamma_both + beta_both * lost, alpha * gamma + beta_both + beta * lost, beta];
        for (into, n) in stiffness.iter_mut().skip(1).zip(handle) {
            *into += n;
        }
        for (into, n) in damping.iter_mut().skip(2).zip([gamma_both, gamma]) {
            *into += n;
        }
        [times(&free, &[zero, zero, one]), stiffness, damping]
    }

    /// Routh's conditions on the polynomial, K and B in units of m and T.
    fn holds([own, stiff, damp]: &[Polynomial<S>; 3], k: S, b: S) -> bool {
        let c: Polynomial<S> = core::array::from_fn(|i| match (own.get(i), stiff.get(i), damp.get(i)) {
            (Some(&o), Some(&s), Some(&d)) => o + k * s + b * d,
            _ => S::zero(),
        });
        let n = |x: f64| S::lit(x);
        // δ = 2s/(1 − s): Σ c_i (2s)^i (1 − s)^(4−i)
        let [c0, c1, c2, c3, c4] = c;
        let a0 = c0;
        let a1 = n(2.0) * c1 - n(4.0) * c0;
        let a2 = n(6.0) * (c0 - c1) + n(4.0) * c2;
        let a3 = n(6.0) * c1 - n(4.0) * c0 + n(8.0) * (c3 - c2);
        let a4 = c0 - n(2.0) * c1 + n(4.0) * c2 - n(8.0) * c3 + n(16.0) * c4;
        let zero = S::zero();
        [a0, a1, a2, a3, a4].into_iter().all(|a| a > zero) && a1 * (a2 * a3 - a1 * a4) > a0 * a3 * a3
    }

    /// Whether every motion of handle against block decays with this coupling, N/m and N·s/m.
    #[must_use]
    pub fn is_stable(&self, stiffness: S, damping: S) -> bool {
        let (per_period, t) = (self.period / self.device_mass, self.period);
        Self::holds(&self.parts(), stiffness * per_period * t, damping * per_period)
    }

    /// Largest stable stiffness at this damping, N/m, at most `most`. 0 if none is stable.
    #[must_use]
    pub fn stiffness_max(&self, damping: S, most: S) -> S {
        let per_period = self.period / self.device_mass;
        let parts = self.parts();
        let stable = |k: S| Self::holds(&parts, k * per_period * self.period, damping * per_period);
        if stable(most) {
            return most;
        }
        let (mut low, mut high) = (S::zero(), most);
        for _ in 0..30 {
            let middle = S::lit(0.5) * (low + high);
            if stable(middle) { low = middle } else { high = middle }
        }
        low
    }
}

#[cfg(test)]
mod tests {
    use super::super::{ClosedLoop, Grasp};
    use super::*;
    use std::println;

    /// Low-discrepancy numbers between 0 and 1.
    fn shares(n: u32) -> [f64; 7] {
        [2, 3, 5, 7, 11, 13, 17].map(|base: u32| {
            let (mut n, mut share, mut sum) = (n, 1.0, 0.0);
            while n > 0 {
                share /= f64::from(base);
                sum += share * f64::from(n % base);
                n /= base;
            }
            sum
        })
    }

    /// A pair within the accepted range, with B.
    fn pair(n: u32) -> (FreeBlock<f64>, f64) {
        let [a, b, c, d, e, f, g] = shares(n + 1);
        let log = |x: f64, low: f64, high: f64| low * (high / low).powf(x);
        let pair = FreeBlock {
            device_mass: log(a, 0.1, 2.0),
            device_damping: log(b, 0.5, 30.0),
            period: [1e-3, 5e-4, 1e-4, 5e-5][(4.0 * c) as usize],
            delay: [0.0, 2e-5, 3.3e-5][(3.0 * d) as usize],
            mass: log(e, 0.01, 5.0),
            midpoint: g > 0.5,
        };
        let delay = pair.delay.min(pair.period);
        (FreeBlock { delay, ..pair }, log(f, 0.3, 200.0))
    }

    /// Stability from the matrix, an independent derivation.
    fn radius(p: &FreeBlock<f64>, stiffness: f64, damping: f64) -> f64 {
        let closed = ClosedLoop {
            device_mass: p.device_mass,
            device_damping: p.device_damping,
            period: p.period,
            delay: p.delay,
            grasp: Grasp::default(),
            stiffness,
            damping,
        };
        if p.midpoint { closed.radius_sliding_stopping_force(p.mass) } else { closed.radius_sliding(p.mass) }
    }

    #[test]
    fn bound_is_where_the_spectral_radius_crosses_one() {
        let (mut bounded, mut none) = (0, 0);
        for n in 0..2_000 {
            let (pair, b) = pair(n);
            let most = pair.stiffness_max(b, 1e7);
            if most == 0.0 {
                none += 1;
                assert!(radius(&pair, 1.0, b) > 1.0 - 1e-9, "{pair:?} {b}");
                continue;
            }
            bounded += usize::from(most < 1e7);
            for share in [0.01, 0.3, 0.9, 0.999] {
                let inside = radius(&pair, share * most, b);
                assert!(inside < 1.0, "{pair:?} B {b}: {inside} at {share} of {most}");
            }
            if most < 1e7 {
                let outside = radius(&pair, 1.001 * most, b);
                assert!(outside > 1.0, "{pair:?} B {b}: {outside} above {most}");
            }
        }
        println!("2000 pairs: {bounded} bounded below 10 MN/m, {none} take no coupling");
        assert!(bounded > 1_000);
    }

    #[test]
    fn single_precision_gives_the_same_bound() {
        let mut worst = 0.0_f64;
        for n in 0..2_000 {
            let (pair, b) = pair(n);
            let exact = pair.stiffness_max(b, 1e7);
            let single = FreeBlock {
                device_mass: pair.device_mass as f32,
                device_damping: pair.device_damping as f32,
                period: pair.period as f32,
                delay: pair.delay as f32,
                mass: pair.mass as f32,
                midpoint: pair.midpoint,
            };
            let found = f64::from(single.stiffness_max(b as f32, 1e7));
            if exact > 1.0 {
                let off = (found / exact - 1.0).abs();
                if off > worst {
                    worst = off;
                    println!("{pair:?} B {b}: {exact} {found}");
                }
            }
        }
        println!("f32 against f64: {worst:.1e}");
        assert!(worst < 1e-3);
    }

    #[test]
    fn short_periods_match_the_continuous_pair() {
        // K (T/2 + d) < B/s + b s for the midpoint block, to first order in T
        for (m, b, block, coupling) in [(0.7, 30.0, 0.3, 1.0), (0.7, 7.0, 0.1, 2.0), (1.0, 20.0, 2.0, 0.5)] {
            let t = 1e-5;
            let pair = FreeBlock {
                device_mass: m,
                device_damping: b,
                period: t,
                delay: 0.5 * t,
                mass: block,
                midpoint: true,
            };
            let s = block / (m + block);
            // the midpoint of the block compensates the delay of half a period
            let told = (coupling / s + b * s) / (0.5 * t + pair.delay);
            let found: f64 = pair.stiffness_max(coupling, 1e9);
            println!(
                "M {block} B {coupling}: {found:.0} N/m, continuous {told:.0}, stuck {:.0}",
                (b + coupling) / t
            );
            assert!((found / told - 1.0).abs() < 0.02);
        }
    }
}
