//! From a recording to signals that can be fitted: velocity and acceleration behind one stated zero-phase filter.
//!
//! Every sample of the recording is kept, in its place, so that a prediction has the recording's own times. What a fit
//! compares are *rows*: [`Signals::condition`] takes a column over every sample (the force, or any regressor built
//! from velocity and acceleration) through the same filter, leaves out gaps and their edges, and decimates. Behind
//! one linear filter on both sides, a model that is linear in its parameters stays exactly linear.

use crate::errors::Variances;
use crate::unfiltered::{Unfiltered, motion};
use signals::{
    Channels, Cutoff, Error, Filter, Geometry, LowPass, Preparation, Prepared, Recording, RecordingFault,
    SHORTEST, Settings, Source, Sources, Stretch, calibrate_accelerometer, central_difference, central_gain,
    closed, decimation_filter, four_point_difference, noise_variance, white_gain, zero_phase_padded,
};
use std::ops::Range;

/// How signals are made from a recording.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Preprocess {
    /// The default, as [`signals::prepare`] gives it: force and regressors pass the zero-phase low-pass; velocity and
    /// acceleration are taken from one cut 1.5 times higher, each from its column if that is in agreement with the
    /// position and has the smaller error, from the position by four-point differences otherwise.
    Tribos {
        /// Cut-off, Hz. None: by [`signals::choose_cutoff_of_fit`].
        cutoff_hz: Option<f64>,
    },
    /// As published for the EMPS benchmark (Janot, Gautier, Brunot 2019): position behind a 4th-order Butterworth at
    /// 0.2 of Nyquist (100 Hz at 1 kHz) forward and backward, central differences, the first 49 samples dropped, then
    /// every column decimated by 10 behind a 0.05 dB Chebyshev filter of order 8, ends continued as MATLAB does.
    Emps,
    /// As in [thesis, ch. 3.5]: velocity and acceleration columns as they were measured, the accelerometer calibrated
    /// against four-point differences of the velocity; no filter.
    Thesis,
}

impl Default for Preprocess {
    fn default() -> Self {
        Self::Tribos { cutoff_hz: None }
    }
}

/// Signals of equal length, one value for each sample of the recording, no NaN among them; by [`Preprocess::Tribos`] of the
/// recording with its short gaps closed ([`signals::bridged`]). Between gap-free stretches
/// holes of the columns are closed by straight lines, and velocity and acceleration are 0: no row is made of that.
#[derive(Debug, Clone, PartialEq)]
pub struct Signals {
    /// Name of the recording.
    pub name: String,
    /// Slide or axis.
    pub geometry: Geometry,
    /// Time between samples, s.
    pub dt: f64,
    /// s.
    pub time: Vec<f64>,
    /// m or rad.
    pub position: Vec<f64>,
    /// m/s or rad/s.
    pub velocity: Vec<f64>,
    /// m/s² or rad/s².
    pub acceleration: Vec<f64>,
    /// As recorded, N or N·m.
    pub force: Vec<f64>,
    /// As recorded, N.
    pub normal_force: Option<Vec<f64>>,
    stretches: Vec<Stretch>,
    /// Where each sample of the recording is.
    places: Vec<usize>,
    force_full: Vec<f64>,
    /// Of each stretch.
    channels: Vec<Channels>,
    rows: Rows,
    errors: (Variances, Variances),
    preparation: Preparation,
    description: String,
}

/// What is not known of the motion, for each sample.
pub(crate) struct Uncertain {
    /// 1 − E\[sgn v\]², of the direction.
    pub unknown: Vec<f64>,
    /// Standard deviation of the velocity, m/s or rad/s.
    pub velocity: Vec<f64>,
    /// Standard deviation of the acceleration, m/s² or rad/s².
    pub acceleration: Vec<f64>,
}

/// A filter between samples and rows.
#[derive(Debug, Clone, PartialEq)]
enum RowFilter {
    LowPass(LowPass),
    /// Its padding beside it.
    Published(Filter, usize),
}

/// From samples to rows.
#[derive(Debug, Clone, PartialEq, Default)]
struct Rows {
    filter: Option<RowFilter>,
    /// Samples dropped in front of the filter, at the beginning of a stretch.
    drop_first: usize,
    /// Samples dropped behind it, at both ends.
    trim: usize,
    /// 1 keeps every sample.
    decimation: usize,
}

impl Signals {
    /// Standard deviation of the velocity's error behind the filter, m/s or rad/s.
    pub(crate) fn velocity_error(&self) -> f64 {
        self.errors.0.velocity.sqrt()
    }

    /// What the smoothed motion does not know of itself. Between stretches nothing is known.
    pub(crate) fn uncertain(&self) -> Uncertain {
        let mut out = Uncertain {
            unknown: vec![1.0; self.len()],
            velocity: vec![f64::NAN; self.len()],
            acceleration: vec![f64::NAN; self.len()],
        };
        for (stretch, channels) in self.stretches.iter().zip(&self.channels) {
            let motion = channels.motion();
            let std = |of: &dyn Fn(usize) -> f64| stretch.back((0..motion.len()).map(of).collect());
            let unknown = motion.direction().iter().map(|e| 1.0 - e * e).collect();
            let places = out.unknown[stretch.range.clone()].iter_mut();
            for (place, u) in places.zip(stretch.back(unknown)) {
                *place = u.clamp(0.0, 1.0);
            }
            for (series, made) in [
                (&mut out.velocity, std(&|i| motion.velocity_std(i))),
                (&mut out.acceleration, std(&|i| motion.acceleration_std(i))),
            ] {
                for (place, s) in series[stretch.range.clone()].iter_mut().zip(made) {
                    *place = s.max(0.0);
                }
            }
        }
        out
    }

    /// Number of samples.
    #[must_use]
    pub fn len(&self) -> usize {
        self.time.len()
    }

    /// The samples of each stretch: where velocity and acceleration are known.
    pub(crate) fn ranges(&self) -> impl Iterator<Item = Range<usize>> {
        self.stretches.iter().map(|s| s.range.clone())
    }

    /// A series of these samples, not a number where velocity and acceleration are not known.
    pub(crate) fn known(&self, series: &[f64]) -> Vec<f64> {
        let mut out = vec![f64::NAN; series.len()];
        for range in self.ranges() {
            out[range.clone()].copy_from_slice(&series[range]);
        }
        out
    }

    /// A series of these samples at those of the recording.
    pub(crate) fn at_recorded(&self, series: &[f64]) -> Vec<f64> {
        self.places.iter().map(|at| series[*at]).collect()
    }

    /// No samples at all; [`prepare`] never returns that.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.time.is_empty()
    }

    /// Takes a column over every sample to rows: through the filter of the fit, without gaps and their edges,
    /// decimated. The force and every regressor go through it alike.
    #[must_use]
    pub fn condition(&self, column: &[f64]) -> Vec<f64> {
        let mut out = Vec::new();
        for stretch in &self.stretches {
            let part = column.get(stretch.range.clone()).unwrap_or(&[]);
            let part = part.get(self.rows.drop_first..).unwrap_or(&[]);
            let filtered = match &self.rows.filter {
                Some(RowFilter::LowPass(low_pass)) => low_pass.apply(part),
                Some(RowFilter::Published(filter, padding)) => zero_phase_padded(filter, part, *padding),
                None => part.to_vec(),
            };
            let (n, step) = (filtered.len(), self.rows.decimation.max(1));
            // MATLAB's `decimate` keeps the last sample of the series, not the first.
            let first = (n + step - 1) % step;
            let trim = self.rows.trim.min(n / 8);
            out.extend(filtered[trim..n - trim].iter().skip(first).step_by(step));
        }
        out
    }

    /// The force at every sample behind the filter that velocity and acceleration are behind: what can be compared
    /// with them sample by sample.
    #[must_use]
    pub fn force_full(&self) -> &[f64] {
        &self.force_full
    }

    /// What a delay of the force adds to it per second; None behind a published procedure, which has no delay.
    pub(crate) fn late(&self) -> Option<Vec<f64>> {
        let Some(RowFilter::LowPass(_)) = self.rows.filter else { return None };
        let mut late = vec![0.0; self.len()];
        for range in self.ranges() {
            let rate = four_point_difference(&self.force_full[range.clone()], self.dt);
            late[range].iter_mut().zip(rate).for_each(|(late, rate)| *late = -rate);
        }
        Some(late)
    }

    /// The motion without the filter, with an acceleration whose error is about `tolerated`, m/s² or rad/s².
    pub(crate) fn unfiltered(&self, tolerated: f64) -> Unfiltered {
        motion(self.len(), &self.stretches, &self.channels, tolerated)
    }

    /// Samples over which the filter of velocity and acceleration blurs a corner of the motion; 0 without a filter.
    pub(crate) fn blurred(&self) -> usize {
        let fraction = match &self.rows.filter {
            Some(RowFilter::LowPass(low_pass)) => 2.0 * low_pass.cutoff() * self.dt,
            Some(RowFilter::Published(filter, _)) => filter.design().cutoff,
            None => return 0,
        };
        // half a period of its cut-off
        (1.0 / (WIDER * fraction)).ceil() as usize
    }

    /// Rows are samples: no filter, no decimation.
    #[must_use]
    pub fn keeps_every_sample(&self) -> bool {
        self.rows.filter.is_none()
    }

    /// Variance of the errors of velocity and acceleration: of the signals, and of the rows.
    pub(crate) fn error_variances(&self) -> (Variances, Variances) {
        self.errors
    }

    /// Faults of the recording: what the audit found, and what was repaired.
    #[must_use]
    pub fn recording_faults(&self) -> Vec<RecordingFault> {
        self.preparation.faults.clone()
    }

    /// What was done to the recording before.
    #[must_use]
    pub fn preparation(&self) -> &Preparation {
        &self.preparation
    }

    /// What was done, in words.
    #[must_use]
    pub fn description(&self) -> String {
        self.description.clone()
    }
}

/// Makes signals of a recording.
///
/// # Errors
/// Columns of unequal length, no clock, no stretch of 64 samples without a gap, a cut-off that is not accepted, or a
/// column that the method needs and that is not there.
pub fn prepare(recording: &Recording, how: &Preprocess) -> Result<Signals, Error> {
    let repair = matches!(how, Preprocess::Tribos { .. });
    let cutoff = match how {
        Preprocess::Tribos { cutoff_hz: Some(cutoff) } => Cutoff::Given(*cutoff),
        _ => Cutoff::OfFit,
    };
    signals_of(signals::prepare(recording, &Settings { repair, cutoff })?, how)
}

/// Makes signals of a recording that is prepared already, by [`Preprocess::Tribos`] behind the cut-off of that preparation.
///
/// # Errors
/// As [`prepare`].
pub fn signals_of(mut prepared: Prepared, how: &Preprocess) -> Result<Signals, Error> {
    let refuse = |name: &str, why: String| Error::Recording { recording: name.into(), why };
    let Some(dt) = prepared.recording.sample_period() else {
        let why = format!("{} samples give no sampling period", prepared.recording.len());
        return Err(refuse(&prepared.name, why));
    };
    let needed = if *how == Preprocess::Emps { 200 } else { SHORTEST };
    let longest = prepared.stretches.iter().map(|s| s.range.len()).max().unwrap_or(0);
    prepared.stretches.retain(|s| s.range.len() >= needed);
    prepared.channels.retain(|c| c.len() >= needed);
    if prepared.stretches.is_empty() {
        let why = format!("the longest stretch without a gap has {longest} samples, {needed} are needed");
        return Err(refuse(&prepared.name, why));
    }
    let dt = if prepared.stretches.len() == 1 { prepared.stretches[0].dt } else { dt };
    let filled = |column: &[f64]| closed(column).unwrap_or_else(|| vec![0.0; column.len()]);
    let Prepared { recording, places, stretches, channels, report, .. } = prepared;
    let position = filled(&recording.position);
    let zeros = vec![0.0; position.len()];
    let mut signals = Signals {
        name: recording.name.clone(),
        geometry: recording.geometry,
        dt,
        time: filled(&recording.time),
        velocity: zeros.clone(),
        acceleration: zeros,
        force: filled(&recording.force),
        normal_force: recording.normal_force.as_deref().map(filled),
        force_full: Vec::new(),
        position,
        stretches,
        places,
        channels,
        rows: Rows { decimation: 1, ..Rows::default() },
        errors: Default::default(),
        preparation: report,
        description: String::new(),
    };
    signals.force_full = signals.force.clone();
    match how {
        Preprocess::Tribos { cutoff_hz } => tribos(&mut signals, cutoff_hz.is_some())?,
        Preprocess::Emps => emps(&mut signals)?,
        Preprocess::Thesis => thesis(&recording, &mut signals)?,
    }
    Ok(signals)
}

impl Signals {
    /// Replaces what is in the stretches by what `make` makes of the channels of each; what is between them stays.
    fn fill(&mut self, pick: fn(&mut Self) -> &mut Vec<f64>, make: impl Fn(&Channels) -> Vec<f64>) {
        for (index, stretch) in self.stretches.clone().into_iter().enumerate() {
            let made = stretch.back(make(&self.channels[index]));
            if let Some(place) = pick(self).get_mut(stretch.range.clone())
                && place.len() == made.len()
            {
                place.copy_from_slice(&made);
            }
        }
    }
}

fn emps(signals: &mut Signals) -> Result<(), Error> {
    let dt = signals.dt;
    let noise = noise_variance(&signals.position);
    // published with the position alone
    for c in &mut signals.channels {
        (c.velocity, c.acceleration) = (None, None);
    }
    let low_pass = Filter::butterworth(4, 0.1 / dt, dt)?;
    let filtered = |column: &[f64]| zero_phase_padded(&low_pass, column, 12);
    let slope = |series: &[f64], dt| central_difference(series, dt);
    signals.fill(|s| &mut s.position, |c| filtered(&c.position));
    signals.fill(|s| &mut s.velocity, |c| slope(&filtered(&c.position), c.dt));
    signals.fill(|s| &mut s.acceleration, |c| slope(&slope(&filtered(&c.position), c.dt), c.dt));
    signals.fill(|s| &mut s.force_full, |c| filtered(&c.force));
    let decimation = decimation_filter(10)?;
    let gain = |order: i32, rows: bool| {
        noise
            * white_gain(|f| {
                let row = if rows { decimation.gain(f).powi(2) } else { 1.0 };
                low_pass.gain(f).powi(2) * central_gain(f, dt).powi(order) * row
            })
    };
    signals.errors = (
        Variances { velocity: gain(1, false), acceleration: gain(2, false), force_rate: 0.0 },
        Variances { velocity: gain(1, true), acceleration: gain(2, true), force_rate: 0.0 },
    );
    signals.rows =
        Rows { filter: Some(RowFilter::Published(decimation, 24)), drop_first: 49, trim: 0, decimation: 10 };
    signals.description = format!(
        "as published for EMPS: position behind a zero-phase 4th-order Butterworth at {:.4} Hz, central differences, \
         first 49 samples dropped, all columns decimated by 10 behind a zero-phase 0.05 dB Chebyshev of order 8",
        0.1 / dt
    );
    Ok(())
}

fn thesis(recording: &Recording, signals: &mut Signals) -> Result<(), Error> {
    let needed = |name: &str| Error::Recording {
        recording: recording.name.clone(),
        why: format!("no column {name}; the thesis's procedure needs it, the default (tribos) does not"),
    };
    let rotary = recording.geometry == Geometry::Rotary;
    let pick = |linear, axis| if rotary { axis } else { linear };
    let velocity =
        recording.velocity.as_deref().ok_or_else(|| needed(pick("velocity_m_s", "velocity_rad_s")))?;
    let reading = recording
        .acceleration
        .as_deref()
        .ok_or_else(|| needed(pick("acceleration_m_s2", "acceleration_rad_s2")))?;
    let (scale, offset, said) = calibrated(signals, velocity, reading).unwrap_or((
        1.0,
        0.0,
        "the accelerometer does not follow the velocity and is taken as it is".into(),
    ));
    signals.velocity = closed(velocity).unwrap_or_default();
    let acceleration: Vec<f64> = reading.iter().map(|a| scale * a + offset).collect();
    signals.acceleration = closed(&acceleration).unwrap_or_default();
    for (stretch, channels) in signals.stretches.iter().zip(&mut signals.channels) {
        channels.velocity.get_or_insert_with(|| stretch.grid(&signals.velocity));
        channels.acceleration = Some(stretch.grid(&signals.acceleration));
    }
    let errors = Variances {
        velocity: noise_variance(&signals.velocity),
        acceleration: noise_variance(&signals.acceleration),
        force_rate: 0.0,
    };
    signals.errors = (errors, errors);
    signals.description = format!("as in the thesis: measured velocity and acceleration, no filter; {said}");
    Ok(())
}

/// Scale and offset of the accelerometer over the longest stretch, and what to say about it.
fn calibrated(signals: &Signals, velocity: &[f64], reading: &[f64]) -> Option<(f64, f64, String)> {
    let stretch = signals.stretches.iter().max_by_key(|s| s.range.len())?;
    let found = calibrate_accelerometer(&stretch.grid(reading), &stretch.grid(velocity), stretch.dt)?;
    if !(found.r_squared > 0.5 && found.scale > 0.0) {
        return None;
    }
    let by = format!("scale {:.4} (std {:.4}), offset {:.4}", found.scale, found.scale_std, found.offset);
    // An accelerometer that agrees already is left alone: a correction would only add its own error.
    if (found.scale - 1.0).abs() < 3.0 * found.scale_std && found.offset.abs() < 3.0 * found.offset_std {
        let said = format!("accelerometer as it is: it agrees with the differentiated velocity ({by})");
        return Some((1.0, 0.0, said));
    }
    let said = format!("accelerometer brought into agreement with the differentiated velocity ({by})");
    Some((found.scale, found.offset, said))
}

/// Cut-off of the filter of velocity and acceleration over that of the rows.
const WIDER: f64 = 1.5;

fn tribos(signals: &mut Signals, asked: bool) -> Result<(), Error> {
    let dt = signals.dt;
    let longest = signals.channels.iter().max_by_key(|c| c.len());
    let (Some(longest), Some(cutoff)) = (longest, signals.preparation.cutoff_hz) else { return Ok(()) };
    let noise = Sources {
        dt,
        position: noise_variance(&longest.position),
        velocity: longest.velocity.as_deref().map(noise_variance),
        acceleration: longest.acceleration.as_deref().map(noise_variance),
    };
    // its rate is derived as a velocity is from a position
    let force = Sources { dt, position: noise_variance(&longest.force), velocity: None, acceleration: None };
    let rows = LowPass::new(cutoff, dt);
    let wide = LowPass::new(WIDER * cutoff, dt);
    let (_, velocity_from) = noise.velocity(&wide);
    let (_, acceleration_from) = noise.acceleration(&wide);
    let low = |column: &[f64], c: &Channels| LowPass::new(WIDER * cutoff, c.dt).apply(column);
    let slope = |series: &[f64], c: &Channels| four_point_difference(series, c.dt);
    signals.fill(|s| &mut s.position, |c| low(&c.position, c));
    signals.fill(|s| &mut s.force_full, |c| low(&c.force, c));
    signals.fill(
        |s| &mut s.velocity,
        |c| match (velocity_from, &c.velocity) {
            (Source::Velocity, Some(v)) => low(v, c),
            _ => slope(&low(&c.position, c), c),
        },
    );
    signals.fill(
        |s| &mut s.acceleration,
        |c| match (acceleration_from, &c.velocity, &c.acceleration) {
            (Source::Column, _, Some(a)) => low(a, c),
            (Source::Velocity, Some(v), _) => slope(&low(v, c), c),
            _ => slope(&slope(&low(&c.position, c), c), c),
        },
    );
    let both = |f: f64| wide.gain(f) * rows.gain(f);
    let wide_only = |f: f64| wide.gain(f);
    signals.errors = (
        Variances {
            velocity: noise.of_velocity(velocity_from, wide_only),
            acceleration: noise.of_acceleration(acceleration_from, wide_only),
            force_rate: force.of_velocity(Source::Position, wide_only),
        },
        Variances {
            velocity: noise.of_velocity(velocity_from, both),
            acceleration: noise.of_acceleration(acceleration_from, both),
            force_rate: force.of_velocity(Source::Position, both),
        },
    );
    signals.description = format!(
        "force and regressors behind a zero-phase 4th-order Butterworth at {cutoff:.4} Hz ({}); velocity {}, \
         acceleration {}, behind the same at {:.4} Hz",
        if asked {
            "as asked"
        } else {
            "the acceleration's error is at most 5 % there, or the bound of the choice"
        },
        velocity_from.words("measured"),
        acceleration_from.words("measured"),
        wide.cutoff()
    );
    // an edge has died out to one part in a thousand after twice the samples over which it swings
    signals.rows = Rows {
        trim: 2 * rows.settle(),
        filter: Some(RowFilter::LowPass(rows)),
        drop_first: 0,
        decimation: 1,
    };
    Ok(())
}
