//! What the suites of one run of `cargo test` have skipped.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;
use std::{fs, io};

/// Folder of the suites' notes.
const FOLDER: &str = "untested";

/// A skipped test and the reason.
pub type Skipped = (String, String);

/// The process that runs the suites, one after the other.
fn run() -> String {
    #[cfg(unix)]
    return std::os::unix::process::parent_id().to_string();
    #[cfg(not(unix))]
    return String::new();
}

/// Leaves what a suite has skipped where [`collect`] finds it.
///
/// # Errors
/// When the note cannot be written.
pub fn leave(scratch: &Path, suite: &str, skipped: &[Skipped]) -> io::Result<()> {
    let folder = scratch.join(FOLDER);
    fs::create_dir_all(&folder)?;
    let mut note = format!("{}\n{suite}\n", run());
    for (test, why) in skipped {
        let _ = writeln!(note, "{test}\t{why}");
    }
    fs::write(folder.join(suite.replace(' ', "-")), note)
}

/// What the suites of this run have skipped, by suite.
#[must_use]
pub fn collect(scratch: &Path) -> Vec<(String, Vec<Skipped>)> {
    let notes = fs::read_dir(scratch.join(FOLDER)).into_iter().flatten().flatten();
    let mut suites: Vec<_> = notes
        .filter_map(|note| {
            let text = fs::read_to_string(note.path()).ok()?;
            let mut lines = text.lines();
            let (of, suite) = (lines.next()?, lines.next()?);
            let tests = lines.filter_map(|line| line.split_once('\t'));
            let skipped = tests.map(|(test, why)| (test.to_owned(), why.to_owned())).collect();
            (of == run()).then(|| (suite.to_owned(), skipped))
        })
        .collect();
    suites.sort();
    suites
}

/// One line for each reason, naming each test.
#[must_use]
pub fn lines(suites: &[(String, Vec<Skipped>)]) -> String {
    let mut reasons: BTreeMap<&str, Vec<String>> = BTreeMap::new();
    for (suite, skipped) in suites {
        for (test, why) in skipped {
            reasons.entry(why).or_default().push(format!("{suite} {test}"));
        }
    }
    reasons.iter().fold(String::new(), |mut lines, (why, tests)| {
        let _ = writeln!(lines, "NOT TESTED ({}), {why}: {}", tests.len(), tests.join(", "));
        lines
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_summary_names_each_skipped_test_and_why() {
        let scratch = tempfile::tempdir().expect("a folder");
        let skipped = |names: &[(&str, &str)]| -> Vec<Skipped> {
            names.iter().map(|(test, why)| ((*test).to_owned(), (*why).to_owned())).collect()
        };
        leave(scratch.path(), "tribos lab", &skipped(&[("scope::live", "no browser")])).expect("written");
        leave(
            scratch.path(),
            "board elf",
            &skipped(&[("safety::off", "no compiler"), ("agreement::on", "no compiler")]),
        )
        .expect("written");
        leave(scratch.path(), "identify recorded", &[]).expect("written");
        let told = lines(&collect(scratch.path()));
        let expected = "NOT TESTED (1), no browser: tribos lab scope::live\n\
                        NOT TESTED (2), no compiler: board elf safety::off, board elf agreement::on\n";
        let sorted = |text: &str| {
            let mut lines: Vec<_> = text.lines().map(str::to_owned).collect();
            lines.sort();
            lines
        };
        assert_eq!(sorted(&told), sorted(expected));
        // another run's notes are not this one's
        fs::write(scratch.path().join(FOLDER).join("tribos-lab"), "0\ntribos lab\nscope::live\tno browser\n")
            .expect("written");
        assert!(!lines(&collect(scratch.path())).contains("browser"));
    }
}
