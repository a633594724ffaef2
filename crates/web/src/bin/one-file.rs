//! Puts the page into one file: `one-file GLUE.js PROGRAM.wasm OUT.html`. `.ci/web` runs it.
#![forbid(unsafe_code)]

#[cfg(not(target_arch = "wasm32"))]
mod page {
    use base64::Engine;
    use base64::engine::general_purpose::STANDARD;
    use sha2::{Digest, Sha256};

    const INDEX: &str = include_str!("../../assets/index.html");
    const STYLE: &str = include_str!("../../assets/page.css");
    const SCRIPT: &str = include_str!("../../assets/page.js");
    const WORKER: &str = include_str!("../../assets/worker.js");
    const EXAMPLE: &str = include_str!("../../../tools/fixtures/recordings/tribometer.csv");

    /// The page around what wasm-bindgen made.
    pub(super) fn page(glue: &str, program: &[u8]) -> Result<String, String> {
        let worker = format!("{glue}\n{WORKER}");
        for (what, text) in
            [("the worker", worker.as_str()), ("the script", SCRIPT), ("the example", EXAMPLE)]
        {
            if text.to_ascii_lowercase().contains("</script") {
                return Err(format!("{what} has `</script`, which would end its element"));
            }
        }
        let module = STANDARD.encode(miniz_oxide::deflate::compress_to_vec_zlib(program, 9));
        let parts = [
            ("HASHES", hashes()),
            ("VERSION", env!("CARGO_PKG_VERSION").into()),
            ("STYLE", STYLE.into()),
            ("WORKER", worker),
            ("MODULE", module),
            ("EXAMPLE", EXAMPLE.into()),
            ("SCRIPT", SCRIPT.into()),
        ];
        let mut pieces = INDEX.split("{{");
        let mut page = pieces.next().unwrap_or_default().to_owned();
        for piece in pieces {
            let (name, rest) = piece.split_once("}}").ok_or("index.html: `{{` without `}}`")?;
            let part = parts.iter().find(|(known, _)| *known == name);
            page += &part.ok_or(format!("index.html: unknown part `{name}`"))?.1;
            page += rest;
        }
        Ok(page)
    }

    /// What may run: the script of the page, and those of a report.
    fn hashes() -> String {
        let mut scripts = vec![SCRIPT.to_owned()];
        scripts.extend(report::page::scripts_of_charts());
        let hash = |script: &String| format!("'sha256-{}'", STANDARD.encode(Sha256::digest(script)));
        scripts.iter().map(hash).collect::<Vec<_>>().join(" ")
    }

    #[cfg(test)]
    mod tests {
        #[test]
        fn one_file_refers_to_nothing_outside() {
            let page = super::page("glue", b"program").expect("a page");
            assert!(!page.contains("{{"));
            for outside in [" src=", "http://", "https://", "url(", "@import"] {
                assert!(!page.contains(outside), "{outside}");
            }
            assert!(page.contains("connect-src 'none'"));
            assert_eq!(
                super::page("</Script>", b"").unwrap_err(),
                "the worker has `</script`, which would end its element"
            );
        }
    }
}

#[cfg(not(target_arch = "wasm32"))]
fn main() -> Result<(), String> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [glue, program, out] = arguments.as_slice() else {
        return Err("one-file GLUE.js PROGRAM.wasm OUT.html".into());
    };
    let failed = |path: &str, e: std::io::Error| format!("{path}: {}", signals::files::reason(&e));
    let glue = std::fs::read_to_string(glue).map_err(|e| failed(glue, e))?;
    let program = std::fs::read(program).map_err(|e| failed(program, e))?;
    let page = page::page(&glue, &program)?;
    std::fs::write(out, page).map_err(|e| failed(out, e))
}

#[cfg(target_arch = "wasm32")]
fn main() {}
