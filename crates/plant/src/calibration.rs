//! Conversion between raw codes and SI, shared by the simulated converters and their readers.

/// One analogue channel: SI = (code − `offset_code`) · `unit_per_code`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Channel {
    /// Code that stands for zero, counts.
    pub offset_code: f64,
    /// SI units per code: N (load cell) or m/s² (accelerometer).
    pub unit_per_code: f64,
}

impl Channel {
    /// SI value of a code.
    #[must_use]
    pub fn to_si(&self, code: u16) -> f64 {
        (f64::from(code) - self.offset_code) * self.unit_per_code
    }

    /// Nearest code of an SI value. Saturates at both ends of the converter; NaN gives the code of zero.
    #[must_use]
    pub fn to_code(&self, si: f64) -> u16 {
        let code = si / self.unit_per_code + self.offset_code;
        if code.is_nan() {
            return self.offset_code as u16;
        }
        // `as` saturates, so codes beyond the converter end at 0 and 65 535
        (code + 0.5) as u16
    }

    /// SI values at which the converter saturates, (lowest, highest).
    #[must_use]
    pub fn range(&self) -> (f64, f64) {
        (self.to_si(0), self.to_si(u16::MAX))
    }
}

/// Calibration that converts raw codes to SI. It is *nominal*, from data sheets: as on a real rig it does not contain the
/// gain and offset errors of the sensors ([`crate::Sensor`]).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Calibration {
    /// Rate of the timer of `sample_ticks` and `edge_ticks`, Hz.
    pub tick_hz: u32,
    /// Handle travel of one quadrature count, m.
    pub metre_per_count: f64,
    /// Load cell, N.
    pub load: Channel,
    /// Accelerometer, m/s².
    pub accel: Channel,
}

impl Calibration {
    /// [thesis, table 3-1]: 8.896 N/V over ±5 V (10 lbf is 44.48 N) and ±50 g, on 16-bit oversampled codes.
    #[must_use]
    pub fn thesis() -> Self {
        let codes = 65_536.0;
        Self {
            tick_hz: 170_000_000,
            metre_per_count: 2.57e-6,
            load: Channel { offset_code: 32_768.0, unit_per_code: 8.896 * 10.0 / codes },
            accel: Channel { offset_code: 32_768.0, unit_per_code: 100.0 * 9.806_65 / codes },
        }
    }

    /// Handle position of an encoder count, m. The count is two's complement: it starts at 0 and may become negative.
    #[must_use]
    pub fn position(&self, count: u32) -> f64 {
        f64::from(count as i32) * self.metre_per_count
    }

    /// Time from one stamp to a later one, s, across at most one wrap of the timer.
    #[must_use]
    pub fn seconds_between(&self, earlier: u32, later: u32) -> f64 {
        f64::from(later.wrapping_sub(earlier)) / f64::from(self.tick_hz)
    }
}

impl Default for Calibration {
    fn default() -> Self {
        Self::thesis()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_round_trip_and_saturate() {
        let c = Calibration::thesis();
        for channel in [c.load, c.accel] {
            for code in (0..=u16::MAX).step_by(97) {
                assert_eq!(channel.to_code(channel.to_si(code)), code);
            }
            let (low, high) = channel.range();
            assert_eq!(channel.to_code(low * 2.0), 0);
            assert_eq!(channel.to_code(high * 2.0), u16::MAX);
            assert_eq!(channel.to_code(f64::NAN), 32_768);
            assert_eq!(channel.to_code(f64::NEG_INFINITY), 0);
        }
        println!("load cell range {:?} N, {} N per code", c.load.range(), c.load.unit_per_code);
        assert_eq!(c.position(u32::MAX), -2.57e-6);
        assert_eq!(c.seconds_between(u32::MAX, 169_999), 1e-3);
    }
}
