//! Console without a terminal: each input line is a command, each output line an answer.

use super::running::Running;
use haptics::ModeId;
use std::io::{BufRead, Write};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

/// Runs until the input ends.
///
/// # Errors
/// The output is gone.
pub fn run(mut running: Running, serial_line: &str) -> std::io::Result<()> {
    let mut out = std::io::stdout().lock();
    writeln!(out, "tribos {}: the firmware on a simulated rig", env!("CARGO_PKG_VERSION"))?;
    writeln!(out, "{serial_line}")?;
    out.flush()?;
    let (typed, commands) = channel();
    std::thread::spawn(move || {
        let mut input = std::io::stdin().lock();
        let mut line = Vec::new();
        // an unreadable input has ended
        while input.read_until(b'\n', &mut line).is_ok_and(|count| count > 0) {
            if typed.send(std::mem::take(&mut line)).is_err() {
                return;
            }
        }
    });
    loop {
        match commands.recv_timeout(Duration::from_millis(1)) {
            Ok(line) => {
                let mut said = running.obey(&line);
                // the next command may need its result
                said.extend(running.finish(|mode| mode == ModeId::Homing));
                if !line.trim_ascii().is_empty() {
                    writeln!(out, "> {}", String::from_utf8_lossy(&line).trim())?;
                }
                say(&mut out, &said)?;
            }
            Err(RecvTimeoutError::Timeout) => {
                let said = running.live();
                say(&mut out, &said)?;
            }
            Err(RecvTimeoutError::Disconnected) => break,
        }
    }
    // completes a running motion, so that its result is not lost
    let mut said = running.finish(ModeId::is_driven);
    said.extend(running.obey(b""));
    say(&mut out, &said)
}

fn say(out: &mut impl Write, lines: &[String]) -> std::io::Result<()> {
    for line in lines {
        writeln!(out, "{line}")?;
    }
    if lines.is_empty() { Ok(()) } else { out.flush() }
}
