//! What lies under the handle: the blocks and surfaces of the thesis, by name.

use crate::{Image, Machine};
use plant::RigConfig;
use plant::materials::material;
use std::str::FromStr;

/// A block of aluminium on a surface, or none.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Block {
    /// The handle is free: what it feels is what the firmware renders.
    #[default]
    None,
    /// Brass, first run of table 3-3.
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
            _ => Err(format!("`{text}` is no block: accepted is none, brass, teflon or rubber")),
        }
    }
}

impl Block {
    /// A board whose rig carries this block; `seed` is that of all noise.
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
        Machine::boot(image, config, block.law, seed).expect("the thesis's rig is within its ranges")
    }
}
