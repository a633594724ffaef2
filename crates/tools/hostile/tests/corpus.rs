//! Every target over its seeds, its minimised corpus and its findings.

use hostile::{TARGETS, accepted, run, seeds};
use std::path::{Path, PathBuf};
use std::sync::mpsc::channel;
use std::time::{Duration, Instant};

/// Time that a reader may take for an input of a few kilobytes: a hundred times what the slowest takes on a busy machine.
const LONGEST: Duration = Duration::from_secs(60);

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../..")
}

fn files(folder: &Path) -> Vec<PathBuf> {
    let Ok(entries) = std::fs::read_dir(folder) else { return Vec::new() };
    let mut files: Vec<PathBuf> =
        entries.filter_map(|e| Some(e.ok()?.path())).filter(|p| p.is_file()).collect();
    files.sort();
    files
}

/// Runs a reader and returns the memory and the time that it took.
fn watched(name: &'static str, input: usize, bytes: Vec<u8>) -> (usize, Duration) {
    let (done, result) = channel();
    let began = Instant::now();
    let reader = std::thread::spawn(move || {
        // after a hang nobody listens
        let _ = done.send(run(name, &bytes));
    });
    match result.recv_timeout(LONGEST) {
        Ok(taken) => {
            reader.join().expect("a reader that has answered");
            (taken, began.elapsed())
        }
        Err(_) if reader.is_finished() => panic!("{name}, input {input}: {:?}", reader.join().err()),
        Err(_) => panic!("{name}, input {input} hangs: not done after {} s", LONGEST.as_secs()),
    }
}

/// One test, because the allocator counts the whole process.
#[test]
fn no_reader_panics_hangs_or_takes_memory_beyond_its_input() {
    let seeds = seeds();
    for (name, _) in TARGETS {
        let mut inputs: Vec<Vec<u8>> =
            seeds.iter().filter(|(target, ..)| *target == name).map(|(.., bytes)| bytes.clone()).collect();
        assert!(!inputs.is_empty(), "{name}: no seed");
        for folder in ["corpus", "findings"] {
            let found = files(&root().join("fuzz").join(folder).join(name));
            inputs.extend(found.iter().map(|path| std::fs::read(path).expect("readable")));
        }
        let (mut largest, mut share, mut longest) = (0, 0.0_f64, Duration::ZERO);
        for (k, bytes) in inputs.iter().enumerate() {
            let (taken, took) = watched(name, k, bytes.clone());
            longest = longest.max(took);
            largest = largest.max(taken);
            share = share.max(taken as f64 / accepted(bytes.len()) as f64);
        }
        let count = inputs.len();
        println!(
            "{name:<8} {count:>5} inputs, at most {largest:>9} bytes taken, {share:.3} of what is accepted, and {:.0} ms",
            1e3 * longest.as_secs_f64()
        );
    }
}
