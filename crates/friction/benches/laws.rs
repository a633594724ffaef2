//! Time of one step of each law.
fn main() {
    divan::main();
}
