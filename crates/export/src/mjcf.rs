//! MJCF, the format of MuJoCo.

use crate::reduce::Exported;
use crate::xml::comment;
use signals::Geometry;
use std::fmt::Write;

/// Time step, s. Friction loss is a soft constraint, as stiff as two time steps allow.
const TIME_STEP: f64 = 2e-4;
/// Part of a radian that a body on bristles swings in a time step: the contact holds then, and the joint follows.
const TURN: f64 = 0.06;

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
    let bristles = joint.bristle.stiffness + joint.fall.stiffness;
    let step = if bristles > 0.0 { TIME_STEP.min(TURN / (bristles / m).sqrt()) } else { TIME_STEP };
    // what the bristles do not carry
    let dry = joint.friction - joint.bristle.level;
    let dry = if bristles > 0.0 && dry <= 1e-9 * joint.friction {
        String::new()
    } else {
        format!(" frictionloss=\"{dry}\" solreffriction=\"{} 1\"", 2.0 * step)
    };
    format!(
        "{}<mujoco model=\"{name}\">\n  <compiler angle=\"radian\"/>\n  <option timestep=\"{step}\" \
         integrator=\"implicitfast\" gravity=\"0 0 0\"/>\n  <worldbody>\n    <body name=\"{name}\">\n      \
         <joint name=\"{name}\" type=\"{kind}\" axis=\"{axis}\" damping=\"{}\"{dry}{spring}/>\n      \
         <inertial pos=\"0 0 0\" mass=\"{mass}\" \
         diaginertia=\"{inertia} {inertia} {inertia}\"/>\n    </body>\n  </worldbody>\n{}</mujoco>\n",
        comment(name, exported),
        joint.damping,
        motors(name, exported, step),
    )
}

/// Motors without input, whose back-EMF of 1e-12 is none: one for the bristles, one for the fall, one for each wave.
fn motors(name: &str, exported: &Exported, step: f64) -> String {
    let joint = &exported.joint;
    let mut out = String::new();
    let mut motor = |what: &str, attribute: String| {
        let _ = writeln!(
            out,
            "    <dcmotor name=\"{name}_{what}\" joint=\"{name}\" input=\"none\" motorconst=\"1e-6\" resistance=\"1\" {attribute}/>"
        );
    };
    for (what, bristle) in [("friction", joint.bristle), ("fall", joint.fall)] {
        if bristle.stiffness == 0.0 {
            continue;
        }
        // explicit steps of an undamped bristle gain energy; that of one step takes it out
        let damping = bristle.damping.max(bristle.stiffness * step);
        let (level, falling) = (bristle.level, bristle.falling);
        // without a fall any speed will do
        let speed = if falling.force > 0.0 { falling.speed } else { 1.0 };
        let most = level + falling.force;
        motor(what, format!("lugre=\"{} {damping} {level} {most} {speed}\"", bristle.stiffness));
    }
    for (i, wave) in exported.waves.iter().enumerate() {
        // the motor pushes where the model resists
        let phase = wave.phase + std::f64::consts::PI;
        motor(
            &format!("wave_{}", i + 1),
            format!("cogging=\"{} {} {phase}\"", wave.amplitude, wave.per_length),
        );
    }
    if out.is_empty() {
        out
    } else {
        format!("  <!-- MuJoCo 3.12 or later -->\n  <actuator>\n{out}  </actuator>\n")
    }
}
