//! What a test prints, kept until it is known whether it passes.

use std::any::Any;
use std::cell::RefCell;
use std::fmt::{Arguments, Write};
use std::panic::{self, AssertUnwindSafe};

thread_local! {
    /// Output of the test that this thread runs.
    static OUTPUT: RefCell<Option<String>> = const { RefCell::new(None) };
}

/// Prints, or keeps while a captured test runs on this thread.
pub fn print(text: Arguments<'_>) {
    let kept = OUTPUT.with_borrow_mut(|output| output.as_mut().map(|output| output.write_fmt(text)));
    if kept.is_none() {
        std::print!("{text}");
    }
}

/// From now on a panic of a captured test is part of its output.
pub fn take_panics() {
    let standard = panic::take_hook();
    panic::set_hook(Box::new(move |info| {
        // a panic while the output is being written shows by itself
        let kept = OUTPUT.try_with(|output| {
            let mut output = output.try_borrow_mut().ok()?;
            writeln!(output.as_mut()?, "{info}").ok()
        });
        if !matches!(kept, Ok(Some(()))) {
            standard(info);
        }
    }));
}

/// Runs a test with its output captured; what it printed when it panics.
pub fn captured(test: fn()) -> Result<(), String> {
    OUTPUT.set(Some(String::new()));
    let ended = panic::catch_unwind(AssertUnwindSafe(test));
    let output = OUTPUT.take().unwrap_or_default();
    ended.map_err(|_| output)
}

/// Runs a test that prints as it goes.
pub fn shown(test: fn()) -> Result<(), String> {
    panic::catch_unwind(test).map_err(|why: Box<dyn Any + Send>| {
        let text = why.downcast_ref::<String>().map(String::as_str).or_else(|| why.downcast_ref().copied());
        text.unwrap_or("panicked").to_owned()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failing_test_shows_what_it_printed() {
        take_panics();
        let failed = captured(|| {
            print(format_args!("measured {}\n", 42));
            assert_eq!(1 + 1, 3, "sum");
        });
        let output = failed.expect_err("it panicked");
        assert!(output.starts_with("measured 42\n") && output.contains("sum"), "{output}");
        assert_eq!(captured(|| print(format_args!("quiet\n"))), Ok(()));
    }
}
