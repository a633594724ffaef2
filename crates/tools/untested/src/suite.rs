//! A suite: its tests, what they need, and how they run.

use crate::{Need, capture, summary};
use libtest_mimic::{Arguments, Completion, Failed, Trial};
use std::fs;
use std::path::Path;
use std::process::ExitCode;
use std::sync::{Arc, Mutex, PoisonError};

/// One test.
#[derive(Debug, Clone)]
pub struct Test {
    name: String,
    run: fn(),
    needs: Vec<&'static Need>,
    on_demand: Option<&'static str>,
}

impl Test {
    /// A test by its path, as `stringify!` writes it.
    #[must_use]
    pub fn new(path: &str, run: fn()) -> Self {
        Self { name: path.replace(' ', ""), run, needs: Vec::new(), on_demand: None }
    }

    /// The first reason why it cannot run, and whether that is one in CI, too.
    fn missing(&self) -> Option<(&str, bool)> {
        self.needs.iter().find_map(|need| Some((need.missing()?, need.is_spared_in_ci())))
    }
}

/// A group of tests.
#[derive(Debug, Clone)]
pub struct Tests(Vec<Test>);

impl Tests {
    /// Tests that need nothing; see [`tests!`](crate::tests).
    #[must_use]
    pub fn new(tests: Vec<Test>) -> Self {
        Self(tests)
    }

    /// All of them need this.
    #[must_use]
    pub fn needing(mut self, need: &'static Need) -> Self {
        self.0.iter_mut().for_each(|test| test.needs.push(need));
        self
    }

    /// They run only with `--ignored` or `--include-ignored`, for this reason.
    #[must_use]
    pub fn on_demand(mut self, why: &'static str) -> Self {
        self.0.iter_mut().for_each(|test| test.on_demand = Some(why));
        self
    }
}

/// Where a suite is; see [`run!`](crate::run!).
#[derive(Debug, Clone, Copy)]
pub struct Place {
    /// Name of the package.
    pub package: &'static str,
    /// Name of the test target.
    pub suite: &'static str,
    /// Folder of the package.
    pub manifest: &'static str,
    /// Source file of the list, as `file!` gives it.
    pub file: &'static str,
    /// Folder for the tests' own files.
    pub scratch: &'static str,
}

/// `CI` is set: a test whose need is missing fails.
#[must_use]
pub fn strict() -> bool {
    std::env::var("CI").is_ok_and(|ci| !ci.is_empty() && ci != "false")
}

/// Runs a suite under the arguments of the command line.
#[must_use]
pub fn run<const GROUPS: usize>(place: &Place, groups: [Tests; GROUPS]) -> ExitCode {
    let args = Arguments::from_args();
    let unlisted = unlisted(place);
    if !unlisted.is_empty() {
        std::println!(
            "error: `#[test]` has no effect here; list the function in {}:\n{}",
            place.file,
            unlisted.join("\n")
        );
        return ExitCode::FAILURE;
    }
    let strict = strict();
    let (asked, captured) = (args.ignored || args.include_ignored, !args.nocapture);
    if captured {
        capture::take_panics();
    }
    let skipped = Arc::new(Mutex::new(Vec::new()));
    let tests = groups.into_iter().flat_map(|group| group.0);
    let trials = tests.map(|test| {
        let skipped = Arc::clone(&skipped);
        let (name, flagged) = (test.name.clone(), test.on_demand.is_some() && asked);
        let run = move || -> Result<Completion, Failed> {
            if let Some(why) = test.on_demand.filter(|_| !asked) {
                return Ok(Completion::ignored_with(why));
            }
            match test.missing() {
                Some((why, spared)) if strict && !spared => {
                    return Err(Failed::from(format!("{why}, and CI is set")));
                }
                Some((why, _)) => {
                    let mut skipped = skipped.lock().unwrap_or_else(PoisonError::into_inner);
                    skipped.push((test.name.clone(), why.to_owned()));
                    return Ok(Completion::ignored_with(why));
                }
                None => {}
            }
            let ended = if captured { capture::captured(test.run) } else { capture::shown(test.run) };
            ended.map(|()| Completion::Completed).map_err(Failed::from)
        };
        Trial::ignorable_test(name, run).with_ignored_flag(flagged)
    });
    let conclusion = libtest_mimic::run(&args, trials.collect());
    if !args.list {
        let skipped = skipped.lock().unwrap_or_else(PoisonError::into_inner);
        let name = format!("{} {}", place.package, place.suite);
        print!("{}", summary::lines(&[(name.clone(), skipped.clone())]));
        if let Err(why) = summary::leave(Path::new(place.scratch), &name, &skipped) {
            eprintln!("the summary of skipped tests misses {name}: {why}");
        }
    }
    conclusion.exit_code()
}

/// Functions of the suite's modules under the attribute of the standard harness, which would never run.
fn unlisted(place: &Place) -> Vec<String> {
    let list =
        Path::new(place.manifest).ancestors().map(|root| root.join(place.file)).find(|path| path.exists());
    // run from elsewhere than where it was built: the sources are not there to be read
    let Some(list) = list else { return Vec::new() };
    let text = fs::read_to_string(&list).unwrap_or_default();
    let modules = text.lines().filter_map(|line| line.strip_prefix("mod ")?.strip_suffix(';'));
    let files = modules.map(|module| list.with_file_name(module).with_extension("rs"));
    let mut found = Vec::new();
    for path in files.chain([list.clone()]) {
        let text = fs::read_to_string(&path).unwrap_or_default();
        let lines = text.lines().enumerate().filter(|(_, line)| line.trim() == "#[test]");
        found.extend(lines.map(|(k, _)| format!("{}:{}", path.display(), k + 1)));
    }
    found
}
