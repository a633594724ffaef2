//! The application in the tasks: reads bytes, executes commands, sends answers, messages and frames.

mod middle;
mod presets;
mod storing;

use super::answer::{self, Named, Pending};
use super::calibrate::{self, Calibration, Fits, RampEnd, describe};
use super::line::{self, Line};
use super::listing::{self, Listing};
use super::selftest::{Progress, SelfTest};
use super::stream::Stream;
use super::{DeskEnds, FaultReport, Handled, OriginReport, Output, Telemetry};
use crate::board::Board;
use crate::presets::NotStored;
use core::fmt::Write;
use friction::{Dimension, Geometry};
use haptics::number::Text;
use haptics::{
    Compensation, Config, Denied, Device, FaultKind, Limits, ModeId, Monitor, NOMINAL_SUPPLY, Number,
    Procedure, Refused, Request, Settings, Solver,
};
use link::{
    BadLine, CALIBRATION_KEY, Calibrate, Command, DeviceCommand, IDENTIFIED, LineEditor, MAX_LINE, Name,
    OffDetector, PresetStore, Watch,
};
use storing::{Keeping, Saving, outcome};

/// Preset after a start without a default.
const FIRST: &str = "brass";
/// Number of lines handled before other tasks run. A flood of invalid commands must not starve the watchdog.
const LINES_AT_ONCE: u32 = 4;
/// Longest time for the control loop to handle a request, ms.
const PATIENCE_MS: u32 = 500;
/// Longest silence of the host while it drives the handle, s, unless set by `watch`. An identification typed by hand takes 14.
const WATCH_S: f32 = 30.0;
/// Shortest time between promises of the host, ms.
const PROMISE_MS: u32 = 20;

/// Console, presets and stream of one device.
pub struct Desk {
    device: Device,
    settings: Settings,
    preset: Name,
    /// Whether the settings differ from the preset.
    changed: bool,
    presets: PresetStore,
    saving: Option<Saving>,
    /// A calibration that is in use and being stored.
    keeping: Option<Keeping>,
    /// Reason why presets are not persistent on this device.
    unusable: Option<NotStored>,
    editor: LineEditor,
    /// Finds the lines that a listener has heard before, see [`super::OffSwitch`].
    off: OffDetector,
    output: Output,
    /// Pending request with its time, ms. An answer is due.
    pending: Option<(Pending, u32)>,
    /// Answer of several lines, with its next line.
    listing: Option<(Listing, usize)>,
    selftest: Option<SelfTest>,
    calibration: Calibration,
    /// End of a calibration of the force.
    ramped: Option<RampEnd>,
    solver: Solver,
    stream: Option<Stream>,
    last: Option<Telemetry>,
    /// Encoder count at position 0, and that of a coming control period.
    origin: u32,
    next_origin: Option<OriginReport>,
    /// Whether the middle of the stroke was known at the last poll.
    referenced: bool,
    fault: Option<FaultReport>,
    /// A person cleared the fault; the board must learn of it.
    cleared: bool,
    /// Control periods that the tasks missed.
    unseen: u32,
    watch: Watch,
    /// Slow checks, their limits, and the fault they have found.
    monitor: Monitor,
    limits: Limits,
    alarm: Option<FaultKind>,
    /// Time of the last byte of the host since its last promise, ms.
    heard: bool,
    promised_ms: u32,
    /// Whether the self-test needs its push.
    push: bool,
}

impl Desk {
    /// The desk of a device, with the first preset.
    #[must_use]
    pub fn new(device: Device) -> Self {
        Self {
            device,
            settings: Settings::preset(FIRST).unwrap_or_default(),
            preset: Name::try_from(FIRST).unwrap_or_default(),
            changed: false,
            presets: PresetStore::new(),
            saving: None,
            keeping: None,
            unusable: None,
            editor: LineEditor::new(),
            off: OffDetector::new(),
            output: Output::new(),
            pending: None,
            listing: None,
            selftest: None,
            calibration: Calibration::default(),
            ramped: None,
            solver: Solver::new(&device, &Procedure::of(&device)),
            stream: None,
            last: None,
            origin: 0,
            next_origin: None,
            referenced: false,
            fault: None,
            cleared: false,
            unseen: 0,
            watch: Watch { seconds: WATCH_S, rendering: false },
            monitor: Monitor::default(),
            limits: Limits::of(&device),
            alarm: None,
            heard: false,
            promised_ms: 0,
            push: false,
        }
    }

    /// Initial configuration of the control loop.
    ///
    /// # Errors
    /// The first preset does not suit this device.
    pub fn config(&self) -> Result<Config, Refused> {
        self.settings.build(&self.device)
    }

    /// The device with its settings and calibration.
    #[must_use]
    pub fn device(&self) -> &Device {
        &self.device
    }

    /// Output that waits for the serial line.
    pub fn output(&mut self) -> &mut Output {
        &mut self.output
    }

    /// Number of bytes that wait for the serial line.
    #[must_use]
    pub fn waiting_output(&self) -> usize {
        self.output.waiting()
    }

    /// Whether a command or the rest of its answer is pending.
    #[must_use]
    pub fn is_busy(&self) -> bool {
        self.pending.is_some()
            || self.saving.is_some()
            || self.keeping.is_some()
            || self.listing.is_some()
            || self.selftest.is_some()
            || self.calibration.is_taking()
            || self.output.is_behind()
    }

    /// The last control period seen.
    #[must_use]
    pub fn last(&self) -> Option<&Telemetry> {
        self.last.as_ref()
    }

    /// Name of the active preset.
    #[must_use]
    pub fn preset(&self) -> &str {
        &self.preset
    }

    /// Reads bytes from the serial line up to the end of a command that must be answered first. Returns the number of bytes
    /// read; offer the rest again after [`Self::poll`].
    pub fn receive(&mut self, bytes: &[u8], ends: &mut DeskEnds<'_>, board: &mut impl Board) -> usize {
        self.heard |= !bytes.is_empty();
        let mut lines = 0;
        for (at, byte) in bytes.iter().enumerate() {
            if self.is_busy() || lines == LINES_AT_ONCE {
                return at;
            }
            let mut line: heapless::String<MAX_LINE> = heapless::String::new();
            let off = self.off.push(*byte);
            match self.editor.push(*byte) {
                // even if the line has unprintable bytes or is too long
                _ if off => self.switch_off(ends, board),
                None => continue,
                Some(Err(bad)) => self.bad_line(bad),
                Some(Ok(text)) => {
                    let _ = line.push_str(text);
                    self.execute(&line, ends, board);
                }
            }
            lines += 1;
        }
        bytes.len()
    }

    /// Advances all work. Call it every few milliseconds.
    pub fn poll(&mut self, ends: &mut DeskEnds<'_>, board: &mut impl Board) {
        while self.output.fits_line(line::LINE) {
            if let Some(handled) = ends.answers.dequeue() {
                self.handled(&handled);
            } else if let Some(fault) = ends.faults.dequeue() {
                self.faulted(&fault);
            } else if let Some(report) = ends.origins.dequeue() {
                self.referred(&report);
            } else if let Some(number) = ends.numbers.dequeue() {
                self.identified(&number);
            } else {
                break;
            }
        }
        if core::mem::take(&mut self.cleared) {
            board.forget();
        }
        if ends.off.is_ahead() && self.selftest.take().is_some() {
            self.push = false;
            self.refuse_overtaken();
        }
        if matches!(self.pending, Some((Pending::Off, _))) && !ends.off.is_asked() {
            self.pending = None;
            let mut line = Line::new();
            let _ = Pending::Off.write(ends.off.take_ended(), &self.device, &mut line);
            self.say(&line);
        }
        while let Some(telemetry) = ends.telemetry.dequeue() {
            self.see(&telemetry);
        }
        if self.pending.is_none()
            && self.keeping.is_none()
            && let Some(end) = self.ramped.take()
        {
            self.calibrate_force(end, board.now_ms(), ends);
        }
        if let Some(kind) = self.alarm.take() {
            // the pin falls at once; the loop keeps it low and latches the fault
            board.off();
            // no room: the next poll tries again
            self.alarm = ends.ask.enqueue(Request::Raise(kind)).err().map(|_| kind);
        }
        if self.pending.as_ref().is_some_and(|(_, since)| board.now_ms().wrapping_sub(*since) > PATIENCE_MS) {
            self.pending = None;
            self.err("NO_ANSWER", "the control loop is not running; see `fault`, or restart the device");
        }
        if core::mem::take(&mut self.push) {
            self.ask(Request::Probe, Pending::Push, board.now_ms(), ends);
        }
        self.promise(board.now_ms(), ends);
        self.poll_saving(board);
        self.poll_keeping(board);
        self.follow_middle(board, ends);
        self.list(board);
    }

    /// Passes on the promise of a host that drives the handle: the loop withdraws force when no bytes come.
    fn promise(&mut self, now: u32, ends: &mut DeskEnds<'_>) {
        let due = self.heard && now.wrapping_sub(self.promised_ms) >= PROMISE_MS;
        if due && self.last.is_some_and(|t| self.is_watched(t.outputs.mode)) {
            // no room: the next poll tries again
            self.heard = ends.ask.enqueue(Request::HostWatch { seconds: self.watch.seconds }).is_err();
            self.promised_ms = now;
        }
    }

    /// Whether the host must report in this mode.
    fn is_watched(&self, mode: ModeId) -> bool {
        mode.is_driven() || (self.watch.rendering && mode == ModeId::Rendering)
    }

    fn say(&mut self, line: &Line) {
        self.output.line(line);
    }

    #[inline(never)]
    fn ok(&mut self, text: core::fmt::Arguments<'_>) {
        let mut line = Line::new();
        let _ = write!(line, "ok {text}");
        self.say(&line);
    }

    /// A refusal in the units of this geometry.
    #[inline(never)] // answers are written at a hundred places; inlined, they take 30 kB of flash
    fn refused(&mut self, refused: &Refused, geometry: Geometry) {
        self.err("REFUSED", refused.on(geometry));
    }

    fn err(&mut self, code: &str, why: impl core::fmt::Display) {
        self.err_text(code, format_args!("{why}"));
    }

    #[inline(never)]
    fn err_text(&mut self, code: &str, why: core::fmt::Arguments<'_>) {
        let mut line = Line::new();
        line::err(code, why, &mut line);
        self.say(&line);
    }

    fn bad_line(&mut self, bad: BadLine) {
        self.err(bad.code(), bad);
    }

    fn faulted(&mut self, fault: &FaultReport) {
        self.fault = Some(*fault);
        let mut line = Line::new();
        let _ = write!(line, "! fault {}: {}", fault.kind, fault.kind.explain());
        self.say(&line);
    }

    fn handled(&mut self, Handled { denied, during }: &Handled) {
        let Some((pending, _)) = self.pending.take() else { return };
        if matches!(pending, Pending::Push) && (denied.is_none() || self.selftest.take().is_none()) {
            // the self-test reports its own end, or `off` has ended it
            return;
        }
        if matches!(pending, Pending::Middle) && denied.is_some() {
            // nobody asked; the next pulse or the end of a contact tells it again
            return;
        }
        let mut line = Line::new();
        if let Some(why) = denied {
            if matches!(pending, Pending::Ramp) {
                self.calibration.drop_ramp();
            }
            answer::denied(*why, self.fault_kind(), &mut line);
        } else {
            // a long line is truncated
            let _ = pending.write(*during, &self.device, &mut line);
            match pending {
                Pending::Settings { settings, name, .. } => {
                    self.settings = settings;
                    self.changed = matches!(name, Named::Parameter(_));
                    if let Named::Preset(name) = name {
                        self.preset = name;
                    }
                }
                Pending::Rate(device) | Pending::Compensation(device) => self.device = device,
                Pending::Device { device, scaled, .. } => {
                    if let Some(settings) = scaled {
                        (self.settings, self.changed) = (settings, true);
                        self.preset = Name::try_from(FIRST).unwrap_or_default();
                    }
                    self.replaced(device);
                    self.calibration.discard();
                    if let Some(stream) = &mut self.stream {
                        stream.restart();
                    }
                    self.keeping = Some(Keeping { answer: line, unasked: false, since: None });
                    return;
                }
                Pending::Clear => {
                    self.fault = None;
                    self.cleared = true;
                }
                Pending::Calibrated(device, fits) => {
                    self.calibrated(device);
                    self.calibration.discard();
                    // the answer says whether it is stored
                    self.keeping = Some(Keeping { answer: line, unasked: fits.is_of_force(), since: None });
                    return;
                }
                _ => {}
            }
        }
        self.say(&line);
    }

    fn referred(&mut self, report: &OriginReport) {
        self.next_origin = Some(*report);
        let Some(homed) = report.homed else { return };
        let mut line = Line::new();
        let _ = answer::homed(homed, &self.device, &mut line);
        self.say(&line);
    }

    fn identified(&mut self, number: &Number) {
        let Some(result) = self.solver.take(number) else { return };
        let mut line = Line::new();
        match result {
            Ok(found) => {
                let _ = answer::identified(&found, self.device.geometry, &mut line);
                self.say(&line);
                line.clear();
                let settings = found.to_settings(&self.settings, &self.device);
                let _ = match settings.validate(&self.device) {
                    Ok(_) => {
                        self.presets.set_identified(&settings);
                        write!(line, "! preset {IDENTIFIED}: `preset use {IDENTIFIED}` renders it")
                    }
                    Err(refused) => {
                        write!(line, "! this device cannot render it: {}", refused.on(self.device.geometry))
                    }
                };
            }
            Err(why) => {
                let _ = write!(line, "! not identified: {why}");
            }
        }
        self.say(&line);
    }

    fn see(&mut self, telemetry: &Telemetry) {
        if let Some(last) = &self.last {
            self.unseen = self.unseen.saturating_add(telemetry.step.wrapping_sub(last.step).wrapping_sub(1));
            if self.selftest.is_none()
                && !self.calibration.is_ramping()
                // a search tells its own end
                && matches!(last.outputs.mode, ModeId::Exciting | ModeId::Identifying)
                && telemetry.outputs.mode == ModeId::Idle
                && self.output.fits_line(line::LINE)
            {
                let mut line = Line::new();
                let _ = write!(line, "! the motion has ended");
                self.say(&line);
            }
        }
        self.last = Some(*telemetry);
        let (inputs, outputs) = (&telemetry.inputs, &telemetry.outputs);
        let found = self.monitor.sample(&self.device, &self.limits, telemetry.step, inputs, outputs);
        // the self-test looks for the same and says more
        if outputs.amplifier && self.selftest.is_none() {
            self.alarm = self.alarm.or(found);
        }
        // the report of a step is here before its telemetry
        let due = |next: &OriginReport| telemetry.step.wrapping_sub(next.step) as i32 >= 0;
        if let Some(next) = self.next_origin.take_if(|next| due(next)) {
            self.origin = next.origin;
        }
        if let Some(stream) = &mut self.stream {
            stream.take(telemetry, self.origin, &self.device, &mut self.output);
        }
        if let Some(line) = self.calibration.take(telemetry, &self.device) {
            self.say(&line);
        }
        self.ramped = self.ramped.take().or(self.calibration.take_ramp(telemetry, &self.device));
        let Some(test) = &mut self.selftest else { return };
        match test.take(telemetry, &self.device) {
            Progress::More => {}
            Progress::Push => self.push = true,
            Progress::Done => self.tested(),
        }
    }

    fn tested(&mut self) {
        let Some(test) = self.selftest.take() else { return };
        let checks = test.checks(&self.device);
        let failed = checks.iter().filter(|check| !check.passed).count();
        let mut line = Line::new();
        let _ = match failed {
            0 => write!(line, "ok selftest passed, {} lines:", checks.len()),
            _ => write!(line, "err SELFTEST: {failed} checks failed, {} lines:", checks.len()),
        };
        self.say(&line);
        self.listing = Some((Listing::Checks(checks), 0));
    }

    fn calibrate(&mut self, step: Calibrate, now: u32, ends: &mut DeskEnds<'_>) {
        match step {
            Calibrate::Status => {
                let mut line = Line::new();
                let _ = line.write_str("ok calibrate status");
                let _ = describe(&self.device, &Fits::default(), &mut line);
                self.say(&line);
            }
            Calibrate::Discard => {
                self.calibration.discard();
                self.ok(format_args!("calibrate discard: no points"));
            }
            _ if !self.is_off() => {
                self.err("BUSY", "calibrate is accepted with the amplifier off: `stop` first")
            }
            Calibrate::Point(sensor, value) => self.calibration.begin(sensor, value),
            Calibrate::Force => {
                self.calibration.begin_ramp();
                self.drive(Request::Ramp, Pending::Ramp, now, ends);
            }
            Calibrate::Save => match self.calibration.fit(&self.device) {
                Ok((device, fits)) => match self.settings.build(&device) {
                    Ok(config) => self.reconfigure(config, Pending::Calibrated(device, fits), now, ends),
                    Err(refused) => self.refused(&refused, self.device.geometry),
                },
                Err((sensor, unfit)) => self.err("CALIBRATION", format_args!("{}: {unfit}", sensor.id())),
            },
        }
    }

    /// Takes the calibration of the force into use.
    fn calibrate_force(&mut self, end: RampEnd, now: u32, ends: &mut DeskEnds<'_>) {
        let mut line = Line::new();
        // a long line is truncated
        let _ = match end {
            Ok((device, fits)) => match self.settings.build(&device) {
                Ok(config) => {
                    return self.reconfigure(config, Pending::Calibrated(device, fits), now, ends);
                }
                Err(refused) => {
                    write!(line, "! no calibration of the force: {}", refused.on(device.geometry))
                }
            },
            Err(unfit) => write!(line, "! no calibration of the force: {unfit}"),
        };
        self.say(&line);
    }

    fn calibrated(&mut self, device: Device) {
        self.device = device;
        self.solver = Solver::new(&self.device, &Procedure::of(&self.device));
    }

    /// Stores a calibration that came into use, and answers once that is done.
    fn poll_keeping(&mut self, board: &mut impl Board) {
        let Some(keeping) = &mut self.keeping else { return };
        let Some(since) = keeping.since else {
            keeping.since = Some(board.now_ms());
            board.store(CALIBRATION_KEY, &calibrate::encode(&self.device.at_supply(NOMINAL_SUPPLY)));
            return;
        };
        let Some(outcome) = outcome(since, board) else { return };
        let Some(Keeping { answer, unasked, .. }) = self.keeping.take() else { return };
        let mut line = Line::new();
        let sign = if unasked { "!" } else { "ok" };
        let _ = match outcome {
            Ok(()) => write!(line, "{sign} {answer}; {}", board.lasting()),
            Err(why) => write!(line, "{sign} warn: {answer}; until the device restarts: {why}"),
        };
        self.say(&line);
    }

    /// Sends lines of a long answer while there is room.
    fn list(&mut self, board: &impl Board) {
        while let Some((listing, at)) = &mut self.listing {
            if self.output.is_behind() {
                return;
            }
            if *at >= listing.lines(board) {
                self.listing = None;
                return;
            }
            let mut line = Line::new();
            let _ = listing.write(*at, &self.device, board, &mut line);
            *at += 1;
            self.output.line(&line);
        }
    }

    fn begin_list(&mut self, title: core::fmt::Arguments<'_>, listing: Listing, board: &impl Board) {
        self.ok(format_args!("{title}, {} lines:", listing.lines(board)));
        self.listing = Some((listing, 0));
    }

    fn fault_kind(&self) -> Option<FaultKind> {
        self.fault.map(|fault| fault.kind)
    }

    fn execute(&mut self, line: &str, ends: &mut DeskEnds<'_>, board: &mut impl Board) {
        let mut own = Line::new();
        if let Some(done) = board.command(line, &mut own) {
            return match done {
                Ok(()) => self.ok(format_args!("{own}")),
                Err(code) => self.err(code, own),
            };
        }
        let command = match Command::parse(line) {
            Ok(Some(command)) => command,
            Ok(None) => return,
            Err(bad) => return self.err(bad.code(), bad),
        };
        let now = board.now_ms();
        if ends.off.is_ahead() && switches_force_on(&command) {
            return self.refuse_overtaken();
        }
        match command {
            Command::Help => self.begin_list(format_args!("help"), Listing::Help, board),
            Command::Version => self.version(board),
            Command::Status => self.status(board),
            Command::Fault => self.tell_fault(board),
            Command::Get(None) => {
                let listing = Listing::Parameters(self.settings);
                self.begin_list(format_args!("{}", self.preset.clone()), listing, board);
            }
            Command::Get(Some(name)) => self.get(name),
            Command::Preset(command) => self.preset_command(command, now, ends, board),
            Command::Set { name, value } => self.set(name, value, now, ends),
            Command::Render(on) => {
                let limited = self.last.is_some_and(|t| !t.outputs.referenced);
                let most = limited.then(|| self.device.unreferenced_force());
                let (request, pending) = (Request::Render(on), Pending::Render(on, most));
                if on && self.watch.rendering {
                    self.drive(request, pending, now, ends);
                } else {
                    self.ask(request, pending, now, ends);
                }
            }
            Command::Zero => self.ask(Request::Zero, Pending::Zero, now, ends),
            Command::Home => self.drive(Request::Home, Pending::Home, now, ends),
            Command::Move(excitation) => match excitation.validate(&self.device) {
                Ok(()) => {
                    let pending = Pending::Move(excitation, self.watch.seconds);
                    self.drive(Request::Excite(excitation), pending, now, ends);
                }
                Err(refused) => self.refused(&refused, self.device.geometry),
            },
            Command::Identify => {
                let procedure = Procedure::of(&self.device);
                let seconds = procedure.warm_up_s + procedure.record_s;
                self.drive(Request::Identify(procedure), Pending::Identify(seconds), now, ends);
            }
            Command::Stop => self.ask(Request::Stop, Pending::Stop, now, ends),
            Command::Off => self.switch_off(ends, board),
            Command::Clear => self.ask(Request::ClearFault, Pending::Clear, now, ends),
            Command::Stream(0) => {
                let dropped = self.stream.take().map_or(0, |stream| stream.dropped());
                self.ok(format_args!("stream off, {dropped} frames dropped"));
            }
            Command::Stream(decimation) => {
                self.ok(format_args!("stream on, every {decimation} periods"));
                self.stream = Some(Stream::new(decimation, self.preset.clone()));
            }
            Command::Device(DeviceCommand::Show) => {
                self.begin_list(format_args!("device"), Listing::Device, board);
            }
            Command::Device(DeviceCommand::Set(pairs)) => self.set_device(&pairs, now, ends),
            Command::Device(DeviceCommand::Reset) => {
                let device = Device { period: self.device.period, ..board.device() };
                let mut what = heapless::String::new();
                let _ = what.push_str(" reset");
                self.change_device(device, what, now, ends);
            }
            Command::Compensate(command) => self.compensate(&command, now, ends),
            Command::Watch(watch) => self.watch(watch, ends),
            Command::Limit(None) => self.tell_limits(),
            Command::Limit(Some((name, value))) => self.limit(name, value),
            Command::Calibrate(step) => self.calibrate(step, now, ends),
            Command::Rate(None) => self.ok(format_args!("rate {:.0} Hz", Text(1.0 / self.device.period))),
            Command::Rate(Some(hz)) => self.rate(hz, now, ends),
            Command::SelfTest => match self.last.map(|t| (t.outputs.mode, t.outputs.referenced)) {
                Some((ModeId::Idle, true)) => self.selftest = Some(SelfTest::default()),
                Some((ModeId::Idle, false)) => {
                    self.err(Denied::Unreferenced.id(), Denied::Unreferenced.explain());
                }
                Some((mode, _)) => {
                    self.err("BUSY", format_args!("{}; accepted while idle: `stop` first", mode.id()))
                }
                None => self.err("NO_ANSWER", "the control loop is not running"),
            },
        }
    }

    /// Reads an `off` in its turn. The answer follows once the control loop has obeyed.
    fn switch_off(&mut self, ends: &mut DeskEnds<'_>, board: &mut impl Board) {
        ends.off.was_read();
        // again, although the listener has asked: it costs nothing, and a board may have no listener
        ends.off.ask();
        board.off();
        self.pending = Some((Pending::Off, board.now_ms()));
    }

    fn refuse_overtaken(&mut self) {
        self.err(Denied::SwitchedOff.id(), Denied::SwitchedOff.explain());
    }

    /// Sends a request that drives the handle, and the promise of the host.
    fn drive(&mut self, request: Request, pending: Pending, now: u32, ends: &mut DeskEnds<'_>) {
        self.ask(request, pending, now, ends);
        // without room, the next bytes send it
        let _ = ends.ask.enqueue(Request::HostWatch { seconds: self.watch.seconds });
    }

    /// Sends a request to the control loop. The answer follows once it is handled.
    fn ask(&mut self, request: Request, pending: Pending, now: u32, ends: &mut DeskEnds<'_>) {
        match ends.ask.enqueue(request) {
            Ok(()) => self.pending = Some((pending, now)),
            Err(_) => self.busy(),
        }
    }

    fn busy(&mut self) {
        self.err("BUSY", "the control loop has pending requests; try again");
    }

    fn watch(&mut self, watch: Option<Watch>, ends: &mut DeskEnds<'_>) {
        if let Some(watch) = watch {
            if self.watch.rendering && !watch.rendering && self.last_mode() == Some(ModeId::Rendering) {
                // without room the old promise stays, which the answer shows
                if ends.ask.enqueue(Request::HostWatch { seconds: 0.0 }).is_err() {
                    return self.busy();
                }
            }
            self.watch = watch;
        }
        let rendering = if self.watch.rendering { ", also while rendering" } else { "" };
        match self.watch.seconds {
            0.0 => self.ok(format_args!("watch off: no limit on the silence of the host")),
            seconds => self.ok(format_args!(
                "watch {} s: force off after this silence of the host{rendering}",
                Text(seconds)
            )),
        }
    }

    /// Whether the amplifier is off and stays off: idle, or a fault, whose way out may be another setting.
    fn is_off(&self) -> bool {
        matches!(self.last_mode(), Some(ModeId::Idle | ModeId::Fault))
    }

    fn last_mode(&self) -> Option<ModeId> {
        self.last.map(|t| t.outputs.mode)
    }

    fn tell_limits(&mut self) {
        let mut line = Line::new();
        let _ = line.write_str("ok limit");
        let mut limits = self.limits;
        for limit in Limits::ALL {
            let value = Text(*(limit.of)(&mut limits));
            let unit = limit.dimension.unit(self.device.geometry);
            let _ = write!(line, "; {} {value} {unit}: {}", limit.name, limit.what);
        }
        let _ = write!(line, "; motor at {:.0} % of its heat", Text(100.0 * self.monitor.heat()));
        self.say(&line);
    }

    fn limit(&mut self, name: &str, value: f32) {
        let Some(limit) = Limits::ALL.iter().find(|limit| limit.name == name) else {
            let [a, b, c] = Limits::ALL.map(|limit| limit.name);
            return self.err("UNKNOWN_PARAMETER", format_args!("`{name}`: expected one of {a}, {b}, {c}"));
        };
        let mut limits = self.limits;
        *(limit.of)(&mut limits) = value;
        match limits.validate(&self.device) {
            Ok(()) => {
                self.limits = limits;
                let unit = limit.dimension.unit(self.device.geometry);
                self.ok(format_args!("limit {name} {} {unit}", Text(value)));
            }
            Err(refused) => self.refused(&refused, self.device.geometry),
        }
    }

    fn get(&mut self, name: &str) {
        if self.settings.get(name).is_none() {
            let mut copy = self.settings;
            // the error of `set` describes the name best
            return match copy.set(name, "0") {
                Err(unknown) => self.err("UNKNOWN_PARAMETER", unknown),
                Ok(()) => self.ok(format_args!("{name} off")),
            };
        }
        let mut line = Line::new();
        let _ = line.write_str("ok ");
        let _ = answer::value(&self.settings, name, self.device.geometry, &mut line);
        self.say(&line);
    }

    fn set(&mut self, name: &str, value: &str, now: u32, ends: &mut DeskEnds<'_>) {
        let mut settings = self.settings;
        if let Err(wrong) = settings.set(name, value) {
            let known = settings.get(name).is_some();
            return self.err(if known { "VALUE" } else { "UNKNOWN_PARAMETER" }, wrong);
        }
        let named = Named::Parameter(name.chars().take(48).collect());
        self.configure(settings, named, now, ends);
    }

    fn configure(&mut self, settings: Settings, name: Named, now: u32, ends: &mut DeskEnds<'_>) {
        match settings.validate(&self.device).and_then(|w| Ok((w, settings.build(&self.device)?))) {
            Ok((warning, config)) => {
                self.reconfigure(config, Pending::Settings { settings, name, warning }, now, ends);
            }
            Err(refused) => self.refused(&refused, self.device.geometry),
        }
    }

    /// Changes the control rate if nothing moves and the active settings are stable at it.
    fn rate(&mut self, hz: u32, now: u32, ends: &mut DeskEnds<'_>) {
        if let Some(mode) = self.last.map(|t| t.outputs.mode).filter(|mode| *mode != ModeId::Idle) {
            return self.err("BUSY", format_args!("{}; accepted while idle: `stop` first", mode.id()));
        }
        let device = Device { period: 1.0 / hz as f32, ..self.device };
        match self.settings.build(&device) {
            Ok(config) => self.reconfigure(config, Pending::Rate(device), now, ends),
            Err(refused) => self.refused(&refused, self.device.geometry),
        }
    }

    /// Feed-forward of the device, checked together and with the contact.
    #[inline(never)]
    fn compensate(&mut self, command: &DeviceCommand<'_>, now: u32, ends: &mut DeskEnds<'_>) {
        let mut device = self.device;
        match command {
            DeviceCommand::Show => {
                return self.ok(format_args!("compensate {}", device.compensation.on(device.geometry)));
            }
            DeviceCommand::Reset => device.compensation = Compensation::off(&device),
            DeviceCommand::Set(pairs) => {
                for (name, value) in pairs.iter().flatten() {
                    if let Err(wrong) = device.compensation.set(name, value) {
                        let known = device.compensation.get(name).is_some();
                        return self.err(if known { "VALUE" } else { "UNKNOWN_PARAMETER" }, wrong);
                    }
                }
            }
        }
        match self.settings.build(&device) {
            Ok(config) => self.reconfigure(config, Pending::Compensation(device), now, ends),
            Err(refused) => self.refused(&refused, device.geometry),
        }
    }

    /// Settings of the device, checked together.
    #[inline(never)]
    fn set_device(&mut self, pairs: &[Option<(&str, &str)>], now: u32, ends: &mut DeskEnds<'_>) {
        let mut device = self.device;
        for (name, value) in pairs.iter().flatten() {
            if let Err(wrong) = device.set(name, value) {
                let known = device.get(name).is_some();
                return self.err(if known { "VALUE" } else { "UNKNOWN_PARAMETER" }, wrong);
            }
        }
        if let Err(refused) = device.check(|name| pairs.iter().flatten().any(|(changed, _)| *changed == name))
        {
            return self.refused(&refused, device.geometry);
        }
        // another device: what was found of this one does not hold
        device.compensation = Compensation::off(&device);
        let mut what = heapless::String::new();
        for (name, _) in pairs.iter().flatten() {
            // a long list is truncated
            let _ = write!(what, " {name} ");
            let _ = listing::value(&device, name, &mut what);
        }
        self.change_device(device, what, now, ends);
    }

    /// Changes the device while nothing moves. A contact that it cannot render is replaced.
    #[inline(never)]
    fn change_device(
        &mut self,
        device: Device,
        what: heapless::String<200>,
        now: u32,
        ends: &mut DeskEnds<'_>,
    ) {
        let rests = |t: &Telemetry| t.outputs.velocity.abs() <= self.device.rest_speed;
        if !(self.is_off() && self.last.as_ref().is_some_and(rests)) {
            return self
                .err("BUSY", "the device is set at rest, with the amplifier off: `stop`, hands off, first");
        }
        let scaled = self.stand_in(&device);
        match scaled.unwrap_or(self.settings).build(&device) {
            Ok(config) => {
                let pending = Pending::Device { device, what, scaled };
                self.reconfigure(config.on_new_device(), pending, now, ends);
            }
            Err(refused) => self.refused(&refused, device.geometry),
        }
    }

    /// Brass at the scale of a device that cannot render the present settings.
    fn stand_in(&self, device: &Device) -> Option<Settings> {
        self.settings.validate(device).err().and_then(|_| Settings::brass().scaled_to(device))
    }

    /// The device is another one.
    pub(super) fn replaced(&mut self, device: Device) {
        self.calibrated(device);
        (self.limits, self.monitor) = (Limits::of(&device), Monitor::default());
    }

    /// Sends a configuration to the control loop. The answer follows once it is in use.
    fn reconfigure(&mut self, config: Config, pending: Pending, now: u32, ends: &mut DeskEnds<'_>) {
        match ends.configure.enqueue(config) {
            Ok(()) => self.pending = Some((pending, now)),
            Err(_) => self.busy(),
        }
    }

    fn version(&mut self, board: &impl Board) {
        let mut line = Line::new();
        let (version, rate) = (env!("CARGO_PKG_VERSION"), Text(1.0 / self.device.period));
        // a long line is truncated
        let _ = write!(line, "ok tribos {version} on {}, {rate:.0} Hz, {}", board.name(), board.clock());
        if let Some(level) = board.weak_brown_out() {
            let _ = write!(line, "; option byte BOR_LEV is {level}: 4 resets the chip below 2.8 V");
        }
        let device = &self.device;
        if device.supply != NOMINAL_SUPPLY {
            let _ = write!(line, "; supply {:.3} V", Text(device.supply));
            if device.reach() < device.force_max {
                let unit = Dimension::FORCE.unit(device.geometry);
                let _ = write!(line, ": the output ends at {:.2} {unit}", Text(device.reach()));
            }
        }
        self.say(&line);
    }

    fn status(&mut self, board: &impl Board) {
        let mut line = Line::new();
        let Some(t) = self.last else {
            return self.err("NO_ANSWER", "the control loop is not running");
        };
        let changed = if self.changed { " (changed)" } else { "" };
        let unreferenced = if t.outputs.referenced { "" } else { ", unreferenced" };
        let _ = write!(line, "ok {}{unreferenced}, preset {}{changed}, ", t.outputs.mode.id(), self.preset);
        let _ = answer::handle(&t, &self.device, &mut line);
        let (step, late, unseen) = (t.step, board.late_steps(), self.unseen);
        let _ = write!(line, ", step {step}, {late} late, {unseen} missed by the console");
        if self.device.compensation.is_on() {
            let share = Text(100.0 * self.device.compensation.share);
            let _ = write!(line, ", compensates {share:.0} % of its friction");
        }
        if board.clock_is_off() {
            let _ = line.write_str(", internal clock (1 %)");
        }
        if let Some(level) = board.weak_brown_out() {
            let _ = write!(line, ", BOR_LEV {level} of 4");
        }
        if let Some(stream) = &self.stream {
            let _ = write!(line, ", stream on, {} frames dropped", stream.dropped());
        }
        self.say(&line);
    }

    fn tell_fault(&mut self, board: &impl Board) {
        let mut line = Line::new();
        // a long line is truncated
        let _ = line.write_str("ok ");
        let _ = match self.fault {
            None => line.write_str("no fault"),
            Some(f) => answer::moment(&f, &self.device, &mut line)
                .and_then(|()| write!(line, "; {}; then `clear`", f.kind.explain())),
        };
        if let Some(earlier) = board.earlier() {
            let _ = line.write_str("; first, before the restart: ");
            let _ = answer::moment(&earlier.fault, &self.device, &mut line);
            if let Some((path, at)) = &earlier.panicked_at {
                let _ = write!(line, ", panicked at {path}:{at}");
            }
            if let Some([pc, lr, cfsr]) = earlier.crashed_at {
                let _ = write!(line, ", crashed at pc {pc:#010x}, lr {lr:#010x}, cfsr {cfsr:#010x}");
            }
        }
        self.say(&line);
    }
}

/// Whether a command switches the force on.
fn switches_force_on(command: &Command<'_>) -> bool {
    matches!(
        command,
        Command::Render(true)
            | Command::Move(_)
            | Command::Identify
            | Command::Home
            | Command::SelfTest
            | Command::Calibrate(Calibrate::Force)
    )
}
