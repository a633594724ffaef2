//! The ELF that would be flashed, on an emulated STM32G474 around the simulated rig.
//!
//! Cycles are those of an interpreter with a model of what the core waits for flash, CCM SRAM and buses (`emulator`, wait.rs).
#![cfg(not(target_os = "none"))]

#[macro_use]
extern crate untested;

mod absolute_encoder;
mod agreement;
mod black_box;
mod board;
mod clock;
mod compensation;
mod cycles;
mod device;
mod endurance;
mod flash;
mod index_pulse;
mod law_names;
mod load_cell_converter;
mod mutations;
mod no_panic;
mod off;
mod origin;
mod plot;
mod power_up;
mod random_commands;
mod random_inputs;
mod random_readings;
mod rate;
mod rendering;
mod safety;
mod selftest;
mod supply;
mod track;
#[path = "../common/typist.rs"]
mod typist;
mod velocity;
mod witness;

use board::{Board, TOOLCHAIN};
use haptics::ModeId;
use link::Frame;
use std::process::ExitCode;

/// Distance of the force's output from the end of conversion, µs: 40.6 µs after the trigger, of which the conversions take 21.5 µs.
const LATENCY_US: f64 = 19.2;

fn main() -> ExitCode {
    untested::run!(
        tests![
            absolute_encoder::the_angle_is_the_position_and_the_force_answers_it,
            absolute_encoder::every_rate_and_law_runs_with_it,
            absolute_encoder::a_start_knows_the_middle_of_the_stroke,
            absolute_encoder::every_failure_takes_the_force_off,
            agreement::target_and_host_render_the_same_forces_bit_for_bit,
            agreement::target_and_host_control_passivity_bit_for_bit,
            agreement::target_and_host_compensate_bit_for_bit,
            agreement::target_and_host_drive_the_handle_bit_for_bit,
            agreement::target_and_host_search_the_stops_bit_for_bit,
            black_box::a_reset_reports_its_reason_and_motion,
            black_box::a_crash_keeps_the_first_fault,
            supply::a_low_supply_changes_no_force,
            supply::a_low_supply_changes_no_reading_of_the_load_cell,
            supply::a_calibration_outlives_another_supply,
            clock::a_board_without_its_crystal_runs_and_says_so,
            clock::a_crystal_that_stops_takes_the_force_and_the_device_goes_on_without_it,
            clock::an_internal_clock_off_by_one_percent_loses_no_step_and_no_byte,
            compensation::the_friction_of_the_device_is_felt_down_to_a_tenth,
            cycles::every_law_under_every_renderer_stays_within_the_cycles_of_a_step,
            cycles::cycles_of_every_law_and_of_a_bond,
            cycles::cycles_of_every_effect,
            cycles::cycles_of_the_passivity_controller,
            cycles::cycles_of_the_compensation,
            cycles::the_longest_allowed_step_is_not_late,
            device::another_device_homes_and_identifies_after_a_reset,
            device::a_power_cut_leaves_the_old_or_the_new_device,
            endurance::full_load_costs_no_step_and_no_frame,
            flash::power_cuts_leave_old_or_new_presets,
            flash::presets_survive_power_cuts_and_deletions_hold,
            flash::flash_writes_delay_no_step_and_lose_no_frame,
            flash::a_failed_flash_changes_nothing,
            no_step_is_missed_under_full_load,
            answers_take_effect_on_the_handle,
            garbage_is_answered_and_changes_nothing,
            a_pasted_page_is_executed_line_by_line,
            frames_are_intact_and_follow_the_rig,
            identification_moves_the_handle_and_reports_its_end,
            mutations::the_correct_build_passes_the_mutation_check,
            mutations::a_wrong_build_finds_the_line_it_changes,
            index_pulse::a_start_knows_the_middle_once_the_index_has_passed,
            index_pulse::lost_counts_are_a_fault_at_the_next_pulse,
            load_cell_converter::weights_are_read_at_every_supply,
            load_cell_converter::every_rate_and_law_runs_with_both_sensors,
            load_cell_converter::every_failure_takes_the_force_off,
            no_panic::no_panic_is_reachable_from_the_control_interrupt,
            no_panic::the_control_path_runs_from_ccm,
            off::off_disables_the_amplifier_within_a_period_from_every_state,
            off::off_overtakes_every_command,
            origin::home_finds_the_middle_from_anywhere_in_the_stroke,
            origin::a_reset_in_mid_stroke_leaves_the_device_unreferenced,
            origin::a_start_at_a_stop_drives_nothing_into_it,
            the_full_force_reaches_the_output_both_ways,
            power_up::every_reset_cause_boots_and_unexpected_ones_are_faults,
            power_up::the_first_power_up_of_the_readme_works,
            power_up::a_low_brown_out_level_is_said,
            power_up::a_single_bank_of_flash_keeps_no_presets,
            random_inputs::target_and_host_agree_over_random_inputs_under_karnopp,
            random_inputs::target_and_host_agree_over_random_inputs_under_dahl,
            random_inputs::target_and_host_agree_over_random_inputs_under_coulomb,
            random_inputs::target_and_host_agree_over_random_inputs_under_lugre,
            random_inputs::target_and_host_agree_over_random_inputs_under_the_other_laws,
            random_inputs::target_and_host_agree_on_subnormals,
            rate::every_rate_misses_nothing_and_is_stable,
            rate::unstable_rates_and_running_modes_refuse_rate,
            rendering::elf_rendering_matches_host_and_continuous_block,
            safety::every_fault_switches_off_in_time,
            safety::the_watchdog_resets_an_endless_step,
            safety::a_pressed_emergency_stop_cannot_be_cleared,
            safety::a_spark_on_the_stop_line_stops_nothing,
            safety::only_driving_needs_a_talking_host,
            selftest::selftest_names_each_wiring_error,
            selftest::two_weights_calibrate_the_load_cell,
            selftest::without_its_flash_a_calibration_warns,
            selftest::the_load_cell_calibrates_the_force,
            selftest::what_is_not_the_force_is_not_calibrated,
            velocity::an_edge_at_any_instruction_of_the_sampling_leaves_the_velocity,
            velocity::pulse_interval_velocity_is_ten_times_better_at_low_speed_and_never_stale,
        ]
        .needing(&TOOLCHAIN),
        tests![random_commands::random_commands_leave_a_way_out]
            .needing(&TOOLCHAIN)
            .on_demand("five virtual minutes take more than two; -- --ignored random_commands"),
        tests![mutations::a_wrong_build_of_the_board_is_seen]
            .needing(&TOOLCHAIN)
            .on_demand("builds the firmware eight times; a step of .ci/run"),
    )
}

/// The buffer of the output once ended it at 8.8 N.
fn the_full_force_reaches_the_output_both_ways() {
    for hand in [9.4, -9.4] {
        let mut board = Board::ready();
        board.ok("preset use rubber");
        board.ok("set f_static 9.48");
        board.ok("render on");
        board.machine.set_hand(move |_: f64, _: f64, v: f64| hand - 20.0 * v);
        board.run(400.0);
        println!("hand {hand} N: the amplifier is told {:.3} N", board.machine.force());
        assert!(-board.machine.force() * hand.signum() > 9.3, "{}", board.machine.force());
        assert_eq!(board.ok("fault"), "ok no fault");
    }
}

fn no_step_is_missed_under_full_load() {
    let mut board = Board::ready();
    let idle = board.machine.statistics();
    println!(
        "idle      first step {:.1} ms after power-on; control interrupt {:.0} ({:.0} to {:.0}) cycles; core awake {:.1} %",
        board.machine.first_step_ms().expect("it has run"),
        idle.step_cycles.mean(),
        idle.step_cycles.min,
        idle.step_cycles.max,
        100.0 * idle.load(),
    );
    board.machine.reset_statistics();
    board.ok("render on");
    for preset in ["brass", "teflon", "viscous", "rubber"] {
        board.ok(&format!("preset use {preset}"));
    }
    let swap = board.machine.statistics();
    println!(
        "swapping  control interrupt at most {:.0} cycles, force ready after {:.2} us",
        swap.step_cycles.max, swap.compute_us.max
    );
    // half of the time there is
    assert!(swap.compute_us.max < LATENCY_US / 2.0, "{:?}", swap.compute_us);
    board.ok("stream on");
    // slides, turns and sticks
    board.machine.set_hand(|t: f64, _: f64, v: f64| 6.0 * (6.0 * t).sin() - 5.0 * v);
    board.run(10.0);
    board.machine.reset_statistics();
    let periods = 5_000;
    for _ in 0..periods / 50 {
        board.run(50.0);
    }
    let s = board.machine.statistics();
    println!(
        "full load {} triggers, {} steps, {} missed, {} late; control interrupt {:.0} ({:.0} to {:.0}) cycles; core awake {:.1} %",
        s.triggers,
        s.steps,
        s.missed,
        s.stale_outputs,
        s.step_cycles.mean(),
        s.step_cycles.min,
        s.step_cycles.max,
        100.0 * s.load(),
    );
    println!(
        "          end of conversion to: encoder read {:.2} to {:.2} us, force ready {:.2} to {:.2} us, force out {:.2} us (spread {:.3} us)",
        s.sampling_us.min,
        s.sampling_us.max,
        s.compute_us.min,
        s.compute_us.max,
        s.latency_us.mean(),
        s.latency_us.spread(),
    );
    println!(
        "          flash {} B of 524288, static RAM {} B and stack {} B of 98304; watchdog fed every {:.2} to {:.2} ms",
        board.image.flash_bytes,
        board.image.ram_bytes,
        board.machine.stack_bytes(),
        s.watchdog_gap_ms.min,
        s.watchdog_gap_ms.max,
    );
    assert_eq!((s.triggers, s.steps), (periods, periods));
    assert!(s.compute_us.max < LATENCY_US / 2.0, "{:?}", s.compute_us);
    assert_eq!((s.missed, s.stale_outputs), (0, 0));
    // every byte sent once interrupted, and woke the tasks: 12 %
    assert!(s.load() < 0.1, "core awake {:.1} %", 100.0 * s.load());
    assert!(
        (s.latency_us.mean() - LATENCY_US).abs() < 0.1 && s.latency_us.spread() < 0.01,
        "{:?}",
        s.latency_us
    );
    assert!((s.output_period_us.min - 1000.0).abs() < 0.01 && s.output_period_us.spread() < 0.01);
    assert!(board.machine.resets().is_empty(), "{:?}", board.machine.resets());
    assert!(board.machine.violations().is_empty(), "{:?}", board.machine.violations());
    let used = board.image.ram_bytes + board.machine.stack_bytes() as usize;
    assert!(used < 96 * 1024 * 3 / 4, "{used} bytes of RAM: the stack comes near the data");
    let status = board.ok("status");
    assert!(
        status.contains(" 0 late, 0 missed by the console") && status.ends_with(" 0 frames dropped"),
        "{status}"
    );
}

fn answers_take_effect_on_the_handle() {
    let mut board = Board::ready();
    println!("{}", board.ok("version"));
    let presets = board.ok("preset list");
    println!("{presets}");
    for name in ["brass", "teflon", "rubber"] {
        assert!(presets.contains(name), "{presets}");
    }
    assert!(!board.machine.amplifier_on());
    board.ok("preset use rubber");
    board.ok("render on");
    assert!(board.machine.amplifier_on());
    // below rubber's break-away: held, by a force as large as the hand's
    board.machine.set_hand(|_: f64, _: f64, _: f64| 2.0);
    let block = |status: String| status.split(", ").find(|part| part.starts_with("block")).map(str::to_owned);
    board.run(400.0);
    let (held, block_then) = (board.machine.truth(), block(board.ok("status")));
    board.run(400.0);
    let (later, block_now) = (board.machine.truth(), block(board.ok("status")));
    let swing = later.position - held.position;
    println!(
        "2 N for 0.8 s: {}; handle {:.1} um, swings by {:.2} um, force {:.2} N",
        block_now.as_deref().unwrap_or("?"),
        1e6 * later.position,
        1e6 * swing,
        board.machine.force()
    );
    // the block does not creep; the handle may swing on the coupling by some counts of 2.57 um
    assert!(block_now.as_deref().is_some_and(|b| b.ends_with("stuck")) && block_now == block_then);
    assert!(swing.abs() < 1e-5 && later.position.abs() < 1e-3);
    assert!((board.machine.force() + 2.0).abs() < 0.2);
    // beyond it: slides
    board.machine.set_hand(|_: f64, _: f64, v: f64| 5.0 - 20.0 * v);
    board.run(60.0);
    let moved = board.machine.truth();
    println!("5 N for 0.06 s: handle {:.2} mm, {:.1} mm/s", 1e3 * moved.position, 1e3 * moved.velocity);
    assert!(moved.position > 1e-3 && moved.velocity > 0.01);
    board.ok("render off");
    assert!(!board.machine.amplifier_on());
    assert_eq!(board.machine.force(), 0.0);
}

fn garbage_is_answered_and_changes_nothing() {
    let mut board = Board::ready();
    board.ok("preset use rubber");
    let before = board.ask("get");
    assert!(before.len() > 10, "{before:?}");
    let long = [b"set f_static ".as_slice(), &[b'1'; 500], b"\n"].concat();
    for (bytes, code) in [
        (b"rendre on\n".as_slice(), "UNKNOWN"),
        (b"render\n", "SYNTAX"),
        (b"\xff\xfe\x00set dv 9\n", "NOT_TEXT"),
        (b"set f_static NaN\n", ""),
        (b"set f_static 1e9\n", ""),
        (b"set k_vc -inf\n", ""),
        (b"preset use granite\n", "NO_PRESET"),
        (b"move sine 1 2\n", ""),
        (&long, "TOO_LONG: line of 513 bytes"),
    ] {
        let said = board.say(bytes, 30.0);
        println!(
            "{:40} {}",
            String::from_utf8_lossy(&bytes[..bytes.len().min(30)]).escape_debug(),
            said.join(" | ")
        );
        assert_eq!(said.len(), 1, "{said:?}");
        assert!(said[0].starts_with(&format!("err {code}")), "{said:?}");
    }
    // half a line is none, until its other half comes
    assert!(board.say(b"preset use br", 200.0).is_empty());
    assert_eq!(board.ok("ass\x7f\x7f\x7f\x7f\x7frubber"), "ok rubber");
    assert_eq!(board.ask("get"), before);
    assert!(!board.machine.amplifier_on());
}

fn a_pasted_page_is_executed_line_by_line() {
    let mut board = Board::ready();
    // the second is more than the device can hold: lines are lost, each loss is told
    for (lines, least) in [(100, 100), (600, 200)] {
        let page: String = (0..lines).map(|k| format!("set f_dynamic 1.{:02}\n", k % 80)).collect();
        let mut said = board.say(page.as_bytes(), 2_000.0);
        // what is lost is told with the end of the line that it is missing from
        said.extend(board.say(b"\n", 50.0));
        let (obeyed, refused): (Vec<_>, Vec<_>) = said.iter().partition(|line| line.starts_with("ok"));
        let lost = board.machine.serial_overruns();
        println!(
            "{lines} lines, {} bytes at once: {} obeyed, {} refused, {lost} bytes lost by the receiver",
            page.len(),
            obeyed.len(),
            refused.len(),
        );
        assert_eq!(lost, 0);
        assert!(obeyed.len() >= least && (obeyed.len() == lines || !refused.is_empty()));
        // each obeyed line is one that was typed
        for line in obeyed {
            let value = line.split_whitespace().find_map(|word| word.parse::<f64>().ok()).expect("a value");
            assert!((1.0..2.0).contains(&value), "{line}");
        }
        assert!(refused.iter().all(|line| line.starts_with("err NOT_TEXT")), "{refused:?}");
    }
    assert!(board.ok("get f_dynamic").starts_with("ok f_dynamic"), "in step again");
}

fn frames_are_intact_and_follow_the_rig() {
    let mut board = Board::ready();
    board.machine.set_hand(|t: f64, x: f64, v: f64| 400.0 * (0.01 * (6.0 * t).sin() - x) - 10.0 * v);
    board.ok("stream on");
    for _ in 0..100 {
        board.run(50.0);
        assert_eq!(board.corrupt, 0);
    }
    let Some((0, Frame::Header(header))) = board.frames.first().cloned() else { panic!("no header first") };
    let samples: Vec<_> = board.samples().collect();
    assert!(samples.len() >= 4_990, "{}", samples.len());
    for pair in samples.windows(2) {
        let [(seq, a), (next, b)] = pair else { unreachable!() };
        assert_eq!(*next, seq + 1, "a frame was lost");
        assert_eq!(b.step, a.step.wrapping_add(1));
        let period = b.sample_ticks.wrapping_sub(a.sample_ticks);
        assert!(period.abs_diff(header.period_ticks) < 170, "{period} ticks"); // 1 us
        assert_eq!((b.mode, b.dropped), (ModeId::Idle.code(), 0));
    }
    let travel = samples.iter().map(|(_, s)| s.count).max().zip(samples.iter().map(|(_, s)| s.count).min());
    let (most, least) = travel.expect("samples");
    let truth = board.machine.truth().position;
    let told = f64::from(samples.last().expect("samples").1.count) * f64::from(header.metre_per_count);
    println!(
        "{} frames, none lost or corrupt; travel {:.2} mm; last position {told:.6} m, truth {truth:.6} m",
        samples.len(),
        f64::from(most - least) * f64::from(header.metre_per_count) * 1e3
    );
    // the newest frame is some milliseconds old
    assert!((told - truth).abs() < 1e-3);
    assert!(most - least > 4_000, "the hand moved it");
    assert!(board.ok("stream off").contains(" 0 frames dropped"));
}

fn identification_moves_the_handle_and_reports_its_end() {
    let mut board = Board::ready();
    board.ok("stream on");
    board.ok("move sine 0.01 2 1");
    for _ in 0..60 {
        board.run(50.0);
    }
    let moving: Vec<_> =
        board.samples().filter(|(_, s)| s.mode == ModeId::Exciting.code()).map(|(_, s)| s).collect();
    let at = |s: &link::Sample| f64::from(s.count) * 2.57e-6;
    let most = moving.iter().map(at).fold(0.0, f64::max);
    let error = moving.iter().map(|s| (at(s) - f64::from(s.reference)).abs()).fold(0.0, f64::max);
    let force = moving.iter().map(|s| s.force.abs()).fold(0.0, f32::max);
    println!(
        "sine of 10 mm at 2 Hz for 1 s: {} periods, handle up to {:.2} mm, {:.2} mm off at most, {force:.2} N at most",
        moving.len(),
        1e3 * most,
        1e3 * error
    );
    assert!((900..2_500).contains(&moving.len()), "{}", moving.len());
    assert!((0.008..0.012).contains(&most), "{most}");
    assert!(error < 0.004, "{error}");
    assert!(board.lines.iter().any(|line| line.starts_with("! the motion has ended")), "{:?}", board.lines);
    assert!(!board.machine.amplifier_on());
}
