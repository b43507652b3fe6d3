//! The smooth surface that a mesh approximates, as the picture should show it: traced along the line of sight of every
//! pixel, or taken from a much finer mesh. The colors of maps of the difference.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use crate::{
    light::LinearImage,
    shading::{
        frame::{Frame, FrameVertex, coverage},
        mesh::Surface,
    },
    system::checkpoint,
};

/// The point of the smooth surface at each pixel of a frame.
#[derive(Clone, Debug)]
pub struct Truth {
    /// Row by row from the top left; `None` where there is only background.
    points: Vec<Option<Point>>,
}

/// A point of the surface in eye space, with its unit normal toward the eye.
#[derive(Clone, Copy, Debug)]
struct Point {
    eye: DVec3,
    normal: DVec3,
}

impl Truth {
    /// Traces the surface that the mesh of `frame` approximates; `None` if it is not known.
    pub fn traced(frame: &Frame) -> Option<Truth> {
        let smooth = frame.smooth?;
        let ((center, radius), rotation) = (frame.sphere, frame.view.rotation);
        let back = rotation.transpose();
        Some(Truth::of_pixels(frame, |screen| {
            let (from, along) = frame.view.ray(screen);
            // Everything lies within two radii of the center.
            let start = if frame.view.distance.is_finite() { (frame.view.distance - 2.0).max(0.0) } else { 0.0 };
            let (origin, along) = (center + back * (from + along * start) * radius, back * along);
            let hit = smooth.trace(origin, along, 4.0 * radius)?;
            Some(Point { eye: rotation * (hit - center) / radius, normal: rotation * smooth.normal(hit) })
        }))
    }

    /// Takes the surface from `fine`, a finer mesh of the surface that the mesh of `frame` approximates.
    pub fn of_mesh(frame: &Frame, fine: &Surface) -> Truth {
        let fine = Frame::within(frame.sphere, fine, &frame.view, &frame.lighting, frame.background);
        let seen = coverage::visible(&fine);
        Truth::of_pixels(frame, |screen| {
            let pixel = screen.y as usize * frame.view.width as usize + screen.x as usize;
            let triangle = Some(seen[pixel]).filter(|triangle| *triangle != coverage::NONE)? as usize;
            let (corners, weights) = (fine.corners(triangle), fine.weights(triangle, screen));
            let sum = |of: fn(&FrameVertex) -> DVec3| -> DVec3 {
                corners.iter().zip(weights).map(|(corner, weight)| of(corner) * weight).sum()
            };
            Some(Point { eye: sum(|v| v.eye), normal: sum(|v| v.normal).normalize_or(DVec3::Z) })
        })
    }

    fn of_pixels(frame: &Frame, point: impl Fn(DVec2) -> Option<Point> + Sync) -> Truth {
        let width = frame.view.width as usize;
        let at = |i: usize| {
            checkpoint();
            let point = point(DVec2::new((i % width) as f64 + 0.5, (i / width) as f64 + 0.5))?;
            let is_back = point.normal.dot(frame.view.to_viewer(point.eye)) < 0.0;
            Some(if is_back { Point { normal: -point.normal, ..point } } else { point })
        };
        // Unwinding at every pixel would take longer than the pixels do.
        let pixels = (0..width * frame.view.height as usize).into_par_iter().with_min_len(width);
        Truth { points: pixels.map(at).collect() }
    }

    /// Returns the picture of the surface under the lighting of `frame`, in linear light, or encoded as the frame is.
    pub fn picture(&self, frame: &Frame) -> LinearImage {
        LinearImage::from_fn(frame.view.width, frame.view.height, |x, y| {
            let light = match &self.points[(y * frame.view.width + x) as usize] {
                Some(point) => frame.lit(point.eye, point.normal),
                None => frame.background,
            };
            light.as_vec3().to_array()
        })
    }

    /// Returns the number of pixels that show either the mesh of `frame` or this surface, as a share of those that show
    /// the mesh.
    pub fn apart(&self, frame: &Frame) -> f64 {
        let meshed = coverage::visible(frame).into_iter().map(|triangle| triangle != coverage::NONE);
        let (all, apart) = self.points.iter().zip(meshed).fold((0_u32, 0_u32), |(all, apart), (point, meshed)| {
            (all + u32::from(meshed), apart + u32::from(meshed != point.is_some()))
        });
        f64::from(apart) / f64::from(all.max(1))
    }

    /// For each pixel, returns true if both `frame` and this picture show the surface there, and no outline or meant
    /// crease is within three pixels; or, where a shader's picture should look like the surface if it is `lit`: no
    /// outline, meant crease, or terminator of a lamp is within two pixels, and the surface does not turn away by more
    /// than 72.5°.
    pub fn mask(&self, frame: &Frame, lit: bool) -> Vec<bool> {
        let (least, margin) = if lit { (0.3, 2) } else { (f64::NEG_INFINITY, 3) };
        let meshed = coverage::interior_mask(frame);
        let faces =
            |point: &Option<Point>| point.as_ref().is_some_and(|p| p.normal.dot(frame.view.to_viewer(p.eye)) >= least);
        let mut inside: Vec<bool> =
            self.points.iter().zip(meshed).map(|(point, meshed)| faces(point) && meshed).collect();
        for (here, there) in coverage::neighbors(frame) {
            if !self.is_joined(frame, lit, here, there) {
                (inside[here], inside[there]) = (false, false);
            }
        }
        for _ in 0..margin {
            inside = eroded(&inside, frame.view.width as usize);
        }
        inside
    }

    /// True if the surface continues from one pixel to its neighbor to the right or below, and, with `lamps`, every lamp
    /// lights both or neither.
    fn is_joined(&self, frame: &Frame, lamps: bool, here: usize, there: usize) -> bool {
        let (Some(a), Some(b)) = (&self.points[here], &self.points[there]) else { return false };
        let step = if there == here + 1 { DVec2::X } else { DVec2::NEG_Y };
        // A plane with the point's normal rises by this per step toward the eye, in a parallel projection.
        let rise = |point: &Point| (point.normal.truncate().dot(step) / point.normal.z.max(1e-3)).abs();
        let pixel = 1.0 / frame.view.pixels_per_unit();
        let is_continuous = (a.eye.z - b.eye.z).abs() <= 2.0 * pixel * (rise(a).max(rise(b)) + 1.0);
        let is_smooth = a.normal.dot(b.normal) > MEANT_CREASE;
        let is_lit = |point: &Point, lamp: usize| frame.lighting.lamps[lamp].toward(point.eye).dot(point.normal) > 0.0;
        let same = |lamp| is_lit(a, lamp) == is_lit(b, lamp);
        is_continuous && is_smooth && (!lamps || (0..frame.lighting.lamps.len()).all(same))
    }
}

/// The cosine between the normals of neighboring pixels below which the surface itself has a crease.
const MEANT_CREASE: f64 = 0.7;

/// Removes the pixels that have a neighbor outside.
fn eroded(inside: &[bool], width: usize) -> Vec<bool> {
    let at = |i: Option<usize>| i.and_then(|i| inside.get(i)).copied().unwrap_or(false);
    let is_inside = |i: usize| {
        let (left, right) =
            (i.checked_sub(1).filter(|_| !i.is_multiple_of(width)), Some(i + 1).filter(|_| i % width + 1 < width));
        inside[i] && [left, right, i.checked_sub(width), Some(i + width)].into_iter().all(at)
    };
    (0..inside.len()).map(is_inside).collect()
}

/// The scale from nothing to the largest value, as encoded sRGB: from blue through gray to yellow, with increasing lightness,
/// so that all trichromats and dichromats see the same order.
const MAP: [[f64; 3]; 5] =
    [[0.13, 0.19, 0.42], [0.27, 0.36, 0.58], [0.55, 0.53, 0.52], [0.86, 0.72, 0.33], [1.0, 0.96, 0.62]];

/// Returns the color of a value that is this share of the largest, as encoded sRGB.
pub fn color(share: f64) -> [f64; 3] {
    let at = share.clamp(0.0, 1.0) * (MAP.len() - 1) as f64;
    let low = (at as usize).min(MAP.len() - 2);
    let (a, b) = (DVec3::from_array(MAP[low]), DVec3::from_array(MAP[low + 1]));
    a.lerp(b, at - low as f64).to_array()
}
