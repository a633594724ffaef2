//! What runs in the control step: delay line, differences, sums.

use super::sum::Sum;
use crate::{Accepted, Config, Device, Excitation, Refused, Wave};

/// The identification procedure (ch. 3.5.2, 3.5.3). `default()` is the thesis's.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Procedure {
    /// Shape of the motion.
    pub wave: Wave,
    /// Amplitude, m.
    pub amplitude_m: f32,
    /// Frequency, Hz.
    pub frequency_hz: f32,
    /// Motion before anything is recorded, s; includes the ramp.
    pub warm_up_s: f32,
    /// Length of the recording, s.
    pub record_s: f32,
    /// Δv: samples slower than this are set aside, m/s.
    pub dv: f32,
}

impl Default for Procedure {
    fn default() -> Self {
        Self {
            wave: Wave::Sine,
            amplitude_m: 0.01,
            frequency_hz: 2.0,
            warm_up_s: 10.0,
            record_s: 2.0,
            dv: 0.007,
        }
    }
}

impl Procedure {
    /// The motion that carries it.
    #[must_use]
    pub fn excitation(&self) -> Excitation {
        // a little longer, so that the delay line of the recorder is fed to the end
        let seconds = self.warm_up_s + self.record_s + 0.02;
        Excitation {
            wave: self.wave,
            amplitude_m: self.amplitude_m,
            frequency_hz: self.frequency_hz,
            seconds,
        }
    }

    /// Checks it against the device.
    ///
    /// # Errors
    /// The parameter that is out of range, with what would be accepted.
    pub fn validate(&self, device: &Device) -> Result<(), Refused> {
        let refuse =
            |parameter, value, accepted, why| Err(Refused { effect: None, parameter, value, accepted, why });
        let ramp = crate::excitation::RAMP_IN_S;
        if !(self.warm_up_s >= ramp && self.warm_up_s <= 600.0) {
            return refuse(
                "warm_up",
                self.warm_up_s,
                Accepted::Between(ramp, 600.0),
                "s; from the end of the ramp",
            );
        }
        if !(self.record_s >= 0.1 && self.record_s <= 600.0) {
            return refuse("record", self.record_s, Accepted::Between(0.1, 600.0), "s");
        }
        if !(self.dv > 0.0 && self.dv <= device.overspeed) {
            return refuse("dv", self.dv, Accepted::Between(device.metre_per_count, device.overspeed), "m/s");
        }
        self.excitation().validate(device)
    }
}

/// Sums over the used samples of one direction. r: accelerometer as it reads, v: velocity, f: load cell.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct DirectionSums {
    pub samples: u32,
    pub r: Sum,
    pub v: Sum,
    pub f: Sum,
    pub rr: Sum,
    pub rv: Sum,
    pub vv: Sum,
    pub rf: Sum,
    pub vf: Sum,
    pub ff: Sum,
}

/// Everything the five parameters need, in 250 bytes.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Sums {
    pub(super) period: f32,
    pub(super) dv: f32,
    pub(super) positive: DirectionSums,
    pub(super) negative: DirectionSums,
    /// All recorded samples, for the accelerometer: d is the differentiated velocity.
    pub(super) recorded: u32,
    pub(super) d: Sum,
    pub(super) r: Sum,
    pub(super) dd: Sum,
    pub(super) dr: Sum,
    pub(super) rr: Sum,
    /// Squares of fourth differences of velocity: what is left of a smooth motion is noise.
    pub(super) rough: Sum,
    /// (force, accelerometer) where the smoothed force was largest while |v| < Δv, and smallest.
    pub(super) highest: Option<(f32, f32)>,
    pub(super) lowest: Option<(f32, f32)>,
}

/// Velocity, accelerometer, force of one sample.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Sample {
    v: f32,
    r: f32,
    f: f32,
}

/// A running identification.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Recorder {
    begin: u32,
    end: u32,
    rate: f32,
    previous: Sample,
    /// The last five samples with their velocity centred, oldest first.
    line: [Sample; 5],
    filled: u8,
    /// Smoothed force and accelerometer.
    smooth: (f32, f32),
    sums: Sums,
}

impl Recorder {
    pub(crate) fn new(config: &Config, procedure: &Procedure) -> Self {
        let rate = config.timing.rate;
        // `as` saturates
        let begin = (procedure.warm_up_s * rate) as u32;
        Self {
            begin,
            end: begin.saturating_add((procedure.record_s * rate) as u32),
            rate,
            previous: Sample::default(),
            line: [Sample::default(); 5],
            filled: 0,
            smooth: (0.0, 0.0),
            sums: Sums { period: config.device.period, dv: procedure.dv, ..Sums::default() },
        }
    }

    /// Samples accumulated so far.
    #[must_use]
    pub fn recorded(&self) -> u32 {
        self.sums.recorded
    }

    /// Takes one sample; the sums when the recording is complete.
    pub(crate) fn sample(&mut self, elapsed: u32, v: f32, r: f32, f: f32) -> Option<Sums> {
        if elapsed < self.begin {
            return None;
        }
        // v is the mean over the period that ended now, the previous one over that before: their mean belongs to
        // the sample between
        let centred = Sample { v: 0.5 * (self.previous.v + v), ..self.previous };
        self.previous = Sample { v, r, f };
        let [_, a, b, c, d] = self.line;
        self.line = [a, b, c, d, centred];
        if self.filled < 6 {
            self.filled += 1;
            if self.filled == 1 {
                self.smooth = (f, r);
            }
            return None;
        }
        self.accumulate();
        (elapsed >= self.end).then_some(self.sums)
    }

    fn accumulate(&mut self) {
        let [a, b, now, d, e] = self.line;
        let sums = &mut self.sums;
        let slope = (8.0 * (d.v - b.v) - (e.v - a.v)) * self.rate * (1.0 / 12.0);
        let rough = e.v - 4.0 * d.v + 6.0 * now.v - 4.0 * b.v + a.v;
        sums.recorded += 1;
        sums.d.add(slope);
        sums.r.add(now.r);
        sums.dd.add(slope * slope);
        sums.dr.add(slope * now.r);
        sums.rr.add(now.r * now.r);
        sums.rough.add(rough * rough);
        self.smooth.0 += 0.25 * (now.f - self.smooth.0);
        self.smooth.1 += 0.25 * (now.r - self.smooth.1);
        let side = if now.v >= sums.dv {
            &mut sums.positive
        } else if now.v <= -sums.dv {
            &mut sums.negative
        } else {
            if sums.highest.is_none_or(|(f, _)| self.smooth.0 > f) {
                sums.highest = Some(self.smooth);
            }
            if sums.lowest.is_none_or(|(f, _)| self.smooth.0 < f) {
                sums.lowest = Some(self.smooth);
            }
            return;
        };
        side.samples += 1;
        side.r.add(now.r);
        side.v.add(now.v);
        side.f.add(now.f);
        side.rr.add(now.r * now.r);
        side.rv.add(now.r * now.v);
        side.vv.add(now.v * now.v);
        side.rf.add(now.r * now.f);
        side.vf.add(now.v * now.f);
        side.ff.add(now.f * now.f);
    }
}
