//! Meshes of triangles: their normals, edges and curvature, and meshes by name.

mod build;
mod normals;
pub mod shapes;
mod surface;
mod triangles;

pub use build::{MAX_COORDINATE, MeshError, Polygons, triangulated};
pub use normals::newell;
pub use surface::Surface;
pub use triangles::{Edge, EdgeKind, Edges, Mesh, Vertex};
