//! The rows of the table of laws, in the order in which `examples/laws.rs` times them.

/// Every law that the crate has, with what distinguishes two rows of one law.
pub const NAMES: [&str; 23] = [
    "viscous",
    "coulomb",
    "classic",
    "karnopp",
    "majd_simaan",
    "armstrong",
    "dahl",
    "dahl, exponent 1.5",
    "lugre",
    "elasto_plastic",
    "generalised_maxwell_slip",
    "hayward_armstrong, stick_slide",
    "hayward_armstrong, stick_slip_slide",
    "hayward_armstrong, stick_creep_slip_slide",
    "planar karnopp",
    "planar coulomb, no grain",
    "planar coulomb",
    "planar dahl",
    "planar lugre",
    "planar elasto_plastic",
    "bristle, 10 bonds",
    "bristle, 20 bonds",
    "bristle, 50 bonds",
];
/// Words of a row: mean and worst cycles.
pub const COLUMNS: usize = 2;
/// What stands behind the rows when they are complete.
pub const DONE: u32 = 0x600d_c0de;
