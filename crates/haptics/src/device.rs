//! The physical device the loop runs on: constants the control step, the checks and the bounds share.

/// One analogue channel: SI = (code − `offset_code`) · `unit_per_code`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Channel {
    /// Code that stands for zero, counts.
    pub offset_code: f32,
    /// SI units of one code step: N (load cell) or m/s² (accelerometer).
    pub unit_per_code: f32,
}

impl Channel {
    /// SI value of a raw code.
    #[must_use]
    pub fn to_si(&self, code: u16) -> f32 {
        (f32::from(code) - self.offset_code) * self.unit_per_code
    }
}

/// A 1-DOF device and its limits. `default()` is the rig of the thesis (tables 3-1, 3-2) on a 170 MHz timer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Device {
    /// Rate of the free-running timer behind every time stamp, Hz.
    pub tick_hz: u32,
    /// Control period T, s.
    pub period: f32,
    /// From a sample to the change of the force that answers it, s; what the stability bounds reckon with.
    pub delay: f32,
    /// Handle travel of one quadrature count, m.
    pub metre_per_count: f32,
    /// Equivalent inertia of motor and slide m, kg.
    pub mass: f32,
    /// Viscous damping b of eq. 4.14, N·s/m. *Assumed*: the thesis says "a small amount" and gives no number for
    /// the rig; its simulated device (m = 1 kg, b = 10 N·s/m) has τ = m/b = 0.1 s, and this keeps that τ.
    pub damping: f32,
    /// Largest force the actuator can hold, N: every command is clamped to it.
    pub force_max: f32,
    /// Load cell, N.
    pub load: Channel,
    /// Capacity of the load cell, N: identification beyond it means nothing.
    pub load_capacity: f32,
    /// Accelerometer, m/s².
    pub accel: Channel,
    /// Largest acceleration the device is built for, m/s²: an encoder that claims more has lost counts.
    pub acceleration_max: f32,
    /// Codes this close to either end of the converter (0 or 65 535) are a rail, not a reading.
    pub rail_codes: u16,
    /// Distance between the mechanical stops, m, centred on count 0.
    pub stroke: f32,
    /// Speed above which force is withdrawn, m/s. The default is beyond what the actuator alone reaches on half a
    /// stroke (0.66 m/s).
    pub overspeed: f32,
    /// Speed below which the handle counts as let go, m/s: what clearing a fault asks for.
    pub rest_speed: f32,
    /// Force on the load cell below which the handle counts as let go, N.
    pub rest_force: f32,
    /// Proportional gain of the excitation, N/m. The thesis tuned by hand and does not print it.
    pub tracking_stiffness: f32,
    /// Derivative gain of the excitation, N·s/m.
    pub tracking_damping: f32,
    /// Cut-off of the second-order low-pass on the excitation command, Hz (ch. 3.5.2).
    pub command_cutoff_hz: f32,
}

/// Control rates a board may run at, Hz; the first after a start.
pub const RATES: &[u32] = &[1_000, 2_000, 5_000, 10_000, 20_000];

impl Device {
    /// Timer ticks in a control period.
    #[must_use]
    pub fn period_ticks(&self) -> u32 {
        // `as` saturates and takes NaN to 0: whatever the constants are, this cannot fail
        (self.tick_hz as f32 * self.period + 0.5) as u32
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
            // 12-bit conversions summed 16 times end at 65 520
            rail_codes: 32,
            stroke: 0.032,
            overspeed: 1.0,
            rest_speed: 5e-3,
            rest_force: 2.0,
            tracking_stiffness: 2_500.0,
            tracking_damping: 50.0,
            command_cutoff_hz: 100.0,
        }
    }
}
