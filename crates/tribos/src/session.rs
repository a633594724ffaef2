//! A conversation with a device: commands and their answers, frames and what they mean.

use crate::failure::{Failure, Result};
use crate::raw::{Calibration, Decoding, Point};
use crate::transport::{Port, Transport, Virtual};
use crate::wire::{Item, Wire};
use link::reply;
use std::collections::VecDeque;
use std::time::{Duration, Instant};

/// How long a device may take to answer.
const PATIENCE: Duration = Duration::from_secs(2);

/// What the device says about its stream before the first sample.
#[derive(Debug, Clone, PartialEq)]
pub struct Header {
    /// Codes to SI.
    pub calibration: Calibration,
    /// Control periods per sample.
    pub decimation: u32,
    /// Control period, s.
    pub period: f64,
    /// Active preset.
    pub preset: String,
}

impl Header {
    /// Time between two samples, s.
    #[must_use]
    pub fn sample_period(&self) -> f64 {
        self.period * f64::from(self.decimation)
    }

    /// One line for a person.
    #[must_use]
    pub fn describe(&self) -> String {
        format!("stream: {:.0} samples a second, preset {}", 1.0 / self.sample_period(), self.preset)
    }

    /// The calibration as lines for the head of a recording.
    #[must_use]
    pub fn notes(&self) -> Vec<(String, String)> {
        let c = &self.calibration;
        [
            ("preset", self.preset.clone()),
            ("sample_period_s", self.sample_period().to_string()),
            ("tick_hz", c.tick_hz.to_string()),
            ("metre_per_count", c.metre_per_count.to_string()),
            ("newton_per_code", c.load_unit.to_string()),
            ("metre_per_second_squared_per_code", c.accel_unit.to_string()),
        ]
        .map(|(key, value)| (key.to_owned(), value))
        .to_vec()
    }
}

/// One sample and the state of the device.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Sample {
    /// In SI.
    pub point: Point,
    /// State code.
    pub mode: u8,
    /// Fault code, 0 for none.
    pub fault: u8,
}

/// What arrives.
#[derive(Debug, Clone, PartialEq)]
pub enum Event {
    /// A line of text.
    Text(String),
    /// A stream begins.
    Header(Header),
    /// A sample of it.
    Sample(Sample),
    /// So many samples are missing here.
    Lost(u64),
}

#[cfg(test)]
impl Event {
    /// A sample at a point.
    pub(crate) fn sample(point: Point) -> Self {
        Self::Sample(Sample { point, ..Sample::default() })
    }
}

/// What became of parameters that were set.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Settled {
    /// Refused for good, one line each: `set NAME VALUE: why`.
    pub refused: Vec<String>,
    /// What the device says of all of them together: taken, but not felt as asked.
    pub warning: Option<String>,
}

/// An open line.
pub struct Session {
    name: String,
    transport: Box<dyn Transport>,
    wire: Wire,
    decoding: Option<Decoding>,
    bytes: Vec<u8>,
    waiting: VecDeque<Event>,
}

impl Session {
    /// Opens a port by name, or `sim` for a virtual device of its own.
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

    /// A conversation over any transport.
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

    /// From now on a virtual device keeps the pace of the clock on the wall.
    pub fn in_real_time(&mut self) {
        self.transport.in_real_time();
    }

    /// Sends one command and does not wait for its answer.
    ///
    /// # Errors
    /// The line is gone.
    pub fn send_line(&mut self, line: &str) -> Result<()> {
        self.transport.send(format!("{line}\n").as_bytes())
    }

    /// What has arrived; waits a few milliseconds.
    ///
    /// # Errors
    /// The line is gone.
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
                Item::Sample(raw, mode, fault) => {
                    // A sample whose header was missed cannot be read.
                    let Some(decoding) = self.decoding.as_mut() else { continue };
                    events.push(Event::Sample(Sample { point: decoding.sample(&raw), mode, fault }));
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
            // what comes with the answer, such as the header of a stream, is kept for later
            let mut answer = None;
            for event in self.receive()? {
                match event {
                    Event::Text(text) if answer.is_none() && reply::is_answer(&text) => answer = Some(text),
                    other => self.waiting.push_back(other),
                }
            }
            match answer {
                Some(text) if reply::refusal(&text).is_some() => {
                    return Err(Failure::new(format!("{}: `{line}` was refused: {text}", self.name)));
                }
                Some(text) => return Ok(text),
                None => {}
            }
            if asked.elapsed() > PATIENCE {
                return Err(self.no_answer(line));
            }
        }
    }

    /// Sends a command and returns every line of its answer, and the news that came meanwhile.
    ///
    /// # Errors
    /// The line is gone, or nobody answers.
    pub fn exchange(&mut self, line: &str) -> Result<Vec<String>> {
        self.send_line(line)?;
        let mut lines = Vec::new();
        // lines still to come, once the first line of the answer was heard
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
    /// The line is gone, or nobody answers. What the device refuses is no error here.
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

    fn no_answer(&self, line: &str) -> Failure {
        Failure::new(format!("{}: no answer to `{line}` within {} s", self.name, PATIENCE.as_secs()))
            .help("is it a tribos device, and does nobody else hold its line?")
    }
}
