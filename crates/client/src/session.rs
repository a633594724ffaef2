//! A session with a device: commands, answers and samples.

use crate::error::{Error, Result};
use crate::sample::{Decoding, Header, Sample};
use crate::transport::{Port, Transport, Virtual};
use crate::wire::{Item, Wire};
use link::reply;
use std::collections::VecDeque;
use std::time::{Duration, Instant};

/// Longest time for an answer.
const PATIENCE: Duration = Duration::from_secs(2);

/// A received item.
#[derive(Debug, Clone, PartialEq)]
pub enum Event {
    /// A line of text.
    Text(String),
    /// Start of a stream.
    Header(Header),
    /// A sample.
    Sample(Sample),
    /// Number of samples lost.
    Lost(u64),
}

/// Result of setting parameters.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Settled {
    /// Finally refused parameters, one line each: `set NAME VALUE: why`.
    pub refused: Vec<String>,
    /// Warning of the device about all parameters together: accepted, but not faithful.
    pub warning: Option<String>,
}

/// An open session.
pub struct Session {
    name: String,
    transport: Box<dyn Transport>,
    wire: Wire,
    decoding: Option<Decoding>,
    bytes: Vec<u8>,
    waiting: VecDeque<Event>,
}

impl Session {
    /// Opens a port by name, or `sim` for a virtual device.
    ///
    /// # Errors
    /// The port cannot be opened.
    pub fn open(port: &str, seed: u64) -> Result<Self> {
        if port == "sim" {
            Ok(Self::over(port, Box::new(Virtual::new(seed)?)))
        } else {
            Ok(Self::over(port, Box::new(Port::open(port)?)))
        }
    }

    /// A session over any transport.
    pub fn over(name: &str, transport: Box<dyn Transport>) -> Self {
        Self {
            name: name.to_owned(),
            transport,
            wire: Wire::default(),
            decoding: None,
            bytes: Vec::new(),
            waiting: VecDeque::new(),
        }
    }

    /// The port as the user named it.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Runs a virtual device in real time from now on.
    pub fn in_real_time(&mut self) {
        self.transport.in_real_time();
    }

    /// Sends a command without waiting for its answer.
    ///
    /// # Errors
    /// The line failed.
    pub fn send_line(&mut self, line: &str) -> Result<()> {
        self.transport.send(format!("{line}\n").as_bytes())
    }

    /// Switches the amplifier off, whatever the device does and whatever was sent before. Does not wait for the answer.
    ///
    /// # Errors
    /// The line failed.
    pub fn off(&mut self) -> Result<()> {
        // the first line end completes what was half sent
        self.transport.send(b"\noff\n")
    }

    /// Received items. Waits a few milliseconds.
    ///
    /// # Errors
    /// The line failed.
    pub fn poll(&mut self) -> Result<Vec<Event>> {
        let mut events: Vec<Event> = self.waiting.drain(..).collect();
        events.extend(self.receive()?);
        Ok(events)
    }

    fn receive(&mut self) -> Result<Vec<Event>> {
        self.bytes.clear();
        self.transport.receive(&mut self.bytes)?;
        let mut events = Vec::new();
        for item in self.wire.decode(&self.bytes) {
            match item {
                Item::Text(line) => events.push(Event::Text(line)),
                Item::Header(header) => {
                    self.decoding = Some(Decoding::new(header.calibration));
                    events.push(Event::Header(header));
                }
                Item::Lost(samples) => events.push(Event::Lost(samples)),
                Item::Sample(raw) => {
                    // a sample without a header cannot be converted
                    let Some(decoding) = self.decoding.as_mut() else { continue };
                    events.extend(decoding.sample(&raw).map(Event::Sample));
                }
            }
        }
        Ok(events)
    }

    /// Sends a command and returns its answer, the line that begins with `ok`.
    ///
    /// # Errors
    /// The device answers `err …`, or not at all.
    pub fn command(&mut self, line: &str) -> Result<String> {
        self.send_line(line)?;
        let asked = Instant::now();
        loop {
            // items that arrive with the answer, such as the header of a stream, are kept
            let mut answer = None;
            for event in self.receive()? {
                match event {
                    Event::Text(text) if answer.is_none() && reply::is_answer(&text) => answer = Some(text),
                    other => self.waiting.push_back(other),
                }
            }
            match answer {
                Some(text) if reply::refusal(&text).is_some() => {
                    return Err(Error::Refused {
                        port: self.name.clone(),
                        command: line.to_owned(),
                        answer: text,
                    });
                }
                Some(text) => return Ok(text),
                None => {}
            }
            if asked.elapsed() > PATIENCE {
                return Err(self.no_answer(line));
            }
        }
    }

    /// Sends a command. Returns all lines of its answer, and messages that arrived before its end.
    ///
    /// # Errors
    /// The line failed, or no answer came.
    pub fn exchange(&mut self, line: &str) -> Result<Vec<String>> {
        self.send_line(line)?;
        let mut lines = Vec::new();
        // remaining lines, once the first line of the answer arrived
        let mut left: Option<usize> = None;
        let mut heard = Instant::now();
        while left != Some(0) {
            for event in self.receive()? {
                heard = Instant::now();
                let Event::Text(text) = event else {
                    self.waiting.push_back(event);
                    continue;
                };
                left = match left {
                    None if reply::is_answer(&text) => Some(reply::lines_to_follow(&text)),
                    Some(count) if !reply::is_news(&text) => Some(count.saturating_sub(1)),
                    unchanged => unchanged,
                };
                lines.push(text);
            }
            if heard.elapsed() > PATIENCE {
                return Err(self.no_answer(line));
            }
        }
        Ok(lines)
    }

    /// Sets parameters, given as name and value. They depend on each other (a heavier block first, then a stiffer
    /// coupling), so what is refused is tried again after the others.
    ///
    /// # Errors
    /// The line failed, or no answer came. A parameter that the device refuses is returned, not an error.
    pub fn set_all(&mut self, wanted: &[(String, String)]) -> Result<Settled> {
        let mut left: Vec<&(String, String)> = wanted.iter().collect();
        let mut settled = Settled::default();
        loop {
            let before = left.len();
            let mut again = Vec::new();
            settled.refused.clear();
            for line in left {
                let set = format!("set {} {}", line.0, line.1);
                let answer = self.exchange(&set)?;
                if let Some((_, why)) = answer.iter().find_map(|text| reply::refusal(text)) {
                    settled.refused.push(format!("{set}: {}", why.trim()));
                    again.push(line);
                } else {
                    let warning = answer.iter().find_map(|text| text.strip_prefix("ok warn: "));
                    settled.warning = warning.map(|warning| warning.trim().to_owned());
                }
            }
            if again.is_empty() || again.len() == before {
                return Ok(settled);
            }
            left = again;
        }
    }

    fn no_answer(&self, line: &str) -> Error {
        Error::NoAnswer { port: self.name.clone(), command: line.to_owned(), seconds: PATIENCE.as_secs() }
    }
}
