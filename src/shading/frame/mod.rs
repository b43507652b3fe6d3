//! A surface on the screen: the positions of its triangles, the visible triangle at each pixel, and its slopes
//! at vertices.

pub mod coverage;
mod patches;
mod projected;
mod scene;

pub use coverage::Outline;
pub use patches::{Field, Patches};
pub use projected::{Fan, Frame, FrameTriangle, FrameVertex, Side, View};
pub use scene::{Mirrors, Scene};
