//! `machband stimulus` and `machband stimuli`

use std::{
    path::PathBuf,
    str::FromStr,
    sync::atomic::{AtomicU64, Ordering},
    time::Instant,
};

use rayon::prelude::*;

use super::{
    Bar, OutPath, count,
    options::{ImageOptions, StimulusOptions},
    print_line, report_written,
};
use crate::{
    experiment::Condition,
    light::{Bits, Quantizer, halftone::Screen, palette::Reduction},
    stimulus::recipe::Recipe,
    store::{self, Writer, definition, manifest::Manifest},
    work::{RequestError, Watcher as _},
};

/// Write one stimulus as an image, and its luminance profile as a table.
#[derive(clap::Args)]
#[command(
    after_help = "Example: machband stimulus --width 0.2 --depth inf --orientation 45 --out ramp.png --profile ramp.csv"
)]
pub(super) struct StimulusArguments {
    #[command(flatten)]
    stimulus: StimulusOptions,
    #[command(flatten)]
    image: ImageOptions,
    /// Reduce the image to a palette, given as the method (popularity, median-cut or k-means) and the maximum number of
    /// colors, such as median-cut:16.
    #[arg(long, value_name = "METHOD:N", requires = "out")]
    palette: Option<String>,
    /// Draw each pixel as a cell of dots, for devices with few codes such as printers; given as the matrix and the bits
    /// per channel, such as clustered3:1.
    #[arg(long, value_name = "MATRIX:BITS", requires = "out", conflicts_with = "palette")]
    halftone: Option<String>,
    /// Where to write the image.
    #[arg(long, value_name = "FILE.png")]
    out: Option<OutPath>,
    /// Where to write the luminance profile through the center, along the orientation.
    #[arg(long, value_name = "FILE.csv")]
    profile: Option<OutPath>,
}

pub(super) fn stimulus(arguments: &StimulusArguments, writer: &Writer) -> anyhow::Result<()> {
    if arguments.out.is_none() && arguments.profile.is_none() {
        return Err(
            RequestError::whole("nothing to write; expected --out FILE.png or --profile FILE.csv".to_owned()).into()
        );
    }
    let recipe = arguments.image.recipe(arguments.stimulus.stimulus()?)?;
    let quantizer = recipe.quantizer();
    let reduction = arguments.palette.as_deref().map(str::parse::<Reduction>).transpose();
    let reduction = reduction.map_err(|error| RequestError::whole(format!("--palette: {error}")))?;
    let screen = arguments.halftone.as_deref().map(str::parse::<Screen>).transpose();
    let screen = screen.map_err(|error| RequestError::whole(format!("--halftone: {error}")))?;
    if let (Some(out), Some(screen)) = (&arguments.out, screen) {
        store::image::write_halftone(writer, out, &recipe, screen)?;
        return finish(arguments, writer, &recipe, &quantizer);
    }
    match (&arguments.out, reduction) {
        (Some(_), Some(_)) if recipe.bits == Bits::Sixteen => {
            return Err(RequestError::whole(
                "--palette: a palette has 8 bits per channel; expected --bits 8".to_owned(),
            )
            .into());
        }
        (Some(out), Some(reduction)) => {
            let image = store::image::write_reduced(writer, out, &recipe, &quantizer, reduction)?;
            print_line(&format!(
                "{reduction}: {}, error in linear light rms {:.5}, largest {:.5}",
                count(image.palette.len() as u64, "color"),
                image.error.rms,
                image.error.max
            ))?;
        }
        (Some(out), None) => store::image::write_recipe(writer, out, &recipe, &quantizer)?,
        (None, _) => {}
    }
    finish(arguments, writer, &recipe, &quantizer)
}

/// Writes the profile if requested, and reports the files that were written.
fn finish(
    arguments: &StimulusArguments,
    writer: &Writer,
    recipe: &Recipe,
    quantizer: &Quantizer,
) -> anyhow::Result<()> {
    if let Some(profile) = &arguments.profile {
        store::curve::write_profile(writer, profile, recipe, quantizer)?;
    }
    arguments.out.iter().chain(&arguments.profile).try_for_each(|path| report_written(path))
}

/// Write an image of every distinct condition of a definition, and a manifest.
#[derive(clap::Args)]
#[command(
    after_help = "Examples: machband stimuli bangay2003 --out stimuli --size 512 --bits 16\n          machband stimuli bangay2003 --out stimuli --shard $SLURM_ARRAY_TASK_ID/$SLURM_ARRAY_TASK_COUNT"
)]
pub(super) struct StimuliArguments {
    /// Built-in definition or path to a .toml file.
    experiment: PathBuf,
    /// Folder for the images. Images that are already there are kept if they are the same.
    #[arg(long, value_name = "DIR", value_hint = clap::ValueHint::DirPath)]
    out: OutPath,
    /// Make only part I of N, counted from 1, to split the work among machines or the tasks of a job array.
    #[arg(long, value_name = "I/N", default_value = "1/1")]
    shard: Shard,
    #[command(flatten)]
    image: ImageOptions,
}

/// Part `index` of `of` parts, counted from 1.
#[derive(Clone, Copy, Debug)]
struct Shard {
    index: usize,
    of: usize,
}

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (index, of) =
            text.split_once('/').ok_or_else(|| format!("shard {text:?} has no slash; expected I/N such as 1/3"))?;
        match (index.parse(), of.parse()) {
            (Ok(index), Ok(of)) if (1..=of).contains(&index) && of <= 1_000_000 => Ok(Self { index, of }),
            _ => Err(format!("shard {text:?} does not exist; expected I/N with 1 ≤ I ≤ N ≤ 1000000, such as 1/3")),
        }
    }
}

/// Memory in bytes for the images that are made at the same time.
const MEMORY: u64 = 4 << 30;

/// Returns how many images are made at the same time: as many as fit into [`MEMORY`], each with its light, its codes
/// and its file.
fn at_once(size: u32) -> usize {
    let image = 16 * u64::from(size) * u64::from(size);
    usize::try_from(MEMORY / image.max(1)).unwrap_or(usize::MAX).max(1)
}

pub(super) fn stimuli(arguments: &StimuliArguments, writer: &Writer) -> anyhow::Result<()> {
    let started = Instant::now();
    let protocol = definition::open(&arguments.experiment)?;
    let conditions = protocol.conditions();
    let like = arguments.image.recipe(protocol.stimulus.clone())?;
    let of = |condition: &Condition| Recipe { stimulus: condition.stimulus.clone(), ..like.clone() };
    let recipes: Vec<Recipe> = conditions.iter().map(of).collect();
    let Shard { index, of } = arguments.shard;
    let manifest = Manifest::open(writer, &arguments.out, &protocol, conditions, &recipes, (index, of))?;
    let (made, kept) = (count(manifest.missing.len() as u64, "image"), manifest.kept);
    let bar = Bar::new("images");
    let (done, missing) = (AtomicU64::new(0), manifest.missing.len() as u64);
    if let Some(first) = manifest.missing.first() {
        let quantizer = recipes[*first].quantizer();
        for together in manifest.missing.chunks(at_once(arguments.image.size)) {
            together.par_iter().try_for_each(|i| {
                manifest.make(*i, &quantizer)?;
                bar.progress(done.fetch_add(1, Ordering::Relaxed) + 1, missing);
                anyhow::Ok(())
            })?;
        }
    }
    bar.clear();
    let whole = manifest.finish()?;
    print_line(&format!(
        "{made} made, {kept} kept, in {}, {:.1} s{}",
        arguments.out.display(),
        started.elapsed().as_secs_f64(),
        if whole { "" } else { "; manifest.csv will be written when every shard is done" }
    ))
}
