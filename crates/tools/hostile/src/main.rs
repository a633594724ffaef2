//! Writes the seeds of each target, for the fuzzer: `cargo run -p hostile -- DIR`.

use std::{env, fs, io, path::PathBuf};

fn main() -> io::Result<()> {
    let folder = env::args().nth(1).map_or_else(|| PathBuf::from("fuzz/work"), PathBuf::from);
    for (target, name, bytes) in hostile::seeds() {
        let folder = folder.join(target);
        fs::create_dir_all(&folder)?;
        fs::write(folder.join(name), bytes)?;
    }
    Ok(())
}
