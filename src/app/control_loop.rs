//! The interrupt's side.

use super::{ControlEnds, FaultReport, Report, Telemetry};
use haptics::{Config, Control, FaultKind, Inputs, ModeId, Outputs, Request};

/// The control step with its queues. Never blocks: what finds no room is not sent, and a gap in the step numbers of
/// the telemetry shows it.
pub struct ControlLoop {
    control: Control,
    step: u32,
    mode: ModeId,
}

impl ControlLoop {
    /// At rest, force off.
    #[must_use]
    pub fn new(config: Config) -> Self {
        Self { control: Control::new(config), step: 0, mode: ModeId::Idle }
    }

    /// One control period. `raise` is a fault the board has seen; it comes before what the tasks ask.
    pub fn tick(&mut self, ends: &mut ControlEnds<'_>, inputs: &Inputs, raise: Option<FaultKind>) -> Outputs {
        let outputs = match raise {
            Some(kind) => self.control.step(Some(&Request::Raise(kind)), inputs),
            None => {
                let request = ends.requests.dequeue();
                let outputs = self.control.step(request.as_ref(), inputs);
                if request.is_some() {
                    let _ = ends.report.enqueue(Report::Handled(outputs.denied));
                }
                outputs
            }
        };
        if outputs.identified
            && let Some(sums) = self.control.state().sums()
        {
            let _ = ends.report.enqueue(Report::Identified(*sums));
        }
        if outputs.mode == ModeId::Fault
            && self.mode != ModeId::Fault
            && let Some(fault) = self.control.state().fault()
        {
            let _ = ends.report.enqueue(Report::Fault(FaultReport {
                kind: fault.kind,
                step: self.step,
                during: self.mode,
                position: fault.position,
                velocity: fault.velocity,
                force: fault.force,
            }));
        }
        self.mode = outputs.mode;
        let _ = ends.tell.enqueue(Telemetry { step: self.step, inputs: *inputs, outputs });
        self.step = self.step.wrapping_add(1);
        outputs
    }

    /// The control loop itself.
    #[must_use]
    pub fn control(&self) -> &Control {
        &self.control
    }

    /// Control steps since the start; wraps.
    #[must_use]
    pub fn steps(&self) -> u32 {
        self.step
    }
}
