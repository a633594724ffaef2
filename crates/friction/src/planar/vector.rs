//! Two components.

use crate::{Scalar, limits};
use core::ops::{Add, Mul, Neg, Sub};
use serde::{Deserialize, Serialize};

/// A vector in the plane.
///
/// ```
/// use friction::planar::Vector;
/// let v = Vector { x: 3.0, y: 4.0 };
/// assert_eq!((v.norm(), v.dot(v)), (5.0, 25.0));
/// assert_eq!(v * 2.0 - v, v);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Vector<S> {
    /// First component.
    pub x: S,
    /// Second component.
    pub y: S,
}

impl<S: Scalar> Default for Vector<S> {
    fn default() -> Self {
        Self { x: S::zero(), y: S::zero() }
    }
}

impl<S: Scalar> Vector<S> {
    /// Inner product.
    ///
    /// ```
    /// use friction::planar::Vector;
    /// assert_eq!(Vector { x: 1.0, y: 2.0 }.dot(Vector { x: 3.0, y: -1.0 }), 1.0);
    /// ```
    pub fn dot(self, other: Self) -> S {
        self.x * other.x + self.y * other.y
    }

    /// Length. Exact on an axis; does not overflow or underflow where the components do not.
    ///
    /// ```
    /// use friction::planar::Vector;
    /// assert_eq!(Vector { x: -1e-30_f32, y: 0.0 }.norm(), 1e-30);
    /// assert_eq!(Vector { x: 3e30_f32, y: 4e30 }.norm(), 5e30);
    /// ```
    pub fn norm(self) -> S {
        let (x, y) = (self.x.abs(), self.y.abs());
        let (long, short) = if x > y { (x, y) } else { (y, x) };
        if short > S::zero() {
            let slope = short / long;
            long * (S::one() + slope * slope).sqrt()
        } else {
            long
        }
    }

    /// Length and direction. The direction of zero is zero; that of a vector on an axis is exact.
    ///
    /// ```
    /// use friction::planar::Vector;
    /// let (length, direction) = Vector { x: 0.0, y: -0.7 }.polar();
    /// assert_eq!((length, direction), (0.7, Vector { x: 0.0, y: -1.0 }));
    /// ```
    pub fn polar(self) -> (S, Self) {
        let length = self.norm();
        if length > S::zero() {
            (length, Self { x: self.x / length, y: self.y / length })
        } else {
            (S::zero(), Self::default())
        }
    }

    /// The nearest vector of a disc about zero.
    ///
    /// ```
    /// use friction::planar::Vector;
    /// assert_eq!(Vector { x: 0.0, y: 3.0 }.within(2.0), Vector { x: 0.0, y: 2.0 });
    /// assert_eq!(Vector { x: 0.0, y: 1.0 }.within(2.0), Vector { x: 0.0, y: 1.0 });
    /// ```
    #[must_use]
    pub fn within(self, radius: S) -> Self {
        if self.norm() > radius { self.polar().1 * radius } else { self }
    }

    /// Both components limited to what a law returns.
    pub(super) fn bounded(self) -> Self {
        Self { x: limits::bounded(self.x), y: limits::bounded(self.y) }
    }

    /// Answer to a motion that is not finite.
    pub(super) fn nan() -> Self {
        Self { x: S::lit(f64::NAN), y: S::lit(f64::NAN) }
    }
}

impl<S: Scalar> Add for Vector<S> {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self { x: self.x + other.x, y: self.y + other.y }
    }
}

impl<S: Scalar> Sub for Vector<S> {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        Self { x: self.x - other.x, y: self.y - other.y }
    }
}

impl<S: Scalar> Neg for Vector<S> {
    type Output = Self;
    fn neg(self) -> Self {
        Self { x: -self.x, y: -self.y }
    }
}

impl<S: Scalar> Mul<S> for Vector<S> {
    type Output = Self;
    fn mul(self, factor: S) -> Self {
        Self { x: self.x * factor, y: self.y * factor }
    }
}
