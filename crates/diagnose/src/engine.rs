//! The steps in order.

use crate::acting::{self, Acting};
use crate::ambiguity::{Rival, blind, equivalents, rejected};
use crate::design::{Answers, Designer, Limits};
use crate::drift;
use crate::flips::gain_interval;
use crate::floor::{Floor, floor, systematic};
use crate::free_run::{self, Plant};
use crate::intake::{Intake, take};
use crate::joint::Joint;
use crate::linear::Fit;
use crate::locate::{locate, row_motion, row_times};
use crate::nuisance::{self, Declared, Nuisance, PerRecording};
use crate::options::{Error, Options};
use crate::result::{
    After, Baseline, Diagnosis, Figures, Location, Missing, NoiseFloor, Quantity, Remainder, SCHEMA, Verdict,
};
use crate::search::{Catalogue, Hypothesis, Search};
use crate::sensor::Acts;
use crate::signal::derivative;
use crate::static_branch;
use crate::term::{Scales, Stage, TermKind};
use crate::track::{Channels, Noise, Track, choose_cutoff, dominant_frequency};
use crate::validate::Frozen;
use identify::{FaultKind, Recording, RecordingFault};
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Names of the baseline's columns, and their units for a slide and for an axis.
pub(crate) const BASELINE: [(&str, &str, &str); 5] = [
    ("mass", "kg", "kg·m²"),
    ("coulomb_p", "N", "N·m"),
    ("coulomb_n", "N", "N·m"),
    ("viscous_p", "N·s/m", "N·m·s/rad"),
    ("viscous_n", "N·s/m", "N·m·s/rad"),
];

/// Share of the floor below which a held-out error refutes it.
const UNDERCUT: f64 = 0.7;

/// Most regions of what was fitted that are told.
const MOST_REGIONS: usize = 12;

/// Share of the time that may be set aside around reversals; where it is more, they are kept.
const MOST_REVERSALS: f64 = 0.6;

/// The same where nothing else is left.
const FEW_REVERSALS: f64 = 0.2;

/// Share of the time around reversals, as far as the filter at `cutoff` Hz smears each.
fn reversals(stretches: &[Channels], cutoff: f64) -> f64 {
    let count =
        |c: &Channels| Track::new(c.clone(), cutoff).sign.windows(2).filter(|w| w[0] != w[1]).count() as f64;
    let seconds: f64 = stretches.iter().map(|c| c.position.len() as f64 * c.dt).sum();
    let long = stretches.iter().filter(|c| c.position.len() >= 16);
    long.map(count).sum::<f64>() / (cutoff * seconds.max(1e-300))
}

/// Locates what a simulation leaves out of a recording, names it, and confirms it on data not used.
///
/// `train` are fitted together with shared parameters; `validate` are judged with structure and parameters
/// frozen. `progress` is told a share of the work done and what is being done.
///
/// # Errors
/// No recording, recordings that do not belong together, channels of different length or an option outside its
/// range. A recording that cannot answer is not an error: its verdict is `not_testable`.
pub fn diagnose(
    train: &[Recording],
    validate: &[Recording],
    options: &Options,
    progress: &dyn Fn(f32, &str),
) -> Result<Diagnosis, Error> {
    options.validate()?;
    progress(0.0, "audit");
    let mut intake = take(train)?;
    let judged = if validate.is_empty() { None } else { Some(take(validate)?) };
    let unit = if intake.rotary { "N·m" } else { "N" };
    if intake.stretches.is_empty() {
        return Ok(untestable(
            intake,
            unit,
            "no stretch of the recording is long and clean enough to be fitted",
        ));
    }
    let mut cutoff = options.cutoff_hz.unwrap_or_else(|| choose_cutoff(&intake.stretches));
    progress(0.05, "filter and baseline");
    if let Some(first) = Stage::new(&intake.stretches, cutoff, false) {
        intake.static_branch(static_branch::delta_v(&first.tracks));
        intake.take_out(&drift::find(&first, train.len()));
    }
    // noise about a place reverses, too
    let still = intake.faults.iter().any(|f| f.kind == FaultKind::TooLittleMotion);
    let around = if still { 0.0 } else { reversals(&intake.stretches, cutoff) };
    let short = around > FEW_REVERSALS && Stage::new(&intake.stretches, cutoff, false).is_none();
    if around > MOST_REVERSALS || short {
        intake.keep_reversals();
        // a motion that is quick for its sampling goes up to where the derivative ends
        let slowest = intake.stretches.iter().map(|s| 1.0 / s.dt).fold(f64::INFINITY, f64::min);
        cutoff = options.cutoff_hz.unwrap_or(slowest / 8.0);
    }
    let mut origins = Vec::new();
    if options.per_recording.contains(&Nuisance::Origin)
        && let Some(mut first) = with_delay(&intake.stretches, cutoff)
    {
        first.declare(&options.per_recording);
        origins = nuisance::origins(&first);
        intake.move_origins(&origins);
    }
    let Some(mut stage) = with_delay(&intake.stretches, cutoff) else {
        return Ok(untestable(
            intake,
            unit,
            "too few samples in motion are left after those with an unknown direction are set aside",
        ));
    };
    if stage.baseline.len() < BASELINE.len() {
        return Ok(untestable(
            intake,
            unit,
            "the body moves in one direction only: record a move that reverses",
        ));
    }
    let Some(baseline) = Hypothesis::new(&stage, Vec::new()) else {
        return Ok(untestable(
            intake,
            unit,
            "mass and friction cannot be told apart on this motion: accelerate more",
        ));
    };
    let declared = stage.declare(&options.per_recording);
    let Some(baseline) =
        (if declared.is_empty() { Some(baseline) } else { Hypothesis::new(&stage, Vec::new()) })
    else {
        return Ok(untestable(
            intake,
            unit,
            "what is declared to differ between the recordings explains all there is",
        ));
    };
    let judged = judged.map(|mut j| {
        if let Some(first) = Stage::new(&j.stretches, cutoff, false) {
            j.take_out(&drift::find(&first, validate.len()));
        }
        j.static_branch(intake.delta_v);
        let quick = intake.stretches.iter().any(|s| s.quick);
        j.stretches.iter_mut().for_each(|s| s.quick = quick);
        j
    });
    let run = Run { intake, stage, baseline, cutoff, options, unit, declared, origins, settled: None };
    Ok(run.diagnose(judged, progress))
}

/// A delay of up to one sample between force and position is how the recording was made, not physics: it is fitted
/// jointly with everything. A longer one is an effect to be named (`time_skew`).
fn with_delay(stretches: &[Channels], cutoff: f64) -> Option<Stage> {
    let stage = Stage::new(stretches, cutoff, true)?;
    let dt = stretches.iter().map(|s| s.dt).fold(0.0, f64::max);
    let Some(first) = Hypothesis::new(&stage, Vec::new()) else {
        return Stage::new(stretches, cutoff, false);
    };
    let at = |values: &[f64]| values.get(BASELINE.len()).copied();
    match at(&first.fit.coefficients).zip(at(&first.fit.deviations)) {
        Some((delay, std)) if delay.abs() - 3.0 * std <= dt => Some(stage),
        _ => Stage::new(stretches, cutoff, false),
    }
}

/// A mass below zero is no mass: what was recorded as the force is not what accelerates this body.
fn implausible_mass(fit: &Fit, rotary: bool) -> Option<RecordingFault> {
    let (mass, std) = (*fit.coefficients.first()?, *fit.deviations.first()?);
    if mass >= 0.0 {
        return None;
    }
    let (what, unit) = if rotary { ("inertia", "kg·m²") } else { ("mass", "kg") };
    let because = if mass + 3.0 * std < 0.0 {
        "the force has the wrong sign, or is mostly something else than what accelerates this body (a pressure, a \
         preload, a spring)"
    } else {
        "the motion is too slow, or the channels too noisy, for inertia to show"
    };
    Some(RecordingFault {
        kind: FaultKind::Implausible,
        at_s: None,
        why: format!("the {what} that fits best is {mass:.4} ± {std:.4} {unit}: {because}"),
    })
}

struct Run<'a> {
    intake: Intake,
    stage: Stage,
    baseline: Hypothesis,
    cutoff: f64,
    options: &'a Options,
    unit: &'static str,
    declared: Vec<Declared>,
    origins: Vec<(usize, Option<(f64, f64)>)>,
    /// Where the force that acts had to be known better than the baseline alone knows it.
    settled: Option<Settled>,
}

/// The force that acts once it is known, with what was evaluated on it.
struct Settled {
    acting: Acting,
    noisy: Stage,
    catalogue: Catalogue,
}

impl Run<'_> {
    fn diagnose(mut self, judged: Option<Intake>, progress: &dyn Fn(f32, &str)) -> Diagnosis {
        let settled = self.settled.take();
        let first = settled.is_none();
        let Self { ref stage, ref baseline, cutoff, options, unit, .. } = self;
        let rotary = self.intake.rotary;
        let rows: f64 = stage.block_weight().iter().sum();
        let to_rms = |sum: f64| (sum / rows.max(1e-300)).sqrt();

        let mut floor = self.floor();
        progress(0.1, "catalogue");
        let scales = Scales::of(&stage.tracks, cutoff);
        let unavailable = self.unavailable();
        let mut exclude: Vec<&str> = options.exclude.iter().map(String::as_str).collect();
        exclude.extend(unavailable.iter().map(|(e, _)| *e));
        if stage.delay {
            exclude.push("time_skew");
        }
        // comparing the channels says more about it than any force
        exclude.push("velocity_lag");
        if self.intake.hears_the_encoder(cutoff) {
            exclude.push("encoder_eccentricity");
        }
        let Settled { acting, noisy, catalogue } = settled.unwrap_or_else(|| {
            let acting = Acting::baseline(&baseline.fit.coefficients);
            let noisy = stage.perturbed(cutoff, &acting, options.seed ^ 0x51f1);
            let lines = crate::lines::fine(stage, &baseline.fit.residual, &scales, options.seed);
            let catalogue = Catalogue::new(stage, &noisy, &scales, &lines, &exclude);
            Settled { acting, noisy, catalogue }
        });
        let above = |floor: f64| Search {
            stage,
            noisy: &noisy,
            catalogue: &catalogue,
            scales: &scales,
            floor: floor * floor * rows,
            systematic: systematic(stage, baseline.fit.coefficients[0], cutoff, floor).powi(2) * rows,
            max_terms: options.max_terms,
            width: options.beam_width,
            seed: options.seed,
        };
        let mut search = above(floor.rms);
        progress(0.3, "naming");
        let (mut found, mut p) = search.run(progress).unwrap_or_else(|| (baseline.clone(), Vec::new()));

        // A floor that a model undercuts on what it has not seen was none: a broad signal was taken for noise.
        let reached = to_rms(found.fit.heldout_sum());
        if reached < UNDERCUT * floor.rms && floor.how == "local differences" && reached > 0.0 {
            floor.rms = reached;
            search = above(floor.rms);
            (found, p) = search.run(progress).unwrap_or_else(|| (baseline.clone(), Vec::new()));
        }
        if let Some((stage, baseline, declared)) = self.without_delay(&found) {
            drop((catalogue, noisy));
            return Run { stage, baseline, declared, ..self }.diagnose(judged, progress);
        }
        let another = if first { acting::settle(&search, &found) } else { None };
        if let Some((stage, acting)) = another {
            let (mut noisy, mut catalogue) = (noisy, catalogue);
            noisy.model_force(&acting);
            catalogue.renew(&stage, &noisy);
            let settled = Some(Settled { acting, noisy, catalogue });
            return Run { stage, settled, ..self }.diagnose(judged, progress);
        }
        let joint = Joint::of(&search, &found);
        found.fit.deviations = (0..found.fit.coefficients.len()).map(|i| joint.gain(i)).collect();

        progress(0.85, "location");
        let columns = Hypothesis::columns(stage, &[]);
        let squared_floor = search.floor;
        let located = locate(
            stage,
            &columns,
            &baseline.fit.residual,
            &found.fit.residual,
            &found.fit.residual,
            squared_floor,
            rotary,
            options.seed,
        );
        let columns = Hypothesis::columns(stage, &found.atoms);
        let left = locate(
            stage,
            &columns,
            &found.fit.residual,
            &found.fit.residual,
            &found.fit.residual,
            squared_floor,
            rotary,
            options.seed,
        );

        let before = baseline.fit.heldout_sum();
        let after = found.fit.heldout_sum();
        let unnamed = crate::unnamed::find(&search, &found, &left, before);
        progress(0.9, "rivals");
        let plant = self.plant(&found);
        let frequency = self.intake.stretches.iter().map(dominant_frequency).fold(0.0, f64::max);
        let rivals: Vec<Vec<Rival>> =
            (0..found.atoms.len()).into_par_iter().map(|i| equivalents(&search, &found, i)).collect();
        let whole = stage.unmasked();
        let blind = blind(&search, &found, &whole, &unavailable);
        let rival = rivals.iter().flatten().map(|r| r.id.to_string());
        let not_ruled_out: Vec<String> = rival.chain(blind.iter().map(|(b, _)| b.effect.clone())).collect();
        let mut missing: Vec<Missing> = p
            .iter()
            .zip(&rivals)
            .enumerate()
            .map(|(i, (p, r))| self.missing(&found, &joint, i, *p, r))
            .collect();
        progress(0.93, "the next experiment");
        let designer = Designer {
            search: &search,
            found: &found,
            limits: options.limits.unwrap_or_else(|| self.limits(plant.mass)),
            plant: plant.clone(),
            floor: floor.rms,
            cutoff,
            frequency,
            velocity: self.intake.stretches.iter().any(|s| s.velocity.is_some()),
            given_up: &options.given_up,
        };
        let Answers { blind, experiments, next_experiment } = designer.answer(&rivals, blind, &mut missing);
        let of_channels = crate::channel::missing(
            &self.intake.channel,
            stage,
            &found.fit.coefficients,
            rotary,
            options.seed,
        );
        let said: Vec<String> = missing.iter().map(|m| &m.effect).chain(&options.exclude).cloned().collect();
        let mut of_channels: Vec<_> =
            of_channels.into_iter().filter(|(m, _)| !said.contains(&m.effect)).collect();
        of_channels.sort_by(|a, b| gain(&b.0).total_cmp(&gain(&a.0)));
        // where the strongest effect shows stands first
        let strongest = missing.iter().map(gain).fold(0.0, f64::max);
        let (ahead, behind): (Vec<_>, Vec<_>) =
            of_channels.into_iter().partition(|(m, _)| gain(m) > strongest);
        let shown = |effects: &[(Missing, Vec<Location>)]| -> Vec<Location> {
            effects.iter().flat_map(|(_, regions)| regions.clone()).collect()
        };
        let of_fit: Vec<Location> = located.regions.into_iter().take(MOST_REGIONS).collect();
        let mut location = [shown(&ahead), of_fit, shown(&behind)].concat();
        missing.extend(ahead.into_iter().chain(behind).map(|(m, _)| m));
        missing.sort_by(|a, b| gain(b).total_cmp(&gain(a)));
        let explained_by_unnamed = unnamed.as_ref().map(|u| u.rms_heldout_after);
        missing.extend(unnamed);
        let verdict = if missing.is_empty() { Verdict::NoMismatch } else { Verdict::Mismatch };

        progress(0.95, "free run and validation");
        let excess = |sum: f64| (sum - squared_floor).max(0.0);
        let explained_share =
            if excess(before) > 0.0 { (1.0 - excess(after) / excess(before)).clamp(0.0, 1.0) } else { 0.0 };
        let run = free_run::run(stage, &plant, frequency);
        let rejected = rejected(&search, &found, &whole, &not_ruled_out, unit);
        // what is smaller is not named even where it is seen
        let bound = detectable(&rejected).max(to_rms(search.systematic));
        let (time, (position, velocity)) = (row_times(stage), row_motion(stage));
        let mut curves = located.curves;
        curves.truncate(8);
        let figures = Figures {
            free_run_position: run.as_ref().map_or_else(Vec::new, |(_, x)| self.at_rows(x)),
            time,
            position,
            velocity,
            force: stage.y.clone(),
            before: baseline.fit.heldout_prediction.clone(),
            after: found.fit.heldout_prediction.clone(),
            curves,
        };
        let frozen = Frozen {
            stage,
            cutoff,
            acting: &acting,
            baseline,
            found: &found,
            declared: &options.per_recording,
        };
        let validation = judged.map_or_else(Vec::new, |j| frozen.judge(&j));
        if verdict != Verdict::Mismatch {
            location.clear();
        }
        let mut diagnosis = Diagnosis {
            schema: SCHEMA,
            verdict,
            summary: String::new(),
            recording_faults: self.faults(&found),
            noise_floor: NoiseFloor { rms: floor.rms, unit: unit.into(), how: floor.how.into() },
            baseline: Baseline {
                law: "karnopp".into(),
                parameters: self.parameters(&baseline.fit),
                rms_heldout: to_rms(before),
            },
            location,
            blind_to: blind,
            rejected,
            after: After {
                rms_heldout: explained_by_unnamed.unwrap_or(to_rms(after)).min(to_rms(before)),
                free_run_error: run.map(|r| r.0),
                explained_share: if verdict == Verdict::Mismatch { explained_share } else { 0.0 },
                parameters: self.parameters(&found.fit),
            },
            remainder: Remainder {
                rms: to_rms(excess(after)),
                located_at: if left.p <= 0.01 {
                    left.regions.into_iter().take(6).collect()
                } else {
                    Vec::new()
                },
            },
            detectable: bound,
            cutoff_hz: cutoff,
            nuisances: self.nuisances(&found),
            validation,
            experiments,
            next_experiment,
            model: Some(self.model(&found)),
            missing,
            figures,
        };
        diagnosis.summary = crate::words::summary(&diagnosis);
        progress(1.0, "done");
        diagnosis
    }

    /// The stage with the delay among the effects, where what was found says that the nuisance of up to a sample was more:
    /// beside it there is a lag of the force, or it is longer once the rest of the physics is there.
    fn without_delay(&self, found: &Hypothesis) -> Option<(Stage, Hypothesis, Vec<Declared>)> {
        if !self.stage.delay {
            return None;
        }
        let dt = self.intake.stretches.iter().map(|s| s.dt).fold(0.0, f64::max);
        let delay = found.fit.coefficients.get(BASELINE.len()).copied().unwrap_or(0.0);
        let lags = found.atoms.iter().any(|a| a.term.kind.acts(Acts::InTime));
        if delay.abs() <= dt && !lags {
            return None;
        }
        let mut stage = Stage::new(&self.intake.stretches, self.cutoff, false)?;
        let declared = stage.declare(&self.options.per_recording);
        let baseline = Hypothesis::new(&stage, Vec::new())?;
        Some((stage, baseline, declared))
    }

    /// What the audit said, and what only the fit could see.
    fn faults(&self, found: &Hypothesis) -> Vec<RecordingFault> {
        let mut faults = self.intake.faults.clone();
        faults.extend(implausible_mass(&found.fit, self.intake.rotary));
        for (i, atom) in found.atoms.iter().enumerate() {
            let channel = atom.gains(found.coefficients(&self.stage, i))[1];
            if atom.term.kind.id() == "actuator_lag" && channel > 0.0 {
                let lag = atom.term.shape[0];
                let why = format!(
                    "the force channel lags by a first order of {:.2} ms: a low-pass at {:.1} Hz that the motion does \
                     not have",
                    1e3 * lag,
                    (std::f64::consts::TAU * lag).recip()
                );
                faults.push(RecordingFault::new(FaultKind::HiddenFilter, None, why));
            }
        }
        faults
    }

    fn floor(&self) -> Floor {
        let residual = self.stage.sample_residual(&self.baseline.fit.coefficients);
        floor(&self.stage, &residual, self.baseline.fit.coefficients[0], self.options.declared_noise)
    }

    /// What the recordings show the device to be able to.
    fn limits(&self, mass: f64) -> Limits {
        let stroke = self.stage.tracks.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), t| {
            t.x.iter().fold((l, h), |(l, h), x| (l.min(*x), h.max(*x)))
        });
        let largest = |of: &dyn Fn(&Track) -> &Vec<f64>| {
            self.stage.tracks.iter().flat_map(of).fold(0.0_f64, |m, x| m.max(x.abs()))
        };
        Limits::shown(stroke.1 - stroke.0, largest(&|t| &t.v), largest(&|t| &t.f), mass)
    }

    /// Effects that need a channel the recordings do not have.
    fn unavailable(&self) -> Vec<(&'static str, String)> {
        let mut out = Vec::new();
        if !self.intake.rotary {
            out.push(("gravity", "weight is a constant along a slide: it is the offset".to_string()));
        }
        if self.intake.stretches.iter().all(|s| s.velocity.is_none()) {
            let because = "there is no velocity channel: velocity is derived from position without lag";
            out.push(("velocity_lag", because.to_string()));
        }
        out
    }

    fn parameters(&self, fit: &Fit) -> BTreeMap<String, Quantity> {
        let delay = ("delay", "s", "s");
        BASELINE
            .iter()
            .chain(self.stage.delay.then_some(&delay))
            .zip(fit.coefficients.iter().zip(&fit.deviations))
            .map(|((name, linear, rotary), (value, std))| {
                let unit = if self.intake.rotary { rotary } else { linear };
                (name.to_string(), Quantity { value: *value, std: *std, unit: unit.to_string() })
            })
            .chain(self.intake.delta_v.map(|(value, std)| {
                let unit = if self.intake.rotary { "rad/s" } else { "m/s" };
                ("delta_v".to_string(), Quantity { value, std, unit: unit.into() })
            }))
            .collect()
    }

    fn missing(&self, found: &Hypothesis, joint: &Joint, i: usize, p: f64, rivals: &[Rival]) -> Missing {
        let stage = &self.stage;
        let atom = &found.atoms[i];
        let mut others = found.atoms.clone();
        others.remove(i);
        let without = Hypothesis::new(stage, others);
        let rows: f64 = stage.block_weight().iter().sum();
        let before = without.as_ref().map_or(f64::NAN, |w| (w.fit.heldout_sum() / rows).sqrt());
        let interval = without.as_ref().map_or([0.0, 0.0], |w| {
            gain_interval(
                &w.fit.heldout,
                &found.fit.heldout,
                &stage.block_weight(),
                &stage.blocks.recordings,
                2000,
                self.options.seed,
            )
        });
        Missing {
            effect: atom.term.kind.id().into(),
            says: atom.term.kind.says().into(),
            equation: atom.term.kind.equation().into(),
            parameters: self.effect_parameters(joint, found, i),
            rms_heldout_before: before,
            rms_heldout_after: (found.fit.heldout_sum() / rows).sqrt(),
            gain_ci95: interval,
            p,
            indistinguishable_from: rivals.iter().map(|r| r.id.to_string()).collect(),
            experiment: String::new(),
        }
    }

    /// Gains and shape of term `i`.
    fn effect_parameters(&self, joint: &Joint, found: &Hypothesis, i: usize) -> BTreeMap<String, Quantity> {
        let atom = &found.atoms[i];
        let kind = atom.term.kind;
        let own = found.offset(&self.stage, i);
        let mut out = BTreeMap::new();
        let gains = atom.gains(found.coefficients(&self.stage, i));
        let groups = atom.term.free_gains();
        for (g, parameter) in kind.gains().iter().enumerate() {
            let column = groups
                .iter()
                .position(|members| members.contains(&g))
                .and_then(|free| atom.active.iter().position(|a| *a == free));
            let Some(column) = column else { continue };
            let unit = self.unit_of(parameter.unit);
            let std = joint.gain(own + column);
            out.insert(parameter.name.to_string(), Quantity { value: gains[g], std, unit });
        }
        for (axis, parameter) in kind.shape().iter().enumerate() {
            let Some(std) = joint.shape(i, axis) else { continue };
            let unit = self.unit_of(parameter.unit);
            out.insert(parameter.name.to_string(), Quantity { value: atom.term.shape[axis], std, unit });
        }
        out
    }

    /// A unit of a slide as that of an axis, where the recording is one.
    fn unit_of(&self, unit: &str) -> String {
        if self.intake.rotary {
            unit.split('/')
                .map(|part| part.replace("kg", "kg·m²").replace('N', "N·m").replace("m²", "rad²"))
                .enumerate()
                .map(|(i, part)| if i > 0 && part == "m" { "rad".into() } else { part })
                .collect::<Vec<_>>()
                .join("/")
        } else {
            unit.to_string()
        }
    }

    fn plant(&self, found: &Hypothesis) -> Plant {
        let c = &found.fit.coefficients;
        let mut plant =
            Plant { mass: c[0], coulomb: [c[1], c[2]], viscous: [c[3], c[4]], ..Plant::default() };
        let delay = if self.stage.delay { c.get(BASELINE.len()).copied().unwrap_or(0.0) } else { 0.0 };
        let late = |t: &Track| derivative(&t.f, t.raw.dt).iter().map(|rate| -delay * rate).collect();
        plant.sensors = self.stage.tracks.iter().map(late).collect();
        for (i, atom) in found.atoms.iter().enumerate() {
            let gains = atom.gains(found.coefficients(&self.stage, i));
            match atom.term.kind {
                TermKind::Force(kind) => plant.effects.push((kind, gains, atom.term.shape)),
                TermKind::Sensor(sensor) => {
                    for (track, sum) in self.stage.tracks.iter().zip(&mut plant.sensors) {
                        for (column, gain) in (sensor.columns)(track, &atom.term.shape).iter().zip(gains) {
                            for (s, x) in sum.iter_mut().zip(column) {
                                *s += gain * x;
                            }
                        }
                    }
                }
            }
        }
        plant
    }

    /// A series of the first track at the times of the rows; NaN for later tracks.
    fn at_rows(&self, series: &[f64]) -> Vec<f64> {
        let Some(first) = self.stage.tracks.first() else { return Vec::new() };
        let mut out: Vec<f64> = (0..first.row_count())
            .map(|r| {
                let rows = r * first.stride..(r + 1) * first.stride;
                series[rows.clone()].iter().sum::<f64>() / rows.len() as f64
            })
            .collect();
        out.resize(self.stage.share.len(), f64::NAN);
        out
    }

    /// What differs between the recordings, as far as it was declared.
    fn nuisances(&self, found: &Hypothesis) -> Vec<PerRecording> {
        let rotary = self.intake.rotary;
        let of = |recording: usize, nuisance: Nuisance, value: f64, std: f64| PerRecording {
            recording: self.intake.names.get(recording).cloned().unwrap_or_default(),
            nuisance: nuisance.id().into(),
            value,
            std,
            unit: nuisance.unit(rotary).into(),
        };
        let from = self.stage.baseline.len() - self.declared.len();
        let columns = self.declared.iter().enumerate().map(|(i, d)| {
            of(d.recording, d.nuisance, found.fit.coefficients[from + i], found.fit.deviations[from + i])
        });
        let origins = self.origins.iter().map(|(recording, found)| {
            let (value, std) = found.unwrap_or((0.0, f64::NAN));
            of(*recording, Nuisance::Origin, value, std)
        });
        columns.chain(origins).collect()
    }

    fn model(&self, found: &Hypothesis) -> identify::Model {
        crate::export::model(&self.intake, &self.stage, found, self.cutoff)
    }
}

fn gain(m: &Missing) -> f64 {
    m.rms_heldout_before - m.rms_heldout_after
}

/// Root-mean-square force above which most effects would have been seen: the median of the bounds.
fn detectable(rejected: &[crate::result::Rejected]) -> f64 {
    let mut bounds: Vec<f64> = rejected.iter().map(|r| r.upper_bound).filter(|b| b.is_finite()).collect();
    bounds.sort_by(f64::total_cmp);
    bounds.get(bounds.len() / 2).copied().unwrap_or(f64::NAN)
}

fn untestable(intake: Intake, unit: &str, because: &str) -> Diagnosis {
    let noise = intake.stretches.first().map_or(Noise::default(), |s| crate::track::derived_noise(s, 1.0));
    let mut diagnosis = Diagnosis {
        schema: SCHEMA,
        verdict: Verdict::NotTestable,
        summary: format!("This recording cannot answer: {because}."),
        recording_faults: intake.faults,
        noise_floor: NoiseFloor { rms: noise.force, unit: unit.into(), how: "local differences".into() },
        baseline: Baseline { law: "karnopp".into(), parameters: BTreeMap::new(), rms_heldout: f64::NAN },
        location: Vec::new(),
        missing: Vec::new(),
        blind_to: Vec::new(),
        rejected: Vec::new(),
        after: After {
            rms_heldout: f64::NAN,
            free_run_error: None,
            explained_share: 0.0,
            parameters: BTreeMap::new(),
        },
        remainder: Remainder { rms: f64::NAN, located_at: Vec::new() },
        detectable: f64::NAN,
        cutoff_hz: f64::NAN,
        nuisances: Vec::new(),
        validation: Vec::new(),
        experiments: Vec::new(),
        next_experiment: None,
        model: None,
        figures: Figures::default(),
    };
    if let Some(fault) = diagnosis.recording_faults.first() {
        diagnosis.summary.push_str(&format!(" The audit says: {}", fault.why));
    }
    diagnosis
}
