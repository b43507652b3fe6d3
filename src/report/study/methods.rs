//! The methods and results sections for a paper, with numbers and references.

use std::collections::BTreeSet;

use super::{findings, health, names};
use crate::{
    analysis::{
        ModelReport, RandomSlope, Results, TermTest, rank_tests::PMethod, results::FactorResults, terms::Variable,
    },
    experiment::{Protocol, ResponseScale},
    report::document::{Section, count, fixed, list, p_is, times, unit, with_interval},
    store::ratings::Source,
};

/// One publication per line, sorted by name: its citation, a tab, and its entry in the list of references.
const PUBLICATIONS: &str = include_str!("references.txt");

/// The publications cited so far.
#[derive(Default)]
struct Cited(BTreeSet<&'static str>);

impl Cited {
    /// Records publications, given as citations separated by semicolons, and returns the same text.
    fn cite(&mut self, publications: &'static str) -> &'static str {
        self.0.extend(publications.split("; "));
        publications
    }
}

/// Writes the methods and their references.
pub(super) fn sections(source: &Source, results: &Results) -> (Section, Section) {
    let mut section = Section::new("methods", "Methods, ready to paste");
    let mut cited = Cited::default();
    let paragraphs = [
        Some(procedure(&mut cited, source, results)),
        model(&mut cited, results),
        tests(&mut cited, results),
        agreement(&mut cited, results),
        intervals(&mut cited, results),
        Some(format!("The analysis was performed with machband {}.", env!("CARGO_PKG_VERSION"))),
    ];
    paragraphs.into_iter().flatten().for_each(|paragraph| section.text(paragraph));
    let mut references = Section::new("references", "References");
    let publications = PUBLICATIONS.lines().filter_map(|line| line.split_once('\t'));
    let entries: Vec<String> =
        publications.filter(|(short, _)| cited.0.contains(short)).map(|(_, entry)| entry.to_owned()).collect();
    debug_assert_eq!(entries.len(), cited.0.len(), "every publication has an entry: {:?}", cited.0);
    references.list(entries);
    (section, references)
}

fn procedure(cited: &mut Cited, source: &Source, results: &Results) -> String {
    let people = count(results.people() as u64, "participant");
    let simulated = health::simulated(source, results);
    let who = match simulated.values().filter(|counts| health::all_simulated(counts)).count() {
        0 => people,
        n if n >= results.people() => count(n as u64, "simulated observer"),
        n => format!("{people}, {n} of them simulated,"),
    };
    let rated = names::rated(&who, results, "which varied in", |factor| {
        let levels = factor.levels.iter().map(|level| names::level_of(results, factor, level).to_string());
        levels.collect::<Vec<_>>().join(", ")
    });
    let shown = source.protocol.as_ref().map(|protocol| shown(cited, protocol)).unwrap_or_default();
    let excluded: String = health::exclusions(source, results).iter().map(|sentence| format!(" {sentence}")).collect();
    format!("{rated}{excluded}{shown}")
}

fn shown(cited: &mut Cited, protocol: &Protocol) -> String {
    let answers = names::categories_of(protocol).join(", ");
    let scale = if protocol.response == ResponseScale::default() {
        format!(" (scale of {})", cited.cite("Bangay"))
    } else {
        String::new()
    };
    let times = times(protocol.design.repetitions);
    format!(
        " Each session was planned to show every condition {times}, after {}. A uniform field of relative luminance {} was \
         shown for {} s before each stimulus. The answers were {answers}{scale}. The planned viewing distance was {} cm, and \
         the planned width of the stimulus was {}°.",
        count(protocol.design.practice.into(), "practice trial"),
        protocol.recovery.level,
        protocol.recovery.duration_s,
        protocol.viewing.distance_cm,
        protocol.viewing.window_deg
    )
}

fn model(cited: &mut Cited, results: &Results) -> Option<String> {
    let report = results.model.as_ref().ok()?;
    let model = &report.model;
    let terms: Vec<String> = results.spec.terms.iter().map(|term| names::term(results, term)).collect();
    let terms =
        if terms.is_empty() { "no fixed effects".to_owned() } else { format!("fixed effects of {}", list(&terms)) };
    let terms = if model.random.is_some() { format!(", {terms}") } else { format!(" and {terms}") };
    let link = model.link;
    let ordinal = cited.cite("Liddell & Kruschke, 2018; Bürkner & Vuorre, 2019");
    let family = cited.cite("McCullagh, 1980; Christensen, 2022");
    let (mixed, how) = match &model.random {
        None => ("", ", fitted by maximum likelihood".to_owned()),
        Some(random) => {
            let is_correlated = random.correlations.is_some();
            let kind = if is_correlated { "correlated" } else { "independent" };
            let is_number = |variable: &Variable| matches!(variable, Variable::Number(_));
            let named =
                |own: &[&RandomSlope]| own.iter().map(|own| names::slope(results, model, own)).collect::<Vec<_>>();
            let (slopes, others): (Vec<_>, Vec<_>) =
                random.slopes.iter().partition(|slope| is_correlated || slope.term.variables.iter().all(is_number));
            let mut groups = vec!["participants".to_owned()];
            groups.extend(named(&others).iter().map(|name| format!("for each combination of participant and {name}")));
            groups
                .extend(random.items.as_ref().map(|items| format!("for each {}", names::factor(results, &items.name))));
            let mut effects = format!(", and random intercepts for {}", list(&groups));
            if !slopes.is_empty() {
                effects += &format!(", with {kind} random slopes of {}", list(&named(&slopes)));
            }
            ("mixed ", effects + ", fitted by maximum likelihood with Laplace’s approximation")
        }
    };
    let mut text = format!(
        "Because ratings are ordered categories ({ordinal}), they were modeled with a cumulative-link {mixed}model ({family}) \
         with a {link} link{terms}{how} to {} (log-likelihood {}, AIC {}).",
        count(model.nobs, "rating"),
        fixed(model.loglik, 2),
        fixed(model.aic(), 2)
    );
    text += &terms_tested(cited, results, report);
    text += &interactions_tested(cited, results, report);
    text += &limits(report);
    if report.comparisons.iter().any(|comparison| comparison.p_holm.is_some()) {
        text += &format!(
            " Levels were compared in the model, corrected within each factor with Holm’s method ({}).",
            cited.cite("Holm, 1979")
        );
    }
    if !results.is_inferential() {
        text += " All inference is about repeated trials of this participant.";
    }
    Some(text)
}

/// Warns of p values that ignore that ratings are related.
fn ignoring(results: &Results) -> &'static str {
    match results.ignores_people() {
        true => {
            " These p values ignore that ratings by the same participant are related, so they may be far too small."
        }
        false => "",
    }
}

/// Says how the terms of the model were tested.
fn terms_tested(cited: &mut Cited, results: &Results, report: &ModelReport) -> String {
    let mut text = String::new();
    if !report.terms.is_empty() {
        let tests: Vec<String> = (report.terms.iter())
            .map(|test| match (names::term(results, &test.term), test.chi_squared, test.p) {
                (term, Some(lr), Some(p)) => format!("{term}, χ²({}) = {}, {}", test.df, fixed(lr, 2), p_is(p)),
                (term, ..) => format!("{term}, not tested"),
            })
            .collect();
        text += &format!(" Terms were tested with likelihood-ratio tests: {}.{}", tests.join("; "), ignoring(results));
    }
    if let Some(draws) = report.terms.iter().filter_map(|test| test.draws).max() {
        let others = report.terms.iter().filter(|test| test.draws.is_none() && test.p.is_some());
        let others: Vec<String> = others.map(|test| names::term(results, &test.term)).collect();
        let error = report.terms.iter().filter_map(|test| test.p_error).reduce(f64::max);
        let error_is = |error: f64| {
            let most = if error < 1e-4 { "below 0.0001".to_owned() } else { format!("at most {}", fixed(error, 4)) };
            format!(" The Monte Carlo standard error of p, where it was not extrapolated, is {most}.")
        };
        let whose = if others.is_empty() {
            "Their p values come".to_owned()
        } else {
            format!("The p values of {} come from the χ² distribution, the others come", list(&others))
        };
        text += &format!(
            " {whose} from a parametric bootstrap ({}): up to {draws} studies were simulated from the fitted model \
             (ChaCha8, seed {}){}, and their ratios were computed at the coefficients that generated them. p is (k + 1)/(n + 1); \
             if no ratio was as large, p was extrapolated with an exponential tail. Simulation ended early when p was clear.{}",
            cited.cite("Davison & Hinkley, 1997; Halekoh & Højsgaard, 2014"),
            results.options.resampling.seed,
            if report.model.random.is_some() {
                ", with variances of the random effects corrected for the estimated means"
            } else {
                ""
            },
            error.map(error_is).unwrap_or_default()
        );
    }
    text
}

/// Says how the interactions that the model does not have were tested.
fn interactions_tested(cited: &mut Cited, results: &Results, report: &ModelReport) -> String {
    let tested: Vec<String> = (report.interactions.iter())
        .filter_map(|own| {
            let (name, TermTest { chi_squared: lr, df, p, .. }) = (names::term(results, &own.test.term), &own.test);
            Some(format!("{name}, χ²({df}) = {}, {}", fixed(*lr, 2), p_is((*p)?)))
        })
        .collect();
    let left_out =
        |by_signs: bool| report.interactions.iter().any(|own| own.test.p.is_some() && own.by_signs == by_signs);
    if left_out(true) {
        let corrected = match tested.len() {
            1 => String::new(),
            _ => format!(", corrected with the minimum-p method ({})", cited.cite("Westfall & Young, 1993")),
        };
        format!(
            " The two-way interactions left out of the model were tested with score tests: p is the proportion of patterns of \
             the signs of the participants’ residual scores with a statistic at least as large{corrected} ({}).",
            tested.join("; ")
        )
    } else if left_out(false) {
        format!(
            " The two-way interactions left out of the model were tested with likelihood ratios in studies simulated from the \
             wider models, corrected with Holm’s method ({}).",
            tested.join("; ")
        )
    } else {
        String::new()
    }
}

/// Says how the intervals of coefficients were found.
fn limits(report: &ModelReport) -> String {
    let is_simulated = report.terms.iter().any(|test| test.draws.is_some());
    let of = if report.model.random.is_some() { "coefficients and of standard deviations" } else { "coefficients" };
    let limits = match report.model.random {
        _ if !is_simulated => "",
        None => ", with limits from the same studies",
        Some(_) => {
            ", with limits from the same studies for coefficients, and adjusted for the number of participants for standard \
             deviations"
        }
    };
    format!(" Intervals of {of} are profile-likelihood intervals{limits}.")
}

fn tests(cited: &mut Cited, results: &Results) -> Option<String> {
    let tested: Vec<String> = (results.factors.iter())
        .filter_map(|factor| {
            let (f, name) = (factor.friedman?, names::factor(results, &factor.name));
            Some(format!("{name}, χ²({}) = {}, {}, W = {}", f.df, fixed(f.chi_squared, 2), p_is(f.p), unit(f.w)))
        })
        .collect();
    if tested.is_empty() {
        return None;
    }
    let mut methods: Vec<&str> = (results.factors.iter().filter_map(|factor| factor.friedman))
        .map(|test| match test.method {
            PMethod::Exact => "exact",
            PMethod::Permutations => "random-permutation",
            PMethod::ChiSquared => "χ²",
        })
        .collect();
    methods.sort_unstable();
    methods.dedup();
    let methods = list(&methods);
    let leads = (results.factors.iter())
        .filter(|_| results.model.is_ok())
        .filter(|factor| findings::evidence(results, factor).is_some_and(|evidence| evidence.is_rank_test));
    let because = |factor: &FactorResults| {
        let reason = findings::reason(results, factor);
        let reason = reason.unwrap_or_else(|| "the model has no random slopes, as requested".to_owned());
        let name = names::factor(results, &factor.name);
        format!(
            " The conclusion about {name} rests on Friedman’s test, because its test in the model is not used: {reason}."
        )
    };
    let rest: String = leads.map(because).collect();
    Some(format!(
        "Participants’ mean ratings at the levels of each factor, over those conditions of the other factors that a participant \
         rated at every level, were compared with Friedman’s test, with {} p values, and \
         Kendall’s coefficient of concordance ({}): {}.{rest}",
        methods,
        cited.cite("Friedman, 1937; Kendall & Babington Smith, 1939"),
        tested.join("; ")
    ))
}

fn agreement(cited: &mut Cited, results: &Results) -> Option<String> {
    let alpha = results.alpha.map(|alpha| {
        format!(
            "Agreement between participants was measured with Krippendorff’s ordinal α ({}), \
             without comparing repeated ratings by the same participant: α = {}{}.",
            cited.cite("Hayes & Krippendorff, 2007; Krippendorff, 2019"),
            unit(alpha.alpha),
            with_interval(alpha.interval, unit)
        )
    });
    let kappa = results.kappa.map(|(kappa, interval)| {
        format!(
            "Agreement between first and second ratings was measured with Cohen’s κ with quadratic weights ({}): κ = {}{}{}.",
            cited.cite("Cohen, 1968"),
            unit(kappa),
            if results.is_inferential() { " on average" } else { "" },
            with_interval(interval, unit)
        )
    });
    let parts: Vec<String> = alpha.into_iter().chain(kappa).collect();
    (!parts.is_empty()).then(|| parts.join(" "))
}

fn intervals(cited: &mut Cited, results: &Results) -> Option<String> {
    results.is_inferential().then(|| {
        let of_means = format!("those of means are score intervals ({})", cited.cite("Wilson, 1927"));
        let mut kinds = vec![of_means + " with t quantiles over participants"];
        let is_by_ranks = |own: &FactorResults| findings::evidence(results, own).is_some_and(|own| own.is_rank_test);
        if results.factors.iter().any(is_by_ranks) {
            kinds.push("those of differences of means are t intervals over participants".to_owned());
        }
        if results.alpha.and_then(|alpha| alpha.interval).or(results.kappa.and_then(|kappa| kappa.1)).is_some() {
            kinds.push("those of agreement use the jackknife over participants".to_owned());
        }
        format!("Intervals are 95\u{a0}% intervals: {}.", list(&kinds))
    })
}
