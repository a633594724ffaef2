//! The clock of the device against that of this computer.

/// Shortest recording that tells a ratio, s.
const SHORTEST_S: f64 = 2.0;
/// Samples within this time are one reading: the earliest arrival counts, s.
const READING_S: f64 = 0.01;
/// Largest deviation of a clock. A virtual device that does not run in real time deviates by more.
const PLAUSIBLE: f64 = 0.05;

/// Times of samples by the device and of their arrival by this computer.
///
/// A line only delays: the earliest of many arrivals comes nearest to its sample. The ratio is that of the earliest arrivals in
/// the first and in the last quarter.
///
/// ```
/// let mut ratio = client::ClockRatio::default();
/// for k in 0..10_000 {
///     let delay = 0.001 * f64::from(k % 7);
///     ratio.sample(1.004 * 0.001 * f64::from(k), 0.001 * f64::from(k) + delay);
/// }
/// let (ratio, error) = ratio.measured().expect("10 s are enough");
/// assert!((ratio - 1.004).abs() < error && error < 0.002);
/// ```
#[derive(Debug, Clone, Default)]
pub struct ClockRatio {
    /// Device time and least delay of each reading, s.
    readings: Vec<(f64, f64)>,
}

impl ClockRatio {
    /// A sample of this time by the device that arrived at this time by this computer, both s since any moment.
    pub fn sample(&mut self, device: f64, arrived: f64) {
        let delay = arrived - device;
        match self.readings.last_mut() {
            Some((begin, least)) if device - *begin < READING_S => *least = least.min(delay),
            _ => self.readings.push((device, delay)),
        }
    }

    /// Seconds of the device in a second of this computer, and the largest error by the delays of the line. `None` for a
    /// recording too short, or a device that does not run in real time.
    #[must_use]
    pub fn measured(&self) -> Option<(f64, f64)> {
        let (begin, end) = (self.readings.first()?.0, self.readings.last()?.0);
        let quarter = 0.25 * (end - begin);
        let (first, first_spread) = earliest(self.readings.iter().filter(|(t, _)| *t <= begin + quarter))?;
        let (last, last_spread) = earliest(self.readings.iter().filter(|(t, _)| *t >= end - quarter))?;
        let span = last.0 - first.0;
        let elapsed = span + last.1 - first.1;
        let ratio = span / elapsed;
        let error = (first_spread + last_spread) / elapsed;
        (end - begin >= SHORTEST_S && elapsed > 0.0 && (ratio - 1.0).abs() < PLAUSIBLE)
            .then_some((ratio, error))
    }
}

/// The reading with the least delay, and how far the median is above it, s.
fn earliest<'a>(readings: impl Iterator<Item = &'a (f64, f64)>) -> Option<((f64, f64), f64)> {
    let mut readings: Vec<_> = readings.copied().collect();
    readings.sort_by(|a, b| a.1.total_cmp(&b.1));
    let least = *readings.first()?;
    Some((least, readings.get(readings.len() / 2)?.1 - least.1))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Delays between 0.2 and 5 ms from a fixed sequence.
    fn delay(seed: u64, k: u64) -> f64 {
        let mut x = (seed << 32) ^ k.wrapping_mul(0x9e37_79b9_7f4a_7c15);
        x ^= x >> 31;
        x = x.wrapping_mul(0xbf58_476d_1ce4_e5b9);
        2e-4 + 4.8e-3 * ((x >> 40) as f64 / (1u64 << 24) as f64)
    }

    #[test]
    fn a_ratio_is_found_in_spite_of_delays() {
        let mut worst = 0.0_f64;
        for seed in 0..40 {
            let truth = 1.0 + 1e-3 * (seed as f64 - 20.0) / 2.0;
            let mut clock = ClockRatio::default();
            for k in 0..20_000 {
                let real = 1e-3 * k as f64;
                clock.sample(truth * real, real + delay(seed, k));
            }
            let (ratio, error) = clock.measured().expect("20 s");
            worst = worst.max((ratio - truth).abs());
            assert!(
                (ratio - truth).abs() <= error && error < 1e-3,
                "seed {seed}: {ratio} ± {error}, truth {truth}"
            );
        }
        println!("clock ratio of 40 recordings of 20 s: at most {worst:.1e} off");
        assert!(worst < 1e-4);
    }

    #[test]
    fn virtual_time_and_short_recordings_have_no_ratio() {
        let (mut fast, mut short) = (ClockRatio::default(), ClockRatio::default());
        for k in 0..10_000 {
            fast.sample(1e-3 * f64::from(k), 1e-6 * f64::from(k));
        }
        for k in 0..1_000 {
            short.sample(1e-3 * f64::from(k), 1e-3 * f64::from(k));
        }
        assert_eq!((fast.measured(), short.measured()), (None, None));
        assert_eq!(ClockRatio::default().measured(), None);
    }
}
