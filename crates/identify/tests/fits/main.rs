//! Fits and models. One binary: it links once, and long tests run beside each other.

mod dahl;
mod karnopp;
mod model;
mod planar;
mod positioner;
mod preprocess;
mod table_3_3;
mod uneven;

use plant::Series;
use signals::Recording;

/// A simulated run, with velocity and acceleration beside position and force.
fn recorded(run: Series) -> Recording {
    Recording {
        name: "simulated".into(),
        time: run.time,
        position: run.position,
        velocity: Some(run.velocity),
        acceleration: Some(run.acceleration),
        force: run.force,
        ..Recording::default()
    }
}
