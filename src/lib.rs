//! The firmware application of tribos, for two boards: a NUCLEO-G474RE and a simulated one.
//!
//! ```text
//!            control interrupt                         tasks
//!  board ──▶ ControlLoop ── Telemetry, Report ──▶ Desk ──▶ serial line
//!        ◀──  (haptics)  ◀────── Request ──────         ◀──
//! ```
//!
//! [`app`] has both sides, synchronous and without hardware. [`board`] has the hardware, [`sensors`] the drivers of chips on its
//! buses. The firmware's tasks and [`VirtualDevice`] only move bytes and time.
#![cfg_attr(target_os = "none", no_std)]
#![deny(unsafe_code)]

pub mod app;
pub mod board;
pub mod presets;
pub mod sensors;

#[cfg(not(target_os = "none"))]
pub use board::simulated::{VirtualConfig, VirtualDevice};
