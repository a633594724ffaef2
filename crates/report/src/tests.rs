//! Reports of an artificial diagnosis. With `TRIBOS_REPORT_DIR` set, the pages are also written there.

use crate::{Identified, Undetermined, diagnosis as html, identification};
use diagnose::*;
use std::collections::BTreeMap;

fn quantity(value: f64, std: f64, unit: &str) -> Quantity {
    Quantity { value, std, unit: unit.into() }
}

/// A 2 Hz, 10 mm slide on brass with Stribeck friction that the baseline lacks.
fn stribeck(n: usize) -> Diagnosis {
    let time: Vec<f64> = (0..n).map(|i| i as f64 * 1e-3).collect();
    let w = 4.0 * std::f64::consts::PI;
    let position: Vec<f64> = time.iter().map(|t| 0.01 * (w * t).sin()).collect();
    let velocity: Vec<f64> = time.iter().map(|t| 0.01 * w * (w * t).cos()).collect();
    // deterministic sensor noise: the golden-angle sequence, uniform
    let noise = |i: usize| 0.2 * ((i as f64 * 0.618_033_988_75).fract() - 0.5);
    let missing = |v: f64| v.signum() * 0.42 * (-(v.abs() / 0.012)).exp();
    let plain = |i: usize| -0.41 * 0.01 * w * w * (w * time[i]).sin() + 1.75 * (velocity[i] / 1e-4).tanh();
    let force: Vec<f64> = (0..n).map(|i| plain(i) + missing(velocity[i]) + noise(i)).collect();
    let before: Vec<f64> = (0..n).map(|i| plain(i) + 0.05 * velocity[i].signum()).collect();
    let after: Vec<f64> = (0..n).map(|i| plain(i) + missing(velocity[i])).collect();
    let curve =
        |coordinate: &str, unit: &str, subset: &str, from: f64, to: f64, f: &dyn Fn(f64) -> f64| Curve {
            coordinate: coordinate.into(),
            unit: unit.into(),
            subset: subset.into(),
            bins: (0..40)
                .map(|i| {
                    let at = from + (to - from) * (i as f64 + 0.5) / 40.0;
                    Bin {
                        at,
                        before: f(at) + 0.1 * noise(i),
                        after: 0.12 * noise(i + 7),
                        band: 0.03 + 0.01 * noise(3 * i).abs(),
                    }
                })
                .collect(),
        };
    let odd = |v: f64| missing(v) - 0.06 * v.signum();
    Diagnosis {
        schema: SCHEMA,
        verdict: Verdict::Mismatch,
        summary:
            "Below 12 mm/s the surface holds more than the simulation says: friction falls as sliding begins \
                  (Stribeck), and that explains 97 % of what was wrong."
                .into(),
        recording_faults: vec![],
        preparation: vec![],
        noise_floor: NoiseFloor { rms: 0.062, unit: "N".into(), how: "repeats".into() },
        baseline: Baseline {
            law: "karnopp".into(),
            parameters: BTreeMap::from([
                ("mass".into(), quantity(0.4103, 0.0041, "kg")),
                ("coulomb_p".into(), quantity(1.7714, 0.0229, "N")),
                ("coulomb_n".into(), quantity(1.729, 0.0229, "N")),
                ("viscous_p".into(), quantity(-1.5778, 0.1884, "N·s/m")),
                ("delay".into(), quantity(2.57e-6, f64::NAN, "s")),
            ]),
            rms_heldout: 0.134,
        },
        location: vec![Location {
            coordinate: "velocity".into(),
            from: -0.012,
            to: 0.012,
            unit: "m/s".into(),
            share_of_mismatch: 0.71,
            p: 1e-7,
        }],
        missing: vec![Missing {
            effect: "stribeck".into(),
            says: "Friction is higher just after sliding begins and falls as it speeds up.".into(),
            equation: "F = sgn(v) · ΔF · exp(−(|v|/v_s)^δ)".into(),
            parameters: BTreeMap::from([
                ("force_p".into(), quantity(0.424, 0.018, "N")),
                ("velocity".into(), quantity(0.0121, 0.0009, "m/s")),
            ]),
            rms_heldout_before: 0.134,
            rms_heldout_after: 0.066,
            gain_ci95: [0.061, 0.074],
            p: 1e-9,
            indistinguishable_from: vec!["sublinear_viscous".into()],
            experiment: "move triangle 0.01 0.2 20, speeds a decade lower".into(),
            free_form: None,
        }],
        blind_to: vec![Blind {
            effect: "spring".into(),
            because: "collinear with mass on one sine".into(),
            experiment: "move sine 0.01 0.5 10".into(),
        }],
        rejected: ["backlash", "quadratic_drag", "position_dependent_friction"]
            .iter()
            .enumerate()
            .map(|(i, e)| Rejected {
                effect: (*e).into(),
                upper_bound: 0.004 * (i + 1) as f64,
                unit: "N".into(),
            })
            .collect(),
        after: After {
            rms_heldout: 0.066,
            free_run_error: Some(1.2e-3),
            explained_share: 0.97,
            parameters: BTreeMap::from([("mass".into(), quantity(0.4187, 0.0031, "kg"))]),
        },
        instruments: vec![],
        does_not_carry_over: vec![CarriesNot {
            effect: "compliance".into(),
            regime: "the second half of the recording".into(),
            rms_before: 0.072,
            rms_after: 0.075,
        }],
        left_out: None,
        detectable: 0.011,
        judged_share: 1.0,
        fitted_share: 1.0,
        cutoff_hz: 40.0,
        validation: vec![Validation {
            recording: "brass-2.csv".into(),
            rms_before: 0.140,
            rms_after: 0.068,
            relative_before: 0.071,
            relative_after: 0.034,
            refitted: vec!["origin".into()],
            rms_before_refitted: Some(0.139),
            rms_after_refitted: Some(0.064),
            relative_before_refitted: Some(0.0705),
            relative_after_refitted: Some(0.032),
            nuisances: vec![PerRecording {
                recording: "brass-2.csv".into(),
                nuisance: "origin".into(),
                value: 0.0011,
                std: 4e-5,
                unit: "m".into(),
            }],
        }],
        nuisances: vec![],
        remainder: Remainder { rms: 0.02, located_at: vec![] },
        experiments: vec![],
        next_experiment: None,
        model: None,
        figures: Figures {
            curves: vec![
                curve("velocity", "m/s", "", -0.126, 0.126, &odd),
                curve("distance_since_reversal", "m", "", 0.0, 0.02, &|x| 0.3 * (-x / 0.001).exp() - 0.02),
                curve("position", "m", "moving forward", -0.01, 0.01, &|x| 3e4 * x.powi(4) - 0.03),
                curve("position", "m", "moving backward", -0.01, 0.01, &|x| -3e4 * x.powi(4) + 0.03),
                curve("time", "s", "", 0.0, n as f64 * 1e-3, &|_| 0.0),
            ],
            free_run_position: position.iter().map(|x| x + 1e-4).collect(),
            time,
            position,
            velocity,
            force,
            before,
            after,
        },
    }
}

fn look(name: &str, page: &str) {
    if let Ok(dir) = std::env::var("TRIBOS_REPORT_DIR") {
        std::fs::write(std::path::Path::new(&dir).join(name), page).unwrap();
    }
}

#[test]
fn one_file_that_fetches_nothing_and_stays_small() {
    let page = html(&stribeck(2000), "brass.csv");
    look("diagnosis.html", &page);
    for fetch in ["src=", "<link", "@import", "url(", "fetch(", "XMLHttpRequest", "<iframe"] {
        assert!(!page.contains(fetch), "the page must not load anything: {fetch}");
    }
    assert!(page.contains("prefers-color-scheme: dark") && page.contains("@media print"));
    let long = html(&stribeck(1_000_000), "long.csv");
    println!("2 000 samples: {} kB, 1 000 000 samples: {} kB", page.len() / 1000, long.len() / 1000);
    assert!(long.len() < 2_000_000, "{} bytes", long.len());
}

#[test]
fn everything_a_person_needs_is_said() {
    let page = html(&stribeck(2000), "brass.csv");
    for needed in [
        "Below 12 mm/s the surface holds more",
        "exp(−(|v|/v_s)^δ)",
        "sublinear viscous",
        "tribos record PORT --move \"triangle 0.01 0.2 20\" --out next.csv",
        "speeds a decade lower",
        "collinear with mass on one sine",
        "backlash",
        "0.4103",
        "from repeats",
        "97 %",
        "brass-2.csv",
        "origin",
        "40.0 Hz",
    ] {
        assert!(page.contains(needed), "missing: {needed}");
    }
}

#[test]
fn hostile_text_stays_text() {
    let mut d = stribeck(50);
    let hostile = "</script><img src=x onerror=alert(1)>";
    d.summary = hostile.into();
    d.missing[0].effect = hostile.into();
    d.missing[0].experiment = format!("move {hostile}");
    d.figures.curves[0].subset = hostile.into();
    d.noise_floor.unit = hostile.into();
    d.baseline.parameters.insert(hostile.into(), quantity(1.0, 0.1, hostile));
    let page = html(&d, hostile);
    assert!(!page.contains("<img"));
    let scripts = page.matches("</script>").count();
    assert_eq!(scripts, 3, "only the page's own three scripts may close");
}

#[test]
fn nothing_to_draw_and_nothing_finite_still_make_a_page() {
    let mut d = stribeck(50);
    d.figures = Figures::default();
    d.missing.clear();
    d.location.clear();
    d.verdict = Verdict::NotTestable;
    d.noise_floor.rms = f64::NAN;
    d.baseline.rms_heldout = f64::INFINITY;
    let page = html(&d, "");
    assert!(page.contains("This recording cannot answer") && page.contains("</html>"));
    assert!(!page.contains("<script"), "a script for charts that are not there");
    let mut d = stribeck(50);
    d.figures.force.fill(f64::NAN);
    d.figures.time[7] = f64::NAN;
    for bin in &mut d.figures.curves[0].bins {
        bin.band = f64::NAN;
    }
    let page = html(&d, "nan");
    assert!(!page.contains("NaN,") && !page.contains("inf,"));
    look("not_finite.html", &page);
}

#[test]
fn an_identification_says_what_it_could_not_determine() {
    let d = stribeck(2000);
    let f = &d.figures;
    let friction: Vec<f64> =
        f.velocity.iter().zip(&f.force).map(|(v, _)| 1.75 * v.signum() + 0.1 * (v * 1e4).sin()).collect();
    let inertia: Vec<f64> = f.position.iter().map(|x| -0.41 * 157.9 * x).collect();
    let found = Identified {
        name: "<teflon>".into(),
        law: "dahl".into(),
        force_unit: "N".into(),
        samples: 2000,
        relative_error: 0.0311,
        parameters: d.baseline.parameters.clone(),
        undetermined: vec![Undetermined {
            parameter: "sigma".into(),
            because: "no reversal is slow enough".into(),
            experiment: "move sine 0.0005 1 10".into(),
        }],
        faults: vec![],
        how: vec!["Fuller's estimator (eq. 3.9)".into()],
        time: f.time.clone(),
        velocity: f.velocity.clone(),
        force: friction.iter().zip(&inertia).map(|(a, b)| a + b).collect(),
        predicted: f.velocity.iter().zip(&inertia).map(|(v, i)| 1.75 * v.signum() + i).collect(),
        friction,
    };
    let page = identification(&found);
    look("identification.html", &page);
    for needed in [
        "Dahl friction",
        "&lt;teflon&gt;",
        "sigma is not identifiable",
        "3.11\u{a0}%",
        "fitted law",
        "Fuller&#39;s",
    ] {
        assert!(page.contains(needed), "missing: {needed}");
    }
    assert!(identification(&Identified::default()).contains("</html>"));
}

#[test]
fn what_was_told_by_comparing_channels_fell_from_an_error_to_the_same_error() {
    let mut d = stribeck(2000);
    d.missing[0].effect = "encoder_eccentricity".into();
    (d.missing[0].rms_heldout_before, d.missing[0].rms_heldout_after) = (0.14, 0.062);
    (d.baseline.rms_heldout, d.after.rms_heldout) = (0.0286, 0.0286);
    let said = summary(&d);
    assert!(said.contains("error of a force sample falls from 0.140 to 0.0620 N"), "{said}");
    let page = html(&d, "brass.csv");
    assert!(page.contains("as recorded") && page.contains("set right"));
    // with an effect on the force, the fit has both
    d.missing.push(Missing { effect: "spring".into(), ..d.missing[0].clone() });
    assert!(summary(&d).contains("with it the held-out error is 0.0286 N"));
}
