//! `results/README.md` is the column dictionary, made from the record itself. `UPDATE_DOCS=1 cargo test --test store dictionary`
//! writes it anew.

use machband::{experiment::columns, store::definition};

const PATH: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/results/README.md");

fn dictionary() -> String {
    let mut text = String::from(
        "# Results\n\n\
         Sessions are recorded here unless you choose another folder (`--results DIR`). Each experiment has one folder, which is a\n\
         Psych-DS data set.\n\n\
         ```\n\
         results/EXPERIMENT/dataset_description.json                         name, description, every column; people add author, license, …\n\
         results/EXPERIMENT/README.md, CHANGES.md                            a description; manual changes\n\
         results/EXPERIMENT/.psychds-ignore, .psychdsignore                  files that are not data, under both names in use\n\
         results/EXPERIMENT/data/subject-ID_session-ID_task-NAME_data.csv    one row per trial, on disk before the next trial is shown\n\
         results/EXPERIMENT/data/subject-ID_session-ID_task-NAME_data.json   the sidecar: definition, seed, program, screen, geometry, frames, columns, hashes of the pictures, the seal\n\
         results/EXPERIMENT/data/subject-ID_session-ID_task-NAME_frames.csv  every frame interval in microseconds, one row per screen content\n\
         ```\n\n\
         The seal contains the hashes of a session's files at its end. `machband verify` uses the seal and the hashes of the\n\
         pictures to verify a session.\n\
         `machband export` writes other formats; see [The data](../docs/data.md).\n\n\
         NAME is the experiment's name without hyphens. Missing values are empty. A corrected response is a new row with\n\
         `attempt` + 1; the last attempt counts. A factor that is not listed below has a column of its own name, after `seed`;\n\
         files from earlier versions may lack some of the last columns.\n\n\
         | column | unit | what |\n|---|---|---|\n",
    );
    for column in columns(&definition::open("bangay2003").unwrap()) {
        let levels: Vec<String> = column
            .levels
            .iter()
            .map(|(value, meaning)| format!("{value}: {}", meaning.as_str().unwrap_or_default()))
            .collect();
        let levels = if levels.is_empty() { String::new() } else { format!(" ({})", levels.join("; ")) };
        text += &format!("| `{}` | {} | {}{levels} |\n", column.name, column.unit, column.description);
    }
    text
}

#[test]
fn the_column_dictionary_is_that_of_the_program() {
    if std::env::var_os("UPDATE_DOCS").is_some() {
        std::fs::write(PATH, dictionary()).unwrap();
    }
    assert_eq!(
        std::fs::read_to_string(PATH).unwrap(),
        dictionary(),
        "run UPDATE_DOCS=1 cargo test --test store dictionary"
    );
}
