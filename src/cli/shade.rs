//! `machband shade`

use std::{
    io::Write as _,
    path::{Path, PathBuf},
};

use glam::DVec3;
use serde_json::json;

use super::{UsageError, options::TransferOptions, say};
use crate::{
    light::{Bits, Depth, LinearImage, Quantizer, Transfer, Transfers},
    shading::{
        Correction, Creases, EdgeKind, Frame, Gradients, Highlight, Reference, Scene, Shade, Shader, Surface, crease,
        shapes::{self, Shape},
    },
    stimulus::{Sight, StimulusColor, Triple},
    store,
    vision::{Visibility, VisionError},
};

/// Shade a mesh: write its picture, how far its edges are from smooth, and how visible its bands are.
///
/// Bands are predicted as `machband predict` does, on the surface within its outlines, of light that is not yet rounded
/// to codes: 0 for none, 1 for what is just seen. The eye looks at a picture of 512 × 512 pixels, whatever --size is, in
/// a window of --window degrees, set for the picture's mean light.
#[derive(clap::Args)]
#[command(
    allow_negative_numbers = true,
    after_help = "Example: machband shade --mesh blob --vertices 313 --shader exact --depth 3 --boundary 0.2 --out exact.png --metrics exact.json"
)]
pub(super) struct Arguments {
    /// cube, pyramid, sphere, torus, blob, or an OBJ file.
    #[arg(long, value_name = "MESH", default_value = "blob")]
    mesh: String,
    /// Number of vertices of a blob; about so many of a sphere or torus.
    #[arg(long, value_name = "N", default_value_t = 313)]
    vertices: usize,
    /// Faces of an OBJ file that meet at more than this many degrees make a crease.
    #[arg(long, value_name = "DEG", default_value_t = 180.0)]
    crease: f64,
    /// How light is spread over the triangles.
    #[arg(long, value_parser = clap::builder::PossibleValuesParser::new(Shader::NAMES))]
    shader: String,
    /// Continuity depth n of the strips at the edges, 1 to 32 or inf; for fixed, gradient, exact, cut and corrections.
    #[arg(long, value_name = "N", default_value = "1")]
    depth: Depth,
    /// Width b of those strips, as a barycentric weight, 0 to 1; above 1/3 only cut differs [default: 1/3
    /// for cut, else 0.2].
    #[arg(long, value_name = "B")]
    boundary: Option<f64>,
    /// Vertex shading, Bangay eq. 7.
    #[arg(long, default_value = "off", value_parser = clap::builder::PossibleValuesParser::new(Correction::NAMES))]
    vertex: String,
    /// Intensity reweighting, Bangay eq. 9.
    #[arg(long, default_value = "off", value_parser = clap::builder::PossibleValuesParser::new(Correction::NAMES))]
    reweight: String,
    /// Where patch has its slopes from.
    #[arg(long, default_value = "curvature", value_parser = clap::builder::PossibleValuesParser::new(Gradients::NAMES))]
    gradients: String,
    /// Degrees by which the mesh is turned about x, then y, then z.
    #[arg(long, value_name = "X,Y,Z", default_value = "25,-35,0", allow_hyphen_values = true)]
    rotate: Triple,
    /// Direction toward the lamp: right, up, toward the viewer.
    #[arg(long, value_name = "X,Y,Z", default_value = "0.36,0.48,0.8", allow_hyphen_values = true)]
    light: Triple,
    /// Color of the surface: gray, yellow, red, green, blue, R,G,B (linear weights), hsv:H,S,V or xyY:x,y,Y.
    #[arg(long, default_value = "gray")]
    color: StimulusColor,
    /// Light where the lamp does not reach, 0 to 1.
    #[arg(long, value_name = "L", default_value_t = Scene::default().ambient)]
    ambient: f64,
    /// Light that the lamp adds where it falls straight on the surface, 0 to 1.
    #[arg(long, value_name = "L", default_value_t = Scene::default().diffuse)]
    diffuse: f64,
    /// Light that the middle of a highlight adds, 0 to 1.
    #[arg(long, value_name = "L", default_value_t = Scene::default().specular)]
    specular: f64,
    /// Shape of the highlight.
    #[arg(long, default_value = "phong", value_parser = clap::builder::PossibleValuesParser::new(Highlight::NAMES))]
    highlight: String,
    /// Exponent of the highlight.
    #[arg(long, value_name = "M", default_value_t = Scene::default().shininess)]
    shininess: f64,
    /// Light around the surface, 0 to 1.
    #[arg(long, value_name = "L", default_value_t = Scene::default().background)]
    background: f64,
    /// Distance of the eye in radii of the mesh, 1.05 to 1e6; inf for a parallel projection.
    #[arg(long, value_name = "R", default_value_t = f64::INFINITY)]
    distance: f64,
    /// Interpolate encoded values, as a renderer does that knows nothing of gamma.
    #[arg(long)]
    naive: bool,
    /// Side of the image in pixels.
    #[arg(long, value_name = "PX", default_value_t = 1024, value_parser = clap::value_parser!(u32).range(1..=16384))]
    size: u32,
    #[command(flatten)]
    transfer: TransferOptions,
    /// Bits a channel.
    #[arg(long, default_value = "8", value_parser = ["8", "16"])]
    bits: String,
    /// Image to write.
    #[arg(long, value_name = "FILE.png")]
    out: Option<PathBuf>,
    /// Measures to write: the jump of the slope across the edges, in linear light a pixel; how visible bands are, and
    /// how much of them there is; both beside Gouraud's.
    #[arg(long, value_name = "FILE.json")]
    metrics: Option<PathBuf>,
    /// Picture of those jumps to write, edge by edge.
    #[arg(long, value_name = "FILE.png")]
    creases: Option<PathBuf>,
    /// Degrees that the picture's width takes of the eye's field, for the visibility of bands, 0.5 to 170.
    #[arg(long, value_name = "DEG", default_value_t = 10.0)]
    window: f64,
    /// Luminance of white for it, cd/m² [default: the display profile's, or 100].
    #[arg(long, value_name = "CD_M2")]
    white: Option<f64>,
}

/// What is seen of the bands of a surface.
#[derive(Clone, Copy, Default)]
struct Bands {
    visibility: Visibility,
    density: f64,
}

/// What goes into the measures.
struct Measured<'a> {
    creases: &'a Creases,
    gouraud: &'a Creases,
    sight: Sight,
    bands: Bands,
    bands_gouraud: Bands,
}

pub(super) fn run(arguments: &Arguments) -> anyhow::Result<()> {
    arguments.check_files()?;
    let (shade, scene, sight) = (arguments.shade()?, arguments.scene()?, arguments.sight()?);
    let (transfers, _) = arguments.transfer.transfers()?;
    let surface = Surface::new(arguments.mesh()?);
    let frame = scene.frame(&surface, arguments.size, arguments.size);
    if frame.triangles.is_empty() {
        anyhow::bail!("{}: no triangle has an area that faces the viewer; expected at least one", arguments.mesh);
    }
    let several = surface.edges.edges.iter().filter(|edge| edge.kind == EdgeKind::NonManifold).count();
    if several > 0 {
        note(&format!(
            "{}: {several} edges have more than two triangles, or two wound against each other; light is not joined across them",
            arguments.mesh
        ));
    }
    let shown = if arguments.naive { frame.clone().encoded(&transfers) } else { frame.clone() };
    if let Some(out) = &arguments.out {
        let image = Reference::new(&shown, &shade).image();
        let clipped = image.data.chunks_exact(3).filter(|pixel| pixel.iter().any(|light| *light > 1.0)).count();
        if clipped > 0 {
            note(&format!(
                "{clipped} pixels are brighter than the screen can be and are clipped, which makes edges of its own"
            ));
        }
        let codes_of = if arguments.naive { Transfer::Linear.into() } else { transfers.clone() };
        let codes = Quantizer::new(codes_of, arguments.bits.parse::<Bits>()?).quantize(&image);
        store::image::write_shaded(out, &codes, &transfers, &arguments.describe(&shade))?;
    }
    if arguments.metrics.is_none() && arguments.creases.is_none() {
        return Ok(());
    }
    let creases = if arguments.naive {
        let decode = |l: DVec3| DVec3::from_array(transfers.linear_from_encoded(l.to_array()));
        Creases::of_encoded(&shown, &shade, decode)
    } else {
        Creases::of(&frame, &shade)
    };
    let gouraud = Creases::of_gouraud(&frame);
    if let Some(path) = &arguments.metrics {
        let seen = scene.frame(&surface, Sight::PICTURE_PX, Sight::PICTURE_PX);
        let [bands, bands_gouraud] = arguments.bands(&seen, &shade, &transfers, &sight)?;
        let measured = Measured { creases: &creases, gouraud: &gouraud, sight, bands, bands_gouraud };
        arguments.write_metrics(path, &surface, &frame, &shade, &measured)?;
    }
    if let Some(path) = &arguments.creases {
        let picture = crease::picture(&frame, &creases, gouraud.p95);
        let codes = Quantizer::new(&Transfer::Srgb, Bits::Eight).quantize(&picture);
        store::image::write_shaded(path, &codes, &Transfer::Srgb.into(), &arguments.describe(&shade))?;
    }
    Ok(())
}

/// Something to know that is no fault.
fn note(text: &str) {
    // Where nobody listens, nothing is lost.
    let _ = writeln!(std::io::stderr(), "note: {text}");
}

impl Arguments {
    /// That there is something to write, and that nothing is written over what is read or written.
    fn check_files(&self) -> Result<(), UsageError> {
        let files = [("--out", &self.out), ("--metrics", &self.metrics), ("--creases", &self.creases)];
        let given: Vec<(&str, &PathBuf)> =
            files.iter().filter_map(|(option, path)| Some((*option, path.as_ref()?))).collect();
        if given.is_empty() {
            let message = "nothing to write; expected --out FILE.png, --metrics FILE.json or --creases FILE.png";
            return Err(UsageError(message.to_owned()));
        }
        for (i, (option, path)) in given.iter().enumerate() {
            if let Some((other, _)) = given[..i].iter().find(|(_, other)| other == path) {
                return Err(UsageError(format!("{option} {} is {other}'s file; expected another", path.display())));
            }
            if Path::new(&self.mesh) == path.as_path() {
                return Err(UsageError(format!("{option} {} is the mesh; expected another file", path.display())));
            }
        }
        Ok(())
    }

    fn shade(&self) -> anyhow::Result<Shade> {
        let shader: Shader = self.shader.parse()?;
        let boundary = self.boundary.unwrap_or(Shade::new(shader).boundary);
        within("--boundary", boundary, 0.0, 1.0)?;
        let corrected = self.vertex != "off" || self.reweight != "off";
        if corrected && matches!(shader, Shader::Flat | Shader::Phong) {
            let message = format!("--vertex and --reweight correct interpolated light; expected off for {shader}");
            return Err(UsageError(message).into());
        }
        Ok(Shade {
            shader,
            depth: self.depth,
            boundary,
            vertex: self.vertex.parse()?,
            reweight: self.reweight.parse()?,
            gradients: self.gradients.parse()?,
        })
    }

    fn scene(&self) -> anyhow::Result<Scene> {
        for (option, value) in [
            ("--ambient", self.ambient),
            ("--diffuse", self.diffuse),
            ("--specular", self.specular),
            ("--background", self.background),
        ] {
            within(option, value, 0.0, 1.0)?;
        }
        within("--shininess", self.shininess, 1.0, 1000.0)?;
        within("--crease", self.crease, 0.0, 180.0)?;
        let light = DVec3::from_array(self.light.0);
        if !(1e-6..=1e6).contains(&light.length()) {
            let message = format!("--light {} is no direction; expected a length from 1e-6 to 1e6", self.light);
            return Err(UsageError(message).into());
        }
        if self.distance.is_finite() || self.distance.is_nan() {
            within("--distance", self.distance, 1.05, 1e6)
                .map_err(|error| UsageError(format!("{error}, or inf (the mesh has the radius 1)")))?;
        }
        Ok(Scene {
            rotate_deg: self.rotate.0,
            light,
            color: DVec3::from_array(self.color.rgb()),
            ambient: self.ambient,
            diffuse: self.diffuse,
            specular: self.specular,
            highlight: self.highlight.parse()?,
            shininess: self.shininess,
            background: self.background,
            distance: self.distance,
            ..Scene::default()
        })
    }

    fn sight(&self) -> anyhow::Result<Sight> {
        within("--window", self.window, 0.5, 170.0)?;
        let white = match self.white {
            Some(white) => within("--white", white, 1e-3, 1e6).map(|()| white)?,
            None => self.transfer.white()?.unwrap_or(Sight::WHITE_CD_M2),
        };
        Ok(Sight { window_deg: self.window, white_cd_m2: white })
    }

    /// What is seen of the bands, and of those of Gouraud's shading in linear light.
    fn bands(&self, frame: &Frame, shade: &Shade, transfers: &Transfers, sight: &Sight) -> anyhow::Result<[Bands; 2]> {
        let look = |image: &LinearImage| match sight.see_surface(frame, image) {
            Ok(view) => Ok(Bands { visibility: view.visibility, density: view.density }),
            Err(VisionError::AllBlack) => Ok(Bands::default()),
            Err(error) => Err(anyhow::anyhow!("--window {}: {error}", self.window)),
        };
        let plain = Shade::new(Shader::Gouraud);
        let gouraud = look(&emitted(&Reference::new(frame, &plain).image(), None))?;
        let is_plain =
            shade.shader == Shader::Gouraud && (shade.vertex, shade.reweight) == (plain.vertex, plain.reweight);
        if is_plain && !self.naive {
            return Ok([gouraud; 2]);
        }
        let own = if self.naive {
            emitted(&Reference::new(&frame.clone().encoded(transfers), shade).image(), Some(transfers))
        } else {
            emitted(&Reference::new(frame, shade).image(), None)
        };
        Ok([look(&own)?, gouraud])
    }

    fn mesh(&self) -> anyhow::Result<crate::shading::Mesh> {
        if let Ok(shape) = self.mesh.parse::<Shape>() {
            return shapes::mesh(shape, self.vertices)
                .map_err(|error| UsageError(format!("--vertices: {error}")).into());
        }
        let path = Path::new(&self.mesh);
        if path.extension().is_none() && !path.exists() {
            let names = Shape::NAMES.join(", ");
            return Err(
                UsageError(format!("--mesh: {:?} is not known; expected {names} or an OBJ file", self.mesh)).into()
            );
        }
        Ok(store::obj::read(path, self.crease)?)
    }

    /// Everything that decides the picture.
    fn describe(&self, shade: &Shade) -> serde_json::Value {
        json!({
            "mesh": self.mesh,
            "vertices": self.vertices,
            "crease_deg": self.crease,
            "shader": shade.shader.name(),
            "depth": shade.depth,
            "boundary": shade.boundary,
            "vertex": shade.vertex.name(),
            "reweight": shade.reweight.name(),
            "gradients": shade.gradients.name(),
            "rotate_deg": self.rotate.0,
            "light": self.light.0,
            "color": self.color.to_string(),
            "ambient": self.ambient,
            "diffuse": self.diffuse,
            "specular": self.specular,
            "highlight": self.highlight,
            "shininess": self.shininess,
            "background": self.background,
            "distance": if self.distance.is_finite() { json!(self.distance) } else { json!("inf") },
            "naive": self.naive,
            "size": self.size,
        })
    }

    fn write_metrics(
        &self,
        path: &Path,
        surface: &Surface,
        frame: &Frame,
        shade: &Shade,
        measured: &Measured<'_>,
    ) -> anyhow::Result<()> {
        let Measured { creases, gouraud, sight, bands, bands_gouraud } = measured;
        // Where Gouraud has none there is nothing to compare with.
        let over = |value: f64, of: f64| if of > crease::NOISE { json!(value / of) } else { json!(null) };
        let [visibility, visibility_gouraud] = [bands, bands_gouraud].map(|bands| bands.visibility.max());
        let mut metrics = self.describe(shade);
        if let Some(fields) = metrics.as_object_mut() {
            for (name, value) in [
                (
                    "sites",
                    json!(surface.mesh.vertices.iter().map(|v| v.site).collect::<std::collections::HashSet<_>>().len()),
                ),
                ("triangles", json!(surface.mesh.triangles.len())),
                ("triangles_seen", json!(frame.triangles.len())),
                ("edges", json!(creases.edges.len())),
                ("crease_rms", json!(creases.rms)),
                ("crease_median", json!(creases.median)),
                ("crease_p95", json!(creases.p95)),
                ("crease_max", json!(creases.max)),
                ("crease_rms_gouraud", json!(gouraud.rms)),
                ("crease_rms_over_gouraud", over(creases.rms, gouraud.rms)),
                ("crease_median_over_gouraud", over(creases.median, gouraud.median)),
                ("crease_p95_over_gouraud", over(creases.p95, gouraud.p95)),
                ("step_rms", json!(creases.step_rms)),
                ("crease_unit", json!("linear light a pixel")),
                ("window_deg", json!(sight.window_deg)),
                ("white_cd_m2", json!(sight.white_cd_m2)),
                ("visibility", json!(visibility)),
                ("visibility_bright", json!(bands.visibility.bright)),
                ("visibility_dark", json!(bands.visibility.dark)),
                ("visibility_gouraud", json!(visibility_gouraud)),
                ("visibility_over_gouraud", over(visibility, visibility_gouraud)),
                ("visibility_unit", json!("contrast times sensitivity, 1 where a band is just seen")),
                ("band_density", json!(bands.density)),
                ("band_density_gouraud", json!(bands_gouraud.density)),
                ("band_density_over_gouraud", over(bands.density, bands_gouraud.density)),
                ("band_density_unit", json!("visibility times length a square degree")),
            ] {
                fields.insert(name.to_owned(), value);
            }
        }
        store::write_json(path, &metrics)?;
        let of_gouraud = |over: Option<f64>| {
            over.map_or_else(|| "Gouraud has none".to_owned(), |over| format!("{over:.4} of Gouraud's"))
        };
        let edges = creases.edges.len();
        let over = of_gouraud(creases.over(gouraud));
        say(&format!("{}: crease rms {:.3e} a pixel over {edges} edges, {over}", shade.shader, creases.rms))?;
        let Visibility { bright, dark } = bands.visibility;
        let over = of_gouraud((visibility_gouraud > crease::NOISE).then(|| visibility / visibility_gouraud));
        let deg = sight.window_deg;
        say(&format!(
            "{}: visibility of bands {visibility:.2} (bright {bright:.2}, dark {dark:.2}) in a window of {deg}°, {over}",
            shade.shader
        ))
    }
}

/// The light that the screen emits for a picture, of codes where `codes` are given: no more than white and no less than
/// black.
fn emitted(image: &LinearImage, codes: Option<&Transfers>) -> LinearImage {
    LinearImage::from_fn(image.width, image.height, |x, y| {
        let pixel = image.pixel(x, y);
        match codes {
            Some(transfers) => transfers.linear_from_encoded(pixel.map(f64::from)).map(|light| light as f32),
            None => pixel.map(|light| light.clamp(0.0, 1.0)),
        }
    })
}

fn within(option: &str, value: f64, least: f64, most: f64) -> Result<(), UsageError> {
    if (least..=most).contains(&value) {
        Ok(())
    } else {
        Err(UsageError(format!("{option} {value} is outside {least}…{most}; expected a number within")))
    }
}
