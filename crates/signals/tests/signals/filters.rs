//! Filters against scipy's numbers, differences against polynomials, noise against what was put in.

use plant::{ThesisExperiment, materials};
use proptest::prelude::*;
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use signals::{
    Design, Filter, Kind, calibrate_accelerometer, central_difference, decimate, four_point_difference,
    noise_variance, zero_phase,
};
use std::collections::BTreeMap;

/// Columns of a golden file; a column may end before the file does.
fn golden(text: &str) -> BTreeMap<String, Vec<f64>> {
    let mut rows = text.lines().filter(|l| !l.starts_with('#'));
    let names: Vec<&str> = rows.next().unwrap().split(',').collect();
    let mut out = BTreeMap::new();
    for row in rows {
        for (name, cell) in names.iter().zip(row.split(',')).filter(|(_, cell)| !cell.is_empty()) {
            out.entry(name.to_string()).or_insert_with(Vec::new).push(cell.parse::<f64>().unwrap());
        }
    }
    out
}

fn butterworth(order: usize, cutoff: f64) -> Filter {
    Filter::new(Design { kind: Kind::Butterworth, order, cutoff }).unwrap()
}

fn chebyshev(order: usize, ripple_db: f64, cutoff: f64) -> Filter {
    Filter::new(Design { kind: Kind::Chebyshev1 { ripple_db }, order, cutoff }).unwrap()
}

fn largest(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

#[test]
fn forward_backward_as_scipy() {
    let golden = golden(include_str!("../golden/filters.csv"));
    let input = &golden["input"];
    for (name, filter) in [
        ("butter_4_0.2", butterworth(4, 0.2)),
        ("butter_3_0.05", butterworth(3, 0.05)),
        ("butter_1_0.5", butterworth(1, 0.5)),
        ("cheby1_8_0.05dB_0.08", chebyshev(8, 0.05, 0.08)),
        ("cheby1_5_1dB_0.3", chebyshev(5, 1.0, 0.3)),
    ] {
        let off = largest(&zero_phase(&filter, input), &golden[name]);
        println!("{name}: largest difference from scipy {off:.1e}");
        assert!(off < 1e-9);
    }
    for factor in [4, 10] {
        let off = largest(&decimate(input, factor).unwrap(), &golden[&format!("decimate_{factor}")]);
        println!("decimate by {factor}: largest difference from scipy {off:.1e}");
        assert!(off < 1e-9);
    }
}

#[test]
fn gains_as_scipy() {
    let golden = golden(include_str!("../golden/gains.csv"));
    for (name, filter) in [
        ("butter_4_0.2", butterworth(4, 0.2)),
        ("butter_3_0.05", butterworth(3, 0.05)),
        ("cheby1_8_0.05dB_0.08", chebyshev(8, 0.05, 0.08)),
        ("cheby1_5_1dB_0.3", chebyshev(5, 1.0, 0.3)),
    ] {
        let gains: Vec<f64> = golden["fraction"].iter().map(|f| filter.gain(*f)).collect();
        let off = largest(&gains, &golden[name]);
        println!("{name}: largest difference of gain from scipy {off:.1e}");
        assert!(off < 1e-11);
    }
    assert!((butterworth(4, 0.3).gain(0.3) - 0.5f64.sqrt()).abs() < 1e-12);
}

#[test]
fn differences_are_exact_for_polynomials() {
    let h = 0.01;
    let x = |i: i32| f64::from(i) * h;
    let quartic: Vec<f64> = (0..40).map(|i| 1.0 - 2.0 * x(i) + 3.0 * x(i).powi(3) - x(i).powi(4)).collect();
    let slope: Vec<f64> = (0..40).map(|i| -2.0 + 9.0 * x(i).powi(2) - 4.0 * x(i).powi(3)).collect();
    let four = four_point_difference(&quartic, h);
    assert!(largest(&four[2..38], &slope[2..38]) < 1e-12);
    let square: Vec<f64> = (0..40).map(|i| x(i).powi(2)).collect();
    let double: Vec<f64> = (0..40).map(|i| 2.0 * x(i)).collect();
    assert!(largest(&central_difference(&square, h)[1..39], &double[1..39]) < 1e-12);
    for short in [&[][..], &[1.0], &[1.0, 2.0], &[1.0, 2.0, 4.0]] {
        assert_eq!(four_point_difference(short, h).len(), short.len());
    }
}

#[test]
fn designs_that_cannot_be_are_refused() {
    for (design, parameter) in [
        (Design { kind: Kind::Butterworth, order: 0, cutoff: 0.1 }, "order"),
        (Design { kind: Kind::Butterworth, order: 99, cutoff: 0.1 }, "order"),
        (Design { kind: Kind::Butterworth, order: 2, cutoff: 1.0 }, "cutoff"),
        (Design { kind: Kind::Butterworth, order: 2, cutoff: f64::NAN }, "cutoff"),
        (Design { kind: Kind::Chebyshev1 { ripple_db: -1.0 }, order: 2, cutoff: 0.1 }, "ripple_db"),
    ] {
        let error = Filter::new(design).unwrap_err().to_string();
        println!("{error}");
        assert!(error.starts_with(parameter) && error.contains("accepted"));
    }
    let error = Filter::butterworth(4, 600.0, 1e-3).unwrap_err().to_string();
    assert!(error.contains("cutoff_hz = 600") && error.contains("500 Hz"), "{error}");
    assert!(decimate(&[1.0; 50], 0).is_err());
}

#[test]
fn noise_is_what_was_put_in() {
    let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(9);
    for std in [1e-6, 0.062, 3.0] {
        let wave: Vec<f64> = (0..20_000)
            .map(|i| 5.0 * std * (0.02 * f64::from(i)).sin() + std * sample(&mut random))
            .collect();
        let found = noise_variance(&wave).sqrt();
        println!("noise {std}: found {found:.4e}");
        assert!((found / std - 1.0).abs() < 0.03);
    }
    // Quantised in steps of 0.01 without any noise: a slow wave still has the quantum over √12.
    let coarse: Vec<f64> =
        (0..2000).map(|i| (0.5 * (0.01 * f64::from(i)).sin() / 0.01).round() * 0.01).collect();
    let found = noise_variance(&coarse).sqrt();
    assert!(found > 0.0028 && found < 0.006, "{found}");
    assert_eq!(noise_variance(&[f64::NAN; 100]), 0.0);
}

fn sample(random: &mut rand_chacha::ChaCha8Rng) -> f64 {
    StandardNormal.sample(random)
}

#[test]
fn an_accelerometer_is_calibrated() {
    let experiment = ThesisExperiment::on(&materials::BRASS).unwrap();
    let (mut scales, mut offsets, mut said) = (0.0, 0.0, 0.0);
    let runs = 20;
    for seed in 0..runs {
        let s = experiment.recording(seed);
        // What the sensor says when a = 1.08·reading − 0.3.
        let reading: Vec<f64> = s.acceleration.iter().map(|a| (a + 0.3) / 1.08).collect();
        let found = calibrate_accelerometer(&reading, &s.velocity, 1e-3).unwrap();
        scales += (found.scale / 1.08 - 1.0).powi(2) / runs as f64;
        offsets += (found.offset + 0.3).powi(2) / runs as f64;
        said += found.scale_std / 1.08 / runs as f64;
    }
    let (scales, offsets) = (scales.sqrt(), offsets.sqrt());
    println!(
        "scale off by {:.2} % (says {:.2} %), offset by {offsets:.4} m/s²",
        100.0 * scales,
        100.0 * said
    );
    assert!(scales < 0.02 && offsets < 0.03);
    assert!(said > 0.4 * scales && said < 2.5 * scales);
    assert!(calibrate_accelerometer(&[0.0; 100], &[1.0; 100], 1e-3).is_none());
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, failure_persistence: None, ..ProptestConfig::default() })]

    /// Any series, any design: the same length, no panic; a straight line passes a zero-phase filter unchanged.
    #[test]
    fn filters_take_anything(series in prop::collection::vec(prop::num::f64::ANY, 0..80), order in 0usize..18, cutoff in -0.1f64..1.1) {
        if let Ok(filter) = Filter::new(Design { kind: Kind::Butterworth, order, cutoff }) {
            prop_assert_eq!(zero_phase(&filter, &series).len(), series.len());
        }
        prop_assert_eq!(central_difference(&series, 1e-3).len(), series.len());
        let _ = (noise_variance(&series), decimate(&series, 7));
    }

    #[test]
    fn a_straight_line_passes(order in 1usize..7, cutoff in 0.05f64..0.9, slope in -5.0f64..5.0, at in -5.0f64..5.0) {
        let line: Vec<f64> = (0..1000).map(|i| at + slope * f64::from(i)).collect();
        let out = zero_phase(&butterworth(order, cutoff), &line);
        // Odd reflection continues a line as itself; what is left of the start of a pass has died out in the middle.
        prop_assert!(largest(&out[450..550], &line[450..550]) < 1e-6 * (1.0 + slope.abs()));
    }
}
