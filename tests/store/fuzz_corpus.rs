//! What the fuzzers found, and what they began with, through every reader of files: see `fuzz/README.md`.

use std::{fs, path::Path, time::Instant};

#[path = "../../fuzz/targets.rs"]
mod targets;

#[test]
fn every_file_of_the_corpus_is_read_or_refused() {
    let corpus = Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/corpus");
    for (name, target) in targets::ALL {
        let mut files: Vec<_> = fs::read_dir(corpus.join(name)).unwrap().map(|entry| entry.unwrap().path()).collect();
        files.sort();
        assert!(!files.is_empty(), "{name}: the corpus is empty");
        let started = Instant::now();
        for file in &files {
            // A panic names the target; this names the file.
            println!("{}", file.display());
            target(&fs::read(file).unwrap());
        }
        println!("{name}: {} files, {:.1} s", files.len(), started.elapsed().as_secs_f64());
    }
}
