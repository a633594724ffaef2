//! Map texts: which variable of a file is which column.

/// A parsed map: `time_s=t,position_m=qm,force_n=gtau*vir`.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Map {
    text: String,
}
