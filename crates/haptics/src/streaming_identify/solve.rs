//! From sums to parameters. Runs in a task, not in the interrupt; `f64`.

use super::recorder::{DirectionSums, Sums};
use crate::{Device, LawKind, Settings};
use core::fmt;

/// The five columns of eq. 3.6.
const NAMES: [&str; 5] = ["mass", "coulomb_p", "viscous_p", "coulomb_n", "viscous_n"];
type Vector = [f64; 5];
type Matrix = [[f64; 5]; 5];

/// A parameter with its standard deviation.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Estimate {
    /// Value.
    pub value: f64,
    /// Standard deviation.
    pub std: f64,
}

/// Result of an identification on the device. Levels are magnitudes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Identified {
    /// m, kg.
    pub mass: Estimate,
    /// C_p, N.
    pub coulomb_p: Estimate,
    /// b_p, N·s/m.
    pub viscous_p: Estimate,
    /// C_n, N.
    pub coulomb_n: Estimate,
    /// b_n, N·s/m.
    pub viscous_n: Estimate,
    /// D_p, N: the largest friction while |v| < Δv, not below C_p.
    pub static_p: f64,
    /// D_n, N.
    pub static_n: f64,
    /// Mass by plain least squares (eq. 3.8), kg: what the noise of the accelerometer would have made of it.
    pub mass_least_squares: f64,
    /// True acceleration over accelerometer reading.
    pub accel_scale: f64,
    /// Added to the scaled reading, m/s².
    pub accel_offset: f64,
    /// Variance of the calibrated acceleration, (m/s²)².
    pub variance_acceleration: f64,
    /// Variance of the velocity, (m/s)².
    pub variance_velocity: f64,
    /// ‖e‖/‖F‖ over the samples used.
    pub relative_error: f64,
    /// Samples used.
    pub used: u32,
    /// Samples set aside as too slow.
    pub set_aside: u32,
    /// Δv, m/s.
    pub dv: f64,
}

/// Why there is no result.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Unidentified {
    /// Too few samples faster than Δv in one direction.
    TooLittleMotion {
        /// Used samples against positive motion.
        positive: u32,
        /// Used samples against negative motion.
        negative: u32,
    },
    /// The accelerometer does not follow the differentiated velocity.
    Accelerometer {
        /// Correlation of the two.
        correlation: f64,
    },
    /// The motion does not tell this parameter from the others.
    NotIdentifiable(&'static str),
}

impl fmt::Display for Unidentified {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TooLittleMotion { positive, negative } => write!(
                f,
                "too little motion: {positive} samples forward and {negative} back are faster than dv; 50 each are needed"
            ),
            Self::Accelerometer { correlation } => write!(
                f,
                "the accelerometer does not follow the motion (correlation {correlation:.3}, at least 0.8 is needed)"
            ),
            Self::NotIdentifiable(name) => write!(f, "{name} cannot be told from the others by this motion"),
        }
    }
}

impl core::error::Error for Unidentified {}

/// Fewest used samples in a direction.
const FEWEST: u32 = 50;
/// Least correlation of accelerometer and differentiated velocity.
const CORRELATED: f64 = 0.8;

/// Scale, offset and noise of the accelerometer.
struct Accelerometer {
    scale: f64,
    offset: f64,
    variance: f64,
}

impl Sums {
    /// Solves eq. 3.8 and 3.9.
    ///
    /// # Errors
    /// [`Unidentified`] when the motion or the accelerometer does not carry the parameters.
    pub fn solve(&self) -> Result<Identified, Unidentified> {
        let (p, n) = (&self.positive, &self.negative);
        if p.samples < FEWEST || n.samples < FEWEST {
            return Err(Unidentified::TooLittleMotion { positive: p.samples, negative: n.samples });
        }
        // fourth differences of white noise have 70 times its variance; centring has halved it, and tied neighbours
        let variance_velocity = self.rough.value() / f64::from(self.recorded) / 70.0;
        let accel = self.accelerometer(variance_velocity)?;
        let used = f64::from(p.samples) + f64::from(n.samples);
        let (gram, moment, force_square) = self.normal_equations(&accel, used);
        let plain = solve(&gram, &moment).map_err(|at| Unidentified::NotIdentifiable(name(at)))?.0;
        let noise = [accel.variance, 0.0, variance_velocity, 0.0, variance_velocity];
        let mut corrected = gram;
        for (k, row) in corrected.iter_mut().enumerate() {
            if let (Some(diagonal), Some(s)) = (row.get_mut(k), noise.get(k)) {
                *diagonal -= s;
            }
        }
        let (beta, inverse) =
            solve(&corrected, &moment).map_err(|at| Unidentified::NotIdentifiable(name(at)))?;
        let residual = (force_square - 2.0 * dot(&beta, &moment) + quadratic(&gram, &beta)).max(0.0);
        let std = deviations(&inverse, &noise, &beta, residual, used);
        let estimate = |k: usize, sign: f64| Estimate {
            value: sign * beta.get(k).copied().unwrap_or_default(),
            std: std.get(k).copied().unwrap_or_default(),
        };
        let mass = estimate(0, 1.0);
        let (coulomb_p, coulomb_n) = (estimate(1, 1.0), estimate(3, 1.0));
        let at_rest = |extreme: Option<(f32, f32)>| {
            extreme.map_or(0.0, |(force, reading)| {
                f64::from(force) - mass.value * (accel.scale * f64::from(reading) + accel.offset)
            })
        };
        Ok(Identified {
            mass,
            coulomb_p,
            viscous_p: estimate(2, 1.0),
            coulomb_n,
            viscous_n: estimate(4, 1.0),
            static_p: at_rest(self.highest).max(coulomb_p.value),
            static_n: (-at_rest(self.lowest)).max(coulomb_n.value),
            mass_least_squares: plain.first().copied().unwrap_or_default(),
            accel_scale: accel.scale,
            accel_offset: accel.offset,
            variance_acceleration: accel.variance,
            variance_velocity,
            relative_error: if force_square > 0.0 { libm::sqrt(residual / force_square) } else { 0.0 },
            used: p.samples + n.samples,
            set_aside: self.recorded.saturating_sub(p.samples + n.samples),
            dv: f64::from(self.dv),
        })
    }

    /// Reading = slope·d + constant + noise, by least squares; turned round afterwards.
    fn accelerometer(&self, variance_velocity: f64) -> Result<Accelerometer, Unidentified> {
        let count = f64::from(self.recorded);
        let (mean_d, mean_r) = (self.d.value() / count, self.r.value() / count);
        let var_d = self.dd.value() / count - mean_d * mean_d;
        let var_r = self.rr.value() / count - mean_r * mean_r;
        let cov = self.dr.value() / count - mean_d * mean_r;
        let correlation = cov / libm::sqrt(var_d * var_r);
        // 130/144: the sum of the squared weights of the four-point difference
        let noise_d = variance_velocity * (130.0 / 144.0) / f64::from(self.period * self.period);
        let slope = cov / (var_d - noise_d);
        if !(correlation >= CORRELATED && slope > 0.0 && slope.is_finite()) {
            return Err(Unidentified::Accelerometer {
                correlation: if correlation.is_finite() { correlation } else { 0.0 },
            });
        }
        let scale = 1.0 / slope;
        let variance = (var_r - slope * cov).max(0.0) * scale * scale;
        Ok(Accelerometer { scale, offset: mean_d - scale * mean_r, variance })
    }

    /// XᵀX/N, XᵀF/N and FᵀF/N with the calibrated acceleration; sgn v₋ is −1 where v < 0.
    fn normal_equations(&self, accel: &Accelerometer, used: f64) -> (Matrix, Vector, f64) {
        let (scale, offset) = (accel.scale, accel.offset);
        let side = |s: &DirectionSums| {
            let n = f64::from(s.samples);
            let (r, v, f) = (s.r.value(), s.v.value(), s.f.value());
            (
                scale * scale * s.rr.value() + 2.0 * scale * offset * r + offset * offset * n,
                scale * r + offset * n,
                scale * s.rv.value() + offset * v,
                scale * s.rf.value() + offset * f,
                (n, v, f, s.vv.value(), s.vf.value(), s.ff.value()),
            )
        };
        let (aa_p, a_p, av_p, af_p, (n_p, v_p, f_p, vv_p, vf_p, ff_p)) = side(&self.positive);
        let (aa_n, a_n, av_n, af_n, (n_n, v_n, f_n, vv_n, vf_n, ff_n)) = side(&self.negative);
        let gram = [
            [aa_p + aa_n, a_p, av_p, -a_n, av_n],
            [a_p, n_p, v_p, 0.0, 0.0],
            [av_p, v_p, vv_p, 0.0, 0.0],
            [-a_n, 0.0, 0.0, n_n, -v_n],
            [av_n, 0.0, 0.0, -v_n, vv_n],
        ];
        let moment = [af_p + af_n, f_p, vf_p, -f_n, vf_n];
        (gram.map(|row| row.map(|x| x / used)), moment.map(|x| x / used), (ff_p + ff_n) / used)
    }
}

/// Standard deviations of Fuller's estimator with the error variances known (Fuller 1987, 2.2):
/// V = [M⁻¹σ² + M⁻¹(Sσ² + Sββ'S)M⁻¹]/N, with σ² the variance of e = F − Xβ, M = XᵀX/N − S.
fn deviations(inverse: &Matrix, noise: &Vector, beta: &Vector, residual: f64, used: f64) -> Vector {
    let sb: Vector = core::array::from_fn(|k| at(noise, k) * at(beta, k));
    core::array::from_fn(|k| {
        let row = inverse.get(k).copied().unwrap_or_default();
        let through: f64 = row.iter().zip(noise).map(|(m, s)| m * m * s).sum();
        let along = dot(&row, &sb);
        libm::sqrt(((at(&row, k) + through) * residual + along * along) / used)
    })
}

fn name(at: usize) -> &'static str {
    NAMES.get(at).copied().unwrap_or("a parameter")
}

fn at(x: &Vector, k: usize) -> f64 {
    x.get(k).copied().unwrap_or_default()
}

fn dot(a: &Vector, b: &Vector) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn quadratic(m: &Matrix, x: &Vector) -> f64 {
    m.iter().zip(x).map(|(row, xi)| xi * dot(row, x)).sum()
}

/// Solution and inverse of a symmetric positive definite system, by Gauss-Jordan on the diagonal; or the column whose
/// pivot vanished.
#[allow(clippy::indexing_slicing)] // constant 5×5, outside the control step
fn solve(matrix: &Matrix, right: &Vector) -> Result<(Vector, Matrix), usize> {
    let mut m = *matrix;
    let mut inverse: Matrix = core::array::from_fn(|r| core::array::from_fn(|c| f64::from(u8::from(r == c))));
    for k in 0..5 {
        let pivot = m[k][k];
        // what the other columns leave of this one, relative to it
        if !(pivot > 1e-9 * matrix[k][k].abs() && pivot.is_finite()) {
            return Err(k);
        }
        for c in 0..5 {
            m[k][c] /= pivot;
            inverse[k][c] /= pivot;
        }
        for r in 0..5 {
            if r != k {
                let factor = m[r][k];
                for c in 0..5 {
                    m[r][c] -= factor * m[k][c];
                    inverse[r][c] -= factor * inverse[k][c];
                }
            }
        }
    }
    Ok((core::array::from_fn(|r| dot(&inverse[r], right)), inverse))
}

impl Identified {
    /// A preset of what was found: a Karnopp block with the coupling of `base`. Levels are kept physical and
    /// within what `device` can hold; `Settings::validate` has the last word.
    #[must_use]
    pub fn to_settings(&self, base: &Settings, device: &Device) -> Settings {
        let level = |x: f64| (x.max(0.0) as f32).min(device.force_max);
        let (f_dynamic_p, f_dynamic_n) = (level(self.coulomb_p.value), level(self.coulomb_n.value));
        Settings {
            law: LawKind::Karnopp,
            f_dynamic_p,
            f_dynamic_n,
            f_static_p: level(self.static_p).max(f_dynamic_p),
            f_static_n: level(self.static_n).max(f_dynamic_n),
            damping_p: self.viscous_p.value as f32,
            damping_n: self.viscous_n.value as f32,
            dv: self.dv as f32,
            mass: self.mass.value as f32,
            ..*base
        }
    }
}
