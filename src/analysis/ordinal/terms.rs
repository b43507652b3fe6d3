//! The grammar of `--terms`: `width,depth` are factors, `num:width` is a number, `a:b` is an interaction, and `a*b`
//! means `a,b,a:b`. `num:inv_n` is 1/depth, which is 0 for `inf`. A name with `,`, `:`, `*` or a quote is quoted, as in CSV.

use std::fmt;

use serde::{Serialize, Serializer};

/// One variable of a term.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum Variable {
    /// A factor, with treatment contrasts against its first level.
    Factor(String),
    /// A number, with one column for the value itself.
    Number(String),
}

/// A main effect or an interaction of several variables.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Term {
    /// At least one variable, without duplicates.
    pub variables: Vec<Variable>,
}

/// One variable of a coefficient and, unless it is a number, the level that it stands for.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct TermPart {
    pub variable: Variable,
    pub level: Option<String>,
}

/// The terms of a model in R's order: main effects first, then interactions by the number of their variables.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Terms(Vec<Term>);

impl Variable {
    /// Returns the name of the column, without `num:`.
    pub fn name(&self) -> &str {
        match self {
            Self::Factor(name) | Self::Number(name) => name,
        }
    }
}

impl fmt::Display for Variable {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let number = if matches!(self, Self::Number(_)) { "num:" } else { "" };
        match self.name() {
            name if name.contains([',', ':', '*', '"']) => write!(f, "{number}\"{}\"", name.replace('"', "\"\"")),
            name => write!(f, "{number}{name}"),
        }
    }
}

impl fmt::Display for Term {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.variables.iter().map(ToString::to_string).collect::<Vec<_>>().join(":"))
    }
}

impl Serialize for Variable {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl Serialize for Term {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl fmt::Display for Terms {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0.iter().map(ToString::to_string).collect::<Vec<_>>().join(","))
    }
}

impl std::str::FromStr for Terms {
    type Err = String;

    /// Reads a list such as `width,depth,num:inv_n,width:depth`. An empty text means a model without terms.
    fn from_str(text: &str) -> Result<Self, String> {
        if text.trim().is_empty() {
            return Ok(Self::default());
        }
        let mut terms = Vec::new();
        for item in unquoted(text, ',') {
            let empty = || format!("{text}: an empty name; expected names, joined by , : or *");
            terms.extend(expand(item).ok_or_else(empty)?);
        }
        let terms = Self::new(terms);
        match terms.iter().find(|term| !term.is_main() && !terms.has_parts(term)) {
            None => Ok(terms),
            Some(term) => Err(format!(
                "{term}: the effects and interactions that it contains are missing; expected {}, which has them",
                term.variables.iter().map(ToString::to_string).collect::<Vec<_>>().join("*")
            )),
        }
    }
}

crate::text::names::serde_as_text!(Terms);

impl fmt::Display for TermPart {
    /// Writes the part as R does: the factor followed by the level, or the name of the number.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}{}", self.variable.name(), self.level.as_deref().unwrap_or_default())
    }
}

impl Term {
    /// Creates the main effect of a factor.
    pub fn factor(name: &str) -> Self {
        Self { variables: vec![Variable::Factor(name.to_owned())] }
    }

    /// Returns the name of the first variable.
    pub fn name(&self) -> &str {
        self.variables.first().map_or("", Variable::name)
    }

    /// Returns whether this is the term of one variable.
    pub fn is_main(&self) -> bool {
        self.variables.len() == 1
    }

    /// Returns whether both terms have the same variables, in any order.
    pub fn same(&self, other: &Self) -> bool {
        self.variables.len() == other.variables.len() && other.contains(self)
    }

    /// Returns whether this term has every variable of `part`.
    pub fn contains(&self, part: &Self) -> bool {
        part.variables.iter().all(|variable| self.variables.contains(variable))
    }
}

impl Terms {
    /// Creates a list of these terms, each once and main effects first. The variables in a term are in the order of
    /// their first appearance.
    pub fn new(terms: impl IntoIterator<Item = Term>) -> Self {
        let mut seen: Vec<Variable> = Vec::new();
        let mut distinct: Vec<Term> = Vec::new();
        for mut term in terms {
            for variable in &term.variables {
                if !seen.contains(variable) {
                    seen.push(variable.clone());
                }
            }
            term.variables.sort_by_key(|variable| seen.iter().position(|other| other == variable));
            if !distinct.contains(&term) {
                distinct.push(term);
            }
        }
        distinct.sort_by_key(|term| term.variables.len());
        Self(distinct)
    }

    /// Creates the main effects of these factors.
    pub fn factors<S: AsRef<str>>(names: &[S]) -> Self {
        Self::new(names.iter().map(|name| Term::factor(name.as_ref())))
    }

    /// Returns the terms in order.
    pub fn iter(&self) -> std::slice::Iter<'_, Term> {
        self.0.iter()
    }

    /// Returns whether there are no terms.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Returns whether one of the terms has these variables.
    pub fn has(&self, term: &Term) -> bool {
        self.0.iter().any(|other| other.same(term))
    }

    /// Returns whether a factor enters as a number.
    pub fn has_number(&self, factor: &str) -> bool {
        let is_own = |variable: &Variable| matches!(variable, Variable::Number(name) if name == factor);
        self.0.iter().flat_map(|term| &term.variables).any(is_own)
    }

    /// Returns whether the parts of an interaction that lack one of its variables are terms too.
    pub fn has_parts(&self, term: &Term) -> bool {
        let without = |variable: &Variable| term.variables.iter().filter(|v| *v != variable).cloned().collect();
        term.variables.iter().all(|variable| self.has(&Term { variables: without(variable) }))
    }

    /// Returns all terms but this one.
    pub fn without(&self, term: &Term) -> Self {
        Self(self.0.iter().filter(|other| !other.same(term)).cloned().collect())
    }

    /// Returns whether a term is part of a larger term. If so, dropping it alone would not give a smaller model.
    pub fn is_marginal(&self, term: &Term) -> bool {
        self.0.iter().any(|other| other.variables.len() > term.variables.len() && other.contains(term))
    }
}

/// Splits a text at a separator outside quotes.
fn unquoted(text: &str, separator: char) -> impl Iterator<Item = &str> {
    let mut is_quoted = false;
    text.split(move |letter| {
        is_quoted ^= letter == '"';
        letter == separator && !is_quoted
    })
}

/// Returns a name without its quotes; `None` if it is empty.
fn plain(name: &str) -> Option<String> {
    let inner = name.strip_prefix('"').and_then(|name| name.strip_suffix('"'));
    Some(inner.map_or_else(|| name.to_owned(), |inner| inner.replace("\"\"", "\""))).filter(|name| !name.is_empty())
}

/// Expands `a*b*c` into terms: every combination of its parts.
fn expand(item: &str) -> Option<Vec<Term>> {
    let parts: Vec<Term> = unquoted(item, '*').map(interaction).collect::<Option<_>>()?;
    let mut terms: Vec<Term> = Vec::new();
    for part in parts {
        let joined: Vec<Term> = (terms.iter())
            .map(|term| {
                let mut variables = term.variables.clone();
                variables.extend(part.variables.iter().filter(|v| !term.variables.contains(v)).cloned());
                Term { variables }
            })
            .collect();
        terms.push(part);
        terms.extend(joined);
    }
    Some(terms)
}

/// Reads one term of the form `a:num:b`.
fn interaction(text: &str) -> Option<Term> {
    let mut variables: Vec<Variable> = Vec::new();
    let mut names = unquoted(text, ':').map(str::trim);
    while let Some(name) = names.next() {
        let variable = match name {
            "num" => Variable::Number(names.next().and_then(plain)?),
            name => Variable::Factor(plain(name)?),
        };
        if !variables.contains(&variable) {
            variables.push(variable);
        }
    }
    Some(Term { variables })
}
