//! Loops of the right area, in closed form.

use crate::common::{along, close, dahl, lugre, triangle};
use friction::{Dahl, FrictionLaw, LuGre, Motion};

/// ∮F dx over a cycle of a triangle, by the trapezoidal rule, and the force at its top. A hundred coarse cycles at
/// the same speed come before, so that the loop is closed.
fn loop_area<L: FrictionLaw<f64>>(law: &L, stroke: f64, steps: usize, dt: f64) -> (f64, f64) {
    let mut state = L::State::default();
    let mut last = 0.0;
    for _ in 0..100 {
        let forces = along(law, &mut state, &triangle(stroke, 1), dt * steps as f64);
        last = forces[1];
    }
    let path = triangle(stroke, steps);
    let forces = along(law, &mut state, &path, dt);
    let mut area = 0.0;
    for (pair, &force) in path.windows(2).zip(&forces) {
        area += 0.5 * (last + force) * (pair[1] - pair[0]);
        last = force;
    }
    (area, forces[steps - 1])
}

#[test]
fn dahl_loop_has_the_closed_form_area() {
    let law = Dahl { limit_n: 3.3122, viscous: 0.0, ..dahl() };
    let kappa = law.sigma / law.limit_p;
    for stroke in [1e-5, 1e-4, 1e-3, 1e-2] {
        let (area, top) = loop_area(&law, stroke, 40_000, 1e-3);
        let turn = f64::tanh(0.5 * kappa * stroke);
        let expected = 2.0 * law.limit_p * (stroke - 2.0 / kappa * turn);
        println!("stroke {stroke:.0e} m: area {area:.6e} J, closed form {expected:.6e}; top {top:.6} N");
        // what the trapezoid loses goes with (κ dx)²
        assert!(close(area / expected, 1.0, 1e-4));
        assert!(close(top, law.limit_p * turn, 1e-9));
    }
}

#[test]
fn asymmetric_dahl_loop_has_the_closed_form_area() {
    let law = Dahl { viscous: 0.0, ..dahl() };
    let (p, n) = (law.limit_p, law.limit_n);
    let (kp, kn) = (law.sigma / p, law.sigma / n);
    for stroke in [5e-5, 2e-4, 1e-2_f64] {
        let (ep, en) = ((-kp * stroke).exp(), (-kn * stroke).exp());
        let top = (p * (1.0 - ep) - ep * n * (1.0 - en)) / (1.0 - ep * en);
        let bottom = n * (1.0 - en) - en * top;
        let expected = p * stroke - (p + bottom) * (1.0 - ep) / kp + n * stroke - (n + top) * (1.0 - en) / kn;
        let (area, measured_top) = loop_area(&law, stroke, 40_000, 1e-3);
        println!("stroke {stroke:.0e} m: area {area:.6e} J, closed form {expected:.6e}");
        assert!(close(area / expected, 1.0, 1e-4));
        assert!(close(measured_top, top, 1e-9));
    }
}

#[test]
fn viscous_friction_adds_its_own_area() {
    let (law, stroke, steps, dt) = (dahl(), 1e-2, 20_000, 1e-3);
    let (with, _) = loop_area(&law, stroke, steps, dt);
    let (without, _) = loop_area(&Dahl { viscous: 0.0, ..law }, stroke, steps, dt);
    let speed = stroke / steps as f64 / dt;
    let expected = 2.0 * law.viscous * speed * stroke;
    println!("viscous area {:.6e} J, b·v·2L = {expected:.6e}", with - without);
    assert!(close((with - without) / expected, 1.0, 1e-3));
}

#[test]
fn dahl_is_independent_of_step_size() {
    for exponent in [0.0, 0.5, 0.9995, 1.0, 1.0005, 1.5, 2.0, 3.0] {
        let law = Dahl { exponent, viscous: 0.0, ..dahl() };
        let (_, fine) = loop_area(&law, 2e-4, 10_000, 1e-3);
        let (_, coarse) = loop_area(&law, 2e-4, 1, 1e-3);
        println!("i = {exponent}: top {fine:.12} N in 10 000 steps, {coarse:.12} N in one");
        assert!(close(fine, coarse, 1e-9));
    }
}

#[test]
fn dahl_solves_its_differential_equation_for_every_exponent() {
    for exponent in [0.3, 0.5, 0.9995, 1.0, 1.0004, 1.2, 2.0, 3.0] {
        let law = Dahl { exponent, viscous: 0.0, ..dahl() };
        // [thesis, eq. 3.2] as printed, by Runge-Kutta in 200 000 steps
        let slope = |z: f64, s: f64| {
            let d = if s > 0.0 { law.limit_p } else { law.limit_n };
            let u = 1.0 - z / d * s;
            law.sigma * u.abs().powf(exponent) * u.signum() * s
        };
        let mut z = 0.0;
        let mut state = Default::default();
        let mut force = 0.0;
        for leg in [8e-5, -1.3e-4, 1e-4_f64] {
            let s = leg.signum();
            let h = leg.abs() / 200_000.0;
            for _ in 0..200_000 {
                let k1 = slope(z, s);
                let k2 = slope(z + 0.5 * h * k1, s);
                let k3 = slope(z + 0.5 * h * k2, s);
                let k4 = slope(z + h * k3, s);
                z += h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
            }
            for _ in 0..3 {
                let motion = Motion { dt: 1e-3, displacement: leg / 3.0, ..Motion::default() };
                force = law.step(&mut state, &motion);
            }
            println!("i = {exponent}, leg {leg:+.1e} m: {force:+.9} N, Runge-Kutta {z:+.9} N");
            assert!(close(force, z, 1e-6));
        }
    }
}

#[test]
fn slow_lugre_loop_is_the_loop_of_dahl() {
    // slow enough that g = F_s and dz/dt → 0: rate-free, limit F_s
    let law = LuGre { sigma_2: 0.0, ..lugre() };
    let kappa = law.sigma_0 / law.stiction;
    for stroke in [3e-5, 1e-4, 1e-3] {
        let (area, _) = loop_area(&law, stroke, 20_000, 1.0);
        let expected = 2.0 * law.stiction * (stroke - 2.0 / kappa * f64::tanh(0.5 * kappa * stroke));
        println!("stroke {stroke:.0e} m: area {area:.6e} J, closed form {expected:.6e}");
        assert!(close(area / expected, 1.0, 1e-4));
    }
}

#[test]
fn fast_lugre_loop_is_smaller_by_the_stribeck_effect() {
    let law = LuGre { sigma_1: 0.0, sigma_2: 0.0, ..lugre() };
    let (slow, _) = loop_area(&law, 1e-3, 10_000, 1.0);
    let (fast, _) = loop_area(&law, 1e-3, 10_000, 1e-6); // 0.1 m/s, ten times v_s
    let expected = |limit: f64| {
        let kappa = law.sigma_0 / limit;
        2.0 * limit * (1e-3 - 2.0 / kappa * f64::tanh(0.5 * kappa * 1e-3))
    };
    println!("{slow:.6e} J slow, {fast:.6e} J fast");
    assert!(close(slow / expected(law.stiction), 1.0, 1e-3));
    assert!(close(fast / expected(law.coulomb), 1.0, 1e-3));
}
