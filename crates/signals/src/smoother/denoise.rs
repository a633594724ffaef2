//! The motion behind noisy channels of position, velocity and acceleration: which samples slide, which way, how far.
//!
//! Selecting samples by their measured velocity would select them by their errors. In a Rauch-Tung-Striebel smoother of ẍ = a
//! the error of a single sample has a few percent of its weight. Unlike a low-pass, the smoother does not blur a
//! break-away, because the accelerometer measures it.

use nalgebra::{Matrix2, Vector2};

/// Channels with the variance of the error of each sample. Equal lengths.
pub struct Measured<'a> {
    /// m, m².
    pub position: (&'a [f64], f64),
    /// m/s, (m/s)².
    pub velocity: (&'a [f64], f64),
    /// m/s², (m/s²)².
    pub acceleration: (&'a [f64], f64),
    /// s.
    pub dt: f64,
}

/// Smoothed position and velocity with their standard deviations: of the position halfway, of each velocity.
#[derive(Default)]
pub struct Smoothed {
    /// m.
    pub position: Vec<f64>,
    /// m.
    pub position_std: f64,
    /// m/s.
    pub velocity: Vec<f64>,
    /// m/s.
    pub velocity_std: Vec<f64>,
}

/// One measurement into mean and covariance; returns how surprising it was.
fn update(mean: &mut Vector2<f64>, p: &mut Matrix2<f64>, k: usize, value: f64, variance: f64) -> f64 {
    let expected = (p[(k, k)] + variance).max(f64::MIN_POSITIVE);
    let gain = p.column(k) / expected;
    let innovation = value - mean[k];
    *mean += gain * innovation;
    *p -= gain * p.row(k).clone_owned();
    *p = (*p + p.transpose()) * 0.5;
    innovation * innovation / expected + expected.ln()
}

/// Smooths; channels without error come back as they are.
pub fn smooth(m: &Measured<'_>) -> Smoothed {
    let (x, var_x) = m.position;
    let (v, var_v) = m.velocity;
    let n = x.len().min(v.len()).min(m.acceleration.0.len());
    let dt = m.dt;
    if n < 2 || var_v <= 0.0 {
        return Smoothed {
            position: x.to_vec(),
            position_std: var_x.max(0.0).sqrt(),
            velocity: v.to_vec(),
            velocity_std: vec![0.0; v.len()],
        };
    }
    // A position without error still has the error of assuming a straight acceleration within a step.
    let var_x = var_x.max((1e-3 * var_v.sqrt() * dt).powi(2));
    // Between two samples an acceleration goes straight where nature makes it, and is held where a controller does.
    let passes = [0.5, 1.0].map(|newer| Forward::run(m, n, var_x, newer));
    let [straight, held] = passes;
    let forward = if held.surprise < straight.surprise { held } else { straight };
    forward.back(dt)
}

/// The Kalman filter's pass: mean and covariance behind each sample, and ahead of it.
struct Forward {
    mean: Vec<Vector2<f64>>,
    cov: Vec<Matrix2<f64>>,
    ahead: Vec<Vector2<f64>>,
    ahead_cov: Vec<Matrix2<f64>>,
    /// Twice the negative logarithm of the likelihood, up to a constant.
    surprise: f64,
}

fn drift(dt: f64) -> Matrix2<f64> {
    Matrix2::new(1.0, dt, 0.0, 1.0)
}

impl Forward {
    /// `newer` is the weight of a sample's own acceleration in the mean over the step that ends with it.
    fn run(m: &Measured<'_>, n: usize, var_x: f64, newer: f64) -> Self {
        let ((x, _), (v, var_v), (a, var_a), dt) = (m.position, m.velocity, m.acceleration, m.dt);
        let drift = drift(dt);
        let start = (Vector2::new(x[0], v[0]), Matrix2::new(var_x, 0.0, 0.0, var_v));
        let mut out = Self {
            mean: vec![start.0; n],
            cov: vec![start.1; n],
            ahead: vec![start.0; n],
            ahead_cov: vec![start.1; n],
            surprise: 0.0,
        };
        let spread = Vector2::new(0.5 * dt * dt, dt);
        for k in 1..n {
            let change = a[k] - a[k - 1];
            // Error of the mean acceleration of a step: of the sensor, each of whose errors is in two steps, and what two
            // samples miss where it jumps.
            let q = var_a + (change * change - 2.0 * var_a).max(0.0) / 12.0;
            let push = newer * a[k] + (1.0 - newer) * a[k - 1];
            let mean = drift * out.mean[k - 1] + spread * push;
            let cov = drift * out.cov[k - 1] * drift.transpose() + spread * spread.transpose() * q;
            (out.ahead[k], out.ahead_cov[k]) = (mean, cov);
            let (mut mean, mut cov) = (mean, cov);
            out.surprise += update(&mut mean, &mut cov, 0, x[k], var_x);
            out.surprise += update(&mut mean, &mut cov, 1, v[k], var_v);
            (out.mean[k], out.cov[k]) = (mean, cov);
        }
        out
    }

    /// The smoother's pass, from the end.
    fn back(self, dt: f64) -> Smoothed {
        let Self { mut mean, mut cov, ahead, ahead_cov, .. } = self;
        let (n, drift) = (mean.len(), drift(dt));
        for k in (0..n - 1).rev() {
            let Some(inverse) = ahead_cov[k + 1].try_inverse() else { continue };
            let gain = cov[k] * drift.transpose() * inverse;
            let (later, later_cov) = (mean[k + 1], cov[k + 1]);
            mean[k] += gain * (later - ahead[k + 1]);
            cov[k] += gain * (later_cov - ahead_cov[k + 1]) * gain.transpose();
        }
        Smoothed {
            position: mean.iter().map(|m| m[0]).collect(),
            position_std: cov[n / 2][(0, 0)].max(0.0).sqrt(),
            velocity: mean.iter().map(|m| m[1]).collect(),
            velocity_std: cov.iter().map(|c| c[(1, 1)].max(0.0).sqrt()).collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};

    #[test]
    fn a_break_away_is_not_blurred_and_noise_falls_five_times() {
        let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(3);
        let mut draw = |std: f64| -> f64 {
            let x: f64 = StandardNormal.sample(&mut random);
            x * std
        };
        let dt = 1e-3;
        let (mut truth, mut a, mut x) = (vec![0.0], vec![0.0], vec![0.0]);
        for k in 1..2000 {
            a.push(if k < 1000 { 0.0 } else { 2.0 * (0.01 * k as f64).cos() });
            truth.push(truth[k - 1] + 0.5 * (a[k] + a[k - 1]) * dt);
            x.push(x[k - 1] + 0.5 * (truth[k] + truth[k - 1]) * dt);
        }
        let mut noisy =
            |series: &[f64], std: f64| -> Vec<f64> { series.iter().map(|y| y + draw(std)).collect() };
        let (position, velocity, acceleration) =
            (noisy(&x, 5.76e-5), noisy(&truth, 3.18e-3), noisy(&a, 0.2379));
        let s = smooth(&Measured {
            position: (&position, 5.76e-5f64.powi(2)),
            velocity: (&velocity, 3.18e-3f64.powi(2)),
            acceleration: (&acceleration, 0.2379f64.powi(2)),
            dt,
        });
        let rms = |a: &[f64], b: &[f64]| {
            (a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>() / 2000.0).sqrt()
        };
        let (ev, ex) = (rms(&s.velocity, &truth), rms(&s.position, &x));
        println!(
            "error {ev:.2e} m/s, reported {:.2e}; {ex:.2e} m, reported {:.2e}",
            s.velocity_std[1000], s.position_std
        );
        assert!(ev < 3.18e-3 / 4.0 && (s.velocity_std[1000] / ev - 1.0).abs() < 0.5);
        assert!(ex < 5.76e-5 / 3.0 && (s.position_std / ex - 1.0).abs() < 0.5);
    }

    #[test]
    fn without_noise_nothing_changes() {
        let (v, none) = ([0.0, 1.0, -2.0], [9.0; 3]);
        let m =
            |v| Measured { position: (&none, 0.0), velocity: (v, 0.0), acceleration: (&none, 1.0), dt: 1e-3 };
        assert_eq!(smooth(&m(&v)).velocity, v);
        assert!(smooth(&m(&[])).velocity.is_empty());
    }
}
