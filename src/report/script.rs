//! The R script that fits the main model again, from `counts.csv` in the same folder, with R's package `ordinal`.

use super::tables::count_columns;
use crate::{
    analysis::{
        Model, Note, RandomEffect, Results, find_factor,
        terms::{Term, Variable},
    },
    store::ratings::Shape,
    text::inert,
};

/// Levels that `clmm` needs at least in a grouping factor.
const FEWEST_PEOPLE: usize = 3;

/// Writes the script. If there is no model, or R cannot fit it, the script says why and does nothing.
pub(super) fn script(shape: &Shape, results: &Results) -> String {
    let introduction = format!(
        "# Fits the main model of this analysis again with R, from counts.csv in this folder. Made by machband {}.\n#\n\
         #   Rscript analysis.R\n#\n# It needs the package ordinal: install.packages(\"ordinal\"). Numbers are about their means and\n\
         # divided by their range, because otherwise clmm may not find the maximum. So their coefficients, those of\n\
         # factors with which they interact, and the thresholds differ from those of the report.\n",
        env!("CARGO_PKG_VERSION")
    );
    let nothing =
        |reason: &str| format!("{introduction}# There is nothing to repeat: {}.\n", reason.replace(['\n', '\r'], " "));
    let model = match &results.model {
        Ok(report) => &report.model,
        Err(error) => return nothing(&error.to_string()),
    };
    if model.random.is_some() && model.subjects < FEWEST_PEOPLE {
        return nothing("clmm needs at least three participants");
    }
    let names = Names::new(results);
    let (data, formula) = (names.data(shape, results, model), names.formula(results, model));
    let function = if model.random.is_some() { "clmm" } else { "clm" };
    format!(
        "{introduction}\nlibrary(ordinal)\n\n{data}\nfit <- {function}({formula},\n  data = data, weights = count, \
             link = \"{}\")\nprint(summary(fit))\n",
        model.link
    )
}

/// The names of the variables in R.
struct Names<'a>(Vec<(&'a Variable, String)>);

impl<'a> Names<'a> {
    fn new(results: &'a Results) -> Self {
        let mut names: Vec<(&Variable, String)> = Vec::new();
        for variable in results.spec.terms.iter().flat_map(|term| &term.variables) {
            if names.iter().all(|(known, _)| *known != variable) {
                let prefix = if matches!(variable, Variable::Number(_)) { "num_" } else { "" };
                let mut name = format!("{prefix}{}", syntactic(variable.name()));
                while names.iter().any(|(_, taken)| *taken == name) {
                    name.push('.');
                }
                names.push((variable, name));
            }
        }
        Self(names)
    }

    fn name(&self, variable: &Variable) -> &str {
        self.0.iter().find(|(known, _)| *known == variable).map_or("", |(_, name)| name)
    }

    fn product<'b>(&self, variables: impl IntoIterator<Item = &'b Variable>) -> String {
        variables.into_iter().map(|variable| self.name(variable)).collect::<Vec<_>>().join(":")
    }

    fn formula(&self, results: &Results, model: &Model) -> String {
        let mut parts: Vec<String> = results.spec.terms.iter().map(|term| self.product(&term.variables)).collect();
        if parts.is_empty() {
            parts.push("1".to_owned());
        }
        if let Some(random) = &model.random {
            parts.extend(self.random(random));
        }
        format!("rating ~ {}", parts.join(" + "))
    }

    /// Returns the random effects as terms of a formula.
    fn random(&self, random: &RandomEffect) -> Vec<String> {
        let mut terms: Vec<&Term> = random.slopes.iter().map(|slope| &slope.term).collect();
        terms.dedup();
        if random.correlations.is_some() {
            let slopes = terms.iter().map(|term| self.product(&term.variables));
            let left: Vec<String> = std::iter::once("1".to_owned()).chain(slopes).collect();
            return vec![format!("({} | subject)", left.join(" + "))];
        }
        let slope = |term: &Term| {
            let (numbers, factors): (Vec<&Variable>, Vec<_>) =
                term.variables.iter().partition(|variable| matches!(variable, Variable::Number(_)));
            let left = if numbers.is_empty() { "1".to_owned() } else { format!("0 + {}", self.product(numbers)) };
            let group = factors.iter().fold("subject".to_owned(), |group, factor| group + ":" + self.name(factor));
            format!("({left} | {group})")
        };
        let items = random.items.as_ref().map(|_| "(1 | item)".to_owned());
        std::iter::once("(1 | subject)".to_owned()).chain(terms.into_iter().map(slope)).chain(items).collect()
    }

    /// Reads the rows of the model, with its levels and categories in order.
    fn data(&self, shape: &Shape, results: &Results, model: &Model) -> String {
        let counts = results.modeled();
        let mut text = "counts <- read.csv(\"counts.csv\", check.names = FALSE, colClasses = \"character\", \
                        na.strings = character(), encoding = \"UTF-8\")\n"
            .to_owned();
        let columns = count_columns(counts, shape);
        let column = |index: usize| format!("counts[[{}]]", string(&inert(&columns[index].name)));
        let [people, ratings, count] = [0, columns.len() - 2, columns.len() - 1].map(column);
        let categories = strings(&model.categories);
        let mut lines = vec![
            format!("subject = factor({people})"),
            format!("rating = factor({ratings}, levels = {categories}, ordered = TRUE)"),
            format!("count = as.numeric({count})"),
        ];
        if let Some((items, _)) = model.random.as_ref().and_then(|random| counts.factor(&random.items.as_ref()?.name)) {
            lines.push(format!("item = factor({})", column(1 + items)));
        }
        let mut centered = String::new();
        for (variable, name) in &self.0 {
            let (index, inverse) = find_factor(counts, variable).unwrap_or_default();
            let factor = &counts.factors[index];
            let cells = column(1 + index);
            if counts.conditions.iter().any(|levels| levels[index].is_none()) {
                text += &format!("counts <- counts[{cells} != \"\", ] # rows without a value are not in the model\n");
            }
            lines.push(match variable {
                Variable::Factor(_) => {
                    let baseline = model.notes.iter().find_map(|note| match note {
                        Note::Rebased { factor: own, baseline, .. } if *own == factor.name => Some(baseline),
                        _ => None,
                    });
                    let mut levels: Vec<&String> = factor.levels.iter().collect();
                    levels.sort_by_key(|level| Some(*level) != baseline);
                    format!("{name} = factor({cells}, levels = {})", strings(&levels))
                }
                Variable::Number(_) => {
                    centered += &format!(
                        "data${name} <- (data${name} - weighted.mean(data${name}, data$count)) / diff(range(data${name}))\n"
                    );
                    format!("{name} = {}as.numeric({cells})", if inverse { "1 / " } else { "" })
                }
            });
        }
        text + &format!("data <- droplevels(data.frame(\n  {}\n))\n{centered}", lines.join(",\n  "))
    }
}

fn strings<S: AsRef<str>>(all: &[S]) -> String {
    let all: Vec<String> = all.iter().map(|text| string(&inert(text.as_ref()))).collect();
    format!("c({})", all.join(", "))
}

/// Writes a string in R, in ASCII, so that it does not depend on the encoding in which R reads the script.
fn string(text: &str) -> String {
    let mut quoted = String::from("\"");
    for c in text.chars() {
        match c {
            '"' | '\\' => quoted.extend(['\\', c]),
            ' '..='~' => quoted.push(c),
            _ => quoted += &format!("\\U{{{:x}}}", u32::from(c)),
        }
    }
    quoted + "\""
}

/// Makes a name that R accepts without quotes and that is not a column of every study.
fn syntactic(name: &str) -> String {
    const RESERVED: [&str; 19] = [
        "if", "else", "repeat", "while", "function", "for", "next", "break", "in", "TRUE", "FALSE", "NULL", "Inf",
        "NaN", "NA", "subject", "item", "rating", "count",
    ];
    let allowed = |c: char| if c.is_ascii_alphanumeric() || c == '_' || c == '.' { c } else { '.' };
    let name: String = name.chars().map(allowed).collect();
    let is_plain = name.starts_with(|c: char| c.is_ascii_alphabetic()) && !RESERVED.contains(&name.as_str());
    if is_plain { name } else { format!("X{name}") }
}
