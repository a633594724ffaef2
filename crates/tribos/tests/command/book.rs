//! The book: every command in it is run, every page is listed, every link leads somewhere.
//! After a wanted change of output: `TRYCMD=overwrite cargo test -p tribos --test command book`, then read the diff.

use std::fs;
use std::path::{Path, PathBuf};

fn docs() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs")
}

/// Markdown files of a folder, by name.
fn pages(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display()));
    let mut pages: Vec<PathBuf> = entries
        .map(|entry| entry.expect("an entry").path())
        .filter(|path| path.extension().is_some_and(|e| e == "md"))
        .collect();
    pages.sort();
    pages
}

/// Targets of the links in a Markdown text, without those to the network and without anchors.
fn links(text: &str) -> Vec<&str> {
    let targets = text.split("](").skip(1).filter_map(|rest| rest.split(')').next());
    targets
        .filter(|target| !target.starts_with("http") && !target.starts_with('#'))
        .map(|target| target.split('#').next().unwrap_or(target))
        .collect()
}

/// Each chapter runs in a folder of its own, beside the recordings that the book speaks of.
#[test]
fn every_command_of_the_book_runs() {
    let recordings = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tools/fixtures/recordings");
    let work = tempfile::tempdir().expect("a folder");
    let cases = trycmd::TestCases::new();
    let chapters = pages(&docs().join("book"));
    let mut commands = 0;
    for chapter in &chapters {
        let copy = work.path().join(chapter.file_name().expect("a name"));
        let text = fs::read_to_string(chapter).expect("a chapter");
        commands += text.lines().filter(|line| line.starts_with("$ ")).count();
        fs::write(&copy, text).expect("a copy");
        let sandbox = copy.with_extension("in");
        fs::create_dir(&sandbox).expect("a sandbox");
        for entry in fs::read_dir(&recordings).expect("the recordings") {
            let path = entry.expect("an entry").path();
            fs::copy(&path, sandbox.join(path.file_name().expect("a name"))).expect("a recording");
        }
        cases.case(&copy);
    }
    assert!(commands > 40, "{commands} commands: chapters are not read");
    cases.run();
    if std::env::var_os("TRYCMD").is_some_and(|mode| mode == "overwrite") {
        for chapter in &chapters {
            fs::copy(work.path().join(chapter.file_name().expect("a name")), chapter).expect("a chapter");
        }
    }
}

#[test]
fn every_page_is_in_the_summary() {
    let summary = fs::read_to_string(docs().join("SUMMARY.md")).expect("the summary");
    let listed: Vec<PathBuf> = links(&summary).iter().map(|target| docs().join(target)).collect();
    let there = [pages(&docs()), pages(&docs().join("book"))].concat();
    for page in there.iter().filter(|page| !page.ends_with("SUMMARY.md")) {
        assert!(listed.contains(page), "{} is not in docs/SUMMARY.md", page.display());
    }
}

#[test]
fn every_link_leads_to_a_file() {
    for page in [pages(&docs()), pages(&docs().join("book"))].concat() {
        let text = fs::read_to_string(&page).expect("a page");
        for target in links(&text) {
            let path = page.parent().expect("a folder").join(target);
            assert!(path.exists(), "{}: no {target}", page.display());
            // the book is made of docs/ alone: what lies outside would be a dead link in it
            let inside =
                path.canonicalize().expect("a path").starts_with(docs().canonicalize().expect("docs"));
            assert!(inside, "{}: {target} is outside docs/", page.display());
        }
    }
}

#[test]
fn every_subcommand_is_in_the_reference() {
    let help = std::process::Command::new(env!("CARGO_BIN_EXE_tribos")).arg("--help").output().expect("help");
    let reference = fs::read_to_string(docs().join("book/commands.md")).expect("the reference");
    let help = String::from_utf8(help.stdout).expect("text");
    let list = help.split("Commands:").nth(1).expect("commands").split("Options:").next().expect("options");
    let names: Vec<&str> = list
        .lines()
        .filter_map(|line| {
            line.strip_prefix("  ")?.split_whitespace().next().filter(|_| !line.starts_with("   "))
        })
        .collect();
    assert!(names.len() > 15, "{names:?}");
    for name in names {
        assert!(
            reference.contains(&format!("$ tribos {name} --help")),
            "`{name}` is not in docs/book/commands.md"
        );
    }
}
