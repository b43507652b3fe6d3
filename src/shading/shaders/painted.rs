//! Colors and normals of a painted mesh at a pixel.

use std::sync::Arc;

use glam::DVec3;

use super::shade::Shader;
use crate::shading::{
    frame::Frame,
    mesh::{Coat, PaintedCorner, Texture},
    number::Number,
};

/// The paint of a frame.
#[derive(Clone, Debug)]
pub struct Painted {
    /// The triangles of the frame.
    triangles: Vec<PaintedTriangle>,
    /// Their textures.
    coats: Vec<Coat>,
}

/// The paint of a triangle of a frame.
#[derive(Clone, Copy, Debug)]
struct PaintedTriangle {
    /// Its corners, with tangents in eye space.
    corners: [PaintedCorner; 3],
    /// [`View::nearness`] of each corner.
    ///
    /// [`View::nearness`]: crate::shading::View::nearness
    nearness: [f64; 3],
    /// The index of its coat.
    coat: u32,
}

impl Painted {
    /// Returns the paint of `frame` for a shader, if it has any. A renderer that ignores gamma multiplies the encoded
    /// light of the vertices by encoded colors.
    pub fn of(frame: &Frame, shader: Shader) -> Option<Painted> {
        let paint = frame.paint.as_ref()?;
        let encoding = frame.encoding.as_ref().filter(|_| !shader.lights_pixels());
        let stored = |color: [f64; 3]| encoding.map_or(color, |transfers| transfers.encoded_from_linear(color));
        let coat = |coat: &Coat| Coat {
            base: coat.base.as_ref().map(|base| match encoding {
                Some(_) => {
                    let texels =
                        base.texels.iter().map(|texel| stored(texel.map(f64::from)).map(|x| x as f32)).collect();
                    Arc::new(Texture { texels, ..**base })
                }
                None => base.clone(),
            }),
            normals: coat.normals.clone(),
        };
        let triangle = |t: usize| {
            let drawn = &frame.triangles[t];
            let [a, b, c] = paint.corners[drawn.of_mesh as usize];
            let corners = if drawn.is_back { [a, c, b] } else { [a, b, c] };
            let turned = |corner: PaintedCorner| {
                let tangent = frame.view.rotation * corner.tangent.truncate();
                // The back's normal is reversed; its textures stay where they are.
                let side = if drawn.is_back { -corner.tangent.w } else { corner.tangent.w };
                let color = DVec3::from_array(stored(corner.color.to_array()));
                PaintedCorner { tangent: tangent.extend(side), color, ..corner }
            };
            PaintedTriangle {
                corners: corners.map(turned),
                nearness: frame.corners(t).map(|v| frame.view.nearness(v.eye.z)),
                coat: paint.of_triangles[drawn.of_mesh as usize],
            }
        };
        let triangles = frame.each_triangle(triangle);
        Some(Painted { triangles, coats: paint.coats.iter().map(coat).collect() })
    }

    /// Multiplies the light at the weights `w` of a triangle by its color.
    #[inline(always)]
    pub fn tinted<N: Number, const C: usize>(&self, triangle: usize, w: [N; 3], light: [N; C]) -> [N; C] {
        let color: [N; 3] = N::each(w, |w| {
            let (coat, corner) = self.at(triangle, w);
            coat.color(&corner).to_array()
        });
        let mut tinted = light;
        for c in 0..C {
            tinted[c] = light[c] * color[c % 3];
        }
        tinted
    }

    /// Returns the color and the normal at the weights `w` of a triangle whose shader gives the unit normal `normal`.
    #[inline(always)]
    pub fn surface<N: Number, const C: usize>(&self, triangle: usize, w: [N; 3], normal: [N; 3]) -> ([N; C], [N; 3]) {
        let both: [N; 6] = N::each([w[0], w[1], w[2], normal[0], normal[1], normal[2]], |[a, b, c, x, y, z]| {
            let (coat, corner) = self.at(triangle, [a, b, c]);
            let (color, normal) = (coat.color(&corner), coat.normal(&corner, DVec3::new(x, y, z)));
            [color.x, color.y, color.z, normal.x, normal.y, normal.z]
        });
        let mut color = [both[0]; C];
        for c in 0..C {
            color[c] = both[c % 3];
        }
        (color, [both[3], both[4], both[5]])
    }

    /// Interpolates the corners of a triangle with correction for perspective.
    fn at(&self, triangle: usize, w: [f64; 3]) -> (&Coat, PaintedCorner) {
        let PaintedTriangle { corners, nearness, coat } = &self.triangles[triangle];
        let weights = [0, 1, 2].map(|k| w[k] * nearness[k]);
        let sum: f64 = weights.iter().sum();
        let mean = PaintedCorner::mean(corners, weights.map(|weight| weight / sum));
        (&self.coats[*coat as usize], mean)
    }
}
