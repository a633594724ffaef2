//! The commands of the book's first hour with a board, against a virtual device on a port.

use crate::cable::Cable;
use client::Session;
use haptics::ModeId;
use std::path::Path;
use std::process::Command;
use std::sync::atomic::Ordering;
use std::thread;
use std::time::{Duration, Instant};

/// Port of the book.
const PORT: &str = "/dev/ttyACM0";

/// The command lines of the blocks that speak of the port, in their order.
fn commands(book: &str) -> Vec<&str> {
    let blocks = book.split("```text\n").skip(1).filter_map(|rest| rest.split("```").next());
    blocks.filter(|block| block.contains(PORT)).flat_map(str::lines).collect()
}

/// What a person does with block and handle before a command.
fn by_hand(port: &str, command: &str) {
    let lines: &[&str] = if command.contains("--preset") {
        &["sim block none", "sim hand sine 0.008 1"]
    } else {
        &["sim block rubber"]
    };
    let mut session = Session::open(port, 1).expect("the port");
    for line in lines {
        session.command(line).expect(line);
    }
}

#[test]
fn every_command_of_the_first_hour_with_a_board_runs() {
    let cable = Cable::plug();
    let folder = tempfile::tempdir().expect("a folder");
    let book = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/book/board.md");
    let book = std::fs::read_to_string(book).expect("the book");
    let lines = commands(&book);
    assert!(lines.len() > 8, "{lines:?}");
    for line in lines {
        if line.contains("record") {
            by_hand(&cable.name, line);
        }
        // a device on a port runs in real time
        let line = line.replace(PORT, &cable.name).replace("--seconds 20", "--seconds 8");
        let words = shlex::split(&line).expect("closed quotes");
        assert_eq!(words[0], "tribos", "{line}");
        let mut command = Command::new(env!("CARGO_BIN_EXE_tribos"));
        let output = command.args(&words[1..]).current_dir(&folder).output().expect("tribos");
        let said = [output.stdout, output.stderr].map(|text| String::from_utf8_lossy(&text).into_owned());
        println!("$ {line}\n{}{}", said[0], said[1]);
        assert!(output.status.success(), "{line}: {:?}", output.status);
        // no command leaves a force on the handle
        let ended = Instant::now();
        while cable.now.0.load(Ordering::SeqCst) != ModeId::Idle.code() {
            assert!(ended.elapsed() < Duration::from_secs(10), "{line}: not idle");
            thread::sleep(Duration::from_millis(2));
        }
    }
}
