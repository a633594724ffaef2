//! Wiring errors, and loads on the sensors during a calibration.

/// Wiring of one signal.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Wire {
    /// Correct.
    #[default]
    Right,
    /// Two wires exchanged: wrong sign.
    Swapped,
    /// No contact. A sensor keeps its value (analogue: the code of zero, without noise); an amplifier gives no force.
    Dead,
    /// No contact at the input of a converter that floats: the code of zero, with the noise of the sensor. Elsewhere as
    /// [`Wire::Dead`].
    Floating,
}

impl Wire {
    /// The wiring named `right`, `swapped`, `dead` or `floating`.
    #[must_use]
    pub fn from_id(id: &str) -> Option<Self> {
        match id {
            "right" => Some(Self::Right),
            "swapped" => Some(Self::Swapped),
            "dead" => Some(Self::Dead),
            "floating" => Some(Self::Floating),
            _ => None,
        }
    }

    /// What becomes of a signal; `None` without contact.
    pub(crate) fn pass(self, signal: f64) -> Option<f64> {
        match self {
            Self::Right => Some(signal),
            Self::Swapped => Some(-signal),
            Self::Dead | Self::Floating => None,
        }
    }

    /// What a converter sees of a signal with this noise.
    pub(crate) fn sense(self, signal: f64, noise: f64) -> f64 {
        match self {
            Self::Floating => noise,
            _ => self.pass(signal + noise).unwrap_or(0.0),
        }
    }
}

/// Wiring of the rig.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Wiring {
    /// Quadrature channels. Exchanged, they count backwards.
    pub encoder: Wire,
    /// Load cell.
    pub load: Wire,
    /// Accelerometer.
    pub accel: Wire,
    /// Motor amplifier.
    pub amplifier: Wire,
}

/// Loads on the sensors during a calibration, with the slide locked. They do not act on the motion.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Bench {
    /// Weight on the load cell in the direction of positive force, N.
    pub weight: f64,
    /// Gravity along the axis of the accelerometer, m/s²: ±9.80665 when it stands on either end.
    pub gravity: f64,
}
