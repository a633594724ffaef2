//! The virtual device on a PC: the firmware application on the simulated rig in real time, with its console on standard input
//! and on a pseudo-terminal.

mod plain;
mod pty;
mod running;
mod screen;

use pty::Pty;
use running::Running;
use std::io::IsTerminal;
use std::path::Path;
use std::process::ExitCode;
use tribos_firmware::board::simulated::flash::SimulatedFlash;
use tribos_firmware::{VirtualConfig, VirtualDevice};

const USAGE: &str = "\
The tribos firmware on a simulated rig: commands on standard input, and on a pseudo-terminal for `tribos`.

    cargo run --release                 at a terminal: live, with a simulated hand on the handle
    cargo run --release < commands      answers each command, ends with the input
    cargo run --release -- --presets FILE   keeps the saved presets in this file

`help` lists the commands of the device. `cargo tribos demo` tells the whole story.";

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
