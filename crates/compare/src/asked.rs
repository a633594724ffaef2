//! A model or preset in the place of a recording: the force it asks for along the motion of the other recording.

use crate::Error;
use identify::Model;
use signals::Recording;

/// The force that `model` asks for along the motion of `motion`, as a recording without noise of its own. Velocities are
/// those of `motion`; samples whose velocity is not known have no force, and are gaps.
///
/// # Errors
/// A motion that cannot be prepared, of another geometry or without what the model needs.
pub fn asked(model: &Model, motion: &Recording) -> Result<Recording, Error> {
    let force = model.predict(motion)?;
    let name = if model.name.is_empty() { "model".into() } else { model.name.clone() };
    Ok(Recording { name, force, ..motion.clone() })
}
