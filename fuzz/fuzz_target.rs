#![no_main]
//! Fuzzes the target that has the same name as this program.

#[path = "targets.rs"]
mod targets;

libfuzzer_sys::fuzz_target!(|content: &[u8]| {
    let (_, target) = targets::ALL.iter().find(|(name, _)| *name == env!("CARGO_BIN_NAME")).expect("a target");
    target(content);
});
