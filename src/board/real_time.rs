//! The real-time side of a board, and the loop that runs on it once a control period.

use crate::app::{Command, ControlEnds, ControlLoop};
use haptics::{FaultKind, Inputs, Outputs};

/// What a control period asks of a board, in this order. Nothing here waits.
pub trait RealTime {
    /// Reads the inputs that the hardware took at the start of this period.
    fn sample(&mut self) -> Inputs;

    /// Fault that a line of the board reports as long as it lasts. It keeps the amplifier off.
    fn trouble(&mut self) -> Option<FaultKind> {
        None
    }

    /// Hands over a force, N, that comes out at the board's fixed time of the period. `None` is no force.
    fn output(&mut self, force: Option<f32>, command: &Command);

    /// Holds the amplifier on until shortly after the next period, or drops it at once.
    fn enable(&mut self, on: bool);

    /// Changes the control period from the present one on, timer ticks. Called only for a new period.
    fn pace(&mut self, period_ticks: u32);

    /// Ends the step of this number. True if the force missed its time of the period.
    fn end(&mut self, _step: u32, _inputs: &Inputs, _outputs: &Outputs) -> bool {
        false
    }
}

/// Consecutive late forces that are a fault: the bounds on stiffness and damping hold for the delay of the board, and a late
/// force comes a period later.
const LATE_STEPS: u32 = 3;

/// The control loop on a board. In this order: see [`ControlLoop`].
#[repr(C)]
pub struct RealTimeLoop<B> {
    /// The board.
    pub board: B,
    /// Fault raised in the next step.
    pending: Option<FaultKind>,
    /// Consecutive steps whose force came out late.
    late: u32,
    /// Control period, ticks.
    period_ticks: u32,
    /// Whether a fault of the board was raised in the last period.
    raised: bool,
    control: ControlLoop,
}

impl<B: RealTime> RealTimeLoop<B> {
    /// A loop on a board that runs at the period of the configuration. `fault` is raised in the first step.
    #[must_use]
    pub fn new(board: B, control: ControlLoop, fault: Option<FaultKind>) -> Self {
        let period_ticks = control.period_ticks();
        Self { board, pending: fault, late: 0, period_ticks, raised: false, control }
    }

    /// One control period.
    #[inline(always)]
    pub fn step(&mut self, ends: &mut ControlEnds<'_>) {
        let mut inputs = self.board.sample();
        let trouble = self.board.trouble();
        let raise = if trouble.is_none() {
            self.raised = false;
            self.pending.take()
        } else {
            // the periods between handle requests, which are answered and denied while the fault lasts
            self.raised = !self.raised;
            self.pending.take().or(trouble.filter(|_| self.raised))
        };
        let step = self.control.steps();
        let outputs = self.control.tick(ends, &mut inputs, raise);
        if outputs.amplifier && trouble.is_none() {
            self.board.output(Some(outputs.force), self.control.command());
            self.board.enable(true);
        } else {
            self.board.output(None, self.control.command());
            self.board.enable(false);
        }
        let period_ticks = self.control.period_ticks();
        if period_ticks != self.period_ticks {
            self.board.pace(period_ticks);
            self.period_ticks = period_ticks;
        }
        if self.board.end(step, &inputs, &outputs) {
            self.late += 1;
            if self.late >= LATE_STEPS {
                (self.late, self.pending) = (0, Some(FaultKind::LateForce));
            }
        } else {
            self.late = 0;
        }
    }

    /// The application in the loop.
    #[must_use]
    pub fn control(&self) -> &ControlLoop {
        &self.control
    }
}
