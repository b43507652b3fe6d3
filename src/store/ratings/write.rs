//! Counts of ratings as CSV: the table that reading takes back.

use std::io::Write;

/// One row of a table of counts.
#[derive(Clone, Debug, PartialEq)]
pub struct CountRow<'a> {
    /// Who.
    pub subject: &'a str,
    /// The level of each factor; empty where it is missing.
    pub values: Vec<&'a str>,
    /// The rating.
    pub rating: &'a str,
    /// How often.
    pub count: u64,
}

/// Writes `subject_id`, the factors, `rating` and `count`, in UTF-8 with a header.
///
/// # Errors
/// The system's refusal; a row with another number of values than there are factors.
pub fn write_counts<'a>(
    to: impl Write,
    factors: &[&str],
    rows: impl IntoIterator<Item = CountRow<'a>>,
) -> std::io::Result<()> {
    let mut writer = csv::Writer::from_writer(to);
    let header = std::iter::once("subject_id").chain(factors.iter().copied()).chain(["rating", "count"]);
    writer.write_record(header)?;
    for row in rows {
        let count = row.count.to_string();
        let cells = std::iter::once(row.subject).chain(row.values.iter().copied()).chain([row.rating, &count]);
        writer.write_record(cells)?;
    }
    writer.flush()
}
