//! The level of friction as an ellipse, in coordinates in which a disc is not singular.

use friction::planar::Grain;

/// Level of friction by direction: the ellipse of [`Grain`] as G = level² ((1 + c, s), (s, 1 − c)), F = G v / √(vᵀGv).
///
/// c and s are components of one number at an angle: (c, s) = e (cos 2α, sin 2α), α the direction in which friction is largest.
/// At e = 0 the level is a disc, whatever the angle, and the force is smooth there.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Ellipse {
    /// Root mean square of the levels along and across the grain, N.
    pub level: f64,
    /// Part of the anisotropy along the axes.
    pub c: f64,
    /// Part of the anisotropy along the diagonals.
    pub s: f64,
}

impl Ellipse {
    /// Force against a slip, and its derivatives by `level`, `c` and `s`. Zero at rest.
    ///
    /// ```
    /// use friction::planar::Vector;
    /// use identify::planar::Ellipse;
    /// let ellipse = Ellipse { level: 2.0, c: -0.3, s: 0.2 };
    /// let force = ellipse.force(0.1, 0.04)[0];
    /// let by_grain = ellipse.grain().sliding(Vector { x: 0.1, y: 0.04 }, ellipse.along());
    /// assert!((force[0] - by_grain.x).abs() < 1e-12 && (force[1] - by_grain.y).abs() < 1e-12);
    /// ```
    #[must_use]
    pub fn force(&self, vx: f64, vy: f64) -> [[f64; 2]; 4] {
        let speed = vx.hypot(vy);
        if !(speed > 0.0) {
            return [[0.0; 2]; 4];
        }
        let v = [vx / speed, vy / speed];
        let h = [(1.0 + self.c) * v[0] + self.s * v[1], self.s * v[0] + (1.0 - self.c) * v[1]];
        let root = (v[0] * h[0] + v[1] * h[1]).max(1e-12).sqrt();
        let unit = h.map(|h| h / root);
        let by = |e: [f64; 2]| {
            let power = v[0] * e[0] + v[1] * e[1];
            [0, 1].map(|i| self.level * (e[i] / root - 0.5 * h[i] * power / root.powi(3)))
        };
        [unit.map(|u| self.level * u), unit, by([v[0], -v[1]]), by([v[1], v[0]])]
    }

    fn eccentricity(&self) -> f64 {
        self.c.hypot(self.s).min(0.999)
    }

    /// Level along the grain, the smaller one, N.
    #[must_use]
    pub fn along(&self) -> f64 {
        self.level * (1.0 - self.eccentricity()).sqrt()
    }

    /// Level across the grain, N.
    #[must_use]
    pub fn across(&self) -> f64 {
        self.level * (1.0 + self.eccentricity()).sqrt()
    }

    /// Angle of the grain with the x axis, rad, above −π/2 and up to π/2.
    #[must_use]
    pub fn angle(&self) -> f64 {
        // friction is largest across the grain
        0.5 * (-self.s).atan2(-self.c)
    }

    /// The grain.
    #[must_use]
    pub fn grain(&self) -> Grain<f64> {
        Grain::at(self.angle(), self.across() / self.along().max(1e-300))
    }

    /// The ellipse with these levels and this angle.
    ///
    /// ```
    /// use identify::planar::Ellipse;
    /// let wood = Ellipse::of(1.0, 1.6, 0.4);
    /// assert!((wood.along() - 1.0).abs() < 1e-12 && (wood.across() - 1.6).abs() < 1e-12);
    /// assert!((wood.angle() - 0.4).abs() < 1e-12);
    /// ```
    #[must_use]
    pub fn of(along: f64, across: f64, angle: f64) -> Self {
        let level = ((along * along + across * across) / 2.0).sqrt();
        let e = (across * across - along * along) / (2.0 * level * level).max(1e-300);
        Self { level, c: -e * (2.0 * angle).cos(), s: -e * (2.0 * angle).sin() }
    }

    /// The same with (c, s) taken back inside of what is an ellipse.
    #[must_use]
    pub fn bounded(self) -> Self {
        const MOST: f64 = 0.98;
        let e = self.c.hypot(self.s);
        let by = if e > MOST { MOST / e } else { 1.0 };
        Self { c: by * self.c, s: by * self.s, ..self }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn derivatives_agree_with_differences() {
        let at = Ellipse { level: 1.3, c: 0.2, s: -0.4 };
        let step = 1e-6;
        let near = [
            Ellipse { level: at.level + step, ..at },
            Ellipse { c: at.c + step, ..at },
            Ellipse { s: at.s + step, ..at },
        ];
        for angle in 0..12 {
            let (vy, vx) = (0.5 * f64::from(angle)).sin_cos();
            let [force, derivatives @ ..] = at.force(0.2 * vx, 0.2 * vy);
            for (other, derivative) in near.iter().zip(derivatives) {
                let [moved, ..] = other.force(0.2 * vx, 0.2 * vy);
                for axis in 0..2 {
                    assert!(((moved[axis] - force[axis]) / step - derivative[axis]).abs() < 1e-5);
                }
            }
        }
    }
}
