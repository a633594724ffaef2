//! What really happened, beside what the sensors say.

/// The noise-free state of the rig at the last sampling instant. Forces are those just before it, while the
/// command of the period that ended was still acting.
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
    /// Position of the block, m; that of the handle when coupled rigidly or when there is no block.
    pub block_position: f64,
    /// Velocity of the block, m/s.
    pub block_velocity: f64,
    /// Force that acted between device and block, N: m_block·a + friction of the block. Without a block the handle
    /// is in its place: m_handle·a less the force of the hand on it.
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
    /// The block rests and its friction holds it.
    pub stuck: bool,
    /// Work done by the actuator since the start, J.
    pub actuator_work: f64,
    /// Work done by the hand since the start, J.
    pub hand_work: f64,
    /// Work taken by both frictions since the start, J. A law with a spring in it stores part of this.
    pub friction_work: f64,
    /// Forces (command, hand, law) that were not finite and were taken as 0 N, since the start. Anything
    /// but 0 means that the run is not to be trusted.
    pub not_finite: u64,
}

/// What the controller gets: raw codes and time stamps, the same meaning as on the board.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Sensors {
    /// When the sample was taken, ticks of the free-running timer; wraps.
    pub sample_ticks: u32,
    /// Quadrature count; wraps.
    pub count: u32,
    /// When the last encoder edge passed, ticks of the same timer; wraps. 0 before the first edge.
    pub edge_ticks: u32,
    /// Load cell code.
    pub load_code: u16,
    /// Accelerometer code.
    pub accel_code: u16,
}
