//! Nothing hidden: the answer has to be `no_mismatch`.

mod plant;

use diagnose::{Options, Verdict, diagnose};
use plant::{Case, Motion, record};
use untested::draws;

#[test]
fn nothing_hidden_is_said_to_be_nothing() {
    let mut quiet = 0;
    let mut total = 0;
    for (motion, noise_position, noise_force) in [
        (Motion::Multisine, 1e-6, 0.062),
        (Motion::Sine, 1e-6, 0.062),
        (Motion::Triangle, 1e-6, 0.062),
        (Motion::Chirp, 1e-5, 0.062),
        (Motion::Multisine, 0.0, 0.01),
    ] {
        let mut here = 0;
        for seed in draws(2, 8) {
            let case = Case { motion, noise_position, noise_force, seed, ..Case::default() };
            let d = diagnose(&[record(&case).0], &[], &Options::default(), &|_, _| ()).unwrap();
            let named: Vec<String> = d
                .missing
                .iter()
                .map(|m| {
                    format!(
                        "{} {:.4}→{:.4} p {:.4}",
                        m.effect, m.rms_heldout_before, m.rms_heldout_after, m.p
                    )
                })
                .collect();
            println!(
                "{motion:?} x {noise_position:.0e} F {noise_force}: fc {:.0} Hz, floor {:.4} ({}), rms {:.4}, free run {:?}, {:?} {}",
                d.cutoff_hz,
                d.noise_floor.rms,
                d.noise_floor.how,
                d.baseline.rms_heldout,
                d.after.free_run_error,
                d.verdict,
                named.join(", ")
            );
            here += usize::from(d.verdict == Verdict::NoMismatch);
            total += 1;
        }
        quiet += here;
        println!("{motion:?}: {here} no_mismatch");
    }
    println!("{quiet} of {total} no_mismatch");
    // a triangle at one speed tells Coulomb friction from viscous by its corners only: the hardest of them
    assert!(quiet * 10 >= total * 9, "{quiet} of {total}");
}

/// The experiment of [thesis, ch. 3.5] on each material of [thesis, table 3-3], with the noise of [thesis, table 3-2]: eight runs of 2 s together, as
/// one run alone is too short to hold blocks out.
#[test]
fn the_thesis_experiment_hides_nothing() {
    use plant_crate::{ThesisExperiment, materials};
    let (mut quiet, mut total) = (0, 0);
    for material in [materials::BRASS, materials::TEFLON, materials::RUBBER] {
        let experiment = ThesisExperiment::on(&material).expect("a material of table 3-3");
        for case in 0..20 {
            let run = |seed| {
                let series = experiment.recording(seed);
                signals::Recording {
                    name: format!("{} {seed}", material.name),
                    time: series.time.clone(),
                    position: series.position.clone(),
                    force: series.force.clone(),
                    velocity: Some(series.velocity.clone()),
                    acceleration: Some(series.acceleration.clone()),
                    ..signals::Recording::default()
                }
            };
            let recordings: Vec<_> = (8 * case..8 * case + 8).map(run).collect();
            let d = diagnose(&recordings, &[], &Options::default(), &|_, _| ()).expect("a diagnosis");
            if d.verdict != Verdict::NoMismatch {
                println!("{} {case}: {}", material.name, d.summary);
            }
            quiet += usize::from(d.verdict == Verdict::NoMismatch);
            total += 1;
        }
        println!("{}: {quiet} of {total} so far", material.name);
    }
    assert!(quiet * 20 >= total * 19, "{quiet} of {total}");
}
