//! What the demo compares, without how it is drawn: a surface in its light under two shaders.

use glam::{DMat3, DVec3, EulerRot};
use serde_json::{Value, json};

use crate::{
    light::{Depth, LinearImage, Transfer},
    shading::{
        Correction, Frame, Mesh, Reference, Scene, Shade, Shader, Surface,
        shapes::{self, Shape},
    },
    store,
};

/// Faces of a file that meet at more than this have a crease between them, degrees: none, to show what shaders do.
const CREASE_DEG: f64 = 180.0;

/// Which surface.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum MeshChoice {
    /// By its name, with so many vertices where it can have more or fewer.
    Named(Shape, usize),
    /// An OBJ file, by its path.
    File(String),
}

/// One of the two pictures compared.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Side {
    /// The shader with its options.
    pub shade: Shade,
    /// Encode the light at the vertices and interpolate the codes, as a program that knows nothing of gamma does.
    pub naive: bool,
}

/// All that decides about the two pictures but their size.
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    /// The surface.
    pub mesh: MeshChoice,
    /// How it is turned, lit and seen.
    pub scene: Scene,
    /// Left and right.
    pub sides: [Side; 2],
    /// What the display does with codes.
    pub transfer: Transfer,
}

impl Side {
    /// `shade` in linear light.
    #[must_use]
    pub const fn new(shade: Shade) -> Side {
        Side { shade, naive: false }
    }

    /// Whether gamma can be ignored here: Phong's light is encoded pixel by pixel whatever is done.
    #[must_use]
    pub fn can_be_naive(&self) -> bool {
        !matches!(self.shade.shader, Shader::Phong)
    }

    /// Whether it is ignored.
    #[must_use]
    pub fn is_naive(&self) -> bool {
        self.naive && self.can_be_naive()
    }

    /// Whether n and b change anything.
    #[must_use]
    pub fn has_strip(&self) -> bool {
        let corrected = self.shade.vertex != Correction::Off || self.shade.reweight == Correction::Printed;
        !matches!(self.shade.shader, Shader::Flat | Shader::Gouraud | Shader::Phong | Shader::Quadratic | Shader::Patch)
            || corrected && self.has_corrections()
    }

    /// Whether vertex correction and reweighting change anything.
    #[must_use]
    pub fn has_corrections(&self) -> bool {
        !matches!(self.shade.shader, Shader::Flat | Shader::Phong)
    }

    /// The frame that this side shades: with its lights encoded where gamma is ignored.
    #[must_use]
    pub fn frame(&self, frame: &Frame, transfer: &Transfer) -> Frame {
        if self.is_naive() { frame.clone().encoded(&transfer.into()) } else { frame.clone() }
    }

    /// What turns this side's picture into codes: nothing more where its lights are encoded already.
    #[must_use]
    pub fn transfer(&self, transfer: &Transfer) -> Transfer {
        if self.is_naive() { Transfer::Linear } else { transfer.clone() }
    }

    /// The light that a display sends for the value `computed` by this side's shader: its code's light, where it computes
    /// codes.
    #[must_use]
    pub fn light(&self, computed: DVec3, transfer: &Transfer) -> DVec3 {
        if self.is_naive() {
            DVec3::from_array(computed.to_array().map(|code| transfer.linear_from_encoded(code)))
        } else {
            computed
        }
    }

    /// This side's picture of `frame` in the light that the display sends, no less than none and no more than white.
    #[must_use]
    pub fn emitted(&self, frame: &Frame, transfer: &Transfer) -> LinearImage {
        let shaded = self.frame(frame, transfer);
        let mut image = Reference::new(&shaded, &self.shade).image();
        for pixel in image.data.chunks_exact_mut(3) {
            let computed = DVec3::new(pixel[0].into(), pixel[1].into(), pixel[2].into());
            // What is no number is black, as it is on the screen.
            let shown = |light: f64| if light > 0.0 { light.min(1.0) as f32 } else { 0.0 };
            let light = self.light(computed, transfer).to_array().map(shown);
            pixel.copy_from_slice(&light);
        }
        image
    }

    /// The shader in words.
    #[must_use]
    pub fn title(&self) -> String {
        let mut text = title(self.shade.shader).to_owned();
        if self.has_strip() {
            text += &format!(" ({}, {})", depth_text(self.shade.depth), short(self.shade.boundary));
        }
        if self.has_corrections() {
            for (correction, name) in [(self.shade.vertex, "vertex"), (self.shade.reweight, "reweighted")] {
                match correction {
                    Correction::Off => {}
                    Correction::Printed => text += &format!(" + {name}"),
                    Correction::Repaired => text += &format!(" + {name}, repaired"),
                }
            }
        }
        if self.is_naive() {
            text += ", gamma ignored";
        }
        text
    }

    fn describe(&self) -> Value {
        let Shade { shader, depth, boundary, vertex, reweight, gradients } = self.shade;
        json!({
            "shader": shader.name(),
            "depth": depth,
            "boundary": boundary,
            "vertex": vertex.name(),
            "reweight": reweight.name(),
            "gradients": gradients.name(),
            "interpolated_in": if self.is_naive() { "code values" } else { "linear light" },
        })
    }
}

impl Default for Comparison {
    /// Gouraud with its bands on the left, *patch* on the right, with highlights on both.
    fn default() -> Self {
        Self {
            mesh: MeshChoice::Named(Shape::Torus, 200),
            scene: Scene::default(),
            sides: [Side::new(Shade::new(Shader::Gouraud)), Side::new(Shade::new(Shader::Patch))],
            transfer: Transfer::Srgb,
        }
    }
}

impl Comparison {
    /// `surface` as seen and lit here, on `width` × `height` pixels.
    #[must_use]
    pub fn frame(&self, surface: &Surface, width: u32, height: u32) -> Frame {
        self.scene.frame(surface, width, height)
    }

    /// Turns the mesh by `right` degrees to the right and `down` degrees downward, as seen by the eye.
    pub fn turn(&mut self, right: f64, down: f64) {
        let before = self.scene.view(1, 1).rotation;
        let turn = DMat3::from_rotation_x(down.to_radians()) * DMat3::from_rotation_y(right.to_radians());
        let (z, y, x) = (turn * before).to_euler(EulerRot::ZYX);
        self.scene.rotate_deg = [x, y, z].map(f64::to_degrees);
    }

    /// Where the light comes from, degrees: to the right of the eye, and above it.
    #[must_use]
    pub fn light_deg(&self) -> [f64; 2] {
        let toward = self.scene.light.normalize_or(DVec3::Z);
        [toward.x.atan2(toward.z), toward.y.clamp(-1.0, 1.0).asin()].map(f64::to_degrees)
    }

    /// Puts the light there. Right above and right below would have no right and left: it stays a hair away.
    pub fn set_light_deg(&mut self, [right, up]: [f64; 2]) {
        let (right, up) = (right.to_radians(), up.clamp(-89.9, 89.9).to_radians());
        self.scene.light = DVec3::new(right.sin() * up.cos(), up.sin(), right.cos() * up.cos());
    }

    /// Moves the light by so many degrees.
    pub fn move_light(&mut self, right: f64, up: f64) {
        let [from_right, from_up] = self.light_deg();
        self.set_light_deg([from_right + right, from_up + up]);
    }

    /// Whether the frame, the shaders aside, is that of `other`.
    #[must_use]
    pub fn same_frame(&self, other: &Comparison) -> bool {
        Comparison { sides: other.sides, ..self.clone() } == *other
    }

    /// Every parameter, for who wants to make the picture again.
    #[must_use]
    pub fn describe(&self) -> Value {
        let (mesh, vertices) = match &self.mesh {
            MeshChoice::Named(shape, vertices) => (shape.name(), shape.has_vertices().then_some(vertices)),
            MeshChoice::File(path) => (path.as_str(), None),
        };
        let scene = &self.scene;
        json!({
            "mesh": mesh,
            "vertices": vertices,
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
            "left": self.sides[0].describe(),
            "right": self.sides[1].describe(),
            "transfer": self.transfer.to_string(),
        })
    }
}

impl MeshChoice {
    /// For readers: a file by its name.
    #[must_use]
    pub fn title(&self) -> String {
        match self {
            MeshChoice::Named(shape, _) => shape.name().to_owned(),
            MeshChoice::File(path) => {
                std::path::Path::new(path).file_name().unwrap_or_default().to_string_lossy().into_owned()
            }
        }
    }

    /// The triangles.
    ///
    /// # Errors
    /// In words, what is wrong with the file or the number of vertices.
    pub fn mesh(&self) -> Result<Mesh, String> {
        match self {
            MeshChoice::Named(shape, vertices) => shapes::mesh(*shape, *vertices).map_err(|error| error.to_string()),
            MeshChoice::File(path) => {
                store::mesh::read(std::path::Path::new(path), CREASE_DEG).map_err(|faults| faults.to_string())
            }
        }
    }
}

/// A shader's name for readers.
#[must_use]
pub fn title(shader: Shader) -> &'static str {
    match shader {
        Shader::Flat => "Flat",
        Shader::Gouraud => "Gouraud",
        Shader::Phong => "Phong",
        Shader::Quadratic => "Quadratic",
        Shader::Fixed => "Fixed, as printed",
        Shader::Gradient => "Gradient, as printed",
        Shader::GradientRepaired => "Gradient, repaired",
        Shader::Exact => "Exact",
        Shader::Cut => "Cut",
        Shader::Patch => "Patch",
    }
}

/// n for readers.
#[must_use]
pub fn depth_text(depth: Depth) -> String {
    if depth == Depth::Infinite { "∞".to_owned() } else { depth.to_string() }
}

/// A number with at most three decimals.
fn short(value: f64) -> String {
    format!("{}", (value * 1000.0).round() / 1000.0)
}
