//! `emulator record`: a run that another emulator repeats (`.ci/witness`).

use emulator::Machine;
use friction::effects::EffectKind;
use std::path::PathBuf;
use std::process::ExitCode;

/// Options of `record`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Image to run; without one, the firmware of this workspace is built
    #[arg(value_name = "ELF")]
    elf: Option<PathBuf>,
    /// Folder for flash.bin, system.bin and run.bin
    #[arg(long, value_name = "FOLDER")]
    out: PathBuf,
}

const LAWS: [&str; 4] = ["karnopp", "dahl", "coulomb", "lugre"];
const RENDERERS: [&str; 3] = ["virtual_coupling", "impedance", "stopping_force"];

/// A terminal at the machine, and what was refused.
struct Terminal {
    machine: Machine,
    said: String,
    refused: usize,
}

impl Terminal {
    fn say(&mut self, line: &str, ms: f64) {
        self.machine.serial_write(format!("{line}\n").as_bytes());
        self.machine.run_for(ms);
        let said = String::from_utf8_lossy(&self.machine.serial_read()).into_owned();
        if said.starts_with("err") {
            println!("{line}: {}", said.trim_end());
            self.refused += 1;
        }
        self.said += &said;
    }

    fn render(&mut self, ms: f64) {
        self.say("render on", ms);
        self.say("render off", 5.0);
    }
}

/// Boots, searches the stops, renders every law by every renderer and every effect under a moving hand, streams, drives and
/// identifies, saves a preset, and ends in an emergency stop.
///
/// # Errors
/// One line with the reason.
pub fn run(args: &Args) -> Result<ExitCode, String> {
    let image = super::image(args.elf.as_deref())?;
    let mut machine = Machine::free_handle(&image, 1);
    machine.record();
    machine.run_for(50.0);
    let mut at = Terminal { machine, said: String::new(), refused: 0 };
    at.say("home", 6_000.0);
    at.say("move multisine 0.01 1 1", 2_500.0);
    at.say("selftest", 4_000.0);
    at.machine.set_hand(|t: f64, _: f64, v: f64| 6.0 * (12.0 * t).sin() - 5.0 * v);
    at.say("preset use rubber", 5.0);
    for set in ["f_static 3.5", "f_dynamic 3", "damping 4", "sigma 8000", "dv 0.01"] {
        at.say(&format!("set {set}"), 5.0);
    }
    for law in LAWS {
        at.say(&format!("set law {law}"), 5.0);
        for renderer in RENDERERS {
            at.say(&format!("set renderer {renderer}"), 5.0);
            at.render(120.0);
        }
    }
    at.say("stream on", 5.0);
    at.say("set passivity on", 5.0);
    at.render(200.0);
    at.say("stream off", 5.0);
    let laws_refused = at.refused;
    for kind in EffectKind::ALL {
        at.say("preset use teflon", 5.0);
        for parameter in kind.gains() {
            at.say(&format!("set {}.{} 0.2", kind.id(), parameter.name), 5.0);
        }
        at.render(60.0);
    }
    at.say("preset save mine", 300.0);
    at.say("render on", 50.0);
    at.machine.press_stop(true);
    at.say("status", 50.0);
    let write = |name: &str, bytes: &[u8]| {
        let path = args.out.join(name);
        std::fs::write(&path, bytes).map_err(|why| format!("{}: {why}", path.display()))
    };
    write("flash.bin", &image.flash_contents())?;
    write("system.bin", &emulator::system_memory())?;
    write("run.bin", &at.machine.recording())?;
    let ends = ["! home: ", "! the motion has ended", "mine saved", "! fault emergency_stop"];
    if let Some(missing) = ends.iter().find(|text| !at.said.contains(**text)) {
        return Err(format!("the run did not come to `{missing}`"));
    }
    let s = at.machine.statistics();
    println!(
        "{:.1} virtual s, {} control steps; {laws_refused} settings of laws and renderers and {} of effects refused",
        at.machine.milliseconds() / 1000.0,
        s.steps,
        at.refused - laws_refused,
    );
    Ok(ExitCode::SUCCESS)
}
