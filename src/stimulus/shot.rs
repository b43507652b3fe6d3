//! A projected and lit mesh as one renderer draws it for one display: its light, codes, creases and description.

use std::borrow::Cow;

use glam::{DVec2, DVec3};
use serde_json::{Value, json};

use crate::{
    light::{LinearImage, Transfer, Transfers},
    shading::{
        Creases, Frame, Scene, Shade, Shader, Shading, Specular, image,
        lighting::{Facets, Microfacets},
    },
};

/// A shader and whether it ignores gamma.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Renderer {
    /// The shader with its options.
    pub shade: Shade,
    /// True to encode the light at the vertices and interpolate the encoded values, as a renderer that ignores gamma
    /// does.
    pub naive: bool,
}

/// The output of a renderer for a frame on a display.
pub struct Shot<'f> {
    /// The frame. If the renderer ignores gamma, its light values are encoded.
    pub frame: Cow<'f, Frame>,
    /// The shader with its options.
    pub shade: Shade,
    /// Turns the values that the shader computes into codes.
    pub transfers: Transfers,
}

impl Renderer {
    /// Creates a renderer that draws `shade` in linear light.
    pub const fn new(shade: Shade) -> Renderer {
        Renderer { shade, naive: false }
    }

    /// Returns Gouraud's shader in linear light, the baseline for all comparisons.
    pub const fn gouraud() -> Renderer {
        Renderer::new(Shade::new(Shader::Gouraud))
    }

    /// Returns whether this renderer draws the same image as [`Renderer::gouraud`]. Options that only other shaders use
    /// may differ.
    pub fn is_gouraud(&self) -> bool {
        let Shade { depth, boundary, gradients, .. } = self.shade;
        *self == Renderer::new(Shade { depth, boundary, gradients, ..Renderer::gouraud().shade })
    }

    /// Returns whether this renderer interpolates encoded values. Shaders that light every pixel never do: they encode
    /// the result.
    pub fn is_naive(&self) -> bool {
        self.naive && !self.shade.shader.lights_pixels()
    }

    /// Draws `frame` for a display with `transfers`.
    pub fn shoot<'f>(&self, frame: &'f Frame, transfers: &Transfers) -> Shot<'f> {
        let shade = self.shade;
        if self.is_naive() {
            let frame = Cow::Owned(frame.clone().encoded(transfers));
            Shot { frame, shade, transfers: Transfer::Linear.into() }
        } else {
            Shot { frame: Cow::Borrowed(frame), shade, transfers: transfers.clone() }
        }
    }

    /// Returns every option, so that anyone can reproduce the rendering.
    pub fn describe(&self) -> Value {
        let Shade { shader, depth, boundary, vertex, reweight, gradients } = self.shade;
        json!({
            "shader": shader.name(),
            "depth": depth,
            "boundary": boundary,
            "vertex": vertex.name(),
            "reweight": reweight.name(),
            "gradients": gradients.name(),
        })
    }
}

/// Returns every setting of a scene, so that anyone can reproduce it.
pub fn describe_scene(scene: &Scene) -> Value {
    let mut all = json!({
        "rotate_deg": scene.rotate_deg,
        "light": scene.light.to_array(),
        "color": scene.color.to_array(),
        "ambient": scene.ambient,
        "diffuse": scene.diffuse,
        "specular": scene.specular,
        "highlight": scene.highlight.name(),
        "shininess": scene.shininess,
        "background": scene.background,
        "fill": scene.fill,
        "distance": if scene.distance.is_finite() { json!(scene.distance) } else { json!("inf") },
    });
    if let Specular::CookTorrance(Microfacets { facets, slope, index }) =
        scene.highlight.model(scene.shininess, scene.mirrors)
    {
        all["facet_slope"] = json!(slope);
        all["facet_index"] = json!(index.x);
        if let Facets::Gaussian { c1 } = facets {
            all["facet_c1"] = json!(c1);
        }
    }
    all
}

impl Shot<'_> {
    /// Returns what the shader computes: linear light, or encoded values if gamma is ignored. [`Shot::transfers`] turns
    /// either into codes.
    pub fn image(&self) -> LinearImage {
        image(&self.frame, &self.shade)
    }

    /// Returns the light that the display emits, limited to the range from black to white.
    pub fn emitted(&self) -> LinearImage {
        // NaN becomes black, as on the screen.
        let shown = |light: f64| if light > 0.0 { light.min(1.0) as f32 } else { 0.0 };
        let mut image = self.image();
        for pixel in image.data.chunks_exact_mut(3) {
            let light = self.frame.emitted(DVec3::new(pixel[0].into(), pixel[1].into(), pixel[2].into()));
            pixel.copy_from_slice(&light.to_array().map(shown));
        }
        image
    }

    /// Returns the creases in the light that the display emits.
    pub fn creases(&self) -> Creases {
        Creases::of(&self.frame, &self.shade)
    }

    /// Divides the line from `from` to `to`, in pixels from the top left, into `count` equal segments and returns the
    /// light that the display emits at the center of each, or `None` where there is no surface.
    pub fn along(&self, [from, to]: [DVec2; 2], count: usize) -> Vec<Option<DVec3>> {
        let line = to - from;
        let mut nearest: Vec<Option<(f64, usize, [f64; 3])>> = vec![None; count];
        for triangle in 0..self.frame.triangles.len() {
            let corners = self.frame.corners(triangle);
            let across = corners.map(|v| (v.screen - from).perp_dot(line));
            if across.iter().all(|a| *a > 0.0) || across.iter().all(|a| *a < 0.0) {
                continue;
            }
            // Visit only the segments that the triangle can cover.
            let along = corners.map(|v| (v.screen - from).dot(line) / line.length_squared() * count as f64);
            let (low, high) = along.iter().fold((f64::INFINITY, 0.0_f64), |(l, h), a| (l.min(*a), h.max(*a)));
            for (i, found) in nearest.iter_mut().enumerate().take((high as usize).saturating_add(1)).skip(low as usize)
            {
                let w = self.frame.weights(triangle, from.lerp(to, (i as f64 + 0.5) / count as f64));
                if !w.iter().all(|w| *w >= 0.0) {
                    continue;
                }
                let depth = w[0] * corners[0].depth + w[1] * corners[1].depth + w[2] * corners[2].depth;
                if found.is_none_or(|(other, ..)| depth < other) {
                    *found = Some((depth, triangle, w));
                }
            }
        }
        let shading = Shading::new(&self.frame, &self.shade);
        nearest.into_iter().map(|found| found.map(|(_, t, w)| self.frame.emitted(shading.light(t, w)))).collect()
    }
}
