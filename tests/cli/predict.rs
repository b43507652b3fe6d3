//! `machband predict` and the vision observer, run as a user runs them.

use std::fs;

use machband::store::{definition, sidecar::Geometry};

use crate::common::{fails, json, machband, refuses, session_csv, split, succeeds, text};

fn column(table: &str, name: &str) -> Vec<String> {
    let mut reader = csv::Reader::from_reader(table.as_bytes());
    let place = reader.headers().unwrap().iter().position(|header| header == name).expect(name);
    reader.records().map(|record| record.unwrap()[place].to_owned()).collect()
}

fn numbers(table: &str, name: &str) -> Vec<f64> {
    column(table, name).iter().map(|text| text.parse().unwrap()).collect()
}

#[test]
fn a_stimulus_and_a_definition_agree() {
    let folder = tempfile::tempdir().unwrap();
    let run = |line: &str| succeeds(folder.path(), &split(line));
    let (one, all) = (run("predict --width 0.1"), run("predict bangay2003"));
    assert!(all.starts_with("width,depth,orientation_deg,band_bright,band_dark,detection\n"), "{all}");
    assert_eq!(all.lines().count(), 121);
    let found = all.lines().find(|line| line.starts_with("0.1,1,0,")).unwrap();
    let own = ["band_bright", "band_dark", "detection"].map(|name| column(&one, name).remove(0)).join(",");
    assert!(found.ends_with(&own), "{found} and {one}");
    // A rating is predicted only by a criterion.
    fs::write(folder.path().join("lab.toml"), "schema = 1\nthresholds = [0.5, 1.0, 2.0]\nspread = 0.5\n").unwrap();
    let rated = run("predict bangay2003 --criterion lab.toml");
    assert!(numbers(&rated, "predicted_rating").iter().all(|rating| (0.0..=3.0).contains(rating)));
    let strongest = numbers(&rated, "band_bright").into_iter().zip(numbers(&rated, "predicted_rating"));
    let strongest = strongest.max_by(|a, b| a.0.total_cmp(&b.0)).unwrap();
    assert!(strongest.0 > 2.0 && strongest.1 > 1.5, "{strongest:?}");
    // Stimuli without a smooth reference have no bands, but can be detected; a mesh differs from its surface.
    let other = run("predict --kind kanizsa");
    assert_eq!([column(&other, "band_bright"), column(&other, "difference")], [[""], [""]]);
    assert!(numbers(&other, "detection")[0] > 1.0);
    let mesh = run("predict --kind shaded-mesh --shader gouraud");
    assert!(numbers(&mesh, "difference")[0] > 1.0 && column(&mesh, "band_bright") == [""], "{mesh}");
    let brighter = run("predict --width 0.1 --white 500 --black 0");
    assert_ne!(column(&brighter, "band_dark"), column(&one, "band_dark"));
    let other = format!(
        "schema = 1\nname = \"{0}\"\ntitle = \"Stairs\"\n[stimulus]\nkind = \"{0}\"\n[factors]\nsteps = [3, 5]\n[viewing]\ndistance_cm = 50.0\nwindow_deg = 10.0\n",
        "chevreul"
    );
    fs::write(folder.path().join("other.toml"), other).unwrap();
    let refused =
        fails(folder.path(), &split("simulate other.toml --observer vision --participants 1 --results none"), 1);
    assert!(refused.contains("expected a mach-band, or a mesh whose smooth surface is known"), "{refused}");
}

/// Fitting simulated ratings recovers the thresholds of the simulated observer.
#[test]
fn a_criterion_is_recovered_from_ratings() {
    let folder = tempfile::tempdir().unwrap();
    let known = "schema = 1\nthresholds = [0.4, 0.8, 1.6]\nspread = 0.5\nsubject_sd = 0.0\nlapse = 0.0\n";
    fs::write(folder.path().join("known.toml"), known).unwrap();
    let run = |line: &str| succeeds(folder.path(), &split(line));
    run("simulate bangay2003 --participants 20 --observer vision --observer-file known.toml");
    let output = run("predict bangay2003 --fit results/bangay2003 --criterion found.toml --out predicted.csv");
    let found: toml::Table = fs::read_to_string(folder.path().join("found.toml")).unwrap().parse().unwrap();
    let thresholds: Vec<f64> = found["thresholds"].as_array().unwrap().iter().map(|t| t.as_float().unwrap()).collect();
    for (found, known) in thresholds.iter().zip([0.4_f64, 0.8, 1.6]) {
        assert!((found / known).ln().abs() < 0.08, "{found} for {known}");
    }
    let text = fs::read_to_string(folder.path().join("found.toml")).unwrap();
    assert!(
        text.starts_with("# approximate 95 % intervals") && text.contains("of 20 simulated participants"),
        "{text}"
    );
    assert!((found["spread"].as_float().unwrap() / 0.5 - 1.0).abs() < 0.1, "{found}");
    let rho = output.lines().find(|line| line.starts_with("rank correlation")).unwrap();
    assert!(rho.rsplit(' ').next().unwrap().parse::<f64>().unwrap() > 0.95, "{output}");
    assert_eq!(fs::read_to_string(folder.path().join("predicted.csv")).unwrap().lines().count(), 121);
}

/// A prediction that is compared with ratings is that for the mean of the widths that people saw.
#[test]
fn the_window_is_as_wide_as_people_saw_it() {
    let folder = tempfile::tempdir().unwrap();
    succeeds(folder.path(), &split("simulate quick --participants 8 --seed 5"));
    for (subject, stimulus_deg) in [("S001", 4.0), ("S002", 5.0)] {
        let path = session_csv(&folder.path().join("results"), "quick", subject).with_extension("json");
        let mut sidecar = json(&path);
        let viewing = Geometry { stimulus_deg, ..Geometry::default() };
        sidecar["sittings"][0]["viewing"] = serde_json::to_value(viewing).unwrap();
        fs::write(&path, sidecar.to_string()).unwrap();
    }
    // A warning says that the sidecars were changed.
    let output = machband(folder.path(), &split("predict quick --fit results --out seen.csv"));
    assert!(output.status.success(), "{}", text(&output.stderr));
    let seen = fs::read_to_string(folder.path().join("seen.csv")).unwrap();
    let narrow = succeeds(folder.path(), &split("predict quick --window 4.5"));
    assert_eq!(column(&seen, "band_bright"), column(&narrow, "band_bright"));
}

#[test]
fn impossible_predictions_are_reported() {
    let folder = tempfile::tempdir().unwrap();
    // The same factors, but another stimulus.
    let gray = definition::BUILT_IN.iter().find(|one| one.name == "quick").unwrap().text.replace("yellow", "gray");
    fs::write(folder.path().join("gray.toml"), gray.replace("\"quick\"", "\"gray\"")).unwrap();
    succeeds(folder.path(), &split("simulate quick --participants 2"));
    let cases = r"
        2: gray.toml --fit results/quick => those of quick; expected those of gray
        2: --window 361 => --window: the image extends over 361
        2: --window 1e-6 => --window: 1.024e9 pixels per degree; expected a number above 0 and at most 2000000
        2: --ppd 1e9 => --ppd: 1e9 pixels per degree
        2: --kind kanizsa --size 5000 => too large
        1: bangay2003 --fit nowhere => nowhere
        1: --low 0 --high 0 --black 0 => mach-band:
        1: --criterion none.toml => none.toml";
    refuses(folder.path(), "predict {}", cases);
    succeeds(folder.path(), &split("predict --width 0.2 --window 359"));
}

/// What the table of a study's own pictures says is a level as it is written, and sessions know their pictures by hashes.
#[test]
fn own_pictures_have_levels_and_hashes() {
    let folder = tempfile::tempdir().unwrap();
    let run = |line: &str| succeeds(folder.path(), &split(line));
    fs::create_dir(folder.path().join("p")).unwrap();
    for name in ["a", "b", "c"] {
        run(&format!("stimulus --kind cornsweet --size 32 --out p/{name}.png"));
    }
    fs::write(folder.path().join("p/pictures.csv"), "file,code\na.png,007\nb.png,7\nc.png,7.0\n").unwrap();
    let definition = "schema = 1\nname = \"own\"\n[stimulus]\nkind = \"image\"\nfiles = \"p/*.png\"\n";
    fs::write(folder.path().join("own.toml"), definition).unwrap();
    assert_eq!(column(&run("predict own.toml"), "code"), ["007", "7", "7.0"]);
    run("simulate own.toml --participants 4 --results r");
    assert!(run("verify r").contains("4 sessions verified; no errors"));
    run("stimulus --kind cornsweet --size 64 --out p/a.png --force");
    let error = fails(folder.path(), &split("predict own.toml --fit r"), 2);
    assert!(error.contains("those of own in another version; expected those of own"), "{error}");
}
