//! The firmware with the absolute encoder: an MT6835 on SPI2 in the place of the quadrature encoder.

use crate::board::{Board, image_with_absolute_encoder};
use crate::cycles::is_not_late;
use crate::no_panic::{REFUSED, in_flash};
use crate::rate::stiffest;
use crate::track::{Track, seconds};
use emulator::{EncoderFault, Machine, ResetCause};
use haptics::settings::law_cycles;
use haptics::{Estimator, LawKind, RATES, RendererKind};
use plant::RigConfig;

/// Travel in a count, m: a turn of 42.1 mm in 2¹⁵.
const COUNT: f64 = 42.1e-3 / 32_768.0;
/// Budget of a control step, cycles.
const BUDGET: f64 = 2_020.0;
/// From the motion to the force that answers it, µs: 40.6 from the trigger, less 16 bits of 5.3 MHz, and 2 in the chip.
const LATENCY_US: f64 = 40.6 - 3.0 + 2.0;
/// A control period and the conversion and step at its end, ms.
const TICK: f64 = 1.05;

fn boot_at(start_position: f64) -> Board {
    let image = image_with_absolute_encoder();
    let config = RigConfig { start_position, ..RigConfig::free_handle() };
    let no_block = friction::Custom(|_: &friction::Motion<f64>| 0.0);
    Board::with(image, Machine::boot(image, config, no_block, 1).expect("a place in the stroke"))
}

fn ready() -> Board {
    let mut board = boot_at(0.0);
    board.ok("zero");
    board.run(60.0);
    let told = board.lines.iter().any(|line| line == "! middle of the stroke kept; in flash");
    assert!(told, "{:?}", board.lines);
    board
}

/// Position that the device tells, m.
fn told_position(board: &mut Board) -> f64 {
    board.ok("stream on");
    board.run(30.0);
    let count = board.samples().last().expect("a frame").1.count;
    board.ok("stream off");
    board.frames.clear();
    f64::from(count) * COUNT
}

pub fn the_angle_is_the_position_and_the_force_answers_it() {
    let mut board = ready();
    board.ok("preset use rubber");
    board.ok("render on");
    // held below its break-away: the force is the hand's
    board.machine.set_hand(|_: f64, _: f64, v: f64| 2.0 - 20.0 * v);
    board.run(400.0);
    let held = board.machine.force();
    let (told, truth) = (told_position(&mut board), board.machine.truth().position);
    println!("2 N: force {held:.2} N; position {:.1} um, truth {:.1} um", 1e6 * told, 1e6 * truth);
    assert!((held + 2.0).abs() < 0.2 && (told - truth).abs() < 3e-6);
    // slides, turns and sticks
    let track = Track::default();
    let hand = |t: f64, x: f64, v: f64| 9.0 * (6.0 * t).sin() - 150.0 * x - 5.0 * v;
    board.machine.set_hand(track.of(hand));
    board.ok("stream on");
    board.run(100.0);
    board.frames.clear();
    board.machine.reset_statistics();
    for _ in 0..40 {
        board.run(50.0);
    }
    let s = board.machine.statistics();
    let samples: Vec<_> = board.samples().map(|(_, sample)| sample).collect();
    assert!(samples.windows(2).all(|w| w[1].step == w[0].step.wrapping_add(1)), "a frame was lost");
    let shift = track.shift(&samples, COUNT);
    let mut estimator = Estimator::default();
    let (mut largest, mut worst, mut squares) = (0.0_f64, 0.0_f64, [0.0; 2]);
    for (k, sample) in samples.iter().enumerate() {
        let ticks = sample.sample_ticks;
        estimator.sample(ticks, sample.count as u32, ticks.wrapping_sub(sample.edge_age));
        let Some((x, v)) = track.at(seconds(sample) + shift).filter(|_| k > 50) else { continue };
        let off = f64::from(sample.count) * COUNT - x;
        let told = f64::from(estimator.counts_per_tick()) * COUNT * 170e6;
        (largest, worst) = (largest.max(v.abs()), worst.max(off.abs()));
        squares = [squares[0] + off * off, squares[1] + (told - v) * (told - v)];
    }
    let [place, speed] = squares.map(|sum| (sum / samples.len() as f64).sqrt());
    println!(
        "moving with up to {:.0} mm/s: position {:.2} um rms off, at most {:.2} um; velocity {:.2} mm/s rms off",
        1e3 * largest,
        1e6 * place,
        1e6 * worst,
        1e3 * speed,
    );
    println!(
        "control interrupt {:.0} ({:.0} to {:.0}) cycles; motion to force {:.2} us (spread {:.3} us); {} missed, {} late",
        s.step_cycles.mean(),
        s.step_cycles.min,
        s.step_cycles.max,
        s.angle_us.mean(),
        s.angle_us.spread(),
        s.missed,
        s.stale_outputs
    );
    assert!(largest > 0.05, "it moved by {largest} m/s");
    // the steps of a count, and three times the noise
    assert!(worst < COUNT + 1.5e-6 && place < 0.8e-6, "{worst} {place}");
    assert!(speed < 4e-3, "{speed}");
    assert!((s.angle_us.mean() - LATENCY_US).abs() < 0.3 && s.angle_us.spread() < 0.05, "{:?}", s.angle_us);
    assert_eq!((s.missed, s.stale_outputs, s.step_flash_loads), (0, 0, 0));
    assert!(s.step_cycles.max < BUDGET, "{} cycles", s.step_cycles.max);
    assert!(board.machine.violations().is_empty(), "{:?}", board.machine.violations());
    let step = board.image.reach("ADC1_2").expect("the control interrupt");
    assert_eq!(in_flash(&step, Some(REFUSED)), Vec::<&str>::new());
    assert!(step.traps.is_empty() && step.indirect.is_empty(), "{:x?} {:x?}", step.traps, step.indirect);
    let panics: Vec<_> = step.functions.iter().filter(|name| name.contains("panic")).collect();
    assert!(panics.is_empty(), "{panics:?}");
}

/// Runs every rate, and every law under every renderer; cycles of the worst step.
pub fn worst_step(ready: impl Fn() -> Board) -> f64 {
    println!(
        "rate Hz  missed  late  worst cycles  motion to force us  force on the load cell to force us  largest k_vc N/m"
    );
    for &hz in RATES {
        let mut board = ready();
        board.ok(&format!("rate {hz}"));
        board.ok("preset use rubber");
        let most = stiffest(&mut board);
        board.ok("render on");
        board.machine.set_hand(|t: f64, _: f64, v: f64| 6.0 * (6.0 * t).sin() - 5.0 * v);
        board.run(20.0);
        board.machine.reset_statistics();
        board.run(500.0);
        let s = board.machine.statistics();
        let (cycles, age) = (s.step_cycles.max, s.angle_us.max);
        let of_load = format!("{:.0} to {:.0}", s.load_us.min, s.load_us.max);
        println!(
            "{hz:>7}  {:>6}  {:>4}  {cycles:>12.0}  {age:>18.2}  {of_load:>33}  {most:>16.0}",
            s.missed, s.stale_outputs
        );
        assert_eq!((s.missed, s.stale_outputs), (0, 0), "{hz} Hz");
        assert_eq!(board.ok("fault"), "ok no fault");
    }
    let mut board = ready();
    board.ok("preset use rubber");
    for pair in
        ["f_static 3.5", "f_dynamic 3", "damping 4", "sigma 8000", "dv 0.02", "stribeck_velocity 0.15"]
    {
        board.ok(&format!("set {pair}"));
    }
    board.machine.set_hand(|t: f64, _: f64, v: f64| 6.0 * (12.0 * t).sin() - 5.0 * v);
    let mut worst = (0.0, String::new());
    for law in LawKind::ALL {
        let answer = board.ask(&format!("set law {}", law.id())).swap_remove(0);
        if !answer.starts_with("ok") {
            // too dear beside the sensors
            assert!(law_cycles(*law) > 0 && answer.contains("cycles"), "{answer}");
            println!("{answer}");
            continue;
        }
        for renderer in RendererKind::ON_BOARD {
            board.ok(&format!("set renderer {}", renderer.id()));
            board.ok("render on");
            board.run(20.0);
            board.machine.reset_statistics();
            board.run(400.0);
            let s = board.machine.statistics();
            assert_eq!((s.missed, s.stale_outputs, s.step_flash_loads), (0, 0, 0));
            let counted = s.step_cycles.max - f64::from(law_cycles(*law));
            if counted > worst.0 {
                worst = (counted, format!("{} with {}", law.id(), renderer.id()));
            }
            board.ok("render off");
        }
    }
    println!("worst step of every law and renderer: {:.0} cycles, {}", worst.0, worst.1);
    assert!(board.machine.violations().is_empty(), "{:?}", board.machine.violations());
    is_not_late(ready());
    worst.0
}

pub fn every_rate_and_law_runs_with_it() {
    let worst = worst_step(ready);
    assert!(worst < BUDGET, "{worst}");
}

pub fn a_start_knows_the_middle_of_the_stroke() {
    let mut board = ready();
    // 6.3 mm is the end of the turn
    for (to, cause) in [(0.008, ResetCause::PowerOn), (-0.013, ResetCause::Pin), (0.013, ResetCause::PowerOn)]
    {
        board.machine.set_hand(move |_: f64, x: f64, v: f64| 800.0 * (to - x) - 30.0 * v);
        board.run(1_000.0);
        board.machine.reset_by(cause);
        board.run(150.0);
        assert!(!board.ok("status").contains("unreferenced"));
        let (told, truth) = (told_position(&mut board), board.machine.truth().position);
        println!("{cause:?} at {:.3} mm: starts at {:.3} mm", 1e3 * truth, 1e3 * told);
        assert!((truth - to).abs() < 2e-3 && (told - truth).abs() < 5e-6);
    }
    // what needs the middle is accepted at once
    board.machine.set_hand(|_: f64, _: f64, _: f64| 0.0);
    board.ok("render on");
    board.ok("render off");
    // without a stored middle it must be found
    let mut fresh = boot_at(0.004);
    assert!(fresh.ok("status").contains("unreferenced"));
    let told = fresh.home();
    fresh.run(100.0);
    println!("{told}; {}", fresh.lines.last().cloned().unwrap_or_default());
    fresh.machine.reset_by(ResetCause::PowerOn);
    fresh.run(150.0);
    assert!(!fresh.ok("status").contains("unreferenced"));
    let off = told_position(&mut fresh) - fresh.machine.truth().position;
    println!("after `home` and a restart: {:.1} um off", 1e6 * off);
    assert!(off.abs() < 100e-6, "{off}");
    assert!(fresh.machine.violations().is_empty(), "{:?}", fresh.machine.violations());
}

pub fn every_failure_takes_the_force_off() {
    use EncoderFault::{FlippedBit, Grounded, LowSupply, MagnetLost, Unplugged};
    println!("{:16} {:15} {:>14}", "failure", "fault", "force off, ms");
    let failures = [
        (Unplugged, "encoder_silent"),
        (MagnetLost, "encoder_silent"),
        (LowSupply, "encoder_silent"),
        (FlippedBit(0), "encoder_jump"),
        (FlippedBit(13), "encoder_jump"),
        (FlippedBit(31), "encoder_jump"),
        // the angle becomes 0, which is not where the handle is
        (Grounded, "encoder_jump"),
    ];
    for (failure, fault) in failures {
        let mut board = ready();
        board.ok("preset use rubber");
        board.ok("render on");
        board.machine.set_hand(|_: f64, _: f64, v: f64| 2.0 - 20.0 * v);
        board.run(300.0);
        assert!(board.machine.amplifier_on() && board.machine.force() < -1.5);
        let begun = board.machine.milliseconds();
        board.machine.set_encoder_fault(failure);
        while board.machine.amplifier_on() {
            board.machine.run_for(0.005);
            assert!(board.machine.milliseconds() - begun < 5.0, "{failure:?}: the force stays on");
        }
        let off = board.machine.milliseconds() - begun;
        board.run(30.0);
        assert_eq!(board.machine.force(), 0.0);
        let said = board.ok("fault");
        println!("{:16} {fault:15} {off:>14.2}", format!("{failure:?}"));
        assert!(off < TICK, "{failure:?}: {off} ms");
        assert!(said.starts_with(&format!("ok {fault}")), "{failure:?}: {said}");
        // as long as it lasts, `clear` does not help
        if failure != Grounded {
            board.ask("clear");
            board.run(10.0);
            assert!(board.ok("fault") != "ok no fault", "{failure:?} was cleared while it lasts");
            assert!(!board.machine.amplifier_on());
        }
        board.machine.set_encoder_fault(EncoderFault::None);
        board.machine.set_hand(|_: f64, _: f64, v: f64| -20.0 * v);
        board.run(300.0);
        board.ok("clear");
        board.run(10.0);
        assert_eq!(board.ok("fault"), "ok no fault", "{failure:?}");
        // the count was in doubt; the next start trusts the stored angle again
        board.machine.reset_by(ResetCause::Pin);
        board.run(150.0);
        let (told, truth) = (told_position(&mut board), board.machine.truth().position);
        assert!((told - truth).abs() < 5e-6, "{failure:?}: {told} {truth}");
        assert!(board.machine.violations().is_empty(), "{:?}", board.machine.violations());
    }
    // the magnet slips: every frame is good, but the handle moves and the angle does not
    let mut board = ready();
    board.ok("watch 5");
    board.ok("move sine 0.008 2");
    board.run(1_130.0);
    board.machine.set_encoder_fault(EncoderFault::Slips);
    let begun = board.machine.milliseconds();
    while board.machine.amplifier_on() {
        board.machine.run_for(0.05);
        assert!(board.machine.milliseconds() - begun < 300.0, "the magnet slips and the force stays on");
    }
    let off = board.machine.milliseconds() - begun;
    board.run(30.0);
    println!("{:16} {:15} {off:>14.2}", "Slips", board.ok("fault").split([' ', ',']).nth(1).unwrap_or("?"));
    // no encoder at the start: no force, and the reason
    let image = image_with_absolute_encoder();
    let mut machine = Machine::free_handle(image, 1);
    machine.set_encoder_fault(Unplugged);
    let mut board = Board::with(image, machine);
    // it waits for the encoder first
    board.run(700.0);
    let said = board.ok("fault");
    let first = board.machine.first_step_ms().unwrap_or(f64::NAN);
    println!("without it, first step after {first:.0} ms: {said}");
    assert!(said.starts_with("ok encoder_silent"), "{said}");
    assert!(board.ask("render on")[0].starts_with("err"));
}
