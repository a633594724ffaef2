//! Karnopp's law identified by linear regression (eq. 3.5 to 3.9), static friction and Δv included.
//!
//! Samples inside Δv are set aside, the rest obey F = m a + C_p sgn v₊ + b_p v₊ + C_n sgn v₋ + b_n v₋. Two things
//! differ from the printed page, both because the page is biased where the velocity is noisy:
//! - which samples slide, and which way, is asked of a smoothed velocity, not of the sample's own noisy one;
//! - the S of eq. 3.9 counts the error of a velocity only on the samples where its column is not zero by
//!   construction. Printed, S = diag(var a, 0, var v, 0, var v) corrects each direction for the errors of both.

use crate::identification::{Estimate, Identification, NotIdentifiable, SCHEMA};
use crate::linear::{Dropped, Problem, Solution};
use crate::ready::Ready;
use crate::static_level::{LowSpeed, StaticLevels};
use crate::{Error, Signals};
use std::collections::BTreeMap;

/// What is done about measurement errors in velocity and acceleration.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Errors {
    /// Nothing: eq. 3.8. Shrinks the mass by the share of noise in the acceleration.
    LeastSquares,
    /// Fuller's estimator, eq. 3.9, with variances from how far samples scatter about their neighbours.
    #[default]
    Fuller,
    /// Fuller's estimator with standard deviations that are known, of the rows that are fitted.
    Declared {
        /// m/s.
        velocity: f64,
        /// m/s².
        acceleration: f64,
    },
}

/// How to fit Karnopp's law.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct KarnoppOptions {
    /// What is done about errors in the regressors.
    pub errors: Errors,
    /// Δv, m/s: samples slower than this are set aside. None: chosen from the data (0 with [`crate::Preprocess::Emps`],
    /// as published). 0: none are.
    pub delta_v: Option<f64>,
    /// One Coulomb level and one viscous friction for both directions, and a constant offset of the force.
    pub symmetric: bool,
}

const ASYMMETRIC: [&str; 5] = ["mass", "coulomb_p", "viscous_p", "coulomb_n", "viscous_n"];
const SYMMETRIC: [&str; 4] = ["mass", "coulomb", "viscous", "offset"];
/// Share of the top speed that is set aside before Δv is known.
const FIRST_BAND: f64 = 0.25;
/// Share of the top speed that is set aside where Δv stays unknown.
const BLIND_BAND: f64 = 0.1;
/// Rows to which the band under Δv contributes more than this through the filter are set aside too.
const LEAK: f64 = 0.02;

/// Fits Karnopp's law to a recording.
///
/// ```
/// use identify::{KarnoppOptions, Preprocess, Recording, identify_karnopp, prepare};
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
/// # Ok::<(), identify::Error>(())
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
    let first = Rows::new(&ready, FIRST_BAND * fastest, options.symmetric);
    let levels = first.solve().map_or_else(StaticLevels::default, |s| first.static_levels(&ready, &s));
    let band = match (options.delta_v, levels.delta_v) {
        (Some(dv), _) => dv,
        // As published: no sample is set aside where the preprocessing decimates.
        (None, _) if 2 * ready.force_rows.len() < signals.len() => 0.0,
        (None, Some((dv, _))) => dv + 2.0 * ready.velocity_std,
        // Where the step from static to sliding is not seen (a filter blurs it), the band is wide enough to hold one.
        (None, None) => resolution.max(BLIND_BAND * fastest),
    };
    let rows = Rows::new(&ready, band, options.symmetric);
    let solution = rows.solve();
    Ok(Report { ready: &ready, options, rows: &rows, levels, band, fastest }.identification(solution))
}

/// The rows outside the band.
struct Rows {
    columns: Vec<Vec<f64>>,
    target: Vec<f64>,
    at: Vec<usize>,
    errors: Vec<f64>,
    symmetric: bool,
}

impl Rows {
    fn new(ready: &Ready<'_>, band: f64, symmetric: bool) -> Self {
        let v = &ready.velocity;
        let where_ = |test: &dyn Fn(f64) -> bool, value: &dyn Fn(usize) -> f64| -> Vec<f64> {
            let column: Vec<f64> =
                v.iter().enumerate().map(|(i, v)| if test(*v) { value(i) } else { 0.0 }).collect();
            ready.rows(&column)
        };
        let (up, down) = (|v: f64| v > band, |v: f64| v < -band);
        let measured = |i: usize| ready.signals.velocity[i];
        let inside = where_(&|v| v.abs() <= band && band > 0.0, &|_| 1.0);
        let ways = [where_(&up, &|_| 1.0), where_(&down, &|_| -1.0)];
        let viscous = [where_(&up, &measured), where_(&down, &measured)];
        let kept: Vec<usize> = (0..ready.force_rows.len()).filter(|i| inside[*i].abs() <= LEAK).collect();
        let pick = |column: &[f64]| -> Vec<f64> { kept.iter().map(|i| column[*i]).collect() };
        let share = |way: &[f64]| {
            kept.iter().filter(|i| way[**i].abs() > 0.5).count() as f64 / kept.len().max(1) as f64
        };
        let (var_a, var_v) = (ready.errors.acceleration, ready.errors.velocity);
        let acceleration = pick(&ready.acceleration_rows);
        let (columns, errors) = if symmetric {
            let sum = |pair: &[Vec<f64>; 2]| -> Vec<f64> {
                kept.iter().map(|i| pair[0][*i] + pair[1][*i]).collect()
            };
            (
                vec![acceleration, sum(&ways), sum(&viscous), vec![1.0; kept.len()]],
                vec![var_a, 0.0, var_v, 0.0],
            )
        } else {
            let columns =
                vec![acceleration, pick(&ways[0]), pick(&viscous[0]), pick(&ways[1]), pick(&viscous[1])];
            (columns, vec![var_a, 0.0, var_v * share(&ways[0]), 0.0, var_v * share(&ways[1])])
        };
        let (mut columns, mut errors) = (columns, errors);
        // Behind a filter a row still sees a little of the band: nothing of it while the body sticks, a level while it
        // slides through. The data say how much; it is not reported.
        if band > 0.0 && !ready.signals.keeps_every_sample() {
            let sign = |i: usize| if v[i] > 0.0 { 1.0 } else { -1.0 };
            columns.push(pick(&where_(&|v| v.abs() <= band, &sign)));
            errors.push(0.0);
        }
        Self {
            columns,
            target: pick(&ready.force_rows),
            at: pick_numbers(&ready.at, &kept),
            errors,
            symmetric,
        }
    }

    fn solve(&self) -> Option<Solution> {
        Problem { columns: &self.columns, target: &self.target, at: &self.at, errors: &self.errors }.solve()
    }

    /// Static friction and Δv, given sliding friction.
    fn static_levels(&self, ready: &Ready<'_>, solution: &Solution) -> StaticLevels {
        let c = &solution.coefficients;
        let lost = |k: usize| solution.dropped.iter().any(|(d, _)| *d == k);
        let mass = if lost(0) { 0.0 } else { c[0] };
        let (coulomb, viscous, offset) = if self.symmetric {
            ([c[1], c[1]], [c[2], c[2]], c[3])
        } else {
            ([c[1], c[3]], [c[2], c[4]], 0.0)
        };
        let signals = ready.signals;
        let friction: Vec<f64> = signals
            .force_full()
            .iter()
            .zip(&signals.acceleration)
            .map(|(f, a)| f - mass * a - offset)
            .collect();
        let n = solution.residual.len().max(1) as f64;
        let noise = (solution.residual.iter().map(|e| e * e).sum::<f64>() / n).sqrt();
        LowSpeed {
            velocity: &signals.known(&ready.velocity),
            velocity_std: ready.velocity_std,
            friction: &friction,
            coulomb,
            viscous,
            noise,
            blur: ready.blur * rms(&signals.acceleration),
            independence: (solution.effective_samples / n).clamp(1e-3, 1.0),
        }
        .find()
    }
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
    fn names(&self) -> &'static [&'static str] {
        if self.rows.symmetric { &SYMMETRIC } else { &ASYMMETRIC }
    }

    /// Names in the JSON of a column: both directions where one column stands for both.
    fn reported(name: &'static str) -> &'static [&'static str] {
        match name {
            "coulomb" => &["coulomb_p", "coulomb_n"],
            "viscous" => &["viscous_p", "viscous_n"],
            "mass" => &["mass"],
            "coulomb_p" => &["coulomb_p"],
            "coulomb_n" => &["coulomb_n"],
            "viscous_p" => &["viscous_p"],
            "viscous_n" => &["viscous_n"],
            _ => &["offset"],
        }
    }

    fn identification(&self, solution: Option<Solution>) -> Identification {
        let units = self.ready.units;
        let moves = self.ready.moves();
        let mut parameters = BTreeMap::new();
        let mut not_identifiable = Vec::new();
        let names = self.names();
        let mut kept = Vec::new();
        for (k, name) in names.iter().enumerate() {
            let why = match &solution {
                None => Some(self.nothing()),
                Some(s) => s
                    .dropped
                    .iter()
                    .find(|(d, _)| *d == k)
                    .map(|(_, why)| self.because(name, why))
                    .or_else(|| {
                        let variance = s.covariance[(k, k)];
                        (!(variance.is_finite() && variance >= 0.0 && s.coefficients[k].is_finite()))
                            .then(|| "the errors of the regressors are larger than the motion".to_string())
                    }),
            };
            for reported in Self::reported(name) {
                match (&why, &solution) {
                    (None, Some(s)) => {
                        let (value, unit) = (s.coefficients[k], units.parameter(reported));
                        let mut estimate = Estimate::gaussian(value, s.covariance[(k, k)].sqrt(), unit);
                        estimate.std_white = Some(s.white[(k, k)].max(0.0).sqrt());
                        parameters.insert((*reported).to_string(), estimate);
                    }
                    (why, _) => not_identifiable.push(NotIdentifiable {
                        parameter: (*reported).into(),
                        because: why.clone().unwrap_or_default(),
                        experiment: if *name == "mass" { moves.faster() } else { moves.reversing() },
                    }),
                }
            }
            if why.is_none() {
                kept.push(k);
            }
        }
        self.levels.report(units, self.fastest, &moves, &mut parameters, &mut not_identifiable);
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
            parameters,
            not_identifiable,
            recording_faults: self.ready.signals.recording_faults(),
            force_unit: units.force().into(),
            residual_rms: fit.residual_rms,
            r_squared: fit.r_squared,
            estimator: self.estimator(),
            preprocess: self.ready.signals.description(),
            correlation_of: kept.iter().map(|k| names[*k].to_string()).collect(),
            correlation: kept.iter().map(|i| kept.iter().map(|j| entry(*i, *j)).collect()).collect(),
            effective_samples: solution.as_ref().map_or(0.0, |s| s.effective_samples),
        }
    }

    fn estimator(&self) -> String {
        let unit = self.ready.units.velocity();
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
            format!("samples slower than {:.3e} {unit} set aside", self.band)
        } else {
            "no sample set aside".to_string()
        };
        format!("{method}; {band}; deviations by a sandwich with Bartlett weights")
    }

    fn nothing(&self) -> String {
        format!(
            "{} samples slide faster than {:.3e} {}, and they do not determine the law",
            self.rows.target.len(),
            self.band,
            self.ready.units.velocity()
        )
    }

    fn because(&self, name: &str, why: &Dropped) -> String {
        match why {
            Dropped::Absent if name == "mass" => "the body never accelerates".into(),
            Dropped::Absent if name.ends_with("_p") => "the body never slides in positive direction".into(),
            Dropped::Absent if name.ends_with("_n") => "the body never slides in negative direction".into(),
            Dropped::Absent => "the body never slides".into(),
            Dropped::Collinear(others) => {
                let others: Vec<&str> = others.iter().filter_map(|k| self.names().get(*k)).copied().collect();
                format!("on this motion it cannot be told from {}", others.join(" and "))
            }
            Dropped::Noise(share) => format!(
                "{:.0} % of what is its own in the {} is measurement error",
                100.0 * share,
                if name == "mass" { "acceleration" } else { "velocity" }
            ),
        }
    }
}
