//! Floor −1, the basement: the clock, threads, signals, folders and fonts of the operating system. Any of them can fail, but
//! these functions never panic.

mod clock;
mod folders;
pub mod fonts;
pub mod signals;
mod threads;

pub use clock::{after, before, check_clock, now, today};
pub use folders::{
    config_folder, data_folder, entries, found, identified, is_of_another_user, link_target, make_private_folder,
    may_write, remove_tree, unless_missing,
};
pub use threads::{Stopped, checkpoint, run_on_thread, start_threads, stop_with, threads};
