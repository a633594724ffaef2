//! Generator of the reference of an excitation.
//!
//! The phase is a 32-bit accumulator. It does not drift or lose resolution, and host and target step through the same phases.

use crate::wave::{HARMONICS, QUARTER, dwell, sine, triangle};
use crate::{Excitation, Wave};

/// Time of one sweep without a given length, s.
const SWEEP_S: f32 = 10.0;

/// Generator of a wave: one value in [−1, 1] per period, before amplitude and ramp.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Generator {
    wave: Wave,
    phase: u32,
    /// Phase increment per period.
    increment: u32,
    sweep: u32,
    sweep_increment: u32,
    half_turns: u32,
}

impl Generator {
    /// Generator at the start of `excitation`, for a control `period` in s.
    #[must_use]
    pub fn new(excitation: &Excitation, period: f32) -> Self {
        let per_turn = 4_294_967_296.0;
        let sweep_s = if excitation.seconds > 0.0 { excitation.seconds } else { 2.0 * SWEEP_S };
        Self {
            wave: excitation.wave,
            phase: 0,
            // `as` saturates
            increment: (excitation.frequency_hz * period * per_turn) as u32,
            sweep: 0,
            sweep_increment: (period / sweep_s * per_turn) as u32,
            half_turns: 0,
        }
    }

    /// Value of this period. Advances by one period.
    #[allow(clippy::should_implement_trait)] // it never ends
    pub fn next(&mut self) -> f32 {
        let (value, advance) = match self.wave {
            Wave::Sine => (sine(self.phase), self.increment),
            Wave::Multisine => {
                let sum = HARMONICS.iter().fold(0.0, |sum, &(number, phase, amplitude)| {
                    sum + amplitude * sine(self.phase.wrapping_mul(number).wrapping_add(phase))
                });
                (sum, self.increment)
            }
            Wave::Chirp => {
                // up in the first half of the sweep, down in the second
                let up = if self.sweep >> 31 == 0 { self.sweep } else { !self.sweep };
                let share = 0.1 + 0.9 * up as f32 * (1.0 / 2_147_483_648.0);
                self.sweep = self.sweep.wrapping_add(self.sweep_increment);
                (sine(self.phase), (self.increment as f32 * share) as u32)
            }
            Wave::Triangle => (triangle(self.phase), self.increment),
            Wave::Dwell => {
                let resting = self.phase & QUARTER != 0;
                let slower = if resting { self.half_turns & 3 } else { 0 };
                (dwell(self.phase), self.increment >> slower)
            }
        };
        let next = self.phase.wrapping_add(advance);
        if (next ^ self.phase) >> 31 != 0 {
            self.half_turns = self.half_turns.wrapping_add(1);
        }
        self.phase = next;
        value
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::println;

    #[test]
    fn every_wave_fills_its_amplitude_and_keeps_its_factors() {
        for &wave in Wave::ALL {
            let excitation = Excitation { wave, amplitude_m: 1.0, frequency_hz: 1.0, seconds: 20.0 };
            let mut generator = Generator::new(&excitation, 1e-4);
            let values: std::vec::Vec<f64> = (0..200_000).map(|_| f64::from(generator.next())).collect();
            let peak = values.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
            // differences over 2 ms suppress the f32 rounding of the values
            let h = 20;
            let dt = f64::from(h as u32) * 1e-4;
            let turn = core::f64::consts::TAU;
            let speed = values.windows(h + 1).fold(0.0_f64, |m, w| m.max((w[h] - w[0]).abs())) / dt / turn;
            let curve =
                values.windows(2 * h + 1).fold(0.0_f64, |m, w| m.max((w[2 * h] - 2.0 * w[h] + w[0]).abs()))
                    / (dt * dt * turn * turn);
            println!("{}: peak {peak:.5}, speed {speed:.3}, acceleration {curve:.3}", wave.id());
            assert!((peak - 1.0).abs() < 2e-3, "{}", wave.id());
            let (s, a) = (f64::from(wave.speed_factor()), f64::from(wave.acceleration_factor()));
            assert!((speed / s - 1.0).abs() < 0.02, "{}: speed {speed}, said {s}", wave.id());
            assert!((curve / a - 1.0).abs() < 0.05, "{}: acceleration {curve}, said {a}", wave.id());
        }
    }

    #[test]
    fn dwells_grow_and_begin_again() {
        let excitation = Excitation { wave: Wave::Dwell, amplitude_m: 1.0, frequency_hz: 1.0, seconds: 0.0 };
        let mut generator = Generator::new(&excitation, 1e-3);
        let mut rests = std::vec::Vec::new();
        let mut length = 0_i32;
        for _ in 0..12_000 {
            if generator.next().abs() >= 1.0 {
                length += 1;
            } else if length > 1 {
                rests.push(length);
                length = 0;
            } else {
                length = 0;
            }
        }
        println!("rests in ms: {rests:?}");
        assert!(rests.len() >= 5);
        for (rest, expected) in rests.iter().zip([250, 500, 1_000, 2_000, 250]) {
            assert!(rest.abs_diff(expected) <= 12, "rest {rest} ms, expected {expected}");
        }
    }
}
