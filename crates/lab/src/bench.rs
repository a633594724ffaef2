//! The thread that owns the device: commands down, samples up to every page, recordings to disk.

mod answers;
mod experiments;
mod jobs;
mod recordings;
pub(crate) use recordings::is_name;
mod requests;
mod sessions;

use crate::batch::Batch;
use crate::device::{Device, Event, Header, Sample};
use crate::known::Known;
use crate::message::Ask;
use crate::orders::{About, Orders};
use crate::say::{Say, Tone};
use crate::tools::Tools;
use axum::extract::ws::Message;
use recordings::Recording;
use std::collections::BTreeSet;
use std::path::PathBuf;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, TryRecvError};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};
use tokio::sync::broadcast;

/// Samples go out this often.
const FLUSH: Duration = Duration::from_millis(16);
/// Most samples of a batch.
const FULL: usize = 1_000;
/// Whatever changed is told this often at most.
const TELL: Duration = Duration::from_millis(50);
/// A driven handle is told that somebody is there.
const ALIVE: Duration = Duration::from_millis(250);
/// Silence after which the device lets go of a handle that it drives for this lab, s.
const WATCH_S: u32 = 2;
/// A device that was lost is looked for.
const RETRY: Duration = Duration::from_secs(1);
/// Silence after which a stream is taken for lost.
const SILENCE: Duration = Duration::from_secs(3);

/// What reaches the thread.
pub(crate) enum ToBench {
    /// A page opened.
    Joined(u64),
    /// A page closed.
    Left(u64),
    /// A page asks.
    Asked(Ask),
    /// A job is so far.
    Progress(f32, String),
    /// A job is over.
    Finished(Box<crate::known::Done>),
    /// The end.
    Quit,
}

/// What thread and server share.
#[derive(Clone)]
pub(crate) struct Shared {
    /// What is known; pages are told from it, and proposals judged by it.
    pub known: Arc<Mutex<Known>>,
    /// To every page.
    pub pages: broadcast::Sender<Message>,
}

impl Shared {
    /// Looks at what is known, or changes it. A thread that panicked leaves it readable.
    pub fn known<T>(&self, with: impl FnOnce(&mut Known) -> T) -> T {
        with(&mut self.known.lock().unwrap_or_else(std::sync::PoisonError::into_inner))
    }

    /// Tells every page.
    pub fn say(&self, say: &Say<'_>) {
        // nobody listens: nobody misses it
        let _ = self.pages.send(Message::Text(say.to_json().into()));
    }
}

/// The thread's memory.
pub(crate) struct Bench {
    tools: Arc<dyn Tools>,
    folder: PathBuf,
    shared: Shared,
    requests: Receiver<ToBench>,
    /// For jobs, to tell how far they are.
    own: Sender<ToBench>,
    device: Option<Box<dyn Device>>,
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
    experiment: Option<experiments::Running>,
    /// How long the device waited for a host before, s.
    watch: Option<String>,
}

impl Bench {
    pub fn new(
        tools: Arc<dyn Tools>,
        folder: PathBuf,
        shared: Shared,
        (requests, own): (Receiver<ToBench>, Sender<ToBench>),
        began: Instant,
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
            experiment: None,
            watch: None,
        }
    }

    /// Runs until told to quit; the device is left without force.
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
            // gone or not, nothing more can be done
            let _ = device.send("stop");
            let _ = device.send("stream off");
            if let Some(seconds) = &self.watch {
                let _ = device.send(&format!("watch {seconds}"));
            }
            let _ = device.poll();
        }
    }

    fn connect(&mut self) {
        match self.tools.open() {
            Ok(device) => {
                self.device = Some(device);
                self.orders.reset();
                self.heard = Instant::now();
                // whatever the device did before: force off until somebody arms it
                for (line, about) in [
                    ("stop", About::Page("stop")),
                    ("version", About::Version),
                    ("watch", About::Watch),
                    ("preset list", About::Presets),
                    ("get", About::Get),
                ] {
                    self.orders.push(line, about);
                }
            }
            Err(why) => {
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

    /// The line is gone: what was recorded is kept, and everybody told.
    fn disconnect(&mut self, why: &str) {
        self.device = None;
        self.orders.reset();
        self.header = None;
        self.flush_now();
        self.end_recording();
        self.interrupt();
        self.shared.known(|known| {
            known.connected = false;
            known.armed = false;
            known.absent = why.to_owned();
        });
        self.say(Tone::Error, "device", format!("the device is gone: {why}; finished trials are kept"));
        self.dirty = true;
        self.tell(true);
    }

    /// Handles what was asked; true at the end.
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
                Ok(ToBench::Finished(done)) => {
                    self.shared.known(|known| {
                        known.job = None;
                        known.done = Some(*done);
                    });
                    self.dirty = true;
                }
            }
        }
    }

    /// Nobody watches any more: force off.
    fn abandoned(&mut self) {
        let armed = self.shared.known(|known| known.armed || !matches!(known.mode, "idle" | "fault"));
        if self.pages.is_empty() && armed {
            self.stop();
        }
    }

    /// Everything that waits is forgotten, and everything that runs ends.
    fn stop(&mut self) {
        self.stop_quietly();
        self.interrupt();
    }

    fn stop_quietly(&mut self) {
        self.orders.forget();
        self.orders.first("stop", About::Page("stop"));
        if self.shared.known(|known| known.sim) {
            self.orders.push("sim hand off", About::Hand);
        }
        if let Some(recording) = &mut self.recording {
            recording.stop_waiting();
        }
        self.shared.known(|known| known.armed = false);
        self.dirty = true;
    }

    fn send(&mut self) {
        if let Some(order) = self.orders.overdue() {
            self.say(Tone::Error, "device", format!("no answer to `{}`", order.line));
        }
        let driven = self.shared.known(|known| matches!(known.mode, "exciting" | "identifying"));
        let Some(device) = &mut self.device else { return };
        let mut sent = Ok(());
        if let Some(line) = self.orders.next() {
            sent = device.send(&line);
        } else if driven && self.alive.elapsed() > ALIVE {
            self.alive = Instant::now();
            sent = device.send("");
        }
        if let Err(why) = sent {
            self.disconnect(&why);
        }
    }

    fn poll(&mut self) {
        let Some(device) = &mut self.device else { return };
        let events = match device.poll() {
            Ok(events) => events,
            Err(why) => return self.disconnect(&why),
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
                Event::Header(header) => self.header(*header),
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
            known.device = header.device;
            known.period = header.sample_period();
            known.reach = 0.5 * f64::from(header.device.stroke);
            known.force_max = f64::from(header.device.force_max);
        });
        self.header = Some(header);
        self.dirty = true;
        self.tell(true);
    }

    fn sample(&mut self, sample: &Sample) {
        let changed = self.last.is_none_or(|last| last.mode != sample.mode || last.fault != sample.fault);
        if changed && self.shared.known(|known| known.state(sample.mode, sample.fault)) {
            self.dirty = true;
        }
        self.last = Some(*sample);
        self.batch.push(sample);
        if self.batch.len() >= FULL {
            self.flush_now();
        }
        self.record(sample);
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

    /// Tells every page what is known, if it is news.
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
