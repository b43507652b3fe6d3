//! Every condition of a definition as an image.

use std::{
    fmt,
    path::{Path, PathBuf},
    str::FromStr,
    sync::atomic::{AtomicUsize, Ordering},
};

use rayon::prelude::*;
use serde::Serialize;

use super::{Image, RequestError, Watcher};
use crate::{
    experiment::Condition,
    stimulus::{Stimulus, recipe::Recipe},
    store::{Writer, definition, manifest::Manifest},
    text::names::serde_as_text,
};

/// A definition, and how the images of its conditions are made.
#[derive(Clone, Debug, PartialEq, clap::Args, Serialize)]
pub struct RenderAll {
    /// Built-in definition or path to a .toml file.
    pub experiment: PathBuf,
    /// Make only part I of N, counted from 1, to split the work among machines or the tasks of a job array.
    #[arg(long, value_name = "I/N", default_value = "1/1")]
    pub shard: Shard,
    #[command(flatten)]
    #[serde(flatten)]
    pub image: Image,
}

/// What was made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rendered {
    /// Number of images that were made.
    pub made: usize,
    /// Number of images that were already there.
    pub kept: usize,
    /// True if every shard is done, so that the manifest is written.
    pub is_whole: bool,
}

/// Part `index` of `of` parts, counted from 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    pub index: usize,
    pub of: usize,
}

impl fmt::Display for Shard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.index, self.of)
    }
}

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parts = text.split_once('/');
        let shard = parts.and_then(|(index, of)| Some(Self { index: index.parse().ok()?, of: of.parse().ok()? }));
        let shard = shard.filter(|shard| (1..=shard.of).contains(&shard.index) && shard.of <= 1_000_000);
        shard
            .ok_or_else(|| format!("shard {text:?} does not exist; expected I/N with 1 ≤ I ≤ N ≤ 1000000, such as 1/3"))
    }
}

serde_as_text!(Shard);

/// Memory in bytes for the images that are made at the same time.
const MEMORY: u64 = 4 << 30;

impl RenderAll {
    /// Writes the images of this shard into a folder, and the manifest once every shard is done. Images that are already
    /// there are kept if they are the same. The watcher learns the number of images.
    ///
    /// # Errors
    /// The definition or the display profile cannot be read, or a file cannot be written.
    pub fn render(&self, out: &Path, writer: &Writer, watcher: &dyn Watcher) -> anyhow::Result<Rendered> {
        let protocol = definition::open(&self.experiment)?;
        if let Stimulus::Image(_) = protocol.stimulus {
            let message = format!("{} shows pictures that are files already; expected stimuli to draw", protocol.name);
            return Err(RequestError::whole(message).into());
        }
        protocol.chosen_later().map_or(Ok(()), |message| Err(RequestError::whole(message)))?;
        let conditions = protocol.conditions();
        let like = self.image.recipe(protocol.stimulus.clone(), watcher)?;
        let of = |condition: &Condition| Recipe { stimulus: condition.stimulus.clone(), ..like.clone() };
        let recipes: Vec<Recipe> = conditions.iter().map(of).collect();
        let Shard { index, of } = self.shard;
        let manifest = Manifest::open(writer, out, &protocol, conditions, &recipes, (index, of))?;
        let (own, [made, done]) = (manifest.own.len(), [(); 2].map(|()| AtomicUsize::new(0)));
        let quantizer = like.quantizer();
        // As many as fit into the memory, each with its light, its codes and its file.
        let at_once = MEMORY / (16 * u64::from(self.image.size).pow(2)).max(1);
        for together in manifest.own.chunks(usize::try_from(at_once)?.max(1)) {
            together.par_iter().try_for_each(|i| {
                made.fetch_add(usize::from(manifest.make(*i, &quantizer)?), Ordering::Relaxed);
                watcher.progress(done.fetch_add(1, Ordering::Relaxed) as u64 + 1, own as u64);
                anyhow::Ok(())
            })?;
        }
        let made = made.into_inner();
        Ok(Rendered { made, kept: own - made, is_whole: manifest.finish()? })
    }
}
