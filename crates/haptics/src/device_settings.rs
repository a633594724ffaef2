//! The device as a set of named settings: what another device than the rig of [thesis, table 3-1] has in another way.
//!
//! A negative `resolution` or gain is a signal that is reversed. Every range depends on other settings, so that a device is set
//! as a whole: [`Device::set`] one by one, then [`Device::check`].

use crate::{Accepted, Channel, Device, NOMINAL_SUPPLY, Reason, Refused, SetError, number, settings::SetWhy};
use friction::{Dimension, Geometry, Unit};

/// Voltage from the middle of the range to its ends, V.
const HALF: f32 = 0.5 * NOMINAL_SUPPLY;
/// The same for the output: its buffer ends 0.2 V from the rails [ds12288, "DAC characteristics"].
const OUTPUT: f32 = HALF - RAIL;
/// Distance of the output from its rails, V.
const RAIL: f32 = 0.2;
/// Codes of the sensors' converter, and of the output.
const ADC_CODES: f32 = 65_536.0;
const DAC_CODES: f32 = 4_096.0;
/// Counts in the stroke: fewer do not resolve a contact, more are not exact in single precision.
const COUNTS: (f32, f32) = (1_000.0, 1e7);
/// Highest rate of the encoder's input, counts per second.
const COUNT_RATE: f32 = 1e6;
/// Strokes per second at the overspeed.
const STROKES: (f32, f32) = (0.1, 250.0);
/// Time in which the largest force brings the handle to the overspeed, s.
const START_S: (f32, f32) = (0.01, 10.0);
/// Time constants m/b, s.
const DECAY_S: (f32, f32) = (2e-3, 1e3);
/// Smallest share of the output's range that the largest force may be.
const USED: f32 = 0.05;

/// A setting, for people.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DeviceSetting {
    /// Name as typed.
    pub name: &'static str,
    /// Dimension of a number. None for a choice.
    pub dimension: Option<Dimension>,
    /// Whether it is per volt at the pin.
    pub per_volt: bool,
    /// One line.
    pub what: &'static str,
}

impl DeviceSetting {
    /// Its SI unit on this device, without the volt of [`Self::per_volt`].
    #[must_use]
    pub fn unit(&self, geometry: Geometry) -> Option<Unit> {
        self.dimension.map(|dimension| dimension.unit(geometry))
    }
}

const fn number(name: &'static str, dimension: Dimension, what: &'static str) -> DeviceSetting {
    DeviceSetting { name, dimension: Some(dimension), per_volt: false, what }
}

const fn gain(name: &'static str, dimension: Dimension, what: &'static str) -> DeviceSetting {
    DeviceSetting { per_volt: true, ..number(name, dimension, what) }
}

/// Every setting, in the order for users.
pub const DEVICE_SETTINGS: &[DeviceSetting; 10] = &[
    DeviceSetting {
        name: "geometry",
        dimension: None,
        per_volt: false,
        what: "linear: a slide; rotary: an axis",
    },
    number("stroke", Dimension::LENGTH, "distance between the stops"),
    number("resolution", Dimension::LENGTH, "travel of one encoder count; negative: counts down"),
    number("mass", Dimension::MASS, "inertia of motor and handle"),
    number("damping", Dimension::DAMPING, "their viscous damping"),
    number("overspeed", Dimension::VELOCITY, "speed above which force is withdrawn"),
    number("force_max", Dimension::FORCE, "largest force"),
    gain("force_gain", Dimension::FORCE, "force per volt of the command; negative: reversed"),
    gain("load_gain", Dimension::FORCE, "force per volt of the load cell; negative: reversed"),
    gain("accel_gain", Dimension::ACCELERATION, "acceleration per volt; negative: reversed"),
];

/// Value of a setting.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum DeviceValue {
    /// In its unit.
    Number(f32),
    /// Slide or axis.
    Geometry(Geometry),
}

impl Device {
    /// Value of a setting; `None` for an unknown name.
    #[must_use]
    #[inline(never)]
    pub fn get(&self, name: &str) -> Option<DeviceValue> {
        Some(DeviceValue::Number(match name {
            "geometry" => return Some(DeviceValue::Geometry(self.geometry)),
            "stroke" => self.stroke,
            "resolution" if self.encoder_reversed => -self.metre_per_count,
            "resolution" => self.metre_per_count,
            "mass" => self.mass,
            "damping" => self.damping,
            "overspeed" => self.overspeed,
            "force_max" => self.force_max,
            "force_gain" => self.sheet.command.unit_per_code * (DAC_CODES / self.supply),
            "load_gain" => self.sheet.load.unit_per_code * (ADC_CODES / self.supply),
            "accel_gain" => self.sheet.accel.unit_per_code * (ADC_CODES / self.supply),
            _ => return None,
        }))
    }

    /// Sets one from text, and what follows from it. [`Self::check`] decides whether the result may run.
    ///
    /// # Errors
    /// Unknown name, or no value of it. Nothing has changed.
    #[inline(never)]
    pub fn set<'a>(&mut self, name: &'a str, value: &'a str) -> Result<(), SetError<'a>> {
        let fail = |why| SetError { name, value, why };
        if name == "geometry" {
            self.geometry = match value {
                "linear" => Geometry::Linear,
                "rotary" => Geometry::Rotary,
                _ => return Err(fail(SetWhy::NotOneOf("linear, rotary"))),
            };
            return Ok(());
        }
        if self.get(name).is_none() {
            return Err(fail(SetWhy::UnknownDeviceSetting));
        }
        let x = number::parse(value).ok_or(fail(SetWhy::NotANumber))?;
        match name {
            "stroke" => self.stroke = x,
            "resolution" => (self.metre_per_count, self.encoder_reversed) = (x.abs(), x < 0.0),
            "mass" => self.mass = x,
            "damping" => self.damping = x,
            "overspeed" => self.overspeed = x,
            "force_max" => self.force_max = x,
            // a calibration ends with the gain it was made for
            "force_gain" => {
                self.sheet.command.unit_per_code = x * (self.supply / DAC_CODES);
                self.command = self.sheet.command;
            }
            "load_gain" => {
                self.sheet.load.unit_per_code = x * (self.supply / ADC_CODES);
                self.load = self.sheet.load;
            }
            _ => {
                self.sheet.accel.unit_per_code = x * (self.supply / ADC_CODES);
                self.accel = self.sheet.accel;
            }
        }
        *self = self.derived();
        Ok(())
    }

    /// Largest force that the output gives both ways with its calibration, N, at this supply.
    #[must_use]
    pub fn reach(&self) -> f32 {
        let Channel { offset_code, unit_per_code } = self.command;
        let (low, high) =
            (RAIL * (DAC_CODES / self.supply), (self.supply - RAIL) * (DAC_CODES / self.supply));
        unit_per_code.abs() * (offset_code - low).min(high - offset_code)
    }

    /// Accepted magnitudes of a setting with the others as they are, and what bounds them.
    fn range(&self, name: &str) -> Option<(f32, f32, Reason)> {
        let d = self;
        let force_gain = d.sheet.command.unit_per_code.abs() * (DAC_CODES / self.supply);
        let load_gain = d.sheet.load.unit_per_code.abs() * (ADC_CODES / self.supply);
        Some(match name {
            "stroke" => (
                (COUNTS.0 * d.metre_per_count).max(d.overspeed / STROKES.1),
                (COUNTS.1 * d.metre_per_count).min(d.overspeed / STROKES.0),
                Reason::of(Dimension::LENGTH, "1000 counts to 1e7, crossed in 4 ms to 10 s at the overspeed"),
            ),
            "resolution" => (
                (d.stroke / COUNTS.1).max(d.overspeed / COUNT_RATE),
                d.stroke / COUNTS.0,
                Reason::of(
                    Dimension::LENGTH,
                    "either sign; 1000 counts to 1e7 in the stroke, 1e6 a second at the overspeed",
                ),
            ),
            "mass" => (
                (d.force_max * START_S.0 / d.overspeed).max(d.damping * DECAY_S.0),
                (d.force_max * START_S.1 / d.overspeed).min(d.damping * DECAY_S.1),
                Reason::of(
                    Dimension::MASS,
                    "the largest force reaches the overspeed in 10 ms to 10 s, m/b is 2 ms to 1000 s",
                ),
            ),
            "damping" => (
                d.mass / DECAY_S.1,
                d.mass / DECAY_S.0,
                Reason::of(Dimension::DAMPING, "m/b is 2 ms to 1000 s"),
            ),
            "overspeed" => (
                (STROKES.0 * d.stroke).max(d.force_max * START_S.0 / d.mass),
                (STROKES.1 * d.stroke)
                    .min(COUNT_RATE * d.metre_per_count)
                    .min(d.force_max * START_S.1 / d.mass),
                Reason::of(
                    Dimension::VELOCITY,
                    "0.1 to 250 strokes and at most 1e6 counts a second, reached in 10 ms to 10 s",
                ),
            ),
            "force_max" => (
                (d.mass * d.overspeed / START_S.1).max(USED * OUTPUT * force_gain),
                (d.mass * d.overspeed / START_S.0).min(d.reach()).min(HALF * load_gain),
                Reason::of(
                    Dimension::FORCE,
                    "within the range of output and load cell, reaches the overspeed in 10 ms to 10 s",
                ),
            ),
            "force_gain" => (
                d.force_max / OUTPUT,
                d.force_max / (USED * OUTPUT),
                Reason::per_volt(Dimension::FORCE, "either sign; 1.45 V reach force_max"),
            ),
            "load_gain" => (
                d.force_max / HALF,
                1e3 * d.force_max,
                Reason::per_volt(Dimension::FORCE, "either sign; 1.65 V reach force_max"),
            ),
            "accel_gain" => {
                let most = d.force_max / d.mass;
                (
                    most / HALF,
                    1e4 * most,
                    Reason::per_volt(
                        Dimension::ACCELERATION,
                        "either sign; 1.65 V reach what force_max gives the mass",
                    ),
                )
            }
            _ => return None,
        })
    }

    /// Checks one setting against the others.
    #[inline(never)]
    fn check_one(&self, setting: &DeviceSetting) -> Result<(), Refused> {
        let Some(DeviceValue::Number(value)) = self.get(setting.name) else { return Ok(()) };
        let Some((low, high, why)) = self.range(setting.name) else { return Ok(()) };
        // only a reversed signal is negative
        let signed = matches!(setting.name, "resolution") || setting.per_volt;
        let magnitude = if signed { value.abs() } else { value };
        // against the rounding of the products
        let slack = 1e-5;
        if magnitude >= low * (1.0 - slack) && magnitude <= high * (1.0 + slack) {
            return Ok(());
        }
        let accepted = Accepted::Between(number::four_digits(low, true), number::four_digits(high, false));
        Err(Refused { effect: None, parameter: setting.name, value, accepted, why })
    }

    /// Checks all settings, those that were `changed` first.
    ///
    /// # Errors
    /// The first one out of its range, with the magnitudes that would be accepted while the others stay.
    pub fn check(&self, changed: impl Fn(&str) -> bool) -> Result<(), Refused> {
        // what is accepted does not depend on the supply of the day
        let nominal = self.at_supply(NOMINAL_SUPPLY);
        let (first, rest) = (|s: &&DeviceSetting| changed(s.name), |s: &&DeviceSetting| !changed(s.name));
        DEVICE_SETTINGS.iter().filter(first).try_for_each(|setting| nominal.check_one(setting))?;
        DEVICE_SETTINGS.iter().filter(rest).try_for_each(|setting| nominal.check_one(setting))
    }
}
