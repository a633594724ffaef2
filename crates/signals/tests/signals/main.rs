//! Recordings from file to preparation. One binary: it links once, and long tests run beside each other.

mod audit;
mod filters;
mod recordings;
mod smoother;
