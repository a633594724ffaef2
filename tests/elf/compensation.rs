//! Feed-forward of the device's own friction and cogging on the target: what a hand feels of them, and whether the handle rests.

use crate::board::{Board, image};
use emulator::Machine;
use plant::{HandForce, HandImpedance, NoHand, RigConfig, Target};

/// Travel of one count, m.
const COUNT: f64 = 2.57e-6;
/// The friction that may be felt of 1.04 N, N.
const FELT: f64 = 0.15;

/// A board on the rig with the friction of [thesis, table 3-1], that renders nothing.
fn board() -> Board {
    let rig = RigConfig::default();
    let config = RigConfig {
        device_friction_p: rig.device_friction_p,
        device_friction_n: rig.device_friction_n,
        device_cogging: 0.2,
        device_cogging_wavelength: 4e-3,
        ..RigConfig::free_handle()
    };
    let no_block = friction::Custom(|_: &friction::Motion<f64>| 0.0);
    let mut board = Board::of(Machine::boot(image(), config, no_block, 1).expect("a rig"));
    board.ok("zero");
    board.ok("preset use viscous");
    for line in ["renderer impedance", "damping 0", "f_dynamic 0", "f_static 0"] {
        board.ok(&format!("set {line}"));
    }
    board.ok("render on");
    board
}

fn hand(stiffness: f64, damping: f64, target: Target) -> HandImpedance {
    HandImpedance { stiffness, damping, ..HandImpedance::relaxed(target) }
}

/// Friction that the hand carries while the handle slides, N, forward and back: its force without that for mass and damping.
fn slides(board: &mut Board, damping: f64) -> [f64; 2] {
    board.machine.set_hand(hand(
        1_500.0,
        15.0,
        Target::Sine { centre: 0.0, amplitude: 0.008, frequency: 0.5 },
    ));
    board.run(1_000.0);
    let mut sums = [(0.0, 0.0); 2];
    for _ in 0..4_000 {
        board.run(1.0);
        let t = board.machine.truth();
        if t.velocity.abs() > 5e-3 {
            let carried = t.hand_force - 0.692 * t.acceleration - damping * t.velocity;
            let sum = &mut sums[usize::from(t.velocity < 0.0)];
            *sum = (sum.0 + carried * t.velocity.signum(), sum.1 + 1.0);
        }
    }
    sums.map(|(sum, n)| sum / n)
}

/// Push that moves the resting handle by 20 counts, N: a slow ramp to each side of a wave of the cogging.
fn breaks_away(board: &mut Board) -> [f64; 2] {
    [1.0, -1.0].map(|sign| {
        board.machine.set_hand(hand(1_500.0, 60.0, Target::Hold { position: 0.0 }));
        board.run(1_500.0);
        board.machine.set_hand(NoHand);
        board.run(300.0);
        let begin = board.machine.truth();
        board.machine.set_hand(HandForce::Ramp { rate: sign * 0.5, from: begin.time, limit: 3.0 });
        for _ in 0..6_000 {
            board.run(1.0);
            let t = board.machine.truth();
            if (t.position - begin.position).abs() > 20.0 * COUNT {
                return sign * t.hand_force;
            }
        }
        panic!("3 N did not move it");
    })
}

/// Travel of the handle in a second, counts: released, in a relaxed hand, in a firm one.
fn rests(board: &mut Board) -> [f64; 3] {
    [(0.0, 0.0), (400.0, 6.0), (1_500.0, 15.0)].map(|(stiffness, damping)| {
        if stiffness > 0.0 {
            board.machine.set_hand(hand(stiffness, damping, Target::Hold { position: 0.002 }));
        } else {
            board.machine.set_hand(NoHand);
        }
        board.run(1_500.0);
        let (mut low, mut high) = (f64::MAX, f64::MIN);
        for _ in 0..1_000 {
            board.run(1.0);
            let x = board.machine.truth().position;
            (low, high) = (low.min(x), high.max(x));
        }
        (high - low) / COUNT
    })
}

pub fn the_friction_of_the_device_is_felt_down_to_a_tenth() {
    let mut board = board();
    let told = |what: &str, [p, n]: [f64; 2], [bp, bn]: [f64; 2], rests: [f64; 3]| {
        println!(
            "{what}: slides at {p:.3} and {n:.3} N, breaks away at {bp:.3} and {bn:.3} N; at rest released, relaxed, firm: {rests:.2?} counts"
        );
    };
    let before = slides(&mut board, 6.92);
    told("before", before, breaks_away(&mut board), rests(&mut board));
    assert!((before[0] - 1.04).abs() < 0.02 && (before[1] - 0.69).abs() < 0.02);
    board.ok("compensate friction_p 1.04 friction_n 0.69 damping 6.9");
    board.ok("compensate cogging.sine_1 0.2 cogging.wavelength 0.004");
    let status = board.ok("status");
    assert!(status.contains("compensates 90 % of its friction"), "{status}");
    let (slid, broke, rested) = (slides(&mut board, 0.71), breaks_away(&mut board), rests(&mut board));
    told("after", slid, broke, rested);
    assert!(slid.iter().all(|felt| (0.0..FELT).contains(felt)), "{slid:?}");
    assert!(broke.iter().all(|felt| (0.0..0.2).contains(felt)), "{broke:?}");
    assert!(rested.iter().all(|counts| *counts < 1.0), "a limit cycle: {rested:?}");
    // off: the hand feels all of it again
    board.ok("compensate off");
    let off = slides(&mut board, 6.92);
    assert!((off[0] - before[0]).abs() < 0.02, "{off:?}");
    assert_eq!(board.ok("fault"), "ok no fault");
}
