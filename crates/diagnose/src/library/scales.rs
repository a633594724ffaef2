//! Scales of a recording, from which the shapes worth trying follow.

use crate::library::term::TermKind;
use crate::preparation::track::Track;
use friction::effects::{MAX_SHAPE, Parameter, Scale};
use signals::{quantile, rms};

/// Latest that a channel, a drive or a contact reacts, s, and in samples of a slow recording. What seems later than that is
/// something else: one joint of several that follow each other.
const LATEST: f64 = 0.25;
const LATEST_SAMPLES: f64 = 5.0;

/// Ratio of neighbouring lags of a force: pulses so much longer have 9/10 in common.
const LAG_RATIO: f64 = 1.23;

/// Ratio of neighbouring frequencies: from farther away than a narrow resonance is wide, a broad one looks nearer.
const FREQUENCY_RATIO: f64 = 1.12;

/// Length that is resolved beside reversals, as a share of that elsewhere: there a body is slow, and each reversal shows it again.
const AT_A_REVERSAL: f64 = 0.25;

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
    /// The same beside reversals.
    pub turning: f64,
    /// 99 % quantile of |F|.
    pub force: f64,
    /// Cut-off of the filter, Hz.
    pub cutoff: f64,
    /// Time between samples, s.
    pub dt: f64,
}

impl Scales {
    /// Scales of `tracks` behind a filter at `cutoff` Hz.
    pub fn of(tracks: &[Track], cutoff: f64) -> Self {
        let largest = |of: &dyn Fn(&Track) -> f64| tracks.iter().map(of).fold(0.0, f64::max);
        let magnitude = |series: &[f64]| quantile(&series.iter().map(|x| x.abs()).collect::<Vec<_>>(), 0.99);
        let fine = largest(&|t| (rms(&t.v) / (4.0 * cutoff)).min(20.0 * t.noise.position.max(1e-12)));
        let turns = tracks.iter().any(|t| t.reversals.one_way.is_none());
        Self {
            duration: largest(&|t| t.len() as f64 * t.raw.dt),
            speed: largest(&|t| magnitude(&t.v)),
            slow: largest(&|t| t.guard()),
            stroke: tracks.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), t| {
                (low.min(quantile(&t.x, 0.002)), high.max(quantile(&t.x, 0.998)))
            }),
            fine,
            turning: if turns { AT_A_REVERSAL * fine } else { fine },
            force: largest(&|t| magnitude(&t.f)),
            cutoff,
            dt: largest(&|t| t.raw.dt),
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

    fn latest(&self) -> f64 {
        (0.1 * self.duration).min(8.0 / self.cutoff).min(LATEST.max(LATEST_SAMPLES * self.dt))
    }

    /// Range of values worth trying for a shape parameter, inside what the effect accepts, and whether its
    /// scale is logarithmic.
    pub fn range(&self, parameter: &Parameter) -> (f64, f64, bool) {
        let span = (self.stroke.1 - self.stroke.0).max(1e-300);
        let place = |share: u8| {
            let share = f64::from(share) / 100.0;
            // from the nearer end
            if share <= 0.5 { self.stroke.0 + share * span } else { self.stroke.1 - (1.0 - share) * span }
        };
        let (low, high, log) = match parameter.scale {
            Scale::Speed => (0.7 * self.slow, 1.5 * self.speed, true),
            Scale::Frequency => (0.1 * self.cutoff, 2.0 * self.cutoff, true),
            Scale::Lag => (0.5 / (20.0 * self.cutoff), self.latest(), true),
            Scale::Force => (0.3 * self.force, 1.1 * self.force, false),
            Scale::Wavelength => (self.finest_wave(), 1.5 * span, true),
            Scale::Rest => (1.0 / self.cutoff, 0.3 * self.duration, true),
            Scale::Duration => (0.03 * self.duration, self.duration, true),
            Scale::Place { from, to } => (place(from), place(to), false),
            Scale::Distance => (self.turning.max(1e-5 * span), 0.3 * span, true),
            Scale::PerLength => (1.0 / (1.5 * span), 40.0 / span, true),
            Scale::Gain | Scale::Range => (parameter.min, parameter.max, false),
            Scale::Damping => (parameter.min, parameter.max, true),
        };
        let (low, high) = (low.max(parameter.min), high.min(parameter.max));
        if low < high { (low, high, log && low > 0.0) } else { (parameter.min, parameter.max, false) }
    }

    /// Shapes to try first for an effect.
    pub fn grid(&self, kind: TermKind) -> Vec<[f64; MAX_SHAPE]> {
        let shape = kind.shape();
        let axis = |p: &Parameter, points: usize| -> Vec<f64> {
            let (mut low, high, log) = self.range(p);
            // what is shorter still is near enough to be reached from there
            if p.scale == Scale::Distance {
                low = low.max(self.fine).min(high);
            }
            let points = if p.scale == Scale::Wavelength {
                // Even in the number of waves over the stroke, half a wave apart: no line falls between.
                let span = self.stroke.1 - self.stroke.0;
                let (few, many) = ((span / high).max(0.5), span / low.max(self.coarse_wave()));
                return (0..)
                    .map(|i| few + 0.4 * f64::from(i))
                    .take_while(|w| *w <= many)
                    .map(|w| span / w)
                    .collect();
            } else if p.scale == Scale::Lag && matches!(kind, TermKind::Force(_)) {
                // It acts for as long after each reversal: a grid from which another effect looks nearer would name that.
                (1.0 + (high / low).ln() / LAG_RATIO.ln()).ceil() as usize
            } else if p.scale == Scale::Frequency {
                (1.0 + (high / low).ln() / FREQUENCY_RATIO.ln()).ceil() as usize
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
