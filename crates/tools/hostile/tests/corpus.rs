//! Every target over its seeds, its minimised corpus and its findings.

use hostile::{TARGETS, accepted, run, seeds};
use std::path::{Path, PathBuf};

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

/// One test, because the allocator counts the whole process.
#[test]
fn no_reader_panics_or_takes_memory_beyond_its_input() {
    let seeds = seeds();
    for (name, _) in TARGETS {
        let mut inputs: Vec<Vec<u8>> =
            seeds.iter().filter(|(target, ..)| *target == name).map(|(.., bytes)| bytes.clone()).collect();
        assert!(!inputs.is_empty(), "{name}: no seed");
        for folder in ["corpus", "findings"] {
            let found = files(&root().join("fuzz").join(folder).join(name));
            inputs.extend(found.iter().map(|path| std::fs::read(path).expect("readable")));
        }
        let (mut largest, mut share) = (0, 0.0_f64);
        for bytes in &inputs {
            let taken = run(name, bytes);
            largest = largest.max(taken);
            share = share.max(taken as f64 / accepted(bytes.len()) as f64);
        }
        let count = inputs.len();
        println!(
            "{name:<8} {count:>5} inputs, at most {largest:>9} bytes taken, {share:.3} of what is accepted"
        );
    }
}
