//! What takes the force off.

use crate::board::Board;
use emulator::ResetCause;
use plant::{Bench, Wire, Wiring};

const TIM6_CR1: u32 = 0x4000_1000;
const TIM2_CNT: u32 = 0x4000_0024;
/// A control period and the conversion and step at its end, ms.
const TICK: f64 = 1.05;
/// Pulse of the enable line: less than two periods after the last good step, ms.
const PULSE_MS: f64 = 1.9;
/// A step that never ends: the watchdog resets the chip within this, ms (the firmware asks for 50).
const WATCHDOG_MS: f64 = 65.0;
/// Half the stroke and what may be beyond it while rendering; the bound of the speed.
const BEYOND: f64 = 0.017;
const OVERSPEED: f64 = 1.0;

fn rendering() -> Board {
    let mut board = Board::ready();
    board.ok("preset use rubber");
    board.ok("render on");
    board.machine.set_hand(|_: f64, _: f64, v: f64| 2.0 - 20.0 * v);
    board.run(300.0);
    assert!(board.machine.amplifier_on() && board.machine.force() < -1.5, "{}", board.machine.force());
    board
}

fn moving() -> Board {
    let mut board = Board::ready();
    board.ok("watch 1");
    board.ok("move sine 0.008 2");
    for _ in 0..6 {
        board.run(190.0);
        board.machine.serial_write(b"\n");
    }
    assert!(board.machine.amplifier_on());
    board
}

/// A block that sticks, pushed with this force, N: the motor holds against it.
fn holding<const NEWTON: u32>() -> Board {
    let mut board = Board::ready();
    board.ok("preset use rubber");
    board.ok("set f_static 9.4");
    board.ok("render on");
    let newton = f64::from(NEWTON);
    board.machine.set_hand(move |_: f64, _: f64, v: f64| newton - 20.0 * v);
    board.run(300.0);
    assert!((board.machine.force() + newton).abs() < 0.5, "{}", board.machine.force());
    board
}

/// A sine that the accelerometer sees well.
fn shaking() -> Board {
    let mut board = Board::ready();
    board.ok("move sine 0.008 3");
    board.run(1_500.0);
    board
}

/// Runs until something is true, at most `ms`.
fn until(board: &mut Board, ms: f64, mut is: impl FnMut(&Board) -> bool) {
    let end = board.machine.milliseconds() + ms;
    while !is(board) {
        assert!(board.machine.milliseconds() < end, "not within {ms} ms");
        board.machine.run_for(0.005);
    }
}

/// One way to go wrong.
struct Case {
    fault: &'static str,
    how: &'static str,
    start: fn() -> Board,
    /// Does it; the evidence is complete when it returns.
    inject: fn(&mut Board),
    /// Longest time to the amplifier's enable pin being low, ms.
    within: f64,
    repair: fn(&mut Board),
}

fn nothing(_: &mut Board) {}

const CASES: &[Case] = &[
    Case {
        fault: "encoder_jump",
        how: "5 mm at once",
        start: rendering,
        inject: |board| board.machine.poke(TIM2_CNT, 2_000),
        within: TICK,
        repair: nothing,
    },
    Case {
        fault: "encoder_silent",
        how: "cable cut while moving",
        start: moving,
        inject: |board| {
            board.machine.rewire(Wiring { encoder: Wire::Dead, ..Wiring::default() });
            let v = board.machine.truth().velocity;
            until(board, 80.0, |board| {
                (board.machine.truth().velocity - v).abs() > 0.06 || !board.machine.amplifier_on()
            });
        },
        within: 30.0,
        repair: |board| board.machine.rewire(Wiring::default()),
    },
    Case {
        fault: "sensor_rail",
        how: "load cell at its end, 3rd sample",
        start: rendering,
        inject: |board| board.machine.put_on_bench(Bench { weight: 200.0, gravity: 0.0 }).expect("in range"),
        within: 2.0 + TICK,
        repair: |board| board.machine.put_on_bench(Bench::default()).expect("in range"),
    },
    Case {
        fault: "sensor_rail",
        how: "accelerometer at its end, 3rd sample",
        start: rendering,
        inject: |board| board.machine.put_on_bench(Bench { weight: 0.0, gravity: -900.0 }).expect("in range"),
        within: 2.0 + TICK,
        repair: |board| board.machine.put_on_bench(Bench::default()).expect("in range"),
    },
    Case {
        fault: "non_finite",
        how: "stiffness in RAM becomes NaN",
        start: || {
            let mut board = rendering();
            board.ok("set k_vc 12345");
            board.run(20.0);
            board
        },
        inject: |board| assert!(board.machine.corrupt_ram(12_345.0_f32.to_bits(), f32::NAN.to_bits()) > 0),
        within: TICK,
        repair: |board| drop(board.ask("preset use rubber")),
    },
    Case {
        fault: "missed_deadline",
        how: "a sample 0.8 ms late",
        start: rendering,
        inject: |board| {
            board.machine.poke(TIM6_CR1, 0);
            board.machine.run_for(0.8);
            board.machine.poke(TIM6_CR1, 1);
        },
        within: TICK,
        repair: nothing,
    },
    Case {
        fault: "missed_deadline",
        how: "samples stop altogether",
        start: rendering,
        inject: |board| board.machine.poke(TIM6_CR1, 0),
        within: PULSE_MS,
        repair: nothing,
    },
    Case {
        fault: "late_force",
        how: "steps take 3 000 cycles more, the third",
        start: rendering,
        inject: |board| board.machine.delay_control(3_000),
        within: 3.0 + TICK,
        repair: |board| board.machine.delay_control(0),
    },
    Case {
        fault: "host_silent",
        how: "1 s after its last byte",
        start: moving,
        inject: |board| {
            board.machine.serial_write(b"\n");
            board.machine.run_for(990.0);
        },
        within: 12.0,
        repair: nothing,
    },
    Case {
        fault: "end_of_stroke",
        how: "pushed beyond while driven",
        start: moving,
        inject: |board| {
            board.machine.set_hand(|_: f64, _: f64, v: f64| 40.0 - 60.0 * v);
            until(board, 200.0, |board| board.machine.truth().position > BEYOND - 0.0015);
        },
        within: TICK,
        repair: nothing,
    },
    Case {
        fault: "overspeed",
        how: "thrown at 1 m/s",
        start: rendering,
        inject: |board| {
            board.machine.set_hand(|_: f64, _: f64, _: f64| 43.0);
            until(board, 200.0, |board| board.machine.truth().velocity > OVERSPEED);
        },
        // the estimate is that of the middle of the period
        within: 0.5 + TICK,
        repair: nothing,
    },
    Case {
        fault: "panic",
        how: "in a task",
        start: rendering,
        inject: |board| assert!(board.machine.run_into_task() && board.machine.panic_here()),
        within: TICK,
        repair: nothing,
    },
    Case {
        fault: "panic",
        how: "in the control interrupt",
        start: rendering,
        inject: |board| assert!(board.machine.run_into_control() && board.machine.panic_here()),
        within: TICK,
        repair: nothing,
    },
    Case {
        fault: "crash",
        how: "jump to where nothing is",
        start: rendering,
        inject: |board| board.machine.derail(0x6000_0000),
        within: TICK,
        repair: nothing,
    },
    Case {
        fault: "brown_out",
        how: "supply falls to 2.8 V",
        start: rendering,
        inject: |board| board.machine.set_supply(2_800),
        within: TICK,
        repair: |board| board.machine.set_supply(3_300),
    },
    Case {
        fault: "brown_out",
        how: "supply falls to 1.5 V: reset",
        start: rendering,
        inject: |board| {
            board.machine.set_supply(2_500);
            board.machine.run_for(0.05);
            board.machine.set_supply(1_500);
            board.machine.set_supply(3_300);
        },
        within: TICK,
        repair: nothing,
    },
    Case {
        fault: "clock",
        how: "the crystal stops",
        start: rendering,
        inject: |board| board.machine.set_crystal(false),
        within: TICK,
        repair: nothing,
    },
    Case {
        fault: "force_contradicted",
        how: "command wire broken: 0 V",
        start: rendering,
        inject: |board| board.machine.break_command(true),
        within: 20.0,
        repair: |board| board.machine.break_command(false),
    },
    Case {
        fault: "force_contradicted",
        how: "load cell floats at mid-scale, 5 N held",
        start: holding::<5>,
        inject: |board| board.machine.rewire(Wiring { load: Wire::Floating, ..Wiring::default() }),
        within: 30.0,
        repair: |board| board.machine.rewire(Wiring::default()),
    },
    Case {
        fault: "force_contradicted",
        how: "load cell shows 6 N that are not there",
        start: rendering,
        inject: |board| board.machine.put_on_bench(Bench { weight: 6.0, gravity: 0.0 }).expect("in range"),
        within: 20.0,
        repair: |board| board.machine.put_on_bench(Bench::default()).expect("in range"),
    },
    Case {
        fault: "force_contradicted",
        how: "amplifier loses its supply, 5 N held",
        start: holding::<5>,
        inject: |board| board.machine.rewire(Wiring { amplifier: Wire::Dead, ..Wiring::default() }),
        within: 30.0,
        repair: |board| board.machine.rewire(Wiring::default()),
    },
    Case {
        fault: "sensor_dead",
        how: "accelerometer floats while driven",
        start: shaking,
        inject: |board| board.machine.rewire(Wiring { accel: Wire::Floating, ..Wiring::default() }),
        within: 1_000.0,
        repair: |board| board.machine.rewire(Wiring::default()),
    },
    Case {
        fault: "sensor_dead",
        how: "load cell: always the same code",
        start: rendering,
        inject: |board| board.machine.rewire(Wiring { load: Wire::Dead, ..Wiring::default() }),
        within: 505.0,
        repair: |board| board.machine.rewire(Wiring::default()),
    },
    Case {
        fault: "motor_hot",
        how: "9 N held, heating in 5 s instead of 60",
        start: || {
            let mut board = holding::<9>();
            board.ok("limit heating 5");
            board
        },
        inject: nothing,
        // 5 s · ln(1.27 / 0.27), from the end of the first 0.3 s on
        within: 8_000.0,
        repair: nothing,
    },
    Case {
        fault: "amplifier",
        how: "its fault output opens, 3rd sample",
        start: rendering,
        inject: |board| board.machine.set_amplifier_fault(true),
        within: 2.0 + TICK,
        repair: |board| board.machine.set_amplifier_fault(false),
    },
    Case {
        fault: "host_silent",
        how: "while rendering, `watch 1 render`",
        start: || {
            let mut board = rendering();
            board.ok("watch 1 render");
            board
        },
        inject: |board| {
            board.machine.serial_write(b"\n");
            board.machine.run_for(990.0);
        },
        // promises are 20 ms apart
        within: 32.0,
        repair: nothing,
    },
    Case {
        fault: "emergency_stop",
        how: "pressed, 3rd sample",
        start: rendering,
        inject: |board| board.machine.press_stop(true),
        within: 2.0 + TICK,
        repair: |board| board.machine.press_stop(false),
    },
];

/// A person takes the handle back to the middle and lets go.
fn hands_off(board: &mut Board) {
    board.machine.set_hand(|_: f64, x: f64, v: f64| -200.0 * x - 20.0 * v);
    board.run(1_200.0);
    board.machine.set_hand(|_: f64, _: f64, _: f64| 0.0);
    board.run(150.0);
}

pub fn every_fault_switches_off_in_time() {
    println!("{:<16} {:<38} {:>10}  message", "fault", "how", "off after");
    for case in CASES {
        let mut board = (case.start)();
        (case.inject)(&mut board);
        let injected = board.machine.milliseconds();
        while board.machine.amplifier_on() && board.machine.milliseconds() - injected < 100.0 + case.within {
            board.machine.run_for(0.002);
        }
        let after = board.machine.milliseconds() - injected;
        for _ in 0..60 {
            board.run(1.0);
            assert!(
                !board.machine.amplifier_on() && board.machine.force() == 0.0,
                "{}: on again",
                case.fault
            );
        }
        let told = board.ok("fault");
        let why = told.split("; ").skip(1).collect::<Vec<_>>().join("; ");
        println!("{:<16} {:<38} {after:>7.3} ms  {why}", case.fault, case.how);
        assert!(told.starts_with(&format!("ok {} ", case.fault)), "{}, {}: {told}", case.fault, case.how);
        assert!(after <= case.within, "{}, {}: {after} ms", case.fault, case.how);
        // latched, whatever is asked
        let refused = board.ask("render on").swap_remove(0);
        assert!(refused.starts_with("err FAULT_LATCHED: ") && refused.contains(case.fault), "{refused}");
        assert!(board.ask("move sine 0.005 1")[0].starts_with("err FAULT_LATCHED"));
        (case.repair)(&mut board);
        hands_off(&mut board);
        // while somebody pulls at the handle it cannot be cleared
        board.machine.put_on_bench(Bench { weight: 4.0, gravity: 0.0 }).expect("in range");
        board.run(20.0);
        let pulled = board.ask("clear").swap_remove(0);
        assert!(pulled.starts_with("err NOT_AT_REST"), "{}: {pulled}", case.fault);
        board.machine.put_on_bench(Bench::default()).expect("in range");
        board.run(20.0);
        board.ok("clear");
        assert_eq!(board.ok("fault"), "ok no fault", "{}", case.fault);
        board.ok("render on");
        board.run(5.0);
        assert!(board.machine.amplifier_on(), "{}", case.fault);
    }
}

pub fn the_watchdog_resets_an_endless_step() {
    let mut board = rendering();
    assert!(board.machine.run_into_control());
    board.machine.hang();
    let stuck = board.machine.milliseconds();
    until(&mut board, PULSE_MS, |board| !board.machine.amplifier_on());
    let off = board.machine.milliseconds() - stuck;
    board.run(0.02); // the rig follows the pin within 10 us
    assert_eq!(board.machine.force(), 0.0);
    println!("step never ends: amplifier off by hardware after {off:.2} ms");
    board.run(WATCHDOG_MS);
    let [(at, ResetCause::Watchdog)] = board.machine.resets() else { panic!("{:?}", board.machine.resets()) };
    println!("step never ends: reset by the watchdog after {:.1} ms", at - stuck);
    board.run(50.0);
    assert!(!board.machine.amplifier_on(), "off after the reset too");
    let fault = board.ok("fault");
    println!("{fault}");
    assert!(fault.starts_with("ok watchdog"), "{fault}");
    assert!(board.ask("render on")[0].starts_with("err"));
}

pub fn a_pressed_emergency_stop_cannot_be_cleared() {
    let mut board = rendering();
    board.machine.press_stop(true);
    hands_off(&mut board);
    assert!(board.ok("fault").starts_with("ok emergency_stop"));
    board.ask("clear");
    board.run(10.0);
    assert!(board.ask("render on")[0].starts_with("err"), "cleared, but still pressed");
    for _ in 0..50 {
        board.run(1.0);
        assert!(!board.machine.amplifier_on());
    }
    board.machine.press_stop(false);
    board.run(10.0);
    board.ok("clear");
    board.ok("render on");
    assert!(board.machine.amplifier_on());
}

pub fn a_spark_on_the_stop_line_stops_nothing() {
    let mut board = rendering();
    board.machine.press_stop(true);
    board.run(1.5);
    board.machine.press_stop(false);
    board.run(20.0);
    assert!(board.machine.amplifier_on());
    assert_eq!(board.ok("fault"), "ok no fault");
}

pub fn only_driving_needs_a_talking_host() {
    let mut board = moving();
    for _ in 0..10 {
        board.machine.serial_write(b"\n");
        board.run(300.0);
    }
    assert_eq!(board.ok("fault"), "ok no fault");
    board.ok("stop");
    board.run(800.0);
    board.ok("render on");
    board.run(1_500.0);
    assert!(board.machine.amplifier_on(), "the promise ended with the motion");
}
