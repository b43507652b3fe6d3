//! The files that describe a results folder to people and to programs that know Psych-DS 1.5: `dataset_description.json`,
//! `README.md`, `CHANGES.md` and the list of files that are not data.

use std::{fs, path::Path};

use serde_json::{Value, json};

use super::frames;
use crate::{
    experiment::{Column, Protocol, columns},
    store::{
        StoreError,
        fault::io,
        file::{is_there, write_json, write_whole},
    },
};

/// Name of the file that describes a data set.
pub const DESCRIPTION: &str = "dataset_description.json";

/// Both names by which the list of files that are not data is known: that of the standard's text and that of its validator.
const IGNORE: [&str; 2] = [".psychds-ignore", ".psychdsignore"];

/// Writes what is not there yet, and adds columns that the description lacks. What people wrote stays. If the description
/// cannot be read, says so in a sentence.
///
/// # Errors
/// The system's refusal.
pub(crate) fn describe(dataset: &Path, protocol: &Protocol) -> Result<Option<String>, StoreError> {
    let [by_text, by_validator] = IGNORE;
    for (name, text) in [
        ("README.md", readme(protocol)),
        ("CHANGES.md", CHANGES.to_owned()),
        (by_text, ignored()),
        (by_validator, ignored()),
    ] {
        let path = dataset.join(name);
        if !is_there(&path)? {
            // The session waits for the disk only where data depend on it.
            write_whole(&path, text.as_bytes(), false)?;
        }
    }
    let path = dataset.join(DESCRIPTION);
    if !is_there(&path)? {
        return write_json(&path, &description(protocol)).map(|()| None);
    }
    let found = fs::read(&path).map_err(io(&path, "read"))?;
    let mut described: Value = serde_json::from_slice(&found).unwrap_or_default();
    match add_columns(&mut described, &columns(protocol)) {
        Some(true) => write_json(&path, &described).map(|()| None),
        Some(false) => Ok(None),
        None => Ok(Some(format!("{DESCRIPTION} has no list variableMeasured; it was left as it is"))),
    }
}

/// A data set's description: its name, what it is, and every column.
fn description(protocol: &Protocol) -> Value {
    json!({
        "@context": "https://schema.org/",
        "@type": "Dataset",
        "name": protocol.name,
        "description": protocol.title,
        "variableMeasured": columns(protocol).iter().map(variable).collect::<Vec<_>>(),
    })
}

/// Adds the columns that a description does not name; whether there were any. `None` where it has no list of columns.
fn add_columns(described: &mut Value, columns: &[Column]) -> Option<bool> {
    let variables = described.get_mut("variableMeasured")?.as_array_mut()?;
    let missing: Vec<Value> =
        columns.iter().filter(|column| !variables.iter().any(|v| names(v, column))).map(variable).collect();
    variables.extend_from_slice(&missing);
    Some(!missing.is_empty())
}

/// A column may stand as an object or as its name alone.
fn names(variable: &Value, column: &Column) -> bool {
    variable.as_str().or_else(|| variable.get("name")?.as_str()) == Some(&column.name)
}

fn variable(column: &Column) -> Value {
    let levels: Vec<String> = column
        .levels
        .iter()
        .map(|(level, meaning)| format!("{level}: {}", meaning.as_str().unwrap_or_default()))
        .collect();
    let description = if levels.is_empty() {
        column.description.clone()
    } else {
        format!("{} ({})", column.description, levels.join("; "))
    };
    let mut variable = json!({ "@type": "PropertyValue", "name": column.name, "description": description });
    if !column.unit.is_empty() {
        variable["unitText"] = column.unit.as_str().into();
    }
    variable
}

fn readme(protocol: &Protocol) -> String {
    let Protocol { name, title, .. } = protocol;
    let version = env!("CARGO_PKG_VERSION");
    format!(
        "# {title}

Ratings recorded with machband {version} by its definition `{name}`.

- `data/subject-…_session-…_task-…_data.csv`: one row a trial. `row_id` names each row of the data set.
- `data/…_data.json`: beside each, everything else that is known of the session: the definition and the seed that the
  order of its trials follows from, program, screen, geometry, and what each column means.
- `data/…{frames}`: every frame interval, where a screen was used.

Missing values are empty. A corrected response is a row of its own with `attempt` + 1; the last attempt of a trial
counts. Rows with `phase` practice are not data.

`machband verify` proves the rows and the pictures from the sidecars; `machband analyze` analyzes the ratings.
Author, license and the like belong in `{DESCRIPTION}`: what is written there stays.
",
        frames = frames::SUFFIX
    )
}

const CHANGES: &str = "# Changes

Sessions are added while they are recorded, and never changed afterwards. Note here, with a date, whatever is changed by
hand.
";

fn ignored() -> String {
    let [by_the_text, _] = IGNORE;
    format!(
        "# Frame intervals describe a session and are not its data.\n*{}\n# This list, by the name that the standard's text gives it.\n{by_the_text}\n",
        frames::SUFFIX
    )
}
