//! The window under the program: the event loop, keys and clicks with the time of their arrival, and what happens when
//! window system or graphics go away.

mod event_loop;
mod input;
mod open;
mod program;

pub use input::{Input, InputReport, PressTime};
pub use open::{LEAST_SIZE, open};
pub use program::{Program, WindowError};
