//! What goes into the control step and what comes out of it.

use crate::{Denied, FaultKind, ModeId};

/// Everything the hardware latched for one control period. Raw codes: SI is made inside the step.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Inputs {
    /// Free-running timer when encoder and converters were sampled, ticks; wraps.
    pub sample_ticks: u32,
    /// Quadrature counter, two's complement; wraps.
    pub count: u32,
    /// Timer at the last encoder edge before the sample, ticks.
    pub edge_ticks: u32,
    /// Load cell, raw code.
    pub load_code: u16,
    /// Accelerometer, raw code.
    pub accel_code: u16,
}

/// Result of one control step.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Outputs {
    /// Force the actuator is told to apply to the handle, N; within ±`force_max`, 0 while `amplifier` is off.
    pub force: f32,
    /// Amplifier enable.
    pub amplifier: bool,
    /// Handle position, m.
    pub position: f32,
    /// Handle velocity, m/s (M/T estimate).
    pub velocity: f32,
    /// Reference the excitation follows, m; the handle position when there is none.
    pub reference: f32,
    /// Which state the machine is in after this step.
    pub mode: ModeId,
    /// The latched fault.
    pub fault: Option<FaultKind>,
    /// Position of the virtual block, m (the stuck point with the impedance renderer).
    pub block_position: f32,
    /// Velocity of the virtual block, m/s; exactly 0 while stuck.
    pub block_velocity: f32,
    /// The rendered contact sticks.
    pub stuck: bool,
    /// Friction force on the virtual block, N, positive against positive motion.
    pub friction: f32,
    /// The request handed to this step was not obeyed, and why.
    pub denied: Option<Denied>,
    /// True in the one step that completed an identification: its sums are in `State::recorder`.
    pub identified: bool,
}
