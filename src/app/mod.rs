//! The application: what runs in the control interrupt, what runs in the tasks, and the queues between them.

mod answer;
mod control_loop;
mod desk;
mod listing;
mod output;
mod selftest;
mod stream;

pub use control_loop::ControlLoop;
pub use desk::Desk;
pub use output::Output;

use haptics::{Denied, FaultKind, Inputs, ModeId, Outputs, Request, Sums};
use heapless::spsc::{Consumer, Producer, Queue};

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

/// What the control loop tells besides telemetry.
#[derive(Debug, Clone, Copy, PartialEq)]
#[allow(clippy::large_enum_variant)] // no heap; rare
pub enum Report {
    /// The request was handled; why it was not obeyed.
    Handled(Option<Denied>),
    /// A fault was latched.
    Fault(FaultReport),
    /// An identification is complete.
    Identified(Sums),
}

/// Telemetry that waits for the tasks: what they may be behind, control periods.
const TELEMETRY: usize = 32;

/// The queues between interrupt and tasks; lock-free, one writer and one reader each.
#[derive(Default)]
pub struct Queues {
    requests: Queue<Request, 4>,
    reports: Queue<Report, 8>,
    telemetry: Queue<Telemetry, TELEMETRY>,
}

impl Queues {
    /// Empty ones.
    #[must_use]
    pub const fn new() -> Self {
        Self { requests: Queue::new(), reports: Queue::new(), telemetry: Queue::new() }
    }

    /// The ends for the interrupt and for the tasks.
    pub fn split(&mut self) -> (ControlEnds<'_>, DeskEnds<'_>) {
        let (ask, requests) = self.requests.split();
        let (report, reports) = self.reports.split();
        let (tell, telemetry) = self.telemetry.split();
        (ControlEnds { requests, report, tell }, DeskEnds { ask, reports, telemetry })
    }
}

/// The interrupt's ends.
pub struct ControlEnds<'q> {
    requests: Consumer<'q, Request>,
    report: Producer<'q, Report>,
    tell: Producer<'q, Telemetry>,
}

/// The tasks' ends.
pub struct DeskEnds<'q> {
    ask: Producer<'q, Request>,
    reports: Consumer<'q, Report>,
    telemetry: Consumer<'q, Telemetry>,
}
