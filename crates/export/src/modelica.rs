//! Modelica, of components of the Modelica Standard Library 4 [modelica-library].

use crate::part::{at_place, at_speed};
use crate::reduce::Exported;
use signals::{Geometry, Recording};
use std::fmt::Write;

/// Speeds of a table per factor of ten: between two of them a power law is off by less than a thousandth.
const PER_DECADE: i32 = 40;
/// Largest speed of a table without a recording, m/s or rad/s. Components extrapolate by the last two points.
const FASTEST: f64 = 100.0;
/// Decades of speed that a table covers, below its largest.
const DECADES: i32 = 6;
/// Share of the largest force by which a table over the position may be off.
const PLACES_OFF: f64 = 1e-3;
/// Largest number of intervals of a table over the position.
const PLACES: usize = 4096;

/// Names in the library.
struct Words {
    package: &'static str,
    body: &'static str,
    inertia: &'static str,
    friction: &'static str,
    table: &'static str,
    rest: &'static str,
    constant: &'static str,
    constant_is: &'static str,
    sensor: &'static str,
    sensed: &'static str,
    source: &'static str,
    driven: &'static str,
}

const SLIDE: Words = Words {
    package: "Modelica.Mechanics.Translational",
    body: "Mass",
    inertia: "m",
    friction: "SupportFriction",
    table: "f_pos",
    rest: "s_rel0",
    constant: "ConstantForce",
    constant_is: "f_constant",
    sensor: "PositionSensor",
    sensed: "s",
    source: "Force",
    driven: "f",
};

const AXIS: Words = Words {
    package: "Modelica.Mechanics.Rotational",
    body: "Inertia",
    inertia: "J",
    friction: "BearingFriction",
    table: "tau_pos",
    rest: "phi_rel0",
    constant: "ConstantTorque",
    constant_is: "tau_constant",
    sensor: "AngleSensor",
    sensed: "phi",
    source: "Torque",
    driven: "tau",
};

/// Largest finite magnitude.
fn largest(values: impl Iterator<Item = f64>) -> f64 {
    values.filter(|x| x.is_finite()).fold(0.0, |most, x| x.abs().max(most))
}

/// Rows of a table.
fn rows(table: &[(f64, f64)]) -> String {
    let rows: Vec<String> = table.iter().map(|(x, f)| format!("{x:.9e}, {f:.9e}")).collect();
    rows.join("; ")
}

/// Friction over the speed, N or N·m: dry, viscous, and effects of the speed.
fn by_speed(exported: &Exported, recording: Option<&Recording>) -> Vec<(f64, f64)> {
    let joint = &exported.joint;
    let friction = |v: f64| {
        let effects: f64 = exported.by_speed.iter().map(|e| at_speed(e, v.max(f64::MIN_POSITIVE))).sum();
        joint.friction + joint.damping * v + effects
    };
    if exported.by_speed.is_empty() {
        return vec![(0.0, friction(0.0)), (1.0, friction(1.0))];
    }
    let recorded = recording.and_then(|r| r.velocity.as_ref()).map(|v| 2.0 * largest(v.iter().copied()));
    let top = recorded.filter(|v| *v > 0.0).unwrap_or(FASTEST);
    let speed = |i: i32| top * 10.0_f64.powf(f64::from(i) / f64::from(PER_DECADE));
    let speeds = (-DECADES * PER_DECADE..=0).map(speed);
    std::iter::once(0.0).chain(speeds).map(|v| (v, friction(v))).collect()
}

/// Force on the body over the recorded stroke and a tenth of it on both sides.
fn by_place(exported: &Exported, recording: &Recording) -> Vec<(f64, f64)> {
    let finite = || recording.position.iter().copied().filter(|x| x.is_finite());
    let (low, high) = (finite().fold(f64::INFINITY, f64::min), finite().fold(f64::NEG_INFINITY, f64::max));
    let margin = 0.1 * (high - low);
    let (low, high) = (low - margin, high + margin);
    // the force of an effect is against positive motion
    let force = |x: f64| -exported.by_place.iter().map(|e| at_place(e, x)).sum::<f64>();
    let mut intervals = 64;
    loop {
        let place = |i: f64| low + (high - low) * i / intervals as f64;
        let table: Vec<(f64, f64)> =
            (0..=intervals).map(|i| place(i as f64)).map(|x| (x, force(x))).collect();
        let most = largest(table.iter().map(|(_, f)| *f));
        let off = largest(
            table.windows(2).enumerate().map(|(i, w)| force(place(i as f64 + 0.5)) - 0.5 * (w[0].1 + w[1].1)),
        );
        if off <= PLACES_OFF * most || intervals >= PLACES {
            return table;
        }
        intervals *= 2;
    }
}

/// The joint: a body between the flange `flange`, where a force drives it, and the frame.
pub(crate) fn write(name: &str, exported: &Exported, recording: Option<&Recording>) -> String {
    let joint = &exported.joint;
    let w = if exported.geometry == Geometry::Rotary { &AXIS } else { &SLIDE };
    let package = w.package;
    let table = by_speed(exported, recording);
    let at_rest = table.first().map_or(0.0, |(_, f)| *f);
    let peak = if at_rest > 0.0 { 1.0 + (joint.break_away - joint.friction) / at_rest } else { 1.0 };
    let (mut parts, mut connected) = (String::new(), String::new());
    if joint.stiffness > 0.0 {
        let _ = write!(
            parts,
            "  {package}.Components.Fixed frame;\n  {package}.Components.Spring spring(c = {:e}, {} = {:e});\n",
            joint.stiffness, w.rest, joint.spring_rest
        );
        connected +=
            "  connect(frame.flange, spring.flange_a);\n  connect(spring.flange_b, body.flange_b);\n";
    }
    if joint.constant != 0.0 {
        let _ = writeln!(
            parts,
            "  {package}.Sources.{} constant_force({} = {:e});",
            w.constant, w.constant_is, -joint.constant
        );
        connected += "  connect(constant_force.flange, body.flange_b);\n";
    }
    if let Some(recording) = recording.filter(|_| !exported.by_place.is_empty()) {
        let _ = write!(
            parts,
            "  {package}.Sensors.{} place;\n  {package}.Sources.{} place_force;\n  \
             Modelica.Blocks.Tables.CombiTable1Ds place_table(table = [{}]);\n",
            w.sensor,
            w.source,
            rows(&by_place(exported, recording))
        );
        let _ = write!(
            connected,
            "  connect(place.flange, body.flange_b);\n  connect(place.{}, place_table.u);\n  \
             connect(place_table.y[1], place_force.{});\n  connect(place_force.flange, body.flange_b);\n",
            w.sensed, w.driven
        );
    }
    let not_held: String = exported.lines().iter().map(|line| format!("  //   {line}\n")).collect();
    format!(
        "model joint_{name} \"Joint of {name}, written by tribos {}\"\n  // Not held here:\n{not_held}  \
         {package}.Interfaces.Flange_a flange \"Where a force drives the body\";\n  \
         {package}.Components.{} body({} = {:e});\n  \
         {package}.Components.{} friction({} = [{}], peak = {peak:.9});\n{parts}equation\n  \
         connect(flange, body.flange_a);\n  connect(body.flange_b, friction.flange_a);\n{connected}  \
         annotation(uses(Modelica(version = \"4.0.0\")));\nend joint_{name};\n",
        env!("CARGO_PKG_VERSION"),
        w.body,
        w.inertia,
        joint.mass,
        w.friction,
        w.table,
        rows(&table),
    )
}
