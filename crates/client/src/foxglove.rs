//! A live stream for Foxglove: a WebSocket server of its protocol [foxglove-ws].
//!
//! It sends and takes no commands. A client chooses the one channel, and receives each sample as JSON with the time of the device.
//! Every client has a queue and a thread: a slow one loses samples, which are counted, and nobody waits for it.

use crate::columns;
use crate::error::{Error, Result};
use crate::live::write_json;
use crate::sample::{Header, Sample};
use friction::Geometry;
use serde_json::{Map, Value, json};
use signals::files::reason;
use std::collections::BTreeMap;
use std::fmt;
use std::io::ErrorKind;
use std::net::{SocketAddr, TcpListener, TcpStream, ToSocketAddrs};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, TryRecvError, TrySendError, sync_channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, SystemTime, UNIX_EPOCH};
use tungstenite::handshake::server::{ErrorResponse, Request, Response};
use tungstenite::http::{HeaderValue, StatusCode};
use tungstenite::protocol::WebSocketConfig;
use tungstenite::{Message, WebSocket};

/// Names of the protocol, by which clients ask for it; the second one is that of newer clients.
const PROTOCOLS: [&str; 2] = ["foxglove.websocket.v1", "foxglove.sdk.v1"];
/// Topic of the samples.
const TOPIC: &str = "/tribos";
/// Samples that wait for a client, some 2 s.
const KEPT: usize = 2048;
/// Most clients at once.
const CLIENTS: usize = 8;
/// Longest message of a client, bytes.
const LONGEST: usize = 64 * 1024;
/// Longest handshake.
const HANDSHAKE: Duration = Duration::from_secs(5);
/// Interval at which a client's thread looks for messages both ways.
const LOOK: Duration = Duration::from_millis(5);
/// Longest wait for a client that takes nothing, before its queue fills.
const WAIT: Duration = Duration::from_millis(100);
/// Interval at which new clients are accepted.
const ACCEPT: Duration = Duration::from_millis(20);

/// Numbers of samples and clients of a stream.
#[derive(Debug)]
pub struct FoxgloveTally {
    address: SocketAddr,
    sent: AtomicU64,
    dropped: AtomicU64,
    clients: AtomicU64,
}

impl FoxgloveTally {
    /// Where it listens.
    #[must_use]
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// Samples sent, over all clients.
    #[must_use]
    pub fn sent(&self) -> u64 {
        self.sent.load(Ordering::Relaxed)
    }

    /// Samples that a client was too slow for.
    #[must_use]
    pub fn dropped(&self) -> u64 {
        self.dropped.load(Ordering::Relaxed)
    }
}

impl fmt::Display for FoxgloveTally {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let clients = self.clients.load(Ordering::Relaxed);
        let s = if clients == 1 { "" } else { "s" };
        let (sent, dropped) = (self.sent(), self.dropped());
        write!(
            f,
            "foxglove ws://{}: {clients} client{s}, {sent} samples sent, {dropped} dropped",
            self.address
        )
    }
}

/// What a client is sent.
enum News {
    /// The channel with this id.
    Channel(u64, String),
    /// A sample: channel, ns since 1970, JSON.
    Sample(u64, u64, String),
}

#[derive(Default)]
struct Hub {
    channel: Option<Arc<News>>,
    clients: Vec<SyncSender<Arc<News>>>,
}

/// Server of a live stream; dropping it ends it.
pub struct Foxglove {
    hub: Arc<Mutex<Hub>>,
    tally: Arc<FoxgloveTally>,
    ended: Arc<AtomicBool>,
    geometry: Geometry,
    channel: u64,
    /// Time of the stream's first sample since 1970.
    began: Duration,
}

impl fmt::Debug for Foxglove {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Foxglove").field("tally", &self.tally).finish_non_exhaustive()
    }
}

/// The hub stays usable after a panic.
fn locked(hub: &Mutex<Hub>) -> MutexGuard<'_, Hub> {
    hub.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Foxglove {
    /// Listens at `HOST:PORT`; port 0 takes a free one.
    ///
    /// # Errors
    /// The address is not of that form, is none of this machine, or is taken.
    pub fn at(address: &str) -> Result<Self> {
        let refused = |why: String| Error::Live { address: address.to_owned(), why };
        let port = address.rsplit_once(':').map(|(_, port)| port.parse::<u16>());
        if !matches!(port, Some(Ok(_))) {
            return Err(refused("HOST:PORT is accepted, e.g. 127.0.0.1:8765; PORT is 0 to 65535".to_owned()));
        }
        let addresses: Vec<SocketAddr> =
            address.to_socket_addrs().map_err(|e| refused(reason(&e)))?.collect();
        let listener = TcpListener::bind(addresses.as_slice()).and_then(|listener| {
            listener.set_nonblocking(true)?;
            let address = listener.local_addr()?;
            Ok((listener, address))
        });
        let (listener, address) = listener.map_err(|e| refused(reason(&e)))?;
        let none = || AtomicU64::new(0);
        let tally = Arc::new(FoxgloveTally { address, sent: none(), dropped: none(), clients: none() });
        let hub = Arc::new(Mutex::new(Hub::default()));
        let ended = Arc::new(AtomicBool::new(false));
        let threads = (hub.clone(), tally.clone(), ended.clone());
        std::thread::spawn(move || accept(&listener, &threads.0, &threads.1, &threads.2));
        Ok(Self { hub, tally, ended, geometry: Geometry::Linear, channel: 0, began: Duration::ZERO })
    }

    /// The counts, which stay readable when the stream is given away.
    #[must_use]
    pub fn tally(&self) -> Arc<FoxgloveTally> {
        self.tally.clone()
    }

    /// Begins a stream of the device: a channel in its units, unless there is one, and the time of its first sample.
    pub fn header(&mut self, header: &Header) {
        self.begin(header.geometry());
    }

    fn begin(&mut self, geometry: Geometry) {
        self.began = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
        let mut hub = locked(&self.hub);
        if hub.channel.is_some() && self.geometry == geometry {
            return;
        }
        self.geometry = geometry;
        self.channel += 1;
        let mut properties = Map::new();
        for name in ["timestamp"].iter().chain(&columns::names(geometry)) {
            properties.insert((*name).to_owned(), json!({ "type": "number" }));
        }
        let schema = json!({ "type": "object", "properties": properties }).to_string();
        let channel = json!({
            "op": "advertise",
            "channels": [{
                "id": self.channel, "topic": TOPIC, "encoding": "json", "schemaName": "tribos.Sample",
                "schema": schema, "schemaEncoding": "jsonschema",
            }],
        });
        let news = Arc::new(News::Channel(self.channel, channel.to_string()));
        hub.channel = Some(news.clone());
        hub.clients.retain(|client| client.try_send(news.clone()).is_ok());
    }

    /// Hands a sample to every client. It never waits.
    pub fn sample(&mut self, sample: &Sample) {
        let mut hub = locked(&self.hub);
        if hub.clients.is_empty() {
            return;
        }
        let at = self.began + Duration::from_nanos((1e9 * sample.time).max(0.0).round() as u64);
        let mut text = String::new();
        write_json(&mut text, self.geometry, self.began.as_secs_f64(), sample);
        let news = Arc::new(News::Sample(self.channel, at.as_nanos() as u64, text));
        let tally = &self.tally;
        hub.clients.retain(|client| match client.try_send(news.clone()) {
            Ok(()) => true,
            Err(TrySendError::Full(_)) => {
                tally.dropped.fetch_add(1, Ordering::Relaxed);
                true
            }
            Err(TrySendError::Disconnected(_)) => false,
        });
    }
}

impl Drop for Foxglove {
    fn drop(&mut self) {
        self.ended.store(true, Ordering::Relaxed);
        // ends the threads of the clients
        locked(&self.hub).clients.clear();
    }
}

fn accept(listener: &TcpListener, hub: &Arc<Mutex<Hub>>, tally: &Arc<FoxgloveTally>, ended: &AtomicBool) {
    while !ended.load(Ordering::Relaxed) {
        match listener.accept() {
            Ok((stream, _)) => {
                let (hub, tally) = (hub.clone(), tally.clone());
                std::thread::spawn(move || {
                    // a client that goes, or speaks another protocol, ends its thread and nothing else
                    let _ = serve(stream, &hub, &tally);
                });
            }
            Err(_) => std::thread::sleep(ACCEPT),
        }
    }
}

/// Agrees with the client on the protocol.
#[allow(clippy::result_large_err)] // the type of the library
fn agree(request: &Request, mut response: Response) -> std::result::Result<Response, ErrorResponse> {
    const HEADER: &str = "Sec-WebSocket-Protocol";
    let asked = request.headers().get_all(HEADER).iter().filter_map(|value| value.to_str().ok());
    let asked: Vec<&str> = asked.flat_map(|value| value.split(',').map(str::trim)).collect();
    match PROTOCOLS.into_iter().find(|protocol| asked.contains(protocol)) {
        Some(protocol) => {
            response.headers_mut().insert(HEADER, HeaderValue::from_static(protocol));
            Ok(response)
        }
        None => {
            let why = format!("accepted are the subprotocols {}\n", PROTOCOLS.join(", "));
            let mut refused = ErrorResponse::new(Some(why));
            *refused.status_mut() = StatusCode::BAD_REQUEST;
            Err(refused)
        }
    }
}

type Socket = WebSocket<TcpStream>;
type Ended = std::result::Result<(), Box<tungstenite::Error>>;

/// Whether it worked; a socket that has no data or no room is asked again later.
fn now<T>(result: tungstenite::Result<T>) -> std::result::Result<Option<T>, Box<tungstenite::Error>> {
    match result {
        Ok(value) => Ok(Some(value)),
        Err(tungstenite::Error::Io(e)) if matches!(e.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => {
            Ok(None)
        }
        Err(e) => Err(Box::new(e)),
    }
}

/// Serves one client until it goes or the stream ends.
fn serve(stream: TcpStream, hub: &Mutex<Hub>, tally: &FoxgloveTally) -> Ended {
    let prepared = |time: Duration| {
        stream.set_nonblocking(false)?;
        stream.set_nodelay(true)?;
        stream.set_read_timeout(Some(time))?;
        stream.set_write_timeout(Some(WAIT))?;
        stream.try_clone()
    };
    let io = |e: std::io::Error| Box::new(tungstenite::Error::Io(e));
    let own = prepared(HANDSHAKE).map_err(io)?;
    let config = WebSocketConfig::default().max_message_size(Some(LONGEST)).max_frame_size(Some(LONGEST));
    let Ok(mut socket) = tungstenite::accept_hdr_with_config(own, agree, Some(config)) else { return Ok(()) };
    stream.set_read_timeout(Some(LOOK)).map_err(io)?;
    let info = json!({
        "op": "serverInfo", "name": "tribos", "capabilities": [], "supportedEncodings": [], "metadata": {},
    });
    socket.send(Message::text(info.to_string()))?;
    let (client, news) = sync_channel(KEPT);
    {
        let mut hub = locked(hub);
        if hub.clients.len() >= CLIENTS {
            return socket.close(None).map_err(Box::new);
        }
        if let Some(channel) = &hub.channel {
            // an empty queue has room
            let _ = client.try_send(channel.clone());
        }
        hub.clients.push(client);
    }
    tally.clients.fetch_add(1, Ordering::Relaxed);
    let mut subscribed = BTreeMap::new();
    let mut channel = 0;
    loop {
        if let Some(Message::Text(text)) = now(socket.read())?
            && let Some(why) = obey(text.as_str(), channel, &mut subscribed)
        {
            let status = json!({ "op": "status", "level": 2, "message": why });
            now(socket.send(Message::text(status.to_string())))?;
        }
        if !pass(&mut socket, &news, &mut channel, &mut subscribed, tally)? {
            return socket.close(None).map_err(Box::new);
        }
    }
}

/// Sends what waits, as long as the client takes it; false when the stream has ended.
fn pass(
    socket: &mut Socket,
    news: &Receiver<Arc<News>>,
    channel: &mut u64,
    subscribed: &mut BTreeMap<u32, u64>,
    tally: &FoxgloveTally,
) -> std::result::Result<bool, Box<tungstenite::Error>> {
    while now(socket.flush())?.is_some() {
        let news = match news.try_recv() {
            Ok(news) => news,
            Err(TryRecvError::Empty) => break,
            Err(TryRecvError::Disconnected) => return Ok(false),
        };
        match &*news {
            News::Channel(id, text) => {
                if *channel != 0 {
                    let gone = json!({ "op": "unadvertise", "channelIds": [*channel] });
                    now(socket.write(Message::text(gone.to_string())))?;
                    subscribed.clear();
                }
                *channel = *id;
                now(socket.write(Message::text(text.clone())))?;
            }
            News::Sample(id, at, text) => {
                for (subscription, _) in subscribed.iter().filter(|(_, channel)| *channel == id) {
                    let mut bytes = Vec::with_capacity(13 + text.len());
                    bytes.push(1);
                    bytes.extend(subscription.to_le_bytes());
                    bytes.extend(at.to_le_bytes());
                    bytes.extend(text.as_bytes());
                    now(socket.write(Message::binary(bytes)))?;
                    tally.sent.fetch_add(1, Ordering::Relaxed);
                }
            }
        }
    }
    Ok(true)
}

/// Obeys a message of a client; what is wrong with it, if anything is.
fn obey(text: &str, channel: u64, subscribed: &mut BTreeMap<u32, u64>) -> Option<String> {
    let Ok(message) = serde_json::from_str::<Value>(text) else {
        return Some("the message is not JSON; subscribe and unsubscribe are accepted".into());
    };
    let list = |name: &str| message[name].as_array().cloned().unwrap_or_default();
    let id = |value: &Value| value.as_u64().and_then(|id| u32::try_from(id).ok());
    match message["op"].as_str() {
        Some("subscribe") => {
            for wanted in list("subscriptions") {
                let (Some(id), Some(of)) = (id(&wanted["id"]), wanted["channelId"].as_u64()) else {
                    return Some("a subscription needs the numbers id and channelId".into());
                };
                if of != channel {
                    return Some(format!("channel {of} is not there; accepted is {channel}"));
                }
                if subscribed.len() < CLIENTS {
                    subscribed.insert(id, of);
                }
            }
            None
        }
        Some("unsubscribe") => {
            for gone in list("subscriptionIds").iter().filter_map(id) {
                subscribed.remove(&gone);
            }
            None
        }
        op => Some(format!(
            "{} is not served; subscribe and unsubscribe are",
            op.unwrap_or("a message without op")
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tungstenite::client::IntoClientRequest;

    fn client(stream: &Foxglove, protocol: &str) -> tungstenite::Result<Socket> {
        let address = stream.tally.address();
        let mut request = format!("ws://{address}").into_client_request()?;
        let protocol = HeaderValue::from_str(protocol).expect("ASCII");
        request.headers_mut().insert("Sec-WebSocket-Protocol", protocol);
        let socket = TcpStream::connect(address)?;
        socket.set_read_timeout(Some(Duration::from_secs(20)))?;
        match tungstenite::client(request, socket) {
            Ok((socket, response)) => {
                let agreed = response.headers().get("Sec-WebSocket-Protocol").cloned();
                println!("agreed on {agreed:?}");
                Ok(socket)
            }
            Err(tungstenite::HandshakeError::Failure(e)) => Err(e),
            Err(tungstenite::HandshakeError::Interrupted(_)) => panic!("the handshake was interrupted"),
        }
    }

    fn text(socket: &mut Socket) -> Value {
        loop {
            if let Message::Text(text) = socket.read().expect("a message") {
                return serde_json::from_str(text.as_str()).expect("JSON");
            }
        }
    }

    /// Subscription, ns and JSON of a message of samples, by the bytes that the protocol says.
    fn sample(socket: &mut Socket) -> (u32, u64, Value) {
        loop {
            if let Message::Binary(bytes) = socket.read().expect("a message") {
                assert_eq!(bytes[0], 1);
                let id = u32::from_le_bytes(bytes[1..5].try_into().expect("4 bytes"));
                let at = u64::from_le_bytes(bytes[5..13].try_into().expect("8 bytes"));
                return (id, at, serde_json::from_slice(&bytes[13..]).expect("JSON"));
            }
        }
    }

    fn subscribed(stream: &Foxglove, id: u32) -> Socket {
        let mut socket = client(stream, "foxglove.sdk.v1, foxglove.websocket.v1").expect("connected");
        assert_eq!(text(&mut socket)["op"], "serverInfo");
        let channel = text(&mut socket)["channels"][0].clone();
        assert_eq!((channel["topic"].as_str(), channel["encoding"].as_str()), (Some(TOPIC), Some("json")));
        let schema: Value = serde_json::from_str(channel["schema"].as_str().expect("text")).expect("JSON");
        assert_eq!(schema["properties"]["force_n"]["type"], "number");
        let ask = json!({ "op": "subscribe", "subscriptions": [{ "id": id, "channelId": channel["id"] }] });
        socket.send(Message::text(ask.to_string())).expect("sent");
        socket
    }

    fn of(k: u32) -> Sample {
        Sample { time: f64::from(k) * 1e-3, force: f64::from(k), ..Sample::default() }
    }

    #[test]
    fn a_client_reads_samples_with_their_time() {
        let mut stream = Foxglove::at("127.0.0.1:0").expect("a server");
        stream.begin(Geometry::Linear);
        let mut socket = subscribed(&stream, 7);
        // the subscription arrives when it arrives
        let reader = std::thread::spawn(move || (0..500).map(|_| sample(&mut socket)).collect::<Vec<_>>());
        let mut k = 0;
        while !reader.is_finished() {
            stream.sample(&of(k));
            k += 1;
            std::thread::sleep(Duration::from_micros(200));
        }
        let got = reader.join().expect("read");
        for (before, after) in got.iter().zip(&got[1..]) {
            assert_eq!(after.0, 7);
            // to the nanosecond, by the clock of the device
            assert_eq!(after.1 - before.1, 1_000_000);
            let force = |(_, _, json): &(u32, u64, Value)| json["force_n"].as_f64().expect("a number");
            assert_eq!(force(after) - force(before), 1.0);
            assert_eq!(1e3 * after.2["time_s"].as_f64().expect("a number"), force(after));
        }
        let since_1970 = Duration::from_nanos(got[0].1);
        let now = SystemTime::now().duration_since(UNIX_EPOCH).expect("a clock");
        assert!(now.abs_diff(since_1970) < Duration::from_secs(3600), "{since_1970:?}");
    }

    #[test]
    fn a_client_that_reads_nothing_loses_samples() {
        let mut stream = Foxglove::at("127.0.0.1:0").expect("a server");
        stream.begin(Geometry::Linear);
        let (slow, mut good) = (subscribed(&stream, 1), subscribed(&stream, 2));
        let reader = std::thread::spawn(move || {
            for _ in 0..1000 {
                sample(&mut good);
            }
        });
        let mut k = 0;
        // buffers of sockets hold megabytes
        while stream.tally.dropped() == 0 || !reader.is_finished() {
            stream.sample(&of(k));
            k += 1;
            assert!(k < 3_000_000, "{}", stream.tally);
            if k % 200 == 0 {
                std::thread::sleep(Duration::from_millis(1));
            }
        }
        reader.join().expect("read");
        println!("{k} samples: {}", stream.tally);
        drop(slow);
    }

    #[test]
    fn another_protocol_and_wrong_messages_are_refused() {
        let mut stream = Foxglove::at("127.0.0.1:0").expect("a server");
        assert!(client(&stream, "mqtt").is_err());
        stream.begin(Geometry::Rotary);
        let mut socket = client(&stream, PROTOCOLS[0]).expect("connected");
        let channel = [text(&mut socket), text(&mut socket)][1]["channels"][0]["id"].clone();
        for (wrong, told) in [
            ("{".to_owned(), "not JSON"),
            (json!({ "op": "advertise" }).to_string(), "advertise is not served"),
            (json!({ "op": "subscribe", "subscriptions": [{ "id": -1 }] }).to_string(), "numbers id"),
            (
                json!({ "op": "subscribe", "subscriptions": [{ "id": 1, "channelId": 99 }] }).to_string(),
                "channel 99",
            ),
        ] {
            socket.send(Message::text(wrong)).expect("sent");
            let said = text(&mut socket);
            println!("{said}");
            assert!(said["op"] == "status" && said["message"].as_str().expect("text").contains(told));
        }
        // a device that becomes a slide has other columns
        stream.begin(Geometry::Linear);
        assert_eq!(text(&mut socket)["channelIds"][0], channel);
        assert_ne!(text(&mut socket)["channels"][0]["id"], channel);
        for (address, told) in [("8765", "HOST:PORT is accepted"), ("127.0.0.1:70000", "PORT is 0 to 65535")]
        {
            let error = Foxglove::at(address).expect_err("refused").to_string();
            assert!(error.contains(told) && !error.contains('\n'), "{error}");
        }
        let taken = Foxglove::at(&stream.tally.address().to_string()).expect_err("taken").to_string();
        println!("{taken}");
        drop(stream);
        assert!(loop {
            match socket.read() {
                Ok(Message::Close(_)) | Err(_) => break true,
                Ok(_) => {}
            }
        });
    }
}
