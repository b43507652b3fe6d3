//! `machband stimulus` and `machband stimuli`

use std::time::Instant;

use super::{Bar, OutPath, count, print_line, report_written};
use crate::{
    store::Writer,
    work::{RequestError, stimuli::RenderAll, stimulus::Render},
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
