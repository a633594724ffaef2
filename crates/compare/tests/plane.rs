//! Surfaces in the plane whose friction is known. Forces are written down from the motion, not by a law of this workspace.

use compare::{Error, MARGIN, PlanarMeasured, Verdict, compare_planar};
use identify::planar::PlanarModel;
use signals::PlanarRecording;

/// A body of 0.5 kg pushed around; of all forces on the ellipse with half axes `along` x and `across`, friction is the one that takes
/// most power. With `line`, along the diagonal only.
fn recording(name: &str, [along, across]: [f64; 2], seed: u64, line: bool) -> PlanarRecording {
    let mut noise = seed;
    let mut jitter = move || {
        noise = noise.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        0.05 * ((noise >> 11) as f64 / (1_u64 << 53) as f64 - 0.5)
    };
    let (mut time, mut position, mut force) =
        (Vec::new(), [const { Vec::new() }; 2], [const { Vec::new() }; 2]);
    for i in 0..12_000 {
        let t = f64::from(i) * 1e-3;
        let axis = |a: f64, w: f64, p: f64| {
            let (sine, cosine) = (w * t + p).sin_cos();
            [a * sine, a * w * cosine, -a * w * w * sine]
        };
        let sum = |one: [f64; 3], other: [f64; 3]| [0, 1, 2].map(|k| one[k] + other[k]);
        let x = sum(axis(0.03, 5.0, 0.0), axis(0.01, 13.1, 1.0));
        let y = if line { x } else { sum(axis(0.03, 6.3, 0.7), axis(0.01, 16.9, 0.2)) };
        let power = (along * x[1]).hypot(across * y[1]);
        time.push(t);
        for (k, (axis, level)) in [(x, along), (y, across)].into_iter().enumerate() {
            position[k].push(axis[0]);
            force[k].push(0.5 * axis[2] + level * level * axis[1] / power + jitter());
        }
    }
    PlanarRecording::of(name, time, position, force)
}

fn measured(name: &str, levels: [f64; 2], seed: u64) -> PlanarMeasured {
    PlanarMeasured::new(&recording(name, levels, seed, false)).unwrap_or_else(|e| panic!("{e}"))
}

#[test]
fn discs_a_jnd_apart_are_a_jnd_apart_in_every_direction() {
    let real = measured("real", [2.0; 2], 1);
    for (level, expected, verdict) in
        [(2.0, 0.0, Verdict::Same), (2.78, 1.0, Verdict::Different), (1.64, 1.0, Verdict::Different)]
    {
        let c = compare_planar(&real, &measured("other", [level; 2], 2), None, MARGIN).expect("compared");
        println!("{level} N: {:?}, {:?} to {:?}", c.distance, c.least.ratio, c.most.ratio);
        assert!((c.distance.value - expected).abs() < 0.05 && c.verdict == verdict, "{:?}", c.verdict);
        assert!((c.most.ratio.value - level / 2.0).abs() < 0.02);
        assert!(c.direction_squared.abs() < 0.01);
    }
}

#[test]
fn an_ellipse_with_the_mean_level_of_a_disc_is_not_the_same() {
    // 2 N in every direction against 1.7 N along x and 2.3 N along y: in the mean nothing is missing
    let c = compare_planar(&measured("disc", [2.0; 2], 1), &measured("ellipse", [1.7, 2.3], 2), None, MARGIN);
    let c = c.expect("compared");
    println!("{:?}: {:?}, {:?}", c.distance, c.least, c.most);
    assert_eq!(c.verdict, Verdict::Different);
    assert!((c.least.ratio.value - 0.85).abs() < 0.01 && (c.most.ratio.value - 1.15).abs() < 0.01);
    // slower along x: 0.3 N of 0.36 N; quicker along y: 0.3 N of 0.78 N
    let at = |degrees: f64| {
        c.points
            .iter()
            .find(|p| (p.direction.to_degrees() - degrees).abs() < 1.0)
            .expect("a direction")
            .level_jnd
    };
    assert!((at(0.0) + 0.3 / 0.36).abs() < 0.05 && (at(90.0) - 0.3 / 0.78).abs() < 0.05);
    // on the diagonal the force is turned by atan((2.3/1.7)²) − 45°
    let turned = (2.3_f64 / 1.7).powi(2).atan() - std::f64::consts::FRAC_PI_4;
    let diagonal =
        c.points.iter().find(|p| (p.direction.to_degrees() - 45.0).abs() < 1.0).expect("a direction");
    assert!((diagonal.turned - turned).abs() < 0.02, "{} for {turned}", diagonal.turned);
    assert!((diagonal.turned_jnd - turned.to_degrees() / 25.6).abs() < 0.05);
}

#[test]
fn a_recording_from_the_side_of_the_hand_and_the_device_alone_are_accounted_for() {
    let mut other = recording("other", [2.5, 3.5], 5, false);
    other.axes.iter_mut().for_each(|axis| axis.force.iter_mut().for_each(|f| *f = -*f));
    let other = PlanarMeasured::new(&other).expect("measured");
    assert!(other.turned);
    let real = measured("real", [2.0, 3.0], 1);
    // alone the device is a disc of 0.5 N: what is left of 2.5 N and 3.5 N along the axes
    let c = compare_planar(&real, &other, Some(&measured("bare", [0.5; 2], 7)), MARGIN).expect("compared");
    println!("{:?}, {:?} to {:?}, {:?}", c.distance, c.least.ratio, c.most.ratio, c.notes);
    let p = c.points.iter().find(|p| p.direction.abs() < 0.01).expect("a direction");
    assert!((p.ratio.value - 1.0).abs() < 0.02, "{p:?}");
    assert!(c.notes.iter().any(|note| note.contains("other: the load cells see the hand")));
}

/// Friction of a disc, 1 N, and of ellipses of the same mean level: at which ratio a hand feels the grain.
#[test]
fn a_hand_feels_a_grain_between_ratios_of_one_and_a_half_and_two() {
    let model = |along: f64, across: f64| {
        let text = format!(
            "schema = \"tribos.planar_model/1\"\nmass_x = 0.5\nmass_y = 0.5\nlevel_along = {along}\nlevel_across = {across}\n\
             angle = 0.0\nviscous_xx = 0.0\nviscous_xy = 0.0\nviscous_yy = 0.0\n"
        );
        PlanarModel::from_toml("m.toml", &text).expect("a model")
    };
    let disc = measured("disc", [1.0; 2], 1);
    let mut distances = Vec::new();
    for ratio in [1.1, 1.2, 1.5, 2.0, 2.5, 3.0] {
        let along = 2.0 / (1.0 + ratio);
        let wood = PlanarMeasured::of_model("wood".into(), model(along, along * ratio));
        let c = compare_planar(&disc, &wood, None, MARGIN).expect("compared");
        println!(
            "| {ratio} | {:.2} | {:.2} | {:.2} |",
            c.distance.value,
            c.level_squared.sqrt(),
            c.direction_squared.sqrt()
        );
        distances.push(c.distance.value);
    }
    let two_models = [model(1.0, 1.0), model(1.0, 2.0)].map(|m| PlanarMeasured::of_model("m".into(), m));
    assert_eq!(compare_planar(&two_models[0], &two_models[1], None, MARGIN).err(), Some(Error::ModelsOnly));
    assert!(distances.is_sorted() && distances[2] < 1.0 && distances[3] > 1.0);
}

#[test]
fn a_line_has_too_few_directions_to_be_compared() {
    let refused = PlanarMeasured::new(&recording("line.csv", [1.0; 2], 1, true)).expect_err("refused");
    assert_eq!(refused.to_string(), "line.csv: slides in 1 of 8 sectors of a half turn; 5 are accepted");
}
