//! From a baseline to a hypothesis: the search for what was left out, with everything it is judged by.

use crate::findings::floor::{Floor, floor, systematic};
use crate::findings::validate::{Frozen, Judge};
use crate::free_form::contradiction::{self, DESCRIBED, Resolved};
use crate::free_form::describe::{Described, Gain};
use crate::free_form::switching::switching;
use crate::free_form::term::FreeTerm;
use crate::library::applied_force::AppliedForce;
use crate::library::design_matrix::DesignMatrix;
use crate::library::scales::Scales;
use crate::library::term::TermKind;
use crate::options::{Interrupted, Options, Watch, tell};
use crate::preparation::intake::Intake;
use crate::search::applied_force;
use crate::search::catalogue::Catalogue;
use crate::search::hypothesis::{Atom, Hypothesis};
use crate::search::judgement::Search;
use crate::search::lasting::{self, Regime, Withdrawn};
use crate::search::refine::FINE;
use crate::search::regression::Regression;
use friction::effects::{About, Acts, LookedFor, Quantity as Measured, Seat};
use rayon::prelude::*;
use signals::Channels;

/// Share of the floor below which a held-out error refutes it.
const UNDERCUT: f64 = 0.7;

/// Rows for each gain and each shape. With fewer, blocks held out no longer tell what repeats from what happened once: a
/// recording of 90 rows had six effects with 21 numbers named.
const ROWS_A_PARAMETER: usize = 10;

/// Squared error over that of the floor from which on several floors remain.
const REMAINS: f64 = 4.0;

/// Share of the squared error above the floor below which an explanation is a small part.
const SMALL: f64 = 1.0 / 3.0;

/// The same of several names: together they leave more than they explain.
const LESS_THAN_LEFT: f64 = 0.5;

/// Steps take the place of a smooth curve over time if they leave less than this share of its squared error.
const OUTDONE: f64 = 0.5;

/// Searches at most: one more after each in which something did not last.
const ROUNDS: usize = 3;

/// What was found, and everything it was judged by.
pub(crate) struct Named {
    pub regression: Regression,
    pub noisy: DesignMatrix,
    pub catalogue: Catalogue,
    pub scales: Scales,
    /// The force that acts, as far as it is known.
    pub acting: AppliedForce,
    pub floor: Floor,
    pub found: Hypothesis,
    /// Family-wise p of each term.
    pub p: Vec<f64>,
    /// What was named and does not last.
    pub withdrawn: Vec<Withdrawn>,
    pub regimes: Vec<Regime>,
    /// What was found with the physics that has no name, fitted jointly.
    pub last: Hypothesis,
    /// What each free form gains.
    pub gains: Vec<Gain>,
    /// Names that the free forms contradict.
    pub kin: Vec<TermKind>,
    /// Effects that explain as much without further columns as the curves over them do.
    pub instead: Vec<TermKind>,
    /// Effects that need another geometry, or a channel that the recordings do not have, and why.
    pub unavailable: Vec<(&'static str, &'static str)>,
}

/// Share of the squared error that an effect may cost on recordings that judge before it is withdrawn.
const CHANCE: f64 = 0.001;

impl Named {
    /// Whether phases along the stroke hold on other recordings: declared, or shown by several that share them.
    pub fn phases_hold(&self, options: &Options) -> bool {
        let mut recordings: Vec<usize> =
            self.regression.design.tracks.iter().map(|t| t.raw.recording).collect();
        recordings.dedup();
        options.absolute || recordings.len() > 1
    }

    /// What is frozen for other recordings.
    pub fn frozen<'a>(&'a self, found: &'a Hypothesis, options: &'a Options) -> Frozen<'a> {
        Frozen {
            design: &self.regression.design,
            baseline: &self.regression.plain,
            found,
            declared: &options.per_recording,
            absolute: self.phases_hold(options),
        }
    }

    /// Withdraws every effect without which the frozen model does better on `judges`, and all of them where the model does
    /// no better than the baseline.
    pub fn confirm(&mut self, judges: &[Judge], options: &Options, cutoff: f64, regime: &str) {
        if judges.is_empty() {
            return;
        }
        let baseline = self.regression.baseline.clone();
        let plain = self.frozen(&baseline, options).squared(judges, &self.regression.plain);
        loop {
            let frozen = self.frozen(&self.found, options);
            let with = frozen.squared(judges, &self.found);
            let others = |i: usize| {
                let mut atoms = self.found.atoms.clone();
                atoms.remove(i);
                let without = Hypothesis::new(frozen.design, atoms)?;
                Some((frozen.squared(judges, &without), i, without))
            };
            let worse = with > plain;
            // recordings with another zero say nothing about what is zero there on the average, unless nothing else is left
            let judged =
                |i: &usize| worse || frozen.absolute || !self.found.atoms[*i].term.kind.is_periodic();
            let best = (0..self.found.atoms.len())
                .into_par_iter()
                .filter(judged)
                .filter_map(others)
                .min_by(|a, b| a.0.total_cmp(&b.0));
            let Some((without, i, fewer)) = best else { return };
            if without >= (1.0 - CHANCE) * with && !worse {
                return;
            }
            let kind = self.found.atoms[i].term.kind;
            let rms = (frozen.rms(judges, &fewer), frozen.rms(judges, &self.found));
            let withdrawn = Withdrawn { kind, regime: regime.into(), rms };
            let search = self.search(options, cutoff);
            let (found, p) = search.prune(search.refine(fewer, FINE), baseline.fit.heldout_sum());
            self.withdrawn.push(withdrawn);
            (self.found, self.p) = (found, p);
        }
    }

    /// Describes what has no name by free forms, as long as they lower the error on `judges`.
    pub fn describe(
        &mut self,
        judges: &[Judge],
        options: &Options,
        cutoff: f64,
        watch: Watch<'_>,
    ) -> Result<(), Interrupted> {
        let search = self.search(options, cutoff);
        let Resolved { found, mut described, kin, beside } =
            contradiction::resolve(&search, &self.found, &self.regimes, &self.regression.baseline, watch)?;
        let squared = |d: &Described| {
            let last = d.beside(&found);
            self.frozen(&last, options).squared(judges, &last)
        };
        let named = self.frozen(&self.found, options).squared(judges, &self.found);
        while !judges.is_empty() && !described.terms.is_empty() {
            tell(watch, DESCRIBED, "what has no name")?;
            let with = squared(&described);
            let fewer =
                (0..described.terms.len()).filter_map(|i| described.without(&search, &found, Some(i)));
            let best = fewer.map(|d| (squared(&d), d)).min_by(|a, b| a.0.total_cmp(&b.0));
            let worse = with > named;
            described = match best {
                Some((without, fewer)) if worse || without <= (1.0 - CHANCE) * with => fewer,
                None if worse => Described::nothing(&found),
                _ => break,
            };
        }
        // without a curve nothing contradicts a name
        let contradicted = !described.terms.is_empty() || kin.is_empty();
        if contradicted {
            let before = self.found.atoms.iter().map(|a| a.term).zip(self.p.iter().copied());
            let known: Vec<_> = beside.into_iter().chain(before).collect();
            let of = |a: &Atom| known.iter().find(|(term, _)| *term == a.term).map_or(1.0, |(_, p)| *p);
            let p = found.atoms.iter().map(of).collect();
            let described = described.measured(&search, &found);
            self.p = p;
            (self.last, self.gains) = (described.beside(&found), described.gains);
            (self.found, self.kin) = (found, kin);
        } else {
            self.last = self.found.clone();
        }
        self.withdraw_a_small_part(options, cutoff);
        if judges.is_empty() {
            self.withdraw_what_costs(options, cutoff);
            self.describe_what_comes_and_goes(options, cutoff);
        }
        Ok(())
    }

    /// Describes an error that nothing else explains, or only a smooth curve over time in part, by what comes and goes.
    fn describe_what_comes_and_goes(&mut self, options: &Options, cutoff: f64) {
        let search = self.search(options, cutoff);
        let left = self.last.fit.heldout_sum();
        let much = left > REMAINS * search.floor;
        if !(much || self.found.atoms.is_empty()) || !self.last.free.iter().all(FreeTerm::is_of_time) {
            return;
        }
        let better = |d: &Described| self.last.free.is_empty() || d.fit.heldout_sum() < OUTDONE * left;
        if let Some(described) = switching(&search, &self.found).filter(better) {
            (self.last, self.gains) = (described.beside(&self.found), described.gains);
        }
    }

    /// Withdraws everything where it explains a small part of what the baseline leaves out and several floors remain: where
    /// the rest is unknown, a part of it looks like any effect.
    fn withdraw_a_small_part(&mut self, options: &Options, cutoff: f64) {
        let search = self.search(options, cutoff);
        let (floor, baseline) = (search.floor, &self.regression.baseline);
        let (before, after) = (baseline.fit.heldout_sum(), self.last.fit.heldout_sum());
        let least = if self.found.atoms.len() > 1 { LESS_THAN_LEFT } else { SMALL };
        if after < REMAINS * floor || before - after >= least * (before - floor) {
            return;
        }
        let regime = format!(
            "everything found explains only {:.0} % of the squared error above the noise floor",
            100.0 * (before - after) / (before - floor)
        );
        self.take_back(&regime, (search.design.rms(before), search.design.rms(after)));
    }

    /// Withdraws everything where it does worse than the baseline in the recording or the half of the time that is left out.
    fn withdraw_what_costs(&mut self, options: &Options, cutoff: f64) {
        let plain = self.regression.plain_columns();
        let search = self.search(options, cutoff);
        if let Some((regime, before, after)) = lasting::left_out(&search, &self.last, &self.regimes, plain)
            && after > before
        {
            self.take_back(&regime, (before, after));
        }
    }

    /// Withdraws everything that was found, because of its errors in a regime, without it and with it.
    fn take_back(&mut self, regime: &str, rms: (f64, f64)) {
        let withdrawn = |atom: &Atom| Withdrawn { kind: atom.term.kind, regime: regime.into(), rms };
        self.withdrawn.extend(self.found.atoms.iter().map(withdrawn));
        let baseline = self.regression.baseline.clone();
        (self.found, self.p) = (baseline.clone(), Vec::new());
        (self.last, self.gains, self.kin) = (baseline, Vec::new(), Vec::new());
    }

    /// The search, to judge further hypotheses by.
    pub fn search<'a>(&'a self, options: &Options, cutoff: f64) -> Search<'a> {
        search(&self.regression, &self.noisy, &self.catalogue, &self.scales, &self.floor, options, cutoff)
    }
}

fn search<'a>(
    regression: &'a Regression,
    noisy: &'a DesignMatrix,
    catalogue: &'a Catalogue,
    scales: &'a Scales,
    floor: &Floor,
    options: &Options,
    cutoff: f64,
) -> Search<'a> {
    let Regression { design, baseline, .. } = regression;
    let rows = design.effective_rows();
    Search {
        design,
        noisy,
        catalogue,
        scales,
        floor: floor.rms * floor.rms * rows,
        systematic: systematic(design, baseline.fit.coefficients[0], cutoff, floor.rms).powi(2) * rows,
        max_terms: options.max_terms,
        max_parameters: (design.used_rows() / ROWS_A_PARAMETER).saturating_sub(design.baseline.len()),
        width: options.beam_width,
        seed: options.seed,
    }
}

/// Names what is left out, with curves over the further columns that the error follows. A column may be the cause of the error
/// or its consequence, as a force measured inside the machine is: so effects without the columns are tried as well.
pub(crate) fn name_beside_columns(
    intake: &Intake,
    plain: Regression,
    cutoff: f64,
    options: &Options,
    watch: Watch<'_>,
) -> Result<Named, Interrupted> {
    let following = plain.following(intake, options).filter(|regression| !regression.followed.is_empty());
    let Some(following) = following else { return name(intake, plain, cutoff, options, watch) };
    let alone = name(intake, plain, cutoff, options, watch)?.found;
    let as_well = alone.fit.heldout_sum() <= following.baseline.fit.heldout_sum();
    let instead = alone.atoms.iter().filter(|_| as_well).map(|a| a.term.kind).collect();
    Ok(Named { instead, ..name(intake, following, cutoff, options, watch)? })
}

/// Searches until the regression and the force that acts agree with what is found.
fn name(
    intake: &Intake,
    mut regression: Regression,
    cutoff: f64,
    options: &Options,
    watch: Watch<'_>,
) -> Result<Named, Interrupted> {
    let unavailable = unavailable(intake, regression.design.is_one_way());
    // the force that acts, with the catalogue on it, once it is known better than the baseline alone knows it
    let mut settled: Option<(AppliedForce, DesignMatrix, Catalogue)> = None;
    loop {
        let Regression { design, baseline, .. } = &regression;
        let mut floor = measured_floor(&regression, options);
        tell(watch, 0.1, "catalogue")?;
        let scales = Scales::of(&design.tracks, cutoff);
        let first = settled.is_none();
        let (acting, mut noisy, mut catalogue) = settled.take().unwrap_or_else(|| {
            let acting = AppliedForce::baseline(design.physics(&baseline.fit.coefficients));
            let noisy = design.perturbed(cutoff, &acting, options.seed ^ 0x51f1);
            let lines = crate::library::lines::fine(design, &baseline.fit.residual, &scales, options.seed);
            let exclude = excluded(intake, design, cutoff, options, &unavailable);
            let catalogue = Catalogue::new(design, &noisy, &scales, &lines, &exclude);
            (acting, noisy, catalogue)
        });
        tell(watch, 0.3, "naming")?;
        let run = |from: &Hypothesis, floor: &Floor, catalogue: &Catalogue| {
            let search = search(&regression, &noisy, catalogue, &scales, floor, options, cutoff);
            let found = search.run(from.clone(), watch)?;
            Ok::<_, Interrupted>(found.unwrap_or_else(|| (from.clone(), Vec::new())))
        };
        let (mut found, mut p) = run(baseline, &floor, &catalogue)?;
        // A floor that a model undercuts on what it has not seen was none: a broad signal was taken for noise.
        let reached = design.rms(found.fit.heldout_sum());
        if reached < UNDERCUT * floor.rms && floor.how == "local differences" && reached > 0.0 {
            floor.rms = reached;
            (found, p) = run(baseline, &floor, &catalogue)?;
        }
        if let Some(other) = without_delay(intake, &regression, &found, cutoff, options) {
            regression = other;
            continue;
        }
        let again = search(&regression, &noisy, &catalogue, &scales, &floor, options, cutoff);
        if let Some((design, acting)) = first.then(|| applied_force::settle(&again, &found)).flatten() {
            noisy.model_force(&acting);
            catalogue.renew(&design, &noisy);
            regression.design = design;
            settled = Some((acting, noisy, catalogue));
            continue;
        }

        let regimes = lasting::regimes(design, &intake.names);
        let mut withdrawn: Vec<Withdrawn> = Vec::new();
        for round in 0.. {
            tell(watch, 0.75, "what lasts")?;
            let search = search(&regression, &noisy, &catalogue, &scales, &floor, options, cutoff);
            let fails;
            (found, p, fails) = search.lasting((found, p), &regimes);
            let last = fails.is_empty() || round == ROUNDS;
            // what takes the place of a symptom may be the cause
            fails.iter().for_each(|w| catalogue.exclude(w.kind));
            withdrawn.extend(fails);
            if last {
                break;
            }
            (found, p) = run(&found, &floor, &catalogue)?;
        }
        let mut told = Vec::new();
        withdrawn.retain(|w| {
            let new = !found.has(w.kind) && !told.contains(&w.kind.id());
            told.push(w.kind.id());
            new
        });
        return Ok(Named {
            regression,
            noisy,
            catalogue,
            scales,
            acting,
            floor,
            p,
            withdrawn,
            regimes,
            last: found.clone(),
            gains: Vec::new(),
            kin: Vec::new(),
            instead: Vec::new(),
            found,
            unavailable,
        });
    }
}

fn measured_floor(regression: &Regression, options: &Options) -> Floor {
    let Regression { design, baseline, .. } = regression;
    let residual = design.sample_residual(&design.physics(&baseline.fit.coefficients));
    floor(design, &residual, baseline.fit.coefficients[0], options.declared_noise)
}

/// Effects that need another geometry, or a channel that the recordings do not have, and why.
fn unavailable(intake: &Intake, one_way: bool) -> Vec<(&'static str, &'static str)> {
    let derived = intake.stretches.iter().all(|s| s.velocity.is_none());
    let why = |about: &About| match (about.only, about.seat) {
        (Some((needed, otherwise)), _) if needed != intake.geometry => Some(otherwise),
        (_, Seat::Channel(Measured::Velocity)) if derived => {
            Some("there is no velocity channel: velocity is derived from position without lag")
        }
        _ => match about.looked_for {
            LookedFor::WhereItAdvances if !one_way => {
                Some("the body reverses, and beside reversals other friction looks like it")
            }
            LookedFor::Nowhere => Some("in a motion it stands in for most other effects"),
            _ => None,
        },
    };
    TermKind::all().iter().filter_map(|kind| Some((kind.id(), why(kind.about())?))).collect()
}

/// Effects that are not searched for.
fn excluded<'a>(
    intake: &Intake,
    design: &DesignMatrix,
    cutoff: f64,
    options: &'a Options,
    unavailable: &[(&'static str, &'static str)],
) -> Vec<&'a str> {
    let mut out: Vec<&str> = options.exclude.iter().map(String::as_str).collect();
    out.extend(unavailable.iter().map(|(e, _)| *e));
    let independent = intake.has_independent_sensor(cutoff);
    let otherwise = TermKind::all().into_iter().filter(|kind| match kind.about().seat {
        // comparing the channels says more about it than any force
        Seat::Channel(Measured::Velocity) => true,
        Seat::Channel(Measured::Position) => independent,
        // the baseline has it
        _ => design.delay && kind.acts(Acts::Delay),
    });
    out.extend(otherwise.map(|kind| kind.id()));
    out
}

/// The regression with the delay among the effects, where what was found says that the nuisance of up to a sample was
/// more: beside it there is a lag of the force, or it is longer once the rest of the physics is there.
fn without_delay(
    intake: &Intake,
    regression: &Regression,
    found: &Hypothesis,
    cutoff: f64,
    options: &Options,
) -> Option<Regression> {
    let design = &regression.design;
    if !design.delay {
        return None;
    }
    let dt = intake.stretches.iter().map(|s: &Channels| s.dt).fold(0.0, f64::max);
    let delay = found.fit.coefficients.get(design.present.len()).copied().unwrap_or(0.0);
    let lags = found.atoms.iter().any(|a| a.term.kind.moves_in_time());
    if delay.abs() <= dt && !lags {
        return None;
    }
    regression.without_delay(intake, cutoff, options)
}
