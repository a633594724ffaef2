//! Dual numbers as scalars: running a law gives its derivative.
//!
//! Real parts use `libm` as elsewhere, so a force has the same value with and without its derivative. An infinite
//! derivative (√x, or x^p with p < 1, at x = 0) is replaced by 0: infinity times zero would turn the other derivatives
//! into NaN.

use crate::Scalar;
use num_dual::{Derivative, Dual64, DualSVec64};

fn finite_or_zero(slope: f64) -> f64 {
    if slope.is_finite() { slope } else { 0.0 }
}

macro_rules! scalar_by_chain_rule {
    (impl [$($generics:tt)*] for $dual:ty, constant: $constant:expr, carries: $carries:expr) => {
        impl<$($generics)*> Scalar for $dual {
            fn lit(value: f64) -> Self {
                Self::new(value, $constant)
            }
            fn re(self) -> f64 {
                self.re
            }
            fn exp(self) -> Self {
                let value = libm::exp(self.re);
                Self::new(value, self.eps * finite_or_zero(value))
            }
            fn ln(self) -> Self {
                Self::new(libm::log(self.re), self.eps * finite_or_zero(1.0 / self.re))
            }
            fn sqrt(self) -> Self {
                let value = libm::sqrt(self.re);
                Self::new(value, self.eps * finite_or_zero(0.5 / value))
            }
            fn sin(self) -> Self {
                Self::new(libm::sin(self.re), self.eps * finite_or_zero(libm::cos(self.re)))
            }
            fn cos(self) -> Self {
                Self::new(libm::cos(self.re), self.eps * finite_or_zero(-libm::sin(self.re)))
            }
            fn powf(self, p: Self) -> Self {
                let value = libm::pow(self.re, p.re);
                let by_base = p.re * libm::pow(self.re, p.re - 1.0);
                let by_power = value * libm::log(self.re);
                Self::new(value, self.eps * finite_or_zero(by_base) + p.eps * finite_or_zero(by_power))
            }
            fn fraction(bits: u32) -> Self {
                Self::new(f64::fraction(bits), $constant)
            }
            fn has_derivative(self) -> bool {
                let carries: fn(&Self) -> bool = $carries;
                carries(&self)
            }
        }
    };
}

scalar_by_chain_rule!(impl [] for Dual64, constant: 0.0, carries: |x| x.eps != 0.0);
scalar_by_chain_rule!(
    impl [const N: usize] for DualSVec64<N>,
    constant: Derivative::none(),
    carries: |x| x.eps != Derivative::none()
);
