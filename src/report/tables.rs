//! The results as tables and as JSON.

use std::ops::Range;

use serde_json::{Value, json};

use crate::{
    analysis::{
        Interaction, Link, Model, ModelReport, Results, TermTest,
        counts::{CountRow, Counts, Factor},
        number_of,
        results::FactorResults,
        summary::{Group, Summary},
    },
    statistics::Interval,
    store::ratings::Shape,
    text::{Cell, Column, Table},
};

fn columns(named: &[(&str, &str)]) -> Vec<Column> {
    named.iter().map(|(name, description)| Column::new(*name, "", *description)).collect()
}

/// A table that is made of columns, each with a value of every row.
pub(crate) struct Rows<'a, R> {
    rows: &'a [R],
    columns: Vec<Column>,
    /// The places of the columns with levels of factors.
    factors: Range<usize>,
}

impl<'a, R> Rows<'a, R> {
    /// Begins a table of these rows.
    pub fn new(rows: &'a [R]) -> Self {
        Self { rows, columns: Vec::new(), factors: 0..0 }
    }

    /// Adds a column without a unit.
    pub fn column<C: Into<Cell>>(mut self, name: &str, description: &str, value: impl Fn(&'a R) -> C) -> Self {
        let cells = self.rows.iter().map(|row| value(row).into()).collect();
        self.columns.push(Column { cells, ..Column::new(name, "", description) });
        self
    }

    /// Gives the last columns a unit.
    pub fn in_unit(mut self, unit: &str, columns: usize) -> Self {
        self.columns.iter_mut().rev().take(columns).for_each(|column| column.unit = unit.to_owned());
        self
    }

    /// Adds two columns with the ends of an interval, which `of` describes.
    pub fn interval(self, name: &str, of: &str, ends: impl Fn(&'a R) -> Option<Interval>) -> Self {
        self.column(&format!("{name}_low"), &format!("Lower end of {of}."), |row| ends(row).map(|ends| ends.low))
            .column(&format!("{name}_high"), &format!("Upper end of {of}."), |row| ends(row).map(|ends| ends.high))
    }

    /// Adds a column for each of these categories.
    pub fn categories(self, categories: &[String], about: &str, proportions: impl Fn(&'a R) -> &'a [f64]) -> Self {
        let add = |all: Self, (place, category): (usize, &String)| {
            all.column(&format!("p{category}"), about, |row| proportions(row)[place])
        };
        categories.iter().enumerate().fold(self, add)
    }

    /// Adds a column with the levels of each of these factors; `level` returns that of a row and a factor.
    pub fn levels<'n>(mut self, names: impl Iterator<Item = &'n String>, level: impl Fn(&'a R, usize) -> Cell) -> Self {
        let first = self.columns.len();
        for (factor, name) in names.enumerate() {
            self = self.column(name, LEVEL, |row| level(row, factor));
        }
        Self { factors: first..self.columns.len(), ..self }
    }

    /// Returns the table.
    pub fn table(self) -> Table {
        Table { columns: apart(self.columns, self.factors) }
    }
}

/// Describes a column with the levels of a factor.
const LEVEL: &str = "Level of the factor.";

/// Makes the names of columns differ. Columns of factors get underscores at their ends; the others keep their names.
fn apart(mut columns: Vec<Column>, factors: Range<usize>) -> Vec<Column> {
    for factor in factors {
        while columns.iter().filter(|column| column.name == columns[factor].name).count() > 1 {
            columns[factor].name.push('_');
        }
    }
    columns
}

fn level(factor: &Factor, name: &str) -> Cell {
    if name.is_empty() {
        return Cell::Missing;
    }
    Cell::Level(name.to_owned(), factor.numbers.as_ref().and_then(|_| number_of(name)))
}

/// Begins a table of groups with their levels of these factors.
fn with_levels<'a, R>(rows: &'a [R], factors: &[Factor], names: impl Fn(&'a R) -> &'a [String]) -> Rows<'a, R> {
    Rows::new(rows)
        .levels(factors.iter().map(|factor| &factor.name), |row, place| level(&factors[place], &names(row)[place]))
}

/// Adds the summary of each row's ratings.
fn with_summary<'a, R>(rows: Rows<'a, R>, counts: &Counts, of: impl Fn(&'a R) -> &'a Summary) -> Rows<'a, R> {
    rows.column("n", "Number of ratings.", |row| of(row).n)
        .column("mean", "Mean rating, in which each participant counts equally.", |row| of(row).mean)
        .column("median", "Median rating.", |row| of(row).median)
        .categories(&counts.categories, "Proportion of the ratings that are in this category.", |row| {
            &of(row).proportions
        })
        .interval("ci", "the 95 % interval of the mean", |row| of(row).interval)
        .column("subjects", "Number of participants.", |row| of(row).subjects)
}

/// Adds the median response time of each row.
fn with_times<R>(rows: Rows<'_, R>, of: impl Fn(&R) -> Option<f64>) -> Table {
    let about = "Median time from the onset of the stimulus to the rating.";
    rows.column("response_time_median_s", about, of).in_unit("s", 1).table()
}

/// Lists every cell of the design.
fn cells(results: &Results) -> Table {
    let counts = &results.measured.counts;
    let rows = with_levels(&results.cells, &counts.factors, |group| &group.names);
    with_summary(rows, counts, |group| &group.summary).table()
}

/// Lists the levels of a factor.
fn by_factor(results: &Results, factor: &FactorResults) -> Table {
    let counts = &results.measured.counts;
    let factors: Vec<Factor> = counts.factors.iter().filter(|known| known.name == factor.name).cloned().collect();
    let rows: Vec<(&Group, Option<f64>)> = factor.levels.iter().zip(factor.times.iter().copied()).collect();
    let rows = with_levels(&rows, &factors, |(group, _)| &group.names);
    with_times(with_summary(rows, counts, |(group, _)| &group.summary), |(_, times)| *times)
}

/// Lists every participant.
fn subjects(results: &Results) -> Table {
    let rows = Rows::new(&results.subjects).column("subject_id", "Participant.", |own| own.group.names[0].as_str());
    let rows = with_summary(rows, &results.measured.counts, |own| &own.group.summary)
        .column("retests", "Number of conditions that the participant rated at least twice.", |own| own.retests)
        .column("kappa", "Quadratically weighted κ of first and second ratings.", |own| own.kappa);
    with_times(rows, |own| own.time)
}

/// Lists Friedman's tests, the likelihood-ratio tests and the comparisons of levels. For a single participant, Friedman's
/// tests are missing, and the others are about that participant's trials.
fn tests(results: &Results) -> Table {
    let columns = columns(&[
        ("test", "Name of the test."),
        ("term", "Factor or term that is tested."),
        ("level", "Later level of a comparison."),
        ("other", "Earlier level, which is subtracted from the later one."),
        ("n", "Number of participants, or of ratings for tests of the model."),
        ("statistic", "Test statistic."),
        ("df", "Degrees of freedom; none for a comparison."),
        ("p", "Probability of such a statistic without an effect."),
        ("p_holm", "p with Holm's correction for the tests of the same kind."),
        ("effect", "Size of the effect."),
        ("se", "Standard error of the effect."),
        ("ci_low", "Lower end of its 95 % interval."),
        ("ci_high", "Upper end of its 95 % interval."),
        ("effect_is", "What the size is."),
        ("note", "Where p comes from, and what limits the test."),
    ]);
    let mut rows = Vec::new();
    if results.is_inferential() {
        rows.extend(results.factors.iter().filter_map(friedman_row));
    }
    let scope = match results.is_inferential() {
        true if results.ignores_people() => "; ignores that ratings by the same participant are related",
        true => "",
        false => "; about this participant's trials only",
    };
    if let Ok(report) = &results.model {
        let simulated = format!("simulated studies{scope}");
        let mut row = |name: &str, test: &TermTest, [p, p_corrected]: [Option<f64>; 2], draws: &str| {
            let note = match (test.withheld, test.draws) {
                (Some(reason), _) => format!("no p: {reason}"),
                (None, Some(number)) => format!("p from {number} {draws}"),
                (None, None) => format!("p from the chi-squared distribution{scope}"),
            };
            let numbers = [test.chi_squared, Some(test.df as f64), p, p_corrected];
            rows.push(test_row([name, &test.term.to_string(), "", ""], report.model.nobs, &numbers, "", &note));
        };
        report.terms.iter().for_each(|test| row("likelihood-ratio", test, [test.p, None], &simulated));
        for Interaction { test, by_signs, .. } in &report.interactions {
            let draws = if *by_signs { "patterns of the participants' signs" } else { &simulated };
            row("interaction", test, [None, test.p], draws);
        }
        if let Some(order) = &report.order {
            let note = match (order.drift, order.drift_p) {
                (None, _) => "no estimate: the conditions tell the place of every trial",
                (_, Some(_)) => "p from the participants' signs",
                (_, None) => "no p: there are fewer than six participants",
            };
            let numbers = |p: Option<f64>, effect: Option<f64>| [None, None, p, None, effect];
            let drift = numbers(order.drift_p, order.drift);
            let what = "change of the latent rating over a session";
            rows.push(test_row(["drift", "", "", ""], order.ratings, &drift, what, note));
            let lag_one = numbers(Some(order.lag_one_p), Some(order.lag_one));
            let (what, note) = ("correlation of successive residuals", "p from the normal distribution");
            rows.push(test_row(["lag-one", "", "", ""], order.ratings, &lag_one, what, note));
        }
        for c in &report.comparisons {
            let average = c.average.then(|| "on average over the factors with which it interacts".to_owned());
            let at = c.at.as_ref().map(|(factor, level)| format!("at {factor} {level}")).or(average);
            let note =
                at.into_iter().chain(c.withheld.map(|reason| format!("no p: {reason}"))).collect::<Vec<_>>().join("; ");
            let [low, high] = [c.interval.map(|i| i.low), c.interval.map(|i| i.high)];
            let numbers = [None, None, c.p, c.p_holm, Some(c.estimate), c.se, low, high];
            let names = ["comparison", &c.factor, &c.level, &c.other];
            rows.push(test_row(names, report.model.nobs, &numbers, "difference on the latent scale", &note));
        }
    }
    Table::new(columns, rows)
}

/// Returns a row of the tests: `names` are the test, the term and two levels; `numbers` begins with the statistic, df, p,
/// the Holm-corrected p, the effect, its standard error, and the ends of its interval; then what the effect is, and a note.
fn test_row(names: [&str; 4], n: u64, numbers: &[Option<f64>], effect_is: &str, note: &str) -> Vec<Cell> {
    let names = names.into_iter().map(Cell::from).chain([n.into()]);
    let numbers = numbers.iter().copied().chain(std::iter::repeat(None)).take(8);
    names.chain(numbers.map(Cell::from)).chain([effect_is, note].map(Cell::from)).collect()
}

fn friedman_row(factor: &FactorResults) -> Option<Vec<Cell>> {
    let test = factor.friedman?;
    let numbers = [Some(test.chi_squared), Some(test.df as f64), Some(test.p), None, Some(test.w)];
    let method = if test.is_exact { "exact" } else { "chi-squared approximation" };
    let note = match factor.matched.incomplete.len() {
        0 => method.to_owned(),
        n => format!("{method}; participants excluded because they did not rate every level: {n}"),
    };
    Some(test_row(["friedman", &factor.name, "", ""], test.subjects as u64, &numbers, "Kendall's W", &note))
}

/// Lists the agreement between participants (Krippendorff's α) and within each participant (weighted κ).
fn agreement(results: &Results) -> Table {
    let mut rows = Vec::new();
    let mut row = |measure: &str, subject: &str, n: u64, estimate: Option<f64>, interval: Option<Interval>| {
        let [low, high] = [interval.map(|interval| interval.low), interval.map(|interval| interval.high)];
        rows.push(vec![measure.into(), subject.into(), n.into(), estimate.into(), low.into(), high.into()]);
    };
    if let Some(alpha) = &results.alpha {
        row("krippendorff_alpha_ordinal", "", alpha.ratings, Some(alpha.alpha), alpha.interval);
    }
    if let Some((mean, interval)) = results.kappa {
        let pairs = results.subjects.iter().map(|subject| subject.retests).sum();
        row("retest_kappa_quadratic_mean", "", pairs, Some(mean), interval);
    }
    for subject in results.subjects.iter().filter(|subject| subject.retests > 0) {
        row("retest_kappa_quadratic", &subject.group.names[0], subject.retests, subject.kappa, None);
    }
    let columns = columns(&[
        ("measure", "Coefficient of agreement."),
        ("subject_id", "Participant, if it is about one."),
        ("n", "Number of ratings, or of pairs of ratings."),
        ("estimate", "Value of the coefficient."),
        ("ci_low", "Lower end of its 95 % interval."),
        ("ci_high", "Upper end of its 95 % interval."),
    ]);
    Table::new(columns, rows)
}

/// Describes the columns of the sufficient statistic: the participant, the factors, the response and the count.
pub(super) fn count_columns(counts: &Counts, shape: &Shape) -> Vec<Column> {
    let count = if shape.response == "count" || shape.subject == "count" { "count_" } else { "count" };
    let factors = counts.factors.iter().map(|factor| (factor.name.as_str(), LEVEL));
    let last = [(shape.response.as_str(), "Category of the rating."), (count, "Number of equal ratings.")];
    let all = [(shape.subject.as_str(), "Participant.")].into_iter().chain(factors).chain(last);
    apart(columns(&all.collect::<Vec<_>>()), 1..1 + counts.factors.len())
}

/// Lists the sufficient statistic: participant, factors, rating and count. `analyze` can read this table in place of the files,
/// because the columns of the participant and the response keep their names.
pub fn counts(counts: &Counts, shape: &Shape) -> Table {
    counts_of(counts, &counts.rows, shape)
}

/// Writes the sufficient statistic as CSV. There may be millions of counts, whose cells would not fit in memory at once.
pub fn counts_csv(counts: &Counts, shape: &Shape) -> Vec<u8> {
    const PART: usize = 10_000;
    let header = counts_of(counts, &[], shape).csv();
    let mut csv = header.clone();
    for rows in counts.rows.chunks(PART) {
        csv.extend_from_slice(&counts_of(counts, rows, shape).csv()[header.len()..]);
    }
    csv
}

fn counts_of(counts: &Counts, rows: &[CountRow], shape: &Shape) -> Table {
    let categories: Vec<Cell> =
        counts.categories.iter().map(|category| Cell::Level(category.clone(), number_of(category))).collect();
    let rows = rows.iter().map(|row| {
        let mut cells = vec![Cell::Text(counts.subjects[row.subject as usize].clone())];
        let names = counts.level_names(row.condition);
        cells.extend(counts.factors.iter().zip(names).map(|(factor, name)| level(factor, name)));
        cells.extend([categories[row.rating as usize].clone(), row.count.into()]);
        cells
    });
    Table::new(count_columns(counts, shape), rows)
}

/// Lists the model's expected ratings in each condition, for a typical participant.
fn predictions(results: &Results, report: &ModelReport) -> Table {
    with_levels(&report.predictions, &results.modeled().factors, |row| &row.names)
        .categories(&report.model.categories, "Expected proportion of ratings in this category.", |row| {
            &row.probabilities
        })
        .column("mean", "Expected rating.", |row| row.mean)
        .interval("ci", "its 95 % interval", |row| row.interval)
        .table()
}

/// Lists the model's coefficients on the scale of the link and, with the logit link, their odds ratios.
fn coefficients(model: &Model) -> Table {
    let few = "Probability of such a z; missing with few participants, for whom it would be too small.";
    let all = Rows::new(&model.coefficients)
        .column("name", "Name of the coefficient, as in R.", |c| c.name.as_str())
        .column("term", "Term that it belongs to.", |c| c.term.to_string())
        .column("estimate", "Estimate on the scale of the link.", |c| c.estimate)
        .column("se", "Standard error.", |c| c.se)
        .column("z", "Estimate divided by its standard error.", |c| c.z)
        .column("p", few, |c| c.p)
        .interval("ci", "the 95 % interval", |c| c.interval);
    if model.link != Link::Logit {
        return all.table();
    }
    let odds = |i: Interval| Interval { low: i.low.exp(), high: i.high.exp() };
    all.column("odds_ratio", "Odds ratio of a higher rating.", |c| c.estimate.exp())
        .interval("odds_ratio", "its 95 % interval", |c| c.interval.map(odds))
        .table()
}

/// Returns all tables but the sufficient statistic, with the names of their files without the extension.
pub fn all(results: &Results) -> Vec<(String, Table)> {
    let mut tables = vec![
        ("cells".to_owned(), cells(results)),
        ("subjects".to_owned(), subjects(results)),
        ("tests".to_owned(), tests(results)),
        ("agreement".to_owned(), agreement(results)),
    ];
    if let Ok(report) = &results.model {
        tables.push(("coefficients".to_owned(), coefficients(&report.model)));
        tables.push(("predictions".to_owned(), predictions(results, report)));
    }
    for factor in &results.factors {
        let mut name = format!("by_{}", file_part(&factor.name));
        // Some systems do not distinguish upper from lower case.
        while tables.iter().any(|(taken, _)| taken.to_lowercase() == name.to_lowercase()) {
            name.push('_');
        }
        tables.push((name, by_factor(results, factor)));
    }
    tables
}

/// Makes a factor's name safe for a file name: all characters except letters, digits, hyphens and dots become
/// underscores.
fn file_part(name: &str) -> String {
    name.chars().map(|c| if c.is_alphanumeric() || c == '-' || c == '.' { c } else { '_' }).collect()
}

/// Describes the model, or the reason why there is none.
pub fn model(results: &Results) -> Value {
    let spec = &results.spec;
    let asked = json!({
        "terms": spec.terms.to_string(), "random": spec.random,
    });
    match &results.model {
        Err(error) => json!({
            "error": error.to_string(), "asked": asked, "link": spec.link, "method": null,
            "nobs": results.measured.counts.total(), "loglik": null, "thresholds": [], "coefficients": [], "random": null,
        }),
        Ok(report) => {
            let mut value = serde_json::to_value(&report.model).unwrap_or_default();
            let sentences: Vec<String> = report.model.notes.iter().map(ToString::to_string).collect();
            value["asked"] = asked;
            value["aic"] = json!(report.model.aic());
            value["sentences"] = json!(sentences);
            value["bic"] = json!(report.model.bic());
            value["likelihood_ratio"] = json!(report.terms);
            value["interactions"] = json!(report.interactions);
            value["order"] = json!(report.order);
            value["comparisons"] = json!(report.comparisons);
            value["margins"] = json!(report.margins);
            value["checks"] = json!(report.checks);
            if !results.is_inferential() {
                value["scope"] = json!("trials of one participant");
            }
            value
        }
    }
}
