//! Answers: recordings in, diagnoses and models out. This file sees neither the plan nor the labels.

use crate::error::Result;
use crate::seal::Places;
use diagnose::{Options, diagnose};
use signals::files;
use signals::{ReadOptions, Recording};

/// Diagnoses one recording, judged on the same bench's second recording, and writes the answer.
///
/// # Errors
/// A recording that cannot be read, or an answer that cannot be written.
pub(crate) fn answer(places: &Places, case: usize) -> Result<()> {
    if places.answer(case, "json").exists() {
        return Ok(());
    }
    let train = Recording::read(places.recording(case), &ReadOptions::default())?;
    let again = Recording::read(places.again(case), &ReadOptions::default())?;
    // one rig, not switched off between the two recordings
    let options = Options { absolute: true, ..Options::default() };
    let found = diagnose(&[train], &[again], &options, &|_, _| ())?;
    if let Some(model) = &found.model {
        let model = identify::Model { name: format!("case {case}"), ..model.clone() };
        files::write(&places.answer(case, "toml"), model.to_toml().as_bytes())?;
    }
    // the answer comes last: with it the case is answered
    let text = serde_json::to_string(&found)?;
    Ok(files::write(&places.answer(case, "json"), text.as_bytes())?)
}
