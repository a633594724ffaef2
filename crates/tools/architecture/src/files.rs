//! Which file of a crate imports which.

use crate::source::{self, Source};
use std::collections::{BTreeMap, BTreeSet};
use std::io;
use std::path::Path;

/// Files by what they import, both relative to `src`.
pub type Graph = BTreeMap<String, BTreeSet<String>>;

/// The modules of a crate by their path below the root: `a::b` is `src/a/b.rs` or `src/a/b/mod.rs`.
struct Modules {
    by_path: BTreeMap<Vec<String>, (String, Source)>,
}

/// The module of a file, `None` for a binary's root beside a library.
fn module(relative: &Path) -> Option<Vec<String>> {
    let mut path: Vec<String> =
        relative.with_extension("").iter().map(|part| part.to_string_lossy().into_owned()).collect();
    match path.last().map(String::as_str) {
        Some("mod") => _ = path.pop(),
        Some("lib") if path.len() == 1 => _ = path.pop(),
        Some("main") if path.len() == 1 => return None,
        _ => {}
    }
    Some(path)
}

impl Modules {
    /// The file that defines what this path from `from` stands for; `None` for what is not of this crate.
    fn file_of(&self, from: &[String], path: &[String], depth: usize) -> Option<&str> {
        // imports that go round in circles end somewhere
        if depth > 16 {
            return None;
        }
        let mut module: Vec<String> = Vec::new();
        let mut rest = path;
        match path.first().map(String::as_str)? {
            "crate" => rest = &rest[1..],
            "self" => (module, rest) = (from.to_vec(), &rest[1..]),
            "super" => {
                module = from.to_vec();
                while let Some("super") = rest.first().map(String::as_str) {
                    module.pop()?;
                    rest = &rest[1..];
                }
            }
            first => {
                // a child module, or a name that this file imports; other crates are neither
                module = from.to_vec();
                let mut child = module.clone();
                child.push(first.to_owned());
                if !self.by_path.contains_key(&child) {
                    let (_, source) = self.by_path.get(&module)?;
                    let alias = source.aliases(first).0.filter(|alias| alias.path != path)?;
                    let through = [&alias.path[..], &rest[1..]].concat();
                    return self.file_of(from, &through, depth + 1);
                }
            }
        }
        while let Some(next) = rest.first() {
            let mut child = module.clone();
            child.push(next.clone());
            if !self.by_path.contains_key(&child) {
                break;
            }
            (module, rest) = (child, &rest[1..]);
        }
        let (file, source) = self.by_path.get(&module)?;
        let Some(item) = rest.first().filter(|item| *item != "self" && *item != "*") else {
            return Some(file);
        };
        if source.items.contains(item) {
            return Some(file);
        }
        let (named, globs) = source.aliases(item);
        if let Some(alias) = named {
            let through = [&alias.path[..], &rest[1..]].concat();
            if let Some(found) = self.file_of(&module, &through, depth + 1) {
                return Some(found);
            }
            // the name of another crate, passed on
            return None;
        }
        for glob in globs.values() {
            let mut through = glob.path.clone();
            through.pop();
            let target = self.file_of(&module, &[&through[..], &["self".to_owned()]].concat(), depth + 1);
            let defines = |file: &str| {
                self.by_path.values().any(|(name, source)| name == file && source.items.contains(item))
            };
            if let Some(target) = target.filter(|file| defines(file)) {
                return Some(target);
            }
        }
        Some(file)
    }
}

/// Which file of the crate below `src` imports which; names that are only passed on, and modules that are only
/// declared, are no imports.
///
/// # Errors
/// A file that cannot be read.
pub fn imports(src: &Path) -> io::Result<Graph> {
    let mut modules = Modules { by_path: BTreeMap::new() };
    let mut roots = Vec::new();
    let has_library = src.join("lib.rs").exists();
    for file in source::files(src)? {
        let relative = file.strip_prefix(src).unwrap_or(&file);
        let name = relative.to_string_lossy().into_owned();
        let read = Source::read(&std::fs::read_to_string(&file)?);
        match module(relative) {
            Some(path) => _ = modules.by_path.insert(path, (name, read)),
            None if has_library => roots.push((name, read)),
            None => _ = modules.by_path.insert(Vec::new(), (name, read)),
        }
    }
    let mut graph = Graph::new();
    let named = modules.by_path.iter().map(|(path, (name, source))| (path.as_slice(), name, source));
    let binaries = roots.iter().map(|(name, source)| (&[][..], name, source));
    for (path, name, source) in named.chain(binaries) {
        let own = source.uses.iter().filter(|u| !u.public).map(|u| &u.path);
        let targets = own.chain(&source.paths).filter_map(|p| modules.file_of(path, p, 0));
        let imported = targets.filter(|file| file != name).map(str::to_owned).collect();
        graph.insert(name.clone(), imported);
    }
    Ok(graph)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::circles;

    fn crate_of(files: &[(&str, &str)]) -> Graph {
        let dir = tempfile::tempdir().expect("a folder");
        for (name, text) in files {
            let path = dir.path().join(name);
            std::fs::create_dir_all(path.parent().expect("a parent")).expect("a folder");
            std::fs::write(path, text).expect("written");
        }
        imports(dir.path()).expect("read")
    }

    fn of(graph: &Graph, file: &str) -> Vec<String> {
        graph[file].iter().cloned().collect()
    }

    #[test]
    fn re_exports_lead_to_the_file_that_defines() {
        let graph = crate_of(&[
            ("lib.rs", "mod a; mod b;\npub use a::{A, Other};\npub use b::*;"),
            ("a/mod.rs", "mod inner;\npub use inner::A;\npub struct Other;"),
            ("a/inner.rs", "use crate::B;\nuse super::Other;\npub struct A;"),
            ("b.rs", "pub struct B;\npub fn f() -> crate::Unknown { std::crate_name::x() }"),
        ]);
        assert_eq!(of(&graph, "lib.rs"), [""; 0]);
        assert_eq!(of(&graph, "a/mod.rs"), [""; 0]);
        assert_eq!(of(&graph, "a/inner.rs"), ["a/mod.rs", "b.rs"]);
        assert!(circles(&graph).is_empty(), "{graph:?}");
    }

    #[test]
    fn circles_are_seen_through_parents_children_and_paths() {
        let graph = crate_of(&[
            ("lib.rs", "mod a; mod b; mod c;\nuse a::A;\npub struct Root(A);"),
            ("a.rs", "pub struct A;\nfn f() { crate::b::g(); let _ = super::Root; }"),
            ("b.rs", "use crate::c::{self, C};\npub fn g() { c::h() }"),
            (
                "c.rs",
                "pub struct C;\npub fn h() { crate::a::i() }\n#[cfg(test)]\nmod tests { use crate::b; }",
            ),
        ]);
        assert_eq!(of(&graph, "a.rs"), ["b.rs", "lib.rs"]);
        let found = circles(&graph);
        assert_eq!(found.len(), 1);
        assert_eq!(found[0].len(), 4);
    }
}
