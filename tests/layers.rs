//! The floors of the program, the rooms of the window, and that no files use each other in a circle.
//!
//! Reads `src/` as tokens and follows every path that starts at `crate`, `machband`, `self`, `super`, a module beside it
//! or an imported name, through re-exports, to the file that it ends in.

use std::{
    collections::{BTreeMap, BTreeSet},
    fs,
    path::{Path, PathBuf},
};

use proc_macro2::{TokenStream, TokenTree};

type Module = Vec<String>;

/// Every room and its floor: it uses lower floors only.
const FLOORS: &[(&str, u32)] = &[
    ("light", 0),
    ("display", 1),
    ("shading", 1),
    ("vision", 1),
    ("stimulus", 2),
    ("experiment", 3),
    ("analysis", 4),
    ("store", 4),
    ("report", 5),
    ("app/ui", 6),
    ("app/window", 7),
    ("app/analysis", 8),
    ("app/explore", 8),
    ("app/session", 8),
    ("app/display", 9),
    ("app/start", 10),
    ("app", 11),
    ("cli", 11),
];

/// Edges that the rule forbids and that are meant, each with its reason.
const EXCEPTIONS: &[(&str, &str, &str)] = &[("cli", "app", "`machband run`, and `machband` alone, open the window")];

/// The program's files by the module that each is, and what each of them uses.
#[derive(Default)]
struct House(BTreeMap<Module, Source>);

#[derive(Default)]
struct Source {
    /// Every path in it from the crate's root, and the line that it is in.
    paths: Vec<(Module, usize)>,
    /// What its `use` declarations bring in.
    names: BTreeMap<String, Module>,
}

/// A use of a file by another.
struct Edge {
    from: Module,
    line: usize,
    path: Module,
    /// The file that the path ends in; empty where there is none.
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
    assert!(rooms.len() >= 5 && edges.len() >= 500, "found too little to be right: {rooms:?}, {}", edges.len());
    let homeless = rooms.iter().filter(|room| floor(room).is_none()).map(|room| format!("src/{room} has no floor"));
    let faults: Vec<String> = homeless.chain(faults_of(&edges)).collect();
    assert!(faults.is_empty(), "\n{}", faults.join("\n"));
    // An exception that nothing uses any more would hide the next one.
    for (from, to, _) in EXCEPTIONS {
        let used = edges.iter().any(|edge| room(&edge.from) == *from && room(&edge.to) == *to);
        assert!(used, "the exception {from} → {to} is no longer needed");
    }
}

/// The scan would be worth nothing if it saw nothing.
#[test]
fn forbidden_edges_are_found() {
    let faults = |file: &str, source: &str| {
        let others =
            "light light/image display analysis shading store store/results cli app app/ui app/ui/text app/start";
        let text = |path: &str| if path == "app/ui" { "pub use text::hint;" } else { "" };
        let others = others.split(' ').map(|path| (path, text(path)));
        let files = others.chain([(file, source)]);
        let house = House::new(files.map(|(path, text)| (module_of(Path::new(path)), text.to_owned())));
        faults_of(&house.edges())
    };
    for upward in [
        "use crate::store;",
        "use crate::store::results::ResultFile;",
        "use crate::{\n    light::Depth,\n    store::{StoreError, session::SessionStore},\n};",
        "use {std::fs, crate::store};",
        "fn f() { crate::store::check(); }",
        "use super::super::store;",
        "use super::{image, super::store::results};",
        "use self::super::super::store;",
        "fn f<'a>(x: &'a str) -> char { let q = '\"'; crate::store::f(x); '\"' }",
        "fn f() { let x = machband::store::check(); }",
        "macro_rules! m { () => { $crate::store::f() } }",
    ] {
        let found = faults("light/gamma", upward);
        let all_up = found.iter().all(|fault| fault.contains("light → store: floor 0 uses floor 4"));
        assert!(!found.is_empty() && all_up, "{upward}: {found:?}");
    }
    for fine in [
        "/// [`crate::store`] and \"use crate::store\"\nfn f() {}",
        "use super::image::CodeImage; pub(crate) fn f() {} pub(super) fn g() {} pub(in crate::light) fn h() {}",
        "use crate::light::{Depth, gamma};",
        "fn store() {} fn f() { store(); other::crate_::store(); }",
    ] {
        assert_eq!(faults("light/gamma", fine), Vec::<String>::new(), "{fine}");
    }
    for (file, source, number) in [
        // Siblings, and the exception in its one direction only.
        ("store/x", "use crate::analysis::fit;", 1),
        ("display/x", "use crate::shading;", 1),
        ("app/ui/x", "use crate::cli;", 1),
        ("cli/run", "use crate::app::{self, Launch};", 0),
        // Rooms of the window: a page may use the vocabulary, and nothing the App.
        ("app/session/x", "use crate::app::ui::{self, Step}; fn f() { ui::hint(); }", 0),
        ("app/ui/x", "use crate::app::start::Form;", 1),
        ("app/session/x", "use super::super::App;", 1),
        // What cannot be followed is not let through.
        ("light/gamma", "use crate::*;", 1),
        ("light/gamma", "use crate as root;", 1),
        ("light/gamma", "use crate::attic::Thing;", 1),
        // Through the re-export of its room's door, two files of a room.
        ("app/ui/page", "use super::hint;", 0),
        ("app/ui/text", "use super::Own;", 1),
    ] {
        assert_eq!(faults(file, source).len(), number, "{file}: {source}: {:?}", faults(file, source));
    }
}

/// Everything that is wrong with these edges.
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

/// The room of a file: its top-level module, or the folder within the window.
fn room(module: &Module) -> String {
    let parts = if module.first().is_some_and(|top| top == "app") { 2 } else { 1 };
    module.iter().take(parts).cloned().collect::<Vec<_>>().join("/")
}

fn floor(room: &str) -> Option<u32> {
    FLOORS.iter().find(|(name, _)| *name == room).map(|(_, floor)| *floor)
}

/// Files that use each other, directly or over others.
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

    /// Every use of a file by another.
    fn edges(&self) -> Vec<Edge> {
        let mut edges = Vec::new();
        // The roots of library and program only name the modules.
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

    /// The file that a path leads to.
    fn resolve(&self, path: &[String], depth: usize) -> Module {
        let mut at = Module::new();
        for (i, part) in path.iter().enumerate() {
            at.push(part.clone());
            if self.0.contains_key(&at) {
                continue;
            }
            at.pop();
            // A name that the module has from elsewhere; not its own, which a name in `use super::Name` would be again.
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
                // There `super` would be another module than the scan takes it for.
                "mod" if text(i + 2) == "{" => panic!("{}: a module within a file; expected none", module.join("/")),
                "use" => {
                    i = source.tree(tokens, i + 1, module.clone(), true, true);
                    continue;
                }
                // `pub(in crate::room)` is no use of it.
                "crate" | "machband" | "super" | "self" if begins && (i == 0 || text(i - 1) != "in") => {
                    i = source.tree(tokens, i, module.clone(), true, false);
                    continue;
                }
                // A name that was imported.
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

    /// Follows the tree of paths at `i` from the module `path`; gives where it ends. What is not of this crate stays
    /// below the module itself, and leads nowhere. `first` where `crate` and the like may stand.
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
        // `crate` alone stands in `pub(crate)`; `self` and `super` alone name no other module.
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

/// Names, `::` and single marks with their lines; no comments, strings, characters or lifetimes.
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

/// `src/` in a fixed order.
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
