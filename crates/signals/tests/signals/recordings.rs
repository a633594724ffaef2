//! Recordings in and out: what is accepted, what is refused and in which words, and that nothing panics.

use proptest::prelude::*;
use signals::{Error, FaultKind, Geometry, Map, ReadOptions, Recording, audit};
use std::fmt::Write;

fn csv(text: &str) -> Result<Recording, Error> {
    Recording::from_csv("rec.csv", text.as_bytes(), &ReadOptions::default())
}

fn mapped(text: &str, map: &str) -> Result<Recording, Error> {
    let map: Map = map.parse()?;
    Recording::from_csv("rec.csv", text.as_bytes(), &ReadOptions { map: Some(map), ..ReadOptions::default() })
}

/// The refusal, printed; it has to be one line and to hold every one of `parts`.
fn refused<T: std::fmt::Debug>(result: Result<T, Error>, parts: &[&str]) {
    let error = result.unwrap_err().to_string();
    println!("{error}");
    assert!(!error.contains('\n'));
    for part in parts {
        assert!(error.contains(part), "`{error}` does not say `{part}`");
    }
}

#[test]
fn a_slide_in_any_order_with_metadata() {
    let text = "\u{feff}# rig: thesis\r\n# sample_rate_hz = 1000\r\nforce_n,time_s,position_m,temperature_c\r\n\
                1.5,0,0.01,21\r\n# a remark\r\n\r\n-2.5e0, 0.001 ,0.011,22\r\n";
    let r = csv(text).unwrap();
    assert_eq!(r.geometry, Geometry::Linear);
    assert_eq!((r.time, r.position, r.force), (vec![0.0, 0.001], vec![0.01, 0.011], vec![1.5, -2.5]));
    assert_eq!(r.temperature, Some(vec![21.0, 22.0]));
    assert_eq!(r.velocity, None);
    assert_eq!(r.metadata["rig"], "thesis");
    assert_eq!(r.metadata["sample_rate_hz"], "1000");
    assert_eq!(r.metadata["comment"], "a remark");
}

#[test]
fn an_axis_and_other_delimiters() {
    let r = csv("time_s;position_rad;torque_nm;velocity_rad_s\n0;1;2;3\n").unwrap();
    assert_eq!((r.geometry, r.velocity), (Geometry::Rotary, Some(vec![3.0])));
    let r = csv("time_s\tposition_m\tforce_n\n0\t1\t2\n").unwrap();
    assert_eq!(r.force, [2.0]);
    let r = csv("time_s,\"position_m\",force_n,note\n0,1,2,\"a, b\"\n").unwrap();
    assert_eq!(r.position, [1.0]);
    assert_eq!(r.metadata["columns_not_used"], "note");
}

#[test]
fn units_decimal_signs_and_spaces() {
    let r = csv("time [ms];Position (mm);force;note\n;;N;-\n0;1,5;2;a\n500;-2,5e1;3;b\n").unwrap();
    assert_eq!((r.time, r.position, r.force), (vec![0.0, 0.5], vec![0.0015, -0.025], vec![2.0, 3.0]));
    assert_eq!(r.remarks, ["converted: time [ms] from ms to s, Position (mm) from mm to m"]);
    let r = csv("  time_s \"position_rad\"   torque_nm\n 0   1\t 2\n1 2 3 \n").unwrap();
    assert_eq!(r.force, [2.0, 3.0]);
    let r = csv("t;x;F\nms;mm;N\n0;1;2\n1;2;3\n");
    refused(r, &["rec.csv:1", "no column time_s", "t, x, F"]);
    let r = mapped("t;x;F\nms;mm;N\n0;1;2\n500;2;3\n", "time_s=t/1000,position_m=x/1000,force_n=F").unwrap();
    assert_eq!(
        (r.time, &*r.remarks[0]),
        (vec![0.0, 0.5], "the map computes with the numbers of the file: t in ms, x in mm")
    );

    refused(
        csv("time;position;force\ns;counts;N\n0;1;2\n"),
        &["rec.csv:1: column 2 (position)", "counts", "map"],
    );
    refused(
        csv("time;position;force\ns;parsec;N\n0;1;2\n"),
        &["column 2 (position)", "`parsec`", "accepted are s, ms"],
    );
    refused(
        csv("time_s;position_m;force_n\ns;mm;N\n0;1;2\n"),
        &["column 2 (position_m)", "in m by its name and in mm"],
    );
    refused(
        csv("time;position;force\ns;mm;Nm\n0;1;2\n"),
        &["column 3 (force)", "a slide or an axis, not both"],
    );
    let mixed = "time_s;position_m;force_n\n0;1,5;2\n1;1.5;2\n";
    refused(csv(mixed), &["rec.csv:3: column 2 (position_m)", "`1.5`", "another decimal sign than line 2"]);
    refused(csv("time_s;position_m;force_n\n0;1.000,5;2\n"), &["rec.csv:2: column 2", "not a number"]);
    refused(csv("time_s position_m force_n\n0 1\n"), &["rec.csv:2", "2 cells", "3"]);
}

#[test]
fn missing_values_are_kept_for_the_audit() {
    let mut text = String::from("time_s,position_m,force_n\n");
    for i in 0..100 {
        let force = ["1.0", "", "NaN", "inf"][if i > 50 && i < 54 { i - 50 } else { 0 }];
        let _ =
            writeln!(text, "{},{},{force}", f64::from(i as u32) * 1e-3, (0.1 * f64::from(i as u32)).sin());
    }
    let r = csv(&text).unwrap();
    assert!(r.force[51].is_nan() && r.force[52].is_nan() && r.force[53].is_infinite());
    let faults = audit(&r).faults;
    let fault = faults.iter().find(|f| f.kind == FaultKind::NotANumber).unwrap();
    println!("{}", fault.why);
    assert!((fault.at_s.unwrap() - 0.051).abs() < 1e-9);
}

#[test]
fn refusals_name_file_line_column_value_and_what_is_accepted() {
    let head = "# a\n\ntime_s,position_m,force_n\n0,0,0\n";
    refused(
        csv(&format!("{head}# b\n0.1,abc,2\n")),
        &["rec.csv:6: column 2 (position_m)", "`abc`", "accepted"],
    );
    refused(csv(&format!("{head}0.1,0,\"1,5\"\n")), &["rec.csv:5: column 3 (force_n)", "`1,5`", "point"]);
    refused(csv(&format!("{head}0.1,2\n")), &["rec.csv:5", "2 cells", "3"]);
    refused(csv(&format!("{head}0.1,2,3,4\n")), &["rec.csv:5", "4 cells"]);
    refused(
        csv("time_s,position_mm,force_n\n0,0,0\n"),
        &["rec.csv:1: column 2", "`position_mm`", "position_m or position_rad"],
    );
    refused(csv("time_ms,position_m,force_n\n0,0,0\n"), &["column 1", "`time_ms`", "accepted is time_s"]);
    refused(csv("time_s,position_m,force\n0,0,0\n"), &["column 3", "`force`", "accepted is force_n"]);
    refused(csv("time_s,positon_m,force_n\n0,0,0\n"), &["`positon_m`", "accepted is position_m"]);
    refused(csv("time_s,position_m,velocity_deg_s,force_n\n0,0,0,0\n"), &["velocity_m_s or velocity_rad_s"]);
    refused(csv("time_s,position_m,force_n,force_n\n0,0,0,0\n"), &["column 4 (force_n)", "twice"]);
    refused(csv("time_s,position_m,torque_nm\n0,0,0\n"), &["column 3 (torque_nm)", "position_m", "not both"]);
    refused(csv("time_s,position_m,velocity_rad_s,force_n\n0,0,0,0\n"), &["not both"]);
    refused(
        csv("time_s,position_m\n0,0\n"),
        &["rec.csv:1", "no column force_n or torque_nm", "time_s, position_m"],
    );
    refused(csv("position_m,force_n\n0,0\n"), &["no column time_s"]);
    refused(csv(""), &["rec.csv", "no header", "time_s,position_m,force_n"]);
    refused(csv("# only\n# remarks\n"), &["no header"]);
    refused(csv("time_s,position_m,force_n\n"), &["rec.csv:1", "no samples"]);
    refused(csv("0,1,2\n1,2,3\n"), &["rec.csv:1", "no header", "c1"]);
    let utf16 = Recording::from_csv("rec.csv", b"\xff\xfet\0i\0", &ReadOptions::default());
    refused(utf16, &["UTF-16", "UTF-8"]);
    refused(Recording::read("/nowhere/rec.csv", &ReadOptions::default()), &["/nowhere/rec.csv"]);
    refused(Recording::read("/", &ReadOptions::default()), &["/: "]);
}

#[test]
fn a_map_of_the_force_alone_was_refused_beside_columns_of_the_right_names() {
    let text = "time_s,position_rad,iq_a\n0,0.1,2\n0.5,0.2,4\n";
    let r = mapped(text, "torque_nm=0.5*iq_a").unwrap();
    assert_eq!((r.geometry, r.time, r.position), (Geometry::Rotary, vec![0.0, 0.5], vec![0.1, 0.2]));
    assert_eq!(r.force, [1.0, 2.0]);
    // what the map says comes first
    let r = mapped(text, "time_s=2*time_s,torque_nm=iq_a").unwrap();
    assert_eq!(r.time, [0.0, 1.0]);
    refused(mapped("t,position_rad,iq_a\n0,1,2\n1,2,3\n", "torque_nm=iq_a"), &["no time_s"]);
}

#[test]
fn maps_are_read_and_refused_with_the_column_of_the_text() {
    let text = "t,\"Force (N)\",x,k\n0,10,1,2\n500,20,3,2\n";
    let r = mapped(text, "time_s = t/1e3, position_m=-(x - 1)*2, force_n='Force (N)'*k+1").unwrap();
    assert_eq!((r.time, r.position, r.force), (vec![0.0, 0.5], vec![0.0, -4.0], vec![21.0, 41.0]));
    let r = mapped("1,2\n3,4\n", "time_s=index*0.5,position_rad=c1,torque_nm=c2/c1").unwrap();
    assert_eq!((r.geometry, r.time, r.force), (Geometry::Rotary, vec![0.0, 0.5], vec![2.0, 4.0 / 3.0]));

    refused(mapped(text, "time_s=t,position_m=y,force_n=k"), &["map, column 21", "`y`", "Force (N)"]);
    refused(mapped(text, "time_s=t,position_mm=x"), &["map, column 10", "`position_mm`", "position_m"]);
    refused(mapped(text, "time_s=t,position_m=x,torque_nm=k"), &["map, column 23", "position_m"]);
    refused(mapped(text, "time_s=t,time_s=t"), &["column 10", "twice"]);
    refused(mapped(text, "time_s=t,position_m=x"), &["force_n"]);
    refused(mapped(text, "time_s=t+"), &["column 10", "the text ends"]);
    refused(mapped(text, "time_s=(t"), &["column 10", "`)`"]);
    refused(mapped(text, "time_s t"), &["column 8", "`=`"]);
    refused(mapped(text, "time_s=t position_m=x"), &["column 10", "`p`", "`,`"]);
    refused(mapped(text, "time_s=1.2.3"), &["column 8", "1.2.3"]);
    refused(mapped(text, "time_s='t"), &["column 8", "quoted"]);
    refused(mapped(text, ""), &["column 1", "name"]);
    refused(mapped(text, &format!("time_s={}t", "(".repeat(10_000))), &["deep"]);
    refused(mapped(text, &format!("time_s={}t", "-".repeat(10_000))), &["deep"]);
    refused(mapped(text, &format!("time_s=t{}", "+t".repeat(10_000))), &["64 terms"]);
    refused(
        mapped("t,x,f\n0,a,0\n1,1,1\n", "time_s=t,position_m=x,force_n=f"),
        &["rec.csv:2: column 2 (x)", "`a`"],
    );
}

#[test]
fn matlab_files() {
    let dir = tempfile::tempdir().unwrap();
    for big in [false, true] {
        let mut file = header(big);
        file.extend(matrix(big, "t", &[3, 1], &[0.0, 0.1, 0.2]));
        file.extend(compressed(big, &matrix(big, "position", &[1, 3], &[1.0, 2.0, 3.0])));
        file.extend(matrix(big, "k", &[1, 1], &[10.0]));
        file.extend(matrix(big, "two", &[2, 1], &[1.0, 2.0]));
        let path = dir.path().join("rec.mat");
        std::fs::write(&path, &file).unwrap();
        let read = |map: &str| {
            Recording::read(&path, &ReadOptions { map: Some(map.parse()?), ..ReadOptions::default() })
        };
        let r = read("time_s=t,position_m=position,force_n=k*position").unwrap();
        assert_eq!(
            (r.time, r.position, r.force),
            (vec![0.0, 0.1, 0.2], vec![1.0, 2.0, 3.0], vec![10.0, 20.0, 30.0])
        );
        assert_eq!(r.name, "rec.mat");
        refused(
            Recording::read(&path, &ReadOptions::default()),
            &["rec.mat", "t (3x1 double)", "k (1x1 double)", "map"],
        );
        refused(read("time_s=t,position_m=two,force_n=k"), &["column 21", "`two` has 2", "`t` has 3"]);
        refused(read("time_s=k,position_m=k,force_n=k"), &["more than one element"]);
        refused(read("time_s=t,position_m=q,force_n=k"), &["`q`", "position (1x3 double)"]);
        std::fs::write(&path, &file[..file.len() - 20]).unwrap();
        refused(read("time_s=t,position_m=position,force_n=k"), &["rec.mat", "byte", "too early"]);
    }
    let path = dir.path().join("new.mat");
    std::fs::write(&path, b"MATLAB 7.3 MAT-file, and so on").unwrap();
    refused(Recording::read(&path, &ReadOptions::default()), &["new.mat", "not a MATLAB file", "save -v7"]);
    std::fs::write(&path, b"hello").unwrap();
    refused(Recording::read(&path, &ReadOptions::default()), &["new.mat", "not a MATLAB file"]);
}

#[test]
fn each_file_is_read_with_the_map_it_needs() {
    let dir = tempfile::tempdir().unwrap();
    let path = |name: &str| dir.path().join(name);
    let mut matlab = header(false);
    for (name, values) in [("t", [0.0, 0.1]), ("qm", [1.0, 2.0]), ("force_n", [5.0, 6.0])] {
        matlab.extend(matrix(false, name, &[2, 1], &values));
    }
    std::fs::write(path("rig.mat"), matlab).unwrap();
    std::fs::write(path("own.csv"), "time_s,position_m,force_n\n0,1,2\n1,2,3\n").unwrap();
    std::fs::write(path("bare.csv"), "0,1,2\n1,2,3\n").unwrap();
    let maps: Vec<Map> = ["time_s=t,position_m=qm,force_n=force_n", "time_s=c1,position_m=c2,force_n=2*c3"]
        .map(|m| m.parse().unwrap())
        .into();
    let read = |name: &str, maps: &[Map]| {
        let (r, used) = Recording::read_with_maps(path(name), maps, None)?;
        Ok::<_, Error>((r.force, maps.iter().position(|map| Some(map) == used)))
    };
    assert_eq!(read("rig.mat", &maps).unwrap(), (vec![5.0, 6.0], Some(0)));
    assert_eq!(read("own.csv", &maps).unwrap(), (vec![2.0, 3.0], None));
    assert_eq!(read("bare.csv", &maps).unwrap(), (vec![4.0, 6.0], Some(1)));
    // names of its own do not keep a map away that names only what the file has
    let doubled: [Map; 1] = ["time_s=time_s,position_m=position_m,force_n=2*force_n".parse().unwrap()];
    assert_eq!(read("own.csv", &doubled).unwrap(), (vec![4.0, 6.0], Some(0)));
    // the map that comes closest says what the file has not
    refused(
        read(
            "rig.mat",
            &["time_s=c1,position_m=c2,force_n=c3", "time_s=t,position_m=q,force_n=force_n"]
                .map(|m| m.parse().unwrap()),
        ),
        &["`q`", "qm (2x1 double)"],
    );
    refused(read("bare.csv", &[]), &["no header"]);
}

fn word(big: bool, value: u32) -> [u8; 4] {
    if big { value.to_be_bytes() } else { value.to_le_bytes() }
}

fn header(big: bool) -> Vec<u8> {
    let mut out = b"MATLAB 5.0 MAT-file, made by a test".to_vec();
    out.resize(124, b' ');
    out.extend(if big { [1, 0, b'M', b'I'] } else { [0, 1, b'I', b'M'] });
    out
}

fn element(big: bool, kind: u32, data: &[u8]) -> Vec<u8> {
    let mut out = [word(big, kind), word(big, data.len() as u32)].concat();
    out.extend(data);
    out.resize(out.len().next_multiple_of(8), 0);
    out
}

/// A real array of doubles.
fn matrix(big: bool, name: &str, size: &[u32], values: &[f64]) -> Vec<u8> {
    let mut inner = element(big, 6, &[word(big, 6), word(big, 0)].concat());
    inner.extend(element(big, 5, &size.iter().flat_map(|s| word(big, *s)).collect::<Vec<u8>>()));
    inner.extend(element(big, 1, name.as_bytes()));
    let bytes = |x: &f64| if big { x.to_be_bytes() } else { x.to_le_bytes() };
    inner.extend(element(big, 9, &values.iter().flat_map(bytes).collect::<Vec<u8>>()));
    element(big, 14, &inner)
}

fn compressed(big: bool, element: &[u8]) -> Vec<u8> {
    let packed = miniz_oxide::deflate::compress_to_vec_zlib(element, 6);
    [&word(big, 15)[..], &word(big, packed.len() as u32), &packed].concat()
}

fn any_column(n: usize) -> impl Strategy<Value = Vec<f64>> {
    prop::collection::vec(
        prop_oneof![8 => prop::num::f64::ANY, 1 => Just(f64::NAN), 1 => Just(f64::INFINITY)],
        n,
    )
}

pub(crate) fn any_recording() -> impl Strategy<Value = Recording> {
    (1usize..30).prop_flat_map(|n| {
        let optional = || prop::option::of(any_column(n));
        (
            (any_column(n), any_column(n), any_column(n), any::<bool>()),
            (optional(), optional(), optional(), optional(), optional(), optional()),
            prop::collection::btree_map("[a-z_]{1,9}", "[A-Za-z0-9.:=#,\"][ -~]{0,20}[a-z]", 0..4),
        )
            .prop_map(
                |((time, position, force, rotary), (v, a, normal_force, command, reference, t), metadata)| {
                    Recording {
                        name: "rec.csv".into(),
                        geometry: if rotary { Geometry::Rotary } else { Geometry::Linear },
                        time,
                        position,
                        force,
                        velocity: v,
                        acceleration: a,
                        normal_force,
                        command,
                        reference,
                        temperature: t,
                        metadata,
                        ..Recording::default()
                    }
                },
            )
    })
}

/// Equal bits; any NaN equals any other, a text has only one.
pub(crate) fn same(a: &Recording, b: &Recording) -> bool {
    let bits = |column: &[f64]| -> Vec<u64> {
        column.iter().map(|x| if x.is_nan() { f64::NAN.to_bits() } else { x.to_bits() }).collect()
    };
    let columns = |r: &Recording| -> Vec<(&str, Vec<u64>)> {
        r.columns().into_iter().map(|(name, column)| (name, bits(column))).collect()
    };
    let extra = |r: &Recording| -> Vec<(String, Vec<u64>)> {
        r.extra.iter().map(|(name, column)| (name.clone(), bits(column))).collect()
    };
    columns(a) == columns(b)
        && extra(a) == extra(b)
        && a.metadata == b.metadata
        && a.geometry == b.geometry
        && a.name == b.name
}

pub(crate) fn cases(cases: u32) -> ProptestConfig {
    ProptestConfig { cases, failure_persistence: None, ..ProptestConfig::default() }
}

proptest! {
    #![proptest_config(cases(256))]

    #[test]
    fn what_is_written_is_read(recording in any_recording()) {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("rec.csv");
        recording.write_csv(&path).unwrap();
        let back = Recording::read(&path, &ReadOptions::default()).unwrap();
        prop_assert!(same(&recording, &back), "{:?} became {:?}", recording, back);
        // Nothing that can be read makes the audit panic.
        let _ = audit(&back);
    }

    #[test]
    fn any_bytes_are_read_or_refused(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
        let _ = Recording::from_csv("x", &bytes, &ReadOptions::default());
    }

    #[test]
    fn any_table_is_read_or_refused(text in "(time_s|position_m|force_n|torque_nm|#|,|;|\t|\"|\n|\r\n|[0-9.e-]{1,4}|NaN|é){0,60}") {
        if let Err(e) = csv(&text) {
            prop_assert!(!e.to_string().contains('\n'), "{}", e);
        }
        let _ = mapped(&text, "time_s=c1,position_m=c2,force_n=c1*c2");
    }

    #[test]
    fn any_map_is_read_or_refused(text in "(time_s=|position_m|force_n|=|[-+*/()', ]|[a-z]{1,3}|[0-9.e]{1,4}|\\PC){0,30}") {
        if let Err(e) = text.parse::<Map>() {
            let line = e.to_string();
            prop_assert!(line.starts_with("map, column ") && !line.contains('\n'), "{}", line);
        }
    }

    /// A MATLAB file with bytes changed, left out or put in.
    #[test]
    fn any_matlab_file_is_read_or_refused(changes in prop::collection::vec((0usize..700, any::<u8>()), 0..6), cut in 0usize..700, big: bool) {
        let mut file = header(big);
        file.extend(matrix(big, "t", &[3, 1], &[0.0, 0.1, 0.2]));
        file.extend(compressed(big, &matrix(big, "x", &[1, 3], &[1.0, 2.0, 3.0])));
        file.extend(matrix(big, "k", &[1, 1], &[10.0]));
        for (at, byte) in changes {
            if let Some(place) = file.get_mut(at) {
                *place = byte;
            }
        }
        if cut % 3 == 0 {
            file.truncate(cut);
        }
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("x.mat");
        std::fs::write(&path, &file).unwrap();
        let map: Map = "time_s=t,position_m=x,force_n=k*x".parse().unwrap();
        let _ = Recording::read(&path, &ReadOptions { map: Some(map), ..ReadOptions::default() });
    }
}
