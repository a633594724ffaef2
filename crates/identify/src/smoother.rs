//! The velocity behind a noisy velocity channel, with the accelerometer's help: which samples slide, and which way.
//!
//! Choosing samples by the velocity they were measured with would choose them by their errors. A
//! Rauch-Tung-Striebel smoother of v̇ = a leaves a sample's own error a few percent of its weight, and, unlike a
//! low-pass, does not blur a break-away, because the accelerometer saw it.

/// Smoothed velocity and its standard deviation, from channels with error variances `var_v` (m/s)² and
/// `var_a` (m/s²)². A velocity without error is returned as it is.
pub(crate) fn smooth(v: &[f64], a: &[f64], dt: f64, var_v: f64, var_a: f64) -> (Vec<f64>, f64) {
    let n = v.len().min(a.len());
    let Some(&first) = v.first() else { return (Vec::new(), 0.0) };
    if var_v <= 0.0 || n < 2 {
        return (v.to_vec(), var_v.max(0.0).sqrt());
    }
    // Mean of the two accelerations a step spans, and what the mean misses where acceleration jumps within it.
    let jumps: Vec<f64> = a.windows(2).map(|w| (w[1] - w[0]).powi(2)).collect();
    let step_error = |k: usize| 0.5 * var_a * dt * dt + (jumps[k] - 2.0 * var_a).max(0.0) * dt * dt / 12.0;
    let (mut mean, mut variance) = (vec![first; n], vec![var_v; n]);
    let (mut ahead, mut ahead_variance) = (vec![first; n], vec![var_v; n]);
    for k in 1..n {
        ahead[k] = mean[k - 1] + 0.5 * (a[k - 1] + a[k]) * dt;
        ahead_variance[k] = variance[k - 1] + step_error(k - 1);
        let gain = ahead_variance[k] / (ahead_variance[k] + var_v);
        mean[k] = ahead[k] + gain * (v[k] - ahead[k]);
        variance[k] = (1.0 - gain) * ahead_variance[k];
    }
    for k in (0..n - 1).rev() {
        let gain = variance[k] / ahead_variance[k + 1];
        mean[k] += gain * (mean[k + 1] - ahead[k + 1]);
        variance[k] += gain * gain * (variance[k + 1] - ahead_variance[k + 1]);
    }
    let typical = variance[n / 2].max(0.0).sqrt();
    (mean, typical)
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
        let mut truth = vec![0.0];
        let mut a = vec![0.0];
        for k in 1..2000 {
            a.push(if k < 1000 { 0.0 } else { 2.0 * (0.01 * k as f64).cos() });
            truth.push(truth[k - 1] + 0.5 * (a[k] + a[k - 1]) * dt);
        }
        let v: Vec<f64> = truth.iter().map(|x| x + draw(3.18e-3)).collect();
        let noisy: Vec<f64> = a.iter().map(|x| x + draw(0.2379)).collect();
        let (smoothed, told) = smooth(&v, &noisy, dt, 3.18e-3f64.powi(2), 0.2379f64.powi(2));
        let error = (smoothed.iter().zip(&truth).map(|(s, t)| (s - t).powi(2)).sum::<f64>() / 2000.0).sqrt();
        println!("error {error:.2e} m/s, told {told:.2e}");
        assert!(error < 3.18e-3 / 4.0 && (told / error - 1.0).abs() < 0.5);
    }

    #[test]
    fn without_noise_nothing_changes() {
        let v = [0.0, 1.0, -2.0];
        assert_eq!(smooth(&v, &[9.0; 3], 1e-3, 0.0, 1.0).0, v);
        assert!(smooth(&[], &[], 1e-3, 1.0, 1.0).0.is_empty());
    }
}
