//! The stiffness a handle takes when the force comes a while after the sample, from the sampled closed loop itself.
//!
//! State (x, v, F₋₁) with the force of the step before acting until the delay d ≤ T is over and −K·x − B·v after it:
//!
//! x' = x + α(T) v + β₁ F₋₁ + β₀ F,  v' = E v + γ₁ F₋₁ + γ₀ F,  E = e^(−bT/m)
//!
//! with α, β, γ of eq. 4.17 over the parts of the period (Åström and Wittenmark, *Computer-Controlled Systems*, 3.2).

use super::stiffness_max;

/// What the device does in one period.
struct Sampled {
    e: f64,
    alpha: f64,
    beta: [f64; 2],
    gamma: [f64; 2],
}

impl Sampled {
    fn new(mass: f64, damping: f64, period: f64, delay: f64) -> Self {
        // far below what any bearing has, and above where the differences below lose their digits
        let damping = damping.max(1e-5 * mass / period);
        let lost = |t: f64| -libm::expm1(-damping * t / mass);
        let alpha = |t: f64| mass / damping * lost(t);
        let beta = |t: f64| (t - alpha(t)) / damping;
        let (whole, rest) = (lost(period) / damping, lost(period - delay) / damping);
        Self {
            e: 1.0 - lost(period),
            alpha: alpha(period),
            beta: [beta(period - delay), beta(period) - beta(period - delay)],
            gamma: [rest, whole - rest],
        }
    }

    /// a₀, a₁, a₂ of z³ + a₂z² + a₁z + a₀; each linear in K.
    fn polynomial(&self, k: f64, b: f64) -> [f64; 3] {
        let Self { e, alpha, beta: [beta_0, beta_1], gamma: [gamma_0, gamma_1] } = *self;
        let (m00, m01, m10, m11) = (1.0 - beta_0 * k, alpha - beta_0 * b, -gamma_0 * k, e - gamma_0 * b);
        [
            -(beta_1 * (m11 * k - m10 * b) + gamma_1 * (m00 * b - m01 * k)),
            m00 * m11 - m01 * m10 + beta_1 * k + gamma_1 * b,
            -(m00 + m11),
        ]
    }
}

/// Where c₀ + c₁t + c₂t², positive at `from`, is first zero beyond it.
fn first_zero([c0, c1, c2]: [f64; 3], from: f64) -> f64 {
    let beyond = |t: f64| if t > from { t } else { f64::INFINITY };
    if c2 == 0.0 {
        return beyond(-c0 / c1);
    }
    let discriminant = c1 * c1 - 4.0 * c2 * c0;
    if !(discriminant >= 0.0) {
        return f64::INFINITY;
    }
    // without the difference of what is nearly equal
    let q = -0.5 * (c1 + if c1 < 0.0 { -libm::sqrt(discriminant) } else { libm::sqrt(discriminant) });
    beyond(q / c2).min(beyond(c0 / q))
}

/// Largest stiffness K, N/m, that a handle held by K·x + B·ẋ takes when the force acts `delay` s after the sample,
/// with an exact velocity. Delays beyond one period count as one. Zero where B alone is already too much. Without
/// delay it is [`stiffness_max`].
///
/// Jury's conditions are linear and quadratic in K: the bound is the first zero of any of them, no search.
#[must_use]
pub fn stiffness_max_delayed(mass: f64, damping: f64, period: f64, coupling_damping: f64, delay: f64) -> f64 {
    let most = stiffness_max(mass, damping, period, coupling_damping);
    if !(delay > 0.0) || !(most > 0.0) {
        return most;
    }
    let sampled = Sampled::new(mass, damping, period, delay.min(period));
    // K = t·most
    let at_0 = sampled.polynomial(0.0, coupling_damping);
    let at_1 = sampled.polynomial(most, coupling_damping);
    let a = |i: usize| (at_0[i], at_1[i] - at_0[i]);
    let ((p0, q0), (p1, q1), (p2, q2)) = (a(0), a(1), a(2));
    // 1 − a₀² ∓ (a₁ − a₀a₂)
    let (base, cross) =
        ([1.0 - p0 * p0, -2.0 * p0 * q0, -q0 * q0], [p1 - p0 * p2, q1 - p0 * q2 - q0 * p2, -q0 * q2]);
    let conditions = [
        [1.0 + p2 + p1 + p0, q2 + q1 + q0, 0.0],
        [1.0 - p2 + p1 - p0, q1 - q2 - q0, 0.0],
        [1.0 - p0, -q0, 0.0],
        [1.0 + p0, q0, 0.0],
        [base[0] - cross[0], base[1] - cross[1], base[2] - cross[2]],
        [base[0] + cross[0], base[1] + cross[1], base[2] + cross[2]],
    ];
    // at K = 0 the free handle's pole is on the unit circle, so the start is a little beyond it
    let start = 1e-6;
    let mut t = f64::INFINITY;
    for c in conditions {
        if !(c[0] + start * (c[1] + start * c[2]) > 0.0) {
            return 0.0;
        }
        t = t.min(first_zero(c, start));
    }
    if t.is_finite() { t * most } else { most }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::println;

    /// Ratio of the energy of the last tenth of a free swing to the first, by stepping the equation of motion in
    /// sub-steps of 1/500 period, not by the matrix.
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
    fn without_delay_it_is_the_closed_form_and_a_short_one_is_near_it() {
        for b in [0.0, 3.0, 15.0, 100.0] {
            let free = stiffness_max(1.0, 10.0, 1e-3, b);
            assert_eq!(stiffness_max_delayed(1.0, 10.0, 1e-3, b, 0.0), free);
            let short = stiffness_max_delayed(1.0, 10.0, 1e-3, b, 1e-9);
            assert!((short / free - 1.0).abs() < 1e-4, "{short} {free}");
        }
        assert!(stiffness_max_delayed(1.0, 0.0, 1e-3, 10.0, 2e-5) > 0.0);
        assert_eq!(stiffness_max_delayed(1.0, 10.0, 1e-3, 1e5, 2e-5), 0.0);
    }
}
