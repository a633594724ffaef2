//! Sliding friction and mass from moments: [thesis, eq. 3.8] with the correction of [thesis, eq. 3.9], in closed form.
//!
//! Within a direction the Coulomb level is an intercept, so centred moments leave m, b₊ and b₋; each b meets only m, so
//! eliminating them leaves one equation for m.

use super::identified::{Estimate, Unidentified};
use super::moments::Centred;
use friction::Scalar;

/// Least correlation of accelerometer and differentiated velocity.
const CORRELATED: f32 = 0.8;
/// What the other columns must leave of one, relative to it.
const LEFT: f32 = 1e-4;
/// Squared deviations, summed over the directions, beyond which the means of a band are not the fit's.
const MEAN: f32 = 16.0;
/// The same for its scatter: a squared sum has a longer tail.
const SCATTER: f32 = 6.0;

/// Scale, offset and errors of the accelerometer; and what its reading is worth beside the difference of velocity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Accelerometer {
    pub scale: f32,
    pub offset: f32,
    /// Variance of the calibrated reading, (m/s²)².
    variance: f32,
    /// Weights of the scaled reading and of the difference in their mean, and the variance of that.
    weight_r: f32,
    weight_d: f32,
    mean_variance: f32,
}

impl Accelerometer {
    /// Reading = slope·d + constant + noise, by least squares; turned round afterwards.
    pub fn calibrate(ways: &[Centred; 2]) -> Result<Self, Unidentified> {
        let [p, n] = ways;
        let count = p.n + n.n;
        let (dd, dr, rr) = (p.dd + n.dd, p.dr + n.dr, p.rr + n.rr);
        let noise_d = (p.noise_d * p.n + n.noise_d * n.n) / count;
        let correlation = dr / Scalar::sqrt(dd * rr);
        let slope = dr / (dd - count * noise_d);
        if !(correlation >= CORRELATED && slope > 0.0 && slope.is_finite()) {
            let correlation = if correlation.is_finite() { correlation } else { 0.0 };
            return Err(Unidentified::Accelerometer { correlation });
        }
        let scale = 1.0 / slope;
        let variance = Scalar::max((rr - slope * dr) / count, 0.0) * scale * scale;
        let sum = variance + noise_d;
        let weight_r = if sum > 0.0 { noise_d / sum } else { 0.5 };
        let mean = |x: f32, y: f32| (x * p.n + y * n.n) / count;
        Ok(Self {
            scale,
            offset: mean(p.d, n.d) - scale * mean(p.r, n.r),
            variance,
            weight_r,
            weight_d: 1.0 - weight_r,
            mean_variance: weight_r * variance,
        })
    }

    /// Acceleration of a reading, m/s².
    pub fn of(&self, reading: f32) -> f32 {
        self.scale * reading + self.offset
    }

    /// Centred products of the acceleration with itself, velocity and force, and its mean.
    fn acceleration(&self, c: &Centred, weight_d: f32, weight_r: f32) -> Acceleration {
        let (d, r) = (weight_d, weight_r * self.scale);
        Acceleration {
            aa: d * d * c.dd + 2.0 * d * r * c.dr + r * r * c.rr,
            av: d * c.dv + r * c.rv,
            af: d * c.df + r * c.rf,
            a: d * c.d + weight_r * self.of(c.r),
        }
    }
}

struct Acceleration {
    aa: f32,
    av: f32,
    af: f32,
    a: f32,
}

/// What one direction contributes once its b is eliminated.
struct Way {
    acceleration: Acceleration,
    vv: f32,
    /// Change of b per mass.
    slope: f32,
}

impl Way {
    fn new(c: &Centred, acceleration: Acceleration, noise_v: f32) -> Self {
        let vv = c.vv - c.n * noise_v;
        Self { slope: acceleration.av / vv, vv, acceleration }
    }
}

/// The sliding law that was fitted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Fit {
    pub mass: Estimate,
    pub coulomb: [Estimate; 2],
    pub viscous: [Estimate; 2],
    pub mass_least_squares: f32,
    pub relative_error: f32,
    pub accelerometer: Accelerometer,
    /// Variance of the residual when acceleration is the accelerometer's alone, N². It sees a corner of the motion
    /// where it is; differences of velocity smear it over some samples.
    pub noise_by_accelerometer: f32,
    /// Of what a prediction at some speed is uncertain by: samples, mean speed, variance of the mean and of the slope.
    spread: [(f32, f32, f32); 2],
}

impl Fit {
    #[allow(clippy::similar_names)] // p and n, the two directions
    pub fn new(ways: &[Centred; 2], accelerometer: Accelerometer) -> Result<Self, Unidentified> {
        let [p, n] = ways;
        let count = p.n + n.n;
        let accel = &accelerometer;
        let (weight_d, weight_r, noise_a) = (accel.weight_d, accel.weight_r, accel.mean_variance);
        let way = |c: &Centred| Way::new(c, accel.acceleration(c, weight_d, weight_r), c.noise_v);
        let (wp, wn) = (way(p), way(n));
        for (c, w, name) in [(p, &wp, "viscous_p"), (n, &wn, "viscous_n")] {
            if !(w.vv > LEFT * c.n * c.v * c.v) {
                return Err(Unidentified::NotIdentifiable(name));
            }
        }
        let left = |w: &Way| w.acceleration.aa - w.slope * w.acceleration.av;
        let gained = |c: &Centred, w: &Way| w.acceleration.af - w.slope * c.vf;
        let whole = wp.acceleration.aa + wn.acceleration.aa;
        let pivot = left(&wp) + left(&wn) - count * noise_a;
        if !(pivot > LEFT * whole) {
            return Err(Unidentified::NotIdentifiable("mass"));
        }
        let mass = (gained(p, &wp) + gained(n, &wn)) / pivot;
        let slopes = |c: &Centred, w: &Way| (c.vf - mass * w.acceleration.av) / w.vv;
        let (bp, bn) = (slopes(p, &wp), slopes(n, &wn));
        let squares = rest(p, &wp.acceleration, mass, bp) + rest(n, &wn.acceleration, mass, bn);
        let squares = Scalar::max(squares, 0.0);
        let noise = squares / (count - 5.0);
        // Fuller 1987, 2.2: V = M⁻¹σ² + M⁻¹(Sσ² + Sββ'S)M⁻¹, here for the mass
        let shrunk = count * noise_a / pivot;
        let mass_variance = noise / pivot * (1.0 + shrunk) + mass * mass * shrunk * shrunk / count;
        let level = |c: &Centred, w: &Way, b: f32| {
            let a = w.acceleration.a;
            let through = a - c.v * w.slope;
            let variance = noise / c.n + c.v * c.v * noise / w.vv + through * through * mass_variance;
            (c.f - mass * a - b * c.v, Scalar::sqrt(variance))
        };
        let viscous = |w: &Way, b: f32| Estimate {
            value: b,
            std: Scalar::sqrt(noise / w.vv + w.slope * w.slope * mass_variance),
        };
        let ((level_p, std_p), (level_n, std_n)) = (level(p, &wp, bp), level(n, &wn, bn));
        let mean_square = p.ff + p.n * p.f * p.f + n.ff + n.n * n.f * n.f;
        // [thesis, eq. 3.8] with the accelerometer alone
        let alone = |c: &Centred| Way::new(c, accel.acceleration(c, 0.0, 1.0), 0.0);
        let (ap, an) = (alone(p), alone(n));
        Ok(Self {
            mass: Estimate { value: mass, std: Scalar::sqrt(mass_variance) },
            coulomb: [Estimate { value: level_p, std: std_p }, Estimate { value: -level_n, std: std_n }],
            viscous: [viscous(&wp, bp), viscous(&wn, bn)],
            mass_least_squares: (gained(p, &ap) + gained(n, &an)) / (left(&ap) + left(&an)),
            relative_error: if mean_square > 0.0 { Scalar::sqrt(squares / mean_square) } else { 0.0 },
            noise_by_accelerometer: noise + mass * mass * Scalar::max(accel.variance - noise_a, 0.0),
            accelerometer,
            spread: [(p.v, noise / p.n, noise / wp.vv), (n.v, noise / n.n, noise / wn.vv)],
        })
    }

    /// Friction at a speed in one direction, a magnitude, N.
    pub fn sliding(&self, way: usize, speed: f32) -> f32 {
        match (self.coulomb.get(way), self.viscous.get(way)) {
            (Some(level), Some(b)) => level.value + b.value * speed,
            _ => 0.0,
        }
    }

    /// Whether a band slides by this law, as far as noise lets one see.
    pub fn explains(&self, band: &[Centred; 2]) -> bool {
        let mut off = 0.0;
        for (way, c) in band.iter().enumerate().filter(|(_, c)| c.n >= 2.0) {
            let (Some(level), Some(b), Some((middle, at_middle, slope))) =
                (self.coulomb.get(way), self.viscous.get(way), self.spread.get(way))
            else {
                continue;
            };
            let b = b.value;
            let level = if way == 0 { level.value } else { -level.value };
            let mass = self.mass.value;
            let a = self.accelerometer.acceleration(c, 0.0, 1.0);
            let mean = c.f - mass * a.a - b * c.v - level;
            let squares = rest(c, &a, mass, b);
            let away = c.v - middle;
            let noise = self.noise_by_accelerometer;
            let degrees = c.n - 1.0;
            if squares > noise * (degrees + SCATTER * Scalar::sqrt(2.0 * degrees)) {
                return false;
            }
            off += mean * mean / (noise / c.n + at_middle + away * away * slope);
        }
        off <= MEAN
    }
}

/// Squared deviations of the force from m·a + b·v, about their mean.
fn rest(c: &Centred, a: &Acceleration, mass: f32, b: f32) -> f32 {
    c.ff + mass * (mass * a.aa - 2.0 * a.af + 2.0 * b * a.av) + b * (b * c.vv - 2.0 * c.vf)
}
