//! Fits and models. One binary: it links once, and long tests run beside each other.

mod dahl;
mod karnopp;
mod model;
mod positioner;
mod preprocess;
mod table_3_3;
mod uneven;
