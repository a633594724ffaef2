//! What a rig is made of. Settings are checked once, by [`RigConfig::validate`], before a rig is built.

use crate::{Bench, Calibration, Wiring};
use friction::{Invalid, in_range};

/// How the block hangs on the device.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Coupling {
    /// Device and block are one body (the thesis: "stiff in the axial direction").
    Rigid,
    /// Two masses joined by a spring and a damper; the load cell measures the force in them.
    Compliant {
        /// k, N/m.
        stiffness: f64,
        /// c, N·s/m.
        damping: f64,
    },
}

/// Errors of one analogue sensor: reading = true · `gain` + `offset` + noise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sensor {
    /// Standard deviation of white Gaussian noise on each sample, SI.
    pub noise: f64,
    /// Factor on the true value, 1 when calibrated.
    pub gain: f64,
    /// Added to the true value, SI.
    pub offset: f64,
}

/// Configuration of the rig. `default()` is the rig of the thesis, tables 3-1 and 3-2, with an aluminium
/// block coupled rigidly.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RigConfig {
    /// Equivalent inertia of motor and slide, kg (table 3-1).
    pub device_mass: f64,
    /// Viscous damping of motor and slide, N·s/m: b of eq. 4.14.
    pub device_damping: f64,
    /// The device's own Coulomb friction against forward motion, N (table 3-1). 0: none.
    pub device_friction_p: f64,
    /// The device's own Coulomb friction against reverse motion, N (table 3-1). 0: none.
    pub device_friction_n: f64,
    /// Mass of the block, kg. 0: no block, the handle is free and the law is not asked.
    pub block_mass: f64,
    /// Mass of the handle beyond the load cell while there is no block on it, kg; a part of `device_mass`.
    pub handle_mass: f64,
    /// Normal load on the block's surface, N. `None`: the weight of the block.
    pub normal_load: Option<f64>,
    /// Connection between device and block.
    pub coupling: Coupling,
    /// Force at which the actuator saturates, N (table 3-1). `None`: never.
    pub force_max: Option<f64>,
    /// Control periods between the call that gives a command and its acting on the device. 1: a command
    /// computed from the samples at t(k) acts from t(k+1) to t(k+2). 0 to 8.
    pub actuation_delay: u32,
    /// Distance between the hard stops, m, centred on position 0. `None`: no stops.
    pub stroke: Option<f64>,
    /// Stiffness of a hard stop, N/m.
    pub stop_stiffness: f64,
    /// Damping of a hard stop while it is pressed, N·s/m. It pushes only, never pulls.
    pub stop_damping: f64,
    /// Control period, timer ticks: 170 000 at 170 MHz is 1 ms.
    pub period_ticks: u32,
    /// Integration steps in a control period, at least 10.
    pub substeps: u32,
    /// Standard deviation of the sampling instant around its nominal time, timer ticks. The time stamp
    /// tells the true instant; it is limited to a quarter of a substep.
    pub clock_jitter_ticks: f64,
    /// Codes, counts and ticks.
    pub calibration: Calibration,
    /// Load cell between device and block (table 3-2), N.
    pub load: Sensor,
    /// Accelerometer on the device (table 3-2), m/s².
    pub accel: Sensor,
    /// Where the handle is at t = 0, m.
    pub start_position: f64,
    /// Mistakes of wiring.
    pub wiring: Wiring,
    /// What is put on the sensors for a calibration.
    pub bench: Bench,
}

impl RigConfig {
    /// The thesis's rig with ideal sensors: no noise, no quantisation finer than the codes can carry.
    #[must_use]
    pub fn noiseless() -> Self {
        let ideal = Sensor { noise: 0.0, gain: 1.0, offset: 0.0 };
        Self { load: ideal, accel: ideal, ..Self::default() }
    }

    /// The thesis's rig without block and without friction of its own: a mass and a damper.
    #[must_use]
    pub fn free_handle() -> Self {
        Self {
            block_mass: 0.0,
            device_friction_p: 0.0,
            device_friction_n: 0.0,
            // assumed: a knob in the place of the block
            handle_mass: 0.05,
            ..Self::default()
        }
    }

    /// Length of a control period, s.
    #[must_use]
    pub fn period(&self) -> f64 {
        f64::from(self.period_ticks) / f64::from(self.calibration.tick_hz)
    }

    /// Length of an integration step, s.
    #[must_use]
    pub fn substep(&self) -> f64 {
        self.period() / f64::from(self.substeps)
    }

    /// Checks every parameter, and that the stiffest spring is integrated stably.
    ///
    /// # Errors
    /// The first parameter out of range, with the range that would be accepted.
    pub fn validate(&self) -> Result<(), Invalid> {
        in_range("device_mass", self.device_mass, 1e-3, 1e3)?;
        in_range("device_damping", self.device_damping, 0.0, 1e4)?;
        in_range("device_friction_p", self.device_friction_p, 0.0, 1e3)?;
        in_range("device_friction_n", self.device_friction_n, 0.0, 1e3)?;
        in_range("block_mass", self.block_mass, 0.0, 1e3)?;
        in_range("handle_mass", self.handle_mass, 0.0, self.device_mass)?;
        if let Some(normal_load) = self.normal_load {
            in_range("normal_load", normal_load, 0.0, 1e5)?;
        }
        if let Some(force_max) = self.force_max {
            in_range("force_max", force_max, 0.0, 1e4)?;
        }
        in_range("actuation_delay", f64::from(self.actuation_delay), 0.0, 8.0)?;
        in_range("period_ticks", f64::from(self.period_ticks), 1e3, 1e8)?;
        in_range("substeps", f64::from(self.substeps), 10.0, 10_000.0)?;
        in_range("tick_hz", f64::from(self.calibration.tick_hz), 1e5, 4e9)?;
        in_range("metre_per_count", self.calibration.metre_per_count, 1e-9, 1.0)?;
        in_range("clock_jitter_ticks", self.clock_jitter_ticks, 0.0, 1e6)?;
        for (channel, names) in [
            (self.calibration.load, ["load.offset_code", "load.unit_per_code"]),
            (self.calibration.accel, ["accel.offset_code", "accel.unit_per_code"]),
        ] {
            in_range(names[0], channel.offset_code, 0.0, 65_535.0)?;
            in_range(names[1], channel.unit_per_code, 1e-12, 1e6)?;
        }
        for (sensor, names) in [
            (self.load, ["load.noise", "load.gain", "load.offset"]),
            (self.accel, ["accel.noise", "accel.gain", "accel.offset"]),
        ] {
            in_range(names[0], sensor.noise, 0.0, 1e6)?;
            in_range(names[1], sensor.gain, -1e3, 1e3)?;
            in_range(names[2], sensor.offset, -1e6, 1e6)?;
        }
        in_range("start_position", self.start_position, -1e3, 1e3)?;
        in_range("bench.weight", self.bench.weight, -1e4, 1e4)?;
        in_range("bench.gravity", self.bench.gravity, -1e3, 1e3)?;
        self.validate_springs()
    }

    /// A spring is integrated stably while ω·h < 2; half of that keeps its frequency right, too.
    fn validate_springs(&self) -> Result<(), Invalid> {
        let h = self.substep();
        let rigid = self.block_mass == 0.0 || self.coupling == Coupling::Rigid;
        let handle_mass = if rigid { self.device_mass + self.block_mass } else { self.device_mass };
        if let Some(stroke) = self.stroke {
            in_range("stroke", stroke, 1e-6, 1e3)?;
            in_range("stop_stiffness", self.stop_stiffness, 0.0, handle_mass / (h * h))?;
            in_range("stop_damping", self.stop_damping, 0.0, 0.5 * handle_mass / h)?;
        }
        if let (false, Coupling::Compliant { stiffness, damping }) = (rigid, self.coupling) {
            let reduced = self.device_mass * self.block_mass / (self.device_mass + self.block_mass);
            in_range("coupling.stiffness", stiffness, 0.0, reduced / (h * h))?;
            in_range("coupling.damping", damping, 0.0, 0.5 * reduced / h)?;
            in_range("block_mass", self.block_mass, 1e-3, 1e3)?;
        }
        Ok(())
    }
}

impl Default for RigConfig {
    fn default() -> Self {
        Self {
            device_mass: 0.692,
            // the thesis calls it "a small amount" and gives no number for the rig; this keeps the
            // τ = m/b = 0.1 s of its simulated device, as `haptics` assumes
            device_damping: 6.92,
            device_friction_p: 1.04,
            device_friction_n: 0.69,
            block_mass: 0.419,
            handle_mass: 0.0,
            normal_load: None,
            coupling: Coupling::Rigid,
            force_max: Some(9.48),
            actuation_delay: 1,
            stroke: Some(0.032),
            // steel on a thin pad: the actuator at full force along the whole stroke presses it in 0.8 mm
            stop_stiffness: 5e5,
            stop_damping: 600.0,
            period_ticks: 170_000,
            substeps: 20,
            clock_jitter_ticks: 0.0,
            calibration: Calibration::thesis(),
            load: Sensor { noise: 0.062, gain: 1.0, offset: 0.0 },
            accel: Sensor { noise: 0.2379, gain: 1.0, offset: 0.0 },
            start_position: 0.0,
            wiring: Wiring::default(),
            bench: Bench::default(),
        }
    }
}
