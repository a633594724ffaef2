//! Spectral radius of the sampled closed loop of handle, hand, virtual coupling and block, which the closed forms
//! approximate.

/// A passive hand on the handle. `default()` is a released handle.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Grasp {
    /// Mass that moves with the handle, kg.
    pub mass: f64,
    /// Damping to ground, N·s/m.
    pub damping: f64,
    /// Stiffness to ground, N/m.
    pub stiffness: f64,
}

/// Linear loop of handle, hand, coupling and block. Friction is either stuck or absent.
///
/// ```text
/// (m + m_h) ẍ + (b + b_h) ẋ + k_h x = F     between samples, exactly, F(k) from t + delay on [thesis, eq. 4.14, 4.15]
/// F(k) = −K (x(k) − p(k)) − B (v(k) − w(k))    [thesis, eq. 4.24]
/// w(k+1) = w(k) − T/M F(k),  p(k+1) = p(k) + T w(k+1)   [thesis, eq. 4.22, 4.23]; p = w = 0 while stuck
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ClosedLoop {
    /// Mass of the handle m, kg.
    pub device_mass: f64,
    /// Viscous damping of the handle b, N·s/m.
    pub device_damping: f64,
    /// Control period T, s.
    pub period: f64,
    /// Delay from sample to force, s. At most one period.
    pub delay: f64,
    /// The hand.
    pub grasp: Grasp,
    /// Stiffness of the coupling K, N/m.
    pub stiffness: f64,
    /// Damping of the coupling B, N·s/m.
    pub damping: f64,
}

type Matrix<const N: usize> = [[f64; N]; N];

fn product<const N: usize>(a: &Matrix<N>, b: &Matrix<N>) -> Matrix<N> {
    core::array::from_fn(|i| core::array::from_fn(|j| (0..N).map(|k| a[i][k] * b[k][j]).sum()))
}

fn largest<const N: usize>(a: &Matrix<N>) -> f64 {
    a.iter().flatten().fold(0.0, |most: f64, x| most.max(x.abs()))
}

/// Largest magnitude of an eigenvalue: lim ‖Aⁿ‖^(1/n) (Gelfand), n = 2⁵⁰ by squaring.
fn spectral_radius<const N: usize>(mut a: Matrix<N>) -> f64 {
    let mut log = 0.0;
    let mut weight = 1.0;
    for _ in 0..50 {
        let scale = largest(&a);
        if !(scale > 0.0) {
            return scale;
        }
        a = a.map(|row| row.map(|x| x / scale));
        log += weight * libm::log(scale);
        a = product(&a, &a);
        weight *= 0.5;
    }
    libm::exp(log)
}

impl ClosedLoop {
    /// Transition of the handle (x, v) over `t` s with constant force f, [[x x, x v, x f], [v x, v v, v f], [0 0 1]]: e^(At) by
    /// Taylor's series on t/2ⁿ, squared n times.
    fn handle(&self, t: f64) -> Matrix<3> {
        let mass = self.device_mass + self.grasp.mass;
        let (c, k) = ((self.device_damping + self.grasp.damping) / mass, self.grasp.stiffness / mass);
        let mut h = t;
        let mut halvings = 0;
        while h * (1.0 + c + libm::sqrt(k)) > 0.1 && halvings < 60 {
            h *= 0.5;
            halvings += 1;
        }
        let step = [[0.0, h, 0.0], [-k * h, -c * h, h / mass], [0.0; 3]];
        let mut term: Matrix<3> = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let mut sum = term;
        for n in 1..14 {
            term = product(&term, &step).map(|row| row.map(|x| x / f64::from(n)));
            for (into, from) in sum.iter_mut().flatten().zip(term.iter().flatten()) {
                *into += from;
            }
        }
        for _ in 0..halvings {
            sum = product(&sum, &sum);
        }
        sum
    }

    /// Transition of (x, v) over one period under the forces of the previous and the present step.
    fn sampled(&self) -> ([[f64; 2]; 2], [f64; 2], [f64; 2]) {
        let delay = self.delay.clamp(0.0, self.period);
        let (first, rest) = (self.handle(delay), self.handle(self.period - delay));
        let free = core::array::from_fn(|i| {
            core::array::from_fn(|j| rest[i][0] * first[0][j] + rest[i][1] * first[1][j])
        });
        let before = core::array::from_fn(|i| rest[i][0] * first[0][2] + rest[i][1] * first[1][2]);
        (free, before, core::array::from_fn(|i| rest[i][2]))
    }

    /// Spectral radius with the block held by friction. Below 1 every motion decays; at 1 some motion persists (a handle
    /// without stiffness coasts); above 1 it grows.
    #[must_use]
    pub fn radius_stuck(&self) -> f64 {
        let (free, before, now) = self.sampled();
        let (k, b) = (self.stiffness, self.damping);
        let row = |i: usize| [free[i][0] - now[i] * k, free[i][1] - now[i] * b, before[i]];
        spectral_radius([row(0), row(1), [-k, -b, 0.0]])
    }

    /// Spectral radius with a free block of `mass` kg stepped by [thesis, eq. 4.22 to 4.24]. The common drift of handle and
    /// block without a holding hand, an eigenvalue of exactly 1, is left out.
    #[must_use]
    pub fn radius_sliding(&self, mass: f64) -> f64 {
        let (k, b) = (self.stiffness, self.damping);
        // of (x, v, p, w, previous F)
        self.radius_free(mass, [-k, -b, k, b, 0.0], 0.0)
    }

    /// Spectral radius with the block of the stopping-force renderer, whose coupling acts in the middle of the period:
    /// F(k) = −(K (x − p) + B v − (KT/2 + B) w)/(1 + cT/M), c = KT/4 + B/2, p(k+1) = p(k) + T (w(k) + w(k+1))/2.
    #[must_use]
    pub fn radius_sliding_stopping_force(&self, mass: f64) -> f64 {
        let (k, b, t) = (self.stiffness, self.damping, self.period);
        let shared = 1.0 + t / mass * (0.25 * k * t + 0.5 * b);
        let force = [-k, -b, k, 0.5 * k * t + b, 0.0].map(|x| x / shared);
        self.radius_free(mass, force, 0.5)
    }

    /// Spectral radius of the admittance renderer with a free block of `mass` kg that the load cell moves; `beyond` kg of the
    /// handle are between load cell and hand [keemink-2018]:
    ///
    /// ```text
    /// F(k) = −μ u(k−1) + (μ (b + b_h) − b_h) v + (μ − 1) k_h x,   μ = (m_h + m_b)/(m + m_h)
    /// w(k+1) = w + T/M F,  p(k+1) = p + T w(k+1),  u(k) = K (p(k+1) − x) + B (w(k+1) − v)
    /// ```
    ///
    /// The common drift and, released, the coasting of handle and block are left out. The cell sees the hand's spring and
    /// damper and the inertia of what is beyond it, under the force that acts at the sample.
    #[must_use]
    pub fn radius_admittance(&self, mass: f64, beyond: f64) -> f64 {
        let (free, before, now) = self.sampled();
        let (k, b, t) = (self.stiffness, self.damping, self.period);
        let Grasp { mass: held, damping, stiffness } = self.grasp;
        let share = (held + beyond) / (self.device_mass + held);
        // of (x, v, p, w, previous u)
        let unit = |at: usize| -> [f64; 5] { core::array::from_fn(|j| f64::from(u8::from(j == at))) };
        let cell =
            [(share - 1.0) * stiffness, share * (self.device_damping + damping) - damping, 0.0, 0.0, -share];
        let speed: [f64; 5] = core::array::from_fn(|j| unit(3)[j] + t / mass * cell[j]);
        let place: [f64; 5] = core::array::from_fn(|j| unit(2)[j] + t * speed[j]);
        let force: [f64; 5] =
            core::array::from_fn(|j| k * (place[j] - unit(0)[j]) + b * (speed[j] - unit(1)[j]));
        let handle = |i: usize| -> [f64; 5] {
            let own = [free[i][0], free[i][1], 0.0, 0.0, before[i]];
            core::array::from_fn(|j| own[j] + now[i] * force[j])
        };
        let (x, v) = (handle(0), handle(1));
        if stiffness > 0.0 {
            return spectral_radius([x, v, place, speed, force]);
        }
        // (x − p, v, w, previous u): the common drift is left out
        let relative = |row: [f64; 5]| [row[0], row[1], row[3], row[4]];
        let apart = core::array::from_fn(|j| x[j] - place[j]);
        let mut released = [relative(apart), relative(v), relative(speed), relative(force)];
        if !(damping > 0.0) {
            // a block without friction coasts, and should: its eigenvalue of 1 is deflated
            let coasting = [t - self.device_damping / k, 1.0, 1.0, self.device_damping];
            for (row, share) in released.iter_mut().zip(coasting) {
                row[2] -= share;
            }
        }
        spectral_radius(released)
    }

    /// Spectral radius with a free block under −`force`. Its position advances with the given share of the old velocity and
    /// the rest of the new one.
    fn radius_free(&self, mass: f64, force: [f64; 5], old: f64) -> f64 {
        let (free, before, now) = self.sampled();
        let t = self.period;
        let handle = |i: usize| -> [f64; 5] {
            let own = [free[i][0], free[i][1], 0.0, 0.0, before[i]];
            core::array::from_fn(|j| own[j] + now[i] * force[j])
        };
        let speed: [f64; 5] = core::array::from_fn(|j| f64::from(u8::from(j == 3)) - t / mass * force[j]);
        let place: [f64; 5] = core::array::from_fn(|j| {
            let is = |at: usize| f64::from(u8::from(j == at));
            is(2) + t * (old * is(3) + (1.0 - old) * speed[j])
        });
        let (x, v) = (handle(0), handle(1));
        if self.grasp.stiffness > 0.0 {
            return spectral_radius([x, v, place, speed, force]);
        }
        // (x − p, v, w, previous F)
        let relative = |row: [f64; 5]| [row[0], row[1], row[3], row[4]];
        let apart = core::array::from_fn(|j| x[j] - place[j]);
        spectral_radius([relative(apart), relative(v), relative(speed), relative(force)])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bounds;
    use std::println;

    const T: f64 = 1e-3;

    fn held(mass: f64, damping: f64, delay: f64, stiffness: f64, coupling: f64) -> ClosedLoop {
        ClosedLoop {
            device_mass: mass,
            device_damping: damping,
            period: T,
            delay,
            grasp: Grasp::default(),
            stiffness,
            damping: coupling,
        }
    }

    #[test]
    fn radius_is_the_largest_eigenvalue() {
        // 0.9·(rotation by 1) and a Jordan block of 0.5
        let (s, c) = (1.0_f64.sin(), 1.0_f64.cos());
        let a = [
            [0.9 * c, -0.9 * s, 0.0, 0.0],
            [0.9 * s, 0.9 * c, 0.0, 0.0],
            [0.0, 0.0, 0.5, 1.0],
            [0.0, 0.0, 0.0, 0.5],
        ];
        assert!((spectral_radius(a) - 0.9).abs() < 1e-12);
        assert!((spectral_radius([[0.5, 1.0], [0.0, 0.5]]) - 0.5).abs() < 1e-12);
        assert_eq!(spectral_radius([[0.0; 2]; 2]), 0.0);
    }

    #[test]
    fn closed_forms_bound_a_stuck_handle() {
        for (mass, damping) in [(1.0, 10.0), (0.692, 6.92), (0.1, 30.0), (2.0, 0.05)] {
            for (delay, b) in [(0.0, 0.0), (0.0, 15.0), (2e-5, 15.0), (1e-3, 5.0)] {
                let limit = bounds::stiffness_max_delayed(mass, damping, T, b, delay);
                if limit == 0.0 {
                    continue;
                }
                let below = held(mass, damping, delay, 0.999 * limit, b).radius_stuck();
                let above = held(mass, damping, delay, 1.001 * limit, b).radius_stuck();
                println!("m {mass} b {damping} d {delay} B {b}: K {limit:.1} N/m, {below:.7} / {above:.7}");
                assert!(below < 1.0 && above > 1.0);
            }
        }
    }

    #[test]
    fn a_held_handle_is_unstable_at_eq_4_35() {
        // a vice instead of a hand
        let vice = Grasp { mass: 1e9, damping: 0.0, stiffness: 0.0 };
        for (mass, b) in [(0.5, 10.0), (0.5, 300.0), (0.05, 3.0)] {
            let limit = bounds::stiffness_singular(mass, b, T);
            let at = |k: f64| ClosedLoop { grasp: vice, ..held(1.0, 10.0, 0.0, k, b) }.radius_sliding(mass);
            println!("M {mass} B {b}: K {limit:.0} N/m, {:.6} / {:.6}", at(0.999 * limit), at(1.001 * limit));
            assert!(at(0.999 * limit) <= 1.0 + 1e-6 && at(1.001 * limit) > 1.0 + 1e-5);
        }
    }

    /// Ratio of the largest motion in the last and the first tenth of a simulated free motion, by small steps.
    fn growth(c: &ClosedLoop, block: f64, stopping_force: bool) -> f64 {
        const FINE: u32 = 400;
        let h = c.period / f64::from(FINE);
        let mass = c.device_mass + c.grasp.mass;
        let (damping, spring) = (c.device_damping + c.grasp.damping, c.grasp.stiffness);
        let (mut x, mut v, mut p, mut w, mut held) = (0.0, 0.1, 0.0, 0.0, 0.0);
        let (mut early, mut late) = (0.0_f64, 0.0_f64);
        for n in 0..4000 {
            let force = if stopping_force {
                // w⁺ from M (w⁺ − w)/T = F_c with the coupling at the middle of the period
                let half = 0.25 * c.stiffness * c.period + 0.5 * c.damping;
                let pull = c.stiffness * (x - p) + c.damping * v;
                let inertia = block / c.period;
                let after = (pull + (inertia - half) * w) / (inertia + half);
                let force = half * (w + after) - pull;
                p += 0.5 * c.period * (w + after);
                w = after;
                force
            } else {
                let force = -c.stiffness * (x - p) - c.damping * (v - w);
                w -= c.period / block * force;
                p += c.period * w;
                force
            };
            for s in 0..FINE {
                let acting = if f64::from(s) * h < c.delay { held } else { force };
                v += h * (acting - damping * v - spring * x) / mass;
                x += h * v;
            }
            held = force;
            let size = (x - p).abs() * c.stiffness + (v - w).abs();
            if !(size < 1e12) {
                return f64::INFINITY;
            }
            if n < 400 {
                early = early.max(size);
            } else if n >= 3600 {
                late = late.max(size);
            }
        }
        late / early
    }

    #[test]
    fn spectral_radius_separates_growth_from_decay() {
        for (grasp, delay, block, b) in [
            (Grasp::default(), 0.0, 0.4, 15.0),
            (Grasp::default(), 1e-3, 0.4, 15.0),
            (Grasp { mass: 0.2, damping: 5.0, stiffness: 300.0 }, 2e-5, 0.5, 10.0),
            (Grasp { mass: 1.0, damping: 30.0, stiffness: 1000.0 }, 1e-3, 0.1, 10.0),
        ] {
            let at = |k: f64| ClosedLoop { grasp, ..held(0.692, 6.92, delay, k, b) };
            for stopping_force in [false, true] {
                let radius = |c: ClosedLoop| {
                    if stopping_force {
                        c.radius_sliding_stopping_force(block)
                    } else {
                        c.radius_sliding(block)
                    }
                };
                let (mut low, mut high) = (10.0, 1e7);
                while high / low > 1.0001 {
                    let k = f64::sqrt(low * high);
                    if radius(at(k)) < 1.0 { low = k } else { high = k }
                }
                let grows = |share: f64| growth(&at(share * low), block, stopping_force);
                let (inside, outside) = (grows(0.97), grows(1.03));
                println!(
                    "{grasp:?} delay {delay}, stopping force {stopping_force}: K {low:.0} N/m; grows by {inside:.1e} inside, {outside:.1e} outside"
                );
                assert!(inside < 0.5 && outside > 2.0);
            }
        }
    }
}
