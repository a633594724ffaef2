//! Recordings in the plane: two axes with one clock, each prepared as a recording on a line is.

use crate::formats::Axis;
use crate::prepare::Prepared;
use crate::{
    Channels, Error, FaultKind, Preparation, Recording, RecordingFault, Settings, choose_cutoff, prepare,
};
use std::path::Path;

/// Names of the axes.
pub const AXES: [&str; 2] = ["x", "y"];

/// A recording in the plane: `time_s`, `position_x_m`, `position_y_m`, `force_x_n`, `force_y_n`; velocities and accelerations
/// are optional.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PlanarRecording {
    /// File name, or what it is called in messages and reports.
    pub name: String,
    /// The x axis and the y axis, at the same times.
    pub axes: [Recording; 2],
}

impl PlanarRecording {
    /// Positions, m, and forces, N, of both axes at the same times, s.
    #[must_use]
    pub fn of(name: &str, time: Vec<f64>, position: [Vec<f64>; 2], force: [Vec<f64>; 2]) -> Self {
        let axis = |time, position, force| Recording {
            name: name.into(),
            time,
            position,
            force,
            ..Recording::default()
        };
        let ([px, py], [fx, fy]) = (position, force);
        Self { name: name.into(), axes: [axis(time.clone(), px, fx), axis(time, py, fy)] }
    }

    /// Reads a recording in the plane, from a file of any kind that [`Recording::read`] takes. None where its columns are not
    /// those of one.
    ///
    /// # Errors
    /// As [`Recording::read`]; a column of one axis without that of the other.
    pub fn read(path: impl AsRef<Path>) -> Result<Option<Self>, Error> {
        let path = path.as_ref();
        Self::of_axes(&path.display().to_string(), |axis| Recording::read_axis(path, axis))
    }

    /// As [`PlanarRecording::read`], of a file in memory.
    ///
    /// # Errors
    /// As [`PlanarRecording::read`].
    pub fn from_bytes(name: &str, bytes: &[u8]) -> Result<Option<Self>, Error> {
        Self::of_axes(name, |axis| Recording::axis_from_bytes(name, bytes, axis))
    }

    fn of_axes(file: &str, read: impl Fn(&Axis) -> Result<Recording, Error>) -> Result<Option<Self>, Error> {
        let axis = Axis::new(0);
        let x = read(&axis);
        if !axis.is_planar() {
            return Ok(None);
        }
        if let Some(why) = axis.missing() {
            return Err(Error::File { file: file.into(), why });
        }
        let axes = [x?, read(&Axis::new(1))?];
        Ok(Some(Self { name: axes[0].name.clone(), axes }))
    }

    /// The columns as a CSV file.
    ///
    /// # Errors
    /// Columns of unequal length.
    pub fn to_csv(&self) -> Result<String, Error> {
        let [x, y] = &self.axes;
        x.check_lengths()?;
        let mut columns: Vec<(&str, &[f64])> = vec![("time_s", &x.time)];
        let mut add = |names: [&'static str; 2], of: fn(&Recording) -> Option<&[f64]>| {
            for (name, axis) in names.into_iter().zip([x, y]) {
                columns.extend(of(axis).map(|values| (name, values)));
            }
        };
        add(["position_x_m", "position_y_m"], |r| Some(&r.position));
        add(["velocity_x_m_s", "velocity_y_m_s"], |r| r.velocity.as_deref());
        add(["acceleration_x_m_s2", "acceleration_y_m_s2"], |r| r.acceleration.as_deref());
        add(["force_x_n", "force_y_n"], |r| Some(&r.force));
        if let Some((name, values)) = columns.iter().find(|(_, values)| values.len() != x.len()) {
            let why = format!("{name} has {} samples, time_s has {}", values.len(), x.len());
            return Err(Error::Recording { recording: self.name.clone(), why });
        }
        let mut text = columns.iter().map(|(name, _)| *name).collect::<Vec<_>>().join(",");
        text.push('\n');
        for i in 0..x.len() {
            let cells: Vec<String> = columns.iter().map(|(_, values)| format!("{:?}", values[i])).collect();
            text += &cells.join(",");
            text.push('\n');
        }
        Ok(text)
    }
}

/// A recording in the plane ready to be fitted.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PlanarPrepared {
    /// Name of the recording.
    pub name: String,
    /// Gap-free stretches of both axes at once: equal start, length and rate.
    pub stretches: Vec<[Channels; 2]>,
    /// Faults of the recording; those of one axis say which.
    pub faults: Vec<RecordingFault>,
    /// What was done; channels are `position_x`, `position_y`, …
    pub report: Preparation,
}

/// Prepares each axis by [`prepare`], and keeps what both axes have.
///
/// # Errors
/// Columns of unequal length; a cut-off that is not above 0 and below half the sampling rate.
pub fn prepare_planar(recording: &PlanarRecording, settings: &Settings) -> Result<PlanarPrepared, Error> {
    let [x, y] = &recording.axes;
    if x.time != y.time {
        let why = "the axes have different times; accepted is one clock for both".into();
        return Err(Error::Recording { recording: recording.name.clone(), why });
    }
    let [x, y] = [prepare(x, settings)?, prepare(y, settings)?];
    let stretches = common(&x.channels, &y.channels);
    let all: Vec<Channels> = stretches.iter().flatten().cloned().collect();
    let mut report = Preparation {
        used: stretches.iter().map(|[x, _]| x.len()).sum(),
        stretches: stretches.len(),
        cutoffs_hz: None,
        cutoff_hz: match settings.cutoff {
            crate::Cutoff::Given(cutoff) => Some(cutoff),
            _ => (!all.is_empty()).then(|| choose_cutoff(&all)),
        },
        ..x.report.clone()
    };
    report.channels.clear();
    for (prepared, axis) in [&x, &y].into_iter().zip(AXES) {
        for (name, channel) in &prepared.report.channels {
            report.channels.insert(format!("{name}_{axis}"), channel.clone());
        }
    }
    let faults = faults(&x, &y);
    report.faults.clone_from(&faults);
    Ok(PlanarPrepared { name: recording.name.clone(), stretches, faults, report })
}

/// Faults of both axes once, those of one with its name. A body that moves along one axis only moves enough.
fn faults(x: &Prepared, y: &Prepared) -> Vec<RecordingFault> {
    let still = |f: &&RecordingFault| {
        !matches!(f.kind, FaultKind::TooLittleMotion | FaultKind::ConstantChannel | FaultKind::QuickReversals)
    };
    let moves = |p: &Prepared| p.faults.iter().all(|f| f.kind != FaultKind::TooLittleMotion);
    let one_moves = moves(x) || moves(y);
    let mut out: Vec<RecordingFault> = Vec::new();
    for (prepared, other, axis) in [(x, y, AXES[0]), (y, x, AXES[1])] {
        for fault in prepared.faults.iter().filter(|f| !one_moves || still(f)) {
            if !other.faults.contains(fault) {
                out.push(RecordingFault { why: format!("{axis} axis: {}", fault.why), ..fault.clone() });
            } else if !out.contains(fault) {
                out.push(fault.clone());
            }
        }
    }
    out
}

/// Parts of the stretches in which both axes are there, of at least 64 samples.
fn common(x: &[Channels], y: &[Channels]) -> Vec<[Channels; 2]> {
    let mut out = Vec::new();
    for a in x {
        for b in y {
            let later = ((b.start - a.start) / a.dt).round() as i64;
            let (from_a, from_b) = (later.max(0) as usize, (-later).max(0) as usize);
            let length = a.len().saturating_sub(from_a).min(b.len().saturating_sub(from_b));
            if length >= 64 {
                out.push([a.part(from_a..from_a + length), b.part(from_b..from_b + length)]);
            }
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEADER: &str = "time_s,position_x_m,position_y_m,force_x_n,force_y_n";

    fn text(header: &str, columns: usize) -> String {
        let mut out = format!("{header}\n");
        for i in 0..400 {
            let t = f64::from(i) * 1e-3;
            let values = [t, 0.01 * (20.0 * t).sin(), 0.01 * (13.0 * t).cos(), 1.0, -2.0, 0.2 * t, 0.3 * t];
            let cells: Vec<String> = values[..columns].iter().map(f64::to_string).collect();
            out += &format!("{}\n", cells.join(","));
        }
        out
    }

    #[test]
    fn columns_of_both_axes_make_a_planar_recording() {
        let read = |text: &str| PlanarRecording::from_bytes("a.csv", text.as_bytes());
        let plain = read(&text(HEADER, 5)).unwrap().expect("planar");
        assert_eq!((plain.axes[0].force[3], plain.axes[1].force[3], plain.axes[1].len()), (1.0, -2.0, 400));
        assert!(plain.axes[0].velocity.is_none());
        let with = format!("{HEADER},velocity_x_m_s,velocity_y_m_s");
        let both = read(&text(&with, 7)).unwrap().expect("planar");
        assert_eq!(both.axes[1].velocity.as_ref().unwrap()[10], 0.3 * 0.01);
        // and back
        assert_eq!(read(&both.to_csv().unwrap()).unwrap().unwrap().axes, both.axes);
    }

    #[test]
    fn half_a_pair_is_refused_with_the_missing_column() {
        let says = |header: &str, columns| {
            PlanarRecording::from_bytes("a.csv", text(header, columns).as_bytes()).unwrap_err().to_string()
        };
        assert_eq!(
            says("time_s,position_x_m,force_x_n,force_y_n", 4),
            "a.csv: position_x_m without position_y_m: a recording in the plane has both, or neither"
        );
        assert!(
            says("time_s,position_x_m,position_y_m,force_y_n", 4).contains("force_y_n without force_x_n")
        );
        assert!(
            says(&format!("{HEADER},velocity_y_m_s"), 6).contains("velocity_y_m_s without velocity_x_m_s")
        );
        assert!(says("time_s,position_x_m,position_y_m", 3).contains("no force_x_n and force_y_n"));
    }

    #[test]
    fn a_recording_on_a_line_is_none_and_a_planar_one_is_refused_as_one() {
        let line = text("time_s,position_m,force_n", 3);
        assert_eq!(PlanarRecording::from_bytes("a.csv", line.as_bytes()).unwrap(), None);
        let beside = text("time_s,position_m,force_n,force_x_n", 4);
        assert_eq!(PlanarRecording::from_bytes("a.csv", beside.as_bytes()).unwrap(), None);
        for (header, columns) in [(HEADER, 5), ("time_s,position_x_m,force_x_n", 3)] {
            let read = Recording::from_bytes(
                "a.csv",
                text(header, columns).as_bytes(),
                &crate::ReadOptions::default(),
            );
            let said = read.unwrap_err().to_string();
            assert!(said.contains("recording in the plane"), "{said}");
        }
    }

    #[test]
    fn what_one_axis_lacks_is_left_out_of_both() {
        let mut planar = PlanarRecording::from_bytes("a.csv", text(HEADER, 5).as_bytes()).unwrap().unwrap();
        // twenty samples of y are lost
        planar.axes[1].position[150..170].fill(f64::NAN);
        let prepared = prepare_planar(&planar, &Settings::default()).unwrap();
        let spans: Vec<(f64, usize)> = prepared.stretches.iter().map(|[x, _]| (x.start, x.len())).collect();
        println!("{spans:?}");
        assert_eq!(spans.len(), 2);
        for [x, y] in &prepared.stretches {
            assert_eq!((x.len(), x.start), (y.len(), y.start));
        }
        assert!((spans[1].0 - 0.170).abs() < 1e-9);
        assert!(prepared.report.channels.contains_key("position_y"));
    }
}
