//! Records a device into a file that survives a crash.
//!
//! The file grows as `NAME.part`, metadata first, flushed ten times a second, and is renamed when complete. After a power cut
//! the `.part` is a readable recording up to its last flush. A recording that is ended early is kept.

use crate::clock::ClockRatio;
use crate::columns;
use crate::error::{Error, Result};
use crate::moves::Move;
use crate::sample::{Header, Sample};
use crate::session::{Event, Session};
use signals::files::{self, FileError};
use std::fs::File;
use std::io::{BufWriter, Write};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Time before a recording begins, while the excitation ramps in and settles, s.
const WARM_UP_S: f64 = 1.5;
/// Silence of the host after which the device releases the handle during this recording, s.
const WATCH_S: u32 = 2;
/// Interval of the sign of life to the device while samples arrive, s.
const ALIVE_S: f64 = 0.25;
/// Silence on the line that ends the stream.
const SILENCE: Duration = Duration::from_secs(2);
/// Longest time in which a stopped motion ramps out.
const RAMPED: Duration = Duration::from_secs(3);

/// Plan of a recording.
#[derive(Debug, Clone)]
pub struct Plan {
    /// Excitation. Without one, a person moves the handle.
    pub motion: Option<Move>,
    /// Length, s.
    pub seconds: f64,
    /// Additional metadata lines.
    pub notes: Vec<(String, String)>,
}

/// Summary of a recording.
#[derive(Debug, Clone, PartialEq)]
pub struct Recorded {
    /// Number of samples in the file.
    pub samples: u64,
    /// Length, s.
    pub seconds: f64,
    /// Number of samples lost by device or line.
    pub lost: u64,
    /// Whether it was ended early.
    pub interrupted: bool,
}

/// Runs the plan and writes `path`. Calls `watch` with the recorded share many times a second; `watch` can end the recording
/// early.
///
/// # Errors
/// The device refuses a command, falls silent or stops on a fault; the file cannot be written; the recording was ended
/// before its first sample.
pub fn record(
    session: &mut Session,
    plan: &Plan,
    path: &Path,
    watch: &mut dyn FnMut(f32) -> ControlFlow<()>,
) -> Result<Recorded> {
    files::check_writable(path)?;
    let mut patience = None;
    let warm_up = if let Some(motion) = &plan.motion {
        // the silence limit is the user's choice: it is restored afterwards
        patience = session.command("watch")?.split_whitespace().nth(2).map(str::to_owned);
        session.command(&format!("watch {WATCH_S}"))?;
        let length = plan.seconds + WARM_UP_S + 0.1;
        session.command(&format!(
            "move {} {} {} {length}",
            motion.wave.id(),
            motion.amplitude,
            motion.frequency
        ))?;
        WARM_UP_S
    } else {
        0.0
    };
    session.command("stream on")?;
    let outcome = take(session, plan, path, warm_up, watch);
    // the device is always left quiet; the first failure is reported
    let ending = if plan.motion.is_some() && !matches!(outcome, Ok(Recorded { interrupted: false, .. })) {
        "off"
    } else {
        "stop"
    };
    let quiet = session.command(ending).and_then(|_| session.command("stream off"));
    let quiet = quiet.and_then(|_| settle(session));
    let quiet =
        match patience.map(|seconds| if seconds.starts_with("off") { "0".to_owned() } else { seconds }) {
            Some(seconds) => quiet.and_then(|_| session.command(&format!("watch {seconds}"))),
            None => quiet,
        };
    let recorded = outcome.map_err(|error| {
        let part = files::part(path);
        if part.exists() { Error::Partial { error: Box::new(error), part } } else { error }
    })?;
    quiet?;
    Ok(recorded)
}

/// Waits until a stopped motion has ramped out: the next command would find the device busy.
fn settle(session: &mut Session) -> Result<String> {
    let began = Instant::now();
    loop {
        let status = session.command("status")?;
        if !status.contains(haptics::ModeId::Exciting.id()) || began.elapsed() > RAMPED {
            return Ok(status);
        }
    }
}

fn take(
    session: &mut Session,
    plan: &Plan,
    path: &Path,
    warm_up: f64,
    watch: &mut dyn FnMut(f32) -> ControlFlow<()>,
) -> Result<Recorded> {
    let mut header: Option<Header> = None;
    let mut file: Option<RecordingFile> = None;
    let mut lost = 0;
    let mut heard = Instant::now();
    let mut last = 0.0;
    let mut last_sign = f64::NEG_INFINITY;
    loop {
        let events = session.poll()?;
        if heard.elapsed() > SILENCE {
            return Err(Error::Silent { port: session.name().to_owned(), seconds: SILENCE.as_secs() });
        }
        for event in events {
            if !matches!(event, Event::Text(_)) {
                heard = Instant::now();
            }
            match event {
                Event::Header(h) => header = Some(h),
                Event::Lost(frames) if file.is_some() => lost += frames,
                Event::Lost(_) => {}
                // `command` reads answers; unsolicited messages are not part of a recording
                Event::Text(_) => {}
                Event::Sample(sample) => {
                    let Some(header) = &header else { continue };
                    if let Some(fault) = fault_of(&sample) {
                        return Err(Error::Fault { port: session.name().to_owned(), fault });
                    }
                    let time = sample.time - warm_up;
                    if time - last_sign > ALIVE_S {
                        last_sign = time;
                        session.send_line("")?;
                    }
                    if time < -1e-9 {
                        continue;
                    }
                    if time >= plan.seconds - 0.5 * header.sample_period() {
                        return finish(file, path, last, lost, false);
                    }
                    if file.is_none() {
                        file = Some(RecordingFile::create(path, header, plan)?);
                    }
                    let Some(open) = file.as_mut() else { continue };
                    // a sample missed by the device is also lost, and shows as a gap in time
                    open.write(&Sample { time, ..sample })?;
                    last = time;
                }
            }
        }
        if watch((last / plan.seconds) as f32).is_break() {
            return finish(file, path, last, lost, true);
        }
    }
}

fn fault_of(sample: &Sample) -> Option<String> {
    (sample.fault != 0).then(|| match haptics::FaultKind::from_code(sample.fault) {
        Some(kind) => kind.explain().to_string(),
        None => format!("number {}", sample.fault),
    })
}

fn finish(
    file: Option<RecordingFile>,
    path: &Path,
    seconds: f64,
    lost: u64,
    interrupted: bool,
) -> Result<Recorded> {
    let Some(file) = file else {
        return Err(Error::Interrupted(path.to_owned()));
    };
    let samples = file.finish(lost)?;
    Ok(Recorded { samples, seconds, lost, interrupted })
}

/// A growing recording file.
pub struct RecordingFile {
    path: PathBuf,
    out: BufWriter<File>,
    samples: u64,
    created: Instant,
    flushed: Instant,
    clock: ClockRatio,
}

impl RecordingFile {
    /// Creates the file, with the units of the device and the metadata of the stream's header.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn create(path: &Path, header: &Header, plan: &Plan) -> Result<Self> {
        let file = File::create(files::part(path)).map_err(|e| FileError::unwritable(path, &e))?;
        let mut out = BufWriter::new(file);
        write_head(&mut out, header, plan).map_err(|e| FileError::unwritable(path, &e))?;
        let (created, clock) = (Instant::now(), ClockRatio::default());
        Ok(Self { path: path.to_owned(), out, samples: 0, created, flushed: created, clock })
    }

    /// Appends a sample.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn write(&mut self, sample: &Sample) -> Result<()> {
        self.samples += 1;
        self.clock.sample(sample.time, self.created.elapsed().as_secs_f64());
        let flush = self.flushed.elapsed() > Duration::from_millis(100);
        let written =
            write_row(&mut self.out, sample).and_then(|()| if flush { self.out.flush() } else { Ok(()) });
        if flush {
            self.flushed = Instant::now();
        }
        Ok(written.map_err(|e| FileError::unwritable(&self.path, &e))?)
    }

    /// Completes and renames the file. Returns its number of samples.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn finish(mut self, lost: u64) -> Result<u64> {
        let part = files::part(&self.path);
        let ratio = match self.clock.measured() {
            Some((ratio, error)) => format!("# clock_ratio: {ratio:.6} +- {error:.6} (device / computer)\n"),
            None => String::new(),
        };
        writeln!(self.out, "{ratio}# lost_samples: {lost}")
            .and_then(|()| self.out.flush())
            .and_then(|()| self.out.get_ref().sync_all())
            .and_then(|()| std::fs::rename(&part, &self.path))
            .map_err(|e| FileError::unwritable(&self.path, &e))?;
        Ok(self.samples)
    }

    /// Removes the unfinished file.
    pub fn discard(self) {
        // a `.part` file left by a crash is not a recording
        let _ = std::fs::remove_file(files::part(&self.path));
    }
}

/// Metadata lines and the header of a recording.
fn write_head(out: &mut impl Write, header: &Header, plan: &Plan) -> std::io::Result<()> {
    writeln!(out, "# recorded_by: tribos {}", env!("CARGO_PKG_VERSION"))?;
    if let Some(motion) = &plan.motion {
        writeln!(out, "# move: {} {} {}", motion.wave.id(), motion.amplitude, motion.frequency)?;
    }
    let mut heads = header.notes();
    heads.retain(|(key, _)| plan.notes.iter().all(|(newer, _)| newer != key));
    for (key, value) in plan.notes.iter().chain(&heads) {
        // a line break in a note would end the comment
        writeln!(out, "# {key}: {}", value.replace(['\n', '\r'], " "))?;
    }
    writeln!(out, "{}", columns::names(header.geometry()).join(","))
}

/// One sample.
fn write_row(out: &mut impl Write, sample: &Sample) -> std::io::Result<()> {
    for (k, (value, decimals)) in columns::values(sample).into_iter().enumerate() {
        let comma = if k > 0 { "," } else { "" };
        write!(out, "{comma}{value:.decimals$}")?;
    }
    writeln!(out)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample::Calibration;
    use friction::Geometry;
    use link::Mechanics;
    use signals::{ReadOptions, Recording};

    #[test]
    fn a_second_recording_right_after_the_first_found_the_device_busy() {
        let path = std::env::temp_dir().join(format!("tribos-twice-{}.csv", std::process::id()));
        let motion = "sine 0.01 2".parse().unwrap();
        let plan = Plan { motion: Some(motion), seconds: 0.5, notes: Vec::new() };
        let mut session = Session::open("sim", 1).unwrap();
        for _ in 0..2 {
            let recorded = record(&mut session, &plan, &path, &mut |_| ControlFlow::Continue(())).unwrap();
            assert_eq!(recorded.samples, 500);
            assert!(session.command("status").unwrap().contains("idle"));
        }
        std::fs::remove_file(&path).unwrap();
    }

    #[test]
    fn a_rotary_device_is_recorded_in_radians() {
        let path = std::env::temp_dir().join(format!("tribos-rotary-{}.csv", std::process::id()));
        let header = Header {
            calibration: Calibration {
                tick_hz: 170e6,
                metre_per_count: 7.67e-4,
                origin_count: 0,
                load_offset: 32_768.0,
                load_unit: -1.5e-5,
                accel_offset: 32_768.0,
                accel_unit: 0.1,
            },
            decimation: 1,
            period: 1e-3,
            preset: "brass".into(),
            mechanics: Mechanics {
                rotary: true,
                stroke: 2.0,
                mass: 1e-4,
                damping: 1e-3,
                force_max: 0.2,
                overspeed: 60.0,
            },
        };
        let plan = Plan { motion: None, seconds: 1.0, notes: Vec::new() };
        let mut file = RecordingFile::create(&path, &header, &plan).unwrap();
        for k in 0..100 {
            let time = 1e-3 * f64::from(k);
            file.write(&Sample { time, position: 0.1 * time, force: 0.05, ..Sample::default() }).unwrap();
        }
        file.finish(0).unwrap();
        let text = std::fs::read_to_string(&path).unwrap();
        let read = Recording::read(&path, &ReadOptions::default()).unwrap();
        std::fs::remove_file(&path).unwrap();
        println!("{}", text.lines().take(10).collect::<Vec<_>>().join("\n"));
        assert!(text.contains(
            "\ntime_s,position_rad,velocity_rad_s,acceleration_rad_s2,torque_nm,command_nm,reference_rad\n"
        ));
        assert!(
            text.contains("# radian_per_count: 0.000767\n") && text.contains("# newton_metre_per_code: ")
        );
        assert_eq!((read.geometry, read.force[50]), (Geometry::Rotary, 0.05));
        // the limits of the device, not of the default one
        let device = header.device();
        assert_eq!((device.stroke, device.force_max, device.geometry), (2.0, 0.2, Geometry::Rotary));
        assert!(device.tracking_stiffness < 1.0);
    }
}
