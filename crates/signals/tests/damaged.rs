//! Files that are cut off or have bits turned over: each is read or refused in one line, none makes the reader panic, and none makes it
//! take memory that the file does not account for. A binary of its own, because it counts what is allocated.

use peak_alloc::PeakAlloc;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use signals::{ReadOptions, Recording};
use std::path::{Path, PathBuf};

#[global_allocator]
static ALLOCATED: PeakAlloc = PeakAlloc;

/// Memory bound of a large file, bytes per byte of the file.
const MOST: usize = 20;

/// Memory bound of a small file, bytes: twice the largest page or chunk whose stated size is accepted.
const LEAST: usize = 4 << 20;

/// Damaged versions of each file.
const FLIPS: usize = 300;
const CUTS: usize = 60;

/// Files, the joint to read, and the map.
const FILES: [(&str, Option<&str>, Option<&str>); 13] = [
    ("arm_sqlite/arm_sqlite.db3", Some("slider"), Some("force_n=/ft:force.z")),
    ("arm_mcap/arm_mcap.mcap", Some("slider"), Some("force_n=/ft:force.z")),
    ("one_joint/one_joint.mcap", None, None),
    ("arm_snappy.parquet", Some("j1"), None),
    ("arm_zstd.parquet", Some("j1"), None),
    ("stamped.parquet", None, None),
    ("arm.h5", Some("j1"), None),
    ("degrees.h5", Some("1"), None),
    ("arm_v73.mat", Some("1"), Some("time_s=t,position_rad=q,torque_nm=tau")),
    ("decimal_comma.txt", None, None),
    ("spaces.txt", None, None),
    ("tabs.txt", Some("1"), None),
    ("ours.mcap", None, None),
];

/// Peak of the memory that reading allocates, bytes, and whether the file was read.
fn taken(path: &Path, options: &ReadOptions) -> (usize, bool) {
    let before = ALLOCATED.current_usage();
    ALLOCATED.reset_peak_usage();
    let read = Recording::read(path, options);
    let peak = ALLOCATED.peak_usage();
    if let Err(error) = &read {
        let said = error.to_string();
        let place = said.contains(&path.display().to_string()) || said.starts_with("map, column ");
        assert!(place && !said.contains('\n'), "{said:?}");
    }
    (peak.saturating_sub(before), read.is_ok())
}

fn fixture(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/foreign").join(name)
}

#[test]
fn damage_is_refused_within_bounds() {
    let dir = tempfile::tempdir().unwrap();
    let ours = Recording::read(fixture("j1.csv"), &ReadOptions::default()).unwrap();
    ours.write(dir.path().join("ours.mcap")).unwrap();
    ours.write(dir.path().join("ours.mat")).unwrap();
    let more = [("ours.mat", None, None)];
    for (name, joint, map) in FILES.into_iter().chain(more) {
        let source = if name.starts_with("ours") { dir.path().join(name) } else { fixture(name) };
        let suffix = source.extension().unwrap().to_str().unwrap();
        let path = dir.path().join(format!("damaged.{suffix}"));
        let options =
            ReadOptions { map: map.map(|text: &str| text.parse().unwrap()), joint: joint.map(str::to_owned) };
        let whole = std::fs::read(&source).unwrap();
        let most = (MOST * whole.len()).max(LEAST);
        let (undamaged, read) = taken(&source, &options);
        assert!(read, "{name}");
        let mut random = ChaCha8Rng::seed_from_u64(whole.len() as u64);
        let (mut largest, mut accepted) = (0, 0);
        for k in 0..CUTS + FLIPS {
            let mut bytes = whole.clone();
            if k < CUTS {
                bytes.truncate(whole.len() * k / CUTS);
            } else {
                // headers and footers are small: a third of the flips each in the first and the last kilobyte
                let n = bytes.len();
                let near = 1024.min(n);
                for _ in 0..random.random_range(1..4) {
                    let at = match random.random_range(0..3) {
                        0 => random.random_range(0..near),
                        1 => n - 1 - random.random_range(0..near),
                        _ => random.random_range(0..n),
                    };
                    bytes[at] ^= 1 << random.random_range(0..8);
                }
            }
            std::fs::write(&path, &bytes).unwrap();
            let (peak, read) = taken(&path, &options);
            assert!(peak <= most, "{name}, version {k}: {peak} bytes taken, {most} accepted");
            largest = largest.max(peak);
            accepted += usize::from(read);
        }
        let n = whole.len();
        println!(
            "{name}: {n} bytes, undamaged {undamaged} taken, damaged at most {largest} ({:.1} of the file), {accepted} of {} read",
            largest as f64 / n as f64,
            CUTS + FLIPS
        );
    }
}
