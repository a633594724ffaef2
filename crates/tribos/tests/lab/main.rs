//! `tribos lab` in a headless browser, and without one. `PICTURES=DIR cargo test -p tribos --test lab` keeps pictures.

mod access;
mod analysis;
mod browser;
mod cost;
mod experiments;
mod scope;
