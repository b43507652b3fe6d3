//! A surface seen and lit: where its triangles are on the screen, which of them each pixel shows, how its light bends at
//! edges and slopes at vertices.

mod bends;
pub mod coverage;
mod frame;
pub mod ordinates;
mod outline;
mod planes;
mod scene;
mod view;

pub use bends::{Bend, bends};
pub use frame::{Across, Frame, FrameTriangle, FrameVertex};
pub use ordinates::{ControlPoints, Gradient, Gradients, Patches};
pub use outline::Outline;
pub use planes::Planes;
pub use scene::{Highlight, Scene};
pub use view::View;
