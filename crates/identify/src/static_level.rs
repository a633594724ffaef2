//! Static friction D and the speed Δv below which it holds, from how a body leaves rest.
//!
//! By eq. 3.1 a body that moves inside the band is held back by D, and by C outside: leaving rest, friction is D until
//! the speed passes Δv, then falls to C. So Δv is the speed of that step (the one that leaves the least squared
//! error), and D the mean friction below it, on the samples that speed up from rest.

use crate::identification::{Estimate, NotIdentifiable, Units};
use crate::moves::Moves;
use std::collections::BTreeMap;

/// What is left of a recording once inertia and sliding friction are known.
pub(crate) struct LowSpeed<'a> {
    /// Velocity behind the noise, m/s; not a number where it is not known.
    pub velocity: &'a [f64],
    /// Its standard deviation, m/s.
    pub velocity_std: f64,
    /// Friction: force less inertia, N.
    pub friction: &'a [f64],
    /// C_p, C_n (magnitudes, N).
    pub coulomb: [f64; 2],
    /// b_p, b_n, N·s/m.
    pub viscous: [f64; 2],
    /// Standard deviation of one sample of friction about the law, N.
    pub noise: f64,
    /// Speed that a body leaving rest gains while the filter spreads a step, m/s; 0 without a filter.
    pub blur: f64,
    /// Independent samples per sample: below one behind a filter.
    pub independence: f64,
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
        units: Units,
        fastest: f64,
        moves: &Moves,
        parameters: &mut BTreeMap<String, Estimate>,
        lost: &mut Vec<NotIdentifiable>,
    ) {
        let blurred = self.blurred.map(|dv| {
            let unit = units.velocity();
            format!("the step from static to sliding at {dv:.2e} {unit} is no sharper than the filter makes any step")
        });
        let mut give = |name: &str, found: Option<(f64, f64)>, unit: &str, because: String| match found {
            Some((value, std)) => {
                parameters.insert(name.into(), Estimate::gaussian(value, std, unit));
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
            give(name, self.levels[way], units.force(), because);
        }
        let because = format!(
            "below {:.3e} {} friction shows no step from static to sliding that stands out of the noise",
            TOP * fastest,
            units.velocity()
        );
        give("delta_v", self.delta_v, units.velocity(), because);
    }
}

/// Leaving rest in one direction: sample numbers, speeds rising.
struct Event {
    way: usize,
    samples: Vec<usize>,
}

/// A step at less than this many times what the filter spreads it over is the filter's.
const BLURRED: f64 = 3.0;
/// Speed, as a share of the largest, above which no static friction is looked for.
const TOP: f64 = 0.3;

impl LowSpeed<'_> {
    /// Finds the levels.
    pub fn find(&self) -> StaticLevels {
        let fastest =
            self.velocity.iter().fold(0.0f64, |m, v| if v.is_finite() { m.max(v.abs()) } else { m });
        // Below this a body may be at rest: three deviations of its velocity, or its resolution. The errors of a
        // smoothed velocity last longer than a break-away, so samples beyond are beyond together.
        let rest = (3.0 * self.velocity_std).max(2e-3 * fastest);
        let events = self.events(rest, TOP * fastest);
        let mut out = StaticLevels::default();
        for event in &events {
            out.events[event.way] += 1;
        }
        out.delta_v = self.step(&events);
        if let Some((dv, _)) = out.delta_v.filter(|(dv, _)| *dv < BLURRED * self.blur) {
            (out.delta_v, out.blurred) = (None, Some(dv));
            return out;
        }
        let top = match out.delta_v {
            Some((dv, _)) => dv - (1.5 * self.velocity_std).min(0.25 * dv),
            None => 3.0 * rest,
        };
        for way in 0..2 {
            out.levels[way] = self.level(&events, way, top);
        }
        out
    }

    /// Where the body leaves rest for good: from the first sample that surely moves to the one at `top`.
    fn events(&self, rest: f64, top: f64) -> Vec<Event> {
        let v = self.velocity;
        let mut out = Vec::new();
        let mut k = 0;
        while k < v.len() {
            if !(v[k].abs() <= rest) {
                k += 1;
                continue;
            }
            let Some(start) = (k..v.len()).find(|i| !(v[*i].abs() <= rest)) else { break };
            // how it left rest, if it did, is in a gap
            if v[start].is_nan() {
                k = start + 1;
                continue;
            }
            let way = usize::from(v[start] < 0.0);
            let sign = if way == 0 { 1.0 } else { -1.0 };
            let end =
                (start..v.len()).find(|i| !(sign * v[*i] > rest && sign * v[*i] <= top)).unwrap_or(v.len());
            // An excursion that falls back to rest is noise, or creep that says nothing about a step.
            if v.get(end).is_some_and(|v| sign * v > top) {
                out.push(Event { way, samples: (start..end).collect() });
            }
            k = end.max(start + 1);
        }
        out
    }

    fn sliding(&self, way: usize, speed: f64) -> f64 {
        self.coulomb[way] + self.viscous[way] * speed
    }

    /// Speed and friction above the sliding law of the samples of one direction, magnitudes.
    fn excess<'b>(&'b self, events: &'b [Event], way: usize) -> impl Iterator<Item = (f64, f64)> + 'b {
        let sign = if way == 0 { 1.0 } else { -1.0 };
        events.iter().filter(move |e| e.way == way).flat_map(|e| &e.samples).filter_map(move |i| {
            let (speed, friction) = (sign * self.velocity[*i], sign * self.friction[*i]);
            (speed > 0.0 && friction.is_finite()).then(|| (speed, friction - self.sliding(way, speed)))
        })
    }

    /// The speed at which friction steps down from static to sliding, in both directions at once.
    fn step(&self, events: &[Event]) -> Option<(f64, f64)> {
        let mut ways = [0, 1].map(|way| {
            let mut s: Vec<(f64, f64)> = self.excess(events, way).collect();
            s.sort_by(|a, b| a.0.total_cmp(&b.0));
            s
        });
        let mut speeds: Vec<f64> = ways.iter().flatten().map(|(speed, _)| *speed).collect();
        speeds.sort_by(f64::total_cmp);
        // What levels above sliding friction, one a direction, explain below `dv`: squared sum over number.
        let explained = |ways: &[Vec<(f64, f64)>; 2], dv: f64| -> f64 {
            ways.iter()
                .map(|s| {
                    let n = s.partition_point(|(speed, _)| *speed <= dv);
                    let sum: f64 = s[..n].iter().map(|(_, e)| *e).sum();
                    if n == 0 { 0.0 } else { sum.max(0.0).powi(2) / n as f64 }
                })
                .sum()
        };
        let best = |ways: &[Vec<(f64, f64)>; 2]| -> Option<(f64, f64)> {
            speeds
                .windows(2)
                .map(|w| (0.5 * (w[0] + w[1]), explained(ways, w[0])))
                .max_by(|a, b| a.1.total_cmp(&b.1))
        };
        let (dv, gain) = best(&ways)?;
        // Twice the log of the number of places looked at is what noise alone would explain; 12 more is 3.5 deviations.
        let chance = 2.0 * (speeds.len().max(2) as f64).ln() + 12.0;
        let unit = self.noise * self.noise / self.independence.max(1e-3);
        if gain < chance * unit || speeds.len() < 6 {
            return None;
        }
        // Jackknife over every third sample says how far the place moves when data are missing.
        let all = ways.clone();
        let mut places = Vec::new();
        for part in 0..8 {
            for (way, s) in ways.iter_mut().enumerate() {
                *s = all[way].iter().enumerate().filter(|(i, _)| i % 8 != part).map(|(_, s)| *s).collect();
            }
            places.extend(best(&ways).map(|b| b.0));
        }
        let mean = places.iter().sum::<f64>() / places.len().max(1) as f64;
        let jackknife = 7.0 / 8.0 * places.iter().map(|p| (p - mean).powi(2)).sum::<f64>();
        let (dv, gap) = self.between(events, dv);
        let count = events.len().max(1) as f64;
        // Blur averages out over events; what lies between two samples does not, where a motion repeats itself.
        let resolution = gap * gap / 12.0 + self.velocity_std.powi(2) / count;
        Some((dv, (jackknife + resolution).sqrt()))
    }

    /// Friction fell between two samples of each event: the middle of them, and how far they are apart, on average.
    fn between(&self, events: &[Event], dv: f64) -> (f64, f64) {
        let pairs: Vec<(f64, f64)> = events
            .iter()
            .filter_map(|e| {
                let last = e.samples.iter().rev().find(|i| self.velocity[**i].abs() <= dv)?;
                Some((self.velocity[*last].abs(), self.velocity.get(last + 1)?.abs()))
            })
            .collect();
        let n = pairs.len() as f64;
        if pairs.is_empty() {
            return (dv, 0.0);
        }
        let mean = |f: fn(&(f64, f64)) -> f64| pairs.iter().map(f).sum::<f64>() / n;
        (mean(|p| 0.5 * (p.0 + p.1)), mean(|p| p.1 - p.0))
    }

    fn level(&self, events: &[Event], way: usize, top: f64) -> Option<(f64, f64)> {
        let mut inside: Vec<f64> = self
            .excess(events, way)
            .filter(|(speed, _)| *speed <= top)
            .map(|(speed, e)| e + self.sliding(way, speed))
            .collect();
        inside.sort_by(f64::total_cmp);
        // A sample that was still at rest carries any force up to D: it stands out, and does not count.
        let middle = inside.get(inside.len() / 2).copied()?;
        inside.retain(|f| (f - middle).abs() <= 3.0 * self.noise);
        let n = inside.len() as f64;
        if inside.len() < 2 {
            return None;
        }
        let level = inside.iter().sum::<f64>() / n;
        let scatter = inside.iter().map(|f| (f - level).powi(2)).sum::<f64>() / (n - 1.0);
        let per_sample = scatter.max(self.noise * self.noise);
        Some((level.max(0.0), (per_sample / (n * self.independence).max(1.0)).sqrt()))
    }
}
