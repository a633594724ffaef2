//! Figures of the firmware under full load: full telemetry, a serial line flooded with commands and garbage, preset swaps, a
//! hand that slides and sticks.

use crate::flood::{Flood, Kind};
use crate::{Image, Machine, UNITS_PER_SECOND};
use link::{Decoder, Frame, Item, Sample, reply};
use serde::Serialize;
use std::fmt;

/// Bytes typed ahead by the terminal: the line is always busy, and typed bytes are sent soon.
const AHEAD: usize = 256;
/// Smallest sliding speed of the handle, m/s.
const SLIDING: f64 = 1e-3;

/// The figures. Times are virtual; cycles are those of an interpreter with modelled waits for flash, CCM SRAM and buses.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Report {
    /// Observed time, s.
    pub seconds: f64,
    /// Control rate, Hz.
    pub rate_hz: f64,
    /// From power-on to the first control step, ms.
    pub boot_ms: f64,
    /// Control steps in that time.
    pub steps: u64,
    /// Expected control steps.
    pub steps_due: u64,
    /// Samples not served, and triggers at a busy converter.
    pub missed: u64,
    /// Forces that were not ready when the DAC latched.
    pub late: u64,
    /// Largest time from end of conversion to DAC output, µs.
    pub latency_us_max: f64,
    /// The same, mean, µs.
    pub latency_us_mean: f64,
    /// The same, largest less smallest, µs.
    pub jitter_us: f64,
    /// End of conversion to the force in the DAC's holding register: largest, µs.
    pub ready_us_max: f64,
    /// Control interrupt from entry to exit: mean, cycles.
    pub step_cycles_mean: f64,
    /// The same, largest, cycles.
    pub step_cycles_max: f64,
    /// Share of time with the core awake.
    pub load: f64,
    /// Largest stack use, bytes.
    pub stack_bytes: u32,
    /// Programmed flash, bytes.
    pub flash_bytes: usize,
    /// Static data, bytes.
    pub ram_bytes: usize,
    /// Telemetry frames received intact.
    pub frames: u64,
    /// Frames missing between the first and the last, or corrupt.
    pub frames_lost: u64,
    /// Answers to commands and to garbage: `ok …`.
    pub commands_answered: u64,
    /// The same: `err …`.
    pub commands_refused: u64,
    /// Valid commands typed.
    pub commands_typed: u64,
    /// Bytes of garbage typed.
    pub garbage_bytes: u64,
    /// Preset swaps while rendering.
    pub preset_swaps: u64,
    /// Bytes lost by the receiver.
    pub serial_overruns: u64,
    /// Share of time in which the handle slid. Otherwise it stuck.
    pub sliding_share: f64,
    /// Resets since power-on, with time and reason.
    pub resets: Vec<String>,
    /// First fault in the telemetry. 0 for none.
    pub fault: u8,
    /// Violations of the data sheet by the firmware.
    pub violations: Vec<String>,
    /// Whether all bars are met.
    pub met: bool,
}

/// Reason why the firmware cannot be observed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Unfit {
    /// No control step.
    #[error("the firmware made no control step within {0} ms of power-on")]
    NoStep(f64),
    /// A necessary command was refused.
    #[error("`{command}` failed: {answer}")]
    Refused {
        /// Typed line.
        command: String,
        /// Answer, or its absence.
        answer: String,
    },
    /// Invalid observation time.
    #[error("seconds = {0}: expected 0.1 to 3600")]
    Seconds(f64),
}

/// Boots the image and observes it for `seconds` of virtual time. Calls `progress` with the share done.
///
/// # Errors
/// The firmware does not run, or refuses a necessary command.
pub fn observe(image: &Image, seconds: f64, mut progress: impl FnMut(f64)) -> Result<Report, Unfit> {
    if !(0.1..=3600.0).contains(&seconds) {
        return Err(Unfit::Seconds(seconds));
    }
    let mut bench = Bench::new(Machine::free_handle(image, 1));
    const BOOT_MS: f64 = 200.0;
    bench.run(BOOT_MS);
    let boot_ms = bench.machine.first_step_ms().ok_or(Unfit::NoStep(BOOT_MS))?;
    // the banner and other first output
    for command in ["zero", "preset use rubber", "render on", "stream on"] {
        bench.obeyed(command)?;
    }
    bench.machine.set_hand(to_and_fro);
    bench.run(20.0);
    bench.begin();
    let whole = (seconds * 1000.0).round() as u64;
    for ms in 0..whole {
        bench.flood();
        bench.run(1.0);
        if ms % 100 == 0 {
            progress(ms as f64 / whole as f64);
        }
    }
    Ok(bench.report(image, whole as f64 / 1000.0, boot_ms))
}

/// A hand that moves the handle back and forth by 8 mm, and holds it still every fourth second.
fn to_and_fro(t: f64, x: f64, v: f64) -> f64 {
    let phase = t % 4.0;
    let omega = std::f64::consts::TAU;
    let (target, speed) = if phase < 3.0 {
        (8e-3 * (omega * phase).sin(), 8e-3 * omega * (omega * phase).cos())
    } else {
        (0.0, 0.0)
    };
    1_500.0 * (target - x) + 15.0 * (speed - v)
}

/// The board with the flood on its serial line.
struct Bench {
    machine: Machine,
    decoder: Decoder,
    flood: Flood,
    lines: Vec<String>,
    period_ticks: Option<(u32, u32)>,
    last_seq: Option<u32>,
    frames: u64,
    lost: u64,
    fault: u8,
    answered: u64,
    refused: u64,
    swaps: u64,
    typed: u64,
    garbage: u64,
    sliding: u64,
    slices: u64,
}

impl Bench {
    fn new(machine: Machine) -> Self {
        Self {
            machine,
            decoder: Decoder::new(),
            flood: Flood::new(1),
            lines: Vec::new(),
            period_ticks: None,
            last_seq: None,
            frames: 0,
            lost: 0,
            fault: 0,
            answered: 0,
            refused: 0,
            swaps: 0,
            typed: 0,
            garbage: 0,
            sliding: 0,
            slices: 0,
        }
    }

    fn run(&mut self, ms: f64) {
        self.machine.run_for(ms);
        self.slices += 1;
        self.sliding += u64::from(self.machine.truth().velocity.abs() > SLIDING);
        for byte in self.machine.serial_read() {
            match self.decoder.push(byte) {
                Some(Item::Text(line)) => self.lines.push(line.to_owned()),
                Some(Item::Frame(_, Frame::Header(header))) => {
                    self.period_ticks = Some((header.tick_hz, header.period_ticks));
                }
                Some(Item::Frame(seq, Frame::Sample(sample))) => self.frame(seq, &sample),
                Some(Item::Corrupt(_)) => self.lost += 1,
                None => {}
            }
        }
        for line in self.lines.iter().filter(|line| reply::is_answer(line)) {
            if line.starts_with("err") {
                self.refused += 1;
            } else {
                self.answered += 1;
                self.swaps +=
                    u64::from(["ok brass", "ok teflon", "ok rubber"].iter().any(|s| line.starts_with(s)));
            }
        }
    }

    fn frame(&mut self, seq: u32, sample: &Sample) {
        if let Some(last) = self.last_seq.replace(seq) {
            self.lost += u64::from(seq.wrapping_sub(last).saturating_sub(1));
        }
        self.frames += 1;
        if self.fault == 0 {
            self.fault = sample.fault;
        }
    }

    fn obeyed(&mut self, command: &str) -> Result<(), Unfit> {
        self.machine.serial_write(format!("{command}\n").as_bytes());
        for _ in 0..200 {
            self.lines.clear();
            self.run(1.0);
            if let Some(answer) = self.lines.iter().find(|line| reply::is_answer(line)) {
                return if answer.starts_with("ok") { Ok(()) } else { Err(refused(command, answer)) };
            }
        }
        Err(refused(command, "no answer within 200 ms"))
    }

    /// Starts the observation.
    fn begin(&mut self) {
        self.machine.reset_statistics();
        (self.answered, self.refused, self.swaps, self.sliding, self.slices) = (0, 0, 0, 0, 0);
        (self.frames, self.lost, self.fault) = (0, 0, 0);
    }

    fn flood(&mut self) {
        self.lines.clear();
        while self.machine.serial_waiting() < AHEAD {
            let (kind, bytes) = self.flood.piece();
            self.machine.serial_write(&bytes);
            match kind {
                Kind::Command => self.typed += 1,
                Kind::Refused => {}
                Kind::Garbage => self.garbage += bytes.len() as u64,
            }
        }
    }

    fn report(self, image: &Image, seconds: f64, boot_ms: f64) -> Report {
        let s = self.machine.statistics();
        let rate_hz = self.period_ticks.map_or(0.0, |(hz, ticks)| f64::from(hz) / f64::from(ticks.max(1)));
        let mut report = Report {
            seconds,
            rate_hz,
            boot_ms,
            steps: s.steps,
            steps_due: (s.elapsed as f64 / UNITS_PER_SECOND as f64 * rate_hz).round() as u64,
            missed: s.missed,
            late: s.stale_outputs,
            latency_us_max: s.latency_us.max,
            latency_us_mean: s.latency_us.mean(),
            jitter_us: s.latency_us.spread(),
            ready_us_max: s.compute_us.max,
            step_cycles_mean: s.step_cycles.mean(),
            step_cycles_max: s.step_cycles.max,
            load: s.load(),
            stack_bytes: self.machine.stack_bytes(),
            flash_bytes: image.flash_bytes,
            ram_bytes: image.ram_bytes,
            frames: self.frames,
            frames_lost: self.lost,
            commands_answered: self.answered,
            commands_refused: self.refused,
            commands_typed: self.typed,
            garbage_bytes: self.garbage,
            preset_swaps: self.swaps,
            serial_overruns: self.machine.serial_overruns(),
            sliding_share: self.sliding as f64 / self.slices.max(1) as f64,
            resets: self
                .machine
                .resets()
                .iter()
                .map(|(at, cause)| format!("{cause:?} at {at:.1} ms"))
                .collect(),
            fault: self.fault,
            violations: self.machine.violations().into_iter().collect(),
            met: false,
        };
        report.met = report.bars().iter().all(|bar| bar.met);
        report
    }
}

fn refused(command: &str, answer: &str) -> Unfit {
    Unfit::Refused { command: command.to_owned(), answer: answer.to_owned() }
}

/// A figure and its bar.
#[derive(Debug, Clone, PartialEq)]
pub struct Bar {
    /// Name of the figure.
    pub what: &'static str,
    /// Observed value with its unit.
    pub figure: String,
    /// Required value.
    pub bar: String,
    /// Whether the bar is met.
    pub met: bool,
}

impl Report {
    /// All figures with their bars.
    #[must_use]
    pub fn bars(&self) -> Vec<Bar> {
        let bar = |what, figure: String, bar: &str, met| Bar { what, figure, bar: bar.to_owned(), met };
        let due = self.steps_due;
        vec![
            bar(
                "boot to first control step",
                format!("{:.2} ms", self.boot_ms),
                "< 100 ms",
                self.boot_ms < 100.0,
            ),
            bar("control steps", self.steps.to_string(), &format!("{due}"), self.steps == due && due > 0),
            bar(
                "missed, late",
                format!("{}, {}", self.missed, self.late),
                "0, 0",
                self.missed + self.late == 0,
            ),
            bar(
                "sample to force output, worst",
                format!("{:.2} us", self.latency_us_max),
                "<= 20 us",
                self.latency_us_max <= 20.0,
            ),
            bar("its jitter", format!("{:.3} us", self.jitter_us), "< 1 us", self.jitter_us < 1.0),
            bar(
                "control step, worst",
                format!("{:.0} cycles (mean {:.0})", self.step_cycles_max, self.step_cycles_mean),
                "< 1700 cycles",
                self.step_cycles_max < 1700.0,
            ),
            bar("flash", format!("{} B", self.flash_bytes), "< 262144 B", self.flash_bytes < 262_144),
            bar("static RAM", format!("{} B", self.ram_bytes), "< 32768 B", self.ram_bytes < 32_768),
            bar(
                "stack, high water",
                format!("{} B", self.stack_bytes),
                "with static RAM < 98304 B",
                self.ram_bytes + (self.stack_bytes as usize) < 98_304,
            ),
            bar("telemetry frames lost", format!("{} of {}", self.frames_lost, self.frames), "0", {
                self.frames_lost == 0 && self.frames > 0
            }),
            bar(
                "faults, resets",
                format!(
                    "{}, {}",
                    self.fault,
                    if self.resets.is_empty() { "0".into() } else { self.resets.join("; ") }
                ),
                "0, 0",
                self.fault == 0 && self.resets.is_empty(),
            ),
            bar(
                "against the data sheet",
                if self.violations.is_empty() { "nothing".into() } else { self.violations.join("; ") },
                "nothing",
                self.violations.is_empty(),
            ),
        ]
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "{} virtual s at {:.0} Hz, stream on, handle sliding {:.0} % of the time; serial line flooded with",
            self.seconds,
            self.rate_hz,
            100.0 * self.sliding_share
        )?;
        writeln!(
            f,
            "{} commands and {} B of garbage: {} answered ok, {} err; {} presets swapped; core awake {:.1} %",
            self.commands_typed,
            self.garbage_bytes,
            self.commands_answered,
            self.commands_refused,
            self.preset_swaps,
            100.0 * self.load
        )?;
        writeln!(f)?;
        writeln!(f, "| what | figure | bar | |")?;
        writeln!(f, "| --- | --- | --- | --- |")?;
        for bar in self.bars() {
            let verdict = if bar.met { "met" } else { "**NOT met**" };
            writeln!(f, "| {} | {} | {} | {verdict} |", bar.what, bar.figure, bar.bar)?;
        }
        write!(f, "\nCycles with modelled waits for flash, CCM SRAM and buses.")
    }
}
