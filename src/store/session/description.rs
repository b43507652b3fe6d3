//! What describes a results folder to people and to programs that know Psych-DS 1.5: `dataset_description.json`,
//! `README.md`, `CHANGES.md` and the list of what is no data.

use std::{fs, path::Path};

use serde_json::{Value, json};

use crate::{
    experiment::{Column, Protocol, columns},
    store::{
        StoreError,
        fault::io,
        file::{is_there, write_json, write_whole},
        frames,
    },
};

/// Name of the file that describes a data set.
pub const DESCRIPTION: &str = "dataset_description.json";

/// Both names by which the list of what is no data is known: that of the standard's text and that of its validator.
const IGNORE: [&str; 2] = [".psychds-ignore", ".psychdsignore"];

/// Writes what is not there yet, and adds columns that the description lacks. What people wrote stays. Gives what could
/// not be read, as a sentence.
///
/// # Errors
/// The system's refusal.
pub(in crate::store) fn describe(dataset: &Path, protocol: &Protocol) -> Result<Option<String>, StoreError> {
    let absent = |name: &str| -> Result<_, StoreError> {
        let path = dataset.join(name);
        Ok(if is_there(&path)? { None } else { Some(path) })
    };
    // The session waits for the disk only where data depend on it.
    if let Some(path) = absent("README.md")? {
        write_whole(&path, readme(protocol).as_bytes(), false)?;
    }
    if let Some(path) = absent("CHANGES.md")? {
        write_whole(&path, changes().as_bytes(), false)?;
    }
    for name in IGNORE {
        if let Some(path) = absent(name)? {
            write_whole(&path, ignored().as_bytes(), false)?;
        }
    }
    let path = dataset.join(DESCRIPTION);
    if !is_there(&path)? {
        return write_json(&path, &description(&protocol.name, &protocol.title, &columns(protocol))).map(|()| None);
    }
    let found = fs::read(&path).map_err(io(&path, "read"))?;
    let described = match serde_json::from_slice::<Value>(&found) {
        Ok(mut described) => add_columns(&mut described, &columns(protocol)).map(|changed| (described, changed)),
        Err(_) => None,
    };
    match described {
        Some((described, true)) => write_json(&path, &described).map(|()| None),
        Some(_) => Ok(None),
        None => Ok(Some(format!("{DESCRIPTION} is no description with a list variableMeasured; it was left as it is"))),
    }
}

/// A data set's description: its name, what it is, and every column.
pub(in crate::store) fn description(name: &str, title: &str, columns: &[Column]) -> Value {
    let variables: Vec<_> = columns.iter().map(variable).collect();
    json!({
        "@context": "https://schema.org/",
        "@type": "Dataset",
        "name": name,
        "description": title,
        "variableMeasured": variables,
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
counts. Rows with `phase` practice are no data.

`machband verify` proves the rows and the pictures from the sidecars; `machband analyze` analyses them.
Author, licence and the like belong in `{DESCRIPTION}`: what is written there stays.
",
        frames = frames::SUFFIX
    )
}

fn changes() -> &'static str {
    "# Changes

Sessions are added while they are recorded, and never changed afterwards. Note here, with a date, whatever is changed by
hand.
"
}

fn ignored() -> String {
    let [by_the_text, _] = IGNORE;
    format!(
        "# Frame intervals describe a session and are not its data.\n*{}\n# This list, by the name that the standard's text gives it.\n{by_the_text}\n",
        frames::SUFFIX
    )
}
