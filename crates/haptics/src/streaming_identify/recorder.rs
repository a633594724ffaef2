//! What runs in the control step: delay line, differences, sums.

use super::moments::{Codes, Moments, SUMS, per_m_s, steps};
use crate::{Accepted, Config, Device, Excitation, Reason, Refused, Wave};
use friction::Dimension;

/// Bands of speed. All but the last are of one width and span the lower three tenths of the top speed; the last has the rest.
pub const BANDS: usize = 12;
/// Share of the top speed in which Δv is looked for.
const SLOW: f32 = 0.3;

/// Speed beyond which the handle is surely not at rest, as a share of a band.
pub(super) const MOVING: f32 = 0.25;

/// Highest frequency of the default device at the amplitude of the default procedure, Hz.
const FASTEST_HZ: f32 = 5.89;
/// Highest frequency of the procedure on any device, Hz: a hundred periods of the slowest loop.
const MOST_HZ: f32 = 10.0;

/// The identification procedure. `default()` is that of [thesis, ch. 3.5.2, 3.5.3].
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
}

impl Default for Procedure {
    fn default() -> Self {
        Self { wave: Wave::Sine, amplitude_m: 0.01, frequency_hz: 2.0, warm_up_s: 10.0, record_s: 2.0 }
    }
}

impl Procedure {
    /// The default procedure on this device: the same share of the stroke, and of the highest frequency.
    #[must_use]
    pub fn of(device: &Device) -> Self {
        let own = Self::default();
        let amplitude_m = device.length(own.amplitude_m);
        let fastest = Excitation { amplitude_m, ..own.excitation() }.fastest(device);
        Self { amplitude_m, frequency_hz: MOST_HZ.min(own.frequency_hz * (fastest / FASTEST_HZ)), ..own }
    }

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

    /// Width of a band of speed, m/s: what Δv is resolved to.
    #[must_use]
    pub fn band_width(&self) -> f32 {
        let top = self.amplitude_m * self.frequency_hz * core::f32::consts::TAU * self.wave.speed_factor();
        top * (SLOW / (BANDS - 1) as f32)
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
                Reason::of(Dimension::TIME, "from the end of the ramp"),
            );
        }
        // the sums hold 60 000 samples, whatever those are
        let longest = 60_000.0 * device.period;
        if !(self.record_s >= 0.1 && self.record_s <= longest) {
            return refuse(
                "record",
                self.record_s,
                Accepted::Between(0.1, longest),
                Reason::of(Dimension::TIME, ""),
            );
        }
        self.excitation().validate(device)
    }
}

/// Numbers in a band: the moments of both directions.
const IN_BAND: usize = 2 * SUMS;
/// Numbers a recording ends with.
pub const NUMBERS: usize = BANDS * IN_BAND;

/// One number of a recording. They come one by one, the last index first: the fastest band is asked for first, and no
/// control period carries more than it can.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Number {
    /// Band, direction and sum, counted through from 0 to [`NUMBERS`] − 1.
    pub index: u16,
    /// The sum.
    pub value: i64,
}

impl Number {
    /// Its band, and whether it is the first to come or the last.
    pub(super) fn band(&self) -> (usize, bool, bool) {
        let (band, within) = (usize::from(self.index) / IN_BAND, usize::from(self.index) % IN_BAND);
        (band, within == IN_BAND - 1, within == 0)
    }

    /// Where it belongs in its band.
    pub(super) fn place<'a>(&self, ways: &'a mut [Moments; 2]) -> Option<&'a mut i64> {
        let within = usize::from(self.index) % IN_BAND;
        ways.get_mut(within / SUMS)?.0.get_mut(within % SUMS)
    }
}

/// An identification: its progress and its sums. It stays where it is and is read number by number.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Recorder {
    begin: u32,
    end: u32,
    /// Steps of velocity in 1 m/s.
    per_m_s: f32,
    /// Bands per step of centred velocity, times 2³².
    per_step: u32,
    /// Speed beyond which the handle is surely not at rest, and what it gains in two periods when it leaves rest.
    moving: i32,
    gaining: i32,
    /// Bands that are cleared: one a step, so that no step clears them all.
    cleared: u8,
    /// Mean velocities over the last six periods, oldest first, steps.
    means: [i32; 6],
    /// Codes at the ends of the last four periods.
    codes: [Codes; 4],
    filled: u8,
    bands: [[Moments; 2]; BANDS],
}

impl Default for Recorder {
    fn default() -> Self {
        Self {
            begin: 0,
            end: 0,
            per_m_s: 0.0,
            per_step: 0,
            moving: 0,
            gaining: 0,
            cleared: 0,
            means: [0; 6],
            codes: [Codes::default(); 4],
            filled: 0,
            bands: [[Moments::default(); 2]; BANDS],
        }
    }
}

impl Recorder {
    /// Begins anew.
    pub(crate) fn start(&mut self, config: &Config, procedure: &Procedure) {
        let rate = config.timing.rate;
        self.per_m_s = per_m_s(&config.device);
        let width = procedure.band_width() * (2.0 * self.per_m_s);
        // `as` saturates
        self.begin = (procedure.warm_up_s * rate) as u32;
        self.end = self.begin.saturating_add((procedure.record_s * rate) as u32);
        self.per_step = (4_294_967_296.0 / width) as u32;
        self.moving = (MOVING * width) as i32;
        self.gaining = (0.25 * width) as i32;
        self.cleared = 0;
        self.filled = 0;
    }

    /// A number of the last recording.
    #[must_use]
    pub fn number(&self, index: u16) -> Option<Number> {
        let at = usize::from(index);
        let moments = self.bands.as_flattened().get(at / SUMS)?;
        Some(Number { index, value: *moments.0.get(at % SUMS)? })
    }

    /// Takes one sample; true when the recording is complete.
    pub(crate) fn sample(&mut self, elapsed: u32, velocity: f32, accel_code: u16, load_code: u16) -> bool {
        if let Some(band) = self.bands.get_mut(usize::from(self.cleared)) {
            *band = Default::default();
            self.cleared += 1;
            return false;
        }
        if elapsed < self.begin {
            return false;
        }
        let [_, a, b, c, d, e] = self.means;
        self.means = [a, b, c, d, e, steps(velocity, self.per_m_s)];
        let [_, x, y, z] = self.codes;
        self.codes = [x, y, z, Codes::new(accel_code, load_code)];
        if self.filled < 6 {
            self.filled += 1;
            return false;
        }
        self.accumulate();
        elapsed >= self.end
    }

    fn accumulate(&mut self) {
        let [a, before, now, after, e, _] = self.means;
        let [codes, ..] = self.codes;
        // the velocity at the end of a period, from the means over it and over the next; the sum is kept
        let v = now + after;
        let speed = v.unsigned_abs();
        let index = ((u64::from(speed) * u64::from(self.per_step)) >> 32) as usize;
        let way = usize::from(v < 0);
        let Some(moments) = self.bands.get_mut(index.min(BANDS - 1)).and_then(|ways| ways.get_mut(way))
        else {
            return;
        };
        moments.add([a, before, now, after, e], v, codes);
        let gained = if way == 0 { after - before } else { before - after };
        if index < BANDS - 1 && v.abs() > self.moving && 2 * gained > self.gaining {
            moments.leave(codes);
        }
    }
}
