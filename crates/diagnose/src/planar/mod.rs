//! Diagnosis of recordings in the plane.
//!
//! The baseline is a disc of friction, a mass of each axis, viscous friction and an offset. Both axes are rows of the one
//! regression of a diagnosis on a line, and are judged as there: by signs of whole blocks and by blocks held out. What may
//! be missing is the grain of the surface, effects of the catalogue along the path, and effects of one axis
//! ([`friction::planar::InPlane`]).

mod design;
mod locate;
mod search;
mod term;

use crate::findings::floor::REGULAR;
use crate::findings::unnamed::SEVERAL;
use crate::findings::words;
use crate::options::{Error, Options, Watch, tell};
use crate::pipeline::unanswered;
use crate::result::{
    After, Baseline, Blind, Diagnosis, Figures, Missing, NoiseFloor, Quantity, Rejected, Remainder, SCHEMA,
    Verdict,
};
use design::{BASELINE, Design};
use friction::Geometry;
use friction::effects::{Describe, Unnamed};
use identify::planar::{Ellipse, PLANAR_MODEL_SCHEMA, PlanarModel, Track};
use nalgebra::DMatrix;
use rayon::prelude::*;
use search::{Found, Hypothesis, Search};
use signals::{Cutoff, PlanarPrepared, PlanarRecording, RecordingFault, Settings, prepare_planar, quantum};
use std::collections::BTreeMap;
use std::ops::ControlFlow;
use term::{Kind, PlanarScales};

/// Move that shows a grain, and tells an axis from the other.
const LINES: &str = "slide to and fro along lines in several directions, each at two speeds";
/// Most regions that are told.
const MOST_REGIONS: usize = 12;

/// Ids of every effect that a diagnosis in the plane can name.
#[must_use]
pub fn planar_effect_ids() -> Vec<&'static str> {
    let mut ids: Vec<&str> = Kind::all(&[]).into_iter().map(|kind| kind.about().id).collect();
    ids.dedup();
    ids
}

/// A diagnosis in the plane.
#[derive(Debug, Clone)]
pub struct PlanarDiagnosis {
    /// The result, in the JSON of every diagnosis.
    pub found: Diagnosis,
    /// The model; None where something is missing that a planar model does not hold.
    pub model: Option<PlanarModel>,
}

/// Locates what a simulation leaves out of recordings in the plane, names it, and confirms it on blocks that were held out.
///
/// # Errors
/// No recording, recordings that cannot be prepared, an option outside its range or one that is for recordings on a line.
pub fn diagnose_planar(
    recordings: &[PlanarRecording],
    options: &Options,
    progress: &dyn Fn(f32, &str),
) -> Result<PlanarDiagnosis, Error> {
    options.validate()?;
    if recordings.is_empty() {
        return Err(Error::NoRecording);
    }
    for (name, asked) in
        [("per_recording", !options.per_recording.is_empty()), ("absolute", options.absolute)]
    {
        if asked {
            return Err(Error::Option { name, value: 1.0, accepted: "with recordings on a line only" });
        }
    }
    let watch = |share: f32, what: &str| {
        progress(share, what);
        ControlFlow::Continue(())
    };
    run(recordings, options, &watch)
}

fn run(
    recordings: &[PlanarRecording],
    options: &Options,
    watch: Watch<'_>,
) -> Result<PlanarDiagnosis, Error> {
    tell(watch, 0.0, "audit")?;
    let settings =
        Settings { cutoff: options.cutoff_hz.map_or(Cutoff::OfSearch, Cutoff::Given), ..Settings::default() };
    let mut prepared: Vec<PlanarPrepared> =
        recordings.iter().map(|r| prepare_planar(r, &settings)).collect::<Result<_, _>>()?;
    let cutoff = prepared.iter().filter_map(|p| p.report.cutoff_hz).fold(f64::INFINITY, f64::min);
    prepared.iter_mut().for_each(|p| p.report.cutoff_hz = p.report.cutoff_hz.map(|_| cutoff));
    tell(watch, 0.05, "filter and baseline")?;
    let (mut tracks, mut of) = (Vec::new(), Vec::new());
    for (index, p) in prepared.iter().enumerate() {
        for stretch in &p.stretches {
            let track = Track::new(stretch.clone(), cutoff);
            if track.row_count() >= 24 {
                tracks.push(track);
                of.push(index);
            }
        }
    }
    let samples: usize = tracks.iter().map(Track::len).sum();
    let judged = tracks.iter().flat_map(|t| &t.mask).sum::<f64>() / samples.max(1) as f64;
    let scales = PlanarScales::of(&tracks, cutoff);
    let untestable = |why: &str| Ok(untestable(&prepared, cutoff, why));
    let Some(mut design) = Design::new(tracks, &of) else {
        return untestable("too few samples at which the body slides in a known direction are left");
    };
    let kinds = Kind::all(&options.exclude);
    let catalogue = term::catalogue(&kinds, &scales);
    let first = {
        let search = searched(&design, &scales, (&[], &[]), (0.0, 0.0), options);
        search.hypothesis(&[], Ellipse::default())
    };
    let Some(first) = first else {
        return untestable(
            "mass, friction and offset cannot be told apart on this motion: move in more directions",
        );
    };
    design.blocks.mass = first.fit.coefficients[0];
    let rows: f64 = design.share.iter().sum();
    let (floor, systematic) = floors(&design, cutoff, options.declared_noise);
    let squared = rows * floor * floor;
    tell(watch, 0.1, "search")?;
    let mut disc = design.clone();
    disc.ellipse = Ellipse { level: first.fit.coefficients[first.level], ..Ellipse::default() };
    let columns: Vec<Vec<Vec<f64>>> = catalogue.par_iter().map(|t| t.columns(&disc)).collect();
    let search = searched(
        &design,
        &scales,
        (&catalogue, &columns),
        (squared, rows * systematic * systematic),
        options,
    );
    let said = |share: f32| {
        // interruption is for recordings on a line: a search in the plane takes seconds
        let _ = watch(0.1 + 0.6 * share, "search");
    };
    let Some((baseline, last, found)) = search.run(&said) else {
        return untestable(
            "mass, friction and offset cannot be told apart on this motion: move in more directions",
        );
    };
    tell(watch, 0.75, "location")?;
    let told = Told { design: &design, search: &search, baseline: &baseline, last: &last, found: &found };
    let located = locate::locate(
        &design,
        &baseline.columns,
        &baseline.fit.residual,
        &last.fit.residual,
        squared,
        options.seed,
    );
    let left =
        locate::locate(&design, &last.columns, &last.fit.residual, &last.fit.residual, squared, options.seed);
    tell(watch, 0.85, "rivals")?;
    let mut missing = told.missing();
    let to_rms = |sum: f64| (sum / rows.max(1e-300)).sqrt();
    let after = last.fit.heldout_sum();
    let excess = |sum: f64| (sum - squared).max(0.0);
    // a level by direction that is no ellipse leaves most of the error behind the ellipse that is nearest to it
    if left.p <= 0.001 && to_rms(excess(after)) > floor.max(2.0 * systematic) {
        missing.extend(unnamed(&left, to_rms(after)));
    }
    let (blind_to, mut rejected) = told.not_found(&kinds);
    // what is left could be any of them
    if to_rms(after) > SEVERAL * floor {
        rejected.clear();
    }
    let verdict = if missing.is_empty() { Verdict::NoMismatch } else { Verdict::Mismatch };
    let before = baseline.fit.heldout_sum();
    let mut curves = located.curves;
    curves.truncate(8);
    let mismatch = verdict == Verdict::Mismatch;
    let explained =
        if excess(before) > 0.0 { (1.0 - excess(after) / excess(before)).clamp(0.0, 1.0) } else { 0.0 };
    let mut out = Diagnosis {
        schema: SCHEMA,
        verdict,
        summary: String::new(),
        recording_faults: faults(&prepared),
        preparation: prepared.iter().map(|p| p.report.clone()).collect(),
        noise_floor: NoiseFloor {
            rms: floor,
            unit: "N".into(),
            how: if options.declared_noise.is_some() { "declared" } else { "local differences" }.into(),
        },
        baseline: Baseline {
            law: "planar_coulomb".into(),
            parameters: told.parameters(&baseline),
            rms_heldout: to_rms(before),
        },
        location: if mismatch {
            located.regions.into_iter().take(MOST_REGIONS).collect()
        } else {
            Vec::new()
        },
        missing,
        instruments: Vec::new(),
        does_not_carry_over: Vec::new(),
        left_out: None,
        blind_to,
        detectable: rejected.iter().map(|r: &Rejected| r.upper_bound).fold(systematic, f64::max),
        rejected,
        after: After {
            rms_heldout: to_rms(after).min(to_rms(before)),
            free_run_error: None,
            explained_share: if mismatch { explained } else { 0.0 },
            parameters: told.parameters(&last),
        },
        remainder: Remainder {
            rms: to_rms(excess(after)),
            located_at: if left.p <= 0.01 { left.regions.into_iter().take(6).collect() } else { Vec::new() },
        },
        judged_share: judged,
        fitted_share: 1.0,
        cutoff_hz: cutoff,
        nuisances: Vec::new(),
        validation: Vec::new(),
        experiments: Vec::new(),
        next_experiment: None,
        model: None,
        figures: told.figures(curves),
    };
    out.summary = words::summary(&out);
    tell(watch, 1.0, "done")?;
    let held = found.iter().all(|f| f.term.kind == Kind::Anisotropy);
    let model = held.then(|| told.model(cutoff));
    Ok(PlanarDiagnosis { found: out, model })
}

fn searched<'a>(
    design: &'a Design,
    scales: &'a PlanarScales,
    (catalogue, columns): (&'a [term::Term], &'a [Vec<Vec<f64>>]),
    (floor, systematic): (f64, f64),
    options: &Options,
) -> Search<'a> {
    Search {
        design,
        scales,
        catalogue,
        columns,
        floor,
        systematic,
        max_terms: options.max_terms,
        seed: options.seed,
    }
}

/// Error that noise alone leaves in a row, and the one below which nothing is named, N: as on a line, over both axes.
fn floors(design: &Design, cutoff: f64, declared: Option<f64>) -> (f64, f64) {
    let mass = design.blocks.mass;
    let (mut square, mut weight, mut steps) = (0.0, 0.0, 0.0_f64);
    for t in &design.tracks {
        let white = t.filter.white_gain(t.stride);
        for (raw, noise) in t.raw.iter().zip(t.acceleration_noise) {
            let force = declared.unwrap_or_else(|| signals::noise_std(&raw.force)) * white;
            let rows = t.row_count() as f64;
            square += rows * (force * force + (mass * noise).powi(2));
            weight += rows;
            let rounding = |series: &[f64]| quantum(series) / 12f64.sqrt();
            let acceleration =
                (rounding(&raw.position) * signals::differentiated(2, cutoff, raw.dt)).min(noise);
            let force = rounding(&raw.force) * signals::differentiated(0, cutoff, raw.dt);
            steps = steps.max((mass * acceleration).hypot(force));
        }
    }
    let floor = (square / f64::max(weight, 1.0)).sqrt();
    (floor, steps.max(REGULAR * floor))
}

fn faults(prepared: &[PlanarPrepared]) -> Vec<RecordingFault> {
    prepared.iter().flat_map(|p| p.faults.clone()).collect()
}

/// A pattern that no hypothesis takes.
fn unnamed(left: &locate::Located, rms: f64) -> Option<Missing> {
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

/// What a search found, to be told.
struct Told<'a> {
    design: &'a Design,
    search: &'a Search<'a>,
    baseline: &'a Hypothesis,
    last: &'a Hypothesis,
    found: &'a [Found],
}

fn quantity(value: f64, std: f64, unit: impl Into<String>) -> Quantity {
    Quantity { value, std, unit: unit.into() }
}

impl Told<'_> {
    /// Parameters of the baseline; masses by axis where both are known.
    fn parameters(&self, h: &Hypothesis) -> BTreeMap<String, Quantity> {
        let mut out = BTreeMap::new();
        for (column, place) in self.design.present.iter().enumerate() {
            let (name, unit) = BASELINE[*place];
            out.insert(
                name.to_string(),
                quantity(h.fit.coefficients[column], h.fit.std_errors[column], unit),
            );
        }
        if let (Some(mass), Some(difference)) = (out.remove("mass"), out.remove("mass_difference")) {
            let std = mass.std.hypot(difference.std);
            out.insert("mass_x".into(), quantity(mass.value + difference.value, std, "kg"));
            out.insert("mass_y".into(), quantity(mass.value - difference.value, std, "kg"));
        } else {
            out.insert("mass".into(), quantity(h.fit.coefficients[0], h.fit.std_errors[0], "kg"));
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
            let stds = [h.fit.std_errors[from], h.fit.std_errors[from + 1]];
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
                    h.fit.std_errors[from + column],
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

    fn missing(&self) -> Vec<Missing> {
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
    fn not_found(&self, kinds: &[Kind]) -> (Vec<Blind>, Vec<Rejected>) {
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
    fn model(&self, cutoff: f64) -> PlanarModel {
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
    fn figures(&self, curves: Vec<crate::result::Curve>) -> Figures {
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

/// A recording that cannot answer.
fn untestable(prepared: &[PlanarPrepared], cutoff: f64, why: &str) -> PlanarDiagnosis {
    let reports = prepared.iter().map(|p| p.report.clone()).collect();
    let noise = prepared.iter().flat_map(|p| &p.stretches).flatten().map(|c| signals::noise_std(&c.force));
    let mut found = unanswered(faults(prepared), reports, noise.fold(0.0, f64::max), "N".into(), why);
    found.cutoff_hz = cutoff;
    PlanarDiagnosis { found, model: None }
}
