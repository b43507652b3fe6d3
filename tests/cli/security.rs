//! Texts from files are harmless: none runs in a spreadsheet, a browser or a terminal.

use std::{
    fs,
    path::{Path, PathBuf},
};

use crate::common::{everything, machband, succeeds, text};

/// Names of files, cells and texts in files may contain sequences that a terminal acts on.
#[cfg(unix)]
#[test]
fn no_message_contains_a_control_character() {
    let folder = tempfile::tempdir().unwrap();
    let escape = "\u{1b}]0;title\u{7}\u{1b}[31m\u{9b}2J\u{202e}";
    let write = |name: &str, text: String| {
        fs::write(folder.path().join(name), text).unwrap();
        name.to_owned()
    };
    let toml = write(&format!("{escape}.toml"), "schema = 1\nname = \"\\u001b[31m\"\n".to_owned());
    let data = "subject-S001_session-1_task-quick_data.csv";
    let rows = write(data, format!("row_id,experiment\n{escape},{escape}\n"));
    let sidecar = write("s.csv", format!("subject_id,rating,{escape}\n\"{escape}\",9,1\n"));
    let image = write(&format!("{escape}.png"), "no image".to_owned());
    let mesh = write(&format!("{escape}.obj"), format!("v {escape}\n"));
    let fine = write(&format!("fine {escape}.toml"), include_str!("../../experiments/quick.toml").to_owned());
    let experiment = format!("neither{escape}");
    let picture = format!("picture {escape}.png");
    succeeds(folder.path(), &["stimulus", "--size", "32", "--out", &picture]);
    let lines: [&[&str]; 13] = [
        &["check", &toml, &rows, &image, &mesh, &fine],
        &["check", &fine],
        &["analyze", &rows, &sidecar, "--out", "out", "--factors", escape],
        &["counts", &sidecar, "--out", &experiment, "--factors", "nothing"],
        &["simulate", &experiment],
        &["simulate", "quick", "--results", escape],
        &["compare", &image, &image, "--window", "5"],
        &["compare", &picture, &picture, "--window", "5"],
        &["predict", "--kind", escape],
        &["shade", "--mesh", &mesh, "--shader", "phong", "--out", "out.png"],
        &["export", escape, "--format", "bids", "--out", escape],
        &["verify", escape],
        &[escape],
    ];
    for line in lines {
        let output = machband(folder.path(), line);
        let said = text(&output.stdout) + &text(&output.stderr);
        let acts = |c: &char| (c.is_control() && *c != '\n') || *c == '\u{202e}';
        assert_eq!(said.chars().find(acts), None, "{line:?}: {said:?}");
        assert!(said.contains("\\u{"), "{line:?}: {said:?}");
    }
}

/// Writes ratings with texts that a spreadsheet would treat as formulas and a browser as markup.
fn hostile(folder: &Path) -> PathBuf {
    let path = folder.join("<img src=x onerror=alert(1)>.csv");
    let mut text = String::from("id,\"<b>shape</b>\",score\n");
    for (subject, shift) in [("=cmd|' /C calc'!A0", 0), ("<script>alert(2)</script>", 1), ("@SUM(A1)", 2), ("S4", 0)] {
        for i in 0..24 {
            let level = ["=1+1", "<svg onload=alert(3)>", "+x", "-y"][i % 4];
            text += &format!("\"{subject}\",\"{level}\",{}\n", (i / 4 + shift + i % 4) % 4);
        }
    }
    fs::write(&path, text).unwrap();
    path
}

#[test]
fn no_table_has_a_formula_and_no_page_has_markup_from_data() {
    let folder = tempfile::tempdir().unwrap();
    let path = hostile(folder.path());
    let options = ["--subject", "id", "--response", "score", "--factors", "<b>shape</b>"];
    let path = path.to_str().unwrap();
    for command in [["analyze", path, "--out", "out"], ["counts", path, "--out", "out/counts2.csv"]] {
        succeeds(folder.path(), &[&command[..], &options[..]].concat());
    }
    let (mut cells, mut pages) = (0, 0);
    for (path, content) in everything(&folder.path().join("out")) {
        let shown = path.display();
        match path.extension().unwrap().to_str().unwrap() {
            "csv" => {
                let mut reader = csv::ReaderBuilder::new();
                for record in reader.has_headers(false).flexible(true).from_reader(&content[..]).records() {
                    for cell in &record.unwrap() {
                        let runs = cell.starts_with(['=', '+', '-', '@', '\t', '\r']) && cell.parse::<f64>().is_err();
                        assert!(!runs, "{shown}: {cell:?}");
                        cells += usize::from(cell.starts_with('\''));
                    }
                }
            }
            "html" | "svg" => {
                let text = String::from_utf8(content).unwrap();
                // The texts in `loads` would make the page load something. Links that a reader may choose to follow do
                // not.
                let loads = ["src=\"http", "url(", "@import", "<link"];
                for markup in ["<script", "<img src=x", "<svg onload", "<b>shape", "javascript:"].iter().chain(&loads) {
                    assert!(!text.contains(markup), "{shown}: {markup}");
                }
                pages += 1;
            }
            _ => {}
        }
    }
    assert!(cells > 10 && pages > 2, "{cells} cells were quoted, {pages} pages were checked");
}
