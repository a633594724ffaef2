//! Parameters of the compensation by name, and their validation against the device.

use super::{COMPENSATION_CYCLES, LARGEST_SHARE, PUSH, SPEED};
use crate::number::{self, Text};
use crate::settings::{SetWhy, effect_cycles, named, parameter_of};
use crate::{Accepted, Compensation, Device, Reason, Refused, SetError, Value};
use core::fmt;
use friction::effects::{Effect, EffectName, EffectState, Scale};
use friction::{Dimension, Geometry, Motion};

/// Share unless one is set.
const SHARE: f32 = 0.9;
/// Largest friction, N; on the default device, like the speeds: three tenths of its force. More is no friction of a haptic device.
const FRICTION: f32 = 0.3 * 9.48;
/// Range of the speed, m/s.
const SPEEDS: (f32, f32) = (1e-4, 0.1);
/// Range of the push, N.
const PUSHES: (f32, f32) = (0.02, 9.48);
/// Largest share of a force that an effect may make of it.
const RIPPLE: f32 = 0.25;
/// Tolerance that keeps a bound at a round number.
const ROUNDING: f32 = 1e-6;
/// Places at which the slope of an effect is taken.
const PLACES: u32 = 64;
/// What it adds more when it has any effect, beside those of the effect.
const HAVING_EFFECTS: u32 = 170;

impl Compensation {
    /// Nothing is known, and nothing fed forward.
    #[must_use]
    pub fn off(device: &Device) -> Self {
        Self { speed: device.speed(SPEED), push: device.force(PUSH), ..Self::NONE }
    }

    /// Its parameters, in the order for users. Effects have theirs as `EFFECT.PARAMETER`.
    pub const PARAMETERS: &'static [crate::Parameter; 6] = &[
        crate::Parameter::number("share", Dimension::NUMBER, "share of what was found that is fed forward"),
        crate::Parameter::number(
            "friction_p",
            Dimension::FORCE,
            "sliding friction of the device, positive motion",
        ),
        crate::Parameter::number("friction_n", Dimension::FORCE, "the same, negative motion"),
        crate::Parameter::number("damping", Dimension::DAMPING, "viscous damping of the device"),
        crate::Parameter::number("speed", Dimension::VELOCITY, "speed from which it says the direction"),
        crate::Parameter::number(
            "push",
            Dimension::FORCE,
            "push of the hand on a handle at rest that says it",
        ),
    ];

    fn place(&mut self, name: &str) -> Option<&mut f32> {
        Some(match name {
            "share" => &mut self.share,
            "friction_p" => &mut self.friction_p,
            "friction_n" => &mut self.friction_n,
            "damping" => &mut self.damping,
            "speed" => &mut self.speed,
            "push" => &mut self.push,
            _ => return None,
        })
    }

    /// Value of a parameter; `None` for an unknown name and for an effect that is not there.
    #[must_use]
    pub fn get(&self, name: &str) -> Option<f32> {
        if let Some(place) = { *self }.place(name) {
            return Some(*place);
        }
        let (effect, parameter) = name.split_once('.')?;
        named(&self.effects, EffectName::parse(effect)?)?.get(parameter)
    }

    /// Sets a parameter from text. The first one switches the feed-forward on, with nine tenths of what is told.
    ///
    /// # Errors
    /// [`SetError`]: one line that says what would be accepted. Nothing has changed.
    pub fn set<'a>(&mut self, name: &'a str, value: &'a str) -> Result<(), SetError<'a>> {
        let fail = |why| SetError { name, value, why };
        let mut next = *self;
        let x = number::parse(value).ok_or(fail(SetWhy::NotANumber));
        if next.share == 0.0 && name != "share" {
            next.share = SHARE;
        }
        if let Some(place) = next.place(name) {
            *place = x?;
        } else {
            let (effect, parameter) = name.split_once('.').ok_or(fail(SetWhy::UnknownOfCompensation))?;
            let effect = EffectName::parse(effect).filter(|effect| effect.kind.is_of_position());
            let effect = effect.ok_or(fail(SetWhy::UnknownOfCompensation))?;
            let place = parameter_of(&mut next.effects, effect, parameter, SetWhy::FedFull).map_err(fail)?;
            *place = x?;
        }
        *self = next;
        Ok(())
    }

    /// Damping of the device that the hand still meets, N·s/m.
    #[must_use]
    pub fn left_damping(&self, device: &Device) -> f32 {
        device.damping - self.share * self.damping
    }

    /// Damping that is left for the sampling of the effects, and what they need of it, N·s/m: passive while the first is
    /// the larger one [colgate-1997].
    #[must_use]
    pub fn sampled_damping(&self, device: &Device) -> (f32, f32) {
        let lag = 0.5 * device.period + device.delay;
        let slope: f32 = self.effects.iter().flatten().map(|effect| steepest(effect, device)).sum();
        (self.left_damping(device), self.share * slope * lag)
    }

    /// Cycles of a control step that it takes.
    #[must_use]
    pub fn cycles(&self) -> u32 {
        let effects = self.effects.iter().flatten().map(|effect| effect_cycles(effect.kind)).sum::<u32>();
        let having = if effects > 0 { HAVING_EFFECTS } else { 0 };
        if self.is_on() { COMPENSATION_CYCLES + having + effects } else { 0 }
    }

    /// Checks every parameter against the device.
    ///
    /// # Errors
    /// [`Refused`]: the first one outside its range, with the number that would be accepted.
    pub fn validate(&self, device: &Device) -> Result<(), Refused> {
        // switched off it does nothing, and its defaults are those of another device
        if self.share == 0.0 {
            return Ok(());
        }
        let force = |what| Reason::of(Dimension::FORCE, what);
        let friction = device.force(FRICTION);
        let ranges = [
            (
                "share",
                self.share,
                (0.0, LARGEST_SHARE),
                Reason::plain(
                    "above, a friction a tenth less than what was found makes the handle run by itself: a limit cycle",
                ),
            ),
            ("friction_p", self.friction_p, (0.0, friction), force("three tenths of the actuator's force")),
            ("friction_n", self.friction_n, (0.0, friction), force("three tenths of the actuator's force")),
            (
                "damping",
                self.damping,
                (0.0, device.damping),
                Reason::of(
                    Dimension::DAMPING,
                    "up to the `damping` of `device`, which the stability bounds are made with",
                ),
            ),
            (
                "speed",
                self.speed,
                (device.speed(SPEEDS.0), device.speed(SPEEDS.1)),
                Reason::of(Dimension::VELOCITY, "below, noise says the direction; above, no hand reaches it"),
            ),
            (
                "push",
                self.push,
                (device.force(PUSHES.0), device.force(PUSHES.1)),
                force("below, noise of the load cell says the direction; above, no hand reaches it"),
            ),
        ];
        for (parameter, value, (low, high), why) in ranges {
            if !(value >= low && value <= high) {
                // against the rounding of round numbers
                let (low, high) = (low * (1.0 - ROUNDING), high * (1.0 + ROUNDING));
                let accepted =
                    Accepted::Between(number::four_digits(low, true), number::four_digits(high, false));
                return Err(Refused { effect: None, parameter, value, accepted, why });
            }
        }
        EffectName::of(self.effects.iter().flatten())
            .try_for_each(|(name, effect)| self.check(name, effect, device))
    }

    fn check(&self, name: EffectName, effect: &Effect<f32>, device: &Device) -> Result<(), Refused> {
        let refused =
            |parameter, value, accepted, why| Refused { effect: Some(name), parameter, value, accepted, why };
        effect.validate().map_err(|invalid| {
            let range = Accepted::Between(invalid.min as f32, invalid.max as f32);
            refused(invalid.parameter, invalid.value as f32, range, Reason::plain("outside its range"))
        })?;
        for (gain, parameter) in effect.gains.iter().zip(effect.kind.gains()) {
            let most = match parameter.dimension {
                Dimension::FORCE => number::four_digits(device.force(FRICTION) * (1.0 + ROUNDING), false),
                Dimension::NUMBER => RIPPLE,
                _ => continue,
            };
            if !(gain.abs() <= most) {
                let why = Reason::of(parameter.dimension, "above, it is more than an error of a device");
                return Err(refused(parameter.name, *gain, Accepted::Between(-most, most), why));
            }
        }
        let (left, needed) = self.sampled_damping(device);
        if needed <= left {
            return Ok(());
        }
        let why = "above, the sampled slope of the effects takes more damping than the device has left";
        let most = number::four_digits(self.share * left / needed, false);
        Err(Refused {
            effect: None,
            parameter: "share",
            value: self.share,
            accepted: Accepted::AtMost(most),
            why: Reason::plain(why),
        })
    }
}

/// Steepest slope of an effect over the position, N/m, with a force that it changes at its largest.
fn steepest(effect: &Effect<f32>, device: &Device) -> f32 {
    let wave = effect.kind.shape().iter().zip(effect.shape).find(|(p, _)| p.scale == Scale::Wavelength);
    let length = wave.map_or(device.stroke, |(_, length)| length);
    let step = length / PLACES as f32;
    let force = |place: u32| {
        let position = place as f32 * step - 0.5 * length;
        effect.step(
            &mut EffectState::default(),
            &Motion { position, applied: device.force_max, ..Motion::default() },
        )
    };
    (0..PLACES).fold(0.0_f32, |most, place| most.max((force(place + 1) - force(place)).abs())) / step
}

impl fmt::Display for On<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(compensation, geometry) = *self;
        if !compensation.is_on() {
            return f.write_str("off");
        }
        for p in Compensation::PARAMETERS {
            let value = Value::Number(compensation.get(p.name).unwrap_or(0.0));
            let comma = if p.name == "share" { "" } else { ", " };
            write!(f, "{comma}{} {value}", p.name)?;
            match p.dimension {
                Some(Dimension::NUMBER) | None => {}
                Some(dimension) => write!(f, " {}", dimension.unit(geometry))?,
            }
        }
        for (name, effect) in EffectName::of(compensation.effects.iter().flatten()) {
            let gains = effect.kind.gains().iter().zip(effect.gains);
            for (p, x) in gains.chain(effect.kind.shape().iter().zip(effect.shape)) {
                write!(f, ", {name}.{} {} {}", p.name, Text(x), p.unit(geometry))?;
            }
        }
        Ok(())
    }
}

/// A compensation in the units of a device. Prints one line.
#[derive(Debug, Clone, Copy)]
pub struct On<'a>(&'a Compensation, Geometry);

impl Compensation {
    /// The same in the units of this geometry.
    #[must_use]
    pub fn on(&self, geometry: Geometry) -> On<'_> {
        On(self, geometry)
    }
}
