//! The application: the part in the control interrupt, the part in the tasks, and the queues between them.

mod answer;
mod calibrate;
mod contact;
mod control_loop;
mod desk;
mod line;
mod listing;
mod off;
mod output;
mod selftest;
mod stream;

pub use contact::{Contact, Lamp};
pub use control_loop::{Command, ControlLoop};
pub use desk::Desk;
pub use off::{Listener, OffSwitch};
pub use output::Output;

use haptics::{Config, Denied, FaultKind, Homed, Inputs, ModeId, Number, Outputs, Request};
use heapless_spsc::spsc::{Consumer, Producer, Queue};

/// One control period, for the tasks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Telemetry {
    /// Number of the control step. Wraps.
    pub step: u32,
    /// Inputs of the step.
    pub inputs: Inputs,
    /// Outputs of the step.
    pub outputs: Outputs,
}

/// Result of a request.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Handled {
    /// Reason of a denial.
    pub denied: Option<Denied>,
    /// Mode before the request.
    pub during: ModeId,
}

/// A new origin of the position, or the end of a search for it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OriginReport {
    /// Control step from which on it holds.
    pub step: u32,
    /// Encoder count at position 0.
    pub origin: u32,
    /// Result of the search that ended.
    pub homed: Option<Homed>,
}

/// A fault with its time and motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FaultReport {
    /// The first fault.
    pub kind: FaultKind,
    /// Control step that found it.
    pub step: u32,
    /// Mode before the fault.
    pub during: ModeId,
    /// Handle position at that time, m.
    pub position: f32,
    /// Handle velocity at that time, m/s.
    pub velocity: f32,
    /// Force commanded in the previous step, N.
    pub force: f32,
}

/// The first fault before the last reset.
#[derive(Debug, Clone, PartialEq)]
pub struct Earlier {
    /// The fault with its motion; for a fault outside a step, the motion of the last step.
    pub fault: FaultReport,
    /// End of the path, and the line, of a panic.
    pub panicked_at: Option<(heapless::String<40>, u32)>,
    /// Program counter, return address and fault status (CFSR) of a crash.
    pub crashed_at: Option<[u32; 3]>,
}

// Sizes of the queues: one more than may wait. Powers of two where possible, which is faster in the interrupt.

/// Telemetry for the tasks: largest lag, control periods.
const TELEMETRY: usize = 32;
/// Waiting requests.
const REQUESTS: usize = 4;
/// The configuration in use and its successor, and a place that saves the step a remainder by three.
const CONFIGS: usize = 4;
/// Waiting answers, faults and numbers of an identification. In separate queues: a small item costs the interrupt a tenth of
/// the largest one.
const ANSWERS: usize = 4;
const FAULTS: usize = 4;
const NUMBERS: usize = 8;
const ORIGINS: usize = 4;

/// Queues between interrupt and tasks, lock-free with one writer and one reader each.
#[derive(Default)]
pub struct Queues {
    configs: Queue<Config, CONFIGS>,
    requests: Queue<Request, REQUESTS>,
    answers: Queue<Handled, ANSWERS>,
    faults: Queue<FaultReport, FAULTS>,
    numbers: Queue<Number, NUMBERS>,
    origins: Queue<OriginReport, ORIGINS>,
    telemetry: Queue<Telemetry, TELEMETRY>,
    off: OffSwitch,
}

impl Queues {
    /// The way of `off` past all queues.
    #[must_use]
    pub fn off(&self) -> &OffSwitch {
        &self.off
    }

    /// Splits into the ends for the interrupt and for the tasks.
    pub fn split(&mut self) -> (ControlEnds<'_>, DeskEnds<'_>) {
        let (configure, configs) = self.configs.split();
        let (ask, requests) = self.requests.split();
        let (answer, answers) = self.answers.split();
        let (report, faults) = self.faults.split();
        let (identified, numbers) = self.numbers.split();
        let (refer, origins) = self.origins.split();
        let (tell, telemetry) = self.telemetry.split();
        (
            ControlEnds { configs, requests, answer, report, identified, refer, tell, off: &self.off },
            DeskEnds { configure, ask, answers, faults, numbers, origins, telemetry, off: &self.off },
        )
    }
}

/// Ends of the queues in the interrupt.
pub struct ControlEnds<'q> {
    /// Configurations. The first is used in place: a swap copies nothing.
    configs: Consumer<'q, Config, CONFIGS>,
    requests: Consumer<'q, Request, REQUESTS>,
    answer: Producer<'q, Handled, ANSWERS>,
    /// Latched faults.
    report: Producer<'q, FaultReport, FAULTS>,
    /// Numbers of a completed identification, one per period.
    identified: Producer<'q, Number, NUMBERS>,
    /// New origins, and results of searches for them.
    refer: Producer<'q, OriginReport, ORIGINS>,
    tell: Producer<'q, Telemetry, TELEMETRY>,
    off: &'q OffSwitch,
}

/// Ends of the queues in the tasks.
pub struct DeskEnds<'q> {
    configure: Producer<'q, Config, CONFIGS>,
    ask: Producer<'q, Request, REQUESTS>,
    answers: Consumer<'q, Handled, ANSWERS>,
    faults: Consumer<'q, FaultReport, FAULTS>,
    numbers: Consumer<'q, Number, NUMBERS>,
    origins: Consumer<'q, OriginReport, ORIGINS>,
    telemetry: Consumer<'q, Telemetry, TELEMETRY>,
    off: &'q OffSwitch,
}

impl<'q> DeskEnds<'q> {
    /// The way of `off` past all queues.
    #[must_use]
    pub fn off(&self) -> &'q OffSwitch {
        self.off
    }
}
