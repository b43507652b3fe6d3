//! Floor 1: shading. A projected and lit mesh becomes light on a screen, with shaders that range from flat to smooth
//! everywhere.
//!
//! ```text
//! Mesh → Surface (edges, curvature: once per mesh) → Frame (view, light: once per frame) → picture
//! ```
//!
//! | room | contents |
//! |---|---|
//! | [`mesh`] | triangles, their normals, edges, curvature and paint, and meshes by name |
//! | [`lighting`] | materials, lamps, highlights, transparency, refraction |
//! | [`cubic`] | fields with a continuous slope over triangles; programmers copy this file |
//! | [`frame`] | a mesh on the screen: the view, which triangle each pixel shows, slopes at vertices |
//! | [`shaders`] | how light spreads over a triangle |
//! | [`draw`] | drawing one mesh, or several |
//! | [`measure`] | the creases that a shader leaves, and the smooth surface itself |

pub mod cubic;
pub mod draw;
pub mod frame;
pub mod lighting;
pub mod measure;
pub mod mesh;
pub mod shaders;

pub use draw::{Body, Composition, image};
pub use frame::{Fan, Field, Frame, FrameTriangle, FrameVertex, Mirrors, Patches, Scene, Side, View, coverage};
pub use lighting::{Highlight, Lamp, LampPosition, Lighting, Material, Refraction, Transmits, Transparency};
pub use measure::{self as crease, Creases, EdgeCrease, Truth};
pub use mesh::{
    Across, Coat, Mesh, Normals, Paint, PaintedCorner, Polygons, Smooth, Surface, Texture, Vertex, Wrap, shapes,
};
pub use shaders::{Correction, Shade, Shader, Shading};
