//! One gap-free stretch of a recording in the plane behind the filter, with what is known of its direction of motion.
//!
//! As on a line, samples at which the direction is not known are set aside before the filter's average is formed, on both
//! sides of the equation alike: friction of a body at rest is whatever balances the applied force.

use signals::{
    Channels, LowPass, SHARPER, SMEARED, derived_noise, differentiated, four_point_difference, noise_std,
    quantile, soften,
};

/// Speeds below this many standard deviations of the velocity's noise have no direction.
const DIRECTED: f64 = 6.0;
/// Speeds below this share of the fast ones count as rest.
const SLOW: f64 = 0.01;
/// Cosine of the largest turn that the filter may smear, from one side of its ring to the other.
const TURN: f64 = 0.3;

/// The stretch, both axes at once.
#[derive(Debug, Clone)]
pub struct Track {
    /// The channels it was made of.
    pub raw: [Channels; 2],
    /// The filter.
    pub filter: LowPass,
    /// Position behind the sharper filter, m.
    pub x: [Vec<f64>; 2],
    /// Velocity behind the sharper filter, m/s.
    pub v: [Vec<f64>; 2],
    /// Acceleration behind the sharper filter, m/s².
    pub a: [Vec<f64>; 2],
    /// Force behind the sharper filter, N.
    pub f: [Vec<f64>; 2],
    /// Speed, m/s.
    pub speed: Vec<f64>,
    /// Direction of the motion, a unit vector.
    pub direction: [Vec<f64>; 2],
    /// 0 where the direction is not known or the filter has not settled, 1 where the body slides, smooth between.
    pub mask: Vec<f64>,
    /// Samples averaged into one row.
    pub stride: usize,
    /// Speed below which the direction is not known, m/s.
    pub guard: f64,
    /// Standard deviation of the noise of each acceleration in a row, m/s².
    pub acceleration_noise: [f64; 2],
}

/// A source of a series: its values, the noise it is weighted by, and the noise of a row.
struct Source {
    series: Vec<f64>,
    noise: f64,
    of_row: f64,
}

/// Sum of two sources weighted by their noise.
fn combined(one: Source, other: Option<Source>) -> Source {
    let Some(other) = other else { return one };
    let information = |noise: f64| 1.0 / (noise * noise).max(1e-300);
    let (a, b) = (information(one.noise), information(other.noise));
    let (a, b) = (a / (a + b), b / (a + b));
    Source {
        series: one.series.iter().zip(&other.series).map(|(x, y)| a * x + b * y).collect(),
        noise: (a * one.noise).hypot(b * other.noise),
        of_row: (a * one.of_row).hypot(b * other.of_row),
    }
}

/// The filters of a stretch.
struct Chain {
    filter: LowPass,
    sharp: LowPass,
    sharper: f64,
    cutoff: f64,
    stride: usize,
    dt: f64,
}

impl Chain {
    fn new(cutoff: f64, dt: f64) -> Self {
        let sharper = (SHARPER * cutoff).min(0.3 / dt);
        let stride = ((1.0 / dt) / (2.5 * cutoff)).round().max(1.0) as usize;
        Self {
            filter: LowPass::new(cutoff, dt),
            sharp: LowPass::new(sharper, dt),
            sharper,
            cutoff,
            stride,
            dt,
        }
    }

    /// A series behind the sharper filter, `times` differentiated.
    fn derivative(&self, series: &[f64], times: i32) -> Vec<f64> {
        let first = self.sharp.apply(series);
        (0..times).fold(first, |series, _| four_point_difference(&series, self.dt))
    }

    /// Noise that a row has of white noise of 1 in a series that is `times` differentiated: behind both filters, averaged over
    /// a row. The noise of a sample behind the filter is larger, and taken for it an attenuation is corrected twice.
    fn row_gain(&self, times: i32) -> f64 {
        let half = 2 * (self.filter.settle() + self.sharp.settle()) + 8 * self.stride + 16;
        let mut impulse = vec![0.0; 2 * half];
        impulse[half] = 1.0;
        let response = self.filter.apply(&self.derivative(&impulse, times));
        let mean = |samples: &[f64]| samples.iter().sum::<f64>() / self.stride as f64;
        response.windows(self.stride).map(|samples| mean(samples).powi(2)).sum::<f64>().sqrt()
    }

    /// Position, velocity and acceleration of an axis behind the sharper filter.
    fn motion(&self, raw: &Channels) -> [Source; 3] {
        let source = |series: &[f64], times: i32, judged: f64| {
            let white = noise_std(series);
            Source {
                series: self.derivative(series, times),
                noise: white * differentiated(times, judged, self.dt),
                of_row: white * self.row_gain(times),
            }
        };
        let x = source(&raw.position, 0, self.sharper);
        let velocity = raw.velocity.as_deref();
        let v = combined(
            source(&raw.position, 1, self.sharper),
            velocity.map(|column| source(column, 0, self.sharper)),
        );
        let slope = source(&raw.position, 2, self.cutoff);
        // of two sources of one motion the quieter; the accelerometer is beside both
        let by_motion = match velocity.map(|column| source(column, 1, self.cutoff)) {
            Some(other) if other.noise < slope.noise => other,
            _ => slope,
        };
        let shown = raw.acceleration.as_deref().map(|column| source(column, 0, self.cutoff));
        [x, v, combined(by_motion, shown)]
    }
}

impl Track {
    /// Filters both axes at `cutoff` Hz and finds where the direction is known.
    #[must_use]
    pub fn new(raw: [Channels; 2], cutoff: f64) -> Self {
        let dt = raw[0].dt;
        let chain = Chain::new(cutoff, dt);
        let (sharper, stride) = (chain.sharper, chain.stride);
        let [[px, vx, ax], [py, vy, ay]] = [&raw[0], &raw[1]].map(|c| chain.motion(c));
        let acceleration_noise = [ax.of_row, ay.of_row];
        let [[px, vx, ax], [py, vy, ay]] = [[px, vx, ax], [py, vy, ay]].map(|axis| axis.map(|s| s.series));
        let Chain { filter, sharp, .. } = chain;
        let speed: Vec<f64> = vx.iter().zip(&vy).map(|(x, y)| x.hypot(*y)).collect();
        let of = |v: &[f64]| v.iter().zip(&speed).map(|(v, s)| v / s.max(1e-300)).collect::<Vec<_>>();
        let direction = [of(&vx), of(&vy)];
        let slow = raw.iter().map(|c| derived_noise(c, sharper).velocity).fold(0.0, f64::max);
        let guard = (DIRECTED * slow).max(SLOW * quantile(&speed, 0.95));
        let n = speed.len();
        let mut track = Self {
            f: [sharp.apply(&raw[0].force), sharp.apply(&raw[1].force)],
            acceleration_noise,
            filter,
            x: [px, py],
            v: [vx, vy],
            a: [ax, ay],
            speed,
            direction,
            mask: vec![1.0; n],
            stride,
            guard,
            raw,
        };
        // as far as an edge of the velocity is smeared
        let ring = (SMEARED / (sharper * dt)).ceil() as usize;
        let unknown: Vec<bool> = (0..n).map(|i| track.is_unknown(i, ring)).collect();
        for i in (0..n).filter(|i| unknown[*i]) {
            track.mask[i.saturating_sub(ring)..(i + ring + 1).min(n)].fill(0.0);
        }
        let settle = filter.settle().min(n / 4);
        track.mask[..settle].fill(0.0);
        track.mask[n - settle..].fill(0.0);
        soften(&mut track.mask, (SMEARED / (cutoff * dt)).ceil() as usize);
        track
    }

    /// Too slow, or turning faster than the filter shows.
    fn is_unknown(&self, i: usize, ring: usize) -> bool {
        if self.speed[i] < self.guard {
            return true;
        }
        let (low, high) = (i.saturating_sub(ring), (i + ring).min(self.len() - 1));
        let [x, y] = &self.direction;
        x[low] * x[high] + y[low] * y[high] < TURN
    }

    /// Number of samples.
    #[must_use]
    pub fn len(&self) -> usize {
        self.speed.len()
    }

    /// No samples at all.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.speed.is_empty()
    }

    /// Number of rows of one axis.
    #[must_use]
    pub fn row_count(&self) -> usize {
        self.len() / self.stride
    }

    /// Time of the middle of row `r`, s.
    #[must_use]
    pub fn row_time(&self, r: usize) -> f64 {
        self.raw[0].start
            + (r * self.stride) as f64 * self.raw[0].dt
            + 0.5 * (self.stride - 1) as f64 * self.raw[0].dt
    }

    /// Rows of a series of one axis: what is set aside taken out, behind the filter, averaged over `stride` samples.
    #[must_use]
    pub fn rows(&self, series: &[f64]) -> Vec<f64> {
        let masked: Vec<f64> = series.iter().zip(&self.mask).map(|(x, m)| x * m).collect();
        let passed = self.filter.apply(&masked);
        let mean = |r: usize| {
            let samples = r * self.stride..(r + 1) * self.stride;
            samples.map(|i| passed[i] * self.mask[i]).sum::<f64>() / self.stride as f64
        };
        (0..self.row_count()).map(mean).collect()
    }

    /// Share of each row's squares that is used.
    #[must_use]
    pub fn share(&self) -> Vec<f64> {
        self.rows(&vec![1.0; self.len()]).iter().map(|s| s * s).collect()
    }

    /// Mean over the used samples of each row; NaN where none is.
    #[must_use]
    pub fn row_means(&self, series: &[f64]) -> Vec<f64> {
        let mean = |r: usize| {
            let samples = r * self.stride..(r + 1) * self.stride;
            let (sum, weight) =
                samples.fold((0.0, 0.0), |(s, w), i| (s + series[i] * self.mask[i], w + self.mask[i]));
            if weight > 0.0 { sum / weight } else { f64::NAN }
        };
        (0..self.row_count()).map(mean).collect()
    }
}
