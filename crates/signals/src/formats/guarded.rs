//! Calls into a library that panics on bytes it does not expect.

use std::any::Any;
use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind, set_hook, take_hook};
use std::sync::Once;

thread_local! {
    static GUARDED: Cell<bool> = const { Cell::new(false) };
}

/// What `call` returns.
///
/// # Errors
/// What it says when it panics; nothing is printed then. What it has written to is not used any more.
pub(crate) fn guarded<T>(call: impl FnOnce() -> T) -> Result<T, String> {
    static HOOK: Once = Once::new();
    HOOK.call_once(|| {
        let before = take_hook();
        set_hook(Box::new(move |panic| {
            if !GUARDED.get() {
                before(panic);
            }
        }));
    });
    let outer = GUARDED.replace(true);
    let result = catch_unwind(AssertUnwindSafe(call));
    GUARDED.set(outer);
    result.map_err(|said| text(&*said).lines().next().unwrap_or_default().to_owned())
}

fn text(said: &(dyn Any + Send)) -> &str {
    said.downcast_ref::<String>()
        .map(String::as_str)
        .or(said.downcast_ref::<&str>().copied())
        .unwrap_or("panic")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_is_an_error_of_one_line_and_the_next_one_is_a_panic() {
        assert_eq!(guarded(|| 3), Ok(3));
        let list = [1.0];
        let beyond = std::hint::black_box(7);
        let why = guarded(|| list[beyond]).unwrap_err();
        assert!(why.contains("index out of bounds"), "{why}");
        assert_eq!(guarded(|| -> () { panic!("two\nlines") }), Err("two".into()));
        assert!(!GUARDED.get());
        assert!(catch_unwind(|| list[beyond]).is_err());
    }
}
