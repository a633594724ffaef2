//! The experiment of [thesis, ch. 3.5]: the simulated truth obeys the printed law, and the noise is the printed one.

use plant::materials::{BRASS, TABLE_3_3, material};
use plant::{MeasurementNoise, ThesisExperiment, thesis_recording};

#[test]
fn truth_obeys_the_printed_law() {
    for material in TABLE_3_3 {
        let run = ThesisExperiment::on(&material).unwrap();
        let (t, law) = (&run.truth, material.law);
        assert_eq!(t.len(), 2000);
        let (mut worst_balance, mut worst_law, mut sliding, mut slow) = (0.0f64, 0.0f64, 0, 0);
        for i in 0..t.len() {
            let (v, a, force) = (t.velocity[i], t.acceleration[i], t.force[i]);
            // [thesis, eq. 3.4]
            worst_balance = worst_balance.max((force - material.mass * a - run.friction[i]).abs());
            if v.abs() > law.delta_v {
                sliding += 1;
                // [thesis, eq. 3.1], written independently of the crate
                let expected = if v > 0.0 { law.c_p + law.b_p * v } else { -law.c_n + law.b_n * v };
                worst_law = worst_law.max((run.friction[i] - expected).abs());
            } else {
                slow += 1;
                assert!(run.friction[i] <= law.d_p + 1e-12 && run.friction[i] >= -law.d_n - 1e-12);
            }
        }
        let high = t.position.iter().copied().fold(f64::MIN, f64::max);
        let low = t.position.iter().copied().fold(f64::MAX, f64::min);
        let repeats = (500..2000).map(|i| (t.position[i] - t.position[i - 500]).abs()).fold(0.0, f64::max);
        println!(
            "{:9} {sliding} sliding, {slow} slow; m·a + f within {worst_balance:.1e} N, law within {worst_law:.1e} N; {:.3} to {:.3} mm, cycles repeat within {repeats:.1e} m",
            material.name,
            low * 1e3,
            high * 1e3
        );
        assert!(worst_balance < 1e-12 && worst_law < 1e-12);
        assert!(sliding > 1500 && slow > 5);
        assert!((high - 0.01).abs() < 1e-3 && (low + 0.01).abs() < 1e-3);
        assert!(repeats < 1e-4);
    }
}

#[test]
fn truth_is_consistent_motion() {
    // velocity is the derivative of position, acceleration that of velocity, wherever friction is smooth
    let run = ThesisExperiment::on(&BRASS).unwrap();
    let t = &run.truth;
    let (mut worst_v, mut worst_a) = (0.0f64, 0.0f64);
    for i in 2..t.len() - 2 {
        if t.velocity[i - 2..=i + 2].iter().all(|v| v.abs() > 0.02) {
            let four_point = |y: &[f64]| (y[i - 2] - 8.0 * y[i - 1] + 8.0 * y[i + 1] - y[i + 2]) / 12e-3;
            worst_v = worst_v.max((four_point(&t.position) - t.velocity[i]).abs());
            worst_a = worst_a.max((four_point(&t.velocity) - t.acceleration[i]).abs());
        }
    }
    println!("ẋ − v within {worst_v:.1e} m/s, v̇ − a within {worst_a:.1e} m/s²");
    assert!(worst_v < 1e-4 && worst_a < 0.2);
}

#[test]
fn noise_is_that_of_table_3_2() {
    let run = ThesisExperiment::on(&BRASS).unwrap();
    let printed = MeasurementNoise::THESIS;
    let mut sums = [(0.0f64, 0.0f64); 4];
    let seeds = 200;
    for seed in 0..seeds {
        let r = run.recording(seed);
        let columns = [
            (&r.position, &run.truth.position),
            (&r.velocity, &run.truth.velocity),
            (&r.acceleration, &run.truth.acceleration),
            (&r.force, &run.truth.force),
        ];
        for ((measured, truth), sum) in columns.into_iter().zip(&mut sums) {
            for (m, t) in measured.iter().zip(truth) {
                sum.0 += m - t;
                sum.1 += (m - t) * (m - t);
            }
        }
    }
    let n = f64::from(u32::try_from(seeds).unwrap() * 2000);
    let stds = [printed.position, printed.velocity, printed.acceleration, printed.force];
    for ((sum, squares), std) in sums.into_iter().zip(stds) {
        let measured = (squares / n).sqrt();
        println!("{n} draws: mean {:.2e}, std {measured:.5e}, printed {std:e}", sum / n);
        assert!((sum / n).abs() < 5.0 * std / n.sqrt());
        assert!((measured / std - 1.0).abs() < 5.0 / (2.0 * n).sqrt());
    }
}

#[test]
fn recordings_are_seeded() {
    let once = thesis_recording(&BRASS, 3).unwrap();
    assert_eq!(once, thesis_recording(&BRASS, 3).unwrap());
    assert_ne!(once.force, thesis_recording(&BRASS, 4).unwrap().force);
    assert_eq!(once.time[1999], 1.999);
}

#[test]
fn materials_are_found_by_name() {
    assert_eq!(material("Brass").unwrap().name, "brass 1");
    assert_eq!(material(" teflon 2").unwrap().mass, 0.4555);
    assert!(material("ice").is_none());
}
