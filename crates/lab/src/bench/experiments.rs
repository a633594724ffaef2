//! Experiments: the rendered resistance follows the task; each finished trial is on disk before the next one begins.

use super::Bench;
use super::recording_in_progress::begin_file;
use super::running::Felt;
use super::sessions::changes;
use crate::experiment::{Shown, Task, told};
use crate::orders::About;
use crate::say::Tone;
use crate::verdict;
use client::Sample;
use perception::{Answer, Record};

impl Bench {
    /// Ends the session; what is finished stays.
    pub(super) fn leave(&mut self) {
        if let Some(mut running) = self.experiment.take() {
            running.abandon();
            self.stop();
            self.list_sessions();
            self.show_experiment();
        }
    }

    /// Discards the current trial after a stop, a fault or the loss of the device.
    pub(super) fn interrupt(&mut self) {
        if let Some(running) = &mut self.experiment {
            running.abandon();
            running.armed = false;
            running.felt = None;
            self.show_experiment();
        }
    }

    /// The subject arms the handle, or begins the trial.
    pub(super) fn ready(&mut self) -> Result<(), String> {
        let time = self.last.map(|sample| sample.time);
        if let Some(fault) = self.shared.known(|known| known.fault.clone()) {
            return Err(format!("a fault is latched: {}; clear it first", fault.says));
        }
        let Some(running) = &mut self.experiment else { return Err("no session is open".into()) };
        let Some(time) = time else { return Err("no samples come from the device".into()) };
        if running.task.is_complete() || running.since.is_some() {
            return Ok(());
        }
        if running.armed {
            running.since = Some(time);
            running.last.clear();
            if let Task::Targeting(task) = &mut running.task {
                task.start(time);
            }
            self.begin_trajectory()?;
        } else {
            running.armed = true;
            self.shared.known(|known| known.armed = true);
        }
        self.feel()?;
        self.show_experiment();
        Ok(())
    }

    fn begin_trajectory(&mut self) -> Result<(), String> {
        let (Some(running), Some(header)) = (&mut self.experiment, &self.header) else { return Ok(()) };
        running.discard_trajectory();
        // a trial that was given up leaves no file
        let number = running.task.progress().0 + 1;
        let name = format!("{}-trial-{number:03}.csv", running.name);
        let notes =
            vec![("session".to_owned(), running.name.clone()), ("trial".to_owned(), number.to_string())];
        let file = begin_file(&self.folder.join(&name), header, notes)?;
        running.trajectory = Some((name, file));
        Ok(())
    }

    /// Puts on the handle what belongs there.
    fn feel(&mut self) -> Result<(), String> {
        let sim = self.shared.known(|known| known.sim);
        let Some(running) = &mut self.experiment else { return Ok(()) };
        let wanted = running.wanted();
        if !running.armed || running.felt == Some(wanted) {
            return Ok(());
        }
        let before = running.felt.replace(wanted);
        let block = |felt: Option<Felt>| matches!(felt, Some(Felt::Bare { block: true }));
        if sim && block(before) != block(Some(wanted)) {
            let name = if block(Some(wanted)) { "rubber" } else { "none" };
            self.orders.push(format!("sim block {name}"), About::Quiet);
            self.shared.known(|known| known.block = name.into());
        }
        match wanted {
            Felt::Bare { .. } => self.orders.push("render off", About::Quiet),
            Felt::Rendered(stimulus) => {
                let (settings, device) = self.shared.known(|known| (known.settings, known.device));
                let wanted: Vec<_> = changes(&stimulus)
                    .into_iter()
                    .filter(|(name, value)| {
                        let mut next = settings;
                        next.set(name, value).is_ok() && next != settings
                    })
                    .collect();
                for (name, value) in verdict::steps(&settings, &device, &wanted)? {
                    self.orders.push(format!("set {name} {value}"), About::Quiet);
                }
                // what the next case is compared with, before the device has listed it
                let now = verdict::changed(&settings, &wanted)?;
                self.shared.known(|known| known.settings = now);
                self.orders.push("get", About::Get);
                if !matches!(before, Some(Felt::Rendered(_))) {
                    self.orders.push("render on", About::Quiet);
                }
            }
        }
        Ok(())
    }

    /// The button, at the newest sample.
    pub(super) fn click(&mut self) -> Result<(), String> {
        let Some(sample) = self.last else { return Ok(()) };
        let Some(running) = &mut self.experiment else { return Ok(()) };
        let Task::Targeting(task) = &mut running.task else { return Ok(()) };
        let Some(event) = task.click(sample.time, sample.position) else { return Ok(()) };
        let (last, record) = told(event);
        running.last = last;
        match record {
            Some(record) => self.finished(record),
            None => {
                self.show_experiment();
                Ok(())
            }
        }
    }

    /// The next case.
    pub(super) fn advance(&mut self) -> Result<(), String> {
        let Some(running) = &mut self.experiment else { return Ok(()) };
        let (Task::Choice(task), Some(_)) = (&mut running.task, running.since) else { return Ok(()) };
        task.advance();
        self.feel()?;
        self.show_experiment();
        Ok(())
    }

    /// The subject names a case.
    pub(super) fn answer(&mut self, answer: Answer) -> Result<(), String> {
        let now = self.last.map_or(0.0, |sample| sample.time);
        let Some(running) = &mut self.experiment else { return Ok(()) };
        let (Task::Choice(task), Some(since)) = (&mut running.task, running.since) else { return Ok(()) };
        let Some(trial) = task.answer(answer, now - since) else {
            return Err("feel the baseline, A and B first".into());
        };
        // feedback would teach the subject
        running.last = "answered".into();
        self.finished(Record::ForcedChoice(trial))
    }

    /// A trial is over: on disk, then the next one.
    fn finished(&mut self, mut record: Record) -> Result<(), String> {
        let lost = self.lost;
        let Some(running) = &mut self.experiment else { return Ok(()) };
        running.since = None;
        if let Some((name, file)) = running.trajectory.take() {
            file.finish(lost).map_err(|e| e.to_string())?;
            match &mut record {
                Record::Targeting(trial) => trial.trajectory = Some(name),
                Record::ForcedChoice(trial) => trial.trajectory = Some(name),
                // its clicks are in the record; the plane has no device
                Record::Ring(_) => {}
            }
        }
        running.log.append(&record).map_err(|e| e.to_string())?;
        if let (Task::Choice(task), true) = (&running.task, running.armed)
            && task.next().is_some()
        {
            // the next question follows at once
            running.since = self.last.map(|sample| sample.time);
            self.begin_trajectory()?;
        }
        if self.experiment.as_ref().is_some_and(|running| running.task.is_complete()) {
            self.stop_quietly();
        } else {
            self.feel()?;
        }
        self.list_sessions();
        self.show_experiment();
        Ok(())
    }

    /// The 1 kHz trajectory of the trial that runs.
    pub(super) fn follow(&mut self, sample: &Sample) {
        if sample.fault != 0 {
            return self.interrupt_once();
        }
        let Some(running) = &mut self.experiment else { return };
        let (Some(since), Some((_, file))) = (running.since, &mut running.trajectory) else { return };
        let written = file.write(&Sample { time: sample.time - since, ..*sample });
        if let Err(why) = written {
            running.discard_trajectory();
            self.say(Tone::Error, "experiment", format!("the trajectory of this trial is lost: {why}"));
        }
    }

    fn interrupt_once(&mut self) {
        if self.experiment.as_ref().is_some_and(|running| running.armed) {
            self.interrupt();
        }
    }

    pub(super) fn show_experiment(&mut self) {
        let sim = self.shared.known(|known| known.sim);
        let now = self.experiment.as_ref().map(|running| Shown {
            waits: running.waits(sim).to_owned(),
            armed: running.armed,
            running: running.since.is_some(),
            last: running.last.clone(),
            ..Shown::new(&running.name, &running.task)
        });
        self.shared.known(|known| known.experiment = now);
        self.dirty = true;
        self.tell(true);
    }
}
