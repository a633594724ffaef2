//! Recomputed figures of [thesis, ch. 3 and 4]: chapter 3 from simulated recordings with the parameters of [thesis, table 3-3],
//! chapter 4 from the renderer of the device.

#![forbid(unsafe_code)]

mod chapter_3;
mod chapter_4;
mod figure;
mod rendered;

pub use figure::{Error, Figure, Number, page};

/// How a figure is made.
pub type Make = fn() -> std::result::Result<Figure, Error>;

/// Every figure, in the printed order.
pub const FIGURES: &[(&str, Make)] = &[
    ("3-3", chapter_3::signals),
    ("3-4", chapter_3::directions),
    ("3-5", chapter_3::brass),
    ("3-6", chapter_3::teflon),
    ("3-7", chapter_3::rubber),
    ("3-8", chapter_3::karnopp_over_velocity),
    ("3-9", chapter_3::dahl_over_velocity),
    ("4-3", chapter_4::step_responses),
    ("4-4", chapter_4::virtual_damping),
    ("4-5", chapter_4::quantised_velocity),
    ("4-6", chapter_4::lagging_friction),
    ("4-7", chapter_4::creeping_while_stuck),
    ("4-8", chapter_4::dead_bands),
    ("4-9", chapter_4::stick_slip),
    ("4-10", chapter_4::tuned),
    ("4-13", chapter_4::limit_cycle_surface),
    ("4-14", chapter_4::limit_cycle_sections),
    ("4-15", rendered::real_and_simulated),
];
