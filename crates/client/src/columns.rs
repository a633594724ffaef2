//! Columns of a recording and of a live stream: their names, and a sample's values with more digits than any sensor resolves.

use crate::sample::Sample;
use friction::Geometry;

/// Number of columns.
pub(crate) const COUNT: usize = 7;

/// Names, with units. The first is the time.
pub(crate) fn names(geometry: Geometry) -> [&'static str; COUNT] {
    match geometry {
        Geometry::Linear => [
            "time_s",
            "position_m",
            "velocity_m_s",
            "acceleration_m_s2",
            "force_n",
            "command_n",
            "reference_m",
        ],
        Geometry::Rotary => [
            "time_s",
            "position_rad",
            "velocity_rad_s",
            "acceleration_rad_s2",
            "torque_nm",
            "command_nm",
            "reference_rad",
        ],
    }
}

/// Values and their numbers of decimals.
pub(crate) fn values(s: &Sample) -> [(f64, usize); COUNT] {
    [
        (s.time, 6),
        (s.position, 8),
        (s.velocity, 7),
        (s.acceleration, 5),
        (s.force, 6),
        (s.command, 6),
        (s.reference, 8),
    ]
}
