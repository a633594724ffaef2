//! Recordings from MATLAB v5 files.
use crate::{Error, Map, Recording};
pub(crate) fn read(file: &str, _bytes: &[u8], _map: Option<&Map>) -> Result<Recording, Error> {
    Err(Error::File { file: file.into(), why: "MATLAB files are not read yet".into() })
}
