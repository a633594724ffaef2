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
use ringbuf::traits::SplitRef;
use ringbuf::{CachingCons, CachingProd, StaticRb};

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

/// Telemetry that waits for the tasks: what they may be behind, control periods.
const TELEMETRY: usize = 32;

/// Requests that may wait.
const REQUESTS: usize = 3;
/// The configuration in use and the one that replaces it.
const CONFIGS: usize = 2;
/// Answers, faults and numbers of an identification that may wait. In queues of their own: a small item costs the
/// interrupt a tenth of what one costs that is as large as the largest.
const ANSWERS: usize = 3;
const FAULTS: usize = 2;
const WAITING_NUMBERS: usize = 7;

/// The queues between interrupt and tasks; lock-free, one writer and one reader each.
#[derive(Default)]
pub struct Queues {
    configs: StaticRb<Config, CONFIGS>,
    requests: StaticRb<Request, REQUESTS>,
    answers: StaticRb<Option<Denied>, ANSWERS>,
    faults: StaticRb<FaultReport, FAULTS>,
    numbers: StaticRb<Number, WAITING_NUMBERS>,
    telemetry: StaticRb<Telemetry, TELEMETRY>,
}

impl Queues {
    /// The ends for the interrupt and for the tasks.
    pub fn split(&mut self) -> (ControlEnds<'_>, DeskEnds<'_>) {
        let (configure, configs) = self.configs.split_ref();
        let (ask, requests) = self.requests.split_ref();
        let (answer, answers) = self.answers.split_ref();
        let (report, faults) = self.faults.split_ref();
        let (identified, numbers) = self.numbers.split_ref();
        let (tell, telemetry) = self.telemetry.split_ref();
        (
            ControlEnds { configs, requests, answer, report, identified, tell },
            DeskEnds { configure, ask, answers, faults, numbers, telemetry },
        )
    }
}

type Producer<'q, T, const N: usize> = CachingProd<&'q StaticRb<T, N>>;
type Consumer<'q, T, const N: usize> = CachingCons<&'q StaticRb<T, N>>;

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
    identified: Producer<'q, Number, WAITING_NUMBERS>,
    tell: Producer<'q, Telemetry, TELEMETRY>,
}

/// The tasks' ends.
pub struct DeskEnds<'q> {
    configure: Producer<'q, Config, CONFIGS>,
    ask: Producer<'q, Request, REQUESTS>,
    answers: Consumer<'q, Option<Denied>, ANSWERS>,
    faults: Consumer<'q, FaultReport, FAULTS>,
    numbers: Consumer<'q, Number, WAITING_NUMBERS>,
    telemetry: Consumer<'q, Telemetry, TELEMETRY>,
}
