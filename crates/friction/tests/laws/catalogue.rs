//! What every effect says about itself, checked against a table, against its own force and against its files.

use friction::effects::{
    Acts, CATALOGUE, Effect, EffectKind, EffectState, MAX_GAINS, MAX_MEMORY, MAX_SHAPE, Quantity, Scale,
    Seat, SeriesKind, about,
};
use friction::{Dimension, Geometry, Motion};
use std::collections::BTreeSet;

/// Effect, parameter, unit on a slide, unit on an axis.
#[rustfmt::skip]
const UNITS: &[(&str, &str, &str, &str)] = &[
    ("stribeck", "force_p", "N", "N·m"),
    ("stribeck", "force_n", "N", "N·m"),
    ("stribeck", "v_s", "m/s", "rad/s"),
    ("stribeck", "delta", "1", "1"),
    ("sublinear_viscous", "force_p", "N", "N·m"),
    ("sublinear_viscous", "force_n", "N", "N·m"),
    ("sublinear_viscous", "v_0", "m/s", "rad/s"),
    ("sublinear_viscous", "power", "1", "1"),
    ("quadratic_drag", "c_p", "N·s²/m²", "N·m·s²/rad²"),
    ("quadratic_drag", "c_n", "N·s²/m²", "N·m·s²/rad²"),
    ("presliding", "force_p", "N", "N·m"),
    ("presliding", "force_n", "N", "N·m"),
    ("presliding", "x_s", "m", "rad"),
    ("lost_motion", "level_p", "N", "N·m"),
    ("lost_motion", "level_n", "N", "N·m"),
    ("lost_motion", "gap", "m", "rad"),
    ("lost_motion", "x_s", "m", "rad"),
    ("frictional_lag", "force", "N", "N·m"),
    ("frictional_lag", "stribeck", "N", "N·m"),
    ("frictional_lag", "lag", "s", "s"),
    ("frictional_lag", "v_s", "m/s", "rad/s"),
    ("rising_static_friction", "force_p", "N", "N·m"),
    ("rising_static_friction", "force_n", "N", "N·m"),
    ("rising_static_friction", "rest_time", "s", "s"),
    ("rising_static_friction", "x_r", "m", "rad"),
    ("rate_and_state", "a", "1", "m"),
    ("rate_and_state", "b", "1", "m"),
    ("rate_and_state", "force_a", "N", "N·m"),
    ("rate_and_state", "force_b", "N", "N·m"),
    ("rate_and_state", "d_c", "m", "rad"),
    ("rate_and_state", "healing", "1", "1"),
    ("friction_drift", "force_p", "N", "N·m"),
    ("friction_drift", "force_n", "N", "N·m"),
    ("friction_drift", "settling_time", "s", "s"),
    ("position_dependent_friction", "slope_p", "N/m", "N·m/rad"),
    ("position_dependent_friction", "slope_n", "N/m", "N·m/rad"),
    ("position_dependent_friction", "curve_p", "N/m²", "N·m/rad²"),
    ("position_dependent_friction", "curve_n", "N/m²", "N·m/rad²"),
    // the normal load is in N on an axis as well: there µ is a coefficient times the radius of the contact
    ("load_dependent_friction", "mu", "1", "m"),
    ("load_dependent_friction", "share", "1", "1"),
    ("directional_efficiency", "driving", "1", "1"),
    ("directional_efficiency", "back_driven", "1", "1"),
    ("spring", "stiffness", "N/m", "N·m/rad"),
    ("nonlinear_spring", "cubic", "N/m³", "N·m/rad³"),
    ("nonlinear_spring", "quadratic", "N/m²", "N·m/rad²"),
    ("gravity", "sine", "N", "N·m"),
    ("gravity", "cosine", "N", "N·m"),
    ("cogging", "cosine_1", "N", "N·m"),
    ("cogging", "sine_1", "N", "N·m"),
    ("cogging", "cosine_2", "N", "N·m"),
    ("cogging", "sine_2", "N", "N·m"),
    ("cogging", "wavelength", "m", "rad"),
    ("periodic_friction", "cosine", "N", "N·m"),
    ("periodic_friction", "sine", "N", "N·m"),
    ("periodic_friction", "wavelength", "m", "rad"),
    ("torque_ripple", "cosine", "1", "1"),
    ("torque_ripple", "sine", "1", "1"),
    ("torque_ripple", "wavelength", "m", "rad"),
    ("hard_stop", "k_p", "N/m", "N·m/rad"),
    ("hard_stop", "k_n", "N/m", "N·m/rad"),
    ("hard_stop", "x_max", "m", "rad"),
    ("hard_stop", "x_min", "m", "rad"),
    ("offset", "force", "N", "N·m"),
    ("time_skew", "behind", "1", "1"),
    ("time_skew", "ahead", "1", "1"),
    ("time_skew", "tau", "s", "s"),
    ("actuator_lag", "command", "1", "1"),
    ("actuator_lag", "channel", "1", "1"),
    ("actuator_lag", "lag", "s", "s"),
    ("velocity_lag", "force", "N", "N·m"),
    ("velocity_lag", "lag", "s", "s"),
    ("force_gain_asymmetry", "gain", "1", "1"),
    ("encoder_eccentricity", "cosine", "N·s²", "N·m·s²"),
    ("encoder_eccentricity", "sine", "N·s²", "N·m·s²"),
    ("encoder_eccentricity", "wavelength", "m", "rad"),
    ("encoder_eccentricity", "amplitude", "m", "rad"),
    ("encoder_eccentricity", "phase", "rad", "rad"),
    ("compliance", "mass", "kg", "kg·m²"),
    ("compliance", "frequency", "Hz", "Hz"),
    ("compliance", "damping", "1", "1"),
    ("backlash", "mass", "kg", "kg·m²"),
    ("backlash", "gap", "m", "rad"),
    ("saturation", "share", "1", "1"),
    ("saturation", "limit", "N", "N·m"),
    ("anisotropy", "ratio", "1", "1"),
    ("anisotropy", "angle", "rad", "rad"),
    ("accelerometer_error", "gain", "1", "1"),
    ("accelerometer_error", "zero", "m/s²", "rad/s²"),
];

#[test]
fn units_of_every_effect() {
    let mut checked = BTreeSet::new();
    for effect in CATALOGUE {
        let compared = effect.comparison.iter().flat_map(|c| c.parameters);
        for parameter in effect.parameters().chain(compared) {
            let found = UNITS.iter().find(|u| (u.0, u.1) == (effect.id, parameter.name));
            let Some((_, _, slide, axis)) = found else {
                panic!("{}.{} is not in the table", effect.id, parameter.name);
            };
            let unit = |geometry| parameter.unit(geometry).to_string();
            assert_eq!(unit(Geometry::Linear), *slide, "{}.{}", effect.id, parameter.name);
            assert_eq!(unit(Geometry::Rotary), *axis, "{}.{}", effect.id, parameter.name);
            checked.insert((effect.id, parameter.name));
        }
    }
    println!("{} parameters of {} effects", checked.len(), CATALOGUE.len());
    assert_eq!(checked.len(), UNITS.len(), "the table has parameters that no effect has");
}

/// Name, unit on a slide, unit on an axis.
#[rustfmt::skip]
const BODY: &[(&str, &str, &str)] = &[
    ("mass", "kg", "kg·m²"),
    ("coulomb_p", "N", "N·m"), ("coulomb_n", "N", "N·m"), ("coulomb", "N", "N·m"),
    ("viscous_p", "N·s/m", "N·m·s/rad"), ("viscous_n", "N·s/m", "N·m·s/rad"), ("viscous", "N·s/m", "N·m·s/rad"),
    ("static_p", "N", "N·m"), ("static_n", "N", "N·m"),
    ("delta_v", "m/s", "rad/s"),
    ("limit_p", "N", "N·m"), ("limit_n", "N", "N·m"),
    ("sigma", "N/m", "N·m/rad"), ("sigma_1", "N·s/m", "N·m·s/rad"),
    ("exponent", "1", "1"),
    ("stribeck_velocity", "m/s", "rad/s"),
    ("elastic", "1", "1"),
    ("attraction", "N/s", "N·m/s"),
    ("memory", "s", "s"),
    ("dwell", "s", "s"),
    ("steepness", "1", "1"),
    ("offset", "N", "N·m"), ("delay", "s", "s"), ("origin", "m", "rad"), ("friction", "N", "N·m"),
    ("f_static", "N", "N·m"), ("f_static_p", "N", "N·m"), ("f_static_n", "N", "N·m"),
    ("f_dynamic", "N", "N·m"), ("f_dynamic_p", "N", "N·m"), ("f_dynamic_n", "N", "N·m"),
    ("damping", "N·s/m", "N·m·s/rad"), ("damping_p", "N·s/m", "N·m·s/rad"), ("damping_n", "N·s/m", "N·m·s/rad"),
    ("dv", "m/s", "rad/s"),
    ("k_vc", "N/m", "N·m/rad"), ("b_vc", "N·s/m", "N·m·s/rad"),
    ("delay_s", "s", "s"), ("cutoff_hz", "Hz", "Hz"),
];

#[test]
fn units_of_body_laws_and_nuisances() {
    let of = |geometry| friction::parameters::ALL.iter().map(move |p| (p.name, p.unit(geometry).to_string()));
    let found: Vec<_> =
        of(Geometry::Linear).zip(of(Geometry::Rotary)).map(|((n, l), (_, r))| (n, l, r)).collect();
    let expected: Vec<_> = BODY.iter().map(|(n, l, r)| (*n, l.to_string(), r.to_string())).collect();
    assert_eq!(found, expected);
}

#[test]
fn ids_are_unique_and_described() {
    let ids: BTreeSet<&str> = CATALOGUE.iter().map(|e| e.id).collect();
    assert_eq!(ids.len(), CATALOGUE.len());
    for effect in CATALOGUE {
        assert!(!effect.says.is_empty() && !effect.equation.is_empty(), "{}", effect.id);
        assert!(!effect.shows.is_empty() && !effect.told_apart_by.is_empty(), "{}", effect.id);
        let names: BTreeSet<&str> = effect.parameters().map(|p| p.name).collect();
        assert_eq!(names.len(), effect.parameters().count(), "{}", effect.id);
        assert!(effect.gains.len() <= MAX_GAINS && effect.shape.len() <= MAX_SHAPE, "{}", effect.id);
        for parameter in effect.parameters() {
            assert!(parameter.min < parameter.max && !parameter.what.is_empty(), "{}", parameter.name);
        }
        // what is named in the place of another, or cannot be told from it, is there
        for other in effect.case_of.iter().chain(effect.twin.iter().flat_map(|t| t.of)) {
            assert!(about(other).is_some() || friction::parameters::find(other).is_some(), "{other}");
        }
        // what no motion shows is shown by something else
        assert!(effect.shown_by_motion || effect.bench_test.is_some(), "{}", effect.id);
    }
    for &kind in EffectKind::ALL {
        assert_eq!(EffectKind::from_id(kind.id()), Some(kind));
        assert_eq!(kind.about().acts == Acts::OnForce, kind.about().acts.on_whole_force());
    }
    for &kind in SeriesKind::ALL {
        assert_eq!(SeriesKind::from_id(kind.about().id), Some(kind));
    }
}

#[test]
fn equations_name_their_parameters() {
    for effect in CATALOGUE {
        for parameter in effect.parameters() {
            let name = parameter.name;
            // one symbol for both directions
            let stem = name.strip_suffix("_p").or_else(|| name.strip_suffix("_n")).unwrap_or(name);
            let equation = effect.equation;
            assert!(equation.contains(name) || equation.contains(stem), "{} in {equation}", parameter.name);
        }
    }
}

#[test]
fn gain_groups_cover_every_gain() {
    for effect in CATALOGUE.iter().filter(|e| !e.gains.is_empty()) {
        let used: BTreeSet<usize> =
            effect.groups.iter().flat_map(|v| v.iter()).flat_map(|c| c.iter()).copied().collect();
        assert_eq!(used, (0..effect.gains.len()).collect(), "{}", effect.id);
        for variant in effect.groups {
            let gains: Vec<usize> = variant.iter().flat_map(|c| c.iter()).copied().collect();
            let once: BTreeSet<usize> = gains.iter().copied().collect();
            assert_eq!(gains.len(), once.len(), "{}: a gain twice in {variant:?}", effect.id);
        }
        let columns: Vec<usize> = effect.groups.iter().map(|v| v.len()).collect();
        assert!(columns.is_sorted(), "{}: simplest first", effect.id);
    }
}

#[test]
fn shapes_are_searched_and_gains_solved() {
    for effect in CATALOGUE {
        assert!(effect.gains.iter().all(|p| p.scale == Scale::Gain), "{}", effect.id);
        assert!(effect.shape.iter().all(|p| p.scale != Scale::Gain), "{}", effect.id);
        for parameter in effect.shape {
            if let Scale::Place { from, to } = parameter.scale {
                assert!(from < to && to <= 100, "{}", parameter.name);
            }
            // what is tried over its own range has no unit that a recording could set
            let ranged = matches!(parameter.scale, Scale::Range | Scale::Damping);
            let bare = [Dimension::NUMBER, Dimension::PHASE].contains(&parameter.dimension);
            assert_eq!(ranged, bare, "{}.{}", effect.id, parameter.name);
        }
    }
}

/// Force of every gain after two steps, the second one with `change`.
fn response(kind: EffectKind, first: Motion<f64>, second: Motion<f64>) -> Vec<f64> {
    let mut shape = Effect::<f64>::silent(kind).shape;
    for (value, parameter) in shape.iter_mut().zip(kind.shape()) {
        *value = match parameter.scale {
            Scale::Place { from, .. } if from > 50 => 0.001,
            Scale::Place { .. } => -0.001,
            Scale::Range => 1.3,
            _ => 0.01,
        };
    }
    let mut memory = [0.0; MAX_MEMORY];
    kind.unit(&shape, &mut memory, &first);
    let force = kind.unit(&shape, &mut memory, &second);
    force.into_iter().chain(memory).collect()
}

#[test]
fn forces_read_what_they_say() {
    let rest = Motion { dt: 1e-3, position: 0.003, applied: 1.0, normal: Some(4.0), ..Motion::default() };
    let slide = Motion { velocity: 0.01, displacement: 1e-5, ..rest };
    for &kind in EffectKind::ALL {
        let reads = |of: &dyn Fn(Motion<f64>) -> Motion<f64>| {
            [rest, slide]
                .into_iter()
                .any(|base| response(kind, slide, base) != response(kind, slide, of(base)))
        };
        let found: Vec<(Quantity, bool)> = vec![
            (Quantity::Time, reads(&|m| Motion { dt: 2e-3, ..m })),
            (Quantity::Position, reads(&|m| Motion { position: 0.0047, ..m })),
            (Quantity::Displacement, reads(&|m| Motion { displacement: 3e-5, ..m })),
            (Quantity::Velocity, reads(&|m| Motion { velocity: -0.02, ..m })),
            (Quantity::Force, reads(&|m| Motion { applied: -2.0, ..m })),
            (Quantity::Load, reads(&|m| Motion { normal: Some(7.0), ..m })),
        ];
        for (quantity, does) in found {
            assert_eq!(kind.about().reads(quantity), does, "{} reads {quantity:?}: {does}", kind.id());
        }
        assert_eq!(kind.about().is_constant(), kind.about().reads.is_empty());
        assert!(!kind.about().is_instrument(), "{} is a force", kind.id());
    }
}

#[test]
fn what_opposes_motion_brakes_in_both_directions() {
    for &kind in EffectKind::ALL.iter().filter(|k| k.opposes_motion()) {
        let Some(example) = kind.about().example else { continue };
        let effect = Effect { kind, gains: example.gains, shape: example.shape };
        for velocity in [0.02, -0.02] {
            let motion = Motion { dt: 1e-3, velocity, position: 1e-4, ..Motion::default() };
            let force: f64 = effect.step(&mut EffectState::default(), &motion);
            assert!(force * velocity > 0.0, "{} at {velocity} m/s: {force} N", kind.id());
        }
    }
}

#[test]
fn examples_are_valid() {
    let mut count = 0;
    for &kind in EffectKind::ALL {
        if let Some(example) = kind.about().example {
            let effect = Effect { kind, gains: example.gains, shape: example.shape };
            effect.validate().unwrap_or_else(|refused| panic!("{}: {refused}", kind.id()));
            count += 1;
        }
    }
    assert!(count >= 8);
}

#[test]
fn instruments_sit_in_channels() {
    let instruments: Vec<&str> = CATALOGUE.iter().filter(|e| e.is_instrument()).map(|e| e.id).collect();
    assert_eq!(
        instruments,
        [
            "time_skew",
            "velocity_lag",
            "force_gain_asymmetry",
            "encoder_eccentricity",
            "accelerometer_error",
            "force_crosstalk"
        ]
    );
    // a comparison needs a channel
    for effect in CATALOGUE.iter().filter(|e| e.comparison.is_some()) {
        assert!(matches!(effect.seat, Seat::Channel(_)), "{}", effect.id);
    }
}
