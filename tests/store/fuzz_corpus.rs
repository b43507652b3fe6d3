//! Runs every file reader on the fuzzers' initial files and on the files they found: see `fuzz/README.md`.

use std::{collections::BTreeMap, fs::File, io::Read as _};

use flate2::read::GzDecoder;

use crate::common::attacks::{HANGS, PANICS, withstood};

#[path = "../../fuzz/targets.rs"]
mod targets;

#[test]
fn every_corpus_file_is_accepted_or_rejected() {
    let archive = File::open(concat!(env!("CARGO_MANIFEST_DIR"), "/fuzz/corpus.tar.gz")).unwrap();
    let mut counts: BTreeMap<String, u32> = BTreeMap::new();
    for entry in tar::Archive::new(GzDecoder::new(archive)).entries().unwrap() {
        let mut entry = entry.unwrap();
        let path = entry.path().unwrap().display().to_string();
        let ["corpus", folder, file] = path.split('/').collect::<Vec<_>>()[..] else { continue };
        if file.is_empty() {
            continue;
        }
        let (_, target) = targets::ALL.iter().find(|(name, _)| *name == folder).unwrap();
        let mut content = Vec::new();
        entry.read_to_end(&mut content).unwrap();
        // A panic names only the target, so this names the file.
        println!("{path}");
        target(&content);
        *counts.entry(folder.to_owned()).or_default() += 1;
    }
    withstood("files that fuzzers found", counts.values().sum::<u32>() as usize, &[PANICS, HANGS]);
    for (name, _) in targets::ALL {
        assert!(counts.get(*name).is_some_and(|count| *count >= 30), "{name}: the corpus has lost files: {counts:?}");
    }
}
