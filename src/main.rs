//! The firmware: on a NUCLEO-G474RE, or as the virtual device on a PC.
#![cfg_attr(target_os = "none", no_std, no_main)]
#![deny(unsafe_code)]

#[cfg(target_os = "none")]
mod firmware;
#[cfg(not(target_os = "none"))]
mod virtual_device;

#[cfg(not(target_os = "none"))]
fn main() -> std::process::ExitCode {
    virtual_device::main()
}
