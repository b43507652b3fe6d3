//! `machband shade`

use std::{
    collections::HashSet,
    path::{Path, PathBuf},
};

use glam::DVec3;
use serde_json::{Value, json};

use super::{OutPath, count, message, options::TransferOptions, print_line};
use crate::{
    light::{Bits, CodeImage, Depth, LinearImage, Quantizer, Transfer, Transfers},
    shading::{
        Correction, Creases, EdgeKind, Frame, Gradients, Highlight, Mesh, Normals, Scene, Shade, Shader, Surface,
        Truth, crease,
        shapes::{self, Shape},
    },
    stimulus::{
        Judged, Renderer, Residual, Shot, StimulusColor, Triple, Undershoot, ViewingConditions, describe_scene,
    },
    store::{self, Writer, scene::SceneFile},
    vision::{PicturePrediction, Visibility, VisionError},
    work::{RequestError, named},
};

/// Shade a mesh: write its image, measure how smooth its edges are, and predict how visible its bands are.
///
/// Bands are predicted as in `machband predict`, on the surface within its outlines, from light that is not rounded to
/// codes: 0 means no band, 1 means a band that is just visible. The prediction always uses an image of 512 × 512 pixels
/// that is --window degrees wide, regardless of --size; the eye is assumed to be adapted to its mean luminance.
#[derive(clap::Args)]
#[command(
    allow_negative_numbers = true,
    after_help = "Example: machband shade --mesh blob --vertices 313 --shader exact --depth 3 --boundary 0.2 --out exact.png --metrics exact.json"
)]
pub struct Arguments {
    /// A scene of several meshes, with their materials, transparency, and lamps, in place of the options for one mesh.
    #[arg(value_name = "SCENE.toml", conflicts_with_all = ONE_MESH)]
    scene: Option<PathBuf>,
    /// Mesh: cube, pyramid, sphere, uv-sphere, torus, jittered-torus, blob, terrain, cylinder, filleted-cylinder, or the
    /// path to an OBJ, PLY, glTF or GLB file.
    #[arg(long, value_name = "MESH", default_value = "blob")]
    mesh: PathBuf,
    /// Number of vertices; exact for a blob, approximate for other round shapes.
    #[arg(long, value_name = "N", default_value_t = 313)]
    vertices: usize,
    /// Angle in degrees above which the edge between two faces of a file is a crease.
    #[arg(long, value_name = "DEG", default_value_t = 180.0, value_parser = within(0.0, 180.0))]
    crease: f64,
    /// Normals at the vertices: the mesh's own, or estimated from its triangles as the mean over the faces, as Max's
    /// weighted mean (1999), or from a cubic fitted to the neighbors.
    #[arg(long, default_value = "given", value_parser = named::<Normals>(Normals::NAMES))]
    normals: Normals,
    /// Shader: how the light inside each triangle is computed.
    #[arg(long, required_unless_present_any = ["truth", "scene"], value_parser = named::<Shader>(Shader::NAMES))]
    shader: Option<Shader>,
    /// Draw the smooth surface that the mesh approximates, not the mesh. For a mesh from a file, the surface is this file
    /// with many more triangles; with --shader, it is only what --metrics compares the picture with.
    #[arg(long, value_name = "FILE", num_args = 0..=1, default_missing_value = KNOWN)]
    truth: Option<PathBuf>,
    /// Continuity depth n of the strips at the edges, 1 to 32 or inf; used by fixed, gradient, exact, cut and the
    /// corrections.
    #[arg(long, value_name = "N", default_value = "1")]
    depth: Depth,
    /// Width b of the strips, as a barycentric weight, 0 to 1; values above 1/3 affect only cut [default: 1/3 for
    /// cut, otherwise 0.2].
    #[arg(long, value_name = "B", value_parser = within(0.0, 1.0))]
    boundary: Option<f64>,
    /// Vertex shading correction (Bangay, eq. 7).
    #[arg(long, default_value = "off", value_parser = named::<Correction>(Correction::NAMES))]
    vertex: Correction,
    /// Intensity reweighting correction (Bangay, eq. 9).
    #[arg(long, default_value = "off", value_parser = named::<Correction>(Correction::NAMES))]
    reweight: Correction,
    /// How patch and c1-phong compute their slopes.
    #[arg(long, default_value = "curvature", value_parser = named::<Gradients>(Gradients::NAMES))]
    gradients: Gradients,
    /// Rotation of the mesh about x, then y, then z, in degrees.
    #[arg(long, value_name = "X,Y,Z", default_value = "25,-35,0", allow_hyphen_values = true)]
    rotate: Triple,
    /// Direction toward the lamp: x right, y up, z toward the viewer.
    #[arg(long, value_name = "X,Y,Z", default_value = "0.36,0.48,0.8", allow_hyphen_values = true)]
    light: Triple,
    /// Color of the surface: gray, yellow, red, green, blue, R,G,B (linear weights), hsv:H,S,V or xyY:x,y,Y.
    #[arg(long, default_value = "gray")]
    color: StimulusColor,
    /// Ambient light, 0 to 1.
    #[arg(long, value_name = "L", default_value_t = Scene::default().ambient, value_parser = within(0.0, 1.0))]
    ambient: f64,
    /// Diffuse light at normal incidence, 0 to 1.
    #[arg(long, value_name = "L", default_value_t = Scene::default().diffuse, value_parser = within(0.0, 1.0))]
    diffuse: f64,
    /// Specular light at the center of a highlight, 0 to 1.
    #[arg(long, value_name = "L", default_value_t = Scene::default().specular, value_parser = within(0.0, 1.0))]
    specular: f64,
    /// Highlight model.
    #[arg(long, default_value = "phong", value_parser = named::<Highlight>(Highlight::NAMES))]
    highlight: Highlight,
    /// Exponent of the highlight.
    #[arg(long, value_name = "M", default_value_t = Scene::default().shininess, value_parser = within(1.0, 1000.0))]
    shininess: f64,
    /// Background light, 0 to 1.
    #[arg(long, value_name = "L", default_value_t = Scene::default().background, value_parser = within(0.0, 1.0))]
    background: f64,
    /// Distance of the eye in mesh radii, 1.05 to 1e6; inf for a parallel projection.
    #[arg(long, value_name = "R", default_value_t = f64::INFINITY, value_parser = distance)]
    distance: f64,
    /// Interpolate encoded values, like a renderer that ignores gamma.
    #[arg(long)]
    naive: bool,
    /// Side of the image in pixels.
    #[arg(long, value_name = "PX", default_value_t = 1024, value_parser = clap::value_parser!(u32).range(1..=16384))]
    size: u32,
    #[command(flatten)]
    transfer: TransferOptions,
    /// Bits per channel.
    #[arg(long, default_value = "8", value_parser = named::<Bits>(&["8", "16"]))]
    bits: Bits,
    /// Where to write the image.
    #[arg(long, value_name = "FILE.png")]
    out: Option<OutPath>,
    /// Where to write the measurements: the change of slope across the edges, in linear light per pixel, the visibility
    /// and density of the bands, and the visible difference from the smooth surface, each also relative to Gouraud's.
    #[arg(long, value_name = "FILE.json")]
    metrics: Option<OutPath>,
    /// Where to write an image of the change of slope at each edge.
    #[arg(long, value_name = "FILE.png")]
    creases: Option<OutPath>,
    /// Width of the image in degrees of visual angle, for the visibility of bands, 0.5 to 170.
    #[arg(long, value_name = "DEG", default_value_t = 10.0, value_parser = within(0.5, 170.0))]
    window: f64,
    /// Luminance of white in cd/m², for the visibility of bands [default: the display profile's, or 100].
    #[arg(long, value_name = "CD_M2", value_parser = within(1e-3, 1e6))]
    white: Option<f64>,
}

/// The options that a scene replaces.
const ONE_MESH: [&str; 26] = [
    "mesh",
    "vertices",
    "crease",
    "normals",
    "shader",
    "truth",
    "depth",
    "boundary",
    "vertex",
    "reweight",
    "gradients",
    "rotate",
    "light",
    "color",
    "ambient",
    "diffuse",
    "specular",
    "highlight",
    "shininess",
    "background",
    "distance",
    "naive",
    "metrics",
    "creases",
    "window",
    "white",
];

/// What `--truth` stands for without a file: the surface that the built-in shape approximates.
const KNOWN: &str = "known";

/// The measurements and predictions for one renderer.
#[derive(Clone)]
struct Measured {
    creases: Creases,
    visibility: Visibility,
    density: f64,
    residual: Option<Residual>,
    undershoot: Undershoot,
}

/// Returns a parser that accepts only numbers from `least` to `most`.
fn within(least: f64, most: f64) -> impl Fn(&str) -> Result<f64, String> + Clone + Send + Sync {
    move |text| match text.parse() {
        Ok(number) if (least..=most).contains(&number) => Ok(number),
        Ok(_) => Err(format!("outside {least}…{most}; expected a number in this range")),
        Err(_) => Err(format!("not a number; expected one from {least} to {most}")),
    }
}

/// Parses the distance of the eye, in mesh radii.
fn distance(text: &str) -> Result<f64, String> {
    match text {
        "inf" => Ok(f64::INFINITY),
        _ => within(1.05, 1e6)(text).map_err(|error| format!("{error}, or inf (the mesh has a radius of 1)")),
    }
}

pub(super) fn run(arguments: &Arguments, writer: &Writer) -> anyhow::Result<()> {
    if [&arguments.out, &arguments.metrics, &arguments.creases].iter().all(|path| path.is_none()) {
        let message = "nothing to write; expected --out FILE.png, --metrics FILE.json or --creases FILE.png";
        return Err(RequestError::whole(message).into());
    }
    if let (Some(scene), Some(out)) = (&arguments.scene, &arguments.out) {
        let (transfers, _) = arguments.transfer.transfers()?;
        let (codes, notes, text) = arguments.scene_codes(scene, &transfers)?;
        notes.iter().for_each(|note| message("note", note));
        let description = json!({ "scene": scene.display().to_string(), "size": arguments.size, "toml": text });
        return Ok(store::image::write_shaded(writer, out, &codes, &transfers, &description)?);
    }
    if arguments.shader.is_none() && (arguments.metrics.is_some() || arguments.creases.is_some()) {
        let message = "--metrics and --creases measure a shader; expected --shader SHADER".to_owned();
        return Err(RequestError::whole(message).into());
    }
    let (mesh, note) = arguments.mesh()?;
    note.iter().for_each(|note| message("note", note));
    let drawing = arguments.drawing(mesh)?;
    drawing.note.iter().for_each(|note| message("note", note));
    let Drawing { transfers, frame, description, .. } = &drawing;
    if let Some(out) = &arguments.out {
        let (codes, note) = drawing.codes();
        note.iter().for_each(|note| message("note", note));
        store::image::write_shaded(writer, out, &codes, transfers, description)?;
    }
    if let Some(path) = &arguments.metrics {
        let (metrics, own, gouraud) = drawing.measure()?;
        writer.write(path, format!("{metrics:#}\n").as_bytes())?;
        summarize(drawing.renderer.shade.shader, &own, &gouraud, &drawing.viewing)?;
    }
    if let Some(path) = &arguments.creases {
        let plain = frame.clone().unpainted();
        let creases = drawing.renderer.shoot(&plain, transfers).creases();
        let picture = crease::picture(&plain, &creases, Creases::of_gouraud(&plain).p95);
        let codes = Quantizer::new(&Transfer::Srgb, Bits::Eight).quantize(&picture);
        store::image::write_shaded(writer, path, &codes, &Transfer::Srgb.into(), description)?;
    }
    Ok(())
}

/// A mesh in its place, with everything that determines how it looks.
pub struct Drawing<'a> {
    arguments: &'a Arguments,
    renderer: Renderer,
    scene: Scene,
    viewing: ViewingConditions,
    transfers: Transfers,
    surface: Surface,
    frame: Frame,
    /// A finer mesh for the same surface, if one was given.
    fine: Option<Surface>,
    /// Every parameter.
    description: Value,
    /// What is unusual about the mesh.
    pub note: Option<String>,
}

impl Drawing<'_> {
    /// Returns the codes of the picture, and a note if light was clipped.
    #[must_use]
    pub fn codes(&self) -> (CodeImage, Option<String>) {
        let shot = self.renderer.shoot(&self.frame, &self.transfers);
        let truth = || self.arguments.truth(&self.frame, self.fine.as_ref());
        let truth = self.arguments.draws_truth().then(truth).flatten();
        let image = truth.map_or_else(|| shot.image(), |truth| truth.picture(&shot.frame));
        let codes = Quantizer::new(shot.transfers.clone(), self.arguments.bits).quantize(&image);
        (codes, clipped(&image))
    }

    /// Returns the measurements that `--metrics` writes.
    ///
    /// # Errors
    /// The picture is too small for a prediction.
    pub fn metrics(&self) -> anyhow::Result<Value> {
        self.measure().map(|(metrics, ..)| metrics)
    }

    /// Returns the measurements of this picture and of Gouraud's.
    fn measure(&self) -> anyhow::Result<(Value, Measured, Measured)> {
        let Self { arguments, renderer, viewing, transfers, surface, frame, .. } = self;
        let (plain, side) = (frame.clone().unpainted(), ViewingConditions::PICTURE_PX);
        let seen = self.scene.frame(surface, side, side).unpainted();
        let judged = Judged::new(viewing, &seen, arguments.truth(&seen, self.fine.as_ref()).as_ref())
            .map_err(|error| anyhow::anyhow!("--window {}: {error}", arguments.window))?;
        let measured = |renderer: &Renderer| {
            let creases = renderer.shoot(&plain, transfers).creases();
            arguments.measured(creases, &renderer.shoot(&seen, transfers), &judged, viewing)
        };
        let own = measured(renderer)?;
        let gouraud = if renderer.is_gouraud() { own.clone() } else { measured(&Renderer::gouraud())? };
        let mut metrics = self.description.clone();
        append(&mut metrics, measurements(surface, frame, &own, &gouraud, viewing));
        append(&mut metrics, compared(&own, &gouraud, &judged));
        Ok((metrics, own, gouraud))
    }
}

/// Says how many pixels are brighter than white, if any.
fn clipped(image: &LinearImage) -> Option<String> {
    let clipped = image.data.chunks_exact(3).filter(|pixel| pixel.iter().any(|light| *light > 1.0)).count();
    let pixels = count(clipped as u64, "pixel");
    (clipped > 0).then(|| format!("light above white is clipped, which creates edges ({pixels})"))
}

/// Returns `value` relative to Gouraud's; `None` if Gouraud's is only rounding error.
fn over(value: f64, gouraud: f64) -> Option<f64> {
    (gouraud > crease::NOISE).then(|| value / gouraud)
}

/// Prints the measurements that matter most.
fn summarize(shader: Shader, own: &Measured, gouraud: &Measured, viewing: &ViewingConditions) -> anyhow::Result<()> {
    let of_gouraud = |of: fn(&Measured) -> f64| match over(of(own), of(gouraud)) {
        Some(over) => format!("{over:.4} times Gouraud's"),
        None => "Gouraud has none".to_owned(),
    };
    let (rms, edges, over) = (own.creases.rms, own.creases.edges.len(), of_gouraud(|of| of.creases.rms));
    print_line(&format!("{shader}: crease rms {rms:.3e} per pixel over {}, {over}", count(edges as u64, "edge")))?;
    let (Visibility { bright, dark }, deg) = (own.visibility, viewing.window_deg);
    let (visibility, over) = (own.visibility.max(), of_gouraud(|of| of.visibility.max()));
    print_line(&format!(
        "{shader}: visibility of bands {visibility:.2} (bright {bright:.2}, dark {dark:.2}) in a {deg}° window, {over}"
    ))?;
    if let Some(Residual { rms, p999 }) = own.residual {
        let over = of_gouraud(|of| of.residual.map_or(0.0, |residual| residual.rms));
        print_line(&format!(
            "{shader}: visible difference from the smooth surface rms {rms:.2e}, 99.9 % {p999:.2e}, {over}"
        ))?;
    } else {
        print_line(&format!(
            "{shader}: the bands include those of the surface itself, which is not known; --truth FILE names a finer mesh"
        ))?;
    }
    Ok(())
}

/// Returns the comparison with the smooth surface, and what it leaves out.
fn compared(own: &Measured, gouraud: &Measured, judged: &Judged) -> Value {
    let residual = own.residual.zip(gouraud.residual).map(|(own, gouraud)| {
        json!({
            "rms": own.rms,
            "p999": own.p999,
            "over_gouraud": { "rms": over(own.rms, gouraud.rms), "p999": over(own.p999, gouraud.p999) },
            "masked": judged.not_compared(),
        })
    });
    json!({
        "residual": residual,
        "residual_unit": "linear light, filtered by contrast sensitivity, against the smooth surface",
        "masked": judged.masked(),
        "undershoot": {
            "below_ambient": own.undershoot.below_ambient,
            "most": own.undershoot.most,
            "clipped": own.undershoot.clipped,
        },
    })
}

/// Adds the fields of one object to another.
fn append(object: &mut Value, fields: Value) {
    if let (Value::Object(object), Value::Object(fields)) = (object, fields) {
        object.extend(fields);
    }
}

/// Returns the numbers of edges and triangles, and the measurements and predictions along with Gouraud's.
fn measurements(
    surface: &Surface,
    frame: &Frame,
    own: &Measured,
    gouraud: &Measured,
    viewing: &ViewingConditions,
) -> Value {
    let sites: HashSet<_> = surface.mesh.vertices.iter().map(|vertex| vertex.site).collect();
    let over = |of: fn(&Measured) -> f64| over(of(own), of(gouraud));
    json!({
        "sites": sites.len(),
        "triangles": surface.mesh.triangles.len(),
        "triangles_seen": frame.triangles.len(),
        "edges": own.creases.edges.len(),
        "crease_rms": own.creases.rms,
        "crease_median": own.creases.median,
        "crease_p95": own.creases.p95,
        "crease_max": own.creases.max,
        "crease_rms_gouraud": gouraud.creases.rms,
        "crease_rms_over_gouraud": over(|of| of.creases.rms),
        "crease_median_over_gouraud": over(|of| of.creases.median),
        "crease_p95_over_gouraud": over(|of| of.creases.p95),
        "step_rms": own.creases.step_rms,
        "crease_unit": "linear light per pixel",
        "window_deg": viewing.window_deg,
        "white_cd_m2": viewing.white_cd_m2,
        "visibility": own.visibility.max(),
        "visibility_bright": own.visibility.bright,
        "visibility_dark": own.visibility.dark,
        "visibility_gouraud": gouraud.visibility.max(),
        "visibility_over_gouraud": over(|of| of.visibility.max()),
        "visibility_unit": "1 is just visible, like a thin line at its threshold",
        "band_density": own.density,
        "band_density_gouraud": gouraud.density,
        "band_density_over_gouraud": over(|of| of.density),
        "band_density_unit": "root mean square of the visibility over the surface",
    })
}

impl Arguments {
    /// Draws a scene of several meshes. Returns the codes, notes on what is unusual, and the text of the file.
    ///
    /// # Errors
    /// The scene or one of its meshes cannot be read.
    fn scene_codes(&self, scene: &Path, transfers: &Transfers) -> anyhow::Result<(CodeImage, Vec<String>, String)> {
        let SceneFile { composition, text, mut notes } = store::scene::read(scene)?;
        let image = composition.image(self.size, self.size);
        notes.extend(clipped(&image));
        Ok((Quantizer::new(transfers, self.bits).quantize(&image), notes, text))
    }

    /// Draws the scene that the options name, if they name one. Returns the codes, and notes on what is unusual.
    ///
    /// # Errors
    /// The scene or one of its meshes cannot be read.
    pub fn scene_picture(&self) -> anyhow::Result<Option<(CodeImage, Vec<String>)>> {
        let Some(scene) = &self.scene else { return Ok(None) };
        let (codes, notes, _) = self.scene_codes(scene, &self.transfer.transfers()?.0)?;
        Ok(Some((codes, notes)))
    }

    /// Puts a mesh in its place.
    ///
    /// # Errors
    /// An option is impossible, a file cannot be read, or no triangle faces the viewer.
    pub fn drawing(&self, mesh: Mesh) -> anyhow::Result<Drawing<'_>> {
        let (renderer, scene, viewing) = (self.renderer()?, self.scene()?, self.viewing()?);
        let (transfers, _) = self.transfer.transfers()?;
        let surface = Surface::new(mesh.estimated(self.normals));
        let frame = scene.frame(&surface, self.size, self.size);
        let name = self.mesh.display();
        if self.truth.is_some() && self.fine_file().is_none() && frame.smooth.is_none() {
            let message = format!(
                "--truth: the smooth surface behind {name} is not known; expected --truth FILE with a finer mesh"
            );
            return Err(RequestError::whole(message).into());
        }
        if frame.triangles.is_empty() {
            anyhow::bail!("{name}: no triangle faces the viewer; expected at least one");
        }
        let non_manifold = surface.edges.edges.iter().filter(|edge| edge.kind == EdgeKind::NonManifold).count();
        let note = (non_manifold > 0).then(|| {
            format!(
                "{name}: shading is not smooth across edges that belong to more than two triangles, or to neighbors with opposite winding ({non_manifold} found)"
            )
        });
        let (fine, description) = (self.fine()?, self.describe(&scene, &renderer));
        Ok(Drawing { arguments: self, renderer, scene, viewing, transfers, surface, frame, fine, description, note })
    }

    fn renderer(&self) -> Result<Renderer, RequestError> {
        let Self { depth, vertex, reweight, gradients, naive, .. } = *self;
        // Without a shader, only the smooth surface is drawn, which every pixel lights.
        let shader = self.shader.unwrap_or(Shader::Phong);
        let boundary = self.boundary.unwrap_or(Shade::new(shader).boundary);
        if [vertex, reweight] != [Correction::Off; 2] && !shader.interpolates_light() {
            let message = format!("--vertex and --reweight need interpolated light; expected off for {shader}");
            return Err(RequestError::whole(message));
        }
        Ok(Renderer { shade: Shade { shader, depth, boundary, vertex, reweight, gradients }, naive })
    }

    fn scene(&self) -> Result<Scene, RequestError> {
        let light = DVec3::from_array(self.light.0);
        if !(1e-6..=1e6).contains(&light.length()) {
            let message = format!("--light {} is too short or long; expected a length from 1e-6 to 1e6", self.light);
            return Err(RequestError::whole(message));
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
            background: self.background,
            distance: self.distance,
            ..Scene::default()
        })
    }

    fn viewing(&self) -> anyhow::Result<ViewingConditions> {
        let of_profile = self.transfer.white()?;
        let white_cd_m2 = self.white.or(of_profile).unwrap_or(ViewingConditions::WHITE_CD_M2);
        Ok(ViewingConditions { window_deg: self.window, white_cd_m2 })
    }

    /// Combines the measurements with the prediction. An all-black picture has no bands.
    fn measured(
        &self,
        creases: Creases,
        shot: &Shot<'_>,
        judged: &Judged,
        viewing: &ViewingConditions,
    ) -> anyhow::Result<Measured> {
        let emitted = shot.emitted();
        let view = match viewing.predict_surface(judged, &emitted) {
            Ok(view) => view,
            Err(VisionError::AllBlack) => PicturePrediction::default(),
            Err(error) => return Err(anyhow::anyhow!("--window {}: {error}", self.window)),
        };
        let residual = judged.residual(viewing, &emitted);
        let undershoot = shot.undershoot();
        Ok(Measured { creases, visibility: view.visibility, density: view.density, residual, undershoot })
    }

    /// True if the picture is the smooth surface's.
    fn draws_truth(&self) -> bool {
        self.shader.is_none() || (self.truth.is_some() && self.fine_file().is_none())
    }

    fn fine_file(&self) -> Option<&Path> {
        self.truth.as_deref().filter(|file| *file != KNOWN)
    }

    /// Reads the fine mesh, if one is given.
    fn fine(&self) -> anyhow::Result<Option<Surface>> {
        let read = |file: &Path| Ok(Surface::new(store::mesh::read(file, self.crease)?.mesh));
        self.fine_file().map(read).transpose()
    }

    /// Returns the smooth surface in `frame`, if it is known.
    fn truth(&self, frame: &Frame, fine: Option<&Surface>) -> Option<Truth> {
        match fine {
            Some(fine) => Some(Truth::of_mesh(frame, fine)),
            None => Truth::traced(frame),
        }
    }

    /// Returns the mesh that the options name, and a note if it was repaired.
    ///
    /// # Errors
    /// There is no such shape, or the file cannot be read.
    pub fn mesh(&self) -> anyhow::Result<(Mesh, Option<String>)> {
        let path = &self.mesh;
        if let Some(shape) = path.to_str().and_then(|name| name.parse::<Shape>().ok()) {
            let mesh = shapes::mesh(shape, self.vertices);
            return Ok((mesh.map_err(|error| RequestError::whole(format!("--vertices: {error}")))?, None));
        }
        if path.extension().is_none() && !path.exists() {
            let names = Shape::NAMES.join(", ");
            return Err(RequestError::whole(format!(
                "--mesh: {:?} is not known; expected {names} or an OBJ, PLY, glTF or GLB file",
                path.display().to_string()
            ))
            .into());
        }
        let file = store::mesh::read(path, self.crease)?;
        let note = file.note(path);
        Ok((file.mesh, note))
    }

    /// Describes all parameters of the image.
    fn describe(&self, scene: &Scene, renderer: &Renderer) -> Value {
        let mut all = json!({ "mesh": self.mesh.display().to_string(), "vertices": self.vertices, "crease_deg": self.crease, "normals": self.normals });
        append(&mut all, renderer.describe());
        if let Some(file) = &self.truth {
            append(&mut all, json!({ "truth": file.display().to_string(), "draws_truth": self.draws_truth() }));
        }
        append(&mut all, describe_scene(scene));
        append(&mut all, json!({ "color": self.color.to_string(), "naive": self.naive, "size": self.size }));
        all
    }
}
