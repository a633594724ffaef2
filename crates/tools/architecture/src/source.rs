//! A file of Rust, as far as its imports need it.

use std::collections::{BTreeMap, BTreeSet};
use std::io;
use std::path::{Path, PathBuf};

/// Every `.rs` file below a folder, sorted; none where the folder is not there.
pub(crate) fn files(folder: &Path) -> io::Result<Vec<PathBuf>> {
    let mut out = Vec::new();
    if !folder.is_dir() {
        return Ok(out);
    }
    for entry in std::fs::read_dir(folder)? {
        let path = entry?.path();
        if path.is_dir() {
            out.extend(files(&path)?);
        } else if path.extension().is_some_and(|e| e == "rs") {
            out.push(path);
        }
    }
    out.sort();
    Ok(out)
}

/// Lines that are neither blank nor comment.
pub(crate) fn lines(text: &str) -> usize {
    text.lines().map(str::trim).filter(|line| !line.is_empty() && !line.starts_with("//")).count()
}

/// The text with comments, strings and characters blanked out; what is left has its place.
fn bare(text: &str) -> String {
    let bytes = text.as_bytes();
    let mut out = bytes.to_vec();
    let mut blank = |range: std::ops::Range<usize>| {
        for b in &mut out[range] {
            if *b != b'\n' {
                *b = b' ';
            }
        }
    };
    let mut i = 0;
    while i < bytes.len() {
        let rest = &bytes[i..];
        let end = if rest.starts_with(b"//") {
            i + rest.iter().position(|b| *b == b'\n').unwrap_or(rest.len())
        } else if rest.starts_with(b"/*") {
            i + block_comment(rest)
        } else if let Some(hashes) = raw_string(rest).filter(|_| i == 0 || !is_word(bytes[i - 1])) {
            let close = [b"\"".to_vec(), vec![b'#'; hashes]].concat();
            let from = i + 1 + hashes + 1;
            from + find(&bytes[from..], &close).map_or(bytes.len() - from, |k| k + close.len())
        } else if rest[0] == b'"' {
            i + quoted(rest)
        } else if rest[0] == b'\'' {
            i + character(rest)
        } else {
            i += 1;
            continue;
        };
        // a single quote of a lifetime stays
        if end > i + 1 {
            blank(i..end);
        }
        i = end.max(i + 1);
    }
    String::from_utf8_lossy(&out).into_owned()
}

fn is_word(b: u8) -> bool {
    b.is_ascii_alphanumeric() || b == b'_'
}

fn find(text: &[u8], what: &[u8]) -> Option<usize> {
    text.windows(what.len()).position(|w| w == what)
}

/// Length of a block comment; they nest.
fn block_comment(text: &[u8]) -> usize {
    let (mut depth, mut i) = (0_usize, 0);
    while i < text.len() {
        if text[i..].starts_with(b"/*") {
            (depth, i) = (depth + 1, i + 2);
        } else if text[i..].starts_with(b"*/") {
            (depth, i) = (depth - 1, i + 2);
            if depth == 0 {
                return i;
            }
        } else {
            i += 1;
        }
    }
    i
}

/// Number of `#` of a raw string that begins here.
fn raw_string(text: &[u8]) -> Option<usize> {
    let hashes = text.strip_prefix(b"r")?.iter().take_while(|b| **b == b'#').count();
    (text.get(1 + hashes) == Some(&b'"')).then_some(hashes)
}

/// Length of a string with its quotes.
fn quoted(text: &[u8]) -> usize {
    let mut i = 1;
    while i < text.len() && text[i] != b'"' {
        i += 1 + usize::from(text[i] == b'\\');
    }
    (i + 1).min(text.len())
}

/// Length of a character with its quotes; 1 for the quote of a lifetime.
fn character(text: &[u8]) -> usize {
    if text.get(1) == Some(&b'\\') {
        // the escaped character may be a quote itself
        return find(&text[3.min(text.len())..], b"'").map_or(1, |k| 3 + k + 1);
    }
    let Ok(head) = std::str::from_utf8(&text[1..text.len().min(6)])
        .or_else(|e| std::str::from_utf8(&text[1..1 + e.valid_up_to()]))
    else {
        return 1;
    };
    let Some(c) = head.chars().next() else { return 1 };
    if text.get(1 + c.len_utf8()) == Some(&b'\'') { 2 + c.len_utf8() } else { 1 }
}

/// The text without comments, strings, and everything that only tests compile.
pub(crate) fn without_tests(text: &str) -> String {
    const MARK: &str = "#[cfg(test)]";
    let mut text = bare(text);
    while let Some(at) = text.find(MARK) {
        let body = at + MARK.len();
        let bytes = text.as_bytes();
        // the item ends with its block, or with a semicolon before one begins
        let (mut depth, mut end) = (0_usize, bytes.len());
        for (k, b) in bytes.iter().enumerate().skip(body) {
            match b {
                b'{' => depth += 1,
                b'}' => {
                    depth = depth.saturating_sub(1);
                    if depth == 0 {
                        end = k + 1;
                        break;
                    }
                }
                b';' if depth == 0 => {
                    end = k + 1;
                    break;
                }
                _ => {}
            }
        }
        let blanked: String = text[at..end].chars().map(|c| if c == '\n' { '\n' } else { ' ' }).collect();
        text.replace_range(at..end, &blanked);
    }
    text
}

/// A path as it is written, and whether the name is only passed on.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Use {
    /// Its segments; the last is `*` for everything, `self` for the module.
    pub path: Vec<String>,
    /// The name it has here.
    pub name: String,
    /// `pub use`.
    pub public: bool,
}

/// What a file says.
#[derive(Debug, Clone, Default)]
pub(crate) struct Source {
    /// `use` lines, one path each.
    pub uses: Vec<Use>,
    /// Paths in the code that begin with `crate`, `super`, `self` or a module declared here.
    pub paths: BTreeSet<Vec<String>>,
    /// Items defined here.
    pub items: BTreeSet<String>,
    /// Modules declared here that are not tests.
    pub modules: BTreeSet<String>,
}

/// Words and punctuation; `::` is one.
fn tokens(text: &str) -> Vec<&str> {
    let bytes = text.as_bytes();
    let (mut out, mut i) = (Vec::new(), 0);
    while i < bytes.len() {
        let from = i;
        if is_word(bytes[i]) {
            while i < bytes.len() && is_word(bytes[i]) {
                i += 1;
            }
        } else if bytes[i..].starts_with(b"::") {
            i += 2;
        } else if bytes[i].is_ascii() {
            i += 1;
            if bytes[from].is_ascii_whitespace() {
                continue;
            }
        } else {
            i += text[i..].chars().next().map_or(1, char::len_utf8);
        }
        out.push(&text[from..i]);
    }
    out
}

/// The paths of a use tree that begins at `tokens[*at]`.
fn tree(tokens: &[&str], at: &mut usize, before: &[String], public: bool, out: &mut Vec<Use>) {
    let mut path = before.to_vec();
    let mut name = None;
    while let Some(&token) = tokens.get(*at) {
        match token {
            "{" => {
                *at += 1;
                while tokens.get(*at).is_some_and(|t| !matches!(*t, "}" | ";")) {
                    tree(tokens, at, &path, public, out);
                    *at += usize::from(tokens.get(*at) == Some(&","));
                }
                *at += usize::from(tokens.get(*at) == Some(&"}"));
                return;
            }
            "," | "}" | ";" => break,
            "::" => {}
            "as" => {
                *at += 1;
                name = tokens.get(*at).map(|t| (*t).to_owned());
            }
            word => path.push(word.to_owned()),
        }
        *at += 1;
    }
    if path.len() > before.len() {
        let own = match path.last().map(String::as_str) {
            Some("self") => path.iter().rev().nth(1).cloned(),
            last => last.map(str::to_owned),
        };
        out.push(Use { name: name.or(own).unwrap_or_default(), path, public });
    }
}

impl Source {
    /// Reads a file's text.
    pub(crate) fn read(text: &str) -> Self {
        let text = without_tests(text);
        let tokens = tokens(&text);
        let mut source = Self::default();
        for pair in tokens.windows(3) {
            if pair[0] == "mod" && pair[2] == ";" {
                source.modules.insert(pair[1].to_owned());
            }
            if matches!(
                pair[0],
                "struct"
                    | "enum"
                    | "union"
                    | "trait"
                    | "type"
                    | "fn"
                    | "const"
                    | "static"
                    | "macro_rules"
                    | "mut"
            ) {
                let name = if pair[1] == "!" { pair[2] } else { pair[1] };
                source.items.insert(name.to_owned());
            }
        }
        let mut at = 0;
        while at < tokens.len() {
            // `use<'a>` captures, it does not import
            if tokens[at] == "use" && tokens.get(at + 1) != Some(&"<") {
                let before = &tokens[at.saturating_sub(4)..at];
                // `pub use`, `pub(crate) use`, `pub(super) use`
                let public = before.last() == Some(&"pub")
                    || (before.last() == Some(&")")
                        && before.get(before.len().wrapping_sub(4)) == Some(&"pub"));
                at += 1;
                tree(&tokens, &mut at, &[], public, &mut source.uses);
            } else if let Some(length) = source.path_at(&tokens, at) {
                let words = tokens[at..at + length].iter().step_by(2).map(|t| (*t).to_owned());
                source.paths.insert(words.collect());
                at += length;
            } else {
                at += 1;
            }
        }
        source
    }

    /// Tokens of the path that begins here with a module of this crate.
    fn path_at(&self, tokens: &[&str], at: usize) -> Option<usize> {
        let begins = matches!(tokens[at], "crate" | "super" | "self") || self.modules.contains(tokens[at]);
        let goes_on = |k: usize| {
            tokens.get(k) == Some(&"::")
                && tokens.get(k + 1).is_some_and(|t| t.bytes().next().is_some_and(is_word))
        };
        if !begins || !goes_on(at + 1) || (at > 0 && matches!(tokens[at - 1], "::" | ".")) {
            return None;
        }
        let mut length = 1;
        while goes_on(at + length) {
            length += 2;
        }
        Some(length)
    }

    /// The paths a name of this file may stand for: by its import, or out of a glob.
    pub(crate) fn aliases(&self, name: &str) -> (Option<&Use>, BTreeMap<usize, &Use>) {
        let named = self.uses.iter().find(|u| u.name == name && u.path.last().is_some_and(|l| l != "*"));
        let globs = self.uses.iter().enumerate().filter(|(_, u)| u.path.last().is_some_and(|l| l == "*"));
        (named, globs.collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comments_strings_and_tests_hold_no_imports() {
        let text = r##"
//! use crate::doc;
use crate::a::{b, c::{self, D as E}, f::*};
/* use crate::gone; /* nested */ */
pub(crate) use super::g;
const S: &str = "use crate::string;";
const R: &str = r#"use crate::raw; " "#;
const C: char = '"';
fn f<'a>(x: &'a str) { crate::h::i(x); j::k() }
mod j;
#[cfg(test)]
mod tests { use crate::test; }
"##;
        let source = Source::read(text);
        let uses: Vec<String> = source.uses.iter().map(|u| u.path.join("::")).collect();
        assert_eq!(
            uses,
            ["crate::a::b", "crate::a::c::self", "crate::a::c::D", "crate::a::f::*", "super::g"]
        );
        assert_eq!(source.uses[1].name, "c");
        assert_eq!(source.uses[2].name, "E");
        assert!(source.uses[4].public && !source.uses[0].public);
        let paths: Vec<String> = source.paths.iter().map(|p| p.join("::")).collect();
        assert_eq!(paths, ["crate::h::i", "j::k"]);
        assert!(source.items.contains("S") && source.items.contains("f") && source.modules.contains("j"));
    }

    #[test]
    fn code_and_tests_are_counted_apart() {
        let text = "fn a() {}\n\n// b\n#[cfg(test)]\nmod tests {\n    fn c() {}\n}\n";
        assert_eq!((lines(text), lines(&without_tests(text))), (5, 1));
    }
}
