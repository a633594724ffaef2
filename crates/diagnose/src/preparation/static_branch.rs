//! Where the baseline's static branch ends: Karnopp's law balances whatever load there is below a speed Δv, so samples
//! slower than that say nothing about sliding, and a step at Δv is no physics that was left out.
//!
//! It shows in one of two ways: the force there wanders with the load, or, where the branch brakes with all it has, it is the
//! static level, higher than that of sliding whether the body slows down or gathers speed.
//!
//! Friction that builds up over a distance after a reversal wanders at low speed as well, but with the distance: it is physics, and
//! no branch.
//!
//! A step, not a slope: smooth physics at low speed (a Stribeck curve, frictional lag) changes as much in the bins above
//! an edge as across it.

use crate::preparation::track::Track;
use friction::Motion;
use friction::effects::{EffectKind, MAX_MEMORY};
use nalgebra::{DMatrix, DVector};
use signals::{dot, quantile};

/// Bins of |v|, and the share of the top speed they span.
const BINS: usize = 40;
const SPAN: f64 = 0.4;
/// Bins averaged on either side of an edge.
const SIDE: usize = 2;
/// The step in standard errors; samples follow each other, so more than the textbook's.
const MIN_T_STATISTIC: f64 = 6.0;
/// Scatter below the edge over that above: what merely balances goes from one level of friction to the other, a law of
/// sliding at low speed has a value.
const WANDERS: f64 = 3.0;
/// Smallest number of samples in a bin on one side of the edge over that on the other, or further above. Between the few speeds
/// of a triangle there are only reversals, and a ripple that is crossed at one of these speeds wanders, too.
const ALIKE: f64 = 0.1;
/// What may change above the edge, as a share of the step.
const FLAT: f64 = 0.25;
/// Share of the squared excess force from which on it is friction that builds up over a distance after each reversal. A force that
/// balances turns round with the load, before the motion does.
const BUILDS_UP: f64 = 0.5;
/// Distances that are tried, from the noise of the position to a share of the stroke, and the shortest as a share of that.
const DISTANCES: usize = 16;
const LONGEST: f64 = 0.1;
const SHORTEST: f64 = 1e-4;

/// Δv and half a bin's width, m/s, where the recording shows the step.
pub fn delta_v(tracks: &[Track]) -> Option<(f64, f64)> {
    let used: Vec<(usize, &Track)> =
        tracks.iter().flat_map(|t| (0..t.len()).filter(|&i| t.mask[i] > 0.0).map(move |i| (i, t))).collect();
    let speeds: Vec<f64> = used.iter().map(|(i, t)| t.v[*i].abs()).collect();
    let top = quantile(&speeds, 0.95);
    if !(top > 0.0) {
        return None;
    }
    let excess = excess(&used, 0.5 * SPAN * top)?;
    let width = SPAN * top / BINS as f64;
    let bins = |wanted: &dyn Fn(usize, &Track) -> bool| {
        let mut bins = [Bin::default(); BINS];
        for ((e, v), _) in excess.iter().zip(&speeds).zip(&used).filter(|(_, (i, t))| wanted(*i, t)) {
            if let Some(bin) = bins.get_mut((v / width) as usize) {
                *bin = Bin { sum: bin.sum + e, squares: bin.squares + e * e, count: bin.count + 1.0 };
            }
        }
        bins
    };
    let all = bins(&|_, _| true);
    let slowing = bins(&|i, t| t.v[i] * t.a[i] < 0.0);
    let gathering = bins(&|i, t| t.v[i] * t.a[i] > 0.0);
    let wanders = |edge: &usize| {
        Step::at(&all, *edge).is_some_and(|s| s.is_one() && s.below.2 > WANDERS * WANDERS * s.above.2)
    };
    let static_level = |edge: &usize| {
        let of = |bins| Step::at(bins, *edge).filter(|s| s.rises());
        of(&slowing).zip(of(&gathering)).is_some_and(|(before, _)| before.is_one())
    };
    // the highest: rest itself is a step, too, at the bottom of the band
    let edge = (1..BINS).rfind(|edge| wanders(edge) || static_level(edge))?;
    let band = edge as f64 * width;
    (built_up(tracks, &used, &excess, band) < BUILDS_UP).then_some((band, 0.5 * width))
}

/// Share of the squared excess force of the samples slower than `band` that presliding explains, at the distance that explains most.
fn built_up(tracks: &[Track], used: &[(usize, &Track)], excess: &[f64], band: f64) -> f64 {
    let slow: Vec<bool> = used.iter().map(|(i, t)| t.v[*i].abs() < band).collect();
    let of_slow = |series: &[f64]| -> Vec<f64> {
        series.iter().zip(&slow).filter(|(_, slow)| **slow).map(|(x, _)| *x).collect()
    };
    let excess = of_slow(excess);
    let positions: Vec<f64> = used.iter().map(|(i, t)| t.x[*i]).collect();
    let most = LONGEST * (quantile(&positions, 1.0) - quantile(&positions, 0.0));
    let noise = tracks.iter().map(|t| t.noise.position).fold(0.0, f64::max);
    let least = noise.clamp(SHORTEST * most, most);
    let share = |k: usize| {
        let x_s = least * (most / least).powf(k as f64 / (DISTANCES - 1) as f64);
        let lack = of_slow(&tracks.iter().flat_map(|t| lack(t, x_s)).collect::<Vec<_>>());
        let along = dot(&lack, &excess).max(0.0);
        along * along / (dot(&lack, &lack) * dot(&excess, &excess)).max(1e-300)
    };
    (0..DISTANCES).map(share).fold(0.0, f64::max)
}

/// What friction that builds up over the distance `x_s`, m or rad, has less than its level, against the motion, at every sample used.
fn lack(track: &Track, x_s: f64) -> Vec<f64> {
    let mut memory = [0.0; MAX_MEMORY];
    let at = |i: usize| {
        let displacement = track.x[i] - track.x[i.saturating_sub(1)];
        let motion = Motion { displacement, velocity: track.sign[i], dt: track.raw.dt, ..Motion::default() };
        let [forward, backward, ..] = EffectKind::Presliding.unit(&[x_s, 0.0], &mut memory, &motion);
        track.sign[i] * (forward + backward)
    };
    let all: Vec<f64> = (0..track.len()).map(at).collect();
    all.into_iter().zip(&track.mask).filter(|(_, mask)| **mask > 0.0).map(|(lack, _)| lack).collect()
}

/// Excess force of the samples in a bin.
#[derive(Debug, Clone, Copy, Default)]
struct Bin {
    sum: f64,
    squares: f64,
    count: f64,
}

/// Mean, squared standard error and variance on either side of an edge between bins, and further above it.
struct Step {
    below: (f64, f64, f64),
    above: (f64, f64, f64),
    further: (f64, f64, f64),
}

impl Step {
    fn at(bins: &[Bin; BINS], edge: usize) -> Option<Self> {
        let over = |from: usize, to: usize| -> Option<(f64, (f64, f64, f64))> {
            let bins = bins.get(from..to)?;
            let total = |of: fn(&Bin) -> f64| bins.iter().map(of).sum::<f64>();
            let count = total(|b| b.count);
            let mean = total(|b| b.sum) / count;
            let variance = (total(|b| b.squares) / count - mean * mean).max(0.0);
            let in_a_bin = count / bins.len() as f64;
            (count >= 20.0).then_some((in_a_bin, (mean, variance / count, variance)))
        };
        let (some, below) = over(edge.checked_sub(SIDE)?, edge)?;
        let (others, above) = over(edge, edge + SIDE)?;
        let (more, further) = over(edge + SIDE, edge + 3 * SIDE)?;
        let alike = some.min(others).min(more) >= ALIKE * some.max(others).max(more);
        alike.then_some(Self { below, above, further })
    }

    fn jump(&self) -> f64 {
        self.below.0 - self.above.0
    }

    fn is_sure(&self) -> bool {
        self.jump().abs() > MIN_T_STATISTIC * (self.below.1 + self.above.1).sqrt()
    }

    /// Flat above the edge, and surely another force below it.
    fn is_one(&self) -> bool {
        (self.above.0 - self.further.0).abs() < FLAT * self.jump().abs() && self.is_sure()
    }

    fn rises(&self) -> bool {
        self.jump() > 0.0 && self.is_sure()
    }
}

/// A series without most of what its single samples have of noise: nothing is filtered here, and an acceleration has much.
fn quiet(series: &[f64], i: usize) -> f64 {
    let (before, after) = (i.saturating_sub(1), (i + 1).min(series.len() - 1));
    0.25 * (series[before] + 2.0 * series[i] + series[after])
}

/// Force beyond what sliding explains, against the motion, at every sample used. What sliding explains is fitted to the
/// samples faster than `slow`, generously: inertia, friction of either direction, drag, springs, friction along the
/// stroke.
fn excess(used: &[(usize, &Track)], slow: f64) -> Option<Vec<f64>> {
    let row = |i: usize, t: &Track| -> [f64; COLUMNS] {
        let (x, v, s) = (t.x[i], t.v[i], t.sign[i]);
        [quiet(&t.a, i), s, 1.0, v, s * v, v * v.abs(), v * v, x, x * x, x * x * x, s * x, s * x * x]
    };
    let mut scale = [1e-300_f64; COLUMNS];
    for (i, t) in used {
        for (m, x) in scale.iter_mut().zip(row(*i, t)) {
            *m = m.max(x.abs());
        }
    }
    let mut gram = DMatrix::<f64>::zeros(COLUMNS, COLUMNS);
    let mut moment = DVector::<f64>::zeros(COLUMNS);
    for (i, t) in used.iter().filter(|(i, t)| t.v[*i].abs() > slow) {
        let r = DVector::from_fn(COLUMNS, |c, _| row(*i, t)[c] / scale[c]);
        gram.ger(1.0, &r, &r, 1.0);
        moment.axpy(t.raw.force[*i], &r, 1.0);
    }
    // nearly dependent columns share what they explain
    let ridge = 1e-9 * gram.trace();
    for c in 0..COLUMNS {
        gram[(c, c)] += ridge;
    }
    let solution = gram.cholesky()?.solve(&moment);
    let explained = |i: usize, t: &Track| -> f64 {
        row(i, t).iter().zip(&scale).zip(solution.iter()).map(|((x, m), c)| c * x / m).sum()
    };
    let out: Vec<f64> = used.iter().map(|(i, t)| t.sign[*i] * (t.raw.force[*i] - explained(*i, t))).collect();
    out.iter().all(|e| e.is_finite()).then_some(out)
}

const COLUMNS: usize = 12;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::preparation::track::Reversals;
    use signals::Channels;

    /// A motion of several frequencies with Coulomb friction of 1 N, and what takes its place below 20 mm/s.
    fn track(slow: impl Fn(f64, &mut f64, f64) -> Option<f64>) -> Track {
        const DT: f64 = 1e-3;
        let place = |t: f64| 0.02 * (5.0 * t).sin() + 0.008 * (13.0 * t).cos() + 0.002 * (31.0 * t).sin();
        let noise = |i: usize| 0.02 * (1e4 * (i * i) as f64).sin();
        let n = 30_000;
        let mut memory = 0.0;
        let force = |i: usize| {
            let t = i as f64 * DT;
            let v = (place(t + 1e-5) - place(t - 1e-5)) / 2e-5;
            let friction = slow(t, &mut memory, v * DT).filter(|_| v.abs() < 0.02);
            friction.unwrap_or(v.signum()) + 2.0 * v + noise(i)
        };
        let force = (0..n).map(force).collect();
        let position = (0..n).map(|i| place(i as f64 * DT)).collect();
        let raw = Channels { dt: DT, position, force, ..Channels::default() };
        Track::new(raw, 60.0, Reversals::default())
    }

    #[test]
    fn friction_that_builds_up_was_a_static_branch() {
        let balances = track(|t, _, _| Some((37.0 * t).sin()));
        let band = delta_v(&[balances]);
        println!("balances: {band:?}");
        assert!(band.is_some_and(|(v, half)| (v - 0.02).abs() < 3.0 * half));
        let builds_up = track(|_, z, moved| {
            *z = moved.signum() + (*z - moved.signum()) * (-moved.abs() / 4e-5).exp();
            Some(*z)
        });
        assert_eq!(delta_v(&[builds_up]), None);
    }

    #[test]
    fn a_ripple_crossed_at_one_speed_of_a_triangle_was_a_static_branch() {
        let bin = |count: f64, mean: f64, deviation: f64| Bin {
            sum: count * mean,
            squares: count * (mean * mean + deviation * deviation),
            count,
        };
        let band = |others: f64| {
            let mut bins = [bin(others, 0.0, 0.01); BINS];
            bins[16..18].fill(bin(1000.0, -0.1, 0.2));
            bins[18..20].fill(bin(1000.0, 0.0, 0.01));
            bins
        };
        // every speed is passed, and below an edge the force wanders
        assert!(Step::at(&band(800.0), 18).is_some_and(|s| s.is_one()));
        // nearly all samples are at one speed, on both sides of the edge
        assert!(Step::at(&band(30.0), 18).is_none());
    }
}
