//! The true state of the rig, and the readings of its sensors.

/// Noise-free state of the rig at the last sampling instant. Forces are those just before it, under the command of the
/// period that ended.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Truth {
    /// Time since the start, s.
    pub time: f64,
    /// Position of the handle, m.
    pub position: f64,
    /// Velocity of the handle, m/s.
    pub velocity: f64,
    /// Acceleration of the handle, m/s².
    pub acceleration: f64,
    /// Position of the block, m. Without a block, or with a rigid coupling, that of the handle.
    pub block_position: f64,
    /// Velocity of the block, m/s.
    pub block_velocity: f64,
    /// Force between device and block, N: m_block·a + friction of the block. Without a block m_handle·a less the force of
    /// the hand.
    pub force_at_load_cell: f64,
    /// Friction of the block, N, positive against positive motion.
    pub friction: f64,
    /// Coulomb friction of the device itself, N, positive against positive motion.
    pub device_friction: f64,
    /// Force of the hand on the handle, N.
    pub hand_force: f64,
    /// Force of the actuator, N, after delay and saturation.
    pub actuator_force: f64,
    /// Force of the hard stops on the handle, N.
    pub stop_force: f64,
    /// Whether the block is at rest, held by its friction.
    pub stuck: bool,
    /// Work done by the actuator since the start, J.
    pub actuator_work: f64,
    /// Work done by the hand since the start, J.
    pub hand_work: f64,
    /// Work done against both frictions since the start, J. A law with a spring stores part of it.
    pub friction_work: f64,
    /// Number of forces (command, hand, law) that were not finite and acted as 0 N, since the start. With any value but 0
    /// the run is invalid.
    pub not_finite: u64,
}

/// Inputs of the controller: raw codes and time stamps, as on the board.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Sensors {
    /// Time of the sample, timer ticks. Wraps.
    pub sample_ticks: u32,
    /// Quadrature count. Wraps.
    pub count: u32,
    /// Time of the last encoder edge, ticks of the same timer. Wraps; 0 before the first edge.
    pub edge_ticks: u32,
    /// Load cell code.
    pub load_code: u16,
    /// Accelerometer code.
    pub accel_code: u16,
}
