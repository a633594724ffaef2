//! A compensated sum.

/// Neumaier's sum: the error of n additions stays that of one.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Sum {
    total: f32,
    lost: f32,
}

impl Sum {
    pub(crate) fn add(&mut self, x: f32) {
        let total = self.total + x;
        self.lost +=
            if self.total.abs() >= x.abs() { (self.total - total) + x } else { (x - total) + self.total };
        self.total = total;
    }

    pub(crate) fn value(&self) -> f64 {
        f64::from(self.total) + f64::from(self.lost)
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
