//! Every shader in plain f64, one pixel at a time: the truth that the fast ways of drawing are held against.

use glam::{DVec2, DVec3};

use crate::{
    light::{Interpolation, LinearImage},
    shading::{
        frame::{
            Across, Frame, FrameTriangle, Patches,
            boundary::{self, Blend, EdgeConstants},
            coverage,
        },
        shaders::{
            Correction, Shade, Shader, cut, exact, fixed, flat, gouraud, gradient, phong, quadratic, reweight, vertex,
        },
    },
};

/// A frame ready to be shaded.
#[derive(Clone, Debug)]
pub struct Reference<'f> {
    frame: &'f Frame,
    shade: Shade,
    /// I_n as printed, for what is printed.
    step: Interpolation,
    /// I_n that reaches 0 and 1, for what is ours or repaired.
    blend: Blend,
    edges: Vec<[EdgeConstants; 3]>,
    lit: Lit,
}

/// What there is besides the lights of the vertices.
#[derive(Clone, Debug)]
enum Lit {
    Vertices,
    Faces(Vec<DVec3>),
    Middles(Vec<[DVec3; 3]>),
    Patches(Patches),
}

impl<'f> Reference<'f> {
    /// Computes what `shade` needs of `frame` once: the constants of its edges, the lights besides the vertices'.
    #[must_use]
    pub fn new(frame: &'f Frame, shade: &Shade) -> Self {
        let triangles = 0..frame.triangles.len();
        let lit = match shade.shader {
            Shader::Flat => Lit::Faces(triangles.map(|t| flat::light(frame, t)).collect()),
            Shader::Quadratic => Lit::Middles(triangles.map(|t| quadratic::middles(frame, t)).collect()),
            Shader::Patch => Lit::Patches(Patches::new(frame, shade.gradients)),
            _ => Lit::Vertices,
        };
        Reference {
            frame,
            shade: *shade,
            step: Interpolation::new(shade.depth),
            blend: Blend::new(shade.depth),
            edges: boundary::edge_constants(frame),
            lit,
        }
    }

    /// The constants of every triangle's edges.
    #[must_use]
    pub fn edges(&self) -> &[[EdgeConstants; 3]] {
        &self.edges
    }

    /// The light at the weights `w` of `triangle`, linear. The shader's light first, then vertex shading, then
    /// reweighting.
    ///
    /// # Panics
    /// If the frame has no such triangle.
    #[must_use]
    pub fn light(&self, triangle: usize, w: [f64; 3]) -> DVec3 {
        let corners = self.frame.corners(triangle);
        let (lights, places) = (corners.map(|v| v.light), corners.map(|v| v.screen));
        // Corrections have the paper's strips, also on *cut*, whose own may be wider.
        let b = self.shade.strip().min(1.0 / 3.0);
        let value = self.shaded(triangle, w, lights);
        let value = match self.shade.vertex {
            Correction::Off => value,
            Correction::Printed => vertex::printed(value, w, lights, places, b, &self.step),
            Correction::Repaired => vertex::repaired(value, w, lights, places, b, &self.blend),
        };
        let normal = || gouraud::weighted(w, corners.map(|v| v.normal)).length();
        match self.shade.reweight {
            Correction::Off => value,
            Correction::Printed => reweight::printed(value, w, normal(), b, &self.step),
            Correction::Repaired => {
                reweight::repaired(value, gouraud::weighted(w, corners.map(|v| v.ambient)), normal())
            }
        }
    }

    fn shaded(&self, t: usize, w: [f64; 3], lights: [DVec3; 3]) -> DVec3 {
        let b = self.shade.strip();
        let edges = &self.edges[t];
        let sign = match self.shade.shader {
            Shader::GradientRepaired => gradient::Sign::Repaired,
            _ => gradient::Sign::Printed,
        };
        match (self.shade.shader, &self.lit) {
            (_, Lit::Faces(faces)) => faces[t],
            (_, Lit::Middles(middles)) => quadratic::quadratic(w, lights, middles[t]),
            (_, Lit::Patches(patches)) => patches.light(t, w),
            (Shader::Phong, _) => phong::light(self.frame, t, w),
            (Shader::Fixed, _) => fixed::fixed(w, lights, b, &self.step),
            (Shader::Gradient | Shader::GradientRepaired, _) => {
                gradient::gradient(w, lights, self.apexes(&self.frame.triangles[t]), sign, b, &self.step)
            }
            (Shader::Exact, _) => {
                let widths = [0, 1, 2].map(|k| boundary::tapered(k, w, b));
                exact::exact(w, lights, edges.map(|edge| edge.c), widths, &self.blend)
            }
            (Shader::Cut, _) => cut::cut(w, lights, edges, b.min(1.0), &self.blend),
            _ => gouraud::weighted(w, lights),
        }
    }

    /// The lights of the neighbours' vertices across each edge.
    fn apexes(&self, triangle: &FrameTriangle) -> [Option<DVec3>; 3] {
        triangle.across.map(|across| match across {
            Across::Triangle { apex, .. } => Some(self.frame.vertices[apex as usize].light),
            Across::Nothing | Across::Several => None,
        })
    }

    /// The whole picture, every pixel at its centre.
    #[must_use]
    pub fn image(&self) -> LinearImage {
        let frame = self.frame;
        let seen = coverage::visible(frame);
        LinearImage::from_fn(frame.width, frame.height, |x, y| {
            let light = match seen[y as usize * frame.width as usize + x as usize] {
                coverage::NONE => frame.background,
                triangle => {
                    let centre = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
                    self.light(triangle as usize, frame.weights(triangle as usize, centre))
                }
            };
            light.as_vec3().to_array()
        })
    }
}
