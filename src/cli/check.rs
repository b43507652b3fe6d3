//! `machband check`, `machband verify` and `machband repair`

use super::{Bar, print_line};
use crate::{
    report::document::numbers::count,
    work::{
        Check, Found, Repair,
        verify::{Verified, Verify},
    },
};

pub(super) fn check(request: &Check) -> anyhow::Result<()> {
    conclude(&request.check(&Bar::new("files"))?)
}

pub(super) fn verify(request: &Verify) -> anyhow::Result<()> {
    let bar = Bar::new("sessions");
    let verified = request.verify(&bar);
    bar.clear();
    let Verified { found, sessions } = verified?;
    conclude(&found)?;
    print_line(&format!("{} verified; no errors", count(sessions as u64, "session")))
}

pub(super) fn repair(request: &Repair) -> anyhow::Result<()> {
    conclude(&request.repair(&Bar::new("files"))?)
}

/// Fails with all errors, if there are any.
fn conclude(found: &Found) -> anyhow::Result<()> {
    let errors: Vec<String> = found.errors.iter().map(ToString::to_string).collect();
    if errors.is_empty() { Ok(()) } else { Err(anyhow::anyhow!(errors.join("\n"))) }
}
