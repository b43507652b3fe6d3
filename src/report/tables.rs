//! The results as tables and as JSON.

use serde_json::{Value, json};

use crate::{
    analysis::{
        Coefficient, Contrast, Link, Model, Prediction, Results,
        counts::{CountRow, Counts, Factor, Quartiles},
        number_of,
        rank_tests::PMethod,
        results::{FactorResults, SubjectResults},
        summary::Group,
    },
    statistics::Interval,
    store::ratings::Shape,
    text::{self, Cell, Column, Table},
};

fn columns(named: &[(&str, &str, &str)]) -> Vec<Column> {
    named.iter().map(|(name, unit, description)| Column::new(*name, unit, *description)).collect()
}

fn ends(interval: Option<Interval>) -> [Cell; 2] {
    [interval.map(|interval| interval.low).into(), interval.map(|interval| interval.high).into()]
}

/// Inserts a column with the levels of each factor of ratings between other columns.
fn with_levels(first: Vec<Column>, factors: &[Factor], last: Vec<Column>) -> Vec<Column> {
    with_factors(first, factors.iter().map(|factor| factor.name.clone()).collect(), last)
}

/// Inserts a column with the levels of each factor between other columns, which keep their names: a factor of the same
/// name gets underscores at its end.
pub(super) fn with_factors(first: Vec<Column>, mut names: Vec<String>, last: Vec<Column>) -> Vec<Column> {
    for factor in 0..names.len() {
        let is_fixed = |name: &String| first.iter().chain(&last).any(|column| column.name == *name);
        while is_fixed(&names[factor]) || names.iter().filter(|name| **name == names[factor]).count() > 1 {
            names[factor].push('_');
        }
    }
    let level = |name: String| Column::new(name, "", "Level of the factor.");
    first.into_iter().chain(names.into_iter().map(level)).chain(last).collect()
}

/// Describes a column for each of these categories.
fn proportions(categories: &[String], description: &str) -> Vec<Column> {
    categories.iter().map(|category| Column::new(format!("p{category}"), "", description)).collect()
}

fn level(factor: &Factor, name: &str) -> Cell {
    if name.is_empty() {
        return Cell::Missing;
    }
    Cell::Level(name.to_owned(), factor.numbers.as_ref().and_then(|_| number_of(name)))
}

/// Returns the cells of the levels of these factors.
fn levels<'a, Name: AsRef<str> + 'a>(factors: &[Factor], names: impl IntoIterator<Item = &'a Name>) -> Vec<Cell> {
    factors.iter().zip(names).map(|(factor, name)| level(factor, name.as_ref())).collect()
}

/// Describes the columns of a summary, and the last columns.
fn summary_columns(counts: &Counts, last: Vec<Column>) -> Vec<Column> {
    let mut all = columns(&[
        ("n", "", "Number of ratings."),
        ("mean", "", "Mean rating, in which each participant counts equally."),
        ("median", "", "Median rating."),
    ]);
    all.extend(proportions(&counts.categories, "Proportion of the ratings that are in this category."));
    all.extend(columns(&[
        ("ci_low", "", "Lower end of the 95 % interval of the mean."),
        ("ci_high", "", "Upper end of the 95 % interval of the mean."),
        ("subjects", "", "Number of participants."),
    ]));
    all.extend(last);
    all
}

/// Returns the cells of a summary, after those of what it summarizes.
fn summary_row(first: Vec<Cell>, Group { summary, .. }: &Group) -> Vec<Cell> {
    let mut cells = first;
    cells.extend([summary.n.into(), summary.mean.into(), summary.median.into()]);
    cells.extend(summary.proportions.iter().map(|p| Cell::from(*p)));
    cells.extend(ends(summary.interval));
    cells.push(summary.subjects.into());
    cells
}

/// Lists every cell of the design.
pub fn cells(results: &Results) -> Table {
    let counts = &results.measured.counts;
    let row = |group: &Group| summary_row(levels(&counts.factors, &group.names), group);
    let columns = with_levels(Vec::new(), &counts.factors, summary_columns(counts, Vec::new()));
    Table::new(columns, results.cells.iter().map(row))
}

fn median_column() -> Column {
    Column::new("response_time_median_s", "s", "Median time from the onset of the stimulus to the rating.")
}

/// Lists the levels of a factor.
pub fn by_factor(results: &Results, factor: &FactorResults) -> Table {
    let counts = &results.measured.counts;
    let factors: Vec<Factor> = counts.factors.iter().filter(|known| known.name == factor.name).cloned().collect();
    let row = |(group, times): (&Group, &Option<Quartiles>)| {
        let mut row = summary_row(levels(&factors, &group.names), group);
        row.push(median(*times));
        row
    };
    let columns = with_levels(Vec::new(), &factors, summary_columns(counts, vec![median_column()]));
    Table::new(columns, factor.levels.iter().zip(&factor.times).map(row))
}

/// Lists every participant.
pub fn subjects(results: &Results) -> Table {
    let mut last = columns(&[
        ("retests", "", "Number of conditions that the participant rated at least twice."),
        ("kappa", "", "Quadratically weighted κ of first and second ratings."),
    ]);
    last.push(median_column());
    let row = |subject: &SubjectResults| {
        let mut row =
            summary_row(subject.group.names.iter().map(|name| name.as_str().into()).collect(), &subject.group);
        row.extend([subject.retests.into(), subject.kappa.into(), median(subject.times)]);
        row
    };
    let mut columns = vec![Column::new("subject_id", "", "Participant.")];
    columns.extend(summary_columns(&results.measured.counts, last));
    Table::new(columns, results.subjects.iter().map(row))
}

fn median(times: Option<Quartiles>) -> Cell {
    times.map(|times| times.median).into()
}

/// Lists Friedman's tests, the likelihood-ratio tests and the comparisons of levels. For a single participant, Friedman's
/// tests are missing, and the others are about that participant's trials.
pub fn tests(results: &Results) -> Table {
    let columns = columns(&[
        ("test", "", "Name of the test."),
        ("term", "", "Factor or term that is tested."),
        ("level", "", "Level that is compared."),
        ("other", "", "Level with which it is compared."),
        ("n", "", "Number of participants, or of ratings for tests of the model."),
        ("statistic", "", "Test statistic."),
        ("df", "", "Degrees of freedom; none for a comparison."),
        ("p", "", "Probability of such a statistic without an effect."),
        ("p_holm", "", "p with Holm's correction for the tests of the same kind."),
        ("effect", "", "Size of the effect."),
        ("se", "", "Standard error of the effect."),
        ("ci_low", "", "Lower end of its 95 % interval."),
        ("ci_high", "", "Upper end of its 95 % interval."),
        ("effect_is", "", "What the size is."),
        ("note", "", "Where p comes from, and what limits the test."),
    ]);
    let mut rows = Vec::new();
    if results.is_inferential() {
        rows.extend(results.factors.iter().filter_map(friedman_row));
    }
    let scope = if results.is_inferential() { "" } else { "; about this participant's trials only" };
    if let Ok(report) = &results.model {
        let groups = [("likelihood-ratio", &report.terms), ("proportional-odds", &report.proportional_odds)];
        for (name, test) in groups.iter().flat_map(|(name, tests)| tests.iter().map(move |test| (name, test))) {
            let numbers = [test.lr, Some(test.df as f64), test.p, test.p_holm];
            let note = match (test.withheld, test.draws) {
                (Some(reason), _) => format!("no p: {reason}"),
                (None, Some(draws)) => format!("p from {draws} simulated studies{scope}"),
                (None, None) => format!("p from the chi-squared distribution{scope}"),
            };
            rows.push(test_row([name, &test.term, "", ""], report.model.nobs, &numbers, "", &note));
        }
        for test in &report.interactions {
            let note = match test.withheld {
                Some(reason) => format!("no p: {reason}"),
                None if test.by_signs => format!("p from {} patterns of the participants' signs{scope}", test.draws),
                None => format!("p from {} simulated studies{scope}", test.draws),
            };
            let numbers = [test.chi_squared, Some(test.df as f64), None, test.p];
            rows.push(test_row(["interaction", &test.term, "", ""], report.model.nobs, &numbers, "", &note));
        }
        if let Some(order) = &report.order {
            let note = match (order.drift, order.drift_p) {
                (None, _) => "no estimate: the conditions tell the place of every trial",
                (_, Some(_)) => "p from the participants' signs",
                (_, None) => "no p: there are fewer than six participants",
            };
            let (drift, lag_one) =
                ("change of the latent rating over a session", "correlation of successive residuals");
            let with_p = |p: Option<f64>, effect: Option<f64>| [None, None, p, None, effect];
            for (test, numbers, what, note) in [
                ("drift", with_p(order.drift_p, order.drift), drift, note),
                (
                    "lag-one",
                    with_p(Some(order.lag_one_p), Some(order.lag_one)),
                    lag_one,
                    "p from the normal distribution",
                ),
            ] {
                rows.push(test_row([test, "", "", ""], order.ratings, &numbers, what, note));
            }
        }
        for c in &report.comparisons {
            let at = c.at.as_ref().map(|(factor, level)| format!("at {factor} {level}"));
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

fn method(method: PMethod) -> &'static str {
    match method {
        PMethod::Exact => "exact",
        PMethod::Permutations => "random orders",
        PMethod::ChiSquared => "chi-squared approximation",
    }
}

fn friedman_row(factor: &FactorResults) -> Option<Vec<Cell>> {
    let test = factor.friedman?;
    let numbers = [Some(test.chi_squared), Some(test.df as f64), Some(test.p), None, Some(test.w)];
    let note = match factor.matched.incomplete.len() {
        0 => method(test.method).to_owned(),
        n => format!("{}; participants excluded because they did not rate every level: {n}", method(test.method)),
    };
    Some(test_row(["friedman", &factor.name, "", ""], test.subjects as u64, &numbers, "Kendall's W", &note))
}

/// Lists the agreement between participants (Krippendorff's α) and within each participant (weighted κ).
pub fn agreement(results: &Results) -> Table {
    let mut rows = Vec::new();
    let mut row = |measure: &str, subject: &str, n: u64, estimate: Option<f64>, interval: Option<Interval>| {
        let [low, high] = ends(interval);
        rows.push(vec![measure.into(), subject.into(), n.into(), estimate.into(), low, high]);
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
        ("measure", "", "Coefficient of agreement."),
        ("subject_id", "", "Participant, if it is about one."),
        ("n", "", "Number of ratings, or of pairs of ratings."),
        ("estimate", "", "Value of the coefficient."),
        ("ci_low", "", "Lower end of its 95 % interval."),
        ("ci_high", "", "Upper end of its 95 % interval."),
    ]);
    Table::new(columns, rows)
}

/// Describes the columns of the sufficient statistic: the participant, the factors, the response and the count.
pub(super) fn count_columns(counts: &Counts, shape: &Shape) -> Vec<Column> {
    let count = if shape.response == "count" || shape.subject == "count" { "count_" } else { "count" };
    let last = [(shape.response.as_str(), "", "Category of the rating."), (count, "", "Number of equal ratings.")];
    with_levels(columns(&[(shape.subject.as_str(), "", "Participant.")]), &counts.factors, columns(&last))
}

/// Returns the columns and the rows of the sufficient statistic: participant, factors, rating and count. `analyze` can
/// read this table in place of the files, because the columns of the participant and the response keep their names.
fn count_rows<'a>(counts: &'a Counts, shape: &Shape) -> (Vec<Column>, impl Iterator<Item = Vec<Cell>> + 'a) {
    let columns = count_columns(counts, shape);
    let conditions: Vec<Vec<Cell>> = (0..counts.conditions.len() as u32)
        .map(|condition| levels(&counts.factors, &counts.level_names(condition)))
        .collect();
    let categories: Vec<Cell> =
        counts.categories.iter().map(|category| Cell::Level(category.clone(), number_of(category))).collect();
    let rows = counts.rows.iter().map(move |row: &CountRow| {
        let mut cells = vec![Cell::Text(counts.subjects[row.subject as usize].clone())];
        cells.extend_from_slice(&conditions[row.condition as usize]);
        cells.extend([categories[row.rating as usize].clone(), row.count.into()]);
        cells
    });
    (columns, rows)
}

/// Writes the sufficient statistic as CSV. There may be millions of rows, so no [`Table`] is built.
pub fn counts_csv(counts: &Counts, shape: &Shape) -> Vec<u8> {
    let (columns, rows) = count_rows(counts, shape);
    text::csv(columns.iter().map(|column| column.name.as_str()), rows)
}

/// Lists the sufficient statistic.
pub fn counts(counts: &Counts, shape: &Shape) -> Table {
    let (columns, rows) = count_rows(counts, shape);
    Table::new(columns, rows)
}

/// Lists the model's expected ratings in each condition, for a typical participant.
pub fn predictions(results: &Results) -> Option<Table> {
    let report = results.model.as_ref().ok()?;
    let counts = results.modeled();
    let mut all = proportions(&report.model.categories, "Expected proportion of ratings in this category.");
    all.extend(columns(&[
        ("mean", "", "Expected rating."),
        ("ci_low", "", "Lower end of its 95 % interval."),
        ("ci_high", "", "Upper end of its 95 % interval."),
    ]));
    let row = |prediction: &Prediction| {
        let mut cells = levels(&counts.factors, &prediction.names);
        cells.extend(prediction.probabilities.iter().chain([&prediction.mean]).map(|value| Cell::from(*value)));
        cells.extend(ends(prediction.interval));
        cells
    };
    Some(Table::new(with_levels(Vec::new(), &counts.factors, all), report.predictions.iter().map(row)))
}

/// Lists the model's coefficients on the scale of the link and, with the logit link, their odds ratios.
fn coefficients(model: &Model) -> Table {
    let mut all = columns(&[
        ("name", "", "Name of the coefficient, as in R."),
        ("term", "", "Term that it belongs to."),
        ("estimate", "", "Estimate on the scale of the link."),
        ("se", "", "Standard error."),
        ("z", "", "Estimate divided by its standard error."),
        ("p", "", "Probability of such a z; missing with few participants, for whom it would be too small."),
        ("ci_low", "", "Lower end of the 95 % interval."),
        ("ci_high", "", "Upper end of the 95 % interval."),
    ]);
    let odds = columns(&[
        ("odds_ratio", "", "Odds ratio of a higher rating."),
        ("odds_ratio_low", "", "Lower end of its 95 % interval."),
        ("odds_ratio_high", "", "Upper end of its 95 % interval."),
    ]);
    let has_odds = model.link == Link::Logit;
    all.extend(odds.into_iter().filter(|_| has_odds));
    let row = |c: &Coefficient| {
        let [low, high] = [c.interval.map(|i| i.low), c.interval.map(|i| i.high)];
        let numbers = [Some(c.estimate), c.se, c.z, c.p, low, high];
        let odds = [Some(c.estimate), low, high].map(|x| x.map(f64::exp)).into_iter().filter(|_| has_odds);
        let names = [&c.name, &c.term].map(|name| Cell::from(name.as_str()));
        names.into_iter().chain(numbers.into_iter().chain(odds).map(Cell::from)).collect()
    };
    Table::new(all, model.coefficients.iter().map(row))
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
    }
    tables.extend(predictions(results).map(|table| ("predictions".to_owned(), table)));
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
            let (share, interval) = report.model.share_between();
            value["intraclass_correlation"] = json!({ "estimate": share, "interval": interval });
            value["likelihood_ratio"] = json!(report.terms);
            value["proportional_odds"] = json!(report.proportional_odds);
            value["interactions"] = json!(report.interactions);
            value["order"] = json!(report.order);
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
