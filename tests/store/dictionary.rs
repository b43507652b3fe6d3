//! `results/README.md` ends with the column dictionary, which is generated from the program's column definitions.
//! `UPDATE_DOCS=1 cargo test --test store dictionary` updates it.

use machband::{experiment::columns, store::definition};

const PATH: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/results/README.md");

#[test]
fn the_column_dictionary_is_up_to_date() {
    const RULE: &str = "|---|---|---|\n";
    let found = std::fs::read_to_string(PATH).unwrap();
    let (head, _) = found.split_once(RULE).unwrap();
    let mut expected = format!("{head}{RULE}");
    for column in columns(&definition::open("bangay2003").unwrap()) {
        let levels: Vec<String> = column
            .levels
            .iter()
            .map(|(value, meaning)| format!("{value}: {}", meaning.as_str().unwrap_or_default()))
            .collect();
        let levels = if levels.is_empty() { String::new() } else { format!(" ({})", levels.join("; ")) };
        expected += &format!("| `{}` | {} | {}{levels} |\n", column.name, column.unit, column.description);
    }
    if std::env::var_os("UPDATE_DOCS").is_some() {
        std::fs::write(PATH, expected).unwrap();
    } else {
        assert_eq!(found, expected, "run UPDATE_DOCS=1 cargo test --test store dictionary");
    }
}
