//! The recording as a chain of nodes in time: one for each stamp, and one for each reading of a channel that lags.

use super::kalman::{Gaussian, JerkPower, Scalar, smoothed};
use super::observation::{Observation, Observed};

/// Length and time in which state and covariance are of order one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Units {
    /// Typical sample period, s.
    pub time: f64,
    /// Standard deviation of the position, m or rad.
    pub length: f64,
}

impl Units {
    /// Size of one unit of state component `c`, in SI.
    pub fn of(&self, c: usize) -> f64 {
        self.length / self.time.powi(c as i32)
    }
}

/// A moment at which something is observed or asked for.
#[derive(Debug, Clone, Copy)]
struct Node {
    /// In units of time, from the first stamp.
    time: f64,
    /// Index of the stamp.
    sample: u32,
    /// Channels of which lag are read here; 0 is none, the stamp itself.
    group: u16,
}

/// Channels with the same lag, their readings in the smoother's units.
struct Group<'a> {
    lag: f64,
    channels: Vec<(&'a Observation<'a>, f64)>,
}

/// Nodes in order of time with the channels read at each.
pub(super) struct Chain<'a> {
    pub units: Units,
    nodes: Vec<Node>,
    groups: Vec<Group<'a>>,
    prior: Gaussian,
    /// Largest change of the slope of the position from one period to the next.
    bend: f64,
}

/// Nodes looked through for the readings that a prior is about.
const NEAR: usize = 1000;

/// Standard deviations of the prior beyond what the channels span.
const WIDE: f64 = 10.0;

impl<'a> Chain<'a> {
    /// `time` is finite and does not decrease; the observations are valid, and there is at least one.
    pub fn new(time: &[f64], observations: &'a [Observation<'a>]) -> Self {
        let units = units(time, observations);
        let start = time.first().copied().unwrap_or(0.0);
        let mut groups = vec![Group { lag: 0.0, channels: Vec::new() }];
        for o in observations {
            let variance = o.variance() / units.of(o.observed.component()).powi(2);
            match groups.iter_mut().find(|g| g.lag == o.lag) {
                Some(group) => group.channels.push((o, variance)),
                None => groups.push(Group { lag: o.lag, channels: vec![(o, variance)] }),
            }
        }
        let mut nodes = Vec::with_capacity(time.len() * groups.len());
        let mut next = vec![0; groups.len()];
        let at =
            |group: &Group, sample: usize| time.get(sample).map(|t| (t - start - group.lag) / units.time);
        let earliest = |next: &[usize]| {
            let each =
                groups.iter().zip(next).enumerate().filter_map(|(g, (group, i))| Some((at(group, *i)?, g)));
            each.min_by(|a, b| a.0.total_cmp(&b.0))
        };
        while let Some((time, group)) = earliest(&next) {
            nodes.push(Node { time, sample: next[group] as u32, group: group as u16 });
            next[group] += 1;
        }
        let bend = bend(time, observations, units);
        let mut prior = prior(time, observations, units);
        if observations.iter().any(|o| o.observed == Observed::Position) {
            prior.cov[5] = prior.cov[5].min((WIDE * (2.0 + bend)).powi(2));
        }
        Self { units, nodes, groups, prior, bend }
    }

    /// Number of nodes.
    pub fn len(&self) -> usize {
        self.nodes.len()
    }

    /// Time from node `k` to the next.
    pub fn step(&self, k: usize) -> f64 {
        self.nodes[k + 1].time - self.nodes[k].time
    }

    /// Index of the stamp at node `k`, if it is one.
    pub fn stamp(&self, k: usize) -> Option<usize> {
        let node = self.nodes[k];
        (node.group == 0).then_some(node.sample as usize)
    }

    fn readings(&self, k: usize) -> impl Iterator<Item = Scalar> {
        let node = self.nodes[k];
        self.groups[node.group as usize].channels.iter().filter_map(move |(o, variance)| {
            let component = o.observed.component();
            let value = o.quantity(node.sample as usize)? / self.units.of(component);
            Some(Scalar { component, value, variance: *variance })
        })
    }

    /// Whether a step is so long that nothing is known of the state behind it: the chain begins again there.
    fn is_broken(&self, d: f64, density: f64) -> bool {
        density * d.powi(5) / 20.0 > self.prior.cov[0]
    }

    /// A wide prior about the next position read at or after node `k`, and the slope to the one after it: a prior much
    /// wider than what is known would cost the covariance its digits.
    fn prior_at(&self, k: usize) -> Gaussian {
        let mut prior = self.prior;
        let near = k..self.len().min(k + NEAR);
        let mut places = near.filter_map(|k| {
            let position = self.readings(k).find(|s| s.component == 0)?;
            Some((self.nodes[k].time, position.value))
        });
        let Some((start, position)) = places.next() else { return prior };
        prior.mean[0] = position;
        if let Some((d, next)) = places.map(|(t, x)| (t - start, x)).find(|(d, _)| *d > 0.5) {
            prior.mean[1] = (next - position) / d;
            let std = WIDE * (d.recip() + d * self.bend);
            prior.cov[3] = prior.cov[3].min(std * std);
        }
        prior
    }

    /// Kalman filter over `nodes` with the jerk density of the step that ends at each; returns twice the negative
    /// logarithm of the likelihood, up to a constant. `out` receives the filtered states.
    pub fn filter(
        &self,
        nodes: std::ops::Range<usize>,
        density: impl Fn(usize) -> f64,
        mut out: impl FnMut(Gaussian),
    ) -> f64 {
        let mut surprise = 0.0;
        let mut state = self.prior_at(nodes.start);
        for k in nodes.clone() {
            if k > nodes.start {
                let (d, density) = (self.step(k - 1), density(k));
                state =
                    if self.is_broken(d, density) { self.prior_at(k) } else { state.predicted(d, density) };
            }
            for reading in self.readings(k) {
                surprise += state.update(&reading);
            }
            out(state);
        }
        surprise
    }

    /// Turns filtered states into smoothed ones, in place; `power` receives what is seen of the jerk in each step.
    pub fn smooth(&self, states: &mut [Gaussian], density: &[f64], power: &mut [JerkPower]) {
        for k in (1..states.len()).rev() {
            let d = self.step(k - 1);
            if self.is_broken(d, density[k]) {
                power[k] = JerkPower::default();
                continue;
            }
            let (before, after) = states.split_at_mut(k);
            (before[k - 1], power[k]) = smoothed(&before[k - 1], &after[0], d, density[k]);
        }
    }
}

/// Typical period, and the noise of the channel nearest to the position.
fn units(time: &[f64], observations: &[Observation<'_>]) -> Units {
    let mut steps: Vec<f64> = time.windows(2).map(|w| w[1] - w[0]).filter(|d| *d > 0.0).collect();
    let middle = steps.len() / 2;
    let time = if steps.is_empty() { 1.0 } else { *steps.select_nth_unstable_by(middle, f64::total_cmp).1 };
    let lowest = observations.iter().min_by_key(|o| o.observed.component());
    let length = lowest.map_or(1.0, |o| o.variance().sqrt() * time.powi(o.observed.component() as i32));
    Units { time, length }
}

/// Largest change of the slope of a position from one period to the next, its noise included.
fn bend(time: &[f64], observations: &[Observation<'_>], units: Units) -> f64 {
    let mut bend = 0.0_f64;
    for o in observations.iter().filter(|o| o.observed == Observed::Position) {
        let mut slope = None;
        let mut last: Option<(f64, f64)> = None;
        let readings = time.iter().enumerate().filter_map(|(i, t)| Some((*t, o.quantity(i)? / units.length)));
        for (t, x) in readings {
            if let Some((then, before)) = last {
                let now = (x - before) / ((t - then) / units.time).max(1.0);
                bend = slope.map_or(bend, |slope: f64| bend.max((now - slope).abs()));
                slope = Some(now);
            }
            last = Some((t, x));
        }
    }
    bend
}

/// A state that nothing in the recording contradicts: as far, as fast and as quick as any two neighbouring readings.
fn prior(time: &[f64], observations: &[Observation<'_>], units: Units) -> Gaussian {
    let mut std = [WIDE; 3];
    let mut widen = |component: usize, size: f64| {
        for (c, s) in std.iter_mut().enumerate().skip(component) {
            // in units of one period a derivative is no larger than what it is the derivative of
            *s = s.max(WIDE * size * if c > component + 1 { 2.0 } else { 1.0 });
        }
    };
    for o in observations {
        let c = o.observed.component();
        let scaled = |i: usize| o.quantity(i).map(|q| q / units.of(c));
        let mut last: Option<(f64, f64)> = None;
        for (i, t) in time.iter().enumerate() {
            let Some(value) = scaled(i) else { continue };
            match last {
                Some((before, then)) => {
                    let d = ((t - then) / units.time).max(1.0);
                    widen(c + 1, (value - before).abs() / d);
                }
                None if c > 0 => widen(c, value.abs()),
                None => {}
            }
            if c > 0 {
                widen(c, value.abs());
            }
            last = Some((value, *t));
        }
    }
    // The position is known from the first reading of it on, and where there is none it is counted from zero.
    let spans = observations.iter().filter(|o| o.observed.component() == 0).map(|o| {
        let readings = (0..time.len()).filter_map(|i| o.quantity(i));
        let (low, high) = readings.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)));
        if low <= high { (high - low) / units.length } else { 0.0 }
    });
    std[0] = spans.fold(std[0].max(std[1]), |s, span| s.max(WIDE * span));
    let limited = std.map(|s| s.min(1e12).powi(2));
    Gaussian { mean: [0.0; 3], cov: [limited[0], 0.0, 0.0, limited[1], 0.0, limited[2]] }
}
