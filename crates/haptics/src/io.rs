//! Inputs and outputs of the control step.

use crate::{Denied, FaultKind, ModeId};

/// Readings that the hardware latched for one control period, in raw codes. The step converts them to SI.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Inputs {
    /// Time of the sample, ticks of the free-running timer. Wraps.
    pub sample_ticks: u32,
    /// Quadrature count, two's complement. Wraps.
    pub count: u32,
    /// Time of the last encoder edge before the sample, ticks.
    pub edge_ticks: u32,
    /// Load cell, raw code.
    pub load_code: u16,
    /// Accelerometer, raw code.
    pub accel_code: u16,
}

impl Inputs {
    /// Highest code of a converter: the sum of 16 12-bit conversions.
    pub const TOP_CODE: u16 = 16 * 4_095;
}

/// Result of one control step.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Outputs {
    /// Commanded force on the handle, N. Within ±`force_max`; 0 while `amplifier` is off.
    pub force: f32,
    /// Amplifier enable.
    pub amplifier: bool,
    /// Handle position, m. From the middle of the stroke if `referenced`, otherwise from where the count began.
    pub position: f32,
    /// Handle velocity, m/s (M/T estimate).
    pub velocity: f32,
    /// Reference of the excitation, m. The handle position without one.
    pub reference: f32,
    /// Mode after this step.
    pub mode: ModeId,
    /// The latched fault.
    pub fault: Option<FaultKind>,
    /// Whether the middle of the stroke is known after this step. The position of a step that changes it counts from the old
    /// origin.
    pub referenced: bool,
    /// Position of the virtual block, m; with the impedance renderer, the stuck point.
    pub block_position: f32,
    /// Velocity of the virtual block, m/s. Exactly 0 while stuck.
    pub block_velocity: f32,
    /// Whether the rendered contact sticks.
    pub stuck: bool,
    /// Friction force on the virtual block, N, positive against positive motion.
    pub friction: f32,
    /// Reason why the request of this step was denied.
    pub denied: Option<Denied>,
    /// True in the step that completes an identification. Its sums are in `State::recorder`.
    pub identified: bool,
}
