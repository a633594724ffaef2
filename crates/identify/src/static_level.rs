//! Static friction D and the speed Δv below which it holds, from how a body leaves rest.
//!
//! By [thesis, eq. 3.1] friction is D inside the band and C + b·v outside. When a body leaves rest, friction is D until the speed
//! passes Δv, then steps down. The speed of that step has a likelihood: friction scatters about both levels, and all
//! velocities of one event share an error. With a flat prior, Δv is the mean of the posterior over all events and its standard
//! error is the posterior's spread, which includes the gap between two samples. D is the mean friction below the step, averaged
//! over the same posterior.
//!
//! A motion that repeats itself passes Δv between the same two speeds in every event. The likelihood shows that where the
//! velocity is exact. Where each event has its own velocity error, the likelihood would average over a gap that is
//! the same in every event; there the standard error is at least that of the gap between two samples.

use crate::identification::{Estimate, NotIdentifiable};
use crate::linear::independence;
use crate::moves::Moves;
use friction::{Dimension, Geometry};
use std::collections::BTreeMap;

/// What is left of a recording once inertia and viscous friction are known, sample by sample.
pub(crate) struct LowSpeed<'a> {
    /// Velocity, m/s; not a number where it is not known.
    pub velocity: &'a [f64],
    /// Its standard deviation, m/s.
    pub velocity_std: &'a [f64],
    /// Friction: force less inertia, N.
    pub friction: &'a [f64],
    /// b_p, b_n, N·s/m.
    pub viscous: [f64; 2],
    /// Samples to either side over which the acceleration is an average.
    pub spread: usize,
    /// Speed that a body leaving rest gains while a step is spread by what made the acceleration, m/s.
    pub blur: f64,
}

/// What was found; None for what was not.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct StaticLevels {
    /// D_p, D_n with standard deviation, N.
    pub levels: [Option<(f64, f64)>; 2],
    /// Δv with standard deviation, m/s.
    pub delta_v: Option<(f64, f64)>,
    /// A step was seen, at this speed, but no wider than what a filter makes of any step.
    pub blurred: Option<f64>,
    /// Times the body left rest in positive and in negative direction.
    pub events: [usize; 2],
}

impl StaticLevels {
    /// Numbers where there are any, reasons and the move that would give them where there are none. `fastest` is the
    /// top speed of the recording, m/s.
    pub fn report(
        &self,
        geometry: Geometry,
        fastest: f64,
        moves: &Moves,
        parameters: &mut BTreeMap<String, Estimate>,
        lost: &mut Vec<NotIdentifiable>,
    ) {
        let blurred = self.blurred.map(|dv| {
            let unit = Dimension::VELOCITY.unit(geometry);
            format!("the step from static to sliding at {dv:.2e} {unit} is no sharper than the filter makes any step")
        });
        let mut give =
            |name: &str, found: Option<(f64, f64)>, dimension: Dimension, because: String| match found {
                Some((value, std)) => {
                    parameters.insert(
                        name.into(),
                        Estimate::gaussian(value, std, dimension.unit(geometry).to_string()),
                    );
                }
                None => lost.push(NotIdentifiable {
                    parameter: name.into(),
                    because: blurred.clone().unwrap_or(because),
                    experiment: moves.break_away(),
                }),
            };
        for (way, (name, direction)) in
            [("static_p", "positive"), ("static_n", "negative")].into_iter().enumerate()
        {
            let because = format!(
                "the body left rest {} times in {direction} direction, with too few samples below Δv to tell static \
                 from sliding friction",
                self.events[way]
            );
            give(name, self.levels[way], Dimension::FORCE, because);
        }
        let because = format!(
            "below {:.3e} {} friction shows no step from static to sliding that stands out of the noise",
            TOP * fastest,
            Dimension::VELOCITY.unit(geometry)
        );
        give("delta_v", self.delta_v, Dimension::VELOCITY, because);
    }
}

/// Leaving rest in one direction: speeds, rising, and friction, both magnitudes.
struct Event {
    way: usize,
    /// Speed, m/s, and sums over the samples up to it.
    below: Vec<(f64, Sums)>,
    /// Standard deviation that the speeds have in common, m/s.
    std: f64,
}

/// Sums over samples.
#[derive(Debug, Clone, Copy, Default)]
struct Sums {
    n: f64,
    friction: f64,
    squares: f64,
    /// Of friction above the sliding law, and its squares.
    above: f64,
    above_squares: f64,
}

impl Sums {
    fn add(&mut self, other: &Self) {
        self.n += other.n;
        self.friction += other.friction;
        self.squares += other.squares;
        self.above += other.above;
        self.above_squares += other.above_squares;
    }

    /// The static level these samples would have; None where they do not lie above the sliding law.
    fn level(&self) -> Option<f64> {
        (self.n > 0.0 && self.above > 0.0).then(|| self.friction / self.n)
    }

    /// Squares that a level explains and the sliding law does not.
    fn explained(&self, level: f64) -> f64 {
        self.above_squares - (self.squares - 2.0 * level * self.friction + self.n * level * level)
    }
}

impl Event {
    /// Sums over the samples up to a speed.
    fn up_to(&self, speed: f64) -> Sums {
        self.first(self.below.partition_point(|(v, _)| *v <= speed))
    }

    /// Sums over the samples that are below a speed for all the errors of velocity and acceleration.
    fn surely_below(&self, speed: f64, spread: usize) -> Sums {
        let speed = speed - (1.5 * self.std).min(0.25 * speed);
        self.first(self.below.partition_point(|(v, _)| *v <= speed).saturating_sub(spread))
    }

    fn first(&self, n: usize) -> Sums {
        n.checked_sub(1).and_then(|last| self.below.get(last)).map_or_else(Sums::default, |(_, sums)| *sums)
    }
}

/// The sliding law as the unfiltered samples have it.
struct Sliding {
    /// C_p, C_n, magnitudes, N.
    coulomb: [f64; 2],
    /// Variance of one sample of friction about it, N².
    variance: f64,
    /// Independent samples per sample.
    independence: f64,
}

/// Where Δv is, by all events together.
struct Posterior {
    speeds: Vec<f64>,
    weights: Vec<f64>,
}

impl Posterior {
    /// Mean and variance of a quantity at each speed.
    fn moments(&self, of: impl Fn(usize) -> f64) -> (f64, f64) {
        let values: Vec<f64> = (0..self.speeds.len()).map(of).collect();
        let mean = values.iter().zip(&self.weights).map(|(x, w)| x * w).sum::<f64>();
        (mean, values.iter().zip(&self.weights).map(|(x, w)| w * (x - mean).powi(2)).sum())
    }
}

/// A step at less than this many times what spreads it is not one of friction.
const BLURRED: f64 = 3.0;
/// Speed, as a share of the largest, above which no static friction is looked for.
const TOP: f64 = 0.3;
/// Speeds that Δv is looked for at.
const SPEEDS: usize = 600;
/// Share of the weight that may lie at the last of them: more, and what lies above the law is no step.
const AT_TOP: f64 = 0.01;
/// Standard deviations below the sliding law at which friction is that of a body at rest.
const AT_REST: f64 = 3.5;
/// Fewest samples that tell the sliding level of a direction.
const FEWEST: usize = 20;
/// Places, in standard deviations, and weights that stand for a normal variable.
const NORMAL: [(f64, f64); 9] = [
    (-2.4, 0.013_6),
    (-1.8, 0.047_9),
    (-1.2, 0.117_7),
    (-0.6, 0.202_0),
    (0.0, 0.237_6),
    (0.6, 0.202_0),
    (1.2, 0.117_7),
    (1.8, 0.047_9),
    (2.4, 0.013_6),
];

impl LowSpeed<'_> {
    /// Finds the levels.
    pub fn find(&self) -> StaticLevels {
        let fastest =
            self.velocity.iter().fold(0.0f64, |m, v| if v.is_finite() { m.max(v.abs()) } else { m });
        let mut out = StaticLevels::default();
        let Some(sliding) = self.sliding(TOP * fastest) else { return out };
        let events = self.events(&sliding, 2e-3 * fastest, TOP * fastest);
        for event in &events {
            out.events[event.way] += 1;
        }
        let Some(posterior) = posterior(&events, &sliding, TOP * fastest) else { return out };
        let (dv, variance) = posterior.moments(|k| posterior.speeds[k]);
        if dv < BLURRED * self.blur {
            out.blurred = Some(dv);
            return out;
        }
        let resolution = self.blur * self.blur / 12.0;
        out.delta_v = Some((dv, (variance.max(repeated(&events, dv)) + resolution).sqrt()));
        for way in 0..2 {
            let sums: Vec<Sums> = posterior
                .speeds
                .iter()
                .map(|dv| total(&events, way, |event| event.surely_below(*dv, self.spread)))
                .collect();
            let likely = posterior.moments(|k| sums[k].n).0;
            if likely < 2.0 {
                continue;
            }
            let (level, between) = posterior.moments(|k| {
                let sums = &sums[k];
                if sums.n > 0.0 { sums.friction / sums.n } else { sliding.coulomb[way] }
            });
            let within = sliding.variance / (likely * sliding.independence);
            out.levels[way] = Some((level.max(0.0), (within + between).sqrt()));
        }
        out
    }

    /// The level of each direction above `slowest`, and how friction scatters about the law.
    fn sliding(&self, slowest: f64) -> Option<Sliding> {
        let faster = |way: usize| {
            let sign = if way == 0 { 1.0 } else { -1.0 };
            let b = self.viscous[way];
            self.velocity.iter().zip(self.friction).enumerate().filter_map(move |(i, (v, f))| {
                let above = sign * f - b * sign * v;
                (sign * v > slowest && above.is_finite()).then_some((i, above))
            })
        };
        let coulomb = [0, 1].map(|way| {
            let (n, sum) = faster(way).fold((0, 0.0), |(n, sum), (_, level)| (n + 1, sum + level));
            if n < FEWEST { f64::NAN } else { sum / n as f64 }
        });
        let mut residual: Vec<(usize, f64)> = [0, 1]
            .into_iter()
            .filter(|way| coulomb[*way].is_finite())
            .flat_map(|way| faster(way).map(move |(i, level)| (i, level - coulomb[way])))
            .collect();
        residual.sort_by_key(|(i, _)| *i);
        let (at, residual): (Vec<usize>, Vec<f64>) = residual.into_iter().unzip();
        let squares = residual.iter().map(|e| e * e).sum::<f64>();
        (squares > 0.0).then(|| Sliding {
            coulomb,
            variance: squares / residual.len() as f64,
            independence: independence(&residual, &at),
        })
    }

    /// Where the body leaves rest for good: from the first sample that surely moves to the one at `top`.
    fn events(&self, sliding: &Sliding, resolution: f64, top: f64) -> Vec<Event> {
        let v = self.velocity;
        // Below this a body may be at rest. The errors of a smoothed velocity last longer than a break-away, so
        // samples beyond are beyond together.
        let rest = |i: usize| (3.0 * self.velocity_std[i]).max(resolution);
        let mut out = Vec::new();
        let mut k = 0;
        while k < v.len() {
            if !(v[k].abs() <= rest(k)) {
                k += 1;
                continue;
            }
            let Some(start) = (k..v.len()).find(|i| !(v[*i].abs() <= rest(*i))) else { break };
            // how it left rest, if it did, is in a gap
            if v[start].is_nan() {
                k = start + 1;
                continue;
            }
            let way = usize::from(v[start] < 0.0);
            let sign = if way == 0 { 1.0 } else { -1.0 };
            let end = (start..v.len())
                .find(|i| !(sign * v[*i] > rest(*i) && sign * v[*i] <= top))
                .unwrap_or(v.len());
            // An excursion that falls back to rest is noise, or creep that says nothing about a step.
            if v.get(end).is_some_and(|v| sign * v > top) && sliding.coulomb[way].is_finite() {
                // an average of the acceleration reaches back into rest
                out.push(self.event(sliding, way, (start + self.spread).min(end)..end));
            }
            k = end.max(start + 1);
        }
        out
    }

    fn event(&self, sliding: &Sliding, way: usize, samples: std::ops::Range<usize>) -> Event {
        let sign = if way == 0 { 1.0 } else { -1.0 };
        let std = samples.clone().map(|i| self.velocity_std[i]).sum::<f64>() / samples.len().max(1) as f64;
        let law = |i: usize| sliding.coulomb[way] + self.viscous[way] * sign * self.velocity[i];
        // a body that pulls less than sliding takes is at rest, whatever the errors of its velocity say
        let at_rest = |i: usize| sign * self.friction[i] < law(i) - AT_REST * sliding.variance.sqrt();
        let samples =
            samples.clone().rev().find(|i| at_rest(*i)).map_or(samples.start, |i| i + 1)..samples.end;
        let mut below: Vec<(f64, Sums)> = samples
            .map(|i| (sign * self.velocity[i], sign * self.friction[i]))
            .filter(|(_, friction)| friction.is_finite())
            .map(|(speed, friction)| {
                let above = friction - (sliding.coulomb[way] + self.viscous[way] * speed);
                let squares = friction * friction;
                (speed, Sums { n: 1.0, friction, squares, above, above_squares: above * above })
            })
            .collect();
        below.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut total = Sums::default();
        for (_, sums) in &mut below {
            total.add(sums);
            *sums = total;
        }
        Event { way, below, std }
    }
}

/// Sums over what `of` takes of each event in one direction.
fn total(events: &[Event], way: usize, of: impl Fn(&Event) -> Sums) -> Sums {
    let mut total = Sums::default();
    for event in events.iter().filter(|e| e.way == way) {
        total.add(&of(event));
    }
    total
}

/// Variance of Δv where every event passes it between the same two samples, as far as the error of their speeds hides
/// whether it does.
fn repeated(events: &[Event], dv: f64) -> f64 {
    let gaps: Vec<(f64, f64)> = events
        .iter()
        .filter_map(|event| {
            let next = event.below.partition_point(|(v, _)| *v <= dv);
            let (last, next) = (event.below.get(next.checked_sub(1)?)?, event.below.get(next)?);
            Some(((next.0 - last.0).powi(2), event.std.powi(2)))
        })
        .collect();
    if gaps.is_empty() {
        return 0.0;
    }
    let n = gaps.len() as f64;
    let (gap, error) = gaps.iter().fold((0.0, 0.0), |(g, e), (gap, error)| (g + gap / n, e + error / n));
    let hidden = if error > 0.0 { error / (error + gap / 64.0) } else { 0.0 };
    hidden * gap / 12.0 + error / n
}

/// How likely the step is at each speed up to `top`; None where none stands out of the noise.
fn posterior(events: &[Event], sliding: &Sliding, top: f64) -> Option<Posterior> {
    let speeds: Vec<f64> = (0..SPEEDS).map(|k| top * (k as f64 + 0.5) / SPEEDS as f64).collect();
    let unit = sliding.variance / sliding.independence;
    let (mut gain, mut scores) = (0.0f64, Vec::with_capacity(SPEEDS));
    for dv in &speeds {
        let (mut score, mut explained) = (0.0, 0.0);
        for way in 0..2 {
            let sums = total(events, way, |event| event.up_to(*dv));
            let Some(level) = sums.level() else { continue };
            explained += sums.explained(level);
            // a level costs what it could have been and is not
            score -= 0.5 * (1.0 + sums.n * sliding.independence).ln();
            for event in events.iter().filter(|e| e.way == way) {
                let at = |off: f64| event.up_to(dv + off * event.std).explained(level) / (2.0 * unit);
                let largest = NORMAL.iter().map(|(off, _)| at(*off)).fold(f64::NEG_INFINITY, f64::max);
                score +=
                    largest + NORMAL.iter().map(|(off, w)| w * (at(*off) - largest).exp()).sum::<f64>().ln();
            }
        }
        gain = gain.max(explained);
        scores.push(score);
    }
    // Twice the log of the number of places looked at is what noise alone would explain; 12 more is 3.5 deviations.
    let samples = events.iter().map(|e| e.below.len()).sum::<usize>();
    let chance = 2.0 * (samples.max(2) as f64).ln() + 12.0;
    if !(gain >= chance * unit) || samples < 6 {
        return None;
    }
    let highest = scores.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let mut weights: Vec<f64> = scores.iter().map(|score| (score - highest).exp()).collect();
    let total = weights.iter().sum::<f64>();
    weights.iter_mut().for_each(|w| *w /= total);
    (weights.last().is_some_and(|last| *last < AT_TOP)).then_some(Posterior { speeds, weights })
}
