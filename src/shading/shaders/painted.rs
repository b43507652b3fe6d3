//! Colors and normals of a painted mesh at a pixel.

use std::sync::Arc;

use glam::DVec3;

use crate::shading::{
    frame::Frame,
    mesh::{Coat, Paint, PaintedCorner},
};

/// The paint of a frame.
#[derive(Clone, Debug)]
pub struct Painted {
    /// The triangles of the frame.
    triangles: Vec<PaintedTriangle>,
    /// Has their textures.
    paint: Arc<Paint>,
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
    /// Returns the paint of `frame`, if it has any.
    pub fn of(frame: &Frame) -> Option<Painted> {
        let paint = frame.paint.as_ref()?;
        let triangle = |t: usize| {
            let drawn = &frame.triangles[t];
            let [a, b, c] = paint.corners[drawn.of_mesh as usize];
            let corners = if drawn.is_back { [a, c, b] } else { [a, b, c] };
            let turned = |corner: PaintedCorner| {
                let tangent = frame.view.rotation * corner.tangent.truncate();
                // The back's normal is reversed; its textures stay where they are.
                let side = if drawn.is_back { -corner.tangent.w } else { corner.tangent.w };
                PaintedCorner { tangent: tangent.extend(side), ..corner }
            };
            PaintedTriangle {
                corners: corners.map(turned),
                nearness: frame.corners(t).map(|v| frame.view.nearness(v.eye.z)),
                coat: paint.of_triangles[drawn.of_mesh as usize],
            }
        };
        Some(Painted { triangles: frame.each_triangle(triangle), paint: paint.clone() })
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
        (&self.paint.coats[*coat as usize], mean)
    }
}
