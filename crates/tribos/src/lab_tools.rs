//! What the lab asks of the host command: a line to the device, recordings, analyses.

use crate::commands::{diagnose as diagnosing, experiment as experimenting, identify as identifying};
use crate::experiment;
use crate::failure::{Failure, Result};
use crate::options::Mapping;
use crate::raw::Point;
use crate::recorder::{Plan, RecordingFile};
use crate::session::{self, Session};
use crate::{files, mcap_file, reading};
use haptics::Channel;
use lab::device::{Device, Event, Header, Recorder, Sample};
use lab::{Found, Progress, Tools};
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

    /// The port can be opened now.
    ///
    /// # Errors
    /// Why not.
    pub fn check(&self) -> Result<()> {
        Session::open(&self.port, self.seed).map(|_| ())
    }
}

fn words(failure: Failure) -> String {
    failure.message().to_owned()
}

/// A session, as the lab sees it.
struct Line(Session);

fn channel(offset: f64, unit: f64) -> Channel {
    Channel { offset_code: offset as f32, unit_per_code: unit as f32 }
}

fn header(h: &session::Header) -> Header {
    let c = &h.calibration;
    let device = haptics::Device {
        tick_hz: c.tick_hz as u32,
        period: h.period as f32,
        metre_per_count: c.metre_per_count as f32,
        load: channel(c.load_offset, c.load_unit),
        accel: channel(c.accel_offset, c.accel_unit),
        ..haptics::Device::default()
    };
    Header { device, decimation: h.decimation, notes: h.notes() }
}

impl Device for Line {
    fn poll(&mut self) -> std::result::Result<Vec<Event>, String> {
        let events = self.0.poll().map_err(words)?;
        let seen = events.into_iter().map(|event| match event {
            session::Event::Text(line) => Event::Text(line),
            session::Event::Header(h) => Event::Header(Box::new(header(&h))),
            session::Event::Lost(count) => Event::Lost(count),
            session::Event::Sample(s) => Event::Sample(Sample {
                time: s.point.time,
                position: s.point.position,
                velocity: s.point.velocity,
                acceleration: s.point.acceleration,
                force: s.point.force,
                command: s.point.command,
                reference: s.point.reference,
                mode: s.mode,
                fault: s.fault,
            }),
        });
        Ok(seen.collect())
    }

    fn send(&mut self, line: &str) -> std::result::Result<(), String> {
        self.0.send_line(line).map_err(words)
    }
}

impl Recorder for RecordingFile {
    fn sample(&mut self, s: &Sample) -> std::result::Result<(), String> {
        let point = Point {
            time: s.time,
            position: s.position,
            velocity: s.velocity,
            acceleration: s.acceleration,
            force: s.force,
            command: s.command,
            reference: s.reference,
        };
        self.write(&point).map_err(words)
    }

    fn finish(self: Box<Self>, lost: u64) -> std::result::Result<u64, String> {
        (*self).finish(lost).map_err(words)
    }

    fn discard(self: Box<Self>) {
        (*self).discard();
    }
}

impl Tools for HostTools {
    fn port(&self) -> &str {
        &self.port
    }

    fn open(&self) -> std::result::Result<Box<dyn Device>, String> {
        let mut session = Session::open(&self.port, self.seed).map_err(words)?;
        session.in_real_time();
        Ok(Box::new(Line(session)))
    }

    fn record(
        &self,
        path: &Path,
        header: &Header,
        notes: &[(String, String)],
    ) -> std::result::Result<Box<dyn Recorder>, String> {
        // what the header knows of the preset is from when the stream began
        let heads: Vec<_> = header.notes.iter().filter(|(key, _)| key != "preset").cloned().collect();
        let plan = Plan { motion: None, seconds: 0.0, notes: notes.to_vec() };
        let file = RecordingFile::create(path, &heads, &plan).map_err(words)?;
        Ok(Box::new(file))
    }

    fn identify(
        &self,
        recordings: &[PathBuf],
        report: &Path,
        progress: Progress<'_>,
    ) -> std::result::Result<Found, String> {
        progress(0.1, "fitting");
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
        let found = diagnose::diagnose(&train, &[], &diagnose::Options::default(), &|share, what| {
            progress(share, what);
        })
        .map_err(|e| e.to_string())?;
        let name = train.iter().map(|r| r.name.as_str()).collect::<Vec<_>>().join(", ");
        files::write(report, diagnose::report::html(&found, &name).as_bytes()).map_err(words)?;
        let preset = found.model.as_ref().map(identify::Model::preset_lines).unwrap_or_default();
        Ok(Found { text: diagnosing::outline(&name, &found), preset, ..Found::default() })
    }

    fn analyse(
        &self,
        sessions: &[PathBuf],
        report: &Path,
        progress: Progress<'_>,
    ) -> std::result::Result<Found, String> {
        progress(0.1, "fitting");
        let sessions = experiment::read(sessions).map_err(words)?;
        let analysis = experiment::analyse(&sessions, perception::Margins::THESIS);
        let html = experiment::html(&analysis).map_err(words)?;
        files::write(report, html.as_bytes()).map_err(words)?;
        let stem = report.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let mut tables = Vec::new();
        for (name, table) in experiment::tables(&sessions, &analysis) {
            let name = format!("{stem}-{name}");
            files::write(&report.with_file_name(&name), table.as_bytes()).map_err(words)?;
            tables.push(name);
        }
        Ok(Found { text: experimenting::text(&analysis), tables, ..Found::default() })
    }

    fn to_mcap(&self, recording: &Path, out: &Path) -> std::result::Result<(), String> {
        let recording = reading::read(recording, &Mapping::default()).map_err(words)?;
        mcap_file::write(out, &recording).map_err(words)
    }
}
