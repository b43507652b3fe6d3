//! Scenes of several meshes (TOML).

use std::path::Path;

use glam::DVec3;
use serde::Deserialize;

use super::{
    FileErrors,
    file::read_text,
    mesh::{self, MeshError},
    toml::{self, Document},
};
use crate::{
    light::Depth,
    shading::{
        Body, Composition, Correction, Highlight, Lamp, LampPosition, Material, Mesh, Mirrors, Normals, Scene, Shade,
        Shader, Surface, Transmits, Transparency, View,
    },
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

/// The largest coordinate, intensity or factor.
const MOST: f64 = 1e6;

/// Declares a table of the file: its keys with their types, their defaults and, for numbers, their range.
macro_rules! table {
    ($name:ident { $($key:ident: $type:ty = $default:expr $(, $range:expr)?;)* }) => {
        #[derive(Deserialize)]
        #[serde(default, deny_unknown_fields)]
        struct $name {
            $($key: $type,)*
        }

        impl Default for $name {
            fn default() -> Self {
                Self { $($key: $default,)* }
            }
        }

        impl $name {
            /// Reports every number that is out of range; `path` is that of the table, with a dot at its end.
            fn check_ranges(&self, path: &str, document: &mut Document<'_>) {
                $($(document.check_range(&[path, stringify!($key)].concat(), self.$key.numbers(), $range);)?)*
            }
        }
    };
}

/// What has a range.
trait Numbers {
    fn numbers(&self) -> &[f64];
}

impl Numbers for f64 {
    fn numbers(&self) -> &[f64] {
        std::slice::from_ref(self)
    }
}

impl Numbers for [f64; 3] {
    fn numbers(&self) -> &[f64] {
        self
    }
}

impl<T: Numbers> Numbers for Option<T> {
    fn numbers(&self) -> &[f64] {
        self.as_ref().map_or(&[], T::numbers)
    }
}

table! {
    SceneTable {
        background: [f64; 3] = [0.05; 3], 0.0..=1.0;
        ambient: [f64; 3] = [1.0; 3], 0.0..=MOST;
        view: ViewTable = ViewTable::default();
        mesh: Vec<MeshTable> = Vec::new();
        lamp: Vec<LampTable> = Vec::new();
    }
}

table! {
    ViewTable {
        rotate: [f64; 3] = Scene::default().rotate_deg, -MOST..=MOST;
        fill: f64 = Scene::default().fill, 0.01..=100.0;
        distance: Option<f64> = None, 1.05..=MOST;
    }
}

table! {
    MeshTable {
        mesh: String = String::new();
        vertices: usize = 313;
        crease: f64 = 180.0, 0.0..=180.0;
        normals: Normals = Normals::Given;
        position: [f64; 3] = [0.0; 3], -MOST..=MOST;
        rotate: [f64; 3] = [0.0; 3], -MOST..=MOST;
        scale: f64 = 1.0, 1e-6..=MOST;
        shader: Shader = Shader::C1Phong;
        depth: Depth = Depth::Finite(1);
        boundary: f64 = Shade::new(Shader::Fixed).boundary, 0.0..=1.0;
        vertex: Correction = Correction::Off;
        reweight: Correction = Correction::Off;
        color: [f64; 3] = [1.0; 3], 0.0..=1.0;
        specular_color: [f64; 3] = [1.0; 3], 0.0..=1.0;
        ambient: f64 = Scene::default().ambient, 0.0..=1.0;
        diffuse: f64 = Scene::default().diffuse, 0.0..=1.0;
        specular: f64 = 0.3, 0.0..=1.0;
        highlight: Highlight = Highlight::Phong;
        shininess: f64 = Scene::default().shininess, 1.0..=1000.0;
        facet_slope: Option<f64> = None, 0.001..=10.0;
        facet_c1: Option<f64> = None, 0.0..=1e6;
        facet_index: Option<f64> = None, 1.0..=1000.0;
        transparency: Transmits = Transmits::Opaque;
        transmission: f64 = 0.5, 0.0..=1.0;
        filter: [f64; 3] = [1.0; 3], 0.0..=1.0;
        index: Option<f64> = None, 0.1..=10.0;
    }
}

table! {
    LampTable {
        direction: Option<[f64; 3]> = None, -MOST..=MOST;
        position: Option<[f64; 3]> = None, -MOST..=MOST;
        attenuation: [f64; 3] = [1.0, 0.0, 0.0], 0.0..=MOST;
        intensity: [f64; 3] = [1.0; 3], 0.0..=MOST;
    }
}

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
    let (folder, mut meshes) = (path.parent().unwrap_or(path), Vec::new());
    for (i, MeshTable { mesh, vertices, crease, normals, .. }) in table.mesh.iter().enumerate() {
        let place = |key: &str| format!("mesh.{i}.{key}");
        match mesh::open(folder, Path::new(mesh), *vertices, *crease, *normals) {
            _ if mesh.is_empty() => {}
            Err(MeshError::Unknown(error)) => document.error(&place("mesh"), error),
            Err(MeshError::Vertices(error)) => document.error(&place("vertices"), format!("vertices: {error}")),
            Err(MeshError::File(errors)) => meshes.push(Err(errors)),
            Ok(file) => meshes.push(Ok(file)),
        }
    }
    let table = document.finish(table)?;
    if table.mesh.is_empty() {
        return Err(FileErrors::whole(path, "the scene has no meshes; expected at least one table [[mesh]]"));
    }
    let mut notes = Vec::new();
    let mut bodies = Vec::new();
    for (table, file) in table.mesh.iter().zip(meshes) {
        let file = file?;
        notes.extend(file.note(&folder.join(&table.mesh)));
        bodies.push(body(table, file.mesh));
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
    let distance = table.view.distance.unwrap_or(f64::INFINITY);
    let composition = Composition {
        bodies,
        ambient: DVec3::from_array(table.ambient),
        lamps: table.lamp.iter().map(lamp).collect(),
        background: DVec3::from_array(table.background),
        view: View { fill: table.view.fill, distance, ..View::square(1) }.rotated(table.view.rotate),
    };
    Ok(SceneFile { composition, text, notes })
}

/// Reports every value that is not possible.
fn check(scene: &SceneTable, document: &mut Document<'_>) {
    scene.check_ranges("", document);
    scene.view.check_ranges("view.", document);
    for (i, mesh) in scene.mesh.iter().enumerate() {
        mesh.check_ranges(&format!("mesh.{i}."), document);
        if mesh.mesh.is_empty() {
            document.error(&format!("mesh.{i}"), "mesh is missing; expected mesh = \"torus\", or the path to a file");
        }
    }
    for (i, lamp) in scene.lamp.iter().enumerate() {
        let of = |key: &str| format!("lamp.{i}.{key}");
        lamp.check_ranges(&of(""), document);
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

/// Returns a body with this mesh.
fn body(table: &MeshTable, mesh: Mesh) -> Body {
    let mesh = mesh.estimated(table.normals).placed(
        table.scale,
        View::square(1).rotated(table.rotate).rotation,
        DVec3::from_array(table.position),
    );
    let mirrors = Mirrors { slope: table.facet_slope, c1: table.facet_c1, index: table.facet_index };
    Body {
        surface: Surface::new(mesh),
        shade: Shade {
            shader: table.shader,
            depth: table.depth,
            boundary: table.boundary,
            vertex: table.vertex,
            reweight: table.reweight,
        },
        material: Material {
            color: DVec3::from_array(table.color),
            specular_color: DVec3::from_array(table.specular_color),
            ambient: table.ambient,
            diffuse: table.diffuse,
            specular: table.specular,
            shininess: table.shininess,
            highlight: table.highlight,
            facets: mirrors.facets(table.highlight, table.shininess),
        },
        transparency: Transparency {
            kind: table.transparency,
            k_t: table.transmission,
            color: DVec3::from_array(table.filter),
        },
        index: table.index,
    }
}
