//! Equation error: force regressed on the motion, as the start of a simulation-error fit.

use crate::data::Record;
use crate::error::Error;
use crate::place::{Place, Way};
use friction::effects::MAX_MEMORY;
use friction::{Motion, Scalar};
use identify::{Preprocess, Signals, prepare};
use nalgebra::{DMatrix, DVector};
use std::ops::Range;

/// Start of a fit, one value for each place.
pub(crate) struct Start {
    pub values: Vec<f64>,
    /// A change of each that changes the force by a few percent.
    pub scales: Vec<f64>,
}

/// Share of the force that a parameter moves by one scale.
const SHARE: f64 = 0.02;
/// Scale of a delay, samples; of a share of the force.
const DELAY: f64 = 0.1;

/// The parameters that the force is proportional to, by least squares over `span`; the others begin at zero.
pub(crate) fn start(places: &[Place], record: &Record, span: &Range<usize>) -> Result<Start, Error> {
    let signals = prepare(&record.part(span), &Preprocess::default())?;
    let force = signals.condition(&signals.force);
    let size = signals::rms(&force);
    let columns: Vec<Option<Vec<f64>>> =
        places.iter().map(|p| column(*p, &signals).map(|c| signals.condition(&c))).collect();
    let linear: Vec<&Vec<f64>> = columns.iter().flatten().collect();
    let norms: Vec<f64> = linear.iter().map(|c| signals::rms(c)).collect();
    if let Some(at) = norms.iter().position(|n| !(n.is_finite() && *n > 0.0)) {
        let place = places.iter().zip(&columns).filter(|(_, c)| c.is_some()).nth(at).map(|(p, _)| p.name());
        let why = format!(
            "the motion does not show {}; expected is the official recording",
            place.unwrap_or_default()
        );
        return Err(Error::Unfit { file: record.file.clone(), why });
    }
    let design = DMatrix::from_fn(force.len(), linear.len(), |i, j| linear[j][i] / norms[j]);
    let target = DVector::from_column_slice(&force);
    let solved = (design.transpose() * &design).cholesky().map(|c| c.solve(&(design.transpose() * target)));
    let Some(solved) = solved.filter(|s| s.iter().all(|x| x.is_finite())) else {
        let why =
            "the motion does not separate the parameters; expected is the official recording".to_owned();
        return Err(Error::Unfit { file: record.file.clone(), why });
    };
    let mut next = solved.iter().zip(&norms);
    let mut start = Start { values: Vec::new(), scales: Vec::new() };
    for (place, column) in places.iter().zip(&columns) {
        let (value, scale) = match column.as_ref().and_then(|_| next.next()) {
            Some((value, norm)) => (value / norm, SHARE * size / norm),
            None if *place == Place::Delay => (0.0, DELAY * signals.dt),
            None => (0.0, SHARE),
        };
        start.values.push(value);
        start.scales.push(scale);
    }
    let mass = places.iter().zip(&start.values).find(|(p, _)| **p == Place::Mass).map(|(_, v)| *v);
    if let Some(mass) = mass.filter(|m| !(*m > 0.0)) {
        let why = format!(
            "mass = {mass:e} kg by equation error; expected is a positive one: is the force's sign right?"
        );
        return Err(Error::Unfit { file: record.file.clone(), why });
    }
    Ok(start)
}

/// Force per unit of a parameter at every sample; None where the force is not proportional to it.
fn column(place: Place, signals: &Signals) -> Option<Vec<f64>> {
    let of = |way: Way, unit: &dyn Fn(f64) -> f64| {
        let in_way = |v: f64| match way {
            Way::Forward => v > 0.0,
            Way::Backward => v < 0.0,
            Way::Both => true,
        };
        signals.velocity.iter().map(|v| if in_way(*v) { unit(*v) } else { 0.0 }).collect()
    };
    match place {
        Place::Mass => Some(signals.acceleration.clone()),
        Place::Level(way) => Some(of(way, &|v| v.sgn())),
        Place::Viscous(way) => Some(of(way, &|v| v)),
        Place::Gain(kind, index) => {
            let unit = |(x, v): (&f64, &f64)| {
                let motion = Motion { position: *x, velocity: *v, ..Motion::default() };
                kind.unit(&[0.0; 2], &mut [0.0; MAX_MEMORY], &motion)[index]
            };
            Some(signals.position.iter().zip(&signals.velocity).map(unit).collect())
        }
        Place::Delay | Place::ForceGain => None,
    }
}
