//! `emulator run`: the host command with the real firmware.

#[macro_use]
extern crate untested;

use emulator::firmware;
use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitCode, Stdio};
use tribos::Cli;
use untested::Need;

struct Running(Child);

impl Drop for Running {
    fn drop(&mut self) {
        // already ended if all went well
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

fn tribos(words: &[&str]) {
    let cli = <Cli as clap::Parser>::try_parse_from([&["tribos"], words].concat()).expect("as documented");
    tribos::run(&cli).unwrap_or_else(|failure| panic!("{words:?}: {}", failure.message()));
}

static TOOLCHAIN: Need = Need::new(|| firmware::missing(&root()));

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../..")
}

fn main() -> ExitCode {
    untested::run!(tests![tribos_identifies_the_real_firmware].needing(&TOOLCHAIN))
}

fn tribos_identifies_the_real_firmware() {
    let target = Path::new(env!("CARGO_BIN_EXE_emulator")).ancestors().nth(2).expect("cargo's layout");
    let elf = firmware::build(&root(), target).unwrap_or_else(|why| panic!("{why}"));
    let mut child = Command::new(env!("CARGO_BIN_EXE_emulator"));
    child.arg("run").arg(elf).args(["--block", "rubber", "--seed", "3"]);
    let mut board = Running(child.stdin(Stdio::null()).stdout(Stdio::piped()).spawn().expect("it was built"));
    let mut said = BufReader::new(board.0.stdout.take().expect("piped"));
    let mut line = String::new();
    let port = loop {
        line.clear();
        assert!(said.read_line(&mut line).expect("text") > 0, "it ended before it named its serial line");
        if let Some(rest) = line.strip_prefix("serial line ") {
            break rest.split_whitespace().next().expect("a name").to_owned();
        }
    };
    // drain the output, so that the pipe never fills
    let rest = std::thread::spawn(move || {
        let mut text = String::new();
        said.read_to_string(&mut text).map(|_| text)
    });

    let dir = tempfile::tempdir().expect("a temporary directory");
    let file = |name: &str| dir.path().join(name).display().to_string();
    let (recording, json) = (file("rec.csv"), file("id.json"));
    // nobody is there to ask
    let quietly = <Cli as clap::Parser>::try_parse_from([
        "tribos",
        "record",
        &port,
        "--move",
        "sine 0.01 2 2",
        "--out",
        &recording,
    ]);
    let refused = tribos::run(&quietly.expect("as documented")).expect_err("it must not move by itself");
    println!("{}", refused.message());
    assert!(
        refused.message().ends_with("the device does not know the middle of its stroke since it started")
    );
    tribos(&["record", &port, "--move", "sine 0.01 2 2", "--out", &recording, "--yes"]);
    let mut csv = csv::ReaderBuilder::new().comment(Some(b'#')).from_path(&recording).expect("written");
    let column = csv.headers().expect("a header").iter().position(|name| name == "time_s").expect("time_s");
    let times: Vec<f64> =
        csv.records().map(|r| r.expect("whole")[column].parse().expect("a number")).collect();
    let gaps = times.windows(2).filter(|t| (t[1] - t[0] - 1e-3).abs() > 1e-5).count();
    println!("{port}: {} samples over {:.3} s, {gaps} gaps", times.len(), times[times.len() - 1] - times[0]);
    assert!((1_990..=3_100).contains(&times.len()) && gaps == 0);

    tribos(&["identify", &recording, "--json", &json]);
    let found: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(&json).expect("written")).expect("JSON");
    let coulomb = found["parameters"]["coulomb_p"]["value"].as_f64().expect("a level");
    let truth = plant::materials::material("rubber").expect("table 3-3").law.c_p;
    println!("rubber: coulomb_p {coulomb:.3} N, rig {truth:.3} N");
    assert!((coulomb / truth - 1.0).abs() < 0.15);

    let interrupted =
        Command::new("kill").args(["-INT", &board.0.id().to_string()]).status().expect("a Unix");
    assert!(interrupted.success());
    let ended = board.0.wait().expect("a child");
    let text = rest.join().expect("no panic").expect("text");
    let last = text.lines().last().unwrap_or("");
    println!("{last}");
    assert!(ended.success(), "{ended}");
    assert!(last.contains(" 0 missed, 0 late; serial overruns 0"), "{text}");
}
