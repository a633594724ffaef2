//! Friction and cogging of a device by itself, from recordings of its handle: linear least squares over the samples at which it
//! slides,
//!
//! ```text
//! F = m·a + b·v + F_p·[v > 0] − F_n·[v < 0] + Σ_k (c_k·cos(2πkx/λ) + s_k·sin(2πkx/λ)) + τ·dF/dt,   k = 1, 2
//! ```
//!
//! λ is searched over the spatial frequencies that the travel tells apart. τ is the delay of the force. Standard errors are those
//! of a jackknife over blocks of a second or more: residuals of neighbouring samples are not independent.

use crate::error::{Error, Result};
use friction::effects::{Effect, EffectKind, Scale};
use friction::{Coulomb, Dimension, Geometry, Law};
use haptics::Device;
use identify::{Model, Preprocess, prepare};
use nalgebra::{SMatrix, SVector};
use signals::Recording;

/// Columns: mass, damping, friction both ways, delay, and four of the wave.
const COLUMNS: usize = 9;
/// Columns without the wave.
const PLAIN: usize = 5;
/// Names of those that people ask for.
const NAMES: [&str; 4] = ["mass", "damping", "friction_p", "friction_n"];
/// Slowest sliding on the default device, m/s: above the speed at which a handle sticks and slips.
const SLIDES: f64 = 2e-3;
/// Samples beside a reversal that are excluded.
const REVERSAL: usize = 15;
/// Blocks of the jackknife.
const BLOCKS: usize = 16;
/// Waves that the travel holds, of those searched.
const WAVES: (f64, f64) = (1.5, 60.0);
/// Steps of the search in a wave more along the travel.
const STEPS: f64 = 6.0;
/// Ratio of two mean square errors that are the same.
const SAME: f64 = 1.05;
/// Share of the error that a cogging must leave at most, and its standard errors at least, to be named. Of a few hundred
/// wavelengths the best one reaches that by chance once in 10⁴.
const LEAVES: f64 = 0.95;
const SURE: f64 = 4.0;

/// Wavelength of the cogging.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Period {
    /// No cogging is fitted.
    None,
    /// m.
    Known(f64),
    /// Looked for; named where it explains the error.
    Searched,
}

type Normal = SMatrix<f64, COLUMNS, COLUMNS>;
type Vector = SVector<f64, COLUMNS>;

/// A sample of the sliding handle.
struct Row {
    plain: [f64; PLAIN],
    position: f64,
    force: f64,
    /// Number of its block.
    block: usize,
}

/// Sums of a block.
#[derive(Clone, Copy, Default)]
struct Sums {
    normal: Normal,
    right: Vector,
    square: f64,
    count: f64,
}

impl Sums {
    fn add(&mut self, column: &Vector, force: f64) {
        self.normal += column * column.transpose();
        self.right += column * force;
        self.square += force * force;
        self.count += 1.0;
    }

    fn plus(mut self, other: &Self, sign: f64) -> Self {
        self.normal += other.normal * sign;
        self.right += other.right * sign;
        self.square += sign * other.square;
        self.count += sign * other.count;
        self
    }

    /// Solution over the first `columns`, and the mean square error.
    fn solve(&self, columns: usize) -> Option<(Vector, f64)> {
        let mut normal = self.normal;
        let mut right = self.right;
        for k in columns..COLUMNS {
            normal.fill_row(k, 0.0);
            normal.fill_column(k, 0.0);
            normal[(k, k)] = 1.0;
            right[k] = 0.0;
        }
        // columns of like size
        let scale = Vector::from_fn(|k, _| 1.0 / normal[(k, k)].sqrt());
        if !scale.iter().all(|s| s.is_finite()) {
            return None;
        }
        let diagonal = Normal::from_diagonal(&scale);
        let inner = (diagonal * normal * diagonal).cholesky()?;
        let solution = diagonal * inner.solve(&(diagonal * right));
        Some((solution, ((self.square - solution.dot(&right)) / self.count).max(0.0)))
    }
}

/// What was found.
#[derive(Debug, Clone, PartialEq)]
pub struct OwnFriction {
    solution: Vector,
    std: Vector,
    wavelength: Option<f64>,
    /// Root-mean-square error, N.
    pub rms: f64,
}

impl OwnFriction {
    /// Fits recordings of one handle, whose force moves it.
    ///
    /// # Errors
    /// A recording that cannot be prepared, or in which the handle does not slide both ways.
    pub fn of(recordings: &[Recording], period: Period, device: &Device) -> Result<Self> {
        let mut rows = Vec::new();
        for recording in recordings {
            rows_of(recording, device, &mut rows)?;
        }
        let count = rows.len();
        for (k, row) in rows.iter_mut().enumerate() {
            row.block = k * BLOCKS / count.max(1);
        }
        let nothing = || {
            let name = recordings.first().map_or("", |r| r.name.as_str());
            Error::input(format!(
                "{name}: the handle does not slide both ways long enough to tell its friction"
            ))
        };
        if count < 20 * BLOCKS {
            return Err(nothing());
        }
        let (_, plain) = total(&rows, None).0.solve(PLAIN).ok_or_else(nothing)?;
        let wavelength = match period {
            Period::None => None,
            Period::Known(length) => Some(length),
            Period::Searched => search(&rows),
        };
        let found = Self::at(&rows, wavelength).ok_or_else(nothing)?;
        let named = match period {
            Period::Searched => found.rms < LEAVES * plain.sqrt() && found.is_sure(),
            _ => true,
        };
        if named { Ok(found) } else { Self::at(&rows, None).ok_or_else(nothing) }
    }

    fn at(rows: &[Row], wavelength: Option<f64>) -> Option<Self> {
        let columns = if wavelength.is_some() { COLUMNS } else { PLAIN };
        let (all, blocks) = total(rows, wavelength);
        let (solution, error) = all.solve(columns)?;
        let mut variance = Vector::zeros();
        for block in &blocks {
            let without = all.plus(block, -1.0).solve(columns)?.0 - solution;
            variance += without.component_mul(&without);
        }
        let share = (BLOCKS as f64 - 1.0) / BLOCKS as f64;
        let std = variance.map(|v| (share * v).sqrt());
        Some(Self { solution, std, wavelength, rms: error.sqrt() })
    }

    /// Value and standard error of a parameter.
    #[must_use]
    pub fn value(&self, name: &str) -> (f64, f64) {
        NAMES
            .iter()
            .position(|n| *n == name)
            .map_or((f64::NAN, f64::NAN), |k| (self.solution[k], self.std[k]))
    }

    /// Amplitude of the first harmonic of the cogging, N.
    #[must_use]
    pub fn amplitude(&self) -> f64 {
        self.solution[PLAIN].hypot(self.solution[PLAIN + 1])
    }

    fn is_sure(&self) -> bool {
        let std = self.std[PLAIN].hypot(self.std[PLAIN + 1]);
        self.amplitude() > SURE * std
    }

    /// As a model: levels that came out below zero are zero, and a second harmonic that is not sure is none.
    #[must_use]
    pub fn model(&self, geometry: Geometry) -> Model {
        let [mass, damping, p, n] = NAMES.map(|name| self.value(name).0.max(0.0));
        let effects = self.wavelength.and_then(|wavelength| {
            let kind = EffectKind::ALL.iter().copied().find(|kind| is_wave(*kind))?;
            let mut effect = Effect::silent(kind);
            effect.shape[0] = wavelength;
            for k in 0..4 {
                let (gain, std) = (self.solution[PLAIN + k], self.std[PLAIN + k]);
                effect.gains[k] = if k < 2 || gain.abs() > SURE * std { gain } else { 0.0 };
            }
            Some(effect)
        });
        let std = [("mass", 0), ("damping_p", 1), ("damping_n", 1), ("f_dynamic_p", 2), ("f_dynamic_n", 3)];
        Model {
            name: "device".into(),
            geometry,
            mass,
            law: Law::Coulomb(Coulomb {
                level_p: p,
                level_n: n,
                static_p: p,
                static_n: n,
                viscous_p: damping,
                viscous_n: damping,
            }),
            effects: effects.into_iter().collect(),
            std: std.map(|(name, k)| (name.to_owned(), self.std[k])).into(),
            ..Model::default()
        }
    }
}

/// Whether an effect is a force of the position alone with two harmonics: cosine and sine of each.
fn is_wave(kind: EffectKind) -> bool {
    kind.is_of_position()
        && kind.gains().len() == 4
        && kind.gains().iter().all(|gain| gain.dimension == Dimension::FORCE)
        && kind.shape().first().is_some_and(|shape| shape.scale == Scale::Wavelength)
}

/// Samples of a recording at which the handle slides.
fn rows_of(recording: &Recording, device: &Device, rows: &mut Vec<Row>) -> Result<()> {
    let signals = prepare(recording, &Preprocess::default())?;
    let slides = f64::from(device.speed(1.0)) * SLIDES;
    let n = signals.len();
    // behind the filter of velocity and acceleration
    let force = signals.force_full();
    let mut since = 0;
    for i in 1..n.saturating_sub(REVERSAL) {
        let v = signals.velocity[i];
        let turns = v.abs() < slides || v.signum() != signals.velocity[i - 1].signum();
        since = if turns { 0 } else { since + 1 };
        let ahead = signals.velocity[i + REVERSAL];
        if since < REVERSAL || ahead.abs() < slides || ahead.signum() != v.signum() {
            continue;
        }
        let (up, down) = if v > 0.0 { (1.0, 0.0) } else { (0.0, -1.0) };
        let rate = (force[i + 1] - force[i - 1]) / (2.0 * signals.dt);
        let plain = [signals.acceleration[i], v, up, down, rate];
        if plain.iter().chain([&force[i], &signals.position[i]]).all(|x| x.is_finite()) {
            rows.push(Row { plain, position: signals.position[i], force: force[i], block: 0 });
        }
    }
    Ok(())
}

/// Sums of all rows and of each block.
fn total(rows: &[Row], wavelength: Option<f64>) -> (Sums, [Sums; BLOCKS]) {
    let mut blocks = [Sums::default(); BLOCKS];
    for row in rows {
        let mut column = Vector::zeros();
        column.as_mut_slice()[..PLAIN].copy_from_slice(&row.plain);
        if let Some(length) = wavelength {
            let (s, c) = (std::f64::consts::TAU * row.position / length).sin_cos();
            column.as_mut_slice()[PLAIN..].copy_from_slice(&[c, s, c * c - s * s, 2.0 * s * c]);
        }
        if let Some(block) = blocks.get_mut(row.block) {
            block.add(&column, row.force);
        }
    }
    (blocks.iter().fold(Sums::default(), |sum, block| sum.plus(block, 1.0)), blocks)
}

/// The wavelength that explains most, m.
fn search(rows: &[Row]) -> Option<f64> {
    let range = rows.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), row| {
        (low.min(row.position), high.max(row.position))
    });
    let travel = range.1 - range.0;
    let error = |frequency: f64| {
        total(rows, Some(1.0 / frequency)).0.solve(COLUMNS).map_or(f64::INFINITY, |(_, error)| error)
    };
    let step = 1.0 / (STEPS * travel);
    let count = ((WAVES.1 - WAVES.0) * STEPS) as usize;
    let grid = (0..count).map(|k| WAVES.0 / travel + k as f64 * step);
    let (mut best, _) = grid.map(|f| (f, error(f))).min_by(|a, b| a.1.total_cmp(&b.1))?;
    let mut step = 0.5 * step;
    while step > 1e-6 * best {
        let tried = [best - step, best, best + step].map(|f| (f, error(f)));
        best = tried.iter().min_by(|a, b| a.1.total_cmp(&b.1))?.0;
        step *= 0.5;
    }
    // twice the wavelength explains the same with its second harmonic
    while 2.0 * best * travel <= WAVES.1 && error(2.0 * best) <= SAME * error(best) {
        best *= 2.0;
    }
    Some(1.0 / best)
}
