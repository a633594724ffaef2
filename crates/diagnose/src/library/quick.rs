//! The scalar in which columns are computed: `f64` with short transcendental functions.
//!
//! A search evaluates laws some hundred million times, and most of that time `libm` spends on the last bit of an exponential
//! or a sine. These functions are within [`ROUNDING`] of it, branch at the ends of their ranges only, and give the same bits on
//! every processor. Models that are written and simulated go by `libm`.

use friction::Scalar;
use num_traits::{Num, One, Zero};
use std::f64::consts::{FRAC_2_PI, LOG2_E, SQRT_2};
use std::ops::{Add, AddAssign, Div, DivAssign, Mul, MulAssign, Neg, Rem, RemAssign, Sub, SubAssign};

/// An `f64` whose laws are quick to compute.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd)]
pub struct Quick(pub f64);

/// Largest relative error of e^x and of ln x, largest error of a sine.
#[cfg(test)]
const ROUNDING: f64 = 1e-14;

/// ln 2 in two parts; products of the first with an integer below 2²⁰ are exact.
const LN_2: [f64; 2] = [6.931_471_803_691_238e-1, 1.908_214_929_270_587_7e-10];
/// π/2 in two parts, likewise.
const HALF_PI: [f64; 2] = [1.570_796_326_734_125_6, 6.077_100_506_506_192e-11];
/// 1.5·2⁵²: adding it rounds a small number to an integer, which is then in the lowest bits.
const ROUND: f64 = 6_755_399_441_055_744.0;
/// Largest |x| for which 2^k and e^x are normal numbers.
const NORMAL: f64 = 700.0;
/// Largest |x| whose quadrant number has 20 bits.
const TURNED: f64 = 1.6e6;

/// e^x; 0 and infinity beyond ±700.
#[inline(always)]
fn exp(x: f64) -> f64 {
    if !(x.abs() <= NORMAL) {
        return if x < 0.0 { 0.0 } else { x * f64::MAX };
    }
    let rounded = x * LOG2_E + ROUND;
    let k = rounded.to_bits().wrapping_sub(ROUND.to_bits()) as i64;
    let whole = rounded - ROUND;
    let r = (x - whole * LN_2[0]) - whole * LN_2[1];
    let (r2, half) = (r * r, 0.5);
    let (r4, sixth) = (r2 * r2, 1.0 / 6.0);
    // Taylor's series to the eleventh power, in pairs that do not wait for each other
    let low = (1.0 + r) + r2 * (half + sixth * r);
    let middle = (1.0 / 24.0 + r * (1.0 / 120.0)) + r2 * (1.0 / 720.0 + r * (1.0 / 5040.0));
    let high = (1.0 / 40_320.0 + r * (1.0 / 362_880.0)) + r2 * (1.0 / 3_628_800.0 + r * (1.0 / 39_916_800.0));
    (low + r4 * (middle + r4 * high)) * f64::from_bits(((k + 1023) as u64) << 52)
}

/// Natural logarithm.
#[inline(always)]
fn ln(x: f64) -> f64 {
    if !(f64::MIN_POSITIVE..=f64::MAX).contains(&x) {
        return x.ln();
    }
    let bits = x.to_bits();
    let mantissa = f64::from_bits(bits & 0x000f_ffff_ffff_ffff | 0x3ff0_0000_0000_0000);
    let above = mantissa > SQRT_2;
    let m = if above { 0.5 * mantissa } else { mantissa };
    let k = ((bits >> 52) as i64 - 1023 + i64::from(above)) as f64;
    let s = (m - 1.0) / (m + 1.0);
    let z = s * s;
    let z2 = z * z;
    // ln m = 2·artanh s, |s| < 0.172
    let low = (1.0 / 3.0 + z * (1.0 / 5.0)) + z2 * (1.0 / 7.0 + z * (1.0 / 9.0));
    let high = (1.0 / 11.0 + z * (1.0 / 13.0)) + z2 * (1.0 / 15.0 + z * (1.0 / 17.0));
    let series = 2.0 * s + 2.0 * s * z * (low + z2 * z2 * high);
    k * LN_2[0] + (series + k * LN_2[1])
}

/// Sine and cosine, with the polynomials of [fdlibm, k_sin.c, k_cos.c].
#[inline(always)]
fn sin_cos(x: f64) -> (f64, f64) {
    if !(x.abs() <= TURNED) {
        return x.sin_cos();
    }
    let rounded = x * FRAC_2_PI + ROUND;
    let quadrant = rounded.to_bits();
    let whole = rounded - ROUND;
    let r = (x - whole * HALF_PI[0]) - whole * HALF_PI[1];
    let z = r * r;
    let z2 = z * z;
    let sin = (-1.666_666_666_666_663_2e-1 + z * 8.333_333_333_322_49e-3)
        + z2 * ((-1.984_126_982_985_795e-4 + z * 2.755_731_370_707_006_8e-6)
            + z2 * (-2.505_076_025_340_686_3e-8 + z * 1.589_690_995_211_55e-10));
    let cos = (4.166_666_666_666_66e-2 + z * -1.388_888_888_887_411e-3)
        + z2 * ((2.480_158_728_947_673e-5 + z * -2.755_731_435_139_066_3e-7)
            + z2 * (2.087_572_321_298_175e-9 + z * -1.135_964_755_778_819_5e-11));
    let (sin, cos) = (r + r * z * sin, 1.0 - 0.5 * z + z2 * cos);
    let (sin, cos) = if quadrant & 1 == 0 { (sin, cos) } else { (cos, sin) };
    let turned = |value: f64, by: u64| f64::from_bits(value.to_bits() ^ ((by & 2) << 62));
    (turned(sin, quadrant), turned(cos, quadrant.wrapping_add(1)))
}

impl Scalar for Quick {
    #[inline(always)]
    fn lit(value: f64) -> Self {
        Self(value)
    }
    #[inline(always)]
    fn re(self) -> f64 {
        self.0
    }
    #[inline(always)]
    fn exp(self) -> Self {
        Self(exp(self.0))
    }
    #[inline(always)]
    fn ln(self) -> Self {
        Self(ln(self.0))
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(self.0.sqrt())
    }
    #[inline(always)]
    fn sin(self) -> Self {
        Self(sin_cos(self.0).0)
    }
    #[inline(always)]
    fn cos(self) -> Self {
        Self(sin_cos(self.0).1)
    }
    #[inline(always)]
    fn powf(self, p: Self) -> Self {
        if self.0 > 0.0 { Self(exp(p.0 * ln(self.0))) } else { Self(self.0.powf(p.0)) }
    }
    fn fraction(bits: u32) -> Self {
        Self(f64::fraction(bits))
    }
    #[inline(always)]
    fn are_finite(numbers: [Self; 7]) -> bool {
        f64::are_finite(numbers.map(Self::re))
    }
}

macro_rules! operators {
    ($($Operator:ident $operator:ident $Assign:ident $assign:ident,)*) => {$(
        impl $Operator for Quick {
            type Output = Self;
            #[inline(always)]
            fn $operator(self, other: Self) -> Self {
                Self(self.0.$operator(other.0))
            }
        }
        impl $Assign for Quick {
            #[inline(always)]
            fn $assign(&mut self, other: Self) {
                self.0.$assign(other.0);
            }
        }
    )*};
}

operators! {
    Add add AddAssign add_assign,
    Sub sub SubAssign sub_assign,
    Mul mul MulAssign mul_assign,
    Div div DivAssign div_assign,
    Rem rem RemAssign rem_assign,
}

impl Neg for Quick {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(-self.0)
    }
}

impl Zero for Quick {
    #[inline(always)]
    fn zero() -> Self {
        Self(0.0)
    }
    fn is_zero(&self) -> bool {
        self.0 == 0.0
    }
}

impl One for Quick {
    #[inline(always)]
    fn one() -> Self {
        Self(1.0)
    }
}

impl Num for Quick {
    type FromStrRadixErr = <f64 as Num>::FromStrRadixErr;
    fn from_str_radix(text: &str, radix: u32) -> Result<Self, Self::FromStrRadixErr> {
        f64::from_str_radix(text, radix).map(Self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn functions_agree_with_those_of_the_standard_library() {
        let mut worst = [0.0_f64; 4];
        for n in 0..400_000_u32 {
            let u = f64::from(n) / 2e5 - 1.0;
            let x = 690.0 * u * u * u;
            worst[0] = worst[0].max((exp(x) / x.exp() - 1.0).abs());
            let positive = x.exp();
            worst[1] = worst[1].max((ln(positive) - positive.ln()).abs() / positive.ln().abs().max(1e-3));
            let angle = 1e5 * u * u * u;
            let ((s, c), (sine, cosine)) = (sin_cos(angle), angle.sin_cos());
            worst[2] = worst[2].max((s - sine).abs()).max((c - cosine).abs());
            let base = (5.0 * u).exp();
            worst[3] = worst[3].max((Quick(base).powf(Quick(1.3)).0 / base.powf(1.3) - 1.0).abs());
        }
        println!("exp, ln, sine, power: {worst:.1?}");
        assert!(worst.iter().all(|w| *w < ROUNDING), "{worst:?}");
    }

    #[test]
    fn ends_of_the_ranges() {
        assert_eq!((exp(0.0), exp(-1e30), exp(f64::INFINITY)), (1.0, 0.0, f64::INFINITY));
        assert_eq!((exp(f64::NEG_INFINITY), ln(1.0), ln(0.0)), (0.0, 0.0, f64::NEG_INFINITY));
        assert!(exp(f64::NAN).is_nan() && ln(-1.0).is_nan() && sin_cos(f64::INFINITY).0.is_nan());
        assert!((ln(5e-320) - 5e-320_f64.ln()).abs() < 1e-9 && ln(f64::INFINITY) == f64::INFINITY);
        let power = |x: f64, p: f64| Quick(x).powf(Quick(p)).0;
        assert_eq!((power(0.0, 0.5), power(0.0, 0.0), power(2.0, 0.0)), (0.0, 1.0, 1.0));
    }
}
