//! What a diagnosis is asked with, checked before it runs.

use crate::error::{Error, Result};
use diagnose::{Nuisance, Options};
use friction::effects::{Describe, Unnamed};

/// Verdicts, as they stand in the JSON.
pub const VERDICTS: [&str; 3] = ["mismatch", "no_mismatch", "not_testable"];

/// Checks options of a diagnosis of `recordings` recordings, those that judge included.
///
/// # Errors
/// An unknown effect, or nuisances between recordings where there is one only.
pub fn check(options: &Options, recordings: usize) -> Result<()> {
    if !options.per_recording.is_empty() && recordings < 2 {
        return Err(Error::option(
            "per_recording",
            "with one recording there is no other to differ from; accepted with two or more",
        ));
    }
    options.exclude.iter().try_for_each(|id| check_finding(id))
}

/// Checks that a diagnosis can find this: an effect or a verdict.
///
/// # Errors
/// An unknown id, with those that are known.
pub fn check_finding(id: &str) -> Result<()> {
    let mut known = diagnose::effect_ids();
    let planar: Vec<&str> =
        diagnose::planar_effect_ids().into_iter().filter(|id| !known.contains(id)).collect();
    known.extend(planar);
    if known.contains(&id) || VERDICTS.contains(&id) || id == Unnamed::ABOUT.id {
        return Ok(());
    }
    Err(Error::input(format!("`{id}` is no effect")).with_help(format!("accepted are {}", known.join(", "))))
}

/// The nuisance with this id.
///
/// # Errors
/// Those that are accepted.
pub fn nuisance(id: &str) -> std::result::Result<Nuisance, String> {
    Nuisance::from_id(id).ok_or_else(|| {
        let ids: Vec<&str> = Nuisance::ALL.iter().map(|n| n.id()).collect();
        format!("accepted are {}", ids.join(", "))
    })
}
