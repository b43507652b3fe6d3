//! Display profiles (TOML).

use std::path::Path;

use jiff::civil::Date;
use serde::Serialize;

use super::{
    FileFaults, StoreError,
    fault::io,
    file::write_whole,
    hash::sha256,
    text,
    toml_reader::{self, Section},
};
use crate::{
    display::{DisplayProfile, LuminanceRange, Measurement, Primaries},
    light::{Transfer, TransferTable, Transfers},
};

/// Channels by the names that their sections have.
const CHANNELS: [&str; 3] = ["red", "green", "blue"];

/// Reads a display profile.
///
/// ```toml
/// schema = 1
/// name = "Left monitor"
/// transfer = "gog:2.2,1.05,-0.05"   # srgb | linear | gamma:G | gog:GAMMA,GAIN,OFFSET | table;
/// # encoded = [0.0, 0.5, 1.0]       # or three joined by "/" for red, green and blue
/// # linear = [0.0, 0.22, 1.0]       # with "table": encoded values and the light they give, both rising from 0 to 1
/// black_cd_m2 = 0.12
/// white_cd_m2 = 251.0
/// bits = 8
/// screen_width_cm = 53.1
/// native_px = [2560, 1440]
///
/// [measured]                        # or a text in its place
/// on = "2026-01-31"
/// by = "N. N."
/// with = "a photometer"
///
/// [primaries]                       # CIE 1931 x, y
/// red = [0.64, 0.33]
/// green = [0.3, 0.6]
/// blue = [0.15, 0.06]
/// white = [0.3127, 0.329]
///
/// # [channels.red]                  # instead of the transfer above: a section for each channel
/// # transfer = "table"
/// # encoded = [0.0, 0.5, 1.0]
/// # linear = [0.0, 0.22, 1.0]
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
    let transfers = transfers(&root, table.contains_key("channels"));
    // Asked of all profiles, so that a luminance on its own is a fault and no unknown key.
    let [black, white] = ["black_cd_m2", "white_cd_m2"].map(|key| optional(&root, key, 0.0..=100_000.0, "cd/m²"));
    let profile = DisplayProfile {
        name,
        transfers,
        luminance: luminance(&root, black, white),
        primaries: primaries(&root),
        bits: bits(&root),
        measured: measured(&root),
        screen_width_cm: optional(&root, "screen_width_cm", 1.0..=1000.0, "cm"),
        native_px: native_px(&root),
    };
    root.finish();
    reader.finish()?;
    Ok(profile)
}

fn transfers(root: &Section<'_, '_>, by_channel: bool) -> Transfers {
    let channels = root.section("channels");
    if !by_channel {
        return transfer(root);
    }
    for key in ["transfer", "encoded", "linear"] {
        if root.has(key) {
            root.fault_at(key, format!("{key} stands beside [channels]; expected one or the other"));
        }
        root.knows(key);
    }
    let each = CHANNELS.map(|channel| {
        let section = channels.section(channel);
        let transfers = transfer(&section);
        section.finish();
        transfers.channels()[0].clone()
    });
    channels.finish();
    Transfers::new(each)
}

/// What a section says of one channel, or of all three.
fn transfer(section: &Section<'_, '_>) -> Transfers {
    let text = section.required_text("transfer").unwrap_or_else(|| "srgb".to_owned());
    let (encoded, linear) = (section.numbers("encoded"), section.numbers("linear"));
    let found = if text == "table" {
        TransferTable::new(encoded.unwrap_or_default(), linear.unwrap_or_default())
            .map(|table| Transfer::Table(table).into())
            .map_err(|error| error.to_string())
    } else if encoded.is_some() || linear.is_some() {
        Err("encoded and linear belong to transfer = \"table\"; expected that, or neither list".to_owned())
    } else if section.is_root() {
        text.parse::<Transfers>().map_err(|error| format!("{error} (or table)"))
    } else {
        text.parse::<Transfer>().map(Transfers::from).map_err(|error| format!("{error} (or table)"))
    };
    found.unwrap_or_else(|message| {
        section.fault_at("transfer", message);
        Transfer::Srgb.into()
    })
}

/// A number that may be absent.
fn optional(
    section: &Section<'_, '_>,
    key: &'static str,
    range: std::ops::RangeInclusive<f64>,
    unit: &str,
) -> Option<f64> {
    section.knows(key);
    let value = section.has(key).then(|| section.number(key, *range.start()))?;
    if !range.contains(&value) {
        let (low, high) = (range.start(), range.end());
        section.fault_at(key, format!("{key} {value} is outside {low}…{high}; expected {unit}"));
    }
    Some(value)
}

fn luminance(root: &Section<'_, '_>, black: Option<f64>, white: Option<f64>) -> Option<LuminanceRange> {
    match (black, white) {
        (Some(black_cd_m2), Some(white_cd_m2)) if black_cd_m2 < white_cd_m2 => {
            Some(LuminanceRange { black_cd_m2, white_cd_m2 })
        }
        (Some(black), Some(white)) => {
            root.fault_at(
                "white_cd_m2",
                format!("white_cd_m2 {white} is not above black_cd_m2 {black}; expected more"),
            );
            None
        }
        (Some(_), None) => {
            root.fault_at("black_cd_m2", "black_cd_m2 stands alone; expected white_cd_m2 too");
            None
        }
        (None, Some(_)) => {
            root.fault_at("white_cd_m2", "white_cd_m2 stands alone; expected black_cd_m2 too");
            None
        }
        (None, None) => None,
    }
}

fn primaries(root: &Section<'_, '_>) -> Option<Primaries> {
    let section = root.section("primaries");
    if !root.has("primaries") {
        return None;
    }
    let [red, green, blue, white] = ["red", "green", "blue", "white"].map(|key| {
        let Some(pair) = section.numbers(key) else {
            section.fault_at(key, format!("primaries.{key} is missing; expected {key} = [x, y]"));
            return [0.0; 2];
        };
        match pair[..] {
            [x, y] if x >= 0.0 && y > 0.0 && x + y <= 1.0 => [x, y],
            _ => {
                let message = format!(
                    "primaries.{key} is {pair:?}; expected CIE 1931 [x, y], both from 0 and together at most 1"
                );
                section.fault_at(key, message);
                [0.0; 2]
            }
        }
    });
    section.finish();
    Some(Primaries { red, green, blue, white })
}

fn bits(root: &Section<'_, '_>) -> Option<u8> {
    let bits = root.whole("bits")?;
    match u8::try_from(bits) {
        Ok(bits @ 1..=16) => Some(bits),
        _ => {
            root.fault_at("bits", format!("bits {bits} is outside 1…16; expected the bits of each channel, mostly 8"));
            None
        }
    }
}

fn native_px(root: &Section<'_, '_>) -> Option<[u32; 2]> {
    let pair = root.numbers("native_px")?;
    match pair[..] {
        [width, height]
            if [width, height].iter().all(|side| side.fract() == 0.0 && (16.0..=65_536.0).contains(side)) =>
        {
            Some([width as u32, height as u32])
        }
        _ => {
            root.fault_at(
                "native_px",
                format!("native_px is {pair:?}; expected columns and rows, such as [2560, 1440]"),
            );
            None
        }
    }
}

/// A table, or a text as in `"2026-01-31, photometer"`.
fn measured(root: &Section<'_, '_>) -> Option<Measurement> {
    if root.is_text("measured") {
        let text = root.text("measured")?;
        let (first, rest) = text.split_once(',').unwrap_or((&text, ""));
        return Some(match (first.trim().parse::<Date>(), rest.trim()) {
            (Ok(day), "") => Measurement { on: Some(day), ..Measurement::default() },
            (Ok(day), with) => Measurement { on: Some(day), with: Some(with.to_owned()), ..Measurement::default() },
            (Err(_), _) => Measurement { with: Some(text), ..Measurement::default() },
        });
    }
    let section = root.section("measured");
    if !root.has("measured") {
        return None;
    }
    let on = section.text("on").and_then(|text| {
        let day = text.parse::<Date>();
        if day.is_err() {
            section.fault_at("on", format!("measured.on is {text:?}; expected a day such as \"2026-01-31\""));
        }
        day.ok()
    });
    let measurement = Measurement { on, by: section.text("by"), with: section.text("with") };
    section.finish();
    Some(measurement)
}

/// A profile as it stands in a file.
#[derive(Serialize)]
struct Form<'a> {
    schema: u32,
    name: &'a str,
    #[serde(flatten, skip_serializing_if = "Option::is_none")]
    alike: Option<TransferForm<'a>>,
    #[serde(flatten)]
    luminance: Option<LuminanceRange>,
    #[serde(skip_serializing_if = "Option::is_none")]
    bits: Option<u8>,
    #[serde(skip_serializing_if = "Option::is_none")]
    screen_width_cm: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    native_px: Option<[u32; 2]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    measured: Option<&'a Measurement>,
    #[serde(skip_serializing_if = "Option::is_none")]
    primaries: Option<Primaries>,
    #[serde(skip_serializing_if = "Option::is_none")]
    channels: Option<ChannelForms<'a>>,
}

#[derive(Serialize)]
struct TransferForm<'a> {
    transfer: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    encoded: Option<&'a [f64]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    linear: Option<&'a [f64]>,
}

#[derive(Serialize)]
struct ChannelForms<'a> {
    red: TransferForm<'a>,
    green: TransferForm<'a>,
    blue: TransferForm<'a>,
}

impl<'a> TransferForm<'a> {
    fn of(transfer: &'a Transfer) -> Self {
        let (encoded, linear) = match transfer {
            Transfer::Table(table) => (Some(table.encoded()), Some(table.linear())),
            _ => (None, None),
        };
        Self { transfer: transfer.to_string(), encoded, linear }
    }
}

impl<'a> Form<'a> {
    fn of(profile: &'a DisplayProfile) -> Self {
        let [red, green, blue] = profile.transfers.channels().each_ref().map(TransferForm::of);
        let channels = profile.transfers.uniform().is_none().then_some(ChannelForms { red, green, blue });
        Self {
            schema: 1,
            name: &profile.name,
            alike: profile.transfers.uniform().map(TransferForm::of),
            luminance: profile.luminance,
            bits: profile.bits,
            screen_width_cm: profile.screen_width_cm,
            native_px: profile.native_px,
            measured: profile.measured.as_ref(),
            primaries: profile.primaries,
            channels,
        }
    }
}

/// The profile in the form of its file, for a sidecar.
#[must_use]
pub fn value(profile: &DisplayProfile) -> serde_json::Value {
    serde_json::to_value(Form::of(profile)).unwrap_or_default()
}

/// SHA-256 of what the profile says, in lower-case hexadecimal: the same for every file that says the same.
#[must_use]
pub fn hash(profile: &DisplayProfile) -> String {
    let canonical = value(profile).to_string();
    sha256(canonical.as_bytes())
}

/// Writes a profile, whole or not at all; [`open`](fn@open) reads it back the same.
///
/// # Errors
/// The system's refusal.
pub fn write(path: &Path, profile: &DisplayProfile) -> Result<(), StoreError> {
    let text =
        toml::to_string(&Form::of(profile)).map_err(|error| io(path, "describe")(std::io::Error::other(error)))?;
    write_whole(path, text.as_bytes(), true)
}
