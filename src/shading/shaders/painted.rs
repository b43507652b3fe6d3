//! Colors and normals of a painted mesh at a pixel.

use std::sync::Arc;

use glam::DVec3;

use crate::{
    light::Transfers,
    shading::{
        frame::Frame,
        mesh::{Coat, PaintedCorner, Texture},
    },
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
    /// Returns the paint of `frame`, if it has any. A renderer that ignores gamma multiplies the encoded light of the
    /// vertices by encoded colors.
    pub fn of(frame: &Frame, encoding: Option<&Transfers>) -> Option<Painted> {
        let paint = frame.paint.as_ref()?;
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

    /// Returns the color at the weights `w` of a triangle.
    pub fn color(&self, triangle: usize, w: [f64; 3]) -> DVec3 {
        let (coat, corner) = self.at(triangle, w);
        coat.color(&corner)
    }

    /// Returns the color and the normal at the weights `w` of a triangle whose shader gives the unit normal `normal`.
    pub fn surface(&self, triangle: usize, w: [f64; 3], normal: DVec3) -> (DVec3, DVec3) {
        let (coat, corner) = self.at(triangle, w);
        (coat.color(&corner), coat.normal(&corner, normal))
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
