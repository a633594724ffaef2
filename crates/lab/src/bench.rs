//! The thread that owns the device: commands down, samples up to every page, recordings to disk.

mod answers;
mod experiments;
mod handover;
mod jobs;
mod recording_in_progress;
mod recordings;
pub(crate) use recordings::is_name;
mod requests;
mod running;
mod sessions;

use crate::batch::Batch;
use crate::handover::Bins;
use crate::known::Known;
use crate::message::Ask;
use crate::orders::{About, Orders};
use crate::say::{Say, Tone};
use crate::tools::{Found, Tools};
use axum::extract::ws::Message;
use client::{Event, Header, Sample, Session, Streams};
use recording_in_progress::Recording;
use running::Running;
use std::collections::BTreeSet;
use std::path::PathBuf;
use std::sync::atomic::AtomicBool;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, TryRecvError};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};
use tokio::sync::broadcast;

/// Interval between batches of samples.
const FLUSH: Duration = Duration::from_millis(16);
/// Largest batch, samples.
const FULL: usize = 1_000;
/// Shortest interval between two state messages.
const TELL: Duration = Duration::from_millis(50);
/// Interval of the sign of life to a device that drives the handle.
const ALIVE: Duration = Duration::from_millis(250);
/// Silence of the lab after which the device releases the handle, s.
const WATCH_S: u32 = 2;
/// Interval of the search for a lost device.
const RETRY: Duration = Duration::from_secs(1);
/// Silence of the device after which the stream counts as lost.
const SILENCE: Duration = Duration::from_secs(3);

/// A message to the thread.
pub(crate) enum ToBench {
    /// A page opened.
    Joined(u64),
    /// A page closed.
    Left(u64),
    /// A page asks.
    Asked(Ask),
    /// The folder has another session.
    Sessions,
    /// Job progress.
    Progress(f32, String),
    /// Result of a job; of a handover what it found, too, or why it found nothing.
    Finished(Box<crate::known::Done>, Option<Box<Result<Found, String>>>),
    /// Ends the thread.
    Quit,
}

/// State shared by thread and server.
#[derive(Clone)]
pub(crate) struct Shared {
    /// State of the device, as the pages show it.
    pub known: Arc<Mutex<Known>>,
    /// Channel to every page.
    pub pages: broadcast::Sender<Message>,
}

impl Shared {
    /// Reads or changes the state. It stays readable after a panic.
    pub fn known<T>(&self, with: impl FnOnce(&mut Known) -> T) -> T {
        with(&mut self.known.lock().unwrap_or_else(std::sync::PoisonError::into_inner))
    }

    /// Sends a message to every page.
    pub fn say(&self, say: &Say<'_>) {
        // without a page there is no receiver
        let _ = self.pages.send(Message::Text(say.to_json().into()));
    }
}

/// State of the thread.
pub(crate) struct Bench {
    tools: Arc<dyn Tools>,
    folder: PathBuf,
    shared: Shared,
    requests: Receiver<ToBench>,
    /// Sender for the progress of jobs.
    own: Sender<ToBench>,
    device: Option<Session>,
    orders: Orders,
    header: Option<Header>,
    batch: Batch,
    flushed: Instant,
    told: Instant,
    alive: Instant,
    heard: Instant,
    dirty: bool,
    /// Samples lost since the stream began.
    lost: u64,
    began: Instant,
    pages: BTreeSet<u64>,
    last: Option<Sample>,
    recording: Option<Recording>,
    /// Force on the body of the last recording.
    recorded: Option<Bins>,
    /// What was found in the recording of the handover.
    found: Option<Found>,
    /// What the handover sent to the device.
    sent: Option<haptics::Settings>,
    /// Force commanded under the active preset.
    felt: Bins,
    /// Time at which it was shown last.
    felt_shown: Instant,
    /// Asks the job that runs to end.
    cancel: Arc<AtomicBool>,
    experiment: Option<Running>,
    /// Silence limit of the device before this lab changed it, s.
    watch: Option<String>,
    live: Streams,
}

impl Bench {
    pub fn new(
        tools: Arc<dyn Tools>,
        folder: PathBuf,
        shared: Shared,
        (requests, own): (Receiver<ToBench>, Sender<ToBench>),
        began: Instant,
        live: Streams,
    ) -> Self {
        let now = Instant::now();
        Self {
            tools,
            folder,
            shared,
            requests,
            own,
            device: None,
            orders: Orders::default(),
            header: None,
            batch: Batch::default(),
            flushed: now,
            told: now,
            alive: now,
            heard: now,
            dirty: true,
            lost: 0,
            began,
            pages: BTreeSet::new(),
            last: None,
            recording: None,
            recorded: None,
            found: None,
            sent: None,
            felt: Bins::new(&haptics::Device::default(), 1e-3),
            felt_shown: now,
            cancel: Arc::default(),
            experiment: None,
            watch: None,
            live,
        }
    }

    /// Runs until [`ToBench::Quit`]; leaves the device without force.
    pub fn run(mut self) {
        self.list_recordings();
        self.list_sessions();
        let mut quit = false;
        while !quit {
            if self.device.is_none() {
                self.connect();
            }
            let wait = if self.device.is_none() { RETRY } else { Duration::ZERO };
            quit = self.requests(wait);
            self.send();
            self.poll();
            self.flush();
            self.tell(false);
        }
        self.end_recording();
        if let Some(device) = &mut self.device {
            // errors are ignored: the device may be gone
            let _ = device.off();
            let _ = device.send_line("stream off");
            if let Some(seconds) = &self.watch {
                let _ = device.send_line(&format!("watch {seconds}"));
            }
            let _ = device.poll();
        }
    }

    fn connect(&mut self) {
        match self.tools.open() {
            Ok(mut device) => {
                device.in_real_time();
                self.device = Some(device);
                self.orders.reset();
                self.heard = Instant::now();
                // whatever the device did before: force off until somebody arms it
                for (line, about) in [
                    ("off", About::Page("stop")),
                    ("version", About::Version),
                    ("watch", About::Watch),
                    ("preset list", About::Presets),
                    ("get", About::Get),
                ] {
                    self.orders.push(line, about);
                }
            }
            Err(why) => {
                let why = why.to_string();
                let news = self.shared.known(|known| {
                    let news = known.connected || known.absent != why;
                    known.connected = false;
                    known.absent = why;
                    news
                });
                self.dirty |= news;
                self.tell(false);
            }
        }
    }

    /// Handles the loss of the line: keeps the recording and informs every page.
    fn disconnect(&mut self, why: &str) {
        self.device = None;
        self.orders.reset();
        self.header = None;
        self.flush_now();
        self.end_recording();
        self.interrupt();
        self.interrupt_handover();
        self.shared.known(|known| {
            known.connected = false;
            known.armed = false;
            known.absent = why.to_owned();
        });
        self.say(Tone::Error, "device", format!("the device is gone: {why}; finished trials are kept"));
        self.dirty = true;
        self.tell(true);
    }

    /// Handles requests; true when asked to quit.
    fn requests(&mut self, wait: Duration) -> bool {
        let mut wait = Some(wait).filter(|wait| !wait.is_zero());
        loop {
            let request = match wait.take() {
                Some(wait) => self.requests.recv_timeout(wait).map_err(|e| match e {
                    RecvTimeoutError::Timeout => TryRecvError::Empty,
                    RecvTimeoutError::Disconnected => TryRecvError::Disconnected,
                }),
                None => self.requests.try_recv(),
            };
            match request {
                Ok(ToBench::Quit) | Err(TryRecvError::Disconnected) => return true,
                Err(TryRecvError::Empty) => return false,
                Ok(ToBench::Joined(page)) => {
                    self.pages.insert(page);
                    self.dirty = true;
                    self.tell(true);
                }
                Ok(ToBench::Left(page)) => {
                    self.pages.remove(&page);
                    self.abandoned();
                }
                Ok(ToBench::Asked(ask)) => self.asked(ask),
                Ok(ToBench::Sessions) => self.list_sessions(),
                Ok(ToBench::Progress(share, says)) => {
                    self.shared.known(|known| {
                        if let Some(job) = &mut known.job {
                            job.share = share;
                            if !says.is_empty() {
                                job.says = says;
                            }
                        }
                    });
                    self.dirty = true;
                }
                Ok(ToBench::Finished(done, found)) => {
                    let of = done.of.clone();
                    let report = done.report.clone();
                    self.shared.known(|known| {
                        known.job = None;
                        known.done = Some(*done);
                    });
                    self.dirty = true;
                    if let Some(found) = found {
                        self.diagnosed(&of, *found, report);
                    }
                }
            }
        }
    }

    /// Switches the force off when no page is open.
    fn abandoned(&mut self) {
        let armed = self.shared.known(|known| known.armed || !matches!(known.mode, "idle" | "fault"));
        if self.pages.is_empty() && armed {
            self.stop();
        }
    }

    /// Drops queued commands and ends what runs.
    fn stop(&mut self) {
        self.stop_quietly();
        self.interrupt();
    }

    fn stop_quietly(&mut self) {
        self.orders.forget();
        self.off_at_once();
        if self.shared.known(|known| known.sim) {
            self.orders.push("sim hand off", About::Hand);
        }
        if let Some(recording) = &mut self.recording {
            recording.stop_waiting();
        }
        self.shared.known(|known| known.armed = false);
        self.interrupt_handover();
        self.dirty = true;
    }

    /// Sends `off` past the queue, without waiting for the answer to the last command.
    fn off_at_once(&mut self) {
        let Some(device) = &mut self.device else { return };
        match device.off() {
            Ok(()) => self.orders.sent_off(),
            Err(why) => self.disconnect(&why.to_string()),
        }
    }

    fn send(&mut self) {
        if let Some(order) = self.orders.overdue() {
            self.say(Tone::Error, "device", format!("no answer to `{}`", order.line));
        }
        let driven = self.shared.known(|known| matches!(known.mode, "exciting" | "identifying" | "homing"));
        let Some(device) = &mut self.device else { return };
        let mut sent = Ok(());
        if let Some(line) = self.orders.next() {
            sent = device.send_line(&line);
        } else if driven && self.alive.elapsed() > ALIVE {
            self.alive = Instant::now();
            sent = device.send_line("");
        }
        if let Err(why) = sent {
            self.disconnect(&why.to_string());
        }
    }

    fn poll(&mut self) {
        let Some(device) = &mut self.device else { return };
        let events = match device.poll() {
            Ok(events) => events,
            Err(why) => return self.disconnect(&why.to_string()),
        };
        if events.is_empty() && self.heard.elapsed() > SILENCE {
            return self.disconnect(&format!("it has said nothing for {} s", SILENCE.as_secs()));
        }
        if !events.is_empty() {
            self.heard = Instant::now();
        }
        for event in events {
            match event {
                Event::Text(line) => self.line(line),
                Event::Header(header) => self.header(header),
                Event::Sample(sample) => self.sample(&sample),
                Event::Lost(count) => {
                    self.lost += count;
                    if let Some(recording) = &mut self.recording {
                        recording.lost(count);
                    }
                }
            }
        }
    }

    fn header(&mut self, header: Header) {
        self.flush_now();
        self.end_recording();
        self.lost = 0;
        self.last = None;
        self.shared.known(|known| {
            known.epoch = known.epoch.wrapping_add(1);
            known.device = header.device();
            known.period = header.sample_period();
            known.reach = 0.5 * f64::from(known.device.stroke);
            known.force_max = f64::from(known.device.force_max);
            known.unreferenced_force = f64::from(known.device.unreferenced_force());
        });
        self.live.header(&header);
        self.header = Some(header);
        self.felt = self.bins().in_a_hand();
        self.dirty = true;
        self.tell(true);
    }

    fn sample(&mut self, sample: &Sample) {
        let state = |s: &Sample| (s.mode, s.fault, s.referenced);
        let changed = self.last.is_none_or(|last| state(&last) != state(sample));
        if changed && self.shared.known(|known| known.state(sample.mode, sample.fault, sample.referenced)) {
            self.dirty = true;
        }
        self.last = Some(*sample);
        self.live.sample(sample);
        self.batch.push(sample);
        if self.batch.len() >= FULL {
            self.flush_now();
        }
        self.record(sample);
        self.feel_handover(sample);
        self.follow(sample);
    }

    fn flush(&mut self) {
        if self.flushed.elapsed() >= FLUSH {
            self.flush_now();
        }
    }

    fn flush_now(&mut self) {
        if self.batch.is_empty() {
            return;
        }
        self.flushed = Instant::now();
        let epoch = self.shared.known(|known| known.epoch);
        // wraps after seven weeks
        let clock = self.began.elapsed().as_millis() as u32;
        let bytes = self.batch.take(epoch, self.lost, clock);
        let _ = self.shared.pages.send(Message::Binary(bytes.into()));
    }

    /// Sends the state to every page if it has changed.
    fn tell(&mut self, now: bool) {
        if !self.dirty || (!now && self.told.elapsed() < TELL) {
            return;
        }
        (self.dirty, self.told) = (false, Instant::now());
        let text = self.shared.known(|known| Say::State(known).to_json());
        let _ = self.shared.pages.send(Message::Text(text.into()));
    }

    fn say(&self, tone: Tone, about: &str, text: impl AsRef<str>) {
        self.shared.say(&Say::Said { tone, about, text: text.as_ref() });
    }
}
