//! A tribos device seen from the host.
//!
//! ```text
//! session     commands and their answers, and unsolicited messages
//!   wire        bytes to lines, headers and samples; counts what is missing
//!   transport   a serial port, or the virtual device inside this process
//! sample      raw codes to SI, by the calibration in the stream's header
//! origin      the middle of the stroke: whether the device knows it, and the search for it
//! recorder    a stream into a CSV file that survives a crash
//! streams     each sample to programs that plot it
//!   live        datagrams, for PlotJuggler
//!   foxglove    a WebSocket server, for Foxglove
//!   columns     names and digits that both write
//! ```
#![forbid(unsafe_code)]

mod clock;
mod columns;
mod error;
mod foxglove;
mod live;
mod moves;
mod origin;
mod recorder;
mod sample;
mod session;
mod streams;
mod transport;
mod wire;

pub use clock::ClockRatio;
pub use error::{Error, Result};
pub use foxglove::{Foxglove, FoxgloveTally};
pub use live::{Live, Tally};
pub use moves::Move;
pub use origin::reference;
pub use recorder::{Plan, Recorded, RecordingFile, record};
pub use sample::{Calibration, Decoding, Header, Raw, Sample};
pub use session::{Event, Session, Settled};
pub use streams::Streams;
pub use transport::{Port, Transport, Virtual};
