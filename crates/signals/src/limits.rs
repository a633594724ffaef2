//! How much a file may unpack to. A length that a damaged file states is checked against it before anything is allocated.

/// Fewest bytes that are granted, however small the file is.
const FLOOR: usize = 1 << 20;

/// Bytes that may be unpacked from a file of `bytes`: recordings that a deflater shrinks more than tenfold hold next to no motion.
pub(crate) fn unpacked(bytes: usize) -> usize {
    bytes.saturating_mul(10).max(FLOOR)
}

/// What is said of a file that states more.
pub(crate) fn too_much(what: &str, stated: impl std::fmt::Display, bytes: usize) -> String {
    let most = unpacked(bytes);
    format!(
        "{what} is said to take {stated} bytes unpacked; accepted from a file of {bytes} bytes are {most}: the file is damaged, or save it uncompressed"
    )
}
