//! The command as people use it. One binary: it links once, and long tests run beside each other.

#[cfg(unix)]
mod board;
mod book;
#[cfg(unix)]
#[path = "../shared/cable.rs"]
mod cable;
mod cli;
mod demo;
mod interrupt;
mod investigate;
mod live;
