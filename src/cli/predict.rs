//! `machband predict`

use super::{Bar, OutPath, count, print_data, print_line, report_written};
use crate::{
    store::{
        Writer, observer,
        ratings::{SessionRead, Source},
    },
    work::{
        criterion::Comparison,
        predict::{Predict, Predictions},
    },
};

/// Predict how visible the Mach bands of one stimulus are, or those of every condition of a definition.
///
/// The bands of a ramp are its difference from the nearest smooth edge, on the light and on the dark side, in times
/// threshold: at 1, people just tell the two apart. Detection is the contrast of the whole picture in the same unit. No
/// observer is needed; --fit compares the prediction with ratings and estimates the thresholds between ratings. To judge
/// any picture against another, use `machband compare`.
#[derive(clap::Args)]
#[command(
    after_help = "Examples: machband predict --width 0.1 --depth 3\n          machband predict bangay2003 --out predicted.csv\n          machband predict bangay2003 --fit results --criterion lab.toml"
)]
pub(super) struct Arguments {
    #[command(flatten)]
    request: Predict,
    /// Where to write the table [default: standard output].
    #[arg(long, value_name = "FILE.csv")]
    out: Option<OutPath>,
    /// Write JSON instead: an object for one stimulus, otherwise a list with an object per condition; with
    /// --fit, the comparison.
    #[arg(long)]
    json: bool,
}

pub(super) fn run(arguments: &Arguments, writer: &Writer) -> anyhow::Result<()> {
    let Arguments { request, json, .. } = arguments;
    let bar = Bar::new("conditions");
    let Some(experiment) = &request.experiment else {
        let (_, table) = request.one(None, &bar)?;
        return put(arguments, writer, &if *json { as_json(&table.json().first())? } else { table.csv() });
    };
    let Predictions { table, fit } = request.all(experiment, &bar)?;
    if let (Some(path), Some((comparison, source))) = (&request.criterion, &fit) {
        observer::write_criterion(writer, path, &told(comparison, source), &comparison.criterion)?;
    }
    if fit.is_none() || arguments.out.is_some() {
        put(arguments, writer, &if *json { as_json(&table.json())? } else { table.csv() })?;
    }
    let Some((found, source)) = fit else { return Ok(()) };
    if *json {
        print_data(&as_json(&found)?)?;
    } else {
        print_comparison(&found, &source)?;
    }
    super::analyze::problems([&source.errors, &source.warnings])
}

fn print_comparison(found: &Comparison, source: &Source) -> anyhow::Result<()> {
    print_line(&format!("{} of {}", count(found.ratings, "rating"), count(found.conditions as u64, "condition")))?;
    let [a, b, c] = found.criterion.thresholds;
    print_line(&format!(
        "criterion: half of the ratings are above 0, 1, 2 at {a:.3}, {b:.3}, {c:.3} times threshold; spread {:.3}",
        found.criterion.spread
    ))?;
    print_line(&told(found, source))?;
    let rho = found.rank_correlation.map_or_else(|| "—".to_owned(), |rho| format!("{rho:.3}"));
    print_line(&format!("rank correlation between prediction and mean rating: {rho}"))
}

/// Says how certain the criterion is, and what it rests on.
fn told(found: &Comparison, source: &Source) -> String {
    let is_simulated = source.sessions.iter().any(SessionRead::is_simulated);
    let who = if is_simulated { "simulated participant" } else { "participant" };
    let interval = |[low, high]: [f64; 2]| format!("{low:.3} to {high:.3}");
    let intervals = found.intervals.map(|ends| ends.map_or_else(|| "unknown".to_owned(), interval));
    format!(
        "approximate 95 % intervals of the thresholds: {}; fitted to {} of {}",
        intervals.join(", "),
        count(found.ratings, "rating"),
        count(found.participants as u64, who)
    )
}

fn as_json(value: &impl serde::Serialize) -> anyhow::Result<Vec<u8>> {
    let mut text = serde_json::to_vec_pretty(value)?;
    text.push(b'\n');
    Ok(text)
}

/// Writes to the file that was asked for, otherwise to standard output.
fn put(arguments: &Arguments, writer: &Writer, data: &[u8]) -> anyhow::Result<()> {
    match &arguments.out {
        Some(path) => {
            writer.write(path, data)?;
            // With a fit, standard output has its results.
            if arguments.request.fit.is_empty() { report_written(path) } else { Ok(()) }
        }
        None => print_data(data),
    }
}
