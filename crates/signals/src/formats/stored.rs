//! Numbers in the types that files store them in.

/// Type of a stored number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Stored {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F32,
    F64,
}

impl Stored {
    /// The integer of `bytes` bytes.
    #[cfg(feature = "hdf5")]
    pub(crate) const fn integer(bytes: u32, signed: bool) -> Option<Self> {
        Some(match (bytes, signed) {
            (1, true) => Self::I8,
            (1, false) => Self::U8,
            (2, true) => Self::I16,
            (2, false) => Self::U16,
            (4, true) => Self::I32,
            (4, false) => Self::U32,
            (8, true) => Self::I64,
            (8, false) => Self::U64,
            _ => return None,
        })
    }

    /// The number at the beginning of `bytes`; `big`: most significant byte first. `None` where the bytes end within it.
    pub(crate) fn read(self, bytes: &[u8], big: bool) -> Option<f64> {
        fn first<const N: usize>(bytes: &[u8], big: bool) -> Option<[u8; N]> {
            let mut little = *bytes.first_chunk::<N>()?;
            if big {
                little.reverse();
            }
            Some(little)
        }
        Some(match self {
            Self::I8 => f64::from(i8::from_le_bytes(first(bytes, big)?)),
            Self::U8 => f64::from(u8::from_le_bytes(first(bytes, big)?)),
            Self::I16 => f64::from(i16::from_le_bytes(first(bytes, big)?)),
            Self::U16 => f64::from(u16::from_le_bytes(first(bytes, big)?)),
            Self::I32 => f64::from(i32::from_le_bytes(first(bytes, big)?)),
            Self::U32 => f64::from(u32::from_le_bytes(first(bytes, big)?)),
            Self::I64 => i64::from_le_bytes(first(bytes, big)?) as f64,
            Self::U64 => u64::from_le_bytes(first(bytes, big)?) as f64,
            Self::F32 => f64::from(f32::from_le_bytes(first(bytes, big)?)),
            Self::F64 => f64::from_le_bytes(first(bytes, big)?),
        })
    }

    /// All numbers of an array; bytes behind the last whole number are left.
    pub(crate) fn read_all(self, bytes: &[u8], big: bool) -> Vec<f64> {
        bytes.chunks_exact(self.bytes()).filter_map(|number| self.read(number, big)).collect()
    }

    const fn bytes(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::I64 | Self::U64 | Self::F64 => 8,
        }
    }
}
