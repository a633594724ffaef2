//! What the lab needs of a device. The host command provides it, so that the lab knows no serial port.

/// What the device says about its stream before the first sample.
#[derive(Debug, Clone, PartialEq)]
pub struct Header {
    /// Constants of the device as its validation uses them: period, resolution and calibration as streamed, limits
    /// of the rig everything here is built for.
    pub device: haptics::Device,
    /// Control periods per sample.
    pub decimation: u32,
    /// Lines for the head of a recording.
    pub notes: Vec<(String, String)>,
}

impl Header {
    /// Time between two samples, s.
    #[must_use]
    pub fn sample_period(&self) -> f64 {
        f64::from(self.device.period_ticks()) / f64::from(self.device.tick_hz) * f64::from(self.decimation)
    }
}

/// One sample in SI, and the state of the device.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Sample {
    /// Since the stream began, by the device's timer, s.
    pub time: f64,
    /// m.
    pub position: f64,
    /// m/s.
    pub velocity: f64,
    /// m/s².
    pub acceleration: f64,
    /// Load cell, N.
    pub force: f64,
    /// Commanded force, N.
    pub command: f64,
    /// Reference of an excitation, m.
    pub reference: f64,
    /// [`haptics::ModeId`] on the wire.
    pub mode: u8,
    /// [`haptics::FaultKind`] on the wire, 0 for none.
    pub fault: u8,
}

/// What arrives.
#[derive(Debug, Clone, PartialEq)]
pub enum Event {
    /// A line of text.
    Text(String),
    /// A stream begins; time begins anew.
    Header(Box<Header>),
    /// A sample of it.
    Sample(Sample),
    /// So many samples are missing here.
    Lost(u64),
}

/// An open line to a device.
pub trait Device {
    /// What has arrived; waits a few milliseconds for it.
    ///
    /// # Errors
    /// The line is gone; why, in one line.
    fn poll(&mut self) -> Result<Vec<Event>, String>;

    /// Sends one command.
    ///
    /// # Errors
    /// The line is gone; why, in one line.
    fn send(&mut self, line: &str) -> Result<(), String>;
}

/// A recording that grows, and survives a crash up to its last flush.
pub trait Recorder {
    /// Appends a sample.
    ///
    /// # Errors
    /// The file cannot be written.
    fn sample(&mut self, sample: &Sample) -> Result<(), String>;

    /// Completes the file with the number of lost samples; how many it has.
    ///
    /// # Errors
    /// The file cannot be written.
    fn finish(self: Box<Self>, lost: u64) -> Result<u64, String>;

    /// Nothing came of it: the file goes.
    fn discard(self: Box<Self>);
}
