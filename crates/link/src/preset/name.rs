//! Names of presets.

use heapless::String;

/// Name of a preset: 1 to 24 of `a-z`, `0-9`, `_`, `-`.
pub type Name = String<24>;
/// Number of presets a user can save.
pub const MAX_SAVED: usize = 8;

/// A [`Name`] that is `Copy`.
pub(super) type ShortName = ([u8; 24], u8);

pub(super) fn short(name: &str) -> Option<ShortName> {
    let good = |b: u8| matches!(b, b'a'..=b'z' | b'0'..=b'9' | b'_' | b'-');
    let mut bytes = [0; 24];
    bytes.get_mut(..name.len())?.copy_from_slice(name.as_bytes());
    (!name.is_empty() && name.bytes().all(good)).then_some((bytes, name.len() as u8))
}

pub(super) fn long((bytes, length): &ShortName) -> &str {
    bytes.get(..usize::from(*length)).and_then(|bytes| core::str::from_utf8(bytes).ok()).unwrap_or("")
}
