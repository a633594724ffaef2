//! Root mean square, spread and similar measures of a series.

/// Root mean square; 0 of an empty series.
#[must_use]
pub fn rms(series: &[f64]) -> f64 {
    if series.is_empty() {
        return 0.0;
    }
    (series.iter().map(|x| x * x).sum::<f64>() / series.len() as f64).sqrt()
}

/// Standard deviation about the mean; 0 of an empty series.
#[must_use]
pub fn spread(series: &[f64]) -> f64 {
    let n = series.len().max(1) as f64;
    let mean = series.iter().sum::<f64>() / n;
    (series.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / n).sqrt()
}

/// The value below which the share `p` of the finite samples lies; 0 where there are none.
#[must_use]
pub fn quantile(series: &[f64], p: f64) -> f64 {
    let mut finite: Vec<f64> = series.iter().copied().filter(|x| x.is_finite()).collect();
    if finite.is_empty() {
        return 0.0;
    }
    let at = (p.clamp(0.0, 1.0) * (finite.len() - 1) as f64).round() as usize;
    *finite.select_nth_unstable_by(at, f64::total_cmp).1
}
