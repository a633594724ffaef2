//! Zero-phase low-pass filters (run forward and backward) and differences.
//!
//! Designs and edges agree with scipy's `butter`, `cheby1`, `sosfiltfilt` and `decimate` to rounding.

mod gains;
mod gaussian;
mod low_pass;
mod soften;

pub(crate) use gains::four_point_gain;
pub use gains::{central_gain, white_gain};
pub use gaussian::Gaussian;
pub use low_pass::LowPass;
pub use soften::soften;

use crate::Error;
use nalgebra::Complex;
use std::f64::consts::{FRAC_PI_2, PI};

/// Family of filters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Kind {
    /// Maximally flat; half power at the cut-off.
    Butterworth,
    /// Equal ripple in the pass band, which ends at the cut-off.
    Chebyshev1 {
        /// Ripple, dB.
        ripple_db: f64,
    },
}

/// What a low-pass is to be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Design {
    /// Family.
    pub kind: Kind,
    /// Order of one pass; forward and backward together act as twice that.
    pub order: usize,
    /// Cut-off of one pass as a fraction of half the sampling rate, between 0 and 1.
    pub cutoff: f64,
}

/// One second-order section: y = (b₀ + b₁z⁻¹ + b₂z⁻²)/(1 + a₁z⁻¹ + a₂z⁻²) x.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Section {
    /// b₀, b₁, b₂.
    pub b: [f64; 3],
    /// a₁, a₂.
    pub a: [f64; 2],
}

impl Section {
    /// Gain at a frequency given as a fraction of half the sampling rate.
    #[must_use]
    pub fn gain(&self, fraction: f64) -> f64 {
        let z = Complex::new(0.0, -PI * fraction).exp();
        ((z * self.b[2] + self.b[1]) * z + self.b[0]).norm() / ((z * self.a[1] + self.a[0]) * z + 1.0).norm()
    }
}

/// A low-pass as second-order sections.
#[derive(Debug, Clone, PartialEq)]
pub struct Filter {
    design: Design,
    sections: Vec<Section>,
}

impl Filter {
    /// Designs the filter by the bilinear transform, warped so that the cut-off is exact.
    ///
    /// # Errors
    /// An order outside 1 to 16, a cut-off not inside (0, 1), or a ripple outside 0.001 to 20 dB.
    pub fn new(design: Design) -> Result<Self, Error> {
        let refuse = |parameter: &str, value: String, accepted: &str| {
            Err(Error::Parameter { parameter: parameter.into(), value, accepted: accepted.into() })
        };
        let Design { kind, order, cutoff } = design;
        if !(1..=16).contains(&order) {
            return refuse("order", order.to_string(), "accepted are orders from 1 to 16");
        }
        if !(cutoff > 0.0 && cutoff < 1.0) {
            return refuse("cutoff", cutoff.to_string(), "accepted are fractions of Nyquist between 0 and 1");
        }
        let (poles, gain) = match kind {
            Kind::Butterworth => (butterworth(order), 1.0),
            Kind::Chebyshev1 { ripple_db } => {
                if !(0.001..=20.0).contains(&ripple_db) {
                    return refuse("ripple_db", ripple_db.to_string(), "accepted are 0.001 to 20 dB");
                }
                chebyshev(order, ripple_db)
            }
        };
        let warped = 4.0 * (FRAC_PI_2 * cutoff).tan();
        let mut sections: Vec<Section> = Vec::with_capacity(order.div_ceil(2));
        for pole in poles {
            let s = pole * warped;
            let z = (s + 4.0) / (-s + 4.0);
            // Poles come with Im ≥ 0 only; the conjugate is in the same section, the zeros are all at −1.
            let (zeros, a) = if pole.im > 0.0 {
                ([1.0, 2.0, 1.0], [-2.0 * z.re, z.norm_sqr()])
            } else {
                ([1.0, 1.0, 0.0], [-z.re, 0.0])
            };
            let unit = (1.0 + a[0] + a[1]) / zeros.iter().sum::<f64>();
            sections.push(Section { b: zeros.map(|b| b * unit), a });
        }
        if let Some(first) = sections.first_mut() {
            first.b = first.b.map(|b| b * gain);
        }
        Ok(Self { design, sections })
    }

    /// A Butterworth low-pass with its cut-off in Hz, for samples `dt` seconds apart.
    ///
    /// # Errors
    /// A cut-off that is not between 0 and half the rate.
    pub fn butterworth(order: usize, cutoff_hz: f64, dt: f64) -> Result<Self, Error> {
        let cutoff = 2.0 * cutoff_hz * dt;
        Self::new(Design { kind: Kind::Butterworth, order, cutoff }).map_err(|e| match e {
            Error::Parameter { parameter, .. } if parameter == "cutoff" => Error::Parameter {
                parameter: "cutoff_hz".into(),
                value: cutoff_hz.to_string(),
                accepted: format!(
                    "accepted is a cut-off above 0 and below {} Hz, half the sampling rate",
                    0.5 / dt
                ),
            },
            other => other,
        })
    }

    /// What it was designed for.
    #[must_use]
    pub fn design(&self) -> Design {
        self.design
    }

    /// Its sections.
    #[must_use]
    pub fn sections(&self) -> &[Section] {
        &self.sections
    }

    /// Gain of one pass at a frequency given as a fraction of half the sampling rate.
    #[must_use]
    pub fn gain(&self, fraction: f64) -> f64 {
        self.sections.iter().map(|s| s.gain(fraction)).product()
    }

    /// Samples by which either end is continued before filtering: three times the number of coefficients.
    #[must_use]
    pub fn padding(&self) -> usize {
        3 * (self.design.order + 1)
    }

    /// Samples after which the response to a disturbance, an end for example, is below one part in a thousand.
    #[must_use]
    pub fn settle(&self) -> usize {
        let slowest = self.sections.iter().map(|s| radius(s.a)).fold(0.0, f64::max);
        if slowest < 1e-6 { 1 } else { (1e-3f64.ln() / slowest.ln()).ceil().clamp(1.0, 1e9) as usize }
    }

    /// One pass, begun in the steady state of the first sample.
    fn run(&self, series: &mut [f64]) {
        let (series, _) = series.as_chunks_mut::<1>();
        for section in &self.sections {
            run([*section], series.iter_mut());
        }
    }
}

/// One pass through `S` sections of several series at once, begun in the steady state of the first sample; sections in
/// transposed direct form II.
#[inline(always)]
pub(crate) fn run<'a, const S: usize, const L: usize>(
    sections: [Section; S],
    series: impl Iterator<Item = &'a mut [f64; L]>,
) {
    let mut series = series.peekable();
    let Some(mut level) = series.peek().map(|x| **x) else { return };
    let mut state = sections.map(|Section { b, a }| {
        let gain = b.iter().sum::<f64>() / (1.0 + a[0] + a[1]);
        let z2 = level.map(|x| (b[2] - a[1] * gain) * x);
        let z1: [f64; L] = std::array::from_fn(|l| (b[1] - a[0] * gain) * level[l] + z2[l]);
        level = level.map(|x| gain * x);
        [z1, z2]
    });
    for x in series {
        for (Section { b, a }, [z1, z2]) in sections.iter().zip(&mut state) {
            for l in 0..L {
                let y = b[0] * x[l] + z1[l];
                z1[l] = b[1] * x[l] - a[0] * y + z2[l];
                z2[l] = b[2] * x[l] - a[1] * y;
                x[l] = y;
            }
        }
    }
}

/// A series continued by odd reflection at both ends, `pad` samples; `pad` is below its length.
pub(crate) fn continued<const L: usize>(series: &[[f64; L]], pad: usize) -> Vec<[f64; L]> {
    let n = series.len();
    let (Some(first), Some(last)) = (series.first(), series.last()) else { return Vec::new() };
    let beyond = |end: &[f64; L], x: &[f64; L]| std::array::from_fn(|l| 2.0 * end[l] - x[l]);
    let mut padded = Vec::with_capacity(n + 2 * pad);
    padded.extend(series[1..=pad].iter().rev().map(|x| beyond(first, x)));
    padded.extend_from_slice(series);
    padded.extend(series[n - 1 - pad..n - 1].iter().rev().map(|x| beyond(last, x)));
    padded
}

/// Largest modulus of the poles of 1 + a₁z⁻¹ + a₂z⁻².
fn radius(a: [f64; 2]) -> f64 {
    let discriminant = 0.25 * a[0] * a[0] - a[1];
    if discriminant < 0.0 { a[1].sqrt() } else { 0.5 * a[0].abs() + discriminant.sqrt() }
}

/// Poles with Im ≥ 0 of the analogue prototype.
fn butterworth(order: usize) -> Vec<Complex<f64>> {
    angles(order).map(|theta| Complex::new(-theta.cos(), snap(theta.sin()))).collect()
}

/// Poles with Im ≥ 0 of the analogue prototype, and its gain at zero frequency.
fn chebyshev(order: usize, ripple_db: f64) -> (Vec<Complex<f64>>, f64) {
    let epsilon = (10f64.powf(0.1 * ripple_db) - 1.0).sqrt();
    let mu = (1.0 / epsilon).asinh() / order as f64;
    let poles =
        angles(order).map(|t| Complex::new(-mu.sinh() * t.cos(), snap(mu.cosh() * t.sin()))).collect();
    (poles, if order.is_multiple_of(2) { 1.0 / (1.0 + epsilon * epsilon).sqrt() } else { 1.0 })
}

/// Angles of the poles from the negative real axis, those in [0, π/2).
fn angles(order: usize) -> impl Iterator<Item = f64> {
    let odd = order % 2;
    (0..order.div_ceil(2)).map(move |k| PI * (2 * k + 1 - odd) as f64 / (2 * order) as f64)
}

fn snap(imaginary: f64) -> f64 {
    if imaginary.abs() < 1e-12 { 0.0 } else { imaginary }
}

/// Runs the filter forward and backward: no phase, the square of its gain. The ends are continued by odd
/// reflection, as scipy's `sosfiltfilt` does; a series shorter than the padding is continued as far as it goes.
#[must_use]
pub fn zero_phase(filter: &Filter, series: &[f64]) -> Vec<f64> {
    zero_phase_padded(filter, series, filter.padding())
}

/// [`zero_phase`] with the ends continued by `padding` samples: MATLAB's `filtfilt` takes three times the order.
pub fn zero_phase_padded(filter: &Filter, series: &[f64], padding: usize) -> Vec<f64> {
    let n = series.len();
    let pad = padding.min(n.saturating_sub(1));
    let mut padded: Vec<f64> = continued(series.as_chunks::<1>().0, pad).into_iter().flatten().collect();
    for _ in 0..2 {
        filter.run(&mut padded);
        padded.reverse();
    }
    padded.truncate(pad + n);
    padded.drain(..pad);
    padded
}

/// Every `factor`-th sample behind a zero-phase Chebyshev low-pass of order 8 with 0.05 dB of ripple at 0.8 of the
/// new Nyquist frequency: scipy's and MATLAB's `decimate`.
///
/// # Errors
/// A factor outside 1 to 1000.
pub fn decimate(series: &[f64], factor: usize) -> Result<Vec<f64>, Error> {
    if factor == 1 {
        return Ok(series.to_vec());
    }
    let filter = decimation_filter(factor)?;
    Ok(zero_phase(&filter, series).into_iter().step_by(factor).collect())
}

/// The low-pass of [`decimate`].
pub fn decimation_filter(factor: usize) -> Result<Filter, Error> {
    if !(2..=1000).contains(&factor) {
        return Err(Error::Parameter {
            parameter: "factor".into(),
            value: factor.to_string(),
            accepted: "accepted are whole factors from 1 to 1000".into(),
        });
    }
    Filter::new(Design { kind: Kind::Chebyshev1 { ripple_db: 0.05 }, order: 8, cutoff: 0.8 / factor as f64 })
}

/// (x₊₁ − x₋₁)/2h, one-sided at the ends. A series of fewer than two samples has derivative 0.
#[must_use]
pub fn central_difference(series: &[f64], dt: f64) -> Vec<f64> {
    let n = series.len();
    if n < 2 {
        return vec![0.0; n];
    }
    (0..n)
        .map(|i| {
            let (low, high) = (i.saturating_sub(1), (i + 1).min(n - 1));
            (series[high] - series[low]) / ((high - low) as f64 * dt)
        })
        .collect()
}

/// Four-point central differences, (x₋₂ − 8x₋₁ + 8x₊₁ − x₊₂)/12h [thesis, ch. 3.5.3]: exact for polynomials to the
/// fourth degree. The two samples at either end fall back to [`central_difference`].
#[must_use]
pub fn four_point_difference(series: &[f64], dt: f64) -> Vec<f64> {
    let mut out = central_difference(series, dt);
    for (y, w) in out.iter_mut().skip(2).zip(series.windows(5)) {
        *y = (w[0] - 8.0 * w[1] + 8.0 * w[3] - w[4]) / (12.0 * dt);
    }
    out
}
