//! A wave on the reading of an encoder, x_read = x + amplitude·cos(2π·x/wavelength + phase): an eccentric disc, a scale that
//! runs crooked, interpolation between two lines of it.

use std::f64::consts::TAU;

/// Steps of Newton's method from reading to place: each doubles the digits.
const STEPS: usize = 8;

/// The wave, each with its standard deviation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wave {
    /// m or rad.
    pub amplitude: (f64, f64),
    /// At x = 0, rad.
    pub phase: (f64, f64),
    /// m or rad.
    pub wavelength: (f64, f64),
}

impl Wave {
    /// Waves per length times 2π.
    fn number(&self) -> f64 {
        TAU / self.wavelength.0
    }

    /// Where the body is when the encoder reads `read`.
    pub fn place(&self, read: f64) -> f64 {
        let (height, k) = (self.amplitude.0, self.number());
        let mut x = read;
        for _ in 0..STEPS {
            let (sine, cosine) = (k * x + self.phase.0).sin_cos();
            x -= (x + height * cosine - read) / (1.0 - height * k * sine);
        }
        x
    }

    /// What a velocity taken from the reading has too much, m/s, at place `x`.
    pub fn velocity(&self, x: f64, v: f64) -> f64 {
        let k = self.number();
        -self.amplitude.0 * k * v * (k * x + self.phase.0).sin()
    }

    /// The same of the acceleration, m/s².
    pub fn acceleration(&self, x: f64, v: f64, a: f64) -> f64 {
        let k = self.number();
        let (sine, cosine) = (k * x + self.phase.0).sin_cos();
        -self.amplitude.0 * k * (k * v * v * cosine + a * sine)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_place_reads_as_it_was_read() {
        let wave = Wave { amplitude: (0.05, 0.0), phase: (2.0, 0.0), wavelength: (0.5, 0.0) };
        for i in -50..50 {
            let x = 0.037 * f64::from(i);
            let read = x + 0.05 * (TAU * x / 0.5 + 2.0).cos();
            assert!((wave.place(read) - x).abs() < 1e-12, "{x}");
        }
    }

    #[test]
    fn its_derivatives_are_those_of_the_reading() {
        let wave = Wave { amplitude: (0.02, 0.0), phase: (0.3, 0.0), wavelength: (0.7, 0.0) };
        let x = |t: f64| (3.0 * t).sin();
        let off = |t: f64| 0.02 * (TAU * x(t) / 0.7 + 0.3).cos();
        let (t, h) = (0.4f64, 1e-4);
        let (v, a) = (3.0 * (3.0 * t).cos(), -9.0 * (3.0 * t).sin());
        let slope = (off(t + h) - off(t - h)) / (2.0 * h);
        let bend = (off(t + h) - 2.0 * off(t) + off(t - h)) / (h * h);
        assert!((wave.velocity(x(t), v) - slope).abs() < 1e-5);
        assert!((wave.acceleration(x(t), v, a) - bend).abs() < 1e-4);
    }
}
