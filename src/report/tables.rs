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

    /// Returns the table, in which the names of columns differ. Columns of factors get underscores at their ends; the others
    /// keep their names.
    pub fn table(self) -> Table {
        let Self { mut columns, factors, .. } = self;
        for factor in factors {
            while columns.iter().filter(|column| column.name == columns[factor].name).count() > 1 {
                columns[factor].name.push('_');
            }
        }
        Table { columns }
    }
}

/// Describes a column with the levels of a factor.
const LEVEL: &str = "Level of the factor.";

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
    let columns = [
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
    ];
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
    Table::new(columns.map(|(name, description)| Column::new(name, "", description)).into(), rows)
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

/// A coefficient of agreement: its name, the participant, the number of ratings or pairs, its value and its interval.
type OfAgreement<'a> = (&'static str, &'a str, u64, Option<f64>, Option<Interval>);

/// Lists the agreement between participants (Krippendorff's α) and within each participant (weighted κ).
fn agreement(results: &Results) -> Table {
    let all = &results.subjects;
    let between =
        results.alpha.map(|own| ("krippendorff_alpha_ordinal", "", own.ratings, Some(own.alpha), own.interval));
    let pairs = all.iter().map(|subject| subject.retests).sum();
    let within = results.kappa.map(|(mean, interval)| ("retest_kappa_quadratic_mean", "", pairs, Some(mean), interval));
    let own = all
        .iter()
        .filter(|subject| subject.retests > 0)
        .map(|subject| ("retest_kappa_quadratic", &*subject.group.names[0], subject.retests, subject.kappa, None));
    let rows: Vec<OfAgreement<'_>> = between.into_iter().chain(within).chain(own).collect();
    Rows::new(&rows)
        .column("measure", "Coefficient of agreement.", |(measure, ..)| *measure)
        .column("subject_id", "Participant, if it is about one.", |(_, subject, ..)| *subject)
        .column("n", "Number of ratings, or of pairs of ratings.", |(_, _, n, ..)| *n)
        .column("estimate", "Value of the coefficient.", |(.., estimate, _)| *estimate)
        .interval("ci", "its 95 % interval", |(.., interval)| *interval)
        .table()
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
    let name = if [&shape.response, &shape.subject].iter().any(|name| *name == "count") { "count_" } else { "count" };
    let categories: Vec<Cell> =
        counts.categories.iter().map(|category| Cell::Level(category.clone(), number_of(category))).collect();
    let own_level = |row: &CountRow, factor: usize| {
        let own = &counts.factors[factor];
        counts.conditions[row.condition as usize][factor]
            .map_or(Cell::Missing, |at| level(own, &own.levels[at as usize]))
    };
    Rows::new(rows)
        .column(&shape.subject, "Participant.", |row| Cell::Text(counts.subjects[row.subject as usize].clone()))
        .levels(counts.factors.iter().map(|factor| &factor.name), own_level)
        .column(&shape.response, "Category of the rating.", |row| categories[row.rating as usize].clone())
        .column(name, "Number of equal ratings.", |row| row.count)
        .table()
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
    all.column("odds_ratio", "Odds ratio of a higher rating.", |c| c.estimate.exp())
        .interval("odds_ratio", "its 95 % interval", |c| Some(c.interval?.map(f64::exp)))
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
    let asked = json!({ "terms": spec.terms.to_string(), "random": spec.random });
    match &results.model {
        Err(error) => json!({
            "error": error.to_string(), "asked": asked, "link": spec.link, "method": null,
            "nobs": results.measured.counts.total(), "loglik": null, "thresholds": [], "coefficients": [], "random": null,
        }),
        Ok(report) => {
            let mut value = serde_json::to_value(report).unwrap_or_default();
            let sentences: Vec<String> = report.model.notes.iter().map(ToString::to_string).collect();
            value["asked"] = asked;
            value["sentences"] = json!(sentences);
            value["aic"] = json!(report.model.aic());
            value["bic"] = json!(report.model.bic());
            if !results.is_inferential() {
                value["scope"] = json!("trials of one participant");
            }
            value
        }
    }
}
