//! Display profiles (TOML).

use std::path::Path;

use super::{FileFaults, text, toml_reader};
use crate::{
    display::profile::DisplayProfile,
    light::gamma::{Transfer, TransferTable},
};

/// Reads a display profile.
///
/// ```toml
/// schema = 1
/// name = "Left monitor"
/// transfer = "gamma:2.2"            # srgb | linear | gamma:G | table
/// # encoded = [0.0, 0.5, 1.0]       # with transfer = "table": encoded values and the linear light they give,
/// # linear = [0.0, 0.22, 1.0]       # both rising from 0 to 1
/// measured = "2026-01-31, photometer"
/// screen_width_cm = 53.1
/// ```
///
/// # Errors
/// Every fault with its line and column.
pub fn open(path: &Path) -> Result<DisplayProfile, FileFaults> {
    parse(&path.display().to_string(), &text::read(path)?)
}

/// Reads a display profile from its text; `file` names it in messages.
///
/// # Errors
/// Every fault with its line and column.
pub fn parse(file: &str, text: &str) -> Result<DisplayProfile, FileFaults> {
    let table = toml_reader::parse(file, text)?;
    let reader = toml_reader::Reader::new(file, text);
    let root = reader.root(&table);
    root.schema();
    let name = root.required_text("name").unwrap_or_default();
    let transfer_text = root.required_text("transfer").unwrap_or_else(|| "srgb".to_owned());
    let (encoded, linear) = (root.numbers("encoded"), root.numbers("linear"));
    let transfer = if transfer_text == "table" {
        TransferTable::new(encoded.unwrap_or_default(), linear.unwrap_or_default())
            .map(Transfer::Table)
            .map_err(|error| error.to_string())
    } else if encoded.is_some() || linear.is_some() {
        Err("encoded and linear belong to transfer = \"table\"; expected that, or neither list".to_owned())
    } else {
        transfer_text.parse().map_err(|error| format!("{error} (or table)"))
    };
    let transfer = transfer.unwrap_or_else(|message| {
        root.fault_at("transfer", message);
        Transfer::Srgb
    });
    let screen_width_cm = table.contains_key("screen_width_cm").then(|| root.number("screen_width_cm", 50.0));
    if let Some(width) = screen_width_cm
        && !(1.0..=1000.0).contains(&width)
    {
        root.fault_at("screen_width_cm", format!("screen_width_cm {width} is outside 1…1000; expected cm"));
    }
    root.knows("screen_width_cm");
    let profile = DisplayProfile { name, transfer, measured: root.text("measured"), screen_width_cm };
    root.finish();
    reader.finish()?;
    Ok(profile)
}
