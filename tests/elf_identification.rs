//! Identification on the emulated board, beside the suite `elf` under the standard harness.
#![cfg(not(target_os = "none"))]

// shared with the suite, which uses the rest of it
#[allow(dead_code)]
#[path = "elf/board.rs"]
mod board;
#[path = "elf/identification.rs"]
mod identification;
#[path = "elf/witness.rs"]
mod witness;
