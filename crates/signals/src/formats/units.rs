//! Units as people write them: what each measures, and how its numbers become SI.

use friction::{Dimension, Geometry};
use std::f64::consts::{PI, TAU};

/// A unit of a column.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Unit {
    /// None for a temperature.
    pub dimension: Option<Dimension>,
    /// None where slide and axis have it alike.
    pub geometry: Option<Geometry>,
    times: f64,
    over: f64,
    plus: f64,
}

impl Unit {
    /// A value in SI (a temperature in °C). Dividing by a thousand rounds once; multiplying by 0.001 rounds twice.
    fn to_si(self, value: f64) -> f64 {
        value * self.times / self.over + self.plus
    }

    /// All values of a column in SI.
    pub(crate) fn all_to_si(self, mut values: Vec<f64>) -> Vec<f64> {
        if !self.is_si() {
            for value in &mut values {
                *value = self.to_si(*value);
            }
        }
        values
    }

    /// Whether numbers stay as they are.
    pub(crate) fn is_si(self) -> bool {
        self.times == 1.0 && self.over == 1.0 && self.plus == 0.0
    }
}

/// Examples of units that are read, for messages.
pub(crate) const ACCEPTED: &str =
    "s, ms, us, m, mm, um, rad, deg, rev, m/s, mm/s, rad/s, deg/s, rpm, m/s^2, N, kN, Nm, mNm, degC";

const SLIDE: Option<Geometry> = Some(Geometry::Linear);
const AXIS: Option<Geometry> = Some(Geometry::Rotary);

/// Names, dimension (none for a temperature), geometry, factor, divisor, summand.
type Row = (&'static [&'static str], Option<Dimension>, Option<Geometry>, f64, f64, f64);

static UNITS: [Row; 27] = {
    const TIME: Option<Dimension> = Some(Dimension::TIME);
    const LENGTH: Option<Dimension> = Some(Dimension::LENGTH);
    const FORCE: Option<Dimension> = Some(Dimension::FORCE);
    [
        (&["s", "sec", "second", "seconds"], TIME, None, 1.0, 1.0, 0.0),
        (&["ms", "msec", "millisecond", "milliseconds"], TIME, None, 1.0, 1e3, 0.0),
        (&["us", "µs", "μs", "microsecond", "microseconds"], TIME, None, 1.0, 1e6, 0.0),
        (&["ns", "nanosecond", "nanoseconds"], TIME, None, 1.0, 1e9, 0.0),
        (&["min", "minute", "minutes"], TIME, None, 60.0, 1.0, 0.0),
        (&["m", "meter", "meters", "metre", "metres"], LENGTH, SLIDE, 1.0, 1.0, 0.0),
        (&["cm"], LENGTH, SLIDE, 1.0, 1e2, 0.0),
        (&["mm", "millimeter", "millimeters", "millimetre", "millimetres"], LENGTH, SLIDE, 1.0, 1e3, 0.0),
        (&["um", "µm", "μm", "micron", "microns"], LENGTH, SLIDE, 1.0, 1e6, 0.0),
        (&["nm"], LENGTH, SLIDE, 1.0, 1e9, 0.0),
        (&["in", "inch", "inches"], LENGTH, SLIDE, 0.0254, 1.0, 0.0),
        (&["rad", "radian", "radians"], LENGTH, AXIS, 1.0, 1.0, 0.0),
        (&["mrad"], LENGTH, AXIS, 1.0, 1e3, 0.0),
        (&["deg", "°", "degree", "degrees"], LENGTH, AXIS, PI, 180.0, 0.0),
        (&["rev", "revolution", "revolutions", "turn", "turns"], LENGTH, AXIS, TAU, 1.0, 0.0),
        (&["rpm", "1/min"], Some(Dimension::VELOCITY), AXIS, TAU, 60.0, 0.0),
        (&["N", "newton", "newtons"], FORCE, SLIDE, 1.0, 1.0, 0.0),
        (&["mN"], FORCE, SLIDE, 1.0, 1e3, 0.0),
        (&["kN"], FORCE, SLIDE, 1e3, 1.0, 0.0),
        (&["MN"], FORCE, SLIDE, 1e6, 1.0, 0.0),
        (&["Nm"], FORCE, AXIS, 1.0, 1.0, 0.0),
        (&["Ncm"], FORCE, AXIS, 1.0, 1e2, 0.0),
        (&["mNm", "Nmm"], FORCE, AXIS, 1.0, 1e3, 0.0),
        (&["uNm", "µNm", "μNm"], FORCE, AXIS, 1.0, 1e6, 0.0),
        (&["kNm"], FORCE, AXIS, 1e3, 1.0, 0.0),
        (&["°C", "degC", "C", "℃", "celsius"], None, None, 1.0, 1.0, 0.0),
        (&["K", "kelvin"], None, None, 1.0, 1.0, -273.15),
    ]
};

/// Steps of an encoder or a converter: how much each is worth is not in the file.
const COUNTS: [&str; 11] =
    ["count", "counts", "cts", "inc", "incs", "increments", "tick", "ticks", "pulses", "lsb", "LSB"];

/// Why a unit is not read.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Unread {
    /// Counts: a map gives their worth.
    Counts,
    Unknown,
}

/// The unit of a text, which may be in brackets: `mm`, `[deg/s]`, `(N·m)`.
pub(crate) fn parse(text: &str) -> Result<Unit, Unread> {
    let text = text.trim();
    let inside = [('[', ']'), ('(', ')')]
        .iter()
        .find_map(|(open, close)| text.strip_prefix(*open)?.strip_suffix(*close))
        .unwrap_or(text);
    let plain: String = inside.chars().filter(|c| !matches!(c, ' ' | '·' | '⋅' | '*' | '^')).collect();
    if COUNTS.contains(&plain.as_str()) {
        return Err(Unread::Counts);
    }
    if let Some(unit) = base(&plain) {
        return Ok(unit);
    }
    // a length over a time, once or twice
    let (above, below) = plain.split_once(['/', '_']).ok_or(Unread::Unknown)?;
    let above = base(above).filter(|u| u.dimension == Some(Dimension::LENGTH)).ok_or(Unread::Unknown)?;
    let (below, power) = match below.trim_matches(['(', ')']) {
        "s2" | "s²" | "s/s" | "ss" => ("s", 2),
        one => (one, 1),
    };
    let time = base(below).filter(|u| u.dimension == Some(Dimension::TIME)).ok_or(Unread::Unknown)?;
    Ok(Unit {
        dimension: above.dimension.map(|d| d.per(Dimension::TIME.power(power))),
        // of a time the factor is in the denominator
        times: above.times * time.over,
        over: above.over * time.times,
        ..above
    })
}

fn base(text: &str) -> Option<Unit> {
    UNITS.iter().find(|row| row.0.contains(&text)).map(|&(_, dimension, geometry, times, over, plus)| Unit {
        dimension,
        geometry,
        times,
        over,
        plus,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_become_si() {
        for (text, value, si) in [
            ("ms", 1500.0, 1.5),
            ("[mm]", 3.0, 0.003),
            ("(deg)", 180.0, PI),
            ("deg/s", 90.0, PI / 2.0),
            ("mm/s", 2.0, 0.002),
            ("mm/ms", 2.0, 2.0),
            ("mm/s^2", 5.0, 0.005),
            ("m/s²", 5.0, 5.0),
            ("rad_s2", 5.0, 5.0),
            ("rpm", 60.0, TAU),
            ("N·m", 2.0, 2.0),
            ("N*mm", 2.0, 0.002),
            ("K", 273.15, 0.0),
        ] {
            let unit = parse(text).unwrap();
            assert!((unit.to_si(value) - si).abs() <= 1e-15 * si.abs(), "{text}: {}", unit.to_si(value));
        }
        // the divisor rounds once
        assert_eq!(parse("mm").unwrap().to_si(0.3), 0.3 / 1000.0);
        assert!(parse("rad/s").unwrap().is_si());
    }

    #[test]
    fn unknown_units_and_counts_are_not_guessed() {
        assert_eq!(parse("counts"), Err(Unread::Counts));
        for text in ["", "furlong", "N/s", "m/m", "s/m", "1.5", "V"] {
            assert_eq!(parse(text), Err(Unread::Unknown), "{text}");
        }
    }
}
