//! Columns of a recording with their names in files.

use signals::{Geometry, Recording};

/// One signal of a recording.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Column<'a> {
    /// Name without unit: `position`.
    pub signal: &'static str,
    /// Name with unit, as in a CSV header: `position_m`.
    pub name: &'static str,
    /// Unit as people write it.
    pub unit: &'static str,
    /// One value a sample.
    pub values: &'a [f64],
}

/// All signals except time, in the order of a CSV header.
pub(crate) fn columns(recording: &Recording) -> Vec<Column<'_>> {
    let rotary = recording.geometry == Geometry::Rotary;
    let pick = |linear: (&'static str, &'static str), turning: (&'static str, &'static str)| {
        if rotary { turning } else { linear }
    };
    let (position, velocity, acceleration) = (
        pick(("position_m", "m"), ("position_rad", "rad")),
        pick(("velocity_m_s", "m/s"), ("velocity_rad_s", "rad/s")),
        pick(("acceleration_m_s2", "m/s²"), ("acceleration_rad_s2", "rad/s²")),
    );
    let force = pick(("force_n", "N"), ("torque_nm", "N·m"));
    let mut out = Vec::new();
    let mut push = |signal, (name, unit), values| out.push(Column { signal, name, unit, values });
    push("position", position, &recording.position);
    let optional = [
        ("velocity", velocity, &recording.velocity),
        ("acceleration", acceleration, &recording.acceleration),
    ];
    for (signal, name, values) in optional {
        if let Some(values) = values {
            push(signal, name, values);
        }
    }
    push(if rotary { "torque" } else { "force" }, force, &recording.force);
    let optional = [
        ("normal_force", ("normal_force_n", "N"), &recording.normal_force),
        ("command", ("command_n", "N"), &recording.command),
        ("reference", ("reference_m", "m"), &recording.reference),
        ("temperature", ("temperature_c", "°C"), &recording.temperature),
    ];
    for (signal, name, values) in optional {
        if let Some(values) = values {
            push(signal, name, values);
        }
    }
    out
}
