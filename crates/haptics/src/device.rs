//! The physical device: constants shared by control step, checks and bounds.

/// One analogue channel: SI = (code − `offset_code`) · `unit_per_code`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Channel {
    /// Code that stands for zero, counts.
    pub offset_code: f32,
    /// SI units per code: N (load cell) or m/s² (accelerometer).
    pub unit_per_code: f32,
}

impl Channel {
    /// SI value of a raw code.
    #[must_use]
    pub fn to_si(&self, code: u16) -> f32 {
        (f32::from(code) - self.offset_code) * self.unit_per_code
    }
}

/// A 1-DOF device and its limits. `default()` is the rig of [thesis, table 3-1 and 3-2] with a 170 MHz timer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Device {
    /// Rate of the timer of all time stamps, Hz.
    pub tick_hz: u32,
    /// Control period T, s.
    pub period: f32,
    /// Delay from a sample to the force that answers it, s. Used by the stability bounds.
    pub delay: f32,
    /// Handle travel of one quadrature count, m.
    pub metre_per_count: f32,
    /// Equivalent inertia of motor and slide m, kg.
    pub mass: f32,
    /// Viscous damping b of [thesis, eq. 4.14], N·s/m. *Assumed*: the source gives no number ("a small amount"). This value
    /// keeps the τ = m/b = 0.1 s of the simulated device in [thesis, ch. 4.5] (m = 1 kg, b = 10 N·s/m).
    pub damping: f32,
    /// Largest continuous force of the actuator, N. Every command is clamped to it.
    pub force_max: f32,
    /// Load cell, N.
    pub load: Channel,
    /// Capacity of the load cell, N. Identification beyond it is invalid.
    pub load_capacity: f32,
    /// Accelerometer, m/s².
    pub accel: Channel,
    /// Largest possible acceleration, m/s². An encoder that shows more has lost counts.
    pub acceleration_max: f32,
    /// Width of the rails, codes: a code this close to 0 or 65 535 is not a reading.
    pub rail_codes: u16,
    /// Distance between the mechanical stops, m. Their middle is position 0 once the device is referenced.
    pub stroke: f32,
    /// Speed above which force is withdrawn, m/s. The default exceeds the speed that the actuator alone reaches over half a
    /// stroke, 0.66 m/s.
    pub overspeed: f32,
    /// Largest speed of a handle at rest, m/s. Clearing a fault requires it.
    pub rest_speed: f32,
    /// Largest force on the load cell of a released handle, N.
    pub rest_force: f32,
    /// Cycles of a control step that effects may take, so that its force is not late under any law.
    pub effect_cycles: u32,
    /// Proportional gain of the excitation, N/m. Not printed in [thesis, ch. 3.5.2], where it was tuned by hand.
    pub tracking_stiffness: f32,
    /// Derivative gain of the excitation, N·s/m.
    pub tracking_damping: f32,
    /// Cut-off of the second-order low-pass on the excitation command, Hz [thesis, ch. 3.5.2].
    pub command_cutoff_hz: f32,
}

/// Share of the actuator's force that a contact may use while the middle of the stroke is unknown: 2.8 N by default. A hand holds
/// it easily, and pushed from anywhere into a stop the handle stays below half of the overspeed.
const UNREFERENCED: f32 = 0.3;

/// Control rates of a board, Hz. The first is that after a start.
pub const RATES: &[u32] = &[1_000, 2_000, 5_000, 10_000, 20_000];

impl Device {
    /// Timer ticks in a control period.
    #[must_use]
    pub fn period_ticks(&self) -> u32 {
        // `as` saturates and maps NaN to 0: this cannot fail for any constants
        (self.tick_hz as f32 * self.period + 0.5) as u32
    }

    /// Largest force of a rendered contact while the middle of the stroke is unknown, N.
    #[must_use]
    pub fn unreferenced_force(&self) -> f32 {
        UNREFERENCED * self.force_max
    }
}

impl Default for Device {
    fn default() -> Self {
        Self {
            tick_hz: 170_000_000,
            period: 1e-3,
            delay: 0.0,
            metre_per_count: 2.57e-6,
            mass: 0.692,
            damping: 6.92,
            force_max: 9.48,
            // 8.896 N/V over ±5 V on 16-bit oversampled codes, zero at mid-scale
            load: Channel { offset_code: 32_768.0, unit_per_code: 88.96 / 65_536.0 },
            load_capacity: 44.8,
            accel: Channel { offset_code: 32_768.0, unit_per_code: 100.0 * 9.806_65 / 65_536.0 },
            acceleration_max: 50.0 * 9.806_65,
            // the sum of 16 12-bit conversions is at most 65 520
            rail_codes: 32,
            stroke: 0.032,
            overspeed: 1.0,
            rest_speed: 5e-3,
            rest_force: 2.0,
            effect_cycles: 1_200,
            tracking_stiffness: 2_500.0,
            tracking_damping: 50.0,
            command_cutoff_hz: 100.0,
        }
    }
}
