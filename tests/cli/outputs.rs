//! No command destroys a file: not one of its inputs, not a file of a session, and no other file without `--force`.

use std::{any::TypeId, collections::BTreeSet, fs};

use clap::{
    Arg, Command, ValueHint,
    error::{ContextKind, ContextValue, ErrorKind},
};
use machband::{
    cli,
    display::DisplayProfile,
    store::{StoreError, Writer, matches::MatchFile, profile, readings},
    work::{FittedPath, NewFolder, OutPath},
};

use crate::common::{
    attacks::{FILES, PANICS, ROWS, withstood},
    everything, fails, machband, split, succeeds, text,
};

fn is<T: 'static>(argument: &Arg) -> bool {
    argument.get_value_parser().type_id() == TypeId::of::<T>()
}

fn is_output(argument: &Arg) -> bool {
    is::<OutPath>(argument) || is::<NewFolder>(argument) || is::<FittedPath>(argument)
}

fn value_name(argument: &Arg) -> String {
    argument.get_value_names().unwrap_or_default().join(" ")
}

/// True if the values of an argument are paths, judged by the help alone.
fn is_path(argument: &Arg) -> bool {
    let name = value_name(argument);
    ["FILE", "DIR", "EXPERIMENT", "MESH"].iter().any(|part| name.contains(part))
        || name.contains(".csv")
        || name.contains(".toml")
}

/// The words of a command line that give an argument this value.
fn words(argument: &Arg, value: &str) -> Vec<String> {
    let option = argument.get_long().map(|long| format!("--{long}"));
    option.into_iter().chain(argument.get_action().takes_values().then(|| value.to_owned())).collect()
}

/// A valid value for an argument.
fn sample(argument: &Arg) -> String {
    let names = argument.get_possible_values();
    match names.first() {
        Some(name) => name.get_name().to_owned(),
        None if argument.get_value_hint() == ValueHint::DirPath || is::<NewFolder>(argument) => "new-folder".to_owned(),
        None if is_output(argument) => format!("new-{}", argument.get_id()),
        None if value_name(argument) == "EXPERIMENT" => "quick".to_owned(),
        None => "1".to_owned(),
    }
}

/// A command line with these arguments, completed with whatever else the command requires; `None` if they conflict.
fn line(command: &Command, given: &[(&Arg, &str)]) -> Option<Vec<String>> {
    let mut given: Vec<(&Arg, String)> =
        given.iter().map(|(argument, value)| (*argument, (*value).to_owned())).collect();
    loop {
        let (options, places): (Vec<_>, Vec<_>) = given.iter().partition(|(argument, _)| argument.get_long().is_some());
        // Options that take several values would take the positional ones too.
        let separator = (!places.is_empty()).then(|| "--".to_owned());
        let (start, end): (Vec<_>, Vec<_>) = (
            options.iter().flat_map(|(argument, value)| words(argument, value)).collect(),
            places.iter().flat_map(|(argument, value)| words(argument, value)).collect(),
        );
        let line: Vec<String> =
            [command.get_name().to_owned()].into_iter().chain(start).chain(separator).chain(end).collect();
        let parsed = cli::definition().try_get_matches_from([&["machband".to_owned()], &line[..]].concat());
        let Err(error) = parsed else { return Some(line) };
        match (error.kind(), error.get(ContextKind::InvalidArg)) {
            (ErrorKind::MissingRequiredArgument, Some(ContextValue::Strings(missing))) => {
                let plain = |shown: &str| shown.trim_matches(['<', '>', '[', ']']).to_owned();
                let is_missing =
                    |argument: &&Arg| missing.iter().any(|shown| plain(shown) == plain(&argument.to_string()));
                let more: Vec<_> = command.get_arguments().filter(is_missing).map(|arg| (arg, sample(arg))).collect();
                assert!(!more.is_empty(), "{line:?}: {error}");
                given.extend(more);
            }
            (ErrorKind::ArgumentConflict, _) => return None,
            _ => panic!("{line:?}: {error}"),
        }
    }
}

/// Every command, with `--help` and the version left out.
fn commands() -> Vec<Command> {
    let mut definition = cli::definition();
    definition.build();
    definition.get_subcommands().filter(|command| command.get_name() != "help").cloned().collect()
}

/// Every command with each of its inputs as each of its outputs: refused before any work, and nothing changes.
#[test]
fn no_command_writes_over_its_inputs() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    fs::create_dir_all(at("folder/sub")).unwrap();
    // No command can read this, so any success or other error would show that work began.
    fs::write(at("file"), "content").unwrap();
    fs::write(at("folder/a.csv"), "content").unwrap();
    let mut ways = vec!["", "./", "folder/../", "folder/sub/../../"];
    #[cfg(unix)]
    {
        fs::hard_link(at("file"), at("hard-file")).unwrap();
        std::os::unix::fs::symlink("file", at("link-file")).unwrap();
        std::os::unix::fs::symlink("folder", at("link-folder")).unwrap();
        ways.extend(["hard-", "link-"]);
    }
    let before = everything(folder.path());
    let (mut pairs, mut together, mut runs) = (BTreeSet::new(), BTreeSet::new(), 0);
    for command in commands() {
        let named = |name: &str| command.get_arguments().find(|argument| argument.get_id() == name);
        let paths: Vec<&Arg> = command.get_arguments().filter(|arg| is_path(arg)).collect();
        let outputs = paths.iter().filter(|argument| is_output(argument));
        let all = outputs.flat_map(|output| paths.iter().map(|other| (*output, *other)));
        for (output, other) in all.filter(|(output, other)| output.get_id() != other.get_id()) {
            let is_written = is_output(other) && !is::<FittedPath>(other);
            let is_folder = output.get_value_hint() == ValueHint::DirPath || is::<NewFolder>(output);
            let (name, expected) = match (is_folder, value_name(other).contains("DIR")) {
                (true, true) => ("folder", "is an input of this command"),
                (true, false) => ("file", "is not a folder"),
                (false, _) if is_written => ("file", "is another output of this command"),
                (false, _) => ("file", "is an input of this command"),
            };
            for way in &ways {
                let path = format!("{way}{name}");
                // Two hard links are replaced independently, so both outputs exist afterward.
                let are_both_written = *way == "hard-" && is_written;
                if are_both_written || !folder.path().join(&path).exists() {
                    continue;
                }
                let mut given = vec![(other, name), (output, &path)];
                // Without `--fit`, the file is read.
                let fit = named("fit").filter(|fit| is::<FittedPath>(output) && fit.get_id() != other.get_id());
                given.extend(fit.map(|fit| (fit, "1")));
                let Some(mut line) = line(&command, &given) else { continue };
                // Even `--force` does not allow it.
                line.splice(1..1, named("force").map(|_| "--force".to_owned()));
                let error = fails(folder.path(), &line, 2);
                runs += 1;
                assert!(error.contains(expected), "{line:?}: {error}");
                assert!(everything(folder.path()) == before, "{line:?} changed something");
                let list = if is_written { &mut together } else { &mut pairs };
                list.insert(format!("{} {} {}", command.get_name(), other.get_id(), output.get_id()));
            }
        }
    }
    for known in [
        "counts paths out",
        "predict experiment out",
        "compare picture map",
        "plan experiment out",
        "calibrate readings out",
    ] {
        assert!(pairs.contains(known), "{known} is not in {pairs:?}");
    }
    assert!(pairs.len() >= 34 && together.len() >= 9, "{pairs:?} {together:?}");
    withstood("an input or another output as an output", runs, &[FILES, PANICS]);
}

/// A mistyped `--out` cannot destroy a session, with or without `--force`, and with or without a link.
#[test]
fn no_command_writes_over_a_session() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    succeeds(folder.path(), &split("simulate quick --results z"));
    let stem = "z/quick/data/subject-S001_session-1_task-quick";
    // Also a session that was copied elsewhere.
    fs::create_dir(at("copy")).unwrap();
    for end in ["_data.csv", "_data.json"] {
        fs::copy(at(&format!("{stem}{end}")), at(&format!("copy/s{end}"))).unwrap();
    }
    // Rows whose sidecar is lost.
    fs::copy(at(&format!("{stem}_data.csv")), at("copy/subject-S1_session-1_task-q_data.csv")).unwrap();
    #[cfg(unix)]
    std::os::unix::fs::symlink(at(&format!("{stem}_data.csv")), at("link.csv")).unwrap();
    let before = everything(folder.path());
    let mut runs = 0;
    for (out, expected) in [
        (format!("{stem}_data.csv"), "is inside the data folder"),
        (format!("{stem}_data.json"), "is inside the data folder"),
        (format!("{stem}_frames.csv"), "is inside the data folder"),
        ("z/quick/data/new.csv".to_owned(), "is inside the data folder"),
        ("z/quick/data/../data/new.csv".to_owned(), "is inside the data folder"),
        ("z/quick/dataset_description.json".to_owned(), "belongs to the data set"),
        ("z/quick/README.md".to_owned(), "belongs to the data set"),
        ("copy/s_data.csv".to_owned(), "belongs to the session of"),
        ("copy/s_data.json".to_owned(), "belongs to the session of"),
        ("copy/s_frames.csv".to_owned(), "belongs to the session of"),
        ("copy/subject-S1_session-1_task-q_data.csv".to_owned(), "belongs to the session of"),
        #[cfg(unix)]
        ("link.csv".to_owned(), "is inside the data folder"),
    ] {
        for command in
            ["counts z --out", "stimulus --size 8 --out", "stimulus --size 8 --profile", "predict --size 16 --out"]
        {
            for force in ["", " --force"] {
                let error = fails(folder.path(), &split(&format!("{command} {out}{force}")), 2);
                assert!(error.starts_with("error: ") && error.contains(expected), "{command} {out}: {error}");
                runs += 1;
            }
        }
    }
    for command in ["analyze z --tables-only", "stimuli quick --size 8"] {
        let error = fails(folder.path(), &split(&format!("{command} --out z/quick/data --force")), 2);
        assert!(error.contains("is inside the data folder"), "{error}");
    }
    for (out, expected) in
        [("z/quick/data/bids", "is inside the data folder"), ("z/bids", "is inside z"), ("copy", "is not empty")]
    {
        let error = fails(folder.path(), &["export", "z", "--format", "bids", "--out", out], 2);
        assert!(error.contains(expected), "{error}");
    }
    // The files that the window writes on its other pages.
    let data = at("z/quick/data");
    for force in [false, true] {
        let writer = Writer::new([], force);
        for done in [
            profile::write(&writer, &data.join("p.toml"), &DisplayProfile::default()),
            readings::write(&writer, &data.join("r.csv"), &[]),
            MatchFile::begin(&data.join("m.csv"), 1).map(drop),
            writer.write_all(&[(at("new.csv"), b"1".to_vec()), (data.join("i.csv"), b"2".to_vec())]),
        ] {
            assert!(matches!(done, Err(StoreError::Protected { .. })), "{done:?}");
            runs += 1;
        }
    }
    assert!(everything(folder.path()) == before);
    withstood("a file of a session as an output", runs, &[ROWS, FILES, PANICS]);
}

/// Other files are replaced only with `--force`; folders, devices and missing folders are refused.
#[test]
fn existing_files_are_replaced_only_with_force() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    succeeds(folder.path(), &split("simulate quick --participants 2 --results z"));
    fs::write(
        at("r.csv"),
        "channel,level,luminance_cd_m2\ngray,0,0.3\ngray,0.25,5\ngray,0.5,22\ngray,0.75,50\ngray,1,90\n",
    )
    .unwrap();
    for (line, outputs) in [
        ("counts z --out o", &["o"][..]),
        ("stimulus --size 8 --out o --profile p", &["o", "p"]),
        ("predict --size 16 --out o", &["o"]),
        ("predict quick --size 64 --fit z --criterion o", &["o"]),
        ("calibrate r.csv --out o", &["o"]),
    ] {
        let run = |force: &str| machband(folder.path(), &split(&format!("{line}{force}")));
        for output in outputs {
            fs::write(at(output), "precious").unwrap();
            let before = everything(folder.path());
            let error = text(&run("").stderr);
            assert_eq!(
                error,
                format!("error: {output}: already exists; expected a new file, or the option --force\n"),
                "{line}"
            );
            assert!(everything(folder.path()) == before, "{line}");
            fs::remove_file(at(output)).unwrap();
        }
        assert!(run("").status.success(), "{line}: {}", text(&run("").stderr));
        outputs.iter().for_each(|output| fs::write(at(output), "old").unwrap());
        assert!(run(" --force").status.success(), "{line}");
        outputs.iter().for_each(|output| assert_ne!(fs::read(at(output)).unwrap(), b"old", "{line}"));
        outputs.iter().for_each(|output| fs::remove_file(at(output)).unwrap());
    }
    succeeds(folder.path(), &split("analyze z --tables-only --draws 99 --out a"));
    // The files of an input folder are inputs.
    fs::create_dir(at("plain")).unwrap();
    fs::copy(at("a/counts.csv"), at("plain/c.csv")).unwrap();
    let before = everything(folder.path());
    let error = fails(folder.path(), &split("counts plain --out plain/c.csv --force"), 2);
    assert!(error.contains("is an input"), "{error}");
    for (out, status, expected) in [
        ("plain", 2, "is not a regular file"),
        ("missing/o.csv", 1, "cannot write"),
        ("missing/../o.csv", 1, "cannot write"),
        #[cfg(unix)]
        ("/dev/null", 2, "is not a regular file"),
        #[cfg(unix)]
        ("/dev/stdout", 2, "is not a regular file"),
    ] {
        let error = fails(folder.path(), &split(&format!("counts z --out {out} --force")), status);
        assert!(error.starts_with(&format!("error: {out}: {expected}")), "{error}");
    }
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink("nothing", at("dangling")).unwrap();
        assert!(fails(folder.path(), &split("counts z --out dangling --force"), 2).contains("is not a regular file"));
        fs::remove_file(at("dangling")).unwrap();
    }
    assert!(everything(folder.path()) == before);
    // A link to another file stays a link; the file is replaced.
    #[cfg(unix)]
    {
        fs::write(at("target"), "old").unwrap();
        std::os::unix::fs::symlink("target", at("link")).unwrap();
        fails(folder.path(), &split("counts z --out link"), 2);
        succeeds(folder.path(), &split("counts z --out link --force"));
        assert!(at("link").is_symlink() && fs::read(at("target")).unwrap().starts_with(b"subject_id,"));
    }
}

/// What a killed command left is removed by the next one that writes the same, and nothing else is.
#[test]
#[cfg(unix)]
fn what_killed_commands_left_is_removed_by_the_next_one() {
    const DAY: u64 = 24 * 60 * 60;
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let left = |name: &str, age_s: u64| {
        let path = at(&format!("{name}.machband-Ab12Cd34Ef56Gh78.tmp"));
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        if name.starts_with('.') {
            fs::create_dir_all(path.join("inside")).unwrap();
        } else {
            fs::write(&path, "left").unwrap();
        }
        let then = std::time::SystemTime::now() - std::time::Duration::from_secs(age_s);
        fs::File::open(&path).unwrap().set_modified(then).unwrap();
        path
    };
    succeeds(folder.path(), &split("simulate quick --participants 2 --results z"));
    for (line, name, old_s) in [
        ("counts z --out o", "o", 120),
        ("analyze z --tables-only --draws 99 --out a", "a/cells.csv", 120),
        ("stimuli quick --size 8 --out s", "s/manifest.csv", 120),
        ("export z --format bids --out b", ".b", 2 * DAY),
    ] {
        let (ours, others) = (left(name, old_s), left(&format!("{name}.other"), old_s));
        succeeds(folder.path(), &split(line));
        assert!(!ours.exists(), "{line}");
        assert!(others.exists() || name == "s/manifest.csv", "{line}");
        fs::remove_file(at(name)).or_else(|_| fs::remove_dir_all(at("b"))).unwrap();
        // A newer one may be in use.
        let newer = left(name, 1);
        succeeds(folder.path(), &split(&format!("{line}{}", if name == "a/cells.csv" { " --force" } else { "" })));
        assert!(newer.exists(), "{line}");
    }
}
