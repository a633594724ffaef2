//! Crates depend downward, files do not circle. `--nocapture` prints the crates with their lines of code.

use architecture::{Package, circles, imports, packages};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// Every crate of the workspace, lowest first: one may depend only on those before it, with its tests as without.
const LAYERS: &[&str] = &[
    // what every test may use
    "untested",
    // what device and host share
    "friction",
    "haptics",
    "link",
    // models, recordings, and what is computed from them
    "plant",
    "fixtures",
    "signals",
    "identify",
    "export",
    "diagnose",
    "perception",
    "compare",
    "report",
    // the device, and how the host sees it
    "emulator",
    "tribos-firmware",
    "client",
    "design",
    "procedures",
    "tribos-web",
    "tribos-lab",
    // what proves, and what people type
    "hostile",
    "benchmark",
    "figures",
    "prove",
    "tribos-python",
    "tribos",
    "architecture",
];

/// Tests that still depend on a crate above them; empty when `emulator run` is tried from a crate above both.
const KNOWN_UPWARD: &[&str] = &["emulator depends in its tests on tribos, which is above it"];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../..")
}

fn workspace() -> Vec<Package> {
    packages(&root()).expect("manifests")
}

#[test]
fn crates_depend_downward_only() {
    let place = |name: &str| LAYERS.iter().position(|layer| *layer == name);
    let mut wrong = Vec::new();
    for package in &workspace() {
        let Some(own) = place(&package.name) else {
            wrong.push(format!("{}: not in the list of layers", package.name));
            continue;
        };
        for (dependencies, how) in
            [(&package.dependencies, "depends"), (&package.dev_dependencies, "depends in its tests")]
        {
            for dependency in dependencies.iter().filter(|d| place(d).is_none_or(|place| place >= own)) {
                wrong.push(format!("{} {how} on {dependency}, which is above it", package.name));
            }
        }
    }
    let names: BTreeSet<String> = workspace().into_iter().map(|p| p.name).collect();
    wrong.extend(LAYERS.iter().filter(|l| !names.contains(**l)).map(|l| format!("{l}: no such crate")));
    let new: Vec<&String> = wrong.iter().filter(|line| !KNOWN_UPWARD.contains(&line.as_str())).collect();
    let gone: Vec<_> = KNOWN_UPWARD.iter().filter(|known| !wrong.iter().any(|line| line == *known)).collect();
    assert!(new.is_empty(), "{new:#?}");
    assert!(gone.is_empty(), "gone, so take them off KNOWN_UPWARD: {gone:?}");
}

#[test]
fn files_do_not_circle() {
    let mut found = Vec::new();
    for package in workspace() {
        let graph = imports(&package.folder.join("src")).expect("readable");
        assert!(!graph.is_empty(), "{}: no source", package.name);
        for circle in circles(&graph) {
            let line = circle.iter().map(String::as_str).collect::<Vec<_>>().join(" ");
            let of_these = |from: &String| {
                let to = graph[from].intersection(&circle).cloned().collect::<Vec<_>>().join(" ");
                format!("    {from} → {to}")
            };
            let edges = circle.iter().map(of_these).collect::<Vec<_>>().join("\n");
            found.push(format!("{}: {line}\n{edges}", package.name));
        }
    }
    assert!(found.is_empty(), "files that import each other:\n{}", found.join("\n"));
}

#[test]
fn every_crate_has_lines_of_code() {
    let mut packages = workspace();
    packages.sort_by_key(|p| LAYERS.iter().position(|layer| *layer == p.name));
    println!("{:<16} {:>6} {:>6}  depends on [in its tests on]", "crate", "code", "tests");
    let (mut code, mut tests) = (0, 0);
    for package in &packages {
        let lines = package.lines().expect("readable");
        let list = |names: &BTreeSet<String>| names.iter().map(String::as_str).collect::<Vec<_>>().join(" ");
        let dev = match list(&package.dev_dependencies) {
            dev if dev.is_empty() => dev,
            dev => format!(" [{dev}]"),
        };
        println!(
            "{:<16} {:>6} {:>6}  {}{dev}",
            package.name,
            lines.code,
            lines.tests,
            list(&package.dependencies)
        );
        assert!(lines.code > 0, "{}: no code", package.name);
        (code, tests) = (code + lines.code, tests + lines.tests);
    }
    println!("{:<16} {code:>6} {tests:>6}", "");
}
