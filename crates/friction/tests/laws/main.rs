//! Laws and effects. One binary: it links once, and long tests run beside each other.

mod catalogue;
mod closed_forms;
mod common;
mod dual;
mod energy;
mod hold;
mod hysteresis;
mod planar;
mod precision;
mod robust;
mod sliding;
mod stopping;
mod surface;
mod symmetry;
