//! A comparison of two shaders on the same lit surface.

use std::path::{Path, PathBuf};

use glam::{DMat3, DVec3, EulerRot};

use crate::{
    light::Depth,
    shading::{Correction, Normals, Scene, Shade, Shader, shapes::Shape},
    store::{
        self,
        mesh::{MeshError, MeshFile},
    },
};

/// Crease angle for meshes from files, degrees. At 180 there are no creases, so that the shaders' own effects are
/// visible.
const CREASE_DEG: f64 = 180.0;

/// The mesh to draw.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MeshChoice {
    /// The name of a shape, or the path of a file.
    pub name: PathBuf,
    /// The number of vertices, if it can be chosen.
    pub vertices: usize,
}

/// Everything that determines the two images except their size.
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    pub mesh: MeshChoice,
    /// Rotation, lighting, and view.
    pub scene: Scene,
    /// The left and the right shader.
    pub sides: [Shade; 2],
}

impl Default for Comparison {
    /// Gouraud, with its bands, on the left and Phong with C1 normals on the right, both with highlights.
    fn default() -> Self {
        Self {
            mesh: MeshChoice { name: Shape::Torus.name().into(), vertices: 200 },
            scene: Scene::default(),
            sides: [Shader::Gouraud, Shader::C1Phong].map(Shade::new),
        }
    }
}

impl Comparison {
    /// Rotates the mesh by `right` degrees to the right and `down` degrees downward, from the viewer's perspective.
    pub fn turn(&mut self, right: f64, down: f64) {
        let before = self.scene.view(1, 1).rotation;
        let turn = DMat3::from_rotation_x(down.to_radians()) * DMat3::from_rotation_y(right.to_radians());
        let (z, y, x) = (turn * before).to_euler(EulerRot::ZYX);
        self.scene.rotate_deg = [x, y, z].map(f64::to_degrees);
    }

    /// Returns the direction of the light in degrees: to the right of the eye, and above it.
    pub fn light_deg(&self) -> [f64; 2] {
        let toward = self.scene.light.normalize_or(DVec3::Z);
        [toward.x.atan2(toward.z), toward.y.clamp(-1.0, 1.0).asin()].map(f64::to_degrees)
    }

    /// Sets the direction of the light. Straight up and straight down, the angle to the right is undefined, so the
    /// light stays slightly off these directions.
    pub fn set_light_deg(&mut self, [right, up]: [f64; 2]) {
        let (right, up) = (right.to_radians(), up.clamp(-89.9, 89.9).to_radians());
        self.scene.light = DVec3::new(right.sin() * up.cos(), up.sin(), right.cos() * up.cos());
    }
}

impl MeshChoice {
    /// Returns the shape; `None` for a file.
    pub fn shape(&self) -> Option<Shape> {
        store::mesh::shape_of(&self.name)
    }

    /// Returns its name on the page; for a file, without the folder.
    pub fn title(&self) -> String {
        self.name.file_name().unwrap_or_default().to_string_lossy().into_owned()
    }

    /// Creates or reads the mesh.
    ///
    /// # Errors
    /// The same errors as [`store::mesh::open`].
    pub fn mesh(&self) -> Result<MeshFile, MeshError> {
        store::mesh::open(Path::new(""), &self.name, self.vertices, CREASE_DEG, Normals::Given)
    }
}

/// Returns the name of a shader on the page, including the options that have an effect.
pub fn title(shade: &Shade) -> String {
    let mut text = shader_title(shade.shader);
    if shade.has_strip() {
        // At most three decimals.
        let boundary = (shade.boundary * 1000.0).round() / 1000.0;
        text += &format!(" ({}, {boundary})", depth_title(shade.depth));
    }
    if shade.shader.interpolates_light() {
        for (correction, name) in [(shade.vertex, "vertex"), (shade.reweight, "reweighted")] {
            if correction != Correction::Off {
                text += &format!(" + {name} {}", correction.name());
            }
        }
    }
    text
}

/// Returns the name of a shader on the page: "Gradient, repaired" for "gradient-repaired".
pub fn shader_title(shader: Shader) -> String {
    if shader == Shader::C1Phong {
        return "Phong with C1 normals".to_owned();
    }
    let (first, rest) = shader.name().split_at(1);
    let printed = if matches!(shader, Shader::Fixed | Shader::Gradient) { ", as printed" } else { "" };
    format!("{}{}{printed}", first.to_uppercase(), rest.replace('-', ", "))
}

/// Returns the continuity depth on the page.
pub fn depth_title(depth: Depth) -> String {
    if depth == Depth::Infinite { "∞".to_owned() } else { depth.to_string() }
}
