//! The control step on the target and on this machine, bit for bit.

use crate::board::Board;
use haptics::{Control, Device, Excitation, Inputs, Request, Settings, Wave};
use link::Sample;

fn inputs(sample: &Sample) -> Inputs {
    Inputs {
        sample_ticks: sample.sample_ticks,
        count: sample.count as u32,
        edge_ticks: sample.edge_ticks(),
        load_code: sample.load_code,
        accel_code: sample.accel_code,
    }
}

/// A loop that knows the middle of its stroke, as the board does after `zero`.
fn control(settings: Settings) -> Control {
    Control::referenced(settings.build(&Device::default()).expect("fits the rig"))
}

fn host(preset: &str) -> Control {
    control(Settings::preset(preset).expect("built in"))
}

/// Replays what the target has measured, with the request in the period in which it left the idle state. Returns how
/// many forces were compared since then, how many of them with the block sliding, and the largest.
fn replay(board: &Board, mut host: Control, request: &Request) -> (u32, u32, f32) {
    let mut idle = true;
    let (mut compared, mut sliding, mut largest) = (0, 0, 0.0_f32);
    for (_, sample) in board.samples() {
        let begins = idle && sample.mode != 0;
        idle &= !begins;
        let outputs = host.step(begins.then_some(request), &inputs(&sample));
        let step = sample.step;
        assert_eq!((sample.fault, sample.mode), (0, outputs.mode.code()), "step {step}");
        let (here, there) = (outputs.force, sample.force);
        assert_eq!(here.to_bits(), there.to_bits(), "step {step}: host {here} N, target {there} N");
        assert_eq!(outputs.reference.to_bits(), sample.reference.to_bits(), "step {step}");
        compared += u32::from(!idle);
        sliding += u32::from(!idle && !outputs.stuck);
        largest = largest.max(outputs.force.abs());
    }
    assert_eq!(board.corrupt, 0);
    (compared, sliding, largest)
}

pub fn target_and_host_render_the_same_forces_bit_for_bit() {
    for name in ["brass", "teflon", "rubber", "viscous"] {
        let mut board = Board::ready();
        board.ok(&format!("preset use {name}"));
        board.ok("stream on");
        board.run(20.0);
        board.ok("render on");
        // slides both ways, turns, sticks
        board.machine.set_hand(|t: f64, x: f64, v: f64| 900.0 * (0.006 * (9.0 * t).sin() - x) - 8.0 * v);
        board.run(2_000.0);
        let (compared, sliding, largest) = replay(&board, host(name), &Request::Render(true));
        println!("{name}: {compared} forces identical, {sliding} of them sliding, up to {largest:.2} N");
        assert!(compared > 1_900 && sliding > 100, "{name}");
    }
}

pub fn target_and_host_control_passivity_bit_for_bit() {
    // a stiff spring with little damping gives energy: the controller has something to take
    let changes = [("renderer", "impedance"), ("k_vc", "12000"), ("b_vc", "1"), ("passivity", "on")];
    for name in ["brass", "rubber"] {
        let mut board = Board::ready();
        let mut settings = Settings::preset(name).expect("built in");
        board.ok(&format!("preset use {name}"));
        for (parameter, value) in changes {
            board.ok(&format!("set {parameter} {value}"));
            settings.set(parameter, value).expect("a parameter");
        }
        board.ok("stream on");
        board.run(20.0);
        board.ok("render on");
        board.machine.set_hand(|t: f64, x: f64, v: f64| 900.0 * (0.006 * (9.0 * t).sin() - x) - 8.0 * v);
        board.run(2_000.0);
        let (compared, sliding, largest) = replay(&board, control(settings), &Request::Render(true));
        // the same readings without it
        let mut with = control(settings);
        let mut without = control(Settings { passivity: false, ..settings });
        let (mut idle, mut differ) = (true, 0);
        for (_, sample) in board.samples() {
            let begins = idle && sample.mode != 0;
            idle &= !begins;
            let request = begins.then_some(&Request::Render(true));
            let forces = [&mut with, &mut without].map(|c| c.step(request, &inputs(&sample)).force);
            differ += u32::from(forces[0] != forces[1]);
        }
        println!(
            "{name}: {compared} forces identical, {sliding} sliding, up to {largest:.2} N; the controller changed {differ}"
        );
        assert!(compared > 1_900 && sliding > 100 && differ > 0, "{name}");
    }
}

pub fn target_and_host_compensate_bit_for_bit() {
    let mut board = Board::ready();
    let mut device = Device::default();
    let line = [
        ("friction_p", "1.04"),
        ("friction_n", "0.69"),
        ("damping", "6.9"),
        ("cogging.cosine_1", "0.1"),
        ("cogging.sine_2", "0.05"),
        ("cogging.wavelength", "0.004"),
    ];
    for (name, value) in line {
        board.ok(&format!("compensate {name} {value}"));
        device.compensation.set(name, value).expect("a parameter");
    }
    board.ok("preset use rubber");
    board.ok("stream on");
    board.run(20.0);
    board.ok("render on");
    board.machine.set_hand(|t: f64, x: f64, v: f64| 900.0 * (0.006 * (9.0 * t).sin() - x) - 8.0 * v);
    board.run(2_000.0);
    let settings = Settings::preset("rubber").expect("built in");
    let control = Control::referenced(settings.build(&device).expect("fits the rig"));
    let (compared, sliding, largest) = replay(&board, control, &Request::Render(true));
    println!(
        "compensation under rubber: {compared} forces identical, {sliding} of them sliding, up to {largest:.2} N"
    );
    assert!(compared > 1_900 && sliding > 100);
}

pub fn target_and_host_drive_the_handle_bit_for_bit() {
    for wave in ["sine", "multisine", "chirp", "triangle", "dwell"] {
        let mut board = Board::ready();
        board.ok("stream on");
        board.run(20.0);
        board.ok(&format!("move {wave} 0.006 2 0.5"));
        board.run(1_200.0);
        let excitation = Excitation {
            wave: Wave::from_id(wave).expect("one of the five"),
            amplitude_m: 0.006,
            frequency_hz: 2.0,
            seconds: 0.5,
        };
        let (compared, _, largest) = replay(&board, host("brass"), &Request::Excite(excitation));
        println!("{wave}: {compared} forces identical, up to {largest:.2} N");
        assert!(compared > 1_000 && largest > 0.2, "{wave}");
    }
}

pub fn target_and_host_search_the_stops_bit_for_bit() {
    for start in [-0.016, 0.012] {
        let mut board = Board::boot_at(start);
        board.ok("stream on");
        board.run(20.0);
        let told = board.home();
        board.run(50.0);
        assert!(told.starts_with("! home"), "{told}");
        let unreferenced = Control::new(*host("brass").config());
        let (compared, _, largest) = replay(&board, unreferenced, &Request::Home);
        println!("from {start} m: {compared} forces identical, up to {largest:.2} N; {told}");
        assert!(compared > 3_000 && largest > 6.0);
    }
}
