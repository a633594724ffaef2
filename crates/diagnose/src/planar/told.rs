//! What a search in the plane found, in the terms of every diagnosis.

use super::design::{BASELINE, Design};
use super::locate::Located;
use super::search::{Found, Hypothesis, Search};
use super::term::Kind;
use crate::result::{Blind, Curve, Figures, Missing, Quantity, Rejected};
use friction::Geometry;
use friction::effects::{Describe, Unnamed};
use identify::planar::{Ellipse, PLANAR_MODEL_SCHEMA, PlanarModel};
use nalgebra::DMatrix;
use std::collections::BTreeMap;

/// Move that shows a grain, and tells an axis from the other.
const LINES: &str = "slide to and fro along lines in several directions, each at two speeds";

/// A pattern that no hypothesis takes.
pub(super) fn unnamed(left: &Located, rms: f64) -> Option<Missing> {
    let place = left.regions.first()?;
    Some(Missing {
        effect: Unnamed::ABOUT.id.into(),
        says: format!(
            "Something that no effect looked for explains shows over {} from {:.3} to {:.3} {}.",
            place.coordinate.replace('_', " "),
            place.from,
            place.to,
            place.unit
        ),
        equation: String::new(),
        parameters: BTreeMap::new(),
        rms_heldout_before: rms,
        rms_heldout_after: rms,
        gain_ci95: [0.0, 0.0],
        p: left.p,
        indistinguishable_from: Vec::new(),
        experiment: LINES.into(),
        free_form: None,
    })
}

/// What a search found.
pub(super) struct Told<'a> {
    pub design: &'a Design,
    pub search: &'a Search<'a>,
    pub baseline: &'a Hypothesis,
    pub last: &'a Hypothesis,
    pub found: &'a [Found],
}

fn quantity(value: f64, std: f64, unit: impl Into<String>) -> Quantity {
    Quantity { value, std, unit: unit.into() }
}

impl Told<'_> {
    /// Parameters of the baseline; masses by axis where both are known.
    pub fn parameters(&self, h: &Hypothesis) -> BTreeMap<String, Quantity> {
        let mut out = BTreeMap::new();
        for (column, place) in self.design.present.iter().enumerate() {
            let (name, unit) = BASELINE[*place];
            out.insert(
                name.to_string(),
                quantity(h.fit.coefficients[column], h.fit.std_errors()[column], unit),
            );
        }
        if let (Some(mass), Some(difference)) = (out.remove("mass"), out.remove("mass_difference")) {
            let std = mass.std.hypot(difference.std);
            out.insert("mass_x".into(), quantity(mass.value + difference.value, std, "kg"));
            out.insert("mass_y".into(), quantity(mass.value - difference.value, std, "kg"));
        } else {
            out.insert("mass".into(), quantity(h.fit.coefficients[0], h.fit.std_errors()[0], "kg"));
        }
        out
    }

    /// Parameters of term `i`.
    fn term(&self, i: usize) -> BTreeMap<String, Quantity> {
        let (h, term) = (self.last, &self.last.terms[i]);
        let about = term.kind.about();
        let (values, from) = (h.coefficients(i), h.offset(i));
        let mut out = BTreeMap::new();
        if term.kind == Kind::Anisotropy {
            let stds = [h.fit.std_errors()[from], h.fit.std_errors()[from + 1]];
            let e = h.ellipse.c.hypot(h.ellipse.s).max(1e-9);
            let (c, s) = (h.ellipse.c / e, h.ellipse.s / e);
            let along = (c * stds[0]).hypot(s * stds[1]);
            let across = (s * stds[0]).hypot(c * stds[1]);
            let ratio = h.ellipse.across() / h.ellipse.along();
            // ratio² = (1 + e)/(1 − e)
            let slope = 1.0 / ((1.0 - e).powi(2) * ratio);
            let unit = |i: usize| about.shape[i].unit(Geometry::Linear).to_string();
            out.insert(about.shape[0].name.into(), quantity(ratio, slope * along, unit(0)));
            out.insert(about.shape[1].name.into(), quantity(h.ellipse.angle(), 0.5 * across / e, unit(1)));
            return out;
        }
        let suffix = term.kind.suffix();
        for (column, members) in term.free().iter().enumerate() {
            for m in *members {
                let parameter = &about.gains[*m];
                // along a path there is one direction
                let name =
                    if suffix.is_empty() { parameter.name.trim_end_matches("_p") } else { parameter.name };
                let q = quantity(
                    values[column],
                    h.fit.std_errors()[from + column],
                    parameter.unit(Geometry::Linear).to_string(),
                );
                out.insert(format!("{name}{suffix}"), q);
            }
        }
        let stds = self.shape_errors(i);
        for (axis, parameter) in about.shape.iter().enumerate() {
            let std = stds.get(axis).copied().unwrap_or(f64::NAN);
            let q = quantity(term.shape[axis], std, parameter.unit(Geometry::Linear).to_string());
            out.insert(format!("{}{suffix}", parameter.name), q);
        }
        out
    }

    /// Standard deviations of the shapes of term `i`: of a linear fit that has their derivatives as columns.
    fn shape_errors(&self, i: usize) -> Vec<f64> {
        let h = self.last;
        let term = h.terms[i];
        let shapes = term.kind.shapes();
        let mut columns = h.columns.clone();
        for axis in 0..shapes {
            let step = 1e-3 * term.shape[axis].abs().max(1e-12);
            let mut moved = term;
            moved.shape[axis] += step;
            let mut slope = vec![0.0; self.design.rows.len()];
            for ((a, b), gain) in
                moved.columns(self.design).iter().zip(term.columns(self.design)).zip(h.coefficients(i))
            {
                for ((s, a), b) in slope.iter_mut().zip(a).zip(b) {
                    *s += gain * (a - b) / step;
                }
            }
            columns.push(slope);
        }
        let p = columns.len();
        let gram = DMatrix::from_fn(p, p, |a, b| signals::dot(&columns[a], &columns[b]));
        let rows: f64 = self.design.share.iter().sum();
        let noise = signals::dot(&h.fit.residual, &h.fit.residual) / rows.max(1.0);
        let scale: Vec<f64> = (0..p).map(|a| gram[(a, a)].sqrt().max(1e-300)).collect();
        let unit = DMatrix::from_fn(p, p, |a, b| gram[(a, b)] / (scale[a] * scale[b]));
        let Some(inverse) = unit.try_inverse() else { return vec![f64::NAN; shapes] };
        (p - shapes..p).map(|a| (noise * inverse[(a, a)].max(0.0)).sqrt() / scale[a]).collect()
    }

    pub fn missing(&self) -> Vec<Missing> {
        let rows: f64 = self.design.share.iter().sum();
        let rms = |h: &Hypothesis| (h.fit.heldout_sum() / rows.max(1e-300)).sqrt();
        let one = |(i, found): (usize, &Found)| {
            let about = found.term.kind.about();
            let without = self.search.without(self.last, i);
            let rivals = self.search.rivals(self.last, i);
            Missing {
                effect: about.id.into(),
                says: about.says.into(),
                equation: about.equation.into(),
                parameters: self.term(i),
                rms_heldout_before: without.as_ref().map_or(f64::NAN, &rms),
                rms_heldout_after: rms(self.last),
                gain_ci95: without.as_ref().map_or([0.0, 0.0], |w| self.search.interval(w, self.last)),
                p: found.p,
                experiment: if rivals.is_empty() { String::new() } else { LINES.into() },
                indistinguishable_from: rivals.into_iter().map(Into::into).collect(),
                free_form: None,
            }
        };
        let mut out: Vec<Missing> = self.found.iter().enumerate().map(one).collect();
        out.sort_by(|a, b| {
            let gain = |m: &Missing| m.rms_heldout_before - m.rms_heldout_after;
            gain(b).total_cmp(&gain(a))
        });
        out
    }

    /// What the motion does not show, and what is not there.
    pub fn not_found(&self, kinds: &[Kind]) -> (Vec<Blind>, Vec<Rejected>) {
        let (mut blind, mut rejected): (Vec<Blind>, Vec<Rejected>) = (Vec::new(), Vec::new());
        for (kind, bound) in self.search.bounds(self.last, kinds) {
            let id = kind.about().id;
            match bound {
                Some(bound) => match rejected.iter_mut().find(|r| r.effect == id) {
                    Some(other) => other.upper_bound = other.upper_bound.max(bound),
                    None => {
                        rejected.push(Rejected { effect: id.into(), upper_bound: bound, unit: "N".into() });
                    }
                },
                None if blind.iter().all(|b| b.effect != id) => blind.push(Blind {
                    effect: id.into(),
                    because: "on this motion its force is one of the baseline".into(),
                    experiment: LINES.into(),
                }),
                None => {}
            }
        }
        let named = |id: &str| self.found.iter().any(|f| f.term.kind.about().id == id);
        rejected.retain(|r| !named(&r.effect) && blind.iter().all(|b| b.effect != r.effect));
        (blind, rejected)
    }

    /// The model, of a body whose friction is an ellipse.
    pub fn model(&self, cutoff: f64) -> PlanarModel {
        let (h, parameters) = (self.last, self.parameters(self.last));
        let of = |name: &str| parameters.get(name).map_or(0.0, |q| q.value);
        let mass =
            |name: &str| parameters.get(name).or(parameters.get("mass")).map_or(0.0, |q| q.value.max(0.0));
        let ellipse = Ellipse { level: h.fit.coefficients[h.level].max(0.0), ..h.ellipse };
        PlanarModel {
            schema: PLANAR_MODEL_SCHEMA.into(),
            name: String::new(),
            mass_x: mass("mass_x"),
            mass_y: mass("mass_y"),
            level_along: ellipse.along(),
            level_across: ellipse.across(),
            angle: ellipse.angle(),
            viscous_xx: of("viscous_xx"),
            viscous_xy: of("viscous_xy"),
            viscous_yy: of("viscous_yy"),
            offset_x: of("offset_x"),
            offset_y: of("offset_y"),
            cutoff_hz: Some(cutoff),
            std: parameters
                .into_iter()
                .map(|(name, q)| (name, q.std))
                .filter(|(_, s)| s.is_finite())
                .collect(),
        }
    }

    /// Series along the motion, in order of time: distance slid, speed, and the force that acts along it.
    pub fn figures(&self, curves: Vec<Curve>) -> Figures {
        let mut out = Figures { curves, ..Figures::default() };
        let mut place = BTreeMap::new();
        for (i, row) in self.design.rows.iter().enumerate() {
            place.insert((row.track, row.axis, row.r), i);
        }
        for (track, t) in self.design.tracks.iter().enumerate() {
            let mut slid = 0.0;
            let path: Vec<f64> = t
                .speed
                .iter()
                .map(|v| {
                    slid += v * t.raw[0].dt;
                    slid
                })
                .collect();
            let [towards_x, towards_y, speed, along_path] =
                [&t.direction[0], &t.direction[1], &t.speed, &path].map(|s| t.row_means(s));
            for r in 0..t.row_count() {
                let (Some(x), Some(y)) = (place.get(&(track, 0, r)), place.get(&(track, 1, r))) else {
                    continue;
                };
                let (nx, ny) = (towards_x[r], towards_y[r]);
                if !(nx.is_finite() && ny.is_finite()) {
                    continue;
                }
                let along = |series: &[f64]| nx * series[*x] + ny * series[*y];
                out.time.push(t.row_time(r));
                out.position.push(along_path[r]);
                out.velocity.push(speed[r]);
                out.force.push(along(&self.design.force));
                out.before.push(along(&self.baseline.fit.heldout_prediction));
                // an ellipse is fitted to the force moved by a known part, and so is what it predicts
                let left = |row: usize| {
                    self.last.fit.heldout_prediction[row] - (self.last.target[row] - self.design.force[row])
                };
                out.after.push(nx * left(*x) + ny * left(*y));
            }
        }
        out
    }
}
