//! Recordings in the plane: read, identified, diagnosed, predicted.

use crate::error::{Error, Result};
use crate::identified::{FittedLaw, How, Preprocessing};
use identify::planar::{Ellipse, PlanarIdentified, PlanarModel, PlanarOptions, Track};
use signals::{Cutoff, PlanarRecording, Recording, Settings, prepare_planar};
use std::path::Path;

/// Recordings on a line, or in the plane.
#[derive(Debug, Clone)]
pub enum Recordings {
    /// On a line.
    Line(Vec<Recording>),
    /// In the plane.
    Plane(Vec<PlanarRecording>),
}

/// Reads recordings on a line or in the plane, whichever the files are; a map or a joint makes recordings on a line.
///
/// # Errors
/// As [`crate::recordings::read_all`]; half a pair of columns, or files of both kinds.
pub fn read_all(paths: &[impl AsRef<Path>], maps: &[String], joint: Option<&str>) -> Result<Recordings> {
    let refused = match crate::recordings::read_all(paths, maps, joint) {
        Ok(read) => return Ok(Recordings::Line(read)),
        Err(refused) => refused,
    };
    if !maps.is_empty() || joint.is_some() {
        return Err(refused);
    }
    let mut planar = Vec::new();
    let mut other = None;
    for path in paths {
        let path = path.as_ref();
        if path.is_dir() && !signals::is_bag(path) {
            return Err(refused);
        }
        match PlanarRecording::read(path).map_err(|e| Error::in_file(path, &e))? {
            Some(recording) => planar.push(recording),
            None => other = Some(path),
        }
    }
    match (other, planar.is_empty()) {
        (None, _) => Ok(Recordings::Plane(planar)),
        (Some(_), true) => Err(refused),
        (Some(line), false) => Err(Error::input(format!(
            "{}: is on a line, and others are in the plane; accepted together are recordings of one kind",
            line.display()
        ))),
    }
}

/// Name of the model of these recordings.
fn model_name(recordings: &[PlanarRecording]) -> String {
    recordings.first().map_or_else(String::new, |r| crate::recordings::model_name(&r.axes[..1]))
}

/// What was identified in the plane.
#[derive(Debug, Clone)]
pub struct Identified {
    /// Names of the recordings.
    pub name: String,
    /// Result, model and series.
    pub planar: PlanarIdentified,
}

/// Identifies friction in the plane as one set of parameters.
///
/// # Errors
/// What is wrong with the recordings, or an option that is for recordings on a line.
pub fn identify(recordings: &[PlanarRecording], how: &How) -> Result<Identified> {
    let line = "accepted with recordings on a line; in the plane the law is a level by direction";
    if how.law != FittedLaw::Karnopp {
        return Err(Error::option("law", format!("`{}`: {line}", how.law.id())));
    }
    if how.preprocess != Preprocessing::Tribos {
        return Err(Error::option("preprocess", format!("`{}`: {line}", how.preprocess.id())));
    }
    if let Some(delta_v) = how.delta_v {
        return Err(Error::option("delta_v", format!("{delta_v}: {line}")));
    }
    let options = PlanarOptions { cutoff_hz: how.cutoff_hz, least_squares: how.least_squares };
    let mut planar = identify::planar::identify_planar(recordings, &options)?;
    planar.model.name = model_name(recordings);
    let name = recordings.iter().map(|r| r.name.as_str()).collect::<Vec<_>>().join(", ");
    Ok(Identified { name, planar })
}

/// The model of a diagnosis in the plane, named after the recordings.
#[must_use]
pub fn model(found: &diagnose::PlanarDiagnosis, recordings: &[PlanarRecording]) -> Option<PlanarModel> {
    Some(PlanarModel { name: model_name(recordings), ..found.model.clone()? })
}

impl Identified {
    /// Series for pictures.
    #[must_use]
    pub fn shown(&self) -> report::PlanarIdentified {
        let (found, model) = (&self.planar.found, &self.planar.model);
        let quantity =
            |p: &identify::Estimate| diagnose::Quantity { value: p.value, std: p.std, unit: p.unit.clone() };
        let mut out = report::PlanarIdentified {
            name: self.name.clone(),
            samples: found.samples,
            relative_error: found.relative_error,
            parameters: found.parameters.iter().map(|(name, p)| (name.clone(), quantity(p))).collect(),
            undetermined: found
                .not_identifiable
                .iter()
                .map(|n| report::Undetermined {
                    parameter: n.parameter.clone(),
                    because: n.because.clone(),
                    experiment: n.experiment.clone(),
                })
                .collect(),
            faults: found.recording_faults.clone(),
            how: vec![found.estimator.clone(), found.preprocess.clone()],
            ..report::PlanarIdentified::default()
        };
        let ellipse = Ellipse::of(model.level_along, model.level_across, model.angle);
        for t in &self.planar.tracks {
            let predicted = model.predict(t);
            for i in (0..t.len()).step_by(t.stride).filter(|i| t.mask[*i] == 1.0) {
                let v = [t.v[0][i], t.v[1][i]];
                let fitted = ellipse.force(v[0], v[1])[0];
                // what is left when all but the level is taken off
                let left = [0, 1].map(|axis| t.f[axis][i] - (predicted[axis][i] - fitted[axis]));
                out.motion.push(v);
                out.friction.push(left);
                out.fitted.push(fitted);
            }
        }
        out
    }

    /// The report, one self-contained HTML page.
    #[must_use]
    pub fn report(&self) -> String {
        report::planar_identification(&self.shown())
    }
}

/// A prediction in the plane.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Predicted {
    /// Times, s: samples of the recording outside of its gaps.
    pub time: Vec<f64>,
    /// Force of each axis, N.
    pub force: [Vec<f64>; 2],
    /// Root mean square of the error over samples at which the body slides, behind the filter, N.
    pub error: f64,
    /// The same over the root mean square of the force.
    pub relative: f64,
}

/// Predicts the force of a recording in the plane.
///
/// # Errors
/// A recording that cannot be prepared, or has no stretch that is long enough.
pub fn predict(model: &PlanarModel, recording: &PlanarRecording) -> Result<Predicted> {
    let settings =
        Settings { cutoff: model.cutoff_hz.map_or(Cutoff::OfSearch, Cutoff::Given), ..Settings::default() };
    let prepared = prepare_planar(recording, &settings)?;
    let Some(cutoff) = prepared.report.cutoff_hz.filter(|_| !prepared.stretches.is_empty()) else {
        return Err(Error::input(format!("{}: no stretch is long and clean enough", recording.name)));
    };
    let mut out = Predicted::default();
    let (mut error, mut size, mut rows) = (0.0, 0.0, 0.0);
    for stretch in prepared.stretches {
        let t = Track::new(stretch, cutoff);
        let force = model.predict(&t);
        for (measured, predicted) in t.f.iter().zip(&force) {
            let left: Vec<f64> = measured.iter().zip(predicted).map(|(f, p)| f - p).collect();
            error += t.rows(&left).iter().map(|x| x * x).sum::<f64>();
            size += t.rows(measured).iter().map(|x| x * x).sum::<f64>();
            rows += t.share().iter().sum::<f64>();
        }
        out.time.extend((0..t.len()).map(|i| t.raw[0].start + i as f64 * t.raw[0].dt));
        for (all, own) in out.force.iter_mut().zip(force) {
            all.extend(own);
        }
    }
    out.error = (error / f64::max(rows, 1.0)).sqrt();
    out.relative = (error / size.max(1e-300)).sqrt();
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::PathBuf;

    /// A body of 0.5 kg pushed around two ellipses, 1 N of friction along x and 1.4 N along y. The forces are written down from the
    /// motion, not by a law of this workspace.
    fn written(folder: &Path) -> PathBuf {
        let (mass, along, across) = (0.5, 1.0, 1.4);
        let mut text = String::from("time_s,position_x_m,position_y_m,force_x_n,force_y_n\n");
        for i in 0..8000 {
            let t = f64::from(i) * 1e-3;
            let axis = |a: f64, w: f64, p: f64| {
                let (sine, cosine) = (w * t + p).sin_cos();
                [a * sine, a * w * cosine, -a * w * w * sine]
            };
            let sum = |one: [f64; 3], other: [f64; 3]| [0, 1, 2].map(|k| one[k] + other[k]);
            let x = sum(axis(0.03, 5.0, 0.0), axis(0.01, 13.1, 1.0));
            let y = sum(axis(0.03, 6.3, 0.7), axis(0.01, 16.9, 0.2));
            // the force on the ellipse that takes most power from the motion
            let power = (along * x[1]).hypot(across * y[1]);
            let noise = |k: f64| 0.02 * (1e4 * t * t + k).sin();
            let fx = mass * x[2] + along * along * x[1] / power + noise(0.0);
            let fy = mass * y[2] + across * across * y[1] / power + noise(2.0);
            text += &format!("{t},{},{},{fx},{fy}\n", x[0], y[0]);
        }
        let path = folder.join("ellipses.csv");
        std::fs::write(&path, text).expect("written");
        path
    }

    fn planar(path: &Path) -> Vec<PlanarRecording> {
        match read_all(&[path], &[], None).expect("read") {
            Recordings::Plane(recordings) => recordings,
            Recordings::Line(_) => panic!("in the plane"),
        }
    }

    #[test]
    fn a_file_in_the_plane_is_identified_predicted_and_reported() {
        let folder = tempfile::tempdir().expect("a folder");
        let recordings = planar(&written(folder.path()));
        let found = identify(&recordings, &How::default()).expect("identified");
        let value = |name: &str| found.planar.found.value(name).unwrap_or(f64::NAN);
        println!("{:?}", found.planar.found.parameters);
        assert!((value("level_along") - 1.0).abs() < 0.01 && (value("level_across") - 1.4).abs() < 0.01);
        assert!(value("angle").abs() < 0.02 && (value("mass") - 0.5).abs() < 0.005);
        assert_eq!(found.planar.model.name, "ellipses");
        let page = found.report();
        assert!(page.contains("Direction of friction against direction of motion") && page.contains("<svg"));
        let predicted = predict(&found.planar.model, &recordings[0]).expect("predicted");
        println!("{:.2} % of the force is left", 100.0 * predicted.relative);
        assert!(predicted.time.len() == 8000 && predicted.relative < 0.02);
        let how = How { law: FittedLaw::Dahl, ..How::default() };
        let refused = identify(&recordings, &how).expect_err("refused").to_string();
        assert!(refused.contains("dahl") && refused.contains("on a line"), "{refused}");
    }

    #[test]
    fn files_of_both_kinds_are_refused_together() {
        let folder = tempfile::tempdir().expect("a folder");
        let plane = written(folder.path());
        let line = folder.path().join("line.csv");
        std::fs::write(&line, "time_s,position_m,force_n\n0,1,2\n1,2,3\n").expect("written");
        let says = |paths: &[&PathBuf]| read_all(paths, &[], None).expect_err("refused").to_string();
        assert!(says(&[&line, &plane]).contains("line.csv: is on a line, and others are in the plane"));
        let half = folder.path().join("half.csv");
        std::fs::write(&half, "time_s,position_x_m,force_x_n,force_y_n\n0,1,2,3\n").expect("written");
        assert!(says(&[&half]).contains("position_x_m without position_y_m"), "{}", says(&[&half]));
        // one axis of it, as a map says, is on a line
        let map = ["time_s=time_s,position_m=position_x_m,force_n=force_x_n".to_owned()];
        assert!(matches!(read_all(&[&plane], &map, None), Ok(Recordings::Line(_))));
        let refused = crate::recordings::read_all(&[&plane], &[], None).expect_err("refused").to_string();
        assert!(refused.contains("is a recording in the plane"), "{refused}");
    }
}
