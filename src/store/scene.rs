//! Scenes of several meshes (TOML).

use std::path::Path;

use glam::DVec3;
use serde::Deserialize;

use super::{
    FileErrors,
    file::read_text,
    mesh,
    toml::{self, Document},
};
use crate::{
    light::Depth,
    shading::{
        Body, Composition, Correction, Highlight, Lamp, LampPosition, Material, Mesh, Mirrors, Normals, Shade, Shader,
        Surface, Transparency, View,
        shapes::{self, Shape},
    },
    system::found,
    text::names::named,
};

/// A scene, and the text that describes it.
#[derive(Clone, Debug)]
pub struct SceneFile {
    /// The scene.
    pub composition: Composition,
    /// The content of the file.
    pub text: String,
    /// For each mesh file in which faces were reversed, a sentence without its subject.
    pub notes: Vec<String>,
}

#[derive(Deserialize)]
#[serde(default, deny_unknown_fields)]
struct SceneTable {
    background: [f64; 3],
    ambient: [f64; 3],
    view: ViewTable,
    mesh: Vec<MeshTable>,
    lamp: Vec<LampTable>,
}

impl Default for SceneTable {
    fn default() -> Self {
        let (view, mesh, lamp) = Default::default();
        Self { background: [0.05; 3], ambient: [1.0; 3], view, mesh, lamp }
    }
}

#[derive(Deserialize)]
#[serde(default, deny_unknown_fields)]
struct ViewTable {
    rotate: [f64; 3],
    fill: f64,
    distance: Option<f64>,
}

impl Default for ViewTable {
    fn default() -> Self {
        Self { rotate: [25.0, -35.0, 0.0], fill: 0.9, distance: None }
    }
}

named! {
    /// Which of the two formulas of transparency applies.
    Transmits, UnknownTransparency {
        /// No light passes.
        Opaque = "opaque",
        /// (1 − k_t)·I_1 + k_t·I_2.
        Interpolated = "interpolated",
        /// I_1 + k_t·O_t·I_2.
        Filtered = "filtered",
    }
}

#[derive(Deserialize)]
#[serde(default, deny_unknown_fields)]
struct MeshTable {
    mesh: String,
    vertices: usize,
    crease: f64,
    normals: Normals,
    position: [f64; 3],
    rotate: [f64; 3],
    scale: f64,
    shader: Shader,
    depth: Option<Depth>,
    boundary: Option<f64>,
    vertex: Correction,
    reweight: Correction,
    color: [f64; 3],
    specular_color: [f64; 3],
    ambient: f64,
    diffuse: f64,
    specular: f64,
    highlight: Highlight,
    shininess: f64,
    facet_slope: Option<f64>,
    facet_c1: Option<f64>,
    facet_index: Option<f64>,
    transparency: Transmits,
    transmission: f64,
    filter: [f64; 3],
    index: Option<f64>,
}

impl Default for MeshTable {
    fn default() -> Self {
        let material = Material::standard();
        Self {
            mesh: String::new(),
            vertices: 313,
            crease: 180.0,
            normals: Normals::Given,
            position: [0.0; 3],
            rotate: [0.0; 3],
            scale: 1.0,
            shader: Shader::C1Phong,
            depth: None,
            boundary: None,
            vertex: Correction::Off,
            reweight: Correction::Off,
            color: [1.0; 3],
            specular_color: [1.0; 3],
            ambient: material.ambient,
            diffuse: material.diffuse,
            specular: material.specular,
            highlight: Highlight::Phong,
            shininess: material.shininess,
            facet_slope: None,
            facet_c1: None,
            facet_index: None,
            transparency: Transmits::Opaque,
            transmission: 0.5,
            filter: [1.0; 3],
            index: None,
        }
    }
}

#[derive(Deserialize)]
#[serde(default, deny_unknown_fields)]
struct LampTable {
    direction: Option<[f64; 3]>,
    position: Option<[f64; 3]>,
    attenuation: [f64; 3],
    intensity: [f64; 3],
}

impl Default for LampTable {
    fn default() -> Self {
        Self { direction: None, position: None, attenuation: [1.0, 0.0, 0.0], intensity: [1.0; 3] }
    }
}

/// The largest coordinate, intensity or factor.
const MOST: f64 = 1e6;

/// Reads a scene. Mesh files are found relative to it.
///
/// # Errors
/// Reports every error in the file, with its line and column; otherwise, the errors of the first mesh that cannot be
/// made.
pub fn read(path: &Path) -> Result<SceneFile, FileErrors> {
    let text = read_text(path)?;
    let file = path.display().to_string();
    let (table, mut document) = toml::read::<SceneTable>(&file, &text)?;
    check(&table, &mut document);
    let mut shape = |(i, table): (usize, &MeshTable)| {
        let Ok(shape) = table.mesh.parse() else {
            let file = path.with_file_name(&table.mesh);
            if !table.mesh.is_empty() && file.extension().is_none() && matches!(found(&file), Ok(None)) {
                document.error(&format!("mesh.{i}.mesh"), Shape::missing(&table.mesh));
            }
            return None;
        };
        let made = shapes::mesh(shape, table.vertices);
        made.map_err(|error| document.error(&format!("mesh.{i}.vertices"), format!("vertices: {error}"))).ok()
    };
    let shapes: Vec<Option<Mesh>> = table.mesh.iter().enumerate().map(&mut shape).collect();
    let table = document.finish(table)?;
    if table.mesh.is_empty() {
        return Err(FileErrors::whole(path, "the scene has no meshes; expected at least one table [[mesh]]"));
    }
    let mut notes = Vec::new();
    let mut bodies = Vec::new();
    for (mesh, shape) in table.mesh.iter().zip(shapes) {
        bodies.push(body(mesh, shape, path, &mut notes)?);
    }
    let lamp = |lamp: &LampTable| Lamp {
        position: match (lamp.position, lamp.direction) {
            (Some(position), _) => {
                LampPosition::Point { position: DVec3::from_array(position), attenuation: lamp.attenuation }
            }
            (None, direction) => {
                LampPosition::Direction(DVec3::from_array(direction.unwrap_or_default()).normalize_or(DVec3::Z))
            }
        },
        intensity: DVec3::from_array(lamp.intensity),
    };
    let composition = Composition {
        bodies,
        ambient: DVec3::from_array(table.ambient),
        lamps: table.lamp.iter().map(lamp).collect(),
        background: DVec3::from_array(table.background),
        rotate_deg: table.view.rotate,
        fill: table.view.fill,
        distance: table.view.distance.unwrap_or(f64::INFINITY),
    };
    Ok(SceneFile { composition, text, notes })
}

/// Reports every value that is out of range.
fn check(scene: &SceneTable, document: &mut Document<'_>) {
    document.check_range("background", &scene.background, 0.0, 1.0);
    document.check_range("ambient", &scene.ambient, 0.0, MOST);
    document.check_range("view.rotate", &scene.view.rotate, -MOST, MOST);
    document.check_range("view.fill", &[scene.view.fill], 0.01, 100.0);
    document.check_range("view.distance", scene.view.distance.as_slice(), 1.05, MOST);
    for (i, mesh) in scene.mesh.iter().enumerate() {
        let of = |key: &str| format!("mesh.{i}.{key}");
        document.check_range(&of("crease"), &[mesh.crease], 0.0, 180.0);
        document.check_range(&of("position"), &mesh.position, -MOST, MOST);
        document.check_range(&of("rotate"), &mesh.rotate, -MOST, MOST);
        document.check_range(&of("scale"), &[mesh.scale], 1e-6, MOST);
        document.check_range(&of("boundary"), mesh.boundary.as_slice(), 0.0, 1.0);
        for (key, color) in [("color", mesh.color), ("specular_color", mesh.specular_color), ("filter", mesh.filter)] {
            document.check_range(&of(key), &color, 0.0, 1.0);
        }
        document.check_range(&of("ambient"), &[mesh.ambient], 0.0, 1.0);
        document.check_range(&of("diffuse"), &[mesh.diffuse], 0.0, 1.0);
        document.check_range(&of("specular"), &[mesh.specular], 0.0, 1.0);
        document.check_range(&of("transmission"), &[mesh.transmission], 0.0, 1.0);
        document.check_range(&of("shininess"), &[mesh.shininess], 1.0, 1000.0);
        document.check_range(&of("facet_slope"), mesh.facet_slope.as_slice(), 0.001, 10.0);
        document.check_range(&of("facet_c1"), mesh.facet_c1.as_slice(), 0.0, 1e6);
        document.check_range(&of("facet_index"), mesh.facet_index.as_slice(), 1.0, 1000.0);
        document.check_range(&of("index"), mesh.index.as_slice(), 0.1, 10.0);
        if mesh.mesh.is_empty() {
            document.error(&format!("mesh.{i}"), "mesh is missing; expected mesh = \"torus\", or the path to a file");
        }
    }
    for (i, lamp) in scene.lamp.iter().enumerate() {
        let of = |key: &str| format!("lamp.{i}.{key}");
        for (key, place) in [("direction", lamp.direction), ("position", lamp.position)] {
            document.check_range(&of(key), place.as_slice().as_flattened(), -MOST, MOST);
        }
        document.check_range(&of("attenuation"), &lamp.attenuation, 0.0, MOST);
        document.check_range(&of("intensity"), &lamp.intensity, 0.0, MOST);
        let length = lamp.direction.map(|toward| DVec3::from_array(toward).length());
        if lamp.direction.is_some() == lamp.position.is_some() {
            let message = "the lamp needs one place; expected either direction = [x, y, z] or position = …";
            document.error(&format!("lamp.{i}"), message);
        } else if length.is_some_and(|length| length < 1e-6) {
            document.error(&of("direction"), "direction has no length; expected a vector toward the lamp");
        } else if lamp.attenuation == [0.0; 3] {
            document.error(&of("attenuation"), "attenuation is 0; expected at least one number above 0");
        }
    }
}

impl MeshTable {
    fn mirrors(&self) -> Mirrors {
        Mirrors { slope: self.facet_slope, c1: self.facet_c1, index: self.facet_index }
    }

    fn shade(&self) -> Shade {
        let plain = Shade::new(self.shader);
        Shade {
            depth: self.depth.unwrap_or(plain.depth),
            boundary: self.boundary.unwrap_or(plain.boundary),
            vertex: self.vertex,
            reweight: self.reweight,
            ..plain
        }
    }
}

/// Returns a body with this shape, or with the mesh in its file.
fn body(table: &MeshTable, shape: Option<Mesh>, scene: &Path, notes: &mut Vec<String>) -> Result<Body, FileErrors> {
    let mesh = match shape {
        Some(shape) => shape,
        None => {
            let path = scene.with_file_name(&table.mesh);
            let file = mesh::read(&path, table.crease, table.normals)?;
            notes.extend(file.note(&path));
            file.mesh
        }
    };
    let mesh: Mesh = mesh.estimated(table.normals).placed(
        table.scale,
        View::square(1).rotated(table.rotate).rotation,
        DVec3::from_array(table.position),
    );
    let (k_t, color) = (table.transmission, DVec3::from_array(table.filter));
    Ok(Body {
        surface: Surface::new(mesh),
        shade: table.shade(),
        material: Material {
            color: DVec3::from_array(table.color),
            specular_color: DVec3::from_array(table.specular_color),
            ambient: table.ambient,
            diffuse: table.diffuse,
            specular: table.specular,
            shininess: table.shininess,
            specular_model: table.highlight.model(table.shininess, table.mirrors()),
        },
        transparency: match table.transparency {
            Transmits::Opaque => Transparency::Opaque,
            Transmits::Interpolated => Transparency::Interpolated { k_t },
            Transmits::Filtered => Transparency::Filtered { k_t, color },
        },
        index: table.index,
    })
}
