//! Files that other software wrote (`tests/foreign/make.py`: rosbags, pyarrow, h5py), compared value by value with the CSV that it wrote
//! of the same numbers.

use signals::{Map, ReadOptions, Recording};
use std::path::{Path, PathBuf};

fn path(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/foreign").join(name)
}

fn read(name: &str, joint: Option<&str>, map: Option<&str>) -> Result<Recording, String> {
    let map: Option<Map> = map.map(|text| text.parse().unwrap());
    let options = ReadOptions { map, joint: joint.map(str::to_owned) };
    Recording::read(path(name), &options).map_err(|e| e.to_string())
}

/// Columns, each equal within `tolerance` of its largest value.
fn same(recording: &Recording, reference: &str, tolerance: f64) {
    let reference = read(reference, None, None).unwrap();
    assert_eq!(recording.len(), 240);
    assert_eq!(recording.geometry, reference.geometry);
    for ((name, values), (wanted_name, wanted)) in recording.columns().into_iter().zip(reference.columns()) {
        assert_eq!(name, wanted_name);
        let size = wanted.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        for (i, (value, wanted)) in values.iter().zip(wanted).enumerate() {
            assert!((value - wanted).abs() <= tolerance * size, "{name}[{i}]: {value}, not {wanted}");
        }
    }
    assert_eq!(recording.columns().len(), reference.columns().len());
}

#[test]
fn bags_of_both_kinds_equal_the_csv() {
    for bag in ["arm_sqlite", "arm_mcap", "arm_sqlite/arm_sqlite.db3", "arm_mcap/arm_mcap.mcap"] {
        for joint in ["j1", "j2"] {
            let recording = read(bag, Some(joint), None).unwrap();
            same(&recording, &format!("{joint}.csv"), 0.0);
            assert_eq!(recording.metadata["time_zero_ns"], "1790000000123456789");
            // the other joints of the same messages are coordinates
            assert_eq!(recording.extra["slider.position"].len(), 240);
        }
        same(&read(bag, Some("slider"), Some("force_n=effort")).unwrap(), "slider.csv", 0.0);
        same(&read(bag, Some("/joint_states:j2"), None).unwrap(), "j2.csv", 0.0);
    }
    // the only joint needs no name
    same(&read("one_joint", None, None).unwrap(), "j2.csv", 0.0);
}

#[test]
fn a_force_of_another_clock_is_interpolated_where_both_are() {
    for bag in ["arm_sqlite", "arm_mcap"] {
        let recording = read(bag, Some("slider"), Some("force_n=/ft:force.z/2")).unwrap();
        let reference = read("slider.csv", None, None).unwrap();
        // the sensor runs from 30 ms to 1.028 s: samples outside are left out, not continued
        let inside: Vec<usize> =
            (0..reference.len()).filter(|&i| (0.03..=1.028).contains(&reference.time[i])).collect();
        assert_eq!(recording.len(), inside.len());
        for (k, &i) in inside.iter().enumerate() {
            assert_eq!(recording.time[k], reference.time[i]);
            assert_eq!(recording.position[k], reference.position[i]);
            // make.py: the sensor's force is 2 N + 3 N/s t
            let force = (2.0 + 3.0 * reference.time[i]) / 2.0;
            assert!((recording.force[k] - force).abs() < 1e-9, "{} at {k}, not {force}", recording.force[k]);
        }
        assert!(
            recording
                .remarks
                .iter()
                .any(|r| r.contains("/ft: interpolated linearly at the stamps of /joint_states")
                    && r.contains(&format!("overlap in {} of its 240", inside.len()))),
            "{:?}",
            recording.remarks
        );
    }
}

#[test]
fn parquet_equals_the_csv() {
    for file in ["arm_snappy.parquet", "arm_zstd.parquet"] {
        for joint in ["j1", "j2"] {
            let recording = read(file, Some(joint), None).unwrap();
            same(&recording, &format!("{joint}.csv"), 0.0);
            assert_eq!(recording.metadata["rig"], "arm");
            assert_eq!(recording.extra["sample"][239], 239.0);
        }
        same(&read(file, Some("j1"), Some("time_s=time_s,position_rad=position_rad,velocity_rad_s=velocity_rad_s,torque_nm=j1_torque_nm")).unwrap(), "j1.csv", 0.0);
    }
    let stamped = read("stamped.parquet", None, None).unwrap();
    same(&stamped, "j1.csv", 0.0);
    assert_eq!(stamped.metadata["time_zero_ns"], "1790000000123456789");
}

#[test]
fn hdf5_equals_the_csv() {
    for joint in ["j1", "j2"] {
        let recording = read("arm.h5", Some(joint), None).unwrap();
        same(&recording, &format!("{joint}.csv"), 0.0);
        assert_eq!((&*recording.metadata["rig"], &*recording.metadata["mass_kg"]), ("arm", "1.5"));
    }
    for (joint, reference) in [("1", "j1.csv"), ("2", "j2.csv")] {
        let recording = read("degrees.h5", Some(joint), None).unwrap();
        // to degrees and back
        same(&recording, reference, 1e-15);
        assert!(recording.remarks[0].contains("from deg to rad"), "{:?}", recording.remarks);
        assert!(recording.remarks[1].contains("counted from 1"), "{:?}", recording.remarks);
    }
}

#[test]
fn matlab_7_3_equals_the_csv() {
    let map = "time_s=t,position_rad=q,velocity_rad_s='rig.qd',torque_nm=tau*gear/100";
    for (joint, reference) in [("1", "j1.csv"), ("2", "j2.csv")] {
        same(&read("arm_v73.mat", Some(joint), Some(map)).unwrap(), reference, 1e-15);
    }
    let said = read("arm_v73.mat", None, None).unwrap_err();
    assert!(
        said.contains("q (240x2 double)") && said.contains("note (1x3 char)") && said.contains("map"),
        "{said}"
    );
}

#[test]
fn text_equals_the_csv() {
    let recording = read("decimal_comma.txt", None, None).unwrap();
    same(&recording, "slider.csv", 1e-15);
    assert_eq!(recording.remarks, ["converted: time from ms to s, position from mm to m"]);
    let recording = read("spaces.txt", None, None).unwrap();
    same(&recording, "j1.csv", 0.0);
    assert_eq!(recording.remarks, [""; 0]);
    for joint in ["1", "2"] {
        same(&read("tabs.txt", Some(joint), None).unwrap(), &format!("j{joint}.csv"), 0.0);
    }
}

#[test]
fn refusals_name_what_is_there() {
    let says = |name, joint, map, parts: &[&str]| {
        let said = read(name, joint, map).unwrap_err();
        assert!(parts.iter().all(|part| said.contains(part)) && !said.contains('\n'), "{name}: {said}");
    };
    let several = ["several joints; accepted is --joint with one of j1, slider, j2"];
    says("arm_sqlite", None, None, &several);
    says("arm_mcap/arm_mcap.mcap", None, None, &several);
    says("arm_mcap", Some("j3"), None, &["no joint `j3`; accepted is --joint with one of j1, slider, j2"]);
    let has = "/ft:{force.x,force.y,force.z,torque.x,torque.y,torque.z} (500 messages), /chatter (std_msgs/msg/String)";
    says("arm_sqlite", Some("slider"), Some("force_n=/ft:force.w"), &["map, column 9", "`/ft:force.w`", has]);
    says("one_joint", None, Some("force_n=/ft:force.z"), &["`/ft:force.z`", "/joint_states:j2."]);
    for (file, joints) in
        [("arm_zstd.parquet", "j1, j2"), ("arm.h5", "j1, j2"), ("degrees.h5", "1, 2"), ("tabs.txt", "1, 2")]
    {
        says(file, None, None, &["several joints", &format!("--joint with one of {joints}")]);
        says(file, Some("9"), None, &["no joint `9`", &format!("--joint with one of {joints}")]);
    }
    says("j1.csv", Some("j1"), None, &["no joint `j1`: no column has a joint's label"]);
}

#[test]
fn a_bag_with_endless_rows_hung() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("endless.db3");
    let database = rusqlite::Connection::open(&path).unwrap();
    database
        .execute_batch(
            "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT, type TEXT, serialization_format TEXT);
             INSERT INTO topics VALUES (1, '/joint_states', 'sensor_msgs/msg/JointState', 'cdr');
             CREATE VIEW messages AS WITH RECURSIVE c(n) AS (SELECT 1 UNION ALL SELECT n + 1 FROM c)
                 SELECT n AS id, 2 AS topic_id, n AS timestamp, x'00' AS data FROM c;",
        )
        .unwrap();
    drop(database);
    let said = Recording::read(&path, &ReadOptions::default()).unwrap_err().to_string();
    assert!(said.contains("takes more work than tables of "), "{said}");
}

#[test]
fn a_bag_named_files_outside_its_folder() {
    let dir = tempfile::tempdir().unwrap();
    let whole = std::fs::canonicalize(path("arm_sqlite/arm_sqlite.db3")).unwrap();
    for name in ["../arm.db3", "/etc/passwd", whole.to_str().unwrap()] {
        std::fs::write(dir.path().join("metadata.yaml"), format!("relative_file_paths:\n  - {name}\n"))
            .unwrap();
        let said = Recording::read(dir.path(), &ReadOptions::default()).unwrap_err().to_string();
        assert!(said.contains(&format!("`{name}` is outside the bag")), "{said}");
    }
}
