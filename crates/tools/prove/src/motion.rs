//! What the body is asked to do: one programme for every case, so that the motion says nothing about what is hidden.
//! Several frequencies, a chirp, slow and fast constant speeds, and moves between rests of different length.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::f64::consts::TAU;

/// Time over which one part fades into the next, s.
const FADE: f64 = 0.25;

/// A part of the programme, in half strokes.
#[derive(Debug, Clone)]
enum Part {
    Multisine(Vec<(f64, f64, f64)>),
    Chirp {
        from: f64,
        to: f64,
        seconds: f64,
    },
    Speeds {
        slow: f64,
        fast: f64,
        seconds: f64,
    },
    /// Start, end, and where it goes.
    Rests(Vec<(f64, f64, f64, f64)>),
}

/// Position asked for over time.
#[derive(Debug, Clone)]
pub(crate) struct Programme {
    parts: Vec<(f64, f64, Part)>,
    /// Frequency, share and phase of what the load on the contact does.
    load: [(f64, f64, f64); 2],
}

/// Mean load on the contact, N or N·m.
pub(crate) const LOAD: f64 = 10.0;

impl Programme {
    /// A programme of `seconds`, drawn from `seed`; every part comes twice, in an order that is drawn.
    pub(crate) fn new(seconds: f64, seed: u64) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut parts = Vec::new();
        let mut start = 0.0;
        for _ in 0..2 {
            let mut order = [0, 1, 2, 3];
            for i in (1..4).rev() {
                order.swap(i, random.random_range(0..=i));
            }
            for which in order {
                let length = 0.5 * seconds * [0.38, 0.2, 0.2, 0.22][which];
                parts.push((start, start + length, part(which, length, &mut random)));
                start += length;
            }
        }
        // the last part goes on, so that nothing stops before the recording does
        if let Some(last) = parts.last_mut() {
            last.1 = f64::INFINITY;
        }
        let mut line = |share: f64| {
            (
                random.random_range(0.15..0.6),
                share * random.random_range(0.8..1.2),
                random.random_range(0.0..TAU),
            )
        };
        let load = [line(0.35), line(0.2)];
        Self { parts, load }
    }

    /// Load on the contact at `t`, which nothing but a law that asks for it feels.
    pub(crate) fn load(&self, t: f64) -> f64 {
        LOAD * (1.0
            + self.load.iter().map(|(f, share, phase)| share * (TAU * f * t + phase).sin()).sum::<f64>())
    }

    /// Position asked for at `t`, in half strokes.
    pub(crate) fn at(&self, t: f64) -> f64 {
        let (mut sum, mut weight) = (0.0, 0.0);
        for (index, (from, to, part)) in self.parts.iter().enumerate() {
            let rise = if index == 0 { 1.0 } else { smooth((t - from + FADE) / (2.0 * FADE)) };
            let fall = smooth((to - t + FADE) / (2.0 * FADE));
            let w = rise * fall;
            if w > 0.0 {
                sum += w * part.at(t - from);
                weight += w;
            }
        }
        if weight > 0.0 { sum / weight } else { 0.0 }
    }
}

fn part(which: usize, seconds: f64, random: &mut ChaCha8Rng) -> Part {
    let mut within = |low: f64, high: f64| random.random_range(low..high);
    match which {
        0 => Part::Multisine(
            [(0.45, 0.5), (1.1, 0.28), (2.3, 0.18), (3.9, 0.1), (6.1, 0.05)]
                .iter()
                .map(|(f, a)| (f * within(0.85, 1.15), a * within(0.8, 1.2), within(0.0, TAU)))
                .collect(),
        ),
        1 => Part::Chirp { from: within(0.8, 1.2), to: within(8.0, 11.0), seconds },
        2 => Part::Speeds { slow: within(0.25, 0.4), fast: within(1.2, 2.0), seconds },
        _ => {
            let (mut moves, mut t, mut x) = (Vec::new(), 0.0, 0.0);
            while t < seconds + 2.0 {
                let travel = within(0.18, 0.4);
                let goal: f64 = within(-0.9, 0.9);
                moves.push((t, t + travel, x, goal));
                x = goal;
                t += travel + 0.04 * 12f64.powf(within(0.0, 1.0));
            }
            Part::Rests(moves)
        }
    }
}

impl Part {
    fn at(&self, t: f64) -> f64 {
        match self {
            Self::Multisine(lines) => lines.iter().map(|(f, a, p)| a * (TAU * f * t + p).sin()).sum(),
            Self::Chirp { from, to, seconds } => {
                let t = t.clamp(-1.0, seconds + 1.0);
                let rate = (to - from) / seconds;
                let now = (from + rate * t).max(0.5);
                0.8 / now.max(1.0).powf(1.2) * (TAU * (from + 0.5 * rate * t) * t).sin()
            }
            Self::Speeds { slow, fast, seconds } => {
                // a triangle: the path covered so far, folded into the stroke
                let half = 0.5 * seconds;
                let path = if t < half { slow * t } else { slow * half + fast * (t - half) };
                let fold = (path + 0.7).rem_euclid(2.8);
                if fold < 1.4 { fold - 0.7 } else { 2.1 - fold }
            }
            Self::Rests(moves) => {
                let now = moves.iter().rev().find(|m| t >= m.0).or(moves.first());
                now.map_or(0.0, |(from, to, a, b)| a + (b - a) * smooth((t - from) / (to - from)))
            }
        }
    }
}

/// 0 to 1 with vanishing velocity and acceleration at both ends.
fn smooth(u: f64) -> f64 {
    let u = u.clamp(0.0, 1.0);
    u * u * u * (10.0 - 15.0 * u + 6.0 * u * u)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_programme_stays_in_the_stroke_and_never_jumps() {
        for seed in 0..20 {
            let programme = Programme::new(16.0, seed);
            let mut last = programme.at(0.0);
            for k in 1..17_000 {
                let x = programme.at(f64::from(k) * 1e-3);
                assert!(x.abs() < 1.6, "{x} at {k} ms");
                assert!((x - last).abs() < 0.02, "a jump of {} at {k} ms", x - last);
                last = x;
            }
        }
    }
}
