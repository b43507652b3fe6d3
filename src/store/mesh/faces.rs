//! Faces from files, which become a mesh.

use std::{
    collections::{BTreeSet, HashMap},
    f64::consts::PI,
};

use glam::DVec3;

use super::MeshFile;

use crate::{
    light::Transfer,
    shading::{Coat, Mesh, Normals, PaintedCorner, Polygons},
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
    /// What the reader ignored or assumed, as sentences without their ends.
    pub notes: Vec<String>,
    /// True if faces without normals are flat.
    pub is_flat: bool,
    /// True if faces without an area were left out.
    is_degenerate: bool,
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

    /// Adds a face, with its coat if it is painted. Corners that repeat their neighbor are left out, and so are faces with
    /// fewer than three others: they would make edges of their own.
    pub fn add(&mut self, mut corners: Vec<(u32, Option<DVec3>, PaintedCorner)>, coat: Option<u32>) {
        corners.dedup_by_key(|(site, ..)| *site);
        if corners.len() > 1 && corners[0].0 == corners[corners.len() - 1].0 {
            corners.pop();
        }
        match coat {
            _ if corners.len() < 3 => self.is_degenerate = true,
            Some(coat) => self.polygons.push_painted(corners, coat),
            None => self.polygons.push(corners.into_iter().map(|(site, normal, _)| (site, normal))),
        }
    }

    /// Returns the mesh, with edges joined that lie in the same place, and with faces reversed so that neighbors have the
    /// same winding. `expected` says what a file with faces has, and `normals` which normals will be used.
    ///
    /// # Errors
    /// There are no faces, none of them has an area, or they cover the same place too often.
    pub fn mesh(
        mut self,
        file: &str,
        crease_deg: f64,
        expected: &str,
        normals: Normals,
    ) -> Result<MeshFile, FileErrors> {
        let repeated = self.polygons.drop_repeated();
        let joined = self.polygons.weld(&self.positions);
        self.is_degenerate |= joined > 0;
        let [reversed, turned, opposed] = self.polygons.unify_winding(&self.positions);
        // Not before the winding is right, which decides to which side they face.
        if self.is_flat && self.polygons.flatten(&self.positions) {
            let note = "faces without normals are flat, as the specification of glTF says; averaged normals would make them smooth";
            self.notes.push(note.to_owned());
        }
        let has_normals = self.polygons.has_normals();
        if crease_deg != 180.0 && self.polygons.has_all_normals() {
            self.notes.push("the crease angle has no effect, because every corner has a normal".to_owned());
        }
        if self.polygons.ends.is_empty() && !self.is_degenerate {
            return Err(FileErrors::whole(file, format!("has no faces; expected {expected}")));
        }
        let mesh = Mesh::from_polygons(&self.positions, &self.polygons, crease_deg)
            .map_err(|message| FileErrors::whole(file, message))?;
        let area = |[a, b, c]: [DVec3; 3]| (b - a).cross(c - a).length() / 2.0;
        let (area, (_, radius)) =
            ((0..mesh.triangles.len()).map(|i| area(mesh.corners(i))).sum::<f64>(), mesh.bounds());
        let layers = area / (PI * radius * radius);
        if layers > MAX_LAYERS {
            let message =
                format!("its triangles cover its outline {layers:.0} times; expected at most {MAX_LAYERS} times");
            return Err(FileErrors::whole(file, message));
        }
        let Self { mut notes, .. } = self;
        for (number, what, of, why) in [
            (repeated, "left out", "repeated face", ""),
            (reversed, "reversed", "face", ", because the neighbors go around the other way"),
            (turned, "reversed", "face", ", because the surface was inside out"),
            (opposed, "reversed", "face", ", because the normals point to the other side"),
            (joined, "joined vertices within a thousandth of an edge at", "place", ""),
        ] {
            if number > 0 {
                notes.push(format!("{what} {number} {of}{}{why}", if number == 1 { "" } else { "s" }));
            }
        }
        let is_wanted = !has_normals && matches!(normals, Normals::Given | Normals::Best);
        Ok(MeshFile { mesh: if is_wanted { mesh.estimated(Normals::Best) } else { mesh }, notes })
    }
}

/// What an OBJ or PLY file lists: vertices, normals, and faces that refer to them.
#[derive(Default)]
pub(super) struct Listed {
    pub vertices: Vec<DVec3>,
    /// The color of each vertex, as it is written; shorter if the last ones have none.
    colors: Vec<Option<DVec3>>,
    /// The normals; `None` for a normal that is zero or not finite.
    pub normals: Vec<Option<DVec3>>,
    /// The corners of all faces, each with its vertex and its normal, from 0.
    pub corners: Vec<(usize, Option<usize>)>,
    /// Where each face ends in `corners`.
    pub ends: Vec<usize>,
    /// What was ignored.
    pub notes: BTreeSet<&'static str>,
}

impl Listed {
    /// Adds a vertex, with its color as it is written.
    pub fn vertex(&mut self, position: DVec3, color: Option<DVec3>) {
        if color.is_some() {
            self.colors.resize(self.vertices.len(), None);
            self.colors.push(color);
        }
        self.vertices.push(position);
    }

    pub fn faces(self) -> Faces {
        let mut faces = Faces { notes: self.notes.into_iter().map(str::to_owned).collect(), ..Faces::default() };
        let largest = self.colors.iter().flatten().map(|color| color.max_element()).fold(0.0, f64::max);
        if largest > 1.0 {
            faces.notes.push("colors above 1 are taken as codes of 8 bits".to_owned());
        }
        let coat = (!self.colors.is_empty()).then_some(0);
        faces.polygons.coats.extend(coat.map(|_| Coat::default()));
        let mut start = 0;
        for end in self.ends {
            let corner = |(vertex, normal): &(usize, Option<usize>)| {
                let color = self.colors.get(*vertex).copied().flatten();
                (faces.site(self.vertices[*vertex]), normal.and_then(|n| self.normals[n]), paint(color, largest))
            };
            let corners = self.corners[start..end].iter().map(corner).collect();
            faces.add(corners, coat);
            start = end;
        }
        faces
    }
}

/// Returns the paint of a vertex with this sRGB color, from 0 to 1, or from 0 to 255 if the `largest` number of the file's
/// colors is above 1.
fn paint(color: Option<DVec3>, largest: f64) -> PaintedCorner {
    let full = if largest > 1.0 { 255.0 } else { 1.0 };
    // NaN counts as 0.
    let channel = |code: f64| Transfer::Srgb.linear_from_encoded(if code > 0.0 { (code / full).min(1.0) } else { 0.0 });
    let color = color.map_or(DVec3::ONE, |color| DVec3::from_array(color.to_array().map(channel)));
    PaintedCorner { color, ..PaintedCorner::default() }
}

/// Returns the triangles of a strip, every other one of which goes around the other way.
pub(super) fn strip_triangles<T: Copy>(strip: &[T]) -> Vec<[T; 3]> {
    let turned = |(i, w): (usize, &[T])| if i % 2 == 0 { [w[0], w[1], w[2]] } else { [w[1], w[0], w[2]] };
    strip.windows(3).enumerate().map(turned).collect()
}
