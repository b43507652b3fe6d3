//! `machband export`

use super::{Bar, count, print_line};
use crate::work::Export;

pub(super) fn run(request: &Export) -> anyhow::Result<()> {
    let waiting = Bar::new("exporting");
    let exported = request.export(&waiting);
    waiting.clear();
    let exported = exported?;
    let pictures = match exported.pictures {
        0 => String::new(),
        pictures => format!(", {}", count(pictures as u64, "picture")),
    };
    print_line(&format!(
        "{} of {} in {}, {}{pictures}",
        count(exported.sessions as u64, "session"),
        exported.experiments.join(", "),
        request.out.display(),
        count(exported.rows as u64, "row")
    ))
}
