//! Pulse-interval velocity (M/T) against fixed-time differencing and the rig's true velocity, from what the ELF streamed.
//!
//! The device estimates with the same crate from the same codes; `agreement` shows that bit for bit in its forces.

use crate::board::Board;
use crate::plot;
use crate::track::{Track, run_to, seconds};
use haptics::Estimator;
use link::Sample;
use report::picture::{BLACK, BLUE, Line, ORANGE, Panel, Scale};

const COUNT: f64 = 2.57e-6;
const TICK_HZ: f64 = 170e6;
/// Length of a change of speed, s.
const RAMP: f64 = 0.03;
/// Start of the motion, s.
const START: f64 = 0.2;

/// A piece of the motion.
#[derive(Clone, Copy, PartialEq)]
enum Piece {
    /// m/s, s.
    Steady(f64, f64),
    /// Amplitude m, Hz, periods; begins in the middle at full speed.
    Sine(f64, f64, f64),
}

impl Piece {
    fn speed(self) -> f64 {
        match self {
            Self::Steady(v, _) => v,
            Self::Sine(amplitude, hz, _) => amplitude * hz * std::f64::consts::TAU,
        }
    }

    fn length(self) -> f64 {
        match self {
            Self::Steady(_, length) => length,
            Self::Sine(_, hz, periods) => periods / hz,
        }
    }
}

const MOTION: [Piece; 16] = [
    Piece::Steady(0.053e-3, 1.2),
    Piece::Steady(-0.21e-3, 1.0),
    Piece::Steady(0.47e-3, 0.8),
    Piece::Steady(-1.13e-3, 0.8),
    Piece::Steady(2.1e-3, 0.8),
    Piece::Steady(-3.3e-3, 0.6),
    Piece::Steady(4.87e-3, 0.6),
    Piece::Steady(-9.7e-3, 0.5),
    Piece::Steady(21e-3, 0.5),
    Piece::Steady(-53e-3, 0.25),
    Piece::Steady(103e-3, 0.15),
    Piece::Steady(-199e-3, 0.09),
    // back to the middle of the stroke
    Piece::Steady(60e-3, 0.18),
    Piece::Sine(0.5e-3, 1.0, 3.0),
    Piece::Sine(5e-3, 2.0, 2.0),
    // and stops dead
    Piece::Steady(20e-3, 0.2),
];

/// Begins after its ramp: start s, position there m, the piece.
type Placed = (f64, f64, Piece);

fn placed() -> Vec<Placed> {
    let (mut t, mut x, mut before) = (START, 0.0, 0.0);
    MOTION
        .iter()
        .map(|piece| {
            x += 0.5 * (before + piece.speed()) * RAMP;
            t += RAMP;
            let at = (t, x, *piece);
            before = piece.speed();
            t += piece.length();
            if let Piece::Steady(v, length) = piece {
                x += v * length;
            }
            at
        })
        .collect()
}

/// Where the hand wants the handle: m, m/s.
fn reference(pieces: &[Placed], t: f64) -> (f64, f64) {
    let k = pieces.partition_point(|(start, _, _)| *start <= t);
    let (here, next) = (k.checked_sub(1).map(|k| pieces[k]), pieces.get(k));
    let (end, x, v) = match here {
        Some((start, x, piece)) => {
            let since = (t - start).min(piece.length());
            let (x, v) = match piece {
                Piece::Steady(v, _) => (x + v * since, v),
                Piece::Sine(amplitude, hz, _) => {
                    let (sin, cos) = (std::f64::consts::TAU * hz * since).sin_cos();
                    (x + amplitude * sin, piece.speed() * cos)
                }
            };
            (start + piece.length(), x, v)
        }
        None => (START, 0.0, 0.0),
    };
    let into = t - end;
    match next {
        _ if into <= 0.0 => (x, v),
        Some((_, _, piece)) => {
            let change = (piece.speed() - v) / RAMP;
            (x + v * into + 0.5 * change * into * into, v + change * into)
        }
        None => (x, 0.0),
    }
}

/// One sample: rig's time s, true velocity, M/T, fixed time m/s; age of the last edge s; and half the interval that was
/// measured.
struct Row {
    t: f64,
    truth: f64,
    pulse: f64,
    fixed: f64,
    age: f64,
    lag: f64,
}

fn rows(samples: &[Sample], track: &Track) -> Vec<Row> {
    let shift = track.shift(samples, COUNT);
    let mut estimator = Estimator::default();
    let (mut previous, mut edge, mut interval) = (None, 0, 0);
    let mut out = Vec::new();
    for s in samples {
        estimator.sample(s.sample_ticks, s.count as u32, s.edge_ticks());
        if s.edge_ticks() != edge {
            interval = s.edge_ticks().wrapping_sub(edge);
            edge = s.edge_ticks();
        }
        let moved = s.count - previous.unwrap_or(s.count);
        previous = Some(s.count);
        let t = seconds(s) + shift;
        let Some((_, truth)) = track.at(t) else { continue };
        let age = f64::from(estimator.edge_age()) / TICK_HZ;
        out.push(Row {
            t,
            truth,
            pulse: f64::from(estimator.counts_per_tick()) * TICK_HZ * COUNT,
            fixed: f64::from(moved) * COUNT / 1e-3,
            age,
            lag: age + 0.5 * f64::from(interval) / TICK_HZ,
        });
    }
    out
}

fn rms(errors: impl Iterator<Item = f64>) -> f64 {
    let (sum, n) = errors.fold((0.0, 0.0_f64), |(sum, n), e| (sum + e * e, n + 1.0));
    (sum / n).sqrt()
}

/// Delay of an estimate behind the truth, s, and what is left of its error beside it, m/s.
fn lag(rows: &[&Row], estimate: impl Fn(&Row) -> f64) -> (f64, f64) {
    let slope = |k: usize| (rows[k + 1].truth - rows[k - 1].truth) / (rows[k + 1].t - rows[k - 1].t);
    let inner = 1..rows.len() - 1;
    let (over, under) = inner.clone().fold((0.0, 0.0), |(over, under), k| {
        let a = slope(k);
        (over + (rows[k].truth - estimate(rows[k])) * a, under + a * a)
    });
    let lag = over / under;
    (lag, rms(inner.map(|k| estimate(rows[k]) - rows[k].truth + lag * slope(k))))
}

pub fn pulse_interval_velocity_is_ten_times_better_at_low_speed_and_never_stale() {
    let mut board = Board::ready();
    let pieces = placed();
    let track = Track::default();
    let path = pieces.clone();
    board.ok("stream on");
    // a machine moves the handle: stiff, and it does not jerk
    board.machine.set_hand(track.of(move |t: f64, x: f64, v: f64| {
        let (to, speed) = reference(&path, t);
        4e5 * (to - x) + 1_000.0 * (speed - v)
    }));
    let (last, _, piece) = *pieces.last().expect("pieces");
    let stopped = last + piece.length();
    run_to(&mut board, stopped + 3.0);
    let samples: Vec<Sample> = board.samples().map(|(_, s)| s).collect();
    assert!(samples.windows(2).all(|w| w[1].step == w[0].step.wrapping_add(1)), "a frame was lost");
    let rows = rows(&samples, &track);
    let within =
        |from: f64, to: f64| -> Vec<&Row> { rows.iter().filter(|r| r.t > from && r.t < to).collect() };

    println!("   true speed | M/T: std, bias, lag                    | fixed time: std, lag  | std, ratio");
    let mut table = Vec::new();
    for (start, _, piece) in &pieces[..12] {
        let Piece::Steady(speed, length) = *piece else { continue };
        // two edges of this speed, and the ringing of the start, are history
        let settled = within(start + 0.03 + 2.5 * COUNT / speed.abs(), start + length);
        let n = settled.len() as f64;
        let bias = settled.iter().map(|r| r.pulse - r.truth).sum::<f64>() / n;
        let std = rms(settled.iter().map(|r| r.pulse - r.truth));
        let fixed = rms(settled.iter().map(|r| r.fixed - r.truth));
        let lag = settled.iter().map(|r| r.lag).sum::<f64>() / n;
        println!(
            "{:7.3} mm/s | {:.6} mm/s, {:+.6} mm/s, {:5.2} ms | {:.3} mm/s, 0.50 ms | {:8.0}",
            1e3 * speed,
            1e3 * std,
            1e3 * bias,
            1e3 * lag,
            1e3 * fixed,
            fixed / std
        );
        table.push((1e3 * speed.abs(), 1e3 * std, 1e3 * fixed));
        assert!(speed.abs() >= 5e-3 || 10.0 * std < fixed, "{speed} m/s: {std} against {fixed}");
        assert!(std < fixed, "{speed} m/s: {std} against {fixed}");
    }

    let mut slow = Vec::new();
    for (start, _, piece) in &pieces[13..15] {
        let turning = within(start + 0.01, start + piece.length() - 0.01);
        let (pulse_lag, pulse_rest) = lag(&turning, |r| r.pulse);
        let (fixed_lag, fixed_rest) = lag(&turning, |r| r.fixed);
        let worst = turning.iter().fold(0.0_f64, |m, r| m.max((r.pulse - r.truth).abs()));
        println!(
            "reversals, sine up to {:6.2} mm/s: M/T lag {:.2} ms, std beside it {:.4} mm/s, worst error {:.2} mm/s; fixed time lag {:.2} ms, std {:.3} mm/s",
            1e3 * piece.speed(),
            1e3 * pulse_lag,
            1e3 * pulse_rest,
            1e3 * worst,
            1e3 * fixed_lag,
            1e3 * fixed_rest
        );
        // Turning within a count shows no edge: it hides √(2·a·count), and nothing else may be worse. Lag is that of
        // the accelerated parts, which in a sine are the reversals.
        let Piece::Sine(_, hz, _) = *piece else { unreachable!() };
        let hidden = (2.0 * piece.speed() * hz * std::f64::consts::TAU * COUNT).sqrt();
        assert!(worst < 1.5 * hidden && pulse_lag < 5e-3 && 4.0 * pulse_rest < fixed_rest);
        if slow.is_empty() {
            slow = turning;
        }
    }

    // one count over the age of the last edge bounds every estimate, whatever came before
    for r in &rows {
        assert!(r.pulse.abs() <= COUNT / r.age.max(1e-9) * (1.0 + 1e-6), "{} m/s at {} s", r.pulse, r.t);
    }
    let rest = within(stopped + RAMP, stopped + 2.99);
    let below = |limit: f64| {
        let since = rest.iter().rev().find(|r| r.pulse.abs() > limit).map_or(0.0, |r| r.t - stopped);
        1e3 * since
    };
    println!(
        "stop from 20 mm/s: below 1 mm/s {:.1} ms after, below 0.1 mm/s {:.1} ms, below 0.01 mm/s {:.0} ms; 2.9 s after {:.5} mm/s",
        below(1e-3),
        below(1e-4),
        below(1e-5),
        1e3 * rest.last().expect("samples").pulse.abs()
    );
    assert!(below(1e-3) < 10.0 && below(1e-4) < 60.0 && below(1e-5) < 600.0);

    let trace = |rows: &[&Row], from: f64, of: fn(&Row) -> f64| -> Vec<(f64, f64)> {
        rows.iter().map(|r| (r.t - from, 1e3 * of(r))).collect()
    };
    let some = &slow[150..650];
    let end = within(stopped - 0.01, stopped + 0.12);
    let panels = vec![
        Panel {
            title: "error at steady speed".into(),
            axes: ["speed, mm/s", "std, mm/s"],
            scale: Scale::Logarithmic,
            lines: vec![
                Line::new("fixed time, 1 ms", ORANGE, table.iter().map(|r| (r.0, r.2)).collect()),
                Line::new("pulse interval (M/T)", BLUE, table.iter().map(|r| (r.0, r.1)).collect()),
            ],
            ..Panel::default()
        },
        Panel {
            title: "through a reversal: sine of 0.5 mm, 1 Hz".into(),
            axes: ["time, s", "velocity, mm/s"],
            lines: vec![
                Line::new("fixed time, 1 ms", ORANGE, trace(some, some[0].t, |r| r.fixed)).dots(),
                Line::new("pulse interval (M/T)", BLUE, trace(some, some[0].t, |r| r.pulse)),
                Line::new("truth", BLACK, trace(some, some[0].t, |r| r.truth)),
            ],
            ..Panel::default()
        },
        Panel {
            title: "stop from 20 mm/s".into(),
            axes: ["time, s", "velocity, mm/s"],
            lines: vec![
                Line::new("fixed time, 1 ms", ORANGE, trace(&end, stopped, |r| r.fixed)).dots(),
                Line::new("pulse interval (M/T)", BLUE, trace(&end, stopped, |r| r.pulse)),
                Line::new("truth", BLACK, trace(&end, stopped, |r| r.truth)),
            ],
            ..Panel::default()
        },
    ];
    println!("{}", plot::write("velocity", panels).display());
}

/// Edges of a constant speed, so that each comes a cycle later within the sampling of its period than the one before: at and
/// between all of its instructions. Capture lag in cycles, periods between edges, direction.
pub fn an_edge_at_any_instruction_of_the_sampling_leaves_the_velocity() {
    const PERIOD: u64 = 170_000;
    /// Cycles from the entry of the interrupt before and after the sampling.
    const SWEEP: std::ops::Range<i64> = -30..190;
    for (lag, periods, up) in [(4, 3, true), (4, 1, false), (4, 2, true), (0, 2, false), (40, 3, true)] {
        let mut board = Board::ready();
        board.machine.set_capture_lag(lag);
        board.ok("stream on");
        assert!(board.machine.run_to_control());
        let interval = periods * PERIOD + 1;
        board.machine.turn_encoder(interval.checked_add_signed(SWEEP.start).expect("a delay"), interval, up);
        board.frames.clear();
        board.run(1.0 * periods as f64 * SWEEP.count() as f64);
        let samples: Vec<Sample> = board.samples().map(|(_, s)| s).collect();
        assert!(samples.windows(2).all(|w| w[1].step == w[0].step.wrapping_add(1)), "a frame was lost");
        let truth = if up { 1.0 } else { -1.0 } / interval as f64;
        let mut estimator = Estimator::default();
        let (mut worst, mut at_sample, mut counts) = (0.0_f64, 0, 0);
        let first = samples.first().expect("samples").count;
        for s in &samples {
            estimator.sample(s.sample_ticks, s.count as u32, s.edge_ticks());
            at_sample += u32::from(s.edge_age == 0);
            counts = (s.count - first).unsigned_abs();
            if counts >= 4 {
                worst = worst.max((f64::from(estimator.counts_per_tick()) / truth - 1.0).abs());
            }
        }
        println!(
            "an edge every {periods} periods and a cycle, captured after {lag} cycles: {counts} edges, {at_sample} between stamp and count, velocity at most {:.5} % off",
            100.0 * worst
        );
        assert!(counts as usize > SWEEP.count() - 10);
        assert!(at_sample > 3, "no edge fell between the stamp and the count");
        assert!(worst < 1e-3, "{worst}");
    }
}
