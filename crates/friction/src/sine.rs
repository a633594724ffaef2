//! Sine and cosine in `f32`.
//!
//! `libm::sinf` reduces its argument and evaluates its polynomial in `f64`. A Cortex-M4F does that in software: thousands
//! of cycles in the control step, and 9 kB of flash.

/// π/2 in three parts. The first two have trailing zeros, so that their products with a quadrant number are exact.
const HALF_PI: [f32; 3] = [1.570_312_5, 4.837_513e-4, 7.549_79e-8];
/// Largest argument whose quadrant number has 13 bits, so that its products with the first two parts of π/2 are exact.
const EXACT: f32 = 8192.0;

/// Sine and cosine of `x` rad. |error| < 1.5·10⁻⁷ up to 8192 rad; beyond, the rounding of `x` itself. NaN for NaN and
/// infinities.
pub(crate) fn sin_cos(x: f32) -> (f32, f32) {
    if !x.is_finite() {
        return (f32::NAN, f32::NAN);
    }
    let x = if x.abs() < EXACT { x } else { fraction_of_turn(x) };
    let turns = x * core::f32::consts::FRAC_2_PI;
    let quadrant = (if turns < 0.0 { turns - 0.5 } else { turns + 0.5 }) as i32;
    let k = quadrant as f32;
    let r = ((x - k * HALF_PI[0]) - k * HALF_PI[1]) - k * HALF_PI[2];
    let (sin, cos) = octant(r);
    match quadrant & 3 {
        0 => (sin, cos),
        1 => (cos, -sin),
        2 => (-sin, -cos),
        _ => (-cos, sin),
    }
}

/// Sine for |x| ≤ π/2, within 1.5·10⁻⁷.
#[inline(always)] // a fifth of the whole sine
pub(crate) fn sin_of_quarter(x: f32) -> f32 {
    let a = x.abs();
    let sin = if a < core::f32::consts::FRAC_PI_4 {
        octant(a).0
    } else {
        octant(((HALF_PI[0] - a) + HALF_PI[1]) + HALF_PI[2]).1
    };
    if x < 0.0 { -sin } else { sin }
}

/// `x` without its whole turns, to the precision of a large number.
fn fraction_of_turn(x: f32) -> f32 {
    let turns = x * (0.5 * core::f32::consts::FRAC_1_PI);
    // beyond 2²³ turns no fraction is left
    let whole = if turns.abs() < 8_388_608.0 { (turns as i32) as f32 } else { turns };
    (turns - whole) * core::f32::consts::TAU
}

/// Sine and cosine for |r| ≤ π/4, with the polynomials of [cephes, sinf.c].
fn octant(r: f32) -> (f32, f32) {
    let z = r * r;
    let sin = ((-1.951_529_6e-4 * z + 8.332_161e-3) * z - 1.666_665_5e-1) * z * r + r;
    let cos = ((2.443_315_7e-5 * z - 1.388_731_6e-3) * z + 4.166_664_6e-2) * z * z - 0.5 * z + 1.0;
    (sin, cos)
}

#[cfg(test)]
mod tests {
    use super::{sin_cos, sin_of_quarter};
    use std::println;

    #[test]
    fn agrees_with_f64_up_to_its_bound() {
        let mut worst = 0.0_f64;
        let mut at = 0.0;
        for k in -400_000..=400_000_i32 {
            // dense near 0
            let u = k as f32 / 400_000.0;
            let x = u * u * u * 8191.0;
            let (sin, cos) = sin_cos(x);
            let (s, c) = f64::from(x).sin_cos();
            let error = (f64::from(sin) - s).abs().max((f64::from(cos) - c).abs());
            if error > worst {
                (worst, at) = (error, x);
            }
        }
        println!("largest error {worst:.2e}, at {at} rad");
        assert!(worst < 1.5e-7);
    }

    #[test]
    fn a_quarter_agrees_with_f64() {
        let most = core::f32::consts::FRAC_PI_2;
        let error = |k: i32| {
            let x = most * (k as f32 / 100_000.0);
            (f64::from(sin_of_quarter(x)) - f64::from(x).sin()).abs()
        };
        let worst = (-100_000..=100_000).map(error).fold(0.0, f64::max);
        println!("largest error {worst:.2e}");
        assert!(worst < 1.5e-7);
    }

    #[test]
    fn the_largest_numbers_stay_on_the_circle() {
        for x in [9e3_f32, 1e5, -3.3e6, 5.2e7, 1e12, -6.3e15, f32::MAX] {
            let (sin, cos) = sin_cos(x);
            assert!((sin * sin + cos * cos - 1.0).abs() < 1e-6, "{x}: {sin} {cos}");
            let ulp = f64::from(f32::from_bits(x.to_bits() + 1)) - f64::from(x);
            if ulp.abs() < 0.5 {
                let (s, c) = f64::from(x).sin_cos();
                let error = (f64::from(sin) - s).abs().max((f64::from(cos) - c).abs());
                println!("{x} rad: error {error:.2e}, distance to the next number {:.2e}", ulp.abs());
                assert!(error < 2.0 * ulp.abs());
            }
        }
        assert!(sin_cos(f32::NAN).0.is_nan() && sin_cos(f32::INFINITY).1.is_nan());
        assert_eq!(sin_cos(0.0), (0.0, 1.0));
    }
}
