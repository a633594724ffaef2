//! The handover, tested through its messages, with a body beyond the limits of the device: what is sent, what is left out, and
//! why.

use client::Session;
use design::LeftOut;
use lab::{Found, Lab, Options, Progress, Tools};
use serde_json::{Value, json};
use std::net::TcpStream;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};
use tungstenite::{Message, WebSocket};

/// Tools that find whatever they are told to find.
struct Finds(Found, Option<&'static str>);

impl Tools for Finds {
    fn port(&self) -> &str {
        "sim"
    }

    fn open(&self) -> Result<Session, client::Error> {
        Session::open("sim", 1)
    }

    fn identify(&self, _: &[PathBuf], _: &Path, _: Progress<'_>) -> Result<Found, String> {
        Err("not here".into())
    }

    fn diagnose(&self, _: &[PathBuf], _: &Path, progress: Progress<'_>) -> Result<Found, String> {
        match progress(0.5, "searching") {
            ControlFlow::Continue(()) => Ok(self.0.clone()),
            ControlFlow::Break(()) => Err("interrupted".into()),
        }
    }

    fn analyse(&self, _: &[PathBuf], _: &Path, _: Progress<'_>) -> Result<Found, String> {
        Err("not here".into())
    }

    fn not_a_body(&self, _: &Path) -> Result<Option<String>, String> {
        Ok(self.1.map(str::to_owned))
    }

    fn to_mcap(&self, _: &Path, _: &Path) -> Result<(), String> {
        Err("not here".into())
    }
}

/// A lab that finds this, and a page of it.
struct Bench {
    socket: WebSocket<TcpStream>,
    _lab: Lab,
    _folder: tempfile::TempDir,
}

impl Bench {
    fn with(finds: Finds) -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        let options = Options {
            address: ([127, 0, 0, 1], 0).into(),
            token: None,
            folder: folder.path().to_owned(),
            live: client::Streams::default(),
        };
        let lab = Lab::start(options, Arc::new(finds)).expect("a free port");
        let stream = TcpStream::connect(lab.address()).expect("the lab listens");
        stream.set_read_timeout(Some(Duration::from_secs(20))).expect("a socket");
        use tungstenite::client::IntoClientRequest;
        let mut request = format!("ws://{}/socket", lab.address()).into_client_request().expect("a request");
        let origin = format!("http://{}", lab.address());
        request.headers_mut().insert("Origin", origin.parse().expect("an origin"));
        let (socket, _) = tungstenite::client(request, stream).expect("its own page");
        let mut bench = Self { socket, _lab: lab, _folder: folder };
        bench.until("the device streams", |now| {
            now["connected"] == true && now["epoch"] != 0 && now["presets"][0].is_string()
        });
        bench
    }

    fn ask(&mut self, what: &Value) {
        self.socket.send(Message::text(what.to_string())).expect("the lab hears");
    }

    fn until(&mut self, what: &str, holds: impl Fn(&Value) -> bool) -> Value {
        let began = Instant::now();
        loop {
            assert!(began.elapsed() < Duration::from_secs(30), "{what}: not within 30 s");
            let Message::Text(text) = self.socket.read().unwrap_or_else(|e| panic!("{what}: {e}")) else {
                continue;
            };
            let now: Value = serde_json::from_str(text.as_str()).expect("JSON");
            if holds(&now) {
                return now;
            }
        }
    }

    /// Records a second, diagnoses it, and waits for what can be done with it.
    fn diagnosed(&mut self) -> Value {
        self.ask(&json!({ "do": "handover_record", "by_hand": true }));
        self.until("it records", |now| now["recording"].as_u64() > Some(1_000));
        self.ask(&json!({ "do": "record_end" }));
        self.until("it is recorded", |now| now["handover"]["step"] == "diagnose");
        self.ask(&json!({ "do": "handover_diagnose" }));
        let now = self.until("it is diagnosed", |now| {
            now["handover"]["step"] == "send" || now["handover"]["step"] == "refused"
        });
        now["handover"].clone()
    }
}

fn found(lines: &[(&str, &str)]) -> Found {
    let preset = lines.iter().map(|(name, value)| ((*name).to_owned(), (*value).to_owned())).collect();
    Found { preset, summary: "The simulation leaves out cogging.".into(), ..Found::default() }
}

fn parameter(state: &Value, name: &str) -> f64 {
    let all = state["verdict"]["parameters"].as_array().expect("a list");
    let value = all.iter().find(|p| p["name"] == name).map(|p| p["value"].as_str().expect("a value"));
    value.and_then(|value| value.parse().ok()).unwrap_or(f64::NAN)
}

#[test]
fn what_exceeds_the_device_is_named_and_the_rest_is_felt() {
    let mut body = found(&[
        ("law", "karnopp"),
        ("mass", "0.0"),
        ("f_static", "15"),
        ("f_dynamic", "2.5"),
        ("damping", "4"),
        ("cogging.sine_1", "0.6"),
        ("cogging.wavelength", "0.008"),
        ("spring.stiffness", "5e7"),
    ]);
    body.left_out.push(LeftOut { name: "compliance".into(), why: "sensor or drive".into() });
    let mut bench = Bench::with(Finds(body, None));
    let plan = bench.diagnosed();
    for note in ["moved", "left_out"] {
        println!("{note}: {}", plan[note]);
    }
    assert_eq!(plan["step"], "send");
    let moved = &plan["moved"][0];
    assert_eq!((&moved["name"], moved["found"].as_f64()), (&json!("f_static_p"), Some(15.0)));
    assert!(moved["why"].as_str().is_some_and(|why| why.contains("limit of the actuator")));
    let names: Vec<&str> = plan["left_out"]
        .as_array()
        .expect("a list")
        .iter()
        .filter_map(|left| left["name"].as_str())
        .collect();
    assert_eq!(names, ["mass", "spring", "compliance"]);
    let why = plan["left_out"][1]["why"].as_str().expect("a reason");
    assert!(why.starts_with("spring.stiffness = 50000000: accepted from 0 to "), "{why}");
    // the pattern shows over the position, before anything is sent
    let curve = |of: &str| -> Vec<f64> {
        plan[of]["over_position"].as_array().expect("a curve").iter().filter_map(Value::as_f64).collect()
    };
    let span = |of: &str| {
        curve(of).iter().fold(f64::MIN, |m, x| m.max(*x)) - curve(of).iter().fold(f64::MAX, |m, x| m.min(*x))
    };
    println!("over position: {:.3} N before, {:.3} N after", span("before"), span("after"));
    assert!(span("before") < 0.01 && (span("after") - 1.2).abs() < 0.05);

    // stopped on its way, and sent again
    bench.ask(&json!({ "do": "handover_send" }));
    bench.ask(&json!({ "do": "stop" }));
    bench.until("it is stopped", |now| now["handover"]["step"] == "send" && now["armed"] == false);
    bench.ask(&json!({ "do": "handover_send" }));
    let sent = bench.until("it is on the device", |now| now["handover"]["step"] == "sent");
    assert_eq!(parameter(&sent, "f_dynamic_p"), 2.5);
    assert_eq!(parameter(&sent, "cogging.sine_1"), 0.6);
    assert!(parameter(&sent, "spring.stiffness").is_nan());
    bench.until("force is on", |now| now["mode"] == "rendering");
    // a stop is a stop, and another preset is compared anew
    bench.ask(&json!({ "do": "stop" }));
    bench.until("force is off", |now| now["mode"] == "idle" && now["armed"] == false);
    bench.ask(&json!({ "do": "use", "name": "teflon" }));
    let again = bench.until("it can be sent again", |now| now["handover"]["step"] == "send");
    assert_eq!(again["preset"], "teflon");
    assert!(again["handover"]["differences"].as_array().is_some_and(|list| list.len() > 5));
}

#[test]
fn nothing_is_sent_of_what_cannot_be_rendered() {
    let none = ["f_static", "f_dynamic", "damping"].map(|name| (name, "0"));
    let cases = [
        (Finds(found(&[]), None), "no model was found"),
        (Finds(found(&[("law", "stick_slip")]), None), "expected one of"),
        (Finds(found(&none), None), "no friction was found"),
        (Finds(found(&[("f_static", "2")]), Some("it shows a hand")), "shows a hand"),
    ];
    for (finds, why) in cases {
        let mut bench = Bench::with(finds);
        let plan = bench.diagnosed();
        println!("{}", plan["refused"]);
        assert_eq!(plan["step"], "refused");
        assert!(plan["refused"].as_str().is_some_and(|text| text.contains(why)), "{why}");
        bench.ask(&json!({ "do": "handover_send" }));
        bench.until("refused", |now| now["tone"] == "refused" && now["text"] == plan["refused"]);
    }
}
