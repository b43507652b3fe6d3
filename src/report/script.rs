//! The R script that fits the main model again, from `counts.csv` in the same folder, with R's package `ordinal`.

use crate::{
    analysis::{
        Model, Note, RandomEffect, Results, find_factor,
        terms::{Term, Variable},
    },
    text::inert,
};

/// Levels that `clmm` needs at least in a grouping factor.
const FEWEST_PEOPLE: usize = 3;
/// Words that are no names in R, and the columns of every study.
const RESERVED: &str =
    "if else repeat while function for next break in TRUE FALSE NULL Inf NaN NA subject item rating count";

/// Writes the script. If there is no model, or R cannot fit it, the script says why and does nothing.
pub(super) fn script(results: &Results) -> String {
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
    let fixed = results.spec.terms.iter().map(|term| names.product(&term.variables));
    let random = model.random.iter().flat_map(|random| names.random(random));
    let mut terms: Vec<String> = fixed.chain(random).collect();
    if results.spec.terms.is_empty() {
        terms.insert(0, "1".to_owned());
    }
    format!(
        "{introduction}\nlibrary(ordinal)\n\n{}\nfit <- {}(rating ~ {},\n  data = data, weights = count, link = \"{}\")\n\
         print(summary(fit))\n",
        names.data(results, model),
        if model.random.is_some() { "clmm" } else { "clm" },
        terms.join(" + "),
        model.link
    )
}

/// The variables of the model, with their names in R.
struct Names<'a>(Vec<(&'a Variable, String)>);

impl<'a> Names<'a> {
    fn new(results: &'a Results) -> Self {
        let mut names: Vec<(&Variable, String)> = Vec::new();
        for variable in results.spec.terms.iter().flat_map(|term| &term.variables) {
            if names.iter().any(|(known, _)| *known == variable) {
                continue;
            }
            let prefix = match variable {
                Variable::Number(_) => "num_",
                Variable::Factor(name) if name.starts_with(|c: char| c.is_ascii_alphabetic()) => "",
                Variable::Factor(_) => "X",
            };
            let is_odd = |c: char| !(c.is_ascii_alphanumeric() || c == '_' || c == '.');
            let mut name = format!("{prefix}{}", variable.name().replace(is_odd, "."));
            while RESERVED.split(' ').chain(names.iter().map(|(_, taken)| &**taken)).any(|taken| taken == name) {
                name.push('.');
            }
            names.push((variable, name));
        }
        Self(names)
    }

    fn name(&self, variable: &Variable) -> &str {
        self.0.iter().find(|(known, _)| *known == variable).map_or("", |(_, name)| name)
    }

    fn product<'b>(&self, variables: impl IntoIterator<Item = &'b Variable>) -> String {
        variables.into_iter().map(|variable| self.name(variable)).collect::<Vec<_>>().join(":")
    }

    /// Returns the random effects as terms of a formula.
    fn random(&self, random: &RandomEffect) -> Vec<String> {
        let mut terms: Vec<&Term> = random.slopes.iter().map(|slope| &slope.term).collect();
        terms.dedup();
        if random.correlations.is_some() {
            let slopes: String = terms.iter().map(|term| format!(" + {}", self.product(&term.variables))).collect();
            return vec![format!("(1{slopes} | subject)")];
        }
        let slope = |term: &Term| {
            let (numbers, factors): (Vec<&Variable>, Vec<_>) =
                term.variables.iter().partition(|variable| matches!(variable, Variable::Number(_)));
            let left = if numbers.is_empty() { "1".to_owned() } else { format!("0 + {}", self.product(numbers)) };
            let group: String = factors.iter().map(|factor| format!(":{}", self.name(factor))).collect();
            format!("({left} | subject{group})")
        };
        let items = random.items.as_ref().map(|_| "(1 | item)".to_owned());
        std::iter::once("(1 | subject)".to_owned()).chain(terms.into_iter().map(slope)).chain(items).collect()
    }

    /// Reads the rows of the model, with its levels and categories in order. Its columns are the participant, the factors, the
    /// rating and the count. Rows without a value are not in the model.
    fn data(&self, results: &Results, model: &Model) -> String {
        let counts = results.modeled();
        let cells = |index: usize| format!("counts[[{}]]", 2 + index);
        let items = model.random.as_ref().and_then(|random| counts.factor(&random.items.as_ref()?.name));
        let items = items.map(|(items, _)| format!("item = factor({})", cells(items)));
        let variable = |(variable, name): &(&Variable, String)| {
            let (index, inverse) = find_factor(counts, variable).unwrap_or_default();
            if let Variable::Number(_) = variable {
                return format!("{name} = centered({}as.numeric({}))", if inverse { "1 / " } else { "" }, cells(index));
            }
            let factor = &counts.factors[index];
            let baseline = model.notes.iter().find_map(|note| match note {
                Note::Rebased { factor: own, baseline, .. } if *own == factor.name => Some(baseline),
                _ => None,
            });
            let mut levels: Vec<&String> = factor.levels.iter().collect();
            levels.sort_by_key(|level| Some(*level) != baseline);
            format!("{name} = factor({}, levels = {})", cells(index), strings(&levels))
        };
        let variables = items.into_iter().chain(self.0.iter().map(variable));
        let variables: String = variables.map(|variable| format!(",\n  {variable}")).collect();
        let rating = counts.factors.len();
        format!(
            "counts <- read.csv(\"counts.csv\", colClasses = \"character\", na.strings = character(), encoding = \"UTF-8\")\n\
             n <- as.numeric({})\n\
             centered <- function(x) (x - weighted.mean(x, n, na.rm = TRUE)) / diff(range(x, na.rm = TRUE))\n\
             data <- droplevels(na.omit(data.frame(\n  subject = factor(counts[[1]]),\n  \
             rating = factor({}, levels = {}, ordered = TRUE),\n  count = n{variables}\n)))\n",
            cells(rating + 1),
            cells(rating),
            strings(&model.categories)
        )
    }
}

/// Writes strings in R, in ASCII, so that they do not depend on the encoding in which R reads the script.
fn strings<S: AsRef<str>>(all: &[S]) -> String {
    let escaped = |c: char| match c.is_ascii() {
        true => c.escape_default().to_string(),
        false => format!("\\U{{{:x}}}", u32::from(c)),
    };
    let string = |text: &S| format!("\"{}\"", inert(text.as_ref()).chars().map(escaped).collect::<String>());
    format!("c({})", all.iter().map(string).collect::<Vec<_>>().join(", "))
}
