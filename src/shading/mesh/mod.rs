//! Meshes of triangles: their normals, edges and curvature, and meshes by name.

mod build;
mod normals;
mod paint;
mod repair;
pub mod shapes;
mod smooth;
mod triangles;

pub use build::{Corner, MAX_COORDINATE, Polygons, triangulated};
pub use normals::{Normals, newell};
pub use paint::{Coat, Paint, PaintedCorner, Texture, Wrap};
pub use smooth::Smooth;
pub use triangles::{Across, Mesh, Surface, Vertex};
