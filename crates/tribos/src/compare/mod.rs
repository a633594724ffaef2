//! Does a rendered block feel like the real one? Two recordings, one number in just noticeable differences.
//!
//! **Curves, not samples.** The motions need not be the same. From each recording the friction force is fitted as a
//! function of speed, in bins k of forward and reverse sliding,
//!
//! > F = m·a + L(k) + b·(v − v(k))
//!
//! with one mass, one slope b a direction and a level L(k) a bin: friction at the speed v(k), inertia taken off. Samples
//! that do not slide steadily (slower than the band about rest, or soon after a reversal) are set aside.
//!
//! **The unit.** The thesis found, at a reference level of 2 N, just noticeable differences of 0.78 N for friction that
//! is higher, 0.36 N for friction that is lower, and, by extrapolation, 3.14 N for a higher static level alone
//! (ch. 5.4.2). By Weber's law (ch. 5.3.2.2) they grow with the level: [`Jnd`].
//!
//! **The distance.** Over the bins both recordings have, weighted by the time w(k) both spend there,
//!
//! > D² = Σ w(k)·(ΔL(k)/JND(k))² + mean over directions of (ΔD/JND)²
//!
//! where ΔD is the difference in break-away force, if both recordings tell it. Two cues of one difference add as
//! squares, as independent cues do in detection theory. What noise alone adds to a square is taken off, and the
//! interval follows from leaving out one tenth of each recording at a time.
//!
//! **The ratio.** g = Σ w·L·L' / Σ w·L², how many times the friction of the real block is rendered. *Different* means:
//! its 95 % interval lies wholly beyond the margin (5 %) on one side of 1; *the same*: wholly within; else undecided.
//! A hand may feel no difference where this does: a tenth of the friction is a quarter to a half of a JND.

mod demo;
mod distance;
mod fit;
mod overlay;

pub(crate) use demo::demo;
pub(crate) use distance::{Comparison, Verdict, compare};
pub(crate) use fit::Measured;
pub(crate) use overlay::overlay;

/// Share by which friction may differ and count as the same.
pub(crate) const MARGIN: f64 = 0.05;

/// Just noticeable differences of chapter 5, as shares of the level they were found at.
pub(crate) struct Jnd;

impl Jnd {
    /// Level of the reference, N (table 5-3).
    const REFERENCE: f64 = 2.0;
    /// Both levels raised, N (batch 1).
    const HIGHER: f64 = 0.78;
    /// Both levels lowered, N (batch 3).
    const LOWER: f64 = 0.36;
    /// The static level raised alone, N: extrapolated by the thesis, its levels did not reach it (batch 2).
    // not π
    #[allow(clippy::approx_constant)]
    const STATIC: f64 = 3.14;
    /// Below this level, N, the JND stays what it is there: a twentieth of the reference, far from where anything was
    /// measured.
    const SMALLEST: f64 = 0.1;

    fn at(level: f64, at_reference: f64) -> f64 {
        at_reference / Self::REFERENCE * level.abs().max(Self::SMALLEST)
    }

    /// Of friction at `level` N against one that is `difference` N higher or lower.
    pub(crate) fn sliding(level: f64, difference: f64) -> f64 {
        Self::at(level, if difference < 0.0 { Self::LOWER } else { Self::HIGHER })
    }

    /// Of a break-away force of `level` N.
    pub(crate) fn breakaway(level: f64) -> f64 {
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
