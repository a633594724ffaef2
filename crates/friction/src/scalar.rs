//! The scalar a law is generic over: `f32` on the device, `f64` in the simulated rig, a dual number for exact
//! derivatives.

use crate::exponential;
use crate::sine::{sin_cos, sin_of_quarter};
use core::fmt::Debug;
use num_traits::{Num, NumAssignOps};

/// A real scalar.
///
/// Transcendental functions never call `std` or `num_traits::Float`: the host must compute bit for bit what the target
/// computes, and `num_traits` changes its backend when any crate of the build enables its `std` feature. They call `libm`,
/// or this crate's own `f32` functions where `libm` is slow or computes in `f64`.
///
/// ```
/// use friction::Scalar;
/// fn smooth_sign<S: Scalar>(v: S) -> S {
///     v / (v * v + S::lit(1e-6)).sqrt()
/// }
/// assert!((smooth_sign(1e-3_f64) - 0.5_f64.sqrt()).abs() < 1e-12);
/// assert!((smooth_sign(1e-3_f32) - 0.5_f32.sqrt()).abs() < 1e-6);
/// assert_eq!(Scalar::sgn(0.0_f64), 0.0); // `f64::signum` gives 1, which would make a resting block slide
/// ```
pub trait Scalar:
    Copy + Debug + PartialOrd + Num + NumAssignOps + core::ops::Neg<Output = Self> + 'static
{
    /// Nearest representable value of a constant.
    fn lit(value: f64) -> Self;
    /// Real part, for decisions and messages.
    fn re(self) -> f64;
    /// e^x.
    fn exp(self) -> Self;
    /// e^x without a call, for a law of which single cycles are counted.
    #[inline(always)]
    fn exp_inlined(self) -> Self {
        self.exp()
    }
    /// Natural logarithm.
    fn ln(self) -> Self;
    /// Square root.
    fn sqrt(self) -> Self;
    /// Sine, x in rad.
    fn sin(self) -> Self;
    /// Cosine, x in rad.
    fn cos(self) -> Self;
    /// Sine for |x| ≤ π/2.
    fn sin_of_quarter(self) -> Self {
        self.sin()
    }
    /// x^p for x ≥ 0.
    fn powf(self, p: Self) -> Self;

    /// The upper 24 bits of `bits` as a number in [0, 1), exactly.
    fn fraction(bits: u32) -> Self;

    /// |x|.
    fn abs(self) -> Self {
        if self < Self::zero() { -self } else { self }
    }
    /// −1, 0 or +1; 0 at ±0, where `f32::signum` gives ±1.
    fn sgn(self) -> Self {
        if self > Self::zero() {
            Self::one()
        } else if self < Self::zero() {
            -Self::one()
        } else {
            Self::zero()
        }
    }
    /// Larger of two values; `self` when `other` is NaN.
    fn max(self, other: Self) -> Self {
        if other > self { other } else { self }
    }
    /// Smaller of two values; `self` when `other` is NaN.
    fn min(self, other: Self) -> Self {
        if other < self { other } else { self }
    }
    /// `self` limited to `[low, high]`.
    fn clamp(self, low: Self, high: Self) -> Self {
        self.max(low).min(high)
    }
    /// Whether the value is neither NaN nor infinite.
    fn is_finite(self) -> bool {
        self.re().is_finite()
    }
    /// Whether all numbers of a motion are finite.
    fn are_finite(numbers: [Self; 7]) -> bool {
        numbers.into_iter().all(Self::is_finite)
    }
    /// Whether the number carries a derivative, which a shortcut for a special value would lose.
    fn has_derivative(self) -> bool {
        false
    }
}

macro_rules! scalar_by_libm {
    ($float:ty, $exp:expr, $exp_inlined:expr, $ln:ident, $sqrt:ident, $sin:expr, $quarter:expr, $cos:expr, $pow:ident) => {
        impl Scalar for $float {
            fn lit(value: f64) -> Self {
                value as $float
            }
            fn re(self) -> f64 {
                self as f64
            }
            #[inline(always)]
            fn exp(self) -> Self {
                $exp(self)
            }
            #[inline(always)]
            fn exp_inlined(self) -> Self {
                $exp_inlined(self)
            }
            fn ln(self) -> Self {
                libm::$ln(self)
            }
            fn sqrt(self) -> Self {
                libm::$sqrt(self)
            }
            fn sin(self) -> Self {
                $sin(self)
            }
            #[inline(always)]
            fn sin_of_quarter(self) -> Self {
                $quarter(self)
            }
            fn cos(self) -> Self {
                $cos(self)
            }
            fn powf(self, p: Self) -> Self {
                libm::$pow(self, p)
            }
            fn fraction(bits: u32) -> Self {
                (bits >> 8) as $float * (1.0 / 16_777_216.0)
            }
            // not through f64, which is software on the target
            fn is_finite(self) -> bool {
                <$float>::is_finite(self)
            }
            // a non-finite number times 0 is NaN: one comparison instead of seven in every control step
            #[inline(always)]
            fn are_finite([a, b, c, d, e, f, g]: [Self; 7]) -> bool {
                a * 0.0 + b * 0.0 + c * 0.0 + d * 0.0 + e * 0.0 + f * 0.0 + g * 0.0 == 0.0
            }
        }
    };
}

scalar_by_libm!(
    f32,
    exponential::exp,
    exponential::inlined,
    logf,
    sqrtf,
    |x| sin_cos(x).0,
    sin_of_quarter,
    |x| sin_cos(x).1,
    powf
);
scalar_by_libm!(f64, libm::exp, libm::exp, log, sqrt, libm::sin, libm::sin, libm::cos, pow);
