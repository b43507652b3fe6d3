//! The window of the program: the event loop, keys and clicks with their arrival times, and what happens if the window
//! system or the graphics are lost.

mod event_loop;
mod input;
mod program;

pub use event_loop::{MIN_SIZE, open};
pub use input::{Input, PressTime, Pressed, Stamps};
pub use program::{Program, WindowError};
