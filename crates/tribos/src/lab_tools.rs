//! Services for the lab: a line to the device, analyses, conversions.

use crate::commands::{diagnose as diagnosing, experiment as experimenting, identify as identifying};
use crate::failure::{Failure, Result};
use crate::options::Mapping;
use crate::{files, reading};
use client::Session;
use design::LeftOut;
use friction::effects::{Describe, Unnamed};
use lab::{Found, Progress, Tools};
use perception::study;
use signals::Recording;
use std::path::{Path, PathBuf};

/// The tools, for one port.
pub(crate) struct HostTools {
    port: String,
    seed: u64,
}

impl HostTools {
    pub fn new(port: &str, seed: u64) -> Self {
        Self { port: port.to_owned(), seed }
    }

    /// Checks that the port can be opened.
    ///
    /// # Errors
    /// The reason why not.
    pub fn check(&self) -> Result<()> {
        Session::open(&self.port, self.seed)?;
        Ok(())
    }
}

fn words(failure: Failure) -> String {
    failure.message().to_owned()
}

impl Tools for HostTools {
    fn port(&self) -> &str {
        &self.port
    }

    fn open(&self) -> std::result::Result<Session, client::Error> {
        Session::open(&self.port, self.seed)
    }

    fn identify(
        &self,
        recordings: &[PathBuf],
        report: &Path,
        progress: Progress<'_>,
    ) -> std::result::Result<Found, String> {
        let _ = progress(0.1, "fitting");
        let (text, html, model) = identifying::by_defaults(recordings).map_err(words)?;
        files::write(report, html.as_bytes()).map_err(words)?;
        Ok(Found { text, preset: model.preset_lines(), ..Found::default() })
    }

    fn diagnose(
        &self,
        recordings: &[PathBuf],
        report: &Path,
        progress: Progress<'_>,
    ) -> std::result::Result<Found, String> {
        let train = reading::read_all(recordings, &Mapping::default()).map_err(words)?;
        let found = diagnose::diagnose_watched(&train, &[], &diagnose::Options::default(), progress)
            .map_err(|e| e.to_string())?;
        let name = train.iter().map(|r| r.name.as_str()).collect::<Vec<_>>().join(", ");
        files::write(report, report::diagnosis(&found, &name).as_bytes()).map_err(words)?;
        let preset = found.model.as_ref().map(identify::Model::preset_lines).unwrap_or_default();
        let left_out = found.model.as_ref().map(not_in_a_preset).unwrap_or_default();
        Ok(Found {
            text: diagnosing::outline(&name, &found),
            preset,
            left_out,
            summary: found.summary,
            ..Found::default()
        })
    }

    fn analyse(
        &self,
        sessions: &[PathBuf],
        report: &Path,
        progress: Progress<'_>,
    ) -> std::result::Result<Found, String> {
        let _ = progress(0.1, "fitting");
        let sessions = study::read(sessions).map_err(|e| words(e.into()))?;
        let analysis = study::analyse(&sessions, perception::Margins::THESIS);
        let html = report::sessions(&analysis).map_err(|e| e.to_string())?;
        files::write(report, html.as_bytes()).map_err(words)?;
        let stem = report.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let mut tables = Vec::new();
        for (name, table) in study::tables(&sessions, &analysis) {
            let name = format!("{stem}-{name}");
            files::write(&report.with_file_name(&name), table.as_bytes()).map_err(words)?;
            tables.push(name);
        }
        Ok(Found { text: experimenting::text(&analysis), tables, ..Found::default() })
    }

    fn not_a_body(&self, recording: &Path) -> std::result::Result<Option<String>, String> {
        let recording = reading::read(recording, &Mapping::default()).map_err(words)?;
        Ok(pushed_from_beyond(&recording))
    }

    fn to_mcap(&self, recording: &Path, out: &Path) -> std::result::Result<(), String> {
        let recording = reading::read(recording, &Mapping::default()).map_err(words)?;
        recording.write(out).map(drop).map_err(|e| e.to_string())
    }
}

/// What a model has and no preset holds.
fn not_in_a_preset(model: &identify::Model) -> Vec<LeftOut> {
    let sensors = model.nuisances.sensors.iter().map(|effect| LeftOut {
        name: effect.kind.about().id.to_owned(),
        why: {
            let values: Vec<String> = effect
                .parameters()
                .map(|(p, x)| format!("{} = {}", p.name, report::number::number(x, 4)))
                .collect();
            format!("{}: sensor or drive; the device renders forces of the contact only", values.join(", "))
        },
    });
    let curves = model.curves.iter().map(|curve| LeftOut {
        name: Unnamed::ABOUT.id.to_owned(),
        why: format!("a curve over {}: the device renders effects of the catalogue only", curve.over.id()),
    });
    sensors.chain(curves).collect()
}

/// Why a recording is not that of a body on the handle: its force takes energy from the motion, as where the load cell is between
/// the handle and a hand that moves it.
fn pushed_from_beyond(recording: &Recording) -> Option<String> {
    let steps = recording.position.windows(2).zip(&recording.force);
    let (work, most, way) = steps.fold((0.0, 0.0, 0.0), |(work, most, way), (x, force)| {
        let step = x[1] - x[0];
        (work + force * step, most + (force * step).abs(), way + step.abs())
    });
    let mean = if way > 0.0 { work / way } else { 0.0 };
    // of a bare handle that the device drives, neither sign stands out
    (work < -0.2 * most).then(|| {
        format!(
            "{}: the force on the load cell takes energy from the motion, {:.2} {} on average: it shows a hand that moves a bare \
             handle, so what was found is the handle itself and what it renders. Mount the body on the handle, and let the device \
             drive it",
            recording.name,
            -mean,
            friction::Dimension::FORCE.unit(recording.geometry)
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_hand_on_a_bare_handle_is_not_taken_for_a_body() {
        let body = |sign: f64| Recording {
            name: "rec-001.csv".into(),
            time: vec![0.0, 1e-3, 2e-3, 3e-3],
            position: vec![0.0, 1e-3, 2e-3, 1e-3],
            force: vec![2.0 * sign, 2.0 * sign, -2.0 * sign, -2.0 * sign],
            ..Recording::default()
        };
        assert_eq!(pushed_from_beyond(&body(1.0)), None);
        let why = pushed_from_beyond(&body(-1.0)).expect("refused");
        println!("{why}");
        assert!(why.contains("2.00 N on average"));
    }
}
