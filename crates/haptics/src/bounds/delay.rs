//! Largest stable stiffness with a delay between sample and force, from the sampled closed loop.
//!
//! State (x, v, F₋₁): the force of the previous step acts until the delay d ≤ T has passed, then −K·x − B·v:
//!
//! x' = x + α(T) v + β₁ F₋₁ + β₀ F,  v' = E v + γ₁ F₋₁ + γ₀ F,  E = e^(−bT/m)
//!
//! with α, β, γ of [thesis, eq. 4.17] over the parts of the period [astrom-1997, ch. 3.2].
//! Units are T and m: time in T, damping in m/T, stiffness in m/T². Every coefficient of the characteristic polynomial
//! z³ + a₂z² + a₁z + a₀ is linear in K and B.

use friction::Scalar;

/// Response of a free device to a constant force.
pub(super) struct Free<S> {
    /// Factor on the velocity, e^(−bt/m).
    pub e: S,
    /// Displacement per velocity.
    pub alpha: S,
    /// Displacement per force.
    pub beta: S,
    /// Velocity per force.
    pub gamma: S,
}

impl<S: Scalar> Free<S> {
    /// Response after the time `t`, periods, with a damping that removes the share 1 − e^(−x) of the velocity per period.
    pub fn over(t: S, x: S) -> Self {
        let (one, half) = (S::one(), S::lit(0.5));
        let y = x * t;
        // φ₁ = (1 − e^−y)/y, φ₂ = (1 − φ₁)/y: from φ₃ = (½ − φ₂)/y upwards nothing cancels
        let (e, phi_1, phi_2) = if y < one {
            let (mut term, mut phi_3, mut k) = (S::lit(1.0 / 6.0), S::zero(), S::lit(3.0));
            for _ in 0..18 {
                phi_3 += term;
                k += one;
                term *= -y / k;
            }
            let phi_2 = half - y * phi_3;
            let phi_1 = one - y * phi_2;
            (one - y * phi_1, phi_1, phi_2)
        } else {
            let e = (-y).exp();
            let phi_1 = (one - e) / y;
            (e, phi_1, (one - phi_1) / y)
        };
        Self { e, alpha: t * phi_1, beta: t * t * phi_2, gamma: t * phi_1 }
    }
}

/// A condition c₀ + c₁K + c₂K² > 0.
type Condition<S> = [S; 3];

/// The condition p + qK > 0.
fn linear<S: Scalar>(p: S, q: S) -> Condition<S> {
    [p, q, S::zero()]
}

/// Product of two polynomials that are linear in K.
fn product<S: Scalar>((p, q): (S, S), (r, s): (S, S)) -> Condition<S> {
    [p * r, p * s + q * r, q * s]
}

/// Largest K up to which the condition holds from K = 0.
fn holds_to<S: Scalar>([c0, c1, c2]: Condition<S>) -> S {
    let (zero, never) = (S::zero(), S::lit(f64::INFINITY));
    if !(c0 > zero) {
        return zero;
    }
    let beyond = |k: S| if k > zero { k } else { never };
    if c2 == zero {
        return beyond(-c0 / c1);
    }
    let discriminant = c1 * c1 - S::lit(4.0) * c2 * c0;
    if !(discriminant >= zero) {
        return never;
    }
    // avoids the difference of nearly equal terms
    let root = discriminant.sqrt();
    let q = S::lit(-0.5) * (c1 + if c1 < zero { -root } else { root });
    beyond(q / c2).min(beyond(c0 / q))
}

/// Largest stable stiffness K, N/m, of a handle held by K·x + B·ẋ with a force that acts `delay` s after the sample and an
/// exact velocity. A delay beyond one period counts as one period. Zero if B alone is unstable, or without any damping.
///
/// Jury's conditions are linear and quadratic in K: the bound is their first zero, found without a search. The condition at
/// z = 1 is K times a positive number.
#[must_use]
pub fn stiffness_max_delayed<S: Scalar>(mass: S, damping: S, period: S, coupling_damping: S, delay: S) -> S {
    let (one, two) = (S::one(), S::lit(2.0));
    let per_period = period / mass;
    let (x, b) = (damping * per_period, coupling_damping * per_period);
    let d = (delay / period).clamp(S::zero(), one);
    let (old, new) = (Free::over(d, x), Free::over(one - d, x));
    let e = old.e * new.e;
    // 1 − E, as a sum
    let lost = x * (old.alpha + old.e * new.alpha);
    // effect of the old force on the speed: it acts, then the device coasts
    let gamma_1 = old.gamma * new.e;
    let beta_1 = old.beta + old.gamma * new.alpha;
    // γ₀α − β₀E and γ₁α − β₁E
    let curl_0 = new.gamma * new.alpha + new.e * (new.gamma * old.alpha - new.beta * old.e);
    let curl_1 = new.e * (old.gamma * (new.alpha * (x * old.alpha) + new.e * old.alpha) - old.beta * old.e);
    // each p + qK
    let a0 = (-gamma_1 * b, curl_1);
    let a2 = (new.gamma * b - one - e, new.beta);
    let a1_below_1 = (lost + (new.gamma - gamma_1) * b, -curl_0 - beta_1);
    let sum = (a2.0 + a0.0, a2.1 + a0.1);
    // (1 − a₁) + a₀(a₂ − a₀), and 1 + a₁ − a₀(a₂ + a₀)
    let [c0, c1, c2] = product(a0, (a2.0 - a0.0, a2.1 - a0.1));
    let inner = [a1_below_1.0 + c0, a1_below_1.1 + c1, c2];
    let [c0, c1, c2] = product(a0, sum);
    let outer = [two - a1_below_1.0 - c0, -a1_below_1.1 - c1, -c2];
    // 1 − a₂ + a₁ − a₀
    let flip = linear(two - a1_below_1.0 - sum.0, -a1_below_1.1 - sum.1);
    let conditions = [flip, linear(one - a0.0, -a0.1), linear(one + a0.0, a0.1), inner, outer];
    let k = conditions.into_iter().map(holds_to).fold(S::lit(f64::INFINITY), S::min);
    if k.is_finite() { k * mass / (period * period) } else { S::zero() }
}

#[cfg(test)]
mod tests {
    use super::super::stiffness_max;
    use super::*;
    use std::println;

    /// Ratio of the energies in the last and the first tenth of a free swing, from the equation of motion in sub-steps of
    /// 1/500 period, independent of the matrix.
    fn grows(mass: f64, damping: f64, period: f64, delay: f64, k: f64, b: f64) -> bool {
        const FINE: u32 = 500;
        let h = period / f64::from(FINE);
        let (mut x, mut v, mut acting, mut next) = (1e-3_f64, 0.0_f64, 0.0, 0.0);
        let energy = |x: f64, v: f64| 0.5 * mass * v * v + 0.5 * k * x * x;
        let (mut early, mut late) = (0.0_f64, 0.0_f64);
        let periods = 4_000;
        for n in 0..periods {
            let force = -k * x - b * v;
            for s in 0..FINE {
                if f64::from(s) * h >= delay - 1e-12 {
                    acting = force;
                } else if s == 0 {
                    acting = next;
                }
                // exact for a constant force, to second order in h
                let a = (acting - damping * v) / mass;
                x += v * h + 0.5 * a * h * h;
                v += a * h * (1.0 - 0.5 * damping / mass * h);
            }
            next = force;
            let now = energy(x, v);
            if n < periods / 10 {
                early = early.max(now);
            } else if n >= periods - periods / 10 {
                late = late.max(now);
            }
        }
        late > early
    }

    #[test]
    fn bound_is_where_a_swing_begins_to_grow() {
        for (period, delay, b) in [
            (1e-3, 20e-6, 0.0),
            (1e-3, 20e-6, 15.0),
            (1e-3, 1e-3, 0.0),
            (1e-3, 1e-3, 15.0),
            (1e-4, 20e-6, 15.0),
            (5e-5, 33e-6, 10.0),
        ] {
            let most = stiffness_max_delayed(0.692, 6.92, period, b, delay);
            let free = stiffness_max(0.692, 6.92, period, b);
            println!("T {period} s, delay {delay} s, B {b}: K max {most:.0} N/m, without delay {free:.0}");
            assert!(!grows(0.692, 6.92, period, delay, 0.98 * most, b));
            assert!(grows(0.692, 6.92, period, delay, 1.02 * most, b));
        }
    }

    #[test]
    fn single_precision_gives_the_same_bound() {
        let mut worst = 0.0_f64;
        for (mass, damping) in
            [(0.692, 6.92), (0.692, 1.0), (0.692, 0.01), (0.1, 30.0), (2.0, 0.05), (0.02, 40.0)]
        {
            for period in [1e-3, 5e-4, 1e-4, 5e-5] {
                for delay in [0.0, 20e-6, 33e-6, 1e-3] {
                    for b in [0.0, 0.3, 3.0, 15.0, 60.0, 500.0] {
                        let exact = stiffness_max_delayed(mass, damping, period, b, delay);
                        let [m, d, t, b, l] = [mass, damping, period, b, delay].map(|x| x as f32);
                        let single = f64::from(stiffness_max_delayed(m, d, t, b, l));
                        // where B alone is nearly unstable the bound is a difference
                        if exact > 1.0 {
                            worst = worst.max((single / exact - 1.0).abs());
                        }
                        assert!(
                            (single - exact).abs() <= 1e-5 * exact + 1e-3,
                            "{mass} {damping} {period} {delay} {b}"
                        );
                    }
                }
            }
        }
        println!("f32 against f64: {worst:.1e}");
    }

    #[test]
    fn without_delay_it_is_the_printed_closed_form() {
        let (m, b, t) = (1.0_f64, 10.0, 1e-3);
        for coupling in [0.0, 3.0, 15.0, 100.0] {
            // det < 1 of the sampled device: (1 − E + γB)/(γα − βE), as [thesis, eq. 4.17 and 4.18] print them
            let (tau, e) = (m / b, (-b * t / m).exp());
            let (alpha, gamma) = (tau * (1.0 - e), (1.0 - e) / b);
            let printed = (1.0 - e + gamma * coupling) / (gamma * alpha - (t - alpha) / b * e);
            let free = stiffness_max_delayed(m, b, t, coupling, 0.0);
            assert!((free / printed - 1.0).abs() < 1e-6, "{free} {printed}");
            let short = stiffness_max_delayed(m, b, t, coupling, 1e-9);
            assert!((short / free - 1.0).abs() < 1e-4, "{short} {free}");
        }
        assert!(stiffness_max_delayed(1.0, 0.0, 1e-3, 10.0, 2e-5) > 0.0);
        assert_eq!(stiffness_max_delayed(1.0, 10.0, 1e-3, 1e5, 2e-5), 0.0);
    }
}
