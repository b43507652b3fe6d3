//! Reads meshes from OBJ, PLY, glTF and GLB files.
//!
//! **Vertices at the same position are merged.** Many programs repeat a position for each of its normals; without
//! merging, every such seam would be a border without smooth shading. On open edges, positions also count as the same if
//! they differ by no more than a thousandth of an edge, and everywhere by a millionth of the edges around. Faces that
//! repeat others are left out. If a file contains both sides of a sheet, or bodies that touch along an edge, the edges
//! there belong to more than two triangles and are shaded accordingly.
//!
//! **Normals** come from the file if it has them. A corner whose normal is missing, zero or not a number gets the
//! average normal of the faces around it. Normals from the file create creases where they differ; averaged normals
//! create creases where faces meet at more than the crease angle. Faces of a glTF file that have no normal at any corner are
//! flat, as its specification says, unless normals are to be estimated.
//!
//! **Winding** is repaired: faces whose neighbors go around the other way are reversed, the fewer in each connected part, or
//! those that face inward in a closed part without given normals. Closed surfaces that are inside out are turned, and so
//! are parts whose given normals point to the other side.

mod faces;
mod gltf;
mod obj;
mod ply;

use std::path::Path;

use glam::DVec3;

use super::{FileErrors, file::read_bytes};
use crate::{
    shading::{
        Mesh, Normals,
        mesh::Corner,
        shapes::{self, Shape},
    },
    system::{checkpoint, found},
};

/// Maximum file size in bytes, enough for about two million triangles.
const MAX_FILE: u64 = 1 << 28;

/// A mesh from a file.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshFile {
    /// The mesh.
    pub mesh: Mesh,
    /// What was repaired, assumed or ignored, as sentences without their ends.
    pub notes: Vec<String>,
}

impl MeshFile {
    /// Returns a sentence about what was repaired, assumed or ignored, if anything.
    pub fn note(&self, path: &Path) -> Option<String> {
        (!self.notes.is_empty()).then(|| format!("{}: {}", path.display(), self.notes.join("; ")))
    }
}

/// Why a name or a path gives no mesh.
#[derive(Debug, thiserror::Error)]
pub enum MeshError {
    /// There is neither a shape nor a file of this name.
    #[error("{0}")]
    Unknown(String),
    /// The shape cannot have this number of vertices.
    #[error("{0}")]
    Vertices(String),
    /// The file cannot be read.
    #[error(transparent)]
    File(#[from] FileErrors),
}

/// Returns the built-in shape of this name, if there is one.
pub fn shape_of(name: &Path) -> Option<Shape> {
    name.to_str()?.parse().ok()
}

/// Returns the shape of this name with `vertices` sites, or the mesh in the file of this path, relative to `folder`, as
/// [`read`] does.
///
/// # Errors
/// See [`MeshError`].
pub fn open(
    folder: &Path,
    name: &Path,
    vertices: usize,
    crease_deg: f64,
    normals: Normals,
) -> Result<MeshFile, MeshError> {
    if let Some(shape) = shape_of(name) {
        let mesh = shapes::mesh(shape, vertices).map_err(MeshError::Vertices)?;
        return Ok(MeshFile { mesh, notes: Vec::new() });
    }
    let path = folder.join(name);
    if path.extension().is_none() && matches!(found(&path), Ok(None)) {
        let expected = format!("expected {}, or an OBJ, PLY, glTF or GLB file", Shape::EXPECTED);
        return Err(MeshError::Unknown(format!("{name:?} is not known; {expected}")));
    }
    Ok(read(&path, crease_deg, normals)?)
}

/// Reads an OBJ, PLY, glTF or GLB file. If the file has no normals, faces that meet at more than `crease_deg` degrees do
/// not share a normal; 180 makes the whole mesh smooth. `normals` are those that will be used; with any but the given ones,
/// no face is flat for want of a normal.
///
/// # Errors
/// The file cannot be read or is too large; otherwise, the same errors as [`parse`].
pub fn read(path: &Path, crease_deg: f64, normals: Normals) -> Result<MeshFile, FileErrors> {
    let content = read_bytes(path, MAX_FILE, "an OBJ, PLY, glTF or GLB file")?;
    parse_in(path.parent(), &path.display().to_string(), &content, crease_deg, normals)
}

/// Reads the content of a file, whose format it recognizes from the first bytes; `file` identifies it in messages. A
/// glTF file must contain its own data.
///
/// # Errors
/// Reports the first errors, each with its place: content that is not of the format, numbers or indices that cannot be
/// read, coordinates that are not finite, vertices that do not exist, and faces with too few corners. It is also an
/// error if the file has no faces, or if none of its faces has an area.
pub fn parse(file: &str, content: &[u8], crease_deg: f64) -> Result<MeshFile, FileErrors> {
    parse_in(None, file, content, crease_deg, Normals::Given)
}

fn parse_in(
    folder: Option<&Path>,
    file: &str,
    content: &[u8],
    crease_deg: f64,
    normals: Normals,
) -> Result<MeshFile, FileErrors> {
    let text = content.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(content).trim_ascii_start();
    if text.is_empty() {
        return Err(FileErrors::whole(file, "is empty; expected an OBJ, PLY, glTF or GLB file"));
    }
    let is_other = [&b"OFF"[..], b"<", b"PK"].iter().any(|start| text.starts_with(start));
    let is_named = Path::new(file).extension().is_none_or(|name| name.eq_ignore_ascii_case("obj"));
    let mut lines = text.split(|byte| matches!(byte, b'\n' | b'\r'));
    let (faces, expected) = if content.starts_with(b"glTF") || text.starts_with(b"{") {
        let faces = gltf::parse(folder, content, normals == Normals::Given);
        let faces = faces.map_err(|message| FileErrors::whole(file, message))?;
        (faces, "at least one primitive with triangles")
    } else if text.starts_with(b"ply\n") || text.starts_with(b"ply\r") {
        (ply::parse(file, content)?, "an element \"face\" with a list \"vertex_indices\"")
    } else if is_other || !is_named && !lines.any(|line| line.trim_ascii_start().starts_with(b"f ")) {
        return Err(FileErrors::whole(file, "is none of OBJ, PLY, glTF and GLB; expected one of these"));
    } else {
        (obj::parse(file, content)?, "at least one line \"f 1 2 3\"")
    };
    faces.mesh(file, crease_deg, expected, normals)
}

/// Makes a mesh of `triangles`, as indices of `positions`, as if it were from a file; `name` identifies it in messages.
/// `normals` are given for each position or not at all.
///
/// # Errors
/// A position that does not exist, and the same errors as [`parse`].
///
/// # Panics
/// Panics if there are normals, but not as many as positions.
pub fn from_arrays(
    name: &str,
    positions: &[DVec3],
    triangles: &[[u32; 3]],
    normals: Option<&[DVec3]>,
    crease_deg: f64,
) -> Result<MeshFile, FileErrors> {
    assert!(normals.is_none_or(|normals| normals.len() == positions.len()), "one normal for each position");
    let is_wrong = |normal: &DVec3| normal.try_normalize().is_none();
    if let Some(index) = normals.and_then(|normals| normals.iter().position(is_wrong)) {
        let message = format!("normal {index} is zero or not finite; expected a vector of any length above 0");
        return Err(FileErrors::whole(name, message));
    }
    let mut faces = faces::Faces::default();
    faces.polygons.positions = positions.to_vec();
    faces.polygons.normals = normals.unwrap_or_default().iter().map(|normal| normal.try_normalize()).collect();
    for (index, corners) in triangles.iter().enumerate() {
        checkpoint();
        if let Some(corner) = corners.iter().find(|corner| **corner as usize >= positions.len()) {
            let message =
                format!("triangle {index} refers to vertex {corner}; expected a number below {}", positions.len());
            return Err(FileErrors::whole(name, message));
        }
        faces.polygons.push(corners.map(Corner::of));
    }
    faces.mesh(name, crease_deg, "at least one triangle", Normals::Given)
}
