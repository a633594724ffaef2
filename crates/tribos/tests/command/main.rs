//! The command as people use it. One binary: it links once, and long tests run beside each other.

mod book;
mod cli;
mod demo;
mod interrupt;
mod investigate;
mod live;
