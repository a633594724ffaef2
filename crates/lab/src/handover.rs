//! From a recording to the handle in three steps: what is recorded is diagnosed, and what was found is rendered. Shows how the
//! friction force differs before and after.
//!
//! ```text
//! record ──▶ diagnose ──▶ send ──▶ felt
//!   ▲            │ refused: why        │
//!   └────────────┴─────────────────────┘ a new recording starts over
//! ```

use client::Sample;
use design::{Change, LeftOut};
use friction::effects::{Effect, EffectName};
use haptics::Device;
use haptics::Settings;
use haptics::settings::PARAMETERS;
use serde::Serialize;

/// Bins over speed, half of them on either side of zero.
pub const SPEED_BINS: usize = 80;
/// Bins over the stroke.
pub const POSITION_BINS: usize = 160;
/// Largest speed shown on the default device, m/s.
const FASTEST: f32 = 0.1;
/// Speed at which the forces before and after are compared, on the default device, m/s.
const COMPARED: f32 = 0.031;
/// Samples of a bin that is shown.
const ENOUGH: u32 = 20;
/// Samples of a bin after which older ones count half.
const MEMORY: u32 = 2_000;
/// Time in which a hand has taken hold, s.
const TAKES_HOLD: f64 = 1.0;
/// Share of the largest force below which nothing is felt.
const FAINT: f32 = 0.005;

/// A parameter that the device takes at its bound.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Moved {
    /// Name as typed.
    pub name: String,
    /// As found.
    pub found: f32,
    /// As sent.
    pub sent: f32,
    /// Unit of both.
    pub unit: String,
    /// Reason.
    pub why: String,
}

impl Moved {
    pub(crate) fn of(change: Change, device: &Device) -> Self {
        let dimension = change.why.dimension;
        Self {
            name: change.parameter,
            found: change.from,
            sent: change.to,
            unit: dimension.map_or_else(String::new, |d| d.unit(device.geometry).to_string()),
            why: change.why.words.to_owned(),
        }
    }
}

/// A parameter that differs between the active preset and the one to send.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Difference {
    /// Name as typed.
    pub name: String,
    /// Unit; empty for a choice.
    pub unit: String,
    /// Value on the device; empty if the device does not have the effect.
    pub before: String,
    /// Value to send; `off` for an effect that was not found.
    pub after: String,
}

/// Mean force, N, at each of a row of places; none where there are too few samples.
pub type Curve = Vec<Option<f32>>;

/// A friction force over speed and over position.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Curves {
    /// At each of [`Handover::speeds`].
    pub over_speed: Curve,
    /// At each of [`Handover::positions`], moving in the positive direction.
    pub over_position: Curve,
}

/// Steps of the handover.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Step {
    /// Nothing is recorded.
    #[default]
    Record,
    /// A recording waits to be diagnosed.
    Diagnose,
    /// What was found can be sent.
    Send,
    /// Nothing can be sent.
    Refused,
    /// It is on its way to the device.
    Sending,
    /// The device lists what was sent.
    Sent,
}

/// State of the handover as the pages show it.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Handover {
    /// What comes next.
    pub step: Step,
    /// Recording of the first step.
    pub recording: Option<String>,
    /// Answer of the diagnosis, one sentence.
    pub summary: String,
    /// Reason why nothing can be sent.
    pub refused: String,
    /// Report of the diagnosis.
    pub report: Option<String>,
    /// Active preset when it was sent.
    pub before_name: String,
    /// Parameters that change.
    pub differences: Vec<Difference>,
    /// Parameters at a bound of the device.
    pub moved: Vec<Moved>,
    /// What is not sent.
    pub left_out: Vec<LeftOut>,
    /// Warning of the device.
    pub warning: Option<String>,
    /// Speeds of the curves, m/s.
    pub speeds: Vec<f32>,
    /// Positions of the curves, m.
    pub positions: Vec<f32>,
    /// Index in `speeds` at which before and after are compared.
    pub compared: usize,
    /// Force of the preset before.
    pub before: Curves,
    /// Force of the preset sent.
    pub after: Curves,
    /// Force on the recorded body.
    pub recorded: Curves,
    /// Force commanded while the preset before was rendered.
    pub felt_before: Curves,
    /// Force commanded since the preset was sent.
    pub felt: Curves,
}

impl Handover {
    /// A finished recording waits for its diagnosis.
    pub(crate) fn recorded(name: String, device: &Device) -> Self {
        let (speeds, positions) = (speeds(device), positions(device));
        let wanted = device.speed(COMPARED);
        let compared = speeds.iter().position(|speed| *speed >= wanted).unwrap_or(0);
        Self { step: Step::Diagnose, recording: Some(name), speeds, positions, compared, ..Self::default() }
    }

    /// Whether this is a force that a hand would notice at any speed.
    pub(crate) fn is_felt(&self, device: &Device) -> bool {
        let curves = [&self.after.over_speed, &self.after.over_position];
        curves.into_iter().flatten().flatten().any(|force| force.abs() > FAINT * device.force_max)
    }
}

/// Middle of bin `k` of `count` between −`most` and `most`.
fn middle(k: usize, count: usize, most: f32) -> f32 {
    most * ((2 * k + 1) as f32 / count as f32 - 1.0)
}

fn speeds(device: &Device) -> Vec<f32> {
    (0..SPEED_BINS).map(|k| middle(k, SPEED_BINS, device.speed(FASTEST))).collect()
}

fn positions(device: &Device) -> Vec<f32> {
    (0..POSITION_BINS).map(|k| middle(k, POSITION_BINS, 0.5 * device.stroke)).collect()
}

/// Sums over the samples of a bin.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Bin {
    force: f64,
    acceleration: f64,
    count: u32,
}

/// Mean force and acceleration of samples, by speed and by position.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Bins {
    speed_max: f64,
    reach: f64,
    over_speed: Vec<Bin>,
    over_position: Vec<Bin>,
    /// Time and velocity of the last sample.
    last: Option<(f64, f64)>,
    /// Longest time between samples that follow each other, s.
    gap: f64,
    /// Time from the first sample that is not counted, s.
    skipped: f64,
    /// Time of the first sample.
    from: Option<f64>,
}

impl Bins {
    pub fn new(device: &Device, sample_period: f64) -> Self {
        Self {
            speed_max: f64::from(device.speed(FASTEST)),
            reach: f64::from(0.5 * device.stroke),
            over_speed: vec![Bin::default(); SPEED_BINS],
            over_position: vec![Bin::default(); POSITION_BINS],
            last: None,
            gap: 1.5 * sample_period,
            skipped: 0.0,
            from: None,
        }
    }

    /// Bins of a handle in a hand, which jerks it at first.
    pub fn in_a_hand(self) -> Self {
        Self { skipped: TAKES_HOLD, ..self }
    }

    /// Adds a sample with the force on the body, N.
    pub fn push(&mut self, sample: &Sample, force: f64) {
        let last = self.last.replace((sample.time, sample.velocity));
        let Some((time, velocity)) = last.filter(|(time, _)| sample.time - time <= self.gap) else { return };
        let step = sample.time - time;
        if step <= 0.0 {
            return;
        }
        if sample.time - *self.from.get_or_insert(sample.time) < self.skipped {
            return;
        }
        let acceleration = (sample.velocity - velocity) / step;
        let place = |x: f64, most: f64, count: usize| {
            let at = (x / most + 1.0) * 0.5 * count as f64;
            (at >= 0.0 && at < count as f64).then_some(at as usize)
        };
        let add = |bin: Option<&mut Bin>| {
            if let Some(bin) = bin {
                bin.force += force;
                bin.acceleration += acceleration;
                bin.count += 1;
                if bin.count >= MEMORY {
                    *bin = Bin {
                        force: 0.5 * bin.force,
                        acceleration: 0.5 * bin.acceleration,
                        count: bin.count / 2,
                    };
                }
            }
        };
        add(place(sample.velocity, self.speed_max, SPEED_BINS).and_then(|k| self.over_speed.get_mut(k)));
        if sample.velocity > 0.05 * self.speed_max {
            let at = place(sample.position, self.reach, POSITION_BINS);
            add(at.and_then(|k| self.over_position.get_mut(k)));
        }
    }

    /// The force without the inertia of `mass`, kg.
    pub fn curves(&self, mass: f64) -> Curves {
        let curve = |bins: &[Bin]| {
            let mean = |bin: &Bin| {
                let friction = (bin.force - mass * bin.acceleration) / f64::from(bin.count);
                (bin.count >= ENOUGH && friction.is_finite()).then(|| rounded(friction as f32))
            };
            bins.iter().map(mean).collect()
        };
        Curves { over_speed: curve(&self.over_speed), over_position: curve(&self.over_position) }
    }
}

/// A force to a tenth of a millinewton: the message stays short.
pub(crate) fn rounded(force: f32) -> f32 {
    (1e4 * force).round() / 1e4
}

/// Every parameter of these settings: name, unit and value.
fn listed(settings: &Settings, device: &Device) -> Vec<(String, String, String)> {
    let mut all = Vec::new();
    let mut push = |name: String, unit: String| {
        if let Some(value) = settings.get(&name) {
            all.push((name, unit, value.to_string()));
        }
    };
    for p in PARAMETERS {
        let unit = p.unit(device.geometry).map_or_else(String::new, |unit| unit.to_string());
        push(p.name.to_owned(), unit);
    }
    for (effect, Effect { kind, .. }) in EffectName::of(settings.effects.iter().flatten()) {
        for p in kind.gains().iter().chain(kind.shape()) {
            push(format!("{effect}.{}", p.name), p.dimension.unit(device.geometry).to_string());
        }
    }
    all
}

/// What must be set to come from one preset to another. Effects are switched off first: places for them are few.
#[must_use]
pub fn differences(from: &Settings, to: &Settings, device: &Device) -> Vec<Difference> {
    let (before, after) = (listed(from, device), listed(to, device));
    let kept: Vec<EffectName> = EffectName::of(to.effects.iter().flatten()).map(|(name, _)| name).collect();
    let gone = EffectName::of(from.effects.iter().flatten()).filter(|(old, _)| !kept.contains(old));
    let off = gone.map(|(effect, _)| Difference {
        name: effect.to_string(),
        unit: String::new(),
        before: "on".into(),
        after: "off".into(),
    });
    let set = after.iter().filter_map(|(name, unit, value)| {
        let old = before.iter().find(|(known, ..)| known == name).map_or("", |(.., old)| old);
        (old != value).then(|| Difference {
            name: name.clone(),
            unit: unit.clone(),
            before: old.to_owned(),
            after: value.clone(),
        })
    });
    off.chain(set).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::verdict;

    #[test]
    fn differences_lead_from_any_preset_to_any_other() {
        let device = Device::default();
        let mut patterned = Settings::teflon();
        for (name, value) in [("cogging.sine_1", "0.5"), ("cogging.wavelength", "0.006"), ("mass", "0.02")] {
            patterned.set(name, value).expect("known");
        }
        let mut presets: Vec<Settings> = Settings::PRESETS.iter().map(|(_, make)| make()).collect();
        presets.extend([patterned, Settings::forced_choice()]);
        for from in &presets {
            for to in &presets {
                let lines = differences(from, to, &device);
                let changes: Vec<_> = lines.iter().map(|d| (d.name.clone(), d.after.clone())).collect();
                let steps = verdict::steps(from, &device, &changes).expect("an order");
                let mut now = *from;
                steps.iter().for_each(|(name, value)| now.set(name, value).expect("taken"));
                assert_eq!(differences(&now, to, &device), [], "the same preset");
            }
        }
    }

    #[test]
    fn inertia_is_taken_off_the_force_of_a_moved_body() {
        let device = Device::default();
        let mut bins = Bins::new(&device, 1e-3);
        let (amplitude, rate, mass, level) = (0.01, std::f64::consts::TAU, 0.5, 2.0);
        // a quarter of a period, in which the body only slows down
        for k in (0..10_000).filter(|k| k % 1_000 < 250) {
            let time = f64::from(k) * 1e-3;
            let (sin, cos) = (rate * time).sin_cos();
            let (position, velocity) = (amplitude * sin, amplitude * rate * cos);
            let force = level - mass * amplitude * rate * rate * sin;
            bins.push(&Sample { time, position, velocity, ..Sample::default() }, force);
        }
        let shown = Handover::recorded("rec-001.csv".into(), &device);
        let at = |mass: f64| f64::from(bins.curves(mass).over_speed[shown.compared].expect("enough samples"));
        println!("{} N with inertia, {} N without", at(0.0), at(mass));
        assert!((at(0.0) - level).abs() > 0.1 && (at(mass) - level).abs() < 1e-3);
        assert_eq!(bins.curves(mass).over_speed[0], None, "never as fast");
        assert_eq!((shown.step, shown.speeds.len()), (Step::Diagnose, SPEED_BINS));
    }
}
