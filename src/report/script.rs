//! The R script that fits the main model again, from `counts.csv` in the same folder, with R's `ordinal`, and compares
//! the numbers.

use std::collections::HashSet;

use super::tables::number;
use crate::{
    analysis::{
        Model, Note, RandomEffect, Results,
        counts::Factor,
        find_factor,
        terms::{Term, Variable},
    },
    store::{ratings::Shape, table::inert},
};

/// Levels that `clmm` needs at least in a grouping factor.
const FEWEST_PEOPLE: usize = 3;

/// Smallest standard deviation that is not 0.
const ZERO: f64 = 1e-6;

/// Returns the call that fits the same model with R's `ordinal` package.
pub(super) fn call(results: &Results, model: &Model) -> String {
    let columns = Columns::new(results);
    let random = model.random.iter().flat_map(|random| columns.deviations(random)).map(|deviation| deviation.piece);
    let random: Vec<String> = random.collect();
    let function = if random.is_empty() { "clm" } else { "clmm" };
    format!("{function}({}, {})", columns.formula(&random), arguments(model))
}

/// Writes the script. If there is no model, or R cannot fit it, the script says why and does nothing.
pub(super) fn script(shape: &Shape, results: &Results) -> String {
    let introduction = format!(
        "# Fits the main model of this analysis again with R's ordinal, from counts.csv in this folder, and puts R's numbers\n\
         # beside machband's. Made by machband {}. The numbers agree if they differ by less than 0.001 standard errors;\n\
         # otherwise, the exit status is 1.\n#\n\
         #   Rscript analysis.R\n#\n\
         # It needs the package ordinal: install.packages(\"ordinal\"). Tested with R 4.2.2 and ordinal 2022.11-16.\n\n",
        env!("CARGO_PKG_VERSION")
    );
    let nothing =
        |reason: &str| format!("{introduction}# There is nothing to repeat: {}.\n", reason.replace(['\n', '\r'], " "));
    let model = match &results.model {
        Ok(report) => &report.model,
        Err(error) => return nothing(&error.to_string()),
    };
    let columns = Columns::new(results);
    let all: Vec<Deviation> = model.random.iter().flat_map(|random| columns.deviations(random)).collect();
    let (used, zero): (Vec<_>, Vec<_>) =
        all.iter().partition(|deviation| deviation.sds.iter().any(|sd| sd.sd * sd.unit > ZERO));
    if !used.is_empty() && model.subjects < FEWEST_PEOPLE {
        return nothing("clmm needs at least three participants");
    }
    let mut text = introduction + "library(ordinal)\n\n" + &columns.data(shape, model);
    for number in columns.centered(&used) {
        text += &format!("data${number}_c <- data${number} - weighted.mean(data${number}, data$count)\n");
    }
    text.push('\n');
    for deviation in zero {
        text += &format!(
            "# The standard deviation of {} is 0, so the likelihood is the same without it.\n",
            deviation.piece
        );
    }
    text += &numbers(model, &columns, &used);
    text += &fit(model, &columns, &used);
    text + COMPARISON
}

/// Compares `r` with `machband`.
const COMPARISON: &str = r#"
# Differences of estimates are in standard errors; differences of standard errors are relative.
by_se <- abs(r$estimate - machband$estimate) / ifelse(is.na(machband$se), 1, machband$se)
of_se <- abs(r$se / machband$se - 1)
by_se <- by_se[is.finite(machband$estimate)]
of_se <- of_se[!is.na(machband$se) & (is.nan(r$se) | !is.na(r$se))]
options(width = 200)
print(data.frame(machband, R = r$estimate, R_se = r$se, difference = r$estimate - machband$estimate), digits = 5,
      row.names = FALSE, right = FALSE)
largest <- max(by_se, of_se)
cat("largest difference:", format(largest, digits = 2), "\n")
if (!isTRUE(largest <= 1e-3)) quit(status = 1)
"#;

/// The names of the variables in R.
struct Columns<'a> {
    results: &'a Results,
    names: Vec<(&'a Variable, String)>,
}

/// A random effect: its piece of the formula and its standard deviations.
struct Deviation<'a> {
    piece: String,
    /// The numbers about their means.
    numbers: Vec<&'a Variable>,
    sds: Vec<Sd<'a>>,
    correlations: &'a [Vec<f64>],
}

struct Sd<'a> {
    name: &'a str,
    /// Its name in R: the grouping factor and the column.
    key: String,
    sd: f64,
    se: Option<f64>,
    unit: f64,
}

impl<'a> Columns<'a> {
    fn new(results: &'a Results) -> Self {
        let mut taken: HashSet<String> = ["subject", "rating", "count"].map(str::to_owned).into();
        let mut names: Vec<(&Variable, String)> = Vec::new();
        for variable in results.spec.terms.iter().flat_map(|term| &term.variables) {
            if names.iter().any(|(known, _)| *known == variable) {
                continue;
            }
            let mut name = match variable {
                Variable::Factor(name) => syntactic(name),
                Variable::Number(name) => format!("num_{}", syntactic(name)),
            };
            while taken.contains(&name) || taken.contains(&format!("{name}_c")) {
                name.push('.');
            }
            taken.extend([name.clone(), format!("{name}_c")]);
            names.push((variable, name));
        }
        Self { results, names }
    }

    fn name(&self, variable: &Variable) -> &str {
        self.names.iter().find(|(known, _)| *known == variable).map_or("", |(_, name)| name)
    }

    fn formula(&self, random: &[String]) -> String {
        let of_term =
            |term: &Term| term.variables.iter().map(|variable| self.name(variable)).collect::<Vec<_>>().join(":");
        let mut parts: Vec<String> = self.results.spec.terms.iter().map(of_term).collect();
        if parts.is_empty() {
            parts.push("1".to_owned());
        }
        format!("rating ~ {}", [&parts, random].concat().join(" + "))
    }

    /// Returns the random effects as terms of a formula, in the order of the model.
    fn deviations(&self, random: &'a RandomEffect) -> Vec<Deviation<'a>> {
        let intercept =
            Sd { name: "(Intercept)", key: "subject (Intercept)".to_owned(), sd: random.sd, se: random.se, unit: 1.0 };
        match &random.correlations {
            Some(correlations) => vec![self.correlated(intercept, random, correlations)],
            None => {
                let piece = "(1 | subject)".to_owned();
                let intercept = Deviation { piece, numbers: Vec::new(), sds: vec![intercept], correlations: &[] };
                let slopes = random.slopes.iter().map(|slope| {
                    let (mut group, mut numbers) = ("subject".to_owned(), Vec::new());
                    for variable in self.part_named(&slope.name) {
                        match variable {
                            Variable::Factor(_) => group += &format!(":{}", self.name(variable)),
                            Variable::Number(_) => numbers.push(variable),
                        }
                    }
                    let product: Vec<_> = numbers.iter().map(|number| format!("{}_c", self.name(number))).collect();
                    let product = product.join(":");
                    let (left, column) = match numbers.is_empty() {
                        true => ("1".to_owned(), "(Intercept)"),
                        false => (format!("0 + {product}"), product.as_str()),
                    };
                    let key = format!("{group} {column}");
                    let unit = self.unit_of(&slope.name);
                    let sd = Sd { name: &slope.name, key, sd: slope.sd, se: slope.se, unit };
                    Deviation { piece: format!("({left} | {group})"), numbers, sds: vec![sd], correlations: &[] }
                });
                std::iter::once(intercept).chain(slopes).collect()
            }
        }
    }

    /// Returns `(1 + width + x | subject)`.
    fn correlated(&self, intercept: Sd<'a>, random: &'a RandomEffect, correlations: &'a [Vec<f64>]) -> Deviation<'a> {
        let (mut left, mut numbers) = ("1".to_owned(), Vec::new());
        for term in &self.results.spec.terms {
            let [variable] = term.variables.as_slice() else { continue };
            let name = self.name(variable);
            if !random.slopes.iter().any(|slope| self.is_contrast(variable, &slope.name)) {
                continue;
            }
            // Contrasts are not centered.
            let is_contrast = self.values(variable).is_none_or(|values| values.iter().all(|x| *x == 0.0 || *x == 1.0));
            left += &format!(" + {name}{}", if is_contrast { "" } else { "_c" });
            numbers.extend((!is_contrast).then_some(variable));
        }
        let slopes = random.slopes.iter();
        let slopes = slopes.map(|slope| {
            // A number has the name of its coefficient, without `num:`.
            let unit = self.unit_of(&format!("num:{}", slope.name));
            Sd { name: &slope.name, key: slope.name.clone(), sd: slope.sd, se: slope.se, unit }
        });
        let sds = std::iter::once(intercept).chain(slopes).collect();
        Deviation { piece: format!("({left} | subject)"), numbers, sds, correlations }
    }

    /// Returns the variables of the part of a term that has this name.
    fn part_named(&self, name: &str) -> Vec<&'a Variable> {
        let part = |term: &'a Term| {
            let mut rest = Some(name);
            let mut variables = Vec::new();
            for variable in &term.variables {
                let after = rest.and_then(|rest| rest.strip_prefix(&variable.to_string()));
                if let Some(after) = after.filter(|after| after.is_empty() || after.starts_with(':')) {
                    variables.push(variable);
                    rest = after.strip_prefix(':');
                }
            }
            rest.is_none().then_some(variables)
        };
        self.results.spec.terms.iter().find_map(part).unwrap_or_default()
    }

    /// Returns whether a coefficient is a contrast of this variable.
    fn is_contrast(&self, variable: &Variable, coefficient: &str) -> bool {
        match (variable, coefficient.strip_prefix(variable.name())) {
            (Variable::Number(_), rest) => rest == Some(""),
            (Variable::Factor(name), Some(level)) => {
                let factor = self.results.measured.counts.factor(name);
                factor.is_some_and(|(_, factor)| factor.levels.iter().any(|known| known == level))
            }
            _ => false,
        }
    }

    /// Returns the index of a variable's factor, and true if the variable is the reciprocal.
    fn factor(&self, variable: &Variable) -> (usize, bool) {
        find_factor(&self.results.measured.counts, variable).unwrap_or_default()
    }

    /// Returns the values of a number; `None` for a factor.
    fn values(&self, variable: &Variable) -> Option<Vec<f64>> {
        let (index, inverse) = self.factor(variable);
        let numbers = self.results.measured.counts.factors[index].numbers.as_ref();
        let numbers = numbers.filter(|_| matches!(variable, Variable::Number(_)))?;
        Some(numbers.iter().map(|x| if inverse { x.recip() } else { *x }).collect())
    }

    /// Returns the power of ten by which a number is divided in R, because clmm's numerical derivatives need values near
    /// 1; 1 for a factor.
    fn unit(&self, variable: &Variable) -> f64 {
        let most = self.values(variable).into_iter().flatten().fold(0.0_f64, |most, x| most.max(x.abs()));
        if most == 0.0 || !most.is_finite() || (0.1..10.0).contains(&most) {
            1.0
        } else {
            10_f64.powf(most.log10().floor())
        }
    }

    /// Returns the product of the units of the variables of a term, given by name.
    fn unit_of(&self, term: &str) -> f64 {
        self.part_named(term).iter().map(|variable| self.unit(variable)).product()
    }

    fn centered(&self, deviations: &[&Deviation]) -> Vec<&str> {
        let used = |variable: &&Variable| deviations.iter().any(|deviation| deviation.numbers.contains(variable));
        self.names.iter().filter(|(variable, _)| used(variable)).map(|(_, name)| name.as_str()).collect()
    }

    /// Reads the rows of the model, with its levels and categories in order.
    fn data(&self, shape: &Shape, model: &Model) -> String {
        let counts = &self.results.measured.counts;
        let mut text = "counts <- read.csv(\"counts.csv\", check.names = FALSE, colClasses = \"character\", \
                        na.strings = character(), encoding = \"UTF-8\")\n"
            .to_owned();
        let column = |name: &str| format!("counts[[{}]]", string(&inert(name)));
        let mut complete = HashSet::new();
        let mut lines = vec![
            format!("subject = factor({})", column(&shape.subject)),
            format!(
                "rating = factor({}, levels = {}, ordered = TRUE)",
                column(&shape.response),
                strings(&model.categories)
            ),
            "count = as.numeric(counts[[ncol(counts)]])".to_owned(),
        ];
        for (variable, name) in &self.names {
            let (index, inverse) = self.factor(variable);
            let factor = &counts.factors[index];
            let cells = column(&factor.name);
            if counts.conditions.iter().any(|levels| levels[index].is_none()) && complete.insert(index) {
                text += &format!("counts <- counts[{cells} != \"\", ] # rows without a value are not in the model\n");
            }
            let unit = match self.unit(variable) {
                1.0 => String::new(),
                unit => format!(" / {}", r_number(unit)),
            };
            lines.push(match variable {
                Variable::Factor(_) => {
                    format!("{name} = factor({cells}, levels = {})", strings(&levels(factor, model)))
                }
                Variable::Number(_) if inverse => format!("{name} = 1 / as.numeric({cells}){unit}"),
                Variable::Number(_) => format!("{name} = as.numeric({cells}){unit}"),
            });
        }
        text + &format!("data <- droplevels(data.frame(\n  {}\n))\n", lines.join(",\n  "))
    }
}

/// Returns the levels of a factor, starting with the baseline of the model.
fn levels(factor: &Factor, model: &Model) -> Vec<String> {
    let mut levels = factor.levels.clone();
    for note in &model.notes {
        if let Note::Rebased { factor: name, baseline, .. } = note
            && *name == factor.name
            && let Some(position) = levels.iter().position(|level| level == baseline)
        {
            levels[..=position].rotate_right(1);
        }
    }
    levels
}

/// Returns the arguments that say how a model is fitted.
fn arguments(model: &Model) -> String {
    format!("link = \"{}\"", model.link)
}

/// Returns whether correlated effects have a variance of 0 in some direction, so that their correlations are arbitrary.
fn is_singular(model: &Model) -> bool {
    model.notes.contains(&Note::SingularCovariance)
}

/// Lists machband's numbers.
fn numbers(model: &Model, columns: &Columns, deviations: &[&Deviation]) -> String {
    let mut rows = vec![("log-likelihood".to_owned(), model.loglik, None)];
    rows.extend(model.thresholds.iter().map(|threshold| (threshold.name.clone(), threshold.estimate, threshold.se)));
    let mut add = |name: String, estimate: f64, se: Option<f64>, unit: f64| {
        let name = if unit == 1.0 { name } else { format!("{name}, per {}", r_number(unit)) };
        rows.push((name, estimate * unit, se.map(|se| se * unit)));
    };
    for one in &model.coefficients {
        add(one.name.clone(), one.estimate, one.se, columns.unit_of(&one.term));
    }
    for deviation in deviations {
        for sd in &deviation.sds {
            add(format!("SD {}", sd.name), sd.sd, sd.se, sd.unit);
        }
        for (index, row) in deviation.correlations.iter().enumerate() {
            for (r, sd) in row.iter().zip(&deviation.sds).take(index) {
                let r = if is_singular(model) { f64::NAN } else { *r };
                add(format!("r {}, {}", sd.name, deviation.sds[index].name), r, None, 1.0);
            }
        }
    }
    let end = rows.len() - 1;
    let row = |(index, (name, estimate, se)): (usize, &(String, f64, Option<f64>))| {
        let skipped = match estimate {
            estimate if estimate.is_finite() => "",
            estimate if estimate.is_nan() => " # not compared: the covariance matrix is singular",
            _ => " # not compared: no finite estimate",
        };
        let comma = if index < end { "," } else { "" };
        let se = se.map_or_else(|| "NA".to_owned(), r_number);
        format!("  number({}, {}, {se}){comma}{skipped}\n", string(name), r_number(*estimate))
    };
    let rows: String = rows.iter().enumerate().map(row).collect();
    format!("number <- function(name, estimate, se) data.frame(name, estimate, se)\nmachband <- rbind(\n{rows})\n\n")
}

/// Fits the model and puts R's numbers into `r`.
fn fit(model: &Model, columns: &Columns, deviations: &[&Deviation]) -> String {
    let pieces: Vec<String> = deviations.iter().map(|deviation| deviation.piece.clone()).collect();
    let formula = columns.formula(&pieces);
    let fixed = model.thresholds.len() + model.coefficients.len();
    // Coefficients without a finite estimate are not free.
    let free = format!(
        "free <- c(is.finite(machband$estimate[2:{}]), rep(TRUE, length(fit$gradient) - {fixed}))\n",
        fixed + 1
    );
    let estimates = "estimate <- coef(fit)[!is.na(coef(fit))]\n\
                     se <- replace(rep(NA_real_, length(free)), free, sqrt(diag(solve(fit$Hessian[free, free]))))\n";
    let arguments = format!("data = data, weights = count, {}", arguments(model));
    if deviations.is_empty() {
        return format!(
            "fit <- clm({formula}, {arguments})\n{free}{estimates}\
             r <- data.frame(estimate = c(logLik(fit), estimate), se = c(NA, se))\n"
        );
    }
    let start = format!("list(start[1:{fixed}], start[-(1:{fixed})])");
    let newton = format!(
        "# clmm stops early, so a Newton step follows.\n\
         start <- fit$optRes$par\n\
         start[free] <- start[free] - solve(fit$Hessian[free, free], fit$gradient[free])\n\
         fit <- refit(start = {start})\n"
    );
    let newton = if is_singular(model) { String::new() } else { newton };
    let spreads = if deviations.iter().any(|deviation| !deviation.correlations.is_empty()) {
        "matrix <- VarCorr(fit)[[1]]\n\
         sd <- attr(matrix, \"stddev\")\n\
         correlation <- attr(matrix, \"correlation\")\n\
         r <- data.frame(estimate = c(logLik(fit), estimate, sd, correlation[upper.tri(correlation)]), se = NA_real_)\n"
            .to_owned()
            + &format!("r$se[2:{}] <- se[1:{fixed}]\n", fixed + 1)
    } else {
        let keys: Vec<&str> =
            deviations.iter().flat_map(|deviation| &deviation.sds).map(|sd| sd.key.as_str()).collect();
        format!(
            "# R sorts the random effects.\n\
             names <- paste(names(fit$gfList)[attr(fit$gfList, \"assign\")], sapply(VarCorr(fit), colnames))\n\
             order <- match({}, names)\n\
             sd <- sapply(VarCorr(fit), attr, \"stddev\")[order]\n\
             r <- data.frame(estimate = c(logLik(fit), estimate, sd), se = c(NA, se[c(1:{fixed}, {fixed} + order)]))\n",
            strings(&keys)
        )
    };
    format!(
        "control <- clmm.control(useMatrix = TRUE, gradTol = 1e-8, maxIter = 200, innerCtrl = \"noWarn\")\n\
         refit <- function(...) clmm({formula},\n  {arguments}, control = control, ...)\n\
         fit <- refit()\n{free}\
         {newton}{estimates}{spreads}"
    )
}

/// Writes a number in R.
fn r_number(value: f64) -> String {
    match value {
        f64::INFINITY => "Inf".to_owned(),
        f64::NEG_INFINITY => "-Inf".to_owned(),
        value if value.is_nan() => "NaN".to_owned(),
        value => number(value),
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

/// Makes a name that R accepts without quotes, like R's `make.names`.
fn syntactic(name: &str) -> String {
    const RESERVED: [&str; 16] = [
        "if", "else", "repeat", "while", "function", "for", "next", "break", "in", "TRUE", "FALSE", "NULL", "Inf",
        "NaN", "NA", "_c",
    ];
    let allowed = |c: char| if c.is_ascii_alphanumeric() || c == '_' || c == '.' { c } else { '.' };
    let mut name: String = name.chars().map(allowed).collect();
    if !name.starts_with(|c: char| c.is_ascii_alphabetic()) {
        name.insert(0, 'X');
    }
    if RESERVED.contains(&name.as_str()) || name.starts_with("NA_") {
        name.push('.');
    }
    name
}
