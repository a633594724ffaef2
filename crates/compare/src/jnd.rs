//! Just noticeable differences of friction and of texture.

/// Just noticeable differences: of friction as in [thesis, ch. 5], shares of the level they were found at; of texture as
/// published elsewhere.
pub struct Jnd;

impl Jnd {
    /// Level of the reference, N [thesis, table 5-3].
    const REFERENCE: f64 = 2.0;
    /// Both levels raised, N (batch 1).
    const HIGHER: f64 = 0.78;
    /// Both levels lowered, N (batch 3).
    const LOWER: f64 = 0.36;
    /// The static level raised alone, N: extrapolated in [thesis, ch. 5.4.2], because the levels of batch 2 do not reach it.
    // not π
    #[allow(clippy::approx_constant)]
    const STATIC: f64 = 3.14;
    /// Below this level, N, the JND stays what it is there: a twentieth of the reference, far from where anything was
    /// measured.
    const SMALLEST: f64 = 0.1;

    /// Of the direction of a force felt by a hand alone, rad: 25.6° [barbagli-2006].
    pub const DIRECTION: f64 = 25.6 * std::f64::consts::PI / 180.0;

    /// Share of a force that is noticed: 7 % from 2.5 N to 10 N [pang-1991], 7 % to 10 % over muscles and methods
    /// [jones-2000].
    const FORCE: f64 = 0.1;
    /// Below this force, N, the share grows [jones-2000]; the JND stays what it is there.
    const SMALLEST_FORCE: f64 = 0.5;

    /// Of the spatial period of a grating, as a share: 5 % at periods of about 1 mm, felt in active touch [morley-1983].
    pub const PERIOD: f64 = 0.05;

    /// Of a force of `force` N that varies over position.
    #[must_use]
    pub fn force(force: f64) -> f64 {
        Self::FORCE * force.abs().max(Self::SMALLEST_FORCE)
    }

    fn at(level: f64, at_reference: f64) -> f64 {
        at_reference / Self::REFERENCE * level.abs().max(Self::SMALLEST)
    }

    /// Of friction at `level` N against one that is `difference` N higher or lower.
    #[must_use]
    pub fn sliding(level: f64, difference: f64) -> f64 {
        Self::at(level, if difference < 0.0 { Self::LOWER } else { Self::HIGHER })
    }

    /// Of a break-away force of `level` N.
    #[must_use]
    pub fn breakaway(level: f64) -> f64 {
        Self::at(level, Self::STATIC)
    }
}

#[cfg(test)]
mod tests {
    use super::Jnd;

    #[test]
    fn the_thesis_s_own_levels_are_one_jnd_apart() {
        assert!((Jnd::sliding(2.0, 0.78) - 0.78).abs() < 1e-12);
        assert!((Jnd::sliding(2.0, -0.36) - 0.36).abs() < 1e-12);
        assert!((Jnd::breakaway(2.0) - Jnd::STATIC).abs() < 1e-12);
        assert!((Jnd::sliding(4.0, 0.1) - 1.56).abs() < 1e-12, "Weber");
        assert!(Jnd::sliding(0.0, 0.1) > 0.0);
    }
}
