//! The firmware with an ADS131M02 on SPI3 in the place of the chip's converter for the load cell, beside the absolute encoder.

use crate::absolute_encoder::worst_step;
use crate::board::{Board, image_with_both_sensors};
use crate::no_panic::{REFUSED, in_flash};
use emulator::{ConverterFault, Machine, ResetCause};
use plant::Bench;

/// Largest step with both sensors, cycles.
const BUDGET: f64 = 2_360.0;

fn boot_at(millivolt: u32) -> Board {
    let image = image_with_both_sensors();
    let mut machine = Machine::free_handle(image, 1);
    machine.set_supply(millivolt);
    Board::with(image, machine)
}

fn ready() -> Board {
    let mut board = boot_at(3_300);
    board.ok("zero");
    board.run(60.0);
    board
}

/// What the device tells of its load cell, N.
fn told_load(board: &mut Board) -> f64 {
    let status = board.ok("status");
    let told = status.split(", load ").nth(1).and_then(|rest| rest.split(' ').next());
    told.and_then(|number| number.parse().ok()).unwrap_or_else(|| panic!("{status}"))
}

pub fn weights_are_read_at_every_supply() {
    for millivolt in [3_300, 3_100] {
        let mut board = boot_at(millivolt);
        for weight in [-20.0, -5.0, 0.0, 5.0, 20.0] {
            board.machine.put_on_bench(Bench { weight, gravity: 0.0 }).expect("in range");
            board.run(20.0);
            let told = told_load(&mut board);
            println!("{millivolt} mV, {weight} N: {told:.3} N");
            // the noise of the rig's load cell
            assert!((told - weight).abs() < 0.3, "{told}");
        }
        assert!(board.machine.violations().is_empty(), "{:?}", board.machine.violations());
    }
}

pub fn every_rate_and_law_runs_with_both_sensors() {
    let worst = worst_step(ready);
    assert!(worst < BUDGET, "{worst}");
    let step = image_with_both_sensors().reach("ADC1_2").expect("the control interrupt");
    assert_eq!(in_flash(&step, Some(REFUSED)), Vec::<&str>::new());
    assert!(step.traps.is_empty() && step.indirect.is_empty(), "{:x?} {:x?}", step.traps, step.indirect);
    let panics: Vec<_> = step.functions.iter().filter(|name| name.contains("panic")).collect();
    assert!(panics.is_empty(), "{panics:?}");
}

pub fn every_failure_takes_the_force_off() {
    type Break = fn(&mut Machine);
    let failures: [(&str, Break, f64); 5] = [
        ("unplugged", |machine| machine.set_converter_fault(ConverterFault::Unplugged), 2.05),
        ("a flipped bit", |machine| machine.set_converter_fault(ConverterFault::FlippedBit(30)), 2.05),
        ("the last bit", |machine| machine.set_converter_fault(ConverterFault::FlippedBit(87)), 2.05),
        ("without clock", |machine| machine.set_converter_fault(ConverterFault::NoClock), 6.05),
        ("restarted", Machine::restart_converter, 2.05),
    ];
    println!("{:16} {:15} {:>14}", "failure", "fault", "force off, ms");
    for (what, failure, within) in failures {
        let mut board = ready();
        board.ok("preset use rubber");
        board.ok("render on");
        board.machine.set_hand(|_: f64, _: f64, v: f64| 2.0 - 20.0 * v);
        board.run(300.0);
        assert!(board.machine.amplifier_on() && board.machine.force() < -1.5);
        let begun = board.machine.milliseconds();
        failure(&mut board.machine);
        while board.machine.amplifier_on() {
            board.machine.run_for(0.005);
            assert!(board.machine.milliseconds() - begun < 10.0, "{what}: the force stays on");
        }
        let off = board.machine.milliseconds() - begun;
        board.run(30.0);
        let said = board.ok("fault");
        println!("{what:16} {:15} {off:>14.2}", said.split([' ', ',']).nth(1).unwrap_or("?"));
        assert!(said.starts_with("ok sensor_dead"), "{what}: {said}");
        assert!(off < within && board.machine.force() == 0.0, "{what}: {off} ms");
        board.machine.set_converter_fault(ConverterFault::None);
        board.machine.set_hand(|_: f64, _: f64, v: f64| -20.0 * v);
        board.run(300.0);
        if what == "restarted" {
            // its settings are written at the start of the board
            board.ask("clear");
            board.run(10.0);
            assert!(board.ok("fault") != "ok no fault");
            board.machine.reset_by(ResetCause::Pin);
            board.run(150.0);
        } else {
            board.ok("clear");
            board.run(10.0);
        }
        assert!(board.ok("fault").starts_with("ok no fault"), "{what}: {}", board.ok("fault"));
        board.ok("render on");
        assert!(board.machine.violations().is_empty(), "{:?}", board.machine.violations());
    }
    // no converter at the start
    let image = image_with_both_sensors();
    let mut machine = Machine::free_handle(image, 1);
    machine.set_converter_fault(ConverterFault::Unplugged);
    let mut board = Board::with(image, machine);
    board.run(300.0);
    let said = board.ok("fault");
    println!("without it: {said}");
    assert!(said.starts_with("ok sensor_dead"), "{said}");
    assert!(board.ask("render on")[0].starts_with("err"));
}
