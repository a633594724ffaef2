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
#[cfg(feature = "ros2")]
mod bag_io;
mod basis;
mod bridge;
mod calibrate;
#[cfg(feature = "ros2")]
mod cdr;
mod columns;
mod csv_io;
mod denoise;
mod error;
mod expression;
pub mod files;
mod filter;
mod formats;
mod gains;
#[cfg(feature = "hdf5")]
mod hdf5_io;
mod json_io;
mod limits;
mod low_pass;
mod mat_io;
#[cfg(feature = "ros2")]
mod mcap_io;
mod naming;
mod noise;
#[cfg(feature = "parquet")]
mod parquet_io;
mod prepare;
mod recording;
mod signatures;
mod smoother;
mod sources;
mod statistics;
mod stored;
mod stretches;
#[cfg(feature = "parquet")]
mod thrift;
#[cfg(feature = "ros2")]
mod topics;
mod units;
mod variables;

pub use audit::{
    Audit, FaultKind, Jump, RecordingFault, audit, implausible_mass, jumps, regressed, without_outliers,
};
pub use basis::{Basis, dot, random_signs, subtract_scaled};
pub use bridge::{Bridged, bridged};
pub use calibrate::{Calibration, calibrate_accelerometer};
pub use denoise::{Measured, Smoothed, smooth};
pub use error::{Error, Place};
pub use expression::Map;
pub use filter::{
    Design, Filter, Kind, Section, central_difference, decimate, decimation_filter, four_point_difference,
    zero_phase, zero_phase_padded,
};
pub use formats::{ReadOptions, WRITTEN, check_suffix, is_bag};
pub use gains::{central_gain, white_gain};
pub use low_pass::LowPass;
pub use noise::{noise_std, noise_variance, quantum};
pub use prepare::{
    ChannelReport, Channels, Column, Cutoff, Estimated, Noise, Preparation, Prepared, Settings, Wave,
    WaveReport, choose_cutoff, choose_cutoff_of_fit, derived_noise, differentiated, prepare,
};
pub use recording::{Geometry, Recording};
pub use smoother::{Motion, Observation, Observed, direction, estimate_motion};
pub use sources::{Source, Sources};
pub use statistics::{quantile, rms, spread};
pub use stretches::{SHORTEST, Stretch, closed, rms_frequency};
