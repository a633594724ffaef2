//! The motion at every sample without the low-pass of the fit, for the search for a step of friction.
//!
//! A filter spreads a step over several samples, in which a body that leaves rest gains more speed than Δv. So each channel is
//! smoothed only as much as its noise requires.

use signals::{Channels, Measured, Stretch, noise_variance, quantum, smooth};

/// Velocity and acceleration at every sample; not a number outside the stretches.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Unfiltered {
    pub velocity: Vec<f64>,
    /// Standard deviation of each velocity.
    pub velocity_std: Vec<f64>,
    pub acceleration: Vec<f64>,
    /// Samples to either side over which the acceleration is an average; 0 where the accelerometer gives it.
    pub half: usize,
}

/// Longest window of the local polynomials, samples to either side.
const WIDEST: usize = 25;
/// Times the tolerated error that an accelerometer may have before differences are taken instead.
const NOISY: f64 = 3.0;

/// The motion of `samples` samples, of which `channels` are those of each stretch, with an acceleration whose error is
/// about `tolerated`, m/s².
pub(crate) fn motion(
    samples: usize,
    stretches: &[Stretch],
    channels: &[Channels],
    tolerated: f64,
) -> Unfiltered {
    let nowhere = vec![f64::NAN; samples];
    let mut out = Unfiltered {
        velocity: nowhere.clone(),
        velocity_std: nowhere.clone(),
        acceleration: nowhere,
        half: 0,
    };
    for (stretch, channels) in stretches.iter().zip(channels) {
        let part = of_stretch(channels, tolerated);
        out.half = out.half.max(part.half);
        for (whole, part) in [
            (&mut out.velocity, part.velocity),
            (&mut out.velocity_std, part.velocity_std),
            (&mut out.acceleration, part.acceleration),
        ] {
            whole[stretch.range.clone()].copy_from_slice(&stretch.back(part));
        }
    }
    out
}

fn of_stretch(channels: &Channels, tolerated: f64) -> Unfiltered {
    let mut motion = estimated(channels, tolerated);
    // A position in counts is as old as its last edge, by up to the time of a count: what the body gained since.
    let count = quantum(&channels.position);
    for ((std, v), a) in motion.velocity_std.iter_mut().zip(&motion.velocity).zip(&motion.acceleration) {
        let old = (count / v.abs()).min(channels.dt);
        *std = std.hypot(a * old / 3f64.sqrt());
    }
    motion
}

fn estimated(channels: &Channels, tolerated: f64) -> Unfiltered {
    let dt = channels.dt;
    let position = &channels.position;
    let velocity = channels.velocity.clone();
    let (var_x, var_v) = (noise_variance(position), velocity.as_deref().map(noise_variance));
    let reading = channels.acceleration.clone();
    let var_a = reading.as_deref().map_or(f64::INFINITY, noise_variance);
    if let Some(acceleration) = reading.filter(|_| var_a <= (NOISY * tolerated).powi(2)) {
        // what is differentiated over three samples hardly weighs beside the integrated accelerometer
        let (velocity, var_v) = match (velocity, var_v) {
            (Some(velocity), Some(variance)) => (velocity, variance),
            _ => (slopes(position, 1, dt), slope_variance(1, dt) * var_x),
        };
        let motion = smooth(&Measured {
            position: (position, var_x),
            velocity: (&velocity, var_v),
            acceleration: (&acceleration, var_a),
            dt,
        });
        return Unfiltered {
            velocity: motion.velocity,
            velocity_std: motion.velocity_std,
            acceleration,
            half: 0,
        };
    }
    let enough = |error: &dyn Fn(usize) -> f64| {
        (1..WIDEST).find(|h| error(*h) <= tolerated * tolerated).unwrap_or(WIDEST)
    };
    let of_position = enough(&|h| curvature_variance(h, dt) * var_x);
    match (velocity, var_v) {
        (Some(velocity), Some(var_v)) if enough(&|h| slope_variance(h, dt) * var_v) <= of_position => {
            let half = enough(&|h| slope_variance(h, dt) * var_v);
            Unfiltered {
                acceleration: slopes(&velocity, half, dt),
                velocity_std: vec![var_v.sqrt(); velocity.len()],
                velocity,
                half,
            }
        }
        _ => Unfiltered {
            velocity: slopes(position, of_position, dt),
            velocity_std: vec![(slope_variance(of_position, dt) * var_x).sqrt(); position.len()],
            acceleration: curvatures(position, of_position, dt),
            half: of_position,
        },
    }
}

/// Σi², and n·Σi⁴ − (Σi²)² over n, of the 2h + 1 whole numbers around 0.
fn sums(half: usize) -> (f64, f64) {
    let n = (2 * half + 1) as f64;
    (n * (n * n - 1.0) / 12.0, n * (n * n - 1.0) * (n * n - 4.0) / 180.0)
}

/// Variance of the slope of a parabola through 2h + 1 samples of unit variance.
fn slope_variance(half: usize, dt: f64) -> f64 {
    1.0 / (sums(half).0 * dt * dt)
}

/// The same of its second derivative.
fn curvature_variance(half: usize, dt: f64) -> f64 {
    4.0 / (sums(half).1 * dt.powi(4))
}

/// The samples around each; at the ends those around the nearest sample that has so many on both sides.
fn around(series: &[f64], half: usize, each: impl Fn(&[f64], f64) -> f64) -> Vec<f64> {
    let n = series.len();
    let half = half.min(n.saturating_sub(1) / 2);
    (0..n)
        .map(|i| {
            let middle = i.clamp(half, n - 1 - half);
            each(&series[middle - half..=middle + half], i as f64 - middle as f64)
        })
        .collect()
}

/// Slope of the parabola through the 2h + 1 samples around each.
fn slopes(series: &[f64], half: usize, dt: f64) -> Vec<f64> {
    around(series, half, |part, off| (slope(part) + 2.0 * off * quadratic(part)) / dt)
}

/// Second derivative of that parabola.
fn curvatures(series: &[f64], half: usize, dt: f64) -> Vec<f64> {
    around(series, half, |part, _| 2.0 * quadratic(part) / (dt * dt))
}

fn numbered(part: &[f64]) -> impl Iterator<Item = (f64, f64)> + '_ {
    let half = (part.len() / 2) as f64;
    part.iter().enumerate().map(move |(k, y)| (k as f64 - half, *y))
}

fn slope(part: &[f64]) -> f64 {
    numbered(part).map(|(i, y)| i * y).sum::<f64>() / sums(part.len() / 2).0
}

fn quadratic(part: &[f64]) -> f64 {
    let (second, fourth) = sums(part.len() / 2);
    let mean = second / part.len() as f64;
    numbered(part).map(|(i, y)| (i * i - mean) * y).sum::<f64>() / fourth
}
