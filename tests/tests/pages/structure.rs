//! A file imports only from files below it: no circle of files in any crate.
//!
//! An arrow is a path in a `use`, a type or an expression of one file that leads to an item of another. A
//! path to a re-exported name leads to the file that re-exports it. Unit tests at the end of a file do not
//! count.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use syn::visit::{self, Visit};

/// Files of one crate by module path, `["laws", "linear"]`; the root is `[]`.
type Modules = BTreeMap<Vec<String>, PathBuf>;

/// Arrows of one crate: file, and the files it imports from.
type Arrows = BTreeMap<Vec<String>, BTreeSet<Vec<String>>>;

#[test]
fn no_circle_of_files() {
    let tests = std::env::var("CARGO_MANIFEST_DIR").expect("cargo names the folder of the package");
    let sources = sources(&Path::new(&tests).join(".."));
    assert!(sources.len() >= 4, "crates found: {sources:?}");
    let mut found = String::new();
    for source in sources {
        let modules = modules(&source);
        let arrows: Arrows =
            modules.iter().map(|(module, file)| (module.clone(), imports(module, file, &modules))).collect();
        for circle in circles(&arrows) {
            found +=
                &format!("{}: {} files import each other in a circle:\n", source.display(), circle.len());
            for module in &circle {
                let into = arrows[module].intersection(&circle).map(|to| name(to)).collect::<Vec<_>>();
                found += &format!("  {} -> {}\n", name(module), into.join(", "));
            }
        }
    }
    assert!(found.is_empty(), "{found}");
}

#[test]
fn a_circle_is_found() {
    let path = |name: &str| vec![name.to_owned()];
    let arrows: Arrows = [("a", "b"), ("b", "c"), ("c", "a"), ("d", "a")]
        .map(|(from, to)| (path(from), BTreeSet::from([path(to)])))
        .into();
    assert_eq!(circles(&arrows), [BTreeSet::from(["a", "b", "c"].map(path))]);
}

/// Every folder `src` of the workspace.
fn sources(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).expect("the workspace can be read");
    let mut found = Vec::new();
    for path in entries.map(|entry| entry.expect("an entry").path()).filter(|path| path.is_dir()) {
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        if name == "src" {
            found.push(path);
        } else if !name.starts_with('.') && name != "target" {
            found.extend(sources(&path));
        }
    }
    found
}

fn modules(source: &Path) -> Modules {
    let mut found = Modules::new();
    collect(source, &[], &mut found);
    found
}

fn collect(folder: &Path, module: &[String], found: &mut Modules) {
    for entry in std::fs::read_dir(folder).expect("a folder of sources") {
        let path = entry.expect("an entry").path();
        let stem = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let mut inner = module.to_vec();
        if path.is_dir() {
            inner.push(stem);
            collect(&path, &inner, found);
        } else if path.extension().is_some_and(|end| end == "rs") {
            if !["mod", "lib", "main"].contains(&stem.as_str()) {
                inner.push(stem);
            }
            // A program beside its library stands alone.
            if !path.ends_with("src/main.rs") {
                found.insert(inner, path);
            }
        }
    }
}

/// The files that `module` imports from.
fn imports(module: &[String], file: &Path, modules: &Modules) -> BTreeSet<Vec<String>> {
    let text = std::fs::read_to_string(file).expect("a source");
    let parsed = syn::parse_file(&text).unwrap_or_else(|error| panic!("{}: {error}", file.display()));
    let mut paths = Paths { module: module.to_vec(), found: Vec::new() };
    paths.visit_file(&parsed);
    let file_of = |path: &Vec<String>| {
        (0..=path.len()).rev().map(|end| path[..end].to_vec()).find(|module| modules.contains_key(module))
    };
    let mut files: BTreeSet<_> = paths.found.iter().filter_map(file_of).collect();
    files.remove(module);
    files
}

/// Every path from the root of the crate in one file.
struct Paths {
    module: Vec<String>,
    found: Vec<Vec<String>>,
}

impl Paths {
    /// `words` as a path from the root of the crate, if it is one of this crate.
    fn absolute(&self, words: &[String]) -> Option<Vec<String>> {
        let (first, rest) = words.split_first()?;
        let mut base = self.module.clone();
        let mut rest = rest;
        match first.as_str() {
            "crate" => base.clear(),
            "self" => {}
            "super" => {
                base.pop();
                while let Some((next, after)) = rest.split_first().filter(|(next, _)| *next == "super") {
                    debug_assert_eq!(next, "super");
                    base.pop();
                    rest = after;
                }
            }
            _ => return None,
        }
        base.extend_from_slice(rest);
        Some(base)
    }

    fn tree(&mut self, tree: &syn::UseTree, words: &mut Vec<String>) {
        match tree {
            syn::UseTree::Path(path) => {
                words.push(path.ident.to_string());
                self.tree(&path.tree, words);
                words.pop();
            }
            syn::UseTree::Name(leaf) => self.leaf(&leaf.ident, words),
            syn::UseTree::Rename(leaf) => self.leaf(&leaf.ident, words),
            syn::UseTree::Glob(_) => self.found.extend(self.local(words)),
            syn::UseTree::Group(group) => group.items.iter().for_each(|item| self.tree(item, words)),
        }
    }

    fn leaf(&mut self, ident: &syn::Ident, words: &[String]) {
        let mut words = words.to_vec();
        if ident != "self" {
            words.push(ident.to_string());
        }
        self.found.extend(self.local(&words));
    }

    /// A path of a `use`, which may begin with a child of this module.
    fn local(&self, words: &[String]) -> Option<Vec<String>> {
        self.absolute(words).or_else(|| Some(self.module.iter().chain(words).cloned().collect()))
    }
}

impl<'ast> Visit<'ast> for Paths {
    fn visit_item_mod(&mut self, item: &'ast syn::ItemMod) {
        if item.ident != "tests" {
            visit::visit_item_mod(self, item);
        }
    }

    fn visit_item_use(&mut self, item: &'ast syn::ItemUse) {
        self.tree(&item.tree, &mut Vec::new());
    }

    fn visit_path(&mut self, path: &'ast syn::Path) {
        let words: Vec<String> = path.segments.iter().map(|segment| segment.ident.to_string()).collect();
        if words.len() > 1 {
            self.found.extend(self.absolute(&words));
        }
        visit::visit_path(self, path);
    }
}

/// Sets of modules that reach each other.
fn circles(arrows: &Arrows) -> Vec<BTreeSet<Vec<String>>> {
    let reach = |from: &Vec<String>| {
        let (mut seen, mut next) = (BTreeSet::new(), vec![from.clone()]);
        while let Some(module) = next.pop() {
            for to in arrows.get(&module).into_iter().flatten() {
                if seen.insert(to.clone()) {
                    next.push(to.clone());
                }
            }
        }
        seen
    };
    let reached: BTreeMap<_, _> = arrows.keys().map(|module| (module, reach(module))).collect();
    let mut found: Vec<BTreeSet<Vec<String>>> = Vec::new();
    for (module, ahead) in reached.iter().filter(|(module, ahead)| ahead.contains(**module)) {
        if !found.iter().any(|circle| circle.contains(*module)) {
            let back =
                |other: &&Vec<String>| reached.get(*other).is_some_and(|there| there.contains(*module));
            found.push(ahead.iter().filter(back).cloned().collect());
        }
    }
    found
}

fn name(module: &[String]) -> String {
    if module.is_empty() { "lib".to_owned() } else { module.join("/") }
}
