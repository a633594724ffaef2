//! File formats: recognised by content, then by the suffix of the name. The one place that decides.
//!
//! A reader makes named arrays of a file (`variables`) or series with clocks of their own (`topics`). Their names say what they are
//! (`naming`, `units`, `columns`), or a map does (`expression`).

mod axis;
#[cfg(feature = "ros2")]
mod bag;
#[cfg(feature = "ros2")]
mod cdr;
mod columns;
mod csv;
mod expression;
#[cfg(feature = "parquet")]
mod guarded;
#[cfg(feature = "hdf5")]
mod hdf5;
mod json;
mod limits;
mod matlab;
#[cfg(feature = "ros2")]
mod mcap;
mod naming;
#[cfg(feature = "parquet")]
mod parquet;
mod signatures;
mod stored;
#[cfg(feature = "parquet")]
mod thrift;
#[cfg(feature = "ros2")]
mod topics;
mod units;
mod variables;

pub(crate) use axis::Axis;
pub use expression::Map;

use crate::{Error, Recording, files};
use std::borrow::Cow;
use std::cell::Cell;
use std::io::Read;
use std::path::Path;
use variables::Wanted;

/// A kind of file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Format {
    Text,
    Json,
    /// MATLAB 5 to 7.
    Matlab,
    /// HDF5, and MATLAB 7.3.
    Hdf5,
    Parquet,
    Mcap,
    /// A bag's file.
    Sqlite,
    /// A bag's folder.
    Folder,
}

/// Suffixes of the files that can be written, for messages.
pub const WRITTEN: [&str; 5] = ["csv", "mat", "mcap", "parquet", "h5"];

/// Bytes from the beginning that decide.
const HEAD: usize = 8192;

/// How to read a file.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ReadOptions {
    /// What the columns are, for a file that does not use the names of this crate.
    pub map: Option<Map>,
    /// Which joint, of a file that has several: the label in the names of its columns, its name in a log, or its column of an array,
    /// from 1.
    pub joint: Option<String>,
}

/// What `read` makes of a file with the map that it needs, and that map.
fn with_needed_map<'m>(
    maps: &'m [Map],
    joint: Option<&str>,
    read: impl FnOnce(&Wanted) -> Result<Recording, Error>,
) -> Result<(Recording, Option<&'m Map>), Error> {
    let used = Cell::new(None);
    let map = |has: &dyn Fn(&str) -> bool| {
        used.set(Map::needed(maps, has));
        used.get()
    };
    let recording = read(&Wanted { map: &map, joint })?;
    Ok((recording, used.get()))
}

impl Recording {
    /// Reads a recording: text, JSON, MATLAB 5 to 7.3, HDF5, Parquet, MCAP, or a bag of ROS 2. What a file begins with decides on its
    /// kind, then the suffix of its name.
    ///
    /// # Errors
    /// Names the file, the line and the column or the topic, what was found and what would be accepted.
    pub fn read(path: impl AsRef<Path>, options: &ReadOptions) -> Result<Self, Error> {
        let map = |_: &dyn Fn(&str) -> bool| options.map.as_ref();
        read(path.as_ref(), &Wanted { map: &map, joint: options.joint.as_deref() })
    }

    /// Reads a recording with the map that its file needs: the first whose variables it all has, or none where its columns have
    /// the names of this crate. Returns that map, too.
    ///
    /// # Errors
    /// As [`Recording::read`], with the map that misses the fewest variables.
    pub fn read_with_maps<'m>(
        path: impl AsRef<Path>,
        maps: &'m [Map],
        joint: Option<&str>,
    ) -> Result<(Self, Option<&'m Map>), Error> {
        with_needed_map(maps, joint, |wanted| read(path.as_ref(), wanted))
    }

    /// As [`Recording::read`], of a file in memory; `name` is the file's. MCAP and bags are read from a disk only.
    ///
    /// # Errors
    /// As [`Recording::read`].
    pub fn from_bytes(name: &str, bytes: &[u8], options: &ReadOptions) -> Result<Self, Error> {
        let map = |_: &dyn Fn(&str) -> bool| options.map.as_ref();
        in_memory(name, bytes, &Wanted { map: &map, joint: options.joint.as_deref() })
    }

    /// As [`Recording::read_with_maps`], of a file in memory.
    ///
    /// # Errors
    /// As [`Recording::from_bytes`].
    pub fn from_bytes_with_maps<'m>(
        name: &str,
        bytes: &[u8],
        maps: &'m [Map],
        joint: Option<&str>,
    ) -> Result<(Self, Option<&'m Map>), Error> {
        with_needed_map(maps, joint, |wanted| in_memory(name, bytes, wanted))
    }

    /// Reads one axis of a recording in the plane.
    pub(crate) fn read_axis(path: &Path, axis: &Axis) -> Result<Self, Error> {
        read_any(path, &Wanted { map: &|has| axis.map(has), joint: None })
    }

    /// As [`Recording::read_axis`], of a file in memory.
    pub(crate) fn axis_from_bytes(name: &str, bytes: &[u8], axis: &Axis) -> Result<Self, Error> {
        any_in_memory(name, bytes, &Wanted { map: &|has| axis.map(has), joint: None })
    }

    /// Reads the text of a CSV file; `name` stands for the file in messages.
    ///
    /// # Errors
    /// As [`Recording::read`].
    pub fn from_csv(name: &str, text: &[u8], options: &ReadOptions) -> Result<Self, Error> {
        let map = |_: &dyn Fn(&str) -> bool| options.map.as_ref();
        let wanted = Wanted { map: &map, joint: options.joint.as_deref() };
        on_a_line(name, &wanted, |wanted| Ok(Self { name: name.into(), ..csv::read(name, text, wanted)? }))
    }

    /// A recording of columns by name, as from a data frame; `name` stands for them in messages. Without a map, columns of other
    /// names are kept as [`Recording::extra`].
    ///
    /// ```
    /// use signals::Recording;
    /// let columns = [("time_s", [0.0, 1e-3]), ("position_m", [0.0, 1e-6]), ("force_n", [1.0, 1.1])];
    /// let columns = columns.map(|(name, values)| (name.to_owned(), values.to_vec()));
    /// let recording = Recording::from_columns("frame", columns.to_vec(), &[])?;
    /// assert_eq!(recording.force, [1.0, 1.1]);
    /// # Ok::<(), signals::Error>(())
    /// ```
    ///
    /// # Errors
    /// The column that is missing, given twice, of another length, or not what the map needs.
    pub fn from_columns(name: &str, columns: Vec<(String, Vec<f64>)>, maps: &[Map]) -> Result<Self, Error> {
        let wanted = Wanted { map: &|has| Map::needed(maps, has), joint: None };
        let read = |wanted: &Wanted| variables::of_columns(name, columns, wanted);
        Ok(Self { name: name.into(), ..on_a_line(name, &wanted, read)? })
    }

    /// Writes a file of the kind that its name says ([`crate::WRITTEN`]), completely or not at all: [`Recording::read`] gives back equal
    /// columns, bit for bit. Returns a remark on what the kind cannot hold.
    ///
    /// # Errors
    /// Columns of unequal length, a suffix of another kind, or a file that cannot be written.
    pub fn write(&self, path: impl AsRef<Path>) -> Result<Option<String>, Error> {
        let path = path.as_ref();
        let (bytes, remark) = written(path, self)?;
        files::write(path, &bytes).map_err(|e| {
            let (file, text) = (path.display().to_string(), e.to_string());
            let why = text.strip_prefix(&format!("{file}: ")).unwrap_or(&text).to_owned();
            Error::File { file, why }
        })?;
        Ok(remark)
    }

    /// Writes CSV: [`Recording::read`] gives back equal columns, bit for bit.
    ///
    /// # Errors
    /// Columns of unequal length, or a file that cannot be written.
    pub fn write_csv(&self, path: impl AsRef<Path>) -> Result<(), Error> {
        let path = path.as_ref();
        let text = self.to_csv()?;
        std::fs::write(path, text)
            .map_err(|e| Error::File { file: path.display().to_string(), why: files::reason(&e) })
    }

    /// The text of [`Recording::write_csv`].
    ///
    /// # Errors
    /// Columns of unequal length.
    pub fn to_csv(&self) -> Result<String, Error> {
        csv::write(self)
    }
}

/// The kind of a file that begins with `head`.
fn recognised(path: &Path, head: &[u8]) -> Result<Format, String> {
    let suffix = suffix(path);
    // HDF5 may begin behind a block of the user's: 512 bytes, 1024, …
    let hdf5 = std::iter::once(0)
        .chain((9..13).map(|n| 1 << n))
        .any(|at| head.get(at..).is_some_and(|b| b.starts_with(signatures::HDF5)));
    let by_content = [
        (hdf5, Format::Hdf5),
        (head.starts_with(signatures::MATLAB_5), Format::Matlab),
        (head.starts_with(signatures::PARQUET), Format::Parquet),
        (head.starts_with(signatures::MCAP), Format::Mcap),
        (head.starts_with(signatures::SQLITE), Format::Sqlite),
    ];
    if let Some((_, format)) = by_content.iter().find(|(is, _)| *is) {
        return Ok(*format);
    }
    let not_read = [
        (&b"#ROSBAG V"[..], "a bag of ROS 1; accepted is one of ROS 2: `rosbags-convert --src IN --dst OUT`"),
        (b"PK\x03\x04", "a zip archive (a spreadsheet or .npz?); accepted is a .csv of it"),
        (b"\x1f\x8b", "compressed by gzip; accepted once it is unpacked"),
        (b"\x28\xb5\x2f\xfd", "compressed by zstd; accepted once it is unpacked"),
        (
            b"\x93NUMPY",
            "an array of NumPy, which has no names; accepted is a .csv, .parquet or .h5 of named columns",
        ),
    ];
    if let Some((_, what)) = not_read.iter().find(|(magic, _)| head.starts_with(magic)) {
        return Err((*what).into());
    }
    let told =
        |what: &str| Err(format!("is not {what}, though its name says so: it is damaged or of another kind"));
    match suffix.as_str() {
        "mat" => Ok(Format::Matlab),
        "json" => Ok(Format::Json),
        "h5" | "hdf5" | "hdf" => told("HDF5"),
        "parquet" | "pq" => told("Parquet"),
        "mcap" => told("MCAP"),
        "db3" => told("SQLite"),
        _ => Ok(Format::Text),
    }
}

fn suffix(path: &Path) -> String {
    path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase()).unwrap_or_default()
}

/// Whether a folder is a recording: a bag of ROS 2.
#[must_use]
pub fn is_bag(path: &Path) -> bool {
    path.join(signatures::BAG_METADATA).is_file()
}

/// Reads a file of any kind as a recording on a line.
fn read(path: &Path, wanted: &Wanted) -> Result<Recording, Error> {
    on_a_line(&path.display().to_string(), wanted, |wanted| read_any(path, wanted))
}

/// Refuses what is a recording in the plane, unless a map or a joint says what is wanted of it.
fn on_a_line(
    file: &str,
    wanted: &Wanted,
    read: impl FnOnce(&Wanted) -> Result<Recording, Error>,
) -> Result<Recording, Error> {
    let planar = Cell::new(false);
    let map = |has: &dyn Fn(&str) -> bool| {
        let map = (wanted.map)(has);
        planar.set(map.is_none() && wanted.joint.is_none() && axis::is_planar(has));
        map
    };
    let recording = read(&Wanted { map: &map, joint: wanted.joint });
    if planar.get() {
        let why = "is a recording in the plane, which `identify` and `diagnose` take; accepted here is one on a line, or a map \
                   of one axis such as time_s=time_s,position_m=position_x_m,force_n=force_x_n";
        return Err(Error::File { file: file.into(), why: why.into() });
    }
    recording
}

/// Reads a file of any kind.
fn read_any(path: &Path, wanted: &Wanted) -> Result<Recording, Error> {
    let file = path.display().to_string();
    let fail = |why: String| Error::File { file: file.clone(), why };
    let words = |e: std::io::Error| fail(files::reason(&e));
    let format = if path.is_dir() && is_bag(path) {
        Format::Folder
    } else {
        let mut head = Vec::new();
        std::fs::File::open(path).and_then(|f| f.take(HEAD as u64).read_to_end(&mut head)).map_err(words)?;
        recognised(path, &head).map_err(fail)?
    };
    let mut recording = match format {
        #[cfg(feature = "ros2")]
        Format::Mcap => mcap::read(&file, path, wanted)?,
        #[cfg(feature = "ros2")]
        Format::Sqlite => bag::read(&file, path, wanted)?,
        #[cfg(feature = "ros2")]
        Format::Folder => bag::read_folder(&file, path, wanted)?,
        other => parsed(other, &file, std::fs::read(path).map_err(words)?.into(), wanted)?,
    };
    recording.name = path.file_name().map_or_else(|| file.clone(), |n| n.to_string_lossy().into_owned());
    Ok(recording)
}

/// Reads a file in memory as a recording on a line.
fn in_memory(name: &str, bytes: &[u8], wanted: &Wanted) -> Result<Recording, Error> {
    on_a_line(name, wanted, |wanted| any_in_memory(name, bytes, wanted))
}

/// Reads a file in memory.
fn any_in_memory(name: &str, bytes: &[u8], wanted: &Wanted) -> Result<Recording, Error> {
    let head = &bytes[..bytes.len().min(HEAD)];
    let format = recognised(Path::new(name), head).map_err(|why| Error::File { file: name.into(), why })?;
    Ok(Recording { name: name.into(), ..parsed(format, name, bytes.into(), wanted)? })
}

/// Reads the content of a file.
fn parsed(format: Format, file: &str, bytes: Cow<'_, [u8]>, wanted: &Wanted) -> Result<Recording, Error> {
    let other = match format {
        Format::Text => return csv::read(file, &bytes, wanted),
        Format::Json => return json::read(file, &bytes, wanted),
        Format::Matlab => return matlab::read(file, &bytes, wanted),
        #[cfg(feature = "hdf5")]
        Format::Hdf5 => return hdf5::read(file, bytes.into_owned(), wanted),
        #[cfg(feature = "parquet")]
        Format::Parquet => return parquet::read(file, bytes.into_owned(), wanted),
        #[cfg(not(feature = "hdf5"))]
        Format::Hdf5 => "HDF5",
        #[cfg(not(feature = "parquet"))]
        Format::Parquet => "Parquet",
        Format::Mcap => "MCAP",
        Format::Sqlite | Format::Folder => "a bag of ROS 2",
    };
    let why = format!("{other} is not read here; accepted is a .csv of it: `tribos convert {file} out.csv`");
    Err(Error::File { file: file.into(), why })
}

/// The bytes of a file of the kind that its name says, and a remark on what it cannot hold.
fn written(path: &Path, recording: &Recording) -> Result<(Vec<u8>, Option<String>), Error> {
    let file = path.display().to_string();
    recording.check_lengths()?;
    check_suffix(path)?;
    match suffix(path).as_str() {
        "csv" => Ok((csv::write(recording)?.into_bytes(), None)),
        "mat" => Ok((matlab::write(&file, recording)?, None)),
        #[cfg(feature = "hdf5")]
        "h5" => Ok((hdf5::write(&file, recording)?, None)),
        #[cfg(feature = "parquet")]
        "parquet" => Ok((parquet::write(&file, recording)?, None)),
        #[cfg(feature = "ros2")]
        "mcap" => mcap::write(&file, recording),
        other => {
            Err(Error::File { file, why: format!(".{other}: this program was built without a writer of it") })
        }
    }
}

/// Refuses a name whose suffix is of no kind that is written.
///
/// # Errors
/// The name, and the suffixes that are accepted.
pub fn check_suffix(path: &Path) -> Result<(), Error> {
    let suffix = suffix(path);
    if WRITTEN.contains(&suffix.as_str()) {
        return Ok(());
    }
    let file = path.display().to_string();
    let [most @ .., last] = WRITTEN;
    let accepted = most.map(|s| format!(".{s}")).join(", ");
    Err(Error::File {
        file,
        why: format!("cannot write `.{suffix}`; accepted is a name ending in {accepted} or .{last}"),
    })
}
