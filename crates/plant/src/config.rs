//! Configuration of a rig. [`RigConfig::validate`] checks it once, before a rig is built.

use crate::{Bench, Calibration, Wiring};
use friction::{Invalid, in_range};

/// Connection of the block to the device.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Coupling {
    /// Device and block are one body: "stiff in the axial direction" [thesis, ch. 3.4].
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
    /// Offset of the reading, SI.
    pub offset: f64,
}

/// Configuration of the rig. `default()` is the rig of [thesis, table 3-1 and 3-2], with an aluminium
/// block coupled rigidly.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RigConfig {
    /// Equivalent inertia of motor and slide, kg [thesis, table 3-1].
    pub device_mass: f64,
    /// Viscous damping of motor and slide, N·s/m: b of [thesis, eq. 4.14].
    pub device_damping: f64,
    /// Coulomb friction of the device against forward motion, N [thesis, table 3-1]. 0 is none.
    pub device_friction_p: f64,
    /// Coulomb friction of the device against reverse motion, N [thesis, table 3-1]. 0 is none.
    pub device_friction_n: f64,
    /// Amplitude of the motor's cogging, N: −A·sin(2πx/λ) on the handle. 0 is none.
    pub device_cogging: f64,
    /// Wavelength λ of it, m.
    pub device_cogging_wavelength: f64,
    /// Mass of the block, kg. 0 is no block: the handle is free and the law is not used.
    pub block_mass: f64,
    /// Mass of the handle beyond the load cell without a block, kg. Part of `device_mass`.
    pub handle_mass: f64,
    /// Normal load on the block's surface, N. `None` is the weight of the block.
    pub normal_load: Option<f64>,
    /// Connection between device and block.
    pub coupling: Coupling,
    /// Force at which the actuator saturates, N [thesis, table 3-1]. `None` is no limit.
    pub force_max: Option<f64>,
    /// Delay of a command, control periods, 0 to 8. With 1 a command computed from the samples at t(k) acts from t(k+1) to
    /// t(k+2).
    pub actuation_delay: u32,
    /// Distance between the hard stops, m, centred on position 0. `None` is no stops.
    pub stroke: Option<f64>,
    /// Stiffness of a hard stop, N/m.
    pub stop_stiffness: f64,
    /// Damping of a hard stop, N·s/m. A stop only pushes.
    pub stop_damping: f64,
    /// Control period, timer ticks: 170 000 at 170 MHz is 1 ms.
    pub period_ticks: u32,
    /// Integration steps in a control period, at least 10.
    pub substeps: u32,
    /// Jitter of the sampling instant, timer ticks, as a standard deviation. Limited to a quarter of a substep. The time
    /// stamp is that of the true instant.
    pub clock_jitter_ticks: f64,
    /// Codes, counts and ticks.
    pub calibration: Calibration,
    /// Load cell between device and block [thesis, table 3-2], N.
    pub load: Sensor,
    /// Accelerometer on the device [thesis, table 3-2], m/s².
    pub accel: Sensor,
    /// Position of the handle at t = 0, m.
    pub start_position: f64,
    /// Wiring errors.
    pub wiring: Wiring,
    /// Loads on the sensors during a calibration.
    pub bench: Bench,
}

impl RigConfig {
    /// The rig of [thesis, table 3-1] with ideal sensors: no noise, and no quantisation beyond that of the codes.
    #[must_use]
    pub fn noiseless() -> Self {
        let ideal = Sensor { noise: 0.0, gain: 1.0, offset: 0.0 };
        Self { load: ideal, accel: ideal, ..Self::default() }
    }

    /// The rig of [thesis, table 3-1] without a block and without friction: a mass and a damper.
    #[must_use]
    pub fn free_handle() -> Self {
        Self {
            block_mass: 0.0,
            device_friction_p: 0.0,
            device_friction_n: 0.0,
            // assumed: a knob instead of the block
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

    /// Checks every parameter, and that the integration of the stiffest spring is stable.
    ///
    /// # Errors
    /// The first parameter out of range, with the range that would be accepted.
    pub fn validate(&self) -> Result<(), Invalid> {
        in_range("device_mass", self.device_mass, 1e-9, 1e3)?;
        in_range("device_damping", self.device_damping, 0.0, 1e4)?;
        in_range("device_friction_p", self.device_friction_p, 0.0, 1e3)?;
        in_range("device_friction_n", self.device_friction_n, 0.0, 1e3)?;
        in_range("device_cogging", self.device_cogging, 0.0, 1e3)?;
        in_range("device_cogging_wavelength", self.device_cogging_wavelength, 1e-4, 1e3)?;
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

    /// Integration of a spring is stable for ω·h < 2. Half of that also keeps its frequency correct.
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
            in_range("block_mass", self.block_mass, 1e-9, 1e3)?;
        }
        Ok(())
    }
}

impl Default for RigConfig {
    fn default() -> Self {
        Self {
            device_mass: 0.692,
            // not printed ("a small amount" [thesis, ch. 4.5]); gives the τ = m/b = 0.1 s of the simulated device there, as
            // in `haptics`
            device_damping: 6.92,
            device_friction_p: 1.04,
            device_friction_n: 0.69,
            device_cogging: 0.0,
            device_cogging_wavelength: 4e-3,
            block_mass: 0.419,
            handle_mass: 0.0,
            normal_load: None,
            coupling: Coupling::Rigid,
            force_max: Some(9.48),
            actuation_delay: 1,
            stroke: Some(0.032),
            // steel on a thin pad: full force along the whole stroke compresses it by 0.8 mm
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
