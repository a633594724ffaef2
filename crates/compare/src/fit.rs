//! A recording as rows of steady sliding, and its friction in bins of speed.

use crate::error::{Error, FEWEST};
use crate::interval::{BLOCKS, jackknife};
use crate::texture::{self, Texture};
use identify::{Identification, KarnoppOptions, Preprocess, identify_karnopp, prepare};
use nalgebra::{DMatrix, DVector};
use signals::{Geometry, Recording, RecordingFault};

/// Bins a direction.
const BINS: usize = 5;
/// Share of the travel that is excluded after a reversal: springs, of a contact or of a coupling, are loading.
const SETTLING: f64 = 0.12;
/// Time that is excluded after a reversal, s: the springs ring. A block of 0.4 kg on the coupling of the built-in
/// presets rings with a time constant of 2M/B = 53 ms.
const RINGING: f64 = 0.1;
/// Share of the top speed that is always about rest.
const BAND: f64 = 0.1;
/// Rows to which excluded samples contribute more than this through the filter are excluded too.
const LEAK: f64 = 0.02;
/// Parts of the recording a bin needs: what only a few of them visit hangs on each of these.
const FEWEST_BLOCKS: usize = 6;

/// One row of steady sliding.
#[derive(Debug, Clone, Copy)]
pub struct Row {
    /// s.
    pub time: f64,
    /// m/s.
    pub velocity: f64,
    acceleration: f64,
    force: f64,
    block: usize,
}

/// A recording, ready to be compared.
#[derive(Debug, Clone)]
pub struct Measured {
    /// File.
    pub name: String,
    /// Karnopp's law, for mass and break-away.
    pub identified: Identification,
    /// What the audit found.
    pub faults: Vec<RecordingFault>,
    /// The load cell was read from the side of the hand: its sign was turned.
    pub turned: bool,
    /// What repeats over position, if that shows.
    pub(crate) texture: Option<Texture>,
    pub(crate) rows_of_texture: Option<texture::Rows>,
    rows: Vec<Row>,
    band: f64,
    fastest: f64,
}

impl Measured {
    /// Prepares, identifies, and keeps what slides steadily.
    ///
    /// # Errors
    /// A recording that cannot be prepared, of an axis, or without steady sliding in both directions.
    pub fn new(recording: &Recording) -> Result<Self, Error> {
        if recording.geometry == Geometry::Rotary {
            return Err(Error::Rotary(recording.name.clone()));
        }
        let mut recording = recording.clone();
        let (signals, turned) = {
            let signals = prepare(&recording, &Preprocess::default())?;
            // a block takes power from what moves it; read from the side of the hand, it would give some
            let power: f64 = signals.force_full().iter().zip(&signals.velocity).map(|(f, v)| f * v).sum();
            if power < 0.0 {
                recording.force.iter_mut().for_each(|f| *f = -*f);
                (prepare(&recording, &Preprocess::default())?, true)
            } else {
                (signals, false)
            }
        };
        let identified = identify_karnopp(&signals, &KarnoppOptions::default())?;
        let velocity = &signals.velocity;
        let fastest = quantile(velocity.iter().map(|v| v.abs()).collect(), 0.98);
        let known = identified.value("delta_v").filter(|dv| *dv < 0.5 * fastest);
        let band = known.unwrap_or(0.0).max(BAND * fastest);
        let (low, high) = signals
            .position
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(*x), h.max(*x)));
        let rows_of_texture = texture::Rows::new(signals.clone(), band);
        let texture = rows_of_texture.as_ref().and_then(texture::Rows::texture);
        let repeated = texture.as_ref().zip(rows_of_texture.as_ref()).map(|(t, rows)| rows.force_of(t));
        let unsteady = match &repeated {
            // a body in detents halts in every valley: what it does there is in the texture
            Some(_) => texture::idle(velocity, band, signals.dt),
            None => {
                let ringing = (RINGING / signals.dt).ceil() as usize;
                unsteady(&signals.position, velocity, band, SETTLING * (high - low), ringing)
            }
        };
        let columns = [&signals.time, velocity, &signals.acceleration, &signals.force, &unsteady];
        let [time, velocity, acceleration, mut force, unsteady] = columns.map(|c| signals.condition(c));
        // the rest is friction
        force.iter_mut().zip(repeated.iter().flatten()).for_each(|(f, texture)| *f -= texture);
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
            let samples = rows.iter().filter(|row| row.velocity * sign > 0.0).count();
            if samples < FEWEST {
                return Err(Error::NoSliding { recording: recording.name, samples, direction: way });
            }
        }
        let name = recording.name.clone();
        let faults = identified.recording_faults.clone();
        Ok(Self { name, identified, faults, turned, texture, rows_of_texture, rows, band, fastest })
    }

    /// Rows of steady sliding.
    #[must_use]
    pub fn rows(&self) -> &[Row] {
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
pub struct Bins {
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
    pub(crate) fn common(all: &[&Measured]) -> Result<Self, Error> {
        let low = all.iter().map(|m| m.band).fold(0.0, f64::max);
        let high = all.iter().map(|m| m.fastest).fold(f64::INFINITY, f64::min);
        let speeds = || {
            let each = all
                .iter()
                .map(|m| format!("{} at {:.1} to {:.1} mm/s", m.name, 1e3 * m.band, 1e3 * m.fastest));
            each.collect::<Vec<_>>().join(", ")
        };
        let none = || Error::NoCommonSpeed(speeds());
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
    #[must_use]
    pub fn speeds(&self) -> Vec<f64> {
        self.middles.iter().flatten().copied().collect()
    }

    /// Number among the bins in use, and speed in its middle.
    fn used(&self, velocity: f64) -> Option<(usize, f64)> {
        let k = self.of(velocity)?;
        let middle = self.middles[k]?;
        Some((self.middles[..k].iter().flatten().count(), middle))
    }
}

/// Friction in the bins in use.
#[derive(Debug, Clone)]
pub struct Levels {
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
    /// Fits F − m·a = L(k) + b·(v − v(k)), and again without each part of the recording.
    ///
    /// The mass is known twice: from the identification, which a rendered block's coupling biases, and from these rows, in
    /// which a step of friction within a bin passes for inertia, because what slides steadily mostly slows down. It is
    /// their weighted mean, and less certain the less they agree.
    ///
    /// # Errors
    /// The motion does not tell mass and friction apart.
    pub(crate) fn fit(measured: &Measured, bins: &Bins) -> Result<Self, Error> {
        let why = || Error::Collinear(measured.name.clone());
        let identified = measured.identified.parameters.get("mass").ok_or_else(why)?;
        let used = bins.speeds().len();
        let mut parts = vec![Sums::new(used + 2); BLOCKS];
        let mut share = vec![0.0; used];
        let mut count = 0.0;
        for row in &measured.rows {
            let Some((k, middle)) = bins.used(row.velocity) else { continue };
            share[k] += 1.0;
            count += 1.0;
            let way = usize::from(row.velocity < 0.0);
            parts[row.block].add(row, [(way, row.velocity - middle), (2 + k, 1.0)]);
        }
        share.iter_mut().for_each(|s| *s /= f64::max(count, 1.0));
        let all = parts.iter().fold(Sums::new(used + 2), |sum, part| sum.with(part, 1.0));
        let whole = all.solve().ok_or_else(why)?;
        let left_out = parts.iter().map(|part| all.with(part, -1.0).solve().ok_or_else(why));
        let left_out = left_out.collect::<Result<Vec<_>, _>>()?;
        let scatter =
            jackknife(&left_out.iter().map(|s| DVector::from_element(1, s.mass)).collect::<Vec<_>>());
        let (mass, of_mass) =
            mean_of([(identified.value, identified.std), (whole.mass, scatter[(0, 0)].sqrt())]);
        let levels: Vec<DVector<f64>> = left_out.iter().map(|s| s.at(mass)).collect();
        let by_mass = &whole.by_mass * of_mass;
        let covariance = jackknife(&levels) + &by_mass * by_mass.transpose();
        let solution = whole.at(mass);
        Ok(Self {
            level: solution.rows(2, used).into_owned(),
            covariance: covariance.view((2, 2), (used, used)).into_owned(),
            share,
            mass,
            slope: [solution[0], solution[1]],
        })
    }

    /// Friction at a sample: the force without inertia, N.
    #[must_use]
    pub fn friction(&self, row: &Row) -> f64 {
        row.force - self.mass * row.acceleration
    }

    /// The fitted curve at a speed, N: in its bin, or from the nearest bin of that direction on.
    #[must_use]
    pub fn at(&self, bins: &Bins, velocity: f64) -> f64 {
        let speeds = bins.speeds();
        let same_way = speeds.iter().enumerate().filter(|(_, middle)| **middle * velocity > 0.0);
        let nearest = same_way.min_by(|a, b| (a.1 - velocity).abs().total_cmp(&(b.1 - velocity).abs()));
        let slope = self.slope[usize::from(velocity < 0.0)];
        nearest.map_or(0.0, |(k, middle)| self.level[k] + slope * (velocity - middle))
    }
}

/// Weighted mean of two values with their standard deviations. Its own is scaled by their disagreement [birge-1932].
fn mean_of([(x, of_x), (y, of_y)]: [(f64, f64); 2]) -> (f64, f64) {
    let (u, v) = (of_x * of_x, of_y * of_y);
    if !(u + v > 0.0 && v.is_finite()) {
        return (x, of_x);
    }
    let ratio = ((x - y).powi(2) / (u + v)).max(1.0);
    ((x * v + y * u) / (u + v), (ratio * u * v / (u + v)).sqrt())
}

/// Sums of the normal equations of slopes and levels, with force and acceleration on their right.
#[derive(Debug, Clone)]
struct Sums {
    squares: DMatrix<f64>,
    /// By force, and by acceleration.
    products: DMatrix<f64>,
    /// Acceleration by itself, and by the force.
    acceleration: [f64; 2],
}

impl Sums {
    fn new(unknowns: usize) -> Self {
        let squares = DMatrix::zeros(unknowns, unknowns);
        Self { squares, products: DMatrix::zeros(unknowns, 2), acceleration: [0.0; 2] }
    }

    fn add(&mut self, row: &Row, entries: [(usize, f64); 2]) {
        for (i, x) in entries {
            self.products[(i, 0)] += x * row.force;
            self.products[(i, 1)] += x * row.acceleration;
            for (j, y) in entries {
                self.squares[(i, j)] += x * y;
            }
        }
        self.acceleration[0] += row.acceleration * row.acceleration;
        self.acceleration[1] += row.acceleration * row.force;
    }

    /// These sums plus `times` those of a part.
    fn with(&self, part: &Self, times: f64) -> Self {
        Self {
            squares: &self.squares + &part.squares * times,
            products: &self.products + &part.products * times,
            acceleration: [0, 1].map(|k| self.acceleration[k] + times * part.acceleration[k]),
        }
    }

    /// None where a bin has no rows, or acceleration follows from speed.
    fn solve(&self) -> Option<Solution> {
        // scaled, so that units do not matter
        let scale = self.squares.diagonal().map(|d| d.sqrt().recip());
        if scale.iter().any(|s| !s.is_finite()) {
            return None;
        }
        let scaled = self.squares.map_with_location(|i, j, x| x * scale[i] * scale[j]);
        let by_row = |m: &DMatrix<f64>| m.map_with_location(|i, _, x| x * scale[i]);
        let solved = by_row(&scaled.cholesky()?.solve(&by_row(&self.products)));
        let (by_force, by_mass) = (solved.column(0).into_owned(), solved.column(1).into_owned());
        let left = |k: usize, of: &DVector<f64>| self.acceleration[k] - self.products.column(1).dot(of);
        let (own, shared) = (left(0, &by_mass), left(1, &by_force));
        (own > 1e-9 * self.acceleration[0]).then(|| Solution { mass: shared / own, by_force, by_mass })
    }
}

/// Slopes and levels for any mass.
struct Solution {
    /// kg, that fits best.
    mass: f64,
    /// For no mass.
    by_force: DVector<f64>,
    /// What a kilogram takes off.
    by_mass: DVector<f64>,
}

impl Solution {
    fn at(&self, mass: f64) -> DVector<f64> {
        &self.by_force - &self.by_mass * mass
    }
}
