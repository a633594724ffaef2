//! [thesis, table 3-3] recovered: 200 seeded recordings a material, simulated with the printed parameters and the noise of
//! [thesis, table 3-2].

use crate::recorded;
use identify::{Errors, Identification, KarnoppOptions, Preprocess, identify_karnopp, prepare};
use plant::ThesisExperiment;
use plant::materials::{BRASS, Material, RUBBER, TEFLON};
use signals::Recording;

const RUNS: u64 = 200;

fn recording(experiment: &ThesisExperiment, seed: u64) -> Recording {
    recorded(experiment.recording(seed))
}

/// Mean and spread over the runs, and the mean of the reported standard errors.
struct Spread {
    runs: usize,
    mean: f64,
    spread: f64,
    reported: f64,
}

impl Spread {
    fn of(runs: &[Identification], name: &str) -> Self {
        let found: Vec<_> = runs.iter().filter_map(|r| r.parameters.get(name)).collect();
        let n = found.len() as f64;
        let mean = found.iter().map(|p| p.value).sum::<f64>() / n;
        Self {
            runs: found.len(),
            mean,
            spread: (found.iter().map(|p| (p.value - mean).powi(2)).sum::<f64>() / (n - 1.0)).sqrt(),
            reported: found.iter().map(|p| p.std).sum::<f64>() / n,
        }
    }
}

fn truth(m: &Material) -> [(&'static str, f64); 8] {
    [
        ("mass", m.mass),
        ("coulomb_p", m.law.c_p),
        ("viscous_p", m.law.b_p),
        ("coulomb_n", m.law.c_n),
        ("viscous_n", m.law.b_n),
        ("static_p", m.law.d_p),
        ("static_n", m.law.d_n),
        ("delta_v", m.law.delta_v),
    ]
}

fn check(material: &Material) {
    let start = std::time::Instant::now();
    let experiment = ThesisExperiment::on(material).unwrap();
    let runs = |errors| -> Vec<Identification> {
        (0..RUNS)
            .map(|seed| {
                let signals = prepare(&recording(&experiment, seed), &Preprocess::Thesis).unwrap();
                identify_karnopp(&signals, &KarnoppOptions { errors, ..KarnoppOptions::default() }).unwrap()
            })
            .collect()
    };
    let (fuller, plain) = (runs(Errors::Fuller), runs(Errors::LeastSquares));
    println!(
        "{}: 2 x {RUNS} runs of 2000 samples in {:.2?}; {}",
        material.name,
        start.elapsed(),
        fuller[0].estimator
    );
    println!(
        "  {:10} {:>8} {:>17} {:>17} {:>8} {:>8}",
        "", "truth", "Fuller", "least squares", "spread", "reported"
    );
    let mut failed = Vec::new();
    for (name, truth) in truth(material) {
        let (f, p) = (Spread::of(&fuller, name), Spread::of(&plain, name));
        let off = |s: &Spread| format!("{:.4} ({:+.2} %)", s.mean, 100.0 * (s.mean / truth - 1.0));
        println!(
            "  {name:10} {truth:8.4} {:>17} {:>17} {:8.4} {:8.4}  {:+.2} std",
            off(&f),
            off(&p),
            f.spread,
            f.reported,
            (f.mean - truth) / f.spread
        );
        let bias = (f.mean - truth).abs();
        let (mean_ok, std_ok) = if name == "delta_v" {
            // The motion repeats itself, so friction falls between the same two samples in every cycle: Δv is
            // known to that gap and no better, however many runs there are.
            (bias < 1.5 * f.reported, f.reported > 0.8 * f.spread)
        } else {
            (bias < 0.01 * truth.abs() || bias < 0.2 * f.spread, (f.reported / f.spread - 1.0).abs() < 0.2)
        };
        if !(mean_ok && std_ok && f.runs >= 195) {
            failed.push(format!("{name}: {} runs, mean {mean_ok}, std {std_ok}", f.runs));
        }
        if name == "mass" {
            assert!(bias < 0.2 * (p.mean - truth).abs(), "Fuller's mass is less biased than least squares'");
            assert!(p.mean < truth, "least squares shrinks a mass");
        }
    }
    assert!(failed.is_empty(), "{}: {}", material.name, failed.join("; "));
}

#[test]
fn brass() {
    check(&BRASS);
}

#[test]
fn teflon() {
    check(&TEFLON);
}

#[test]
fn rubber() {
    check(&RUBBER);
}
