//! What is known of an effect to hide before it is drawn.

/// An effect to hide.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Kind {
    /// Catalogue id.
    pub id: &'static str,
    /// Other answers that are right: one class with it, or what its recording is a case of.
    pub also: &'static [&'static str],
    /// Coordinates over which its residual shows.
    pub shows_over: &'static [&'static str],
    /// A size to start from, and the largest that is still this effect.
    pub size: (f64, f64),
    /// Only an axis has it.
    pub rotary: bool,
    /// No motion of one body on a level slide, seen by its own sensors, tells it from the baseline: the right answer is to
    /// say so.
    pub never: bool,
}
