//! Type I errors and coverage of the analysis in studies that an independent generator simulated
//! (scripts/calibration_studies.py).

use std::{collections::BTreeMap, error::Error, path::Path, time::Instant};

use machband::analysis::{
    Options, Resampling, Results, analyze,
    counts::{Measured, MeasuredBuilder},
};
use machband::{experiment::RatingRow, statistics::Interval};
use rayon::prelude::*;
use serde_json::Value;

/// The 0.05 level of all tests.
const ALPHA: f64 = 0.05;

/// What the columns of the table count: for each statistic, whether it was given, and whether it rejected or covered.
const COLUMNS: [&str; 11] = [
    "LR",
    "Friedman",
    "interaction",
    "comparison",
    "coefficient",
    "mean",
    "cell",
    "expected",
    "alpha",
    "drift",
    "lag-one",
];

/// Counts of one study: given and successful, by column, and withheld.
#[derive(Clone, Default)]
struct Tally {
    given: [f64; COLUMNS.len()],
    hits: [f64; COLUMNS.len()],
    withheld: [f64; COLUMNS.len()],
}

impl Tally {
    fn add(&mut self, column: &str, hit: Option<bool>) {
        let Some(index) = COLUMNS.iter().position(|name| *name == column) else { return };
        match hit {
            Some(hit) => {
                self.given[index] += 1.0;
                self.hits[index] += f64::from(u8::from(hit));
            }
            None => self.withheld[index] += 1.0,
        }
    }

    fn absorb(mut self, other: &Self) -> Self {
        for index in 0..COLUMNS.len() {
            self.given[index] += other.given[index];
            self.hits[index] += other.hits[index];
            self.withheld[index] += other.withheld[index];
        }
        self
    }
}

/// Prints one row per design. A number in parentheses is the share of studies in which the statistic is withheld.
pub fn run(folder: &Path, designs: &[String], studies: usize, draws: u32) -> Result<(), Box<dyn Error>> {
    let mut names: Vec<String> = (std::fs::read_dir(folder)?.filter_map(Result::ok))
        .filter_map(|entry| entry.file_name().to_str()?.strip_suffix(".json").map(str::to_owned))
        .filter(|name| designs.is_empty() || designs.contains(name))
        .collect();
    names.sort();
    println!("| design | {} |", COLUMNS.join(" | "));
    println!("|---|{}", "--:|".repeat(COLUMNS.len()));
    for name in names {
        let start = Instant::now();
        let truth: Value = serde_json::from_slice(&std::fs::read(folder.join(format!("{name}.json")))?)?;
        let all = read(&folder.join(format!("{name}.csv")), studies)?;
        let tallies: Vec<Tally> = all.into_par_iter().map(|measured| study(measured, &truth, draws)).collect();
        let total = tallies.iter().fold(Tally::default(), Tally::absorb);
        let cell = |index: usize| {
            let (given, withheld) = (total.given[index], total.withheld[index]);
            let share = if given > 0.0 { format!("{:.3}", total.hits[index] / given) } else { "–".to_owned() };
            let withheld = withheld / (given + withheld).max(1.0);
            if withheld > 0.0005 { format!("{share} ({withheld:.3})") } else { share }
        };
        let cells: Vec<String> = (0..COLUMNS.len()).map(cell).collect();
        println!("| {name} | {} |", cells.join(" | "));
        eprintln!("{name}: {} studies, {:.0} s", tallies.len(), start.elapsed().as_secs_f64());
    }
    Ok(())
}

/// Reads the studies of a design.
fn read(file: &Path, most: usize) -> Result<Vec<Measured>, Box<dyn Error>> {
    let mut reader = csv::Reader::from_path(file)?;
    let header: Vec<String> = reader.headers()?.iter().map(str::to_owned).collect();
    let is_placed = header.last().is_some_and(|name| name == "trial");
    let last = header.len() - 2 - usize::from(is_placed);
    let mut builders: BTreeMap<usize, MeasuredBuilder> = BTreeMap::new();
    for record in reader.records() {
        let record = record?;
        let study: usize = record[0].parse()?;
        if study > most {
            break;
        }
        let cells: Vec<&str> = record.iter().collect();
        let builder = builders
            .entry(study)
            .or_insert_with(|| MeasuredBuilder::new(&header[2..last]).with_categories(&["0", "1", "2", "3"]));
        builder.add(&RatingRow {
            subject: cells[1],
            values: &cells[2..last],
            rating: cells[last],
            count: cells[last + 1].parse()?,
            position: if is_placed { Some(cells[last + 2].parse()?) } else { None },
            ..RatingRow::default()
        })?;
    }
    Ok(builders.into_values().map(MeasuredBuilder::finish).collect())
}

fn study(measured: Measured, truth: &Value, draws: u32) -> Tally {
    let numeric: Vec<&str> = truth["numeric"].as_array().into_iter().flatten().filter_map(Value::as_str).collect();
    let items = truth["items"].as_str().map(str::to_owned);
    let factors = measured.counts.factors.iter().filter(|factor| Some(&factor.name) != items.as_ref());
    let names = factors.map(|factor| match numeric.contains(&factor.name.as_str()) {
        true => format!("num:{}", factor.name),
        false => factor.name.clone(),
    });
    let terms = names.collect::<Vec<_>>().join(",").parse().ok();
    let resampling = Resampling { draws, ..Resampling::default() };
    let results = analyze(measured, &Options { terms, items, resampling, unchecked: true, ..Options::default() });
    tally(&results, truth)
}

fn tally(results: &Results, truth: &Value) -> Tally {
    let mut tally = Tally::default();
    let covers = |interval: Option<Interval>, value: &Value| {
        let value = value.as_f64()?;
        interval.map(|interval| interval.low <= value && value <= interval.high)
    };
    let null: Vec<&str> = truth["null"].as_array().into_iter().flatten().filter_map(Value::as_str).collect();
    for name in &null {
        let report = results.model.as_ref().ok();
        let test =
            report.and_then(|report| report.terms.iter().find(|test| test.term.is_main() && test.term.name() == *name));
        tally.add("LR", test.and_then(|test| test.p).map(|p| p < ALPHA));
        let Some(factor) = results.factors.iter().find(|factor| factor.name == *name) else { continue };
        if factor.within && results.is_inferential() {
            tally.add("Friedman", factor.friedman.map(|test| test.p < ALPHA));
        }
        let comparisons = report.into_iter().flat_map(|report| &report.comparisons).filter(|c| c.factor == *name);
        let any: Vec<bool> = comparisons.filter_map(|comparison| comparison.p_holm).map(|p| p < ALPHA).collect();
        if !any.is_empty() {
            tally.add("comparison", Some(any.contains(&true)));
        }
    }
    if let Ok(report) = &results.model {
        let interactions: Vec<f64> = report.interactions.iter().filter_map(|own| own.test.p).collect();
        if !report.interactions.is_empty() {
            tally.add("interaction", (!interactions.is_empty()).then(|| interactions.iter().any(|p| *p < ALPHA)));
        }
        if let Some(order) = &report.order {
            tally.add("drift", order.drift_p.map(|p| p < ALPHA));
            tally.add("lag-one", Some(order.lag_one_p < ALPHA));
        }
        for coefficient in &report.model.coefficients {
            tally.add("coefficient", covers(coefficient.interval, &truth["coefficients"][&coefficient.name]));
        }
        for prediction in &report.predictions {
            tally.add("expected", covers(prediction.interval, &truth["typical_means"][prediction.names.join(",")]));
        }
    }
    for factor in &results.factors {
        for level in &factor.levels {
            tally.add("mean", covers(level.summary.interval, &truth["level_means"][&factor.name][&level.names[0]]));
        }
    }
    for cell in &results.cells {
        tally.add("cell", covers(cell.summary.interval, &truth["cell_means"][cell.names.join(",")]));
    }
    if results.is_inferential() {
        tally.add("alpha", covers(results.alpha.and_then(|alpha| alpha.interval), &truth["alpha"]));
    }
    tally
}
