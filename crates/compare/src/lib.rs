//! Does a rendered block feel like the real one? Two recordings, one number in just noticeable differences.
//!
//! **Curves, not samples.** The motions need not be the same. From each recording the friction force is fitted as a
//! function of speed, in bins k of forward and reverse sliding,
//!
//! > F − m·a = L(k) + b·(v − v(k))
//!
//! with one mass and, for each direction, one slope b and one level L(k) per bin: friction without inertia at the speed v(k).
//! Samples without steady sliding (slower than the band about rest, or soon after a reversal) are excluded.
//!
//! **The unit.** At a reference level of 2 N the just noticeable differences are 0.78 N for higher friction, 0.36 N for lower
//! friction and, by extrapolation, 3.14 N for a higher static level alone [thesis, ch. 5.4.2]. By Weber's law
//! [thesis, ch. 5.3.2.2] they grow with the level: [`Jnd`].
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
//!
//! **Over position** (detents, a ratchet, bumps, grain) force repeats with a period. Where that shows beyond noise in a recording,
//! amplitude by direction, period and shape are compared, each in its own JND, with a distance and a verdict beside
//! those of friction (texture.rs, texture_distance.rs).
//!
//! **In the plane** ([`compare_planar`]) friction has a size and a direction at each direction of motion. Sizes differ in the JND
//! above, directions in that of the direction of a force, 25.6° [barbagli-2006]:
//!
//! > D² = mean over directions of motion of (Δ|F|/JND)² + (Δangle/25.6°)²
//!
//! *Different* means that in some direction of motion |F'|/|F| lies wholly beyond the margin, *the same*: within it in all.

#![forbid(unsafe_code)]

mod asked;
mod distance;
mod error;
mod fit;
mod interval;
mod jnd;
mod plane;
mod texture;
mod texture_distance;
mod verdict;

pub use asked::asked;
pub use distance::{Breakaway, Comparison, Curves, Point, compare};
pub use error::Error;
pub use fit::{Bins, Levels, Measured, Row};
pub use interval::Interval;
pub use jnd::Jnd;
pub use plane::{PlanarComparison, PlanarMeasured, PlanarPoint, compare_planar};
pub use texture_distance::{Kind, TextureComparison, TextureDirection};
pub use verdict::Verdict;

/// Largest relative difference of friction that counts as the same.
pub const MARGIN: f64 = 0.05;
