//! `tribos lab`: live scope, presets and experiments in a browser.
//!
//! ```text
//!  device ──▶ bench (thread) ──▶ broadcast ──▶ one task a page ──▶ WebSocket ──▶ page
//!             commands, answers,   every sample,                     guard: Host,
//!             recordings, jobs     in batches                        Origin, token
//! ```
//!
//! The bench owns the device. Force is off until a page arms it, and goes off when the last page closes, when a page
//! stops it, and when the lab ends. Nothing is sent that the device would refuse: [`verdict`] asks the device's own
//! validation first. Loopback only, unless an address and a token are asked for; see [`guard`].
//!
//! The lab speaks to the device through [`client`]. What the host command knows beyond that, it gives as [`Tools`].
#![forbid(unsafe_code)]

pub mod assets;
pub mod batch;
mod bench;
pub mod experiment;
pub mod guard;
pub mod handover;
pub mod known;
pub mod message;
mod orders;
pub mod plane;
pub mod say;
mod server;
mod session_file;
pub mod tools;
pub mod verdict;

pub use handover::{Curves, Moved};
pub use tools::{Found, Progress, Tools};

use bench::{Bench, Shared, ToBench};
use std::net::SocketAddr;
use std::path::PathBuf;
use std::sync::atomic::AtomicU64;
use std::sync::mpsc::{Sender, channel};
use std::sync::{Arc, Mutex};
use std::time::Instant;
use tokio::sync::{broadcast, oneshot};

/// Messages kept for a page that is slow: some 30 s of samples.
const KEPT: usize = 2_048;

/// How the lab is served.
#[derive(Debug)]
pub struct Options {
    /// Where it listens; port 0 takes a free one.
    pub address: SocketAddr,
    /// What a page must bring; needed beyond loopback.
    pub token: Option<String>,
    /// Where recordings, sessions and reports go.
    pub folder: PathBuf,
    /// Where each sample goes besides.
    pub live: client::Streams,
}

/// A lab that runs; dropping it ends it.
pub struct Lab {
    address: SocketAddr,
    token: Option<String>,
    bench: Sender<ToBench>,
    threads: Vec<std::thread::JoinHandle<()>>,
    ended: Option<oneshot::Sender<()>>,
}

/// 128 bits that nobody guesses, as text.
#[must_use]
pub fn new_token() -> String {
    format!("{:032x}", rand::random::<u128>())
}

impl Lab {
    /// Starts serving.
    ///
    /// # Errors
    /// The address is taken or is none of this machine; it is beyond loopback and no token is given.
    pub fn start(options: Options, tools: Arc<dyn Tools>) -> Result<Self, String> {
        if !options.address.ip().is_loopback() && options.token.is_none() {
            return Err(format!("{}: beyond loopback a token is needed", options.address));
        }
        let taken = |e: std::io::Error| format!("{}: cannot listen there: {e}", options.address);
        let listener = std::net::TcpListener::bind(options.address).map_err(taken)?;
        listener.set_nonblocking(true).map_err(taken)?;
        let address = listener.local_addr().map_err(taken)?;
        let (bench, requests) = channel();
        let (pages, _) = broadcast::channel(KEPT);
        let known = Arc::new(Mutex::new(known::Known::new(tools.port())));
        let shared = Shared { known, pages };
        let began = Instant::now();
        let app = server::App {
            shared: shared.clone(),
            bench: bench.clone(),
            guard: Arc::new(guard::Guard::new(address, options.token.clone())),
            folder: options.folder.clone(),
            tools: tools.clone(),
            pages: Arc::new(AtomicU64::new(1)),
            began,
        };
        let own = bench.clone();
        let mut threads = Vec::new();
        let thread = |name: &str| std::thread::Builder::new().name(name.to_owned());
        threads.push(
            thread("device")
                .spawn(move || {
                    Bench::new(tools, options.folder, shared, (requests, own), began, options.live).run()
                })
                .map_err(taken)?,
        );
        let (ended, end) = oneshot::channel::<()>();
        let serve = move || {
            let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build();
            let Ok(runtime) = runtime else { return };
            runtime.block_on(async {
                let Ok(listener) = tokio::net::TcpListener::from_std(listener) else { return };
                tokio::select! {
                    _ = axum::serve(listener, server::router(app)) => {}
                    _ = end => {}
                }
            });
        };
        threads.push(thread("server").spawn(serve).map_err(taken)?);
        Ok(Self { address, token: options.token, bench, threads, ended: Some(ended) })
    }

    /// Where it listens.
    #[must_use]
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// What to open in a browser.
    #[must_use]
    pub fn url(&self) -> String {
        // a wildcard is no address to go to
        let host = match self.address {
            SocketAddr::V4(a) if a.ip().is_unspecified() => format!("127.0.0.1:{}", a.port()),
            SocketAddr::V6(a) if a.ip().is_unspecified() => format!("[::1]:{}", a.port()),
            address => address.to_string(),
        };
        match &self.token {
            Some(token) => format!("http://{host}/?token={token}"),
            None => format!("http://{host}/"),
        }
    }

    /// Ends it: force off, recordings closed.
    pub fn stop(&mut self) {
        let _ = self.bench.send(ToBench::Quit);
        if let Some(ended) = self.ended.take() {
            let _ = ended.send(());
        }
        for thread in self.threads.drain(..) {
            // what a thread had to say it has said
            let _ = thread.join();
        }
    }
}

impl Drop for Lab {
    fn drop(&mut self) {
        self.stop();
    }
}
