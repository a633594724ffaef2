//! Static friction D and the speed Δv below which it holds, from how a body leaves rest.
//!
//! By eq. 3.1 a body that moves inside the band is held back by D, and by C outside: leaving rest, friction is D until
//! the speed passes Δv, then falls to C. So Δv is the speed of that step (the one that leaves the least squared
//! error), and D the mean friction below it, on the samples that speed up from rest.

/// What is left of a recording once inertia and sliding friction are known.
pub(crate) struct LowSpeed<'a> {
    /// Velocity behind the noise, m/s.
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
    /// Times the body left rest in positive and in negative direction.
    pub events: [usize; 2],
}

/// Leaving rest in one direction: sample numbers, speeds rising.
struct Event {
    way: usize,
    samples: Vec<usize>,
}

/// Speed, as a share of the largest, above which no static friction is looked for.
const TOP: f64 = 0.3;

impl LowSpeed<'_> {
    /// Finds the levels.
    pub fn find(&self) -> StaticLevels {
        let fastest = self.velocity.iter().fold(0.0f64, |m, v| if v.is_finite() { m.max(v.abs()) } else { m });
        // Below this a body may be at rest: three deviations of its velocity, or its resolution.
        let rest = (3.0 * self.velocity_std).max(2e-3 * fastest);
        let events = self.events(rest, TOP * fastest);
        let mut out = StaticLevels::default();
        for event in &events {
            out.events[event.way] += 1;
        }
        // Samples at which the body surely moves: two deviations.
        let moving = (2.0 * self.velocity_std).max(1e-3 * fastest);
        out.delta_v = self.step(&events, moving, TOP * fastest);
        let (top, blur) = match out.delta_v {
            Some((dv, _)) => (dv, (1.5 * self.velocity_std).min(0.25 * dv)),
            None => (3.0 * rest, 0.0),
        };
        for way in 0..2 {
            out.levels[way] = self.level(&events, way, moving.min(0.4 * top), top - blur);
        }
        out
    }

    fn events(&self, rest: f64, top: f64) -> Vec<Event> {
        let v = self.velocity;
        let mut out = Vec::new();
        let mut k = 0;
        while k < v.len() {
            // leave the band of rest …
            if v[k].abs() > rest || !v[k].is_finite() {
                k += 1;
                continue;
            }
            let Some(leaves) = (k..v.len()).find(|i| v[*i].abs() > rest) else { break };
            let way = usize::from(v[leaves] < 0.0);
            let sign = if way == 0 { 1.0 } else { -1.0 };
            // … having come from rest and not straight through from the other direction: slower than a deviation on
            // average for as long as it takes to leave
            let start = (k..leaves).rev().find(|i| sign * v[*i] <= 0.0).unwrap_or(k);
            let end = (leaves..v.len()).find(|i| sign * v[*i] > top || sign * v[*i] < 0.0).unwrap_or(v.len());
            out.push(Event { way, samples: (start..end).collect() });
            k = end.max(leaves + 1);
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

    /// The speed at which friction steps from static to sliding, in both directions at once.
    fn step(&self, events: &[Event], moving: f64, top: f64) -> Option<(f64, f64)> {
        let mut ways = [0, 1].map(|way| {
            let mut s: Vec<(f64, f64)> =
                self.excess(events, way).filter(|(speed, _)| *speed > moving && *speed < top).collect();
            s.sort_by(|a, b| a.0.total_cmp(&b.0));
            s
        });
        let mut speeds: Vec<f64> = ways.iter().flatten().map(|(speed, _)| *speed).collect();
        speeds.sort_by(f64::total_cmp);
        // What a level below `dv` explains: the squared sum over the number, per direction.
        let explained = |ways: &[Vec<(f64, f64)>; 2], dv: f64| -> f64 {
            ways.iter()
                .map(|s| {
                    let n = s.partition_point(|(speed, _)| *speed <= dv);
                    let sum: f64 = s[..n].iter().map(|(_, e)| *e).sum();
                    if n == 0 { 0.0 } else { sum * sum / n as f64 }
                })
                .sum()
        };
        let best = |ways: &[Vec<(f64, f64)>; 2]| -> Option<(f64, f64)> {
            speeds.windows(2).map(|w| (0.5 * (w[0] + w[1]), explained(ways, w[0]))).max_by(|a, b| a.1.total_cmp(&b.1))
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
        let near = speeds.iter().filter(|s| (*s - dv).abs() < 0.5 * dv).count().max(1) as f64;
        let resolution = dv / near / 12f64.sqrt();
        let blur = self.velocity_std / (events.len().max(1) as f64).sqrt();
        Some((dv, (jackknife + resolution * resolution + blur * blur).sqrt()))
    }

    fn level(&self, events: &[Event], way: usize, from: f64, to: f64) -> Option<(f64, f64)> {
        let inside: Vec<(f64, f64)> =
            self.excess(events, way).filter(|(speed, _)| *speed >= from && *speed <= to).collect();
        let n = inside.len() as f64;
        if inside.len() < 2 {
            return None;
        }
        let level = inside.iter().map(|(speed, e)| e + self.sliding(way, *speed)).sum::<f64>() / n;
        let scatter =
            inside.iter().map(|(speed, e)| (e + self.sliding(way, *speed) - level).powi(2)).sum::<f64>() / (n - 1.0);
        let per_sample = scatter.max(self.noise * self.noise);
        Some((level.max(0.0), (per_sample / (n * self.independence).max(1.0)).sqrt()))
    }
}
