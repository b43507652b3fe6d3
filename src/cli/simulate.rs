//! `machband simulate`

use std::time::Instant;

use super::{Bar, print_line};
use crate::{
    report::document::numbers::count,
    store::definition,
    system::signals,
    work::simulate::{Simulate, simulate},
};

pub(super) fn run(request: &Simulate) -> anyhow::Result<()> {
    let protocol = definition::open(&request.experiment)?;
    let started = Instant::now();
    let bar = Bar::new("trials");
    signals::watch();
    let done = simulate(request, &protocol, &bar);
    bar.clear();
    let done = done?;
    print_line(&format!(
        "{} of {} in {}, {}, {:.1} s",
        count(done.sessions, "session"),
        protocol.name,
        done.folder.display(),
        count(done.rows, "row"),
        started.elapsed().as_secs_f64()
    ))
}
