//! `machband compare`

use std::path::Path;

use maud::{PreEscaped, html};

use super::{Bar, OutPath, print_data, print_line, told_of};
use crate::{
    light::Transfer,
    report::terminal::{message, printable},
    stimulus::ViewingConditions,
    store::{self, Writer},
    work::{
        RequestError,
        compare::{Compare, Compared, Steps},
    },
};

/// Judge how visible the difference between two pictures is, in times threshold.
///
/// At 1, people just tell the pictures apart in a choice between two (84 % correct) if they look at the place where the
/// difference is most visible. The pictures must be registered: a shift by one pixel is a visible difference. Only
/// luminance is judged; colors of equal luminance look alike to the model. With --steps, no reference is needed.
///
/// The exit status is 1 if the difference is larger than --max. Folders are compared in pairs by name.
#[derive(clap::Args)]
#[command(
    after_help = "Examples: machband compare render.png truth.png --window 20 --max 1 --map difference.png\n          machband compare new/ approved/ --window 20 --max 1 --junit compare.xml\n          machband compare sky.png --steps --window 30 --dither-out dithered.png"
)]
pub(super) struct Arguments {
    #[command(flatten)]
    request: Compare,
    /// Where to write a map of the difference.
    #[arg(long, value_name = "FILE.png", conflicts_with = "steps")]
    map: Option<OutPath>,
    /// Where to write the picture in 8 bits with blue-noise dither. A picture of 8 bits is smoothed first.
    #[arg(long, value_name = "FILE.png", requires = "steps")]
    dither_out: Option<OutPath>,
    /// Write JSON: an object, or for folders a list of objects.
    #[arg(long)]
    json: bool,
    /// Where to write the results as JUnit XML, for continuous integration.
    #[arg(long, value_name = "FILE.xml")]
    junit: Option<OutPath>,
}

/// One comparison: its name, the number that is compared with the maximum or the error, and what else there is to say.
struct Case {
    name: String,
    times: Result<f64, String>,
    line: String,
    json: serde_json::Value,
    /// What the number does not say.
    note: Option<String>,
}

/// Compares, and returns true if everything is within the maximum.
pub(super) fn run(arguments: &Arguments, writer: &Writer) -> anyhow::Result<bool> {
    let Arguments { request, json, junit, .. } = arguments;
    let is_folder = request.is_folder()?;
    let bar = Bar::new(if is_folder { "pairs" } else { "comparing" });
    let cases = match judged(arguments, writer, is_folder, &bar) {
        // JUnit also tells of what cannot be judged: an older file would look current.
        Err(error) if junit.is_some() && !error.is::<RequestError>() => {
            vec![Case::of_pair(&request.picture, request.picture.display().to_string(), Err(error))?]
        }
        cases => cases?,
    };
    bar.clear();
    if let Some(path) = junit {
        writer.write(path, document(&cases, request.max).as_bytes())?;
    }
    if *json {
        let all: Vec<&serde_json::Value> = cases.iter().map(|case| &case.json).collect();
        let text = match all.as_slice() {
            [one] if !is_folder => serde_json::to_string_pretty(one)?,
            all => serde_json::to_string_pretty(all)?,
        };
        print_data(format!("{text}\n").as_bytes())?;
    }
    let mut is_within = true;
    for case in &cases {
        if !*json && case.times.is_ok() {
            print_line(&case.line)?;
        }
        if let Some(note) = &case.note {
            message("warning", &format!("{}: {note}", printable(&case.name)));
        }
        if let Some(wrong) = case.wrong(request.max) {
            is_within = false;
            message("error", &wrong);
        }
    }
    Ok(is_within)
}

/// Judges what the arguments ask for, and writes the picture that belongs to it.
fn judged(arguments: &Arguments, writer: &Writer, is_folder: bool, bar: &Bar) -> anyhow::Result<Vec<Case>> {
    let Arguments { request, map, dither_out, .. } = arguments;
    // For clap, a reference excuses the steps, which it excludes.
    if dither_out.is_some() && !request.steps {
        return Err(RequestError::value("dither_out", "is for steps without a reference; expected --steps").into());
    }
    if is_folder {
        if request.steps || map.is_some() {
            let option = if request.steps { "steps" } else { "map" };
            return Err(RequestError::value(option, "is for one picture; expected no folders").into());
        }
        let of = |(name, found)| Case::of_pair(&request.picture.join(&name), name, found);
        return request.folders(bar)?.into_iter().map(of).collect();
    }
    if request.steps {
        let found = request.steps(None, bar)?;
        if let Some(path) = dither_out {
            if !found.is_srgb {
                let message = "writes sRGB's primaries, but the picture has others; expected a picture of sRGB";
                return Err(RequestError::value("dither_out", message).into());
            }
            store::image::write_codes(writer, path, &found.picture_dithered, &found.transfers, None)?;
        }
        return Ok(vec![Case::of_steps(&found)?]);
    }
    let found = request.pair(None, bar)?;
    if let Some(path) = map {
        store::image::write_codes(writer, path, &found.picture_of_map(), &Transfer::Srgb.into(), None)?;
    }
    Ok(vec![Case::of_pair(&request.picture, found.picture.clone(), Ok(found))?])
}

impl Case {
    /// Says what is wrong: what could not be judged, or that the difference is above the maximum, in a number that is above it
    /// too.
    fn wrong(&self, max: Option<f64>) -> Option<String> {
        match (&self.times, max) {
            (Err(error), _) => Some(error.clone()),
            (Ok(times), Some(max)) if *times > max => {
                let (name, shown) = (printable(&self.name), (1e4 * times).ceil() / 1e4);
                Some(format!("{name}: {shown} times threshold; expected at most {max}"))
            }
            _ => None,
        }
    }

    fn of_pair(picture: &Path, name: String, found: anyhow::Result<Compared>) -> anyhow::Result<Self> {
        let found = match found {
            Ok(found) => found,
            Err(error) => {
                let text = told_of::<Compare>(&error);
                let json = serde_json::json!({ "picture": picture.display().to_string(), "error": text });
                return Ok(Self { name, times: Err(text), line: String::new(), json, note: None });
            }
        };
        let place =
            found.places.first().map_or_else(String::new, |place| format!(", most at ({}, {})", place.x, place.y));
        let line = format!(
            "{}: {:.3} times threshold{place}; {:.3} for a gaze at the middle ({})",
            printable(&found.picture),
            found.times_threshold,
            found.center,
            seen(&found.viewing, &found.light)
        );
        let json = serde_json::to_value(&found)?;
        Ok(Self { name, times: Ok(found.times_threshold), line, json, note: found.note() })
    }

    fn of_steps(found: &Steps) -> anyhow::Result<Self> {
        let keep = found.bits > 8 && found.steps < 1.0;
        let better = if keep { format!("keep {} bits", found.bits) } else { "write 16 bits".to_owned() };
        let remedy = match (found.is_below(), found.is_edges) {
            (true, true) => "what is judged is below threshold".to_owned(),
            (true, false) => "the steps are below threshold: no dither is needed".to_owned(),
            _ if found.dithered < found.in_8_bits() => format!("{better}, or dither to 8 (--dither-out)"),
            _ => format!("dither would be more visible than the steps: {better}"),
        };
        let rounded = found.rounded.map_or_else(String::new, |times| format!("; rounded to 8 bits {times:.3}"));
        let line = format!(
            "{}: steps {:.3} times threshold{rounded}; with blue-noise dither {:.3}, which is grain; {remedy} ({})",
            printable(&found.picture),
            found.steps,
            found.dithered,
            seen(&found.viewing, &found.light)
        );
        Ok(Self {
            name: found.picture.clone(),
            times: Ok(found.steps),
            line,
            json: serde_json::to_value(found)?,
            note: found.note(),
        })
    }
}

/// Says how pictures are seen, and what their codes mean.
fn seen(viewing: &ViewingConditions, light: &str) -> String {
    // Of pixels per degree, a width has many decimals.
    let ViewingConditions { window_deg, white_cd_m2: white, black_cd_m2: black } = viewing;
    let window_deg = (1e4 * window_deg).round() / 1e4;
    format!("luminance only; {window_deg}° wide; white {white} cd/m², black {black} cd/m²; {light}")
}

/// Returns text without the characters that XML cannot contain; [`printable`] escapes the others.
fn plain(text: &str) -> String {
    printable(text).replace(['\u{fffe}', '\u{ffff}'], "\u{fffd}")
}

/// Writes the cases as JUnit XML.
fn document(cases: &[Case], max: Option<f64>) -> String {
    let errors = cases.iter().filter(|case| case.times.is_err()).count();
    let failures = cases.iter().filter(|case| case.wrong(max).is_some()).count() - errors;
    let body = html! {
        testsuites {
            testsuite name="machband compare" tests=(cases.len()) failures=(failures) errors=(errors) {
                @for case in cases {
                    testcase classname="machband.compare" name=(plain(&case.name)) {
                        @match case.wrong(max) {
                            Some(error) if case.times.is_err() => error message=(plain(&error)) {},
                            Some(failure) => failure message=(plain(&failure)) {},
                            None => {},
                        }
                        @if case.times.is_ok() {
                            system-out { (plain(&case.line)) @if let Some(note) = &case.note { "\nwarning: " (plain(note)) } }
                        }
                    }
                }
            }
        }
    };
    html! { (PreEscaped("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n")) (body) "\n" }.into_string()
}
