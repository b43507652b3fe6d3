//! The picture of a shaded mesh or scene, and its measurements.

use std::{
    collections::HashSet,
    fmt::Display,
    path::{Path, PathBuf},
};

use glam::DVec3;
use rayon::prelude::*;
use serde::{Serialize, Serializer};
use serde_json::{Value, json};

use super::{
    Image, Luminances, RequestError, Watcher,
    request::{self, changed},
};
use crate::{
    light::{CodeImage, Depth, LinearImage, Quantizer, Transfers},
    report::document::numbers::count,
    shading::{
        self, Body, Correction, Creases, Frame, Highlight, Mirrors, Normals, Scene, Shader, Surface, Truth, crease,
        image, shapes::Shape,
    },
    stimulus::{Judged, Residual, StimulusColor, SurfaceDifference, Triple, ViewingConditions, emitted},
    store::{
        self,
        mesh::{MeshError, MeshFile, shape_of},
        scene::SceneFile,
    },
    text::{
        names::one_of,
        number::{whole, within},
    },
    vision::VisionError,
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
    /// Normals at the vertices: the mesh's own, or estimated from its triangles as the mean over the faces, or as the best
    /// between a mean and a cubic that is fitted to the neighbors, which is also what a mesh without normals gets.
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
    #[arg(long, value_name = "X,Y,Z", default_value_t = Triple(Scene::default().rotate_deg), allow_hyphen_values = true)]
    pub rotate: Triple,
    /// Direction toward the lamp: x right, y up, z toward the viewer.
    #[arg(long, value_name = "X,Y,Z", default_value_t = Triple(Scene::default().light.to_array()), allow_hyphen_values = true)]
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
    #[serde(serialize_with = "number_or_inf")]
    pub distance: f64,
    /// Width of the image in degrees of visual angle, for the difference from the smooth surface, 0.5 to 170.
    #[arg(long = "window", value_name = "DEG", default_value_t = ViewingConditions::WINDOW_DEG, value_parser = within(0.5, 170.0))]
    pub window_deg: f64,
}

/// What the request's `truth` stands for without a file: the surface that the built-in shape approximates.
const KNOWN: &str = "known";

/// Writes a number that may be infinite, which JSON's cannot be.
fn number_or_inf<S: Serializer>(number: &f64, serializer: S) -> Result<S::Ok, S::Error> {
    if number.is_finite() { serializer.serialize_f64(*number) } else { serializer.serialize_str("inf") }
}

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

    fn scene(&self) -> Result<Scene, RequestError> {
        let light = DVec3::from_array(self.light.0);
        if !(1e-6..=1e6).contains(&light.length()) {
            let message = format!("{} is too short or too long; expected a length from 1e-6 to 1e6", self.light);
            return Err(RequestError::value("light", message));
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
            mirrors: Mirrors { slope: self.facet_slope, c1: self.facet_c1, index: self.facet_index },
            background: self.background,
            distance: self.distance,
            ..Scene::default()
        })
    }

    /// Says which options have no effect on a mesh, which is a built-in one if it is `named`.
    fn idle(&self, named: Option<Shape>, is_measured: bool) -> Vec<String> {
        let idle = |(field, _): (String, Value)| {
            let why = match &field[..] {
                "depth" | "boundary" if !self.shade().has_strip() => "nothing draws strips",
                "vertex" | "reweight" if !self.shade().shader.interpolates_light() => "no light is interpolated",
                "facet_c1" if self.highlight != Highlight::TorranceSparrow => "only torrance-sparrow uses it",
                "facet_slope" | "facet_index" if !self.highlight.has_mirrors() => "the highlight has no small mirrors",
                "vertices" if !named.is_some_and(Shape::has_vertices) => "the mesh has as many as it has",
                "crease" if named.is_some() => "built-in meshes have their own creases",
                "shininess" if self.facet_slope.is_some() && self.highlight.has_mirrors() => {
                    "facet_slope says how sharp the highlight is"
                }
                "window_deg" if !is_measured => "nothing is measured",
                _ => return None,
            };
            Some(format!("{field} has no effect, because {why}"))
        };
        changed(self).into_iter().filter_map(idle).collect()
    }

    fn fine_file(&self) -> Option<&Path> {
        self.truth.as_deref().filter(|file| *file != KNOWN)
    }

    /// Returns the smooth surface in `frame`, if it is known.
    fn truth(&self, frame: &Frame, fine: Option<&Surface>) -> Option<Truth> {
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
        let opened = store::mesh::open(Path::new(""), &self.mesh, self.vertices, self.crease, self.normals);
        opened.map_err(|error| match error {
            MeshError::Unknown(message) => RequestError::new("mesh", message).into(),
            MeshError::Vertices(message) => RequestError::new("vertices", message).into(),
            MeshError::File(errors) => errors.into(),
        })
    }
}

/// A mesh or a scene, and how it is shaded.
#[derive(Clone, Debug, PartialEq, clap::Args, Serialize)]
pub struct Shade {
    /// A scene of several meshes, with their materials, transparency, and lamps, in place of the options for one mesh.
    #[arg(value_name = "SCENE.toml")]
    pub scene: Option<PathBuf>,
    #[command(flatten)]
    #[serde(flatten)]
    pub one: OneMesh,
    #[command(flatten)]
    #[serde(flatten)]
    pub image: Image,
    #[command(flatten)]
    #[serde(flatten)]
    pub luminances: Luminances,
}

/// A mesh and the surface with which it is compared are taken for different ones if more than this share of their pixels
/// shows only one of them.
const APART: f64 = 0.1;

/// Which results are wanted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Wanted {
    /// The picture.
    pub picture: bool,
    /// The measurements, which take longer than the picture.
    pub metrics: bool,
}

/// A shaded mesh or scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Shaded {
    pub picture: Option<CodeImage>,
    pub metrics: Option<Metrics>,
    /// The display's transfer functions, for which the picture was made.
    pub transfers: Transfers,
    /// Every parameter, as image files record them.
    pub description: Value,
    /// What is unusual about the mesh or the light.
    pub notes: Vec<String>,
}

/// How smooth the edges of a shaded mesh are, and how far and how visibly it differs from the smooth surface. What is
/// `over_gouraud` is relative to Gouraud shading, and missing if that has only rounding error.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Metrics {
    /// Every parameter.
    #[serde(flatten)]
    pub description: Value,
    /// Number of different positions of vertices.
    pub sites: usize,
    pub triangles: usize,
    /// Number of triangles that face the viewer.
    pub triangles_seen: usize,
    /// Number of interior edges between two triangles that face the viewer.
    pub edges: usize,
    #[serde(flatten)]
    pub creases: Creases,
    pub crease_rms_gouraud: f64,
    pub crease_rms_over_gouraud: Option<f64>,
    pub crease_median_over_gouraud: Option<f64>,
    pub crease_p95_over_gouraud: Option<f64>,
    pub crease_unit: &'static str,
    #[serde(flatten)]
    pub viewing: ViewingConditions,
    /// How visible the difference from the smooth surface is; `None` if that is not known or no pixel can be compared.
    pub difference: Option<Compared<SurfaceDifference>>,
    pub difference_unit: &'static str,
    /// The difference from the smooth surface in light; `None` if that is not known or no pixel can be compared.
    pub residual: Option<Compared<Residual>>,
    pub residual_unit: &'static str,
    /// The share of the surface that is not compared, 0…1; `None` if nothing is.
    pub masked: Option<f64>,
}

/// What was measured, and the same relative to Gouraud's.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Compared<T> {
    #[serde(flatten)]
    pub own: T,
    pub over_gouraud: Value,
}

impl Shade {
    /// Draws and measures what is wanted of `given`, or of the mesh or scene that the request names. A scene has nothing
    /// but a picture.
    ///
    /// # Errors
    /// A value is impossible, a file cannot be read, no triangle faces the viewer, or the picture is too small for a
    /// prediction.
    pub fn shade(&self, given: Option<MeshFile>, wanted: Wanted, watcher: &dyn Watcher) -> anyhow::Result<Shaded> {
        let encoded = self.image.encoding.read(watcher)?;
        let one = &self.one;
        if let Some(scene) = &self.scene {
            request::allow_only(
                one,
                &[],
                "does not apply to a scene; expected keys in its file, or --mesh in its place",
            )?;
            return self.scene(scene, encoded.transfers);
        }
        if one.shader.is_none() && wanted.metrics {
            let message = format!("is missing, but the measurements need one; expected {}", Shader::EXPECTED);
            return Err(RequestError::value("shader", message).into());
        }
        if one.shader.is_some() && one.truth.is_some() && one.fine_file().is_none() {
            let message = "draws the smooth surface itself; expected no --shader, or a file of the smooth surface, with which the picture is compared";
            return Err(RequestError::new("truth", message).into());
        }
        if one.shader.is_some() && one.truth.is_some() && !wanted.metrics {
            let message = "is compared only by the metrics; expected metrics, or no smooth surface";
            return Err(RequestError::new("truth", message).into());
        }
        let mut notes = one.idle(shape_of(&one.mesh).filter(|_| given.is_none()), wanted.metrics);
        let found = given.map_or_else(|| one.mesh(), Ok)?;
        let viewing = encoded.viewing(one.window_deg, &self.luminances);
        let drawing = Drawing::new(one, found, self.image.size, &mut notes)?;
        // Only a path that is not Unicode cannot be written.
        let mut description = serde_json::to_value(self).unwrap_or_default();
        if !shape_of(&one.mesh).is_some_and(Shape::has_vertices) {
            description["vertices"] = Value::Null;
        }
        let picture = wanted.picture.then(|| {
            let image = drawing.image();
            notes.extend(clipped(&image));
            Quantizer::new(&encoded.transfers, self.image.bits).quantize_with(
                &image,
                self.image.dither,
                self.image.seed,
            )
        });
        let metrics = wanted.metrics.then(|| drawing.metrics(viewing, description.clone(), &mut notes)).transpose()?;
        Ok(Shaded { picture, metrics, transfers: encoded.transfers, description, notes })
    }

    /// Draws a scene of several meshes.
    fn scene(&self, scene: &Path, transfers: Transfers) -> anyhow::Result<Shaded> {
        let SceneFile { composition, text, mut notes } = store::scene::read(scene)?;
        let of_body = |(i, body): (usize, &Body)| {
            non_manifold(&format_args!("{}, mesh {}", scene.display(), i + 1), &body.surface)
        };
        notes.extend(composition.bodies.iter().enumerate().filter_map(of_body));
        let image = composition.image(self.image.size, self.image.size);
        notes.extend(clipped(&image));
        let picture =
            Quantizer::new(&transfers, self.image.bits).quantize_with(&image, self.image.dither, self.image.seed);
        let description = json!({ "scene": scene.display().to_string(), "size": self.image.size, "toml": text });
        Ok(Shaded { picture: Some(picture), metrics: None, transfers, description, notes })
    }
}

/// A mesh in its place, with everything that determines how it looks.
struct Drawing<'a> {
    one: &'a OneMesh,
    shade: shading::Shade,
    scene: Scene,
    surface: Surface,
    frame: Frame,
    /// A finer mesh for the same surface, if one was given.
    fine: Option<Surface>,
}

impl<'a> Drawing<'a> {
    /// Puts a mesh in its place.
    fn new(one: &'a OneMesh, file: MeshFile, size: u32, notes: &mut Vec<String>) -> anyhow::Result<Self> {
        let (shade, scene) = (one.shade(), one.scene()?);
        notes.extend(file.note(&one.mesh));
        let surface = Surface::new(file.mesh.estimated(one.normals));
        let frame = scene.frame(&surface, size, size);
        let name = one.mesh.display();
        notes.extend(non_manifold(&name, &surface));
        if one.truth.is_some() && one.fine_file().is_none() && frame.smooth.is_none() {
            let message = format!("the smooth surface behind {name} is not known; expected the file of a finer mesh");
            return Err(RequestError::new("truth", message).into());
        }
        if frame.triangles.is_empty() {
            anyhow::bail!("{name}: no triangle faces the viewer and is large enough to be seen; expected at least one");
        }
        // A smooth surface is not flat for want of normals.
        let fine = |path| {
            let file = store::mesh::read(path, one.crease, Normals::Best)?;
            notes.extend(file.note(path));
            anyhow::Ok(Surface::new(file.mesh))
        };
        let fine = one.fine_file().map(fine).transpose()?;
        Ok(Drawing { one, shade, scene, surface, frame, fine })
    }

    /// Returns the light of the picture.
    fn image(&self) -> LinearImage {
        let truth = || self.one.truth(&self.frame, self.fine.as_ref());
        let truth = self.one.shader.is_none().then(truth).flatten();
        truth.map_or_else(|| image(&self.frame, &self.shade), |truth| truth.picture(&self.frame))
    }

    /// Measures this picture and Gouraud's.
    fn metrics(
        &self,
        viewing: ViewingConditions,
        mut description: Value,
        notes: &mut Vec<String>,
    ) -> anyhow::Result<Metrics> {
        // It is one of the viewing conditions.
        description.as_object_mut().map(|all| all.remove("window_deg"));
        let Self { one, shade, surface, frame, .. } = self;
        let (plain, side) = (frame.clone().unpainted(), ViewingConditions::PICTURE_PX);
        let seen = self.scene.frame(surface, side, side).unpainted();
        let judged = Judged::new(&seen, one.truth(&seen, self.fine.as_ref()).as_ref());
        if let Some(apart) = judged.apart().filter(|apart| *apart > APART)
            && let Some(file) = one.fine_file()
        {
            notes.push(format!(
                "the outlines of {} and {} differ by {:.0} % of the pixels; expected the same surface in the same place",
                file.display(),
                one.mesh.display(),
                100.0 * apart
            ));
        }
        let unseen = |error: VisionError| {
            let (field, value) = match error {
                VisionError::Black { .. } | VisionError::AllBlack => ("black", viewing.black_cd_m2),
                _ => ("window_deg", viewing.window_deg),
            };
            RequestError::value(field, format!("{value}: {error}"))
        };
        let measured = |shade: &shading::Shade| {
            let emitted = emitted(&seen, shade);
            let difference = judged.difference(&viewing, &emitted).map_err(unseen)?;
            Ok::<_, RequestError>((Creases::of(&plain, shade), difference, judged.residual(&viewing, &emitted)))
        };
        let own = measured(shade)?;
        let gouraud = if shade.is_gouraud() { own.clone() } else { measured(&shading::Shade::new(Shader::Gouraud))? };
        let [(creases, difference, residual), (creases_gouraud, difference_gouraud, residual_gouraud)] = [own, gouraud];
        let sites: HashSet<_> = surface.mesh.vertices.iter().map(|vertex| vertex.site).collect();
        let residual = residual.zip(residual_gouraud).map(|(own, gouraud)| Compared {
            own,
            over_gouraud: json!({ "rms": over(own.rms, gouraud.rms), "p999": over(own.p999, gouraud.p999) }),
        });
        let difference = difference.zip(difference_gouraud).map(|(own, gouraud)| Compared {
            over_gouraud: json!({ "largest": over(own.largest, gouraud.largest), "p95": over(own.p95, gouraud.p95) }),
            own,
        });
        Ok(Metrics {
            description,
            sites: sites.len(),
            triangles: surface.mesh.triangles.len(),
            triangles_seen: frame.triangles.len(),
            edges: creases.edges.len(),
            crease_rms_gouraud: creases_gouraud.rms,
            crease_rms_over_gouraud: over(creases.rms, creases_gouraud.rms),
            crease_median_over_gouraud: over(creases.median, creases_gouraud.median),
            crease_p95_over_gouraud: over(creases.p95, creases_gouraud.p95),
            creases,
            crease_unit: "linear light per pixel",
            viewing,
            difference,
            difference_unit: "times threshold, against the smooth surface",
            residual,
            residual_unit: "linear light, filtered by contrast sensitivity, against the smooth surface",
            masked: judged.not_compared(),
        })
    }
}

/// Says how many edges of a mesh cannot be shaded smoothly, if any.
fn non_manifold(name: &dyn Display, surface: &Surface) -> Option<String> {
    let found = surface.non_manifold;
    (found > 0).then(|| {
        format!(
            "{name}: shading is not smooth across edges that belong to more than two triangles, or to neighbors with opposite winding ({found} found)"
        )
    })
}

/// Says how many pixels are brighter than white, if any.
fn clipped(image: &LinearImage) -> Option<String> {
    let clipped = image.data.par_chunks_exact(3).filter(|pixel| pixel.iter().any(|light| *light > 1.0)).count();
    let pixels = count(clipped as u64, "pixel");
    (clipped > 0).then(|| format!("light above white is clipped, which creates edges ({pixels})"))
}

/// Returns `value` relative to Gouraud's; `None` if Gouraud's is only rounding error.
fn over(value: f64, gouraud: f64) -> Option<f64> {
    (gouraud > crease::NOISE).then(|| value / gouraud)
}
