//! e^x in `f32` without a division, and with branches only at the ends of its range.
//!
//! `libm::expf` divides, and scales with a loop that covers every exponent: 160 cycles on a Cortex-M4F, twice in a control
//! step under LuGre.

/// log₂ e.
const LOG2_E: f32 = core::f32::consts::LOG2_E;
/// ln 2 in two parts. The first has nine bits, so that its product with an integer below 2¹⁵ is exact.
const LN_2: [f32; 2] = [0.693_359_4, -2.121_944_4e-4];
/// 1.5·2²³: adding it rounds a small number to an integer, which is then in the lowest bits.
const ROUND: f32 = 12_582_912.0;
/// Largest |x| for which 2^k and e^x are normal numbers.
const NORMAL: f32 = 87.0;

/// e^x within one unit in the last place for |x| ≤ 87. Beyond, 0 (instead of values below 1.7·10⁻³⁸) and infinity; NaN for
/// NaN.
#[inline(never)] // copies of it would not fit into the fast memory of a device
pub(crate) fn exp(x: f32) -> f32 {
    inlined(x)
}

/// The same without a call, which would make a law save its registers: half as much as this function costs.
#[inline(always)]
pub(crate) fn inlined(x: f32) -> f32 {
    if !(x.abs() <= NORMAL) {
        return if x < 0.0 { 0.0 } else { x * f32::MAX };
    }
    let rounded = x * LOG2_E + ROUND;
    let k = (rounded.to_bits().wrapping_sub(ROUND.to_bits())) as i32;
    let whole = rounded - ROUND;
    let r = (x - whole * LN_2[0]) - whole * LN_2[1];
    // (e^r − 1 − r)/r² for |r| ≤ ln(2)/2, minimax: e^r to 4e-09
    let p = (((0.0013863757 * r + 0.00836751) * r + 0.041667238) * r + 0.16666535) * r + 0.5;
    (p * (r * r) + r + 1.0) * f32::from_bits(((k + 127) as u32) << 23)
}

#[cfg(test)]
mod tests {
    use super::exp;
    use std::println;

    #[test]
    fn agrees_with_f64_within_a_unit_in_the_last_place() {
        let (mut worst, mut at) = (0.0_f64, 0.0);
        for n in 0..2_000_000_u32 {
            // evenly over what is normal, and densely about 0
            let u = f64::from(n) / 1e6 - 1.0;
            for x in [(87.0 * u) as f32, (u * u * u) as f32] {
                let exact = f64::from(x).exp();
                let ulp = f64::from(f32::from_bits((exact as f32).to_bits() + 1)) - f64::from(exact as f32);
                let off = (f64::from(exp(x)) - exact).abs() / ulp;
                if off > worst {
                    (worst, at) = (off, x);
                }
            }
        }
        println!("largest error {worst:.3} units in the last place, at {at}");
        assert!(worst < 1.0);
    }

    #[test]
    fn ends_of_the_range() {
        assert_eq!((exp(0.0), exp(-0.0), exp(f32::MIN_POSITIVE)), (1.0, 1.0, 1.0));
        assert!(exp(f32::NAN).is_nan());
        assert_eq!((exp(f32::INFINITY), exp(f32::NEG_INFINITY)), (f32::INFINITY, 0.0));
        assert_eq!(
            (exp(87.01), exp(1e30), exp(-87.01), exp(-1e30)),
            (f32::INFINITY, f32::INFINITY, 0.0, 0.0)
        );
        println!("e^87 = {:e}; e^-87 = {:e}", exp(87.0), exp(-87.0));
        assert!(exp(87.0) > 6e37 && exp(-87.0).is_normal());
    }
}
