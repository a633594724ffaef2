//! Karnopp's law identified by linear regression [thesis, eq. 3.5 to 3.9], static friction and Δv included.
//!
//! Samples inside Δv are excluded, the rest obey F = m a + C_p sgn v₊ + b_p v₊ + C_n sgn v₋ + b_n v₋. Two things
//! differ from the printed page, both because the page is biased where the velocity is noisy:
//! - which samples slide, and which way, is asked of a smoothed velocity, not of the sample's own noisy one;
//! - the S of [thesis, eq. 3.9] counts the error of a velocity only on the samples where its column is not zero by
//!   construction. Printed, S = diag(var a, 0, var v, 0, var v) corrects each direction for the errors of both.
//!
//! A force channel that lags the position by τ biases the fit: the mass comes out too small by b·τ, and part of the inertial force
//! passes for viscous friction. Where a lag of up to one sample is significant, its first-order term −τ dF/dt is fitted with the law.

use crate::Signals;
use crate::errors::Errors;
use crate::identification::{Estimate, Identification, NotIdentifiable, SCHEMA};
use crate::linear::{Dropped, Problem, Solution};
use crate::ready::Ready;
use crate::static_level::{LowSpeed, StaticLevels};
use friction::Dimension;
use friction::effects::Parameter;
use friction::parameters::{COULOMB_N, COULOMB_P, DELAY, MASS, OFFSET, VISCOUS_N, VISCOUS_P};
use signals::{Error, noise_variance};
use std::collections::BTreeMap;

/// How to fit Karnopp's law.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct KarnoppOptions {
    /// What is done about errors in the regressors.
    pub errors: Errors,
    /// Δv, m/s: slower samples are excluded. None: chosen from the data (0 with [`crate::Preprocess::Emps`],
    /// as published). 0: none are.
    pub delta_v: Option<f64>,
    /// One Coulomb level and one viscous friction for both directions, and a constant offset of the force.
    pub symmetric: bool,
}

/// A column of the regression.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Column {
    Mass,
    Coulomb(Way),
    Viscous(Way),
    Offset,
    Delay,
}

/// Directions that a column stands for.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Way {
    Positive,
    Negative,
    Both,
}

impl Column {
    /// Parameters that its coefficient is.
    fn parameters(self) -> &'static [Parameter] {
        match self {
            Self::Mass => &[MASS],
            Self::Coulomb(Way::Positive) => &[COULOMB_P],
            Self::Coulomb(Way::Negative) => &[COULOMB_N],
            Self::Coulomb(Way::Both) => &[COULOMB_P, COULOMB_N],
            Self::Viscous(Way::Positive) => &[VISCOUS_P],
            Self::Viscous(Way::Negative) => &[VISCOUS_N],
            Self::Viscous(Way::Both) => &[VISCOUS_P, VISCOUS_N],
            Self::Offset => &[OFFSET],
            Self::Delay => &[DELAY],
        }
    }

    /// Name in the correlation and in messages.
    fn name(self) -> &'static str {
        match self {
            Self::Coulomb(Way::Both) => "coulomb",
            Self::Viscous(Way::Both) => "viscous",
            one => one.parameters()[0].name,
        }
    }
}

const ASYMMETRIC: [Column; 5] = [
    Column::Mass,
    Column::Coulomb(Way::Positive),
    Column::Viscous(Way::Positive),
    Column::Coulomb(Way::Negative),
    Column::Viscous(Way::Negative),
];
const SYMMETRIC: [Column; 4] =
    [Column::Mass, Column::Coulomb(Way::Both), Column::Viscous(Way::Both), Column::Offset];
/// Share of the top speed below which samples are excluded before Δv is known.
const FIRST_BAND: f64 = 0.25;
/// Share of the top speed below which samples are excluded where Δv stays unknown.
const BLIND_BAND: f64 = 0.1;
/// Standard errors above which a delay of the force is significant.
const LATE: f64 = 5.0;
/// Share of a row that must be from sliding samples.
const PRESENT: f64 = 0.5;

/// Fits Karnopp's law to a recording.
///
/// ```
/// use identify::{KarnoppOptions, Preprocess, identify_karnopp, prepare};
/// use signals::Recording;
/// let mut recording = Recording::default();
/// for i in 0..4000 {
///     let t = f64::from(i) * 1e-3;
///     let (x, v, a) = (0.01 * (12.0 * t).sin(), 0.12 * (12.0 * t).cos(), -1.44 * (12.0 * t).sin());
///     recording.time.push(t);
///     recording.position.push(x);
///     recording.force.push(0.4 * a + 1.5 * v.signum() + 2.0 * v);
/// }
/// let signals = prepare(&recording, &Preprocess::default())?;
/// let found = identify_karnopp(&signals, &KarnoppOptions::default())?;
/// assert!((found.parameters["mass"].value - 0.4).abs() < 0.004);
/// # Ok::<(), signals::Error>(())
/// ```
///
/// # Errors
/// A Δv that is negative or not finite, or a recording with too few samples. A parameter that the motion does not
/// determine is no error: it is in `not_identifiable`.
pub fn identify_karnopp(signals: &Signals, options: &KarnoppOptions) -> Result<Identification, Error> {
    if let Some(dv) = options.delta_v.filter(|dv| !(dv.is_finite() && *dv >= 0.0)) {
        return Err(Error::Parameter {
            parameter: "delta_v".into(),
            value: dv.to_string(),
            accepted: "accepted is a finite speed from 0, in m/s or rad/s".into(),
        });
    }
    let ready = Ready::new(signals, options.errors)?;
    let fastest = ready.velocity.iter().fold(0.0f64, |m, v| m.max(v.abs()));
    let resolution = (3.0 * ready.velocity_std).max(1e-3 * fastest);
    // First with a band that is surely wide enough, to know sliding friction and with it the step to static.
    let (first, solution) = Rows::new(&ready, FIRST_BAND * fastest, options.symmetric).solved(&ready);
    let levels = solution.map_or_else(StaticLevels::default, |s| first.static_levels(&ready, &s));
    let band = match (options.delta_v, levels.delta_v) {
        (Some(dv), _) => dv,
        // As published: no sample is excluded where the preprocessing decimates.
        (None, _) if 2 * ready.force_rows.len() < signals.len() => 0.0,
        (None, Some((dv, std))) => dv + 2.0 * ready.velocity_std.hypot(std),
        // Where the step from static to sliding is not seen (a filter blurs it), the band is wide enough to hold one.
        (None, None) => resolution.max(BLIND_BAND * fastest),
    };
    let (rows, solution) = Rows::new(&ready, band, options.symmetric).solved(&ready);
    Ok(Report { ready: &ready, options, rows: &rows, levels, band, fastest }.identification(solution))
}

/// The rows outside the band.
struct Rows {
    columns: Vec<Vec<f64>>,
    target: Vec<f64>,
    at: Vec<usize>,
    errors: Vec<f64>,
    symmetric: bool,
    /// Column of the force delay (force change per second of delay) and the variance of its error; `None` once it is the last of
    /// `columns`.
    late: Option<(Vec<f64>, f64)>,
}

impl Rows {
    fn new(ready: &Ready<'_>, band: f64, symmetric: bool) -> Self {
        let v = &ready.velocity;
        let slides = beyond(ready, band);
        // What does not slide is taken out of force and regressors alike, in front of the filter: behind it the law
        // holds for what is left, and no row sees anything of the band.
        let rows = |value: &dyn Fn(usize) -> f64| -> Vec<f64> {
            let column: Vec<f64> =
                slides.iter().enumerate().map(|(i, s)| if *s { value(i) } else { 0.0 }).collect();
            ready.rows(&column)
        };
        let signals = ready.signals;
        let way = |up: bool, value: &dyn Fn(usize) -> f64| {
            rows(&|i| if (v[i] > 0.0) == up { value(i) } else { 0.0 })
        };
        let present = rows(&|_| 1.0);
        let kept: Vec<usize> = (0..present.len()).filter(|i| present[*i] > PRESENT).collect();
        let pick = |column: Vec<f64>| -> Vec<f64> { kept.iter().map(|i| column[*i]).collect() };
        let ways = [pick(way(true, &|_| 1.0)), pick(way(false, &|_| -1.0))];
        let viscous = [true, false].map(|up| pick(way(up, &|i| signals.velocity[i])));
        let share = |way: &[f64]| way.iter().map(|w| w.abs()).sum::<f64>() / kept.len().max(1) as f64;
        let shares = [share(&ways[0]), share(&ways[1])];
        let all = (shares[0] + shares[1]).min(1.0);
        let (var_a, var_v) = (ready.errors.acceleration * all, ready.errors.velocity);
        let acceleration = pick(rows(&|i| signals.acceleration[i]));
        let [up, down] = ways;
        let [fast_up, fast_down] = viscous;
        let sum = |a: &[f64], b: &[f64]| -> Vec<f64> { a.iter().zip(b).map(|(a, b)| a + b).collect() };
        let (columns, errors) = if symmetric {
            (
                vec![acceleration, sum(&up, &down), sum(&fast_up, &fast_down), pick(present.clone())],
                vec![var_a, 0.0, var_v * all, 0.0],
            )
        } else {
            (
                vec![acceleration, up, fast_up, down, fast_down],
                vec![var_a, 0.0, var_v * shares[0], 0.0, var_v * shares[1]],
            )
        };
        let late = signals.late().map(|late| (pick(rows(&|i| late[i])), ready.errors.force_rate * all));
        Self {
            columns,
            target: pick(rows(&|i| signals.force[i])),
            at: pick_numbers(&ready.at, &kept),
            errors,
            symmetric,
            late,
        }
    }

    /// What its columns stand for.
    fn regressors(&self) -> impl Iterator<Item = Column> {
        let sliding = if self.symmetric { &SYMMETRIC[..] } else { &ASYMMETRIC };
        sliding.iter().copied().chain([Column::Delay]).take(self.columns.len())
    }

    /// Solves, with the delay of the force as a last column if it is significant, at most one sample long, and leaves every other
    /// coefficient determined. A longer delay is a fault of the recording; on a single sine any delay is a combination of mass and
    /// viscous friction.
    fn solved(mut self, ready: &Ready<'_>) -> (Self, Option<Solution>) {
        let without = self.solve();
        let (Some(known), Some((late, error))) = (&without, self.late.take()) else { return (self, without) };
        self.columns.push(late);
        self.errors.push(error);
        let delayed = self.solve().filter(|s| {
            let last = self.columns.len() - 1;
            let (delay, std) = (s.coefficients[last].abs(), s.covariance[(last, last)].sqrt());
            s.dropped == known.dropped && delay > LATE * std && delay - 3.0 * std <= ready.dt
        });
        if delayed.is_some() {
            return (self, delayed);
        }
        self.columns.pop();
        self.errors.pop();
        (self, without)
    }

    fn solve(&self) -> Option<Solution> {
        Problem { columns: &self.columns, target: &self.target, at: &self.at, errors: &self.errors }.solve()
    }

    /// Static friction and Δv, given inertia and viscous friction.
    fn static_levels(&self, ready: &Ready<'_>, solution: &Solution) -> StaticLevels {
        let c = &solution.coefficients;
        let lost = |k: usize| solution.dropped.iter().any(|(d, _)| *d == k);
        let mass = if lost(0) { 0.0 } else { c[0] };
        let (viscous, offset) = if self.symmetric { ([c[2], c[2]], c[3]) } else { ([c[2], c[4]], 0.0) };
        let signals = ready.signals;
        let noise = noise_variance(&signals.force).sqrt();
        let motion = signals.unfiltered(noise / mass.abs().max(f64::MIN_POSITIVE));
        let friction: Vec<f64> =
            signals.force.iter().zip(&motion.acceleration).map(|(f, a)| f - mass * a - offset).collect();
        LowSpeed {
            velocity: &motion.velocity,
            velocity_std: &motion.velocity_std,
            friction: &friction,
            viscous,
            spread: motion.half,
            blur: motion.half as f64 * ready.dt * rms(&signals.acceleration),
        }
        .find()
    }
}

/// Which samples are beyond the band, and farther from it than the filter blurs the motion.
fn beyond(ready: &Ready<'_>, band: f64) -> Vec<bool> {
    let margin = ready.signals.blurred();
    let mut out = vec![true; ready.velocity.len()];
    if band > 0.0 {
        for stretch in ready.signals.ranges() {
            for i in stretch.clone().filter(|i| ready.velocity[*i].abs() <= band) {
                let begin = i.saturating_sub(margin).max(stretch.start);
                out[begin..(i + margin + 1).min(stretch.end)].fill(false);
            }
        }
    }
    out
}

fn rms(series: &[f64]) -> f64 {
    (series.iter().map(|x| x * x).sum::<f64>() / series.len().max(1) as f64).sqrt()
}

fn pick_numbers(at: &[usize], kept: &[usize]) -> Vec<usize> {
    kept.iter().map(|i| at[*i]).collect()
}

struct Report<'a> {
    ready: &'a Ready<'a>,
    options: &'a KarnoppOptions,
    rows: &'a Rows,
    levels: StaticLevels,
    band: f64,
    fastest: f64,
}

impl Report<'_> {
    fn identification(&self, solution: Option<Solution>) -> Identification {
        let geometry = self.ready.geometry;
        let moves = self.ready.moves();
        let mut parameters = BTreeMap::new();
        let mut not_identifiable = Vec::new();
        let columns: Vec<Column> = self.rows.regressors().collect();
        let mut kept = Vec::new();
        for (k, column) in columns.iter().enumerate() {
            let why = match &solution {
                None => Some(self.nothing()),
                Some(s) => s
                    .dropped
                    .iter()
                    .find(|(d, _)| *d == k)
                    .map(|(_, why)| self.because(*column, why))
                    .or_else(|| {
                        let variance = s.covariance[(k, k)];
                        (!(variance.is_finite() && variance >= 0.0 && s.coefficients[k].is_finite()))
                            .then(|| "the errors of the regressors are larger than the motion".to_string())
                    }),
            };
            for parameter in column.parameters() {
                match (&why, &solution) {
                    (None, Some(s)) => {
                        let (value, unit) = (s.coefficients[k], parameter.unit(geometry).to_string());
                        let mut estimate = Estimate::gaussian(value, s.covariance[(k, k)].sqrt(), unit);
                        estimate.std_white = Some(s.white[(k, k)].max(0.0).sqrt());
                        parameters.insert(parameter.name.to_string(), estimate);
                    }
                    (why, _) => not_identifiable.push(NotIdentifiable {
                        parameter: parameter.name.into(),
                        because: why.clone().unwrap_or_default(),
                        experiment: if *column == Column::Mass { moves.faster() } else { moves.reversing() },
                    }),
                }
            }
            if why.is_none() {
                kept.push(k);
            }
        }
        self.levels.report(geometry, self.fastest, &moves, &mut parameters, &mut not_identifiable);
        let empty = Vec::new();
        let residual = solution.as_ref().map_or(&empty, |s| &s.residual);
        let fit =
            Ready::goodness(&self.rows.target, if solution.is_some() { residual } else { &self.rows.target });
        let entry = |i: usize, j: usize| {
            let Some(s) = &solution else { return 0.0 };
            let size = (s.covariance[(i, i)] * s.covariance[(j, j)]).sqrt();
            if i == j {
                1.0
            } else if size > 0.0 {
                (s.covariance[(i, j)] / size).clamp(-1.0, 1.0)
            } else {
                0.0
            }
        };
        Identification {
            schema: SCHEMA.into(),
            law: "karnopp".into(),
            samples: self.rows.target.len(),
            relative_error: fit.relative_error,
            recording_faults: self.ready.faults(&parameters),
            parameters,
            not_identifiable,
            preparation: vec![self.ready.signals.preparation().clone()],
            force_unit: Dimension::FORCE.unit(geometry).to_string(),
            residual_rms: fit.residual_rms,
            r_squared: fit.r_squared,
            estimator: self.estimator(),
            preprocess: self.ready.signals.description(),
            correlation_of: kept.iter().map(|k| columns[*k].name().to_string()).collect(),
            correlation: kept.iter().map(|i| kept.iter().map(|j| entry(*i, *j)).collect()).collect(),
            effective_samples: solution.as_ref().map_or(0.0, |s| s.effective_samples),
        }
    }

    fn estimator(&self) -> String {
        let unit = Dimension::VELOCITY.unit(self.ready.geometry);
        let method = match self.options.errors {
            Errors::LeastSquares => "least squares (eq. 3.8)".to_string(),
            _ if self.rows.errors.iter().all(|e| *e == 0.0) => {
                "least squares (eq. 3.8): the regressors have no errors to speak of".to_string()
            }
            _ => format!(
                "Fuller's errors in variables (eq. 3.9), std of velocity {:.2e} {unit}, of acceleration {:.2e} {unit}²",
                self.ready.errors.velocity.sqrt(),
                self.ready.errors.acceleration.sqrt()
            ),
        };
        let band = if self.band > 0.0 {
            format!("samples slower than {:.3e} {unit} excluded", self.band)
        } else {
            "no sample excluded".to_string()
        };
        format!("{method}; {band}; standard errors by a sandwich with Bartlett weights")
    }

    fn nothing(&self) -> String {
        format!(
            "{} samples slide faster than {:.3e} {}, and they do not determine the law",
            self.rows.target.len(),
            self.band,
            Dimension::VELOCITY.unit(self.ready.geometry)
        )
    }

    fn because(&self, column: Column, why: &Dropped) -> String {
        match why {
            Dropped::Absent => match column {
                Column::Mass => "the body never accelerates",
                Column::Coulomb(Way::Positive) | Column::Viscous(Way::Positive) => {
                    "the body never slides in positive direction"
                }
                Column::Coulomb(Way::Negative) | Column::Viscous(Way::Negative) => {
                    "the body never slides in negative direction"
                }
                _ => "the body never slides",
            }
            .into(),
            Dropped::Collinear(others) => {
                let others: Vec<&str> =
                    others.iter().filter_map(|k| self.rows.regressors().nth(*k)).map(Column::name).collect();
                format!("on this motion it cannot be told from {}", others.join(" and "))
            }
            Dropped::Noise(share) => format!(
                "{:.0} % of what is its own in the {} is measurement error",
                100.0 * share,
                if column == Column::Mass { "acceleration" } else { "velocity" }
            ),
        }
    }
}
