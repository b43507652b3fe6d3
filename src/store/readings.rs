//! Photometer readings: CSV with the columns `channel,level,luminance_cd_m2`, or a file of another program: CGATS tables,
//! which ArgyllCMS writes as `.ti3`, the monitor files of PsychoPy, and the calibrations of Psychtoolbox.

use std::{collections::HashSet, path::Path};

use serde_json::Value;

use super::{
    FileError, FileErrors, StoreError, Writer,
    file::{folder_of, read_bytes, read_text},
    mat::{self, Value as MatValue},
    table::{self, separator, with_point},
};
use crate::{
    display::{
        Channel,
        photometer::{MIN_LEVELS, Reading, Readings},
    },
    light::color::luminance_of_spectrum,
};

/// The columns, in the order in which they are written. Additional columns are ignored when reading.
pub const COLUMNS: [&str; 3] = ["channel", "level", "luminance_cd_m2"];

/// Maximum number of readings. Three at each of the 256 levels of four channels are 3,072.
const MAX_READINGS: usize = 4000;

/// Reads a complete set of readings, sufficient for a profile, in the order in which they were taken.
///
/// # Errors
/// Reports every error, with its line and column if it is in a cell.
pub fn open(path: &Path) -> Result<Readings, FileErrors> {
    let (file, bytes) = (path.display().to_string(), read_bytes(path, mat::MAX_BYTES, "a readable file")?);
    if !mat::is_mat(&bytes) {
        return parse(&file, &read_text(path)?);
    }
    complete(&file, psychtoolbox(&bytes).map_err(|message| FileErrors::whole(&file, message))?)
}

/// Parses the text of a readings file; `file` identifies it in messages.
///
/// # Errors
/// The same errors as [`open()`].
pub fn parse(file: &str, text: &str) -> Result<Readings, FileErrors> {
    complete(
        file,
        match of_other_program(text) {
            Some(found) => found.map_err(|(line, message)| match line {
                0 => FileErrors::whole(file, message),
                _ => FileErrors::at(file, (line, 1), message),
            })?,
            None => incomplete(file, text)?,
        },
    )
}

/// Reads the readings in a possibly incomplete file in order to resume it.
///
/// # Errors
/// Reports rows that are not readings, with their line and column.
pub fn open_incomplete(path: &Path) -> Result<Vec<Reading>, FileErrors> {
    incomplete(&path.display().to_string(), &read_text(path)?)
}

/// Checks all readings. That of black is given to every channel that lacks it: all channels are dark in it.
fn complete(file: &str, mut readings: Vec<Reading>) -> Result<Readings, FileErrors> {
    let blacks: Vec<Reading> = readings.iter().filter(|one| one.level == 0.0).copied().collect();
    for &channel in Channel::ALL {
        let own = |one: &Reading| one.channel == channel;
        if readings.iter().any(own) && !blacks.iter().any(own) {
            let of_first = blacks.iter().filter(|one| one.channel == blacks[0].channel);
            readings.extend(of_first.map(|one| Reading { channel, ..*one }));
        }
    }
    let whole = |errors: Vec<String>| errors.into_iter().map(|error| FileError::whole(file, error)).collect();
    Readings::new(readings).map_err(|errors| FileErrors(whole(errors)))
}

/// Writes readings, and creates their folder if necessary.
///
/// # Errors
/// The same errors as [`Writer::write`].
pub fn write(writer: &Writer, path: &Path, readings: &[Reading]) -> Result<(), StoreError> {
    let mut text = COLUMNS.join(",") + "\n";
    for Reading { channel, level, luminance_cd_m2 } in readings {
        text += &format!("{},{level},{luminance_cd_m2}\n", channel.key());
    }
    writer.make_folder(folder_of(path))?;
    writer.write(path, text.as_bytes())
}

/// Reads the rows of our own table.
///
/// # Errors
/// The header lacks a column, a row is not a reading, or there are too many readings.
fn incomplete(file: &str, text: &str) -> Result<Vec<Reading>, FileErrors> {
    let separator = separator(text.lines().next().unwrap_or_default().as_bytes());
    let header = |names: &[&str]| {
        let found = COLUMNS.map(|column| names.iter().position(|name| name.trim().eq_ignore_ascii_case(column)));
        let missing = COLUMNS.into_iter().zip(found).filter(|(_, index)| index.is_none()).map(|(name, _)| name);
        let missing: Vec<&str> = missing.collect();
        let message = || format!("the header lacks {}; expected the columns {}", missing.join(", "), COLUMNS.join(","));
        if missing.is_empty() { Ok(found.map(Option::unwrap_or_default)) } else { Err((0, message())) }
    };
    let (_, rows) = table::parse(file, text.as_bytes(), separator, header, |columns, cells| {
        let number = |index: usize| {
            let cell = cells[columns[index]].trim();
            let message = || format!("{} {cell:?} is not a number; expected one such as 0.5", COLUMNS[index]);
            with_point(cell, separator).parse::<f64>().map_err(|_| (columns[index], message()))
        };
        let (name, lower) = (cells[columns[0]], cells[columns[0]].trim().to_lowercase());
        let channel = Channel::ALL.iter().find(|channel| [channel.name(), channel.key()].contains(&&*lower));
        let message = || (columns[0], format!("channel {name:?} is not known; expected r, g, b or gray"));
        let reading =
            Reading { channel: *channel.ok_or_else(message)?, level: number(1)?, luminance_cd_m2: number(2)? };
        let place = |field| COLUMNS.iter().position(|column| *column == field).map_or(0, |index| columns[index]);
        reading.check().map_err(|(field, message)| (place(field), message))?;
        Ok(reading)
    })?;
    match rows.len() {
        0..=MAX_READINGS => Ok(rows),
        many => {
            let message = format!("the number of readings is {many}; expected at most {MAX_READINGS}");
            Err(FileErrors::whole(file, message))
        }
    }
}

/// Reads the readings of another program; `None` if the text is not one of these formats. Mixed colors are not readings of a
/// channel and are left out. An error has its line, or 0.
fn of_other_program(text: &str) -> Option<Result<Vec<Reading>, (usize, String)>> {
    // Editors may put a mark before the first character.
    let text = text.trim_start_matches('\u{feff}');
    match text.split_whitespace().next()? {
        first if first.starts_with("CTI") || first.starts_with("CGATS") => Some(cgats(text)),
        first if first.starts_with('{') => Some(psychopy(text).map_err(|message| (0, message))),
        _ if text.starts_with("# Created by Octave") => {
            Some(Err((0, "is a text file of Octave; expected one that was saved with save -v7".to_owned())))
        }
        _ => None,
    }
}

/// Reads a CGATS table with the fields `RGB_R`, `RGB_G`, `RGB_B` and `XYZ_Y`.
fn cgats(text: &str) -> Result<Vec<Reading>, (usize, String)> {
    let lines = || (1..).zip(text.lines()).map(|(line, text)| (line, text.split_whitespace().collect::<Vec<&str>>()));
    // A second table describes something else.
    let table: Vec<_> = lines().take_while(|(_, words)| words.first() != Some(&"END_DATA")).collect();
    let place = |keyword: &str| table.iter().position(|(_, words)| words.first() == Some(&keyword));
    let after = |keyword: &str| table[place(keyword).map_or(table.len(), |place| place + 1)..].iter();
    let word = |keyword: &str, index: usize| table[place(keyword)?].1.get(index).copied();
    let fields = after("BEGIN_DATA_FORMAT").take_while(|(_, words)| words.first() != Some(&"END_DATA_FORMAT"));
    let fields: Vec<&str> = fields.flat_map(|(_, words)| words).copied().collect();
    let mut rows = Vec::new();
    for (line, words) in after("BEGIN_DATA").filter(|(_, words)| !words.is_empty()) {
        let value = |name: &str| {
            let place = fields.iter().position(|field| *field == name);
            let lacking = || (0, format!("has no field {name}; expected RGB_R, RGB_G, RGB_B, XYZ_Y"));
            let place = place.ok_or_else(lacking)?;
            let word = words.get(place).copied().unwrap_or_default();
            let wrong = |_| (*line, format!("{name} {word:?} is not a number; expected one such as 12.5"));
            word.parse::<f64>().map_err(wrong)
        };
        rows.push(([value("RGB_R")?, value("RGB_G")?, value("RGB_B")?], value("XYZ_Y")?, *line));
    }
    if rows.is_empty() {
        return Err((0, "has no data; expected a table between BEGIN_DATA and END_DATA".to_owned()));
    }
    if table.len() == lines().take(table.len() + 1).count() {
        return Err((0, "ends within its data; expected END_DATA".to_owned()));
    }
    if let Some(sets) = word("NUMBER_OF_SETS", 1).filter(|sets| *sets != rows.len().to_string()) {
        return Err((0, format!("has {} rows of data; expected {sets}, as NUMBER_OF_SETS says", rows.len())));
    }
    let is_relative = word("NORMALIZED_TO_Y_100", 1).is_some_and(|word| word.contains("YES"));
    let white_cd_m2 = word("LUMINANCE_XYZ_CDM2", 2).and_then(|y| y.trim_matches('"').parse::<f64>().ok());
    let lacking =
        || (0, "has luminances relative to white only; expected LUMINANCE_XYZ_CDM2 with that of white".to_owned());
    let scale = if is_relative { white_cd_m2.ok_or_else(lacking)? / 100.0 } else { 1.0 };
    let largest = rows.iter().flat_map(|(rgb, ..)| rgb).fold(0.0_f64, |most, value| most.max(*value));
    let full = if largest > 100.0 { 255.0 } else { 100.0 };
    let mut found = Vec::new();
    for (rgb, y, line) in rows {
        let channel = match rgb {
            [r, g, b] if r == g && g == b => Channel::Gray,
            [_, 0.0, 0.0] => Channel::Red,
            [0.0, _, 0.0] => Channel::Green,
            [0.0, 0.0, _] => Channel::Blue,
            _ => continue,
        };
        let level = rgb.into_iter().fold(0.0, f64::max) / full;
        let reading = Reading { channel, level, luminance_cd_m2: y * scale };
        reading.check().map_err(|(_, message)| (line, message))?;
        found.push(reading);
    }
    // A chart of colors has a few patches of pure primaries, which are not a curve beside the grays.
    let levels = |channel: Channel| {
        let own = found.iter().filter(|one| one.channel == channel && one.level != 0.0);
        own.map(|one| one.level.to_bits()).collect::<HashSet<_>>().len()
    };
    let is_curve = |channel: &Channel| match levels(Channel::Gray) {
        0 => levels(*channel) > 0,
        _ => levels(*channel) + 1 >= MIN_LEVELS,
    };
    let channels: Vec<Channel> = Channel::ALL.iter().copied().filter(is_curve).collect();
    // Black is no gray where no grays were read.
    for black in found.iter_mut().filter(|one| one.level == 0.0) {
        black.channel = channels.first().copied().unwrap_or(Channel::Gray);
    }
    found.retain(|one| channels.contains(&one.channel));
    Ok(found)
}

/// Reads the newest calibration in a monitor file of PsychoPy: `levelsPre`, 0 to 255, and `lumsPre`, one row for gray and
/// then one each for red, green and blue.
fn psychopy(text: &str) -> Result<Vec<Reading>, String> {
    let file: Value = serde_json::from_str(text).map_err(|error| format!("is not valid JSON: {error}"))?;
    let has_readings = |one: &&Value| !one["levelsPre"].is_null();
    let all = file.as_object().into_iter().flat_map(|all| all.values());
    let calibration = if has_readings(&&file) { Some(&file) } else { all.rev().find(has_readings) };
    let calibration =
        calibration.ok_or("has no readings; expected a monitor file of PsychoPy with levelsPre and lumsPre")?;
    let list = |value: &Value| -> Option<Vec<Value>> { value.get("__ndarray__").unwrap_or(value).as_array().cloned() };
    let numbers = |value: &Value| -> Option<Vec<f64>> { list(value)?.iter().map(Value::as_f64).collect() };
    let levels = numbers(&calibration["levelsPre"]).ok_or("levelsPre is not a list of numbers")?;
    let rows = list(&calibration["lumsPre"]).ok_or("lumsPre is not a list")?;
    let rows = if rows.iter().all(Value::is_number) { vec![calibration["lumsPre"].clone()] } else { rows };
    if ![1, 4].contains(&rows.len()) {
        let expected = "expected one row for gray, or four for gray, red, green and blue";
        return Err(format!("the number of rows in lumsPre is {}; {expected}", rows.len()));
    }
    let mut found = Vec::new();
    for (channel, row) in [Channel::Gray, Channel::Red, Channel::Green, Channel::Blue].into_iter().zip(&rows) {
        let lums = numbers(row).filter(|lums| lums.len() == levels.len());
        let lums =
            lums.ok_or_else(|| format!("lumsPre has a row without {} numbers, one for each level", levels.len()))?;
        let reading =
            |(level, luminance_cd_m2): (&f64, f64)| Reading { channel, level: level / 255.0, luminance_cd_m2 };
        found.extend(levels.iter().zip(lums).map(reading));
    }
    Ok(found)
}

/// Reads the newest calibration in a file of Psychtoolbox: `cals`, or `cal` alone. The light of each primary is its spectrum
/// `P_device`, in W/(sr·m²) per band, times its raw gamma table; what remains at black is `P_ambient`.
fn psychtoolbox(bytes: &[u8]) -> Result<Vec<Reading>, String> {
    let file = mat::variables(bytes)?;
    let cal = match file.field("cals").or_else(|| file.field("cal")) {
        Some(MatValue::List(all)) => all.last(),
        one => one,
    };
    let cal = cal.ok_or("has no variable cals; expected a calibration of Psychtoolbox")?;
    let lacking = |name: &str| format!("the calibration has no numbers {name}; expected those of Psychtoolbox");
    let numbers = |of: Option<&MatValue>, name: &str| -> Result<Vec<f64>, String> {
        of.and_then(|of| of.numbers(name))
            .filter(|all| !all.is_empty())
            .map(<[f64]>::to_vec)
            .ok_or_else(|| lacking(name))
    };
    let raw = cal.field("rawdata").or_else(|| cal.field("rawData"));
    let (inputs, table) = (numbers(raw, "rawGammaInput")?, numbers(raw, "rawGammaTable")?);
    let (spectra, dark) = (numbers(Some(cal), "P_device")?, numbers(Some(cal), "P_ambient")?);
    let [start_nm, step_nm, bands] = numbers(Some(cal), "S_device")?[..] else { return Err(lacking("S_device")) };
    let (bands, width) = (bands as usize, cal.numbers("nDevices").map_or(3.0, |devices| devices[0]) as usize);
    let channels = match width {
        1 => &[Channel::Gray][..],
        3 => &Channel::ALL[..3],
        _ => return Err(format!("the calibration has {width} primaries; expected 3, or 1 for gray")),
    };
    // The table has the columns of the spectra: one for each primary, and behind them those of what changes in their shape.
    let columns = spectra.len() / bands.max(1);
    let rows = table.len() / columns.max(1);
    let fits = [bands * columns == spectra.len(), rows * columns == table.len(), dark.len() == bands, columns >= width];
    if fits.contains(&false) || ![rows, width * rows].contains(&inputs.len()) {
        let names = "rawGammaInput, rawGammaTable, P_device, P_ambient and S_device";
        return Err(format!("the sizes of {names} do not fit together; expected a calibration of Psychtoolbox"));
    }
    let light = |spectrum: &[f64]| luminance_of_spectrum(spectrum, start_nm, step_nm);
    let black = light(&dark);
    // Before 2006, levels were codes.
    let full = if inputs.iter().any(|level| *level > 1.0) { 255.0 } else { 1.0 };
    let mut found = Vec::new();
    for (index, channel) in channels.iter().enumerate() {
        let white = light(&spectra[index * bands..][..bands]);
        let levels = if inputs.len() == rows { &inputs[..] } else { &inputs[index * rows..][..rows] };
        let of = |(level, share): (&f64, &f64)| (level / full, black + white * share);
        let read = levels.iter().zip(&table[index * rows..][..rows]).map(of).filter(|(level, _)| *level > 0.0);
        let all = [(0.0, black)].into_iter().chain(read);
        found.extend(all.map(|(level, luminance_cd_m2)| Reading { channel: *channel, level, luminance_cd_m2 }));
    }
    Ok(found)
}
