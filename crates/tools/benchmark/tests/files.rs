//! Folders without the official files, and files of another shape: one line with the path and what is expected there.

use benchmark::{Error, emps, silverbox};
use std::fs;

fn said(error: Error) -> String {
    let text = error.to_string();
    assert!(!text.contains('\n'), "{text}");
    text
}

#[test]
fn missing_files_are_named_with_their_source() {
    let dir = tempfile::tempdir().unwrap();
    let error = silverbox::read(dir.path()).unwrap_err();
    assert!(error.help().unwrap().contains("nonlinearbenchmark.org/benchmarks/silverbox"));
    let text = said(error);
    assert!(text.starts_with(&dir.path().display().to_string()) && text.contains("SNLS80mV"), "{text}");
    let text = said(emps::read(&dir.path().join("nowhere")).unwrap_err());
    assert!(text.ends_with("nowhere: no DATA_EMPS.mat"), "{text}");
}

#[test]
fn files_of_another_shape_are_refused() {
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("SNLS80mV.csv");
    for (contents, says) in [
        ("V1,V2\n0.1,0.2\n0.1,0.3\n0.2,0.1\n", "3 samples; expected are the 131072"),
        ("V1,V3\n0.1,0.2\n", "`V2`"),
        ("V1,V2\n0.1,0.2\n0.3,x\n", "`x`"),
        ("V1,V2\n0.1,0.2\n0.3,nan\n", "sample 1 of position_m is NaN"),
        ("", "SNLS80mV.csv"),
    ] {
        fs::write(&file, contents).unwrap();
        let text = said(silverbox::read(dir.path()).unwrap_err());
        assert!(text.contains(says) && text.contains("SNLS80mV.csv"), "{text}");
    }
    fs::write(dir.path().join("DATA_EMPS.mat"), b"not a file of MATLAB").unwrap();
    let text = said(emps::read(dir.path()).unwrap_err());
    assert!(text.contains("DATA_EMPS.mat: not a MATLAB file"), "{text}");
}

#[test]
fn official_text_file_is_read_from_the_folder_of_its_archive() {
    let dir = tempfile::tempdir().unwrap();
    let inside = dir.path().join("SilverboxFiles");
    fs::create_dir(&inside).unwrap();
    let mut text = String::from("V1,V2\n");
    for i in 0..silverbox::SAMPLES {
        text.push_str(if i % 2 == 0 { "0.1,0.02\n" } else { "-0.1,0.01\n" });
    }
    fs::write(inside.join("SNLS80mV.csv"), text).unwrap();
    let record = silverbox::read(dir.path()).unwrap();
    assert_eq!((record.len(), record.position[1]), (silverbox::SAMPLES, 0.01));
    assert!((record.drive.dt() - 1.0 / 610.35).abs() < 1e-15);
}
