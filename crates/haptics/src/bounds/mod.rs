//! Closed-form stability and limit-cycle bounds [thesis, ch. 4].
//!
//! The device is [thesis, eq. 4.14] (mass m, damping b) sampled with period T through a zero-order hold, so E = e^(−T/τ) and
//! τ = m/b. The printed forms lose four digits at x = bT/m = 0.01 and are 0/0 without damping. Here they are written without
//! cancellation, so that `f32` is sufficient: on the device `f64` is software and takes 10 kB of flash. Nothing here runs in
//! the control step.

mod closed_loop;
mod delay;
mod free_block;

pub use closed_loop::{ClosedLoop, Grasp};
pub use delay::stiffness_max_delayed;
pub use free_block::FreeBlock;

use friction::Scalar;

/// Largest gain K_p of the stuck state, N/m: b(1−E)/(τ−τE−TE), from [thesis, eq. 4.18]. The printed [thesis, eq. 4.19] is
/// wrong.
///
/// ```
/// // m = 1 kg, b = 10 N·s/m, T = 1 ms: "about 20,000" [thesis, ch. 4.5]
/// assert!((haptics::bounds::kp_max(1.0_f64, 10.0, 1e-3) - 20_033.4).abs() < 0.05);
/// ```
#[must_use]
pub fn kp_max<S: Scalar>(mass: S, damping: S, period: S) -> S {
    stiffness_max(mass, damping, period, S::zero())
}

/// Smallest gain K_p, N/m, that follows a force of `frequency` Hz: the natural frequency of the stuck handle is 20 times as
/// high, K = m (20·2πf)² [thesis, ch. 4.5.1.3].
#[must_use]
pub fn kp_min(mass: f64, frequency: f64) -> f64 {
    let natural = 20.0 * core::f64::consts::TAU * frequency;
    mass * natural * natural
}

/// Largest stable stiffness K, N/m, of a handle held by K·x + B·ẋ, with an exact velocity and no delay. Equals [`kp_max`] for
/// `coupling_damping` = 0. Zero if `coupling_damping` alone is unstable.
#[must_use]
pub fn stiffness_max<S: Scalar>(mass: S, damping: S, period: S, coupling_damping: S) -> S {
    stiffness_max_delayed(mass, damping, period, coupling_damping, S::zero())
}

/// Largest stable damping of the sampled device without stiffness, N·s/m: b(1+E)/(1−E).
#[must_use]
pub fn damping_max<S: Scalar>(mass: S, damping: S, period: S) -> S {
    friction_max(mass, damping, period, S::one())
}

/// Largest dynamic friction without the zero-crossing limit cycle on the bare device, N, for a dead band `dv`, m/s:
/// b·DV·(1+E)/(1−E) [thesis, eq. 4.21]. The printed minus sign is a direction.
#[must_use]
pub fn friction_max<S: Scalar>(mass: S, damping: S, period: S, dv: S) -> S {
    let free = delay::Free::over(S::one(), damping * period / mass);
    // γ = (1 − E)m/bT
    mass / period * dv * (S::one() + free.e) / free.gamma
}

/// Velocity amplitude of the zero-crossing limit cycle with the virtual coupling and a fixed handle, m/s: 2FT/(4M − KT² − 2BT)
/// [thesis, eq. 4.35]. Infinite at and beyond the singularity, where the block itself is unstable.
#[must_use]
pub fn limit_cycle_velocity<S: Scalar>(friction: S, mass: S, stiffness: S, damping: S, period: S) -> S {
    let two = S::lit(2.0);
    let room = two * two * mass - stiffness * period * period - two * damping * period;
    if room > S::zero() { two * friction * period / room } else { S::lit(f64::INFINITY) }
}

/// Position amplitude of the same limit cycle, m: vT/2 by [thesis, eq. 4.31]. The printed [thesis, eq. 4.36] is twice as large.
#[must_use]
pub fn limit_cycle_position<S: Scalar>(friction: S, mass: S, stiffness: S, damping: S, period: S) -> S {
    limit_cycle_velocity(friction, mass, stiffness, damping, period) * period / S::lit(2.0)
}

/// Coupling damping B, N·s/m, at which [thesis, eq. 4.35] is singular: (4M − KT²)/2T.
#[must_use]
pub fn damping_singular<S: Scalar>(mass: S, stiffness: S, period: S) -> S {
    (S::lit(4.0) * mass - stiffness * period * period) / (S::lit(2.0) * period)
}

/// Coupling stiffness K, N/m, at which [thesis, eq. 4.35] is singular: (4M − 2BT)/T².
#[must_use]
pub fn stiffness_singular<S: Scalar>(mass: S, damping: S, period: S) -> S {
    (S::lit(4.0) * mass - S::lit(2.0) * damping * period) / (period * period)
}

/// Margin of the passivity condition b > KT/2 + B [colgate-1997], N·s/m. At zero or above the coupling is passive with *any*
/// hand. The condition is sufficient, not necessary: a grasp adds damping.
#[must_use]
pub fn passivity_margin<S: Scalar>(damping: S, stiffness: S, coupling_damping: S, period: S) -> S {
    damping - (stiffness * period / S::lit(2.0) + coupling_damping)
}

/// Whether the admittance renderer is stable in hands from released to firm, 0.3 kg, 15 N·s/m and 1 500 N/m at the scale of the
/// default device, with none to a tenth of the handle beyond the load cell.
#[cfg(feature = "admittance")]
#[must_use]
pub fn admittance_is_stable(device: &crate::Device, stiffness: f32, damping: f32, mass: f32) -> bool {
    let wide = |x: f32| f64::from(x);
    let [held, resists, springs] = [0.3, 15.0, 1_500.0].map(|x| wide(device.inertia(x)));
    // a light grip is not between a released handle and a firm one
    [0.0, 0.015, 0.03, 0.05, 0.08, 0.12, 0.18, 0.25, 0.35, 0.5, 0.7, 1.0].iter().all(|share| {
        let closed = ClosedLoop {
            device_mass: wide(device.mass),
            device_damping: wide(device.damping),
            period: wide(device.period),
            delay: wide(device.delay),
            grasp: Grasp { mass: share * held, damping: share * resists, stiffness: share * springs },
            stiffness: wide(stiffness),
            damping: wide(damping),
        };
        [0.0, 0.1]
            .iter()
            .all(|beyond| closed.radius_admittance(wide(mass) / 1.001, beyond * wide(device.mass)) < 1.0)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::println;

    const T: f64 = 1e-3;

    #[test]
    fn printed_numbers_are_reproduced() {
        let kp = kp_max(1.0, 10.0, T);
        let friction = friction_max(1.0, 10.0, T, 0.02);
        let singular = damping_singular(0.5, 10_000.0, T);
        let cycle = limit_cycle_velocity(4.0, 0.5, 10_000.0, 10.0, T);
        let table_5_3 = limit_cycle_velocity(2.0, 0.5, 25_000.0, 10.0, T);
        println!(
            "K_p max {kp:.1} N/m (20 033.4), F_d max {friction:.2} N (40.0), B singular {singular:.1} N·s/m (995)"
        );
        println!("limit cycle {:.3} mm/s (4.06), table 5-3 {:.3} mm/s (2.05)", cycle * 1e3, table_5_3 * 1e3);
        assert!((kp - 20_033.4).abs() < 0.05);
        assert!((friction - 40.0).abs() < 0.05);
        assert!((singular - 995.0).abs() < 1e-9);
        assert!((cycle * 1e3 - 4.06).abs() < 0.005);
        assert!((table_5_3 * 1e3 - 2.05).abs() < 0.005);
        assert!((limit_cycle_position(4.0, 0.5, 10_000.0, 10.0, T) - cycle * T / 2.0).abs() < 1e-15);
        assert!((stiffness_singular(0.5, 995.0, T) - 10_000.0).abs() < 1e-6);
        assert_eq!(limit_cycle_velocity(4.0, 0.5, 10_000.0, 995.0, T), f64::INFINITY);
    }

    /// Spectral radius of the closed loop, from the matrix itself, not from the closed form.
    fn radius(mass: f64, damping: f64, k: f64, b: f64) -> f64 {
        let tau = mass / damping;
        let e = (-T / tau).exp();
        let (alpha, gamma) = (tau * (1.0 - e), (1.0 - e) / damping);
        let beta = (T - alpha) / damping;
        let trace = 1.0 - beta * k + e - gamma * b;
        let det = (1.0 - beta * k) * (e - gamma * b) + gamma * k * (alpha - beta * b);
        let disc = trace * trace / 4.0 - det;
        if disc < 0.0 { det.sqrt() } else { trace.abs() / 2.0 + disc.sqrt() }
    }

    #[test]
    fn stiffness_bound_is_where_poles_become_unstable() {
        for (mass, damping) in [(1.0, 10.0), (0.692, 6.92), (0.692, 1.0), (0.1, 30.0), (2.0, 0.05)] {
            for b in [0.0, 3.0, 15.0, 100.0] {
                let limit = stiffness_max(mass, damping, T, b);
                if limit == 0.0 {
                    assert!(radius(mass, damping, 1.0, b) > 1.0);
                    continue;
                }
                let (below, above) =
                    (radius(mass, damping, 0.999 * limit, b), radius(mass, damping, 1.001 * limit, b));
                println!("m {mass} b {damping} B {b}: K max {limit:.1} N/m, radius {below:.6} / {above:.6}");
                assert!(below < 1.0 && above > 1.0);
            }
        }
    }

    #[test]
    fn without_damping_the_bounds_stay_finite_and_continuous() {
        assert_eq!(kp_max(1.0, 0.0, T), 0.0);
        for damping in [1e-12, 1e-9, 1e-6, 1e-3, 0.04, 0.0501, 49.9, 50.1] {
            let k = kp_max(1.0, damping, T);
            println!("b {damping:e}: K_p max {k:e} N/m, 2b/T = {:e}", 2.0 * damping / T);
            assert!((k / (2.0 * damping / T) - 1.0).abs() < 0.02, "2b/T is the limit for small b");
            assert!((friction_max(1.0, damping, T, 0.02) - 40.0).abs() < 0.05);
        }
        assert!((stiffness_max(1.0, 0.0, T, 10.0) - 2.0 * 10.0 / T).abs() < 200.0);
    }

    #[test]
    fn limit_cycle_of_table_4_1_follows_eq_4_21() {
        // one step from v = DV under dynamic friction alone, [thesis, eq. 4.20]
        let (mass, damping, dv) = (1.0, 10.0, 0.02);
        let force = friction_max(mass, damping, T, dv);
        let e = (-T * damping / mass).exp();
        let next = -force / damping + (dv + force / damping) * e;
        assert!((next + dv).abs() < 1e-9, "reaches exactly −DV");
    }
}
