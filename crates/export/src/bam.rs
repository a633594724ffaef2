//! JSON of BAM [duclusaud-2024].

use crate::reduce::Exported;
use serde_json::{Map, Value, json};

/// Parameters of the smallest of BAM's friction models that holds the joint: M1 Coulomb and viscous, M2 with friction that falls with
/// the speed, M3 with friction that grows with the torque, M4 with both. M5 and M6 tell the motor's side of the gears from the load's,
/// which one torque cannot.
///
/// BAM reads a file with the name of an actuator. That of the Go1 is driven by a torque, as the model is; all others by a voltage or a
/// current, with constants of a motor that no recording of a torque has.
pub(crate) fn write(name: &str, exported: &Exported) -> String {
    let joint = &exported.joint;
    let (falls, grows) = (joint.falling.force > 0.0, joint.per_load > 0.0);
    let model = match (falls, grows) {
        (false, false) => "m1",
        (true, false) => "m2",
        (false, true) => "m3",
        (true, true) => "m4",
    };
    let mut out = Map::new();
    let mut put = |key: &str, value: Value| out.insert(key.to_owned(), value);
    put("model", json!(model));
    put("actuator", json!("unitree_go1"));
    put("armature", json!(joint.mass));
    put("friction_base", json!(joint.friction));
    put("friction_viscous", json!(joint.damping));
    if falls {
        put("friction_stribeck", json!(joint.falling.force));
        put("dtheta_stribeck", json!(joint.falling.speed));
        put("alpha", json!(joint.falling.exponent));
    }
    if grows {
        put("load_friction_base", json!(joint.per_load));
    }
    if falls && grows {
        put("load_friction_stribeck", json!(0.0));
    }
    put("written_by", json!(format!("tribos {}, from {name}", env!("CARGO_PKG_VERSION"))));
    put("not_held", json!(exported.lines()));
    serde_json::to_string_pretty(&out).unwrap_or_default() + "\n"
}
