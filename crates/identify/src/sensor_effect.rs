//! Effects of sensors and drive that a model carries beside its physics, by their ids in the catalogue. A device that
//! renders the model leaves them out; a prediction of a recording needs them.

use crate::dynamics::{first_order_lag, load_in_play, load_on_spring};
use crate::four_point_difference;
use crate::predict::Kinematics;
use friction::{Invalid, in_range};

macro_rules! effects {
    ($($(#[$doc:meta])* $variant:ident $id:literal {
        $($(#[$what:meta])* $field:ident: $min:literal to $max:literal,)*
    })*) => {
        /// An effect that sits in a sensor or the drive. F_m is the force of the model.
        #[derive(Debug, Clone, Copy, PartialEq)]
        pub enum SensorEffect {
            $($(#[$doc])* $variant { $($(#[$what])* $field: f64,)* },)*
        }

        impl SensorEffect {
            /// Every id that a model can carry, with the names of its parameters. (`offset` and `time_skew` have places
            /// of their own in [`crate::Nuisances`].)
            pub const ALL: &'static [(&'static str, &'static [&'static str])] =
                &[$(($id, &[$(stringify!($field),)*]),)*];

            /// The effect with this id from its parameters by name. None for an id that is not in
            /// [`SensorEffect::ALL`], or a parameter that `value` does not have.
            #[must_use]
            pub fn from_parts(id: &str, value: impl Fn(&str) -> Option<f64>) -> Option<Self> {
                match id {
                    $($id => Some(Self::$variant { $($field: value(stringify!($field))?,)* }),)*
                    _ => None,
                }
            }

            /// Id, and parameters with their names, in the order of [`SensorEffect::ALL`].
            #[must_use]
            pub fn parts(&self) -> (&'static str, Vec<(&'static str, f64)>) {
                match *self {
                    $(Self::$variant { $($field,)* } => ($id, vec![$((stringify!($field), $field),)*]),)*
                }
            }

            /// Checks every parameter against its range.
            ///
            /// # Errors
            /// The first that is out of range, by its name in `model.toml`.
            pub fn validate(&self) -> Result<(), Invalid> {
                match *self {
                    $(Self::$variant { $($field,)* } => {
                        $(in_range(concat!($id, ".", stringify!($field)), $field, $min, $max)?;)*
                    })*
                }
                Ok(())
            }
        }
    };
}

effects! {
    /// F = F_m + command·T·dF_m/dt + channel·(F_m behind 1/(T·s + 1) − F_m), T = lag: a recorded command that runs ahead
    /// of the force, or a force channel that lags.
    ActuatorLag "actuator_lag" {
        /// Share of the force that follows a recorded command.
        command: 0.0 to 2.0,
        /// Share of the force that its channel shows late.
        channel: 0.0 to 2.0,
        /// Time constant, s.
        lag: 1e-5 to 0.5,
    }
    /// F = F_m + force·(sgn v(t − lag) − sgn v(t)).
    VelocityLag "velocity_lag" {
        /// Coulomb level seen through the lag, N.
        force: -1e6 to 1e6,
        /// Lag, s.
        lag: 0.0 to 0.2,
    }
    /// F = F_m + gain·max(F_m, 0).
    ForceGainAsymmetry "force_gain_asymmetry" {
        /// Extra gain for positive force.
        gain: -1.0 to 1.0,
    }
    /// F = F_m + share·(|F_m| − limit)₊·sgn F_m.
    Saturation "saturation" {
        /// Minus the share of the excess that is cut.
        share: -2.0 to 2.0,
        /// Where it begins, N.
        limit: 1e-9 to 1e9,
    }
    /// F = F_m + d²/dt² (cosine·cos(2πx/wavelength) + sine·sin(2πx/wavelength)).
    EncoderEccentricity "encoder_eccentricity" {
        /// Amplitude of the cosine times the mass, N·s².
        cosine: -1e9 to 1e9,
        /// Amplitude of the sine times the mass, N·s².
        sine: -1e9 to 1e9,
        /// Travel per turn of the encoder, m.
        wavelength: 1e-6 to 100.0,
    }
    /// F = F_m + mass·(a₂ − a), a₂ = a behind the resonance of a load on a spring: two masses.
    Compliance "compliance" {
        /// Mass of the load, kg.
        mass: 0.0 to 1e6,
        /// At which the load would swing with the drive held, Hz.
        frequency: 0.1 to 1e4,
        /// Damping ratio of that.
        damping: 0.02 to 0.6,
    }
    /// F = F_m + mass·(a₂ − a), a₂ = the acceleration of a load that flies freely within a play and is caught at its ends.
    Backlash "backlash" {
        /// Mass of the load, kg.
        mass: 0.0 to 1e6,
        /// Play, m.
        gap: 1e-7 to 1.0,
    }
}

impl SensorEffect {
    /// What it adds to the model's force, N, at every sample.
    pub(crate) fn added(&self, model: &[f64], motion: &Kinematics<'_>) -> Vec<f64> {
        let dt = motion.dt;
        let slope = |series: &[f64]| four_point_difference(series, dt);
        match *self {
            Self::ActuatorLag { command, channel, lag } => {
                let rate = slope(model);
                let slow = first_order_lag(model, lag, dt);
                (0..model.len()).map(|i| command * lag * rate[i] + channel * (slow[i] - model[i])).collect()
            }
            Self::VelocityLag { force, lag } => {
                let sign: Vec<f64> =
                    motion.velocity.iter().map(|v| if *v == 0.0 { 0.0 } else { v.signum() }).collect();
                delayed(&sign, lag, dt).iter().zip(&sign).map(|(late, s)| force * (late - s)).collect()
            }
            Self::ForceGainAsymmetry { gain } => model.iter().map(|f| gain * f.max(0.0)).collect(),
            Self::Saturation { share, limit } => {
                model.iter().map(|f| share * (f.abs() - limit).max(0.0) * f.signum()).collect()
            }
            Self::EncoderEccentricity { cosine, sine, wavelength } => {
                let wave = |x: &f64| {
                    let (s, c) = (std::f64::consts::TAU * x / wavelength).sin_cos();
                    cosine * c + sine * s
                };
                slope(&slope(&motion.position.iter().map(wave).collect::<Vec<f64>>()))
            }
            Self::Compliance { mass, frequency, damping } => {
                let drive = motion.acceleration;
                let load = load_on_spring(drive, frequency, damping, dt);
                load.iter().zip(drive).map(|(load, a)| mass * (load - a)).collect()
            }
            Self::Backlash { mass, gap } => {
                let load = load_in_play(motion.position, gap, dt);
                load.iter().zip(motion.acceleration).map(|(load, a)| mass * (load - a)).collect()
            }
        }
    }
}

/// `series` later by `delay` s, interpolated; its ends are held.
pub(crate) fn delayed(series: &[f64], delay: f64, dt: f64) -> Vec<f64> {
    let Some(last) = series.len().checked_sub(1).filter(|_| delay != 0.0) else { return series.to_vec() };
    (0..=last)
        .map(|i| {
            let at = (i as f64 - delay / dt).clamp(0.0, last as f64);
            let low = at.floor() as usize;
            let share = at - low as f64;
            series[low] * (1.0 - share) + series[(low + 1).min(last)] * share
        })
        .collect()
}
