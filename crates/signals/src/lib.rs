//! Recordings of sliding: in and out, audited, repaired.
//!
//! A [`Recording`] is read from text, JSON, MATLAB, HDF5, Parquet, MCAP or a bag of ROS 2. [`prepare`] makes it ready to be fitted, for everybody: it is
//! [`audit`]ed, repaired ([`without_outliers`], [`bridged`]), cut into gap-free [`Stretch`]es, its channels compared and
//! brought into agreement. What everybody does to a channel is here once: the zero-phase [`LowPass`], differences, noise
//! and quantum. [`estimate_motion`] gives the motion and its covariance at every stamp.
//!
//! Units are SI: s, m, m/s, m/s², N; on a rotary axis rad, rad/s, rad/s², N·m.
#![forbid(unsafe_code)]

mod audit;
mod basis;
mod bridge;
mod error;
pub mod files;
mod filter;
mod formats;
mod noise;
mod planar;
mod prepare;
mod recording;
mod smoother;
mod statistics;
mod stretches;

pub use audit::{
    Audit, FaultKind, Jump, RecordingFault, audit, implausible_mass, jumps, regressed, without_outliers,
};
pub use basis::{Basis, block_products, dot, random_signs, subtract_scaled};
pub use bridge::{Bridged, bridged};
pub use error::{Error, Place};
pub use filter::{
    Design, Filter, Gaussian, Kind, LowPass, Section, central_difference, central_gain, decimate,
    decimation_filter, four_point_difference, soften, white_gain, zero_phase, zero_phase_padded,
};
pub use formats::{Map, ReadOptions, WRITTEN, check_suffix, is_bag};
pub use noise::{Calibration, Source, Sources, calibrate_accelerometer, noise_std, noise_variance, quantum};
pub use planar::{AXES, PlanarPrepared, PlanarRecording, prepare_planar};
pub use prepare::{
    ChannelReport, Channels, Column, Cutoff, Cutoffs, Estimated, Noise, Preparation, Prepared, SHARPER,
    SMEARED, Settings, Wave, WaveReport, choose_cutoff, choose_cutoff_of_fit, derived_noise, differentiated,
    one_way, prepare,
};
pub use recording::{Geometry, Recording};
pub use smoother::{Measured, Motion, Observation, Observed, Smoothed, direction, estimate_motion, smooth};
pub use statistics::{quantile, rms, spread};
pub use stretches::{SHORTEST, Stretch, closed, rms_frequency};
