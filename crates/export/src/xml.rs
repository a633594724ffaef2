//! What the formats share: names, and the comment that says what is dropped.

use crate::reduce::Exported;

/// A name that every format takes.
pub(crate) fn name(name: &str) -> String {
    let clean: String =
        name.chars().map(|c| if c.is_ascii_alphanumeric() || c == '_' { c } else { '_' }).collect();
    if clean.is_empty() { "body".into() } else { clean }
}

/// What is dropped, as an XML comment.
pub(crate) fn comment(name: &str, exported: &Exported) -> String {
    let mut out = format!("<!-- {name}, written by tribos {}. Not held here:\n", env!("CARGO_PKG_VERSION"));
    for line in exported.lines() {
        // two hyphens would end the comment
        out += &format!("     {}\n", line.replace("--", "- -"));
    }
    out + "-->\n"
}
