//! Meshes of triangles: their normals, edges and curvature, and meshes by name.

mod build;
mod curvature;
mod edges;
mod normals;
mod polygons;
pub mod shapes;
mod surface;
mod triangles;

pub use build::{LARGEST_COORDINATE, MeshError, Polygons};
pub use edges::{Edge, EdgeKind, Edges};
pub use normals::newell;
pub use polygons::triangulated;
pub use surface::Surface;
pub use triangles::{Mesh, Vertex};
