//! Time of one control step on this machine. The figure that matters, cycles on the target, is measured on the ELF.

fn main() {
    divan::main();
}
