//! A wrong setting of the board is seen. One check of everything the registers decide, which the firmware passes; and
//! copies of the source tree with one line of the board changed, which must not.
//!
//! Each mutant is a build of its own (half a minute), so they run in a step of `.ci/run`:
//! `cargo test --test elf a_wrong_build -- --ignored --nocapture`, one of them with `TRIBOS_MUTANT` = a part of its name.

use crate::board::image;
use crate::no_panic::in_flash;
use crate::witness;
use emulator::{Image, Machine, firmware};
use haptics::Estimator;
use link::{Decoder, Frame, Item, Sample};
use std::path::{Path, PathBuf};

/// What the check sees that should not be; empty when all is well.
fn check(image: &Image) -> Vec<String> {
    let mut saw = Vec::new();
    let mut wants = |holds: bool, what: String| {
        if !holds {
            saw.push(what);
        }
    };
    let mut machine = Machine::free_handle(image, 1);
    witness::watch(&mut machine);
    machine.run_for(50.0);
    wants(machine.first_step_ms().is_some_and(|ms| ms < 100.0), "no control step within 50 ms".into());
    machine.serial_write(b"preset use viscous\nrender on\nstream on\n");
    machine.run_for(30.0);
    let _ = machine.serial_read();
    let at_rest = machine.force();
    wants(at_rest.abs() < 0.5, format!("at rest the amplifier is told {at_rest:.2} N"));
    for millivolt in [3_300, 3_200] {
        let load = load_under_5_newton(image, millivolt);
        wants((load - 5.0).abs() < 0.5, format!("5 N on the load cell are {load:.2} N at {millivolt} mV"));
    }
    let mut stopping = rendering(image);
    stopping.set_crystal(false);
    stopping.run_for(3.0);
    wants(!stopping.amplifier_on(), "enable line high 3 ms after the crystal stopped".into());
    // some 40 mm/s to and fro: 16 edges in a period
    machine.set_hand(|t: f64, _: f64, v: f64| 3.0 * (20.0 * t).sin() - 2.0 * v);
    machine.run_for(50.0);
    machine.reset_statistics();
    let mut decoder = Decoder::new();
    let (mut samples, mut forces, mut off) = (Vec::<Sample>::new(), Vec::new(), 0);
    for _ in 0..300 {
        // more than the line brings in a period: a byte is received in every phase of it
        machine.serial_write(
            b"status status status status status status status status status status status status status status\n",
        );
        for _ in 0..8 {
            machine.run_for(0.125);
            off += u32::from(!machine.amplifier_on());
        }
        forces.push((machine.force(), machine.truth()));
        for byte in machine.serial_read() {
            if let Some(Item::Frame(_, Frame::Sample(sample))) = decoder.push(byte) {
                samples.push(sample);
            }
        }
    }
    let s = machine.statistics();
    wants(
        // the window may begin within a period
        s.triggers.abs_diff(300) <= 1 && s.steps.abs_diff(300) <= 1,
        format!("{} conversions and {} steps in 300 periods", s.triggers, s.steps),
    );
    wants(
        s.missed + s.stale_outputs == 0,
        format!("{} samples missed, {} forces late", s.missed, s.stale_outputs),
    );
    wants(samples.len() > 250, format!("{} frames in 300 periods", samples.len()));
    wants(
        s.latency_us.max <= 20.0 && s.latency_us.spread() < 1.0,
        format!("force out {:.2} to {:.2} us after the sample", s.latency_us.min, s.latency_us.max),
    );
    wants(
        (s.output_period_us.mean() - 1000.0).abs() < 0.1,
        format!("a force every {:.2} us", s.output_period_us.mean()),
    );
    wants(off == 0, format!("enable line low at {off} of 2400 looks while rendering"));
    for violation in machine.violations() {
        wants(false, violation);
    }
    let last = |k: usize| samples.get(samples.len().wrapping_sub(k));
    let moved = samples.iter().map(|s| s.count.unsigned_abs()).max().unwrap_or(0);
    wants(moved > 100, format!("encoder: {moved} counts at most while the handle moved"));
    // edges come every 60 us or so but at the turns
    let fresh = samples.iter().filter(|s| s.edge_age < 170_000).count();
    wants(
        10 * fresh > 8 * samples.len(),
        format!("edge times: {fresh} of {} samples saw an edge of their period", samples.len()),
    );
    let largest = |f: &dyn Fn(&Sample) -> f64| samples.iter().map(f).fold(0.0, |a: f64, b| a.max(b.abs()));
    let (told, felt) =
        (largest(&|s| f64::from(s.force)), forces.iter().map(|(force, _)| force.abs()).fold(0.0, f64::max));
    wants(
        told > 0.3 && (felt / told - 1.0).abs() < 0.1,
        format!("the step commands {told:.2} N, the amplifier is told {felt:.2} N"),
    );
    // at rest the load cell and the accelerometer are at half of their 16 bits
    for (what, code) in
        [("load cell", last(1).map(|s| s.load_code)), ("accelerometer", last(1).map(|s| s.accel_code))]
    {
        let code = code.unwrap_or(0);
        wants((28_000..37_500).contains(&code), format!("{what}: code {code}"));
    }
    if let Ok(step) = image.reach("ADC1_2") {
        let slow = in_flash(&step, None);
        wants(slow.is_empty(), format!("in flash: {slow:?}"));
    } else {
        wants(false, "the control interrupt cannot be followed".into());
    }
    // what waits to be sent of the flood
    machine.run_for(50.0);
    // an edge at a constant pace, a cycle later in every other period
    if machine.run_to_control() {
        let off = velocity_error(&mut machine);
        wants(off < 1e-3, format!("velocity {:.1} % off by an edge during the sampling", 100.0 * off));
    }
    // the processor hangs: nothing but hardware can take the force away
    let mut hanging = rendering(image);
    if hanging.run_into_control() {
        hanging.hang();
        hanging.run_for(1.0);
        wants(!hanging.amplifier_on(), "enable line high 1 ms after the processor hung".into());
    } else {
        wants(false, "no control step to hang in".into());
    }
    saw
}

/// A machine that renders, its amplifier on.
fn rendering(image: &Image) -> Machine {
    let mut machine = Machine::free_handle(image, 1);
    machine.run_for(50.0);
    machine.serial_write(b"render on\n");
    machine.run_for(20.0);
    machine
}

/// What the device says of 5 N on its load cell, N.
fn load_under_5_newton(image: &Image, millivolt: u32) -> f64 {
    let mut machine = Machine::free_handle(image, 1);
    machine.set_supply(millivolt);
    machine.put_on_bench(plant::Bench { weight: 5.0, gravity: 0.0 }).expect("in range");
    machine.run_for(50.0);
    let _ = machine.serial_read();
    machine.serial_write(b"status\n");
    machine.run_for(10.0);
    let said = String::from_utf8_lossy(&machine.serial_read()).into_owned();
    let number = said.split(", load ").nth(1).and_then(|rest| rest.split(' ').next()).map(str::parse);
    number.and_then(Result::ok).unwrap_or(f64::NAN)
}

/// Largest relative error of the velocity while edges sweep over the sampling.
fn velocity_error(machine: &mut Machine) -> f64 {
    let interval = 2 * 170_000 + 1;
    let _ = machine.serial_read();
    machine.turn_encoder(interval - 30, interval, true);
    let (mut decoder, mut estimator) = (Decoder::new(), Estimator::default());
    let (mut first, mut worst) = (None, 0.0_f64);
    for _ in 0..50 {
        machine.run_for(8.0);
        for byte in machine.serial_read() {
            let Some(Item::Frame(_, Frame::Sample(s))) = decoder.push(byte) else { continue };
            estimator.sample(s.sample_ticks, s.count as u32, s.edge_ticks());
            // the first edges follow those of the rig
            if s.count - *first.get_or_insert(s.count) > 8 {
                worst = worst.max((estimator.counts_per_tick() * interval as f32 - 1.0).abs().into());
            }
        }
    }
    worst
}

pub fn the_correct_build_passes_the_mutation_check() {
    let saw = check(image());
    assert!(saw.is_empty(), "{saw:#?}");
}

/// Fails at once when a mutated line has moved; the step that builds the mutants takes minutes.
pub fn a_wrong_build_finds_the_line_it_changes() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    for mutant in &MUTANTS {
        mutant.found_in(&std::fs::read_to_string(root.join(mutant.file)).expect(mutant.file));
    }
}

struct Mutant {
    what: &'static str,
    file: &'static str,
    right: &'static str,
    wrong: &'static str,
    /// Part of what must be seen.
    shows: &'static str,
}

impl Mutant {
    /// Panics unless the right line is in the source exactly once.
    fn found_in(&self, source: &str) {
        assert_eq!(
            source.matches(self.right).count(),
            1,
            "{}: its line in {} has changed",
            self.what,
            self.file
        );
    }
}

const CHIP: &str = "src/board/nucleo_g474re.rs";
const SETUP: &str = "src/board/nucleo/setup.rs";
const BOARD: &str = "src/board/nucleo.rs";
const QUADRATURE: &str = "src/board/nucleo/quadrature.rs";
const ENABLE: &str = "src/board/nucleo/enable.rs";

const MUTANTS: [Mutant; 21] = [
    Mutant {
        what: "supply not measured: the converters at 3.3 V",
        file: BOARD,
        right: "        .at_supply(SUPPLY_MV.load(Relaxed) as f32 / 1_000.0)\n",
        wrong: "",
        shows: "at 3200 mV",
    },
    Mutant {
        what: "ADC trigger: TIM3 instead of TIM6",
        file: CHIP,
        right: "triggers::TIM6_TRGO,",
        wrong: "triggers::TIM3_TRGO,",
        shows: "no control step",
    },
    Mutant {
        what: "TIM5 trigger input: TIM3 instead of TIM2",
        file: CHIP,
        right: "set_ts(Ts::ITR1)",
        wrong: "set_ts(Ts::ITR2)",
        shows: "edge times",
    },
    Mutant {
        what: "priority of the control interrupt below the serial line's",
        file: BOARD,
        right: "ADC1_2.set_priority(Priority::P0)",
        wrong: "ADC1_2.set_priority(Priority::P8)",
        shows: "its priority is too low",
    },
    Mutant {
        what: "DAC alignment: left instead of right",
        file: BOARD,
        right: "pac::DAC1.dhr12r(0).write(|w| w.set_dhr(code));",
        wrong: "pac::DAC1.dhr12l(0).write(|w| w.0 = code.into());",
        shows: "the amplifier is told",
    },
    Mutant {
        what: "oversampling by 8 instead of 16",
        file: CHIP,
        right: "w.set_ovsr(3);",
        wrong: "w.set_ovsr(2);",
        shows: "load cell: code",
    },
    Mutant {
        what: "clock: no boost at 170 MHz",
        file: CHIP,
        right: "    boost();\n",
        wrong: "",
        shows: "without boost",
    },
    Mutant {
        what: "trigger output of TIM2: update instead of encoder clock",
        file: CHIP,
        right: "set_mms(Mms::ENCODER_CLOCK_OUTPUT)",
        wrong: "set_mms(Mms::UPDATE)",
        shows: "edge times",
    },
    Mutant {
        what: "the sample stamped after its edge is read",
        file: QUADRATURE,
        right: "    let sample = if edge.wrapping_sub(stamp) < SAMPLING_TICKS { edge } else { stamp };",
        wrong: "    let sample = stamp.max(tim5.cnt().read()).max(SAMPLING_TICKS);",
        shows: "edge during the sampling",
    },
    Mutant {
        what: "enable timer not rearmed",
        file: ENABLE,
        right: "    timer.cnt().write(|w| w.set_cnt(1));\n",
        wrong: "",
        shows: "enable line low",
    },
    Mutant {
        what: "enable timer without one-pulse mode",
        file: ENABLE,
        right: "            w.set_opm(true);\n",
        wrong: "",
        shows: "enable line high",
    },
    Mutant {
        what: "enable timer with a pulse of 2.75 periods",
        file: ENABLE,
        right: "const PULSE_QUARTERS: u32 = 7;",
        wrong: "const PULSE_QUARTERS: u32 = 11;",
        shows: "enable line high",
    },
    Mutant {
        what: "power interface without its clock",
        file: CHIP,
        right: "    pac::RCC.apb1enr1().modify(|w| w.set_pwren(true));\n",
        wrong: "",
        shows: "PWR used without its clock",
    },
    Mutant {
        what: "converter not calibrated",
        file: CHIP,
        right: "    let mut adc = Adc::new(adc, AdcConfig::default());\n",
        wrong: "    let mut adc = Adc::new(adc, AdcConfig::default());\n    pac::ADC1.calfact().write(|w| w.0 = 0);\n",
        shows: "ADC1 used without its calibration",
    },
    Mutant {
        what: "load cell and accelerometer exchanged",
        file: BOARD,
        right: "[pac::ADC1.jdr(1).read().jdata(), pac::ADC1.jdr(2).read().jdata()]",
        wrong: "[pac::ADC1.jdr(2).read().jdata(), pac::ADC1.jdr(1).read().jdata()]",
        shows: "5 N on the load cell",
    },
    Mutant {
        what: "the first conversion after a pause used",
        file: BOARD,
        right: "[pac::ADC1.jdr(1).read().jdata(), pac::ADC1.jdr(2).read().jdata()]",
        wrong: "[pac::ADC1.jdr(0).read().jdata(), pac::ADC1.jdr(2).read().jdata()]",
        shows: "5 N on the load cell",
    },
    Mutant {
        what: "AHB not divided while switching to 170 MHz",
        file: CHIP,
        right: "    config.rcc.ahb_pre = AHBPrescaler::DIV2;\n",
        wrong: "    config.rcc.ahb_pre = AHBPrescaler::DIV1;\n",
        shows: "with an undivided AHB",
    },
    Mutant {
        what: "no clock security",
        file: CHIP,
        right: "        pac::RCC.cr().modify(|w| w.set_csson(true));\n",
        wrong: "",
        shows: "after the crystal stopped",
    },
    Mutant {
        what: "PLL for a crystal of 25 MHz: the clock 4 % off",
        file: CHIP,
        right: "mul: PllMul::MUL85,",
        wrong: "mul: PllMul::MUL82,",
        shows: "a force every",
    },
    Mutant {
        what: "DAC trigger: TIM6 instead of TIM7",
        file: SETUP,
        right: "w.set_tsel(0, 2);",
        wrong: "w.set_tsel(0, 7);",
        shows: "force out",
    },
    Mutant {
        what: "range of the regulator at bit 0, as in metapac",
        file: CHIP,
        right: "pac::PWR.cr5().modify(|w| w.0 &= !(1 << 8));",
        wrong: "pac::PWR.cr5().modify(|w| w.0 = w.0 & !(1 << 8) | 1);",
        shows: "reserved bits 0x1 of PWR CR5",
    },
];

/// A copy of what the firmware is built from, whose binary has a name of its own: it shares the build directory.
fn copy(root: &Path, to: &Path) {
    for part in ["src", "crates", "benches", "examples", ".cargo"] {
        copy_tree(&root.join(part), &to.join(part));
    }
    for file in ["Cargo.lock", "build.rs", "memory.x", "rust-toolchain.toml"] {
        std::fs::copy(root.join(file), to.join(file)).expect(file);
    }
    let manifest = std::fs::read_to_string(root.join("Cargo.toml")).expect("Cargo.toml");
    let bin = "[lib]\nname = \"tribos_firmware\"";
    assert!(manifest.contains(bin));
    let named = format!("[[bin]]\nname = \"{MUTANT}\"\npath = \"src/main.rs\"\n\n{bin}");
    std::fs::write(to.join("Cargo.toml"), manifest.replacen(bin, &named, 1)).expect("written");
}

const MUTANT: &str = "mutant";

fn copy_tree(from: &Path, to: &Path) {
    std::fs::create_dir_all(to).expect("made");
    for entry in std::fs::read_dir(from).expect("there").map(|entry| entry.expect("readable")) {
        let (path, to) = (entry.path(), to.join(entry.file_name()));
        if path.is_dir() {
            copy_tree(&path, &to);
        } else {
            std::fs::copy(&path, &to).expect("copied");
        }
    }
}

pub fn a_wrong_build_of_the_board_is_seen() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let own = std::env::current_exe().expect("a test has a path");
    let target: PathBuf = own.ancestors().nth(3).expect("cargo's layout").to_owned();
    // beside the build, so that the copy and what cargo knows of it last from run to run
    let tree = target.join("mutants");
    let _ = std::fs::remove_dir_all(&tree);
    std::fs::create_dir_all(&tree).expect("made");
    copy(root, &tree);
    let mut unseen = Vec::new();
    let only = std::env::var("TRIBOS_MUTANT").unwrap_or_default();
    for mutant in MUTANTS.iter().filter(|mutant| mutant.what.contains(&only)) {
        let path = tree.join(mutant.file);
        let right = std::fs::read_to_string(&path).expect("a source");
        mutant.found_in(&right);
        std::fs::write(&path, right.replace(mutant.right, mutant.wrong)).expect("written");
        let elf = firmware::build_bin(&tree, &target, MUTANT).expect("a mutant builds");
        std::fs::write(&path, right).expect("written");
        let image = Image::parse(&std::fs::read(elf).expect("it is there")).expect("an image");
        let saw = check(&image);
        println!("{}:\n    {}", mutant.what, saw.join("\n    "));
        if !saw.iter().any(|line| line.contains(mutant.shows)) {
            unseen.push(mutant.what);
        }
    }
    assert!(unseen.is_empty(), "not seen: {unseen:?}");
}
