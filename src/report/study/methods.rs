//! Methods and results as a paper states them, with the numbers in place, and the literature they lean on.

use super::{
    effects, names,
    references::{self as r, Reference},
};
use crate::report::document::numbers::{count, fixed, list, p_is, percent, range, unit, whole};
use crate::{
    analysis::{Link, Results, rank_tests::PMethod},
    experiment::Protocol,
    report::prediction::Predicted,
    store::ratings::Source,
};

/// Paragraphs, and what they cite.
#[derive(Default)]
pub(crate) struct Methods {
    /// The text.
    pub paragraphs: Vec<String>,
    /// The literature, in the order it is first cited.
    pub cited: Vec<Reference>,
}

impl Methods {
    fn cite(&mut self, reference: Reference) -> String {
        if !self.cited.contains(&reference) {
            self.cited.push(reference);
        }
        reference.short.replace(" (", ", ").replace(')', "")
    }
}

/// The text.
pub(crate) fn methods(source: &Source, results: &Results, predicted: Option<&Predicted>, version: &str) -> Methods {
    let mut methods = Methods::default();
    let paragraphs = [
        procedure(&mut methods, source, results),
        model(&mut methods, results),
        tests(&mut methods, results),
        agreement(&mut methods, results),
        bootstrap(&mut methods, results),
        predicted.map(|predicted| vision(&mut methods, predicted)),
        Some(format!("The analysis was made with machband {version}.")),
    ];
    methods.paragraphs = paragraphs.into_iter().flatten().collect();
    // The health of the data measures κ by this mark wherever there is a κ.
    if results.kappa.is_some() {
        methods.cite(r::LANDIS);
    }
    methods
}

fn procedure(methods: &mut Methods, source: &Source, results: &Results) -> Option<String> {
    let counts = &results.measured.counts;
    let varied: Vec<String> = (names::varied(results))
        .map(|factor| {
            let level = |group: &crate::analysis::summary::Group| {
                names::level(&factor.name, group.names.first().map_or("", String::as_str))
            };
            let levels: Vec<String> = factor.levels.iter().map(level).collect();
            format!("{} ({})", names::factor(&factor.name), levels.join(", "))
        })
        .collect();
    let simulated = super::sittings::simulated(source).len();
    let who = match simulated {
        0 => count(results.people() as u64, "participant"),
        n if n >= results.people() => count(n as u64, "simulated observer"),
        n => format!("{}, {n} of them simulated,", count(results.people() as u64, "participant")),
    };
    let mut text = format!(
        "{who} gave {} of {}",
        count(counts.total(), "rating"),
        count(counts.conditions.len() as u64, "condition")
    );
    if !varied.is_empty() {
        text.push_str(&format!(", which varied in {}", list(&varied)));
    }
    text.push('.');
    if let Some(protocol) = &source.protocol {
        text.push_str(&shown(methods, protocol));
    }
    Some(text)
}

fn shown(methods: &mut Methods, protocol: &Protocol) -> String {
    let answers = names::categories_of(protocol).join(", ");
    let own = protocol.response == crate::experiment::ResponseScale::default();
    let scale = if own { format!(" (scale of {})", methods.cite(r::BANGAY)) } else { String::new() };
    let times = match protocol.design.repetitions {
        1 => "once".to_owned(),
        2 => "twice".to_owned(),
        n => format!("{n} times"),
    };
    format!(
        " Each session was to show every condition {times}, after {}. A uniform field of relative luminance {} was shown for {} s \
         before each stimulus. The answers were {answers}{scale}. The viewing distance was to be {} cm and the stimulus {}° wide.",
        count(protocol.design.practice.into(), "practice trial"),
        protocol.recovery.level,
        protocol.recovery.duration_s,
        protocol.viewing.distance_cm,
        protocol.viewing.window_deg
    )
}

fn model(methods: &mut Methods, results: &Results) -> Option<String> {
    let report = results.model.as_ref().ok()?;
    let model = &report.model;
    let terms: Vec<String> =
        results.spec.terms.iter().map(|term| names::factor(&term.to_string()).to_owned()).collect();
    let terms = if terms.is_empty() { "no terms".to_owned() } else { format!("the terms {}", list(&terms)) };
    let link = match model.link {
        Link::Logit => "logit",
        Link::Probit => "probit",
    };
    let ordinal = [methods.cite(r::LIDDELL), methods.cite(r::BURKNER)].join("; ");
    let family = [methods.cite(r::MCCULLAGH), methods.cite(r::CHRISTENSEN)].join("; ");
    let mut text = format!(
        "Since ratings are ordered categories ({ordinal}), they were modelled with a cumulative-link {}model ({family}) with {link} link and {terms}",
        if model.random.is_some() { "mixed " } else { "" }
    );
    if model.random.is_some() {
        let how = if results.spec.quadrature > 1 {
            format!(
                "adaptive Gauss–Hermite quadrature with {} nodes ({})",
                results.spec.quadrature,
                methods.cite(r::LIU)
            )
        } else {
            "Laplace’s approximation".to_owned()
        };
        text.push_str(&format!(" and a random intercept for participants, fitted by maximum likelihood with {how}"));
    } else {
        text.push_str(", fitted by maximum likelihood");
    }
    text.push_str(&format!(
        " to {} (log-likelihood {}, AIC {}).",
        count(model.nobs, "rating"),
        fixed(model.loglik, 2),
        fixed(model.aic(), 2)
    ));
    if results.is_inferential() && !report.terms.is_empty() {
        text.push_str(" Terms were tested by likelihood ratios: ");
        let tests: Vec<String> = (report.terms.iter())
            .map(|test| match (test.lr, test.p) {
                (Some(lr), Some(p)) => {
                    format!("{}, χ²({}) = {}, {}", names::factor(&test.term), test.df, fixed(lr, 2), p_is(p))
                }
                _ => format!("{}, no test", names::factor(&test.term)),
            })
            .collect();
        text.push_str(&tests.join("; "));
        text.push('.');
    }
    Some(text)
}

fn tests(methods: &mut Methods, results: &Results) -> Option<String> {
    let tested: Vec<String> = (results.factors.iter())
        .filter_map(|factor| {
            let f = factor.friedman?;
            let name = names::factor(&factor.name);
            Some(format!("{name}, χ²({}) = {}, {}, W = {}", f.df, fixed(f.chi_squared, 2), p_is(f.p), unit(f.w)))
        })
        .collect();
    if tested.is_empty() {
        return None;
    }
    let friedman = [methods.cite(r::FRIEDMAN), methods.cite(r::KENDALL)].join("; ");
    let mut text = format!(
        "Participants’ mean ratings at the levels of each factor were compared with Friedman’s test and Kendall’s coefficient of concordance ({friedman}): {}.",
        tested.join("; ")
    );
    let pairs: Vec<_> = results.factors.iter().filter_map(|factor| factor.pairs.as_ref()).collect();
    if pairs.iter().any(|pairs| !pairs.pairs.is_empty()) {
        let exact = pairs.iter().flat_map(|pairs| &pairs.pairs).any(|pair| pair.test.method == PMethod::Exact);
        let how = if exact { format!(", exact by {}", methods.cite(r::STREITBERG)) } else { String::new() };
        let wilcoxon = methods.cite(r::WILCOXON);
        let holm = methods.cite(r::HOLM);
        text.push_str(&format!(
            " Pairs of levels were compared with Wilcoxon’s signed-rank test ({wilcoxon}{how}), corrected within each factor by Holm’s method ({holm})."
        ));
    }
    Some(text)
}

fn agreement(methods: &mut Methods, results: &Results) -> Option<String> {
    let level = percent(results.options.bootstrap.level);
    let with = |interval: Option<crate::analysis::bootstrap::Interval>| {
        interval.map(|i| format!(", {level} interval {}", range(Some(i), unit))).unwrap_or_default()
    };
    let mut parts = Vec::new();
    if let Some(alpha) = results.alpha {
        let sources = [methods.cite(r::HAYES), methods.cite(r::KRIPPENDORFF)].join("; ");
        parts.push(format!(
            "Agreement between participants was measured with Krippendorff’s ordinal α ({sources}), a participant’s repeated ratings not being compared with each other: α = {}{}.",
            unit(alpha.alpha),
            with(alpha.interval)
        ));
    }
    if let Some((kappa, interval)) = results.kappa {
        parts.push(format!(
            "Agreement of first and second ratings was measured with Cohen’s κ with quadratic weights ({}): κ = {}{}{}.",
            methods.cite(r::COHEN),
            unit(kappa),
            if results.is_inferential() { " on average" } else { "" },
            with(interval)
        ));
    }
    (!parts.is_empty()).then(|| parts.join(" "))
}

fn bootstrap(methods: &mut Methods, results: &Results) -> Option<String> {
    let bootstrap = &results.options.bootstrap;
    let wald = if effects::is_clustered(results) {
        " Intervals of the model’s coefficients are Wald intervals."
    } else {
        ""
    };
    results.is_inferential().then(|| {
        format!(
            "Intervals of means and of agreement are {} percentile intervals of {} bootstrap samples of participants ({}; ChaCha8, seed {}).{wald}",
            percent(bootstrap.level),
            whole(bootstrap.replicates as u64),
            methods.cite(r::EFRON),
            bootstrap.seed
        )
    })
}

fn vision(methods: &mut Methods, predicted: &Predicted) -> String {
    let held = &predicted.held;
    let mut text = format!(
        "The visibility of the bands of every condition was predicted, for a window of {} and a white of {} cd/m², by a model of local energy \
         ({}) in log-Gabor channels of light weighted by contrast sensitivity ({}).",
        super::vision::degrees(predicted),
        fixed(predicted.sight.white_cd_m2, 0),
        methods.cite(r::MORRONE),
        methods.cite(r::BARTEN)
    );
    if let Some(rho) = held.rank_correlation {
        text.push_str(&format!(" Its rank correlation with the mean ratings was {}", unit(rho)));
        if let (Some(each), Some([low, high])) = (held.with_subjects, held.ceiling) {
            text.push_str(&format!(
                ", and with single participants {} on average, with a noise ceiling ({}) of {} to {}",
                unit(each),
                methods.cite(r::NILI),
                unit(low),
                unit(high)
            ));
        }
        text.push('.');
    }
    text
}
