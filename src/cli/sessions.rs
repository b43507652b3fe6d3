//! `machband simulate`, `machband check`, `machband verify`, `machband repair` and `machband export`

use std::{collections::HashSet, time::Instant};

use super::{Bar, count, print_line, told_of};
use crate::{
    store::definition,
    system::signals,
    work::{
        Check, Export, Found, Repair, Request,
        simulate::{self, Simulate},
        verify::Verify,
    },
};

pub(super) fn simulate(request: &Simulate) -> anyhow::Result<()> {
    let protocol = definition::open(&request.experiment)?;
    let started = Instant::now();
    let bar = Bar::new("trials");
    signals::watch();
    let rows = simulate::simulate(request, &protocol, &bar);
    bar.clear();
    print_line(&format!(
        "{} of {} in {}, {}, {:.1} s",
        count(request.participants.into(), "session"),
        protocol.name,
        request.results.join(&protocol.name).display(),
        count(rows?, "row"),
        started.elapsed().as_secs_f64()
    ))
}

pub(super) fn check(request: &Check) -> anyhow::Result<()> {
    conclude::<Check>(request.check(&Bar::new("files"))?)
}

pub(super) fn verify(request: &Verify) -> anyhow::Result<()> {
    let bar = Bar::new("sessions");
    let verified = request.verify(&bar);
    bar.clear();
    let found = verified?;
    let sessions = found.files.len() as u64;
    conclude::<Verify>(found)?;
    print_line(&format!("{} verified; no errors", count(sessions, "session")))
}

pub(super) fn repair(request: &Repair) -> anyhow::Result<()> {
    conclude::<Repair>(request.repair(&Bar::new("files"))?)
}

/// Fails with all errors, if there are any. One that concerns several sessions is told once.
fn conclude<T: Request>(found: Found) -> anyhow::Result<()> {
    let mut told = HashSet::new();
    let errors = found.errors.into_iter().map(|error| told_of::<T>(&error.into()));
    let errors: Vec<String> = errors.filter(|error| told.insert(error.clone())).collect();
    if errors.is_empty() { Ok(()) } else { Err(anyhow::anyhow!(errors.join("\n"))) }
}

pub(super) fn export(request: &Export) -> anyhow::Result<()> {
    let waiting = Bar::new("exporting");
    signals::watch();
    let exported = request.export(&waiting);
    waiting.clear();
    let exported = exported.map_err(|error| match signals::received() {
        Some(signal) => anyhow::anyhow!("{}: ended by {signal}; nothing was written", request.out.display()),
        None => error,
    })?;
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
