//! The recorded force between its samples.

use friction::Scalar;

/// What the force does between two samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Between {
    /// A controller holds it from one sample to the next.
    Held,
    /// It has nothing above half the sampling rate: an analogue signal that was sampled.
    BandLimited,
}

/// Fine samples of a band-limited signal for each recorded one.
const FINE: usize = 8;
/// Half length of the interpolating filter, recorded samples.
const HALF: i64 = 32;
/// Shape of its Kaiser window: side lobes 80 dB down.
const KAISER: f64 = 8.0;

/// A recorded force, N, that a free run can ask for at any time within the recording.
#[derive(Debug, Clone, PartialEq)]
pub struct Drive {
    /// s.
    dt: f64,
    between: Between,
    /// As recorded, or [`FINE`] for each recorded sample.
    values: Vec<f64>,
}

impl Drive {
    /// From samples `dt` s apart. Beyond its ends the force stays as it is there.
    ///
    /// ```
    /// use benchmark::{Between, Drive};
    /// let wave = |t: f64| (0.9 * t).sin();
    /// let samples: Vec<f64> = (0..200).map(|i| wave(f64::from(i))).collect();
    /// let drive = Drive::new(&samples, 1.0, Between::BandLimited);
    /// let [_, middle, _] = drive.over(100, 0.25, 0.5, 0.0_f64);
    /// assert!((middle - wave(100.5)).abs() < 1e-4);
    /// ```
    #[must_use]
    pub fn new(force: &[f64], dt: f64, between: Between) -> Self {
        let values = match between {
            Between::Held => force.to_vec(),
            Between::BandLimited => interpolated(force),
        };
        Self { dt, between, values }
    }

    /// Time between samples, s.
    #[must_use]
    pub fn dt(&self) -> f64 {
        self.dt
    }

    /// Steps of an integrator for each sample. Resonances sit at a tenth of the rate: four steps of fourth order take
    /// them to 1e-6.
    #[must_use]
    pub fn steps(&self) -> usize {
        match self.between {
            Between::Held => 1,
            Between::BandLimited => 4,
        }
    }

    /// Force at the beginning, the middle and the end of a step, N. The step begins the share `from` of a sample behind sample
    /// `sample` and is the share `share` of it long; the force is taken `later` s later.
    #[inline]
    pub fn over<S: Scalar>(&self, sample: usize, from: f64, share: f64, later: S) -> [S; 3] {
        let shift = later / S::lit(self.dt);
        match self.between {
            // the mean over the sample of a signal that steps within it
            Between::Held => [self.line(S::lit(sample as f64) + shift); 3],
            Between::BandLimited => {
                let fine = FINE as f64;
                let at = |part: f64| {
                    self.cubic(S::lit(fine * (sample as f64 + from + part * share)) + shift * S::lit(fine))
                };
                [at(0.0), at(0.5), at(1.0)]
            }
        }
    }

    /// Place of a value and the share of the way to the next, with `margin` values beside both.
    fn between<S: Scalar>(&self, at: S, margin: usize) -> (usize, S) {
        let last = self.values.len().saturating_sub(2 + margin) as f64;
        let at = at.clamp(S::lit(margin as f64), S::lit(last));
        let index = at.re().floor();
        (index as usize, at - S::lit(index))
    }

    fn value<S: Scalar>(&self, index: usize) -> S {
        S::lit(self.values.get(index).or(self.values.last()).copied().unwrap_or(0.0))
    }

    fn line<S: Scalar>(&self, at: S) -> S {
        let (i, f) = self.between(at, 0);
        let (a, b): (S, S) = (self.value(i), self.value(i + 1));
        a + f * (b - a)
    }

    /// Lagrange's cubic through four values.
    fn cubic<S: Scalar>(&self, at: S) -> S {
        let (i, f) = self.between(at, 1);
        let one = S::one();
        let (two, six) = (S::lit(2.0), S::lit(6.0));
        let (before, behind, far) = (f + one, f - one, f - two);
        let [a, b, c, d]: [S; 4] =
            [self.value(i.saturating_sub(1)), self.value(i), self.value(i + 1), self.value(i + 2)];
        (d * before * f * behind - a * f * behind * far) / six
            + (b * before * behind * far - c * before * f * far) / two
    }
}

/// [`FINE`] values for each one, by a windowed sinc.
fn interpolated(force: &[f64]) -> Vec<f64> {
    let filters: Vec<Vec<f64>> = (0..FINE).map(|phase| filter(phase as f64 / FINE as f64)).collect();
    let last = force.len() as i64 - 1;
    let mut out = Vec::with_capacity(force.len() * FINE);
    for i in 0..=last {
        for filter in &filters {
            let near = (i - HALF + 1..=i + HALF).map(|k| force[k.clamp(0, last) as usize]);
            out.push(near.zip(filter).map(|(u, w)| u * w).sum());
        }
    }
    out
}

/// Weights of the samples from −[`HALF`] + 1 to [`HALF`] for a value `phase` behind sample 0; their sum is 1.
fn filter(phase: f64) -> Vec<f64> {
    let weight = |k: i64| {
        let d = k as f64 - phase;
        let r = d / HALF as f64;
        let angle = std::f64::consts::PI * d;
        let sinc = if angle == 0.0 { 1.0 } else { angle.sin() / angle };
        if r.abs() < 1.0 { sinc * bessel_i0(KAISER * (1.0 - r * r).sqrt()) } else { 0.0 }
    };
    let weights: Vec<f64> = (1 - HALF..=HALF).map(weight).collect();
    let sum: f64 = weights.iter().sum();
    weights.into_iter().map(|w| w / sum).collect()
}

/// Modified Bessel function of the first kind and order 0, for |x| below 20.
fn bessel_i0(x: f64) -> f64 {
    let mut term = 1.0;
    let mut sum = 1.0;
    for k in 1..60 {
        term *= (0.5 * x / f64::from(k)).powi(2);
        sum += term;
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn held_force_is_averaged_over_a_delayed_sample() {
        let drive = Drive::new(&[0.0, 1.0, 3.0, 3.0], 1e-3, Between::Held);
        assert_eq!(drive.over(1, 0.0, 1.0, 0.0_f64), [1.0; 3]);
        assert!((drive.over(1, 0.0, 1.0, 0.25e-3_f64)[0] - 1.5).abs() < 1e-12);
        // beyond the ends
        assert_eq!(drive.over(9, 0.0, 1.0, 0.0_f64), [3.0; 3]);
        assert_eq!(drive.over(0, 0.0, 1.0, -1.0_f64), [0.0; 3]);
    }

    #[test]
    fn short_signals_do_not_panic() {
        for n in 0..4 {
            for between in [Between::Held, Between::BandLimited] {
                let drive = Drive::new(&vec![2.0; n], 1.0, between);
                let [a, ..] = drive.over(1, 0.5, 0.25, 0.1_f64);
                assert!(n == 0 || (a - 2.0).abs() < 1e-12, "{n} {between:?} {a}");
            }
        }
    }
}
