//! The figures of the thesis, computed anew: chapter 3 from simulated recordings with the parameters of table 3-3,
//! chapter 4 from the very renderer of the device.

mod chapter_3;
mod chapter_4;
mod plot;
mod rendered;

use crate::failure::Result;
pub(crate) use plot::{BLUE, GREEN, GREY, Line, ORANGE, PURPLE, Panel, svg};

/// A number the thesis states, and ours.
#[derive(Debug, Clone)]
pub(crate) struct Number {
    pub what: String,
    pub thesis: String,
    pub ours: String,
}

/// One figure.
#[derive(Debug, Clone)]
pub(crate) struct Figure {
    /// As the thesis numbers it: `4-10`.
    pub id: &'static str,
    /// Caption of the thesis.
    pub caption: &'static str,
    pub panels: Vec<Panel>,
    pub numbers: Vec<Number>,
}

/// How a figure is made.
type Make = fn() -> Result<Figure>;

/// Every figure, in the thesis's order.
pub(crate) const FIGURES: &[(&str, Make)] = &[
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

fn number(what: impl Into<String>, thesis: impl Into<String>, ours: impl Into<String>) -> Number {
    Number { what: what.into(), thesis: thesis.into(), ours: ours.into() }
}
