//! What tells an effect where no motion can.

use friction::effects::About;

/// Why no motion tells an effect, and what would; None where a motion can.
pub(crate) fn elsewhere(about: &About, unavailable: bool) -> Option<&'static str> {
    about.bench_test.filter(|_| unavailable || !about.shown_by_motion)
}
