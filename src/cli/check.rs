//! `machband check`, `machband verify` and `machband repair`

use super::{Bar, print_line, told_of};
use crate::{
    report::document::numbers::count,
    work::{Check, Found, Repair, Request, verify::Verify},
};

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

/// Fails with all errors, if there are any.
fn conclude<T: Request>(found: Found) -> anyhow::Result<()> {
    let errors: Vec<String> = found.errors.into_iter().map(|error| told_of::<T>(&error.into())).collect();
    if errors.is_empty() { Ok(()) } else { Err(anyhow::anyhow!(errors.join("\n"))) }
}
