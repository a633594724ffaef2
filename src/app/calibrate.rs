//! Calibration of the analogue channels: the sensors with known values, weights on the load cell and gravity on the
//! accelerometer; then the force command with the load cell.
//!
//! Each `calibrate load|accel VALUE` averages half a second at rest into a point. `calibrate save` fits a line to the points,
//! code = offset + VALUE / gain, by least squares, and refuses an implausible one.
//!
//! `calibrate force` ramps the force up and down in both directions while a person holds the handle, so that the load cell
//! carries it up to the friction of the device. Friction adds while the force falls and takes while it rises: both directions
//! have one slope, the gain, and the mean of their zeros is the zero. After each turn the handle sticks until twice the friction
//! is overcome; these samples are excluded. Half of what the friction differs in the two directions stays in the zero.

use super::Telemetry;
use super::line::{self, Line, err};
use core::fmt::{self, Write};
use friction::{Dimension, Geometry};
use haptics::number::Text;
use haptics::{Channel, Device, Inputs, ModeId, Ramp};
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
/// Change of the force after a turn of the ramp that is excluded, as a share of its peak.
const TURN: f32 = 0.6;
/// Largest friction of the device, as a share of the peak: half of the change that is excluded.
const FRICTION: f32 = 0.5 * TURN;
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
    ramp: Option<Ramped>,
}

/// Samples of the ramp in which the force moves one way.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Way {
    count: f32,
    force: f32,
    load: f32,
    force_force: f32,
    force_load: f32,
}

impl Way {
    fn add(&mut self, force: f32, load: f32) {
        self.count += 1.0;
        self.force += force;
        self.load += load;
        self.force_force += force * force;
        self.force_load += force * load;
    }

    /// Centred sums of force², and of force and load.
    fn centred(&self) -> [f32; 2] {
        let mean = self.force / self.count;
        [self.force_force - mean * self.force, self.force_load - mean * self.load]
    }

    /// Load at no force, N.
    fn zero(&self, slope: f32) -> f32 {
        (self.load - slope * self.force) / self.count
    }
}

/// A running ramp of the force.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Ramped {
    began: bool,
    /// Handle position at its begin, m.
    start: f32,
    /// Largest distance from there, m.
    travel: f32,
    seconds: f32,
    last: f32,
    /// Force of the last turn, N.
    turn: f32,
    /// Rising and falling force.
    ways: [Way; 2],
    rising: bool,
}

/// End of the ramp.
pub(super) type RampEnd = Result<(Device, Fits), Unfit>;

/// A channel fitted to points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Fit {
    channel: Channel,
    points: usize,
    /// Largest deviation of a point from the line, codes.
    residual: f32,
}

/// What a calibration found.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Fits {
    load: Option<Fit>,
    accel: Option<Fit>,
    /// Friction of the device found by the ramp, N.
    friction: Option<f32>,
}

impl Fits {
    /// Whether it is the force that was calibrated.
    pub fn is_of_force(&self) -> bool {
        self.friction.is_some()
    }
}

/// Reason why points are not a calibration.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Unfit {
    Few,
    Backwards,
    Gain {
        found: f32,
        nominal: f32,
    },
    Offset {
        found: f32,
        nominal: f32,
        within: f32,
    },
    Crooked {
        value: f32,
        off: f32,
        most: f32,
    },
    /// The ramp ended before its time.
    Interrupted,
    /// The handle moved further than this, m.
    NotHeld {
        most: f32,
        geometry: Geometry,
    },
    /// The load cell shows this share of the force, or the opposite.
    Share(f32),
    /// Friction, N.
    Friction {
        found: f32,
        most: f32,
        geometry: Geometry,
    },
    /// The output reaches this force only, N.
    Reach {
        found: f32,
        most: f32,
        geometry: Geometry,
    },
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
            Self::Offset { found, nominal, within } => {
                let found = Text(found);
                let (low, high) = (Text(nominal - within), Text(nominal + within));
                write!(
                    f,
                    "zero at code {found:.0}: accepted from {low:.0} to {high:.0}; check what loads the sensor, and the supply"
                )
            }
            Self::Crooked { value, off, most } => {
                let (value, off, most) = (Text(value), Text(off), Text(most));
                write!(
                    f,
                    "the point at {value} is {off:.0} codes off the line: accepted up to {most:.0}; `calibrate discard` and repeat"
                )
            }
            Self::Interrupted => f.write_str("interrupted"),
            Self::NotHeld { most, geometry } => {
                let (scale, unit) = line::travel(geometry);
                let most = Text(scale * most);
                write!(f, "the handle moved: accepted up to {most:.1} {unit}; hold it in the middle, or lock it")
            }
            Self::Share(share) => write!(
                f,
                "the load cell shows {:.2} of the force: accepted from {} to {}; hold the handle in the middle, check `load_gain` and `force_gain`",
                Text(share),
                Text(1.0 - GAIN),
                Text(1.0 + GAIN)
            ),
            Self::Friction { found, most, geometry } => {
                let unit = Dimension::FORCE.unit(geometry);
                write!(
                    f,
                    "the device rubs by {:.3} {unit}: accepted up to {:.3}; hold the handle still, and check its guide",
                    Text(found),
                    Text(most)
                )
            }
            Self::Reach { found, most, geometry } => {
                let unit = Dimension::FORCE.unit(geometry);
                let (found, most) = (Text(found), Text(most));
                write!(
                    f,
                    "the output gives {found:.4} {unit}, force_max is {most}: `device set force_max` to less than it gives, and repeat"
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

    /// Whether the ramp of the force runs.
    pub fn is_ramping(&self) -> bool {
        self.ramp.is_some()
    }

    /// Begins to look for the ramp of the force.
    pub fn begin_ramp(&mut self) {
        self.ramp = Some(Ramped::default());
    }

    /// Drops the ramp: it was denied.
    pub fn drop_ramp(&mut self) {
        self.ramp = None;
    }

    /// One control period of the ramp. The device with the calibrated force, once it has ended.
    pub fn take_ramp(&mut self, t: &Telemetry, device: &Device) -> Option<RampEnd> {
        let ramp = self.ramp.as_mut()?;
        if t.outputs.mode == ModeId::Exciting {
            ramp.take(t, device);
            return None;
        }
        let ended = ramp.began || t.outputs.mode == ModeId::Fault;
        // before the first period it is not there yet
        self.ramp.take_if(|_| ended).map(|ramp| ramp.fit(device))
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
        let mut fits = Fits::default();
        if !self.load.is_empty() {
            let found = fit(&self.load, &device.sheet.load, false).map_err(|unfit| (Sensor::Load, unfit))?;
            (calibrated.load, fits.load) = (found.channel, Some(found));
        }
        if !self.accel.is_empty() {
            let found =
                fit(&self.accel, &device.sheet.accel, true).map_err(|unfit| (Sensor::Accel, unfit))?;
            (calibrated.accel, fits.accel) = (found.channel, Some(found));
        }
        if self.load.is_empty() && self.accel.is_empty() {
            Err((Sensor::Load, Unfit::Few))
        } else {
            Ok((calibrated, fits))
        }
    }
}

impl Ramped {
    fn take(&mut self, t: &Telemetry, device: &Device) {
        let (force, position) = (t.outputs.force, t.outputs.position);
        if !self.began {
            (self.began, self.start, self.rising) = (true, position, true);
        }
        self.seconds += device.period;
        self.travel = self.travel.max((position - self.start).abs());
        // what is sampled now follows the force of the period before
        let before = core::mem::replace(&mut self.last, force);
        if force != before && (force > before) != self.rising {
            (self.rising, self.turn) = (!self.rising, before);
        }
        if (force - self.turn).abs() > TURN * Ramp::peak(device) {
            let way = if self.rising { &mut self.ways[0] } else { &mut self.ways[1] };
            way.add(before, device.load.to_si(t.inputs.load_code));
        }
    }

    fn fit(&self, device: &Device) -> RampEnd {
        let geometry = device.geometry;
        let far = Ramp::far(device);
        if self.travel > 0.99 * far {
            return Err(Unfit::NotHeld { most: far, geometry });
        }
        if self.seconds < 0.99 * Ramp::SECONDS {
            return Err(Unfit::Interrupted);
        }
        let [rising, falling] = &self.ways;
        let ([a, b], [c, d]) = (rising.centred(), falling.centred());
        let slope = (b + d) / (a + c);
        if !((slope - 1.0).abs() <= GAIN * 1.5) {
            return Err(Unfit::Share(slope));
        }
        let (low, high) = (rising.zero(slope), falling.zero(slope));
        let friction = 0.5 * (high - low);
        let most = FRICTION * Ramp::peak(device);
        if !(friction.abs() <= most) {
            return Err(Unfit::Friction { found: friction, most, geometry });
        }
        let old = &device.command;
        // the load is zero + slope · commanded force
        let zero = 0.5 * (low + high);
        let unit_per_code = slope * old.unit_per_code;
        let command = Channel { offset_code: old.offset_code - zero / unit_per_code, unit_per_code };
        plausible(&command, &device.sheet.command, COMMAND_OFFSET)?;
        let calibrated = Device { command, ..*device };
        let (found, most) = (calibrated.reach(), device.force_max);
        if !(found >= most * (1.0 - 1e-5)) {
            return Err(Unfit::Reach { found, most, geometry });
        }
        Ok((calibrated, Fits { friction: Some(friction), ..Fits::default() }))
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
        if device.sheet.command != board.sheet.command {
            device.command = device.sheet.command;
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
        return Err(Unfit::Offset { found, nominal: sheet, within: offset });
    }
    Ok(())
}

/// `; load: …; accel: …; force: 0.0053711 N per code, zero at 2048.0`
pub(super) fn describe(device: &Device, fits: &Fits, out: &mut Line) -> fmt::Result {
    let sensors = [(Sensor::Load, &device.load, &fits.load), (Sensor::Accel, &device.accel, &fits.accel)];
    for (sensor, channel, fit) in sensors {
        describe_one(sensor.id(), sensor.dimension(), channel, device.geometry, out)?;
        if let Some(fit) = fit {
            write!(out, ", {} points within {:.1} codes", fit.points, Text(fit.residual))?;
        }
    }
    describe_one("force", Dimension::FORCE, &device.command, device.geometry, out)?;
    match fits.friction {
        Some(friction) => {
            write!(out, ", device rubs by {:.3} {}", Text(friction), Dimension::FORCE.unit(device.geometry))
        }
        None => Ok(()),
    }
}

/// `; load: 0.0013574 N per code, zero at 32768.0`
fn describe_one(
    name: &str,
    dimension: Dimension,
    channel: &Channel,
    geometry: Geometry,
    out: &mut Line,
) -> fmt::Result {
    let (gain, zero, unit) =
        (Text(channel.unit_per_code), Text(channel.offset_code), dimension.unit(geometry));
    write!(out, "; {name}: {gain:.7} {unit} per code, zero at {zero:.1}")
}
