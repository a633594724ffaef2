//! `emulator run [ELF]`

use crate::pty::Pty;
use emulator::Machine;
use emulator::block::Block;
use link::{Decoder, Item};
use plant::{HandForce, HandImpedance, Target};
use std::io::{BufRead, IsTerminal};
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

/// Virtual time between two polls of the serial line, ms.
const SLICE_MS: f64 = 1.0;
/// Virtual time for the start of the firmware before its serial line is announced, ms.
const BOOT_MS: f64 = 50.0;
/// Longest time to catch up after the PC was busy. The rest is skipped.
const CATCH_UP: Duration = Duration::from_millis(250);

/// Options of `run`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Image to run; without one, the firmware of this workspace is built
    #[arg(value_name = "ELF")]
    elf: Option<PathBuf>,
    /// Block under the handle: none, brass, teflon or rubber
    #[arg(long, default_value = "none", value_name = "MATERIAL")]
    block: Block,
    /// Hand on the handle: off, hold, push NEWTON, sine METRE HERTZ
    #[arg(long, num_args = 1..=3, default_value = "off", value_name = "HAND", allow_negative_numbers = true)]
    hand: Vec<String>,
    /// Seed of all noise
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Virtual time per real time, or `max`
    #[arg(long, default_value = "1", value_parser = speed)]
    speed: f64,
    /// End after this virtual time, s
    #[arg(long)]
    seconds: Option<f64>,
}

/// Speed from text. Infinity is as fast as possible.
fn speed(text: &str) -> Result<f64, String> {
    if text == "max" {
        return Ok(f64::INFINITY);
    }
    text.parse()
        .ok()
        .filter(|factor| (0.001..=1000.0).contains(factor))
        .ok_or_else(|| format!("`{text}`: expected 0.001 to 1000, or max"))
}

fn set_hand(machine: &mut Machine, words: &[String]) -> Result<(), String> {
    let joined = words.join(" ");
    let words: Vec<_> = joined.split_whitespace().collect();
    let refused = || {
        format!(
            "--hand {joined}: expected off, hold, push NEWTON (at most 50) or sine METRE HERTZ (at most 0.05, 20)"
        )
    };
    let number = |text: &str, most: f64| {
        text.parse::<f64>().ok().filter(|value| value.abs() <= most).ok_or_else(refused)
    };
    match words[..] {
        ["off"] => {}
        ["hold"] => machine.set_hand(HandImpedance::relaxed(Target::Hold { position: 0.0 })),
        ["push", force] => {
            let force = number(force, 50.0)?;
            machine.set_hand(HandForce::PushRelease { force, from: 0.0, until: f64::INFINITY });
        }
        ["sine", amplitude, frequency] => {
            let (amplitude, frequency) = (number(amplitude, 0.05)?, number(frequency, 20.0)?);
            let target = Target::Sine { centre: 0.0, amplitude, frequency };
            let hand = HandImpedance { stiffness: 1_500.0, damping: 15.0, ..HandImpedance::relaxed(target) };
            machine.set_hand(hand);
        }
        _ => return Err(refused()),
    }
    Ok(())
}

/// Runs until Ctrl-C.
///
/// # Errors
/// One line with the reason.
pub fn run(args: &Args) -> Result<ExitCode, String> {
    if args.seconds.is_some_and(|s| !(s > 0.0)) {
        return Err(format!("--seconds {}: expected more than 0", args.seconds.unwrap_or(0.0)));
    }
    let image = super::image(args.elf.as_deref())?;
    let mut machine = args.block.under(&image, args.seed);
    set_hand(&mut machine, &args.hand)?;
    let mut pty = Pty::open().map_err(|why| format!("no pseudo-terminal: {why}"))?;
    let stop = Arc::new(AtomicBool::new(false));
    let pressed = Arc::clone(&stop);
    ctrlc::set_handler(move || pressed.store(true, Relaxed)).map_err(|e| e.to_string())?;

    // the board already listens when its line is announced, like one that is plugged in
    machine.run_for(BOOT_MS);

    println!("the firmware, {} B, on an emulated NUCLEO-G474RE", image.flash_bytes);
    println!("serial line {}   (cargo tribos connect {})", pty.name(), pty.name());
    if std::io::stdin().is_terminal() {
        println!("commands are taken here, too; Ctrl-C ends");
    }
    let typed = commands();
    let mut decoder = Decoder::new();
    let (mut resets, mut due) = (0, Instant::now());
    let end = args.seconds.map_or(f64::INFINITY, |s| 1000.0 * s);
    while !stop.load(Relaxed) && machine.milliseconds() < end {
        while let Some(bytes) = pty.received() {
            machine.serial_write(&bytes);
        }
        while let Ok(line) = typed.try_recv() {
            machine.serial_write(&line);
        }
        machine.run_for(SLICE_MS);
        let said = machine.serial_read();
        pty.send(&said);
        for byte in said {
            if let Some(Item::Text(line)) = decoder.push(byte) {
                println!("{line}");
            }
        }
        for (at, cause) in machine.resets().iter().skip(resets) {
            println!("[{at:.3} ms] reset: {cause:?}");
        }
        resets = machine.resets().len();
        due = wait(due, args.speed);
    }
    summary(&machine);
    Ok(ExitCode::SUCCESS)
}

/// Lines typed on standard input. The board continues after its end.
fn commands() -> Receiver<Vec<u8>> {
    let (typed, commands) = channel();
    std::thread::spawn(move || {
        let mut input = std::io::stdin().lock();
        let mut line = Vec::new();
        while input.read_until(b'\n', &mut line).is_ok_and(|count| count > 0) {
            if typed.send(std::mem::take(&mut line)).is_err() {
                return;
            }
        }
    });
    commands
}

/// Waits until the real time of the last slice has passed. Returns the time of the next slice.
fn wait(due: Instant, speed: f64) -> Instant {
    let now = Instant::now();
    if speed.is_infinite() {
        return now;
    }
    let next = due + Duration::from_secs_f64(SLICE_MS / 1000.0 / speed);
    if let Some(early) = next.checked_duration_since(now) {
        std::thread::sleep(early);
        next
    } else if now - next > CATCH_UP {
        now - CATCH_UP
    } else {
        next
    }
}

fn summary(machine: &Machine) {
    let s = machine.statistics();
    println!(
        "{:.3} virtual s: {} control steps, {} missed, {} late; serial overruns {}; core awake {:.1} %",
        machine.milliseconds() / 1000.0,
        s.steps,
        s.missed,
        s.stale_outputs,
        machine.serial_overruns(),
        100.0 * s.load()
    );
    for violation in machine.violations() {
        println!("against the data sheet: {violation}");
    }
    if machine.locked_up() {
        println!("the core has locked up: {}", machine.whereabouts());
    }
}
