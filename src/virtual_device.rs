//! The virtual device on a PC: the firmware application on the simulated rig in real time, with its console on standard input
//! and on a pseudo-terminal.

mod plain;
mod pty;
mod screen;

use haptics::ModeId;
use link::{Decoder, Item};
use pty::Pty;
use std::io::IsTerminal;
use std::path::Path;
use std::process::ExitCode;
use std::time::{Duration, Instant};
use tribos_firmware::board::simulated::flash::SimulatedFlash;
use tribos_firmware::{VirtualConfig, VirtualDevice};

const USAGE: &str = "\
The tribos firmware on a simulated rig: commands on standard input, and on a pseudo-terminal for `tribos`.

    cargo run --release                 at a terminal: live, with a simulated hand on the handle
    cargo run --release < commands      answers each command, ends with the input
    cargo run --release -- --presets FILE   keeps the saved presets in this file

`help` lists the commands of the device. `cargo tribos demo` tells the whole story.";

/// Longest continuation of a motion, s.
const FINISH_S: f64 = 120.0;
/// Longest time to catch up after the PC was busy. The rest is skipped.
const CATCH_UP: Duration = Duration::from_millis(250);

pub fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let flash = match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        [] => Ok(SimulatedFlash::default()),
        ["-h" | "--help"] => {
            println!("{USAGE}");
            return ExitCode::SUCCESS;
        }
        ["--presets", file] => SimulatedFlash::open(Path::new(file)).map_err(|e| format!("{file}: {e}")),
        ["--presets"] => Err("--presets: missing file name".to_owned()),
        [other, ..] => Err(format!("`{other}`: expected no argument, --presets FILE, or --help")),
    };
    let device = flash.and_then(|flash| {
        VirtualDevice::with_flash(&VirtualConfig::default(), flash).map_err(|unfit| unfit.to_string())
    });
    let device = match device {
        Ok(device) => device,
        Err(why) => {
            eprintln!("{why}");
            return ExitCode::from(2);
        }
    };
    let pty = Pty::open();
    let serial_line = match &pty {
        Ok(pty) => format!("serial line {}   (cargo tribos connect {})", pty.name(), pty.name()),
        Err(why) => format!("no serial line: {why}"),
    };
    let running = Running::new(device, pty.ok());
    let ended = if std::io::stdin().is_terminal() && std::io::stdout().is_terminal() {
        screen::run(running, &serial_line)
    } else {
        plain::run(running, &serial_line)
    };
    match ended {
        // the reader has gone away, which is no error
        Err(e) if e.kind() == std::io::ErrorKind::BrokenPipe => ExitCode::SUCCESS,
        Err(e) => {
            eprintln!("the console is gone: {e}");
            ExitCode::FAILURE
        }
        Ok(()) => ExitCode::SUCCESS,
    }
}

/// The device in real time, and its serial line.
struct Running {
    device: VirtualDevice,
    pty: Option<Pty>,
    decoder: Decoder,
    bytes: Vec<u8>,
    lines: Vec<String>,
    period: Duration,
    /// Time of the next control period.
    due: Instant,
}

impl Running {
    fn new(device: VirtualDevice, pty: Option<Pty>) -> Self {
        let period = Duration::from_secs_f64(device.period());
        let (decoder, bytes, lines) = (Decoder::new(), Vec::new(), Vec::new());
        Self { device, pty, decoder, bytes, lines, period, due: Instant::now() }
    }

    /// Advances the device to the present time. Returns its lines.
    fn live(&mut self) -> Vec<String> {
        let now = Instant::now();
        if now.saturating_duration_since(self.due) > CATCH_UP {
            self.due = now - CATCH_UP;
        }
        if let Some(pty) = &self.pty {
            while let Some(bytes) = pty.received() {
                self.device.write(&bytes);
            }
        }
        while self.due <= now {
            self.tick();
            self.due += self.period;
        }
        self.carry();
        std::mem::take(&mut self.lines)
    }

    /// Executes a command as fast as possible. Returns the lines until the device is quiet.
    fn obey(&mut self, line: &[u8]) -> Vec<String> {
        self.device.write(line);
        if !line.ends_with(b"\n") {
            self.device.write(b"\n");
        }
        // a self-test takes half a second, the longest of all commands
        for _ in 0..5_000 {
            self.tick();
            self.carry();
            if self.device.is_quiet() {
                break;
            }
        }
        std::mem::take(&mut self.lines)
    }

    /// Advances as fast as possible until a motion ends. Returns the lines of this time.
    fn finish(&mut self, is_running: impl Fn(ModeId) -> bool) -> Vec<String> {
        let mut left = 0..(FINISH_S / self.period.as_secs_f64()) as u64;
        while (is_running(self.device.mode()) || !self.device.is_quiet()) && left.next().is_some() {
            self.tick();
        }
        self.carry();
        std::mem::take(&mut self.lines)
    }

    fn tick(&mut self) {
        self.device.tick();
        self.device.read(&mut self.bytes);
    }

    /// Sends bytes to the pseudo-terminal and lines to the console.
    fn carry(&mut self) {
        if let Some(pty) = &mut self.pty {
            pty.send(&self.bytes);
        }
        for byte in self.bytes.drain(..) {
            if let Some(Item::Text(line)) = self.decoder.push(byte) {
                self.lines.push(line.to_owned());
            }
        }
    }
}
