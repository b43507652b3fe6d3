//! `machband plan`

use super::{Bar, OutPath, columns, print_line};
use crate::{
    analysis::{
        Slopes,
        power::{Effect, Hypothesis, Power, Precision, Sampling, ThresholdObserver},
    },
    report::document::Shown,
    store::Writer,
    work::{
        plan::{OPTIONS, Plan, Planned},
        plan_thresholds::{Found, PlannedThresholds},
    },
};

/// Find how many participants a study needs, by simulating its power.
///
/// Simulates studies with the ordered-logit observer of `simulate` and analyzes each as `analyze` would. For each
/// number of participants and each effect, reports the proportion of studies that find it, with its exact 95 % interval
/// (Clopper and Pearson). Two tests are used: the likelihood-ratio test of the term in the ordinal mixed model, and
/// Friedman's test of the participants' means. If an effect is absent, this proportion is reported as the false-alarm
/// rate.
#[derive(clap::Args)]
#[command(
    after_help = "Effects: NAME=VALUE sets a parameter of the observer: depth, fall, narrow, oblique, contrast, \
    infinite_as, strongest_width, subject_sd, lapse (see experiments/observers/paper.toml). FACTOR:LEVEL=LOGITS adds to \
    one level of any factor of the experiment.\n\n\
    --slope FACTOR=SD lets people differ in the effect of a factor: each deviates at each of its levels by an independent \
    normal value, as in R's (1 | subject:factor). The more they differ, the lower the power.\n\n\
    Up to 40 participants, p values of the model come from simulated studies without the effect: as many as --studies, \
    but at least 199 and at most 999.\n\n\
    Thresholds: for a task with [adaptive], reports the precision of a person's threshold, of the mean and of differences, \
    and the power to find FACTOR:LEVEL=SHIFT, in base-10 logarithms of the level if the method is logarithmic. NAME=VALUE \
    sets threshold, subject_sd, slope, lapse or false_alarms. --trials compares numbers of trials.\n\n\
    Results depend on the seed but not on the number of threads (ChaCha8, one stream per participant and study).\n\n\
    Examples:\n  machband plan orientation --participants 4,8,12 --effect oblique=0.5\n  \
    machband plan orientation --participants 12 --effect oblique=0.5 --slope orientation_deg=0.5\n  \
    machband plan shaders --participants 8 --effect shader:gouraud=1 --effect shader:flat=2\n  \
    machband plan threshold-width --participants 4,8 --trials 20,40 --effect orientation_deg:90=0.1 --studies 100"
)]
pub(super) struct Arguments {
    #[command(flatten)]
    request: Plan,
    /// Where to write the table as CSV.
    #[arg(long, value_name = "FILE.csv")]
    out: Option<OutPath>,
    /// Where to write the text of a preregistration.
    #[arg(long, value_name = "FILE.md")]
    preregistration: Option<OutPath>,
}

pub(super) fn run(arguments: &Arguments, writer: &Writer) -> anyhow::Result<()> {
    let bar = Bar::new("simulated participants");
    let planned = arguments.request.plan(&bar);
    bar.clear();
    let found = planned?;
    let lines = match &found {
        Found::Ratings(planned) => lines(planned),
        Found::Thresholds(planned) => thresholds(planned),
    };
    lines.iter().try_for_each(|line| print_line(line))?;
    // Written last, so that no result is lost if the path cannot be written.
    if let Some(path) = &arguments.out {
        writer.write(path, &found.table().csv())?;
    }
    if let Some(path) = &arguments.preregistration {
        writer.write(path, arguments.request.preregistration(&found).as_bytes())?;
    }
    Ok(())
}

/// Returns the lines about a study of thresholds.
fn thresholds(planned: &PlannedThresholds) -> Vec<String> {
    const HEADER: [&str; 8] = [
        "participants",
        "trials",
        "estimate",
        "true difference",
        "± (95 % interval)",
        "rms error",
        "power",
        "false alarms",
    ];
    let ThresholdObserver { threshold, subject_sd, slope, lapse, false_alarms } = planned.observer;
    let heading = format!(
        "{}: {} studies per number of participants, seed {}; observer threshold={threshold} subject_sd={subject_sd} slope={slope} \
         lapse={lapse} false_alarms={false_alarms}; differences and errors in {}",
        planned.protocol.name,
        planned.sampling.studies,
        planned.sampling.seed,
        planned.unit(),
    );
    let row = |found: &Precision| {
        let (truth, differs) = (found.quantity.truth(), found.quantity.differs());
        let number =
            |value: Option<f64>| Shown::new(value, value.map_or_else(String::new, |value| format!("{value:.3}")));
        let (share, interval) = found.share();
        let percent = format!("{:.1} % ({:.1}–{:.1})", 100.0 * share, 100.0 * interval.low, 100.0 * interval.high);
        // One participant has no interval, which could exclude 0.
        let percent = |shown: bool| {
            if shown && found.half_width.is_some() { Shown::new(share, percent.clone()) } else { Shown::from("") }
        };
        vec![
            Shown::new(found.participants, found.participants.to_string()),
            Shown::new(found.trials, found.trials.to_string()),
            planned.name(&found.quantity).as_str().into(),
            number(truth),
            number(found.half_width),
            number(found.error),
            percent(differs),
            percent(truth.is_some() && !differs),
        ]
    };
    let table = columns(&HEADER, &planned.found.iter().map(row).collect::<Vec<_>>());
    [vec![heading, String::new()], table, vec![String::new()], planned.sentences()].concat()
}

/// Returns the lines to print.
fn lines(planned: &Planned) -> Vec<String> {
    let (spec, Sampling { studies, alpha, seed }) = (&planned.plan.spec, planned.sampling);
    let heading = format!(
        "{}, observer {}: {} ratings from each participant, {studies} studies per number of participants, seed {seed}; \
             {} model of {} with {}, alpha {alpha}",
        planned.protocol.name,
        planned.observer,
        planned.plan.ratings(),
        spec.link,
        spec.terms,
        match spec.slopes {
            Slopes::None => "random intercepts only",
            Slopes::Independent => "independent random slopes",
            Slopes::Correlated => "correlated random slopes",
        }
    );
    [vec![heading, String::new()], table(planned), vec![String::new()], planned.sentences(OPTIONS)].concat()
}

/// Formats one line for each number of participants and each test.
fn table(planned: &Planned) -> Vec<String> {
    const HEADER: [&str; 8] = [
        "participants",
        "term",
        "test",
        "true effect, logits",
        "power",
        "false alarms",
        "95 % interval",
        "median estimate",
    ];
    columns(&HEADER, &planned.powers.iter().map(|power| cells(planned, power)).collect::<Vec<_>>())
}

fn cells(planned: &Planned, power: &Power) -> Vec<Shown> {
    let Hypothesis { term, effect, .. } = planned.hypothesis(power);
    let interval = power.interval();
    let share = Shown::new(power.share(), format!("{:.1} %", 100.0 * power.share()));
    let none = || Shown::from("");
    let [found, false_alarms] = if effect.is_some() { [share, none()] } else { [none(), share] };
    let truth = |effect: &Effect| {
        let levels = format!("{} over {}", effect.above, effect.below);
        effect
            .logits
            .map_or_else(|| Shown::from(levels.as_str()), |logits| Shown::new(logits, format!("{logits:.2}: {levels}")))
    };
    vec![
        Shown::new(power.participants, power.participants.to_string()),
        term.as_str().into(),
        planned.test(power).into(),
        effect.as_ref().map_or("none".into(), truth),
        found,
        false_alarms,
        Shown::new(interval.low, format!("{:.1}–{:.1} %", 100.0 * interval.low, 100.0 * interval.high)),
        Shown::new(power.estimate, power.estimate.map_or_else(String::new, |estimate| format!("{estimate:.2}"))),
    ]
}
