//! Small inputs that ask for much time or memory, and paths that are not data files. Every command ends soon and uses
//! little memory.

use std::{
    fmt::Write as _,
    fs,
    io::Read as _,
    os::unix::{fs::symlink, net::UnixListener},
    path::Path,
    process::{Command, Stdio},
    time::{Duration, Instant},
};

use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;

use crate::common::{
    attacks::{HANGS, PANICS, withstood},
    command, split, succeeds, workbook,
};

/// Maximum time in seconds for an input below 1 MB. The tests' own build is slower than a release build and may run on a busy
/// machine, so that only an input that hangs is found.
const MAX_S: f64 = 30.0;
/// Maximum peak memory in KiB.
const MAX_KIB: u64 = 1 << 20;

/// Runs a command line and returns its status and its messages. Panics if the command takes
/// too long, uses too much memory, or ends in a way that no command should.
fn bounded(folder: &Path, line: &str) -> (Option<i32>, String) {
    let mut command = command(folder, &split(line));
    // The test itself may be limited to one thread, so that a single command runs at a time.
    command.env_remove("RAYON_NUM_THREADS");
    let started = Instant::now();
    let messages = tempfile::NamedTempFile::new().unwrap();
    let mut child = command.stdout(Stdio::null()).stderr(messages.reopen().unwrap()).spawn().unwrap();
    let mut peak = 0;
    let status = loop {
        let status = fs::read_to_string(format!("/proc/{}/status", child.id())).unwrap_or_default();
        let high_water = status.lines().find_map(|line| line.strip_prefix("VmHWM:")?.split_whitespace().next());
        peak = high_water.and_then(|kib| kib.parse().ok()).unwrap_or(peak);
        if let Some(status) = child.try_wait().unwrap() {
            break status;
        }
        if peak > MAX_KIB || started.elapsed().as_secs_f64() > MAX_S {
            child.kill().unwrap();
            child.wait().unwrap();
            panic!("{line} in {}: {peak} KiB and {:?}", folder.display(), started.elapsed());
        }
        std::thread::sleep(Duration::from_millis(2));
    };
    let mut text = Vec::new();
    messages.reopen().unwrap().take(100_000).read_to_end(&mut text).unwrap();
    let text = String::from_utf8_lossy(&text).into_owned();
    assert!(matches!(status.code(), Some(0..=2)) && !text.contains("panicked"), "{line}: {status}: {text}");
    (status.code(), text)
}

/// The commands that read a file with a given ending.
const READERS: &str = "csv => check {}
    csv => analyze {} --out {}.out
    csv => counts {} --out {}.counts
    csv => calibrate {} --out {}.toml
    csv => predict quick --fit {}
    toml => check {}
    toml => plan {} --participants 2 --studies 1
    toml => predict {}
    toml => predict --display {}
    toml => predict --criterion {}
    toml => plan quick --participants 2 --studies 1 --observer-file {}
    toml => simulate {}
    png => check {}
    png => compare {} {} --window 5
    obj => shade --shader gouraud --mesh {} --metrics {}.metrics.csv
    json => analyze session.csv --out out
    json => check session.csv";

/// A device, a pipe without a writer and a socket are refused at once by every command; so is a folder, except where a
/// folder of files is expected.
#[test]
fn only_regular_files_are_read() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let _socket = UnixListener::bind(at("socket")).unwrap();
    assert!(Command::new("mkfifo").arg(at("pipe")).status().unwrap().success());
    fs::create_dir(at("folder")).unwrap();
    let header = "subject_id,session_id,phase,trial,attempt,experiment,width,rating\nS1,1,main,1,1,x,0.1,1\n";
    fs::write(at("session.csv"), header).unwrap();
    let mut runs = 0;
    for what in ["/dev/zero", "pipe", "socket", "folder"] {
        for (ending, line) in READERS.lines().filter_map(|line| line.trim().split_once(" => ")) {
            // A link with the right ending leads to it.
            let link = if ending == "json" { "session.json".to_owned() } else { format!("link.{ending}") };
            symlink(what, at(&link)).unwrap();
            let line = line.replace("{}", &link);
            let (status, messages) = bounded(folder.path(), &line);
            fs::remove_file(at(&link)).unwrap();
            runs += 1;
            // A folder with the name of the sidecar does not count as a sidecar.
            let is_expected = messages.contains("is not a regular file") || messages.contains("is a folder");
            let is_read_as_folder = what == "folder"
                && (ending == "json" || messages.contains("CSV files") || messages.contains("contains no PNG"));
            assert!(
                status == Some(1) && is_expected || is_read_as_folder || ending == "json",
                "{what}: {line}: {messages}"
            );
        }
    }
    withstood("devices, pipes, sockets and folders as data", runs, &[PANICS, HANGS]);
}

/// A table of counts with `rows` rows by `people` participants, at random among `levels` levels of each factor.
fn ratings(rows: usize, people: usize, factors: usize, levels: usize, ratings: usize) -> String {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let mut text = "subject_id,rating,count".to_owned();
    (0..factors).for_each(|factor| write!(text, ",f{factor}").unwrap());
    for row in 0..rows {
        write!(text, "\nP{},{},1", row % people, rng.random_range(0..ratings)).unwrap();
        (0..factors).for_each(|factor| {
            // The levels of the first factor all occur.
            let level = if factor == 0 { row / people % levels } else { rng.random_range(0..levels) };
            write!(text, ",{level}").unwrap();
        });
    }
    text + "\n"
}

fn definition(factors: &str, design: &str) -> String {
    format!(
        "schema = 1\nname = \"b\"\n[stimulus]\nkind = \"mach-band\"\n[factors]\n{factors}\n[design]\nrepetitions = 1\n{design}\n"
    )
}

fn list(count: usize, of: impl Fn(usize) -> f64) -> String {
    (0..count).map(|i| format!("{:.6}", of(i))).collect::<Vec<_>>().join(", ")
}

/// A PNG of zeros, with an extra chunk.
fn png(side: u32, depth: png::BitDepth, color: png::ColorType, extra: Option<([u8; 4], Vec<u8>)>) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, side, side);
    encoder.set_color(color);
    encoder.set_depth(depth);
    let mut writer = encoder.write_header().unwrap();
    if let Some((name, data)) = extra {
        writer.write_chunk(png::chunk::ChunkType(name), &data).unwrap();
    }
    let row = (side as usize * color.samples() * depth as usize).div_ceil(8);
    let mut stream = writer.stream_writer().unwrap();
    let zeros = vec![0; row];
    (0..side).for_each(|_| std::io::Write::write_all(&mut stream, &zeros).unwrap());
    stream.finish().unwrap();
    drop(writer);
    bytes
}

/// Returns `size` equal bytes, compressed a thousandfold.
fn bomb(prefix: &[u8], size: usize) -> Vec<u8> {
    let mut encoder = flate2::write::ZlibEncoder::new(prefix.to_vec(), flate2::Compression::best());
    let block = vec![b'x'; 1 << 20];
    (0..size >> 20).for_each(|_| std::io::Write::write_all(&mut encoder, &block).unwrap());
    encoder.finish().unwrap()
}

/// A mesh of `faces` faces with `corners` corners each, on random points.
fn obj(points: usize, faces: usize, corners: usize) -> String {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let mut text = String::new();
    for _ in 0..points {
        let [x, y, z]: [f64; 3] = std::array::from_fn(|_| rng.random_range(-1.0..1.0));
        writeln!(text, "v {x:.3} {y:.3} {z:.3}").unwrap();
    }
    for _ in 0..faces {
        text += "f";
        (0..corners).for_each(|_| write!(text, " {}", rng.random_range(1..=points)).unwrap());
        text += "\n";
    }
    text
}

/// An input: its name, its content, and what the commands say about it, separated by ` | `: a command, ` => ` and a part of
/// its first error; nothing if it must succeed, or `*` if it may succeed or fail. Words in capitals stand for commands.
type Case = (&'static str, Vec<u8>, String);

const COMMANDS: [(&str, &str); 6] = [
    ("ANALYZE", "analyze {} --out {}.out"),
    ("COUNTS", "counts {} --out {}.csv"),
    ("SHADE", "shade --shader gouraud --mesh {} --metrics {}.metrics.csv"),
    ("CALIBRATE", "calibrate {} --out {}.toml"),
    ("PLAN", "plan {} --participants 2 --studies 1"),
    ("COMPARE", "compare {} {} --window 5"),
];

/// Inputs below 1 MB that are as expensive as possible, each with the commands that read it.
fn cases() -> Vec<Case> {
    use png::{BitDepth::*, ColorType::*};
    let readings = |count: usize| -> String {
        let level = |i: usize| i as f64 / (count - 1) as f64;
        let row = |i: usize| format!("gray,{},{}\n", level(i), 0.1 + (i as f64 / count as f64).powf(2.2));
        format!("channel,level,luminance_cd_m2\n{}", (0..count).map(row).collect::<String>())
    };
    let widths = |count: usize| format!("width = [{}]", list(count, |i| 0.001 + 0.99 * i as f64 / count as f64));
    let mebibyte = 1 << 20;
    let (many, bombs) = (2_000, 100 * mebibyte);
    let long = |cell: &str| format!("subject_id,rating,count,width\nS1,1,1,{cell}\nS1,1,1,1\nS2,2,1,2\n");
    let text_bomb = |keyword: &[u8]| bomb(keyword, bombs);
    let case =
        |name: &'static str, content: &dyn AsRef<[u8]>, said: &str| (name, content.as_ref().to_vec(), said.into());
    // In each row, the cells share a text of a megabyte.
    let texts = format!("<row>{}</row>", "<c t=\"s\"><v>0</v></c>".repeat(8000));
    let curve = list(40_001, |i| i as f64 / 40_000.0);
    let profile = "schema = 1\nname = \"x\"";
    let [a, b] = ["a", "b"].map(|letter| letter.repeat(500_000));
    vec![
        case("levels.csv", &ratings(2 * many, 2, 1, many, 4), "ANALYZE => the number of levels of f0 is | COUNTS"),
        case("cell.csv", &long(&"x".repeat(200_000)), "ANALYZE => the number of bytes of the name | COUNTS"),
        case(
            "columns.csv",
            &ratings(2, 2, 3000, 2, 4),
            "ANALYZE => the number of factors is | check {} => is not named like",
        ),
        case("people.csv", &ratings(60_000, 30_000, 1, 2, 4), "ANALYZE => the number of participants is | COUNTS"),
        case(
            "times.csv",
            &ratings(4_800, 8, 2, 3, 400),
            "ANALYZE --response rating => the number of different values is 255 or more; expected | \
             COUNTS --response rating => the number of different values is 255 or more; expected",
        ),
        case(
            "texts.xlsx",
            &workbook(&[("s", &texts)], &"x".repeat(1 << 20)),
            "COUNTS => the sheet has more than 67108864 bytes as CSV; expected fewer",
        ),
        case(
            "readings.csv",
            &readings(many.max(5000)),
            "CALIBRATE => the number of readings is | check {} => the number of readings is",
        ),
        case(
            "blocks.toml",
            &definition(&widths(50_000), "order = \"blocked:width\""),
            "check {} | PLAN => the number of levels of width | predict {} => the number of conditions is",
        ),
        case("deep.toml", &format!("x = {}", "[".repeat(500_000)), "check {} => is not valid TOML"),
        case(
            "profile.toml",
            &format!("{profile}\ntransfer = {{ encoded = [{curve}], linear = [{curve}] }}\n"),
            "check {} => * | predict --display {} => *",
        ),
        case(
            "ztxt.png",
            &png(64, Eight, Grayscale, Some((*b"zTXt", text_bomb(b"machband\0\0")))),
            "check {} => no text chunk | COMPARE --black 0 => no light",
        ),
        case(
            "iccp.png",
            &png(64, Eight, Grayscale, Some((*b"iCCP", text_bomb(b"p\0\0")))),
            "check {} => no text chunk | COMPARE => has a color profile that is too large",
        ),
        case("corners.obj", &obj(1024, 40, 1025), "SHADE => the number of corners is 1025"),
        case("layers.obj", &layers(39), "SHADE => cover its outline"),
        case(
            "words.toml",
            &format!("schema = 1\nname = \"b\"\n{a}= 1\n[stimulus]\nkind = \"{b}\"\n"),
            "check {} => aaaa … aaaa | predict {} => aaaa … aaaa",
        ),
    ]
}

/// No input below 1 MB takes long or much memory.
#[test]
fn small_inputs_cost_little() {
    let folder = tempfile::tempdir().unwrap();
    let mut runs = 0;
    for (name, content, said) in cases() {
        assert!(content.len() < 1 << 20, "{name}: {}", content.len());
        fs::write(folder.path().join(name), content).unwrap();
        for said in said.split(" | ") {
            let (line, expected) = said.split_once(" => ").unwrap_or((said, ""));
            let line = COMMANDS.iter().fold(line.to_owned(), |line, (word, command)| line.replace(word, command));
            let line = line.replace("{}", name);
            let (status, messages) = bounded(folder.path(), &line);
            runs += 1;
            match expected {
                "*" => {}
                "" => assert_eq!(status, Some(0), "{line}: {messages}"),
                _ => {
                    assert!(matches!(status, Some(1 | 2)), "{line}: {status:?}: {messages}");
                    let mut errors = messages.lines().filter(|line| line.starts_with("error: "));
                    assert!(errors.any(|error| error.contains(expected)), "{line}: {messages}");
                }
            }
        }
    }
    withstood("small files that ask for much work", runs, &[PANICS, HANGS]);
}

/// A data file may claim to be huge without taking any space.
#[test]
fn huge_files_are_refused_before_they_are_read() {
    let folder = tempfile::tempdir().unwrap();
    succeeds(folder.path(), &split("simulate quick --results results"));
    let csv = "results/quick/data/subject-S001_session-1_task-quick_data.csv";
    fs::File::options().write(true).open(folder.path().join(csv)).unwrap().set_len(10 << 30).unwrap();
    for line in [
        "check {}",
        "verify results",
        "repair {}",
        "simulate quick --results results --resume",
        "analyze results --out out",
        "counts results --out c.csv",
        "export results --format bids --out bids",
    ] {
        let (status, messages) = bounded(folder.path(), &line.replace("{}", csv));
        assert!(status == Some(1) && messages.contains("error: "), "{line}: {messages}");
    }
}

/// Files that are only copied or only referred to are bounded too, each and in sum.
#[test]
fn huge_files_beside_the_data_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    succeeds(folder.path(), &split("simulate quick --results results"));
    let sparse = |name: &str, size| fs::File::create(folder.path().join(name)).unwrap().set_len(size).unwrap();
    let buffer = r#"{"byteLength": 4, "uri": "big.bin"}"#;
    let gltf = format!(r#"{{"asset": {{"version": "2.0"}}, "buffers": [{}]}}"#, [buffer; 12].join(","));
    fs::write(folder.path().join("mesh.gltf"), gltf).unwrap();
    sparse("big.bin", 250 << 20);
    for name in ["LICENSE", "README.md", "CHANGES.md"] {
        sparse(&format!("results/quick/{name}"), 3 << 30);
        for format in ["bids", "psych-ds"] {
            let (status, messages) = bounded(folder.path(), &format!("export results --format {format} --out out"));
            let expected = format!("{name}: has 3221225472 bytes; expected at most 16777216");
            assert!(status == Some(1) && messages.contains(&expected), "{format}: {messages}");
        }
        fs::remove_file(folder.path().join("results/quick").join(name)).unwrap();
    }
    let (status, messages) = bounded(folder.path(), "shade --shader gouraud --mesh mesh.gltf --metrics m.csv");
    let expected = "big.bin: has 262144000 bytes; expected at most 629";
    assert!(status == Some(1) && messages.contains(expected), "{messages}");
}

/// A sidecar may claim pictures of any size and any number of sittings.
#[test]
fn a_sidecar_cannot_ask_for_huge_pictures() {
    let folder = tempfile::tempdir().unwrap();
    succeeds(folder.path(), &split("simulate quick --results results"));
    let path = folder.path().join("results/quick/data/subject-S001_session-1_task-quick_data.json");
    let text = fs::read_to_string(&path).unwrap();
    let changed = text.replacen("\"size\": 256", "\"size\": 100000", 1);
    assert_ne!(changed, text);
    fs::write(&path, changed).unwrap();
    let (status, messages) = bounded(folder.path(), "verify results");
    assert!(status == Some(1) && messages.contains("were not rendered"), "{messages}");
    let mut sidecar: serde_json::Value = serde_json::from_str(&text).unwrap();
    let sitting = sidecar["sittings"][0].clone();
    sidecar["sittings"] = vec![sitting; 200].into();
    fs::write(&path, sidecar.to_string()).unwrap();
    for line in [
        "verify results",
        "check results/quick/data/subject-S001_session-1_task-quick_data.csv",
        "analyze results --out out",
    ] {
        bounded(folder.path(), line);
    }
}

/// The option `--large` removes the limits.
#[test]
fn limits_can_be_raised() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("levels.csv"), ratings(242, 2, 1, 121, 4)).unwrap();
    let line = "analyze levels.csv --out out --tables-only --draws 99";
    let (status, messages) = bounded(folder.path(), line);
    assert!(status == Some(2) && messages.contains("or the option --large"), "{messages}");
    assert_eq!(bounded(folder.path(), &format!("{line} --large --terms num:f0")).0, Some(0));
}

/// A mesh of `n`³ squares that lie over each other; all their triangles are different.
fn layers(n: usize) -> String {
    let corners = ["0 0", "1 0", "1 1", "0 1"].iter().flat_map(|at| (0..n).map(move |i| format!("v {at} .{i:03}\n")));
    let square = |i: usize| [i % n, n + i / n % n, 2 * n + i / n / n, 3 * n + i / n % n].map(|corner| corner + 1);
    let faces = (0..n * n * n).map(square).map(|[a, b, c, d]| format!("f {a} {b} {c} {d}\n"));
    corners.chain(faces).collect()
}
