//! A hypothesis about what was left out: an effect of the catalogue with a shape, as columns of the regression.

use crate::linear::Blocks;
use crate::sensor::{Acts, Sensor};
use crate::signal::{quantile, rms};
use crate::track::Track;
use friction::Motion;
use friction::effects::{EffectKind, MAX_GAINS, MAX_MEMORY, MAX_SHAPE, Parameter};

/// What a term is a hypothesis about.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum TermKind {
    /// A force, renderable on the device unchanged.
    Force(EffectKind),
    /// A sensor, an estimator or the drive.
    Sensor(&'static Sensor),
}

impl TermKind {
    /// Every effect that can be told from others by a recording.
    pub fn all() -> Vec<Self> {
        let forces = EffectKind::ALL.iter().copied().map(Self::Force);
        forces.chain(crate::sensor::ALL.iter().map(Self::Sensor)).collect()
    }

    /// Catalogue id.
    pub fn id(&self) -> &'static str {
        match self {
            Self::Force(kind) => kind.id(),
            Self::Sensor(sensor) => sensor.id,
        }
    }

    /// One plain sentence.
    pub fn says(&self) -> &'static str {
        match self {
            Self::Force(kind) => kind.says(),
            Self::Sensor(sensor) => sensor.says,
        }
    }

    /// The equation.
    pub fn equation(&self) -> &'static str {
        match self {
            Self::Force(kind) => kind.equation(),
            Self::Sensor(sensor) => sensor.equation,
        }
    }

    /// Gains, in the order of the columns.
    pub fn gains(&self) -> &'static [Parameter] {
        match self {
            Self::Force(kind) => kind.gains(),
            Self::Sensor(sensor) => sensor.gains,
        }
    }

    /// Shape parameters.
    pub fn shape(&self) -> &'static [Parameter] {
        match self {
            Self::Force(kind) => kind.shape(),
            Self::Sensor(sensor) => sensor.shape,
        }
    }

    /// Whether its columns are made of the force that acts: what moves, bends or follows the whole of it.
    pub fn needs_force(&self) -> bool {
        match self {
            Self::Sensor(sensor) => matches!(sensor.acts, Acts::InTime | Acts::OnForce),
            Self::Force(kind) => kind.id() == "torque_ripple",
        }
    }

    /// Whether it is a sensor or drive effect that acts there.
    pub fn acts(&self, there: Acts) -> bool {
        matches!(self, Self::Sensor(sensor) if sensor.acts == there)
    }

    /// Whether another force that acts changes a column of it.
    pub fn reads_force(&self) -> bool {
        self.needs_force() || self.id() == "load_dependent_friction"
    }

    /// Ways the gains may go together, simplest first; each is a list of gains that share one column.
    pub fn variants(&self) -> Vec<Vec<Vec<usize>>> {
        let gains = self.gains();
        let each = |members: &[usize]| members.iter().map(|g| vec![*g]).collect::<Vec<_>>();
        let all: Vec<usize> = (0..gains.len()).collect();
        let pairs: Vec<Vec<usize>> = all
            .iter()
            .filter_map(|&i| {
                let stem = gains[i].name.strip_suffix("_p")?;
                let j = gains.iter().position(|h| h.name.strip_suffix("_n") == Some(stem))?;
                Some(vec![i, j])
            })
            .collect();
        match self.id() {
            // The two ends of a stop, the two orders of a spring, load and share are separate mechanisms.
            "hard_stop" | "nonlinear_spring" | "load_dependent_friction" => {
                let mut out: Vec<_> = all.iter().map(|g| each(&[*g])).collect();
                if self.id() != "load_dependent_friction" {
                    out.push(each(&all));
                }
                out
            }
            "frictional_lag" => vec![each(&all[..1]), each(&all)],
            // one way in time or the other
            "time_skew" | "actuator_lag" => all.iter().map(|g| each(&[*g])).collect(),
            "cogging" => vec![each(&all[..2]), each(&all)],
            _ if pairs.is_empty() => vec![each(&all)],
            _ => {
                // Both directions alike or each its own; first the leading pair, then all of them.
                let mut out = Vec::new();
                for count in 1..=pairs.len() {
                    let used = &pairs[..count];
                    out.push(used.to_vec());
                    out.push(used.iter().flatten().map(|g| vec![*g]).collect());
                }
                out
            }
        }
    }
}

/// An effect with its shape, and which of its gains are free.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Term {
    /// The effect.
    pub kind: TermKind,
    /// Non-linear parameters.
    pub shape: [f64; MAX_SHAPE],
    /// Index into [`TermKind::variants`].
    pub variant: usize,
}

/// Sums of the columns that share a gain.
pub fn gather(all: &[Vec<f64>], groups: &[Vec<usize>]) -> Vec<Vec<f64>> {
    groups
        .iter()
        .map(|members| {
            let mut sum = vec![0.0; all.first().map_or(0, Vec::len)];
            for column in members.iter().filter_map(|m| all.get(*m)) {
                for (s, x) in sum.iter_mut().zip(column) {
                    *s += x;
                }
            }
            sum
        })
        .collect()
}

/// Everything the regressors are made from, and how rows become blocks.
#[derive(Debug, Clone)]
pub struct Stage {
    /// Gap-free stretches, in order of time within a recording.
    pub tracks: Vec<Track>,
    /// Share of each row's samples that are used.
    pub share: Vec<f64>,
    /// Blocks of rows.
    pub blocks: Blocks,
    /// Filtered, masked force.
    pub y: Vec<f64>,
    /// The same for the baseline's columns.
    pub baseline: Vec<Vec<f64>>,
    /// The delay of the force is a column of the baseline, the last one.
    pub delay: bool,
}

impl Stage {
    /// Rows of a series per track that is already filtered.
    pub fn rows(&self, of: impl Fn(&Track) -> Vec<f64>) -> Vec<f64> {
        let mut out = Vec::with_capacity(self.share.len());
        for track in &self.tracks {
            track.rows(&of(track), &mut out);
        }
        out
    }

    /// Effective number of rows in each block.
    pub fn block_weight(&self) -> Vec<f64> {
        (0..self.blocks.len()).map(|k| self.blocks.rows(k).map(|r| self.share[r]).sum()).collect()
    }

    /// Columns of a term, one per free gain.
    pub fn columns(&self, term: &Term) -> Vec<Vec<f64>> {
        gather(&self.all_columns(term.kind, &term.shape), &term.free_gains())
    }

    /// Columns of an effect, one per gain.
    pub fn all_columns(&self, kind: TermKind, shape: &[f64; MAX_SHAPE]) -> Vec<Vec<f64>> {
        match kind {
            TermKind::Sensor(sensor) => self.sensor_columns(sensor, shape),
            TermKind::Force(kind) => self.force_columns(kind, shape),
        }
    }

    fn sensor_columns(&self, sensor: &Sensor, shape: &[f64; MAX_SHAPE]) -> Vec<Vec<f64>> {
        let mut out = vec![Vec::with_capacity(self.share.len()); sensor.gains.len()];
        for track in &self.tracks {
            for (column, series) in out.iter_mut().zip((sensor.columns)(track, shape)) {
                track.rows(&track.pass(&series), column);
            }
        }
        out
    }

    fn force_columns(&self, kind: EffectKind, shape: &[f64; MAX_SHAPE]) -> Vec<Vec<f64>> {
        match kind.gains().len() {
            0 | 1 => self.force_lanes::<1>(kind, shape),
            2 => self.force_lanes::<2>(kind, shape),
            3 => self.force_lanes::<3>(kind, shape),
            _ => self.force_lanes::<MAX_GAINS>(kind, shape),
        }
    }

    /// Rows of the force per unit of each of `L` gains.
    fn force_lanes<const L: usize>(&self, kind: EffectKind, shape: &[f64; MAX_SHAPE]) -> Vec<Vec<f64>> {
        let mut out = vec![Vec::with_capacity(self.share.len()); L];
        for (track, series) in self.tracks.iter().zip(self.units::<L>(kind, shape)) {
            track.passed_rows(&series, &mut out);
        }
        out
    }

    /// Force per unit of each of `L` gains at every sample of every track; memory runs through the gaps of a recording.
    pub(crate) fn units<const L: usize>(
        &self,
        kind: EffectKind,
        shape: &[f64; MAX_SHAPE],
    ) -> Vec<Vec<[f64; L]>> {
        let mut memory = [0.0; MAX_MEMORY];
        let mut previous: Option<&Track> = None;
        let mut out = Vec::with_capacity(self.tracks.len());
        for track in &self.tracks {
            match previous {
                Some(last) if last.raw.recording == track.raw.recording => {
                    let gap = track.raw.start - last.time(last.len());
                    let jump = track.x[0] - last.x[last.len() - 1];
                    if gap > 0.0 {
                        let motion =
                            Motion { dt: gap, displacement: jump, velocity: jump / gap, ..motion(track, 0) };
                        kind.unit(shape, &mut memory, &motion);
                    }
                }
                _ => memory = [0.0; MAX_MEMORY],
            }
            let sample = |i: usize| {
                let unit = kind.unit(shape, &mut memory, &motion(track, i));
                std::array::from_fn(|l| if unit[l].is_finite() { unit[l] } else { 0.0 })
            };
            out.push((0..track.len()).map(sample).collect());
            previous = Some(track);
        }
        out
    }
}

/// The motion of sample `i` as a law sees it; the direction is the track's, which does not flicker in noise.
fn motion(track: &Track, i: usize) -> Motion<f64> {
    let displacement = if i > 0 { track.x[i] - track.x[i - 1] } else { 0.0 };
    let speed = track.v[i] * track.sign[i];
    Motion {
        dt: track.raw.dt,
        position: track.x[i],
        displacement,
        velocity: track.sign[i] * speed.max(1e-12),
        applied: track.force_model[i],
        mass: 0.0,
        normal: track.normal.as_ref().map(|n| n[i]),
    }
}

impl Term {
    /// Gains that share one column each.
    pub fn free_gains(&self) -> Vec<Vec<usize>> {
        self.kind.variants().into_iter().nth(self.variant).unwrap_or_default()
    }

    /// The full set of gains from one coefficient per column.
    pub fn spread(&self, coefficients: &[f64]) -> [f64; MAX_GAINS] {
        let mut gains = [0.0; MAX_GAINS];
        for (members, c) in self.free_gains().iter().zip(coefficients) {
            for &m in members {
                gains[m] = *c;
            }
        }
        gains
    }
}

/// Scales of a set of stretches, from which the shapes worth trying follow.
#[derive(Debug, Clone, Copy, Default)]
pub struct Scales {
    /// Length of the recording, s.
    pub duration: f64,
    /// 99 % quantile of |v|.
    pub speed: f64,
    /// Smallest speed at which the direction is known.
    pub slow: f64,
    /// Lowest and highest position.
    pub stroke: (f64, f64),
    /// Smallest length that is resolved.
    pub fine: f64,
    /// 99 % quantile of |F|.
    pub force: f64,
    /// Cut-off of the filter, Hz.
    pub cutoff: f64,
}

impl Scales {
    /// Scales of `tracks` behind a filter at `cutoff` Hz.
    pub fn of(tracks: &[Track], cutoff: f64) -> Self {
        let largest = |of: &dyn Fn(&Track) -> f64| tracks.iter().map(of).fold(0.0, f64::max);
        let magnitude = |series: &[f64]| quantile(&series.iter().map(|x| x.abs()).collect::<Vec<_>>(), 0.99);
        Self {
            duration: largest(&|t| t.len() as f64 * t.raw.dt),
            speed: largest(&|t| magnitude(&t.v)),
            slow: largest(&|t| t.guard()),
            stroke: tracks.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), t| {
                (low.min(quantile(&t.x, 0.002)), high.max(quantile(&t.x, 0.998)))
            }),
            fine: largest(&|t| (rms(&t.v) / (4.0 * cutoff)).min(20.0 * t.noise.position.max(1e-12))),
            force: largest(&|t| magnitude(&t.f)),
            cutoff,
        }
    }

    /// Shortest wavelength of the grid; finer ones are looked for by a scan (`lines`).
    pub fn coarse_wave(&self) -> f64 {
        (self.stroke.1 - self.stroke.0) / 40.0
    }

    /// Shortest wavelength that can be seen: what passes faster than the filter lets through is not there any more.
    pub fn finest_wave(&self) -> f64 {
        (0.7 * self.speed / self.cutoff).max(4.0 * self.fine).min(self.coarse_wave())
    }

    /// Range of values worth trying for a shape parameter, inside what the effect accepts, and whether its
    /// scale is logarithmic.
    pub fn range(&self, parameter: &Parameter) -> (f64, f64, bool) {
        let span = (self.stroke.1 - self.stroke.0).max(1e-300);
        let name = parameter.name;
        let (low, high, log) = match parameter.unit {
            "m/s" | "rad/s" => (0.7 * self.slow, 1.5 * self.speed, true),
            "Hz" => (0.1 * self.cutoff, 2.0 * self.cutoff, true),
            "s" if name == "tau" || name.contains("lag") || name.contains("delay") => {
                (0.5 / (20.0 * self.cutoff), (0.1 * self.duration).min(8.0 / self.cutoff), true)
            }
            "N" | "N·m" => (0.3 * self.force, 0.95 * self.force, false),
            "m" | "rad" if is_wave(name) => (self.finest_wave(), 1.5 * span, true),
            "s" if name.contains("rest") => (1.0 / self.cutoff, 0.3 * self.duration, true),
            "s" => (0.03 * self.duration, self.duration, true),
            "m" | "rad" if name == "x_max" => {
                (self.stroke.0 + 0.6 * span, self.stroke.1 - 0.02 * span, false)
            }
            "m" | "rad" if name == "x_min" => {
                (self.stroke.0 + 0.02 * span, self.stroke.1 - 0.6 * span, false)
            }
            "m" | "rad" if is_place(name) => {
                (self.stroke.0 + 0.05 * span, self.stroke.1 - 0.05 * span, false)
            }
            "m" | "rad" => (self.fine.max(1e-5 * span), 0.3 * span, true),
            "1/m" | "1/rad" => (1.0 / (1.5 * span), 40.0 / span, true),
            _ => (parameter.min, parameter.max, false),
        };
        let (low, high) = (low.max(parameter.min), high.min(parameter.max));
        if low < high { (low, high, log && low > 0.0) } else { (parameter.min, parameter.max, false) }
    }

    /// Shapes to try first for an effect.
    pub fn grid(&self, kind: TermKind) -> Vec<[f64; MAX_SHAPE]> {
        let shape = kind.shape();
        let axis = |p: &Parameter, points: usize| -> Vec<f64> {
            let (low, high, log) = self.range(p);
            let points = if is_wave(p.name) {
                // Even in the number of waves over the stroke, half a wave apart: no line falls between.
                let span = self.stroke.1 - self.stroke.0;
                let (few, many) = ((span / high).max(0.5), span / low.max(self.coarse_wave()));
                return (0..)
                    .map(|i| few + 0.4 * f64::from(i))
                    .take_while(|w| *w <= many)
                    .map(|w| span / w)
                    .collect();
            } else {
                points
            };
            (0..points)
                .map(|i| {
                    let share = if points > 1 { i as f64 / (points - 1) as f64 } else { 0.5 };
                    if log { low * (high / low).powf(share) } else { low + (high - low) * share }
                })
                .collect()
        };
        match shape {
            [] => vec![[0.0; MAX_SHAPE]],
            [one] => axis(one, 12).into_iter().map(|a| [a, 0.0]).collect(),
            [one, two, ..] => {
                let second = axis(two, 3);
                axis(one, 9).into_iter().flat_map(|a| second.iter().map(move |b| [a, *b])).collect()
            }
        }
    }
}

/// Whether a shape parameter is a wavelength.
pub fn is_wave(name: &str) -> bool {
    ["wave", "pitch", "lambda", "period"].iter().any(|s| name.contains(s))
}

fn is_place(name: &str) -> bool {
    name == "x_0"
}
