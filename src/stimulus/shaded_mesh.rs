//! A mesh drawn by one of the shaders: banding as it occurs in computer graphics, rated like any other stimulus.

use std::{fmt, str::FromStr};

use glam::{DVec2, DVec3};

use super::{
    color::{self, StimulusColor},
    drawing::Area,
    parameter::{ParameterError, Range, kind, parameter_error, text_field, unknown},
};
use crate::{
    light::{Depth, LinearImage},
    shading::{
        Correction, Frame, Mesh, Scene, Shade, Shader, Shading, Surface, image,
        shapes::{self, Shape},
    },
    text::names::serde_as_text,
};

/// Three numbers, written `X,Y,Z`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Triple(pub [f64; 3]);

impl fmt::Display for Triple {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [x, y, z] = self.0;
        write!(f, "{x},{y},{z}")
    }
}

impl FromStr for Triple {
    type Err = &'static str;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let numbers: Option<Vec<f64>> =
            text.split(',').map(|part| part.trim().parse().ok().filter(|n: &f64| n.is_finite())).collect();
        numbers
            .and_then(|numbers| <[f64; 3]>::try_from(numbers).ok())
            .map(Triple)
            .ok_or("expected three numbers separated by commas, such as 25,-35,0")
    }
}

text_field! {
    Triple: &[], unknown;
    Shape: Self::NAMES, unknown;
    Shader: Self::NAMES, unknown;
    Correction: Self::NAMES, unknown;
}

serde_as_text!(Triple);

kind! {
    /// A rotated and lit mesh, drawn by one of the shaders; Bangay §4 and figs. 8–12. It addresses the question that he
    /// left for future work: how visible are the bands of each shader?
    ///
    /// The luminance of the surface is `low` where only ambient light reaches it and `high` at normal incidence; a
    /// highlight adds up to `highlight`. Equal parameters give equal bytes on every machine.
    ShadedMesh = "shaded-mesh" where contradictions {
        shader: Shader = Shader::Gouraud, Range::Any, "", "Shader", Shader::EXPECTED, ["flat", "gouraud", "phong", "fixed", "patch", "c1-phong"];
        depth: Depth = Depth::Finite(3), Range::Any, "", "Continuity depth n of the strips at the edges", "a whole number from 1 to 32, or inf", ["1", "3", "5"];
        boundary: f64 = 0.2, Range::Within(0.0, 1.0), "1", "Width b of the strips at the edges, as a barycentric weight", "a width from 0 to 1; values above 1/3 act as 1/3", ["0.05", "0.2", "0.33"];
        vertex: Correction = Correction::Off, Range::Any, "", "Vertex shading, Bangay eq. 7", Correction::EXPECTED, ["off", "repaired"];
        reweight: Correction = Correction::Off, Range::Any, "", "Intensity reweighting, Bangay eq. 9", Correction::EXPECTED, ["off", "repaired"];
        mesh: Shape = Shape::Blob, Range::Any, "", "Mesh", Shape::EXPECTED, ["cube", "sphere", "blob"];
        vertices: u32 = 313, Range::Within(4.0, 20_000.0), "1", "Number of vertices; exact for a blob, approximate for other round shapes", "a whole number from 4 to 20000", ["313", "771"];
        rotate: Triple = Triple([25.0, -35.0, 0.0]), Range::Any, "°", "Rotation about x, then y, then z", "three angles in degrees, such as 25,-35,0", ["25,-35,0"];
        light: Triple = Triple([0.36, 0.48, 0.8]), Range::Any, "", "Direction toward the lamp: right, up, toward the viewer", "a vector with a length from 1e-6 to 1e6, such as 0.36,0.48,0.8", ["0.36,0.48,0.8"];
        highlight: f64 = 0.2, Range::Within(0.0, 1.0), "1", "Relative luminance added in the middle of a highlight", "a relative luminance", ["0", "0.2"];
        background: f64 = 0.05, Range::Within(0.0, 1.0), "1", "Relative luminance of the background", "a relative luminance", ["0.05"];
        low: f64 = 0.1, Range::Within(0.0, 1.0), "1", "Relative luminance where only ambient light reaches the surface", "the relative luminance where only ambient light reaches the surface", ["0.1"];
        high: f64 = 0.7, Range::Within(0.0, 1.0), "1", "Relative luminance where the lamp's light is at normal incidence", "a relative luminance, not below low", ["0.7"];
        color: StimulusColor = StimulusColor::GRAY, Range::Any, "", color::MEANING, color::EXPECTED, ["gray", "yellow"];
    }
}

impl ShadedMesh {
    fn contradictions(&self) -> Option<ParameterError> {
        let fault =
            |name, value: &dyn fmt::Display, problem: &str| parameter_error(Self::PARAMETERS, name, value, problem);
        if !(1e-6..=1e6).contains(&DVec3::from_array(self.light.0).length()) {
            return fault("light", &self.light, "is not a direction");
        }
        let least = self.mesh.min_vertices();
        if self.mesh.has_vertices() && (self.vertices as usize) < least {
            return fault("vertices", &self.vertices, &format!("is below the {least} that a {} needs", self.mesh));
        }
        let corrections = [("vertex", self.vertex), ("reweight", self.reweight)];
        let is_idle = |(_, correction): &(&str, Correction)| *correction != Correction::Off;
        if let Some((name, correction)) = corrections.into_iter().find(is_idle)
            && !self.shader.interpolates_light()
        {
            let problem = format!("corrects interpolated light, which {} does not use", self.shader);
            return fault(name, &correction, &problem);
        }
        if self.high + self.highlight > 1.0 {
            return fault("highlight", &self.highlight, "and high have a sum above 1: clipping would add edges");
        }
        None
    }

    /// Returns the shader with its options.
    pub fn shade(&self) -> Shade {
        Shade {
            shader: self.shader,
            depth: self.depth,
            boundary: self.boundary,
            vertex: self.vertex,
            reweight: self.reweight,
        }
    }

    /// Returns the scene: how the mesh is viewed and lit.
    pub fn scene(&self) -> Scene {
        Scene {
            rotate_deg: self.rotate.0,
            light: DVec3::from_array(self.light.0),
            color: DVec3::from_array(self.color.rgb()),
            ambient: self.low,
            diffuse: self.high - self.low,
            specular: self.highlight,
            background: self.background,
            ..Scene::default()
        }
    }

    /// Returns the mesh.
    ///
    /// # Errors
    /// Returns an error if there are too few or too many vertices, which never happens for a valid stimulus.
    pub fn mesh(&self) -> Result<Mesh, String> {
        shapes::mesh(self.mesh, self.vertices as usize)
    }

    /// Returns the scene in a window of `size` × `size` pixels, or `None` if the stimulus is invalid.
    pub(super) fn frame(&self, size: u32) -> Option<Frame> {
        Some(self.scene().frame(&Surface::new(self.mesh().ok()?), size, size))
    }
}

impl Area for ShadedMesh {
    fn linear(&self, size: u32) -> LinearImage {
        self.frame(size).map_or_else(|| LinearImage::new(size, size), |frame| image(&frame, &self.shade()))
    }

    fn profile(&self, size: u32) -> Vec<[f32; 3]> {
        let Some(frame) = self.frame(size) else { return vec![[0.0; 3]; size as usize] };
        let ends = [0.0, f64::from(size)].map(|x| DVec2::new(x, f64::from(size) / 2.0));
        let lights = along(&frame, &self.shade(), ends, size as usize);
        lights.iter().map(|light| light.unwrap_or(frame.background).as_vec3().to_array()).collect()
    }
}

/// Returns the picture of a frame, limited to the range from black to white, as a display emits it.
pub fn emitted(frame: &Frame, shade: &Shade) -> LinearImage {
    let mut image = image(frame, shade);
    // NaN becomes black, as on the screen.
    image.data.iter_mut().for_each(|light| *light = if *light > 0.0 { light.min(1.0) } else { 0.0 });
    image
}

/// Divides the line from `from` to `to`, in pixels from the top left, into `count` equal segments and returns the light at
/// the center of each, or `None` where there is no surface.
pub fn along(frame: &Frame, shade: &Shade, [from, to]: [DVec2; 2], count: usize) -> Vec<Option<DVec3>> {
    let line = to - from;
    let mut nearest: Vec<Option<(f64, usize, [f64; 3])>> = vec![None; count];
    for triangle in 0..frame.triangles.len() {
        let corners = frame.corners(triangle);
        let across = corners.map(|v| (v.screen - from).perp_dot(line));
        if across.iter().all(|a| *a > 0.0) || across.iter().all(|a| *a < 0.0) {
            continue;
        }
        // Visit only the segments that the triangle can cover.
        let along = corners.map(|v| (v.screen - from).dot(line) / line.length_squared() * count as f64);
        let (low, high) = along.iter().fold((f64::INFINITY, 0.0_f64), |(l, h), a| (l.min(*a), h.max(*a)));
        for (i, found) in nearest.iter_mut().enumerate().take((high as usize).saturating_add(1)).skip(low as usize) {
            let w = frame.weights(triangle, from.lerp(to, (i as f64 + 0.5) / count as f64));
            if !w.iter().all(|w| *w >= 0.0) {
                continue;
            }
            let depth = frame.depth(triangle, w);
            if found.is_none_or(|(other, ..)| depth < other) {
                *found = Some((depth, triangle, w));
            }
        }
    }
    let shading = Shading::new(frame, shade);
    nearest.into_iter().map(|found| found.map(|(_, t, w)| shading.light(t, w))).collect()
}
