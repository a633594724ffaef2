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
mod told;
mod validate;

use crate::findings::floor::REGULAR;
use crate::findings::unnamed::SEVERAL;
use crate::findings::words;
use crate::options::{Error, Options, tell};
use crate::pipeline::unanswered;
use crate::result::{After, Baseline, Diagnosis, NoiseFloor, Rejected, Remainder, SCHEMA, Verdict};
use design::{Design, tracks};
use identify::planar::{Ellipse, PlanarModel, Track};
use rayon::prelude::*;
use search::Search;
use signals::{Cutoff, PlanarPrepared, PlanarRecording, RecordingFault, Settings, prepare_planar, quantum};
use std::ops::ControlFlow;
use term::{Kind, PlanarScales};
use told::{Told, unnamed};

/// Largest number of regions in the answer.
const MOST_REGIONS: usize = 12;
/// A motion on which the baseline is not determined.
const COLLINEAR: &str =
    "on this motion the forces of mass, friction and offset are alike: move in more directions";

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
/// `train` are fitted together; each of `validate` is predicted with structure and parameters frozen.
///
/// # Errors
/// No recording, recordings that cannot be prepared, an option outside its range or one that is for recordings on a line, and
/// a recording of `validate` that cannot judge.
pub fn diagnose_planar(
    train: &[PlanarRecording],
    validate: &[PlanarRecording],
    options: &Options,
    progress: &dyn Fn(f32, &str),
) -> Result<PlanarDiagnosis, Error> {
    diagnose_planar_watched(train, validate, options, &|share, what| {
        progress(share, what);
        ControlFlow::Continue(())
    })
}

/// As [`diagnose_planar`]; `watch` ends it early with `Break`, which it may wait for up to a step of the search.
///
/// # Errors
/// Those of [`diagnose_planar`], and [`Error::Interrupted`].
pub fn diagnose_planar_watched(
    train: &[PlanarRecording],
    validate: &[PlanarRecording],
    options: &Options,
    watch: &dyn Fn(f32, &str) -> ControlFlow<()>,
) -> Result<PlanarDiagnosis, Error> {
    options.validate()?;
    if train.is_empty() {
        return Err(Error::NoRecording);
    }
    for (name, asked) in
        [("per_recording", !options.per_recording.is_empty()), ("absolute", options.absolute)]
    {
        if asked {
            return Err(Error::Option { name, value: 1.0, accepted: "with recordings on a line only" });
        }
    }
    tell(watch, 0.0, "audit")?;
    let settings =
        Settings { cutoff: options.cutoff_hz.map_or(Cutoff::OfSearch, Cutoff::Given), ..Settings::default() };
    let mut prepared: Vec<PlanarPrepared> =
        train.iter().map(|r| prepare_planar(r, &settings)).collect::<Result<_, _>>()?;
    let cutoff = prepared.iter().filter_map(|p| p.report.cutoff_hz).fold(f64::INFINITY, f64::min);
    prepared.iter_mut().for_each(|p| p.report.cutoff_hz = p.report.cutoff_hz.map(|_| cutoff));
    tell(watch, 0.05, "filter and baseline")?;
    let (tracks, of) = tracks(&prepared, cutoff);
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
    let Some(first) = first else { return untestable(COLLINEAR) };
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
    let searched = search.run(&|share| tell(watch, 0.1 + 0.6 * share, "search"))?;
    let Some((baseline, last, found)) = searched else { return untestable(COLLINEAR) };
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
    tell(watch, 0.8, "what was not fitted")?;
    let (validation, cannot_judge) = validate::judged(validate, &design, [&baseline, &last], cutoff)?;
    tell(watch, 0.85, "rivals")?;
    let mut missing = told.missing();
    let to_rms = |sum: f64| (sum / rows.max(1e-300)).sqrt();
    let after = last.fit.heldout_sum();
    let excess = |sum: f64| (sum - squared).max(0.0);
    // the nearest ellipse leaves most of the error of a level that follows the direction in another way
    if left.p <= 0.001 && to_rms(excess(after)) > floor.max(2.0 * systematic) {
        missing.extend(unnamed(&left, to_rms(after)));
    }
    let (blind_to, mut rejected) = told.not_found(&kinds);
    // an error this large may hide any effect: none is ruled out
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
        recording_faults: faults(&prepared).into_iter().chain(cannot_judge).collect(),
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
        validation,
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

/// A recording that cannot answer.
fn untestable(prepared: &[PlanarPrepared], cutoff: f64, why: &str) -> PlanarDiagnosis {
    let reports = prepared.iter().map(|p| p.report.clone()).collect();
    let noise = prepared.iter().flat_map(|p| &p.stretches).flatten().map(|c| signals::noise_std(&c.force));
    let mut found = unanswered(faults(prepared), reports, noise.fold(0.0, f64::max), "N".into(), why);
    found.cutoff_hz = cutoff;
    PlanarDiagnosis { found, model: None }
}
