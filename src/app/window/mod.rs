//! The window of the program: the event loop, keys and clicks with their arrival times, and what happens if the window
//! system or the graphics are lost.

mod event_loop;
mod input;
mod open;
mod program;

pub use input::{Input, InputReport, PressTime, Pressed, Stamps};
pub use open::{MIN_SIZE, open};
pub use program::{Program, WindowError};
