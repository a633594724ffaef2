//! The steps in order.

use crate::experiment::answers::Answers;
use crate::experiment::design::Designer;
use crate::experiment::moves::Limits;
use crate::findings;
use crate::findings::ambiguity::{Rival, blind, rejected, rivals};
use crate::findings::free_run::{self, Plant};
use crate::findings::locate::{locate, row_motion, row_times};
use crate::findings::nuisance;
use crate::findings::unnamed::SEVERAL;
use crate::findings::validate::{Judge, judges};
use crate::free_form;
use crate::free_form::contradiction::DESCRIBED;
use crate::free_form::hum::{self, Hum};
use crate::free_form::term::FreeTerm;
use crate::library::baseline::BASELINE;
use crate::library::design_matrix::{DesignMatrix, FEWEST_ROWS};
use crate::library::series;
use crate::library::term::TermKind;
use crate::naming::{self, Named};
use crate::options::{Error, Interrupted, Options, Watch, tell};
use crate::per_recording::{Nuisance, PerRecording};
use crate::preparation::blows;
use crate::preparation::drift;
use crate::preparation::intake::{Intake, take};
use crate::preparation::static_branch;
use crate::preparation::track::{Reversals, Track};
use crate::regression::linear::Fit;
use crate::regression::sign_flips::gain_interval;
use crate::result::{
    After, Baseline, CarriesNot, Diagnosis, Figures, LeftOut, Location, Missing, NoiseFloor, Quantity,
    Remainder, SCHEMA, Verdict,
};
use crate::search::hypothesis::Hypothesis;
use crate::search::joint::Joint;
use crate::search::judgement::{LEVEL, Search};
use crate::search::lasting::{self, Withdrawn};
use crate::search::regression::Regression;
use friction::Dimension;
use friction::effects::{Describe, Parameter, Unnamed};
use friction::parameters::{DELAY, DELTA_V};
use signals::{
    Basis, Channels, FaultKind, Noise, Preparation, Recording, RecordingFault, derived_noise,
    implausible_mass,
};
use std::collections::BTreeMap;
use std::ops::ControlFlow;

/// Most regions of the motion that are reported.
const MOST_REGIONS: usize = 12;

/// Share of the time that may be set aside around reversals; where it is more, they are kept.
const MOST_REVERSALS: f64 = 0.6;

/// The same where nothing else is left.
const FEW_REVERSALS: f64 = 0.2;

/// Cycles of the cut-off in a recording that leave enough rows to be fitted and held out.
const FEWEST_CYCLES: f64 = 50.0;

/// Share of the time around reversals, as far as the filter at `cutoff` Hz smears each.
fn reversals(stretches: &[Channels], cutoff: f64) -> f64 {
    let count = |c: &Channels| {
        Track::new(c.clone(), cutoff, Reversals::default()).sign.windows(2).filter(|w| w[0] != w[1]).count()
            as f64
    };
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
    diagnose_watched(train, validate, options, &|share, what| {
        progress(share, what);
        ControlFlow::Continue(())
    })
}

/// As [`diagnose`]; `watch` ends it early with `Break`, which it may wait for up to a step of the search.
///
/// # Errors
/// Those of [`diagnose`], and [`Error::Interrupted`].
pub fn diagnose_watched(
    train: &[Recording],
    validate: &[Recording],
    options: &Options,
    watch: &dyn Fn(f32, &str) -> ControlFlow<()>,
) -> Result<Diagnosis, Error> {
    options.validate()?;
    tell(watch, 0.0, "audit")?;
    let mut intake = take(train)?;
    let judged = if validate.is_empty() { None } else { Some(take(validate)?) };
    if intake.stretches.is_empty() {
        return Ok(untestable(intake, "no stretch of the recording is long and clean enough to be fitted"));
    }
    let mut cutoff = intake.cutoff(options.cutoff_hz);
    tell(watch, 0.05, "filter and baseline")?;
    let seconds: f64 = intake.stretches.iter().map(|s| s.position.len() as f64 * s.dt).sum();
    // a motion that is quick for its sampling goes up to where the derivative ends
    let rate = intake.stretches.iter().map(|s| 1.0 / s.dt).fold(f64::INFINITY, f64::min);
    let least = (FEWEST_CYCLES / seconds.max(1e-300)).min(rate / 8.0);
    if options.cutoff_hz.is_none()
        && cutoff < least
        && DesignMatrix::new(&intake.stretches, cutoff, intake.reversals, false).is_none()
    {
        // so slow that the noise of its acceleration asks for a filter that leaves nothing
        cutoff = intake.cutoff(Some(least));
    }
    intake.thin(cutoff);
    if let Some(first) = DesignMatrix::new(&intake.stretches, cutoff, intake.reversals, false) {
        intake.static_branch(static_branch::delta_v(&first.tracks));
        intake.take_out(&drift::find(&first, train.len()));
    }
    // noise about a place reverses, too
    let still = intake.faults.iter().any(|f| f.kind == FaultKind::TooLittleMotion);
    let around = if still { 0.0 } else { reversals(&intake.stretches, cutoff) };
    // whatever the margin beside reversals: with a narrow one enough rows may be left to be fitted, but not to be searched
    let short = around > FEW_REVERSALS
        && DesignMatrix::new(&intake.stretches, cutoff, Reversals { wide: true, ..intake.reversals }, false)
            .is_none();
    if around > MOST_REVERSALS || short {
        intake.keep_reversals();
        cutoff = options.cutoff_hz.unwrap_or(rate / 8.0);
    }
    let mut origins = Vec::new();
    if options.per_recording.contains(&Nuisance::Origin)
        && let Some(mut first) = with_delay(&intake.stretches, cutoff, intake.reversals)
    {
        first.declare(&options.per_recording);
        origins = nuisance::origins(&first);
        intake.move_origins(&origins);
    }
    let mut hums = hum::find(|found| quiet(&intake, found, cutoff), &intake.extra, cutoff, options.seed);
    intake = intake.without_hums(&hums);
    let Some(design) = with_delay(&intake.stretches, cutoff, intake.reversals) else {
        return Ok(untestable(
            intake,
            "too few samples in motion are left after those with an unknown direction are set aside",
        ));
    };
    let Some(mut regression) = Regression::new(design, options) else {
        return Ok(untestable(
            intake,
            "mass, friction and what is declared to differ between the recordings cannot be told apart on this motion: \
             accelerate more",
        ));
    };
    let judged = judged.map(|mut j| {
        if let Some(first) = DesignMatrix::new(&j.stretches, cutoff, j.reversals, false) {
            j.take_out(&drift::find(&first, validate.len()));
        }
        j.static_branch(intake.delta_v);
        j.reversals.kept = intake.reversals.kept;
        j
    });
    let names: Vec<&str> = validate.iter().map(|r| r.name.as_str()).collect();
    let mut astray = None;
    let (named, judges) = loop {
        let mut named = naming::name_beside_columns(&intake, regression.clone(), cutoff, options, watch)?;
        // what was left out may have covered a hum
        if hums.is_empty() {
            let fresh = |found: &[Hum]| quiet_beside(&named, &intake, found, cutoff);
            let covered = hum::find(fresh, &intake.extra, cutoff, options.seed);
            let without = intake.without_hums(&covered);
            let again =
                || Regression::new(with_delay(&without.stretches, cutoff, without.reversals)?, options);
            if !covered.is_empty()
                && let Some(again) = again()
            {
                (intake, regression, hums) = (without, again, covered);
                continue;
            }
        }
        let of = |judged| judges(judged, cutoff, &named.regression, &named.acting);
        let judges = judged.as_ref().map_or_else(Vec::new, of);
        named.confirm(&judges, options, cutoff, &names.join(", "));
        tell(watch, DESCRIBED, "what has no name")?;
        named.describe(&judges, options, cutoff, watch)?;
        let frozen = named.frozen(&named.last, options);
        let before = frozen.rms(&judges, &named.regression.plain);
        let after = frozen.rms(&judges, &named.last);
        if named.regression.followed.is_empty() || judges.is_empty() || after <= before {
            break (named, judges);
        }
        // what the error followed here it does not follow there
        astray = Some(CarriesNot {
            effect: Unnamed::ABOUT.id.into(),
            regime: names.join(", "),
            rms_before: before,
            rms_after: after,
        });
        intake.extra.clear();
    };
    let judging = |name: &&str| judges.iter().any(|j| j.name() == *name);
    for name in names.iter().filter(|name| !judging(name)) {
        let why = format!(
            "{name} cannot judge: behind a filter at {cutoff:.3} Hz fewer than {FEWEST_ROWS} samples are left in which the \
             body surely slides"
        );
        intake.faults.push(RecordingFault::new(FaultKind::TooShort, None, why));
    }
    Ok(Run { intake, cutoff, options, origins, hums, named, astray }.diagnose(&judges, watch)?)
}

/// The design matrix without hums.
fn quiet(intake: &Intake, hums: &[Hum], cutoff: f64) -> Option<DesignMatrix> {
    DesignMatrix::new(&intake.without_hums(hums).stretches, cutoff, intake.reversals, false)
}

/// The same with what was found in its baseline, but for what follows the whole force: that holds a part of a hum itself.
fn quiet_beside(named: &Named, intake: &Intake, hums: &[Hum], cutoff: f64) -> Option<DesignMatrix> {
    let terms: Vec<_> =
        named.found.atoms.iter().map(|a| a.term).filter(|term| !term.kind.needs_force()).collect();
    if terms.is_empty() {
        return None;
    }
    let mut design = quiet(intake, hums, cutoff)?;
    let columns: Vec<_> = terms.iter().flat_map(|term| design.columns(term)).collect();
    let mut basis = Basis::of(&design.baseline);
    design.baseline.extend(columns.into_iter().filter(|column| basis.push(column)));
    Some(design)
}

/// A delay of up to one sample between force and position is how the recording was made, not physics: it is fitted
/// jointly with everything. A longer one is an effect to be named (`time_skew`).
fn with_delay(stretches: &[Channels], cutoff: f64, reversals: Reversals) -> Option<DesignMatrix> {
    let design = DesignMatrix::new(stretches, cutoff, reversals, true)?;
    let dt = stretches.iter().map(|s| s.dt).fold(0.0, f64::max);
    let Some(first) = Hypothesis::new(&design, Vec::new()) else {
        return DesignMatrix::new(stretches, cutoff, reversals, false);
    };
    let at = |values: &[f64]| values.get(design.present.len()).copied();
    match at(&first.fit.coefficients).zip(at(first.fit.std_errors())) {
        Some((delay, std)) if delay.abs() - 3.0 * std <= dt => Some(design),
        _ => DesignMatrix::new(stretches, cutoff, reversals, false),
    }
}

struct Run<'a> {
    intake: Intake,
    cutoff: f64,
    options: &'a Options,
    origins: Vec<(usize, Option<(f64, f64)>)>,
    /// Forces that repeat in time, which were taken out.
    hums: Vec<Hum>,
    named: Named,
    /// Curves over further columns that do not hold on other recordings.
    astray: Option<CarriesNot>,
}

impl Run<'_> {
    fn diagnose(&self, judges: &[Judge], watch: Watch<'_>) -> Result<Diagnosis, Interrupted> {
        let Self { cutoff, options, ref named, .. } = *self;
        let Regression { design, baseline, .. } = &named.regression;
        let (floor, p) = (&named.floor, &named.p);
        let geometry = self.intake.geometry;
        let unit = Dimension::FORCE.unit(geometry);
        let rows = design.effective_rows();
        let to_rms = |sum: f64| design.rms(sum);
        let search = named.search(options, cutoff);
        let mut found = named.found.clone();
        let joint = Joint::of(&search, &found);
        found.fit.set_std_errors((0..found.fit.coefficients.len()).map(|i| joint.gain(i)).collect());
        let mut last = named.last.clone();
        let mut std_errors = last.fit.std_errors().to_vec();
        for (std, joint) in std_errors.iter_mut().zip(found.fit.std_errors()) {
            *std = std.max(*joint);
        }
        last.fit.set_std_errors(std_errors);

        tell(watch, 0.85, "location")?;
        let columns = Hypothesis::columns(design, &[]);
        let squared_floor = search.floor;
        let located = locate(
            design,
            &columns,
            &baseline.fit.residual,
            &last.fit.residual,
            &last.fit.residual,
            squared_floor,
            geometry,
            options.seed,
        );
        let left = locate(
            design,
            &last.all_columns(design),
            &last.fit.residual,
            &last.fit.residual,
            &last.fit.residual,
            squared_floor,
            geometry,
            options.seed,
        );

        let followed = &named.regression.followed;
        let hums: f64 = self.hums.iter().map(|h| h.squared.0 - h.squared.1).sum();
        let before = named.regression.plain.fit.heldout_sum() + hums * rows;
        let after = last.fit.heldout_sum();
        let kin = findings::words::distinct(named.kin.iter().map(TermKind::id));
        let form = |(i, (t, gain))| {
            let kin = if i == 0 { kin.as_slice() } else { &[] };
            free_form::finding::missing(t, gain, rows, kin, geometry)
        };
        let switching = free_form::finding::switching(&last.free, &named.gains, rows, geometry);
        let (unnamed, switched): (Vec<Missing>, Option<Location>) = match switching {
            Some((missing, between)) => (vec![missing], Some(between)),
            None => (last.free.iter().zip(&named.gains).enumerate().map(form).collect(), None),
        };
        let elsewhere = findings::unnamed::elsewhere(&search, &found, left.p, geometry)
            .filter(|_| found.atoms.is_empty() && unnamed.is_empty());
        tell(watch, 0.9, "rivals")?;
        let plant = self.plant(&last);
        let frequency = self.intake.stretches.iter().map(Channels::dominant_frequency).fold(0.0, f64::max);
        let rivals: Vec<Vec<Rival>> = rivals(&search, &found);
        let whole = design.unmasked();
        let blind = blind(&search, &found, &whole, &named.unavailable, geometry);
        let rival = rivals.iter().flatten().map(|r| r.about.id.to_string());
        let not_ruled_out: Vec<String> = rival.chain(blind.iter().map(|(b, _)| b.effect.clone())).collect();
        let mut missing: Vec<Missing> = p
            .iter()
            .zip(&rivals)
            .enumerate()
            .map(|(i, (p, r))| self.missing(&found, &last, &joint, i, *p, r))
            .collect();
        tell(watch, 0.93, "the next experiment")?;
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
        let of_channels = findings::channel::missing(
            &self.intake.channel,
            design,
            &found.fit.coefficients,
            geometry,
            options.seed,
        );
        let said: Vec<String> = missing.iter().map(|m| &m.effect).chain(&options.exclude).cloned().collect();
        let of_channels: Vec<_> =
            of_channels.into_iter().filter(|(m, _)| !said.contains(&m.effect)).collect();
        let (instruments, mut of_channels): (Vec<_>, Vec<_>) =
            of_channels.into_iter().partition(|(m, _)| findings::channel::is_repaired(&m.effect));
        let instruments = instruments.into_iter().map(|(m, _)| m).collect();
        of_channels.sort_by(|a, b| gain(&b.0).total_cmp(&gain(&a.0)));
        // where the strongest effect shows stands first
        let strongest = missing.iter().map(gain).fold(0.0, f64::max);
        let (ahead, behind): (Vec<_>, Vec<_>) =
            of_channels.into_iter().partition(|(m, _)| gain(m) > strongest);
        let shown = |effects: &[(Missing, Vec<Location>)]| -> Vec<Location> {
            effects.iter().flat_map(|(_, regions)| regions.clone()).collect()
        };
        // what comes and goes in time shows over whatever the body did then
        let of_fit: Vec<Location> = switched.into_iter().chain(located.regions).take(MOST_REGIONS).collect();
        let follows = findings::unnamed::where_it_follows(followed);
        let mut hummed: Vec<Location> = Vec::new();
        if let Some(last) = row_times(design).last().filter(|_| !self.hums.is_empty()) {
            hummed.push(Location {
                coordinate: "time".into(),
                from: design.tracks.first().map_or(0.0, |t| t.time(0)),
                to: *last,
                unit: "s".into(),
                share_of_mismatch: hums * rows / before,
                p: LEVEL,
            });
        }
        let mut location = [hummed, follows, shown(&ahead), of_fit, shown(&behind)].concat();
        missing.extend(ahead.into_iter().chain(behind).map(|(m, _)| m));
        missing.extend(findings::unnamed::follows(followed, &named.instead));
        missing.extend(unnamed);
        missing.extend(self.hums.iter().map(|h| h.missing(geometry)));
        missing.sort_by(|a, b| gain(b).total_cmp(&gain(a)));
        if let Some((told, when)) = elsewhere {
            missing.push(told);
            location.extend(when);
        }
        let verdict = if missing.is_empty() { Verdict::NoMismatch } else { Verdict::Mismatch };

        tell(watch, 0.95, "free run and validation")?;
        let excess = |sum: f64| (sum - squared_floor).max(0.0);
        let explained_share =
            if excess(before) > 0.0 { (1.0 - excess(after) / excess(before)).clamp(0.0, 1.0) } else { 0.0 };
        let run = free_run::run(design, &plant, frequency);
        let mut rejected = rejected(&search, &found, &whole, &not_ruled_out, unit);
        // what is smaller is not named even where it is seen
        let bound = detectable(&rejected).max(to_rms(search.systematic));
        // while several floors are left, any of them may be part of that
        if to_rms(after) > SEVERAL * floor.rms {
            rejected.clear();
        }
        let (time, (position, velocity)) = (row_times(design), row_motion(design));
        let mut curves = located.curves;
        curves.truncate(8);
        let figures = Figures {
            free_run_position: run.as_ref().map_or_else(Vec::new, |(_, x)| self.at_rows(x)),
            time,
            position,
            velocity,
            force: design.y.clone(),
            before: baseline.fit.heldout_prediction.clone(),
            after: last.fit.heldout_prediction.clone(),
            curves,
        };
        let validation = named.frozen(&last, options).judge(judges, geometry);
        let left_out = self.left_out(judges, &last, &search);
        if verdict != Verdict::Mismatch {
            location.clear();
        }
        let mut diagnosis = Diagnosis {
            schema: SCHEMA,
            verdict,
            summary: String::new(),
            recording_faults: self.faults(&last),
            preparation: self.intake.reports.clone(),
            noise_floor: NoiseFloor { rms: floor.rms, unit: unit.to_string(), how: floor.how.into() },
            baseline: Baseline {
                law: "karnopp".into(),
                parameters: self.parameters(&baseline.fit),
                rms_heldout: to_rms(before),
            },
            location,
            instruments,
            does_not_carry_over: self.withdrawn(),
            left_out,
            blind_to: blind,
            rejected,
            after: After {
                rms_heldout: to_rms(after).min(to_rms(before)),
                free_run_error: run.map(|r| r.0),
                explained_share: if verdict == Verdict::Mismatch { explained_share } else { 0.0 },
                parameters: self.parameters(&last.fit),
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
            judged_share: design.judged_share() * self.intake.fitted,
            fitted_share: self.intake.fitted,
            cutoff_hz: cutoff,
            nuisances: self.nuisances(&last),
            validation,
            experiments,
            next_experiment,
            model: Some(self.model(&last)),
            missing,
            figures,
        };
        diagnosis.summary = crate::findings::words::summary(&diagnosis);
        tell(watch, 1.0, "done")?;
        Ok(diagnosis)
    }

    /// What the audit said, and what only the fit could see.
    fn faults(&self, found: &Hypothesis) -> Vec<RecordingFault> {
        let mut faults = self.intake.faults.clone();
        let mass = found.fit.coefficients.first().zip(found.fit.std_errors().first());
        faults.extend(mass.and_then(|(mass, std)| implausible_mass(*mass, *std, self.intake.geometry)));
        let blows = |t: &Track| t.blows.iter().map(|i| t.time(*i)).collect();
        faults.extend(blows::fault(self.design().tracks.iter().map(blows)));
        for (i, atom) in found.atoms.iter().enumerate() {
            let TermKind::Series(kind) = atom.term.kind else { continue };
            let gains = atom.gains(found.coefficients(self.design(), i));
            if let Some(lag) = kind.low_pass(&gains, &atom.term.shape) {
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

    fn design(&self) -> &DesignMatrix {
        &self.named.regression.design
    }

    /// What the recordings show the device to be able to.
    fn limits(&self, mass: f64) -> Limits {
        let stroke = self.design().tracks.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), t| {
            t.x.iter().fold((l, h), |(l, h), x| (l.min(*x), h.max(*x)))
        });
        let largest = |of: &dyn Fn(&Track) -> &Vec<f64>| {
            self.design().tracks.iter().flat_map(of).fold(0.0_f64, |m, x| m.max(x.abs()))
        };
        Limits::shown(stroke.1 - stroke.0, largest(&|t| &t.v), largest(&|t| &t.f), mass)
    }

    fn parameters(&self, fit: &Fit) -> BTreeMap<String, Quantity> {
        let estimates = fit.coefficients.iter().copied().zip(fit.std_errors().iter().copied());
        self.design()
            .present
            .iter()
            .map(|i| &BASELINE[*i])
            .chain(self.design().delay.then_some(&DELAY))
            .zip(estimates)
            .chain(self.intake.delta_v.map(|found| (&DELTA_V, found)))
            .map(|(parameter, (value, std))| {
                (parameter.name.to_string(), self.quantity(parameter, value, std))
            })
            .collect()
    }

    fn missing(
        &self,
        found: &Hypothesis,
        last: &Hypothesis,
        joint: &Joint,
        i: usize,
        p: f64,
        rivals: &[Rival],
    ) -> Missing {
        let design = self.design();
        let atom = &found.atoms[i];
        let mut others = found.atoms.clone();
        others.remove(i);
        let without = Hypothesis::new(design, others);
        let before = without.as_ref().map_or(f64::NAN, |w| design.rms(w.fit.heldout_sum()));
        let interval = without.as_ref().map_or([0.0, 0.0], |w| {
            gain_interval(
                &w.fit.heldout,
                &found.fit.heldout,
                &design.block_weight(),
                &design.blocks.recordings,
                2000,
                self.options.seed,
            )
        });
        Missing {
            effect: atom.term.kind.id().into(),
            says: atom.term.kind.about().says.into(),
            equation: atom.term.kind.about().equation.into(),
            parameters: self.effect_parameters(joint, last, i),
            rms_heldout_before: before,
            rms_heldout_after: design.rms(found.fit.heldout_sum()),
            gain_ci95: interval,
            p,
            indistinguishable_from: rivals.iter().map(|r| r.about.id.to_string()).collect(),
            experiment: String::new(),
            free_form: None,
        }
    }

    /// Gains and shape of term `i`.
    fn effect_parameters(&self, joint: &Joint, found: &Hypothesis, i: usize) -> BTreeMap<String, Quantity> {
        let atom = &found.atoms[i];
        let kind = atom.term.kind;
        let own = found.offset(self.design(), i);
        let mut out = BTreeMap::new();
        let gains = atom.gains(found.coefficients(self.design(), i));
        let groups = atom.term.free_gains();
        for (g, parameter) in kind.gains().iter().enumerate() {
            let column = groups
                .iter()
                .position(|members| members.contains(&g))
                .and_then(|free| atom.active.iter().position(|a| *a == free));
            let Some(column) = column else { continue };
            let quantity = self.quantity(parameter, gains[g], joint.gain(own + column));
            out.insert(parameter.name.to_string(), quantity);
        }
        for (axis, parameter) in kind.shape().iter().enumerate() {
            let Some(std) = joint.shape(i, axis) else { continue };
            let quantity = self.quantity(parameter, atom.term.shape[axis], std);
            out.insert(parameter.name.to_string(), quantity);
        }
        out
    }

    /// An estimate of a parameter, in its unit.
    fn quantity(&self, parameter: &Parameter, value: f64, std: f64) -> Quantity {
        Quantity { value, std, unit: parameter.unit(self.intake.geometry).to_string() }
    }

    fn plant(&self, found: &Hypothesis) -> Plant {
        let [mass, c_p, c_n, b_p, b_n] = self.design().physics(&found.fit.coefficients);
        let mut plant = Plant { mass, coulomb: [c_p, c_n], viscous: [b_p, b_n], ..Plant::default() };
        let delay =
            if self.design().delay { found.fit.coefficients[self.design().present.len()] } else { 0.0 };
        let late = |t: &Track| t.late().iter().map(|late| delay * late).collect();
        plant.sensors = self.design().tracks.iter().map(late).collect();
        plant.free = found.free.iter().map(|t| t.form).collect();
        for (i, atom) in found.atoms.iter().enumerate() {
            let gains = atom.gains(found.coefficients(self.design(), i));
            match atom.term.kind {
                TermKind::Force(kind) => plant.effects.push((kind, gains, atom.term.shape)),
                TermKind::Series(kind) => {
                    for (track, sum) in self.design().tracks.iter().zip(&mut plant.sensors) {
                        for (g, gain) in gains.iter().enumerate().take(kind.about().gains.len()) {
                            let column = series::column(track, kind, g, &atom.term.shape);
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
        let Some(first) = self.design().tracks.first() else { return Vec::new() };
        let mut out: Vec<f64> = (0..first.row_count())
            .map(|r| {
                let rows = r * first.stride..(r + 1) * first.stride;
                series[rows.clone()].iter().sum::<f64>() / rows.len() as f64
            })
            .collect();
        out.resize(self.design().share.len(), f64::NAN);
        out
    }

    /// What was named and taken back.
    fn withdrawn(&self) -> Vec<CarriesNot> {
        let of = |w: &Withdrawn| CarriesNot {
            effect: w.kind.id().into(),
            regime: w.regime.clone(),
            rms_before: w.rms.0,
            rms_after: w.rms.1,
        };
        self.named.withdrawn.iter().map(of).chain(self.astray.clone()).collect()
    }

    /// Error on the recordings that judge; without any, on the regime left out in which the model does worst.
    fn left_out(&self, judges: &[Judge], found: &Hypothesis, search: &Search) -> Option<LeftOut> {
        let named = &self.named;
        // a hum is fitted over the whole recording, and no half tells of the time of the other: where they are all that was found,
        // no half can judge it
        let of_time = !self.hums.is_empty() || !found.free.is_empty();
        if judges.is_empty()
            && of_time
            && found.atoms.is_empty()
            && found.free.iter().all(FreeTerm::is_of_time)
        {
            return None;
        }
        if judges.is_empty() {
            return lasting::left_out(search, found, &named.regimes, named.regression.plain_columns())
                .map(|(on, rms_before, rms_after)| LeftOut { on, rms_before, rms_after });
        }
        let frozen = named.frozen(found, self.options);
        let on: Vec<&str> = judges.iter().map(Judge::name).collect();
        Some(LeftOut {
            on: on.join(", "),
            rms_before: frozen.rms(judges, &named.regression.plain),
            rms_after: frozen.rms(judges, found),
        })
    }

    /// What differs between the recordings, as far as it was declared.
    fn nuisances(&self, found: &Hypothesis) -> Vec<PerRecording> {
        let of = |recording: usize, nuisance: Nuisance, value: f64, std: f64| PerRecording {
            recording: self.intake.names.get(recording).cloned().unwrap_or_default(),
            nuisance: nuisance.id().into(),
            value,
            std,
            unit: nuisance.parameter().unit(self.intake.geometry).to_string(),
        };
        let from = self.design().present.len() + usize::from(self.design().delay);
        let columns = self.named.regression.declared.iter().enumerate().map(|(i, d)| {
            of(d.recording, d.nuisance, found.fit.coefficients[from + i], found.fit.std_errors()[from + i])
        });
        let origins = self.origins.iter().map(|(recording, found)| {
            let (value, std) = found.unwrap_or((0.0, f64::NAN));
            of(*recording, Nuisance::Origin, value, std)
        });
        columns.chain(origins).collect()
    }

    fn model(&self, found: &Hypothesis) -> identify::Model {
        crate::findings::export::model(&self.intake, self.design(), found, self.cutoff)
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

fn untestable(intake: Intake, because: &str) -> Diagnosis {
    let noise = intake.stretches.first().map_or(Noise::default(), |s| derived_noise(s, 1.0));
    let unit = Dimension::FORCE.unit(intake.geometry).to_string();
    unanswered(intake.faults, intake.reports, noise.force, unit, because)
}

/// The diagnosis of recordings that cannot answer.
pub(crate) fn unanswered(
    faults: Vec<RecordingFault>,
    reports: Vec<Preparation>,
    noise: f64,
    unit: String,
    because: &str,
) -> Diagnosis {
    let mut diagnosis = Diagnosis {
        schema: SCHEMA,
        verdict: Verdict::NotTestable,
        summary: format!("This recording cannot answer: {because}."),
        recording_faults: faults,
        preparation: reports,
        noise_floor: NoiseFloor { rms: noise, unit, how: "local differences".into() },
        baseline: Baseline { law: "karnopp".into(), parameters: BTreeMap::new(), rms_heldout: f64::NAN },
        location: Vec::new(),
        missing: Vec::new(),
        instruments: Vec::new(),
        does_not_carry_over: Vec::new(),
        left_out: None,
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
        judged_share: 0.0,
        fitted_share: 0.0,
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
