//! What the fuzzer begins with: small inputs that the readers accept.

use crate::device::{bodies, virtual_device};
use signals::Recording;
use std::path::Path;

/// A target's name, a file name, and an input.
pub type Seed = (&'static str, String, Vec<u8>);

/// A recording of a few samples, with every column.
fn recording(samples: u32) -> Recording {
    let of = |f: &dyn Fn(f64) -> f64| (0..samples).map(|k| f(1e-3 * f64::from(k))).collect::<Vec<_>>();
    Recording {
        time: of(&|t| t),
        position: of(&|t| 0.01 * (20.0 * t).sin()),
        force: of(&|t| (20.0 * t).cos().signum()),
        velocity: Some(of(&|t| 0.2 * (20.0 * t).cos())),
        temperature: Some(of(&|t| 20.0 + t)),
        extra: [("load".to_owned(), of(&|t| 3.0 - t))].into(),
        metadata: [("preset".to_owned(), "brass".to_owned())].into(),
        ..Recording::default()
    }
}

/// Bytes that a device sends.
fn said(lines: &str, ms: usize) -> Vec<u8> {
    let (mut device, mut said) = (virtual_device(), Vec::new());
    device.write(lines.as_bytes());
    for _ in 0..ms {
        device.tick();
        device.read(&mut said);
    }
    said
}

/// The first messages of a bag, on small pages.
fn small_bag(bag: &Path, small: &Path) -> rusqlite::Result<()> {
    let database = rusqlite::Connection::open(small)?;
    database.execute_batch("PRAGMA page_size = 512;")?;
    database.execute("ATTACH ?1 AS bag", [bag.display().to_string()])?;
    database.execute_batch(
        "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT, type TEXT, serialization_format TEXT);
         CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER, timestamp INTEGER, data BLOB);
         INSERT INTO topics SELECT id, name, type, serialization_format FROM bag.topics;
         INSERT INTO messages SELECT id, topic_id, timestamp, data FROM bag.messages WHERE id < 12;",
    )
}

const MESSAGES: [&str; 14] = [
    r#"{"do":"arm"}"#,
    r#"{"do":"hand","at":0.01}"#,
    r#"{"do":"use","name":"rubber"}"#,
    r#"{"do":"propose","id":3,"changes":[["f_static","3"],["law","lugre"],["cogging.wavelength","0.006"]]}"#,
    r#"{"do":"set","changes":[["mass","0.5"],["k_vc","8000"],["b_vc","20"]]}"#,
    r#"{"do":"move","wave":"sine","amplitude":0.01,"frequency":2.0,"seconds":5.0,"record":true}"#,
    r#"{"do":"diagnose","recordings":["rec-001.csv"]}"#,
    r#"{"do":"handover_record","by_hand":false}"#,
    r#"{"do":"handover_send"}"#,
    r#"{"do":"begin_targeting","subject":"s1","seed":1,"practice":false}"#,
    r#"{"do":"begin_choice","subject":"s1","seed":1,"batches":"[[batch]]\nname = \"a\"\nreference = { f_static = 2.0, f_dynamic = 2.0, damping = 1.0, mass = 0.2 }\nprocedure = { constant = { comparisons = [], rounds = 2 } }\n"}"#,
    "[[batch]]\nname = \"a\"\n[batch.procedure.adaptive]\nvaried = \"both\"\nrange_n = [0.1, 1.0]\ntrials = 60\nenough = 2.0\n",
    r#"{"do":"answer","answer":"a"}"#,
    r#"{"do":"ping","id":1.5}"#,
];

const CONSOLE: [&str; 14] = [
    "preset use rubber\nrender on\nset f_static 3\nget\nrender off\n",
    "preset save mine\npreset default mine\npreset list\npreset delete mine\n",
    "home\nstop\nzero\nmove multisine 0.01 0.8 2\nidentify\n",
    "device set geometry rotary stroke 2 resolution -0.000767 mass 1e-4 damping 1e-3 overspeed 60 force_max 0.2\n",
    "device\ndevice reset\nrate 2000\nrate\n",
    "calibrate load 0\ncalibrate load 4.905\ncalibrate save\ncalibrate status\ncalibrate discard\n",
    "watch 2 render\nlimit\nlimit heat 8\nstatus\nfault\nclear\n",
    "stream on 2\nversion\nstream off\n",
    "sim hand sine 0.008 0.5\nsim block rubber\nsim device stroke 0.03\nsim hand off\n",
    "set law lugre\nset sigma_0 1e5\nset renderer stopping_force\n",
    "set cogging.sine_1 1.5\nset cogging.wavelength 0.006\n",
    "selftest\noff\n",
    "move chirp 0.005 3\nmove triangle 0.005 1 1\nmove dwell 0.005 1\nmove sine nan 1\n",
    "sim help\nhelp\nset dv 1e999\nset mass -0\n",
];

/// All seeds.
///
/// # Panics
/// Files of the repository are not there.
#[must_use]
pub fn seeds() -> Vec<Seed> {
    let mut seeds: Vec<Seed> = Vec::new();
    let folder = tempfile::tempdir().expect("a folder for temporary files");
    for (target, suffix) in
        [("csv", "csv"), ("mat5", "mat"), ("hdf5", "h5"), ("parquet", "parquet"), ("mcap", "mcap")]
    {
        for samples in [3, 40] {
            let path = folder.path().join(format!("rec-{samples}.{suffix}"));
            recording(samples).write(&path).expect("a recording");
            seeds.push((target, format!("rec-{samples}"), std::fs::read(path).expect("a recording")));
        }
    }
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../..");
    let read = |path: &str| std::fs::read(root.join(path)).unwrap_or_else(|e| panic!("{path}: {e}"));
    let mut file = |target, path: &str, longest: usize| {
        let mut bytes = read(path);
        bytes.truncate(longest);
        let name = path.rsplit('/').next().unwrap_or(path).to_owned();
        seeds.push((target, name, bytes));
    };
    // text is as good when it is short; the rest is whole
    for name in ["decimal_comma.txt", "spaces.txt", "tabs.txt", "slider.csv"] {
        file("csv", &format!("crates/signals/tests/foreign/{name}"), 2_000);
    }
    for name in ["stage.csv", "seal_1bar.csv"] {
        file("csv", &format!("crates/tools/fixtures/recordings/{name}"), 2_000);
    }
    for (target, name) in [
        ("hdf5", "arm.h5"),
        ("hdf5", "degrees.h5"),
        ("hdf5", "arm_v73.mat"),
        ("parquet", "arm_snappy.parquet"),
        ("parquet", "arm_zstd.parquet"),
        ("parquet", "stamped.parquet"),
        ("mcap", "one_joint/one_joint.mcap"),
        ("mcap", "arm_mcap/arm_mcap.mcap"),
    ] {
        file(target, &format!("crates/signals/tests/foreign/{name}"), usize::MAX);
    }
    let small = folder.path().join("small.db3");
    small_bag(&root.join("crates/signals/tests/foreign/arm_sqlite/arm_sqlite.db3"), &small).expect("a bag");
    let small = std::fs::read(small).expect("a bag");
    for name in ["oscillator.mat", "positioner.mat"] {
        file("mat5", &format!("crates/tools/fixtures/recordings/{name}"), usize::MAX);
    }
    for target in ["model", "preset"] {
        for name in ["washboard", "wood-grain", "rubber-1", "ball-slide", "file", "volume-knob"] {
            file(target, &format!("presets/{name}.toml"), usize::MAX);
        }
    }
    let json = [
        r#"{"time_s":[0,0.001,0.002],"position_m":[0,1e-6,2e-6],"force_n":[1,1.5,-2],"torque":3}"#,
        r#"[{"t":0.1,"q":0.2,"tau":0.3},{"t":0.2,"q":0.3,"tau":null}]"#,
        r#"{"t":[0,1],"q":[[1,2],[3,4]],"tau":[[1,2],[3,4]],"samples":[{"t":1}]}"#,
    ];
    let mut text = |target, k: usize, bytes: &[u8]| seeds.push((target, format!("{k}"), bytes.to_vec()));
    for (k, json) in json.iter().enumerate() {
        text("json", k, json.as_bytes());
    }
    for (k, message) in MESSAGES.iter().enumerate() {
        text("page", k, message.as_bytes());
    }
    for (k, lines) in CONSOLE.iter().enumerate() {
        text("console", k, lines.as_bytes());
    }
    text("bag", 0, &small);
    text("frame", 0, &said("stream on\n", 30));
    text("frame", 1, &said("get\nstream on 2\nstatus\n", 30));
    text("frame", 2, &bodies(&said("stream on\n", 30)));
    let mut device = virtual_device();
    device.write(b"set f_static 3\npreset save mine\npreset default mine\n");
    for _ in 0..50 {
        device.tick();
    }
    text("flash", 0, device.power_off().contents());
    seeds
}
