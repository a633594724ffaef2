//! Dahl's law with its stiffness free [thesis, eq. 3.2, 3.3, 3.10], where it is set by hand.
//!
//! Levenberg-Marquardt on mass, viscous, ln D_p, ln D_n and ln σ, with derivatives taken through the law itself. The
//! squared error is flat in σ wherever the bristle bends by less than a sample's travel, so a start there would
//! stay there: σ is first scanned over every length the motion can resolve. Whether the recording determines σ at
//! all, its profile likelihood says; when it does not, the answer is a lower bound and a move, not a number.

use crate::dahl_fit::{COUNT, Fitted, LIMIT_N, LIMIT_P, MASS, Point, SIGMA, Trace, VISCOUS};
use crate::identification::{Estimate, Identification, NotIdentifiable, SCHEMA, unit_of};
use crate::linear::{Dropped, Problem};
use crate::moves::Moves;
use crate::ready::Ready;
use crate::{Errors, Signals};
use friction::Dimension;
use signals::Error;
use std::collections::BTreeMap;

/// Where a fit of Dahl's law starts. SI units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DahlStart {
    /// kg.
    pub mass: f64,
    /// N·s/m.
    pub viscous: f64,
    /// D_p, N.
    pub limit_p: f64,
    /// D_n, N.
    pub limit_n: f64,
    /// σ, N/m.
    pub sigma: f64,
}

/// How to fit Dahl's law.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DahlOptions {
    /// Start; None: from a straight line through the sliding samples.
    pub start: Option<DahlStart>,
    /// What is done about errors in velocity and acceleration.
    pub errors: Errors,
    /// Scan σ first, so that no start is a bad one. Off: Levenberg-Marquardt from `start` alone.
    pub scan: bool,
}

impl Default for DahlOptions {
    fn default() -> Self {
        Self { start: None, errors: Errors::default(), scan: true }
    }
}

const NAMES: [&str; COUNT] = ["mass", "viscous", "limit_p", "limit_n", "sigma"];
/// A level or stiffness whose logarithm has a larger deviation is not known.
const VAGUE: f64 = 1.5;
/// χ² with one degree of freedom, 95 %.
const CHI_SQUARED: f64 = 3.841;
const ALL: [usize; COUNT] = [MASS, VISCOUS, LIMIT_P, LIMIT_N, SIGMA];
const BUT_SIGMA: [usize; COUNT - 1] = [MASS, VISCOUS, LIMIT_P, LIMIT_N];

/// Fits Dahl's law to a recording.
///
/// # Errors
/// A start that is not finite and positive where it must be, or a recording with too few samples in motion.
pub fn identify_dahl(signals: &Signals, options: &DahlOptions) -> Result<Identification, Error> {
    fit(signals, options, &|| false)
}

/// As [`identify_dahl`]. Asks `is_interrupted` at each evaluation of the law; None once it says so.
///
/// # Errors
/// As [`identify_dahl`].
pub fn identify_dahl_watched(
    signals: &Signals,
    options: &DahlOptions,
    is_interrupted: &dyn Fn() -> bool,
) -> Result<Option<Identification>, Error> {
    let found = fit(signals, options, is_interrupted)?;
    Ok((!is_interrupted()).then_some(found))
}

fn fit(
    signals: &Signals,
    options: &DahlOptions,
    is_interrupted: &dyn Fn() -> bool,
) -> Result<Identification, Error> {
    let ready = Ready::new(signals, options.errors)?;
    let start = match options.start {
        Some(start) => checked(&start)?,
        None => first_guess(&ready)?,
    };
    Ok(with_trace(&ready, is_interrupted, |trace| {
        let best = search(trace, &ready, &start, options.scan);
        Report { trace, ready: &ready, best }.identification()
    }))
}

/// A trace over ready signals, handed to `use_it`.
fn with_trace<R>(
    ready: &Ready<'_>,
    is_interrupted: &dyn Fn() -> bool,
    use_it: impl FnOnce(&Trace<'_>) -> R,
) -> R {
    let rows = |series: &[f64]| ready.rows(series);
    use_it(&Trace {
        dt: ready.dt,
        displacement: &ready.displacement,
        velocity: &ready.velocity,
        linear: [ready.acceleration_rows.clone(), ready.velocity_rows.clone()],
        force: ready.force_rows.clone(),
        rows: &rows,
        errors: [ready.errors.acceleration, ready.errors.velocity],
        is_interrupted,
    })
}

/// A bristle shorter than this many deviations of the position is not resolved: it looks as long as the errors.
const RESOLVED: f64 = 4.0;

fn checked(start: &DahlStart) -> Result<Point, Error> {
    let values = [start.mass, start.viscous, start.limit_p, start.limit_n, start.sigma];
    for (k, value) in values.iter().enumerate() {
        let positive = k >= LIMIT_P;
        if !value.is_finite() || positive && *value <= 0.0 {
            return Err(Error::Parameter {
                parameter: NAMES[k].into(),
                value: value.to_string(),
                accepted: if positive {
                    "accepted is a number above 0"
                } else {
                    "accepted is a finite number"
                }
                .into(),
            });
        }
    }
    Ok([start.mass, start.viscous, start.limit_p.ln(), start.limit_n.ln(), start.sigma.ln()])
}

/// Mass, viscous and the mean limit from a straight line through every sample; σ for a bristle of a hundredth of the stroke.
fn first_guess(ready: &Ready<'_>) -> Result<Point, Error> {
    let band = 0.1 * ready.velocity.iter().fold(0.0f64, |m, v| m.max(v.abs()));
    let sign: Vec<f64> = ready
        .velocity
        .iter()
        .map(|v| if v.abs() > band { v.signum() } else { v / band.max(1e-300) })
        .collect();
    let columns = vec![ready.acceleration_rows.clone(), ready.velocity_rows.clone(), ready.rows(&sign)];
    let solution =
        Problem { columns: &columns, target: &ready.force_rows, at: &ready.at, errors: &[0.0; 3] }.solve();
    let Some(c) = solution.map(|s| s.coefficients).filter(|_| ready.travel > 0.0) else {
        return Err(Error::Recording {
            recording: ready.signals.name.clone(),
            why: "nothing moves: Dahl's law needs a motion with reversals".into(),
        });
    };
    let n = ready.force_rows.len() as f64;
    let rms = (ready.force_rows.iter().map(|f| f * f).sum::<f64>() / n).sqrt();
    let level = c[2].max(0.05 * rms).max(1e-9);
    Ok([c[0], c[1], level.ln(), level.ln(), (level / (0.01 * ready.travel)).ln()])
}

/// ln σ from a bristle that bends over half the stroke to one that bends by a fiftieth of a step.
fn log_sigma_range(ready: &Ready<'_>, level: f64) -> (f64, f64) {
    let soft = (level / (0.5 * ready.travel).max(1e-12)).max(1.0).ln();
    let rigid = (level / (0.02 * ready.step_rms).max(1e-15)).ln().min(25.0);
    (soft.min(rigid - 1.0).max(0.0), rigid.max(1.0))
}

fn search(trace: &Trace<'_>, ready: &Ready<'_>, start: &Point, scan: bool) -> Fitted {
    let from_start = trace.minimise(start, &ALL, 60);
    if !scan {
        return from_start;
    }
    let guess = first_guess(ready).unwrap_or(*start);
    let level = guess[LIMIT_P].exp().max(guess[LIMIT_N].exp());
    let (soft, rigid) = log_sigma_range(ready, level);
    let mut candidates = vec![from_start];
    let mut coarse: Vec<Fitted> = (0..9)
        .map(|i| {
            let mut point = guess;
            point[SIGMA] = soft + (rigid - soft) * f64::from(i) / 8.0;
            trace.minimise(&point, &BUT_SIGMA, 6)
        })
        .collect();
    coarse.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    candidates.extend(coarse.iter().take(2).map(|c| trace.minimise(&c.point, &ALL, 60)));
    candidates.extend(coarse.first());
    candidates.into_iter().min_by(|a, b| a.cost.total_cmp(&b.cost)).unwrap_or(from_start)
}

struct Report<'a> {
    trace: &'a Trace<'a>,
    ready: &'a Ready<'a>,
    best: Fitted,
}

/// The 95 % interval of ln σ; an end that the profile never reaches is None.
struct Profile {
    low: Option<f64>,
    high: Option<f64>,
}

impl Report<'_> {
    /// Squared error that one independent sample is worth.
    fn unit(&self, independence: f64) -> f64 {
        let n = self.trace.force.len() as f64;
        (self.best.cost.max(0.0) / (n - COUNT as f64).max(1.0) / independence.clamp(1e-6, 1.0))
            .max(f64::MIN_POSITIVE)
    }

    fn level(&self) -> f64 {
        self.best.point[LIMIT_P].max(self.best.point[LIMIT_N]).exp()
    }

    /// D/σ, the distance over which friction builds up, m.
    fn bristle(&self) -> f64 {
        self.level() / self.best.point[SIGMA].exp()
    }

    fn profile(&mut self, independence: f64) -> Profile {
        let level = self.level();
        let (soft, rigid) = log_sigma_range(self.ready, level);
        let low = self.side(-0.35, soft.min(self.best.point[SIGMA]) - 2.0, independence);
        let high = self.side(0.35, rigid.max(self.best.point[SIGMA]), independence);
        Profile { low, high }
    }

    /// Where the profile leaves the 95 % region on one side, walking by `step` up to `end`.
    fn side(&mut self, step: f64, end: f64, independence: f64) -> Option<f64> {
        let above =
            |report: &Self, cost: f64| cost - report.best.cost > CHI_SQUARED * report.unit(independence);
        let (mut at, mut point) = (self.best.point[SIGMA], self.best.point);
        loop {
            if (self.trace.is_interrupted)() {
                return None;
            }
            let next = at + step;
            // written so that what is not a number ends the walk
            if !((end - next) * step >= 0.0) {
                return None;
            }
            let fitted = self.at(next, &point);
            if above(self, fitted.cost) {
                break;
            }
            if fitted.cost < self.best.cost {
                // The walk found a better place: the profile is about it from now on.
                self.best = Fitted { evaluations: self.best.evaluations + fitted.evaluations, ..fitted };
            }
            (at, point) = (next, fitted.point);
        }
        let (mut inside, mut outside) = (at, at + step);
        for _ in 0..4 {
            let middle = 0.5 * (inside + outside);
            if above(self, self.at(middle, &point).cost) {
                outside = middle;
            } else {
                inside = middle;
            }
        }
        Some(0.5 * (inside + outside))
    }

    fn at(&self, log_sigma: f64, from: &Point) -> Fitted {
        let mut point = *from;
        point[SIGMA] = log_sigma;
        self.trace.minimise(&point, &BUT_SIGMA, 6)
    }

    fn identification(mut self) -> Identification {
        let independence = self.covariance(&ALL).map_or(1.0, |c| c.2);
        let profile = self.profile(independence);
        let known = profile.low.is_some()
            && profile.high.is_some()
            && self.bristle() > RESOLVED * self.ready.position_std;
        let free: &[usize] = if known { &ALL } else { &BUT_SIGMA };
        let solution = self.covariance(free);
        let geometry = self.ready.geometry;
        let moves = self.ready.moves();
        let p = self.best.point;
        let mut parameters = BTreeMap::new();
        let mut not_identifiable = Vec::new();
        let (mut of, mut correlation) = (Vec::new(), Vec::new());
        let (variances, dropped) = solution
            .as_ref()
            .map_or((Vec::new(), free.iter().map(|k| (*k, Dropped::Absent)).collect()), |(s, d, _)| {
                (s.clone(), d.clone())
            });
        for (j, k) in free.iter().enumerate() {
            let name = NAMES[*k];
            let variance = variances.get(j).and_then(|row| row.get(j)).copied().unwrap_or(f64::NAN);
            let why = dropped.iter().find(|(d, _)| d == k).map(|(_, why)| why);
            let vague = *k >= LIMIT_P && variance.sqrt() > VAGUE;
            if why.is_some() || vague || !variance.is_finite() || variance < 0.0 {
                let because = match why {
                    None if vague => {
                        format!("its deviation is a factor of {:.1e}", variance.sqrt().min(100.0).exp())
                    }
                    Some(Dropped::Absent) | None => "nothing in this motion depends on it".to_string(),
                    Some(Dropped::Collinear(others)) => {
                        let names: Vec<&str> = others.iter().filter_map(|o| NAMES.get(*o)).copied().collect();
                        format!("on this motion it cannot be told from {}", names.join(" and "))
                    }
                    Some(Dropped::Noise(share)) => {
                        format!("{:.0} % of what its signal varies is measurement error", 100.0 * share)
                    }
                };
                let experiment = match *k {
                    MASS => moves.faster(),
                    SIGMA => moves.presliding(),
                    _ => moves.reversing(),
                };
                not_identifiable.push(NotIdentifiable { parameter: name.into(), because, experiment });
                continue;
            }
            let std = variance.sqrt();
            let unit = unit_of(name, geometry);
            let estimate = if *k < LIMIT_P {
                Estimate::gaussian(p[*k], std, unit)
            } else {
                let value = p[*k].exp();
                // Errors of the position lengthen a bristle by no more than themselves: a bias, which the standard error includes.
                let blur = if *k == SIGMA { self.ready.position_std / self.bristle() } else { 0.0 };
                let std = std.hypot(blur);
                let mut ci95 = [value * (-1.96 * std).exp(), value * (1.96 * std).exp()];
                if let (SIGMA, Some(low), Some(high)) = (*k, profile.low, profile.high) {
                    ci95 = [ci95[0].min(low.exp()), ci95[1].max(high.exp())];
                }
                Estimate { ci95, ..Estimate::gaussian(value, value * std, unit) }
            };
            parameters.insert(name.to_string(), estimate);
            of.push(name.to_string());
            correlation.push(j);
        }
        if !known {
            not_identifiable.push(self.no_sigma(&profile, &moves));
        }
        let matrix = correlation
            .iter()
            .map(|i| {
                let entry = |j: &usize| {
                    let size = (variances[*i][*i] * variances[*j][*j]).sqrt();
                    if size > 0.0 { variances[*i][*j] / size } else { 0.0 }
                };
                correlation.iter().map(|j| if i == j { 1.0 } else { entry(j).clamp(-1.0, 1.0) }).collect()
            })
            .collect();
        let (residual, _) = self.trace.linearise(&p, &[]);
        let residual: Vec<f64> = residual.iter().map(|e| -e).collect();
        let fit = Ready::goodness(&self.trace.force, &residual);
        let n = residual.len();
        Identification {
            schema: SCHEMA.into(),
            law: "dahl".into(),
            samples: n,
            relative_error: fit.relative_error,
            recording_faults: self.ready.faults(&parameters),
            parameters,
            not_identifiable,
            preparation: vec![self.ready.signals.preparation().clone()],
            force_unit: Dimension::FORCE.unit(geometry).to_string(),
            residual_rms: fit.residual_rms,
            r_squared: fit.r_squared,
            estimator: format!(
                "Levenberg-Marquardt on Dahl's law with exact derivatives{}; {}, {} evaluations from the last start; σ by profile likelihood",
                if self.trace.errors == [0.0, 0.0] {
                    ""
                } else {
                    ", then Fuller's correction for errors in velocity and acceleration (eq. 3.9)"
                },
                if self.best.converged { "converged" } else { "not converged" },
                self.best.evaluations,
            ),
            preprocess: self.ready.signals.description(),
            correlation_of: of,
            correlation: matrix,
            effective_samples: independence * n as f64,
        }
    }

    /// Covariance of the free parameters at the best point, what could not be told, and independent samples per
    /// sample.
    #[allow(clippy::type_complexity)]
    fn covariance(&self, free: &[usize]) -> Option<(Vec<Vec<f64>>, Vec<(usize, Dropped)>, f64)> {
        let (residual, jacobian) = self.trace.linearise(&self.best.point, free);
        let columns: Vec<Vec<f64>> =
            (0..free.len()).map(|j| jacobian.column(j).iter().copied().collect()).collect();
        // The law made linear here: the same regression has the same errors.
        let target: Vec<f64> = (0..residual.len())
            .map(|i| {
                free.iter().enumerate().map(|(j, k)| columns[j][i] * self.best.point[*k]).sum::<f64>()
                    - residual[i]
            })
            .collect();
        let errors: Vec<f64> =
            free.iter().map(|k| if *k < LIMIT_P { self.trace.errors[*k] } else { 0.0 }).collect();
        let s =
            Problem { columns: &columns, target: &target, at: &self.ready.at, errors: &errors }.solve()?;
        let covariance =
            (0..free.len()).map(|i| (0..free.len()).map(|j| s.covariance[(i, j)]).collect()).collect();
        let dropped = s.dropped.into_iter().filter_map(|(j, why)| free.get(j).map(|k| (*k, why))).collect();
        Some((covariance, dropped, s.effective_samples / residual.len().max(1) as f64))
    }

    fn no_sigma(&self, profile: &Profile, moves: &Moves) -> NotIdentifiable {
        let geometry = self.ready.geometry;
        let level = self.level();
        let because = match (profile.low, profile.high) {
            (Some(low), Some(_)) => format!(
                "friction builds up over {:.1e} {}, and the position is only known to {:.1e}: σ is above {:.3e} {}, and how far \
                 above cannot be told",
                self.bristle(),
                Dimension::LENGTH.unit(geometry),
                self.ready.position_std,
                low.exp(),
                Dimension::STIFFNESS.unit(geometry)
            ),
            (Some(low), None) => format!(
                "any σ above {:.3e} {} explains the recording as well (95 %): the bristle bends by less than {:.1e} {}, \
                 and near a reversal the motion crosses that within {} samples",
                low.exp(),
                Dimension::STIFFNESS.unit(geometry),
                level / low.exp(),
                Dimension::LENGTH.unit(geometry),
                self.ready.samples_to_cross(level / low.exp())
            ),
            _ => "every σ explains the recording as well (95 %): there is no reversal that shows the bristle bend".into(),
        };
        NotIdentifiable { parameter: "sigma".into(), because, experiment: moves.presliding() }
    }
}
