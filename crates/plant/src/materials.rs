//! An aluminium block on brass, Teflon and rubber, as printed in [thesis, table 3-3].

use friction::Karnopp;

/// Mass of the block on a scale, kg [thesis, ch. 3.6]. The masses in [thesis, table 3-3] are estimates.
pub const WEIGHED_BLOCK_MASS: f64 = 0.419;

/// A column of [thesis, table 3-3]: the block identified on one surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Material {
    /// "brass 1", "Teflon 2", …
    pub name: &'static str,
    /// Estimated mass of this run, kg.
    pub mass: f64,
    /// Karnopp's law with the levels of this run, as magnitudes.
    pub law: Karnopp<f64>,
    /// Printed standard deviations of m, C_p, b_p, C_n, b_n.
    pub printed_std: [f64; 5],
}

/// All six columns of [thesis, table 3-3]: both runs on brass, Teflon and rubber.
pub const TABLE_3_3: [Material; 6] = [
    Material {
        name: "brass 1",
        mass: 0.4033,
        law: Karnopp {
            c_p: 1.7714,
            b_p: 0.457,
            c_n: 1.729,
            b_n: 0.6196,
            d_p: 2.1302,
            d_n: 1.8623,
            delta_v: 0.007,
        },
        printed_std: [0.0051, 0.023, 0.248, 0.0229, 0.2504],
    },
    Material {
        name: "brass 2",
        mass: 0.4117,
        law: Karnopp {
            c_p: 1.6814,
            b_p: -1.5778,
            c_n: 1.6384,
            b_n: -0.618,
            d_p: 2.0842,
            d_n: 1.7328,
            delta_v: 0.007,
        },
        printed_std: [0.0039, 0.0173, 0.1884, 0.0174, 0.1894],
    },
    Material {
        name: "Teflon 1",
        mass: 0.4436,
        law: Karnopp {
            c_p: 0.513,
            b_p: 1.0957,
            c_n: 0.5365,
            b_n: 1.3038,
            d_p: 1.0078,
            d_n: 0.7167,
            delta_v: 0.005,
        },
        printed_std: [0.0038, 0.0136, 0.1519, 0.0133, 0.15],
    },
    Material {
        name: "Teflon 2",
        mass: 0.4555,
        law: Karnopp {
            c_p: 0.4808,
            b_p: 1.6554,
            c_n: 0.5233,
            b_n: 1.5635,
            d_p: 0.9319,
            d_n: 0.6553,
            delta_v: 0.005,
        },
        printed_std: [0.0037, 0.0132, 0.1476, 0.0127, 0.1434],
    },
    Material {
        name: "rubber 1",
        mass: 0.3886,
        law: Karnopp {
            c_p: 3.4901,
            b_p: 8.7338,
            c_n: 2.5611,
            b_n: 7.9521,
            d_p: 3.8513,
            d_n: 2.9099,
            delta_v: 0.02,
        },
        printed_std: [0.0045, 0.0334, 0.3621, 0.0298, 0.3225],
    },
    Material {
        name: "rubber 2",
        mass: 0.3737,
        law: Karnopp {
            c_p: 3.7244,
            b_p: 9.6733,
            c_n: 2.7269,
            b_n: 8.0322,
            d_p: 4.0179,
            d_n: 2.7733,
            delta_v: 0.02,
        },
        printed_std: [0.0047, 0.0353, 0.3853, 0.0296, 0.3213],
    },
];

/// Aluminium on brass, run 1 of [thesis, table 3-3].
pub const BRASS: Material = TABLE_3_3[0];
/// Aluminium on Teflon, run 1 of [thesis, table 3-3].
pub const TEFLON: Material = TABLE_3_3[2];
/// Aluminium on rubber, run 1 of [thesis, table 3-3].
pub const RUBBER: Material = TABLE_3_3[4];

/// The material with this name, in any case. "rubber" is run 1.
#[must_use]
pub fn material(name: &str) -> Option<Material> {
    let name = name.trim();
    TABLE_3_3.into_iter().find(|m| {
        m.name.eq_ignore_ascii_case(name)
            || m.name.strip_suffix(" 1").is_some_and(|n| n.eq_ignore_ascii_case(name))
    })
}
