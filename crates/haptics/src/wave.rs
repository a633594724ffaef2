//! Shapes of the excitation as functions of a 32-bit phase.

use crate::excitation::Excitation;

/// Shape of the reference.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Wave {
    /// One frequency [thesis, ch. 3.5.2].
    Sine,
    /// Harmonics 1, 2, 3, 5 and 7 with amplitudes 1/n. Separates position, velocity and acceleration, which one sine ties
    /// together.
    Multisine,
    /// Sweep from a tenth of the frequency to the frequency and back, every 10 s or once in the given time.
    Chirp,
    /// Constant speed in both directions, with corners rounded over 4 % of the period.
    Triangle,
    /// Moves and rests. The rests grow 1, 2, 4, 8 times, then start again.
    Dwell,
}

impl Wave {
    /// All variants.
    pub const ALL: &'static [Self] = &[Self::Sine, Self::Multisine, Self::Chirp, Self::Triangle, Self::Dwell];

    /// Name as typed.
    #[must_use]
    pub const fn id(self) -> &'static str {
        match self {
            Self::Sine => "sine",
            Self::Multisine => "multisine",
            Self::Chirp => "chirp",
            Self::Triangle => "triangle",
            Self::Dwell => "dwell",
        }
    }

    /// The wave with this name.
    #[must_use]
    pub fn from_id(id: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|wave| wave.id() == id)
    }

    /// Peak speed relative to a sine of the same amplitude and frequency.
    #[must_use]
    pub const fn speed_factor(self) -> f32 {
        match self {
            Self::Sine | Self::Chirp => 1.0,
            Self::Multisine => 3.83,
            Self::Triangle => 0.664,
            Self::Dwell => 2.388,
        }
    }

    /// Peak acceleration relative to a sine of the same amplitude and frequency.
    #[must_use]
    pub const fn acceleration_factor(self) -> f32 {
        match self {
            Self::Sine | Self::Chirp => 1.0,
            Self::Multisine => 12.5,
            Self::Triangle => 5.28,
            Self::Dwell => 4.68,
        }
    }
}

/// A quarter turn of the phase.
const QUARTER: u32 = 1 << 30;
/// Half width of a rounded corner, turns.
const CORNER: f32 = 0.02;
/// Time of one sweep without a given length, s.
const SWEEP_S: f32 = 10.0;
/// Harmonics of the multisine: number, phase (for a low peak of the sum), amplitude.
const HARMONICS: [(u32, u32, f32); 5] = [
    (1, 0, MULTISINE_SCALE),
    (2, 165 << 24, MULTISINE_SCALE / 2.0),
    (3, 242 << 24, MULTISINE_SCALE / 3.0),
    (5, 30 << 24, MULTISINE_SCALE / 5.0),
    (7, 27 << 24, MULTISINE_SCALE / 7.0),
];
/// Reciprocal of the peak of the sum.
const MULTISINE_SCALE: f32 = 0.843_17;

/// sin(2π·phase/2³²), |error| < 3·10⁻⁷. `libm::sinf` computes in `f64`, which is software on this core.
#[must_use]
pub fn sine(phase: u32) -> f32 {
    let mut p = phase as i32;
    if p.unsigned_abs() > QUARTER {
        // sin(π − θ), and sin(−π − θ): the same number in two's complement
        p = i32::MIN.wrapping_sub(p);
    }
    // Hastings' polynomial for sin(πt/2), |t| ≤ 1
    let t = p as f32 * (1.0 / QUARTER as f32);
    let s = t * t;
    t * (core::f32::consts::FRAC_PI_2
        + s * (-0.645_963_7 + s * (0.079_689_68 + s * (-0.004_673_765_6 + s * 0.000_151_484_2))))
}

/// Triangle with rounded corners, peak exactly 1.
fn triangle(phase: u32) -> f32 {
    // distance from the corner of this half turn, turns; each corner is a quarter turn after a zero
    let half = phase & (u32::MAX >> 1);
    let distance = half.abs_diff(QUARTER) as f32 * (1.0 / 4_294_967_296.0);
    let shape = if distance < CORNER {
        1.0 - 2.0 * CORNER - distance * distance * (2.0 / CORNER)
    } else {
        1.0 - 4.0 * distance
    };
    let unit = shape * (1.0 / (1.0 - 2.0 * CORNER));
    if phase >> 31 == 0 { unit } else { -unit }
}

/// Minimum-jerk moves: from −1 to 1 in the first quarter turn, then rest; back in the third quarter turn, then rest.
fn dwell(phase: u32) -> f32 {
    let half = phase & (u32::MAX >> 1);
    let u = half as f32 * (1.0 / QUARTER as f32);
    let moved = if u >= 1.0 { 1.0 } else { u * u * u * (10.0 - u * (15.0 - 6.0 * u)) };
    let unit = 2.0 * moved - 1.0;
    if phase >> 31 == 0 { unit } else { -unit }
}

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
    fn sine_is_a_sine() {
        let mut worst = 0.0_f64;
        for phase in (0..=u32::MAX).step_by(40_009) {
            let exact = (f64::from(phase) * core::f64::consts::TAU / 4_294_967_296.0).sin();
            worst = worst.max((f64::from(sine(phase)) - exact).abs());
        }
        println!("sine: worst error {worst:.2e}");
        assert!(worst < 3e-7);
    }

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
