//! Options of the live streams.

use crate::failure::Result;
use client::{Foxglove, Live, Streams};

/// Programs that see each sample as it comes.
#[derive(Debug, clap::Args)]
pub(crate) struct Options {
    /// Also send each sample of the stream by UDP, as JSON for PlotJuggler, e.g. 127.0.0.1:9870
    #[arg(long, value_name = "HOST:PORT")]
    live: Option<String>,
    /// Also serve each sample of the stream to Foxglove, which opens ws://localhost:8765
    #[arg(long, value_name = "HOST:PORT", num_args = 0..=1, require_equals = true,
        default_missing_value = "127.0.0.1:8765")]
    foxglove: Option<String>,
}

impl Options {
    pub(crate) fn open(&self) -> Result<Streams> {
        let live = self.live.as_deref().map(Live::to).transpose()?;
        let foxglove = self.foxglove.as_deref().map(Foxglove::at).transpose()?;
        if let Some(foxglove) = &foxglove {
            eprintln!("foxglove: ws://{}", foxglove.tally().address());
        }
        Ok(Streams { live, foxglove })
    }
}
