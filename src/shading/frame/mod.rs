//! A surface seen and lit: where its triangles are on the screen, which of them each pixel shows, how its light bends at
//! edges and slopes at vertices.

mod bends;
pub mod coverage;
pub mod ordinates;
mod outline;
mod planes;
mod projected;
mod scene;
mod view;

pub use bends::{Bend, bends};
pub use ordinates::{ControlPoints, Gradient, Gradients, Patches};
pub use outline::Outline;
pub use planes::Planes;
pub use projected::{Across, Frame, FrameTriangle, FrameVertex};
pub use scene::{Highlight, Scene};
pub use view::View;
