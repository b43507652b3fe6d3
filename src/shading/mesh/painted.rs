//! Paints and places meshes.

use std::{collections::HashMap, sync::Arc};

use glam::{DMat3, DVec3, DVec4};

use super::{paint::Paint, triangles::Mesh};

impl Mesh {
    /// Returns this mesh with `paint`, unless that is plain. Corners whose coat has a normal map and which have no
    /// tangent get the mean over the triangles that share their vertex and place on the texture, weighted by area
    /// (Lengyel 2001).
    ///
    /// # Panics
    /// Panics if the paint is not that of as many triangles.
    pub fn painted(mut self, mut paint: Paint) -> Mesh {
        assert_eq!(paint.corners.len(), self.triangles.len(), "every triangle has its paint");
        self.find_tangents(&mut paint);
        self.paint = (!paint.is_plain()).then(|| Arc::new(paint));
        self
    }

    /// Returns this mesh scaled, then rotated, then moved. Which surface it approximates is no longer known.
    pub fn placed(mut self, scale: f64, rotation: DMat3, position: DVec3) -> Mesh {
        for vertex in &mut self.vertices {
            vertex.position = position + rotation * (scale * vertex.position);
            vertex.normal = rotation * vertex.normal;
        }
        for corner in self.paint.iter_mut().flat_map(|paint| Arc::make_mut(paint).corners.iter_mut().flatten()) {
            corner.tangent = (rotation * corner.tangent.truncate()).extend(corner.tangent.w);
        }
        self.smooth = None;
        self
    }

    fn find_tangents(&self, paint: &mut Paint) {
        let wants = |t: &usize| {
            paint.coats[paint.of_triangles[*t] as usize].normals.is_some()
                && paint.corners[*t].iter().any(|corner| corner.tangent == DVec4::ZERO)
        };
        let mut means: HashMap<_, DVec3> = HashMap::new();
        let mut keys = Vec::new();
        for t in (0..self.triangles.len()).filter(wants) {
            let ([a, b, c], places) = (self.corners(t), paint.corners[t].map(|corner| corner.place));
            let (u, v) = (places[1] - places[0], places[2] - places[0]);
            let area = u.perp_dot(v);
            // Multiplied by the area on the texture: triangles without one do not count.
            let tangent = ((b - a) * v.y - (c - a) * u.y) * area.signum();
            for (k, place) in places.into_iter().enumerate() {
                let key = (self.triangles[t][k], place.to_array().map(f64::to_bits), area < 0.0);
                *means.entry(key).or_default() += tangent;
                keys.push((t, k, key));
            }
        }
        for (t, k, key) in keys {
            paint.corners[t][k].tangent = means[&key].normalize_or_zero().extend(if key.2 { -1.0 } else { 1.0 });
        }
    }
}
