//! What the control interrupt can reach, from the machine code of the ELF.

use crate::board::{Board, image};
use emulator::Reach;

/// Names of what must not be in a step: panics and what formats them, the log, soft-float `f64`, the allocator.
const FORBIDDEN: [&str; 8] =
    ["panic", "unwind", "unwrap_failed", "expect_failed", "core::fmt", "defmt", "__aeabi_d", "alloc::"];

/// What a step may run from flash: the check of a motion, once a command, and an exponent that no device's Dahl law has.
const ONCE_OR_NEVER: [&str; 4] =
    ["Excitation::validate", "Excitation::fastest", "Procedure::validate", "Dahl<S>::curved"];
/// The law that a device with another sensor refuses, and keeps in flash.
pub const REFUSED: &str = "LawState<S>::elasto_plastic";
/// Brings one of them back to CCM.
const BACK: &str = "__Thumbv7ABSLongThunk";

/// What a step runs from flash beside [`ONCE_OR_NEVER`] and `refused`, with its wait states.
pub fn in_flash<'a>(step: &'a Reach, refused: Option<&str>) -> Vec<&'a str> {
    let known = |name: &str| {
        name.starts_with(BACK) || ONCE_OR_NEVER.into_iter().chain(refused).any(|part| name.contains(part))
    };
    step.in_flash.iter().map(String::as_str).filter(|name| !known(name)).collect()
}

pub fn no_panic_is_reachable_from_the_control_interrupt() {
    let image = image();
    let step = image.reach("ADC1_2").expect("the control interrupt");
    println!(
        "control interrupt: {} instructions in {} functions can be reached, {} of them traps, {} calls through registers",
        step.instructions,
        step.functions.len(),
        step.traps.len(),
        step.indirect.len()
    );
    for function in &step.functions {
        println!("  {function}");
    }
    assert!(step.indirect.is_empty(), "calls that cannot be followed: {:x?}", step.indirect);
    assert!(step.traps.is_empty(), "{:x?}", step.traps);
    let found: Vec<_> =
        step.functions.iter().filter(|name| FORBIDDEN.iter().any(|word| name.contains(word))).collect();
    assert!(found.is_empty(), "{found:?}");
    // the same look at an interrupt that may panic, embassy's clock, finds it
    let clock = image.reach("TIM4").expect("the clock of the tasks");
    let panics = clock.functions.iter().any(|name| name.contains("panic"));
    println!("clock of the tasks: {} instructions, a panic among them: {panics}", clock.instructions);
    assert!(panics);
}

pub fn the_control_path_runs_from_ccm() {
    let step = image().reach("ADC1_2").expect("the control interrupt");
    // memory.x lists what is placed there
    assert_eq!(in_flash(&step, None), Vec::<&str>::new());
    let mut board = Board::ready();
    board.ok("preset use rubber");
    board.ok("render on");
    board.machine.set_hand(|t: f64, _: f64, v: f64| 6.0 * (6.0 * t).sin() - 5.0 * v);
    board.machine.reset_statistics();
    board.run(300.0);
    let s = board.machine.statistics();
    println!(
        "{} functions of the control interrupt in CCM; {} loads from flash in a step at most; {:.0} cycles at most",
        step.functions.len(),
        s.step_flash_loads,
        s.step_cycles.max
    );
    assert_eq!(s.step_flash_loads, 0);
}
