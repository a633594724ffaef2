//! The form of a message.

/// A message for people is one line.
pub(crate) fn is_one_line(message: &str) {
    assert!(!message.is_empty() && !message.contains('\n'), "{message:?}");
}
