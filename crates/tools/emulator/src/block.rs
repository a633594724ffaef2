//! The block under the handle, by name [thesis, table 3-3].

use crate::{Image, Machine};
use plant::RigConfig;
use plant::materials::material;
use std::str::FromStr;

/// A block of aluminium on a surface, or none.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Block {
    /// No block: the handle is free.
    #[default]
    None,
    /// Brass, first run of [thesis, table 3-3].
    Brass,
    /// Teflon, first run.
    Teflon,
    /// Rubber, first run.
    Rubber,
}

impl FromStr for Block {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "none" => Ok(Self::None),
            "brass" => Ok(Self::Brass),
            "teflon" => Ok(Self::Teflon),
            "rubber" => Ok(Self::Rubber),
            _ => Err(format!("unknown block `{text}`: expected none, brass, teflon or rubber")),
        }
    }
}

impl Block {
    /// A board with this block on its rig. `seed` is that of all noise.
    #[must_use]
    pub fn under(self, image: &Image, seed: u64) -> Machine {
        let name = match self {
            Self::None => return Machine::free_handle(image, seed),
            Self::Brass => "brass",
            Self::Teflon => "teflon",
            Self::Rubber => "rubber",
        };
        let block = material(name).expect("a column of table 3-3");
        let config = RigConfig { block_mass: block.mass, ..RigConfig::default() };
        Machine::boot(image, config, block.law, seed).expect("the default rig is within its ranges")
    }
}
