//! The fit of mass, level, viscous friction and offset to a recording in the plane.

use super::ellipse::Ellipse;
use super::model::PlanarModel;
use super::track::Track;
use crate::identification::{Estimate, Identification, NotIdentifiable, SCHEMA};
use crate::linear::{Dropped, Problem, Solution};
use crate::ready::Ready;
use nalgebra::{DMatrix, DVector};
use signals::{
    Cutoff, Error, PlanarPrepared, PlanarRecording, RecordingFault, Settings, four_point_difference,
    prepare_planar,
};
use std::collections::BTreeMap;

/// χ² above which two parameters are not one, with one and with two degrees of freedom: p = 0.001.
const DIFFERENT: [f64; 2] = [10.83, 13.82];
/// Steps of the fit of the ellipse.
const STEPS: usize = 25;
/// Fewest rows of an axis that are fitted.
const FEWEST: usize = 30;
/// Rows between two stretches, and between the axes: none are neighbours.
const APART: usize = 1 << 20;

/// Law id of a level by direction.
pub const ELLIPSE: &str = "planar_coulomb";

/// What a column is the coefficient of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Term {
    Mass,
    MassX,
    MassY,
    Viscous,
    ViscousXx,
    ViscousXy,
    ViscousYy,
    OffsetX,
    OffsetY,
    Level,
    C,
    S,
    Lag,
}

impl Term {
    /// Its name and unit in files; none where it is part of an ellipse.
    fn named(self) -> Option<(&'static str, &'static str)> {
        Some(match self {
            Self::Mass => ("mass", "kg"),
            Self::MassX => ("mass_x", "kg"),
            Self::MassY => ("mass_y", "kg"),
            Self::Viscous => ("viscous", "N·s/m"),
            Self::ViscousXx => ("viscous_xx", "N·s/m"),
            Self::ViscousXy => ("viscous_xy", "N·s/m"),
            Self::ViscousYy => ("viscous_yy", "N·s/m"),
            Self::OffsetX => ("offset_x", "N"),
            Self::OffsetY => ("offset_y", "N"),
            Self::Lag => ("friction_lag", "s"),
            Self::Level | Self::C | Self::S => return None,
        })
    }

    /// Its unfiltered column, x and y; `units` is the derivative of the friction by level, c and s.
    fn columns(self, track: &Track, units: &[[Vec<f64>; 2]; 4]) -> [Vec<f64>; 2] {
        let none = || vec![0.0; track.len()];
        let ones = || vec![1.0; track.len()];
        match self {
            Self::Mass => track.a.clone(),
            Self::MassX => [track.a[0].clone(), none()],
            Self::MassY => [none(), track.a[1].clone()],
            Self::Viscous => track.v.clone(),
            Self::ViscousXx => [track.v[0].clone(), none()],
            Self::ViscousXy => [track.v[1].clone(), track.v[0].clone()],
            Self::ViscousYy => [none(), track.v[1].clone()],
            Self::OffsetX => [ones(), none()],
            Self::OffsetY => [none(), ones()],
            Self::Level => units[1].clone(),
            Self::C => units[2].clone(),
            Self::S => units[3].clone(),
            // F(t − lag) ≈ F − lag dF/dt
            Self::Lag => units[0]
                .each_ref()
                .map(|f| four_point_difference(f, track.raw[0].dt).iter().map(|rate| -rate).collect()),
        }
    }
}

/// Force of the ellipse and its derivatives at every sample.
fn units(track: &Track, ellipse: &Ellipse) -> [[Vec<f64>; 2]; 4] {
    let mut out: [[Vec<f64>; 2]; 4] = std::array::from_fn(|_| [Vec::new(), Vec::new()]);
    for i in 0..track.len() {
        for (part, force) in out.iter_mut().zip(ellipse.force(track.v[0][i], track.v[1][i])) {
            part[0].push(force[0]);
            part[1].push(force[1]);
        }
    }
    out
}

/// Rows of x, then rows of y, of every track.
fn stacked(tracks: &[Track], of: impl Fn(&Track) -> [Vec<f64>; 2]) -> Vec<f64> {
    let both: Vec<[Vec<f64>; 2]> = tracks
        .iter()
        .map(|t| {
            let [x, y] = of(t);
            [t.rows(&x), t.rows(&y)]
        })
        .collect();
    [0, 1].into_iter().flat_map(|axis| both.iter().flat_map(move |b| b[axis].iter().copied())).collect()
}

/// A solution and the ellipse it ended with.
struct Solved {
    terms: Vec<Term>,
    solution: Solution,
    ellipse: Ellipse,
}

impl Solved {
    fn place(&self, term: Term) -> Option<usize> {
        let at = self.terms.iter().position(|t| *t == term)?;
        self.solution.dropped.iter().all(|(d, _)| *d != at).then_some(at)
    }

    fn covariance(&self, of: &[Term]) -> Option<DMatrix<f64>> {
        let places: Option<Vec<usize>> = of.iter().map(|t| self.place(*t)).collect();
        let places = places?;
        Some(DMatrix::from_fn(places.len(), places.len(), |i, j| {
            self.solution.covariance[(places[i], places[j])]
        }))
    }

    fn value(&self, term: Term) -> Option<f64> {
        Some(self.solution.coefficients[self.place(term)?])
    }

    /// χ² of the hypothesis that these combinations are zero.
    fn chi_squared(&self, of: &[Term], combinations: &[&[f64]]) -> Option<f64> {
        let covariance = self.covariance(of)?;
        let values: Option<Vec<f64>> = of.iter().map(|t| self.value(*t)).collect();
        let values = DVector::from_vec(values?);
        let by = DMatrix::from_fn(combinations.len(), of.len(), |i, j| combinations[i][j]);
        let difference = &by * values;
        let inverse = (&by * covariance * by.transpose()).try_inverse()?;
        Some(difference.dot(&(inverse * &difference)))
    }
}

/// The rows of a recording.
struct Rows<'a> {
    tracks: &'a [Track],
    force: Vec<f64>,
    at: Vec<usize>,
    /// Error variance of the acceleration over the rows of x, and of y.
    noise: [f64; 2],
}

impl<'a> Rows<'a> {
    fn of(tracks: &'a [Track]) -> Self {
        let force = stacked(tracks, |t| t.f.clone());
        let (mut at, mut from) = (Vec::new(), 0);
        for _ in 0..2 {
            for t in tracks {
                at.extend((0..t.row_count()).map(|r| from + r));
                from += t.row_count() + APART;
            }
        }
        let mut noise = [0.0; 2];
        for t in tracks {
            let rows: f64 = t.share().iter().sum();
            for (sum, std) in noise.iter_mut().zip(t.acceleration_noise) {
                *sum += rows * std * std;
            }
        }
        let noise = noise.map(|sum| sum / force.len().max(1) as f64);
        Self { tracks, force, at, noise }
    }

    /// Fits the terms by Gauss and Newton: the columns of the ellipse are its derivatives where the last step ended.
    fn solve(&self, terms: &[Term], start: Ellipse) -> Option<Solved> {
        let mut ellipse = start;
        let errors: Vec<f64> = terms
            .iter()
            .map(|term| match term {
                Term::Mass => self.noise[0] + self.noise[1],
                Term::MassX => self.noise[0],
                Term::MassY => self.noise[1],
                _ => 0.0,
            })
            .collect();
        let bends = terms.contains(&Term::C);
        for step in 0..STEPS {
            let derived: Vec<[[Vec<f64>; 2]; 4]> = self.tracks.iter().map(|t| units(t, &ellipse)).collect();
            let column = |term: &Term| {
                let mut tracks = derived.iter();
                let both: Vec<[Vec<f64>; 2]> = self
                    .tracks
                    .iter()
                    .map(|t| {
                        let [x, y] = tracks.next().map(|u| term.columns(t, u)).unwrap_or_default();
                        [t.rows(&x), t.rows(&y)]
                    })
                    .collect();
                [0, 1]
                    .into_iter()
                    .flat_map(|axis| both.iter().flat_map(move |b| b[axis].iter().copied()))
                    .collect::<Vec<f64>>()
            };
            let columns: Vec<Vec<f64>> = terms.iter().map(column).collect();
            // F(θ) ≈ F(θ₀) + J (θ − θ₀), and the force is proportional to its level
            let mut target = self.force.clone();
            for (column, value) in columns.iter().zip(terms.iter().map(|t| match t {
                Term::C => ellipse.c,
                Term::S => ellipse.s,
                _ => 0.0,
            })) {
                for (t, x) in target.iter_mut().zip(column) {
                    *t += value * x;
                }
            }
            let problem = Problem { columns: &columns, target: &target, at: &self.at, errors: &errors };
            let solved = Solved { terms: terms.to_vec(), solution: problem.solve()?, ellipse };
            let next = Ellipse {
                level: solved.value(Term::Level)?,
                c: solved.value(Term::C).unwrap_or(0.0),
                s: solved.value(Term::S).unwrap_or(0.0),
            };
            let moved = (next.c - ellipse.c).hypot(next.s - ellipse.s)
                + ((next.level - ellipse.level) / next.level.abs().max(1e-12)).abs();
            ellipse = next.bounded();
            if !bends || moved < 1e-9 || step + 1 == STEPS {
                return Some(Solved { ellipse, ..solved });
            }
        }
        None
    }
}

/// How to identify in the plane; the default is right for most recordings.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct PlanarOptions {
    /// Cut-off of the filter, Hz; chosen from the noise when not given.
    pub cutoff_hz: Option<f64>,
    /// Without correction of the errors in the acceleration.
    pub least_squares: bool,
}

/// What was identified in the plane, and the series it was made of.
#[derive(Debug, Clone)]
pub struct PlanarIdentified {
    /// The result, in the JSON of every identification.
    pub found: Identification,
    /// The model.
    pub model: PlanarModel,
    /// The stretches.
    pub tracks: Vec<Track>,
}

/// Identifies mass, level of friction by direction, viscous friction and offset from recordings in the plane.
///
/// The level is an ellipse, F = G v/√(vᵀGv) ([`Ellipse`]). One mass, one viscous coefficient and one level for all directions
/// stand in the result where the recording does not show that they differ (Wald's test, p = 0.001).
///
/// # Errors
/// No recording, recordings of different rates, too little motion.
pub fn identify_planar(
    recordings: &[PlanarRecording],
    options: &PlanarOptions,
) -> Result<PlanarIdentified, Error> {
    let Some(first) = recordings.first() else {
        let why = "no recording: give at least one".into();
        return Err(Error::Recording { recording: "identify".into(), why });
    };
    let settings =
        Settings { cutoff: options.cutoff_hz.map_or(Cutoff::OfSearch, Cutoff::Given), ..Settings::default() };
    let prepared: Vec<PlanarPrepared> =
        recordings.iter().map(|r| prepare_planar(r, &settings)).collect::<Result<_, _>>()?;
    let chosen = prepared.iter().filter_map(|p| p.report.cutoff_hz).fold(f64::INFINITY, f64::min);
    let tracks: Vec<Track> = prepared
        .iter()
        .flat_map(|p| &p.stretches)
        .map(|s| Track::new(s.clone(), chosen))
        .filter(|t| t.row_count() >= 24)
        .collect();
    let rows: f64 = tracks.iter().flat_map(Track::share).sum();
    let refuse = |why: String| Err(Error::Recording { recording: first.name.clone(), why });
    if rows < FEWEST as f64 {
        return refuse(format!(
            "{rows:.0} rows of samples at which the body slides in a known direction, at least {FEWEST} are needed"
        ));
    }
    let mut data = Rows::of(&tracks);
    if options.least_squares {
        data.noise = [0.0; 2];
    }
    let Some(solved) = selected(&data) else {
        return refuse(
            "mass, friction and offset cannot be told apart on this motion: move in more directions".into(),
        );
    };
    let faults: Vec<RecordingFault> = prepared.iter().flat_map(|p| p.faults.clone()).collect();
    let mut found = described(&data, &solved, rows);
    found.recording_faults = faults;
    found.preparation = prepared.into_iter().map(|p| p.report).collect();
    found.preprocess =
        format!("one zero-phase filter at {chosen:.3} Hz on every signal and regressor of both axes");
    let mut model = PlanarModel::of(&found, solved.ellipse);
    model.cutoff_hz = Some(chosen);
    Ok(PlanarIdentified { found, model, tracks })
}

/// The fit with as many parameters as the recording tells apart.
fn selected(data: &Rows) -> Option<Solved> {
    let mass = [Term::MassX, Term::MassY];
    let viscous = [Term::ViscousXx, Term::ViscousXy, Term::ViscousYy];
    let bend = [Term::C, Term::S];
    let offsets = [Term::OffsetX, Term::OffsetY];
    let terms = |m: &[Term], v: &[Term], e: &[Term]| [m, v, &offsets[..], &[Term::Level][..], e].concat();
    let disc = data.solve(&terms(&mass, &viscous, &[]), Ellipse { level: 1.0, ..Ellipse::default() })?;
    let full = data.solve(&terms(&mass, &viscous, &bend), disc.ellipse).unwrap_or(disc);
    let differ = |of: &[Term], combinations: &[&[f64]]| {
        let most = DIFFERENT[combinations.len() - 1];
        full.chi_squared(of, combinations).is_some_and(|chi| chi > most)
    };
    let m = if differ(&mass, &[&[1.0, -1.0]]) { &mass[..] } else { &[Term::Mass] };
    let v = if differ(&viscous, &[&[1.0, 0.0, -1.0], &[0.0, 1.0, 0.0]]) {
        &viscous[..]
    } else {
        &[Term::Viscous]
    };
    let e = if differ(&bend, &[&[1.0, 0.0], &[0.0, 1.0]]) { &bend[..] } else { &[] };
    let start = if e.is_empty() { Ellipse { c: 0.0, s: 0.0, ..full.ellipse } } else { full.ellipse };
    let instant = terms(m, v, e);
    let lagging = data.solve(&[&instant[..], &[Term::Lag]].concat(), start);
    lagging.filter(|found| found.place(Term::Lag).is_some()).or_else(|| data.solve(&instant, start))
}

/// The solution in the JSON of an identification.
fn described(data: &Rows, solved: &Solved, rows: f64) -> Identification {
    let mut parameters = BTreeMap::new();
    let mut not_identifiable = Vec::new();
    for (i, term) in solved.terms.iter().enumerate() {
        let Some((name, unit)) = term.named() else { continue };
        match solved.solution.dropped.iter().find(|(d, _)| *d == i) {
            None => {
                let std = solved.solution.covariance[(i, i)].max(0.0).sqrt();
                parameters
                    .insert(name.into(), Estimate::gaussian(solved.solution.coefficients[i], std, unit));
            }
            Some((_, why)) => not_identifiable.push(NotIdentifiable {
                parameter: name.into(),
                because: match why {
                    Dropped::Absent => "the body does not move that way".into(),
                    Dropped::Collinear(_) => "other parameters have the same force on this motion".into(),
                    Dropped::Noise(share) => format!("{:.0} % of its regressor is noise", 100.0 * share),
                },
                experiment: "move in circles and along lines in several directions, at several speeds".into(),
            }),
        }
    }
    let ellipse = &solved.ellipse;
    match solved.covariance(&[Term::Level, Term::C, Term::S]) {
        Some(covariance) => {
            for (name, unit, of) in SHAPE {
                let std = propagated(&covariance, ellipse, of);
                parameters.insert(name.into(), Estimate::gaussian(of(ellipse), std, unit));
            }
        }
        None => {
            if let Some(covariance) = solved.covariance(&[Term::Level]) {
                let std = covariance[(0, 0)].max(0.0).sqrt();
                parameters.insert("level".into(), Estimate::gaussian(ellipse.level, std, "N"));
            }
            not_identifiable.push(NotIdentifiable {
                parameter: "angle".into(),
                because: "the level is the same in every direction, as far as this recording shows".into(),
                experiment: "slide along lines in several directions, to and fro, at one speed".into(),
            });
        }
    }
    let residual = &solved.solution.residual;
    let goodness = Ready::goodness(&data.force, residual);
    Identification {
        schema: SCHEMA.into(),
        law: ELLIPSE.into(),
        samples: data.tracks.iter().map(|t| t.mask.iter().filter(|m| **m > 0.5).count()).sum(),
        relative_error: goodness.relative_error,
        parameters,
        not_identifiable,
        recording_faults: Vec::new(),
        preparation: Vec::new(),
        force_unit: "N".into(),
        // rows that are set aside count as nothing
        residual_rms: goodness.residual_rms * (residual.len() as f64 / (2.0 * rows)).sqrt(),
        r_squared: goodness.r_squared,
        estimator: "both axes at once: Fuller's estimator, the ellipse by Gauss and Newton".into(),
        preprocess: String::new(),
        correlation_of: Vec::new(),
        correlation: Vec::new(),
        effective_samples: solved.solution.effective_samples,
    }
}

/// What is said of an ellipse.
type Shape = (&'static str, &'static str, fn(&Ellipse) -> f64);
const SHAPE: [Shape; 3] = [
    ("level_along", "N", Ellipse::along),
    ("level_across", "N", Ellipse::across),
    ("angle", "rad", Ellipse::angle),
];

/// Standard deviation of a function of an ellipse, by differences.
fn propagated(covariance: &DMatrix<f64>, at: &Ellipse, of: fn(&Ellipse) -> f64) -> f64 {
    let step = 1e-6;
    let moved = [
        Ellipse { level: at.level + step, ..*at },
        Ellipse { c: at.c + step, ..*at },
        Ellipse { s: at.s + step, ..*at },
    ];
    let half_turn = std::f64::consts::PI;
    let slope = DVector::from_fn(3, |i, _| {
        let change = of(&moved[i]) - of(at);
        // an angle may step over by half a turn
        (if change.abs() > 1.0 { change - half_turn * change.signum() } else { change }) / step
    });
    slope.dot(&(covariance * &slope)).max(0.0).sqrt()
}
