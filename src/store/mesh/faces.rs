//! Faces from files, which become a mesh.

use std::{collections::HashMap, f64::consts::PI};

use glam::DVec3;

use crate::{
    shading::{Mesh, MeshError, Polygons},
    store::FileErrors,
};

/// Maximum number of corners of a face, because triangulation takes quadratic time. The caps of a finely divided
/// cylinder have a few hundred.
pub(super) const MAX_CORNERS: usize = 1024;

/// Maximum area of the triangles, relative to the disk around the mesh, because every layer is drawn. Surfaces have less
/// than ten.
const MAX_LAYERS: f64 = 10_000.0;

/// The faces of a file. Vertices at exactly the same position are merged.
#[derive(Default)]
pub(super) struct Faces {
    /// The distinct positions.
    positions: Vec<DVec3>,
    sites: HashMap<[u64; 3], u32>,
    /// The faces, whose sites index the positions.
    pub polygons: Polygons,
}

impl Faces {
    /// Returns the site of a position.
    pub fn site(&mut self, position: DVec3) -> u32 {
        // Adding 0 turns −0 into 0.
        let position = position + DVec3::ZERO;
        *self.sites.entry(position.to_array().map(f64::to_bits)).or_insert_with(|| {
            self.positions.push(position);
            (self.positions.len() - 1) as u32
        })
    }

    /// Returns the mesh, and the number of faces that were reversed so that neighbors have the same winding. `expected`
    /// says what a file with faces has.
    ///
    /// # Errors
    /// There are no faces, none of them has an area, or they cover the same place too often.
    pub fn mesh(mut self, file: &str, crease_deg: f64, expected: &str) -> Result<(Mesh, usize), FileErrors> {
        let reversed = self.polygons.unify_winding();
        let mesh = Mesh::from_polygons(&self.positions, &self.polygons, crease_deg).map_err(|error| {
            let message = match error {
                MeshError::NoTriangles => format!("has no faces; expected {expected}"),
                MeshError::NoArea(_) => "has no face with a nonzero area; expected at least one".to_owned(),
                error => error.to_string(),
            };
            FileErrors::whole(file, message)
        })?;
        let area = |[a, b, c]: [DVec3; 3]| (b - a).cross(c - a).length() / 2.0;
        let (area, (_, radius)) =
            ((0..mesh.triangles.len()).map(|i| area(mesh.corners(i))).sum::<f64>(), mesh.bounds());
        let layers = area / (PI * radius * radius);
        if layers > MAX_LAYERS {
            let message =
                format!("its triangles cover its outline {layers:.0} times; expected at most {MAX_LAYERS} times");
            return Err(FileErrors::whole(file, message));
        }
        Ok((mesh, reversed))
    }
}
