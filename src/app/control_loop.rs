//! The application in the control interrupt.

use super::{ControlEnds, FaultReport, Handled, OriginReport, Telemetry};
use haptics::streaming_identify::NUMBERS;
use haptics::{Config, Denied, Device, FaultKind, Inputs, ModeId, Outputs, Request, State, step};

/// How a force becomes a code of the output.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Command {
    /// Code of no force.
    pub zero: f32,
    /// The same and a half: what is cut off above it is rounded. Here, because a step has no cycle to spare.
    pub to_round: f32,
    /// Newtons per code, negative if the amplifier is reversed.
    pub newton_per_code: f32,
    /// The inverse.
    pub code_per_newton: f32,
}

impl Command {
    fn of(device: &Device) -> Self {
        let newton_per_code = device.command.unit_per_code;
        let zero = device.command.offset_code;
        Self { zero, to_round: zero + 0.5, newton_per_code, code_per_newton: 1.0 / newton_per_code }
    }
}

/// The control step with its queues. Never blocks: telemetry that finds no room is dropped, which shows as a gap in the step
/// numbers.
// In this order: what every step uses is within the reach of a load with an offset; behind the sums of the state it was not,
// which cost 20 cycles.
#[repr(C)]
pub struct ControlLoop {
    /// Whether the first configuration of the queue is in use.
    replaced: bool,
    period_ticks: u32,
    /// The encoder counts backwards.
    reversed: bool,
    command: Command,
    step: u32,
    mode: ModeId,
    /// Origin of the last report.
    origin: u32,
    /// Numbers of a completed identification that are still to be sent.
    numbers: u16,
    /// Waiting requests that `off` overtook.
    overtaken: usize,
    /// Configuration until the first one arrives through the queue.
    first: Config,
    state: State,
}

impl ControlLoop {
    /// A loop at rest with the force off.
    #[must_use]
    pub fn new(config: Config) -> Self {
        Self {
            state: State::new(config.device()),
            period_ticks: config.period_ticks(),
            reversed: config.device().encoder_reversed,
            command: Command::of(config.device()),
            first: config,
            replaced: false,
            step: 0,
            mode: ModeId::Idle,
            origin: 0,
            numbers: 0,
            overtaken: 0,
        }
    }

    /// The same, on a device whose count 0 is the middle of the stroke.
    #[must_use]
    pub fn referenced(config: Config) -> Self {
        Self { state: State::referenced(config.device()), ..Self::new(config) }
    }

    /// One control period. Turns the count of the inputs round if the encoder is reversed. `raise` is a fault found by the board; it
    /// precedes `off`, which precedes requests of the tasks.
    #[inline(always)]
    pub fn tick(
        &mut self,
        ends: &mut ControlEnds<'_>,
        inputs: &mut Inputs,
        raise: Option<FaultKind>,
    ) -> Outputs {
        let raise = raise.map(Request::Raise);
        let off = raise.is_none() && ends.off.obey();
        if off {
            self.overtaken = ends.requests.len();
            ends.off.has_ended(self.mode);
        }
        let configured = raise.is_none() && !off && self.configure(ends);
        let config = if self.replaced { ends.configs.peek() } else { None }.unwrap_or(&self.first);
        if configured {
            let period_ticks = config.period_ticks();
            self.state.reconfigured(period_ticks != self.period_ticks);
            self.period_ticks = period_ticks;
            let device = config.device();
            (self.reversed, self.command) = (device.encoder_reversed, Command::of(device));
        }
        if self.reversed {
            inputs.count = inputs.count.wrapping_neg();
        }
        let listens = raise.is_none() && !off && !configured && ends.requests.ready();
        let asked = if listens { ends.requests.peek() } else { None };
        let overtaken = asked.is_some() && self.overtaken > 0;
        // a promise and an alarm have no answer
        let answered = configured
            || asked.is_some_and(|asked| !matches!(asked, Request::HostWatch { .. } | Request::Raise(_)));
        let taken = asked.is_some();
        let request = if off { Some(&Request::Off) } else { raise.as_ref() };
        let request = request.or(if overtaken { None } else { asked });
        let outputs = step(config, &mut self.state, request, inputs);
        if answered {
            let denied = if overtaken { Some(Denied::SwitchedOff) } else { outputs.denied };
            let _ = ends.answer.enqueue(Handled { denied, during: self.mode });
        }
        if taken {
            let _ = ends.requests.dequeue();
            self.overtaken = self.overtaken.saturating_sub(1);
            // `zero` changes the origin, not the mode
            self.tell_change(ends, &outputs);
        }
        if outputs.identified {
            self.numbers = NUMBERS as u16;
        } else if outputs.mode == ModeId::Identifying {
            // restarted: unsent numbers are discarded
            self.numbers = 0;
        }
        if let Some(number) = self.numbers.checked_sub(1).and_then(|k| self.state.recorder().number(k))
            && ends.identified.enqueue(number).is_ok()
        {
            self.numbers -= 1;
        }
        if outputs.mode != self.mode {
            self.tell_change(ends, &outputs);
        }
        let _ = ends.tell.enqueue(Telemetry { step: self.step, inputs: *inputs, outputs });
        self.step = self.step.wrapping_add(1);
        outputs
    }

    /// Reports a fault, and the origin if it is another. Out of the way of a contact.
    #[inline(never)]
    fn tell_change(&mut self, ends: &mut ControlEnds<'_>, outputs: &Outputs) {
        let changed = outputs.mode != self.mode;
        let mut homed = None;
        if let (true, ModeId::Fault, Some(fault)) = (changed, outputs.mode, self.state.fault()) {
            let report = FaultReport {
                kind: fault.kind,
                step: self.step,
                during: self.mode,
                position: fault.position,
                velocity: fault.velocity,
                force: fault.force,
            };
            let _ = ends.report.enqueue(report);
        } else if changed && self.mode == ModeId::Homing {
            homed = Some(self.state.homed());
        }
        let origin = self.state.origin();
        if homed.is_some() || origin != self.origin {
            let _ = ends.refer.enqueue(OriginReport { step: self.step, origin, homed });
        }
        (self.mode, self.origin) = (outputs.mode, origin);
    }

    /// Switches to the configuration that the tasks have sent, if any.
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

    /// State of the loop.
    #[must_use]
    pub fn state(&self) -> &State {
        &self.state
    }

    /// How the force of the last step becomes a code of the output.
    #[must_use]
    pub fn command(&self) -> &Command {
        &self.command
    }

    /// Timer ticks to the next step, from the present configuration.
    #[must_use]
    pub fn period_ticks(&self) -> u32 {
        self.period_ticks
    }

    /// Control steps since the start. Wraps.
    #[must_use]
    pub fn steps(&self) -> u32 {
        self.step
    }
}
