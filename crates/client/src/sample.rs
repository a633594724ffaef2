//! Conversion of raw codes to SI, with the calibration of the header and the velocity estimator of the device.

use friction::Geometry;
use haptics::{Channel, Estimator};
use link::Mechanics;

/// A telemetry sample as received.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Raw {
    /// Time of the sample, ticks. Wraps.
    pub sample_ticks: u32,
    /// Quadrature count. Wraps.
    pub count: u32,
    /// Time of the last encoder edge, ticks.
    pub edge_ticks: u32,
    /// Load cell code.
    pub load_code: u16,
    /// Accelerometer code.
    pub accel_code: u16,
    /// Commanded force, N.
    pub command: f32,
    /// Reference of the excitation, m.
    pub reference: f32,
    /// State code.
    pub mode: u8,
    /// Fault code.
    pub fault: u8,
    /// Whether the device knows the middle of its stroke.
    pub referenced: bool,
}

/// Calibration of codes: from the header of the stream, or of the simulated rig.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Calibration {
    /// Rate of the timer, Hz.
    pub tick_hz: f64,
    /// Handle travel of a count, m.
    pub metre_per_count: f64,
    /// Count at position 0.
    pub origin_count: i32,
    /// Code of 0 N.
    pub load_offset: f64,
    /// Force per code, N.
    pub load_unit: f64,
    /// Code of 0 m/s².
    pub accel_offset: f64,
    /// Acceleration per code, m/s².
    pub accel_unit: f64,
}

/// Header of a stream, sent before the first sample.
#[derive(Debug, Clone, PartialEq)]
pub struct Header {
    /// Calibration of the codes.
    pub calibration: Calibration,
    /// Control periods per sample.
    pub decimation: u32,
    /// Control period, s.
    pub period: f64,
    /// Active preset.
    pub preset: String,
    /// Mechanics and limits of the device.
    pub mechanics: Mechanics,
}

impl Header {
    /// Time between two samples, s.
    #[must_use]
    pub fn sample_period(&self) -> f64 {
        self.period * f64::from(self.decimation)
    }

    /// Description in one line.
    #[must_use]
    pub fn describe(&self) -> String {
        format!("stream: {:.0} samples a second, preset {}", 1.0 / self.sample_period(), self.preset)
    }

    /// The calibration as lines for the head of a recording.
    #[must_use]
    pub fn notes(&self) -> Vec<(String, String)> {
        let c = &self.calibration;
        [
            ("preset", self.preset.clone()),
            ("sample_period_s", self.sample_period().to_string()),
            ("tick_hz", c.tick_hz.to_string()),
            ("metre_per_count", c.metre_per_count.to_string()),
            ("newton_per_code", c.load_unit.to_string()),
            ("metre_per_second_squared_per_code", c.accel_unit.to_string()),
        ]
        .map(|(key, value)| (if self.mechanics.rotary { rotary(key) } else { key }, value))
        .map(|(key, value)| (key.to_owned(), value))
        .to_vec()
    }

    /// Slide or axis.
    #[must_use]
    pub fn geometry(&self) -> Geometry {
        if self.mechanics.rotary { Geometry::Rotary } else { Geometry::Linear }
    }

    /// Constants of the device as its validation uses them, as streamed.
    #[must_use]
    pub fn device(&self) -> haptics::Device {
        let c = &self.calibration;
        let channel =
            |offset: f64, unit: f64| Channel { offset_code: offset as f32, unit_per_code: unit as f32 };
        let m = &self.mechanics;
        let own = haptics::Device::default();
        let mechanics = haptics::Device {
            geometry: self.geometry(),
            stroke: m.stroke,
            mass: m.mass,
            damping: m.damping,
            force_max: m.force_max,
            overspeed: m.overspeed,
            ..own
        };
        // what follows from the default values is exact without
        let mechanics = if mechanics == own { own } else { mechanics.derived() };
        haptics::Device {
            tick_hz: c.tick_hz as u32,
            period: self.period as f32,
            metre_per_count: c.metre_per_count as f32,
            load: channel(c.load_offset, c.load_unit),
            accel: channel(c.accel_offset, c.accel_unit),
            ..mechanics
        }
    }
}

/// The same note of a rotary device.
fn rotary(key: &str) -> &str {
    match key {
        "metre_per_count" => "radian_per_count",
        "newton_per_code" => "newton_metre_per_code",
        "metre_per_second_squared_per_code" => "radian_per_second_squared_per_code",
        _ => key,
    }
}

/// A sample in SI, with the state of the device.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Sample {
    /// Time since the first sample that was decoded, by the timer of the device, s.
    pub time: f64,
    /// m.
    pub position: f64,
    /// Velocity from the M/T estimator of the device, m/s.
    pub velocity: f64,
    /// Accelerometer, m/s².
    pub acceleration: f64,
    /// Load cell, N.
    pub force: f64,
    /// Commanded force, N.
    pub command: f64,
    /// Reference of the excitation, m.
    pub reference: f64,
    /// [`haptics::ModeId`] on the wire.
    pub mode: u8,
    /// [`haptics::FaultKind`] on the wire, 0 for none.
    pub fault: u8,
    /// Whether position 0 is the middle of the stroke.
    pub referenced: bool,
}

/// Number of samples without an edge after which the handle is at rest: it moves less than a count in that time.
const AT_REST: u32 = 10;

/// Decodes a run of samples.
///
/// A velocity needs two edges. The samples before, or the first ten of a handle at rest, are not given: their velocity would
/// be 0 whatever the handle does.
#[derive(Debug, Clone)]
pub struct Decoding {
    calibration: Calibration,
    estimator: Estimator,
    history: History,
    last_ticks: u32,
    /// Ticks since the first sample given, unwrapped.
    ticks: u64,
}

/// What the velocity estimator has seen.
#[derive(Debug, Clone, Copy, PartialEq)]
enum History {
    Nothing,
    /// Number of samples with an edge before them, and without.
    Edges(u32, u32),
    Enough,
}

impl History {
    fn after(self, moved: bool) -> Self {
        match self {
            Self::Nothing => Self::Edges(0, 0),
            Self::Edges(edges, still) => {
                let (edges, still) = if moved { (edges + 1, 0) } else { (edges, still + 1) };
                if edges == 2 || still == AT_REST { Self::Enough } else { Self::Edges(edges, still) }
            }
            Self::Enough => Self::Enough,
        }
    }
}

impl Decoding {
    /// A decoder before its first sample.
    #[must_use]
    pub fn new(calibration: Calibration) -> Self {
        let estimator = Estimator::default();
        Self { calibration, estimator, history: History::Nothing, last_ticks: 0, ticks: 0 }
    }

    /// Converts the next sample to SI; none while its velocity is not known.
    pub fn sample(&mut self, raw: &Raw) -> Option<Sample> {
        let c = &self.calibration;
        if self.history == History::Enough {
            self.ticks += u64::from(raw.sample_ticks.wrapping_sub(self.last_ticks));
        }
        self.last_ticks = raw.sample_ticks;
        self.estimator.sample(raw.sample_ticks, raw.count, raw.edge_ticks);
        self.history = self.history.after(self.estimator.step() != 0);
        (self.history == History::Enough).then(|| Sample {
            time: self.ticks as f64 / c.tick_hz,
            position: f64::from((raw.count as i32).wrapping_sub(c.origin_count)) * c.metre_per_count,
            velocity: f64::from(self.estimator.counts_per_tick()) * c.metre_per_count * c.tick_hz,
            acceleration: (f64::from(raw.accel_code) - c.accel_offset) * c.accel_unit,
            force: (f64::from(raw.load_code) - c.load_offset) * c.load_unit,
            command: f64::from(raw.command),
            reference: f64::from(raw.reference),
            mode: raw.mode,
            fault: raw.fault,
            referenced: raw.referenced,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RIG: Calibration = Calibration {
        tick_hz: 170e6,
        metre_per_count: 2.57e-6,
        origin_count: 0,
        load_offset: 32_768.0,
        load_unit: 1e-3,
        accel_offset: 32_768.0,
        accel_unit: 0.01,
    };

    #[test]
    fn time_survives_the_wrap_of_the_timer_and_speed_is_exact() {
        let mut decoding = Decoding::new(RIG);
        let (mut given, mut last) = (0, Sample::default());
        // 40 s, the timer wraps after 25; 100 counts a millisecond backward from zero
        for k in 0..40_000_u32 {
            let ticks = (u64::from(k) * 170_000) as u32;
            let raw = Raw {
                sample_ticks: ticks,
                count: 0_u32.wrapping_sub(100 * k),
                edge_ticks: ticks.wrapping_sub(10),
                load_code: 33_768,
                accel_code: 32_668,
                ..Raw::default()
            };
            if let Some(sample) = decoding.sample(&raw) {
                (given, last) = (given + 1, sample);
            }
        }
        println!("{given} samples, {last:?}");
        assert!((last.time - 1e-3 * f64::from(given - 1)).abs() < 1e-9 && given == 39_998);
        assert!((last.position + 3_999_900.0 * 2.57e-6).abs() < 1e-9);
        assert!((last.velocity + 0.257).abs() < 1e-6);
        assert!((last.force - 1.0).abs() < 1e-12 && (last.acceleration + 1.0).abs() < 1e-12);
    }

    #[test]
    fn the_first_velocity_of_a_moving_handle_was_zero() {
        // counts a period: fast, slow, at rest
        for (step, given_from) in [(50, 2), (1, 2), (0, 10)] {
            let mut decoding = Decoding::new(RIG);
            let decoded: Vec<Option<Sample>> = (0..30_u32)
                .map(|k| {
                    let ticks = (7 + k) * 170_000;
                    let edge_ticks = if step == 0 { 1 } else { ticks - 20 };
                    decoding.sample(&Raw {
                        sample_ticks: ticks,
                        count: step * k,
                        edge_ticks,
                        ..Raw::default()
                    })
                })
                .collect();
            let first = decoded.iter().position(Option::is_some);
            assert_eq!(first, Some(given_from), "{step} counts a period");
            let first = decoded[given_from].unwrap();
            let expected = f64::from(step) * 2.57e-3;
            println!("{step} counts a period: {first:?}");
            assert_eq!(first.time, 0.0);
            assert!((first.velocity - expected).abs() <= 1e-6 * expected);
            assert!(decoded[given_from..].iter().all(Option::is_some));
        }
    }
}
