//! Meshes (Wavefront OBJ).
//!
//! Read are places (`v`), normals (`vn`) and faces (`f`), of any number of corners, by positive and relative indices;
//! objects and groups make one mesh. Everything else (texture coordinates, lines, materials, smoothing groups, curved
//! surfaces) is passed over. `tobj` parses; what it cannot say or would take for something else is seen to before, line
//! by line: where a fault is, corners without a normal, lines of three points and more, which are no faces.
//!
//! **Places that are exactly equal are one**: programs write a place again for each of its normals, and without that
//! every such seam would be a border, at which nothing is smooth. Places that are only nearly equal stay apart, and an
//! edge between them is two borders. Where a file holds both sides of a sheet, or bodies that touch along an edge, those
//! edges then have more than two sides, and are shaded as such.
//!
//! **Normals**: the file's, where it has them; where a corner has none, or one that is zero or not a number, the average
//! of the faces around it. Normals of the file make creases where they differ; averages where faces meet at more than
//! the angle of the crease.

mod check;

use std::{collections::HashMap, fs::File, io::Read as _, path::Path};

use glam::DVec3;

use crate::{
    shading::{Mesh, MeshError, Polygons},
    store::FileFaults,
};

/// Largest file, in bytes: about two million triangles.
const LARGEST_FILE: u64 = 1 << 28;

/// Reads an OBJ file. Faces that meet at more than `crease_deg` degrees share no normals, where the file has none;
/// 180 makes everything smooth.
///
/// # Errors
/// A file that cannot be read or is too large; otherwise what [`parse`] finds.
pub fn read(path: &Path, crease_deg: f64) -> Result<Mesh, FileFaults> {
    let name = path.display().to_string();
    let fail = |message: String| FileFaults::whole(name.clone(), message);
    let metadata =
        std::fs::metadata(path).map_err(|error| fail(format!("cannot be opened: {error}; expected an OBJ file")))?;
    if metadata.is_dir() {
        return Err(fail("is a folder; expected an OBJ file".to_owned()));
    }
    let mut bytes = Vec::new();
    // Bounded while reading, not by the length alone: a pipe or a device has none.
    File::open(path)
        .and_then(|file| file.take(LARGEST_FILE + 1).read_to_end(&mut bytes))
        .map_err(|error| fail(format!("cannot be read: {error}; expected an OBJ file")))?;
    if bytes.len() as u64 > LARGEST_FILE {
        let size = metadata.len().max(bytes.len() as u64);
        return Err(fail(format!("has {size} bytes; expected at most {LARGEST_FILE}")));
    }
    parse(&name, &bytes, crease_deg)
}

/// Reads the content of an OBJ file; `file` names it in messages.
///
/// # Errors
/// The first faults, each with its line and column: what is not text, numbers and indices that are none, places that
/// are not finite, places and normals that do not exist, faces with too few corners. A file without faces, or whose
/// faces have no area.
pub fn parse(file: &str, content: &[u8], crease_deg: f64) -> Result<Mesh, FileFaults> {
    let clean = check::checked(file, content)?;
    let fail = |message: String| FileFaults::whole(file, message);
    let options = tobj::LoadOptions::default();
    let (models, _) = tobj::load_obj_buf(&mut clean.as_bytes(), &options, |_| Err(tobj::LoadError::GenericFailure))
        .map_err(|error| fail(format!("is not understood: {error}; expected an OBJ file")))?;
    drop(clean);
    let mut welded = Welded::default();
    for model in models {
        welded.add(&model.mesh);
    }
    Mesh::from_polygons(&welded.places, &welded.polygons, crease_deg).map_err(|error| {
        fail(match error {
            MeshError::NoTriangles => "has no faces; expected at least one line \"f 1 2 3\"".to_owned(),
            MeshError::NoArea(_) => {
                "has no face with an area; expected at least one whose corners are apart".to_owned()
            }
            error => error.to_string(),
        })
    })
}

/// Faces whose equal places are one.
#[derive(Default)]
struct Welded {
    places: Vec<DVec3>,
    sites: HashMap<[u64; 3], u32>,
    polygons: Polygons,
}

impl Welded {
    fn add(&mut self, mesh: &tobj::Mesh) {
        let triple = |list: &[f64], i: usize| DVec3::new(list[3 * i], list[3 * i + 1], list[3 * i + 2]);
        let sites: Vec<u32> = (0..mesh.positions.len() / 3)
            .map(|i| {
                // −0 is 0.
                let place = triple(&mesh.positions, i) + DVec3::ZERO;
                *self.sites.entry(place.to_array().map(f64::to_bits)).or_insert_with(|| {
                    self.places.push(place);
                    (self.places.len() - 1) as u32
                })
            })
            .collect();
        let normals: Vec<Option<DVec3>> =
            (0..mesh.normals.len() / 3).map(|i| triple(&mesh.normals, i).try_normalize()).collect();
        let corner = |at: usize| {
            let normal = mesh.normal_indices.get(at).and_then(|n| normals.get(*n as usize).copied().flatten());
            (sites[mesh.indices[at] as usize], normal)
        };
        // No arities: all are triangles.
        let faces = if mesh.face_arities.is_empty() { mesh.indices.len() / 3 } else { mesh.face_arities.len() };
        let mut start = 0;
        for face in 0..faces {
            let end = start + mesh.face_arities.get(face).map_or(3, |arity| *arity as usize);
            self.polygons.push((start..end).map(corner));
            start = end;
        }
    }
}
