//! Cost of estimating a motion, by number of samples and channels: `cargo bench -p signals`.

use divan::Bencher;
use divan::counter::ItemsCount;
use signals::{Observation, Observed, estimate_motion};
use std::f64::consts::TAU;

fn main() {
    divan::main();
}

/// A sine of 1.3 Hz at 1 kHz, with an encoder of 2.57 µm and two analogue channels that carry a regular error.
fn channels(samples: usize) -> (Vec<f64>, [Vec<f64>; 3]) {
    let time: Vec<f64> = (0..samples).map(|i| 1e-3 * i as f64).collect();
    let w = TAU * 1.3;
    let ripple = |i: usize| ((i * 7_919) % 1_009) as f64 / 504.5 - 1.0;
    let each = |of: &dyn Fn(usize, f64) -> f64| time.iter().enumerate().map(|(i, t)| of(i, *t)).collect();
    let position = each(&|_, t| (0.01 * (w * t).sin() / 2.57e-6).round() * 2.57e-6);
    let velocity = each(&|i, t| 0.01 * w * (w * t).cos() + 3e-3 * ripple(i));
    let acceleration = each(&|i, t| -0.01 * w * w * (w * t).sin() + 0.2 * ripple(3 * i));
    (time, [position, velocity, acceleration])
}

#[divan::bench(args = [10_000, 1_000_000], sample_count = 3)]
fn position_only(bencher: Bencher, samples: usize) {
    let (time, [position, ..]) = channels(samples);
    let observations = [Observation::new(Observed::Position, &position)];
    bencher.counter(ItemsCount::new(samples)).bench(|| estimate_motion(&time, &observations));
}

#[divan::bench(args = [10_000, 1_000_000], sample_count = 3)]
fn three_channels(bencher: Bencher, samples: usize) {
    let (time, channels) = channels(samples);
    let kinds = [Observed::Position, Observed::Velocity, Observed::Acceleration];
    let observations = [0, 1, 2].map(|c| Observation::new(kinds[c], &channels[c]));
    bencher.counter(ItemsCount::new(samples)).bench(|| estimate_motion(&time, &observations));
}
