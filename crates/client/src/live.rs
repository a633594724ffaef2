//! A live stream: each sample as a UDP datagram, for PlotJuggler and programs like it.
//!
//! A datagram is a flat JSON object: `timestamp`, s since 1970 as the computer's clock had it when the stream began plus the
//! time of the device, and the columns of a recording. A value that is not a number is left out.

use crate::columns;
use crate::error::{Error, Result};
use crate::sample::{Header, Sample};
use friction::Geometry;
use signals::files::reason;
use std::fmt::{self, Write};
use std::io::ErrorKind;
use std::net::{Ipv4Addr, Ipv6Addr, SocketAddr, ToSocketAddrs, UdpSocket};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{SystemTime, UNIX_EPOCH};

/// Sender of a live stream. It never waits: a sample that the computer cannot take at once is dropped and counted.
#[derive(Debug)]
pub struct Live {
    socket: UdpSocket,
    tally: Arc<Tally>,
    geometry: Geometry,
    /// Time of the stream's first sample, s since 1970.
    began: f64,
    text: String,
}

/// Number of samples of a live stream by what became of them.
#[derive(Debug)]
pub struct Tally {
    address: SocketAddr,
    sent: AtomicU64,
    dropped: AtomicU64,
    unheard: AtomicU64,
}

impl Tally {
    /// Samples handed to the network.
    #[must_use]
    pub fn sent(&self) -> u64 {
        self.sent.load(Ordering::Relaxed)
    }

    /// Samples that the computer did not take.
    #[must_use]
    pub fn dropped(&self) -> u64 {
        self.dropped.load(Ordering::Relaxed)
    }

    /// Samples sent of which the address said that nobody listens there. A listener further away says nothing.
    #[must_use]
    pub fn unheard(&self) -> u64 {
        self.unheard.load(Ordering::Relaxed)
    }
}

impl fmt::Display for Tally {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "live {}: {} samples sent, {} dropped", self.address, self.sent(), self.dropped())?;
        match self.unheard() {
            0 => Ok(()),
            unheard => write!(f, "; nobody listened for {unheard} of them"),
        }
    }
}

impl Live {
    /// Opens a stream to `HOST:PORT`.
    ///
    /// # Errors
    /// The address is not of that form, is unknown, or cannot be reached from this machine.
    pub fn to(address: &str) -> Result<Self> {
        let refused = |why: String| Error::Live { address: address.to_owned(), why };
        let port = address.rsplit_once(':').map(|(_, port)| port.parse::<u16>());
        if !matches!(port, Some(Ok(1..))) {
            return Err(refused("HOST:PORT is accepted, e.g. 127.0.0.1:9870; PORT is 1 to 65535".to_owned()));
        }
        let mut found = address.to_socket_addrs().map_err(|e| refused(reason(&e)))?;
        let to = found.next().ok_or_else(|| refused("the name has no address".to_owned()))?;
        let any = if to.is_ipv4() { Ipv4Addr::UNSPECIFIED.into() } else { Ipv6Addr::UNSPECIFIED.into() };
        let socket = UdpSocket::bind(SocketAddr::new(any, 0)).and_then(|socket| {
            socket.connect(to)?;
            socket.set_nonblocking(true)?;
            Ok(socket)
        });
        let socket = socket.map_err(|e| refused(reason(&e)))?;
        let none = || AtomicU64::new(0);
        let tally = Tally { address: to, sent: none(), dropped: none(), unheard: none() };
        Ok(Self {
            socket,
            tally: Arc::new(tally),
            geometry: Geometry::Linear,
            began: 0.0,
            text: String::new(),
        })
    }

    /// The counts, which stay readable when the stream is given away.
    #[must_use]
    pub fn tally(&self) -> Arc<Tally> {
        self.tally.clone()
    }

    /// Begins a stream of the device: its units, and the time of its first sample.
    pub fn header(&mut self, header: &Header) {
        self.geometry = header.geometry();
        self.began = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0.0, |since| since.as_secs_f64());
    }

    /// Sends a sample, or drops it.
    pub fn sample(&mut self, sample: &Sample) {
        self.text.clear();
        write_json(&mut self.text, self.geometry, self.began, sample);
        let mut sent = self.socket.send(self.text.as_bytes());
        if sent.as_ref().is_err_and(|e| e.kind() == ErrorKind::ConnectionRefused) {
            // reports an earlier datagram; this one has not been sent
            self.tally.unheard.fetch_add(1, Ordering::Relaxed);
            sent = self.socket.send(self.text.as_bytes());
        }
        let count = if sent.is_ok() { &self.tally.sent } else { &self.tally.dropped };
        count.fetch_add(1, Ordering::Relaxed);
    }
}

/// A sample as a flat JSON object.
pub(crate) fn write_json(out: &mut String, geometry: Geometry, began: f64, sample: &Sample) {
    // writing to a string cannot fail
    let _ = write!(out, "{{\"timestamp\":{:.6}", began + sample.time);
    for (name, (value, decimals)) in columns::names(geometry).iter().zip(columns::values(sample)) {
        if value.is_finite() {
            let _ = write!(out, ",\"{name}\":{value:.decimals$}");
        }
    }
    out.push('}');
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Event, Plan, RecordingFile, Session};
    use serde_json::Value;
    use signals::{ReadOptions, Recording};
    use std::time::Duration;

    fn listener() -> (UdpSocket, String) {
        let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
        socket.set_read_timeout(Some(Duration::from_secs(10))).unwrap();
        let address = socket.local_addr().unwrap().to_string();
        (socket, address)
    }

    fn received(socket: &UdpSocket) -> Value {
        let mut bytes = [0; 1500];
        let n = socket.recv(&mut bytes).unwrap();
        serde_json::from_slice(&bytes[..n]).unwrap()
    }

    #[test]
    fn a_listener_receives_what_is_recorded() {
        let (socket, address) = listener();
        let mut live = Live::to(&address).unwrap();
        let mut session = Session::open("sim", 3).unwrap();
        session.command("sim hand sine 0.008 2").unwrap();
        session.command("render on").unwrap();
        session.command("stream on").unwrap();
        let path = std::env::temp_dir().join(format!("tribos-live-{}.csv", std::process::id()));
        let plan = Plan { motion: None, seconds: 1.0, notes: Vec::new() };
        let mut file = None;
        let mut got = Vec::new();
        while got.len() < 2000 {
            for event in session.poll().unwrap() {
                match event {
                    Event::Header(header) => {
                        live.header(&header);
                        file = Some(RecordingFile::create(&path, &header, &plan).unwrap());
                    }
                    Event::Sample(sample) => {
                        file.as_mut().unwrap().write(&sample).unwrap();
                        live.sample(&sample);
                        got.push(received(&socket));
                    }
                    _ => {}
                }
            }
        }
        file.unwrap().finish(0).unwrap();
        let recorded = Recording::read(&path, &ReadOptions::default()).unwrap();
        std::fs::remove_file(&path).unwrap();
        println!("{} received, {} recorded; {}", got.len(), recorded.len(), got[1000]);
        assert_eq!(got.len(), recorded.len());
        assert_eq!((live.tally.sent(), live.tally.dropped()), (got.len() as u64, 0));
        let of = |column: &Option<Vec<f64>>| column.clone().unwrap();
        for (name, column) in [
            ("time_s", recorded.time.clone()),
            ("position_m", recorded.position.clone()),
            ("velocity_m_s", of(&recorded.velocity)),
            ("acceleration_m_s2", of(&recorded.acceleration)),
            ("force_n", recorded.force.clone()),
            ("command_n", of(&recorded.command)),
            ("reference_m", of(&recorded.reference)),
        ] {
            for (k, (datagram, value)) in got.iter().zip(&column).enumerate() {
                assert_eq!(datagram[name].as_f64(), Some(*value), "{name} of sample {k}");
            }
            let moves = column.iter().any(|value| *value != column[0]);
            assert!(moves || name == "reference_m", "{name} shows nothing");
        }
        // by the clock of the device, without the jitter of the line
        let stamp = |k: usize| got[k]["timestamp"].as_f64().unwrap();
        for k in 1..got.len() {
            assert!((stamp(k) - stamp(k - 1) - 1e-3).abs() < 3e-6, "{k}");
        }
        assert_eq!(got[0].as_object().unwrap().len(), 8);
    }

    #[test]
    fn a_value_that_is_not_a_number_made_the_datagram_unreadable() {
        let (socket, address) = listener();
        let mut live = Live::to(&address).unwrap();
        live.geometry = Geometry::Rotary;
        live.sample(&Sample {
            time: 0.25,
            force: f64::NAN,
            command: f64::INFINITY,
            position: -1.5,
            ..Sample::default()
        });
        let got = received(&socket);
        assert_eq!((got["timestamp"].as_f64(), got["position_rad"].as_f64()), (Some(0.25), Some(-1.5)));
        assert!(got.get("torque_nm").is_none() && got.get("command_nm").is_none());
    }

    #[test]
    fn nobody_listening_is_counted() {
        let (socket, address) = listener();
        drop(socket);
        let mut live = Live::to(&address).unwrap();
        for _ in 0..100 {
            live.sample(&Sample::default());
        }
        println!("{}", live.tally);
        assert_eq!(live.tally.sent() + live.tally.dropped(), 100);
        // loopback answers each datagram; how soon is the system's affair
        assert!(live.tally.unheard() > 0);
        assert!(live.tally.to_string().contains("; nobody listened for "));
    }

    #[test]
    fn a_wrong_address_is_one_error() {
        for (address, told) in [
            ("9870", "live 9870: HOST:PORT is accepted, e.g. 127.0.0.1:9870; PORT is 1 to 65535"),
            ("localhost:0", "PORT is 1 to 65535"),
            ("127.0.0.1:70000", "PORT is 1 to 65535"),
            ("no such host:9870", "live no such host:9870: "),
        ] {
            let error = Live::to(address).unwrap_err().to_string();
            println!("{error}");
            assert!(error.contains(told) && !error.contains('\n'), "{error}");
        }
    }
}
