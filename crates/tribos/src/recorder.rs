//! Records a device: commands, frames, SI, and a file that survives a crash.
//!
//! The file grows as `NAME.part`, metadata first, flushed ten times a second, and takes its name when it is complete;
//! after a power cut the `.part` is a readable recording up to its last flush. Ctrl-C ends a recording early and
//! keeps what there is.

use crate::failure::{Failure, Result};
use crate::files::{self, unwritable};
use crate::moves::Move;
use crate::progress::Progress;
use crate::raw::Point;
use crate::session::{Event, Header, Sample, Session};
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Time before a recording begins, while the excitation ramps in and settles, s.
pub(crate) const WARM_UP_S: f64 = 1.5;
/// Silence after which the device lets go of a handle it moves for this recording, s.
const WATCH_S: u32 = 2;
/// Samples are heard this long before the device is told so, s.
const ALIVE_S: f64 = 0.25;
/// Silence on the line after which the stream is given up.
const SILENCE: Duration = Duration::from_secs(2);

/// What to record.
#[derive(Debug, Clone)]
pub(crate) struct Plan {
    /// Excitation, or none: whatever moves the handle.
    pub motion: Option<Move>,
    /// Length, s.
    pub seconds: f64,
    /// Lines for the file's head, beside what the header of the stream says.
    pub notes: Vec<(String, String)>,
}

/// What was recorded.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Recorded {
    /// Samples in the file.
    pub samples: u64,
    /// Length, s.
    pub seconds: f64,
    /// Samples the device or the line lost.
    pub lost: u64,
    /// Ctrl-C ended it early.
    pub interrupted: bool,
}

/// Ctrl-C was pressed since [`watch_ctrl_c`].
static INTERRUPTED: AtomicBool = AtomicBool::new(false);

/// Ctrl-C was pressed since the last recording began.
pub(crate) fn interrupted() -> bool {
    INTERRUPTED.load(Ordering::SeqCst)
}

/// From now on Ctrl-C asks a recording to end instead of ending the process.
fn watch_ctrl_c() {
    static HANDLER: OnceLock<()> = OnceLock::new();
    HANDLER.get_or_init(|| {
        // Without a handler Ctrl-C still ends the process, and the .part file stays readable.
        let _ = ctrlc::set_handler(|| INTERRUPTED.store(true, Ordering::SeqCst));
    });
    INTERRUPTED.store(false, Ordering::SeqCst);
}

/// Runs the plan and writes `path`.
///
/// # Errors
/// The device refuses a command, falls silent or stops on a fault; the file cannot be written.
pub(crate) fn record(session: &mut Session, plan: &Plan, path: &Path) -> Result<Recorded> {
    files::check_writable(path)?;
    watch_ctrl_c();
    let mut watch = None;
    let warm_up = if let Some(motion) = &plan.motion {
        // how long the device waits for a host is the user's choice: it is put back afterwards
        watch = session.command("watch")?.split_whitespace().nth(2).map(str::to_owned);
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
    let outcome = take(session, plan, path, warm_up);
    // The device is left quiet whatever happened; the first failure is the one to tell.
    let quiet = session.command("stream off").and_then(|_| session.command("stop"));
    let quiet = match watch.map(|seconds| if seconds.starts_with("off") { "0".to_owned() } else { seconds }) {
        Some(seconds) => quiet.and_then(|_| session.command(&format!("watch {seconds}"))),
        None => quiet,
    };
    let recorded = outcome.map_err(|failure| {
        let part = files::part(path);
        if part.exists() {
            failure.help(format!("what was recorded until then is in {}", part.display()))
        } else {
            failure
        }
    })?;
    quiet?;
    Ok(recorded)
}

fn take(session: &mut Session, plan: &Plan, path: &Path, warm_up: f64) -> Result<Recorded> {
    let bar = Progress::new("recording");
    let mut header: Option<Header> = None;
    let mut file: Option<RecordingFile> = None;
    let mut lost = 0;
    let mut heard = Instant::now();
    let mut last = 0.0;
    let mut told = f64::NEG_INFINITY;
    loop {
        let events = session.poll()?;
        if heard.elapsed() > SILENCE {
            return Err(Failure::new(format!("{}: no frames for {} s", session.name(), SILENCE.as_secs()))
                .help("is the device still connected? its `status` says what it does"));
        }
        for event in events {
            if !matches!(event, Event::Text(_)) {
                heard = Instant::now();
            }
            match event {
                Event::Header(h) => header = Some(h),
                Event::Lost(frames) if file.is_some() => lost += frames,
                Event::Lost(_) => {}
                // Answers to commands are read by `command`; what comes by itself is not part of a recording.
                Event::Text(_) => {}
                Event::Sample(sample) => {
                    let Some(header) = &header else { continue };
                    if let Some(fault) = fault_of(&sample) {
                        return Err(Failure::new(format!(
                            "{}: stopped by the fault {fault}",
                            session.name()
                        ))
                        .help(
                            "`fault` tells more, `clear` clears it; a smaller move asks less of the device",
                        ));
                    }
                    let time = sample.point.time - warm_up;
                    if time - told > ALIVE_S {
                        told = time;
                        session.send_line("")?;
                    }
                    if time < -1e-9 {
                        continue;
                    }
                    if time >= plan.seconds - 0.5 * header.sample_period() {
                        return finish(file, path, last, lost, false);
                    }
                    if file.is_none() {
                        file = Some(RecordingFile::create(path, &header.notes(), plan)?);
                    }
                    let Some(open) = file.as_mut() else { continue };
                    // A sample missing on the device's side is lost, too, and shows as a gap in time.
                    open.write(&Point { time, ..sample.point })?;
                    last = time;
                    bar.set((time / plan.seconds) as f32, "");
                }
            }
        }
        if INTERRUPTED.load(Ordering::SeqCst) {
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
        return Err(Failure::in_file(path, "interrupted before the first sample; nothing was written"));
    };
    let samples = file.finish(lost)?;
    Ok(Recorded { samples, seconds, lost, interrupted })
}

/// A recording that grows.
pub(crate) struct RecordingFile {
    path: PathBuf,
    out: BufWriter<File>,
    samples: u64,
    flushed: Instant,
}

impl RecordingFile {
    /// Begins one; `heads` are the lines the header of the stream gives.
    pub(crate) fn create(path: &Path, heads: &[(String, String)], plan: &Plan) -> Result<Self> {
        let file = File::create(files::part(path)).map_err(|e| unwritable(path, &e))?;
        let mut out = BufWriter::new(file);
        write_head(&mut out, heads, plan).map_err(|e| unwritable(path, &e))?;
        Ok(Self { path: path.to_owned(), out, samples: 0, flushed: Instant::now() })
    }

    /// Appends a sample.
    pub(crate) fn write(&mut self, point: &Point) -> Result<()> {
        self.samples += 1;
        let flush = self.flushed.elapsed() > Duration::from_millis(100);
        let written =
            write_row(&mut self.out, point).and_then(|()| if flush { self.out.flush() } else { Ok(()) });
        if flush {
            self.flushed = Instant::now();
        }
        written.map_err(|e| unwritable(&self.path, &e))
    }

    /// Completes the file under its name; how many samples it has.
    pub(crate) fn finish(mut self, lost: u64) -> Result<u64> {
        let part = files::part(&self.path);
        writeln!(self.out, "# lost_samples: {lost}")
            .and_then(|()| self.out.flush())
            .and_then(|()| self.out.get_ref().sync_all())
            .and_then(|()| std::fs::rename(&part, &self.path))
            .map_err(|e| unwritable(&self.path, &e))?;
        Ok(self.samples)
    }

    /// Nothing came of it.
    pub(crate) fn discard(self) {
        // a leftover under its unfinished name is no recording
        let _ = std::fs::remove_file(files::part(&self.path));
    }
}

/// Metadata lines and the header of a recording.
pub(crate) fn write_head(
    out: &mut impl Write,
    notes: &[(String, String)],
    plan: &Plan,
) -> std::io::Result<()> {
    writeln!(out, "# recorded_by: tribos {}", env!("CARGO_PKG_VERSION"))?;
    if let Some(motion) = &plan.motion {
        writeln!(out, "# move: {} {} {}", motion.wave.id(), motion.amplitude, motion.frequency)?;
    }
    for (key, value) in plan.notes.iter().chain(notes) {
        // A line break in a note would end the comment.
        writeln!(out, "# {key}: {}", value.replace(['\n', '\r'], " "))?;
    }
    writeln!(out, "time_s,position_m,velocity_m_s,acceleration_m_s2,force_n,command_n,reference_m")
}

/// One sample; finer than every sensor resolves.
pub(crate) fn write_row(out: &mut impl Write, p: &Point) -> std::io::Result<()> {
    writeln!(
        out,
        "{:.6},{:.8},{:.7},{:.5},{:.6},{:.6},{:.8}",
        p.time, p.position, p.velocity, p.acceleration, p.force, p.command, p.reference
    )
}
