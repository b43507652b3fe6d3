//! `machband stimulus`, `machband stimuli` and `machband shade`

use std::time::Instant;

use super::{Bar, OutPath, count, message, print_line, report_written};
use crate::{
    report::document::numbers::{ratio, significant},
    shading::{Shader, crease},
    store::{self, Writer},
    work::{
        RequestError,
        shade::{Metrics, Shade, Wanted},
        stimuli::RenderAll,
        stimulus::Render,
    },
};

/// Write one stimulus as an image, and its luminance profile as a table.
#[derive(clap::Args)]
#[command(
    after_help = "Example: machband stimulus --width 0.2 --depth inf --orientation 45 --out ramp.png --profile ramp.csv"
)]
pub(super) struct StimulusArguments {
    #[command(flatten)]
    request: Render,
    /// Where to write the image.
    #[arg(long, value_name = "FILE.png")]
    out: Option<OutPath>,
    /// Where to write the luminance profile through the center, along the orientation.
    #[arg(long, value_name = "FILE.csv")]
    profile: Option<OutPath>,
}

pub(super) fn stimulus(arguments: &StimulusArguments, writer: &Writer) -> anyhow::Result<()> {
    let StimulusArguments { request, out, profile } = arguments;
    if out.is_none() && profile.is_none() {
        let message = "nothing to write; expected --out FILE.png or --profile FILE.csv";
        return Err(RequestError::whole(message).into());
    }
    let bar = Bar::new("images");
    request.render(out.as_deref(), profile.as_deref(), writer, &bar)?;
    out.iter().chain(profile).try_for_each(|path| report_written(path))
}

/// Write an image of every distinct condition of a definition, and a manifest.
#[derive(clap::Args)]
#[command(
    after_help = "Examples: machband stimuli bangay2003 --out stimuli --size 512 --bits 16\n          machband stimuli bangay2003 --out stimuli --shard $SLURM_ARRAY_TASK_ID/$SLURM_ARRAY_TASK_COUNT"
)]
pub(super) struct StimuliArguments {
    #[command(flatten)]
    request: RenderAll,
    /// Folder for the images. Images that are already there are kept if they are the same.
    #[arg(long, value_name = "DIR", value_hint = clap::ValueHint::DirPath)]
    out: OutPath,
}

pub(super) fn stimuli(arguments: &StimuliArguments, writer: &Writer) -> anyhow::Result<()> {
    let started = Instant::now();
    let bar = Bar::new("images");
    let rendered = arguments.request.render(&arguments.out, writer, &bar);
    bar.clear();
    let rendered = rendered?;
    print_line(&format!(
        "{} made, {} kept, in {}, {:.1} s{}",
        count(rendered.made as u64, "image"),
        rendered.kept,
        arguments.out.display(),
        started.elapsed().as_secs_f64(),
        if rendered.is_whole { "" } else { "; manifest.csv will be written when every shard is done" }
    ))
}

/// Shade a mesh: write its image, measure how smooth its edges are, and how visibly it differs from the smooth surface.
///
/// The difference is judged as in `machband compare`, on the surface within its outlines, from light that is not rounded
/// to codes: at 1, people just see it. It always uses an image of 512 × 512 pixels that is --window degrees wide,
/// regardless of --size.
#[derive(clap::Args)]
#[command(
    after_help = "Example: machband shade --mesh blob --vertices 313 --shader fixed --depth 3 --boundary 0.2 --out fixed.png --metrics fixed.json"
)]
pub(super) struct ShadeArguments {
    #[command(flatten)]
    request: Shade,
    /// Where to write the image.
    #[arg(long, value_name = "FILE.png")]
    out: Option<OutPath>,
    /// Where to write the measurements: the change of slope across the edges, in linear light per pixel, and the
    /// difference from the smooth surface, in times threshold and in light, each also relative to Gouraud's.
    #[arg(long, value_name = "FILE.json", conflicts_with = "scene")]
    metrics: Option<OutPath>,
}

pub(super) fn shade(arguments: &ShadeArguments, writer: &Writer) -> anyhow::Result<()> {
    let ShadeArguments { request, out, metrics } = arguments;
    let wanted = Wanted { picture: out.is_some(), metrics: metrics.is_some() };
    if wanted == Wanted::default() {
        let message = "nothing to write; expected --out FILE.png or --metrics FILE.json";
        return Err(RequestError::whole(message).into());
    }
    let bar = Bar::new("shading");
    let shaded = request.shade(None, wanted, &bar);
    bar.clear();
    let shaded = shaded?;
    shaded.notes.iter().for_each(|note| message("note", note));
    if let (Some(path), Some(codes)) = (out, &shaded.picture) {
        store::image::write_codes(writer, path, codes, &shaded.transfers, Some(&shaded.description))?;
    }
    if let (Some(path), Some(found)) = (metrics, &shaded.metrics) {
        writer.write(path, format!("{}\n", serde_json::to_string_pretty(found)?).as_bytes())?;
        summarize(request.one.shader.unwrap_or(Shader::Phong), found)?;
    }
    [out, metrics].into_iter().flatten().try_for_each(|path| report_written(path))
}

/// Prints the measurements that matter most.
fn summarize(shader: Shader, found: &Metrics) -> anyhow::Result<()> {
    let relative = |over: Option<f64>| match over {
        Some(over) => format!("{} times Gouraud's", ratio(over)),
        None => "Gouraud has none".to_owned(),
    };
    let number = |value: f64| significant(value, value, value);
    let steps = (found.creases.step_rms > crease::NOISE)
        .then(|| format!(", but steps of {} (rms)", number(found.creases.step_rms)));
    // A few narrow triangles decide the root mean square.
    print_line(&format!(
        "{shader}: crease median {} per pixel over {}, {} (95 % of their length: at most {}, {}){}",
        number(found.creases.median),
        count(found.edges as u64, "edge"),
        relative(found.crease_median_over_gouraud),
        number(found.creases.p95),
        relative(found.crease_p95_over_gouraud),
        steps.unwrap_or_default()
    ))?;
    print_line(&match &found.difference {
        Some(difference) => format!(
            "{shader}: differs from the smooth surface by {:.2} times what people can just see in a {}° window (95 % of the surface: at most {:.2}), {}",
            difference.own.largest,
            found.viewing.window_deg,
            difference.own.p95,
            relative(difference.over_gouraud["largest"].as_f64())
        ),
        None if found.masked.is_some() => {
            format!("{shader}: nothing can be compared with the smooth surface, so only the creases are measured")
        }
        None => format!(
            "{shader}: the smooth surface is not known, so only the creases are measured; --truth FILE names a finer mesh"
        ),
    })
}
