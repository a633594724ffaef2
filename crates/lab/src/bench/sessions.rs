//! Sessions: opened, resumed, listed. A plan with a stimulus that the device cannot present is refused before the first trial.

use super::Bench;
use super::running::Running;
use crate::experiment::{Begun, Task};
use crate::say::Tone;
use crate::session_file;
use crate::verdict;
use friction::effects::EffectKind;
use perception::{Experiment, ForcedChoicePlan, Log, Stimulus, TargetingPlan};
use std::path::PathBuf;

impl Bench {
    pub(super) fn begin_targeting(&mut self, subject: &str, seed: u64, practice: bool) -> Result<(), String> {
        let mut plan = TargetingPlan::thesis(seed);
        if !practice {
            plan = TargetingPlan { practice, order: Vec::new(), ..plan };
            plan.order = plan.drawn();
        }
        let reach = self.shared.known(|known| known.reach);
        let widest = plan.order.iter().map(|s| 0.5 * (s.difficulty.distance_px + s.difficulty.width_px));
        let needed = widest.fold(0.0_f64, f64::max) * plan.metre_per_px;
        if needed > reach {
            return Err(format!(
                "the widest targets need {:.1} mm to either side, the handle has {:.1}",
                1e3 * needed,
                1e3 * reach
            ));
        }
        self.begin(subject, Experiment::Targeting(plan))
    }

    pub(super) fn begin_choice(&mut self, subject: &str, seed: u64, batches: &str) -> Result<(), String> {
        let plan = match batches {
            "thesis" => ForcedChoicePlan::thesis(seed),
            "adaptive" => ForcedChoicePlan::adaptive(seed),
            own => ForcedChoicePlan::from_toml(own)?,
        };
        self.all_presentable(&plan)?;
        self.begin(subject, Experiment::ForcedChoice(plan))
    }

    /// Nothing may turn out to be refused in the middle of a session.
    fn all_presentable(&self, plan: &ForcedChoicePlan) -> Result<(), String> {
        let device = self.shared.known(|known| known.device);
        let check = |batch: &str, stimulus: &Stimulus| {
            let settings = verdict::changed(&haptics::Settings::default(), &changes(stimulus))?;
            settings.validate(&device).map(|_| ()).map_err(|refused| format!("batch `{batch}`: {refused}"))
        };
        for batch in &plan.batches {
            check(&batch.name, &batch.reference)?;
            match &batch.procedure {
                perception::Procedure::Constant { comparisons, .. } => {
                    comparisons.iter().try_for_each(|stimulus| check(&batch.name, stimulus))?;
                }
                perception::Procedure::Adaptive { varied, range_n: (low, high), .. } => {
                    for difference in [*low, *high] {
                        check(&batch.name, &varied.apply(&batch.reference, difference))?;
                    }
                }
            }
        }
        Ok(())
    }

    fn begin(&mut self, subject: &str, experiment: Experiment) -> Result<(), String> {
        session_file::none_open(self.experiment.is_some())?;
        let task = Task::new(experiment.clone()).ok_or("a session on the plane begins there")?;
        let kind = if matches!(task, Task::Choice(_)) { "choice" } else { "targeting" };
        let device = self.shared.known(|known| format!("{}: {}", known.port, known.version));
        let (log, name) = session_file::create(&self.folder, kind, subject, device, experiment)?;
        self.open_session(log, name, task);
        Ok(())
    }

    pub(super) fn resume(&mut self, file: &str) -> Result<(), String> {
        session_file::none_open(self.experiment.is_some())?;
        if !super::is_name(file, ".jsonl") {
            return Err(format!("no session `{file}`"));
        }
        let (log, session) = Log::resume(&self.folder.join(file)).map_err(|e| e.to_string())?;
        if session.cut_off {
            self.say(
                Tone::Warning,
                "experiment",
                "the last trial was not finished when the file ended; it starts again",
            );
        }
        let task = Task::resume(&session).ok_or("a session on the plane goes on there")?;
        self.open_session(log, file.trim_end_matches(".jsonl").to_owned(), task);
        Ok(())
    }

    fn open_session(&mut self, log: Log, name: String, task: Task) {
        self.stop();
        self.experiment = Some(Running::new(log, name, task));
        self.list_sessions();
        self.show_experiment();
    }

    /// Lists the sessions of the folder; reads their finished trials again.
    pub(super) fn list_sessions(&mut self) {
        let Ok(entries) = std::fs::read_dir(&self.folder) else { return };
        let mut paths: Vec<PathBuf> = entries
            .filter_map(|entry| entry.ok().map(|e| e.path()))
            .filter(|path| path.extension().is_some_and(|e| e == "jsonl"))
            .collect();
        paths.sort();
        let sessions: Vec<Begun> = paths.iter().filter_map(|path| Begun::read(path)).collect();
        self.shared.known(|known| known.sessions = sessions);
        self.dirty = true;
    }
}

/// A stimulus as commands: the block of [thesis, table 5-3], and none of the effects a preset may have had.
pub(super) fn changes(stimulus: &Stimulus) -> Vec<(String, String)> {
    let mut all = vec![
        ("law".to_owned(), "karnopp".to_owned()),
        ("renderer".to_owned(), "virtual_coupling".to_owned()),
    ];
    all.extend(EffectKind::ALL.iter().map(|kind| (kind.id().to_owned(), "off".to_owned())));
    // dynamic before static when falling, static before dynamic when rising: `steps` finds the order
    all.extend(stimulus.parameters().map(|(name, value)| (name.to_owned(), format!("{value}"))));
    all
}
