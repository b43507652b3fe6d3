//! The commands as a user's script sees them: the real program, its files, its exit status.

use std::{
    collections::HashSet,
    fs,
    path::{Path, PathBuf},
    process::Stdio,
    time::{Duration, Instant},
};

use machband::{
    experiment::{Protocol, session_seed},
    light::{Bits, Quantizer, Transfer},
    store::definition,
};

use crate::common::{command, everything, fails, machband, rows, session_csv, succeeds, text};

fn csv(folder: &Path, protocol: &Protocol, number: usize) -> PathBuf {
    session_csv(folder, &protocol.name, &format!("S{number:03}"))
}

/// What must be the same however often a simulation was interrupted.
fn ratings(folder: &Path, protocol: &Protocol, participants: usize) -> Vec<(String, u8, String)> {
    let all = (1..=participants).flat_map(|number| rows(&csv(folder, protocol, number), protocol));
    all.map(|row| (row.row_id, row.rating.0, format!("{:?} {:?} {:?}", row.width, row.depth, row.response_time_s)))
        .collect()
}

mod simulate {
    use super::*;

    #[test]
    fn eight_participants_are_the_same_each_time() {
        let folder = tempfile::tempdir().unwrap();
        let protocol = definition::open("bangay2003").unwrap();
        for results in ["a", "b"] {
            let said = succeeds(
                folder.path(),
                &["simulate", "bangay2003", "--participants", "8", "--seed", "1", "--results", results],
            );
            assert!(said.contains("8 sessions") && said.contains("2016 rows"), "{said}");
        }
        let names = |results: &str| -> Vec<PathBuf> {
            let root = folder.path().join(results);
            everything(&root).into_iter().map(|(path, _)| path.strip_prefix(&root).unwrap().to_owned()).collect()
        };
        assert_eq!(names("a").len(), 8 * 2 + 5);
        assert_eq!(names("a"), names("b"));
        let mut orders = HashSet::new();
        for number in 1..=8 {
            let [a, b] = ["a", "b"]
                .map(|results| fs::read_to_string(csv(&folder.path().join(results), &protocol, number)).unwrap());
            assert_eq!(a.lines().count(), 1 + 6 * 5 * 4 * 2 + 12);
            let started = a.lines().next().unwrap().split(',').position(|name| name == "started_at").unwrap();
            for (a, b) in a.lines().zip(b.lines()) {
                let without = |line: &str| {
                    line.split(',')
                        .enumerate()
                        .filter(|(i, _)| *i != started)
                        .map(|(_, cell)| cell.to_owned())
                        .collect::<Vec<_>>()
                };
                assert_eq!(without(a), without(b));
            }
            assert_eq!(a.lines().count(), b.lines().count());
            let rows = rows(&csv(&folder.path().join("a"), &protocol, number), &protocol);
            orders.insert(
                rows.iter()
                    .map(|row| format!("{:?}{:?}{:?}", row.width, row.depth, row.orientation_deg))
                    .collect::<String>(),
            );
            let said = succeeds(folder.path(), &["check", csv(Path::new("a"), &protocol, number).to_str().unwrap()]);
            assert!(said.contains("252 rows; 252 of 252 planned trials"), "{said}");
        }
        assert_eq!(orders.len(), 8, "each participant has an order of their own");
    }

    #[test]
    fn nothing_is_written_over_and_a_complete_run_stays() {
        let folder = tempfile::tempdir().unwrap();
        let simulate = ["simulate", "quick", "--participants", "3", "--results", "r"];
        succeeds(folder.path(), &simulate);
        let before = everything(folder.path());
        let said = fails(folder.path(), &simulate, 1);
        assert!(said.contains("_data.csv") && said.contains("--resume"), "{said}");
        assert!(everything(folder.path()) == before);
        succeeds(folder.path(), &[&simulate[..], &["--resume"]].concat());
        assert!(everything(folder.path()) == before, "a resumed run that was complete changed something");
        let said = fails(folder.path(), &[&simulate[..], &["--resume", "--seed", "2"]].concat(), 1);
        assert!(said.contains("has seed 1; expected that or none, not 2"), "{said}");
        fs::write(folder.path().join("quick.toml"), definition::BUILT_IN[0].text.replace("0.02", "0.03")).unwrap();
        let said =
            fails(folder.path(), &["simulate", "quick.toml", "--participants", "3", "--results", "r", "--resume"], 1);
        assert!(said.contains("another definition"), "{said}");
        fs::remove_file(folder.path().join("quick.toml")).unwrap();
        assert!(everything(folder.path()) == before);
    }

    #[test]
    fn two_runs_into_one_folder_do_not_meet() {
        let folder = tempfile::tempdir().unwrap();
        let protocol = definition::open("quick").unwrap();
        let simulate = ["simulate", "quick", "--participants", "40", "--results", "r"];
        for round in 0..3 {
            let resume = [&simulate[..], &["--resume"]].concat();
            let runs = [if round == 0 { &simulate[..] } else { &resume[..] }, &resume[..]];
            let children = runs
                .map(|run| command(folder.path(), run).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap());
            for child in children {
                let output = child.wait_with_output().unwrap();
                let said = text(&output.stderr);
                let known = said.is_empty()
                    || said.contains("another machband is writing")
                    || said.contains("already have a file");
                assert!(matches!(output.status.code(), Some(0 | 1)) && known, "{said}");
            }
        }
        succeeds(folder.path(), &[&simulate[..], &["--resume"]].concat());
        for number in 1..=40 {
            assert_eq!(rows(&csv(&folder.path().join("r"), &protocol, number), &protocol).len(), 28, "S{number:03}");
        }
        succeeds(folder.path(), &["simulate", "quick", "--participants", "40", "--results", "alone"]);
        assert_eq!(
            ratings(&folder.path().join("r"), &protocol, 40),
            ratings(&folder.path().join("alone"), &protocol, 40)
        );
        for (path, _) in everything(folder.path()) {
            let described = path.file_name().unwrap().to_str().unwrap().starts_with(".psychds");
            let known = matches!(path.extension().and_then(|e| e.to_str()), Some("csv" | "json" | "md"));
            assert!(known || described, "{path:?} was left");
        }
    }

    /// The heart of it: a program that is killed at any moment has lost nothing that was rated.
    #[test]
    fn killed_at_fifty_moments_and_resumed_it_is_as_if_it_had_not_been() {
        const PARTICIPANTS: usize = 20;
        let folder = tempfile::tempdir().unwrap();
        let protocol = definition::open("bangay2003").unwrap();
        let run = |results: &str| {
            ["simulate", "bangay2003", "--participants", "20", "--results", results, "--resume"].map(str::to_owned)
        };
        let spawn = |results: &str| {
            let arguments = run(results);
            let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
            command(folder.path(), &arguments).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap()
        };
        let started = Instant::now();
        assert!(spawn("whole").wait().unwrap().success());
        let whole = started.elapsed();
        let expected = ratings(&folder.path().join("whole"), &protocol, PARTICIPANTS);
        assert_eq!(expected.len(), PARTICIPANTS * 252);
        let (mut kills, mut rounds, mut mid_run) = (0_u64, 0, 0);
        while kills < 50 {
            rounds += 1;
            let results = format!("killed{rounds}");
            let rated = || -> usize {
                let files =
                    fs::read_dir(folder.path().join(&results).join("bangay2003/data")).into_iter().flatten().flatten();
                let csv = files.filter(|file| file.path().extension().is_some_and(|e| e == "csv"));
                csv.map(|file| {
                    fs::read(file.path()).unwrap().iter().filter(|byte| **byte == b'\n').count().saturating_sub(1)
                })
                .sum()
            };
            loop {
                // From the first instructions of the program to most of a whole run.
                let share = session_seed(kills * 1000 + rounds) as f64 / 2_f64.powi(32);
                let delay =
                    if kills % 5 == 0 { Duration::from_secs_f64(share * 0.02) } else { whole.mul_f64(0.8 * share) };
                let before = rated();
                let mut child = spawn(&results);
                std::thread::sleep(delay);
                if kills < 50 && child.try_wait().unwrap().is_none() {
                    child.kill().unwrap();
                    child.wait().unwrap();
                    kills += 1;
                    let after = rated();
                    assert!(after >= before, "{after} rows after {before}");
                    mid_run += u32::from(after > before && after < expected.len());
                } else if child.wait().unwrap().success() {
                    break;
                } else {
                    panic!(
                        "{results} cannot be resumed: {}",
                        text(
                            &command(folder.path(), &run(&results).iter().map(String::as_str).collect::<Vec<_>>())
                                .output()
                                .unwrap()
                                .stderr
                        )
                    );
                }
            }
            let found = ratings(&folder.path().join(&results), &protocol, PARTICIPANTS);
            assert!(found == expected, "{results}: {} rows, not {}", found.len(), expected.len());
            let data = folder.path().join(&results).join("bangay2003/data");
            assert_eq!(everything(&data).len(), 2 * PARTICIPANTS, "{results}: rows and sidecars, nothing half written");
            for number in 1..=PARTICIPANTS {
                let path = csv(&folder.path().join(&results), &protocol, number);
                let said = succeeds(folder.path(), &["check", path.to_str().unwrap()]);
                assert!(said.contains("252 of 252"), "{said}");
            }
        }
        assert!(mid_run >= 10, "only {mid_run} of {kills} kills came while rows were written");
        eprintln!("{kills} kills, {mid_run} while rows were written, {rounds} rounds; a whole run takes {whole:?}");
    }
}

mod usage {
    use super::*;

    #[test]
    fn wrong_usage_is_told_and_nothing_else_happens() {
        let folder = tempfile::tempdir().unwrap();
        let cases: &[(&[&str], &str)] = &[
            (&["--nonsense"], "--nonsense"),
            (&["simulte"], "simulte"),
            (&["run"], "EXPERIMENT"),
            (&["run", "quick", "--participant", "../../x"], "'.'"),
            (&["run", "quick", "--participant", "a,b"], "','"),
            (&["run", "quick", "--participant", ""], "is empty"),
            (&["run", "quick", "--participant", "Zoë"], "'ë'"),
            (&["run", "quick", "--participant", "S001", "--session", "1 2"], "' '"),
            (&["run", "quick", "--resume"], "--participant"),
            (&["run", "quick", "--seed", "-1"], "-1"),
            (&["simulate", "quick", "--participants", "0"], "0"),
            (&["simulate", "quick", "--participants", "many"], "many"),
            (&["simulate", "quick", "--seed", "1.5"], "1.5"),
            (&["simulate", "quick", "--observer", "nobody"], "nobody"),
            (&["simulate", "quick", "--observer", "random", "--observer-file", "x.toml"], "--observer-file"),
            (&["check"], "FILE"),
            (&["check", ""], "empty"),
            (&["stimulus"], "--out"),
            (&["stimulus", "--out", "x.png", "--width", "1.5"], "width 1.5"),
            (&["stimulus", "--out", "x.png", "--depth", "0"], "depth 0"),
            (&["stimulus", "--out", "x.png", "--depth", "33"], "depth 33"),
            (&["stimulus", "--out", "x.png", "--orientation", "nan"], "orientation"),
            (&["stimulus", "--out", "x.png", "--low", "-0.1"], "low -0.1"),
            (&["stimulus", "--out", "x.png", "--low", "0.9"], "below low"),
            (&["stimulus", "--out", "x.png", "--color", "1,1"], "color"),
            (&["stimulus", "--out", "x.png", "--size", "0"], "0"),
            (&["stimulus", "--out", "x.png", "--size", "99999999"], "99999999"),
            (&["stimulus", "--out", "x.png", "--transfer", "gamma:0"], "gamma 0 is outside"),
            (&["stimulus", "--out", "x.png", "--transfer", "srgb", "--display", "p.toml"], "--display"),
            (&["stimulus", "--out", "x.png", "--bits", "12"], "12"),
            (&["stimulus", "--out", "x.png", "--kind", "moire"], "moire"),
        ];
        for (arguments, part) in cases {
            let said = fails(folder.path(), arguments, 2);
            assert!(said.contains(part), "{arguments:?}: {said}");
        }
        assert_eq!(everything(folder.path()), []);
    }

    #[test]
    fn what_cannot_be_done_is_told_with_its_place() {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("file"), "").unwrap();
        fs::write(
            folder.path().join("bad.toml"),
            "schema = 1\nname = \"a\"\nstimulus.kind = \"mach-band\"\nfactors.width = [1.5]\n",
        )
        .unwrap();
        let cases: &[(&[&str], &str)] = &[
            (&["simulate", "quick", "--results", "file"], "error: file/quick/data: cannot make the folder"),
            (&["simulate", "quik"], "error: quik: is neither a built-in definition nor a file"),
            (&["simulate", "none.toml"], "error: none.toml: cannot be opened"),
            (&["simulate", "bad.toml"], "error: bad.toml:4:18: width 1.5"),
            (&["simulate", "quick", "--observer-file", "bad.toml"], "error: bad.toml:2:1: unknown key"),
            (&["stimulus", "--size", "8", "--out", "none/x.png"], "error: none/x.png: cannot "),
            (&["stimulus", "--size", "8", "--profile", "file/x.csv"], "error: file/x.csv: cannot "),
            (
                &["stimulus", "--size", "8", "--out", "x.png", "--display", "none.toml"],
                "error: none.toml: cannot be opened",
            ),
            (&["run", "quick", "--participant", "S001", "--resume"], "no such session"),
            (&["run", "bad.toml"], "error: bad.toml:4:18: width 1.5"),
        ];
        for (arguments, start) in cases {
            let said = fails(folder.path(), arguments, 1);
            assert!(said.contains(start), "{arguments:?}: {said}");
            assert!(said.matches("os error").count() <= 1, "{arguments:?} says its cause twice: {said}");
        }
        assert_eq!(everything(folder.path()).len(), 2, "nothing was made");
    }

    #[test]
    fn check_says_every_fault_of_every_file() {
        let folder = tempfile::tempdir().unwrap();
        let write = |name: &str, content: &str| fs::write(folder.path().join(name), content).unwrap();
        write(
            "bad.toml",
            "schema = 1\nname = \"Bad\"\n[stimulus]\nkind = \"mach-band\"\n[factors]\nwidth = [1.5, 2]\n[desing]\n",
        );
        write("good.toml", definition::BUILT_IN[0].text);
        write("screen.toml", "schema = 1\nname = \"TV\"\ntransfer = \"gama:2\"\n");
        write("rows.csv", "row_id,experiment\nx\n");
        succeeds(folder.path(), &["simulate", "quick", "--results", "r"]);
        let path = csv(&folder.path().join("r"), &definition::open("quick").unwrap(), 1);
        let rows = fs::read_to_string(&path).unwrap();
        let mut lines: Vec<String> = rows.lines().map(str::to_owned).collect();
        lines[3] = lines[2].clone();
        lines[5] = lines[5].replacen(",yellow,", ",yellow,9", 1);
        write("twice.csv", &(lines.join("\n") + "\n"));
        fs::copy(path.with_extension("json"), folder.path().join("twice.json")).unwrap();
        let good = path.to_str().unwrap();
        let output = machband(
            folder.path(),
            &["check", "bad.toml", "good.toml", "quick", "screen.toml", "rows.csv", "twice.csv", good, "none.csv", "r"],
        );
        assert_eq!(output.status.code(), Some(1));
        let (said, good_ones) = (text(&output.stderr), text(&output.stdout));
        for start in [
            "bad.toml:2:1: ",
            "bad.toml:6:10: ",
            "bad.toml:6:15: ",
            "bad.toml:7:2: ",
            "screen.toml:3:1: ",
            "rows.csv:1:",
            "rows.csv:2:1: ",
            "twice.csv:6:",
            "none.csv: ",
            "r: ",
        ] {
            assert_eq!(
                said.lines().filter(|line| line.starts_with(&format!("error: {start}"))).count(),
                1,
                "{start}: {said}"
            );
        }
        assert!(said.lines().all(|line| line.starts_with("error: ")), "{said}");
        assert_eq!(good_ones.lines().count(), 3, "{good_ones}");
        // Without the unreadable cell, the row that stands twice is found; its trial is missing then.
        lines[5] = lines[5].replacen(",yellow,9", ",yellow,", 1);
        write("twice.csv", &(lines.join("\n") + "\n"));
        let said = fails(folder.path(), &["check", "twice.csv"], 1);
        assert!(said.contains("twice.csv:4:1: row_id S001_1_practice_0002_1 is already in line 3"), "{said}");
        // A large file of nothing is not repeated in its message.
        fs::File::create(folder.path().join("large.csv")).unwrap().set_len(100 << 20).unwrap();
        let said = fails(folder.path(), &["check", "large.csv"], 1);
        assert!(said.len() < 1000, "{} bytes", said.len());
    }

    #[test]
    fn every_command_has_help_with_an_example() {
        let folder = tempfile::tempdir().unwrap();
        for command in [
            &["--help"][..],
            &["run", "--help"],
            &["simulate", "--help"],
            &["check", "--help"],
            &["stimulus", "--help"],
            &["stimuli", "--help"],
        ] {
            let said = succeeds(folder.path(), command);
            let example = said
                .lines()
                .rev()
                .find_map(|line| {
                    line.strip_prefix("Example").and_then(|rest| rest.split_once("machband ")).map(|found| found.1)
                })
                .unwrap_or_else(|| panic!("{said}"));
            assert!(command.len() == 1 || example.starts_with(command[0]), "{example}");
        }
        assert!(succeeds(folder.path(), &["--version"]).starts_with("machband "));
    }

    /// Nobody listens any more, as after `| head -1`: all is well. No room for the data is a failure in words.
    #[test]
    fn a_closed_pipe_or_a_full_disk_is_no_panic() {
        let folder = tempfile::tempdir().unwrap();
        for arguments in [&["check", "quick", "orientation"][..], &["simulate", "quick", "--resume"]] {
            let (reader, writer) = std::io::pipe().unwrap();
            drop(reader);
            let output = command(folder.path(), arguments).stdout(writer).output().unwrap();
            assert_eq!((output.status.code(), text(&output.stderr).as_str()), (Some(0), ""));
            let Ok(full) = fs::OpenOptions::new().write(true).open("/dev/full") else {
                eprintln!("SKIPPED: a full disk behind standard output; there is no /dev/full here");
                continue;
            };
            let output = command(folder.path(), arguments).stdout(full).output().unwrap();
            assert_eq!(output.status.code(), Some(1));
            assert!(
                text(&output.stderr).starts_with("error: standard output: cannot write"),
                "{}",
                text(&output.stderr)
            );
        }
    }
}

mod stimulus {
    use super::*;

    fn pixels(path: &Path) -> (png::Info<'static>, Vec<u8>) {
        let mut reader = png::Decoder::new(std::io::BufReader::new(fs::File::open(path).unwrap())).read_info().unwrap();
        let mut data = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut data).unwrap();
        (reader.info().clone(), data)
    }

    /// sRGB codes of the plateaus, from IEC 61966-2-1 by hand: ¼ → 0.537099 · 255 = 136.96, ¾ → 0.880825 · 255 = 224.61.
    #[test]
    fn the_image_has_the_plateaus_and_the_profile_agrees() {
        let folder = tempfile::tempdir().unwrap();
        for (bits, dark, bright) in [("8", 137_u16, 225_u16), ("16", 35199, 57725)] {
            let arguments = ["stimulus", "--size", "100", "--bits", bits, "--out", "a.png", "--profile", "a.csv"];
            assert_eq!(succeeds(folder.path(), &arguments), "wrote a.png\nwrote a.csv\n");
            let (info, data) = pixels(&folder.path().join("a.png"));
            assert_eq!((info.width, info.height, info.color_type), (100, 100, png::ColorType::Rgb));
            assert!(info.srgb.is_some(), "the file says what its codes mean");
            let sample = |x: usize, y: usize, channel: usize| {
                let at = (y * 100 + x) * 3 + channel;
                if bits == "8" { u16::from(data[at]) } else { u16::from_be_bytes([data[2 * at], data[2 * at + 1]]) }
            };
            let mut reader = csv::Reader::from_path(folder.path().join("a.csv")).unwrap();
            assert_eq!(
                reader.headers().unwrap().iter().collect::<Vec<_>>(),
                ["x", "linear", "code_r", "code_g", "code_b", "emitted"]
            );
            let rows: Vec<Vec<f64>> =
                reader.records().map(|row| row.unwrap().iter().map(|cell| cell.parse().unwrap()).collect()).collect();
            assert_eq!(rows.len(), 100);
            let scale = if bits == "8" { 255.0 } else { 65535.0 };
            for (x, row) in rows.iter().enumerate() {
                for y in [0, 50, 99] {
                    let codes = [0, 1, 2].map(|channel| f64::from(sample(x, y, channel)));
                    assert_eq!(codes, [row[2], row[3], row[4]], "column {x}");
                }
                assert!((row[0] - (x as f64 + 0.5 - 50.0) / 100.0).abs() < 1e-12);
                // IEC 61966-2-1, decoding.
                let v = row[2] / scale;
                let light = if v <= 0.04045 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) };
                assert!((row[5] - light).abs() < 1e-6, "column {x}: {} is not {light}", row[5]);
                // A linear ramp over 0.4 of the window.
                let asked = 0.25 + 0.5 * (row[0] / 0.4 + 0.5).clamp(0.0, 1.0);
                assert!((row[1] - asked).abs() < 1e-6 && (row[5] - asked).abs() < 2.3 / scale, "column {x}");
            }
            let ends = [(sample(0, 0, 0), sample(0, 0, 2)), (sample(99, 99, 1), sample(99, 99, 2))];
            assert_eq!(ends, [(dark, 0), (bright, 0)]);
        }
        // Upwards, and light that goes to all channels; a display whose codes are light itself.
        succeeds(
            folder.path(),
            &[
                "stimulus",
                "--size",
                "9",
                "--orientation",
                "90",
                "--color",
                "gray",
                "--transfer",
                "linear",
                "--out",
                "b.png",
            ],
        );
        let (_, data) = pixels(&folder.path().join("b.png"));
        let quantizer = Quantizer::new(&Transfer::Linear, Bits::Eight);
        assert_eq!(data[..3], [191; 3], "bright at the top");
        assert_eq!(data[data.len() - 3..], [64; 3]);
        assert_eq!(u16::from(data[0]), quantizer.channel(0).code(0.75));
        let again = fs::read(folder.path().join("b.png")).unwrap();
        succeeds(
            folder.path(),
            &[
                "stimulus",
                "--size",
                "9",
                "--orientation",
                "450",
                "--color",
                "1,1,1",
                "--transfer",
                "gamma:1",
                "--out",
                "c.png",
            ],
        );
        assert_eq!(pixels(&folder.path().join("c.png")).1, data);
        succeeds(
            folder.path(),
            &[
                "stimulus",
                "--size",
                "9",
                "--orientation",
                "90",
                "--color",
                "gray",
                "--transfer",
                "linear",
                "--out",
                "b.png",
            ],
        );
        assert_eq!(fs::read(folder.path().join("b.png")).unwrap(), again, "equal inputs, equal bytes");
    }
}

mod profiles {
    use super::*;

    fn profile(measured: &str) -> String {
        format!("schema = 1\nname = \"left\"\ntransfer = \"gamma:2.2\"\n{measured}")
    }

    /// Each command that takes a profile, in a folder with `p.toml`.
    const COMMANDS: [&[&str]; 4] = [
        &["check", "p.toml"],
        &["stimulus", "--size", "8", "--out", "x.png", "--display", "p.toml"],
        &["stimuli", "quick", "--size", "8", "--out", "many", "--display", "p.toml"],
        &["shade", "--shader", "gouraud", "--size", "8", "--out", "cube.png", "--display", "p.toml"],
    ];

    #[test]
    fn a_doubtful_one_is_warned_of_once_and_used() {
        for (day, expected) in [("2020-02-29", "days ago; after 30 days"), ("2999-01-01", "is in the future")] {
            let folder = tempfile::tempdir().unwrap();
            fs::write(folder.path().join("p.toml"), profile(&format!("[measured]\non = \"{day}\"\n"))).unwrap();
            for arguments in COMMANDS {
                let output = machband(folder.path(), arguments);
                let warned = text(&output.stderr);
                assert_eq!(output.status.code(), Some(0), "{arguments:?}: {warned}");
                assert_eq!(warned.lines().count(), 1, "{arguments:?}: {warned}");
                assert!(warned.starts_with("warning: p.toml: The "), "{arguments:?}: {warned}");
                assert!(warned.contains(expected), "{arguments:?}: {warned}");
            }
            assert!(folder.path().join("x.png").exists() && folder.path().join("many/manifest.csv").exists());
        }
    }

    #[test]
    fn one_of_today_and_an_assumption_are_not() {
        let today = jiff::tz::TimeZone::UTC.to_datetime(jiff::Timestamp::now()).date();
        for measured in [format!("[measured]\non = \"{today}\"\n"), String::new()] {
            let folder = tempfile::tempdir().unwrap();
            fs::write(folder.path().join("p.toml"), profile(&measured)).unwrap();
            for arguments in COMMANDS {
                succeeds(folder.path(), arguments);
            }
        }
    }
}
