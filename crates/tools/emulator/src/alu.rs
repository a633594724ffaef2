//! Arithmetic of the quick core: shifts, sums with carry, and floats on the host.

use rsemu::cpu::arm::v7m::fp::fpscr;
use rsemu::cpu::arm::v7m::fpisa::DataOp;
use rsemu::cpu::arm::v7m::isa::{DpOp, Shift, ShiftType};

const NEGATIVE: u32 = 1 << 31;

/// The result of the host's arithmetic, where it is the target's bit for bit and raises nothing but `inexact`, which is set
/// already: operands normal or zero, result normal and not the smallest [armv7-m, ch. A2.5].
pub(crate) fn on_host(status: u32, op: DataOp, a: u32, b: u32, c: u32) -> Option<u32> {
    let plain = fpscr::RMODE | fpscr::IXC;
    if status & plain != fpscr::IXC || !is_normal_or_zero(b) || !is_normal_or_zero(c) {
        return None;
    }
    if let DataOp::Mla | DataOp::Mls | DataOp::Nmla | DataOp::Nmls = op {
        let product = on_host(status, DataOp::Mul, a, b, c)?;
        let (a_sign, product_sign) = product_signs(op);
        return on_host(status, DataOp::Add, a, a ^ a_sign, product ^ product_sign);
    }
    let [x, y, z] = [a, b, c].map(f32::from_bits);
    let result = match op {
        DataOp::Add => y + z,
        DataOp::Sub => y - z,
        DataOp::Mul => y * z,
        DataOp::Nmul => -(y * z),
        DataOp::Div => y / z,
        _ if !is_normal_or_zero(a) => return None,
        DataOp::Fma => y.mul_add(z, x),
        DataOp::Fms => (-y).mul_add(z, x),
        DataOp::Fnma => (-y).mul_add(z, -x),
        DataOp::Fnms => y.mul_add(z, -x),
        _ => return None,
    }
    .to_bits();
    // a sum that is zero is exact, and a product of zero
    let exact_zero = result << 1 == 0
        && match op {
            DataOp::Add | DataOp::Sub => true,
            DataOp::Mul | DataOp::Nmul => b << 1 == 0 || c << 1 == 0,
            _ => false,
        };
    ((2..255).contains(&(result >> 23 & 0xff)) || exact_zero).then_some(result)
}

/// Sign bits that a sum with a product, rounded twice, flips: of the addend, and of the product.
pub(crate) fn product_signs(op: DataOp) -> (u32, u32) {
    match op {
        DataOp::Mls => (0, NEGATIVE),
        DataOp::Nmla => (NEGATIVE, NEGATIVE),
        DataOp::Nmls => (NEGATIVE, 0),
        _ => (0, 0),
    }
}

pub(crate) fn is_normal_or_zero(bits: u32) -> bool {
    bits << 1 == 0 || (1..255).contains(&(bits >> 23 & 0xff))
}

#[inline(always)]
pub(crate) fn shift_imm(shift: Shift, value: u32, carry: bool) -> (u32, bool) {
    match shift.ty {
        ShiftType::Rrx => (u32::from(carry) << 31 | value >> 1, value & 1 != 0),
        ty => shift_reg(ty, value, u32::from(shift.amount), carry),
    }
}

/// Result and carry of a shift [armv7-m, ch. A2.2.1].
pub(crate) fn shift_reg(ty: ShiftType, value: u32, amount: u32, carry: bool) -> (u32, bool) {
    let bit = |k: u32| value >> k & 1 != 0;
    match (ty, amount) {
        (_, 0) => (value, carry),
        (ShiftType::Lsl, 1..32) => (value << amount, bit(32 - amount)),
        (ShiftType::Lsl, 32) => (0, bit(0)),
        (ShiftType::Lsr, 1..32) => (value >> amount, bit(amount - 1)),
        (ShiftType::Lsr, 32) => (0, bit(31)),
        (ShiftType::Lsl | ShiftType::Lsr, _) => (0, false),
        (ShiftType::Asr, 1..32) => (((value as i32) >> amount) as u32, bit(amount - 1)),
        (ShiftType::Asr, _) => (((value as i32) >> 31) as u32, bit(31)),
        (ShiftType::Ror, _) => {
            let result = value.rotate_right(amount & 31);
            (result, result >> 31 != 0)
        }
        (ShiftType::Rrx, _) => (u32::from(carry) << 31 | value >> 1, bit(0)),
    }
}

/// Result, carry and overflow.
#[inline(always)]
pub(crate) fn alu(op: DpOp, a: u32, b: u32, carry: bool, shifted_out: bool, v: bool) -> (u32, bool, bool) {
    let add = |a: u32, b: u32, carry: bool| {
        let wide = u64::from(a) + u64::from(b) + u64::from(carry);
        let result = wide as u32;
        (result, wide >> 32 != 0, (a ^ result) & (b ^ result) & NEGATIVE != 0)
    };
    match op {
        DpOp::And | DpOp::Tst => (a & b, shifted_out, v),
        DpOp::Bic => (a & !b, shifted_out, v),
        DpOp::Orr => (a | b, shifted_out, v),
        DpOp::Orn => (a | !b, shifted_out, v),
        DpOp::Eor | DpOp::Teq => (a ^ b, shifted_out, v),
        DpOp::Add | DpOp::Cmn => add(a, b, false),
        DpOp::Adc => add(a, b, carry),
        DpOp::Sbc => add(a, !b, carry),
        DpOp::Sub | DpOp::Cmp => add(a, !b, true),
        DpOp::Rsb => add(!a, b, true),
        DpOp::Mov => (b, shifted_out, v),
        DpOp::Mvn => (!b, shifted_out, v),
    }
}
