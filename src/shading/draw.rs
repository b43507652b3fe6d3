//! Draws frames: one mesh, or several in one picture, some of them transparent (Shoaff §4.4). Light that is refracted finds
//! the first triangle on its way in a tree of boxes.

use glam::{DMat3, DVec2, DVec3};
use rayon::prelude::*;

use crate::{
    light::LinearImage,
    shading::{
        frame::{Frame, Outline, View, coverage},
        lighting::{Lamp, LampPosition, Lighting, Material, Refraction, Transmits, Transparency},
        mesh::{Mesh, Surface},
        shaders::{Shade, Shading},
    },
    system::checkpoint,
};

/// A mesh with its material.
#[derive(Clone, Debug)]
pub struct Body {
    /// The mesh, placed in the scene.
    pub surface: Surface,
    /// How its light is computed.
    pub shade: Shade,
    /// How it reflects light.
    pub material: Material,
    /// How it transmits light.
    pub transparency: Transparency,
    /// The index of refraction of the medium inside, relative to the medium around the mesh, which may be that of another
    /// one; above 0. Where meshes overlap, their indices multiply. `None` lets light pass straight.
    pub index: Option<f64>,
}

/// Several bodies under the same lamps.
#[derive(Clone, Debug)]
pub struct Composition {
    /// The meshes.
    pub bodies: Vec<Body>,
    /// I_a of red, green and blue.
    pub ambient: DVec3,
    /// The lamps, in the axes and units of the scene.
    pub lamps: Vec<Lamp>,
    /// The light where there is no body.
    pub background: DVec3,
    /// How all bodies are seen, but for the number of pixels.
    pub view: View,
}

/// The number of surfaces that a refracted line of sight meets, at most; after that, it shows the background.
const MAX_MEETINGS: usize = 16;

/// The shortest way of a refracted ray from one surface to the next, in radii of the scene; surfaces that are nearer to each
/// other touch.
const LEAST: f64 = 1e-7;

impl Composition {
    /// Draws the scene in linear light, `width` × `height` pixels, each sampled at its center.
    ///
    /// At every pixel, the bodies' shaders give the light of all surfaces in front of the nearest opaque one, and
    /// [`Transparency::through`] combines them from the farthest to the nearest. Behind a body with an index, the line
    /// of sight is bent where it enters and leaves; what it then meets is lit at that point, whatever its shader. No
    /// body casts shadows.
    pub fn image(&self, width: u32, height: u32) -> LinearImage {
        let view = View { width, height, ..self.view };
        let sphere = Mesh::bounds_of(&self.bodies.iter().map(|body| &body.surface.mesh).collect::<Vec<_>>());
        let lamps: Vec<Lamp> = self.lamps.iter().map(|lamp| in_eye_space(lamp, view.rotation, sphere)).collect();
        let frame = |body: &Body| {
            let lighting = Lighting { material: body.material, ambient: self.ambient, lamps: lamps.clone() };
            Frame::within(sphere, &body.surface, &view, &lighting, self.background)
        };
        let frames: Vec<Frame> = self.bodies.iter().map(frame).collect();
        let drawn = frames.iter().zip(&self.bodies).map(|(frame, body)| Drawn {
            frame,
            shading: Shading::new(frame, &body.shade),
            outlines: coverage::outlines(frame),
        });
        // The triangles of all bodies in eye space.
        let of_body = |(b, (body, frame)): (u32, (&Body, &Frame))| -> Vec<Target> {
            let triangles = (0..).zip(&body.surface.mesh.triangles);
            let corners = |t: &[u32; 3]| t.map(|v| frame.vertices[v as usize].eye);
            triangles.map(|(t, triangle)| Target { of: (b, t), corners: corners(triangle) }).collect()
        };
        let targets = self.bodies.iter().any(|body| body.index.is_some());
        let targets =
            targets.then(|| Targets::new((0..).zip(self.bodies.iter().zip(&frames)).flat_map(of_body).collect()));
        let picture = Picture { scene: self, view, drawn: drawn.collect(), targets };
        in_bands(width, height, |first, pixels| picture.draw(first, pixels))
    }
}

/// Returns the lamp in eye space, where the radius of the scene is 1.
fn in_eye_space(lamp: &Lamp, rotation: DMat3, (center, radius): (DVec3, f64)) -> Lamp {
    let radius = if radius > 0.0 { radius } else { 1.0 };
    let position = match lamp.position {
        LampPosition::Direction(toward) => LampPosition::Direction((rotation * toward).normalize_or_zero()),
        LampPosition::Point { position, attenuation: [c1, c2, c3] } => LampPosition::Point {
            position: rotation * ((position - center) / radius),
            attenuation: [c1, c2 * radius, c3 * radius * radius],
        },
    };
    Lamp { position, ..*lamp }
}

/// A body that is ready to be drawn.
struct Drawn<'f> {
    frame: &'f Frame,
    shading: Shading<'f>,
    outlines: Vec<Option<Outline>>,
}

/// A surface at a pixel.
#[derive(Clone, Copy)]
struct Layer {
    depth: f64,
    body: usize,
    triangle: usize,
}

/// Returns the light of surfaces, the nearest first, in front of some other light.
fn over(surfaces: &[(Transparency, DVec3)], light: DVec3) -> DVec3 {
    surfaces.iter().rev().fold(light, |behind, (transparency, front)| transparency.through(*front, behind))
}

struct Picture<'f> {
    scene: &'f Composition,
    view: View,
    drawn: Vec<Drawn<'f>>,
    /// Every triangle, if any body bends light.
    targets: Option<Targets>,
}

impl Picture<'_> {
    /// Draws the rows from `first`.
    fn draw(&self, first: usize, pixels: &mut [f32]) {
        let width = self.view.width as usize;
        let rows = pixels.len() / (3 * width);
        let mut layers: Vec<Vec<Layer>> = vec![Vec::new(); rows * width];
        for (body, drawn) in self.drawn.iter().enumerate() {
            let within = first as u32..(first + rows) as u32;
            coverage::each_layer(drawn.frame, &drawn.outlines, within, |triangle, at, depth| {
                layers[at].push(Layer { depth, body, triangle });
            });
        }
        for (i, (pixel, layers)) in pixels.as_chunks_mut::<3>().0.iter_mut().zip(&mut layers).enumerate() {
            let place = self.view.center(first * width + i);
            // A tie goes to the first body and triangle.
            layers.sort_by(|a, b| a.depth.total_cmp(&b.depth));
            *pixel = self.light(place, layers).as_vec3().to_array();
        }
    }

    /// Returns the light at a place on the screen that shows `layers`, the nearest first.
    fn light(&self, place: DVec2, layers: &[Layer]) -> DVec3 {
        let (mut passed, mut light) = (Vec::new(), self.scene.background);
        for (i, layer) in layers.iter().enumerate() {
            let (drawn, body) = (&self.drawn[layer.body], &self.scene.bodies[layer.body]);
            let front = drawn.shading.light(layer.triangle, drawn.frame.weights(layer.triangle, place));
            if body.transparency.kind == Transmits::Opaque {
                light = front;
                break;
            }
            passed.push((body.transparency, front));
            if body.index.is_some()
                && let Some(behind) = self.refracted(place, &layers[..=i])
            {
                light = behind;
                break;
            }
        }
        over(&passed, light)
    }

    /// Returns the light that enters the last of the surfaces `shown` at a place on the screen, from behind it. The
    /// screen's corners are rounded, so the line of sight may meet another triangle than the pixel shows, or, at an
    /// outline, none.
    fn refracted(&self, place: DVec2, shown: &[Layer]) -> Option<DVec3> {
        let (from, along) = self.view.ray(place);
        let (targets, body) = (self.targets.as_ref()?, shown.last()?.body);
        let mut met = targets.first(from, along, LEAST, LEAST);
        loop {
            if met.iter().any(|at| at.of.0 as usize == body) {
                return Some(self.behind(from, along, &met, &[], 0, shown));
            }
            met = targets.first(from, along, met.first()?.distance + LEAST, LEAST);
        }
    }

    /// Returns the light that comes along a ray. `inside` are the bodies with an index that it is in.
    fn traced(&self, from: DVec3, along: DVec3, inside: &[usize], count: usize) -> DVec3 {
        let targets = self.targets.as_ref().filter(|_| count < MAX_MEETINGS);
        let met = targets.map(|targets| targets.first(from, along, LEAST, LEAST)).unwrap_or_default();
        if met.is_empty() { self.scene.background } else { self.behind(from, along, &met, inside, count, &[]) }
    }

    /// Returns the light from the surfaces that a ray meets at one place, and from beyond them. The light of the surfaces
    /// that are `shown` is already known.
    fn behind(
        &self,
        from: DVec3,
        along: DVec3,
        met: &[Meeting],
        inside: &[usize],
        count: usize,
        shown: &[Layer],
    ) -> DVec3 {
        let (mut passed, mut beyond) = (Vec::new(), inside.to_vec());
        for at in met {
            let (which, body) = (at.of.0 as usize, &self.scene.bodies[at.of.0 as usize]);
            let leaves = inside.contains(&which);
            if !leaves && shown.iter().all(|layer| layer.body != which) {
                let front = self.lit(from, along, at);
                if body.transparency.kind == Transmits::Opaque {
                    return over(&passed, front);
                }
                passed.push((body.transparency, front));
            }
            match body.index {
                Some(_) if leaves => beyond.retain(|body| *body != which),
                Some(_) => beyond.push(which),
                None => {}
            }
        }
        over(&passed, self.bent(from + along * met[0].distance, along, met, [inside, &beyond], count))
    }

    /// Returns the light that enters the bodies of `beyond` from those of `inside`, where a ray meets their surfaces.
    fn bent(
        &self,
        place: DVec3,
        along: DVec3,
        met: &[Meeting],
        [inside, beyond]: [&[usize]; 2],
        count: usize,
    ) -> DVec3 {
        let index = |of: &usize| self.scene.bodies[*of].index;
        let Some(at) = met.iter().find(|at| index(&(at.of.0 as usize)).is_some()) else {
            return self.traced(place, along, inside, count + 1);
        };
        // Where media touch, there is no gap between them.
        let [before, after] = [inside, beyond].map(|bodies| bodies.iter().filter_map(index).product::<f64>());
        match Refraction::of(-along, self.normal(at), before / after) {
            Refraction::Transmitted(along) => self.traced(place, along, beyond, count + 1),
            Refraction::TotalReflection(along) => self.traced(place, along, inside, count + 1),
        }
    }

    /// Returns the normal where a ray meets a triangle: the mean of the corners', weighted.
    fn normal(&self, at: &Meeting) -> DVec3 {
        let (body, frame) = (&self.scene.bodies[at.of.0 as usize], self.drawn[at.of.0 as usize].frame);
        let corners = body.surface.mesh.triangles[at.of.1 as usize].map(|v| frame.vertices[v as usize].normal);
        corners.into_iter().zip(at.weights).map(|(normal, w)| w * normal).sum::<DVec3>().normalize_or(DVec3::Z)
    }

    /// Returns the light that a surface sends toward the origin of a ray that meets it.
    fn lit(&self, from: DVec3, along: DVec3, at: &Meeting) -> DVec3 {
        let (which, normal) = (at.of.0 as usize, self.normal(at));
        // The back of a sheet is lit as well.
        let normal = if normal.dot(along) > 0.0 { -normal } else { normal };
        let frame = self.drawn[which].frame;
        let color = frame.paint.as_ref().map_or(DVec3::ONE, |paint| paint.color(at.of.1 as usize, at.weights));
        frame.lighting.painted(from + along * at.distance, normal, -along, color)
    }
}

/// The number of rows that one thread draws at a time.
pub(super) const ROWS: usize = 16;

/// Draws `frame` with `shade` in linear light, with every pixel sampled at its center. The picture is the same for any
/// number of threads.
pub fn image(frame: &Frame, shade: &Shade) -> LinearImage {
    let (shading, outlines) = (Shading::new(frame, shade), coverage::outlines(frame));
    let background = frame.background.as_vec3().to_array();
    let width = frame.view.width as usize;
    in_bands(frame.view.width, frame.view.height, |first, pixels| {
        let seen = coverage::visible_in(frame, &outlines, first as u32..(first + pixels.len() / (3 * width)) as u32);
        for (i, (pixel, triangle)) in pixels.as_chunks_mut::<3>().0.iter_mut().zip(seen).enumerate() {
            if triangle == coverage::NONE {
                *pixel = background;
                continue;
            }
            let weights = frame.weights(triangle as usize, frame.view.center(first * width + i));
            *pixel = shading.light(triangle as usize, weights).as_vec3().to_array();
        }
    })
}

/// Returns an image whose bands of rows `draw` draws, each from its first row on.
fn in_bands(width: u32, height: u32, draw: impl Fn(usize, &mut [f32]) + Sync) -> LinearImage {
    let mut image = LinearImage::new(width, height);
    image.data.par_chunks_mut((3 * width as usize * ROWS).max(1)).enumerate().for_each(|(band, pixels)| {
        checkpoint();
        draw(band * ROWS, pixels);
    });
    image
}

/// A triangle that rays can meet.
#[derive(Clone, Copy, Debug)]
struct Target {
    /// The body that it belongs to, and its index in the body's mesh.
    pub of: (u32, u32),
    /// Its corners.
    pub corners: [DVec3; 3],
}

/// Where a ray meets a triangle.
#[derive(Clone, Copy, Debug)]
struct Meeting {
    /// The body and the triangle.
    pub of: (u32, u32),
    /// The distance along the ray, in lengths of its direction.
    pub distance: f64,
    /// The weights of the corners.
    pub weights: [f64; 3],
}

/// Triangles in a tree of boxes.
#[derive(Clone, Debug)]
struct Targets {
    targets: Vec<Target>,
    boxes: Vec<Box>,
}

/// A box around the targets from `first` to `end`; all of them follow each other.
#[derive(Clone, Copy, Debug)]
struct Box {
    low: DVec3,
    high: DVec3,
    first: u32,
    end: u32,
    /// The box after this one and everything inside it.
    next: u32,
}

/// The number of targets that a box need not divide.
const FEW: usize = 4;

impl Targets {
    /// Builds the tree.
    pub fn new(mut targets: Vec<Target>) -> Targets {
        let mut boxes = Vec::new();
        let end = targets.len();
        divide(&mut targets, 0, end, &mut boxes);
        Targets { targets, boxes }
    }

    /// Returns the first triangle that the ray meets farther away than `after`, and where it meets other bodies at the same
    /// place, within `reach`: one triangle of each body, the nearest first. Both sides of a triangle count.
    pub fn first(&self, from: DVec3, along: DVec3, after: f64, reach: f64) -> Vec<Meeting> {
        let (mut met, mut most, mut at) = (Vec::<Meeting>::new(), f64::INFINITY, 0);
        let inverse = along.recip();
        while let Some(Box { low, high, first, end, next }) = self.boxes.get(at).copied() {
            let (a, b) = ((low - from) * inverse, (high - from) * inverse);
            let (enters, leaves) = (a.min(b).max_element(), a.max(b).min_element());
            if leaves < enters.max(after) || most < enters {
                at = next as usize;
                continue;
            }
            at += 1;
            for target in &self.targets[first as usize..end as usize] {
                if let Some(found) = target.meet(from, along, after)
                    && found.distance <= most
                {
                    most = most.min(found.distance + reach);
                    met.push(found);
                }
            }
        }
        met.retain(|found| found.distance <= most);
        met.sort_by(|a, b| a.of.0.cmp(&b.of.0).then(a.distance.total_cmp(&b.distance)));
        met.dedup_by_key(|found| found.of.0);
        met.sort_by(|a, b| a.distance.total_cmp(&b.distance));
        met
    }
}

/// Adds the boxes of the targets from `first` to `end`, divided at the median along the longest side.
fn divide(targets: &mut [Target], first: usize, end: usize, boxes: &mut Vec<Box>) {
    let corners = || targets[first..end].iter().flat_map(|target| target.corners);
    let (low, high) = corners().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(a, b), p| (a.min(p), b.max(p)));
    let (own, is_few) = (boxes.len(), end - first <= FEW);
    // A box that is divided has no targets of its own.
    boxes.push(Box { low, high, first: first as u32, end: if is_few { end } else { first } as u32, next: 0 });
    if !is_few {
        let side = (high - low).max_position();
        let middle = (end - first) / 2;
        let center = |target: &Target| target.corners.iter().map(|p| p[side]).sum::<f64>();
        targets[first..end].select_nth_unstable_by(middle, |a, b| center(a).total_cmp(&center(b)));
        divide(targets, first, first + middle, boxes);
        divide(targets, first + middle, end, boxes);
    }
    boxes[own].next = boxes.len() as u32;
}

/// Rounding errors of the weights: a ray through an edge meets at least one of its triangles.
const ROUNDING: f64 = 1e-12;

impl Target {
    fn meet(&self, from: DVec3, along: DVec3, after: f64) -> Option<Meeting> {
        let [a, b, c] = self.corners;
        let normal = (b - a).cross(c - a);
        let distance = (a - from).dot(normal) / along.dot(normal);
        let point = from + along * distance;
        let share = |p: DVec3, q: DVec3| (q - p).cross(point - p).dot(normal) / normal.length_squared();
        let weights = [share(b, c), share(c, a), share(a, b)];
        // The conditions are false for NaN.
        let is_met = distance > after && distance.is_finite() && weights.iter().all(|w| *w >= -ROUNDING);
        is_met.then_some(Meeting { of: self.of, distance, weights })
    }
}
