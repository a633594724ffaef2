//! Friction in the plane: how much more of it a hand feels in any direction, and how far it points elsewhere.

use crate::interval::{BLOCKS, Interval, Squared, jackknife};
use crate::verdict::Verdict;
use crate::{Error, Jnd};
use identify::planar::{PlanarModel, PlanarOptions, Track, identify_planar};
use nalgebra::{DMatrix, DVector};
use serde::Serialize;
use signals::{PlanarRecording, Recording, RecordingFault, quantile};
use std::f64::consts::{PI, TAU};
use std::ops::Range;

/// Directions of motion that are compared.
const DIRECTIONS: usize = 16;
/// Speeds that are compared: the ends and the middle of those that all have.
const SPEEDS: usize = 3;
/// Sectors of a half turn, and how many of them a recording has to visit: to and fro count as one.
const SECTORS: usize = 8;
const FEWEST_SECTORS: usize = 5;
/// Share of the sliding samples that makes a visit.
const VISIT: f64 = 0.01;
/// Student's t of 95 % for the level and both parts of an anisotropy at once: 0.05/3 on both sides, nine degrees of freedom.
const T_ALL: f64 = 2.933;

/// Friction in the plane, ready to be compared: of a recording, or of a model.
#[derive(Debug, Clone)]
pub struct PlanarMeasured {
    /// File.
    pub name: String,
    /// What was identified, or read.
    pub model: PlanarModel,
    /// What the audit found.
    pub faults: Vec<RecordingFault>,
    /// The load cells were read from the side of the hand: their signs were turned.
    pub turned: bool,
    /// The same without each part of the recording; none of a model, which is exact.
    left_out: Vec<PlanarModel>,
    /// Range of its speeds, m/s.
    speeds: [f64; 2],
}

impl PlanarMeasured {
    /// Identifies the recording, and without each of its parts.
    ///
    /// # Errors
    /// A recording that cannot be prepared or identified, or that slides in too few directions.
    pub fn new(recording: &PlanarRecording) -> Result<Self, Error> {
        let mut recording = recording.clone();
        let first = identify_planar(std::slice::from_ref(&recording), &PlanarOptions::default())?;
        let visited = sectors(&first.tracks);
        if visited < FEWEST_SECTORS {
            return Err(Error::FewDirections { recording: recording.name, visited });
        }
        // a surface takes power from what moves over it; read from the side of the hand, it would give some
        let turned = power(&first.tracks) < 0.0;
        let first = if turned {
            for axis in &mut recording.axes {
                axis.force.iter_mut().for_each(|f| *f = -*f);
            }
            identify_planar(std::slice::from_ref(&recording), &PlanarOptions::default())?
        } else {
            first
        };
        let options = PlanarOptions { cutoff_hz: first.model.cutoff_hz, ..PlanarOptions::default() };
        let count = recording.axes[0].time.len();
        let without = |k: usize| {
            let rest = [0..k * count / BLOCKS, (k + 1) * count / BLOCKS..count];
            let parts: Vec<PlanarRecording> =
                rest.into_iter().filter(|r| !r.is_empty()).map(|r| part(&recording, &r)).collect();
            Ok(identify_planar(&parts, &options)?.model)
        };
        let left_out = (0..BLOCKS).map(without).collect::<Result<_, Error>>()?;
        let speeds: Vec<f64> = sliding(&first.tracks).map(|(t, i)| t.speed[i]).collect();
        Ok(Self {
            name: recording.name,
            faults: first.found.recording_faults,
            turned,
            left_out,
            speeds: [quantile(&speeds, 0.1), quantile(&speeds, 0.9)],
            model: first.model,
        })
    }

    /// A model, which has every speed.
    #[must_use]
    pub fn of_model(name: String, model: PlanarModel) -> Self {
        let speeds = [0.0, f64::INFINITY];
        Self { name, model, faults: Vec::new(), turned: false, left_out: Vec::new(), speeds }
    }
}

/// Samples at which the body slides in a known direction.
fn sliding(tracks: &[Track]) -> impl Iterator<Item = (&Track, usize)> {
    tracks.iter().flat_map(|t| (0..t.len()).filter(|i| t.mask[*i] > 0.5).map(move |i| (t, i)))
}

fn power(tracks: &[Track]) -> f64 {
    sliding(tracks).map(|(t, i)| t.f[0][i] * t.v[0][i] + t.f[1][i] * t.v[1][i]).sum()
}

/// Number of sectors of a half turn in which the body slides.
fn sectors(tracks: &[Track]) -> usize {
    let mut counts = [0_usize; SECTORS];
    for (t, i) in sliding(tracks) {
        let turn = t.direction[1][i].atan2(t.direction[0][i]).rem_euclid(PI) / PI;
        counts[((turn * SECTORS as f64) as usize).min(SECTORS - 1)] += 1;
    }
    let all: usize = counts.iter().sum();
    counts.iter().filter(|count| **count as f64 > VISIT * all as f64).count()
}

/// These samples of a recording.
fn part(recording: &PlanarRecording, samples: &Range<usize>) -> PlanarRecording {
    let cut = |series: &Vec<f64>| series.get(samples.clone()).unwrap_or_default().to_vec();
    let axes = recording.axes.each_ref().map(|axis| Recording {
        time: cut(&axis.time),
        position: cut(&axis.position),
        force: cut(&axis.force),
        velocity: axis.velocity.as_ref().map(cut),
        acceleration: axis.acceleration.as_ref().map(cut),
        ..axis.clone()
    });
    PlanarRecording { name: recording.name.clone(), axes }
}

/// Friction in one direction of motion at one speed.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct PlanarPoint {
    /// Direction of the motion, rad.
    pub direction: f64,
    /// m/s.
    pub speed: f64,
    /// Real friction, x and y, N.
    pub real: [f64; 2],
    /// Rendered friction, without the device's own where that was recorded, N.
    pub rendered: [f64; 2],
    /// Size of the rendered over that of the real friction.
    pub ratio: Interval,
    /// What a hand notices of the size, N.
    pub jnd: f64,
    /// Difference of the sizes, JND.
    pub level_jnd: f64,
    /// Angle from the real to the rendered friction, rad.
    pub turned: f64,
    /// The same, JND.
    pub turned_jnd: f64,
}

/// A comparison in the plane.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PlanarComparison {
    /// Version of the layout.
    pub schema: &'static str,
    /// File of the real surface.
    pub real: String,
    /// File of the rendered one.
    pub rendered: String,
    /// File of the device alone.
    pub bare: Option<String>,
    /// JND, over all directions.
    pub distance: Interval,
    /// Its part of the sizes, JND².
    pub level_squared: f64,
    /// Its part of the directions of the force, JND².
    pub direction_squared: f64,
    /// Rendered over real friction in the direction of motion where that is smallest.
    pub least: PlanarPoint,
    /// The same where it is largest.
    pub most: PlanarPoint,
    /// Largest relative difference of friction that counts as the same.
    pub margin: f64,
    /// What the ratios say of all directions.
    pub verdict: Verdict,
    /// Direction by direction, slowest speed first.
    pub points: Vec<PlanarPoint>,
    /// What was found at fault, by recording.
    pub faults: Vec<(String, String)>,
    /// What a reader must know.
    pub notes: Vec<String>,
}

/// Compares friction in the plane; `bare` is the device alone, whose resistance is taken off.
///
/// # Errors
/// No speed in common, and models only.
pub fn compare_planar(
    real: &PlanarMeasured,
    rendered: &PlanarMeasured,
    bare: Option<&PlanarMeasured>,
    margin: f64,
) -> Result<PlanarComparison, Error> {
    let all: Vec<&PlanarMeasured> = [Some(real), Some(rendered), bare].into_iter().flatten().collect();
    let motions = motions(&all)?;
    let models: Vec<&PlanarModel> = all.iter().map(|m| &m.model).collect();
    let frictions = |models: &[&PlanarModel]| -> Vec<[[f64; 2]; 2]> {
        let of = |v: &[f64; 2]| {
            let own = models.get(2).map_or([0.0; 2], |bare| bare.friction(*v));
            let felt = models[1].friction(*v);
            [models[0].friction(*v), [felt[0] - own[0], felt[1] - own[1]]]
        };
        motions.iter().map(of).collect()
    };
    let n = motions.len();
    let whole = frictions(&models);
    let size = |f: [f64; 2]| f[0].hypot(f[1]);
    let jnd: Vec<f64> = whole.iter().map(|[a, b]| Jnd::sliding(size(*a), size(*b) - size(*a))).collect();
    // differences of the sizes in JND, angles in JND, and ratios
    let figures = |pairs: &[[[f64; 2]; 2]]| {
        let angle = |[a, b]: &[[f64; 2]; 2]| (a[0] * b[1] - a[1] * b[0]).atan2(a[0] * b[0] + a[1] * b[1]);
        let levels = pairs.iter().zip(&jnd).map(|([a, b], jnd)| (size(*b) - size(*a)) / jnd);
        let angles = pairs.iter().map(|p| angle(p) / Jnd::DIRECTION);
        let ratios = pairs.iter().map(|[a, b]| size(*b) / size(*a).max(f64::MIN_POSITIVE));
        DVector::from_vec(levels.chain(angles).chain(ratios).collect())
    };
    let mut covariance = DMatrix::zeros(3 * n, 3 * n);
    for (source, measured) in all.iter().enumerate().filter(|(_, m)| !m.left_out.is_empty()) {
        let without: Vec<DVector<f64>> = measured
            .left_out
            .iter()
            .map(|model| {
                let mut models = models.clone();
                models[source] = model;
                figures(&frictions(&models))
            })
            .collect();
        covariance += jackknife(&without);
    }
    let off = figures(&whole);
    let square = |from: usize, count: usize| {
        let noise = covariance.view((from, from), (count, count)).into_owned();
        let weight = DVector::from_element(count, 1.0 / n as f64);
        Squared::of(&off.rows(from, count).into_owned(), &weight, &noise)
    };
    let points: Vec<PlanarPoint> = (0..n)
        .map(|k| {
            let [vx, vy] = motions[k];
            let half = T_ALL * covariance[(2 * n + k, 2 * n + k)].max(0.0).sqrt();
            let ratio = off[2 * n + k];
            PlanarPoint {
                direction: vy.atan2(vx),
                speed: vx.hypot(vy),
                real: whole[k][0],
                rendered: whole[k][1],
                ratio: Interval { value: ratio, ci95: [ratio - half, ratio + half] },
                jnd: jnd[k],
                level_jnd: off[k],
                turned: off[n + k] * Jnd::DIRECTION,
                turned_jnd: off[n + k],
            }
        })
        .collect();
    let (low, high) = (1.0 - margin, 1.0 + margin);
    let verdict = if points.iter().all(|p| p.ratio.ci95[0] >= low && p.ratio.ci95[1] <= high) {
        Verdict::Same
    } else if points.iter().any(|p| p.ratio.ci95[0] > high || p.ratio.ci95[1] < low) {
        Verdict::Different
    } else {
        Verdict::Undecided
    };
    let by = |a: &&PlanarPoint, b: &&PlanarPoint| a.ratio.value.total_cmp(&b.ratio.value);
    // there are directions
    let (least, most) = (points.iter().min_by(by), points.iter().max_by(by));
    let (Some(least), Some(most)) = (least.copied(), most.copied()) else {
        return Err(Error::NoCommonSpeed(real.name.clone()));
    };
    Ok(PlanarComparison {
        schema: "tribos.planar_comparison/1",
        real: real.name.clone(),
        rendered: rendered.name.clone(),
        bare: bare.map(|bare| bare.name.clone()),
        distance: square(0, 2 * n).root(),
        level_squared: square(0, n).value,
        direction_squared: square(n, n).value,
        least,
        most,
        margin,
        verdict,
        points,
        faults: all
            .iter()
            .flat_map(|m| m.faults.iter().map(|fault| (m.name.clone(), fault.why.clone())))
            .collect(),
        notes: notes(&all, bare.is_some()),
    })
}

/// Velocities at which all are compared, m/s.
fn motions(all: &[&PlanarMeasured]) -> Result<Vec<[f64; 2]>, Error> {
    let low = all.iter().map(|m| m.speeds[0]).fold(0.0, f64::max);
    let high = all.iter().map(|m| m.speeds[1]).fold(f64::INFINITY, f64::min);
    if high.is_infinite() {
        return Err(Error::ModelsOnly);
    }
    if !(low < high) {
        let of = |m: &&PlanarMeasured| {
            format!("{}: {:.0} to {:.0} mm/s", m.name, 1e3 * m.speeds[0], 1e3 * m.speeds[1])
        };
        return Err(Error::NoCommonSpeed(all.iter().map(of).collect::<Vec<_>>().join(", ")));
    }
    let speed = |k: usize| low + (high - low) * k as f64 / (SPEEDS - 1) as f64;
    let of = |k: usize| {
        (0..DIRECTIONS).map(move |d| {
            let (sine, cosine) = (TAU * d as f64 / DIRECTIONS as f64).sin_cos();
            [speed(k) * cosine, speed(k) * sine]
        })
    };
    Ok((0..SPEEDS).flat_map(of).collect())
}

fn notes(all: &[&PlanarMeasured], bare: bool) -> Vec<String> {
    let turned = all.iter().filter(|m| m.turned);
    let mut notes: Vec<String> = turned
        .map(|m| {
            format!("{}: the load cells see the hand from the other side; their signs were turned", m.name)
        })
        .collect();
    if !bare && !notes.is_empty() {
        notes.push("what the device itself resists is in the rendered recording; --bare takes it off".into());
    }
    notes.push("break-away is not compared in the plane: sliding has no share of it".into());
    notes
}
