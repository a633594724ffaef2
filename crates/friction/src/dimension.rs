//! Physical dimensions, and the unit each has on a slide and on an axis.

use core::fmt;
use serde::{Deserialize, Serialize};

/// How the machine moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Geometry {
    /// A slide: m, m/s, m/s², N, kg.
    #[default]
    Linear,
    /// An axis: rad, rad/s, rad/s², N·m, kg·m².
    Rotary,
}

/// A product of powers of the quantities a machine with one degree of freedom has.
///
/// Force and length are those *along the motion*: on an axis they are torque and angle. That one decision gives every
/// unit, so none is ever translated as text.
///
/// ```
/// use friction::{Dimension, Geometry};
///
/// let cubic = Dimension::FORCE.per(Dimension::LENGTH.power(3));
/// assert_eq!(cubic.unit(Geometry::Linear).to_string(), "N/m³");
/// assert_eq!(cubic.unit(Geometry::Rotary).to_string(), "N·m/rad³");
/// assert_eq!(Dimension::MASS.unit(Geometry::Rotary).to_string(), "kg·m²");
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Dimension {
    force: i8,
    length: i8,
    time: i8,
    load: i8,
    angle: i8,
}

impl Dimension {
    /// A pure number.
    pub const NUMBER: Self = Self { force: 0, length: 0, time: 0, load: 0, angle: 0 };
    /// Force along the motion: N, or N·m.
    pub const FORCE: Self = Self { force: 1, ..Self::NUMBER };
    /// Distance along the motion: m, or rad.
    pub const LENGTH: Self = Self { length: 1, ..Self::NUMBER };
    /// s.
    pub const TIME: Self = Self { time: 1, ..Self::NUMBER };
    /// Force across the contact: N on a slide and on an axis.
    pub const LOAD: Self = Self { load: 1, ..Self::NUMBER };
    /// Phase of a wave: rad on a slide and on an axis.
    pub const PHASE: Self = Self { angle: 1, ..Self::NUMBER };
    /// m/s, or rad/s.
    pub const VELOCITY: Self = Self::LENGTH.per(Self::TIME);
    /// m/s², or rad/s².
    pub const ACCELERATION: Self = Self::VELOCITY.per(Self::TIME);
    /// kg, or kg·m².
    pub const MASS: Self = Self::FORCE.per(Self::ACCELERATION);
    /// N/m, or N·m/rad.
    pub const STIFFNESS: Self = Self::FORCE.per(Self::LENGTH);
    /// N·s/m, or N·m·s/rad.
    pub const DAMPING: Self = Self::FORCE.per(Self::VELOCITY);
    /// Hz.
    pub const FREQUENCY: Self = Self::NUMBER.per(Self::TIME);
    /// N/s, or N·m/s.
    pub const FORCE_RATE: Self = Self::FORCE.per(Self::TIME);

    /// The product of two.
    #[must_use]
    pub const fn times(self, other: Self) -> Self {
        Self {
            force: self.force + other.force,
            length: self.length + other.length,
            time: self.time + other.time,
            load: self.load + other.load,
            angle: self.angle + other.angle,
        }
    }

    /// The quotient of two.
    #[must_use]
    pub const fn per(self, other: Self) -> Self {
        self.times(other.power(-1))
    }

    /// A whole power.
    #[must_use]
    pub const fn power(self, exponent: i8) -> Self {
        Self {
            force: exponent * self.force,
            length: exponent * self.length,
            time: exponent * self.time,
            load: exponent * self.load,
            angle: exponent * self.angle,
        }
    }

    /// Its SI unit.
    #[must_use]
    pub const fn unit(self, geometry: Geometry) -> Unit {
        Unit { dimension: self, geometry }
    }
}

/// The SI unit of a [`Dimension`]; displays as text.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Unit {
    dimension: Dimension,
    geometry: Geometry,
}

/// Base units in the order they are written.
const SYMBOLS: [&str; 4] = ["N", "m", "rad", "s"];
/// From the second power on; an exponent is at most one digit.
const POWERS: [&str; 8] = ["²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"];

impl fmt::Display for Unit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let width = f.width().unwrap_or(0);
        let mut text = Text { f, length: 0 };
        self.write(&mut text)?;
        // to the left in a column, as text is
        let missing = width.saturating_sub(text.length);
        (0..missing).try_for_each(|_| text.put(" "))
    }
}

impl Unit {
    fn write(self, text: &mut Text<'_, '_>) -> fmt::Result {
        let Dimension { force, length, time, load, angle } = self.dimension;
        let rotary = self.geometry == Geometry::Rotary;
        match (self.dimension, rotary) {
            (Dimension::NUMBER, _) => return text.put("1"),
            (Dimension::FREQUENCY, _) => return text.put("Hz"),
            (Dimension::MASS, false) => return text.put("kg"),
            (Dimension::MASS, true) => return text.put("kg·m²"),
            _ => {}
        }
        let (newton, metre, radian) =
            if rotary { (force + load, force, length + angle) } else { (force + load, length, angle) };
        let exponents = [newton, metre, radian, time];
        if !exponents.iter().any(|e| *e > 0) {
            text.put("1")?;
        }
        text.product(exponents)?;
        let below = exponents.map(|e| -e);
        match below.iter().filter(|e| **e > 0).count() {
            0 => Ok(()),
            1 => {
                text.put("/")?;
                text.product(below)
            }
            _ => {
                text.put("/(")?;
                text.product(below)?;
                text.put(")")
            }
        }
    }
}

/// Text on its way out, and how many characters it has.
struct Text<'a, 'b> {
    f: &'a mut fmt::Formatter<'b>,
    length: usize,
}

impl Text<'_, '_> {
    fn put(&mut self, text: &str) -> fmt::Result {
        self.length += text.chars().count();
        self.f.write_str(text)
    }

    /// The factors with a positive exponent.
    fn product(&mut self, exponents: [i8; 4]) -> fmt::Result {
        let mut between = "";
        for (symbol, exponent) in SYMBOLS.iter().zip(exponents) {
            if exponent > 0 {
                self.put(between)?;
                self.put(symbol)?;
                if let Some(power) = usize::try_from(exponent - 2).ok().and_then(|at| POWERS.get(at)) {
                    self.put(power)?;
                }
                between = "·";
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::string::ToString;

    #[test]
    fn units_of_a_slide_and_of_an_axis() {
        let d = Dimension::FORCE;
        for (dimension, slide, axis) in [
            (Dimension::NUMBER, "1", "1"),
            (d, "N", "N·m"),
            (Dimension::LENGTH, "m", "rad"),
            (Dimension::TIME, "s", "s"),
            (Dimension::FREQUENCY, "Hz", "Hz"),
            (Dimension::LOAD, "N", "N"),
            (Dimension::PHASE, "rad", "rad"),
            (Dimension::VELOCITY, "m/s", "rad/s"),
            (Dimension::ACCELERATION, "m/s²", "rad/s²"),
            (Dimension::MASS, "kg", "kg·m²"),
            (Dimension::STIFFNESS, "N/m", "N·m/rad"),
            (Dimension::DAMPING, "N·s/m", "N·m·s/rad"),
            (d.per(Dimension::LENGTH.power(2)), "N/m²", "N·m/rad²"),
            (d.per(Dimension::LENGTH.power(3)), "N/m³", "N·m/rad³"),
            (d.per(Dimension::VELOCITY.power(2)), "N·s²/m²", "N·m·s²/rad²"),
            (d.per(Dimension::TIME), "N/s", "N·m/s"),
            (d.per(Dimension::LOAD), "1", "m"),
            (Dimension::MASS.times(Dimension::LENGTH), "N·s²", "N·m·s²"),
            (Dimension::NUMBER.per(Dimension::LENGTH), "1/m", "1/rad"),
            (Dimension::NUMBER.per(Dimension::VELOCITY.times(d)), "s/(N·m)", "s/(N·m·rad)"),
            (Dimension::LENGTH.times(Dimension::PHASE), "m·rad", "rad²"),
        ] {
            assert_eq!(dimension.unit(Geometry::Linear).to_string(), slide);
            assert_eq!(dimension.unit(Geometry::Rotary).to_string(), axis);
        }
        assert_eq!(std::format!("{:<7}|", Dimension::MASS.unit(Geometry::Rotary)), "kg·m²  |");
    }
}
