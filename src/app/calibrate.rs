//! Calibration of an analogue channel with known values: weights on the load cell, gravity on the accelerometer.
//!
//! Each `calibrate load|accel VALUE` averages half a second at rest into a point. `calibrate save` fits a line to the points,
//! code = offset + VALUE / gain, by least squares, and refuses an implausible one.

use super::Telemetry;
use super::line::{Line, err};
use core::fmt::{self, Write};
use friction::Geometry;
use haptics::number::Text;
use haptics::{Channel, Device, Inputs};
use heapless::Vec;
use link::Sensor;

/// Control periods per point.
const PERIODS: u32 = 500;
/// Largest number of points per channel.
const POINTS: usize = 8;
/// Largest motion of the handle, counts.
const STILL: u32 = 2;
/// Smallest spread of the codes that is not rest: 3 % of the scale.
const NOISY: u16 = 2_000;
/// Smallest distance of two points, codes: ten times the noise of a mean.
const APART: u16 = 100;
/// Largest relative deviation of a gain from the data sheet.
const GAIN: f32 = 0.2;
/// Largest deviation of the code of zero from the data sheet, codes.
const OFFSET: f32 = 8_000.0;
/// The same for the force command: 1 % of its range.
const COMMAND_OFFSET: f32 = 41.0;
/// Largest deviation of a point from the line, as a share of the span of the points.
const STRAIGHT: f32 = 0.01;

/// A value with its mean code.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Point {
    value: f32,
    code: f32,
}

/// A running average.
#[derive(Debug, Clone, Copy)]
struct Average {
    sensor: Sensor,
    value: f32,
    seen: u32,
    sum: u32,
    lowest: u16,
    highest: u16,
    start: u32,
    travel: u32,
}

/// Points that are not yet saved.
#[derive(Debug, Clone, Default)]
pub(super) struct Calibration {
    load: Vec<Point, POINTS>,
    accel: Vec<Point, POINTS>,
    taking: Option<Average>,
}

/// A channel fitted to points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Fit {
    channel: Channel,
    points: usize,
    /// Largest deviation of a point from the line, codes.
    residual: f32,
}

/// Fits of load cell and accelerometer, if they have points.
pub(super) type Fits = [Option<Fit>; 2];

/// Reason why points are not a calibration.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Unfit {
    Few,
    Backwards,
    Gain { found: f32, nominal: f32 },
    Offset { found: f32, nominal: f32 },
    Crooked { value: f32, off: f32, most: f32 },
}

impl fmt::Display for Unfit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Few => {
                f.write_str("needs two points with different values, for example no weight and a weight")
            }
            Self::Backwards => f.write_str(
                "the code runs against the sign of its gain: exchange the signal wires, or `device set` the gain with the other sign",
            ),
            Self::Gain { found, nominal } => {
                let found = Text(found);
                let (low, high) = (Text((1.0 - GAIN) * nominal), Text((1.0 + GAIN) * nominal));
                write!(f, "gain {found:.7} per code: accepted from {low:.7} to {high:.7}; check the values")
            }
            Self::Offset { found, nominal } => {
                let found = Text(found);
                let (low, high) = (Text(nominal - OFFSET), Text(nominal + OFFSET));
                write!(
                    f,
                    "zero at code {found:.0}: accepted from {low:.0} to {high:.0}; check that nothing loads the sensor"
                )
            }
            Self::Crooked { value, off, most } => {
                let (value, off, most) = (Text(value), Text(off), Text(most));
                write!(
                    f,
                    "the point at {value} is {off:.0} codes off the line: accepted up to {most:.0}; `calibrate discard` and repeat"
                )
            }
        }
    }
}

/// Line through points. One point with a trusted gain gives the offset.
fn fit(points: &[Point], nominal: &Channel, one_will_do: bool) -> Result<Fit, Unfit> {
    let count = points.len() as f32;
    let mean = |of: fn(&Point) -> f32| points.iter().map(of).sum::<f32>() / count;
    let (value, code) = (mean(|p| p.value), mean(|p| p.code));
    let spread: f32 = points.iter().map(|p| (p.value - value) * (p.value - value)).sum();
    let slope = if points.len() >= 2 {
        points.iter().map(|p| (p.value - value) * (p.code - code)).sum::<f32>() / spread
    } else if one_will_do && points.len() == 1 {
        1.0 / nominal.unit_per_code
    } else {
        return Err(Unfit::Few);
    };
    if !(slope * nominal.unit_per_code > 0.0) {
        return Err(Unfit::Backwards);
    }
    let channel = Channel { offset_code: code - slope * value, unit_per_code: 1.0 / slope };
    plausible(&channel, nominal, OFFSET)?;
    let off = |p: &Point| (p.code - channel.offset_code - slope * p.value).abs();
    let span = points.iter().map(|p| p.code).fold(f32::MIN, f32::max)
        - points.iter().map(|p| p.code).fold(f32::MAX, f32::min);
    let (mut residual, mut worst) = (0.0, value);
    for point in points {
        if off(point) > residual {
            (residual, worst) = (off(point), point.value);
        }
    }
    let most = STRAIGHT * span;
    if residual > most && points.len() > 1 {
        return Err(Unfit::Crooked { value: worst, off: residual, most });
    }
    Ok(Fit { channel, points: points.len(), residual })
}

impl Calibration {
    /// Whether a point is being measured.
    pub fn is_taking(&self) -> bool {
        self.taking.is_some()
    }

    /// Starts the measurement of a point.
    pub fn begin(&mut self, sensor: Sensor, value: f32) {
        self.taking = Some(Average {
            sensor,
            value,
            seen: 0,
            sum: 0,
            lowest: u16::MAX,
            highest: 0,
            start: 0,
            travel: 0,
        });
    }

    /// Discards all points.
    pub fn discard(&mut self) {
        self.load.clear();
        self.accel.clear();
    }

    /// One control period. Returns the answer once a point is complete.
    pub fn take(&mut self, t: &Telemetry, device: &Device) -> Option<Line> {
        let average = self.taking.as_mut()?;
        let code = match average.sensor {
            Sensor::Load => t.inputs.load_code,
            Sensor::Accel => t.inputs.accel_code,
        };
        if average.seen == 0 {
            average.start = t.inputs.count;
        }
        average.seen += 1;
        average.sum += u32::from(code);
        (average.lowest, average.highest) = (average.lowest.min(code), average.highest.max(code));
        average.travel =
            average.travel.max((t.inputs.count.wrapping_sub(average.start) as i32).unsigned_abs());
        if average.seen < PERIODS {
            return None;
        }
        let average = *average;
        self.taking = None;
        let mut line = Line::new();
        if let Err(code) = self.add(&average, device, &mut line) {
            let why = line.clone();
            line.clear();
            err(code, why, &mut line);
        }
        Some(line)
    }

    fn add(&mut self, average: &Average, device: &Device, out: &mut Line) -> Result<(), &'static str> {
        let (value, span) = (average.value, average.highest.saturating_sub(average.lowest));
        let code = average.sum as f32 / PERIODS as f32;
        let points = match average.sensor {
            Sensor::Load => &mut self.load,
            Sensor::Accel => &mut self.accel,
        };
        let top = Inputs::TOP_CODE.saturating_sub(device.rail_codes);
        // a long line is truncated
        let (refusal, _) = if average.travel > STILL {
            (
                "NOT_AT_REST",
                write!(out, "the handle moved by {} counts: accepted up to {STILL}; lock it", average.travel),
            )
        } else if average.lowest < device.rail_codes || average.highest > top {
            (
                "SENSOR_RAIL",
                write!(
                    out,
                    "codes {} to {}: accepted from {} to {top}; check load and cable",
                    average.lowest, average.highest, device.rail_codes
                ),
            )
        } else if span > NOISY {
            (
                "NOISY",
                write!(out, "codes spread over {span}: accepted up to {NOISY}; wait until the load rests"),
            )
        } else if span == 0 {
            ("DEAD", write!(out, "code {:.0} without any noise: check the connection", Text(code)))
        } else if let Some(same) =
            points.iter().find(|p| (p.code - code).abs() < f32::from(APART) && p.value != value)
        {
            (
                "EQUAL",
                write!(
                    out,
                    "code {:.0} as at {}: accepted at a distance of {APART} codes; check that the load changed",
                    Text(code),
                    Text(same.value)
                ),
            )
        } else {
            // a repeated value replaces the point
            points.retain(|p| p.value != value);
            let (name, unit) = (average.sensor.id(), average.sensor.dimension().unit(device.geometry));
            if points.push(Point { value, code }).is_err() {
                let _ =
                    write!(out, "all {POINTS} points are in use: `calibrate save` or `calibrate discard`");
                return Err("FULL");
            }
            let _ = write!(
                out,
                "ok calibrate {name} {} {unit}: code {:.1}, noise over {span} codes, {} points",
                Text(value),
                Text(code),
                points.len()
            );
            return Ok(());
        };
        Err(refusal)
    }

    /// The device with the calibration of the points, and its description.
    pub fn fit(&self, device: &Device) -> Result<(Device, Fits), (Sensor, Unfit)> {
        let mut calibrated = *device;
        let mut fits = [None; 2];
        if !self.load.is_empty() {
            let found = fit(&self.load, &device.sheet.load, false).map_err(|unfit| (Sensor::Load, unfit))?;
            (calibrated.load, fits[0]) = (found.channel, Some(found));
        }
        if !self.accel.is_empty() {
            let found =
                fit(&self.accel, &device.sheet.accel, true).map_err(|unfit| (Sensor::Accel, unfit))?;
            (calibrated.accel, fits[1]) = (found.channel, Some(found));
        }
        if self.load.is_empty() && self.accel.is_empty() {
            Err((Sensor::Load, Unfit::Few))
        } else {
            Ok((calibrated, fits))
        }
    }
}

/// Bytes of a stored device: the format, its signs, its settings, and the calibration of its channels.
const STORED: usize = 2 + 4 * 15;
/// Format 1 has offset and gain of load cell and accelerometer only.
const FORMAT: u8 = 2;
const ROTARY: u8 = 1;
const REVERSED: u8 = 2;

/// Settings and calibration of a device as an item of persistent memory.
pub(super) fn encode(device: &Device) -> [u8; STORED] {
    let mut item = [FORMAT; STORED];
    let rotary = if device.geometry == Geometry::Rotary { ROTARY } else { 0 };
    item[1] = rotary | if device.encoder_reversed { REVERSED } else { 0 };
    let settings = settings(&mut { *device }).map(|setting| *setting);
    let channels = [device.command, device.load, device.accel].map(|c| [c.offset_code, c.unit_per_code]);
    for (to, number) in item[2..].chunks_exact_mut(4).zip(settings.iter().chain(channels.as_flattened())) {
        to.copy_from_slice(&number.to_le_bytes());
    }
    item
}

/// The stored device on this board. `None` if the item is none, or not plausible.
pub(super) fn decode(item: &[u8], board: &Device) -> Option<Device> {
    let (format, rest) = item.split_first()?;
    let (signs, numbers) = match format {
        1 => (None, rest),
        &FORMAT => rest.split_first().map(|(signs, rest)| (Some(*signs), rest))?,
        _ => return None,
    };
    let (numbers, []) = numbers.as_chunks::<4>() else { return None };
    if numbers.len() != if signs.is_some() { 15 } else { 4 } {
        return None;
    }
    let mut numbers = numbers.iter().map(|bytes| f32::from_le_bytes(*bytes));
    let mut device = *board;
    if let Some(signs) = signs {
        device.geometry = if signs & ROTARY != 0 { Geometry::Rotary } else { Geometry::Linear };
        device.encoder_reversed = signs & REVERSED != 0;
        for to in settings(&mut device) {
            *to = numbers.next()?;
        }
        if device != *board {
            device = device.derived();
        }
        device.check(|_| false).ok()?;
    }
    let mut channel = |sheet: &Channel, offset: f32| {
        let channel = Channel { offset_code: numbers.next()?, unit_per_code: numbers.next()? };
        plausible(&channel, sheet, offset).ok().map(|()| channel)
    };
    if signs.is_some() {
        device.command = channel(&device.sheet.command, COMMAND_OFFSET)?;
    }
    device.load = channel(&device.sheet.load, OFFSET)?;
    device.accel = channel(&device.sheet.accel, OFFSET)?;
    Some(device)
}

/// Settings of a device that are numbers, in the order in which they are stored.
fn settings(device: &mut Device) -> [&mut f32; 9] {
    let sheet = &mut device.sheet;
    [
        &mut device.stroke,
        &mut device.metre_per_count,
        &mut device.mass,
        &mut device.damping,
        &mut device.overspeed,
        &mut device.force_max,
        &mut sheet.command.unit_per_code,
        &mut sheet.load.unit_per_code,
        &mut sheet.accel.unit_per_code,
    ]
}

/// Whether a channel is near that of the data sheet, its zero within `offset` codes.
fn plausible(channel: &Channel, nominal: &Channel, offset: f32) -> Result<(), Unfit> {
    let (found, sheet) = (channel.unit_per_code, nominal.unit_per_code);
    if !((found / sheet - 1.0).abs() <= GAIN) {
        return Err(Unfit::Gain { found, nominal: sheet });
    }
    let (found, sheet) = (channel.offset_code, nominal.offset_code);
    if !((found - sheet).abs() <= offset) {
        return Err(Unfit::Offset { found, nominal: sheet });
    }
    Ok(())
}

/// `; load: 0.0013574 N per code, zero at 32768.0, 2 points within 0.0 codes`
pub(super) fn describe(sensor: Sensor, device: &Device, fit: Option<&Fit>, out: &mut Line) -> fmt::Result {
    let channel = match sensor {
        Sensor::Load => &device.load,
        Sensor::Accel => &device.accel,
    };
    let (name, unit) = (sensor.id(), sensor.dimension().unit(device.geometry));
    let (gain, zero) = (Text(channel.unit_per_code), Text(channel.offset_code));
    write!(out, "; {name}: {gain:.7} {unit} per code, zero at {zero:.1}")?;
    match fit {
        Some(fit) => write!(out, ", {} points within {:.1} codes", fit.points, Text(fit.residual)),
        None => Ok(()),
    }
}
