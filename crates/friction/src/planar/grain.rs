//! The level of friction as a set of forces: a disc, or an ellipse along a grain.

use super::Vector;
use crate::{Invalid, Scalar, in_range};
use serde::{Deserialize, Serialize};

/// Most steps of a projection. Four reach the last bit of `f32` with ratios up to 3, fourteen at every ratio that is accepted.
const STEPS: usize = 16;

/// Direction of a grain, and how much more friction there is across it than along it.
///
/// The forces that a contact holds are the ellipse |M⁻¹F| ≤ level, M = diag(1, `across`) in the frame of the grain. The
/// slip is *associated*: of all forces on the ellipse, friction is the one that takes most power from the motion,
/// F = level·M²v/|Mv|. Across the grain bristles are stiffer, and viscous friction is larger, by the square of `across`.
/// In the coordinates w = Mv and f = M⁻¹F the ellipse is a disc, friction opposes the motion, and
/// f·w is the power F·v. Every law here is written in these coordinates: a law that is passive on a disc is passive
/// on every ellipse.
///
/// ```
/// use friction::planar::{Grain, Vector};
/// let wood = Grain::at(0.0, 2.0); // grain along x, twice the friction across it
/// let force = wood.sliding(Vector { x: 0.1, y: 0.1 }, 1.0);
/// assert!((force.y / force.x - 4.0_f64).abs() < 1e-12); // pulled along the diagonal, the body veers along the grain
/// assert!((wood.sliding(Vector { x: 0.0, y: 0.1 }, 1.0).y - 2.0).abs() < 1e-12);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Grain<S> {
    /// Unit vector along the grain.
    pub along: Vector<S>,
    /// Friction across the grain over friction along it, 0.01 to 100. 1 is a disc: no grain.
    pub across: S,
}

impl<S: Scalar> Default for Grain<S> {
    fn default() -> Self {
        Self { along: Vector { x: S::one(), y: S::zero() }, across: S::one() }
    }
}

impl<S: Scalar> Grain<S> {
    /// A grain that makes `angle` with the x axis, rad.
    ///
    /// ```
    /// let grain = friction::planar::Grain::at(core::f64::consts::FRAC_PI_2, 2.0);
    /// assert!(grain.along.x.abs() < 1e-15 && grain.along.y == 1.0);
    /// ```
    pub fn at(angle: S, across: S) -> Self {
        Self { along: Vector { x: angle.cos(), y: angle.sin() }, across }
    }

    /// Components along and across the grain.
    fn turned(&self, v: Vector<S>) -> Vector<S> {
        let a = self.along;
        Vector { x: a.x * v.x + a.y * v.y, y: a.x * v.y - a.y * v.x }
    }

    /// w = Mv, in the frame of the grain: motion in the coordinates in which the level is a disc.
    ///
    /// ```
    /// use friction::planar::{Grain, Vector};
    /// assert_eq!(Grain::at(0.0, 2.0).slip(Vector { x: 1.0, y: 1.0 }), Vector { x: 1.0, y: 2.0 });
    /// ```
    pub fn slip(&self, v: Vector<S>) -> Vector<S> {
        let turned = self.turned(v);
        Vector { x: turned.x, y: self.across * turned.y }.bounded()
    }

    /// F = Mf back in the plane, the transpose of [`Grain::slip`]: F·v = f·w.
    ///
    /// ```
    /// use friction::planar::{Grain, Vector};
    /// let (grain, v, f) = (Grain::at(0.3_f64, 2.0), Vector { x: 1.0, y: 0.2 }, Vector { x: -0.4, y: 3.0 });
    /// assert!((grain.force(f).dot(v) - f.dot(grain.slip(v))).abs() < 1e-14);
    /// ```
    pub fn force(&self, f: Vector<S>) -> Vector<S> {
        let (a, f) = (self.along, f.bounded());
        let across = self.across * f.y;
        Vector { x: a.x * f.x - a.y * across, y: a.y * f.x + a.x * across }.bounded()
    }

    /// How far a force is towards the edge of the ellipse, |M⁻¹F|, N: the level that just holds it.
    ///
    /// ```
    /// use friction::planar::{Grain, Vector};
    /// assert_eq!(Grain::at(0.0, 2.0).level_of(Vector { x: 0.0, y: 3.0 }), 1.5);
    /// ```
    pub fn level_of(&self, force: Vector<S>) -> S {
        let turned = self.turned(force);
        Vector { x: turned.x, y: turned.y / self.across }.bounded().norm()
    }

    /// Friction of this level against a slip v, N; zero at rest.
    ///
    /// ```
    /// use friction::planar::{Grain, Vector};
    /// let force = Grain::default().sliding(Vector { x: 0.0, y: -0.1 }, 3.0);
    /// assert_eq!(force, Vector { x: 0.0, y: -3.0 });
    /// ```
    pub fn sliding(&self, v: Vector<S>, level: S) -> Vector<S> {
        self.force(self.slip(v).polar().1 * level)
    }

    /// The force on the edge of the ellipse nearest to `force`, which lies outside of it, N.
    ///
    /// "Nearest" is measured by the inertia, which is the same in every direction. Then the difference of the two forces, and
    /// with it the velocity at the end of the step, is normal to the ellipse: the implicit Euler solution of the associated
    /// law, as [kikuuwe-2006] has it for a disc. In the metric of the ellipse itself the projection would be a mere
    /// scaling of `force`, but associated only for a body as anisotropic as its friction; for any other, friction would
    /// point against the motion, where Dahl's law and the bristles on the same ellipse do not.
    ///
    /// For a disc the two metrics are one, and the projection is closed. For an ellipse the multiplier κ is the root of a
    /// quartic, whose formula cancels in `f32`. Its secular equation 1/|p(κ)| = 1 is concave and nearly straight, as for a
    /// trust region: every tangent, that at infinity among them, meets 1 before the root. Newton's method approaches the root
    /// from there, in steps that are shortened a little to need no square root: √S ≤ (S + 1)/2.
    ///
    /// ```
    /// use friction::planar::{Grain, Vector};
    /// assert_eq!(Grain::default().nearest(Vector { x: 0.0, y: 5.0 }, 3.0), Vector { x: 0.0, y: 3.0 });
    /// let (grain, pushed) = (Grain::at(0.0, 2.0), Vector { x: 4.0, y: 4.0 });
    /// let force: Vector<f64> = grain.nearest(pushed, 1.0);
    /// assert!((grain.level_of(force) - 1.0).abs() < 1e-12);
    /// // the difference is normal to the ellipse
    /// let left = pushed - force;
    /// assert!((left.y / left.x - force.y / 4.0 / force.x).abs() < 1e-12);
    /// ```
    pub fn nearest(&self, force: Vector<S>, level: S) -> Vector<S> {
        let (one, zero) = (S::one(), S::zero());
        let s = self.turned(force).bounded();
        if self.across == one && !self.across.has_derivative() {
            return self.force(s.polar().1 * level);
        }
        if !(level > zero) {
            return Vector::default();
        }
        let scaled = Vector { x: s.x, y: self.across * s.y };
        // in units of the larger component: no square overflows
        let inverse = one / scaled.x.abs().max(scaled.y.abs());
        let t = scaled * inverse;
        let unit = level * inverse;
        let e = Vector { x: unit, y: self.across * self.across * unit };
        let (x2, y2) = (t.x * t.x, t.y * t.y);
        // one division serves both axes
        let shrunk = |kappa: S| {
            let (x, y) = (e.x + kappa, e.y + kappa);
            let inverse = one / (x * y);
            Vector { x: y * inverse, y: x * inverse }
        };
        // the tangent at infinity, |t| from below by its chord; before zero the force would lie inside
        let length = one + S::lit(core::f64::consts::SQRT_2 - 1.0) * x2.min(y2);
        let mut kappa = (length - (x2 * e.x + y2 * e.y) / (x2 + y2)).max(zero);
        for _ in 0..STEPS {
            let by = shrunk(kappa);
            let (x2, y2) = (x2 * by.x * by.x, y2 * by.y * by.y);
            let squared = x2 + y2;
            let over = squared - one;
            let slope = (squared + S::lit(3.0)) * (x2 * by.x + y2 * by.y);
            kappa += S::lit(2.0) * over * squared / slope;
            // Newton's method squares an error: what is left is below the last bit
            if !(one + over * over > one) {
                break;
            }
        }
        let by = shrunk(kappa);
        let p = Vector { x: t.x * by.x, y: t.y * by.y };
        // of length 1 but for rounding
        self.force(p * (level * S::lit(0.5) * (S::lit(3.0) - p.dot(p))))
    }

    /// Checks direction and ratio.
    ///
    /// # Errors
    /// What is out of range, with what would be accepted.
    ///
    /// ```
    /// let error = friction::planar::Grain::at(0.0, 0.0).validate().unwrap_err();
    /// assert_eq!(error.to_string(), "across = 0: accepted from 0.01 to 100");
    /// ```
    pub fn validate(&self) -> Result<(), Invalid> {
        in_range("along", self.along.norm(), 0.999, 1.001)?;
        in_range("across", self.across, 0.01, 100.0)
    }
}
