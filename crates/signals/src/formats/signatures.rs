//! What kinds of files begin with, whether this program has a reader of them or not.

pub(crate) const HDF5: &[u8] = b"\x89HDF\r\n\x1a\n";
pub(crate) const MATLAB_5: &[u8] = b"MATLAB 5.0";
/// Also the end of the file.
pub(crate) const PARQUET: &[u8] = b"PAR1";
pub(crate) const MCAP: &[u8] = b"\x89MCAP0\r\n";
pub(crate) const SQLITE: &[u8] = b"SQLite format 3\0";
/// File that makes a folder a bag of ROS 2.
pub(crate) const BAG_METADATA: &str = "metadata.yaml";
