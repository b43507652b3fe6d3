//! Checks the architecture: rooms use only rooms on lower floors, and files have no circular dependencies.
//!
//! The scan reads every file in `src/` as tokens. It takes every path in a `use` declaration, and every other path that
//! begins with `crate`, `machband`, `self`, `super` or an imported name, and follows it through imports and re-exports
//! to a file.

use std::{
    collections::{BTreeMap, BTreeSet},
    fs,
    path::{Path, PathBuf},
};

use proc_macro2::{TokenStream, TokenTree};

type Module = Vec<String>;

/// The floor of every room. A room may use only rooms on lower floors. The window, which is one floor in
/// `src/lib.rs`, is divided into several floors here.
const FLOORS: &[(&str, i32)] = &[
    ("text", -1),
    ("system", -1),
    ("light", 0),
    ("statistics", 0),
    ("display", 1),
    ("shading", 1),
    ("vision", 1),
    ("stimulus", 2),
    ("experiment", 3),
    ("analysis", 4),
    ("store", 4),
    ("report", 5),
    ("work", 6),
    ("app/ui", 7),
    ("app/window", 8),
    ("app/analysis", 9),
    ("app/editor", 9),
    ("app/explore", 9),
    ("app/session", 9),
    ("app/display", 10),
    ("app/dialogs", 11),
    ("app/memory", 11),
    ("app/studies", 11),
    ("app", 12),
    ("cli", 12),
];

/// Dependencies that intentionally break the rule: the room, the room that it uses, and the reason.
const EXCEPTIONS: &[(&str, &str, &str)] = &[("cli", "app", "`machband run`, and `machband` alone, open the window")];

/// The source files by module path, with what each of them uses.
#[derive(Default)]
struct House(BTreeMap<Module, Source>);

#[derive(Default)]
struct Source {
    /// Every path in the file, from the crate's root, with its line number.
    paths: Vec<(Module, usize)>,
    /// The names that its `use` declarations import, with the path of each.
    names: BTreeMap<String, Module>,
}

/// A use of one file by another.
struct Edge {
    from: Module,
    line: usize,
    path: Module,
    /// The file that the path leads to; empty if there is none.
    to: Module,
}

#[test]
fn files_use_lower_floors_only_and_never_each_other() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let files = sources(&root).into_iter().map(|file| {
        let text = fs::read_to_string(&file).unwrap();
        (module_of(file.strip_prefix(&root).unwrap()), text)
    });
    let house = House::new(files);
    let edges = house.edges();
    let rooms: BTreeSet<_> = house.0.keys().filter(|module| !module.is_empty()).map(room).collect();
    assert!(rooms.len() >= 5 && edges.len() >= 500, "the scan found too little: {rooms:?}, {}", edges.len());
    let homeless = rooms.iter().filter(|room| floor(room).is_none()).map(|room| format!("src/{room} has no floor"));
    let faults: Vec<String> = homeless.chain(faults_of(&edges)).collect();
    assert!(faults.is_empty(), "\n{}", faults.join("\n"));
    // An exception that is no longer needed could hide a new violation.
    for (from, to, _) in EXCEPTIONS {
        let used = edges.iter().any(|edge| room(&edge.from) == *from && room(&edge.to) == *to);
        assert!(used, "the exception {from} → {to} is no longer needed");
    }
}

/// What reads from the disk.
const READS: [&str; 11] = [
    "entries(",
    "found(",
    "exists(",
    "read_regular(",
    "read_existing(",
    "open_regular(",
    "read_bytes(",
    "read_text(",
    "fs::",
    "canonicalize(",
    "Sidecar::read",
];
/// What forgets an error.
const FORGETS: [&str; 7] = [".ok()", "unwrap_or_default()", ".unwrap_or(", "is_ok", "let _ =", "let Ok(", "Err(_) =>"];
/// Where that is right: files that are no longer needed are removed, and nothing follows if that fails.
const FORGIVEN: [&str; 4] = [
    "let Some(found) = is_ours.then(|| fs::symlink_metadata(&path).ok()).flatten() else",
    "if removed.is_ok() || !exists(&paths.sidecar).unwrap_or(true)",
    "remove_file(",
    "?.unwrap_or_default()",
];

/// An error is not an absence: in the store and the operations, no error of reading is forgotten. `clippy.toml` forbids
/// the standard library's questions that answer false after an error.
#[test]
fn no_error_of_reading_is_forgotten() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let has = |code: &str, any: &[&str]| any.iter().any(|part| code.contains(part));
    let mut forgotten = Vec::new();
    for file in ["store", "work"].iter().flat_map(|room| sources(&root.join(room))) {
        let text = fs::read_to_string(&file).unwrap();
        let code: String = text.lines().map(|line| line.split("//").next().unwrap_or_default()).collect();
        for part in code.split([';', '{', '}']) {
            let part = part.split_whitespace().collect::<Vec<_>>().join(" ");
            if has(&part, &READS) && has(&part, &FORGETS) && !has(&part, &FORGIVEN) {
                forgotten.push(format!("{}: {part}", file.display()));
            }
        }
    }
    assert!(forgotten.is_empty(), "{}", forgotten.join("\n"));
}

/// The scan itself reports what is forbidden, and nothing else.
#[test]
fn forbidden_edges_are_found() {
    for (file, source, number) in [
        ("light/gamma", "use {std::fs, crate::store};", 1),
        ("light/gamma", "fn f<'a>(x: &'a str) -> char { let q = '\"'; crate::store::f(x); '\"' }", 1),
        ("light/gamma", "/// [`crate::store`] and \"use crate::store\"\npub(in crate::light) fn store() {}", 0),
        ("store/x", "use crate::analysis::fit;", 1),
        ("cli/run", "use crate::app::{self, Launch};", 0),
        ("app/session/x", "use super::super::App;", 1),
        ("app/ui/page", "use super::hint;", 0),
        ("app/ui/text", "use super::Own;", 1),
    ] {
        let others = ["light", "analysis", "store", "cli", "app", "app/ui", "app/ui/text"];
        let text = |path: &str| if path == "app/ui" { "pub use text::hint;" } else { "" };
        let files = others.map(|path| (path, text(path))).into_iter().chain([(file, source)]);
        let house = House::new(files.map(|(path, text)| (module_of(Path::new(path)), text.to_owned())));
        let found = faults_of(&house.edges());
        assert_eq!(found.len(), number, "{file}: {source}: {found:?}");
    }
}

/// Returns a message for every violation of the rules.
fn faults_of(edges: &[Edge]) -> Vec<String> {
    let mut faults = Vec::new();
    let mut uses: BTreeMap<&Module, BTreeSet<&Module>> = BTreeMap::new();
    for Edge { from, line, path, to } in edges {
        uses.entry(from).or_default().insert(to);
        let (low, high) = (room(from), if to.is_empty() { room(path) } else { room(to) });
        if low == high || EXCEPTIONS.iter().any(|(a, b, _)| *a == low && *b == high) {
            continue;
        }
        let why = match (floor(&low), floor(&high)) {
            (Some(low), Some(high)) if high > low => format!("floor {low} uses floor {high}"),
            (Some(low), Some(high)) if high == low => format!("both are on floor {low}"),
            (Some(_), Some(_)) => continue,
            _ => "not a room with a floor in tests/layers.rs".to_owned(),
        };
        faults.push(format!("src/{}:{line}: {low} → {high}: {why}", from.join("/")));
    }
    faults.extend(circles(&uses));
    faults
}

/// Returns the room of a file: its top-level module or, in the window, its folder in `app`.
fn room(module: &Module) -> String {
    let parts = if module.first().is_some_and(|top| top == "app") { 2 } else { 1 };
    module.iter().take(parts).cloned().collect::<Vec<_>>().join("/")
}

fn floor(room: &str) -> Option<i32> {
    FLOORS.iter().find(|(name, _)| *name == room).map(|(_, floor)| *floor)
}

/// Returns a message for each group of files that use each other, directly or through other files.
fn circles(uses: &BTreeMap<&Module, BTreeSet<&Module>>) -> Vec<String> {
    let reach = |start| {
        let (mut found, mut next) = (BTreeSet::new(), vec![start]);
        while let Some(module) = next.pop() {
            let fresh = uses.get(module).into_iter().flatten().filter(|to| found.insert(**to));
            next.extend(fresh.collect::<Vec<_>>());
        }
        found
    };
    let reached: BTreeMap<_, _> = uses.keys().map(|module| (*module, reach(*module))).collect();
    let circle = |module: &&Module| -> Vec<String> {
        let both = reached[*module].iter().filter(|other| reached.get(**other).is_some_and(|r| r.contains(*module)));
        both.map(|other| other.join("/")).collect()
    };
    let found: BTreeSet<Vec<String>> = reached.keys().map(circle).filter(|circle| !circle.is_empty()).collect();
    found.iter().map(|circle| format!("these files use each other in a circle: {}", circle.join(", "))).collect()
}

impl House {
    fn new(files: impl Iterator<Item = (Module, String)>) -> Self {
        let mut house = Self::default();
        for (module, text) in files {
            let mut tokens = Vec::new();
            flatten(text.parse().unwrap(), &mut tokens);
            house.0.insert(module.clone(), Source::read(&tokens, &module));
        }
        house
    }

    /// Returns every use of one file by another.
    fn edges(&self) -> Vec<Edge> {
        let mut edges = Vec::new();
        // `lib.rs` and `main.rs`, the roots of the library and the program, have no floor.
        for (from, source) in self.0.iter().filter(|(module, _)| !module.is_empty()) {
            for (path, line) in &source.paths {
                let to = self.resolve(path, 0);
                if to != *from {
                    edges.push(Edge { from: from.clone(), line: *line, path: path.clone(), to });
                }
            }
        }
        edges
    }

    /// Returns the file that a path leads to, following imports and re-exports.
    fn resolve(&self, path: &[String], depth: usize) -> Module {
        let mut at = Module::new();
        for (i, part) in path.iter().enumerate() {
            at.push(part.clone());
            if self.0.contains_key(&at) {
                continue;
            }
            at.pop();
            // If the module imports or re-exports this name, continue with the path that the name stands for. If that
            // is the same path again, stop, because following it would never end.
            let elsewhere = self.0.get(&at).and_then(|source| source.names.get(part));
            if let Some(target) = elsewhere.filter(|target| depth < 8 && target[..] != path[..=i]) {
                let whole: Module = target.iter().chain(&path[i + 1..]).cloned().collect();
                return self.resolve(&whole, depth + 1);
            }
            break;
        }
        at
    }
}

impl Source {
    fn read(tokens: &[(String, usize)], module: &Module) -> Self {
        let mut source = Self::default();
        let mut i = 0;
        while i < tokens.len() {
            let text = |j: usize| tokens.get(j).map_or("", |(text, _)| text.as_str());
            let begins = i == 0 || text(i - 1) != "::";
            match text(i) {
                // In an inline module, `super` would be a different module than the scan assumes.
                "mod" if text(i + 2) == "{" => panic!("{}: contains an inline module; expected none", module.join("/")),
                "use" => {
                    i = source.tree(tokens, i + 1, module.clone(), true, true);
                    continue;
                }
                // `pub(in crate::room)` does not use that room.
                "crate" | "machband" | "super" | "self" if begins && (i == 0 || text(i - 1) != "in") => {
                    i = source.tree(tokens, i, module.clone(), true, false);
                    continue;
                }
                // A path that begins with an imported name.
                name if begins && text(i + 1) == "::" && source.names.contains_key(name) => {
                    i = source.tree(tokens, i + 2, source.names[name].clone(), false, false);
                    continue;
                }
                _ => {}
            }
            i += 1;
        }
        source
    }

    /// Reads the path, or the tree of paths, that begins at token `i` and is relative to the module `path`. Returns the
    /// index of the next token. A path into another crate stays relative to the module and leads to no other file.
    ///
    /// `first` is true where `crate` or `machband` may begin the path; `is_use` is true in a `use` declaration.
    fn tree(
        &mut self,
        tokens: &[(String, usize)],
        mut i: usize,
        mut path: Module,
        mut first: bool,
        is_use: bool,
    ) -> usize {
        let text = |j: usize| tokens.get(j).map_or("", |(text, _)| text.as_str());
        let line = tokens.get(i).map_or(0, |(_, line)| *line);
        // Without `::`, these words use no other module: they occur in `pub(crate)` and `pub(super)`, or as `self`.
        let alone = matches!(text(i), "crate" | "machband" | "super" | "self") && text(i + 1) != "::";
        loop {
            match text(i) {
                "{" => {
                    i += 1;
                    while i < tokens.len() && text(i) != "}" {
                        i = self.tree(tokens, i, path.clone(), first, is_use).max(i + 1);
                    }
                    return i + 1;
                }
                "crate" | "machband" if first => path.clear(),
                "super" => _ = path.pop(),
                "self" => {}
                name if is_name(name) || name == "*" => path.push(name.to_owned()),
                _ => return i,
            }
            first = false;
            i += 1;
            if text(i) != "::" {
                break;
            }
            i += 1;
        }
        let mut name = path.last().cloned().unwrap_or_default();
        let renamed = text(i) == "as";
        if renamed {
            name = text(i + 1).to_owned();
            i += 2;
        }
        if !alone || renamed {
            if is_use {
                self.names.insert(name, path.clone());
            }
            self.paths.push((path, line));
        }
        i
    }
}

fn is_name(text: &str) -> bool {
    text.starts_with(|c: char| c.is_alphabetic() || c == '_')
}

/// Appends the names, brackets and punctuation marks with their line numbers, and `::` as one token. Every literal
/// becomes `""`; comments and lifetimes are omitted.
fn flatten(stream: TokenStream, tokens: &mut Vec<(String, usize)>) {
    let mut lifetime = false;
    for token in stream {
        let line = token.span().start().line;
        match token {
            TokenTree::Group(group) => {
                let text = format!("{:?}", group.delimiter());
                let [open, close] = match text.as_str() {
                    "Parenthesis" => ["(", ")"],
                    "Brace" => ["{", "}"],
                    "Bracket" => ["[", "]"],
                    _ => ["", ""],
                };
                tokens.push((open.to_owned(), line));
                flatten(group.stream(), tokens);
                tokens.push((close.to_owned(), group.span_close().start().line));
            }
            TokenTree::Ident(_) if std::mem::take(&mut lifetime) => {}
            TokenTree::Ident(name) => tokens.push((name.to_string(), line)),
            TokenTree::Punct(mark) if mark.as_char() == '\'' => lifetime = true,
            TokenTree::Punct(mark) => match tokens.last_mut() {
                Some((last, at)) if last == ":" && mark.as_char() == ':' && *at == line => *last = "::".to_owned(),
                _ => tokens.push((mark.to_string(), line)),
            },
            TokenTree::Literal(_) => tokens.push(("\"\"".to_owned(), line)),
        }
    }
}

/// Returns the Rust files in a folder and its subfolders, in a fixed order.
fn sources(folder: &Path) -> Vec<PathBuf> {
    let mut entries: Vec<_> = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    entries.sort();
    let below = |path: PathBuf| match path.extension() {
        None if path.is_dir() => sources(&path),
        Some(extension) if extension == "rs" => vec![path],
        _ => Vec::new(),
    };
    entries.into_iter().flat_map(below).collect()
}

/// `app/home.rs` is `app::home`, `app/mod.rs` is `app`; `lib.rs` and `main.rs` are the root.
fn module_of(file: &Path) -> Module {
    let mut module: Module = file.with_extension("").iter().map(|part| part.to_string_lossy().into_owned()).collect();
    if matches!(module.last().map(String::as_str), Some("mod" | "lib" | "main")) {
        module.pop();
    }
    module
}
