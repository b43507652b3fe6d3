//! Meshes of triangles: their normals, edges and curvature, and meshes by name.

mod build;
mod estimated;
mod normals;
mod paint;
pub mod shapes;
mod smooth;
mod triangles;
mod weld;
mod winding;

pub use build::{MAX_COORDINATE, Polygons, triangulated};
pub use estimated::Normals;
pub use normals::newell;
pub use paint::{Coat, Paint, PaintedCorner, Texture, Wrap};
pub use smooth::Smooth;
pub use triangles::Surface;
pub use triangles::{Edge, EdgeKind, Edges, Mesh, Vertex};
pub use weld::Seams;
