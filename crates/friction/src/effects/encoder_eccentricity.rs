//! A wave on the measured position.

use super::{About, Acts, BOTH, Comparison, Describe, Parameter, Quantity, Scale, Seat};
use crate::Dimension;

/// A wave on the position, as of an encoder disc that sits beside its centre. Its acceleration grows with v², which tells it
/// from [`Cogging`](super::Cogging), a line of the same height at every speed.
///
/// A recording that has a position alone shows it in the force. Where an accelerometer or a tachometer does not go through
/// the encoder, comparing the channels says more.
///
/// ```
/// # #[cfg(feature = "alloc")] {
/// use friction::effects::{Record, SeriesKind};
///
/// let position: Vec<f64> = (0..100).map(|i| f64::from(i) * 1e-4).collect(); // 0.1 m/s
/// let rest = [0.0; 100];
/// let record = Record { dt: 1e-3, position: &position, acceleration: &rest, direction: &rest, force: &rest };
/// let cosine = SeriesKind::EncoderEccentricity.added(0, &[0.1, 0.0], &record);
/// let expected = -(std::f64::consts::TAU * 0.1 / 0.1f64).powi(2); // −(2πv/λ)², where the cosine is 1
/// assert!((cosine[2] / expected - 1.0).abs() < 1e-3);
/// # }
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct EncoderEccentricity;

/// An amplitude times a mass.
const MOMENT: Dimension = Dimension::MASS.times(Dimension::LENGTH);

impl Describe for EncoderEccentricity {
    const ABOUT: About = About {
        id: "encoder_eccentricity",
        says: "the encoder disc is eccentric, so the position carries a wave",
        equation: "F = F_model + d²/dt² (cosine·cos(2πx/wavelength) + sine·sin(2πx/wavelength))",
        shows: "a line in position frequency that grows with v²",
        confused_with: "cogging",
        told_apart_by: "three speeds",
        gains: &[
            Parameter::gain("cosine", MOMENT, (-1e9, 1e9), "amplitude of the cosine times the mass"),
            Parameter::gain("sine", MOMENT, (-1e9, 1e9), "the same for the sine"),
        ],
        groups: BOTH,
        shape: &[Parameter::shape("wavelength", Scale::Wavelength, (1e-6, 100.0), "travel per turn of the encoder")],
        reads: &[Quantity::Position, Quantity::Time],
        seat: Seat::Channel(Quantity::Position),
        acts: Acts::OnMotion,
        comparison: Some(Comparison {
            equation: "x = x_true + amplitude·cos(2π·x_true/wavelength + phase)",
            parameters: &[
                Parameter::gain("amplitude", Dimension::LENGTH, (0.0, 100.0), "height of the wave"),
                Parameter::gain("phase", Dimension::PHASE, (-7.0, 7.0), "its phase at x = 0"),
                Parameter::shape("wavelength", Scale::Wavelength, (1e-6, 100.0), "travel per turn of the encoder"),
            ],
            confirmed_by: "no move is needed: centre the disc, read it by two heads opposite each other, or subtract the wave",
        }),
        ..About::EFFECT
    };
}

#[cfg(feature = "alloc")]
impl super::series::Operator for EncoderEccentricity {
    fn added(gain: usize, &[wavelength, _]: &[f64; 2], record: &super::Record<'_>) -> alloc::vec::Vec<f64> {
        use super::series::derivative;
        let phase = if gain == 0 { 0.0 } else { -core::f64::consts::FRAC_PI_2 };
        let wave: alloc::vec::Vec<f64> = record
            .position
            .iter()
            .map(|x| crate::Scalar::cos(core::f64::consts::TAU * x / wavelength + phase))
            .collect();
        derivative(&derivative(&wave, record.dt), record.dt)
    }
}
