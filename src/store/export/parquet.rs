//! Apache Parquet for data engines: a file for each experiment, a row a trial, every column with its type, nulls for what
//! is missing. What the columns mean stands in the file, as JSON under the key `machband`.

use std::{fs::File, path::Path, sync::Arc};

use parquet::{
    basic::Compression,
    data_type::{BoolType, ByteArray, ByteArrayType, DataType, DoubleType, Int32Type, Int64Type},
    errors::ParquetError,
    file::{
        metadata::KeyValue,
        properties::WriterProperties,
        writer::{SerializedFileWriter, SerializedRowGroupWriter},
    },
    schema::parser::parse_message_type,
};
use serde_json::{Map, Value, json};

use super::Experiment;
use crate::{
    experiment::{Column, Protocol, columns},
    stimulus::ParameterValue,
    store::{StoreError, fault::io, recorded::Recorded},
};

/// Key under which the file says what it is.
const KEY: &str = "machband";
/// Rows of a group at least, but in the last: enough to be read fast, few enough to be held in memory.
const GROUP_ROWS: usize = 1 << 20;

/// What a column holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Boolean,
    Whole,
    Unsigned,
    Number,
    Time,
    Text,
}

impl Kind {
    /// As the schema's text says it, around the column's name.
    fn declared(self, name: &str) -> String {
        match self {
            Self::Boolean => format!("OPTIONAL BOOLEAN {name};"),
            Self::Whole => format!("OPTIONAL INT32 {name};"),
            Self::Unsigned => format!("OPTIONAL INT64 {name} (INTEGER(64,false));"),
            Self::Number => format!("OPTIONAL DOUBLE {name};"),
            Self::Time => format!("OPTIONAL INT64 {name} (TIMESTAMP(MILLIS,true));"),
            Self::Text => format!("OPTIONAL BYTE_ARRAY {name} (STRING);"),
        }
    }

    /// By the name of a column that every result file has; else by the levels of the factor.
    fn of(protocol: &Protocol, name: &str) -> Self {
        let numbers = || {
            let factor = protocol.factors.iter().find(|factor| factor.name == name);
            factor.is_some_and(|factor| factor.levels.iter().all(|level| matches!(level, ParameterValue::Number(_))))
        };
        match name {
            "block" | "trial" | "attempt" | "repetition" | "rating" | "frames" | "dropped_frames" | "sitting" => {
                Self::Whole
            }
            "seed" => Self::Unsigned,
            // inf is a number too.
            "width"
            | "depth"
            | "orientation_deg"
            | "low"
            | "high"
            | "response_time_s"
            | "onset_s"
            | "recovery_s"
            | "stimulus_s"
            | "response_uncertainty_s" => Self::Number,
            "late_onset" => Self::Boolean,
            "started_at" => Self::Time,
            "row_id" | "experiment" | "subject_id" | "session_id" | "phase" | "stimulus" | "color" => Self::Text,
            _ if numbers() => Self::Number,
            _ => Self::Text,
        }
    }
}

/// Writes a file for each experiment into `to`.
pub(super) fn write(experiments: &[Experiment], to: &Path) -> Result<(), StoreError> {
    for experiment in experiments {
        let path = to.join(format!("{}.parquet", experiment.name));
        let file = File::create_new(&path).map_err(io(&path, "write"))?;
        table(experiment, file).map_err(|error| io(&path, "write")(std::io::Error::other(error)))?;
    }
    Ok(())
}

fn table(experiment: &Experiment, file: File) -> Result<(), ParquetError> {
    let columns = joined(experiment);
    let fields: Vec<String> = columns.iter().map(|(column, kind)| kind.declared(&column.name)).collect();
    let schema = parse_message_type(&format!("message trial {{ {} }}", fields.join(" ")))?;
    let said = KeyValue::new(KEY.to_owned(), meaning(experiment, &columns).to_string());
    let properties = WriterProperties::builder()
        .set_compression(Compression::SNAPPY)
        .set_created_by(concat!(env!("CARGO_PKG_NAME"), " ", env!("CARGO_PKG_VERSION")).to_owned())
        .set_key_value_metadata(Some(vec![said]))
        .build();
    let mut writer = SerializedFileWriter::new(file, Arc::new(schema), Arc::new(properties))?;
    let mut rest = experiment.sessions.as_slice();
    while !rest.is_empty() {
        let mut rows = 0;
        let wanted = rest.iter().take_while(|session| {
            let more = rows < GROUP_ROWS;
            rows += session.rows.len();
            more
        });
        let (group, later) = rest.split_at(wanted.count());
        let mut group_writer = writer.next_row_group()?;
        for ((_, kind), cells) in columns.iter().zip(cells(group, &columns)) {
            write_column(&mut group_writer, *kind, &cells)?;
        }
        group_writer.close()?;
        rest = later;
    }
    writer.close()?;
    Ok(())
}

/// The columns of all sessions: those of the first, then what others have. A column that is not the same kind in all of
/// them is text.
fn joined(experiment: &Experiment) -> Vec<(Column, Kind)> {
    let mut joined: Vec<(Column, Kind)> = Vec::new();
    let mut last: Option<&Protocol> = None;
    for protocol in experiment.sessions.iter().map(|session| &session.protocol) {
        if last == Some(protocol) {
            continue;
        }
        last = Some(protocol);
        for column in columns(protocol) {
            let kind = Kind::of(protocol, &column.name);
            match joined.iter_mut().find(|(known, _)| known.name == column.name) {
                Some((_, known)) if *known == kind => {}
                Some((_, known)) => *known = Kind::Text,
                None => joined.push((column, kind)),
            }
        }
    }
    joined
}

/// The cells of each column, row by row; empty where a session does not have the column.
fn cells(sessions: &[Recorded], joined: &[(Column, Kind)]) -> Vec<Vec<String>> {
    let mut all = vec![Vec::new(); joined.len()];
    for session in sessions {
        let own = columns(&session.protocol);
        let places: Vec<Option<usize>> =
            joined.iter().map(|(column, _)| own.iter().position(|other| other.name == column.name)).collect();
        for row in &session.rows {
            let mut cells = row.cells();
            for (column, place) in all.iter_mut().zip(&places) {
                let cell = place.and_then(|place| cells.get_mut(place)).map(std::mem::take);
                column.push(cell.unwrap_or_default());
            }
        }
    }
    all
}

fn write_column<W: std::io::Write + Send>(
    group: &mut SerializedRowGroupWriter<'_, W>,
    kind: Kind,
    cells: &[String],
) -> Result<(), ParquetError> {
    match kind {
        Kind::Boolean => write_values::<BoolType, _>(group, cells, |cell| Some(cell == "1")),
        Kind::Whole => write_values::<Int32Type, _>(group, cells, |cell| {
            // Counts of a session: none comes near the end of the range.
            cell.parse::<i32>().ok()
        }),
        // The same 64 bits: the schema says that they have no sign.
        Kind::Unsigned => write_values::<Int64Type, _>(group, cells, |cell| cell.parse().ok().map(u64::cast_signed)),
        Kind::Number => write_values::<DoubleType, _>(group, cells, |cell| cell.parse().ok()),
        Kind::Time => write_values::<Int64Type, _>(group, cells, |cell| {
            cell.parse::<jiff::Timestamp>().ok().map(jiff::Timestamp::as_millisecond)
        }),
        Kind::Text => write_values::<ByteArrayType, _>(group, cells, |cell| Some(ByteArray::from(cell))),
    }
}

/// Writes the next column. A cell that is there and has no value is an error: it would be lost.
fn write_values<T: DataType, W: std::io::Write + Send>(
    group: &mut SerializedRowGroupWriter<'_, W>,
    cells: &[String],
    value: impl Fn(&str) -> Option<T::T>,
) -> Result<(), ParquetError> {
    let there: Vec<i16> = cells.iter().map(|cell| i16::from(!cell.is_empty())).collect();
    let values: Result<Vec<T::T>, ParquetError> = cells
        .iter()
        .filter(|cell| !cell.is_empty())
        .map(|cell| value(cell).ok_or_else(|| ParquetError::General(format!("the cell {cell:?} is not of its column"))))
        .collect();
    let mut column =
        group.next_column()?.ok_or_else(|| ParquetError::General("the schema has too few columns".to_owned()))?;
    column.typed::<T>().write_batch(&values?, Some(&there), None)?;
    column.close()
}

/// What the table is, and what each column means.
fn meaning(experiment: &Experiment, columns: &[(Column, Kind)]) -> Value {
    let described = columns
        .iter()
        .map(|(column, _)| (column.name.clone(), serde_json::to_value(column).unwrap_or_default()))
        .collect::<Map<_, _>>();
    json!({
        "experiment": experiment.name,
        "title": experiment.sessions[0].protocol.title,
        "program": { "name": env!("CARGO_PKG_NAME"), "version": env!("CARGO_PKG_VERSION") },
        "columns": described,
    })
}
