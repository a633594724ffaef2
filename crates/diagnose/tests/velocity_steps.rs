//! Steps of the speed, as tribologists make them: a spring pulls a slider whose friction follows the equations of Dieterich and
//! Ruina in *time*, integrated in steps of a thousandth of the contact's renewal. The diagnosis knows them as a decay over distance.
//! `cargo test -p diagnose --test velocity_steps -- --nocapture` prints what is found.

use diagnose::{Diagnosis, Options, diagnose};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use signals::Recording;

/// N.
const LOAD: f64 = 30.0;
/// Stiffness of the machine, friction coefficient per metre.
const STIFFNESS: f64 = 5e4;
/// Speeds, m/s, and for how long, s.
const STEPS: [(f64, f64); 8] = [
    (1e-6, 60.0),
    (1e-5, 20.0),
    (1e-6, 60.0),
    (1e-5, 20.0),
    (3e-6, 40.0),
    (3e-5, 10.0),
    (1e-6, 60.0),
    (1e-5, 20.0),
];

struct Rock {
    a: f64,
    b: f64,
    d_c: f64,
    /// The contact ages at rest, too (Dieterich); it changes only while it slides (Ruina) otherwise.
    ages: bool,
}

/// Ten samples a second of the pulled end, the friction and the load.
fn record(rock: &Rock, steps: &[(f64, f64)], seed: u64) -> Recording {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut noise = |std: f64| {
        let sum: f64 = (0..12).map(|_| random.random::<f64>()).sum();
        std * (sum - 6.0)
    };
    let Rock { a, b, d_c, ages } = *rock;
    let (v_0, mu_0) = (1e-6, 0.6);
    let mut theta = d_c / steps[0].0;
    let mut mu = mu_0 + (a - b) * (steps[0].0 / v_0).ln();
    let (mut pulled, mut t, mut next) = (0.0, 0.0, 0.0);
    let mut out = Recording { name: "steps".into(), ..Recording::default() };
    let mut normal = Vec::new();
    for &(speed, seconds) in steps {
        let end = t + seconds;
        while t < end {
            let v = v_0 * ((mu - mu_0 - b * (v_0 * theta / d_c).ln()) / a).exp();
            if t >= next {
                out.time.push(next);
                out.position.push(((pulled + noise(1e-8)) / 1e-9).round() * 1e-9);
                out.force.push(mu * LOAD + noise(0.015));
                normal.push(LOAD + noise(0.005));
                next += 0.1;
            }
            // neither the spring nor the contact changes by more than a thousandth of what changes it
            let h =
                (1e-3 * d_c / v).min(1e-3 * a / (STIFFNESS * v.max(speed))).min(0.02).min(end - t + 1e-12);
            let renewed = v * theta / d_c;
            theta += h * if ages { 1.0 - renewed } else { -renewed * renewed.ln() };
            mu += h * STIFFNESS * (speed - v);
            pulled += h * speed;
            t += h;
        }
    }
    out.normal_force = Some(normal);
    out
}

fn found(recording: &Recording) -> Diagnosis {
    let found = diagnose(std::slice::from_ref(recording), &[], &Options::default(), &|_, _| ()).unwrap();
    println!("{}, filter {:.2} Hz", found.summary, found.cutoff_hz);
    for m in &found.missing {
        let numbers: Vec<String> =
            m.parameters.iter().map(|(n, q)| format!("{n} {:.3e} ± {:.1e}", q.value, q.std)).collect();
        println!("  {}: {:.4} -> {:.4}: {numbers:?}", m.effect, m.rms_heldout_before, m.rms_heldout_after);
    }
    found
}

#[test]
fn steps_of_speed_show_rate_and_state() {
    let rocks = [
        Rock { a: 0.010, b: 0.006, d_c: 12e-6, ages: true },
        Rock { a: 0.010, b: 0.006, d_c: 12e-6, ages: false },
        Rock { a: 0.006, b: 0.010, d_c: 15e-6, ages: true },
        // a clay
        Rock { a: 0.008, b: -0.004, d_c: 20e-6, ages: true },
        Rock { a: 0.008, b: -0.004, d_c: 20e-6, ages: false },
    ];
    for (seed, rock) in rocks.iter().enumerate() {
        let found = found(&record(rock, &STEPS, seed as u64));
        let names: Vec<&str> = found.missing.iter().map(|m| m.effect.as_str()).collect();
        assert_eq!(names, ["rate_and_state"]);
        let of = |name: &str| &found.missing[0].parameters[name];
        let healing = if rock.ages { 1.0 } else { 0.0 };
        for (name, truth) in [("a", rock.a), ("b", rock.b), ("d_c", rock.d_c)] {
            let error = of(name).value / truth - 1.0;
            assert!(error.abs() < 0.12, "{name}: {} for {truth}", of(name).value);
        }
        assert!((of("healing").value - healing).abs() < 0.2, "the law of the contact's age");
    }
}

#[test]
fn a_friction_without_memory_has_no_state() {
    // what changes with the speed at once is a curve over the speed
    let rock = Rock { a: 0.01, b: 0.0, d_c: 1e-5, ages: true };
    let found = found(&record(&rock, &STEPS, 7));
    let state = found.missing.iter().find(|m| m.effect == "rate_and_state");
    let age = state.and_then(|m| m.parameters.get("b"));
    assert!(age.is_none_or(|b| b.value.abs() < 2.0 * b.std + 3e-4), "{age:?}");
}
