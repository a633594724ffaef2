//! The physical device: constants shared by control step, checks and bounds.
//!
//! On a rotary device every length is an angle: read rad for m, N·m for N and kg·m² for kg.

use crate::Compensation;
use friction::Geometry;

/// One analogue channel: SI = (code − `offset_code`) · `unit_per_code`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Channel {
    /// Code that stands for zero, counts.
    pub offset_code: f32,
    /// SI units per code: N (load cell, force command) or m/s² (accelerometer). Negative: the signal is reversed.
    pub unit_per_code: f32,
}

impl Channel {
    /// SI value of a raw code.
    #[must_use]
    pub fn to_si(&self, code: u16) -> f32 {
        (f32::from(code) - self.offset_code) * self.unit_per_code
    }
}

/// Channels as in the data sheets.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sheet {
    /// Force command.
    pub command: Channel,
    /// Load cell.
    pub load: Channel,
    /// Accelerometer.
    pub accel: Channel,
}

impl Sheet {
    /// Those of the rig of [thesis, table 3-1].
    pub const RIG: Self = Self {
        // ±11 N over the 3.3 V of the output, no force at half of them
        command: Channel { offset_code: 2_048.0, unit_per_code: 11.0 / 2_048.0 },
        // 8.896 N/V over ±5 V on 16-bit oversampled codes, zero at mid-scale
        load: Channel { offset_code: 32_768.0, unit_per_code: 88.96 / 65_536.0 },
        accel: Channel { offset_code: 32_768.0, unit_per_code: 100.0 * 9.806_65 / 65_536.0 },
    };
}

/// A 1-DOF device and its limits. `default()` is the rig of [thesis, table 3-1 and 3-2] with a 170 MHz timer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Device {
    /// Slide or axis.
    pub geometry: Geometry,
    /// Rate of the timer of all time stamps, Hz.
    pub tick_hz: u32,
    /// Control period T, s.
    pub period: f32,
    /// Delay from a sample to the force that answers it, s. Used by the stability bounds.
    pub delay: f32,
    /// Handle travel of one quadrature count, m.
    pub metre_per_count: f32,
    /// Whether the encoder counts down in the positive direction. The control loop turns it round.
    pub encoder_reversed: bool,
    /// Equivalent inertia of motor and slide m, kg.
    pub mass: f32,
    /// Viscous damping b of [thesis, eq. 4.14], N·s/m. *Assumed*: the source gives no number ("a small amount"). This value
    /// keeps the τ = m/b = 0.1 s of the simulated device in [thesis, ch. 4.5] (m = 1 kg, b = 10 N·s/m).
    pub damping: f32,
    /// Largest continuous force of the actuator, N. Every command is clamped to it.
    pub force_max: f32,
    /// Force command, N: 12-bit codes of the output, with its amplifier.
    pub command: Channel,
    /// Load cell, N.
    pub load: Channel,
    /// Accelerometer, m/s².
    pub accel: Channel,
    /// The same three as in the data sheets: what a calibration is compared with.
    pub sheet: Sheet,
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
    /// Cycles of a control step that a dear law and effects may take, so that its force is not late under any law.
    pub effect_cycles: u32,
    /// Proportional gain of the excitation, N/m. Not printed in [thesis, ch. 3.5.2], where it was tuned by hand.
    pub tracking_stiffness: f32,
    /// Derivative gain of the excitation, N·s/m.
    pub tracking_damping: f32,
    /// What was found of the device and is fed forward while it renders.
    pub compensation: Compensation,
    /// Cut-off of the second-order low-pass on the excitation command, Hz [thesis, ch. 3.5.2].
    pub command_cutoff_hz: f32,
    /// Reference of both converters, V: the codes of all channels are at this supply.
    pub supply: f32,
}

/// Share of the actuator's force that a contact may use while the middle of the stroke is unknown: 2.8 N by default. A hand holds
/// it easily, and pushed from anywhere into a stop the handle stays below half of the overspeed.
const UNREFERENCED: f32 = 0.3;

/// Supply of data sheets, settings and stored calibrations, V.
pub const NOMINAL_SUPPLY: f32 = 3.3;

/// Control rates of a board, Hz. The first is that after a start.
pub const RATES: &[u32] = &[1_000, 2_000, 5_000, 10_000, 20_000];

impl Device {
    /// A length of the default device on this one, m: the same share of the stroke.
    #[must_use]
    pub fn length(&self, of_default: f32) -> f32 {
        self.stroke * (of_default / STROKE)
    }

    /// A speed of the default device on this one, m/s: the same share of the overspeed.
    #[must_use]
    pub fn speed(&self, of_default: f32) -> f32 {
        self.overspeed * (of_default / OVERSPEED)
    }

    /// A force of the default device on this one, N: the same share of the largest force.
    #[must_use]
    pub fn force(&self, of_default: f32) -> f32 {
        self.force_max * (of_default / FORCE_MAX)
    }

    /// A mass of the default device on this one, kg. Stiffness and damping that keep their time constants scale alike.
    #[must_use]
    pub fn inertia(&self, of_default: f32) -> f32 {
        self.mass * (of_default / MASS)
    }

    /// A stiffness of the default device on this one, N/m: the same share of force over stroke.
    #[must_use]
    pub fn stiffness(&self, of_default: f32) -> f32 {
        self.force(of_default) / (self.stroke / STROKE)
    }

    /// Distance beyond a stop, m, at which a driven handle faults: before it.
    #[must_use]
    pub fn driven_margin(&self) -> f32 {
        self.length(-0.5e-3)
    }

    /// The same of a handle that is held, which reaches the stops in normal use: beyond them.
    #[must_use]
    pub fn held_margin(&self) -> f32 {
        self.length(1e-3)
    }

    /// The same device with converters at another supply, V: a voltage at a pin has another code.
    ///
    /// ```
    /// let nominal = haptics::Device::default();
    /// let low = nominal.at_supply(3.2);
    /// // 1 V at the load cell's pin, as each converter codes it
    /// let [a, b] = [(nominal, 3.3), (low, 3.2)].map(|(d, volt)| d.load.to_si((65_536.0 / volt) as u16));
    /// assert!((a - b).abs() < 2e-3, "one code is 1.4 mN");
    /// ```
    #[must_use]
    pub fn at_supply(mut self, supply: f32) -> Self {
        if supply != self.supply {
            let ratio = supply / self.supply;
            let Sheet { command, load, accel } = &mut self.sheet;
            for channel in [&mut self.command, &mut self.load, &mut self.accel, command, load, accel] {
                channel.offset_code /= ratio;
                channel.unit_per_code *= ratio;
            }
            self.supply = supply;
        }
        self
    }

    /// The device with what follows from its settings: limits at rest, gains of the excitation, largest acceleration.
    #[must_use]
    pub fn derived(self) -> Self {
        Self {
            acceleration_max: self.speed(ACCELERATION_MAX),
            rest_speed: self.speed(REST_SPEED),
            rest_force: self.force(REST_FORCE),
            tracking_stiffness: self.inertia(TRACKING_STIFFNESS),
            tracking_damping: self.inertia(TRACKING_DAMPING),
            ..self
        }
    }

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

/// Values of the default device that others scale from.
const STROKE: f32 = 0.032;
const OVERSPEED: f32 = 1.0;
const FORCE_MAX: f32 = 9.48;
const MASS: f32 = 0.692;
const ACCELERATION_MAX: f32 = 50.0 * 9.806_65;
const REST_SPEED: f32 = 5e-3;
const REST_FORCE: f32 = 2.0;
const TRACKING_STIFFNESS: f32 = 2_500.0;
const TRACKING_DAMPING: f32 = 50.0;

impl Default for Device {
    fn default() -> Self {
        Self {
            geometry: Geometry::Linear,
            tick_hz: 170_000_000,
            period: 1e-3,
            delay: 0.0,
            metre_per_count: 2.57e-6,
            encoder_reversed: false,
            mass: MASS,
            damping: 6.92,
            force_max: FORCE_MAX,
            command: Sheet::RIG.command,
            load: Sheet::RIG.load,
            accel: Sheet::RIG.accel,
            sheet: Sheet::RIG,
            acceleration_max: ACCELERATION_MAX,
            supply: NOMINAL_SUPPLY,
            // the sum of 16 12-bit conversions is at most 65 520
            rail_codes: 32,
            stroke: STROKE,
            overspeed: OVERSPEED,
            rest_speed: REST_SPEED,
            rest_force: REST_FORCE,
            effect_cycles: 1_200,
            tracking_stiffness: TRACKING_STIFFNESS,
            tracking_damping: TRACKING_DAMPING,
            compensation: Compensation::NONE,
            command_cutoff_hz: 100.0,
        }
    }
}
