//! `machband stimuli`

use std::{path::PathBuf, str::FromStr, time::Instant};

use indicatif::ProgressBar;
use rayon::prelude::*;

use super::{options::ImageOptions, progress_style};
use crate::{
    experiment::Condition,
    stimulus::recipe::Recipe,
    store::{definition, manifest::Manifest},
};

/// Write every distinct condition of a definition as an image, and a manifest.
#[derive(clap::Args)]
#[command(
    after_help = "Examples: machband stimuli bangay2003 --out stimuli --size 512 --bits 16\n          machband stimuli bangay2003 --out stimuli --shard $SLURM_ARRAY_TASK_ID/$SLURM_ARRAY_TASK_COUNT"
)]
pub(super) struct Arguments {
    /// Built-in definition or path of a .toml file.
    experiment: String,
    /// Folder for the images.
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Make only part I of N, counted from 1: for several machines, or the tasks of a job array.
    #[arg(long, value_name = "I/N", default_value = "1/1")]
    shard: Shard,
    #[command(flatten)]
    image: ImageOptions,
}

/// Part `index` of `of` parts, from 1.
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

pub(super) fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let started = Instant::now();
    let protocol = definition::open(&arguments.experiment)?;
    let conditions = protocol.conditions()?;
    let like = arguments.image.recipe(protocol.stimulus.clone())?;
    let of = |condition: &Condition| Recipe { stimulus: condition.stimulus.clone(), ..like.clone() };
    let recipes: Vec<Recipe> = conditions.iter().map(of).collect();
    let Shard { index, of } = arguments.shard;
    let manifest = Manifest::open(&arguments.out, &protocol, &conditions, &recipes, (index, of))?;
    let (made, kept) = (manifest.missing.len(), manifest.kept);
    let bar = ProgressBar::new(made as u64).with_style(progress_style("images"));
    if let Some(first) = manifest.missing.first() {
        let quantizer = recipes[*first].quantizer();
        manifest.missing.par_iter().try_for_each(|i| {
            manifest.make(*i, &quantizer)?;
            bar.inc(1);
            anyhow::Ok(())
        })?;
    }
    bar.finish_and_clear();
    let whole = manifest.finish()?;
    super::say(&format!(
        "{made} images made, {kept} kept, in {}, {:.1} s{}",
        arguments.out.display(),
        started.elapsed().as_secs_f64(),
        if whole { "" } else { "; manifest.csv follows when every shard is done" }
    ))
}
