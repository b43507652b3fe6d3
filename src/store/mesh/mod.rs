//! Meshes (Wavefront OBJ).
//!
//! Read are vertices (`v`), normals (`vn`) and faces (`f`), of any number of corners, by positive and relative indices;
//! objects and groups make one mesh. Everything else (texture coordinates, lines, materials, smoothing groups, curved
//! surfaces) is passed over.
//!
//! **Vertices in exactly one position are one**: programs write a position again for each of its normals, and without
//! that every such seam would be a border, at which nothing is smooth. Positions that are only nearly equal stay apart, and
//! an edge between them is two borders. Where a file holds both sides of a sheet, or bodies that touch along an edge, those
//! edges then have more than two sides, and are shaded as such.
//!
//! **Normals**: the file's, where it has them; where a corner has none, or one that is zero or not a number, the average
//! of the faces around it. Normals of the file make creases where they differ; averages where faces meet at more than
//! the angle of the crease.

mod obj;

use std::path::Path;

use super::{FileFaults, text::read_bytes};
use crate::shading::{Mesh, MeshError};

/// Largest file, in bytes: about two million triangles.
const LARGEST_FILE: u64 = 1 << 28;

/// Reads an OBJ file. Where the file has no normals, faces that meet at more than `crease_deg` degrees do not share any;
/// 180 makes everything smooth.
///
/// # Errors
/// A file that cannot be read or is too large; otherwise what [`parse`] finds.
pub fn read(path: &Path, crease_deg: f64) -> Result<Mesh, FileFaults> {
    parse(&path.display().to_string(), &read_bytes(path, LARGEST_FILE, "an OBJ file")?, crease_deg)
}

/// Reads the content of an OBJ file; `file` names it in messages.
///
/// # Errors
/// The first faults, each with its line and column: content that is not text, numbers or indices that cannot be read,
/// coordinates that are not finite, vertices and normals that do not exist, faces with too few corners. A file without
/// faces, or whose faces have no area.
pub fn parse(file: &str, content: &[u8], crease_deg: f64) -> Result<Mesh, FileFaults> {
    let (positions, polygons) = obj::polygons(file, content)?;
    Mesh::from_polygons(&positions, &polygons, crease_deg).map_err(|error| {
        let message = match error {
            MeshError::NoTriangles => "has no faces; expected at least one line \"f 1 2 3\"".to_owned(),
            MeshError::NoArea(_) => {
                "has no face with an area; expected at least one whose corners are apart".to_owned()
            }
            error => error.to_string(),
        };
        FileFaults::whole(file, message)
    })
}
