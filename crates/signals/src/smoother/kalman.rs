//! Gaussian state of a moving body and its propagation: prediction under white jerk, scalar updates, smoothing.
//!
//! All quantities are in the smoother's own units (see [`super::Units`]): time in typical sample periods, length in
//! standard deviations of the position. The state is then of order one whatever the sensor, and a covariance stays
//! well conditioned.

/// Position, velocity, acceleration.
pub(super) type Vector = [f64; 3];

/// Symmetric 3×3 matrix: xx, xv, xa, vv, va, aa.
pub(super) type Symmetric = [f64; 6];

/// General 3×3 matrix, by rows.
pub(super) type Matrix = [Vector; 3];

/// Mean and covariance of the state.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Gaussian {
    pub mean: Vector,
    pub cov: Symmetric,
}

/// One scalar measurement y = h·state + e, e of variance `variance`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Scalar {
    /// State component observed: 0, 1 or 2.
    pub component: usize,
    pub value: f64,
    pub variance: f64,
}

/// Index of (i, j) in a [`Symmetric`].
const INDEX: [[usize; 3]; 3] = [[0, 1, 2], [1, 3, 4], [2, 4, 5]];

pub(super) fn full(s: &Symmetric) -> Matrix {
    [[s[0], s[1], s[2]], [s[1], s[3], s[4]], [s[2], s[4], s[5]]]
}

fn product(a: &Matrix, b: &Matrix) -> Matrix {
    let mut out = [[0.0; 3]; 3];
    for (row, a) in out.iter_mut().zip(a) {
        for (j, x) in row.iter_mut().enumerate() {
            *x = a[0] * b[0][j] + a[1] * b[1][j] + a[2] * b[2][j];
        }
    }
    out
}

/// A·S·Aᵀ.
fn congruence(a: &Matrix, s: &Symmetric) -> Symmetric {
    let b = product(a, &full(s));
    let entry = |i: usize, j: usize| b[i][0] * a[j][0] + b[i][1] * a[j][1] + b[i][2] * a[j][2];
    [entry(0, 0), entry(0, 1), entry(0, 2), entry(1, 1), entry(1, 2), entry(2, 2)]
}

fn plus(a: &Symmetric, b: &Symmetric) -> Symmetric {
    std::array::from_fn(|i| a[i] + b[i])
}

fn transition(d: f64) -> Matrix {
    [[1.0, d, 0.5 * d * d], [0.0, 1.0, d], [0.0, 0.0, 1.0]]
}

fn advanced(m: &Vector, d: f64) -> Vector {
    [m[0] + d * (m[1] + 0.5 * d * m[2]), m[1] + d * m[2], m[2]]
}

/// Covariance that white jerk of unit density adds over `d`.
pub(super) fn jerk_covariance(d: f64) -> Symmetric {
    let (d2, d3) = (d * d, d * d * d);
    [d3 * d2 / 20.0, d2 * d2 / 8.0, d3 / 6.0, d3 / 3.0, 0.5 * d2, d]
}

/// Inverse of a positive definite matrix by Cholesky factorisation; None where it is not positive definite.
fn inverse(s: &Symmetric) -> Option<Symmetric> {
    // Scaled to unit diagonal: position and acceleration over a long step differ by orders of magnitude.
    let scale = [s[0], s[3], s[5]].map(|d| d.sqrt().recip());
    let r = |k: usize, i: usize, j: usize| s[k] * scale[i] * scale[j];
    let l10 = r(1, 0, 1);
    let l20 = r(2, 0, 2);
    let l11 = (1.0 - l10 * l10).sqrt();
    let l21 = (r(4, 1, 2) - l20 * l10) / l11;
    let l22 = (1.0 - l20 * l20 - l21 * l21).sqrt();
    // The inverse factor, then its square.
    let (i11, i22) = (l11.recip(), l22.recip());
    let i10 = -l10 * i11;
    let i21 = -l21 * i11 * i22;
    let i20 = -(l20 + l21 * i10) * i22;
    let out = [
        (1.0 + i10 * i10 + i20 * i20) * scale[0] * scale[0],
        (i10 * i11 + i20 * i21) * scale[0] * scale[1],
        i20 * i22 * scale[0] * scale[2],
        (i11 * i11 + i21 * i21) * scale[1] * scale[1],
        i21 * i22 * scale[1] * scale[2],
        i22 * i22 * scale[2] * scale[2],
    ];
    out.iter().all(|x| x.is_finite()).then_some(out)
}

impl Gaussian {
    /// The state `d` later, under white jerk of density `density`.
    pub fn predicted(&self, d: f64, density: f64) -> Self {
        let q = jerk_covariance(d);
        let [xx, xv, xa, vv, va, aa] = self.cov;
        // F·P row by row, then ·Fᵀ.
        let (h, two) = (0.5 * d * d, d);
        let (r0x, r0v, r0a) = (xx + two * xv + h * xa, xv + two * vv + h * va, xa + two * va + h * aa);
        let (r1v, r1a) = (vv + two * va, va + two * aa);
        let cov = [
            r0x + two * r0v + h * r0a + density * q[0],
            r0v + two * r0a + density * q[1],
            r0a + density * q[2],
            r1v + two * r1a + density * q[3],
            r1a + density * q[4],
            aa + density * q[5],
        ];
        Self { mean: advanced(&self.mean, d), cov }
    }

    /// Takes a measurement in; returns the squared innovation over its variance, plus the logarithm of that variance.
    pub fn update(&mut self, m: &Scalar) -> f64 {
        let c = m.component;
        let column = INDEX[c].map(|k| self.cov[k]);
        let variance = column[c] + m.variance;
        if !(variance > 0.0) {
            return 0.0;
        }
        let innovation = m.value - self.mean[c];
        let gain = column.map(|p| p / variance);
        for (x, g) in self.mean.iter_mut().zip(gain) {
            *x += g * innovation;
        }
        // Joseph's form for one component, written out: what is observed keeps variance·gain exactly.
        let keep = m.variance / variance;
        let before = self.cov;
        for i in 0..3 {
            for j in i..3 {
                let k = INDEX[i][j];
                self.cov[k] =
                    if i == c || j == c { before[k] * keep } else { before[k] - gain[i] * column[j] };
            }
        }
        innovation * innovation / variance + variance.ln()
    }
}

/// What one step backward yields besides the smoothed state: the power of the jerk seen in it, and what it would be on
/// average if the density were right, both over the density.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct JerkPower {
    pub seen: f64,
    pub expected: f64,
}

/// One Rauch-Tung-Striebel step: the smoothed state before a step of length `d`, from the filtered one there and the
/// smoothed one behind it.
pub(super) fn smoothed(filtered: &Gaussian, later: &Gaussian, d: f64, density: f64) -> (Gaussian, JerkPower) {
    let ahead = filtered.predicted(d, density);
    let Some(information) = inverse(&ahead.cov) else { return (*filtered, JerkPower::default()) };
    let (f, information) = (transition(d), full(&information));
    let transposed: Matrix = std::array::from_fn(|i| std::array::from_fn(|j| f[j][i]));
    let gain = product(&product(&full(&filtered.cov), &transposed), &information);
    let away: Vector = std::array::from_fn(|i| later.mean[i] - ahead.mean[i]);
    let dot = |a: &Vector, b: &Vector| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let mean = std::array::from_fn(|i| filtered.mean[i] + dot(&gain[i], &away));
    // (I − G F) P (I − G F)ᵀ + G (Q + P_later) Gᵀ: a sum of what is never negative, unlike P + G (P_later − P_ahead) Gᵀ.
    let through = product(&gain, &f);
    let rest: Matrix =
        std::array::from_fn(|i| std::array::from_fn(|j| f64::from(u8::from(i == j)) - through[i][j]));
    let unit = jerk_covariance(d);
    let behind = std::array::from_fn(|k| density * unit[k] + later.cov[k]);
    let cov = plus(&congruence(&rest, &filtered.cov), &congruence(&gain, &behind));

    // Score of the density (Fisher): the smoothed jerk is ρ Q₀ u, with u = P⁻¹ away, of expected square tr(Q₀ Λ).
    let u: Vector = std::array::from_fn(|i| dot(&information[i], &away));
    let unit_full = full(&unit);
    let seen = density * (0..3).map(|i| u[i] * dot(&unit_full[i], &u)).sum::<f64>();
    let kept = congruence(&information, &later.cov);
    let kept = full(&kept);
    let expected = density
        * (0..3)
            .flat_map(|i| (0..3).map(move |j| (i, j)))
            .map(|(i, j)| unit_full[i][j] * (information[i][j] - kept[i][j]))
            .sum::<f64>();
    (Gaussian { mean, cov }, JerkPower { seen, expected: expected.max(0.0) })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inverse_of_a_jerk_covariance_is_the_known_one() {
        let q = jerk_covariance(2.0);
        let unit = product(&full(&q), &full(&inverse(&q).unwrap()));
        for (i, row) in unit.iter().enumerate() {
            for (j, x) in row.iter().enumerate() {
                assert!((x - f64::from(u8::from(i == j))).abs() < 1e-9, "({i}, {j}): {x}");
            }
        }
        assert!(inverse(&[1.0, 1.0, 0.0, 1.0, 0.0, 1.0]).is_none());
    }

    #[test]
    fn smoothing_two_states_equals_conditioning_the_joint_gaussian() {
        let start = Gaussian { mean: [1.0, -0.5, 0.2], cov: [2.0, 0.3, 0.1, 1.5, 0.2, 0.7] };
        let (d, density) = (1.3, 0.4);
        let measured = Scalar { component: 0, value: 2.5, variance: 0.3 };
        let mut later = start.predicted(d, density);
        later.update(&measured);
        let (smoothed, _) = smoothed(&start, &later, d, density);
        // x(t+d) = row·state + w: one scalar measurement of the state before the step
        let row = transition(d)[0];
        let p = full(&start.cov);
        let column: Vector = std::array::from_fn(|i| (0..3).map(|j| p[i][j] * row[j]).sum());
        let expected: f64 = (0..3).map(|i| row[i] * start.mean[i]).sum();
        let variance = (0..3).map(|i| row[i] * column[i]).sum::<f64>()
            + density * jerk_covariance(d)[0]
            + measured.variance;
        for i in 0..3 {
            let mean = start.mean[i] + column[i] / variance * (measured.value - expected);
            assert!((smoothed.mean[i] - mean).abs() < 1e-12);
            for j in 0..3 {
                let cov = p[i][j] - column[i] * column[j] / variance;
                assert!((full(&smoothed.cov)[i][j] - cov).abs() < 1e-12);
            }
        }
    }
}
