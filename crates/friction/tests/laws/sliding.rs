//! The right force in steady sliding, and the right terminal velocity under a constant load.

use crate::common::{Block, MASS, close, coulomb, dahl, laws, lugre, rubber};
use friction::{FrictionLaw, Law, LuGre, Motion, Surface};

/// Level and viscous coefficient by direction, from the parameters alone.
fn line(law: &Law<f64>, positive: bool) -> (f64, f64) {
    let surface = Surface::of(law);
    if positive { (surface.dynamic_p, surface.damping_p) } else { (surface.dynamic_n, surface.damping_n) }
}

#[test]
fn steady_sliding_force() {
    for (law, ..) in laws() {
        for v in [-0.5, -0.1, 0.1, 0.5_f64] {
            let (level, viscous) = line(&law, v > 0.0);
            let expected = v.signum() * (level + viscous * v.abs());
            for mass in [0.0, MASS] {
                let mut state = Default::default();
                let mut force = 0.0;
                for _ in 0..1000 {
                    let motion =
                        Motion { dt: 1e-3, displacement: v * 1e-3, velocity: v, mass, ..Motion::default() };
                    force = law.step(&mut state, &motion);
                }
                println!("{:8} v {v:+.1} m/s, mass {mass}: {force:+.9} N, expected {expected:+.9}", law.id());
                assert!(close(force, expected, 1e-12));
            }
        }
    }
}

#[test]
fn terminal_velocity() {
    for (law, ..) in laws() {
        for load in [-8.0, 8.0_f64] {
            let (level, viscous) = line(&law, load > 0.0);
            let expected = load.signum() * (load.abs() - level) / viscous;
            let mut block = Block::new(law, MASS, 1e-3);
            for _ in 0..5000 {
                block.push(load);
            }
            println!("{:8} under {load:+} N: {:+.9} m/s, expected {expected:+.9}", law.id(), block.v);
            assert!(close(block.v, expected, 1e-9));
        }
    }
}

#[test]
fn friction_that_falls_with_speed_never_drives() {
    // brass, [thesis, table 3-3] run 2: b_p = −1.58, the line crosses zero at 1.07 m/s
    let law = friction::Karnopp { c_p: 1.6814, b_p: -1.5778, ..rubber() };
    let at = |velocity| law.step(&mut (), &Motion { dt: 1e-3, velocity, ..Motion::default() });
    assert!(close(at(0.5), 1.6814 - 0.5 * 1.5778, 1e-12));
    assert_eq!(at(5.0), 0.0);
    assert!(law.validate().is_ok());
}

#[test]
fn lugre_follows_its_stribeck_curve() {
    let law = LuGre { sigma_2: 0.0, ..lugre() };
    for v in [0.001, 0.005, 0.01, 0.02, 0.1] {
        let mut state = Default::default();
        let mut force = 0.0;
        for _ in 0..20_000 {
            let motion = Motion { dt: 1e-3, displacement: v * 1e-3, velocity: v, ..Motion::default() };
            force = law.step(&mut state, &motion);
        }
        let expected = 3.0 + 0.4 * f64::exp(-(v / 0.01) * (v / 0.01));
        println!("v {v}: {force:.6} N, expected {expected:.6}");
        assert!(close(force, expected, 1e-9));
    }
}

#[test]
fn parameters_out_of_range_are_named() {
    let refused = |law: Law<f64>| law.validate().expect_err("must be refused").parameter;
    assert_eq!(refused(Law::Karnopp(friction::Karnopp { c_p: f64::NAN, ..rubber() })), "c_p");
    assert_eq!(refused(Law::Karnopp(friction::Karnopp { delta_v: -0.1, ..rubber() })), "delta_v");
    assert_eq!(refused(Law::Coulomb(friction::Coulomb { static_p: 3.0, ..coulomb() })), "static_p");
    assert_eq!(refused(Law::Dahl(friction::Dahl { sigma: 0.0, ..dahl() })), "sigma");
    assert_eq!(refused(Law::Dahl(friction::Dahl { exponent: -1.0, ..dahl() })), "exponent");
    assert_eq!(refused(Law::LuGre(LuGre { stiction: 2.9, ..lugre() })), "stiction");
    assert_eq!(refused(Law::LuGre(LuGre { sigma_0: f64::INFINITY, ..lugre() })), "sigma_0");
    for (law, ..) in laws() {
        law.validate().expect("the examples are valid");
    }
    let said = friction::Coulomb { static_p: 3.0, ..coulomb() }.validate().expect_err("refused");
    assert_eq!(said.to_string(), "static_p = 3: accepted from 3.4901 to 1000000");
}
