//! Recordings from file to preparation. One binary: it links once, and long tests run beside each other.

mod audit;
mod filters;
mod foreign;
mod recordings;
mod round_trips;
mod smoother;
