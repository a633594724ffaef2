//! Progress bars for anything over a second; silent without a terminal.

use indicatif::{ProgressBar, ProgressStyle};
use std::time::Duration;

/// A bar from 0 to 1 on standard error, erased when dropped.
pub(crate) struct Progress(ProgressBar);

impl Progress {
    /// Shown on a terminal only.
    pub(crate) fn new(what: &str) -> Self {
        let bar = ProgressBar::new(1000);
        let style = ProgressStyle::with_template("  {msg:<34} {bar:30.cyan/dim} {percent:>3} %  {elapsed}")
            .unwrap_or_else(|_| ProgressStyle::default_bar());
        bar.set_style(style);
        bar.set_message(what.to_owned());
        bar.enable_steady_tick(Duration::from_millis(200));
        Self(bar)
    }

    /// Moves the bar to `share` with a message.
    pub(crate) fn set(&self, share: f32, what: &str) {
        self.0.set_position((1000.0 * share.clamp(0.0, 1.0)) as u64);
        if !what.is_empty() {
            self.0.set_message(what.to_owned());
        }
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}
