//! Masks whose edges a filter does not ring at.

use std::f64::consts::PI;

/// Lets a mask of zeros and ones rise over `width` samples beside every gap, as a half cosine. An edge of a derivative is smeared by
/// the filter it was taken behind; cut through by a hard mask it would not cancel.
///
/// ```
/// let mut mask = [1.0, 1.0, 1.0, 0.0, 0.0, 1.0];
/// signals::soften(&mut mask, 1);
/// let halves = [mask[2], mask[5]].map(|m| (m - 0.5).abs() < 1e-15);
/// assert_eq!((halves, mask[1], mask[3]), ([true, true], 1.0, 0.0));
/// ```
pub fn soften(mask: &mut [f64], width: usize) {
    let run = |since: &mut usize, mask: f64| {
        *since = if mask == 0.0 { 0 } else { since.saturating_add(1) };
        *since
    };
    let mut since = usize::MAX;
    let mut nearest: Vec<usize> = mask.iter().map(|m| run(&mut since, *m)).collect();
    since = usize::MAX;
    for (near, m) in nearest.iter_mut().zip(&*mask).rev() {
        *near = (*near).min(run(&mut since, *m));
    }
    for (m, near) in mask.iter_mut().zip(nearest) {
        if near <= width {
            *m = 0.5 - 0.5 * (PI * near as f64 / (width + 1) as f64).cos();
        }
    }
}
