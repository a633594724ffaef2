//! Mistakes of wiring, and what is put on the rig's sensors on the bench.

/// How one signal is wired.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Wire {
    /// As it should be.
    #[default]
    Right,
    /// Two wires exchanged: the sign is wrong.
    Swapped,
    /// No contact: a sensor stays where it is (analogue: at the code of zero, without noise), an amplifier gives nothing.
    Dead,
}

impl Wire {
    /// By its name: `right`, `swapped`, `dead`.
    #[must_use]
    pub fn from_id(id: &str) -> Option<Self> {
        match id {
            "right" => Some(Self::Right),
            "swapped" => Some(Self::Swapped),
            "dead" => Some(Self::Dead),
            _ => None,
        }
    }

    /// What becomes of a signal; `None` when nothing does.
    pub(crate) fn pass(self, signal: f64) -> Option<f64> {
        match self {
            Self::Right => Some(signal),
            Self::Swapped => Some(-signal),
            Self::Dead => None,
        }
    }
}

/// The signals of the rig.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Wiring {
    /// Quadrature channels; exchanged they count backwards.
    pub encoder: Wire,
    /// Load cell.
    pub load: Wire,
    /// Accelerometer.
    pub accel: Wire,
    /// Motor amplifier.
    pub amplifier: Wire,
}

/// What a person does to the sensors for a calibration, the slide being locked. The motion does not notice it.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Bench {
    /// Weight hung on the load cell in the direction of positive force, N.
    pub weight: f64,
    /// Component of gravity along the accelerometer's axis that it reads, m/s²: ±9.80665 standing on either end.
    pub gravity: f64,
}
