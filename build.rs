//! Linker arguments of the firmware and of what is timed beside it, for the chosen board. On a PC there is nothing to do.

/// Cargo features that choose a board, and the regions of its memory.
const BOARDS: [(&str, &str); 2] =
    [("nucleo-g474re", "src/board/nucleo_g474re.x"), ("nucleo-l476rg", "src/board/nucleo_l476rg.x")];

/// Cargo features of sensors that the first board may have.
const SENSORS: [&str; 3] = ["absolute-encoder", "index-pulse", "load-cell-converter"];

/// The law that a board with such a sensor has no time for. Its code stays in flash there: CCM is full.
const DEAR_LAW: &str =
    "SECTIONS { .dear : { *(.text._ZN8friction3any*elasto_plastic*); } > FLASH } INSERT AFTER .text;";

fn main() {
    println!("cargo:rerun-if-changed=memory.x");
    println!("cargo:rerun-if-changed=build.rs");
    if std::env::var("CARGO_CFG_TARGET_OS").as_deref() != Ok("none") {
        return;
    }
    let feature = |name: &str| format!("CARGO_FEATURE_{}", name.to_uppercase().replace('-', "_"));
    let chosen: Vec<_> =
        BOARDS.iter().filter(|(name, _)| std::env::var_os(feature(name)).is_some()).collect();
    let [(name, regions)] = chosen[..] else {
        let names = BOARDS.map(|(name, _)| name).join(", ");
        let count = chosen.len();
        panic!(
            "{count} boards chosen: accepted exactly one of the features {names}; another than the first with --no-default-features --features NAME"
        );
    };
    let [absolute, index, converter] = SENSORS.map(|sensor| std::env::var_os(feature(sensor)).is_some());
    if (absolute || index || converter) && *name != BOARDS[0].0 {
        panic!("{}: accepted with {}", SENSORS.join(", "), BOARDS[0].0);
    }
    if absolute && index {
        panic!("{} and {}: accepted one of them; the first has no index", SENSORS[0], SENSORS[1]);
    }
    println!("cargo:rerun-if-changed={regions}");
    let out = std::env::var("OUT_DIR").expect("cargo sets OUT_DIR");
    std::fs::copy("memory.x", format!("{out}/memory.x")).expect("memory.x lies beside Cargo.toml");
    let dear = if absolute || index || converter { DEAR_LAW } else { "" };
    std::fs::write(format!("{out}/dear_law.x"), dear).expect("the directory of this build");
    std::fs::copy(regions, format!("{out}/regions.x")).expect("each board has its regions");
    println!("cargo:rustc-link-search={out}");
    for argument in ["--nmagic", "-Tlink.x", "-Tdefmt.x"] {
        println!("cargo:rustc-link-arg-bins={argument}");
        println!("cargo:rustc-link-arg-examples={argument}");
    }
}
