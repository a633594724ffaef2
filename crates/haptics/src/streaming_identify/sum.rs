//! A compensated sum.

/// Kahan's sum: the error of n additions stays that of two, in four operations and no branch.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Sum {
    total: f32,
    /// What the total has too much.
    excess: f32,
}

impl Sum {
    pub(crate) fn add(&mut self, x: f32) {
        let x = x - self.excess;
        let total = self.total + x;
        self.excess = (total - self.total) - x;
        self.total = total;
    }

    pub(crate) fn value(&self) -> f64 {
        f64::from(self.total) - f64::from(self.excess)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::println;

    #[test]
    fn keeps_what_a_plain_sum_loses() {
        let (mut sum, mut plain, mut exact) = (Sum::default(), 0.0_f32, 0.0_f64);
        for k in 0..1_000_000_u32 {
            let x = 0.1 + (k % 7) as f32 * 1e-5;
            sum.add(x);
            plain += x;
            exact += f64::from(x);
        }
        let (error, plain_error) = ((sum.value() - exact).abs(), (f64::from(plain) - exact).abs());
        println!("10⁶ terms: compensated error {error:.1e}, plain {plain_error:.1e}");
        assert!(error < 1e-6 * exact && plain_error > 1e-4 * exact);
    }
}
