//! One file a subcommand: its options and what it does.

pub mod benchmark;
pub mod compare;
pub mod compensate;
pub mod connect;
pub mod convert;
pub mod demo;
pub mod design;
pub mod design_args;
mod design_grid;
pub mod diagnose;
pub mod experiment;
pub mod export;
pub mod figures;
pub mod identify;
pub mod investigate;
pub mod lab;
pub mod predict;
pub mod preset;
pub mod prove;
pub mod record;
pub mod simulate;
