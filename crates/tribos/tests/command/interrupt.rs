//! A diagnosis that is interrupted leaves nothing half-written.

use std::fmt::Write;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

/// Some seconds' work: 60 s of a slide with a spring, at 1 kHz.
fn recording(path: &Path) {
    let mut text = String::from("time_s,position_m,force_n\n");
    for i in 0..60_000 {
        let t = f64::from(i) * 1e-3;
        let (s, c) = (9.0 * t).sin_cos();
        let (x, v, a) = (0.01 * s, 0.09 * c, -0.81 * s);
        let noise = 0.05 * (1e4 * t * t).sin();
        let _ =
            writeln!(text, "{t},{x},{}", 0.4 * a + 1.5 * v.signum() + 2.0 * v + 900.0 * x * x * x + noise);
    }
    std::fs::write(path, text).expect("a recording");
}

#[cfg(target_os = "linux")]
#[test]
fn an_interrupted_diagnosis_leaves_no_file_and_keeps_the_old_one() {
    use std::os::unix::process::ExitStatusExt;
    let dir = tempfile::tempdir().expect("a folder");
    let rec = dir.path().join("rec.csv");
    recording(&rec);
    std::fs::write(dir.path().join("found.json"), "old").expect("an old result");
    let mut interrupted = 0;
    for wait in [50, 200, 400, 800] {
        // a shell that runs this in the background sets the signal to be ignored, and children inherit that
        let mut child = Command::new("env")
            .current_dir(dir.path())
            .args([
                "--default-signal=INT",
                env!("CARGO_BIN_EXE_tribos"),
                "diagnose",
                "rec.csv",
                "--out",
                "model.toml",
                "--json",
                "found.json",
                "--report",
                "report.html",
            ])
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .expect("tribos");
        std::thread::sleep(Duration::from_millis(wait));
        let sent = Command::new("kill").args(["-INT", &child.id().to_string()]).status().expect("kill");
        let ended = child.wait().expect("an end");
        // on a machine this fast the work was done before
        if !sent.success() || ended.signal().is_none() && ended.success() {
            continue;
        }
        interrupted += 1;
        let mut there: Vec<String> = std::fs::read_dir(dir.path())
            .expect("the folder")
            .map(|e| e.expect("an entry").file_name().to_string_lossy().into_owned())
            .collect();
        there.sort();
        println!("interrupted after {wait} ms: {ended}, files {there:?}");
        assert_eq!(there, ["found.json", "rec.csv"]);
        assert_eq!(std::fs::read_to_string(dir.path().join("found.json")).expect("the old result"), "old");
    }
    assert!(interrupted > 0, "no run was interrupted");
}
