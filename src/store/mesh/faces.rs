//! Faces from files, which become a mesh.

use std::{collections::BTreeSet, f64::consts::PI};

use glam::DVec3;

use super::MeshFile;

use crate::{
    light::Transfer,
    shading::{Coat, Normals, PaintedCorner, Polygons},
    store::FileErrors,
};

/// Maximum number of corners of a face, because triangulation takes quadratic time. The caps of a finely divided
/// cylinder have a few hundred.
pub(super) const MAX_CORNERS: usize = 1024;

/// Maximum area of the triangles, relative to the disk around the mesh, because every layer is drawn. Surfaces have less
/// than ten.
const MAX_LAYERS: f64 = 10_000.0;

/// What a file lists.
#[derive(Default)]
pub(super) struct Faces {
    /// The positions, normals, paint and corners as they are listed.
    pub polygons: Polygons,
    /// The color of each position, as it is written; shorter if the last ones have none.
    colors: Vec<Option<DVec3>>,
    /// What the reader ignored.
    pub ignored: BTreeSet<&'static str>,
    /// What else the reader ignored or assumed, as sentences without their ends.
    pub notes: Vec<String>,
    /// True if faces without normals are flat.
    pub is_flat: bool,
}

impl Faces {
    /// Adds a position, with its color as it is written.
    pub fn position(&mut self, position: DVec3, color: Option<DVec3>) {
        if color.is_some() {
            self.colors.resize(self.polygons.positions.len(), None);
            self.colors.push(color);
        }
        self.polygons.positions.push(position);
    }

    /// Paints the polygons with the colors of their positions, if there are any.
    fn paint(&mut self) {
        let Self { polygons, colors, notes, .. } = self;
        if colors.is_empty() {
            return;
        }
        let largest = colors.iter().flatten().map(|color| color.max_element()).fold(0.0, f64::max);
        if largest > 1.0 {
            notes.push("colors above 1 are taken as codes of 8 bits".to_owned());
        }
        colors.resize(polygons.positions.len(), None);
        polygons.paint = colors.iter().map(|color| paint(*color, largest)).collect();
        polygons.of_polygons = vec![0; polygons.ends.len()];
        polygons.coats = vec![Coat::default()];
    }

    /// Returns the mesh, with vertices merged that are at exactly the same position, with edges joined that lie in the same
    /// place, and with faces reversed so that neighbors have the same winding. `expected` says what a file with faces has,
    /// and `normals` which normals will be used.
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
        if self.polygons.ends.is_empty() {
            return Err(FileErrors::whole(file, format!("has no faces; expected {expected}")));
        }
        self.paint();
        let Self { mut polygons, ignored, notes, is_flat, .. } = self;
        let mut notes: Vec<String> = ignored.into_iter().map(str::to_owned).chain(notes).collect();
        // Before merging, which counts the positions anew.
        polygons.check().map_err(|message| FileErrors::whole(file, message))?;
        polygons.merge();
        polygons.drop_collapsed();
        let repeated = polygons.drop_repeated();
        let joined = polygons.weld();
        let [reversed, turned, opposed] = polygons.unify_winding();
        // Not before the winding is right, which decides to which side they face.
        if is_flat && polygons.flatten() {
            let note = "faces without normals are flat, as the specification of glTF says; averaged normals would make them smooth";
            notes.push(note.to_owned());
        }
        let has_normals = polygons.has_normals();
        if crease_deg != 180.0 && polygons.has_all_normals() {
            notes.push("the crease angle has no effect, because every corner has a normal".to_owned());
        }
        let mesh = polygons.mesh(crease_deg).map_err(|message| FileErrors::whole(file, message))?;
        let area = |[a, b, c]: [DVec3; 3]| (b - a).cross(c - a).length() / 2.0;
        let (area, (_, radius)) =
            ((0..mesh.triangles.len()).map(|i| area(mesh.corners(i))).sum::<f64>(), mesh.bounds());
        let layers = area / (PI * radius * radius);
        if layers > MAX_LAYERS {
            let message =
                format!("its triangles cover its outline {layers:.0} times; expected at most {MAX_LAYERS} times");
            return Err(FileErrors::whole(file, message));
        }
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
