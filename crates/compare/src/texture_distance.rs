//! From two textures to a distance in just noticeable differences.
//!
//! The zero of position need not be the same in both recordings, and what is between block and encoder bends by another
//! length in each direction. A shift of each direction is therefore no difference. With the harmonics c(d,h) = A + iB of
//! [`crate::texture`], their amplitude A_d and their shape u(d,h) = c(d,h)/A_d,
//!
//! > D² = mean_d ((A'_d − A_d)/JND_d)² + (ln(λ'/λ)/0.05)² + mean_d (A_d·A'_d·E_d/JND_d²)
//!
//! > E_d = min over φ of Σ_h |u'(d,h)·e^(−ihφ) − u(d,h)|² = 2·(1 − overlap)
//!
//! The JND of an amplitude is that of the largest force, level plus amplitude: a tenth of it, and of half a newton at least.
//! [`Jnd::force`] and [`Jnd::PERIOD`] name the sources. Squares are without what noise adds, as in
//! [`crate::distance`]. Period and shape are in D² only if both recordings show a texture.
//!
//! *The same*: in both directions the interval of A'/A lies within the margin, that of λ'/λ too, and the overlap is within
//! the margin of 1. *Different*: one of them lies wholly beyond it, or one texture is a force of position (it pulls the body
//! into its valleys) and the other a friction (it resists in both directions). Which it is follows from the strongest harmonic:
//! cos ψ = Re(c₊·c₋*)/|c₊·c₋| is 1 for a force, −1 for a friction. An elastic connection turns ψ by its own lag, so the kind
//! is known only where ψ is clear of a quarter turn by the phase of half a millimetre: not below periods of 2 mm. No JND is known for that, so it is not in D².
//! The intervals hold for all of these figures at once.

use crate::Jnd;
use crate::fit::Measured;
use crate::interval::{BLOCKS, Interval, Squared, jackknife};
use crate::texture::{HARMONICS, Lines, Texture};
use crate::verdict::{Verdict, all_of};
use nalgebra::{Complex, DMatrix, DVector};
use serde::Serialize;
use std::f64::consts::TAU;

/// Student's t for nine degrees of freedom and 5 % over five figures, on both sides: two ratios, two overlaps, the period.
const T_ALL: f64 = 3.250;
const _: () = assert!(BLOCKS == 10);
/// Distance by which an elastic connection, such as the coupling of a rendered block, may move the texture of one direction
/// against that of the other, m: 2 N in both directions on 8000 N/m.
const LAG: f64 = 0.5e-3;
/// Shifts that are tried, of one period.
const SHIFTS: usize = 180;

/// What a texture does to the body.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Kind {
    /// A force of position, the same in both directions: detents.
    Force,
    /// A friction, against the motion in both directions: grain.
    Friction,
}

/// Texture in one direction.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct TextureDirection {
    /// `forward` or `reverse`.
    pub direction: &'static str,
    /// Amplitude of the real texture, N: of the sine with the same power.
    pub real: f64,
    /// Of the rendered one, N.
    pub rendered: f64,
    /// Standard deviation of the difference, N.
    pub std: f64,
    /// What a hand notices of it, N.
    pub jnd: f64,
    /// Rendered over real amplitude; None if the real one shows none.
    pub ratio: Option<Interval>,
    /// 1 for the same shape; None unless both show one.
    pub overlap: Option<Interval>,
}

/// Comparison of two textures.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TextureComparison {
    /// Periods of the real and the rendered texture, m; None where none shows.
    pub period: [Option<f64>; 2],
    /// Rendered over real period; None unless both show one.
    pub period_ratio: Option<Interval>,
    /// Kinds of the real and the rendered texture; None where it is not known.
    pub kind: [Option<Kind>; 2],
    /// By direction.
    pub directions: Vec<TextureDirection>,
    /// JND.
    pub distance: Interval,
    /// Its part by amplitude, JND².
    pub amplitude_squared: f64,
    /// Its part by the period, JND².
    pub period_squared: Option<f64>,
    /// Its part by the shape, JND².
    pub shape_squared: Option<f64>,
    /// What amplitudes, periods and shapes say.
    pub verdict: Verdict,
}

/// What is compared, in the order of [`figures`].
const AMPLITUDE: usize = 0;
const RATIO: usize = 2;
const BEYOND: usize = 4;
const PERIOD: usize = 8;
const KIND: usize = 9;
const SHAPE: usize = 11;
const PER_SHAPE: usize = 2 * HARMONICS;
const FIGURES: usize = SHAPE + 2 * PER_SHAPE;

/// None if neither shows a texture; the reason if one shows and the other recording does not tell its period.
pub(crate) fn compare_textures(
    real: &Measured,
    rendered: &Measured,
    margin: f64,
) -> Option<Result<TextureComparison, String>> {
    let shown = [real.texture.as_ref(), rendered.texture.as_ref()];
    let at = |measured: &Measured, other: Option<&Texture>| -> Result<Texture, String> {
        let period = other.map_or(0.0, |t| t.whole.period);
        let found = measured.rows_of_texture.as_ref().and_then(|rows| rows.texture_beside(period));
        found.ok_or_else(|| {
            format!(
                "{}: does not tell force over position with a period of {:.3} mm; textures are not compared",
                measured.name,
                1e3 * period
            )
        })
    };
    let pair = match shown {
        [None, None] => return None,
        [Some(a), Some(b)] => Ok([a.clone(), b.clone()]),
        [Some(a), None] => at(rendered, Some(a)).map(|b| [a.clone(), b]),
        [None, Some(b)] => at(real, Some(b)).map(|a| [a, b.clone()]),
    };
    Some(pair.map(|pair| distance(&pair, shown.map(|t| t.is_some()), margin)))
}

fn distance(pair: &[Texture; 2], shows: [bool; 2], margin: f64) -> TextureComparison {
    let [a, b] = pair;
    let noise = [a.noise, b.noise];
    let of = |x: &Lines, y: &Lines| figures([x, y], noise, margin);
    let whole = of(&a.whole, &b.whole);
    let without_a: Vec<_> = a.left_out.iter().map(|x| of(x, &b.whole)).collect();
    let without_b: Vec<_> = b.left_out.iter().map(|y| of(&a.whole, y)).collect();
    let covariance = jackknife(&without_a) + jackknife(&without_b);
    let std = |k: usize| covariance[(k, k)].max(0.0).sqrt();
    let interval = |k: usize| {
        let half = T_ALL * std(k);
        Interval { value: whole[k], ci95: [whole[k] - half, whole[k] + half] }
    };
    let both = shows[0] && shows[1];
    let jnd = [0, 1].map(|d| Jnd::force(a.level[d] + a.amplitude[d]));
    // of the numbers from `from` on, each times its factor
    let square = |from: usize, factors: &[f64], weight: f64| {
        let n = factors.len();
        let off = DVector::from_fn(n, |i, _| factors[i] * whole[from + i]);
        let noise = DMatrix::from_fn(n, n, |i, j| factors[i] * factors[j] * covariance[(from + i, from + j)]);
        Squared::of(&off, &DVector::from_element(n, weight), &noise)
    };
    let amplitude = square(AMPLITUDE, &jnd.map(f64::recip), 0.5);
    let period = both.then(|| square(PERIOD, &[1.0 / Jnd::PERIOD], 1.0));
    let shape = both.then(|| {
        let in_jnd = |d: usize| (a.amplitude[d] * b.amplitude[d]).sqrt() / jnd[d];
        let factors: Vec<f64> = (0..2 * PER_SHAPE).map(|i| in_jnd(i / PER_SHAPE)).collect();
        square(SHAPE, &factors, 0.5)
    });
    let parts = [Some(amplitude), period, shape].into_iter().flatten();
    let total = parts.fold(Squared { value: 0.0, variance: 0.0 }, |sum, part| Squared {
        value: sum.value + part.value,
        variance: sum.variance + part.variance,
    });
    let overlap = |d: usize| {
        let off = square(SHAPE + d * PER_SHAPE, &[1.0; PER_SHAPE], 0.5);
        let half = T_ALL * off.variance.max(0.0).sqrt();
        let of = |gap: f64| (1.0 - gap).clamp(0.0, 1.0);
        Interval { value: of(off.value), ci95: [of(off.value + half), of(off.value - half)] }
    };
    let directions: Vec<TextureDirection> = ["forward", "reverse"]
        .into_iter()
        .enumerate()
        .map(|(d, direction)| TextureDirection {
            direction,
            real: a.amplitude[d],
            rendered: b.amplitude[d],
            std: std(AMPLITUDE + d),
            jnd: jnd[d],
            ratio: (shows[0] && a.amplitude[d] > 0.0).then(|| interval(RATIO + d)),
            // a direction without amplitude has no shape
            overlap: (both && a.amplitude[d] > 0.0 && b.amplitude[d] > 0.0).then(|| overlap(d)),
        })
        .collect();
    let kind = |k: usize| {
        let cosine = interval(KIND + k);
        // cosine of a quarter of a turn less the phase of the lag
        let least = (TAU * LAG / pair[k].whole.period).min(0.25 * TAU).sin();
        match cosine.ci95 {
            [low, _] if shows[k] && low > least => Some(Kind::Force),
            [_, high] if shows[k] && high < -least => Some(Kind::Friction),
            _ => None,
        }
    };
    let kinds = [kind(0), kind(1)];
    let period_ratio = both.then(|| {
        let log = interval(PERIOD);
        Interval { value: log.value.exp(), ci95: log.ci95.map(f64::exp) }
    });
    let mut verdicts: Vec<Verdict> = (0..2)
        .map(|d| {
            // A' against (1 + margin) A and (1 − margin) A: no division by a texture that is not there
            let (above, below) = (interval(BEYOND + d).ci95, interval(BEYOND + 2 + d).ci95);
            if above[1] <= 0.0 && below[0] >= 0.0 {
                Verdict::Same
            } else if above[0] > 0.0 || below[1] < 0.0 {
                Verdict::Different
            } else {
                Verdict::Undecided
            }
        })
        .collect();
    verdicts.extend(period_ratio.map(|r| within(r.ci95, [1.0 - margin, 1.0 + margin])));
    verdicts.extend(
        directions.iter().filter_map(|d| d.overlap).map(|o| within(o.ci95, [1.0 - margin, f64::INFINITY])),
    );
    if let [Some(one), Some(other)] = kinds {
        verdicts.push(if one == other { Verdict::Same } else { Verdict::Different });
    }
    TextureComparison {
        period: [0, 1].map(|k| shows[k].then_some(pair[k].whole.period)),
        period_ratio,
        kind: kinds,
        directions,
        distance: total.root(),
        amplitude_squared: amplitude.value,
        period_squared: period.map(|s| s.value),
        shape_squared: shape.map(|s| s.value),
        verdict: all_of(&verdicts),
    }
}

fn within([low, high]: [f64; 2], [least, most]: [f64; 2]) -> Verdict {
    if low >= least && high <= most {
        Verdict::Same
    } else if low > most || high < least {
        Verdict::Different
    } else {
        Verdict::Undecided
    }
}

/// Differences of amplitudes, ratios, amplitudes beyond the margin above and below, logarithm of the period's ratio, kinds,
/// and differences of shapes.
fn figures(lines: [&Lines; 2], noise: [[f64; 2]; 2], margin: f64) -> DVector<f64> {
    let amplitude = |k: usize, d: usize| (lines[k].power(d) - noise[k][d]).max(0.0).sqrt();
    let mut out = DVector::zeros(FIGURES);
    for d in 0..2 {
        let (one, other) = (amplitude(0, d), amplitude(1, d));
        out[AMPLITUDE + d] = other - one;
        out[RATIO + d] = if one > 0.0 { other / one } else { 0.0 };
        out[BEYOND + d] = other - (1.0 + margin) * one;
        out[BEYOND + 2 + d] = other - (1.0 - margin) * one;
        let [one, other] = [0, 1].map(|k| shape(&lines[k].lines[d]));
        let shift = shift(&one, &other);
        for h in 0..HARMONICS {
            let off = turned(&other, shift, h) - one[h];
            out[SHAPE + d * PER_SHAPE + 2 * h] = off.re;
            out[SHAPE + d * PER_SHAPE + 2 * h + 1] = off.im;
        }
    }
    let ratio = lines[1].period / lines[0].period;
    out[PERIOD] = if ratio > 0.0 { ratio.ln() } else { 0.0 };
    for (k, lines) in lines.into_iter().enumerate() {
        let h = lines.strongest();
        let product = lines.lines[0][h] * lines.lines[1][h].conj();
        out[KIND + k] = if product.norm() > 0.0 { product.re / product.norm() } else { 0.0 };
    }
    out
}

/// Harmonics with an amplitude of one.
fn shape(lines: &[Complex<f64>; HARMONICS]) -> [Complex<f64>; HARMONICS] {
    let size = lines.iter().map(Complex::norm_sqr).sum::<f64>().sqrt();
    if size > 0.0 { lines.map(|c| c / size) } else { *lines }
}

fn turned(shape: &[Complex<f64>; HARMONICS], shift: f64, h: usize) -> Complex<f64> {
    shape[h] * Complex::from_polar(1.0, -((h + 1) as f64) * shift)
}

/// Phase of the fundamental by which `other` is moved on against `one`.
fn shift(one: &[Complex<f64>; HARMONICS], other: &[Complex<f64>; HARMONICS]) -> f64 {
    let overlap =
        |phase: f64| (0..HARMONICS).map(|h| (turned(other, phase, h) * one[h].conj()).re).sum::<f64>();
    let step = TAU / SHIFTS as f64;
    let best = (0..SHIFTS)
        .map(|k| k as f64 * step)
        .max_by(|a, b| overlap(*a).total_cmp(&overlap(*b)))
        .unwrap_or(0.0);
    // thirds of an interval about the best
    let (mut low, mut high) = (best - step, best + step);
    for _ in 0..60 {
        let third = (high - low) / 3.0;
        if overlap(low + third) < overlap(high - third) { low += third } else { high -= third }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(of: impl Fn(usize, usize) -> Complex<f64>, period: f64) -> Lines {
        let mut lines = [[Complex::new(0.0, 0.0); HARMONICS]; 2];
        for (d, direction) in lines.iter_mut().enumerate() {
            for (h, line) in direction.iter_mut().enumerate() {
                *line = of(d, h);
            }
        }
        Lines { lines, period }
    }

    /// Known without noise.
    fn exact(lines: Lines) -> Texture {
        let amplitude = [0, 1].map(|d| lines.power(d).sqrt());
        Texture { left_out: vec![lines; BLOCKS], whole: lines, amplitude, noise: [0.0; 2], level: [1.0; 2] }
    }

    #[test]
    fn a_shift_is_no_difference() {
        let of = |shift: f64| {
            let sizes = [1.2, 0.6, 0.1];
            exact(lines(|_, h| Complex::from_polar(sizes[h], (h + 1) as f64 * shift + h as f64), 0.004))
        };
        for shift in [0.3, 2.0, 4.5, 6.0] {
            let c = distance(&[of(0.0), of(shift)], [true; 2], 0.05);
            assert!(c.distance.value < 1e-6 && c.verdict == Verdict::Same, "{shift}: {c:?}");
        }
    }

    #[test]
    fn each_part_has_its_closed_form() {
        let sine = |size: f64, period: f64| {
            exact(lines(|_, h| Complex::new(if h == 0 { size } else { 0.0 }, 0.0), period))
        };
        // level and amplitude are 1 N each: a JND is 0.2 N
        let c = distance(&[sine(1.0, 0.002), sine(1.1, 0.002)], [true; 2], 0.05);
        assert!((c.distance.value - 0.5).abs() < 1e-9 && c.verdict == Verdict::Different, "{c:?}");
        let c = distance(&[sine(1.0, 0.002), sine(1.0, 0.002 * 0.1_f64.exp())], [true; 2], 0.05);
        assert!((c.distance.value - 2.0).abs() < 1e-9 && c.verdict == Verdict::Different, "{c:?}");
        // an overtone with an angle of 60° to the fundamental's share: overlap cos 60°
        let mixed = exact(lines(|_, h| Complex::new([0.5, 0.75_f64.sqrt(), 0.0][h], 0.0), 0.002));
        let c = distance(&[sine(1.0, 0.002), mixed], [true; 2], 0.05);
        let overlap = c.directions[0].overlap.expect("an overlap").value;
        assert!((overlap - 0.5).abs() < 1e-9 && c.verdict == Verdict::Different, "{c:?}");
        // E = 1, and a JND of 0.2 N
        assert!((c.distance.value - 5.0).abs() < 1e-6, "{c:?}");
    }

    #[test]
    fn a_force_is_no_friction() {
        let of = |way: f64| {
            exact(lines(
                |d, h| {
                    Complex::new(
                        if h > 0 {
                            0.0
                        } else if d == 0 {
                            1.0
                        } else {
                            way
                        },
                        0.0,
                    )
                },
                0.006,
            ))
        };
        let c = distance(&[of(1.0), of(-1.0)], [true; 2], 0.05);
        assert_eq!(c.kind, [Some(Kind::Force), Some(Kind::Friction)]);
        assert!(c.distance.value < 1e-6 && c.verdict == Verdict::Different, "{c:?}");
    }

    #[test]
    fn a_texture_against_none_has_numbers_only() {
        let zero = exact(lines(|_, _| Complex::new(0.0, 0.0), 0.002));
        let one = exact(lines(|_, h| Complex::new(if h == 0 { 1.0 } else { 0.0 }, 0.0), 0.002));
        for (pair, shows, jnd) in
            [([zero.clone(), one.clone()], [false, true], 0.1), ([one, zero], [true, false], 0.2)]
        {
            let c = distance(&pair, shows, 0.05);
            assert_eq!(c.verdict, Verdict::Different);
            assert!((c.distance.value - 1.0 / jnd).abs() < 1e-9, "{c:?}");
            assert!(!serde_free_of_nan(&c), "{c:?}");
        }
    }

    fn serde_free_of_nan(c: &TextureComparison) -> bool {
        format!("{c:?}").contains("NaN") || format!("{c:?}").contains("inf")
    }
}
