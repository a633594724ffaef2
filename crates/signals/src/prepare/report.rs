//! What was done to a recording before anything was fitted, as `preparation` in the JSON of an identification and of a
//! diagnosis.

use super::agreement::Column;
use super::channels::Channels;
use super::wave::Wave;
use crate::{Geometry, RecordingFault, noise_std, quantum};
use friction::Dimension;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// A number and its standard deviation.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Estimated {
    /// Estimate.
    pub value: f64,
    /// Standard deviation.
    pub std: f64,
}

impl From<(f64, f64)> for Estimated {
    fn from((value, std): (f64, f64)) -> Self {
        Self { value, std }
    }
}

/// One channel of a recording.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ChannelReport {
    /// Unit of the channel, and of all below but lag and scale.
    pub unit: String,
    /// It is used. A velocity that is not the derivative of the position, or too late for it, is not.
    pub used: bool,
    /// Standard deviation of its white noise; at least quantum/√12.
    pub noise: f64,
    /// Step it is quantised in; 0 where it is continuous.
    pub quantum: f64,
    /// Lag behind the position, s; a used channel was advanced by it where it stands out of its error.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lag_s: Option<Estimated>,
    /// Times what the position says.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub scale: Option<Estimated>,
    /// What it shows at zero.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub zero: Option<Estimated>,
}

/// Cut-offs that a recording asks for, Hz. A search for what is missing and the fit of one law need different ones.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Cutoffs {
    /// By [`crate::choose_cutoff`].
    pub search: f64,
    /// By [`crate::choose_cutoff_of_fit`].
    pub fit: f64,
}

/// A wave on the encoder's reading, taken off.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct WaveReport {
    /// m or rad.
    pub amplitude: Estimated,
    /// m or rad.
    pub wavelength: Estimated,
}

/// The preparation of one recording.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Preparation {
    /// Name of the recording.
    pub recording: String,
    /// Samples of the recording.
    pub samples: usize,
    /// Samples in gap-free stretches that are long enough to be used, those that were put into short gaps included.
    pub used: usize,
    /// Number of these stretches.
    pub stretches: usize,
    /// Median time between samples, s.
    pub sample_period_s: Option<f64>,
    /// The filter, in words.
    pub filter: String,
    /// Its cut-off as it was used, Hz; None where no stretch is left.
    pub cutoff_hz: Option<f64>,
    /// Cut-offs chosen for this recording, whichever was used.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cutoffs_hz: Option<Cutoffs>,
    /// Channels by name: `position`, `velocity`, `acceleration`, `force`, `normal_force`.
    pub channels: BTreeMap<String, ChannelReport>,
    /// A wave on the encoder that an independent channel does not show.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub encoder_wave: Option<WaveReport>,
    /// Faults of the recording: what the audit found, and what was repaired.
    pub faults: Vec<RecordingFault>,
}

/// The filter of the default preparation.
const FILTER: &str = "4th-order Butterworth, forward and backward";

/// Channels as they were recorded and as they are used, and what was found about them.
pub(super) struct Found<'a> {
    pub name: &'a str,
    pub geometry: Geometry,
    pub samples: usize,
    pub sample_period: Option<f64>,
    pub recorded: &'a [Channels],
    pub used: &'a [Channels],
    pub velocity: Option<Column>,
    pub acceleration: Option<Column>,
    pub wave: Option<Wave>,
    pub faults: &'a [RecordingFault],
}

impl Found<'_> {
    /// The report, without cut-offs.
    pub fn report(&self) -> Preparation {
        Preparation {
            recording: self.name.into(),
            samples: self.samples,
            used: self.used.iter().map(Channels::len).sum(),
            stretches: self.used.len(),
            sample_period_s: self.sample_period,
            filter: FILTER.into(),
            cutoff_hz: None,
            cutoffs_hz: None,
            channels: self.channels(),
            encoder_wave: self
                .wave
                .map(|w| WaveReport { amplitude: w.amplitude.into(), wavelength: w.wavelength.into() }),
            faults: self.faults.to_vec(),
        }
    }

    /// Noise and quantum are those of the longest stretch.
    fn channels(&self) -> BTreeMap<String, ChannelReport> {
        let pairs = self.recorded.iter().zip(self.used);
        let Some((recorded, used)) = pairs.max_by_key(|(c, _)| c.len()) else { return BTreeMap::new() };
        let plain = |dimension: Dimension, column: &Vec<f64>| ChannelReport {
            unit: dimension.unit(self.geometry).to_string(),
            used: true,
            noise: noise_std(column),
            quantum: quantum(column),
            lag_s: None,
            scale: None,
            zero: None,
        };
        let compared = |dimension, column: &Vec<f64>, used, found: Option<Column>| ChannelReport {
            used,
            lag_s: found.map(|c| c.lag.into()),
            scale: found.map(|c| c.scale.into()),
            zero: found.map(|c| c.zero.into()),
            ..plain(dimension, column)
        };
        let velocity = recorded
            .velocity
            .as_ref()
            .map(|column| compared(Dimension::VELOCITY, column, used.velocity.is_some(), self.velocity));
        let acceleration = recorded.acceleration.as_ref().map(|column| {
            compared(Dimension::ACCELERATION, column, used.acceleration.is_some(), self.acceleration)
        });
        [
            ("position", Some(plain(Dimension::LENGTH, &recorded.position))),
            ("velocity", velocity),
            ("acceleration", acceleration),
            ("force", Some(plain(Dimension::FORCE, &recorded.force))),
            ("normal_force", recorded.normal.as_ref().map(|column| plain(Dimension::LOAD, column))),
        ]
        .into_iter()
        .filter_map(|(name, channel)| Some((name.to_string(), channel?)))
        .collect()
    }
}
