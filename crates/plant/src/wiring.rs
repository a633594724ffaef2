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
}

impl Wire {
    /// The wiring named `right`, `swapped` or `dead`.
    #[must_use]
    pub fn from_id(id: &str) -> Option<Self> {
        match id {
            "right" => Some(Self::Right),
            "swapped" => Some(Self::Swapped),
            "dead" => Some(Self::Dead),
            _ => None,
        }
    }

    /// Factor on a signal; `None` for a dead one.
    pub(crate) fn pass(self, signal: f64) -> Option<f64> {
        match self {
            Self::Right => Some(signal),
            Self::Swapped => Some(-signal),
            Self::Dead => None,
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
