//! Floor 1: shading. A mesh, seen and lit, becomes light on a screen: the ladder of shaders from flat to smooth
//! everywhere.
//!
//! ```text
//! Mesh → Surface (edges, curvature: once a mesh) → Frame (view, light: once a frame) → picture
//! ```
//!
//! Shaders light the vertices (all but flat and Phong), and spread that light over the triangles on the screen.

pub mod boundary;
pub mod coverage;
pub mod crease;
mod curvature;
pub mod edges;
pub mod frame;
#[cfg(feature = "gpu")]
pub mod gpu;
pub mod illumination;
pub mod mesh;
pub mod normals;
pub mod patch;
pub mod polygon;
pub mod raster;
pub mod reference;
pub mod refraction;
pub mod scene;
pub mod shader;
pub mod shaders;
pub mod shapes;
pub mod surface;
pub mod transparency;
pub mod view;

pub use crease::{Creases, EdgeCrease};
pub use edges::{Edge, EdgeKind, Edges};
pub use frame::{Across, Frame, FrameTriangle, FrameVertex};
pub use illumination::{Lamp, LampPlace, Lighting, LightingError, Material, Specular};
pub use mesh::{Mesh, MeshError, Polygons, Vertex};
pub use patch::Patches;
pub use reference::Reference;
pub use refraction::Refraction;
pub use scene::{Highlight, Scene};
pub use shader::{Correction, Gradients, Shade, Shader};
pub use surface::Surface;
pub use transparency::{Transparency, TransparencyError};
pub use view::View;
