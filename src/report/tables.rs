//! The results as CSV and JSON. Missing values are empty, and numbers are written so that they read back exactly.

use std::borrow::Cow;

use serde_json::{Value, json};

use crate::analysis::{
    Contrast, Link, Model, Results,
    counts::{CountRow, Counts, Quartiles},
    rank_tests::PMethod,
    results::{FactorResults, SubjectResults},
    summary::Group,
};
use crate::statistics::Interval;
use crate::store::{ratings::Shape, table::inert};

/// A table: its header and its rows.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// Names of the columns.
    pub header: Vec<String>,
    /// Cells, one per column.
    pub rows: Vec<Vec<String>>,
}

impl Table {
    fn new(header: impl IntoIterator<Item = impl Into<String>>, rows: Vec<Vec<String>>) -> Self {
        Self { header: header.into_iter().map(Into::into).collect(), rows }
    }

    /// Writes the table as CSV in UTF-8. Texts that a spreadsheet would evaluate as formulas are prefixed with an
    /// apostrophe.
    pub fn csv(&self) -> Vec<u8> {
        csv(std::iter::once(&self.header).chain(&self.rows))
    }
}

fn csv<Row: IntoIterator<Item: AsRef<str>>>(rows: impl Iterator<Item = Row>) -> Vec<u8> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    for row in rows {
        // Writing to memory does not fail, and all rows have as many cells as the header.
        let _ = writer.write_record(row.into_iter().map(|cell| inert(cell.as_ref()).into_owned()));
    }
    writer.into_inner().unwrap_or_default()
}

/// Formats a number so that it reads back exactly; very small and very large numbers have an exponent.
pub fn number(value: f64) -> String {
    // Adding 0 turns −0 into 0.
    let value = value + 0.0;
    match value.abs() {
        magnitude if magnitude > 0.0 && !(1e-4..1e15).contains(&magnitude) => format!("{value:e}"),
        _ => value.to_string(),
    }
}

fn maybe(value: Option<f64>) -> String {
    value.map(number).unwrap_or_default()
}

fn ends(interval: Option<Interval>) -> [String; 2] {
    [maybe(interval.map(|interval| interval.low)), maybe(interval.map(|interval| interval.high))]
}

/// Returns the header `n, mean, median, p…, ci_low, ci_high, subjects`, between other columns.
fn summary_header(first: impl IntoIterator<Item = String>, counts: &Counts, last: &[&str]) -> Vec<String> {
    let proportions = counts.categories.iter().map(|category| format!("p{category}"));
    let owned = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect::<Vec<_>>();
    let parts = [first.into_iter().collect(), owned(&["n", "mean", "median"]), proportions.collect()];
    [&parts.concat()[..], &owned(&["ci_low", "ci_high", "subjects"]), &owned(last)].concat()
}

fn group_row(Group { names, summary }: &Group) -> Vec<String> {
    let mut cells = names.clone();
    cells.extend([summary.n.to_string(), number(summary.mean), number(summary.median)]);
    cells.extend(summary.proportions.iter().map(|&p| number(p)));
    cells.extend(ends(summary.interval));
    cells.push(summary.subjects.to_string());
    cells
}

/// Lists every cell of the design.
pub fn cells(results: &Results) -> Table {
    let counts = &results.measured.counts;
    let factors = counts.factors.iter().map(|factor| factor.name.clone());
    Table::new(summary_header(factors, counts, &[]), results.cells.iter().map(group_row).collect())
}

/// Lists the levels of a factor.
pub fn by_factor(results: &Results, factor: &FactorResults) -> Table {
    let header = summary_header([factor.name.clone()], &results.measured.counts, &["response_time_median_s"]);
    let row = |(group, times): (&Group, &Option<Quartiles>)| [group_row(group), vec![median(*times)]].concat();
    Table::new(header, factor.levels.iter().zip(&factor.times).map(row).collect())
}

/// Lists every participant.
pub fn subjects(results: &Results) -> Table {
    let more = ["retests", "kappa", "response_time_median_s"];
    let header = summary_header(["subject_id".to_owned()], &results.measured.counts, &more);
    let row = |subject: &SubjectResults| {
        let more = [subject.retests.to_string(), maybe(subject.kappa), median(subject.times)];
        [group_row(&subject.group), more.to_vec()].concat()
    };
    Table::new(header, results.subjects.iter().map(row).collect())
}

fn median(times: Option<Quartiles>) -> String {
    maybe(times.map(|times| times.median))
}

/// Lists Friedman's and Wilcoxon's tests and the likelihood-ratio tests. For a single participant, there are only the
/// latter, about that participant's trials.
pub fn tests(results: &Results) -> Table {
    let header =
        ["test", "term", "level", "other", "n", "statistic", "df", "p", "p_holm", "effect", "effect_is", "note"];
    let mut rows = Vec::new();
    if results.is_inferential() {
        rows.extend(results.factors.iter().flat_map(rank_rows));
    }
    let scope = if results.is_inferential() { "" } else { "; about this participant's trials only" };
    if let Ok(report) = &results.model {
        let groups = [("likelihood-ratio", &report.terms), ("proportional-odds", &report.proportional_odds)];
        for (name, test) in groups.iter().flat_map(|(name, tests)| tests.iter().map(move |test| (name, test))) {
            let numbers = [test.lr, Some(test.df as f64), test.p, test.p_holm, None];
            let note = match (test.withheld, test.draws) {
                (Some(reason), _) => format!("no p: {reason}"),
                (None, Some(draws)) => format!("p from {draws} simulated studies{scope}"),
                (None, None) => format!("p from the chi-squared distribution{scope}"),
            };
            rows.push(test_row([name, &test.term, "", ""], report.model.nobs, numbers, "", &note));
        }
        for c in &report.comparisons {
            let note = c.at.as_ref().map_or_else(String::new, |(factor, level)| format!("at {factor} {level}"));
            let numbers = [None, None, c.p, c.p_holm, Some(c.estimate)];
            let names = ["comparison", &c.factor, &c.level, &c.other];
            rows.push(test_row(names, report.model.nobs, numbers, "difference on the latent scale", &note));
        }
    }
    Table::new(header, rows)
}

/// Formats a row of the tests: `names` are the test, the term and two levels; `numbers` are the statistic, df, p, the
/// Holm-corrected p, and the effect; then what the effect is, and a note.
fn test_row(names: [&str; 4], n: u64, numbers: [Option<f64>; 5], effect_is: &str, note: &str) -> Vec<String> {
    let names = names.into_iter().map(str::to_owned).chain([n.to_string()]);
    names.chain(numbers.map(maybe)).chain([effect_is, note].map(str::to_owned)).collect()
}

fn method(method: PMethod) -> &'static str {
    match method {
        PMethod::Exact => "exact",
        PMethod::Permutations => "100000 random orders",
        PMethod::ChiSquared => "chi-squared approximation",
        PMethod::Normal => "normal approximation",
    }
}

fn rank_rows(factor: &FactorResults) -> Vec<Vec<String>> {
    let (name, mut rows) = (&factor.name, Vec::new());
    let left_out = match factor.incomplete.len() {
        0 => String::new(),
        n => format!("participants excluded because they did not rate every level: {n}"),
    };
    if let Some(test) = &factor.friedman {
        let numbers = [Some(test.chi_squared), Some(test.df as f64), Some(test.p), None, Some(test.w)];
        let note = [method(test.method), &left_out].into_iter().filter(|note| !note.is_empty()).collect::<Vec<_>>();
        rows.push(test_row(["friedman", name, "", ""], test.subjects as u64, numbers, "Kendall's W", &note.join("; ")));
    }
    let Some(pairs) = &factor.pairs else { return rows };
    let limit = if pairs.cannot_reach(0.05) {
        let n = super::document::numbers::count(pairs.pairs.len() as u64, "pair");
        format!("with so few participants and {n}, p_holm cannot be below {:.3}", pairs.least_p)
    } else {
        String::new()
    };
    for pair in &pairs.pairs {
        let method = method(pair.test.method);
        let note =
            [method, &limit, &left_out].into_iter().filter(|note| !note.is_empty()).collect::<Vec<_>>().join("; ");
        let numbers = [Some(pair.test.v), None, Some(pair.test.p), Some(pair.p_holm), Some(pair.difference)];
        let names = ["wilcoxon", name, &pair.level, &pair.other];
        rows.push(test_row(names, pair.test.n as u64, numbers, "mean difference", &note));
    }
    rows
}

/// Lists the agreement between participants (Krippendorff's α) and within each participant (weighted κ).
pub fn agreement(results: &Results) -> Table {
    let mut rows = Vec::new();
    let mut row = |measure: &str, subject: &str, n: u64, estimate: Option<f64>, interval: Option<Interval>| {
        let [low, high] = ends(interval);
        rows.push(vec![measure.to_owned(), subject.to_owned(), n.to_string(), maybe(estimate), low, high]);
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
    Table::new(["measure", "subject_id", "n", "estimate", "ci_low", "ci_high"], rows)
}

/// Lists the sufficient statistic as CSV: participant, factors, rating and count. `analyze` can read this table in
/// place of the files, because the columns of the participant and the response keep their names. There may be millions
/// of rows, so no [`Table`] is built.
pub fn counts(counts: &Counts, shape: &Shape) -> Vec<u8> {
    let factors = counts.factors.iter().map(|factor| &factor.name);
    let header = [&shape.subject].into_iter().chain(factors).map(Cow::from);
    let header = header.chain([Cow::from(&shape.response), Cow::from("count")]).collect();
    let row = |row: &CountRow| {
        let mut cells = vec![Cow::from(&counts.subjects[row.subject as usize])];
        cells.extend(counts.level_names(row.condition).into_iter().map(Cow::from));
        cells.extend([Cow::from(&counts.categories[row.rating as usize]), row.count.to_string().into()]);
        cells
    };
    csv(std::iter::once(header).chain(counts.rows.iter().map(row)))
}

/// Lists the model's expected ratings in each condition, for a typical participant.
pub fn predictions(results: &Results) -> Option<Table> {
    let report = results.model.as_ref().ok()?;
    let factors = results.measured.counts.factors.iter().map(|factor| factor.name.clone());
    let header = factors
        .chain(report.model.categories.iter().map(|category| format!("p{category}")))
        .chain(["mean", "ci_low", "ci_high"].map(str::to_owned));
    let rows = (report.predictions.iter())
        .map(|prediction| {
            let numbers = prediction.probabilities.iter().chain([&prediction.mean]).map(|&value| number(value));
            prediction.names.iter().cloned().chain(numbers).chain(ends(prediction.interval)).collect()
        })
        .collect();
    Some(Table::new(header, rows))
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
            let (share, interval) = report.model.share_between();
            value["intraclass_correlation"] = json!({ "estimate": share, "interval": interval });
            value["likelihood_ratio"] = json!(report.terms);
            value["proportional_odds"] = json!(report.proportional_odds);
            value["effect_sizes"] = effect_sizes(&report.model);
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

/// Lists the contrasts as odds ratios, probabilities of superiority and latent differences in standard deviations.
fn effect_sizes(model: &Model) -> Value {
    let link = model.link;
    let of = |contrast: &Contrast, scale: &dyn Fn(f64) -> f64| {
        let ends = contrast.interval.map(|interval| [scale(interval.low), scale(interval.high)]);
        json!({ "estimate": scale(contrast.estimate), "interval": ends })
    };
    let row = |contrast: &Contrast| {
        let mut value = json!({
            "factor": contrast.factor, "level": contrast.level, "other": contrast.other,
            "superiority": of(contrast, &|x| link.superiority(x)), "d": of(contrast, &|x| x / link.sd()),
        });
        if link == Link::Logit {
            value["odds_ratio"] = of(contrast, &f64::exp);
        }
        value
    };
    model.contrasts.iter().map(row).collect()
}
