//! What a control step costs on the target under every law and every renderer.

use crate::board::{Board, built};
use crate::law_names::{COLUMNS, DONE, NAMES};
use emulator::{Machine, firmware};
use friction::effects::EffectKind;
use haptics::compensation::COMPENSATION_CYCLES;
use haptics::settings::{EFFECTS_CYCLES, PASSIVITY_CYCLES, effect_cycles, law_cycles};
use haptics::{LawKind, RendererKind};

/// Budget of a control step, cycles: a tenth of the period at 10 kHz.
const BUDGET: f64 = 1_700.0;
/// The elasto-plastic law in the plane is not in the device's step. Beyond this it would make the force late, cycles: 19.2 µs.
const LATE: f64 = 3_260.0;

/// A board with a block that every law can render, in a hand that makes it slide, turn and stick.
fn handled() -> Board {
    let mut board = Board::ready();
    board.ok("preset use rubber");
    for (name, value) in [
        ("f_static", "3.5"),
        ("f_dynamic", "3"),
        ("damping", "4"),
        ("sigma", "8000"),
        ("dv", "0.02"),
        ("stribeck_velocity", "0.15"),
    ] {
        board.ok(&format!("set {name} {value}"));
    }
    board.machine.set_hand(|t: f64, _: f64, v: f64| 6.0 * (12.0 * t).sin() - 5.0 * v);
    board
}

/// What a law is listed with beyond the budget, cycles.
fn own(law: LawKind) -> f64 {
    f64::from(law_cycles(law))
}

/// Part of [`own`] that a step of `worst` cycles does not use. The stored energy of a law with many springs, and bonds that snap
/// at random, may take it.
fn left(law: LawKind, worst: f64) -> f64 {
    (own(law) - (worst - BUDGET).max(0.0)).max(0.0)
}

pub fn every_law_under_every_renderer_stays_within_the_cycles_of_a_step() {
    let mut board = handled();
    board.ok("stream on");
    let renderers: String = RendererKind::ON_BOARD.iter().map(|r| format!("{:>18}", r.id())).collect();
    println!("{:40}{renderers}", "control interrupt, cycles: mean (worst)");
    for law in LawKind::ALL {
        board.ok(&format!("set law {}", law.id()));
        let mut row = format!("{:40}", law.id());
        for renderer in RendererKind::ON_BOARD {
            board.ok(&format!("set renderer {}", renderer.id()));
            board.ok("render on");
            board.run(20.0);
            board.machine.reset_statistics();
            board.run(600.0);
            let cycles = board.machine.statistics().step_cycles;
            row += &format!("{:>10.0} ({:5.0})", cycles.mean(), cycles.max);
            assert!(
                cycles.max < BUDGET + own(*law),
                "{} with {}: {} cycles",
                law.id(),
                renderer.id(),
                cycles.max
            );
            board.ok("render off");
        }
        println!("{row}");
    }
}

pub fn cycles_of_every_law_and_of_a_bond() {
    let image = built(|root, target| firmware::build_example(root, target, "laws"));
    let mut machine = Machine::free_handle(&image, 1);
    let words = COLUMNS * NAMES.len() + 1;
    let mut table = Vec::new();
    for _ in 0..200 {
        machine.run_for(100.0);
        table = machine.static_words("LAW_CYCLES", words).expect("the static of examples/laws.rs");
        if table.last() == Some(&DONE) {
            break;
        }
    }
    assert_eq!(table.last(), Some(&DONE), "not done after 20 s: {}", machine.whereabouts());
    println!("{:44}{:>6} {:>6}", "one step of a law, cycles:", "mean", "worst");
    for (name, row) in NAMES.iter().zip(table.chunks(COLUMNS)) {
        println!("{name:44}{:>6} {:>6}", row[0], row[1]);
    }
    let row = |name: &str| {
        let at = NAMES.iter().position(|n| *n == name).expect("a row");
        [f64::from(table[COLUMNS * at]), f64::from(table[COLUMNS * at + 1])]
    };
    let [few, some, many] = ["bristle, 10 bonds", "bristle, 20 bonds", "bristle, 50 bonds"].map(row);
    let a_bond = (many[0] - few[0]) / 40.0;
    let fixed = few[0] - 10.0 * a_bond;
    println!(
        "a bond: {a_bond:.1} cycles on the mean, {:.1} at worst; {fixed:.0} beside the bonds",
        (many[1] - few[1]) / 40.0
    );
    // linear in the bonds
    assert!(a_bond > 5.0 && (some[0] - few[0] - 10.0 * a_bond).abs() < 0.1 * some[0]);
    for name in NAMES.iter().filter(|name| !name.starts_with("bristle")) {
        let [_, worst] = row(name);
        let budget = if *name == "planar elasto_plastic" { LATE } else { BUDGET };
        assert!(worst > 0.0 && worst < budget, "{name}: {worst} cycles");
    }
}

/// What the passivity controller adds to the worst step under every law and renderer.
pub fn cycles_of_the_passivity_controller() {
    let mut board = handled();
    println!("{:36} {:>6} {:>6} {:>6}", "control interrupt, cycles at worst:", "off", "on", "listed");
    for law in LawKind::ALL {
        board.ok(&format!("set law {}", law.id()));
        for renderer in RendererKind::ON_BOARD {
            board.ok(&format!("set renderer {}", renderer.id()));
            let [off, on] = ["off", "on"].map(|switch| {
                board.ok(&format!("set passivity {switch}"));
                board.ok("render on");
                board.run(20.0);
                board.machine.reset_statistics();
                board.run(300.0);
                board.ok("render off");
                board.machine.statistics().step_cycles.max
            });
            board.ok("set passivity off");
            println!("{:17} {:18} {off:>6.0} {on:>6.0} {PASSIVITY_CYCLES:>6}", law.id(), renderer.id());
            let listed = f64::from(PASSIVITY_CYCLES) + left(*law, off);
            assert!(on - off <= listed, "{} with {}: {}", law.id(), renderer.id(), on - off);
        }
    }
}

/// What the feed-forward of the device's friction adds to the worst step under every law and renderer, and with cogging.
pub fn cycles_of_the_compensation() {
    let mut board = handled();
    let listed = COMPENSATION_CYCLES;
    println!("{:36} {:>6} {:>6} {:>6}", "control interrupt, cycles at worst:", "off", "on", "listed");
    let friction = "compensate friction_p 0.5 friction_n 0.4 damping 3";
    let cogging = "compensate friction_p 0.5 cogging.sine_1 0.1 cogging.cosine_2 0.1 cogging.wavelength 0.01";
    let worst = |board: &mut Board, compensate: &str| {
        board.ok(compensate);
        board.ok("render on");
        board.run(20.0);
        board.machine.reset_statistics();
        board.run(300.0);
        board.ok("render off");
        board.machine.statistics().step_cycles.max
    };
    for law in LawKind::ALL {
        board.ok(&format!("set law {}", law.id()));
        for renderer in RendererKind::ON_BOARD {
            board.ok(&format!("set renderer {}", renderer.id()));
            let [off, on] = ["compensate off", friction].map(|line| worst(&mut board, line));
            println!("{:17} {:18} {off:>6.0} {on:>6.0} {listed:>6}", law.id(), renderer.id());
            let listed = f64::from(listed) + left(*law, off);
            assert!(on - off <= listed, "{} with {}", law.id(), renderer.id());
        }
    }
    board.ok("set law karnopp");
    let [off, on] = ["compensate off", cogging].map(|line| worst(&mut board, line));
    let mut compensation = haptics::Compensation::off(&haptics::Device::default());
    compensation.set("cogging.sine_1", "0.1").expect("a parameter");
    let listed = compensation.cycles();
    println!("{:36} {off:>6.0} {on:>6.0} {listed:>6}", "karnopp, with cogging");
    assert!(on - off <= f64::from(listed));
}

/// Every effect alone under the cheapest law, with every gain set: what it adds to a step.
pub fn cycles_of_every_effect() {
    let mut board = Board::ready();
    board.machine.set_hand(|t: f64, x: f64, v: f64| 8.0 * (9.0 * t).sin() - 900.0 * x - 10.0 * v);
    let worst = |board: &mut Board| {
        board.ok("render on");
        board.run(20.0);
        board.machine.reset_statistics();
        board.run(400.0);
        let cycles = board.machine.statistics().step_cycles;
        board.ok("render off");
        cycles
    };
    board.ok("preset use teflon");
    let without = worst(&mut board);
    println!("{:32} {:>6} {:>6} {:>6}", "control interrupt with, cycles:", "mean", "worst", "listed");
    println!("{:32} {:>6.0} {:>6.0}", "no effect", without.mean(), without.max);
    let mut beyond = Vec::new();
    for kind in EffectKind::ALL {
        board.ok("preset use teflon");
        let mut set = false;
        for parameter in kind.gains() {
            let answer = board.ask(&format!("set {}.{} 0.2", kind.id(), parameter.name)).swap_remove(0);
            set |= answer.starts_with("ok");
        }
        if !set {
            println!("{:32} not on the device", kind.id());
            continue;
        }
        let with = worst(&mut board);
        let told = effect_cycles(*kind);
        println!("{:32} {:>6.0} {:>6.0} {told:>6}", kind.id(), with.mean(), with.max);
        let added = with.max - without.max - f64::from(EFFECTS_CYCLES);
        if added > f64::from(told) {
            beyond.push(format!("{}: {added} cycles, listed with {told}", kind.id()));
        }
    }
    assert!(beyond.is_empty(), "{beyond:?}");
}

/// The most expensive step that validation allows: the dearest law, and effects up to their limit.
pub fn the_longest_allowed_step_is_not_late() {
    is_not_late(Board::ready());
}

/// Renders the most expensive settings that this board accepts.
pub fn is_not_late(mut board: Board) {
    board.machine.set_hand(|t: f64, x: f64, v: f64| 8.0 * (9.0 * t).sin() - 900.0 * x - 10.0 * v);
    let of_effects: &[(&str, &str)] = &[
        ("law", "lugre"),
        ("stribeck.force_p", "0.2"),
        ("stribeck.force_n", "0.2"),
        ("frictional_lag.force", "0.2"),
        ("frictional_lag.stribeck", "0.2"),
    ];
    let of_law: &[(&str, &str)] = &[("law", "elasto_plastic"), ("spring.stiffness", "2")];
    for (renderer, dearest) in
        RendererKind::ON_BOARD.iter().flat_map(|renderer| [(renderer, of_effects), (renderer, of_law)])
    {
        board.ok("preset use rubber");
        let contact = [
            ("f_static", "3.5"),
            ("f_dynamic", "3"),
            ("damping", "4"),
            ("sigma", "8000"),
            ("dv", "0.01"),
            ("renderer", renderer.id()),
        ];
        let mut has_law = true;
        for (name, value) in contact.iter().chain(dearest) {
            let answer = board.ask(&format!("set {name} {value}")).swap_remove(0);
            if !answer.starts_with("ok") {
                println!("{answer}");
                has_law &= *name != "law";
            }
        }
        if !has_law {
            continue;
        }
        let refused = board.ask("set sublinear_viscous.force_p 0.2").swap_remove(0);
        println!("{refused}");
        assert!(refused.starts_with("err"), "{refused}");
        board.ok("render on");
        board.run(20.0);
        board.machine.reset_statistics();
        board.run(500.0);
        let s = board.machine.statistics();
        println!(
            "{} {}: {:.0} cycles at most, force ready after {:.2} us, {} late",
            dearest[0].1,
            renderer.id(),
            s.step_cycles.max,
            s.compute_us.max,
            s.stale_outputs
        );
        assert_eq!(s.stale_outputs, 0);
        board.ok("render off");
    }
}
