//! `machband plan`

mod findings;

use super::{Bar, OutPath, print_line};
use crate::{store::Writer, work::plan::Plan};
use findings::Findings;

/// Find how many participants a study needs, by simulating its power.
///
/// Simulates studies with the ordered-logit observer of `simulate` and analyzes each as `analyze` would. For each
/// number of participants and each effect, reports the proportion of studies that find it, with its exact 95 % interval
/// (Clopper and Pearson). Two tests are used: the likelihood-ratio test of the term in the ordinal mixed model, and
/// Friedman's test of the participants' means. If an effect is absent, this proportion is reported as the false-alarm
/// rate.
#[derive(clap::Args)]
#[command(
    after_help = "Effects: NAME=VALUE sets a parameter of the observer: depth, fall, narrow, oblique, contrast, \
    infinite_as, strongest_width, subject_sd, lapse (see experiments/observers/paper.toml). FACTOR:LEVEL=LOGITS adds to \
    one level of any factor of the experiment.\n\n\
    --slope FACTOR=SD lets people differ in the effect of a factor: each deviates at each of its levels by an independent \
    normal value, as in R's (1 | subject:factor). The more they differ, the lower the power.\n\n\
    Up to 40 participants, p values of the model come from simulated studies without the effect: as many as --studies, \
    but at least 199 and at most 999.\n\n\
    Results depend on the seed but not on the number of threads (ChaCha8, one stream per participant and study).\n\n\
    Examples:\n  machband plan orientation --participants 4,8,12 --effect oblique=0.5\n  \
    machband plan orientation --participants 12 --effect oblique=0.5 --slope orientation_deg=0.5\n  \
    machband plan shaders --participants 8 --effect shader:gouraud=1 --effect shader:flat=2"
)]
pub(super) struct Arguments {
    #[command(flatten)]
    request: Plan,
    /// Where to write the table as CSV.
    #[arg(long, value_name = "FILE.csv")]
    out: Option<OutPath>,
}

pub(super) fn run(arguments: &Arguments, writer: &Writer) -> anyhow::Result<()> {
    let bar = Bar::new("simulated participants");
    let planned = arguments.request.plan(&bar);
    bar.clear();
    let planned = planned?;
    Findings(&planned).lines().iter().try_for_each(|line| print_line(line))?;
    // Written last, so that no result is lost if the path cannot be written.
    if let Some(path) = &arguments.out {
        writer.write(path, &planned.table().csv())?;
    }
    Ok(())
}
