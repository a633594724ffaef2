//! The supply is the reference of both converters: zero and gain of force and sensors do not follow it.

use crate::board::{Board, image};
use emulator::Machine;

/// A board that starts with this supply, mV.
fn board(millivolt: u32) -> Board {
    let mut machine = Machine::free_handle(image(), 1);
    machine.set_supply(millivolt);
    Board::of(machine)
}

/// Largest and smallest force, N: that the step commands, and that the amplifier puts out.
fn forces(board: &mut Board) -> [[f64; 2]; 2] {
    board.ok("zero");
    board.ok("preset use viscous");
    board.ok("render on");
    board.ok("stream on");
    board.machine.set_hand(|t: f64, _: f64, v: f64| 6.0 * (12.0 * t).sin() - 5.0 * v);
    board.run(100.0);
    let mut felt = Vec::new();
    board.frames.clear();
    for _ in 0..1_100 {
        board.run(1.0);
        felt.push(board.machine.force());
    }
    let told: Vec<f64> = board.samples().map(|(_, sample)| sample.force.into()).collect();
    assert!(told.len() > 1_000, "{} samples", told.len());
    [told, felt]
        .map(|f| [f.iter().copied().fold(f64::MIN, f64::max), f.iter().copied().fold(f64::MAX, f64::min)])
}

pub fn a_low_supply_changes_no_force() {
    for millivolt in [3_300, 3_200, 3_400] {
        let mut board = board(millivolt);
        let version = board.ok("version");
        assert_eq!(version.contains("supply"), millivolt != 3_300, "{version}");
        let [told, felt] = forces(&mut board);
        for (told, felt) in told.into_iter().zip(felt) {
            println!("{millivolt} mV: {told:.3} N commanded, {felt:.3} N at the amplifier");
            assert!(told.abs() > 1.0 && (felt / told - 1.0).abs() < 0.005, "{told} {felt}");
        }
    }
}

pub fn a_low_supply_changes_no_reading_of_the_load_cell() {
    for millivolt in [3_300, 3_200, 3_400] {
        let mut machine = Machine::free_handle(image(), 1);
        machine.set_supply(millivolt);
        machine.put_on_bench(plant::Bench { weight: 5.0, gravity: 0.0 }).expect("in range");
        let mut board = Board::of(machine);
        // the noise of one reading is 0.02 N
        let load = mean_load(&mut board);
        println!("{millivolt} mV: 5 N are {load:.3} N");
        assert!((load / 5.0 - 1.0).abs() < 0.005, "{load}");
    }
}

/// A calibration is stored for the nominal supply, and used at the one of the next start.
pub fn a_calibration_outlives_another_supply() {
    let mut first = board(3_300);
    first.ok("device set load_gain 10");
    first.run(300.0);
    let stored = first.presets();
    let mut machine = Machine::free_handle(image(), 1);
    machine.program_flash(0x0807_d800, &stored);
    machine.set_supply(3_200);
    machine.put_on_bench(plant::Bench { weight: 5.0, gravity: 0.0 }).expect("in range");
    let mut second = Board::of(machine);
    let gain = second.ask("device");
    assert!(gain.iter().any(|line| line.contains("load_gain") && line.contains("10 ")), "{gain:?}");
    // the rig has 8.896 N a volt; the noise of one reading is a hundredth of it
    let (load, shown) = (mean_load(&mut second), 5.0 * 10.0 / (8.896 * 10.0 / 3.3));
    assert!((load / shown - 1.0).abs() < 0.005, "{load} {shown}");
}

/// Mean load over twenty answers to `status`, N.
fn mean_load(board: &mut Board) -> f64 {
    (0..20).map(|_| load(&board.ok("status"))).sum::<f64>() / 20.0
}

/// Load in an answer to `status`, N.
fn load(status: &str) -> f64 {
    let number = status.split(", load ").nth(1).and_then(|rest| rest.split(' ').next()).map(str::parse);
    number.and_then(Result::ok).expect("a load")
}
