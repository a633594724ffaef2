//! Effects concealed in an independent plant: named first, or said to be indistinguishable from what is named, or said
//! to be invisible on this motion.

mod plant;

use diagnose::{Options, diagnose};
use plant::{Case, Hidden, Motion, record};

const SEEDS: u64 = 3;

#[test]
fn what_is_concealed_is_named() {
    // forces two to five times the noise of one sample (0.062 N)
    let cases: [(&str, Hidden, Motion); 13] = [
        ("stribeck", Hidden::Stribeck { size: 0.5, speed: 0.02 }, Motion::Multisine),
        ("sublinear_viscous", Hidden::Sublinear { size: 0.5, speed: 0.03 }, Motion::Multisine),
        ("quadratic_drag", Hidden::Quadratic { size: 0.5 }, Motion::Multisine),
        ("spring", Hidden::Spring { size: 0.4 }, Motion::Multisine),
        ("nonlinear_spring", Hidden::Cubic { size: 0.4 }, Motion::Multisine),
        ("cogging", Hidden::Cogging { size: 0.25, wavelength: 0.004 }, Motion::Multisine),
        ("periodic_friction", Hidden::PeriodicFriction { size: 0.25, wavelength: 0.004 }, Motion::Multisine),
        ("position_dependent_friction", Hidden::PositionFriction { size: 0.4 }, Motion::Multisine),
        ("load_dependent_friction", Hidden::LoadShare { size: 0.4 }, Motion::Multisine),
        ("friction_drift", Hidden::Drift { size: 0.4, settle: 4.0 }, Motion::Multisine),
        ("hard_stop", Hidden::Stop { size: 0.6 }, Motion::Multisine),
        ("presliding", Hidden::Bristles { size: 0.6, reach: 3e-4 }, Motion::Multisine),
        ("time_skew", Hidden::Skew { size: 2e-3 }, Motion::Multisine),
    ];
    let (mut first, mut told, mut total) = (0, 0, 0);
    for (id, hidden, motion) in cases {
        let mut said = Vec::new();
        for seed in 0..SEEDS {
            let case =
                Case { hidden: [hidden, Hidden::Nothing], motion, seed: 100 + seed, ..Case::default() };
            let d = diagnose(&[record(&case).0], &[], &Options::default(), &|_, _| ()).expect("a diagnosis");
            total += 1;
            let leading = d.missing.first();
            if leading.is_some_and(|m| m.effect == id) {
                first += 1;
                told += 1;
            } else if leading.is_some_and(|m| m.indistinguishable_from.iter().any(|other| other == id))
                || leading.is_none() && d.blind_to.iter().any(|b| b.effect == id)
            {
                told += 1;
            }
            let named: Vec<&str> = d.missing.iter().map(|m| m.effect.as_str()).collect();
            said.push(if named.is_empty() { "nothing".into() } else { named.join("+") });
        }
        println!("{id:<28} {}", said.join(" | "));
    }
    println!(
        "{first} of {total} named first, {told} counting those said to be indistinguishable or concealed by the motion"
    );
    assert!(told * 10 >= total * 9, "{told} of {total}");
}
