//! The window of the program: the event loop, keys and clicks with their arrival times, and the response to the loss of
//! the window system or the graphics.

mod event_loop;
mod input;
mod open;
mod program;

pub use input::{Input, InputReport, PressTime, Pressed, Stamps};
pub use open::{LEAST_SIZE, open};
pub use program::{Program, WindowError};
