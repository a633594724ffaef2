//! Shapes of the excitation as functions of a 32-bit phase.

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
pub(crate) const QUARTER: u32 = 1 << 30;
/// Half width of a rounded corner, turns.
const CORNER: f32 = 0.02;
/// Harmonics of the multisine: number, phase (for a low peak of the sum), amplitude.
pub(crate) const HARMONICS: [(u32, u32, f32); 5] = [
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
pub(crate) fn triangle(phase: u32) -> f32 {
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
pub(crate) fn dwell(phase: u32) -> f32 {
    let half = phase & (u32::MAX >> 1);
    let u = half as f32 * (1.0 / QUARTER as f32);
    let moved = if u >= 1.0 { 1.0 } else { u * u * u * (10.0 - u * (15.0 - 6.0 * u)) };
    let unit = 2.0 * moved - 1.0;
    if phase >> 31 == 0 { unit } else { -unit }
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
}
