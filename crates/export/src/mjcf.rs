//! MJCF, the format of MuJoCo.

use crate::reduce::Exported;
use crate::xml::comment;
use signals::Geometry;

/// Time step, s. Friction loss is a soft constraint, as stiff as two time steps allow.
const TIME_STEP: f64 = 2e-4;

pub(crate) fn write(name: &str, exported: &Exported) -> String {
    let joint = &exported.joint;
    let rotary = exported.geometry == Geometry::Rotary;
    let (kind, axis) = if rotary { ("hinge", "0 0 1") } else { ("slide", "1 0 0") };
    let m = joint.mass;
    // a slide does not turn, and a hinge does not move its centre: what is not seen is any positive number
    let (mass, inertia) = if rotary { (1.0, m) } else { (m, 1e-4 * m) };
    let spring = if joint.stiffness > 0.0 {
        format!(" stiffness=\"{}\" springref=\"{}\"", joint.stiffness, joint.spring_rest)
    } else {
        String::new()
    };
    format!(
        "{}<mujoco model=\"{name}\">\n  <compiler angle=\"radian\"/>\n  <option timestep=\"{TIME_STEP}\" \
         integrator=\"implicitfast\" gravity=\"0 0 0\"/>\n  <worldbody>\n    <body name=\"{name}\">\n      \
         <joint name=\"{name}\" type=\"{kind}\" axis=\"{axis}\" damping=\"{}\" frictionloss=\"{}\" \
         solreffriction=\"{} 1\"{spring}/>\n      <inertial pos=\"0 0 0\" mass=\"{mass}\" \
         diaginertia=\"{inertia} {inertia} {inertia}\"/>\n    </body>\n  </worldbody>\n</mujoco>\n",
        comment(name, exported),
        joint.damping,
        joint.friction,
        2.0 * TIME_STEP,
    )
}
