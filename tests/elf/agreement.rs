//! The control step on the target and on this machine, bit for bit.

use crate::board::Board;
use haptics::{Control, Device, Inputs, ModeId, Request, Settings};

#[test]
fn target_and_host_compute_the_same_forces_bit_for_bit() {
    for name in ["brass", "teflon", "rubber", "viscous"] {
        let Some(mut board) = Board::boot() else { return };
        board.ok(&format!("preset use {name}"));
        board.ok("stream on");
        board.run(20.0);
        board.ok("render on");
        // slides both ways, turns, sticks
        board.machine.set_hand(|t: f64, x: f64, v: f64| 900.0 * (0.006 * (9.0 * t).sin() - x) - 8.0 * v);
        board.run(2_000.0);
        let device = Device::default();
        let config = Settings::preset(name).expect("built in").build(&device).expect("fits the rig");
        let mut host = Control::new(config);
        let mut idle = true;
        let (mut compared, mut sliding, mut largest) = (0, 0, 0.0_f32);
        for (_, sample) in board.samples() {
            let inputs = Inputs {
                sample_ticks: sample.sample_ticks,
                count: sample.count as u32,
                edge_ticks: sample.edge_ticks(),
                load_code: sample.load_code,
                accel_code: sample.accel_code,
            };
            let begins = idle && sample.mode == ModeId::Rendering.code();
            idle &= !begins;
            let outputs = host.step(begins.then_some(&Request::Render(true)), &inputs);
            assert_eq!(sample.fault, 0);
            assert_eq!(
                outputs.force.to_bits(),
                sample.force.to_bits(),
                "{name}, step {}: host {} N, target {} N",
                sample.step,
                outputs.force,
                sample.force
            );
            compared += u32::from(!idle);
            sliding += u32::from(!idle && !outputs.stuck);
            largest = largest.max(outputs.force.abs());
        }
        println!("{name}: {compared} forces identical, {sliding} of them sliding, up to {largest:.2} N");
        assert!(compared > 1_900 && sliding > 100, "{name}");
        assert_eq!(board.corrupt, 0);
    }
}
