//! Links and texts from files are harmless: no link leads out of the results folder, and no text runs in a spreadsheet
//! or a browser.

use std::{
    fs,
    path::{Path, PathBuf},
};

use crate::common::{everything, fails, succeeds};

#[cfg(unix)]
#[test]
fn links_below_the_results_folder_are_refused() {
    use std::os::unix::fs::symlink;
    let stem = "subject-S001_session-1_task-quick";
    let places = [
        "quick".to_owned(),
        "quick/data".to_owned(),
        format!("quick/data/{stem}_data.csv"),
        format!("quick/data/{stem}_data.json"),
        format!("quick/data/{stem}_frames.csv"),
    ];
    for place in &places {
        for target_exists in [true, false] {
            let folder = tempfile::tempdir().unwrap();
            let outside = folder.path().join("outside");
            fs::create_dir(&outside).unwrap();
            let is_file = place.contains("subject");
            let target = outside.join("target");
            if target_exists && is_file {
                fs::write(&target, "not ours").unwrap();
            } else if target_exists {
                fs::create_dir(&target).unwrap();
            }
            let link = folder.path().join("results").join(place);
            fs::create_dir_all(link.parent().unwrap()).unwrap();
            symlink(&target, &link).unwrap();
            let before = everything(folder.path());
            for resume in [false, true] {
                let arguments = ["simulate", "quick", "--results", "results", "--resume"];
                let error = fails(folder.path(), &arguments[..if resume { 5 } else { 4 }], 1);
                assert!(error.starts_with("error: results/quick"), "{place}: {error}");
                assert_eq!(everything(folder.path()), before, "{place}");
            }
        }
    }
    // The results folder itself may be a link, so that results can be kept on another disk.
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir(folder.path().join("disk")).unwrap();
    symlink(folder.path().join("disk"), folder.path().join("results")).unwrap();
    succeeds(folder.path(), &["simulate", "quick"]);
    assert!(folder.path().join("disk/quick/data").is_dir());
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
