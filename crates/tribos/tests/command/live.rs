//! `--live`: samples by UDP while the console and the lab go on.

use serde_json::Value;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::UdpSocket;
use std::process::{Command, Stdio};
use std::time::Duration;

const COLUMNS: [&str; 8] = [
    "timestamp",
    "time_s",
    "position_m",
    "velocity_m_s",
    "acceleration_m_s2",
    "force_n",
    "command_n",
    "reference_m",
];

fn listener() -> (UdpSocket, String) {
    let socket = UdpSocket::bind("127.0.0.1:0").expect("a socket");
    socket.set_read_timeout(Some(Duration::from_secs(30))).expect("a timeout");
    let address = socket.local_addr().expect("an address").to_string();
    (socket, address)
}

/// The next samples, on a grid of milliseconds; a listener that is slow may miss some.
fn samples(socket: &UdpSocket, count: usize) -> Vec<Value> {
    let mut bytes = [0; 2000];
    let got: Vec<Value> = (0..count)
        .map(|_| {
            let n = socket.recv(&mut bytes).expect("a datagram within 30 s");
            serde_json::from_slice(&bytes[..n]).expect("JSON")
        })
        .collect();
    let mut last = -1.0;
    for sample in &got {
        let object = sample.as_object().expect("an object");
        assert_eq!(object.len(), COLUMNS.len(), "{sample}");
        assert!(COLUMNS.iter().all(|name| sample[name].is_f64()), "{sample}");
        let milliseconds = 1e3 * sample["time_s"].as_f64().expect("a number");
        assert!(milliseconds > last && (milliseconds - milliseconds.round()).abs() < 0.05, "{sample}");
        last = milliseconds;
    }
    got
}

fn tally(text: &str) -> u64 {
    let line = text.lines().find(|line| line.contains("live 127.0.0.1:")).expect(text);
    assert!(line.ends_with(" 0 dropped"), "{line}");
    line.split_whitespace().nth(2).and_then(|sent| sent.parse().ok()).expect(line)
}

#[test]
fn the_console_answers_while_it_streams() {
    let (socket, address) = listener();
    let mut child = Command::new(env!("CARGO_BIN_EXE_tribos"))
        .args(["connect", "sim", "--live", &address])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("tribos");
    let mut keys = child.stdin.take().expect("stdin");
    let mut answers = BufReader::new(child.stdout.take().expect("stdout")).lines();
    let still = samples(&socket, 100);
    keys.write_all(b"sim hand sine 0.008 2\nset dv\n").expect("sent");
    let mut said = || answers.next().expect("a line").expect("text");
    let (first, second) = (said(), said());
    assert!(first.starts_with("ok") && second.starts_with("err "), "{first}\n{second}");
    let moved = samples(&socket, 1500);
    drop(keys);
    let mut told = String::new();
    child.stderr.take().expect("stderr").read_to_string(&mut told).expect("text");
    assert!(child.wait().expect("an end").success(), "{told}");
    let travel = |samples: &[Value]| {
        let x = samples.iter().filter_map(|s| s["position_m"].as_f64());
        x.clone().fold(f64::MIN, f64::max) - x.fold(f64::MAX, f64::min)
    };
    println!("{told}{} m, then {} m", travel(&still), travel(&moved));
    assert!(tally(&told) >= 1600);
    assert!(travel(&still) < 1e-4 && travel(&moved) > 4e-3);
}

#[cfg(target_os = "linux")]
#[test]
fn the_lab_streams_without_a_page() {
    let (socket, address) = listener();
    let folder = tempfile::tempdir().expect("a folder");
    let mut child = Command::new("env")
        .current_dir(folder.path())
        .args(["--default-signal=INT", env!("CARGO_BIN_EXE_tribos")])
        .args(["lab", "sim", "--http-port", "0", "--live", &address])
        .stdout(Stdio::piped())
        .spawn()
        .expect("tribos");
    let got = samples(&socket, 500);
    let interrupted = Command::new("kill").args(["-INT", &child.id().to_string()]).status().expect("kill");
    let mut told = String::new();
    child.stdout.take().expect("stdout").read_to_string(&mut told).expect("text");
    assert!(interrupted.success() && child.wait().expect("an end").success(), "{told}");
    println!("{told}{}", got[0]);
    assert!(tally(&told) >= 500);
}
