//! How much memory a file may ask for. What is unpacked grows with what is really there; where a library reserves what a length in
//! the file says, that length is checked first.

/// Least of [`stated`]: the page and the chunk of every usual writer are smaller, however small the file is.
#[cfg(any(feature = "hdf5", feature = "parquet"))]
const PIECE: usize = 2 << 20;

/// Least of [`total`].
const TOTAL: usize = 512 << 20;

/// Largest piece of a file of `bytes` whose size is believed before it is unpacked, bytes.
#[cfg(any(feature = "hdf5", feature = "parquet"))]
pub(crate) fn stated(bytes: usize) -> usize {
    bytes.saturating_mul(10).max(PIECE)
}

/// Bytes that a file of `bytes` may unpack to in all.
pub(crate) fn total(bytes: usize) -> usize {
    bytes.saturating_mul(10).max(TOTAL)
}

/// What is said of a file that goes beyond: `what` of it, the bytes that it takes, and those that are accepted.
pub(crate) fn too_much(what: &str, taken: impl std::fmt::Display, accepted: usize) -> String {
    format!(
        "{what} unpacks to {taken} bytes; accepted are {accepted}: the file is damaged, or save it uncompressed"
    )
}
