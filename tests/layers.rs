//! The floors of the program: a module uses only modules of lower floors.
//!
//! Reads `src/` as text, with comments, strings and characters taken out, and follows every path that starts at
//! `crate`, `machband`, `self` or `super` to the top-level module that it enters.

use std::{
    collections::{BTreeMap, BTreeSet},
    fs,
    path::{Path, PathBuf},
};

/// Every top-level module and its floor.
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
    ("app", 6),
    ("cli", 6),
];

/// Edges that the rule forbids and that are meant, each with its reason.
const EXCEPTIONS: &[(&str, &str, &str)] = &[("cli", "app", "`machband run`, and `machband` alone, open the window")];

/// One use of a module by another.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Edge {
    from: String,
    to: String,
    file: String,
    line: usize,
}

#[test]
fn modules_use_lower_floors_only() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut edges = Vec::new();
    let mut seen = BTreeSet::new();
    for file in sources(&root) {
        let within = file.strip_prefix(&root).unwrap();
        let module = module_of(within);
        // The roots of library and program only name the modules.
        let Some(top) = module.first().cloned() else { continue };
        seen.insert(top);
        edges.extend(edges_of(&fs::read_to_string(&file).unwrap(), &module, &within.display().to_string()));
    }
    assert!(
        seen.len() >= 5 && edges.len() >= 10,
        "the scan found too little to be right: {seen:?}, {} edges",
        edges.len()
    );
    let mut faults: Vec<_> = seen
        .iter()
        .filter(|name| floor(name).is_none())
        .map(|name| format!("src/{name}: has no floor in tests/layers.rs"))
        .collect();
    faults.extend(faults_of(&edges));
    assert!(faults.is_empty(), "\n{}", faults.join("\n"));
    // An exception that nothing uses any more would hide the next one.
    for (from, to, _) in EXCEPTIONS {
        assert!(
            edges.iter().any(|edge| edge.from == *from && edge.to == *to),
            "the exception {from} → {to} is no longer needed"
        );
    }
}

/// The scan would be worth nothing if it saw nothing.
#[test]
fn forbidden_edges_are_found() {
    let faults = |module: &[&str], source: &str| {
        let module: Vec<_> = module.iter().map(|part| (*part).to_owned()).collect();
        faults_of(&edges_of(source, &module, "fabricated.rs"))
    };
    let light: &[&str] = &["light", "gamma"];
    for upward in [
        "use crate::store;",
        "use crate::store::results::ResultFile;",
        "use crate::{\n    light::Depth,\n    store::{StoreError, session::SessionStore},\n};",
        "use {std::fs, crate::store};",
        "fn f() { crate::store::check(); }",
        "use super::super::store;",
        "use super::{image, super::store::results};",
        "mod tests { use super::super::super::store; }",
        "use self::super::super::store;",
        "fn f<'a>(x: &'a str) -> char { let q = '\"'; crate::store::f(x); '\"' }",
        "const A: &str = r#\"a \" quote\"#; use crate::store;",
        "fn f() { let x = machband::store::check(); }",
        "macro_rules! m { () => { $crate::store::f() } }",
        "pub(in crate::store) fn f() {}",
    ] {
        let found = faults(light, upward);
        assert!(!found.is_empty(), "{upward}: not found");
        assert!(found.iter().all(|fault| fault.contains("light → store: floor 0 uses floor 4")), "{upward}: {found:?}");
    }
    for fine in [
        "// use crate::store;",
        "/// [`crate::store`] and \"use crate::store\"\nfn f() {}",
        "/* a /* nested */ crate::store */ fn f() {}",
        "const A: &str = \"\\\" crate::store\";",
        "const A: &str = r##\"crate::store \"# \"##;",
        "const A: &[u8] = b\"crate::store\";",
        "use super::image::CodeImage; pub(crate) fn f() {} pub(super) fn g() {}",
        "mod tests { use super::super::image; }",
        "use crate::light::{Depth, gamma};",
        "fn store() {} fn f() { store(); other::crate_::store(); }",
    ] {
        assert_eq!(faults(light, fine), Vec::<String>::new(), "{fine}");
    }
    // Siblings, and the exception in its one direction only.
    assert_eq!(faults(&["store"], "use crate::analysis::fit;").len(), 1);
    assert_eq!(faults(&["display"], "use crate::shading;").len(), 1);
    assert_eq!(faults(&["app", "home"], "use crate::cli;").len(), 1);
    assert_eq!(faults(&["cli", "run"], "use crate::app::{self, Launch};").len(), 0);
    // What cannot be followed is not let through.
    assert_eq!(faults(light, "use crate::*;").len(), 1);
    assert_eq!(faults(light, "use crate as root;").len(), 1);
    assert_eq!(faults(light, "use crate::attic::Thing;").len(), 1);
    // A ring is named, also where an exception would let its parts through.
    let edge = |from: &str, to: &str| Edge { from: from.into(), to: to.into(), file: "f".into(), line: 1 };
    assert!(ring(&[edge("cli", "app"), edge("app", "store"), edge("store", "light")]).is_none());
    assert!(ring(&[edge("cli", "app"), edge("app", "store"), edge("store", "cli")]).is_some());
}

fn floor(module: &str) -> Option<u32> {
    FLOORS.iter().find(|(name, _)| *name == module).map(|(_, floor)| *floor)
}

/// Everything that is wrong with a set of edges.
fn faults_of(edges: &[Edge]) -> Vec<String> {
    let mut faults = Vec::new();
    for Edge { from, to, file, line } in edges {
        if EXCEPTIONS.iter().any(|(a, b, _)| a == from && b == to) {
            continue;
        }
        let why = match (floor(from), floor(to)) {
            (Some(low), Some(high)) if high > low => format!("floor {low} uses floor {high}"),
            (Some(low), Some(high)) if high == low => format!("both are on floor {low}"),
            (Some(_), Some(_)) => continue,
            _ => "not a module with a floor in tests/layers.rs".to_owned(),
        };
        faults.push(format!("src/{file}:{line}: {from} → {to}: {why}"));
    }
    faults.extend(ring(edges).map(|ring| format!("modules use each other in a ring: {}", ring.join(" → "))));
    faults
}

/// A cycle, if there is one.
fn ring(edges: &[Edge]) -> Option<Vec<String>> {
    let mut uses: BTreeMap<&str, BTreeSet<&str>> = BTreeMap::new();
    for edge in edges {
        uses.entry(&edge.from).or_default().insert(&edge.to);
    }
    fn visit<'a>(at: &'a str, uses: &BTreeMap<&'a str, BTreeSet<&'a str>>, path: &mut Vec<&'a str>) -> bool {
        let again = path.contains(&at);
        path.push(at);
        if again || uses.get(at).is_some_and(|next| next.iter().any(|to| visit(to, uses, path))) {
            return true;
        }
        path.pop();
        false
    }
    uses.keys().find_map(|start| {
        let mut path = Vec::new();
        visit(start, &uses, &mut path).then(|| path.iter().map(|part| (*part).to_owned()).collect())
    })
}

/// `src/` in a fixed order.
fn sources(folder: &Path) -> Vec<PathBuf> {
    let mut entries: Vec<_> = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    entries.sort();
    entries
        .into_iter()
        .flat_map(|path| match path.is_dir() {
            true => sources(&path),
            false if path.extension().is_some_and(|extension| extension == "rs") => vec![path],
            false => Vec::new(),
        })
        .collect()
}

/// `app/home.rs` is `app::home`, `app/mod.rs` is `app`; `lib.rs` and `main.rs` are the root.
fn module_of(file: &Path) -> Vec<String> {
    let mut module: Vec<_> = file.with_extension("").iter().map(|part| part.to_string_lossy().into_owned()).collect();
    if module.last().is_some_and(|last| last == "mod")
        || matches!(module.as_slice(), [only] if only == "lib" || only == "main")
    {
        module.pop();
    }
    module
}

/// The uses of other top-level modules in a source file of `module`.
fn edges_of(source: &str, module: &[String], file: &str) -> Vec<Edge> {
    let tokens = tokens(source);
    let mut edges = Vec::new();
    // Inline modules around the place, each with the depth of braces outside it.
    let mut here = module.to_vec();
    let mut inline: Vec<usize> = Vec::new();
    let mut depth = 0;
    let mut i = 0;
    while i < tokens.len() {
        let text = tokens[i].text.as_str();
        match text {
            "mod" if tokens.get(i + 2).is_some_and(|token| token.text == "{") => {
                here.push(tokens[i + 1].text.clone());
                inline.push(depth);
                depth += 1;
                i += 3;
                continue;
            }
            "{" => depth += 1,
            "}" => {
                depth -= 1;
                if inline.last() == Some(&depth) {
                    inline.pop();
                    here.pop();
                }
            }
            "crate" | "machband" | "super" | "self"
                if i == 0 || tokens[i - 1].text != "::" || !is_name(&tokens, i.wrapping_sub(2)) =>
            {
                let base = if text == "super" || text == "self" { here.clone() } else { Vec::new() };
                let mut targets = Vec::new();
                i = follow(&tokens, i, base, true, &mut targets);
                for (target, line) in targets {
                    if target != module[0] {
                        edges.push(Edge { from: module[0].clone(), to: target, file: file.to_owned(), line });
                    }
                }
                continue;
            }
            _ => {}
        }
        i += 1;
    }
    edges
}

fn is_name(tokens: &[Token], i: usize) -> bool {
    tokens.get(i).is_some_and(|token| token.text.starts_with(|c: char| c.is_alphanumeric() || c == '_'))
}

/// Follows the path at `i` from module `at`; gives the first module of every path that it spreads into, and where it
/// ends. `start` where the path begins with a keyword that has a meaning of its own.
fn follow(
    tokens: &[Token],
    mut i: usize,
    mut at: Vec<String>,
    start: bool,
    targets: &mut Vec<(String, usize)>,
) -> usize {
    let line = tokens[i].line;
    let mut first = start;
    let mut root_only = false;
    loop {
        match tokens.get(i).map(|token| token.text.as_str()) {
            Some("{") => {
                i += 1;
                while tokens.get(i).is_some_and(|token| token.text != "}") {
                    // At least one on, also over what is no path.
                    i = (i + 1).max(if tokens[i].text == "," {
                        0
                    } else {
                        follow(tokens, i, at.clone(), false, targets)
                    });
                }
                return i + 1;
            }
            Some("super") => _ = at.pop(),
            Some("self") => {}
            Some("crate" | "machband") if first => {
                at.clear();
                root_only = true;
            }
            Some("*") => {
                targets.push((at.first().cloned().unwrap_or_else(|| "crate::*".to_owned()), line));
                return i + 1;
            }
            Some(name) if name.starts_with(|c: char| c.is_alphabetic() || c == '_') => {
                at.push(name.to_owned());
                root_only = false;
            }
            _ => return i,
        }
        first = false;
        i += 1;
        if tokens.get(i).is_some_and(|token| token.text == "::") {
            i += 1;
            continue;
        }
        break;
    }
    if tokens.get(i).is_some_and(|token| token.text == "as") {
        if at.is_empty() {
            targets.push(("crate".to_owned(), line));
        }
        i += 2;
    }
    // `crate` alone stands in `pub(crate)`; `self` and `super` alone name no other module.
    if !root_only && let Some(target) = at.first() {
        targets.push((target.clone(), line));
    }
    i
}

struct Token {
    text: String,
    line: usize,
}

/// Names, `::` and single marks; without comments, strings, characters, lifetimes.
fn tokens(source: &str) -> Vec<Token> {
    let chars: Vec<char> = source.chars().collect();
    let at = |i: usize| chars.get(i).copied().unwrap_or('\0');
    let mut tokens = Vec::new();
    let mut line = 1;
    let mut i = 0;
    while i < chars.len() {
        let start = i;
        match at(i) {
            '/' if at(i + 1) == '/' => {
                while i < chars.len() && at(i) != '\n' {
                    i += 1;
                }
            }
            '/' if at(i + 1) == '*' => {
                let mut depth = 0;
                loop {
                    match (at(i), at(i + 1)) {
                        ('/', '*') => (depth, i) = (depth + 1, i + 2),
                        ('*', '/') => (depth, i) = (depth - 1, i + 2),
                        _ => i += 1,
                    }
                    if depth == 0 || i >= chars.len() {
                        break;
                    }
                }
            }
            '"' => {
                i += 1;
                while i < chars.len() && at(i) != '"' {
                    i += if at(i) == '\\' { 2 } else { 1 };
                }
                i += 1;
            }
            '\'' if at(i + 1) == '\\' => {
                i += 3;
                while i < chars.len() && at(i) != '\'' {
                    i += 1;
                }
                i += 1;
            }
            '\'' if at(i + 2) == '\'' => i += 3,
            // A lifetime: the mark alone goes, and the name after it must not count as one.
            '\'' => {
                i += 1;
                while at(i).is_alphanumeric() || at(i) == '_' {
                    i += 1;
                }
            }
            c if c.is_alphanumeric() || c == '_' => {
                while at(i).is_alphanumeric() || at(i) == '_' {
                    i += 1;
                }
                let text: String = chars[start..i].iter().collect();
                let hashes = (i..).take_while(|j| at(*j) == '#').count();
                if matches!(text.as_str(), "r" | "br" | "cr") && at(i + hashes) == '"' {
                    i += hashes + 1;
                    while i < chars.len() && !(at(i) == '"' && (1..=hashes).all(|j| at(i + j) == '#')) {
                        i += 1;
                    }
                    i += hashes + 1;
                } else {
                    tokens.push(Token { text, line });
                }
            }
            ':' if at(i + 1) == ':' => {
                tokens.push(Token { text: "::".to_owned(), line });
                i += 2;
            }
            c => {
                if !c.is_whitespace() {
                    tokens.push(Token { text: c.to_string(), line });
                }
                i += 1;
            }
        }
        line += chars[start..i.min(chars.len())].iter().filter(|c| **c == '\n').count();
    }
    tokens
}
