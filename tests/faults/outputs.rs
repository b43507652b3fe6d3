//! Every file that a command leaves was synced, and so was its folder. Otherwise, a power failure soon afterward could
//! leave an empty file or no file.

use std::{
    collections::{BTreeSet, HashSet},
    ffi::OsStr,
    path::{Path, PathBuf},
};

use crate::{
    common::{command, everything, split, succeeds},
    shim::{self, Fault},
};

fn names<'a>(paths: impl Iterator<Item = &'a Path>) -> HashSet<String> {
    let names = paths.filter_map(Path::file_name).filter_map(OsStr::to_str);
    // A file is synced under its temporary name.
    names.map(|name| name.split(".machband-").next().unwrap_or(name).to_owned()).collect()
}

#[test]
fn every_output_is_synced() {
    if shim::library().is_none() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let root = folder.path().canonicalize().unwrap();
    let files = || everything(&root).into_iter().map(|(path, _)| path).collect::<BTreeSet<PathBuf>>();
    succeeds(&root, &split("simulate quick --participants 2 --results z"));
    let readings = "channel,level,luminance_cd_m2\ngray,0,0.3\ngray,0.25,5\ngray,0.5,22\ngray,0.75,50\ngray,1,90\n";
    std::fs::write(root.join("r.csv"), readings).unwrap();
    // The fault only logs each call.
    let noted = Fault { op: "sync", n: 1, what: "log", repeated: true };
    for (line, expected) in [
        ("counts z --out ROOT/counts/c.csv", 1),
        ("stimulus --size 8 --out ROOT/i/i.png --profile ROOT/p/p.csv", 2),
        ("stimuli quick --size 8 --out ROOT/stimuli", 25),
        ("shade --shader flat --size 8 --out ROOT/shade/s.png --creases ROOT/shade/c.png", 2),
        ("predict --size 16 --out ROOT/bands/v.csv", 1),
        ("plan quick --participants 2 --studies 1 --effect oblique=1 --out ROOT/plan/p.csv", 1),
        ("calibrate r.csv --out ROOT/left/p.toml --plot ROOT/left/p.svg --report ROOT/left/p.json", 3),
        ("analyze z --tables-only --draws 19 --out ROOT/analysis", 9),
        ("export z --format bids --out ROOT/bids", 30),
        ("export z --format psych-ds --out ROOT/psych-ds", 9),
    ] {
        let line = line.replace("ROOT", root.to_str().unwrap());
        for folder in ["counts", "i", "p", "shade", "bands", "plan", "left"] {
            std::fs::create_dir_all(root.join(folder)).unwrap();
        }
        let before = files();
        let log = folder.path().join("log");
        let (ended, log) =
            shim::run_with(&mut command(&root, &split(&line)), std::slice::from_ref(&noted), &root, &log);
        assert!(ended.status.success(), "{line}: {ended:?}");
        std::fs::remove_file(root.join("log")).unwrap();
        let synced = names(log.hits.iter().map(|hit| Path::new(&hit.path)));
        let made: Vec<PathBuf> = files().difference(&before).cloned().collect();
        assert!(made.len() >= expected, "{line}: {made:?}");
        for path in made.iter().map(PathBuf::as_path).chain(made.iter().filter_map(|path| path.parent())) {
            let is_synced = names(std::iter::once(path)).is_subset(&synced);
            assert!(is_synced, "{line}: {} was not synced, only {synced:?}", path.display());
        }
    }
}
