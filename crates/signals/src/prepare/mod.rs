//! One preparation of a recording for everybody: audited, repaired, cut at its gaps, its channels compared with each other
//! and brought into agreement, and the cut-off of the one filter chosen.
//!
//! Nothing here knows a friction law. What only a fit can tell of a recording (a drifting zero of the force, a lag of
//! the force channel) is found where the fit is.

mod agreement;
mod channels;
mod cutoff;
mod encoder_wave;
mod late;
mod one_way;
mod pulses;
mod report;
mod wave;

pub use agreement::Column;
pub use channels::Channels;
pub use cutoff::{
    Noise, SHARPER, SMEARED, choose_cutoff, choose_cutoff_of_fit, derived_noise, differentiated,
};
pub use one_way::one_way;
pub use report::{ChannelReport, Cutoffs, Estimated, Preparation, WaveReport};
pub use wave::Wave;

use crate::stretches::{Stretch, cut, split, used};
use crate::{
    Basis, Bridged, Error, FaultKind, Geometry, LowPass, Recording, RecordingFault, audit, bridged,
    central_difference, dot, jumps, regressed, without_outliers,
};
use friction::Dimension;
use pulses::LateWhereSlow;
use report::Found;

/// Lag of a column, in samples, that is undone; a later one is left out.
const MENDED: f64 = 2.0;
/// Lag in samples from which on a velocity is late, and an acceleration: an average over the last sample is late by half of one,
/// and a delay of the force of up to a sample is fitted with everything else.
const LATE_VELOCITY: f64 = 0.1;
const LATE_ACCELERATION: f64 = 0.75;

/// Choices of a preparation; the default is right for most recordings.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Leave out outliers and put up to four lost samples in a row in.
    pub repair: bool,
    /// Where the filter cuts.
    pub cutoff: Cutoff,
}

/// How the cut-off of the filter is found.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub enum Cutoff {
    /// By [`choose_cutoff`].
    #[default]
    OfSearch,
    /// By [`choose_cutoff_of_fit`].
    OfFit,
    /// As given, Hz.
    Given(f64),
}

impl Default for Settings {
    fn default() -> Self {
        Self { repair: true, cutoff: Cutoff::default() }
    }
}

/// A recording ready to be fitted.
#[derive(Debug, Clone, PartialEq)]
pub struct Prepared {
    /// Name of the recording.
    pub name: String,
    /// Slide or axis.
    pub geometry: Geometry,
    /// The recording with its short gaps closed, its channels as they were measured.
    pub recording: Recording,
    /// Where each sample of the original is in it.
    pub places: Vec<usize>,
    /// Gap-free stretches of it, at least 64 samples each.
    pub stretches: Vec<Stretch>,
    /// Channels of each stretch on an even grid, in agreement with each other.
    pub channels: Vec<Channels>,
    /// Faults of the recording: what the audit found, and what was repaired.
    pub faults: Vec<RecordingFault>,
    /// The velocity column against the position, where it is late by more than its making.
    pub late_velocity: Option<Column>,
    /// The acceleration column against the position, where scale or zero are off.
    pub off_acceleration: Option<Column>,
    /// The wave that was taken off the position.
    pub wave: Option<Wave>,
    /// Whether an independent channel has said if there is a wave on the encoder.
    pub witnessed: bool,
    /// All of that as it is reported.
    pub report: Preparation,
}

impl Prepared {
    /// Cut-off of the filter, Hz; None where no stretch is left.
    #[must_use]
    pub fn cutoff_hz(&self) -> Option<f64> {
        self.report.cutoff_hz
    }
}

/// Prepares a recording: [`audit`], [`without_outliers`], [`bridged`]; stretches on an even grid; a wave on the encoder
/// taken off; a velocity column advanced by its lag, or left out where it is not the derivative of the position, and checked for
/// a further lag at low speed; an acceleration column scaled and shifted to agree with it, advanced or its low-pass undone, or
/// left out where it does not follow it.
///
/// A recording of which no stretch is long enough has no channels and says so in its faults.
///
/// ```
/// let mut recording = signals::Recording { name: "sine".into(), ..Default::default() };
/// for i in 0..4000 {
///     let t = f64::from(i) * 1e-3;
///     recording.time.push(t);
///     recording.position.push(0.01 * (12.0 * t).sin());
///     recording.force.push(t.cos());
/// }
/// // a velocity column that is 1 ms late
/// let late = |t: &f64| 0.12 * (12.0 * (t - 1e-3)).cos();
/// recording.velocity = Some(recording.time.iter().map(late).collect());
/// let prepared = signals::prepare(&recording, &signals::Settings::default())?;
/// let velocity = &prepared.report.channels["velocity"];
/// assert!(velocity.used && (velocity.lag_s.unwrap().value - 1e-3).abs() < 2e-5);
/// let [stretch] = &prepared.channels[..] else { panic!("one stretch") };
/// assert!((stretch.velocity.as_ref().unwrap()[2000] - 0.12 * 24f64.cos()).abs() < 1e-4);
/// # Ok::<(), signals::Error>(())
/// ```
///
/// # Errors
/// Columns of unequal length; a cut-off that is not above 0 and below half the sampling rate.
pub fn prepare(recording: &Recording, settings: &Settings) -> Result<Prepared, Error> {
    recording.check_lengths()?;
    let audit = audit(recording);
    let mut prepared = Prepared::audited(recording, settings, audit.faults);
    prepared.channels = prepared.stretches.iter().map(|s| Channels::of(&prepared.recording, s)).collect();
    let recorded = prepared.channels.clone();
    prepared.straighten();
    let (velocity, acceleration) = prepared.bring_into_agreement();
    prepared.report = Found {
        name: &prepared.name,
        geometry: prepared.geometry,
        samples: recording.len(),
        sample_period: audit.sample_period,
        recorded: &recorded,
        used: &prepared.channels,
        velocity,
        acceleration,
        wave: prepared.wave,
        faults: &prepared.faults,
    }
    .report();
    if let Some(slowest) = prepared.channels.iter().map(|c| c.dt).reduce(f64::max) {
        if let Cutoff::Given(cutoff) = settings.cutoff {
            crate::Filter::butterworth(4, cutoff, slowest)?;
        }
        let cutoffs = choose_cutoff_of_fit(&prepared.channels)
            .map(|fit| Cutoffs { search: choose_cutoff(&prepared.channels), fit });
        prepared.report.cutoffs_hz = cutoffs;
        prepared.report.cutoff_hz = cutoffs.map(|chosen| match settings.cutoff {
            Cutoff::Given(cutoff) => cutoff,
            Cutoff::OfSearch => chosen.search,
            Cutoff::OfFit => chosen.fit,
        });
    }
    Ok(prepared)
}

impl Prepared {
    /// A stretch that is prepared already, as a recording of its own; the filter cuts at `cutoff_hz`. Without stretches
    /// where it has fewer than 64 samples.
    #[must_use]
    pub fn of_stretch(channels: Channels, geometry: Geometry, cutoff_hz: f64) -> Self {
        let c = &channels;
        let recording = Recording {
            geometry,
            time: (0..c.len()).map(|i| i as f64 * c.dt).collect(),
            position: c.position.clone(),
            force: c.force.clone(),
            velocity: c.velocity.clone(),
            acceleration: c.acceleration.clone(),
            normal_force: c.normal.clone(),
            ..Recording::default()
        };
        let mut prepared =
            Self::audited(&recording, &Settings { repair: false, ..Settings::default() }, Vec::new());
        prepared.report.cutoff_hz = Some(cutoff_hz);
        prepared.channels = prepared.stretches.iter().map(|_| channels.clone()).collect();
        prepared
    }

    /// The repaired recording and its stretches.
    fn audited(recording: &Recording, settings: &Settings, mut faults: Vec<RecordingFault>) -> Self {
        let Bridged { recording, places, fault } = if settings.repair {
            let mut mended = without_outliers(recording);
            if let Some((even, _)) = regressed(&mended) {
                mended.time = even;
            }
            bridged(&mended)
        } else {
            Bridged { recording: recording.clone(), places: (0..recording.len()).collect(), fault: None }
        };
        faults.extend(fault);
        let mut stretches =
            recording.sample_period().map_or_else(Vec::new, |dt| cut(&recording.time, &used(&recording), dt));
        if settings.repair {
            // a motion across a jump is none that a body made
            let at: Vec<usize> = jumps(&recording, &stretches).iter().map(|j| j.index).collect();
            stretches = split(&recording.time, stretches, &at);
        }
        Self {
            name: recording.name.clone(),
            geometry: recording.geometry,
            recording,
            places,
            stretches,
            channels: Vec::new(),
            faults,
            late_velocity: None,
            off_acceleration: None,
            wave: None,
            witnessed: false,
            report: Preparation::default(),
        }
    }

    /// Takes a wave off the encoder that an independent channel does not show, and says so.
    fn straighten(&mut self) {
        let by_acceleration = encoder_wave::compare_channels(&self.channels, 2, 0);
        let by_velocity = || {
            let comparison = encoder_wave::compare_channels(&self.channels, 1, 0);
            comparison.and_then(|h| h.wave).map(|w| (w, "velocity"))
        };
        let wave = by_acceleration.and_then(|h| h.wave).map(|w| (w, "acceleration")).or_else(by_velocity);
        self.witnessed = wave.is_some() || by_acceleration.is_some_and(|h| h.independent);
        let Some((wave, witness)) = wave else { return };
        let through = witness == "acceleration" && through_the_encoder(&wave, &self.channels);
        for s in &mut self.channels {
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
        let unit = Dimension::LENGTH.unit(self.geometry);
        let [(amplitude, of_amplitude), (wavelength, of_wavelength)] = [wave.amplitude, wave.wavelength];
        let why = format!(
            "the position carries a wave of {amplitude:.3e} {unit} (std {of_amplitude:.1e}) over {wavelength:.4e} {unit} \
             (std {of_wavelength:.1e}) that the {witness} column does not show: taken off {}",
            if through { "the position and the velocity" } else { "the position" }
        );
        self.faults.push(RecordingFault::new(FaultKind::EncoderWave, None, why));
        self.wave = Some(wave);
    }

    /// Compares velocity and acceleration columns with the position, mends what is late, corrects an acceleration, and leaves
    /// out what does not agree. Returns the comparisons.
    fn bring_into_agreement(&mut self) -> (Option<Column>, Option<Column>) {
        let Some(dt) = self.channels.first().map(|c| c.dt) else { return (None, None) };
        let (velocity, acceleration) = agreement::compare(&self.channels);
        if let Some(column) = velocity {
            let is_late =
                self.mend_late("velocity", &column, LATE_VELOCITY, dt, late::velocity, |s| s.velocity = None);
            if is_late && !column.is_backward_difference(dt) {
                self.late_velocity = Some(column);
            }
        }
        if !velocity.is_some_and(|c| c.is_the_derivative()) {
            self.channels.iter_mut().for_each(|s| s.velocity = None);
        } else if let Some(slow) = LateWhereSlow::of(&self.channels) {
            self.channels.iter_mut().for_each(|s| s.late_below = Some(slow.below));
            let why = slow.says(self.geometry);
            self.faults.push(RecordingFault::new(FaultKind::HiddenFilter, None, why));
        }
        match acceleration.filter(Column::follows) {
            Some(column) => {
                if column.differs() {
                    let corrected = |a: &mut f64| *a = (*a - column.zero.0) / column.scale.0;
                    self.channels
                        .iter_mut()
                        .flat_map(|s| s.acceleration.as_mut())
                        .flatten()
                        .for_each(corrected);
                }
                self.mend_late("acceleration", &column, LATE_ACCELERATION, dt, late::acceleration, |s| {
                    s.acceleration = None
                });
            }
            None => self.channels.iter_mut().for_each(|s| s.acceleration = None),
        }
        if let Some(column) = acceleration.filter(Column::is_off) {
            let why = format!(
                "the acceleration column is {:.3} (std {:.3}) times the position's second derivative and shows {:.3} (std \
                 {:.3}) at zero: {}",
                column.scale.0,
                column.scale.1,
                column.zero.0,
                column.zero.1,
                if column.follows() { "scaled and shifted to agree" } else { "left out" }
            );
            self.faults.push(RecordingFault::new(FaultKind::AccelerationScale, None, why));
            self.off_acceleration = Some(column);
        }
        (velocity, acceleration)
    }

    /// Mends a column that is late by at least `least` and at most two samples with `mend`, which says how, leaves a later one out,
    /// and says so; whether it is late.
    fn mend_late(
        &mut self,
        name: &str,
        column: &Column,
        least: f64,
        dt: f64,
        mend: impl Fn(&mut [Channels], f64) -> &'static str,
        leave_out: impl Fn(&mut Channels),
    ) -> bool {
        let Some(lag) = column.late(least * dt) else { return false };
        let done = if lag > MENDED * dt {
            self.channels.iter_mut().for_each(leave_out);
            "left out"
        } else {
            mend(&mut self.channels, lag)
        };
        let is_known = |f: &RecordingFault| f.kind == FaultKind::HiddenFilter && f.why.contains(name);
        if !self.faults.iter().any(is_known) {
            let made = if column.is_backward_difference(dt) { ", a backward difference" } else { "" };
            let why = format!("the {name} column is {:.3} ms behind the position{made}: {done}", 1e3 * lag);
            self.faults.push(RecordingFault::new(FaultKind::HiddenFilter, None, why));
        }
        true
    }
}

/// The derivative of the position behind a filter that lets a wave on it through.
fn smooth_velocity(s: &Channels) -> Vec<f64> {
    central_difference(&LowPass::new(0.05 / s.dt, s.dt).apply(&s.position), s.dt)
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
