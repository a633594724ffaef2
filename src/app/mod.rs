//! The application: what runs in the control interrupt, what runs in the tasks, and the queues between them.

mod answer;
mod calibrate;
mod control_loop;
mod desk;
mod listing;
mod output;
mod selftest;
mod stream;

pub use control_loop::ControlLoop;
pub use desk::Desk;
pub use output::Output;

use haptics::{Config, Denied, FaultKind, Inputs, ModeId, Number, Outputs, Request};
use heapless_spsc::spsc::{Consumer, Producer, Queue};

/// One control period, for the tasks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Telemetry {
    /// Number of the control step; wraps.
    pub step: u32,
    /// What went in.
    pub inputs: Inputs,
    /// What came out.
    pub outputs: Outputs,
}

/// A fault, with the moment of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FaultReport {
    /// The first fault.
    pub kind: FaultKind,
    /// Control step that found it.
    pub step: u32,
    /// State of the machine before.
    pub during: ModeId,
    /// Handle position then, m.
    pub position: f32,
    /// Handle velocity then, m/s.
    pub velocity: f32,
    /// Force commanded in the step before, N.
    pub force: f32,
}

/// The first fault of before the last reset.
#[derive(Debug, Clone, PartialEq)]
pub struct Earlier {
    /// What was found, and the motion it was found at; for what no step could find, the motion of the last step.
    pub fault: FaultReport,
    /// End of the path and line, if it was a panic.
    pub panicked_at: Option<(heapless::String<40>, u32)>,
}

// Places of the queues: one more than may wait. Powers of two where it does not matter, for the sake of the interrupt.

/// Telemetry that waits for the tasks: what they may be behind, control periods.
const TELEMETRY: usize = 32;
/// Requests that may wait.
const REQUESTS: usize = 4;
/// The configuration in use and the one that replaces it: no more.
const CONFIGS: usize = 3;
/// Answers, faults and numbers of an identification that may wait. In queues of their own: a small item costs the
/// interrupt a tenth of what one costs that is as large as the largest.
const ANSWERS: usize = 4;
const FAULTS: usize = 4;
const NUMBERS: usize = 8;

/// The queues between interrupt and tasks; lock-free, one writer and one reader each.
#[derive(Default)]
pub struct Queues {
    configs: Queue<Config, CONFIGS>,
    requests: Queue<Request, REQUESTS>,
    answers: Queue<Option<Denied>, ANSWERS>,
    faults: Queue<FaultReport, FAULTS>,
    numbers: Queue<Number, NUMBERS>,
    telemetry: Queue<Telemetry, TELEMETRY>,
}

impl Queues {
    /// The ends for the interrupt and for the tasks.
    pub fn split(&mut self) -> (ControlEnds<'_>, DeskEnds<'_>) {
        let (configure, configs) = self.configs.split();
        let (ask, requests) = self.requests.split();
        let (answer, answers) = self.answers.split();
        let (report, faults) = self.faults.split();
        let (identified, numbers) = self.numbers.split();
        let (tell, telemetry) = self.telemetry.split();
        (
            ControlEnds { configs, requests, answer, report, identified, tell },
            DeskEnds { configure, ask, answers, faults, numbers, telemetry },
        )
    }
}

/// The interrupt's ends.
pub struct ControlEnds<'q> {
    /// The first is in use where it lies: a swap copies nothing.
    configs: Consumer<'q, Config, CONFIGS>,
    requests: Consumer<'q, Request, REQUESTS>,
    /// The request was handled; why it was not obeyed.
    answer: Producer<'q, Option<Denied>, ANSWERS>,
    /// A fault was latched.
    report: Producer<'q, FaultReport, FAULTS>,
    /// An identification is complete: its numbers, one a period.
    identified: Producer<'q, Number, NUMBERS>,
    tell: Producer<'q, Telemetry, TELEMETRY>,
}

/// The tasks' ends.
pub struct DeskEnds<'q> {
    configure: Producer<'q, Config, CONFIGS>,
    ask: Producer<'q, Request, REQUESTS>,
    answers: Consumer<'q, Option<Denied>, ANSWERS>,
    faults: Consumer<'q, FaultReport, FAULTS>,
    numbers: Consumer<'q, Number, NUMBERS>,
    telemetry: Consumer<'q, Telemetry, TELEMETRY>,
}
