//! Independent pieces of work on several threads.

use std::sync::{
    Mutex,
    atomic::{AtomicUsize, Ordering},
};

/// Does `work` for 0…`count` − 1, `at_a_time` at a time, each once and in no particular order. After the first failure no
/// further piece is begun.
///
/// # Errors
/// The first failure.
pub(super) fn each<E: Send>(
    count: usize,
    at_a_time: usize,
    work: impl Fn(usize) -> Result<(), E> + Sync,
) -> Result<(), E> {
    let next = AtomicUsize::new(0);
    let failure = Mutex::new(None);
    std::thread::scope(|scope| {
        for _ in 0..at_a_time.min(count) {
            scope.spawn(|| {
                loop {
                    let piece = next.fetch_add(1, Ordering::Relaxed);
                    if piece >= count {
                        return;
                    }
                    if let Err(error) = work(piece) {
                        next.store(count, Ordering::Relaxed);
                        failure.lock().unwrap_or_else(|poisoned| poisoned.into_inner()).get_or_insert(error);
                        return;
                    }
                }
            });
        }
    });
    match failure.into_inner().unwrap_or_else(|poisoned| poisoned.into_inner()) {
        Some(error) => Err(error),
        None => Ok(()),
    }
}
