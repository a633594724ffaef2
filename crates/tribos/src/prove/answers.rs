//! Answers: recordings in, diagnoses and models out. Neither plan nor labels are within reach of this file.

use super::seal::Places;
use crate::failure::{Failure, Result};
use crate::options::Mapping;
use crate::{files, reading};
use diagnose::{Options, diagnose};

/// Diagnoses one recording, judged on the same bench's second recording, and writes the answer.
///
/// # Errors
/// A recording that cannot be read, or an answer that cannot be written.
pub(crate) fn answer(places: &Places, case: usize) -> Result<()> {
    if places.answer(case, "json").exists() {
        return Ok(());
    }
    let train = reading::read(&places.recording(case), &Mapping::default())?;
    let again = reading::read(&places.again(case), &Mapping::default())?;
    let found = diagnose(&[train], &[again], &Options::default(), &|_, _| ()).map_err(Failure::new)?;
    if let Some(model) = &found.model {
        let model = identify::Model { name: format!("case {case}"), ..model.clone() };
        files::write(&places.answer(case, "toml"), model.to_toml().as_bytes())?;
    }
    // the answer comes last: with it the case is answered
    let text = serde_json::to_string(&found).map_err(Failure::new)?;
    files::write(&places.answer(case, "json"), text.as_bytes())
}
