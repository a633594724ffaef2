//! The simulated rig. One binary: it links once, and long tests run beside each other.

mod hostile;
mod laws;
mod motion;
mod sensors;
mod thesis;
