//! Arguments of `tribos design`.

use crate::failure::{Failure, Result};
use crate::options;
use haptics::Settings;
use haptics::bounds::Grasp;
use std::path::PathBuf;

/// Options of `design`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  tribos design --mass 0.5 --friction 4 --stiffness 10000 --damping 10
  tribos design --device-mass 1 --device-damping 10 --dv 0.02
  tribos design --preset rubber --map rubber.svg
  tribos design --grid --map grid.svg
  tribos design --renderers")]
pub struct Args {
    /// Mass of the virtual block M, kg
    #[arg(long, value_name = "KG", value_parser = options::above_zero, allow_hyphen_values = true)]
    pub(super) mass: Option<f64>,
    /// Dynamic friction F, N
    #[arg(long, value_name = "N", value_parser = options::not_negative, allow_hyphen_values = true)]
    pub(super) friction: Option<f64>,
    /// Control period T, s
    #[arg(long, value_name = "S", default_value = "0.001", value_parser = options::above_zero, allow_hyphen_values = true)]
    pub(super) period: f64,
    /// Coupling stiffness K, N/m
    #[arg(long, value_name = "N/m", value_parser = options::above_zero, allow_hyphen_values = true)]
    pub(super) stiffness: Option<f64>,
    /// Coupling damping B, N·s/m
    #[arg(long, value_name = "N·s/m", value_parser = options::not_negative, allow_hyphen_values = true)]
    pub(super) damping: Option<f64>,
    /// Mass of the handle m, kg
    #[arg(long, value_name = "KG", value_parser = options::above_zero, allow_hyphen_values = true)]
    pub(super) device_mass: Option<f64>,
    /// Damping of the handle b, N·s/m
    #[arg(long, value_name = "N·s/m", value_parser = options::not_negative, allow_hyphen_values = true)]
    pub(super) device_damping: Option<f64>,
    /// Delay from sample to force, s; up to one period
    #[arg(long, value_name = "S", default_value = "0", value_parser = options::not_negative, allow_hyphen_values = true)]
    pub(super) delay: f64,
    /// Speed taken for zero DV, m/s
    #[arg(long, value_name = "m/s", value_parser = options::above_zero, allow_hyphen_values = true)]
    pub(super) dv: Option<f64>,
    /// Travel of one encoder count, m
    #[arg(long, value_name = "M", value_parser = options::above_zero, allow_hyphen_values = true)]
    pub(super) encoder: Option<f64>,
    /// Dominant frequency of the force to render, Hz
    #[arg(long, value_name = "HZ", value_parser = options::above_zero, allow_hyphen_values = true)]
    pub(super) frequency: Option<f64>,
    /// Hand on the handle: mass kg, damping N·s/m, stiffness N/m (released when not given)
    #[arg(long, value_name = "KG,N·s/m,N/m", value_parser = grasp, allow_hyphen_values = true)]
    pub(super) hand: Option<Grasp>,
    /// Check a preset on this device instead, and find the nearest one without a warning: a built-in name
    #[arg(long, value_name = "NAME", conflicts_with_all = ["mass", "friction", "stiffness", "damping", "dv"])]
    pub(super) preset: Option<String>,
    /// Run this number of couplings (10 000 by default) through the simulated device under every renderer: which
    /// come to rest, which chatter; with --map as a picture. --dv is the Δv of the Karnopp renderers
    #[arg(long, value_name = "POINTS", num_args = 0..=1, default_missing_value = "10000", value_parser = clap::value_parser!(u32).range(1..=1_000_000), conflicts_with_all = ["mass", "friction", "stiffness", "damping", "device_mass", "device_damping"])]
    pub(super) grid: Option<u32>,
    /// Compare the renderers through the sensors of the device, without and with passivity control: force errors, creep,
    /// noise at rest, energy, and the share of the grid (500 couplings, or those of --grid) that comes to rest and gives no
    /// energy; what a hand feels of a heavy and of a light block; of --preset, or of [thesis, table 5-3] and the materials
    #[arg(long, conflicts_with_all = ["mass", "friction", "stiffness", "damping", "dv", "device_mass", "device_damping", "map"])]
    pub(super) renderers: bool,
    /// Draw the safe region over K and B
    #[arg(long, value_name = "FILE.svg")]
    pub(super) map: Option<PathBuf>,
    /// Write the numbers as JSON, `-` for standard output
    #[arg(long, value_name = "FILE")]
    pub(super) json: Option<PathBuf>,
}

fn grasp(text: &str) -> std::result::Result<Grasp, String> {
    let numbers: Option<Vec<f64>> = text.split(',').map(|part| options::not_negative(part).ok()).collect();
    match numbers.as_deref() {
        Some(&[mass, damping, stiffness]) => Ok(Grasp { mass, damping, stiffness }),
        _ => Err("three numbers from 0 on are accepted: kg,N·s/m,N/m, e.g. 0.3,5,400".into()),
    }
}

/// The built-in preset of this name.
pub(super) fn built_in(name: &str) -> Result<Settings> {
    Settings::preset(name).ok_or_else(|| {
        let known: Vec<&str> = Settings::PRESETS.iter().map(|(name, _)| *name).collect();
        Failure::new(format!("--preset {name}: no such preset; there are {}", known.join(", ")))
    })
}
