//! Floor 0: what the operating system provides: the clock, threads, signals and folders. Each of them can fail, and none
//! of these functions panics then.

mod clock;
mod folders;
pub mod signals;
mod threads;

pub use clock::{after, before, check_clock, now};
pub use folders::{data_folder, entries, make_private_folder, remove_tree};
pub use threads::{run_on_thread, start_threads, threads};
