//! Published figures, each with its source. None of them was recomputed here.

use serde::Serialize;

/// A method and its figures on the tests of a benchmark.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Rival {
    /// What it is.
    pub method: &'static str,
    /// Key of docs/references.md, or what it is known from.
    pub source: &'static str,
    /// Errors in the order of the benchmark's tests, in their unit.
    pub errors: &'static [f64],
}

/// On multisine, arrow, arrow without extrapolation, mV.
pub const SILVERBOX: &[Rival] = &[
    Rival {
        method: "one cubic spring, simulation error",
        source: "reference run of this project",
        errors: &[0.389, 0.563, 0.383],
    },
    Rival { method: "GRU", source: "reported; not traced to a table", errors: &[1.49, 2.80, 0.95] },
];

/// On the pulses, mm.
pub const EMPS: &[Rival] = &[
    Rival { method: "CT-SUBNET", source: "beintema-2023", errors: &[4.61] },
    Rival { method: "LSTM", source: "reported; not traced to a table", errors: &[74.0] },
];
