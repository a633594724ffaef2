//! Five minutes of random commands, hands, broken wires and resets at the running ELF, as `tests/random_commands.rs` does for an hour
//! at the virtual device.

use crate::board::Board;
use crate::typist::line;
use emulator::ResetCause;
use emulator::random::Random;
use link::reply;
use plant::{Wire, Wiring};

/// The largest force, and the resolution of the converter, N.
const MOST_N: f64 = 9.48 + 0.006;
const SECONDS: f64 = 300.0;

struct Run {
    board: Board,
    log: Vec<String>,
}

impl Run {
    fn fail(&self, what: &str) -> ! {
        panic!("{what}\n{}", self.log[self.log.len().saturating_sub(40)..].join("\n"));
    }

    fn pass(&mut self, ms: f64) {
        let end = self.board.machine.milliseconds() + ms;
        while self.board.machine.milliseconds() < end {
            self.board.run(2.0);
            let force = self.board.machine.force();
            if force.abs() > MOST_N {
                self.fail(&format!("{force} N"));
            }
        }
    }

    fn ask(&mut self, command: &str) -> Vec<String> {
        self.log.push(command.to_owned());
        self.board.lines.clear();
        self.board.machine.serial_write(format!("{command}\n").as_bytes());
        for _ in 0..4_000 {
            self.pass(2.0);
            let lines = &self.board.lines;
            let Some(at) = lines.iter().position(|line| reply::is_answer(line)) else { continue };
            let end = at + 1 + reply::lines_to_follow(&lines[at]);
            if lines.len() >= end {
                let answer = lines[at..end].to_vec();
                self.log.push(format!("    {}", answer[0]));
                return answer;
            }
        }
        self.fail(&format!("`{command}` was not answered; {}", self.board.machine.whereabouts()));
    }

    fn say(&mut self, command: &str) -> String {
        self.ask(command).swap_remove(0)
    }

    fn must(&mut self, command: &str) {
        let said = self.say(command);
        if !said.starts_with("ok") {
            self.fail(&format!("{command}: {said}"));
        }
    }

    fn way_out(&mut self) {
        self.board.machine.rewire(Wiring::default());
        self.board.machine.set_hand(|_: f64, _: f64, _: f64| 0.0);
        for command in ["off", "stream off", "calibrate discard"] {
            self.must(command);
        }
        self.pass(3_000.0);
        let refused = self.say("clear");
        if refused.starts_with("err OUTSIDE_STROKE: ") || refused.starts_with("err NOT_AT_REST: ") {
            self.must("device reset");
            self.must("clear");
        } else if !refused.starts_with("ok") {
            self.fail(&refused);
        }
        for command in ["watch 30", "device reset", "preset use brass", "rate 1000", "home"] {
            self.must(command);
        }
        self.board.lines.clear();
        for _ in 0..30 {
            self.pass(500.0);
            if self.board.lines.iter().any(|line| line.starts_with("! home")) {
                break;
            }
        }
        if !self.board.lines.iter().any(|line| line.starts_with("! home")) {
            self.fail(&format!("home: {:?}", self.board.lines));
        }
        self.must("render on");
        self.must("render off");
    }
}

pub fn random_commands_leave_a_way_out() {
    let mut random = Random(1);
    let mut run = Run { board: Board::ready(), log: Vec::new() };
    for command in ["set f_static 1.9", "preset save a", "set damping 3", "preset save b"] {
        run.must(command);
    }
    let shelf = ["a", "b"].map(|name| run.ask(&format!("preset show {name}")));
    let (mut commands, mut obeyed, mut resets) = (0, 0, 0);
    while run.board.machine.milliseconds() < 1e3 * SECONDS {
        for _ in 0..40 {
            let typed = line(&mut random);
            // the gain of the amplifier that is there does not follow
            let force = typed.contains("force_gain") || typed.starts_with("calibrate force");
            if typed.trim().is_empty() || typed.starts_with("sim ") || force {
                continue;
            }
            commands += 1;
            obeyed += u32::from(run.say(&typed).starts_with("ok"));
            let longest = if random.below(8) == 0 { 2_000 } else { 60 };
            run.pass(random.below(longest) as f64);
            match random.below(24) {
                0 => {
                    let push = [3.0, -15.0, 6.0][random.below(3)];
                    run.log.push(format!("-- hand {push} N"));
                    run.board.machine.set_hand(move |_: f64, _: f64, v: f64| push - 20.0 * v);
                }
                1 => run.board.machine.set_hand(|_: f64, _: f64, _: f64| 0.0),
                2 => {
                    let broken = [Wire::Swapped, Wire::Dead, Wire::Floating, Wire::Right][random.below(4)];
                    let right = Wiring::default();
                    let wiring = [
                        Wiring { encoder: broken, ..right },
                        Wiring { load: broken, ..right },
                        Wiring { accel: broken, ..right },
                        Wiring { amplifier: broken, ..right },
                    ][random.below(4)];
                    run.log.push(format!("-- {wiring:?}"));
                    run.board.machine.rewire(wiring);
                }
                3 => {
                    run.log.push("-- reset".into());
                    run.board.machine.reset_by([ResetCause::Pin, ResetCause::PowerOn][random.below(2)]);
                    run.pass(80.0);
                    resets += 1;
                    if run.board.machine.amplifier_on() {
                        run.fail("on after a reset");
                    }
                }
                _ => {}
            }
        }
        run.way_out();
        for (name, shown) in ["a", "b"].iter().zip(&shelf) {
            let found = run.ask(&format!("preset show {name}"));
            if found != *shown {
                run.fail(&format!("preset {name}: {found:?}, saved {shown:?}"));
            }
        }
    }
    let s = run.board.machine.statistics();
    println!(
        "{commands} commands, {obeyed} obeyed, {resets} resets in {:.0} s; {} steps missed, {:.0} cycles at most",
        run.board.machine.milliseconds() / 1e3,
        s.missed,
        s.step_cycles.max
    );
    assert!(resets > 3 && obeyed > commands / 4);
    assert!(run.board.machine.violations().is_empty(), "{:?}", run.board.machine.violations());
}
