//! From recordings to gap-free stretches: what the audit found is repaired where that is safe, and said.

use crate::agreement::{Column, compare};
use crate::channel::Channel;
use crate::drift::Drift;
use crate::linear::{Basis, dot};
use crate::options::{Error, LARGEST};
use crate::sensor::delayed;
use crate::signal::{LowPass, derivative, local_noise};
use crate::track::{Channels, differentiated, dominant_frequency};
use crate::wave::Wave;
use crate::witness::hear;
use identify::{Bridged, FaultKind, Geometry, Recording, RecordingFault, audit, bridged, without_outliers};

/// What came in.
#[derive(Debug, Clone)]
pub struct Intake {
    /// Gap-free stretches at a constant rate.
    pub stretches: Vec<Channels>,
    /// What the audit said, of all recordings.
    pub faults: Vec<RecordingFault>,
    /// Names of the recordings.
    pub names: Vec<String>,
    /// Axes rather than slides.
    pub rotary: bool,
    /// Δv of the baseline and its uncertainty, where the recordings show a static branch.
    pub delta_v: Option<(f64, f64)>,
    /// What was wrong with the motion channels of the recordings, and is repaired.
    pub channel: Channel,
    /// Whether, for each recording, an accelerometer has said if there is a wave on the encoder.
    pub witnessed: Vec<bool>,
}

impl Intake {
    /// Takes the origin of each recording off its positions.
    pub fn move_origins(&mut self, origins: &[(usize, Option<(f64, f64)>)]) {
        for (recording, found) in origins {
            let by = found.map_or(0.0, |f| f.0);
            for stretch in self.stretches.iter_mut().filter(|s| s.recording == *recording) {
                stretch.position.iter_mut().for_each(|x| *x -= by);
            }
        }
    }

    /// Speeds below Δv, and a little above it, belong to the static branch from now on.
    pub fn static_branch(&mut self, delta_v: Option<(f64, f64)>) {
        self.delta_v = delta_v;
        for stretch in &mut self.stretches {
            stretch.static_band = delta_v.map_or(0.0, |(value, uncertain)| value + 2.0 * uncertain);
        }
    }
}

impl Intake {
    /// Takes straight lines out of the force channel.
    pub fn take_out(&mut self, drifts: &[Drift]) {
        for d in drifts {
            for s in self.stretches.iter_mut().filter(|s| s.recording == d.recording) {
                for (i, f) in s.force.iter_mut().enumerate() {
                    *f -= d.slope.0 * (s.start + i as f64 * s.dt - d.middle);
                }
            }
            let unit = if self.rotary { "N·m" } else { "N" };
            let why = format!(
                "the zero of the force channel drifts by {:.4} {unit} over {:.1} s (std {:.4}), whichever way the body \
                 moves: a straight line is taken out",
                d.slope.0 * d.duration,
                d.duration,
                d.slope.1 * d.duration
            );
            self.faults.push(RecordingFault::new(FaultKind::ForceDrift, None, why));
        }
    }
}

impl Intake {
    /// Takes a wave off the encoder that an independent channel of one recording does not show, and says so.
    fn straighten(&mut self, stretches: &mut [Channels]) {
        let by_acceleration = hear(stretches, 2, 0);
        let by_velocity = || hear(stretches, 1, 0).and_then(|h| h.wave).map(|w| (w, "velocity"));
        let wave = by_acceleration.and_then(|h| h.wave).map(|w| (w, "acceleration")).or_else(by_velocity);
        self.witnessed.push(wave.is_some() || by_acceleration.is_some_and(|h| h.independent));
        let Some((wave, witness)) = wave else { return };
        let through = witness == "acceleration" && through_the_encoder(&wave, stretches);
        for s in stretches.iter_mut() {
            for x in &mut s.position {
                *x = wave.place(*x);
            }
            let v = smooth_velocity(s);
            if let Some(column) = s.velocity.as_mut().filter(|_| through) {
                for ((shown, x), v) in column.iter_mut().zip(&s.position).zip(v) {
                    *shown -= wave.velocity(*x, v);
                }
            }
        }
        let unit = if self.rotary { "rad" } else { "m" };
        let [(amplitude, of_amplitude), (wavelength, of_wavelength)] = [wave.amplitude, wave.wavelength];
        let why = format!(
            "the position carries a wave of {amplitude:.3e} {unit} (std {of_amplitude:.1e}) over {wavelength:.4e} {unit} \
             (std {of_wavelength:.1e}) that the {witness} column does not show: taken off {}",
            if through { "the position and the velocity" } else { "the position" }
        );
        self.faults.push(RecordingFault::new(FaultKind::EncoderWave, None, why));
        self.channel.encoder = Some(wave);
    }

    /// Whether another channel says more of a wave on the encoder than the force can: the accelerations are then mostly not
    /// the encoder's, and a wave on it would not show in the force as it does where they are.
    pub fn hears_the_encoder(&self, cutoff: f64) -> bool {
        let quieter = |s: &Channels| {
            let noise = |c: &[f64], order| local_noise(c) * differentiated(order, cutoff, s.dt);
            s.acceleration.as_ref().is_some_and(|a| noise(a, 0) < noise(&s.position, 2))
        };
        self.witnessed.iter().all(|w| *w)
            && (self.channel.encoder.is_some() || self.stretches.iter().all(quieter))
    }
}

/// The derivative of the position behind a filter that lets a wave on it through.
fn smooth_velocity(s: &Channels) -> Vec<f64> {
    derivative(&LowPass::new(0.05 / s.dt, s.dt).apply(&s.position), s.dt)
}

/// Whether a velocity column shows the wave too, as the derivative of what the encoder reads.
fn through_the_encoder(wave: &Wave, stretches: &[Channels]) -> bool {
    let (mut along, mut power) = (0.0, 0.0);
    for s in stretches {
        let Some(column) = &s.velocity else { continue };
        let v = smooth_velocity(s);
        let extra: Vec<f64> =
            s.position.iter().zip(&v).map(|(x, v)| wave.velocity(wave.place(*x), *v)).collect();
        let column = LowPass::new(0.05 / s.dt, s.dt).apply(column);
        let basis = Basis::of(&[&v[..], &vec![1.0; v.len()][..]]);
        let away: Vec<f64> = v.iter().zip(&column).map(|(v, c)| v - c).collect();
        let extra = basis.project_out(&extra);
        along += dot(&extra, &away);
        power += dot(&extra, &extra);
    }
    power > 0.0 && along < 0.5 * power
}

/// Lag of a velocity column, in samples, that is undone; a later one is left out.
const MENDED: f64 = 2.0;

impl Intake {
    /// Compares the motion channels of one recording, says what is wrong, and advances a velocity that is late.
    fn mend(&mut self, stretches: &mut [Channels]) {
        let Some(dt) = stretches.first().map(|s| s.dt) else { return };
        let (velocity, acceleration) = compare(stretches);
        if let Some(column) = velocity
            && let Some((lag, _)) = column.late(dt)
        {
            for s in stretches.iter_mut() {
                s.velocity = s.velocity.take().filter(|_| lag <= MENDED * dt).map(|v| delayed(&v, -lag, dt));
            }
            let known =
                self.faults.iter().any(|f| f.kind == FaultKind::HiddenFilter && f.why.contains("velocity"));
            if !known {
                let made = if column.is_backward_difference(dt) { ", a backward difference" } else { "" };
                let done = if lag <= MENDED * dt { "advanced by that" } else { "left out" };
                let why =
                    format!("the velocity column is {:.3} ms behind the position{made}: {done}", 1e3 * lag);
                self.faults.push(RecordingFault::new(FaultKind::HiddenFilter, None, why));
            }
            if !column.is_backward_difference(dt) {
                self.channel.velocity = Some(column);
            }
        }
        if let Some(column) = acceleration.filter(off) {
            let why = format!(
                "the acceleration column is {:.3} (std {:.3}) times the position's second derivative and shows {:.3} (std \
                 {:.3}) at zero: scaled and shifted to agree",
                column.scale.0, column.scale.1, column.zero.0, column.zero.1
            );
            self.faults.push(RecordingFault::new(FaultKind::AccelerationScale, None, why));
            self.channel.acceleration = Some(column);
        }
    }
}

/// Whether scale or zero of an acceleration column are off by more than chance and three percent.
fn off(column: &Column) -> bool {
    let (scale, scale_std) = column.scale;
    let (zero, zero_std) = column.zero;
    (scale - 1.0).abs() > (5.0 * scale_std).max(0.03) || zero.abs() > 8.0 * zero_std
}

impl Intake {
    /// Keeps the moments around reversals, and says so.
    pub fn keep_reversals(&mut self) {
        for stretch in &mut self.stretches {
            stretch.quick = true;
        }
        let why = "the body reverses every few samples: all of them are used, and friction right at a reversal is not \
                   resolved";
        self.faults.push(RecordingFault { kind: FaultKind::QuickReversals, at_s: None, why: why.into() });
    }
}

/// Shortest stretch worth keeping, samples.
const SHORTEST: usize = 64;

/// Audits the recordings and cuts them at gaps and at samples that are not numbers.
pub fn take(recordings: &[Recording]) -> Result<Intake, Error> {
    let first = recordings.first().ok_or(Error::NoRecording)?;
    let rotary = first.geometry == Geometry::Rotary;
    let mut intake = Intake {
        stretches: Vec::new(),
        faults: Vec::new(),
        names: Vec::new(),
        rotary,
        delta_v: None,
        channel: Channel::default(),
        witnessed: Vec::new(),
    };
    let loaded = recordings.iter().find(|r| r.normal_force.is_some());
    for (index, recording) in recordings.iter().enumerate() {
        if let (Some(other), None) = (loaded, &recording.normal_force) {
            return Err(Error::MixedNormalForce { name: recording.name.clone(), other: other.name.clone() });
        }
        if recording.geometry != first.geometry {
            return Err(Error::MixedGeometry { name: recording.name.clone() });
        }
        check_lengths(recording)?;
        intake.names.push(recording.name.clone());
        intake.faults.extend(audit(recording).faults);
        let Bridged { recording: whole, fault, .. } = bridged(&without_outliers(recording));
        intake.faults.extend(fault);
        let mut stretches = cut(&whole, index);
        intake.straighten(&mut stretches);
        intake.mend(&mut stretches);
        for mut stretch in stretches {
            keep_trustworthy(&mut stretch);
            check_sizes(&stretch, &recording.name)?;
            intake.stretches.push(stretch);
        }
    }
    Ok(intake)
}

fn check_lengths(r: &Recording) -> Result<(), Error> {
    let expected = r.time.len();
    let optional = [
        ("velocity", &r.velocity),
        ("acceleration", &r.acceleration),
        ("normal force", &r.normal_force),
        ("reference", &r.reference),
    ];
    let required = [("position", Some(&r.position)), ("force", Some(&r.force))];
    for (channel, series) in required.into_iter().chain(optional.into_iter().map(|(n, s)| (n, s.as_ref()))) {
        if let Some(series) = series
            && series.len() != expected
        {
            return Err(Error::Length { name: r.name.clone(), channel, found: series.len(), expected });
        }
    }
    Ok(())
}

/// Refuses what would overflow: no outlier, as those are gone, but a whole channel of such numbers.
fn check_sizes(c: &Channels, name: &str) -> Result<(), Error> {
    let optional =
        [("velocity", &c.velocity), ("acceleration", &c.acceleration), ("normal force", &c.normal)];
    let required = [("position", Some(&c.position)), ("force", Some(&c.force))];
    for (channel, series) in required.into_iter().chain(optional.map(|(n, s)| (n, s.as_ref()))) {
        let large = |x: &f64| !(x.abs() <= LARGEST);
        if let Some(series) = series
            && let Some(i) = series.iter().position(large)
        {
            let at = c.start + i as f64 * c.dt;
            return Err(Error::TooLarge { name: name.into(), channel, at, value: series[i] });
        }
    }
    Ok(())
}

/// Stretches without a gap, a step backward in time or a value that is not a number.
fn cut(r: &Recording, index: usize) -> Vec<Channels> {
    let mut steps: Vec<f64> =
        r.time.windows(2).map(|w| w[1] - w[0]).filter(|d| d.is_finite() && *d > 0.0).collect();
    steps.sort_by(f64::total_cmp);
    let Some(&dt) = steps.get(steps.len() / 2) else { return Vec::new() };
    // Where the clock is uneven by itself, a sample that comes late is none that is missing: a straight line goes there.
    let near: Vec<f64> = steps.iter().map(|s| s / dt - 1.0).filter(|s| *s < 0.5).collect();
    let uneven = near.iter().map(|s| s * s).sum::<f64>() > 0.05 * 0.05 * near.len() as f64;
    let longest = if uneven { 3.0 } else { 1.6 };
    let good = |i: usize| {
        let optional = [&r.velocity, &r.acceleration, &r.normal_force];
        r.time[i].is_finite()
            && r.position[i].is_finite()
            && r.force[i].is_finite()
            && optional.iter().all(|s| s.as_ref().is_none_or(|s| s[i].is_finite()))
    };
    let mut out = Vec::new();
    let mut start = 0;
    let mut close = |from: usize, to: usize| {
        if to - from >= SHORTEST {
            out.push(uniform(r, index, from, to));
        }
    };
    for i in 0..r.time.len() {
        let breaks = !good(i)
            || i > start && {
                let step = r.time[i] - r.time[i - 1];
                !(step > 0.05 * dt && step < longest * dt)
            };
        if breaks {
            close(start, i);
            start = if good(i) { i } else { i + 1 };
        }
    }
    if start < r.time.len() {
        close(start, r.time.len());
    }
    out
}

/// One stretch on an even grid; a clock that wanders within its steps is interpolated.
fn uniform(r: &Recording, recording: usize, from: usize, to: usize) -> Channels {
    let time = &r.time[from..to];
    let n = time.len();
    let dt = (time[n - 1] - time[0]) / (n - 1) as f64;
    let even = time.iter().enumerate().all(|(i, t)| (t - time[0] - i as f64 * dt).abs() < 0.02 * dt);
    let grid = |series: &[f64]| -> Vec<f64> {
        let series = &series[from..to];
        if even {
            return series.to_vec();
        }
        let mut low = 0;
        (0..n)
            .map(|i| {
                let t = time[0] + i as f64 * dt;
                while low + 2 < n && time[low + 1] < t {
                    low += 1;
                }
                let share = ((t - time[low]) / (time[low + 1] - time[low])).clamp(0.0, 1.0);
                series[low] * (1.0 - share) + series[low + 1] * share
            })
            .collect()
    };
    Channels {
        recording,
        dt,
        start: time[0],
        position: grid(&r.position),
        velocity: r.velocity.as_deref().map(grid),
        acceleration: r.acceleration.as_deref().map(grid),
        force: grid(&r.force),
        normal: r.normal_force.as_deref().map(grid),
        static_band: 0.0,
        quick: false,
        reference: r.reference.as_deref().filter(|s| s.iter().all(|x| x.is_finite())).map(grid),
    }
}

/// Leaves out a velocity channel that is not the derivative of the position, and scales and offsets an
/// accelerometer so that it agrees with it (thesis, 3.5).
fn keep_trustworthy(c: &mut Channels) {
    let cutoff = (4.0 * dominant_frequency(c)).clamp(1e-3 / c.dt, 0.1 / c.dt);
    let filter = LowPass::new(cutoff, c.dt);
    let velocity = derivative(&filter.apply(&c.position), c.dt);
    let settle = filter.settle().min(c.position.len() / 4);
    let inner = settle..c.position.len() - settle;
    let line = |x: &[f64], y: &[f64]| -> Option<(f64, f64, f64)> {
        let n = x.len() as f64;
        let (mx, my) = (x.iter().sum::<f64>() / n, y.iter().sum::<f64>() / n);
        let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
        for (x, y) in x.iter().zip(y) {
            xx += (x - mx) * (x - mx);
            xy += (x - mx) * (y - my);
            yy += (y - my) * (y - my);
        }
        let slope = xy / xx;
        (xx > 0.0 && yy > 0.0).then(|| (slope, my - slope * mx, xy * xy / (xx * yy)))
    };
    if let Some(column) = &c.velocity {
        let filtered = filter.apply(column);
        let agrees = line(&filtered[inner.clone()], &velocity[inner.clone()])
            .is_some_and(|(slope, _, r2)| (slope - 1.0).abs() < 0.02 && r2 > 0.995);
        if !agrees {
            c.velocity = None;
        }
    }
    if let Some(column) = &c.acceleration {
        let acceleration = derivative(&velocity, c.dt);
        let filtered = filter.apply(column);
        match line(&filtered[inner.clone()], &acceleration[inner]) {
            Some((slope, offset, r2)) if r2 > 0.9 && slope > 0.2 && slope < 5.0 => {
                c.acceleration = Some(column.iter().map(|a| slope * a + offset).collect());
            }
            _ => c.acceleration = None,
        }
    }
}
