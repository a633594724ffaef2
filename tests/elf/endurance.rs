//! The figures of `emulator report`, over a shorter time: the same code.

use crate::board::image;
use emulator::report::observe;

pub fn full_load_costs_no_step_and_no_frame() {
    let image = image();
    let report = observe(image, 6.0, |_| ()).expect("it runs and obeys");
    println!("{report}");
    for bar in &report.bars() {
        assert!(bar.met, "{}: {} must be {}", bar.what, bar.figure, bar.bar);
    }
    assert_eq!((report.steps, report.missed, report.frames_lost), (6_000, 0, 0));
    // it was a flood, it was answered, and the handle both slid and stuck
    assert!(
        report.garbage_bytes > 100_000 && report.commands_answered > 100 && report.commands_refused > 100
    );
    assert!(report.preset_swaps > 20 && (0.1..0.95).contains(&report.sliding_share), "{report:?}");
}
