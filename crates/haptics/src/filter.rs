//! A biquad section, for the low-pass on the excitation command.

use friction::Scalar;

/// Coefficients of a second-order section, normalised to a₀ = 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Biquad {
    b: [f32; 3],
    a: [f32; 2],
}

/// State of a [`Biquad`], transposed direct form II.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct BiquadState {
    s: [f32; 2],
}

impl Biquad {
    /// Second-order Butterworth low-pass by the bilinear transform, pre-warped for a gain of 1/√2 at `cutoff_hz`. Passes
    /// everything if the cut-off is not positive, or at least half the sampling rate.
    #[must_use]
    pub fn low_pass(cutoff_hz: f32, period: f32) -> Self {
        let turn = cutoff_hz * period;
        if !(turn > 0.0 && turn < 0.5) {
            return Self { b: [1.0, 0.0, 0.0], a: [0.0, 0.0] };
        }
        let half = core::f32::consts::PI * turn;
        let k = Scalar::sin(half) / Scalar::cos(half);
        let norm = 1.0 / (1.0 + core::f32::consts::SQRT_2 * k + k * k);
        let b0 = k * k * norm;
        Self {
            b: [b0, 2.0 * b0, b0],
            a: [2.0 * (k * k - 1.0) * norm, (1.0 - core::f32::consts::SQRT_2 * k + k * k) * norm],
        }
    }

    /// One sample through the filter.
    #[must_use]
    pub fn step(&self, state: &mut BiquadState, input: f32) -> f32 {
        let [b0, b1, b2] = self.b;
        let [a1, a2] = self.a;
        let [s1, s2] = state.s;
        let output = b0 * input + s1;
        state.s = [b1 * input - a1 * output + s2, b2 * input - a2 * output];
        output
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::println;

    fn gain(filter: &Biquad, hz: f64) -> f64 {
        let mut state = BiquadState::default();
        let (mut re, mut im) = (0.0, 0.0);
        // whole periods of every frequency, after the transient
        for k in 0..4_000_u32 {
            let phase = core::f64::consts::TAU * hz * f64::from(k) * 1e-3;
            let y = f64::from(filter.step(&mut state, phase.sin() as f32));
            if k >= 2_000 {
                re += y * phase.sin() / 1_000.0;
                im += y * phase.cos() / 1_000.0;
            }
        }
        re.hypot(im)
    }

    #[test]
    fn low_pass_is_second_order_at_100_hz() {
        let filter = Biquad::low_pass(100.0, 1e-3);
        for (hz, expected) in [(2.0, 1.0), (100.0, core::f64::consts::FRAC_1_SQRT_2), (400.0, 0.0111)] {
            let measured = gain(&filter, hz);
            println!("low-pass 100 Hz: gain at {hz} Hz = {measured:.5} (expected {expected:.5})");
            assert!((measured - expected).abs() < 2e-4);
        }
    }

    #[test]
    fn nonsense_cutoff_passes_everything() {
        for cutoff in [0.0, -3.0, 500.0, f32::NAN, f32::INFINITY] {
            let filter = Biquad::low_pass(cutoff, 1e-3);
            assert_eq!(filter.step(&mut BiquadState::default(), 1.25), 1.25);
        }
    }
}
