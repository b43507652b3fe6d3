//! One mesh, and how it is shaded and seen.

use std::path::{Path, PathBuf};

use glam::DVec3;
use serde::Serialize;
use serde_json::{Value, json};

use super::{RequestError, request::changed};
use crate::{
    light::Depth,
    shading::{
        self, Correction, Frame, Highlight, Mirrors, Normals, Scene, Shader, Surface, Truth,
        shapes::{self, Shape},
    },
    stimulus::{StimulusColor, Triple, ViewingConditions, describe_scene},
    store::{self, mesh::MeshFile},
    system::found,
    text::{
        names::one_of,
        number::{whole, within},
    },
};

/// One mesh, and how it is shaded and seen.
#[derive(Clone, Debug, PartialEq, clap::Args, Serialize)]
pub struct OneMesh {
    #[arg(long, value_name = "MESH", default_value = "blob", help = format!("Mesh: {}, or the path to an OBJ, PLY, glTF or GLB file", Shape::NAMES.join(", ")))]
    pub mesh: PathBuf,
    /// Number of vertices; exact for a blob, approximate for other round shapes.
    #[arg(long, value_name = "N", default_value_t = 313, value_parser = whole(1..=usize::MAX))]
    pub vertices: usize,
    /// Angle in degrees above which the edge between two faces of a file without normals is a crease.
    #[arg(long, value_name = "DEG", default_value_t = 180.0, value_parser = within(0.0, 180.0))]
    pub crease: f64,
    /// Normals at the vertices: the mesh's own, or estimated from its triangles as the mean over the faces, as Max's
    /// weighted mean (1999), from a cubic fitted to the neighbors, or as the best between a mean and the cubic, which is
    /// also what a mesh without normals gets.
    #[arg(long, default_value = "given", value_parser = one_of::<Normals>(Normals::NAMES))]
    pub normals: Normals,
    /// Shader: how the light inside each triangle is computed.
    #[arg(long, required_unless_present_any = ["truth", "scene"], value_parser = one_of::<Shader>(Shader::NAMES))]
    pub shader: Option<Shader>,
    /// Draw the smooth surface that the mesh approximates, not the mesh. For a mesh from a file, give a file of the same
    /// surface with many more triangles; with a shader, that surface is not drawn, but the picture is compared with it.
    #[arg(long, value_name = "FILE", num_args = 0..=1, default_missing_value = KNOWN)]
    pub truth: Option<PathBuf>,
    /// Continuity depth n of the strips at the edges, 1 to 32 or inf; used by fixed, gradient and the corrections.
    #[arg(long, value_name = "N", default_value = "1")]
    pub depth: Depth,
    /// Width b of the strips, as a barycentric weight, 0 to 1; values above 1/3 act as 1/3.
    #[arg(long, value_name = "B", default_value_t = shading::Shade::new(Shader::Fixed).boundary, value_parser = within(0.0, 1.0))]
    pub boundary: f64,
    /// Vertex shading correction (Bangay, eq. 7).
    #[arg(long, default_value = "off", value_parser = one_of::<Correction>(Correction::NAMES))]
    pub vertex: Correction,
    /// Intensity reweighting correction (Bangay, eq. 9).
    #[arg(long, default_value = "off", value_parser = one_of::<Correction>(Correction::NAMES))]
    pub reweight: Correction,
    /// Rotation of the mesh about x, then y, then z, in degrees.
    #[arg(long, value_name = "X,Y,Z", default_value = "25,-35,0", allow_hyphen_values = true)]
    pub rotate: Triple,
    /// Direction toward the lamp: x right, y up, z toward the viewer.
    #[arg(long, value_name = "X,Y,Z", default_value = "0.36,0.48,0.8", allow_hyphen_values = true)]
    pub light: Triple,
    /// Color of the surface: gray, yellow, red, green, blue, R,G,B (linear weights), hsv:H,S,V or xyY:x,y,Y.
    #[arg(long, default_value = "gray")]
    pub color: StimulusColor,
    /// Ambient light, 0 to 1.
    #[arg(long, value_name = "L", default_value_t = Scene::default().ambient, value_parser = within(0.0, 1.0))]
    pub ambient: f64,
    /// Diffuse light at normal incidence, 0 to 1.
    #[arg(long, value_name = "L", default_value_t = Scene::default().diffuse, value_parser = within(0.0, 1.0))]
    pub diffuse: f64,
    /// Strength of the highlight, 0 to 1: what phong and blinn add at its center; torrance-sparrow and cook-torrance may
    /// add more or less.
    #[arg(long, value_name = "L", default_value_t = Scene::default().specular, value_parser = within(0.0, 1.0))]
    pub specular: f64,
    /// Highlight model.
    #[arg(long, default_value = "phong", value_parser = one_of::<Highlight>(Highlight::NAMES))]
    pub highlight: Highlight,
    /// Exponent of the highlight.
    #[arg(long, value_name = "M", default_value_t = Scene::default().shininess, value_parser = within(1.0, 1000.0))]
    pub shininess: f64,
    /// Root mean square slope m of the small mirrors of torrance-sparrow and cook-torrance, 0.001 to 10; without it, the
    /// highlight is as sharp as Blinn's.
    #[arg(long, value_name = "M", value_parser = within(0.001, 10.0))]
    pub facet_slope: Option<f64>,
    /// Constant c1 of torrance-sparrow, 0 to 1e6; without it, as many mirrors face along the normal as in cook-torrance.
    #[arg(long, value_name = "C1", value_parser = within(0.0, 1e6))]
    pub facet_c1: Option<f64>,
    /// Index of refraction of the small mirrors, 1 to 1000; they reflect ((index - 1) / (index + 1))^2 of the light at
    /// normal incidence [default: 3].
    #[arg(long, value_name = "INDEX", value_parser = within(1.0, 1000.0))]
    pub facet_index: Option<f64>,
    /// Background light, 0 to 1.
    #[arg(long, value_name = "L", default_value_t = Scene::default().background, value_parser = within(0.0, 1.0))]
    pub background: f64,
    /// Distance of the eye in mesh radii, 1.05 to 1e6; inf for a parallel projection.
    #[arg(long, value_name = "R", default_value_t = f64::INFINITY, value_parser = distance)]
    pub distance: f64,
    /// Width of the image in degrees of visual angle, for the difference from the smooth surface, 0.5 to 170.
    #[arg(long = "window", value_name = "DEG", default_value_t = ViewingConditions::WINDOW_DEG, value_parser = within(0.5, 170.0))]
    pub window_deg: f64,
}

/// What the request's `truth` stands for without a file: the surface that the built-in shape approximates.
const KNOWN: &str = "known";

/// Parses the distance of the eye, in mesh radii.
fn distance(text: &str) -> Result<f64, String> {
    match text {
        "inf" => Ok(f64::INFINITY),
        _ => within(1.05, 1e6)(text).map_err(|error| format!("{error}, or inf (the mesh has a radius of 1)")),
    }
}

impl OneMesh {
    fn shade(&self) -> shading::Shade {
        let Self { depth, boundary, vertex, reweight, .. } = *self;
        // Without a shader, only the smooth surface is drawn, which every pixel lights.
        let shader = self.shader.unwrap_or(Shader::Phong);
        shading::Shade { shader, depth, boundary, vertex, reweight }
    }

    pub(super) fn checked_shade(&self) -> Result<shading::Shade, RequestError> {
        let shade = self.shade();
        let drawn =
            self.shader.map_or_else(|| "the smooth surface".to_owned(), |shader| format!("the shader {shader}"));
        match shade.idle_correction(&drawn) {
            Some((field, _, problem)) => Err(RequestError::value(field, format!("{problem}; expected off"))),
            None => Ok(shade),
        }
    }

    /// Returns the built-in shape that the request names, if it does.
    pub(super) fn named(&self) -> Option<Shape> {
        self.mesh.to_str().and_then(|name| name.parse().ok())
    }

    pub(super) fn scene(&self) -> Result<Scene, RequestError> {
        let light = DVec3::from_array(self.light.0);
        if !(1e-6..=1e6).contains(&light.length()) {
            let message = format!("{} is too short or too long; expected a length from 1e-6 to 1e6", self.light);
            return Err(RequestError::value("light", message));
        }
        let mirrors = Mirrors { slope: self.facet_slope, c1: self.facet_c1, index: self.facet_index };
        if let Some((name, problem)) = self.highlight.idle_option(mirrors) {
            return Err(RequestError::value(name, problem));
        }
        Ok(Scene {
            rotate_deg: self.rotate.0,
            light,
            color: DVec3::from_array(self.color.rgb()),
            ambient: self.ambient,
            diffuse: self.diffuse,
            specular: self.specular,
            highlight: self.highlight,
            shininess: self.shininess,
            mirrors,
            background: self.background,
            distance: self.distance,
            ..Scene::default()
        })
    }

    /// Says which options have no effect on a mesh, which is a built-in one if it is `named`.
    pub(super) fn idle(&self, named: Option<Shape>, is_measured: bool) -> Vec<String> {
        let idle = |(field, _): (String, Value)| {
            let why = match &field[..] {
                "depth" | "boundary" if !self.shade().has_strip() => "nothing draws strips",
                "vertices" if !named.is_some_and(Shape::has_vertices) => "the mesh has as many as it has",
                "crease" if named.is_some() => "built-in meshes have their own creases",
                "shininess" if self.facet_slope.is_some() => "facet_slope says how sharp the highlight is",
                "window_deg" if !is_measured => "nothing is measured",
                _ => return None,
            };
            Some(format!("{field} has no effect, because {why}"))
        };
        changed(self).into_iter().filter_map(idle).collect()
    }

    pub(super) fn fine_file(&self) -> Option<&Path> {
        self.truth.as_deref().filter(|file| *file != KNOWN)
    }

    /// Returns the smooth surface in `frame`, if it is known.
    pub(super) fn truth(&self, frame: &Frame, fine: Option<&Surface>) -> Option<Truth> {
        match fine {
            Some(fine) => Some(Truth::of_mesh(frame, fine)),
            None => Truth::traced(frame),
        }
    }

    /// Returns the mesh that the request names.
    ///
    /// # Errors
    /// There is no such shape, or the file cannot be read.
    pub fn mesh(&self) -> anyhow::Result<MeshFile> {
        let path = &self.mesh;
        if let Some(shape) = self.named() {
            let mesh = shapes::mesh(shape, self.vertices);
            let mesh = mesh.map_err(|error| RequestError::new("vertices", error))?;
            return Ok(MeshFile { mesh, notes: Vec::new() });
        }
        if path.extension().is_none() && matches!(found(path), Ok(None)) {
            return Err(RequestError::new("mesh", Shape::missing(&path.to_string_lossy())).into());
        }
        Ok(store::mesh::read(path, self.crease, self.normals)?)
    }

    /// Describes all parameters of the image.
    pub(super) fn describe(&self, scene: &Scene, size: u32) -> Value {
        let vertices = self.named().is_some_and(Shape::has_vertices).then_some(self.vertices);
        let mut all = json!({ "mesh": self.mesh.display().to_string(), "vertices": vertices, "crease_deg": self.crease, "normals": self.normals });
        append(&mut all, json!(self.shade()));
        if let Some(file) = &self.truth {
            append(&mut all, json!({ "truth": file.display().to_string(), "draws_truth": self.shader.is_none() }));
        }
        append(&mut all, describe_scene(scene));
        append(&mut all, json!({ "color": self.color.to_string(), "size": size }));
        all
    }
}

/// Adds the fields of one object to another.
pub(super) fn append(object: &mut Value, fields: Value) {
    if let (Value::Object(object), Value::Object(fields)) = (object, fields) {
        object.extend(fields);
    }
}
