//! `machband plan`

use super::{Bar, OutPath, print_line};
use crate::{
    analysis::power::Sampling,
    report::document::Shown,
    store::{Writer, definition},
    text::{Cell, Column, Table},
    work::{
        RequestError,
        plan::{Found, OPTIONS, Plan, Planned, PlannedTask},
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
    infinite_as, strongest_width, subject_sd, lapse (see experiments/observers/paper.toml). FACTOR:LEVEL=SHIFT adds logits \
    to one level of any factor of the experiment.\n\n\
    --slope FACTOR=SD lets people differ in the effect of a factor: each deviates at each of its levels by an independent \
    normal value, as in R's (1 | subject:factor). The more they differ, the lower the power.\n\n\
    Up to 40 participants, p values of the model come from simulated studies without the effect: as many as --studies, \
    but at least 199 and at most 999.\n\n\
    Other tasks: reports the error of one person's threshold, d', proportion of correct answers, scale value or setting, the \
    precision of the mean and of differences from the first condition, and how often analyze would find these. \
    FACTOR:LEVEL=SHIFT moves it: in base-10 logarithms if levels or settings are logarithmic, in JND for pairs. NAME=VALUE \
    sets a parameter that the first line of the output names. --trials compares numbers of trials.\n\n\
    Results depend on the seed but not on the number of threads (ChaCha8, one stream per participant and study).\n\n\
    Examples:\n  machband plan orientation --participants 4,8,12 --effect oblique=0.5\n  \
    machband plan orientation --participants 12 --effect oblique=0.5 --slope orientation_deg=0.5\n  \
    machband plan shaders --participants 8 --effect shader:gouraud=1 --effect shader:flat=2\n  \
    machband plan threshold-width --participants 4,8 --trials 20,40 --effect orientation_deg:90=0.1 --studies 100\n  \
    machband plan pairs-shaders --participants 4,8 --trials 60,120 --effect shader:flat=2"
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
    let Arguments { request, out, preregistration } = arguments;
    if preregistration.is_some() && !definition::open(&request.experiment)?.task.is_default() {
        let message = "does not apply to this task; expected a definition of ratings";
        return Err(RequestError::new("preregistration", message).into());
    }
    let bar = Bar::new("simulated participants");
    let planned = request.plan(&bar);
    bar.clear();
    let found = planned?;
    let (heading, names, below) = match &found {
        Found::Ratings(planned) => {
            (ratings(planned), RATINGS, [vec![String::new()], planned.sentences(OPTIONS)].concat())
        }
        Found::Task(planned) => (task(planned), TASK, Vec::new()),
    };
    let table = found.table();
    let lines = [vec![heading, String::new()], shown(&table, names), below].concat();
    lines.iter().try_for_each(|line| print_line(line))?;
    // Written last, so that no result is lost if the path cannot be written.
    if let Some(path) = out {
        writer.write(path, &table.csv())?;
    }
    if let (Some(path), Found::Ratings(planned)) = (preregistration, &found) {
        writer.write(path, request.preregistration(planned).as_bytes())?;
    }
    Ok(())
}

/// The columns of a plan that are printed.
const RATINGS: &str = "participants term test effect_logits above below power false_alarms ci_low ci_high";
const TASK: &str = "participants trials estimate truth missing power false_alarms ci_low ci_high half_width error";

/// Formats these columns of a table, with three decimals.
fn shown(table: &Table, names: &str) -> Vec<String> {
    let text = |cell: &Cell| match cell {
        Cell::Number(number) => Shown::new(*number, format!("{number:.3}")),
        cell => Shown::new(cell.clone(), cell.to_string()),
    };
    let is_shown = |column: &&Column| names.split(' ').any(|name| name == column.name);
    let table = Table { columns: table.columns.iter().filter(is_shown).cloned().collect() };
    let rows: Vec<Vec<Shown>> = table.rows().map(|row| row.into_iter().map(text).collect()).collect();
    let names: Vec<&str> = table.columns.iter().map(|column| column.name.as_str()).collect();
    super::columns(&names, &rows)
}

/// Says what was simulated.
fn task(planned: &PlannedTask) -> String {
    let PlannedTask { plan, sampling: Sampling { studies, seed, .. }, .. } = planned;
    format!(
        "{}: {studies} studies per number of participants, seed {seed}; observer {}; differences and errors in {}",
        plan.protocol.name,
        plan.observer,
        planned.unit(),
    )
}

fn ratings(planned: &Planned) -> String {
    let (spec, Sampling { studies, alpha, seed }) = (&planned.plan.spec, planned.sampling);
    format!(
        "{}, observer {}: {} ratings from each participant, {studies} studies per number of participants, seed {seed}; \
             {} model of {}, slopes {}, alpha {alpha}",
        planned.protocol.name,
        planned.observer,
        planned.plan.ratings(),
        spec.link,
        spec.terms,
        spec.slopes,
    )
}
