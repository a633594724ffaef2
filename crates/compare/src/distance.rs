//! From two friction curves to a distance in just noticeable differences.

use crate::fit::{Bins, Levels, Measured};
use crate::interval::{Interval, Squared, T95};
use crate::texture_distance::{TextureComparison, compare_textures};
use crate::verdict::{Verdict, all_of};
use crate::{Error, Jnd};
use identify::Identification;
use nalgebra::{DMatrix, DVector};
use serde::Serialize;

/// Friction at one speed.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Point {
    /// m/s, negative in reverse.
    pub velocity: f64,
    /// N, magnitude.
    pub real: f64,
    /// N, magnitude, without the device's own where that was recorded.
    pub rendered: f64,
    /// Standard deviation of the difference, N.
    pub std: f64,
    /// What a hand notices there, N.
    pub jnd: f64,
    /// Of the time both spend.
    pub weight: f64,
}

/// Break-away in one direction.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Breakaway {
    /// `forward` or `reverse`.
    pub direction: &'static str,
    /// N.
    pub real: f64,
    /// N.
    pub rendered: f64,
    /// Standard deviation of the difference, N.
    pub std: f64,
    /// N.
    pub jnd: f64,
}

/// The comparison.
#[derive(Debug, Clone, Serialize)]
pub struct Comparison {
    /// Version of the layout.
    pub schema: &'static str,
    /// The real block's recording.
    pub real: String,
    /// The rendered block's.
    pub rendered: String,
    /// The device's alone.
    pub bare: Option<String>,
    /// JND.
    pub distance: Interval,
    /// Its part while sliding, JND².
    pub sliding_squared: f64,
    /// Its part at break-away, JND²; None where a recording does not tell it.
    pub breakaway_squared: Option<f64>,
    /// Rendered over real friction.
    pub ratio: Interval,
    /// Largest relative difference of friction that counts as the same.
    pub margin: f64,
    /// What the ratio says.
    pub verdict: Verdict,
    /// Force that repeats over position, if it shows in one of the recordings.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub texture: Option<TextureComparison>,
    /// Bin by bin.
    pub points: Vec<Point>,
    /// By direction.
    pub breakaway: Vec<Breakaway>,
    /// Masses of real and rendered block, kg, where identified. [thesis, ch. 5.4.2] has no JND for mass.
    pub mass: [Option<f64>; 2],
    /// What was found at fault, by recording.
    pub faults: Vec<(String, String)>,
    /// What a reader must know.
    pub notes: Vec<String>,
    /// What is drawn.
    #[serde(skip)]
    pub curves: Curves,
}

impl Comparison {
    /// What friction over speed and texture say together.
    #[must_use]
    pub fn overall(&self) -> Verdict {
        self.texture.as_ref().map_or(self.verdict, |texture| all_of(&[self.verdict, texture.verdict]))
    }
}

/// What is drawn.
#[derive(Debug, Clone)]
pub struct Curves {
    /// Of speed.
    pub bins: Bins,
    /// Of the real block.
    pub real: Levels,
    /// Of the rendered one.
    pub rendered: Levels,
    /// Of the device alone.
    pub bare: Option<Levels>,
}

/// Compares; `bare` is the device alone, moved as in `rendered`, whose resistance is taken off.
///
/// # Errors
/// The recordings have no speed in common, or one does not tell inertia and friction apart.
pub fn compare(
    real: &Measured,
    rendered: &Measured,
    bare: Option<&Measured>,
    margin: f64,
) -> Result<Comparison, Error> {
    let all: Vec<&Measured> = [Some(real), Some(rendered), bare].into_iter().flatten().collect();
    let bins = Bins::common(&all)?;
    let of_real = Levels::fit(real, &bins)?;
    let of_rendered = Levels::fit(rendered, &bins)?;
    let of_bare = bare.map(|bare| Levels::fit(bare, &bins)).transpose()?;
    let n = of_real.level.len();
    let own = of_bare.as_ref().map_or_else(|| DVector::zeros(n), |b| b.level.clone());
    let own_covariance = of_bare.as_ref().map_or_else(|| DMatrix::zeros(n, n), |b| b.covariance.clone());
    let felt = &of_rendered.level - own;
    let felt_covariance = &of_rendered.covariance + own_covariance;
    // time both spend
    let both: Vec<f64> = of_real.share.iter().zip(&of_rendered.share).map(|(a, b)| a.min(*b)).collect();
    let sum: f64 = both.iter().sum();
    let speeds = bins.speeds();
    let ways: Vec<f64> = speeds.iter().map(|v| v.signum()).collect();
    let covariance = &of_real.covariance + &felt_covariance;
    let points: Vec<Point> = (0..n)
        .map(|k| {
            let (level, other) = (ways[k] * of_real.level[k], ways[k] * felt[k]);
            Point {
                velocity: speeds[k],
                real: level,
                rendered: other,
                std: covariance[(k, k)].max(0.0).sqrt(),
                jnd: Jnd::sliding(level, other - level),
                weight: both[k] / sum,
            }
        })
        .collect();
    let sliding = {
        let off = DVector::from_iterator(n, points.iter().map(|p| (p.rendered - p.real) / p.jnd));
        // in JND, and signed as the magnitudes are
        let unit = |k: usize| ways[k] / points[k].jnd;
        let noise = DMatrix::from_fn(n, n, |i, j| covariance[(i, j)] * unit(i) * unit(j));
        Squared::of(&off, &DVector::from_iterator(n, points.iter().map(|p| p.weight)), &noise)
    };
    let breakaway = breakaways(&real.identified, &rendered.identified);
    let static_part =
        (!breakaway.is_empty()).then(|| {
            let n = breakaway.len();
            let off = DVector::from_iterator(n, breakaway.iter().map(|b| (b.rendered - b.real) / b.jnd));
            let noise = DMatrix::from_fn(n, n, |i, j| {
                if i == j { (breakaway[i].std / breakaway[i].jnd).powi(2) } else { 0.0 }
            });
            Squared::of(&off, &DVector::from_element(n, 1.0 / n as f64), &noise)
        });
    let total = Squared {
        value: sliding.value + static_part.map_or(0.0, |s| s.value),
        variance: sliding.variance + static_part.map_or(0.0, |s| s.variance),
    };
    let ratio = ratio(&points, &ways, &of_real.covariance, &felt_covariance);
    let [low, high] = ratio.ci95;
    let verdict = if low >= 1.0 - margin && high <= 1.0 + margin {
        Verdict::Same
    } else if low > 1.0 + margin || high < 1.0 - margin {
        Verdict::Different
    } else {
        Verdict::Undecided
    };
    let mut notes = notes(&all, bare.is_some());
    let texture = match compare_textures(real, rendered, margin) {
        Some(Ok(texture)) => Some(texture),
        Some(Err(why)) => {
            notes.push(why);
            None
        }
        None => None,
    };
    if let Some(texture) = bare.and_then(|bare| bare.texture.as_ref()) {
        let period = 1e3 * texture.whole.period;
        notes.push(format!("the device alone has a texture of {period:.3} mm, which is not taken off"));
    }
    Ok(Comparison {
        schema: "tribos.comparison/1",
        real: real.name.clone(),
        rendered: rendered.name.clone(),
        bare: bare.map(|bare| bare.name.clone()),
        distance: total.root(),
        sliding_squared: sliding.value,
        breakaway_squared: static_part.map(|s| s.value),
        ratio,
        margin,
        verdict,
        texture,
        points,
        breakaway,
        mass: {
            let of = |measured: &Measured| measured.identified.value("mass");
            let own = bare.map_or(Some(0.0), of);
            [of(real), of(rendered).zip(own).map(|(all, own)| all - own)]
        },
        faults: all
            .iter()
            .flat_map(|m| m.faults.iter().map(|fault| (m.name.clone(), fault.why.clone())))
            .collect(),
        notes,
        curves: Curves { bins, real: of_real, rendered: of_rendered, bare: of_bare },
    })
}

fn ratio(points: &[Point], ways: &[f64], of_real: &DMatrix<f64>, of_felt: &DMatrix<f64>) -> Interval {
    let n = points.len();
    let scale: f64 = points.iter().map(|p| p.weight * p.real * p.real).sum();
    let gain = DVector::from_iterator(
        n,
        points.iter().zip(ways).map(|(p, way)| way * p.weight * p.real / scale.max(f64::MIN_POSITIVE)),
    );
    let value: f64 = points.iter().map(|p| p.weight * p.real * p.rendered).sum::<f64>() / scale;
    let variance = (gain.transpose() * (of_felt + of_real * (value * value)) * &gain)[0];
    let half = T95 * variance.max(0.0).sqrt();
    Interval { value, ci95: [value - half, value + half] }
}

fn breakaways(real: &Identification, rendered: &Identification) -> Vec<Breakaway> {
    let of = |direction: &'static str, name: &str| {
        // a static level below the sliding one is a step that the filter blurred away
        let told = |found: &'_ Identification| {
            let level = found.parameters.get(name)?.clone();
            let sliding = found.value(&name.replace("static", "coulomb"))?;
            (level.value >= sliding).then_some(level)
        };
        let (a, b) = (told(real)?, told(rendered)?);
        Some(Breakaway {
            direction,
            real: a.value,
            rendered: b.value,
            std: a.std.hypot(b.std),
            jnd: Jnd::breakaway(a.value),
        })
    };
    [of("forward", "static_p"), of("reverse", "static_n")].into_iter().flatten().collect()
}

fn notes(all: &[&Measured], bare: bool) -> Vec<String> {
    let mut notes = Vec::new();
    for m in all.iter().filter(|m| m.turned) {
        notes.push(format!(
            "{}: the load cell sees the hand from the other side; its sign was turned",
            m.name
        ));
    }
    if !bare && all.iter().any(|m| m.turned) {
        notes.push("what the device itself resists is in the rendered recording; --bare takes it off".into());
    }
    notes
}
