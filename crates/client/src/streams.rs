//! The live streams of a session.

use crate::foxglove::Foxglove;
use crate::live::Live;
use crate::sample::{Header, Sample};
use std::fmt::Display;
use std::sync::Arc;

/// Programs that see each sample as it comes.
#[derive(Debug, Default)]
pub struct Streams {
    /// Datagrams, for PlotJuggler.
    pub live: Option<Live>,
    /// A server for Foxglove.
    pub foxglove: Option<Foxglove>,
}

impl Streams {
    /// Whether there is any.
    #[must_use]
    pub fn is_any(&self) -> bool {
        self.live.is_some() || self.foxglove.is_some()
    }

    /// Begins a stream of the device.
    pub fn header(&mut self, header: &Header) {
        if let Some(live) = &mut self.live {
            live.header(header);
        }
        if let Some(foxglove) = &mut self.foxglove {
            foxglove.header(header);
        }
    }

    /// Passes a sample on. It never waits.
    pub fn sample(&mut self, sample: &Sample) {
        if let Some(live) = &mut self.live {
            live.sample(sample);
        }
        if let Some(foxglove) = &mut self.foxglove {
            foxglove.sample(sample);
        }
    }

    /// The counts of each, one line to print, which stay readable when the streams are given away.
    #[must_use]
    pub fn tallies(&self) -> Vec<Arc<dyn Display + Send + Sync>> {
        let live = self.live.iter().map(|live| live.tally() as Arc<dyn Display + Send + Sync>);
        live.chain(self.foxglove.iter().map(|foxglove| foxglove.tally() as _)).collect()
    }
}
