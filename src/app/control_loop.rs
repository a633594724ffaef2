//! The interrupt's side.

use super::{ControlEnds, FaultReport, Telemetry};
use haptics::streaming_identify::NUMBERS;
use haptics::{Config, FaultKind, Inputs, ModeId, Outputs, Request, State, step};

/// The control step with its queues. Never blocks: what finds no room is not sent, and a gap in the step numbers of
/// the telemetry shows it.
pub struct ControlLoop {
    /// In use until another came through the queue.
    first: Config,
    /// The first of the queue is in use.
    replaced: bool,
    period_ticks: u32,
    state: State,
    step: u32,
    mode: ModeId,
    /// Numbers of a completed identification that are still to be told.
    numbers: u16,
}

impl ControlLoop {
    /// At rest, force off.
    #[must_use]
    pub fn new(config: Config) -> Self {
        Self {
            state: State::new(config.device()),
            period_ticks: config.period_ticks(),
            first: config,
            replaced: false,
            step: 0,
            mode: ModeId::Idle,
            numbers: 0,
        }
    }

    /// One control period. `raise` is a fault the board has seen; it comes before what the tasks ask.
    pub fn tick(&mut self, ends: &mut ControlEnds<'_>, inputs: &Inputs, raise: Option<FaultKind>) -> Outputs {
        let raise = raise.map(Request::Raise);
        let configured = raise.is_none() && self.configure(ends);
        let config = if self.replaced { ends.configs.peek() } else { None }.unwrap_or(&self.first);
        if configured {
            let period_ticks = config.period_ticks();
            self.state.reconfigured(period_ticks != self.period_ticks);
            self.period_ticks = period_ticks;
        }
        let listens = raise.is_none() && !configured && ends.requests.ready();
        let asked = if listens { ends.requests.peek() } else { None };
        // a promise is kept quietly: nobody waits for its answer
        let answered = configured || asked.is_some_and(|asked| !matches!(asked, Request::HostWatch { .. }));
        let taken = asked.is_some();
        let outputs = step(config, &mut self.state, raise.as_ref().or(asked), inputs);
        if taken {
            let _ = ends.requests.dequeue();
        }
        if answered {
            let _ = ends.answer.enqueue(outputs.denied);
        }
        if outputs.identified {
            self.numbers = NUMBERS as u16;
        } else if outputs.mode == ModeId::Identifying {
            // begun anew: what was not told is gone
            self.numbers = 0;
        }
        if let Some(number) = self.numbers.checked_sub(1).and_then(|k| self.state.recorder().number(k))
            && ends.identified.enqueue(number).is_ok()
        {
            self.numbers -= 1;
        }
        if outputs.mode == ModeId::Fault
            && self.mode != ModeId::Fault
            && let Some(fault) = self.state.fault()
        {
            let report = FaultReport {
                kind: fault.kind,
                step: self.step,
                during: self.mode,
                position: fault.position,
                velocity: fault.velocity,
                force: fault.force,
            };
            let _ = ends.report.enqueue(report);
        }
        self.mode = outputs.mode;
        let _ = ends.tell.enqueue(Telemetry { step: self.step, inputs: *inputs, outputs });
        self.step = self.step.wrapping_add(1);
        outputs
    }

    /// Takes up the configuration that the tasks have sent, if there is one.
    fn configure(&mut self, ends: &mut ControlEnds<'_>) -> bool {
        let waiting = ends.configs.len() > usize::from(self.replaced);
        if waiting {
            if self.replaced {
                let _ = ends.configs.dequeue();
            }
            self.replaced = true;
        }
        waiting
    }

    /// What the loop remembers.
    #[must_use]
    pub fn state(&self) -> &State {
        &self.state
    }

    /// Timer ticks to the next step, as the configuration in use wants it.
    #[must_use]
    pub fn period_ticks(&self) -> u32 {
        self.period_ticks
    }

    /// Control steps since the start; wraps.
    #[must_use]
    pub fn steps(&self) -> u32 {
        self.step
    }
}
