//! The methods section for a paper, with references.

use super::{findings, health, model::is_additive, names};
use crate::{
    analysis::{Model, RandomSlope, Results, TermTest, results::FactorResults, terms::Variable},
    experiment::{Protocol, ResponseScale},
    report::document::{Section, count, fixed, list, times},
    store::ratings::Source,
};

/// One publication per line, sorted by name: its citation, a tab, and its entry in the list of references.
const PUBLICATIONS: &str = include_str!("references.txt");

/// Writes the methods and the references in them.
pub(super) fn sections(source: &Source, results: &Results) -> (Section, Section) {
    let version = format!("The analysis was performed with machband {}.", env!("CARGO_PKG_VERSION"));
    let paragraphs = [vec![procedure(source, results)], model(results), description(results), vec![version]];
    let paragraphs = paragraphs.map(|sentences| sentences.join(" "));
    let (mut section, mut references) =
        (Section::new("methods", "Methods, ready to paste"), Section::new("references", "References"));
    paragraphs.iter().filter(|paragraph| !paragraph.is_empty()).for_each(|paragraph| section.text(paragraph.clone()));
    let is_cited = |citation: &str| paragraphs.iter().any(|paragraph| paragraph.contains(citation));
    let publications = PUBLICATIONS.lines().filter_map(|line| line.split_once('\t'));
    references
        .list(publications.filter(|(citation, _)| is_cited(citation)).map(|(_, entry)| entry.to_owned()).collect());
    (section, references)
}

fn procedure(source: &Source, results: &Results) -> String {
    let people = count(results.people() as u64, "participant");
    let simulated = health::simulated(source, results);
    let who = match simulated.values().filter(|[own, all]| own == all).count() {
        0 => people,
        n if n >= results.people() => count(n as u64, "simulated observer"),
        n => format!("{people}, {n} of them simulated,"),
    };
    let rated = names::rated(&who, results, "which varied in", |factor| {
        let levels = factor.levels.iter().map(|level| names::level_of(results, factor, level).to_string());
        levels.collect::<Vec<_>>().join(", ")
    });
    let shown = source.protocol.as_ref().map(shown).unwrap_or_default();
    let excluded = health::exclusions(source, results).map_or_else(String::new, |sentence| format!(" {sentence}"));
    format!("{rated}{excluded}{shown}")
}

fn shown(protocol: &Protocol) -> String {
    let answers = names::categories_of(protocol).join(", ");
    let scale = if protocol.response == ResponseScale::default() { ", on the scale of Bangay" } else { "" };
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

/// Names the random effects, and says how the model was fitted.
fn fitted(results: &Results, model: &Model) -> String {
    let terms: Vec<String> = results.spec.terms.iter().map(|term| names::term(results, term)).collect();
    let terms =
        if terms.is_empty() { "no fixed effects".to_owned() } else { format!("fixed effects of {}", list(&terms)) };
    let Some(random) = &model.random else { return format!(" and {terms}, fitted by maximum likelihood") };
    let is_correlated = random.correlations.is_some();
    let is_number = |variable: &Variable| matches!(variable, Variable::Number(_));
    let named = |own: &[&RandomSlope]| own.iter().map(|own| names::slope(results, model, own)).collect::<Vec<_>>();
    let (slopes, others): (Vec<_>, Vec<_>) =
        random.slopes.iter().partition(|slope| is_correlated || slope.term.variables.iter().all(is_number));
    let mut groups = vec!["participants".to_owned()];
    groups.extend(named(&others).iter().map(|name| format!("for each combination of participant and {name}")));
    groups.extend(random.items.as_ref().map(|items| format!("for each {}", names::factor(results, &items.name))));
    let kind = if is_correlated { "correlated" } else { "independent" };
    let slopes = match &named(&slopes)[..] {
        [] => String::new(),
        slopes => format!(", with {kind} random slopes of {}", list(slopes)),
    };
    format!(
        ", {terms}, and random intercepts for {}{slopes}, fitted by maximum likelihood with Laplace’s approximation",
        list(&groups)
    )
}

/// Says how the ratings were modeled.
fn model(results: &Results) -> Vec<String> {
    let Ok(report) = &results.model else { return Vec::new() };
    let model = &report.model;
    let mixed = model.random.is_some();
    // The tests that are so, after a singular or a plural.
    let named = |is: &dyn Fn(&TermTest) -> bool, [one, several]: [&str; 2]| -> Option<String> {
        let own = report.terms.iter().filter(|test| test.p.is_some() && is(test));
        let own: Vec<String> = own.map(|test| names::term(results, &test.term)).collect();
        let text = if own.len() == 1 { one } else { several };
        (!own.is_empty()).then(|| text.replace('#', &list(&own)))
    };
    let p_comes = ["The p value of # comes from", "The p values of # come from"];
    let left_out = |by_signs: bool| {
        report.interactions.iter().filter(|own| own.test.p.is_some() && own.by_signs == by_signs).count()
    };
    let simulated = named(&|test| test.draws.is_some(), p_comes);
    let draws = report.terms.iter().filter_map(|test| test.draws).max().unwrap_or_default();
    let variances = if mixed { ", with variances of the random effects corrected for the estimated means" } else { "" };
    let limits = if simulated.is_some() { ", with limits from the same studies" } else { "" };
    let sentences = [
        Some(format!(
            "Because ratings are ordered categories (Liddell & Kruschke, 2018; Bürkner & Vuorre, 2019), they were modeled with a \
             cumulative-link {}model (McCullagh, 1980; Christensen, 2022) with a {} link{} to {}.",
            if mixed { "mixed " } else { "" },
            model.link,
            fitted(results, model),
            count(model.nobs, "rating")
        )),
        named(&|_| true, ["A likelihood-ratio test was computed for #.", "Likelihood-ratio tests were computed for #."]),
        results.ignores_people().then(|| IGNORING.to_owned()),
        named(&|test| test.draws.is_none(), p_comes).map(|p| format!("{p} the χ² distribution.")),
        simulated.map(|p| {
            format!(
                "{p} a parametric bootstrap (Davison & Hinkley, 1997; Halekoh & Højsgaard, 2014): up to {draws} \
                 studies were simulated from the fitted model (ChaCha8, seed {}){variances}, and their ratios were computed at the \
                 coefficients that generated them. p is (k + 1)/(n + 1); if no ratio was as large, p was extrapolated with an \
                 exponential tail. Simulation ended early when p was clear.",
                results.options.resampling.seed
            )
        }),
        report.terms.iter().filter_map(|test| test.p_error).reduce(f64::max).map(|error| {
            let most = fixed((1e3 * error).ceil() / 1e3, 3).replacen('0', "", 1);
            format!("The Monte Carlo standard error of p, where it was not extrapolated, is at most {most}.")
        }),
        match (left_out(true), left_out(false)) {
            (0, 0) => None,
            (0, _) => Some(WIDER_MODELS.to_owned()),
            (1, _) => Some(format!("{SIGNS}.")),
            _ => Some(format!("{SIGNS}, corrected with Holm’s method (Holm, 1979).")),
        },
        model.coefficients.iter().any(|own| own.interval.is_some()).then(|| {
            let simple = if is_additive(results) { "" } else { "; those of simple effects are Wald intervals" };
            format!("The 95\u{a0}% intervals of coefficients are profile-likelihood intervals{limits}{simple}.")
        }),
        report.comparisons.iter().any(|own| own.p_holm.is_some()).then(|| COMPARED.to_owned()),
        (!results.is_inferential()).then(|| "All inference is about repeated trials of this participant.".to_owned()),
    ];
    sentences.into_iter().flatten().collect()
}

const IGNORING: &str =
    "They ignore that ratings by the same participant are related, so their p values may be far too small.";
const WIDER_MODELS: &str = "The two-way interactions left out of the model were tested with likelihood ratios in studies \
                            simulated from the wider models, corrected with Holm’s method.";
const SIGNS: &str = "The two-way interactions left out of the model were tested with score tests: p is the proportion of \
                     patterns of the signs of the participants’ residual scores with a statistic at least as large";
const COMPARED: &str =
    "Levels were compared in the model; p was corrected within each factor with Holm’s method (Holm, 1979).";

/// Says what was computed without the model, and how the intervals were found.
fn description(results: &Results) -> Vec<String> {
    let ranked = |factor: &FactorResults| {
        findings::evidence(results, factor).filter(|evidence| evidence.is_rank_test)?;
        let reason = findings::reason(results, &factor.name);
        Some(format!(
            "The conclusion about {} rests on Friedman’s test (Friedman, 1937) with {} p value, of participants’ means over those \
             conditions of the other factors that they rated at every level, because its test in the model is not used: {}.",
            names::factor(results, &factor.name),
            if factor.friedman?.is_exact { "an exact" } else { "a χ²" },
            reason.unwrap_or_else(|| "the model has no random slopes, as requested".to_owned())
        ))
    };
    let mut sentences: Vec<String> = results.factors.iter().filter_map(ranked).collect();
    sentences.extend(results.alpha.map(|_| {
        "Agreement between participants was measured with Krippendorff’s ordinal α (Hayes & Krippendorff, 2007; \
         Krippendorff, 2019), without comparing repeated ratings by the same participant."
            .to_owned()
    }));
    sentences.extend(results.kappa.map(|_| {
        "Agreement between first and second ratings was measured with Cohen’s κ with quadratic weights (Cohen, 1968)."
            .to_owned()
    }));
    if results.is_inferential() {
        let mut kinds = vec!["those of means are score intervals (Wilson, 1927) with t quantiles over participants"];
        let is_difference = |factor| findings::has_interval_of_means(results, factor);
        let differences = "those of differences of means are t intervals over participants";
        kinds.extend(results.factors.iter().any(is_difference).then_some(differences));
        let of_alpha = results.alpha.and_then(|alpha| alpha.interval);
        kinds.extend(of_alpha.map(|_| "that of α uses the jackknife over participants"));
        let of_kappa = results.kappa.and_then(|(_, interval)| interval);
        kinds.extend(of_kappa.map(|_| "that of κ is a t interval over participants"));
        sentences.push(format!("Intervals are 95\u{a0}% intervals: {}.", list(&kinds)));
    }
    sentences
}
