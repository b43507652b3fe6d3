//! A projected and lit surface: everything that the shaders need for one frame.

use std::sync::Arc;

use glam::{DMat3, DVec2, DVec3};

use crate::shading::{
    cubic,
    lighting::Lighting,
    mesh::{Across, Paint, Smooth, Surface},
};

/// A window of pixels, and the rotation and projection of the mesh in it.
///
/// In eye space, x points right, y up, and z toward the eye; the mesh's bounding sphere is the unit sphere around the
/// origin. Positions on the screen are in physical pixels, with x to the right and y **down**; pixel centers are at
/// half-integers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// Pixels per row.
    pub width: u32,
    /// Number of rows.
    pub height: u32,
    /// The rotation from the mesh's own axes to eye space.
    pub rotation: DMat3,
    /// The share of the window's smaller side that the bounding sphere fills.
    pub fill: f64,
    /// Distance of the eye from the mesh's center in radii of the bounding sphere, above 1; infinite for a parallel
    /// projection.
    pub distance: f64,
}

impl View {
    /// Creates a square window of `size` pixels with a fill of 0.9, in parallel projection and without rotation.
    pub fn square(size: u32) -> View {
        View { width: size, height: size, rotation: DMat3::IDENTITY, fill: 0.9, distance: f64::INFINITY }
    }

    /// Returns this view with the mesh rotated by `degrees` about x, then y, then z, counterclockwise as seen from the
    /// tip of the axis.
    pub fn rotated(mut self, degrees: [f64; 3]) -> View {
        let [x, y, z] = degrees.map(f64::to_radians);
        self.rotation = DMat3::from_rotation_z(z) * DMat3::from_rotation_y(y) * DMat3::from_rotation_x(x);
        self
    }

    /// Returns the unit vector from a point in eye space to the eye.
    #[inline]
    pub fn to_viewer(&self, eye: DVec3) -> DVec3 {
        if self.distance.is_finite() { (DVec3::new(0.0, 0.0, self.distance) - eye).normalize() } else { DVec3::Z }
    }

    /// Returns the center of a pixel, which is given by its index, row by row from the top left.
    pub(crate) fn center(&self, pixel: usize) -> DVec2 {
        let width = self.width as usize;
        DVec2::new((pixel % width) as f64, (pixel / width) as f64) + 0.5
    }

    /// Projects a point in eye space: returns its position on the screen and its depth. Depth is 0 at the nearest and 1
    /// at the farthest point, and within a plane it is affine on the screen.
    pub fn project(&self, eye: DVec3) -> (DVec2, f64) {
        let (xy, d) = (eye.truncate() * self.ratio(eye.z), self.distance);
        let depth = if d.is_finite() {
            // 1/(d − z) is affine on the screen.
            1.0 - ((1.0 / (d - eye.z)) - 1.0 / (d + 1.0)) / (1.0 / (d - 1.0) - 1.0 / (d + 1.0))
        } else {
            (1.0 - eye.z) / 2.0
        };
        let middle = DVec2::new(f64::from(self.width), f64::from(self.height)) / 2.0;
        (middle + DVec2::new(xy.x, -xy.y) * self.scale(), depth)
    }

    /// Returns how many times larger than at the rim of the bounding sphere a point with this z is seen. In perspective,
    /// the visible rim of the sphere, not its equator, fills the window.
    fn ratio(&self, z: f64) -> f64 {
        let d = self.distance;
        if d.is_finite() { (d * d - 1.0).sqrt() / (d - z) } else { 1.0 }
    }

    /// Returns the weight of a point with this z in interpolation that is corrected for perspective: the eye's distance
    /// over the point's distance from the eye along z.
    #[inline]
    pub fn nearness(&self, z: f64) -> f64 {
        if self.distance.is_finite() { self.distance / (self.distance - z) } else { 1.0 }
    }

    /// Returns the pixels per radius at the distance at which the rim of the bounding sphere is seen.
    fn scale(&self) -> f64 {
        f64::from(self.width.min(self.height)) * self.fill / 2.0
    }

    /// Returns the pixels per unit of the plane z = 0 in eye space.
    pub fn pixels_per_unit(&self) -> f64 {
        self.scale() * self.ratio(0.0)
    }

    /// Returns the line of sight through a position on the screen: a point on it in front of the bounding sphere, and
    /// its direction, a unit vector.
    pub fn ray(&self, screen: DVec2) -> (DVec3, DVec3) {
        let sight = self.sight(screen).extend(0.0);
        if self.distance.is_finite() {
            let eye = DVec3::new(0.0, 0.0, self.distance);
            (eye, (sight - eye).normalize())
        } else {
            (sight + 2.0 * DVec3::Z, DVec3::NEG_Z)
        }
    }

    /// Returns the point on the plane z = 0 in eye space that a position on the screen shows.
    pub fn sight(&self, screen: DVec2) -> DVec2 {
        let middle = DVec2::new(f64::from(self.width), f64::from(self.height)) / 2.0;
        let xy = (screen - middle) / self.pixels_per_unit();
        DVec2::new(xy.x, -xy.y)
    }
}

impl cubic::Screen for View {
    fn moved(&self, eye: cubic::V, step: cubic::V) -> [f64; 2] {
        let (eye, step) = (DVec3::from(eye), DVec3::from(step));
        // In a parallel projection, the eye is infinitely far away, and only `step` counts.
        let xy = (step.truncate() + eye.truncate() * (step.z / (self.distance - eye.z))) * self.ratio(eye.z);
        (DVec2::new(xy.x, -xy.y) * self.scale()).to_array()
    }

    fn toward(&self, eye: cubic::V) -> cubic::V {
        self.to_viewer(eye.into()).to_array()
    }
}

/// A frame to be shaded. Vertices are on the screen; light values are linear red, green and blue.
#[derive(Clone, Debug)]
pub struct Frame {
    /// The light where there is no surface.
    pub background: DVec3,
    /// The center and radius of the sphere in mesh space that is the unit sphere of eye space.
    pub sphere: (DVec3, f64),
    /// The surface that the mesh approximates, if it is known, in mesh space.
    pub smooth: Option<Smooth>,
    /// The colors and textures of the mesh, if it has any.
    pub paint: Option<Arc<Paint>>,
    /// The vertices. If the surface also shows its back, the vertices of the back follow the vertices of the front.
    pub vertices: Vec<FrameVertex>,
    /// The curvature at the vertices, as in [`Surface::fans`]. The fans of a back follow the fans of the
    /// front.
    pub fans: Vec<Fan>,
    /// The triangles to draw: the ones that face the eye and have an area on the screen, in the order of the mesh.
    pub triangles: Vec<FrameTriangle>,
    /// The edges of the drawn triangles at which the surface is meant to have a crease.
    pub creases: Vec<Side>,
    /// The lighting in eye space, for shaders that light every pixel.
    pub lighting: Lighting,
    /// The window and the position of the eye.
    pub view: View,
}

/// A vertex on the screen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrameVertex {
    /// Position in physical pixels from the top left, with x to the right and y down, in steps of 1/256 as graphics
    /// cards use, so that all renderers agree on which pixel belongs to which triangle.
    pub screen: DVec2,
    /// Depth: 0 is nearest, 1 farthest.
    pub depth: f64,
    /// Position in eye space.
    pub eye: DVec3,
    /// Unit normal in eye space.
    pub normal: DVec3,
    /// The light sent to the eye, evaluated once per frame.
    pub light: DVec3,
}

/// Triangles around a vertex over which the curvature does not jump; usually all of them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fan {
    /// The index into [`Frame::vertices`].
    pub vertex: u32,
    /// dN/dp in eye space; see [`Surface::fans`].
    pub curvature: DMat3,
}

/// A triangle on the screen. Edge k is opposite corner k, from corner k+1 to k+2.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrameTriangle {
    /// Indices into [`Frame::vertices`].
    pub vertices: [u32; 3],
    /// The fans of the corners, as indices into [`Frame::fans`].
    pub fans: [u32; 3],
    /// The fans whose slopes count along the edges; see [`cubic::Surface::sides`].
    pub sides: [[u32; 2]; 3],
    /// The index of the mesh's triangle.
    pub of_mesh: u32,
    /// True if this is the back of the mesh's triangle, whose corners 1 and 2 then swap places.
    pub is_back: bool,
    /// The side of the neighbor across each edge, which shares the edge's vertices; `None` if there is none to join smoothly: the edge is a border of the surface, a
    /// crease, a silhouette (the neighbor faces away or lies on the same side of the edge on the screen), or the edge of
    /// more than two triangles.
    pub across: [Option<Side>; 3],
}

/// A side of a drawn triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Side {
    /// The triangle's index into [`Frame::triangles`].
    pub triangle: u32,
    /// The corner that is opposite the side.
    pub corner: u32,
}

/// The number of positions per pixel on which vertices can lie.
const STEPS: f64 = 256.0;

impl Frame {
    /// Projects and lights `surface` in `view` under `lighting`, in front of `background`. A closed surface shows only
    /// its outside; a surface with a border shows both sides.
    pub fn new(surface: &Surface, view: &View, lighting: &Lighting, background: DVec3) -> Frame {
        Frame::within(surface.mesh.bounds(), surface, view, lighting, background)
    }

    /// Projects `surface` as [`Frame::new`] does, but with the sphere (center and radius) that the view shows given
    /// instead of computed, so that two meshes of the same surface lie in the same place.
    pub fn within(
        (center, radius): (DVec3, f64),
        surface: &Surface,
        view: &View,
        lighting: &Lighting,
        background: DVec3,
    ) -> Frame {
        let mesh = &surface.mesh;
        let scale = if radius > 0.0 { 1.0 / radius } else { 1.0 };
        let rotation = view.rotation;
        let open = surface.across.as_flattened().contains(&Across::Border);
        let mut vertices = Vec::with_capacity(mesh.vertices.len() * if open { 2 } else { 1 });
        let sides = if open { &[1.0, -1.0][..] } else { &[1.0] };
        for side in sides {
            for vertex in &mesh.vertices {
                let eye = rotation * ((vertex.position - center) * scale);
                let normal = rotation * vertex.normal * *side;
                let (screen, depth) = view.project(eye);
                vertices.push(FrameVertex {
                    screen: (screen * STEPS).round() / STEPS,
                    depth,
                    eye,
                    normal,
                    light: lighting.light(eye, normal, view.to_viewer(eye)),
                });
            }
        }
        // The fans of the vertices come first on either side.
        let back = mesh.vertices.len() as u32;
        let fan = |(vertex, rows): (&u32, &cubic::Tensor), side: f64| Fan {
            vertex: vertex + if side < 0.0 { back } else { 0 },
            // The tensors are symmetric, so that their rows are their columns.
            curvature: rotation * DMat3::from_cols_array_2d(rows) * rotation.transpose() * (side / scale),
        };
        let of_mesh = || surface.fans.vertices.iter().zip(&surface.fans.curvature);
        let fans = sides.iter().flat_map(|side| of_mesh().map(|of| fan(of, *side))).collect();
        let mut frame = Frame {
            background,
            sphere: (center, radius),
            smooth: mesh.smooth,
            paint: mesh.paint.clone(),
            vertices,
            fans,
            triangles: Vec::new(),
            creases: Vec::new(),
            lighting: lighting.clone(),
            view: *view,
        };
        frame.find_triangles(surface, open);
        frame
    }

    /// Returns this frame without the paint of the mesh: edges in a texture are neither creases nor bands.
    pub fn unpainted(self) -> Frame {
        Frame { paint: None, ..self }
    }

    /// Returns twice the signed area of the triangle between three points on the screen, positive for a triangle that
    /// faces the eye.
    #[inline]
    pub fn area2(a: DVec2, b: DVec2, c: DVec2) -> f64 {
        // y points down, so a counterclockwise triangle has a negative sum.
        -(b - a).perp_dot(c - a)
    }

    /// Returns the three corners of triangle `triangle`.
    #[inline]
    pub fn corners(&self, triangle: usize) -> [&FrameVertex; 3] {
        let ([a, b, c], vertex) = (self.triangles[triangle].vertices, |v: u32| &self.vertices[v as usize]);
        [vertex(a), vertex(b), vertex(c)]
    }

    /// Calls `of` with each triangle's index and collects the results.
    pub(crate) fn each_triangle<R>(&self, of: impl Fn(usize) -> R) -> Vec<R> {
        (0..self.triangles.len()).map(of).collect()
    }

    /// Returns the barycentric weights of a point on the screen with respect to triangle `triangle`.
    #[inline]
    pub fn weights(&self, triangle: usize, p: DVec2) -> [f64; 3] {
        let [a, b, c] = self.corners(triangle);
        let (a, b, c) = (a.screen, b.screen, c.screen);
        let area = Frame::area2(a, b, c);
        let (wa, wb) = (Frame::area2(p, b, c) / area, Frame::area2(p, c, a) / area);
        [wa, wb, 1.0 - wa - wb]
    }

    /// Returns the depth, which is affine on the screen, where the corners of triangle `triangle` have these weights.
    pub fn depth(&self, triangle: usize, weights: [f64; 3]) -> f64 {
        self.corners(triangle).iter().zip(weights).map(|(vertex, weight)| weight * vertex.depth).sum()
    }

    /// Returns the light that a point of the surface at `eye` with the unit normal `normal` sends to the eye.
    pub fn lit(&self, eye: DVec3, normal: DVec3) -> DVec3 {
        self.lighting.light(eye, normal, self.view.to_viewer(eye))
    }

    fn find_triangles(&mut self, surface: &Surface, open: bool) {
        let mesh = &surface.mesh;
        let back = mesh.vertices.len() as u32;
        let mut count = 0;
        // For each triangle of the mesh, its index among the drawn triangles and its corners; the corners of a back are
        // reversed.
        let drawn: Vec<Option<(u32, [u32; 3])>> = mesh
            .triangles
            .iter()
            .map(|t| {
                let [a, b, c] = t.map(|v| self.vertices[v as usize].screen);
                let area = Frame::area2(a, b, c);
                let is_back = open && area < 0.0;
                // An area that is NaN counts as no area.
                (area > 0.0 || is_back).then(|| {
                    count += 1;
                    (count - 1, if is_back { [t[0] + back, t[2] + back, t[1] + back] } else { *t })
                })
            })
            .collect();
        for (t, drawn_as) in drawn.iter().enumerate() {
            let Some((_, corners)) = *drawn_as else { continue };
            let is_back = corners[0] >= back;
            let [a, b, c] = surface.across[t];
            // The back is the triangle with its corners reversed, so its edges 1 and 2 swap places.
            let beyond = if is_back { [a, c, b] } else { [a, b, c] };
            let across = beyond.map(|side| {
                let Across::Smooth(side) = side else { return None };
                let (other, k) = ((side / 3) as usize, (side % 3) as usize);
                let apex = mesh.triangles[other][k] + if is_back { back } else { 0 };
                let (triangle, theirs) = drawn[other]?;
                let corner = theirs.iter().position(|vertex| *vertex == apex)? as u32;
                Some(Side { triangle, corner })
            });
            let triangle = self.triangles.len() as u32;
            let meant = (0..).zip(beyond).filter(|(_, side)| matches!(side, Across::Crease(_)));
            self.creases.extend(meant.map(|(corner, _)| Side { triangle, corner }));
            let (mut fans, mut sides) = (surface.fans.triangles[t], surface.fans.sides[t]);
            if is_back {
                let of_back = |fan: u32| fan + surface.fans.vertices.len() as u32;
                fans = [fans[0], fans[2], fans[1]].map(of_back);
                sides = [sides[0], sides[2], sides[1]].map(|[next, previous]| [previous, next].map(of_back));
            }
            let of_mesh = t as u32;
            self.triangles.push(FrameTriangle { vertices: corners, fans, sides, of_mesh, is_back, across });
        }
    }

    /// Returns every edge that two triangles share smoothly, once: the two triangles in ascending order, each with the
    /// corner that is opposite the edge.
    pub(crate) fn shared_edges(&self) -> impl Iterator<Item = [(usize, usize); 2]> + '_ {
        let sides = (0..self.triangles.len()).flat_map(|t| [(t, 0), (t, 1), (t, 2)]);
        sides.filter_map(|(t, k)| {
            let other = self.triangles[t].across[k]?;
            let other = (other.triangle as usize, other.corner as usize);
            (t < other.0).then_some([(t, k), other])
        })
    }
}
