//! Two measures of a shader: the creases that it leaves at the edges of triangles, and the smooth surface with which
//! its picture can be compared.
//!
//! A crease is the jump of the slope of the light on the screen.
//!
//! Creases are measured on the light itself, by one-sided differences between the light values that a shader gives at
//! points close to the edge. No shader's formula is used, so errors in the shaders show up here. A jump of the slope is
//! a property of the light. Whether it is visible as a band is another question, which depends on its size, its length,
//! and its surroundings.
//!
//! The smooth surface is traced along the line of sight of every pixel, or taken from a much finer mesh.

use glam::{DVec2, DVec3};
use rayon::prelude::*;
use serde::Serialize;

use crate::{
    light::LinearImage,
    shading::{
        frame::{Frame, FrameVertex, coverage},
        mesh::Surface,
        shaders::{Shade, Shading},
    },
    system::checkpoint,
};

/// The crease at one edge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EdgeCrease {
    /// The edge's length on the screen in pixels.
    pub length: f64,
    /// The jump of the slope normal to the edge, in linear light per pixel: the root mean square along the edge and
    /// over red, green and blue.
    pub jump: f64,
    /// The jump of the light itself, averaged in the same way: 0 for a continuous shader.
    pub step: f64,
}

/// The creases at all edges that two triangles facing the eye share smoothly. Edges are weighted by their length, so
/// splitting an edge into pieces makes no difference.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Creases {
    /// The crease at each edge.
    #[serde(skip)]
    pub edges: Vec<EdgeCrease>,
    /// Root mean square jump of the slope, in linear light per pixel.
    #[serde(rename = "crease_rms")]
    pub rms: f64,
    /// The jump that half of the total edge length does not exceed, in linear light per pixel. Narrow triangles near
    /// silhouettes dominate the rms; the median is typical of most edges.
    #[serde(rename = "crease_median")]
    pub median: f64,
    /// The jump that 95 % of the total edge length does not exceed, in linear light per pixel.
    #[serde(rename = "crease_p95")]
    pub p95: f64,
    /// The largest jump, in linear light per pixel.
    #[serde(rename = "crease_max")]
    pub max: f64,
    /// Root mean square jump of the light itself, in linear light.
    pub step_rms: f64,
}

impl Creases {
    /// Measures the creases of `frame` under a shader. `light(triangle, weights)` must return the light of triangle
    /// `triangle` of the frame at these barycentric weights, which are all at least 0. Steps from the edge change no
    /// weight by more than the share `step`, 0…1, of the smaller weight there.
    pub fn of_field(frame: &Frame, step: f64, light: impl Fn(usize, [f64; 3]) -> DVec3 + Sync) -> Creases {
        let shared: Vec<_> = frame.shared_edges().collect();
        let measured = |sides| {
            checkpoint();
            measured(frame, sides, step, &light)
        };
        let edges: Vec<EdgeCrease> = shared.into_par_iter().map(measured).collect();
        let length: f64 = edges.iter().map(|e| e.length).sum();
        if length <= 0.0 {
            return Creases { edges, ..Creases::default() };
        }
        let rms =
            |of: fn(&EdgeCrease) -> f64| (edges.iter().map(|e| e.length * of(e) * of(e)).sum::<f64>() / length).sqrt();
        let mut sorted: Vec<&EdgeCrease> = edges.iter().collect();
        sorted.sort_by(|a, b| a.jump.total_cmp(&b.jump));
        let max = sorted.last().map_or(0.0, |last| last.jump);
        let at_most = |share: f64| {
            let mut below = 0.0;
            let reached = sorted.iter().find(|edge| {
                below += edge.length;
                below >= share * length
            });
            reached.map_or(max, |edge| edge.jump)
        };
        let (median, p95) = (at_most(0.5), at_most(0.95));
        Creases { rms: rms(|e| e.jump), step_rms: rms(|e| e.step), median, p95, max, edges }
    }

    /// Measures the creases that `shade` leaves in `frame`.
    pub fn of(frame: &Frame, shade: &Shade) -> Creases {
        let shading = Shading::new(frame, shade);
        // The step must be much smaller than the strips. Below b = 1e-6, rounding would dominate.
        let step = if shade.boundary > 0.0 { STEP.min(shade.strip() * 1e-2).max(1e-8) } else { STEP };
        Creases::of_field(frame, step, |triangle, weights| shading.light(triangle, weights))
    }
}

/// The number of points along an edge at which the slopes are compared.
const POINTS: usize = 6;

/// The largest change of a barycentric weight in a step, relative to the smaller weight at the edge. Strips are many
/// such steps wide, and rounding errors are still ten digits below the slope.
const STEP: f64 = 1e-5;

/// The largest jump that rounding produces in a field without creases, in linear light per pixel.
pub const NOISE: f64 = 1e-9;

/// Measures the crease at the edge between two triangles, each given with its corner opposite the edge.
fn measured(
    frame: &Frame,
    sides: [(usize, usize); 2],
    step: f64,
    light: &impl Fn(usize, [f64; 3]) -> DVec3,
) -> EdgeCrease {
    let (mut jump2, mut step2) = (0.0, 0.0);
    for point in 0..POINTS {
        let s = (point as f64 + 0.5) / POINTS as f64;
        // The two triangles traverse the edge in opposite directions.
        let [own, theirs] =
            [(sides[0], s), (sides[1], 1.0 - s)].map(|(side, s)| one_sided(frame, side, s, step, light));
        step2 += (own.0 - theirs.0).length_squared();
        // Each slope points into its own triangle. The directions are opposite, so the sum of the slopes is the jump.
        jump2 += (own.1 + theirs.1).length_squared();
    }
    let samples = (3 * POINTS) as f64;
    let (t, k) = sides[0];
    let [a, b] = [1, 2].map(|i| frame.corners(t)[(k + i) % 3].screen);
    EdgeCrease { length: a.distance(b), jump: (jump2 / samples).sqrt(), step: (step2 / samples).sqrt() }
}

/// Returns the light, and its slope normal to the edge opposite corner `k` into triangle `t`, at the point that divides
/// the edge s : 1 − s.
fn one_sided(
    frame: &Frame,
    (t, k): (usize, usize),
    s: f64,
    step: f64,
    light: &impl Fn(usize, [f64; 3]) -> DVec3,
) -> (DVec3, DVec3) {
    let (i, j) = ((k + 1) % 3, (k + 2) % 3);
    let corners = frame.corners(t).map(|v| v.screen);
    let (along, up) = (corners[j] - corners[i], corners[k] - corners[i]);
    let foot = up.dot(along) / along.length_squared();
    let height = along.perp_dot(up).abs() / along.length();
    // Per pixel along the normal, w_k grows by 1/height; the position of its foot determines how much each of the other
    // weights falls.
    let rates = (-(1.0 - foot) / height, -foot / height);
    let fastest = rates.0.abs().max(rates.1.abs()).max(1.0 / height);
    let h = step * s.min(1.0 - s) / fastest;
    let at = |steps: f64| {
        let mut w = [0.0; 3];
        w[k] = steps * h / height;
        w[i] = (1.0 - s) + steps * h * rates.0;
        w[j] = s + steps * h * rates.1;
        light(t, w)
    };
    // The slope of the parabola through three points.
    let here = at(0.0);
    (here, (4.0 * at(1.0) - at(2.0) - 3.0 * here) / (2.0 * h))
}

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
            let point = point(frame.view.center(i))?;
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
