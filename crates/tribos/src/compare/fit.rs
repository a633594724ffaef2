//! A recording as rows of steady sliding, and its friction in bins of speed.

use crate::failure::{Failure, Result};
use identify::{
    Geometry, Identification, KarnoppOptions, Preprocess, Recording, RecordingFault, identify_karnopp,
    prepare,
};
use nalgebra::{DMatrix, DVector};

/// Parts a recording is left out by, one at a time.
pub(super) const BLOCKS: usize = 10;
/// Bins a direction.
const BINS: usize = 5;
/// Share of the travel that is set aside after a reversal: springs, of a contact or of a coupling, are loading.
const SETTLING: f64 = 0.12;
/// Time that is set aside after a reversal, s: the springs ring. A block of 0.4 kg on the coupling of the built-in
/// presets rings with a time constant of 2M/B = 53 ms.
const RINGING: f64 = 0.1;
/// Share of the top speed that is always about rest.
const BAND: f64 = 0.1;
/// Rows to which samples that were set aside contribute more than this through the filter are set aside too.
const LEAK: f64 = 0.02;
/// Rows a bin needs.
const FEWEST: usize = 40;
/// Parts of the recording a bin needs: what only a few of them visit hangs on each of these.
const FEWEST_BLOCKS: usize = 6;

/// One row of steady sliding.
#[derive(Debug, Clone, Copy)]
pub(super) struct Row {
    pub time: f64,
    pub velocity: f64,
    acceleration: f64,
    force: f64,
    block: usize,
}

/// A recording, ready to be compared.
#[derive(Debug, Clone)]
pub(crate) struct Measured {
    /// File.
    pub name: String,
    /// Karnopp's law, for mass and break-away.
    pub identified: Identification,
    /// What the audit found.
    pub faults: Vec<RecordingFault>,
    /// The load cell was read from the side of the hand: its sign was turned.
    pub turned: bool,
    rows: Vec<Row>,
    band: f64,
    fastest: f64,
}

impl Measured {
    /// Prepares, identifies, and keeps what slides steadily.
    ///
    /// # Errors
    /// A recording that cannot be prepared, of an axis, or without steady sliding in both directions.
    pub(crate) fn new(recording: &Recording) -> Result<Self> {
        let named = |why: String| Failure::new(format!("{}: {why}", recording.name));
        if recording.geometry == Geometry::Rotary {
            return Err(named(
                "is of an axis, in N·m; just noticeable differences are known in N at a handle".into(),
            )
            .help("recordings with position_m and force_n are accepted"));
        }
        let mut recording = recording.clone();
        let (signals, turned) = {
            let signals = prepare(&recording, &Preprocess::default()).map_err(Failure::new)?;
            // a block takes power from what moves it; read from the side of the hand, it would give some
            let power: f64 = signals.force_full().iter().zip(&signals.velocity).map(|(f, v)| f * v).sum();
            if power < 0.0 {
                recording.force.iter_mut().for_each(|f| *f = -*f);
                (prepare(&recording, &Preprocess::default()).map_err(Failure::new)?, true)
            } else {
                (signals, false)
            }
        };
        let identified = identify_karnopp(&signals, &KarnoppOptions::default()).map_err(Failure::new)?;
        let velocity = &signals.velocity;
        let fastest = quantile(velocity.iter().map(|v| v.abs()).collect(), 0.98);
        let known = identified.value("delta_v").filter(|dv| *dv < 0.5 * fastest);
        let band = known.unwrap_or(0.0).max(BAND * fastest);
        let (low, high) = signals
            .position
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(*x), h.max(*x)));
        let ringing = (RINGING / signals.dt).ceil() as usize;
        let unsteady = unsteady(&signals.position, velocity, band, SETTLING * (high - low), ringing);
        let columns = [&signals.time, velocity, &signals.acceleration, &signals.force, &unsteady];
        let [time, velocity, acceleration, force, unsteady] = columns.map(|c| signals.condition(c));
        let count = time.len();
        let rows: Vec<Row> = (0..count)
            .filter(|&i| unsteady[i].abs() <= LEAK && velocity[i].abs() > band)
            .map(|i| Row {
                time: time[i],
                velocity: velocity[i],
                acceleration: acceleration[i],
                force: force[i],
                block: i * BLOCKS / count.max(1),
            })
            .collect();
        for (way, sign) in [("forward", 1.0), ("reverse", -1.0)] {
            let sliding = rows.iter().filter(|row| row.velocity * sign > 0.0).count();
            if sliding < FEWEST {
                return Err(named(format!(
                    "{sliding} samples of steady sliding in {way} direction; {FEWEST} are accepted"
                ))
                .help("move to and fro, over several millimetres, for ten seconds or more"));
            }
        }
        let name = recording.name.clone();
        let faults = identified.recording_faults.clone();
        Ok(Self { name, identified, faults, turned, rows, band, fastest })
    }

    pub(super) fn rows(&self) -> &[Row] {
        &self.rows
    }
}

/// 1 where a sample is not of steady sliding: about rest, or less than `settling` m or `ringing` samples after a
/// reversal.
fn unsteady(position: &[f64], velocity: &[f64], band: f64, settling: f64, ringing: usize) -> Vec<f64> {
    let (mut way, mut turned_at, mut since) = (0.0, position.first().copied().unwrap_or(0.0), 0);
    let steady = |(&x, &v): (&f64, &f64)| {
        // rest counts as a reversal, too: contacts load again from it
        if v.abs() <= band || v.signum() != way {
            (way, turned_at, since) = (v.signum(), x, 0);
        }
        since += 1;
        v.abs() > band && (x - turned_at).abs() >= settling && since > ringing
    };
    let slides: Vec<bool> = position.iter().zip(velocity).map(steady).collect();
    slides.into_iter().map(|slides| f64::from(u8::from(!slides))).collect()
}

fn quantile(mut values: Vec<f64>, q: f64) -> f64 {
    values.retain(|v| v.is_finite());
    values.sort_by(f64::total_cmp);
    values.get((q * values.len().saturating_sub(1) as f64) as usize).copied().unwrap_or(0.0)
}

/// Speeds in the middle of bins, m/s, negative in reverse; bins are equally wide.
#[derive(Debug, Clone)]
pub(super) struct Bins {
    low: f64,
    width: f64,
    /// By bin: its middle; None where a recording does not fill it.
    middles: Vec<Option<f64>>,
}

impl Bins {
    /// Those that all recordings fill.
    ///
    /// # Errors
    /// The recordings have no speed in common.
    pub(super) fn common(all: &[&Measured]) -> Result<Self> {
        let low = all.iter().map(|m| m.band).fold(0.0, f64::max);
        let high = all.iter().map(|m| m.fastest).fold(f64::INFINITY, f64::min);
        let speeds = || {
            let each = all
                .iter()
                .map(|m| format!("{} at {:.1} to {:.1} mm/s", m.name, 1e3 * m.band, 1e3 * m.fastest));
            each.collect::<Vec<_>>().join(", ")
        };
        let none = || {
            Failure::new(format!("no speed at which all slide: {}", speeds()))
                .help("recordings whose speeds overlap are accepted")
        };
        if !(high > 1.1 * low) {
            return Err(none());
        }
        let width = (high - low) / BINS as f64;
        let mut bins = Self { low, width, middles: vec![None; 2 * BINS] };
        for k in 0..2 * BINS {
            let filled = |m: &&Measured| {
                let of: Vec<&Row> = m.rows.iter().filter(|row| bins.of(row.velocity) == Some(k)).collect();
                let mut blocks: Vec<usize> = of.iter().map(|row| row.block).collect();
                blocks.dedup();
                of.len() >= FEWEST && blocks.len() >= FEWEST_BLOCKS
            };
            if all.iter().all(filled) {
                let speed = low + (k % BINS) as f64 * width + 0.5 * width;
                bins.middles[k] = Some(if k < BINS { speed } else { -speed });
            }
        }
        let any = |range: std::ops::Range<usize>| bins.middles[range].iter().any(Option::is_some);
        if any(0..BINS) && any(BINS..2 * BINS) { Ok(bins) } else { Err(none()) }
    }

    fn of(&self, velocity: f64) -> Option<usize> {
        let k = ((velocity.abs() - self.low) / self.width).floor();
        let within = k >= 0.0 && k < BINS as f64;
        within.then(|| k as usize + if velocity < 0.0 { BINS } else { 0 })
    }

    /// Speeds of the bins in use.
    pub(super) fn speeds(&self) -> Vec<f64> {
        self.middles.iter().flatten().copied().collect()
    }

    /// Number among the bins in use, and speed in its middle.
    pub(super) fn used(&self, velocity: f64) -> Option<(usize, f64)> {
        let k = self.of(velocity)?;
        let middle = self.middles[k]?;
        Some((self.middles[..k].iter().flatten().count(), middle))
    }
}

/// Friction in the bins in use.
#[derive(Debug, Clone)]
pub(super) struct Levels {
    /// Signed as friction opposes: positive forward, N.
    pub level: DVector<f64>,
    /// Covariance of the levels, N².
    pub covariance: DMatrix<f64>,
    /// Share of the samples, by bin.
    pub share: Vec<f64>,
    /// kg.
    pub mass: f64,
    /// N·s/m, forward and reverse.
    pub slope: [f64; 2],
}

impl Levels {
    /// Fits F = m·a + L(k) + b·(v − v(k)), and again without each part of the recording.
    ///
    /// # Errors
    /// The motion does not tell mass and friction apart.
    pub(super) fn fit(measured: &Measured, bins: &Bins) -> Result<Self> {
        let used = bins.speeds().len();
        let unknowns = used + 3;
        let mut squares = vec![DMatrix::zeros(unknowns, unknowns); BLOCKS];
        let mut products = vec![DVector::zeros(unknowns); BLOCKS];
        let mut share = vec![0.0; used];
        let mut count = 0.0;
        for row in &measured.rows {
            let Some((k, middle)) = bins.used(row.velocity) else { continue };
            share[k] += 1.0;
            count += 1.0;
            let way = if row.velocity > 0.0 { 1 } else { 2 };
            let entries = [(0, row.acceleration), (way, row.velocity - middle), (3 + k, 1.0)];
            for (i, x) in entries {
                products[row.block][i] += x * row.force;
                for (j, y) in entries {
                    squares[row.block][(i, j)] += x * y;
                }
            }
        }
        share.iter_mut().for_each(|s| *s /= f64::max(count, 1.0));
        let all = squares.iter().fold(DMatrix::zeros(unknowns, unknowns), |sum, part| sum + part);
        let right = products.iter().fold(DVector::zeros(unknowns), |sum, part| sum + part);
        let why = || {
            Failure::new(format!("{}: the motion does not tell inertia and friction apart", measured.name))
                .help("a motion whose speed changes is accepted, such as a hand that moves to and fro")
        };
        let solution = solve(&all, &right).ok_or_else(why)?;
        let mut left_out = Vec::new();
        for (part, product) in squares.iter().zip(&products) {
            left_out.push(solve(&(&all - part), &(&right - product)).ok_or_else(why)?);
        }
        let mean = left_out.iter().fold(DVector::zeros(unknowns), |sum, x| sum + x) / BLOCKS as f64;
        let scatter = left_out.iter().fold(DMatrix::zeros(unknowns, unknowns), |sum, x| {
            let off = x - &mean;
            sum + &off * off.transpose()
        });
        let covariance = scatter * ((BLOCKS - 1) as f64 / BLOCKS as f64);
        Ok(Self {
            level: solution.rows(3, used).into_owned(),
            covariance: covariance.view((3, 3), (used, used)).into_owned(),
            share,
            mass: solution[0],
            slope: [solution[1], solution[2]],
        })
    }

    /// Friction at a sample: the force without inertia, N.
    pub(super) fn friction(&self, row: &Row) -> f64 {
        row.force - self.mass * row.acceleration
    }

    /// The fitted curve at a speed, N: in its bin, or from the nearest bin of that direction on.
    pub(super) fn at(&self, bins: &Bins, velocity: f64) -> f64 {
        let speeds = bins.speeds();
        let same_way = speeds.iter().enumerate().filter(|(_, middle)| **middle * velocity > 0.0);
        let nearest = same_way.min_by(|a, b| (a.1 - velocity).abs().total_cmp(&(b.1 - velocity).abs()));
        let slope = self.slope[usize::from(velocity < 0.0)];
        nearest.map_or(0.0, |(k, middle)| self.level[k] + slope * (velocity - middle))
    }
}

/// Normal equations, scaled so that kilograms and newtons do not matter.
fn solve(squares: &DMatrix<f64>, right: &DVector<f64>) -> Option<DVector<f64>> {
    let scale = DVector::from_iterator(right.len(), squares.diagonal().iter().map(|d| d.sqrt().recip()));
    if scale.iter().any(|s| !s.is_finite()) {
        return None;
    }
    let scaled = DMatrix::from_fn(right.len(), right.len(), |i, j| squares[(i, j)] * scale[i] * scale[j]);
    let solution = scaled.cholesky()?.solve(&right.component_mul(&scale));
    Some(solution.component_mul(&scale))
}
