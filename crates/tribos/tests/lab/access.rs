//! The lab as somebody with bad intentions meets it.

use crate::browser::{Lab, Page, chromium};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::{Value, json};
use std::time::{Duration, Instant};
use tungstenite::{Message, WebSocket};

pub type Socket = WebSocket<std::net::TcpStream>;

fn lab(folder: &tempfile::TempDir) -> Lab {
    Lab::start(&folder.path().join("lab"), &["sim"])
}

pub fn own_socket(lab: &Lab) -> Socket {
    let origin = format!("http://{}", lab.host());
    let socket = lab.socket(Some(&origin)).expect("its own page");
    socket.get_ref().set_read_timeout(Some(Duration::from_secs(20))).expect("a socket");
    socket
}

/// Messages until one is as wanted.
pub fn wait_for(socket: &mut Socket, what: &str, mut wanted: impl FnMut(&Value) -> bool) -> Value {
    let began = Instant::now();
    loop {
        assert!(began.elapsed() < Duration::from_secs(20), "{what}: not within 20 s");
        let Message::Text(text) = socket.read().unwrap_or_else(|e| panic!("{what}: {e}")) else { continue };
        let message: Value = serde_json::from_str(text.as_str()).expect("JSON");
        if wanted(&message) {
            return message;
        }
    }
}

pub fn ask(socket: &mut Socket, what: &Value) {
    socket.send(Message::text(what.to_string())).expect("the lab hears");
}

pub fn pages_of_other_origins_can_neither_read_nor_command() {
    let folder = tempfile::tempdir().expect("a folder");
    let lab = lab(&folder);
    let own = format!("http://{}", lab.host());
    for origin in [
        None,
        Some("http://evil.example"),
        Some("null"),
        Some("https://127.0.0.1"),
        Some("http://localhost:1"),
    ] {
        let refused = lab.socket(origin).err();
        println!("socket from {origin:?}: {refused:?}");
        assert!(refused.is_some_and(|why| why.contains("403")), "{origin:?}");
    }
    assert!(lab.socket(Some(&own)).is_ok(), "its own page");
    let rebound = "Host: evil.example\r\nOrigin: http://evil.example\r\n";
    for (path, headers) in [
        ("/", rebound),
        ("/socket", rebound),
        ("/recordings/rec-001.csv", "Sec-Fetch-Site: cross-site\r\n"),
        ("/recordings/rec-001.csv", "Origin: http://evil.example\r\n"),
        ("/reports/x.html", "Sec-Fetch-Site: same-site\r\n"),
        ("/assets/main.js", "Sec-Fetch-Site: cross-site\r\n"),
    ] {
        let answer = lab.get(path, headers);
        println!("GET {path} {headers:?}: {}", answer.lines().next().unwrap_or_default());
        assert!(answer.starts_with("HTTP/1.1 403"), "{answer}");
    }
    for path in
        ["/recordings/..%2f..%2fCargo.toml", "/reports/%2e%2e%2fx.html", "/recordings/%00.csv", "/nothing"]
    {
        let answer = lab.get(path, "");
        assert!(answer.starts_with("HTTP/1.1 40"), "{path}: {answer}");
    }
    let page = lab.get("/", "");
    assert!(page.starts_with("HTTP/1.1 200") && page.contains("frame-ancestors 'none'"));
    assert!(!page.to_ascii_lowercase().contains("access-control-allow"), "nothing is shared");
}

pub fn beyond_loopback_nobody_comes_in_without_the_token() {
    let folder = tempfile::tempdir().expect("a folder");
    let lab = Lab::start(&folder.path().join("lab"), &["sim", "--bind", "0.0.0.0"]);
    let token = lab.url.split("token=").nth(1).expect("a token is made up").to_owned();
    assert!(token.len() >= 32);
    for path in ["/", "/assets/main.js", "/recordings/rec-001.csv", "/?token=0123456789abcdef"] {
        assert!(lab.get(path, "").starts_with("HTTP/1.1 403"), "{path}");
    }
    assert!(lab.socket(Some(&format!("http://{}", lab.host()))).is_err());
    let opened = lab.get(&format!("/?token={token}"), "");
    assert!(opened.contains("HttpOnly; SameSite=Strict"), "{opened}");
    assert!(lab.get("/", &format!("Cookie: tribos_lab={token}\r\n")).starts_with("HTTP/1.1 200"));
    let token = "--token=short";
    let refused = std::process::Command::new(env!("CARGO_BIN_EXE_tribos"))
        .args(["lab", "sim", token])
        .output()
        .expect("tribos runs");
    assert_eq!(refused.status.code(), Some(2));
}

/// Files beside the lab's folder, with names that the lab serves, are neither sent nor analysed.
pub fn no_path_leads_out_of_the_folder() {
    const SECRET: &str = "not for the page";
    let folder = tempfile::tempdir().expect("a folder");
    let inside = folder.path().join("lab");
    std::fs::create_dir(&inside).expect("the lab's folder");
    let rows = |what: &str| format!("# note: {what}\ntime_s,position_m,force_n\n0,0,1\n0.001,0,1\n");
    for name in ["rec-900.csv", "rec-900.html", "rec-900.jsonl", "lab.csv"] {
        std::fs::write(folder.path().join(name), rows(SECRET)).expect("a file outside");
    }
    std::fs::write(inside.join("rec-001.csv"), rows("for the page")).expect("a file inside");
    let lab = lab(&folder);
    let served = lab.get("/recordings/rec-001.csv", "");
    assert!(served.starts_with("HTTP/1.1 200") && served.contains("for the page"), "{served}");
    let outside = folder.path().join("rec-900").display().to_string();
    let mut tried = 0;
    for kind in ["recordings", "reports", "assets"] {
        for ending in ["csv", "html", "jsonl", "mcap"] {
            for way in [
                "../rec-900",
                "../../rec-900",
                "..%2frec-900",
                "..%2Frec-900",
                "%2e%2e/rec-900",
                "%2e%2e%2frec-900",
                "..%252frec-900",
                "..%5crec-900",
                "..\\rec-900",
                "rec-001.csv/../../rec-900",
                "..%00/rec-900",
                &outside,
                &outside.replace('/', "%2f"),
                &format!("/{outside}"),
            ] {
                let answer = lab.get(&format!("/{kind}/{way}.{ending}"), "");
                tried += 1;
                assert!(answer.starts_with("HTTP/1.1 40"), "{kind}/{way}.{ending}: {answer}");
                assert!(!answer.contains(SECRET), "{kind}/{way}.{ending} is sent");
            }
        }
    }
    let mut socket = own_socket(&lab);
    wait_for(&mut socket, "the device", |m| m["is"] == "state" && m["connected"] == true);
    for name in
        ["../rec-900.csv", "..\\rec-900.csv", &format!("{outside}.csv"), "rec-001.csv/../../rec-900.csv"]
    {
        for (what, message) in [
            ("identify", json!({ "do": "identify", "recordings": [name] })),
            ("diagnose", json!({ "do": "diagnose", "recordings": [name] })),
            ("analyse", json!({ "do": "analyse", "sessions": [name] })),
            ("resume", json!({ "do": "resume", "name": name.replace(".csv", ".jsonl") })),
        ] {
            ask(&mut socket, &message);
            let said = wait_for(&mut socket, "a refusal", |m| m["is"] == "said" && m["tone"] == "refused");
            let why = said["text"].as_str().unwrap_or_default();
            assert!(
                why.starts_with("no recording or session `") || why.starts_with("no session `"),
                "{what} {name}: {said}"
            );
            tried += 1;
        }
    }
    println!("{tried} ways out of the folder, all refused");
    let beside = std::fs::read_dir(folder.path()).expect("the folder").count();
    assert_eq!(beside, 5, "nothing was written beside the lab's folder");
}

/// A page that floods the lab is refused, and `stop` still works.
pub fn a_flood_of_requests_is_refused_and_stop_is_not() {
    let folder = tempfile::tempdir().expect("a folder");
    let lab = lab(&folder);
    let mut socket = own_socket(&lab);
    wait_for(&mut socket, "the device", |m| m["is"] == "state" && m["connected"] == true);
    ask(&mut socket, &json!({ "do": "arm" }));
    wait_for(&mut socket, "force", |m| m["is"] == "state" && m["armed"] == true);
    let began = Instant::now();
    for k in 0..5_000 {
        let at = 1e-6 * f64::from(k % 100);
        socket.write(Message::text(json!({ "do": "hand", "at": at }).to_string())).expect("the lab hears");
    }
    ask(&mut socket, &json!({ "do": "stop" }));
    ask(&mut socket, &json!({ "do": "ping", "id": 1 }));
    let (mut refused, mut refusals_of_stop) = (0, 0);
    wait_for(&mut socket, "the lab answers", |m| {
        let flood = m["text"].as_str().is_some_and(|why| why.starts_with("too many requests"));
        refused += u32::from(flood);
        refusals_of_stop += u32::from(m["tone"] == "refused" && !flood);
        m["is"] == "pong"
    });
    let took = began.elapsed().as_secs_f64();
    println!("{refused} of 5000 requests in {took:.2} s are refused");
    // those of a second and of the time that the flood took are accepted
    assert!(f64::from(refused) >= 5_000.0 - 500.0 * (took + 1.0) - 1.0, "{refused} in {took} s");
    assert!(refused > 1_000, "the flood was too slow to be one: {refused} in {took} s");
    assert_eq!(refusals_of_stop, 0);
    wait_for(&mut socket, "a device without force", |m| m["is"] == "state" && m["armed"] == false);
}

/// What a page may send, broken in every way one can think of.
fn malformed(rng: &mut ChaCha8Rng) -> Message {
    const GOOD: &[&str] = &[
        r#"{"do":"arm"}"#,
        r#"{"do":"propose","id":7,"changes":[["k_vc","9000"]]}"#,
        r#"{"do":"set","changes":[["f_static","2.5"],["mass","0.4"]]}"#,
        r#"{"do":"move","wave":"sine","amplitude":0.01,"frequency":2,"seconds":3,"record":true}"#,
        r#"{"do":"hand","at":0.004}"#,
        r#"{"do":"begin_choice","subject":"x","seed":1,"batches":"thesis"}"#,
        r#"{"do":"answer","answer":"A"}"#,
        r#"{"do":"identify","recordings":["../../etc/passwd"]}"#,
        r#"{"do":"resume","name":"..%2f.jsonl"}"#,
        r#"{"do":"save","name":"a\nstop"}"#,
    ];
    const ODD: &[&str] = &[
        "1e999",
        "-0",
        "NaN",
        "null",
        "[]",
        "{}",
        "\"\"",
        "\\u0000",
        "\\ud800",
        "18446744073709551616",
        "\u{feff}",
        "[[[[[[[[[[[[[[[[",
        "\n",
        "stop",
        "true",
        "é",
    ];
    let mut bytes = GOOD[rng.random_range(0..GOOD.len())].as_bytes().to_vec();
    for _ in 0..rng.random_range(1..6) {
        let at = rng.random_range(0..=bytes.len());
        match rng.random_range(0..6) {
            0 if at < bytes.len() => bytes[at] = rng.random(),
            1 => bytes.truncate(at),
            2 => {
                let end = rng.random_range(at..=bytes.len());
                bytes.drain(at..end);
            }
            3 => {
                let odd = ODD[rng.random_range(0..ODD.len())];
                bytes.splice(at..at, odd.bytes());
            }
            4 => {
                let piece = bytes[at..].to_vec();
                bytes.extend(piece);
            }
            _ => bytes.splice(at..at, (0..rng.random_range(0..40)).map(|_| b'[')).for_each(drop),
        }
        bytes.truncate(2_000);
    }
    if rng.random_bool(0.1) {
        return Message::binary(bytes);
    }
    Message::text(String::from_utf8_lossy(&bytes).into_owned())
}

pub fn ten_thousand_malformed_messages_crash_nothing() {
    malformed_messages_crash_nothing(50);
}

pub fn a_hundred_thousand_malformed_messages_crash_nothing() {
    malformed_messages_crash_nothing(500);
}

fn malformed_messages_crash_nothing(rounds: u32) {
    let folder = tempfile::tempdir().expect("a folder");
    let mut lab = lab(&folder);
    let mut rng = ChaCha8Rng::seed_from_u64(20261121);
    let (mut texts, mut binaries, mut refused) = (0, 0, 0);
    let began = Instant::now();
    let mut socket = own_socket(&lab);
    for round in 0..rounds {
        for _ in 0..200 {
            let message = malformed(&mut rng);
            if message.is_text() {
                texts += 1
            } else {
                binaries += 1
            }
            socket.write(message).expect("the lab hears");
        }
        socket.flush().expect("the lab hears");
        // answers come in order: with this one, all before it were read
        ask(&mut socket, &json!({ "do": "ping", "id": round }));
        wait_for(&mut socket, "the lab answers", |m| {
            refused += u32::from(m["tone"] == "refused");
            m["is"] == "pong" && m["id"].as_f64() == Some(f64::from(round))
        });
    }
    let took = began.elapsed().as_secs_f64();
    println!("{texts} texts and {binaries} binaries in {took:.1} s: {refused} refusals, no crash");
    assert!(texts + binaries == 200 * rounds && refused > texts / 2);
    // one too long, one that is no frame at all
    let mut socket = own_socket(&lab);
    let _ = socket.send(Message::text("x".repeat(1 << 20)));
    drop(socket);
    assert!(lab.child.try_wait().expect("a process").is_none(), "the lab runs on");
    let mut socket = own_socket(&lab);
    ask(&mut socket, &json!({ "do": "leave" }));
    ask(&mut socket, &json!({ "do": "stop" }));
    wait_for(&mut socket, "a device without force", |m| m["is"] == "state" && m["mode"] == "idle");
    let before = std::fs::read_dir(folder.path()).expect("the folder").count();
    assert_eq!(before, 1, "nothing was written outside the lab's folder");
}

/// A web site of somebody else, on this machine: answers every request with an empty page.
fn somebody_elses_site() -> String {
    use std::io::{Read, Write};
    let listener = std::net::TcpListener::bind("127.0.0.1:0").expect("a port");
    let address = format!("http://{}/", listener.local_addr().expect("its address"));
    std::thread::spawn(move || {
        for mut stream in listener.incoming().map_while(Result::ok) {
            let mut request = [0; 2048];
            let _ = stream.read(&mut request);
            let page =
                "HTTP/1.1 200 OK\r\nContent-Type: text/html\r\nConnection: close\r\n\r\n<title>evil</title>";
            let _ = stream.write_all(page.as_bytes());
        }
    });
    address
}

pub fn a_malicious_page_in_a_real_browser_gets_nothing() {
    let chromium = chromium();
    let folder = tempfile::tempdir().expect("a folder");
    let lab = lab(&folder);
    let mut page = Page::open(&chromium, &somebody_elses_site(), (800, 600));
    page.until("the evil page", "document.title === 'evil'", 10);
    let got = page.eval(&format!(
        "(async () => {{ const lab = 'http://{0}'; const out = {{}}; \
          out.socket = await new Promise((r) => {{ const s = new WebSocket('ws://{0}/socket'); s.onopen = () => {{ s.send('{{\"do\":\"arm\"}}'); r('open'); }}; s.onerror = () => r('refused'); }}); \
          for (const mode of ['cors', 'no-cors']) out[mode] = await fetch(lab + '/assets/main.js', {{ mode }}).then(async (a) => (await a.text()).length, () => 'refused'); \
          out.script = await new Promise((r) => {{ const s = document.createElement('script'); s.src = lab + '/assets/uPlot.js'; s.onload = () => r(typeof uPlot); s.onerror = () => r('refused'); document.head.append(s); }}); \
          out.frame = await new Promise((r) => {{ const f = document.createElement('iframe'); f.src = lab + '/'; f.onload = () => {{ try {{ r(f.contentDocument ? 'readable' : 'closed'); }} catch {{ r('closed'); }} }}; document.body.append(f); }}); \
          return out; }})()",
        lab.host()
    ));
    println!("what another origin gets: {got}");
    assert_eq!(got["socket"], json!("refused"));
    assert_eq!(got["cors"], json!("refused"));
    assert!(got["no-cors"] == json!("refused") || got["no-cors"] == json!(0), "{got}");
    assert_eq!(got["script"], json!("refused"));
    assert_eq!(got["frame"], json!("closed"));
    let mut socket = own_socket(&lab);
    let state = wait_for(&mut socket, "the state", |m| m["is"] == "state" && m["connected"] == true);
    assert_eq!((&state["armed"], &state["mode"]), (&json!(false), &json!("idle")), "nothing was commanded");
}

pub fn batches_of_ones_own_are_presented_and_what_the_device_would_refuse_is_refused_before_the_first_trial()
{
    let folder = tempfile::tempdir().expect("a folder");
    let lab = lab(&folder);
    let mut socket = own_socket(&lab);
    wait_for(&mut socket, "the device", |m| {
        m["is"] == "state" && m["connected"] == true && m["period"] == 0.001
    });
    let batches = |k_vc: u32| {
        let block = |level: f64| {
            format!(
                "{{ f_static = {level}, f_dynamic = {level}, damping = 5, dv = 0.01, mass = 0.5, k_vc = {k_vc}, b_vc = 15 }}"
            )
        };
        format!(
            "[[batch]]\nname = \"mine\"\nreference = {}\n[batch.procedure]\nprocedure = \"constant\"\nrounds = 3\ncomparisons = [{}, {}]\n",
            block(1.0),
            block(1.5),
            block(2.0)
        )
    };
    for (text, says) in
        [(batches(900_000), "batch `mine`: k_vc = 900000"), ("[[batch]]\nname = 3".into(), "name")]
    {
        ask(&mut socket, &json!({ "do": "begin_choice", "subject": "s1", "seed": 1, "batches": text }));
        let said = wait_for(&mut socket, "a refusal", |m| m["is"] == "said" && m["about"] == "experiment");
        println!("{}", said["text"]);
        assert!(said["text"].as_str().is_some_and(|why| why.contains(says)), "{said}");
    }
    ask(&mut socket, &json!({ "do": "begin_choice", "subject": "s1", "seed": 1, "batches": batches(9_000) }));
    let state = wait_for(&mut socket, "the session", |m| m["is"] == "state" && m["experiment"].is_object());
    assert_eq!((&state["experiment"]["of"], &state["experiment"]["armed"]), (&json!(6), &json!(false)));
    // while it is open nobody changes what is felt
    ask(&mut socket, &json!({ "do": "use", "name": "teflon" }));
    wait_for(&mut socket, "a refusal", |m| m["is"] == "said" && m["tone"] == "refused");
}
