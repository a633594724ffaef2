//! A whole diagnosis of 25 000 samples: under 5 s on two cores. `cargo bench -p diagnose`.

#[path = "../tests/plant/mod.rs"]
mod plant;

use diagnose::{Options, diagnose};
use plant::{Case, Hidden, Motion, record};
use signals::Recording;

fn main() {
    divan::main();
}

/// 25 s at 1 kHz on the independent plant.
fn recording(hidden: [Hidden; 2]) -> Recording {
    record(&Case { hidden, motion: Motion::Multisine, seconds: 25.0, ..Case::default() }).0
}

fn run(bencher: divan::Bencher, hidden: [Hidden; 2]) {
    let recordings = [recording(hidden)];
    bencher
        .counter(divan::counter::ItemsCount::new(recordings[0].time.len()))
        .bench_local(|| diagnose(&recordings, &[], &Options::default(), &|_, _| ()).expect("a diagnosis"));
}

#[divan::bench(sample_count = 3, sample_size = 1)]
fn nothing_hidden(bencher: divan::Bencher) {
    run(bencher, [Hidden::Nothing; 2]);
}

#[divan::bench(sample_count = 3, sample_size = 1)]
fn two_effects(bencher: divan::Bencher) {
    run(bencher, [Hidden::Stribeck { size: 0.5, speed: 0.02 }, Hidden::Spring { size: 0.4 }]);
}
