//! What the repository says and asks of effects: the page of the catalogue, and that nobody asks for an id. Not part of the
//! published crate.

use friction::Geometry::{Linear, Rotary};
use friction::effects::{About, CATALOGUE, Parameter, Seat};
use std::fmt::Write;
use std::path::{Path, PathBuf};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// Set to rewrite the page.
const ACCEPT: &str = "TRIBOS_ACCEPT";

fn seat(seat: Seat) -> String {
    match seat {
        Seat::Unknown => "a place that a recording does not tell".into(),
        Seat::Contact => "the contact".into(),
        Seat::Body => "the body".into(),
        Seat::Drive => "the drive".into(),
        Seat::Channel(quantity) => format!("the {} channel", format!("{quantity:?}").to_lowercase()),
    }
}

fn number(x: f64) -> String {
    let plain = x == 0.0 || (1e-2..1e3).contains(&x.abs());
    if plain { x.to_string() } else { format!("{x:e}") }
}

fn sentence(text: &str) -> String {
    let mut letters = text.trim_end_matches('.').chars();
    letters.next().map_or_else(String::new, |first| format!("{}{}", first.to_uppercase(), letters.as_str()))
}

fn table(out: &mut String, parameters: &[&Parameter]) {
    out.push_str(
        "\n| parameter | slide | axis | from | to | what |\n| --- | --- | --- | --- | --- | --- |\n",
    );
    for p in parameters {
        let (slide, axis) = (p.unit(Linear), p.unit(Rotary));
        let (min, max) = (number(p.min), number(p.max));
        let _ = writeln!(out, "| `{}` | {slide} | {axis} | {min} | {max} | {} |", p.name, p.what);
    }
}

fn section(out: &mut String, about: &About) {
    let _ = write!(out, "\n## {}\n\n{}.\n\n    {}\n\n", about.id, sentence(about.says), about.equation);
    let _ = writeln!(out, "- Sits in {}.", seat(about.seat));
    let _ = writeln!(out, "- Shows: {}.", about.shows);
    for (what, text) in [("Confused with", about.confused_with), ("Told apart by", about.told_apart_by)] {
        if !text.is_empty() {
            let _ = writeln!(out, "- {what}: {text}.");
        }
    }
    if let Some((geometry, otherwise)) = about.only {
        let _ = writeln!(
            out,
            "- Only where the machine is {}: {otherwise}.",
            format!("{geometry:?}").to_lowercase()
        );
    }
    if let Some(twin) = about.twin {
        let _ = writeln!(out, "- No motion tells it from {}: {}.", twin.of.join(", "), twin.because);
    }
    if let Some(other) = about.case_of {
        let _ = writeln!(out, "- A diagnosis names `{other}`, of which it is a case.");
    }
    if let Some(axis) = about.several_by {
        let (id, by) = (about.id, about.shape[axis].name);
        let _ = writeln!(
            out,
            "- A machine may have several, each with a `{by}` of its own: `{id}`, `{id}_2` and so on."
        );
    }
    if let Some(test) = about.bench_test {
        let _ = writeln!(out, "- Shown without a move: {test}.");
    }
    let parameters: Vec<&Parameter> = about.parameters().collect();
    if !parameters.is_empty() {
        table(out, &parameters);
    }
    if let Some(comparison) = about.comparison {
        let _ = writeln!(
            out,
            "\nBetween channels: {}. {}.",
            comparison.equation,
            sentence(comparison.confirmed_by)
        );
        table(out, &comparison.parameters.iter().collect::<Vec<_>>());
    }
}

fn page() -> String {
    let mut out = String::from(
        "# Effects\n\nWritten from the descriptions in `crates/friction/src/effects/` by `TRIBOS_ACCEPT=1 cargo test -p friction \
         --test repository`;\na change here is lost. x is the position, v the velocity, s the sign of v, F_a the applied \
         force, N the normal load.\nNumbers in brackets are cosines between two signatures on a simulated slide, the \
         baseline projected out.\n\n| effect | in one sentence | sits in |\n| --- | --- | --- |\n",
    );
    for about in CATALOGUE {
        let _ =
            writeln!(out, "| [{0}](#{0}) | {1} | {2} |", about.id, sentence(about.says), seat(about.seat));
    }
    for about in CATALOGUE {
        section(&mut out, about);
    }
    out
}

#[test]
fn the_page_of_effects_is_current() {
    let path = root().join("docs/effects.md");
    let page = page();
    if std::env::var_os(ACCEPT).is_some() {
        std::fs::write(&path, &page).expect("docs/effects.md is written");
    }
    let there = std::fs::read_to_string(&path).unwrap_or_default();
    let line = there.lines().zip(page.lines()).position(|(a, b)| a != b).map_or(0, |at| at + 1);
    assert!(
        there == page,
        "docs/effects.md is stale from line {line}: run `{ACCEPT}=1 cargo test -p friction --test repository`"
    );
}

fn sources(folder: &Path, out: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).expect("a folder").map(|e| e.expect("an entry").path()) {
        let name = entry.file_name().unwrap_or_default().to_string_lossy().into_owned();
        if entry.is_dir() {
            // the sealed plant asks on purpose, and tests and examples may
            if !["target", "tests", "benches", "examples", "prove"].contains(&name.as_str()) {
                sources(&entry, out);
            }
        } else if name.ends_with(".rs") && name != "tests.rs" && !name.starts_with("prove") {
            out.push(entry);
        }
    }
}

#[test]
fn nobody_else_asks_for_an_id() {
    let mut files = Vec::new();
    sources(&root().join("src"), &mut files);
    for crate_folder in std::fs::read_dir(root().join("crates")).expect("crates") {
        let folder = crate_folder.expect("an entry").path();
        if folder.file_name().is_none_or(|name| name != "friction") {
            sources(&folder, &mut files);
        }
    }
    assert!(files.len() > 100, "{} files", files.len());
    let mut asked = Vec::new();
    for path in &files {
        let text = std::fs::read_to_string(path).expect("a source");
        // tests stand at the end of a file
        let code = text.split("#[cfg(test)]").next().unwrap_or_default();
        for (at, line) in code.lines().enumerate() {
            let code = line.split("//").next().unwrap_or_default();
            if let Some(about) = CATALOGUE.iter().find(|about| code.contains(&format!("\"{}\"", about.id))) {
                asked.push(format!("{}:{}: {}", path.display(), at + 1, about.id));
            }
        }
    }
    assert!(asked.is_empty(), "asked for by id: {asked:#?}");
}
