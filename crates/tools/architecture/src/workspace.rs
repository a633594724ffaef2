//! The members of a workspace and what they depend on.

use crate::source;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// A member.
#[derive(Debug, Clone)]
pub struct Package {
    /// As in its manifest.
    pub name: String,
    /// Its folder.
    pub folder: PathBuf,
    /// Members it depends on, for whatever target.
    pub dependencies: BTreeSet<String>,
    /// Members that its tests, examples and benches depend on besides.
    pub dev_dependencies: BTreeSet<String>,
}

/// Lines that are neither blank nor comment.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Lines {
    /// Of `src`, without test modules.
    pub code: usize,
    /// Of test modules, `tests`, `benches` and `examples`.
    pub tests: usize,
}

impl Package {
    /// Lines of this package, without those of packages in folders below it.
    ///
    /// # Errors
    /// A file that cannot be read.
    pub fn lines(&self) -> std::io::Result<Lines> {
        let mut lines = Lines::default();
        for file in source::files(&self.folder.join("src"))? {
            let text = std::fs::read_to_string(&file)?;
            let (all, code) = (source::lines(&text), source::lines(&source::without_tests(&text)));
            // `tests.rs` and `soc_tests.rs` are modules of tests only
            let of_tests = file.file_stem().is_some_and(|stem| stem.to_string_lossy().ends_with("tests"));
            let code = if of_tests { 0 } else { code };
            lines = Lines { code: lines.code + code, tests: lines.tests + all - code };
        }
        for folder in ["tests", "benches", "examples"] {
            for file in source::files(&self.folder.join(folder))? {
                lines.tests += source::lines(&std::fs::read_to_string(file)?);
            }
        }
        Ok(lines)
    }
}

fn manifest(folder: &Path) -> Result<toml::Table, String> {
    let path = folder.join("Cargo.toml");
    let text = std::fs::read_to_string(&path).map_err(|e| format!("{}: {e}", path.display()))?;
    text.parse().map_err(|e| format!("{}: {e}", path.display()))
}

/// Folders of the members: `members` of the workspace at `root`, with `*` at the end of a path for every folder.
fn members(root: &Path, manifest: &toml::Table) -> Result<Vec<PathBuf>, String> {
    let listed = manifest.get("workspace").and_then(|w| w.get("members")).and_then(toml::Value::as_array);
    let mut folders = Vec::new();
    for member in listed.ok_or("no workspace members")? {
        let member = member.as_str().ok_or("a member that is no text")?;
        let Some(parent) = member.strip_suffix("/*") else {
            folders.push(root.join(member));
            continue;
        };
        let entries = std::fs::read_dir(root.join(parent)).map_err(|e| format!("{parent}: {e}"))?;
        let mut inside: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).collect();
        inside.retain(|path| path.join("Cargo.toml").exists());
        inside.sort();
        folders.extend(inside);
    }
    Ok(folders)
}

/// Keys of every table of this kind: of the package and of its targets, with the package each stands for.
fn depended_on(manifest: &toml::Table, workspace: &toml::Table, kinds: &[&str]) -> BTreeSet<String> {
    let targets = manifest.get("target").and_then(toml::Value::as_table);
    let tables = targets.into_iter().flat_map(|t| t.values().filter_map(toml::Value::as_table));
    let mut out = BTreeSet::new();
    for table in std::iter::once(manifest).chain(tables) {
        for kind in kinds {
            for (key, value) in table.get(*kind).and_then(toml::Value::as_table).into_iter().flatten() {
                let renamed = value.get("package").and_then(toml::Value::as_str);
                let shared = || {
                    let shared = workspace.get("dependencies")?.get(key)?;
                    shared.get("package")?.as_str()
                };
                out.insert(renamed.or_else(shared).unwrap_or(key).to_owned());
            }
        }
    }
    out
}

/// The members of the workspace at `root`, in the order of its manifest.
///
/// # Errors
/// A manifest that cannot be read; which, and why.
pub fn packages(root: &Path) -> Result<Vec<Package>, String> {
    let top = manifest(root)?;
    let empty = toml::Table::new();
    let workspace = top.get("workspace").and_then(toml::Value::as_table).unwrap_or(&empty);
    let mut found = Vec::new();
    for folder in members(root, &top)? {
        let own = manifest(&folder)?;
        let name = own.get("package").and_then(|p| p.get("name")).and_then(toml::Value::as_str);
        let name = name.ok_or_else(|| format!("{}: a package without a name", folder.display()))?;
        found.push(Package {
            name: name.to_owned(),
            dependencies: depended_on(&own, workspace, &["dependencies", "build-dependencies"]),
            dev_dependencies: depended_on(&own, workspace, &["dev-dependencies"]),
            folder,
        });
    }
    let names: BTreeSet<String> = found.iter().map(|p| p.name.clone()).collect();
    for package in &mut found {
        package.dependencies.retain(|d| names.contains(d));
        let (normal, own) = (&package.dependencies, &package.name);
        package.dev_dependencies.retain(|d| names.contains(d) && !normal.contains(d) && d != own);
    }
    Ok(found)
}
