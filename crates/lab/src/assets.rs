//! The page, embedded in the binary; it needs no network.

const HTML: &str = "text/html; charset=utf-8";
const SCRIPT: &str = "text/javascript; charset=utf-8";
const STYLE: &str = "text/css; charset=utf-8";

macro_rules! assets {
    ($($name:literal, $kind:ident, $file:literal;)*) => {
        /// Every file, with its media type.
        pub const ALL: &[(&str, &str, &str)] = &[$(($name, $kind, include_str!($file)),)*];
    };
}

assets! {
    "index.html", HTML, "../assets/index.html";
    "lab.css", STYLE, "../assets/lab.css";
    "main.js", SCRIPT, "../assets/main.js";
    "wire.js", SCRIPT, "../assets/wire.js";
    "ring.js", SCRIPT, "../assets/ring.js";
    "scope.js", SCRIPT, "../assets/scope.js";
    "loop.js", SCRIPT, "../assets/loop.js";
    "handle.js", SCRIPT, "../assets/handle.js";
    "controls.js", SCRIPT, "../assets/controls.js";
    "bench.js", SCRIPT, "../assets/bench.js";
    "handover.js", SCRIPT, "../assets/handover.js";
    "plane.js", SCRIPT, "../assets/plane.js";
    "try.js", SCRIPT, "../assets/try.js";
    // MIT, its licence beside it; the reports inline the same file
    "uPlot.js", SCRIPT, "../../report/assets/uPlot.iife.min.js";
    "uPlot.css", STYLE, "../../report/assets/uPlot.min.css";
    "uPlot.LICENSE", HTML, "../../report/assets/uPlot.LICENSE";
}

/// Media type and content of a file.
#[must_use]
pub fn find(name: &str) -> Option<(&'static str, &'static str)> {
    ALL.iter().find(|(known, ..)| *known == name).map(|(_, kind, body)| (*kind, *body))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_page_is_small_and_self_contained() {
        let size: usize = ALL.iter().map(|(.., body)| body.len()).sum();
        println!("page: {} files, {size} bytes", ALL.len());
        assert!(size < 250_000);
        for (name, _, body) in ALL.iter().filter(|(name, ..)| !name.starts_with("uPlot")) {
            assert!(!body.contains("https://") && !body.contains("http://"), "{name} names another place");
        }
    }
}
