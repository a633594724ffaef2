//! What a recording cannot tell is said, with the move that would.
//!
//! The recordings are prescribed motions, in closed form, with the force that the physics asks for: equations of this
//! file's own.

use diagnose::{Diagnosis, Options, Verdict, WORTHWHILE, diagnose};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};
use signals::Recording;
use std::f64::consts::TAU;

/// Hz; no reversal falls on a sample.
const FREQUENCY: f64 = 1.93;

/// A slide of 0.42 kg under 1.75 N and 1.6 N of friction moves as one sine of 1.93 Hz and 10 mm; `beyond` is what else acts:
/// of time, position, velocity and the distance since the last reversal.
fn one_sine(seed: u64, rate: f64, beyond: impl Fn(f64, f64, f64, f64) -> f64) -> Recording {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let (mut of_force, mut of_position) = {
        let normal = |s: f64| Normal::new(0.0, s).unwrap();
        (normal(0.062), normal(1e-6))
    };
    let mut draw = |from: &mut Normal<f64>| from.sample(&mut random);
    let (reach, w) = (0.010, TAU * FREQUENCY);
    let mut out = Recording { name: format!("one sine {seed}"), ..Recording::default() };
    for i in 0..(16.0 * rate) as i32 {
        let t = f64::from(i) / rate;
        let (x, v) = (reach * (w * t).sin(), reach * w * (w * t).cos());
        let since = if v > 0.0 { x + reach } else { reach - x };
        let level = if v > 0.0 { 1.75 + 4.0 * v } else { -1.6 + 5.0 * v };
        let force = -0.42 * w * w * x + level + beyond(t, x, v, since);
        out.time.push(t);
        out.position.push(x + draw(&mut of_position));
        out.force.push(force + draw(&mut of_force));
    }
    out
}

fn run(what: &str, recording: Recording) -> Diagnosis {
    let start = std::time::Instant::now();
    let d = diagnose(&[recording], &[], &Options::default(), &|_, _| ()).expect("a diagnosis");
    println!("{what}: {:?} ({:.1} s)", d.verdict, start.elapsed().as_secs_f64());
    for m in &d.missing {
        println!("  {} or {:?}: {}", m.effect, m.indistinguishable_from, m.experiment);
    }
    for b in &d.blind_to {
        println!("  blind to {}: {}; {}", b.effect, b.because, b.experiment);
    }
    println!("  next: {:?}", d.next_experiment.as_ref().map(|n| &n.command));
    d
}

/// The experiment with which the recording is said not to tell `effect`.
fn open(d: &Diagnosis, effect: &str) -> Option<String> {
    let blind = d.blind_to.iter().find(|b| b.effect == effect).map(|b| b.experiment.clone());
    let rival = d.missing.iter().find(|m| {
        !m.indistinguishable_from.is_empty()
            && (m.effect == effect || m.indistinguishable_from.iter().any(|r| r == effect))
    });
    blind.or_else(|| rival.map(|m| m.experiment.clone()))
}

#[test]
fn a_spring_hides_behind_the_mass_on_one_sine_and_a_move_is_found_that_shows_it() {
    for seed in [11, 12, 13] {
        let d = run(&format!("spring, seed {seed}"), one_sine(seed, 1e3, |_, x, _, _| 40.0 * x));
        let experiment = open(&d, "spring").expect("said to be open");
        assert!(experiment.starts_with("move "), "{experiment}");
        let e = d.experiments.iter().find(|e| e.effect == "spring" || e.rival.as_deref() == Some("spring"));
        let e = e.expect("designed");
        println!("  {e:?}");
        assert!(
            e.discrimination > 2.0 * WORTHWHILE && e.discrimination > 3.0 * e.discrimination_now,
            "{e:?}"
        );
        assert!(e.cosine_now > 0.99 && e.cosine < e.cosine_now, "{e:?}");
        // a sine of the same frequency would show nothing, whatever its amplitude
        assert!(
            e.motion.wave != haptics::Wave::Sine || (e.motion.frequency / FREQUENCY - 1.0).abs() > 0.2,
            "{e:?}"
        );
    }
}

#[test]
fn what_no_motion_can_tell_is_said_with_what_would() {
    for seed in [21, 22] {
        let d = run(&format!("offset 0.3 N, seed {seed}"), one_sine(seed, 1e3, |_, _, _, _| 0.3));
        // reversals too swift for any sample to fall into them were taken for an actuator's lag
        assert_eq!(d.verdict, Verdict::NoMismatch, "{}", d.summary);
        assert!(open(&d, "back_emf").expect("viscous friction may be back-EMF").contains("winding"));
        assert!(open(&d, "offset").expect("an offset is Coulomb asymmetry while moving").contains("at rest"));
    }
}

#[test]
fn presliding_on_one_sine_is_named_or_said_to_be_open() {
    for (size, seed) in [(0.06, 31), (0.3, 32)] {
        // after a reversal friction builds up over 0.4 mm
        let recording =
            one_sine(seed, 1e3, |_, _, v, since| -2.0 * size * v.signum() * (-since / 4e-4).exp());
        let d = run(&format!("presliding {size} N, seed {seed}"), recording);
        let named = d.missing.first().is_some_and(|m| m.effect == "presliding");
        let open = open(&d, "presliding");
        assert!(named || open.is_some_and(|e| e.starts_with("move ")), "{size} N: {}", d.summary);
    }
}
