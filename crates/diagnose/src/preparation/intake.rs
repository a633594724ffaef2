//! Recordings that are diagnosed together: each prepared as everybody has it, checked to belong together.

use crate::findings::channel::Channel;
use crate::free_form::hum::Hum;
use crate::options::{Error, LARGEST};
use crate::preparation::drift::Drift;
use crate::preparation::track::{Reversals, stride};
use crate::search::extra_columns::{self, ExtraColumn};
use friction::Dimension;
use signals::{
    Channels, FaultKind, Geometry, Preparation, Recording, RecordingFault, Settings, choose_cutoff,
    differentiated, noise_std, one_way,
};

/// What came in.
#[derive(Debug, Clone)]
pub struct Intake {
    /// Gap-free stretches at a constant rate.
    pub stretches: Vec<Channels>,
    /// What the audit said, of all recordings.
    pub faults: Vec<RecordingFault>,
    /// Names of the recordings.
    pub names: Vec<String>,
    /// Slides or axes.
    pub geometry: Geometry,
    /// What is known of the reversals.
    pub reversals: Reversals,
    /// Δv of the baseline and its uncertainty, where the recordings show a static branch.
    pub delta_v: Option<(f64, f64)>,
    /// What was wrong with the motion channels of the recordings, and is repaired.
    pub channel: Channel,
    /// What was done to each recording.
    pub reports: Vec<Preparation>,
    /// Further columns of the files.
    pub extra: Vec<ExtraColumn>,
    /// Share of the samples that is fitted: 1, or less of a long recording.
    pub fitted: f64,
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
        self.reversals.static_band = delta_v.map_or(0.0, |(value, uncertain)| value + 2.0 * uncertain);
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
            let unit = Dimension::FORCE.unit(self.geometry);
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
    /// The same without forces that repeat in time.
    pub fn without_hums(&self, hums: &[Hum]) -> Self {
        let mut out = self.clone();
        for s in &mut out.stretches {
            for (i, f) in s.force.iter_mut().enumerate() {
                let time = s.start + i as f64 * s.dt;
                *f -= hums.iter().map(|h| h.force(s.recording, time)).sum::<f64>();
            }
        }
        out
    }
}

impl Intake {
    /// Whether another channel says more of a wave on the encoder than the force can: the accelerations are then mostly not
    /// the encoder's, and a wave on it would not show in the force as it does where they are.
    pub fn has_independent_sensor(&self, cutoff: f64) -> bool {
        let quieter = |s: &Channels| {
            let noise = |c: &[f64], order| noise_std(c) * differentiated(order, cutoff, s.dt);
            s.acceleration.as_ref().is_some_and(|a| noise(a, 0) < noise(&s.position, 2))
        };
        self.witnessed.iter().all(|w| *w)
            && (self.channel.encoder.is_some() || self.stretches.iter().all(quieter))
    }
}

/// Most rows that are fitted. What they tell is known to a thousandth by then; more of them cost time and memory only.
const MOST_ROWS: f64 = 30_000.0;
/// Parts of a longer recording that are fitted, spread evenly over it.
const PARTS: f64 = 60.0;

impl Intake {
    /// Leaves evenly spread parts of recordings that are longer than can be fitted in one piece behind a filter at `cutoff` Hz.
    pub fn thin(&mut self, cutoff: f64) {
        let rows: f64 = self.stretches.iter().map(|s| (s.position.len() / stride(s.dt, cutoff)) as f64).sum();
        if rows <= MOST_ROWS {
            return;
        }
        self.fitted = MOST_ROWS / rows;
        let samples: usize = self.stretches.iter().map(|s| s.position.len()).sum();
        let share = self.fitted;
        let parts = |s: &Channels| -> Vec<Channels> {
            let n = s.position.len();
            let parts = (PARTS * n as f64 / samples as f64).round().max(1.0) as usize;
            let length = (share * n as f64 / parts as f64) as usize;
            (0..parts).map(|k| s.part(k * n / parts..k * n / parts + length)).collect()
        };
        self.stretches = self.stretches.iter().flat_map(parts).collect();
    }
}

impl Intake {
    /// Keeps the moments around reversals, and says so.
    pub fn keep_reversals(&mut self) {
        self.reversals.kept = true;
        let why = "the body reverses every few samples: all of them are used, and friction right at a reversal is not \
                   resolved";
        self.faults.push(RecordingFault { kind: FaultKind::QuickReversals, at_s: None, why: why.into() });
    }
}

/// Prepares the recordings, each as [`signals::prepare`] does.
pub fn take(recordings: &[Recording]) -> Result<Intake, Error> {
    let first = recordings.first().ok_or(Error::NoRecording)?;
    let mut intake = Intake {
        stretches: Vec::new(),
        faults: Vec::new(),
        names: Vec::new(),
        geometry: first.geometry,
        reversals: Reversals::default(),
        delta_v: None,
        reports: Vec::new(),
        extra: extra_columns::of(recordings),
        channel: Channel::default(),
        fitted: 1.0,
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
        let prepared = signals::prepare(recording, &Settings::default())?;
        for mut stretch in prepared.channels {
            check_sizes(&stretch, &recording.name)?;
            stretch.recording = index;
            intake.stretches.push(stretch);
        }
        intake.faults.extend(prepared.faults);
        intake.witnessed.push(prepared.witnessed);
        intake.channel.velocity = prepared.late_velocity.or(intake.channel.velocity);
        intake.channel.acceleration = prepared.off_acceleration.or(intake.channel.acceleration);
        intake.channel.encoder = prepared.wave.or(intake.channel.encoder);
        intake.reports.push(prepared.report);
    }
    intake.reversals.one_way = one_way(&intake.stretches);
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

impl Intake {
    /// Cut-off of the one filter, Hz: `asked`, or one for all recordings together. It is in their reports from then on.
    pub fn cutoff(&mut self, asked: Option<f64>) -> f64 {
        let cutoff = match (asked, &self.reports[..]) {
            (Some(cutoff), _) => cutoff,
            (None, [one]) => one.cutoff_hz.unwrap_or_else(|| choose_cutoff(&self.stretches)),
            (None, _) => choose_cutoff(&self.stretches),
        };
        self.reports.iter_mut().for_each(|r| r.cutoff_hz = r.cutoff_hz.map(|_| cutoff));
        cutoff
    }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_million_samples_took_eight_gigabytes() {
        let samples = 1_000_000;
        let position: Vec<f64> = (0..samples).map(f64::from).collect();
        let force = position.iter().map(|x| -x).collect();
        let time = position.iter().map(|x| 1e-3 * x).collect();
        let recording = Recording { time, position, force, ..Recording::default() };
        let mut intake = take(&[recording]).unwrap();
        let whole = intake.stretches.clone();
        intake.thin(100.0);
        let kept: usize = intake.stretches.iter().map(|s| s.position.len()).sum();
        // one row for four samples
        let rows = kept as f64 / 4.0;
        println!("{} parts, {rows} rows, {:.3} of the samples", intake.stretches.len(), intake.fitted);
        assert!(rows <= MOST_ROWS && rows > 0.99 * MOST_ROWS);
        assert!((kept as f64 / samples as f64 - intake.fitted).abs() < 1e-3);
        // spread over the whole, each at its own time
        let first = &whole[0];
        for (part, next) in intake.stretches.iter().zip(&intake.stretches[1..]) {
            assert!((next.start - part.start - 1000.0 / PARTS).abs() < 0.01);
        }
        for part in &intake.stretches {
            let from = ((part.start - first.start) / first.dt).round() as usize;
            assert_eq!(part.position[..], first.position[from..from + part.position.len()]);
            assert_eq!(part.force[..], first.force[from..from + part.position.len()]);
        }
        // what can be fitted whole is
        let mut short = Intake { stretches: vec![first.part(0..100_000)], fitted: 1.0, ..intake.clone() };
        short.thin(100.0);
        assert_eq!((short.stretches.len(), short.fitted), (1, 1.0));
    }
}
