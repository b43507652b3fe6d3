//! Hashes of what was shown, made beside the window's loop: no frame waits for them.

use std::{
    collections::BTreeMap,
    sync::mpsc::{Sender, channel},
    thread::{self, JoinHandle},
};

use crate::{light::CodeImage, store::image};

/// Takes pictures, and gives their hashes at the end.
pub struct Hasher {
    pictures: Sender<(usize, CodeImage)>,
    hashes: JoinHandle<BTreeMap<usize, String>>,
}

impl Hasher {
    /// Starts; `None` where the system gives no thread, and the pictures then have no hash.
    pub fn start() -> Option<Self> {
        let (pictures, shown) = channel::<(usize, CodeImage)>();
        let hash = move || {
            let mut hashes = BTreeMap::new();
            for (condition, picture) in shown {
                hashes.entry(condition).or_insert_with(|| image::hash(&picture));
            }
            hashes
        };
        Some(Self { pictures, hashes: thread::Builder::new().name("hasher".to_owned()).spawn(hash).ok()? })
    }

    /// Hands on the picture of a condition, counted from 0.
    pub fn take(&self, condition: usize, picture: CodeImage) {
        // A thread that has ended takes none; its pictures then have no hash, which says so.
        let _ = self.pictures.send((condition, picture));
    }

    /// Waits for the hash of each condition.
    pub fn finish(self) -> BTreeMap<usize, String> {
        drop(self.pictures);
        self.hashes.join().unwrap_or_default()
    }
}
