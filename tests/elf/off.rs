//! `off` on the running ELF: the enable pin falls within a period of the last byte, from every state and in the middle of
//! every command.

use crate::board::Board;

/// A control period, ms.
const PERIOD: f64 = 1.0;

/// Types, and returns the time at which the last byte is on the wire, ms.
fn typed(board: &mut Board, text: &str) -> f64 {
    board.machine.serial_write(text.as_bytes());
    while board.machine.serial_waiting() > 0 {
        board.machine.run_for(0.002);
    }
    board.machine.milliseconds()
}

/// Time to the low enable pin from a moment on, ms.
fn off_after(board: &mut Board, since: f64) -> f64 {
    while board.machine.amplifier_on() {
        assert!(board.machine.milliseconds() - since < 50.0, "still on");
        board.machine.run_for(0.002);
    }
    board.machine.milliseconds() - since
}

/// The pin stays low and the force zero for `ms`.
fn stays_off(board: &mut Board, ms: u32, what: &str) {
    for _ in 0..10 * ms {
        board.run(0.1);
        assert!(!board.machine.amplifier_on() && board.machine.force() == 0.0, "{what}: on again");
    }
}

fn until_on(board: &mut Board) {
    for _ in 0..2_000 {
        board.run(1.0);
        if board.machine.amplifier_on() {
            return;
        }
    }
    panic!("never on: {:?}", board.lines);
}

/// A state, how it is reached, and what `off` says of it.
type State = (&'static str, fn(&mut Board), &'static str);

const STATES: [State; 8] = [
    ("idle", |_| {}, "nothing was running"),
    ("rendering", |board| drop(board.ok("render on")), "rendering has ended"),
    ("moving", |board| drop(board.ok("move sine 0.008 2")), "the motion has ended"),
    (
        "ramping out",
        |board| {
            board.ok("move sine 0.008 2");
            board.run(700.0);
            board.ok("stop");
        },
        "the motion has ended",
    ),
    ("searching the stops", |board| drop(board.ok("home")), "the search has ended"),
    ("identifying", |board| drop(board.ok("identify")), "without a result"),
    ("push of the self-test", |board| board.machine.serial_write(b"selftest\n"), "the motion has ended"),
    (
        "fault",
        |board| {
            board.machine.press_stop(true);
            board.run(10.0);
            board.machine.press_stop(false);
        },
        "by a fault",
    ),
];

pub fn off_disables_the_amplifier_within_a_period_from_every_state() {
    println!("{:<24} {:>12}  answer", "state", "off after");
    for (name, enter, says) in STATES {
        let mut board = Board::ready();
        enter(&mut board);
        let drives = !matches!(name, "idle" | "fault");
        if drives {
            until_on(&mut board);
            board.run(80.0);
            assert!(board.machine.amplifier_on(), "{name}");
        }
        board.lines.clear();
        let sent = typed(&mut board, "off\n");
        let after = off_after(&mut board, sent);
        stays_off(&mut board, 30, name);
        let answers: Vec<&String> = board.lines.iter().filter(|line| line.starts_with("ok off: ")).collect();
        assert_eq!(answers.len(), 1, "{name}: {:?}", board.lines);
        println!("{name:<24} {after:>9.3} ms  {}", answers[0]);
        assert!(after <= PERIOD, "{name}: {after} ms");
        assert!(answers[0].ends_with(says), "{name}: {}", answers[0]);
        if name.contains("self-test") {
            assert!(board.lines.iter().any(|line| line.starts_with("err SWITCHED_OFF")), "{:?}", board.lines);
        }
        // again changes nothing, and nothing has to be undone
        let again = board.ok("off");
        if name == "fault" {
            assert!(again.ends_with("by a fault"), "{again}");
            assert!(board.ok("fault").starts_with("ok emergency_stop"));
            board.ok("clear");
        } else {
            assert_eq!(again, "ok off: the amplifier is off, nothing was running");
        }
        board.run(200.0);
        board.ok("render on");
        board.run(2.0);
        assert!(board.machine.amplifier_on(), "{name}: no way on again");
    }
}

pub fn off_overtakes_every_command() {
    let page: String = (0..300).map(|k| format!("set f_dynamic 1.{:02}\n", k % 80)).collect();
    let cases = [
        "help\n",
        "version\n",
        "status\n",
        "fault\n",
        "clear\n",
        "preset list\n",
        "preset show rubber\n",
        "preset use teflon\n",
        "preset save mine\n",
        "preset default mine\n",
        "preset delete mine\n",
        "set dv 0.009\n",
        "get\n",
        "get dv\n",
        "render on\n",
        "render off\nrender on\n",
        "move sine 0.008 2\n",
        "stop\nmove sine 0.008 2\n",
        "stop\nidentify\n",
        "stop\nhome\n",
        "stop\nzero\nmove sine 0.008 2\n",
        "stop\nselftest\n",
        "stop\nselftest\nmove sine 0.008 2\nrender on\n",
        "stop\ncalibrate load 0\nrender on\n",
        "stop\nrate 5000\nrender on\n",
        "stream on\n",
        "watch 5\n",
        "render on",
        "set dv 0.0",
        "\u{7f}\u{1}\u{2}rubbish",
        "rendre on\n",
        &page,
    ];
    let mut worst: f64 = 0.0;
    let mut board = Board::ready();
    for case in cases {
        board.ok("render on");
        board.run(20.0);
        board.lines.clear();
        let sent = typed(&mut board, &format!("{case}\noff\n"));
        let after = off_after(&mut board, sent);
        worst = worst.max(after);
        assert!(after <= PERIOD, "{case:?}: {after} ms");
        // until the slowest command has been answered: the self-test, a point of the calibration, a page
        stays_off(&mut board, 700, case);
        assert!(board.lines.iter().any(|line| line.starts_with("ok off: ")), "{case:?}: {:?}", board.lines);
        let answers = board.lines.iter().filter(|line| link::reply::is_answer(line)).count();
        let typed = format!("{case}\noff\n").split('\n').filter(|line| !line.is_empty()).count();
        if case != page {
            assert_eq!(answers, typed, "one answer a line: {case:?}: {:?}", board.lines);
        }
        board.run(400.0);
        board.ask("stream off");
        board.ask("rate 1000");
    }
    println!("{} commands: amplifier off at most {worst:.3} ms after the last byte of `off`", cases.len());
}
