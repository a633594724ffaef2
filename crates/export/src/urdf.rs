//! URDF, the format of ROS.

use crate::error::Error;
use crate::reduce::Exported;
use crate::xml::comment;
use signals::{Geometry, Recording};

/// Smallest and largest finite value.
fn range(values: &[f64]) -> Option<(f64, f64)> {
    let finite = values.iter().copied().filter(|v| v.is_finite());
    finite.fold(None, |range, v| {
        let (low, high) = range.unwrap_or((v, v));
        Some((low.min(v), high.max(v)))
    })
}

pub(crate) fn write(name: &str, exported: &Exported, recording: Option<&Recording>) -> Result<String, Error> {
    let joint = &exported.joint;
    let rotary = exported.geometry == Geometry::Rotary;
    let limits = recording.and_then(|r| Some((range(&r.position)?, range(&r.force)?, speed(r))));
    let limit = limits.map(|((lower, upper), (weakest, strongest), speed)| {
        let effort = strongest.max(-weakest);
        format!(
            "    <limit lower=\"{lower}\" upper=\"{upper}\" effort=\"{effort}\" velocity=\"{speed}\"/> <!-- as recorded -->\n"
        )
    });
    let (kind, axis) = match (rotary, &limit) {
        (true, Some(_)) => ("revolute", "0 0 1"),
        (true, None) => ("continuous", "0 0 1"),
        (false, Some(_)) => ("prismatic", "1 0 0"),
        (false, None) => return Err(Error::NoLimits),
    };
    let m = joint.mass;
    // a slide does not turn, and an axis does not move its centre: what is not seen is any positive number
    let (mass, inertia) = if rotary { (1.0, m) } else { (m, 1e-4 * m) };
    Ok(format!(
        "<?xml version=\"1.0\"?>\n{}<robot name=\"{name}\">\n  <link name=\"base\"/>\n  <link name=\"{name}\">\n    \
         <inertial>\n      <mass value=\"{mass}\"/>\n      <inertia ixx=\"{inertia}\" ixy=\"0\" ixz=\"0\" \
         iyy=\"{inertia}\" iyz=\"0\" izz=\"{inertia}\"/>\n    </inertial>\n  </link>\n  <joint name=\"{name}_joint\" \
         type=\"{kind}\">\n    <parent link=\"base\"/>\n    <child link=\"{name}\"/>\n    <axis xyz=\"{axis}\"/>\n    \
         <dynamics damping=\"{}\" friction=\"{}\"/>\n{}  </joint>\n</robot>\n",
        comment(name, exported),
        joint.damping,
        joint.friction,
        limit.unwrap_or_default(),
    ))
}

/// Largest speed of a recording, m/s or rad/s: of its column, or between samples.
fn speed(recording: &Recording) -> f64 {
    let between = || {
        let steps = recording.time.windows(2).zip(recording.position.windows(2));
        steps.map(|(t, x)| (x[1] - x[0]) / (t[1] - t[0])).collect::<Vec<f64>>()
    };
    let velocity = recording.velocity.clone().unwrap_or_else(between);
    velocity.into_iter().filter(|v| v.is_finite()).fold(0.0, |most, v| v.abs().max(most))
}
