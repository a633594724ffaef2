//! A headless Chromium, driven through its DevTools protocol, and a lab to point it at.

use serde_json::{Value, json};
use std::io::{BufRead, BufReader};
use std::net::TcpStream;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};
use tungstenite::{Message, WebSocket};
use untested::Need;

pub static CHROMIUM: Need =
    Need::new(|| find().is_none().then(|| "no chromium: the page is not checked".into())).spared_in_ci();

/// The browser of this machine.
pub fn chromium() -> PathBuf {
    find().expect("the tests of the page need it")
}

fn find() -> Option<PathBuf> {
    let named = std::env::var_os("CHROMIUM").map(PathBuf::from).filter(|path| path.exists());
    named.or_else(|| {
        ["chromium", "chromium-browser", "google-chrome", "chrome"].iter().find_map(|name| {
            let path = std::env::var_os("PATH")?;
            std::env::split_paths(&path).map(|dir| dir.join(name)).find(|path| path.exists())
        })
    })
}

/// `tribos lab` as a process of its own.
pub struct Lab {
    pub child: Child,
    pub url: String,
}

impl Lab {
    pub fn start(folder: &Path, arguments: &[&str]) -> Self {
        let mut child = Command::new(env!("CARGO_BIN_EXE_tribos"))
            .args(["lab", "--http-port", "0", "--out"])
            .arg(folder)
            .args(arguments)
            .stdout(Stdio::piped())
            .spawn()
            .expect("tribos lab starts");
        let out = child.stdout.take().expect("its output");
        let mut lines = BufReader::new(out).lines();
        let first = lines.next().expect("a line").expect("text");
        let url = first.split_whitespace().last().expect("an address").to_owned();
        // nobody reads the rest, but the pipe must stay open
        std::thread::spawn(move || lines.for_each(drop));
        Self { child, url }
    }

    /// `127.0.0.1:PORT`
    pub fn host(&self) -> &str {
        self.url.trim_start_matches("http://").split('/').next().expect("a host")
    }

    /// A socket as a page of the origin given opens it.
    pub fn socket(&self, origin: Option<&str>) -> Result<WebSocket<TcpStream>, String> {
        use tungstenite::client::IntoClientRequest;
        let mut request = format!("ws://{}/socket", self.host()).into_client_request().expect("a request");
        if let Some(origin) = origin {
            request.headers_mut().insert("Origin", origin.parse().expect("an origin"));
        }
        let stream = TcpStream::connect(self.host()).map_err(|e| e.to_string())?;
        stream.set_nodelay(true).expect("a socket");
        tungstenite::client(request, stream).map(|(socket, _)| socket).map_err(|e| e.to_string())
    }

    /// Answer to `GET path`: status line, head and body.
    pub fn get(&self, path: &str, headers: &str) -> String {
        use std::io::{Read, Write};
        let mut stream = TcpStream::connect(self.host()).expect("the lab listens");
        stream.set_read_timeout(Some(Duration::from_secs(20))).expect("a socket");
        let host = if headers.to_ascii_lowercase().contains("host:") {
            String::new()
        } else {
            format!("Host: {}\r\n", self.host())
        };
        write!(stream, "GET {path} HTTP/1.1\r\n{host}{headers}Connection: close\r\n\r\n").expect("sent");
        let mut bytes = Vec::new();
        let _ = stream.read_to_end(&mut bytes);
        String::from_utf8_lossy(&bytes).into_owned()
    }
}

impl Drop for Lab {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// One page in a browser of its own.
pub struct Page {
    child: Child,
    socket: WebSocket<TcpStream>,
    session: Option<String>,
    next: u64,
    _profile: tempfile::TempDir,
}

impl Page {
    pub fn open(chromium: &Path, url: &str, size: (u32, u32)) -> Self {
        let profile = tempfile::tempdir().expect("a folder");
        let mut child = Command::new(chromium)
            .args(["--headless", "--no-sandbox", "--disable-gpu", "--no-first-run", "--mute-audio"])
            .args(["--remote-debugging-port=0", "--disable-dev-shm-usage", "--hide-scrollbars"])
            .arg(format!("--window-size={},{}", size.0, size.1))
            .arg(format!("--user-data-dir={}", profile.path().display()))
            .arg("about:blank")
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .expect("chromium starts");
        let mut lines = BufReader::new(child.stderr.take().expect("its errors")).lines();
        let address = lines
            .by_ref()
            .map_while(Result::ok)
            .find_map(|line| line.split("DevTools listening on ").nth(1).map(str::to_owned))
            .expect("chromium says where it listens");
        std::thread::spawn(move || lines.for_each(drop));
        let host = address.trim_start_matches("ws://").split('/').next().expect("a host").to_owned();
        let stream = TcpStream::connect(host).expect("chromium listens");
        let (socket, _) = tungstenite::client(&address, stream).expect("a socket to chromium");
        let mut page = Self { child, socket, session: None, next: 0, _profile: profile };
        let target = page.call("Target.createTarget", json!({ "url": "about:blank" }));
        let attached =
            page.call("Target.attachToTarget", json!({ "targetId": target["targetId"], "flatten": true }));
        page.session = attached["sessionId"].as_str().map(str::to_owned);
        page.call("Page.enable", json!({}));
        page.size(size, 1.0);
        page.goto(url);
        page
    }

    /// The page of a lab whose device has answered.
    pub fn of(lab: &Lab, chromium: &Path, size: (u32, u32)) -> Self {
        let mut page = Self::open(chromium, &lab.url, size);
        page.until("the device answers", "lab.known.connected && lab.ring.end > 100", 30);
        page
    }

    /// Size of the window in CSS pixels.
    pub fn size(&mut self, (width, height): (u32, u32), scale: f64) {
        let mobile = width < 600;
        let metrics =
            json!({ "width": width, "height": height, "deviceScaleFactor": scale, "mobile": mobile });
        self.call("Emulation.setDeviceMetricsOverride", metrics);
    }

    pub fn goto(&mut self, url: &str) {
        self.call("Page.navigate", json!({ "url": url }));
    }

    pub fn dark(&mut self, dark: bool) {
        let value = if dark { "dark" } else { "light" };
        self.call(
            "Emulation.setEmulatedMedia",
            json!({ "features": [{ "name": "prefers-color-scheme", "value": value }] }),
        );
    }

    /// Sends a command and waits for what it gives.
    pub fn call(&mut self, method: &str, params: Value) -> Value {
        self.next += 1;
        let id = self.next;
        let mut command = json!({ "id": id, "method": method, "params": params });
        if let Some(session) = &self.session {
            command["sessionId"] = json!(session);
        }
        self.socket.send(Message::text(command.to_string())).expect("chromium hears");
        loop {
            let Message::Text(text) = self.socket.read().expect("chromium answers") else { continue };
            let answer: Value = serde_json::from_str(text.as_str()).expect("JSON");
            if answer["id"] == json!(id) {
                assert!(answer.get("error").is_none(), "{method}: {}", answer["error"]);
                return answer["result"].clone();
            }
        }
    }

    /// Value of an expression in the page; a promise is waited for.
    pub fn eval(&mut self, expression: &str) -> Value {
        let given = self.call(
            "Runtime.evaluate",
            json!({ "expression": expression, "awaitPromise": true, "returnByValue": true, "userGesture": true }),
        );
        assert!(given.get("exceptionDetails").is_none(), "{expression}: {}", given["exceptionDetails"]);
        given["result"]["value"].clone()
    }

    /// Waits until an expression is true.
    pub fn until(&mut self, what: &str, expression: &str, seconds: u64) {
        let began = Instant::now();
        loop {
            let expression =
                format!("Boolean((() => {{ try {{ return {expression}; }} catch {{ return false; }} }})())");
            if self.eval(&expression) == json!(true) {
                return;
            }
            assert!(
                began.elapsed() < Duration::from_secs(seconds),
                "{what}: not within {seconds} s: {expression}"
            );
            std::thread::sleep(Duration::from_millis(50));
        }
    }

    /// Presses a key as a person does.
    pub fn key(&mut self, key: &str) {
        let text = if key.chars().count() == 1 { key } else { "" };
        for kind in ["keyDown", "keyUp"] {
            let text = if kind == "keyDown" { text } else { "" };
            self.call(
                "Input.dispatchKeyEvent",
                json!({ "type": kind, "key": key, "code": key, "text": text }),
            );
        }
    }

    /// `mousePressed`, `mouseMoved` or `mouseReleased` at a place of the window.
    pub fn mouse(&mut self, kind: &str, x: f64, y: f64) {
        let buttons = u8::from(kind != "mouseReleased");
        let event =
            json!({ "type": kind, "x": x, "y": y, "button": "left", "buttons": buttons, "clickCount": 1 });
        self.call("Input.dispatchMouseEvent", event);
    }

    /// A picture of the page, into the folder named by `PICTURES`, if it is.
    pub fn picture(&mut self, name: &str) {
        let Some(folder) = std::env::var_os("PICTURES") else { return };
        let shot = self.call("Page.captureScreenshot", json!({ "format": "png" }));
        let bytes = base64(shot["data"].as_str().unwrap_or_default());
        std::fs::create_dir_all(&folder).expect("a folder for pictures");
        std::fs::write(Path::new(&folder).join(format!("{name}.png")), bytes).expect("a picture");
    }

    /// Processes of this browser, the parent first.
    pub fn pid(&self) -> u32 {
        self.child.id()
    }
}

impl Drop for Page {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn base64(text: &str) -> Vec<u8> {
    let digit = |b: u8| match b {
        b'A'..=b'Z' => Some(b - b'A'),
        b'a'..=b'z' => Some(b - b'a' + 26),
        b'0'..=b'9' => Some(b - b'0' + 52),
        b'+' => Some(62),
        b'/' => Some(63),
        _ => None,
    };
    let digits: Vec<u8> = text.bytes().filter_map(digit).collect();
    let mut out = Vec::with_capacity(digits.len() * 3 / 4);
    for four in digits.chunks(4) {
        let bits = four.iter().fold(0_u32, |bits, &d| bits << 6 | u32::from(d)) << (6 * (4 - four.len()));
        out.extend_from_slice(&bits.to_be_bytes()[1..four.len()]);
    }
    out
}
