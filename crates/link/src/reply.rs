//! Format of an answer.
//!
//! One line, `ok …` or `err CODE: why`. A longer answer gives the number of lines that follow, `ok help, 31 lines:`, each
//! indented by two spaces.

/// Number of lines that follow this first line of an answer.
///
/// ```
/// assert_eq!(link::reply::lines_to_follow("ok help, 31 lines:"), 31);
/// assert_eq!(link::reply::lines_to_follow("ok dv 0.007 m/s"), 0);
/// ```
#[must_use]
pub fn lines_to_follow(first: &str) -> usize {
    let count = first.strip_suffix(" lines:").and_then(|head| head.rsplit(", ").next());
    count.and_then(|count| count.parse().ok()).unwrap_or(0)
}

/// Whether the line is the first line of an answer: it begins with `ok` or `err`.
#[must_use]
pub fn is_answer(line: &str) -> bool {
    matches!(line.split([' ', ',']).next(), Some("ok" | "err"))
}

/// Whether the line is an unsolicited message.
#[must_use]
pub fn is_news(line: &str) -> bool {
    line.starts_with('!')
}

/// Code and reason of an `err` answer.
///
/// ```
/// assert_eq!(link::reply::refusal("err RANGE: dv = 9"), Some(("RANGE", "dv = 9")));
/// assert_eq!(link::reply::refusal("ok"), None);
/// ```
#[must_use]
pub fn refusal(line: &str) -> Option<(&str, &str)> {
    line.strip_prefix("err ")?.split_once(": ")
}
