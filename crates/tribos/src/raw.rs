//! Raw codes to SI, with the calibration of the header and the velocity estimator of the device.

use haptics::Estimator;

/// One telemetry sample as it came over the line.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Raw {
    /// Free-running timer at the sample, ticks; wraps.
    pub sample_ticks: u32,
    /// Quadrature count; wraps.
    pub count: u32,
    /// Timer at the last encoder edge, ticks.
    pub edge_ticks: u32,
    /// Load cell code.
    pub load_code: u16,
    /// Accelerometer code.
    pub accel_code: u16,
    /// Commanded force, N.
    pub command: f32,
    /// Reference of the excitation, m.
    pub reference: f32,
}

/// What turns codes into SI: the stream header, or the simulated rig's own figures.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Calibration {
    /// Rate of the timer, Hz.
    pub tick_hz: f64,
    /// Handle travel of a count, m.
    pub metre_per_count: f64,
    /// Code of 0 N.
    pub load_offset: f64,
    /// N per code.
    pub load_unit: f64,
    /// Code of 0 m/s².
    pub accel_offset: f64,
    /// m/s² per code.
    pub accel_unit: f64,
}

/// One sample in SI.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Point {
    /// Since the first sample, s.
    pub time: f64,
    /// m.
    pub position: f64,
    /// M/T estimate, the same estimator as on the device, m/s.
    pub velocity: f64,
    /// Accelerometer, m/s².
    pub acceleration: f64,
    /// Load cell, N.
    pub force: f64,
    /// Commanded force, N.
    pub command: f64,
    /// Reference of the excitation, m.
    pub reference: f64,
}

/// Decodes a run of samples.
#[derive(Debug, Clone)]
pub struct Decoding {
    calibration: Calibration,
    estimator: Estimator,
    last_ticks: Option<u32>,
    /// Since the first sample, unwrapped.
    ticks: u64,
}

impl Decoding {
    /// Starts with nothing known.
    #[must_use]
    pub fn new(calibration: Calibration) -> Self {
        Self { calibration, estimator: Estimator::default(), last_ticks: None, ticks: 0 }
    }

    /// The next sample in SI.
    pub fn sample(&mut self, raw: &Raw) -> Point {
        let c = &self.calibration;
        if let Some(last) = self.last_ticks {
            self.ticks += u64::from(raw.sample_ticks.wrapping_sub(last));
        }
        self.last_ticks = Some(raw.sample_ticks);
        self.estimator.sample(raw.sample_ticks, raw.count, raw.edge_ticks);
        Point {
            time: self.ticks as f64 / c.tick_hz,
            position: f64::from(raw.count as i32) * c.metre_per_count,
            velocity: f64::from(self.estimator.counts_per_tick()) * c.metre_per_count * c.tick_hz,
            acceleration: (f64::from(raw.accel_code) - c.accel_offset) * c.accel_unit,
            force: (f64::from(raw.load_code) - c.load_offset) * c.load_unit,
            command: f64::from(raw.command),
            reference: f64::from(raw.reference),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RIG: Calibration = Calibration {
        tick_hz: 170e6,
        metre_per_count: 2.57e-6,
        load_offset: 32_768.0,
        load_unit: 1e-3,
        accel_offset: 32_768.0,
        accel_unit: 0.01,
    };

    #[test]
    fn time_survives_the_wrap_of_the_timer_and_speed_is_exact() {
        let mut decoding = Decoding::new(RIG);
        let mut last = Point::default();
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
            last = decoding.sample(&raw);
        }
        println!("{last:?}");
        assert!((last.time - 39.999).abs() < 1e-9);
        assert!((last.position + 3_999_900.0 * 2.57e-6).abs() < 1e-9);
        assert!((last.velocity + 0.257).abs() < 1e-6);
        assert!((last.force - 1.0).abs() < 1e-12 && (last.acceleration + 1.0).abs() < 1e-12);
    }
}
