//! The velocity estimator against trajectories that are known exactly.
//!
//! Encoder edges are synthesised from the trajectory by bisection to a fraction of a tick; the estimator sees what
//! the hardware would latch: count, time of the last edge, time of the sample.

use haptics::Estimator;

const HZ: f64 = 170e6;
const COUNT: f64 = 2.57e-6;
const PERIOD_TICKS: u64 = 170_000;

/// An encoder on a trajectory x(t) in m. `phase` is where in a count it starts.
struct Encoder<F: Fn(f64) -> f64> {
    path: F,
    phase: f64,
    ticks: u64,
    count: i64,
    edge: u64,
    /// Free-running timer at t = 0.
    epoch: u32,
    /// How far the four edges of a line are off, counts.
    errors: [f64; 4],
}

impl<F: Fn(f64) -> f64> Encoder<F> {
    fn new(path: F, phase: f64, epoch: u32) -> Self {
        let mut encoder = Self { path, phase, ticks: 0, count: 0, edge: 0, epoch, errors: [0.0; 4] };
        encoder.count = encoder.cell(0);
        encoder
    }

    fn cell(&self, ticks: u64) -> i64 {
        let at = (self.path)(ticks as f64 / HZ) / COUNT + self.phase;
        let cell = at.floor() as i64;
        let edge = |k: i64| k as f64 + self.errors[k.rem_euclid(4) as usize];
        if at < edge(cell) {
            cell - 1
        } else if at >= edge(cell + 1) {
            cell + 1
        } else {
            cell
        }
    }

    /// One control period; (sample_ticks, count, edge_ticks).
    fn sample(&mut self) -> (u32, u32, u32) {
        let end = self.ticks + PERIOD_TICKS;
        // monotonic pieces: 64 a period are enough for every trajectory here
        let piece = PERIOD_TICKS / 64;
        let mut from = self.ticks;
        while from < end {
            let to = (from + piece).min(end);
            while self.cell(to) != self.count {
                let up = self.cell(to) > self.count;
                let (mut low, mut high) = (from, to);
                while high - low > 1 {
                    let middle = low.midpoint(high);
                    let beyond =
                        if up { self.cell(middle) > self.count } else { self.cell(middle) < self.count };
                    if beyond { high = middle } else { low = middle }
                }
                self.count += if up { 1 } else { -1 };
                self.edge = high;
            }
            from = to;
        }
        self.ticks = end;
        let stamp = |ticks: u64| (ticks as u32).wrapping_add(self.epoch);
        (stamp(end), self.count as u32, stamp(self.edge))
    }
}

fn metres_per_second(estimator: &Estimator) -> f64 {
    f64::from(estimator.counts_per_tick()) * HZ * COUNT
}

#[test]
fn constant_speeds_at_least_ten_times_better_than_fixed_time_differencing() {
    println!(
        "  speed mm/s |  M/T std mm/s | fixed time std | ratio | bias mm/s | lag ms (edge mid to sample)"
    );
    for speed in [0.05e-3, 0.2e-3, 1e-3, 2.57e-3, 3.3e-3, 4.9e-3, 20e-3, 77.7e-3, 200e-3] {
        // long enough for the first two edges to be history
        let settle = (3.0 * COUNT / speed / 1e-3) as usize + 3;
        let (mut square, mut plain_square, mut sum, mut lag, mut n) = (0.0, 0.0, 0.0, 0.0, 0.0_f64);
        for phase in [0.0, 0.37, 0.81] {
            let mut encoder = Encoder::new(|t| speed * t, phase, 0xFFFF_0000);
            let mut estimator = Estimator::default();
            let (mut previous, mut previous_edge) = (0_u32, 0_u32);
            for k in 0..settle + 2_000 {
                let (ticks, count, edge) = encoder.sample();
                estimator.sample(ticks, count, edge);
                if k >= settle {
                    let error = metres_per_second(&estimator) - speed;
                    let plain = f64::from(count.wrapping_sub(previous) as i32) * COUNT / 1e-3 - speed;
                    square += error * error;
                    plain_square += plain * plain;
                    sum += error;
                    let interval = f64::from(edge.wrapping_sub(previous_edge)) / 2.0;
                    lag += (f64::from(ticks.wrapping_sub(edge)) + interval) / HZ * 1e3;
                    n += 1.0;
                }
                (previous, previous_edge) = (count, edge);
            }
        }
        let (std, plain) = ((square / n).sqrt(), (plain_square / n).sqrt());
        println!(
            "{:12.2} | {:13.6} | {:14.4} | {:5.0} | {:9.6} | {:.3}",
            speed * 1e3,
            std * 1e3,
            plain * 1e3,
            plain / std,
            sum / n * 1e3,
            lag / n
        );
        // timer resolution: one tick in the interval, twice
        assert!(std < speed * 2e-4, "speed {speed}");
        if speed < 5e-3 && (speed - 2.57e-3).abs() > 1e-9 {
            assert!(std * 10.0 < plain, "speed {speed}: {std} against {plain}");
        }
    }
}

#[test]
fn a_slow_sine_through_many_reversals() {
    // 0.5 mm at 1 Hz: 3.1 mm/s at most, twenty reversals
    for (amplitude, hz) in [(0.5e-3, 1.0), (0.05e-3, 2.0), (10e-3, 2.0)] {
        let turn = std::f64::consts::TAU * hz;
        let mut encoder = Encoder::new(|t| amplitude * (turn * t).sin(), 0.4, 0);
        let mut estimator = Estimator::default();
        let (mut square, mut plain_square, mut worst, mut n) = (0.0, 0.0, 0.0_f64, 0.0);
        let mut previous = 0_u32;
        for k in 1..=10_000_u32 {
            let (ticks, count, edge) = encoder.sample();
            estimator.sample(ticks, count, edge);
            if k > 20 {
                // both estimates are means over the period: compare with its middle
                let truth = amplitude * turn * (turn * (f64::from(k) - 0.5) * 1e-3).cos();
                let error = metres_per_second(&estimator) - truth;
                let plain = f64::from(count.wrapping_sub(previous) as i32) * COUNT / 1e-3 - truth;
                square += error * error;
                plain_square += plain * plain;
                worst = worst.max(error.abs());
                n += 1.0;
            }
            previous = count;
        }
        let (rms, plain) = ((square / n).sqrt(), (plain_square / n).sqrt());
        let peak = amplitude * turn;
        println!(
            "sine {:.2} mm {hz} Hz, peak {:.2} mm/s: M/T rms {:.4}, worst {:.4}, fixed time rms {:.4} mm/s",
            amplitude * 1e3,
            peak * 1e3,
            rms * 1e3,
            worst * 1e3,
            plain * 1e3
        );
        assert!(rms * 3.0 < plain, "reversals must not cost what the edges gain");
        assert!(worst < 2.57e-3, "never worse than one count a period");
    }
}

#[test]
fn a_stop_falls_smoothly_to_zero_and_is_never_stale() {
    for speed in [1e-3, 20e-3, 200e-3] {
        // stops dead at t = 0.1 s
        let mut encoder = Encoder::new(move |t: f64| speed * t.min(0.1), 0.2, 0);
        let mut estimator = Estimator::default();
        let mut last = f64::INFINITY;
        let mut halved_after = None;
        for k in 1..=7_000_u32 {
            let (ticks, count, edge) = encoder.sample();
            estimator.sample(ticks, count, edge);
            let v = metres_per_second(&estimator);
            let age = f64::from(k) * 1e-3 - 0.1;
            if age > 2e-3 {
                assert!(v >= 0.0 && v <= last, "falls, never rises: {v} after {last} at {age} s");
                // the last edge may have come up to one count before the stop
                assert!(v <= COUNT / (age - 1e-3) + 1e-12, "bounded by one count over the age of the edge");
                if last.is_finite() && last > 0.0 && v > 0.0 {
                    assert!(last / v < 2.5, "no cliff: {last} to {v} at {age} s");
                }
                if v < speed / 2.0 && halved_after.is_none() {
                    halved_after = Some(age);
                }
                last = v;
            }
        }
        println!(
            "stop from {:5.1} mm/s: below half after {:?} s, after 6.9 s {last:e} m/s",
            speed * 1e3,
            halved_after
        );
        assert_eq!(last, 0.0, "and ends at exactly zero");
    }
}

#[test]
fn dither_of_one_edge_is_not_speed() {
    // 0.2 counts about an edge at 40 Hz: the count toggles all the time
    let mut encoder = Encoder::new(|t| 0.1 * COUNT * (251.3 * t).sin(), 0.0, 7);
    let mut estimator = Estimator::default();
    let (mut toggles, mut worst, mut plain_worst, mut previous) = (0, 0.0_f64, 0.0_f64, 0_u32);
    for k in 0..2_000 {
        let (ticks, count, edge) = encoder.sample();
        estimator.sample(ticks, count, edge);
        toggles += i32::from(count != previous);
        if k > 0 {
            plain_worst =
                plain_worst.max(f64::from(count.wrapping_sub(previous) as i32).abs() * COUNT / 1e-3);
        }
        previous = count;
        worst = worst.max(metres_per_second(&estimator).abs());
    }
    println!("dither: {toggles} toggles, M/T worst {worst} m/s, fixed time worst {plain_worst} m/s");
    assert!(toggles > 100);
    assert_eq!(worst, 0.0);
}

#[test]
fn the_timer_wraps_and_an_old_edge_stays_old() {
    // moves at 50 mm/s, then rests for 60 s: the 32-bit timer wraps twice (25.3 s)
    let mut encoder = Encoder::new(|t: f64| 0.05 * t.min(0.05), 0.5, u32::MAX - 1_000_000);
    let mut estimator = Estimator::default();
    let mut worst_at_rest = 0.0_f64;
    for k in 1..=60_000_u32 {
        let (ticks, count, edge) = encoder.sample();
        estimator.sample(ticks, count, edge);
        if k > 60 {
            let bound = COUNT / (f64::from(k - 51) * 1e-3);
            let v = metres_per_second(&estimator);
            assert!(v <= bound, "at {k} ms: {v} above {bound}");
            if k > 7_000 {
                worst_at_rest = worst_at_rest.max(v.abs());
            }
        }
    }
    println!("after 7 s of rest and two wraps of the timer: {worst_at_rest} m/s");
    assert_eq!(worst_at_rest, 0.0);
}

#[test]
fn motion_after_rest_is_seen_at_once() {
    // rests 30 s (beyond a wrap), then 10 m/s² for 20 ms
    let start = 30.0;
    let mut encoder =
        Encoder::new(move |t: f64| if t < start { 0.0 } else { 5.0 * (t - start) * (t - start) }, 0.3, 0);
    let mut estimator = Estimator::default();
    for k in 1..=30_020_u32 {
        let (ticks, count, edge) = encoder.sample();
        estimator.sample(ticks, count, edge);
        if k >= 30_002 {
            let t = f64::from(k) * 1e-3 - start;
            let v = metres_per_second(&estimator);
            let middle = 10.0 * (t - 0.5e-3);
            if k <= 30_004 || k == 30_020 {
                println!("{:4.0} ms after the start: {v:.5} m/s, mean over the period {middle:.5}", t * 1e3);
            }
            assert!((v - middle).abs() < 0.15 * middle + 1e-3, "{v} against {middle} at {t}");
        }
    }
}

#[test]
fn phase_error_of_the_encoder_is_bounded() {
    // a count is a quarter of a line; its edges are up to 15 % of a count late
    let errors = [0.0, 0.1, 0.05, 0.15];
    // between neighbours, the largest deviation of an interval from one count
    let worst_interval = 0.15;
    println!("  speed mm/s | M/T std mm/s | of the speed | fixed time std | ratio");
    for speed in [0.05e-3, 0.5e-3, 1.1e-3, 3.3e-3, 4.9e-3, 23e-3, 211e-3] {
        let settle = (3.0 * COUNT / speed / 1e-3) as usize + 3;
        let (mut square, mut plain_square, mut worst, mut n) = (0.0, 0.0, 0.0_f64, 0.0_f64);
        let mut encoder = Encoder { errors, ..Encoder::new(|t| speed * t, 0.37, 0) };
        let mut estimator = Estimator::default();
        let mut previous = 0_u32;
        for k in 0..settle + 2_000 {
            let (ticks, count, edge) = encoder.sample();
            estimator.sample(ticks, count, edge);
            if k >= settle {
                let error = metres_per_second(&estimator) - speed;
                let plain = f64::from(count.wrapping_sub(previous) as i32) * COUNT / 1e-3 - speed;
                square += error * error;
                plain_square += plain * plain;
                worst = worst.max(error.abs());
                n += 1.0;
            }
            previous = count;
        }
        let (std, plain) = ((square / n).sqrt(), (plain_square / n).sqrt());
        println!(
            "{:12.2} | {:12.4} | {:10.2} % | {:14.4} | {:5.1}",
            speed * 1e3,
            std * 1e3,
            100.0 * std / speed,
            plain * 1e3,
            plain / std
        );
        // One interval, or as many counts as there are in a period. And an interval that is 10 % too long looks like a
        // handle that slows down: the bound of one count over the age of the last edge takes that off.
        let counts = (speed * 1e-3 / COUNT).max(1.0).floor();
        let expected = (worst_interval / (counts - worst_interval)).max(0.1 / 1.1);
        assert!(worst <= speed * expected * 1.01, "{speed}: {worst}");
        // beyond, that bound costs more than the resolution of a count over a period
        assert!(speed > 0.05 || 2.0 * std < plain, "{speed}");
    }
}
