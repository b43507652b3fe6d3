//! Images as PNG: gray where the colour allows, with what the codes mean and how they were made.

use std::{
    borrow::Cow,
    fs::File,
    io::{BufReader, Cursor},
    path::Path,
};

use super::light;
use crate::{
    light::{
        CodeImage, Quantizer, Samples, Transfer, Transfers,
        halftone::{Halftone, Screen},
        palette::{IndexedImage, Reduction, reduce},
    },
    stimulus::recipe::{Recipe, SIZE_MAX},
    store::{FileFaults, StoreError, fault::io, file::write_whole},
};

/// Keyword of the text chunk that holds the recipe as JSON.
const KEYWORD: &str = "machband";
/// Keyword of the text chunk that names the palette's making, where there is one.
const PALETTE_KEYWORD: &str = "machband-palette";
/// Keyword of the text chunk that names the halftone, where it is one.
const HALFTONE_KEYWORD: &str = "machband-halftone";
/// Keyword of the text chunk that holds the parameters of a shaded mesh as JSON.
const SHADED_KEYWORD: &str = "machband-shading";
/// Chromaticities of D65 and of the sRGB primaries, in the hundred-thousandths of PNG. IEC 61966-2-1.
const SRGB_CHROMATICITIES: [[u32; 2]; 4] = [[31_270, 32_900], [64_000, 33_000], [30_000, 60_000], [15_000, 6_000]];
/// Entries of the tone curves in an embedded profile.
const CURVE_POINTS: u16 = 4096;

/// Renders a recipe and writes it as PNG, whole or not at all. Gives the file's bytes.
///
/// # Errors
/// The system's refusal.
pub fn write_recipe(path: &Path, recipe: &Recipe, quantizer: &Quantizer) -> Result<Vec<u8>, StoreError> {
    let bytes = encode(&recipe.codes(quantizer), &recipe.transfers, &[(KEYWORD, describe(recipe))])
        .map_err(|error| io(path, "encode")(std::io::Error::other(error)))?;
    write_whole(path, &bytes, false)?;
    Ok(bytes)
}

/// Renders a recipe, reduces it to a palette and writes an indexed PNG. Gives the error in linear light.
///
/// # Errors
/// 16 bits, which have no palette, or the system's refusal.
pub fn write_reduced(
    path: &Path,
    recipe: &Recipe,
    quantizer: &Quantizer,
    reduction: Reduction,
) -> Result<IndexedImage, StoreError> {
    let failed = |error: Box<dyn std::error::Error + Send + Sync>| io(path, "encode")(std::io::Error::other(error));
    let image = reduce(&recipe.codes(quantizer), &recipe.transfers, reduction.colors, reduction.reducer)
        .map_err(|error| failed(error.into()))?;
    let mut info = png::Info::with_size(image.width, image.height);
    info.color_type = png::ColorType::Indexed;
    info.palette = Some(Cow::Owned(image.palette.concat()));
    let texts = [(KEYWORD, describe(recipe)), (PALETTE_KEYWORD, reduction.to_string())];
    let bytes = finish(info, &recipe.transfers, false, &texts, &image.indices).map_err(|error| failed(error.into()))?;
    write_whole(path, &bytes, false)?;
    Ok(image)
}

/// Renders a recipe as dots of a device with few codes, each pixel a cell, and writes it.
///
/// # Errors
/// Too many dots, or the system's refusal.
pub fn write_halftone(path: &Path, recipe: &Recipe, screen: Screen) -> Result<(), StoreError> {
    let failed = |error: Box<dyn std::error::Error + Send + Sync>| io(path, "encode")(std::io::Error::other(error));
    let image =
        Halftone::new(screen, &recipe.transfers).enlarged(&recipe.linear()).map_err(|error| failed(error.into()))?;
    let texts = [(KEYWORD, describe(recipe)), (HALFTONE_KEYWORD, screen.to_string())];
    let bytes = encode(&image, &recipe.transfers, &texts).map_err(|error| failed(error.into()))?;
    write_whole(path, &bytes, false)
}

/// Writes the picture of a shaded mesh, `parameters` saying how it was made.
///
/// # Errors
/// The system's refusal.
pub fn write_shaded(
    path: &Path,
    image: &CodeImage,
    transfers: &Transfers,
    parameters: &serde_json::Value,
) -> Result<(), StoreError> {
    // Text chunks are Latin-1, and the path of a mesh may be anything: JSON can say it in ASCII.
    let escape = |c: char| {
        let units = |c: char| c.encode_utf16(&mut [0; 2]).iter().map(|u| format!("\\u{u:04x}")).collect::<String>();
        if c.is_ascii() { c.to_string() } else { units(c) }
    };
    let text = parameters.to_string().chars().map(escape).collect();
    let bytes = encode(image, transfers, &[(SHADED_KEYWORD, text)])
        .map_err(|error| io(path, "encode")(std::io::Error::other(error)))?;
    write_whole(path, &bytes, false)
}

/// Writes codes for a screen with sRGB's transfer function, without a word of how they were made.
///
/// # Errors
/// The system's refusal.
pub fn write_codes(path: &Path, image: &CodeImage) -> Result<(), StoreError> {
    let bytes =
        encode(image, &Transfer::Srgb.into(), &[]).map_err(|error| io(path, "encode")(std::io::Error::other(error)))?;
    write_whole(path, &bytes, false)
}

/// The recipe as it stands in an image.
pub fn describe(recipe: &Recipe) -> String {
    serde_json::to_string(recipe).unwrap_or_default()
}

/// An image file as bytes. Equal inputs give equal bytes.
fn encode(image: &CodeImage, transfers: &Transfers, texts: &[(&str, String)]) -> Result<Vec<u8>, png::EncodingError> {
    // Equal codes of channels that differ are no gray.
    let gray = transfers.uniform().is_some() && is_gray(&image.samples);
    let mut info = png::Info::with_size(image.width, image.height);
    info.color_type = if gray { png::ColorType::Grayscale } else { png::ColorType::Rgb };
    info.bit_depth = match image.samples {
        Samples::Eight(_) => png::BitDepth::Eight,
        Samples::Sixteen(_) => png::BitDepth::Sixteen,
    };
    finish(info, transfers, gray, texts, &raw_samples(&image.samples, gray))
}

/// Adds what the codes mean and how they were made, and encodes.
fn finish(
    mut info: png::Info<'_>,
    transfers: &Transfers,
    gray: bool,
    texts: &[(&str, String)],
    samples: &[u8],
) -> Result<Vec<u8>, png::EncodingError> {
    let curve = match transfers.uniform() {
        Some(Transfer::Srgb) => None,
        Some(Transfer::Linear) => Some(1.0),
        Some(Transfer::Gamma(gamma)) => Some(*gamma),
        Some(Transfer::Gog(_) | Transfer::Table(_)) | None => {
            info.icc_profile = profile(transfers, gray).map(Cow::Owned);
            None
        }
    };
    if let Some(gamma) = curve {
        let [white, red, green, blue] = SRGB_CHROMATICITIES.map(|pair| pair.map(png::ScaledFloat::from_scaled).into());
        info.source_gamma = Some(png::ScaledFloat::from_scaled((100_000.0 / gamma).round() as u32));
        info.source_chromaticities = Some(png::SourceChromaticities { white, red, green, blue });
    }
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::with_info(&mut bytes, info)?;
    if transfers.uniform() == Some(&Transfer::Srgb) {
        encoder.set_source_srgb(png::SrgbRenderingIntent::RelativeColorimetric);
    }
    // Neighbouring rows of a stimulus are all but equal: their difference is zeros, and a fast coder is enough.
    encoder.set_compression(png::Compression::Fast);
    encoder.set_filter(png::Filter::Up);
    for (keyword, text) in texts {
        encoder.add_text_chunk((*keyword).to_owned(), text.clone())?;
    }
    let mut writer = encoder.write_header()?;
    writer.write_image_data(samples)?;
    writer.finish()?;
    Ok(bytes)
}

fn is_gray(samples: &Samples) -> bool {
    fn equal<T: PartialEq>(codes: &[T]) -> bool {
        codes.chunks_exact(3).all(|pixel| pixel[0] == pixel[1] && pixel[1] == pixel[2])
    }
    match samples {
        Samples::Eight(codes) => equal(codes),
        Samples::Sixteen(codes) => equal(codes),
    }
}

/// The samples as PNG stores them: one a pixel for gray, 16 bits most significant byte first.
fn raw_samples(samples: &Samples, gray: bool) -> Cow<'_, [u8]> {
    let step = if gray { 3 } else { 1 };
    match samples {
        Samples::Eight(codes) if !gray => Cow::Borrowed(codes),
        Samples::Eight(codes) => codes.iter().step_by(step).copied().collect(),
        Samples::Sixteen(codes) => codes.iter().step_by(step).flat_map(|code| code.to_be_bytes()).collect(),
    }
}

/// Measured transfer functions as an ICC profile, with sRGB's primaries.
fn profile(transfers: &Transfers, gray: bool) -> Option<Vec<u8>> {
    let curve = |transfer: &Transfer| {
        let points = (0..CURVE_POINTS).map(|i| {
            let linear = transfer.linear_from_encoded(f64::from(i) / f64::from(CURVE_POINTS - 1));
            (linear * f64::from(u16::MAX)).round() as u16
        });
        Some(moxcms::ToneReprCurve::Lut(points.collect()))
    };
    let [red, green, blue] = transfers.channels();
    let mut profile =
        if gray { moxcms::ColorProfile::new_gray_with_gamma(1.0) } else { moxcms::ColorProfile::new_srgb() };
    // A fixed date: equal inputs give equal bytes.
    profile.creation_date_time =
        moxcms::ColorDateTime { year: 2026, month: 1, day_of_the_month: 1, hours: 0, minutes: 0, seconds: 0 };
    profile.cicp = None;
    if gray {
        profile.gray_trc = curve(red);
    } else {
        profile.red_trc = curve(red);
        profile.green_trc = curve(green);
        profile.blue_trc = curve(blue);
    }
    profile.encode().ok()
}

/// An image file of this program, read back.
#[derive(Clone, Debug)]
pub struct ReadBack {
    /// How it says it was made.
    pub recipe: Recipe,
    /// The palette it was reduced to, if it was.
    pub reduction: Option<Reduction>,
    /// The halftone it was made into, if it was.
    pub halftone: Option<Screen>,
    /// What is in it.
    pub image: CodeImage,
}

/// The recipe's text in an image file, without looking at the pixels; `None` where there is none.
pub(in crate::store) fn recipe_text(path: &Path) -> Option<String> {
    let reader = png::Decoder::new(BufReader::new(File::open(path).ok()?)).read_info().ok()?;
    let chunks = &reader.info().uncompressed_latin1_text;
    chunks.iter().find(|chunk| chunk.keyword == KEYWORD).map(|chunk| chunk.text.clone())
}

/// Reads an image with its recipe.
///
/// # Errors
/// Not readable, not a PNG of this program, or too large.
pub fn read(path: &Path) -> Result<ReadBack, FileFaults> {
    parse(&path.display().to_string(), &light::content(path)?)
}

/// Reads the content of an image with its recipe; `name` names it in messages.
///
/// # Errors
/// As [`read`].
pub fn parse(name: &str, content: &[u8]) -> Result<ReadBack, FileFaults> {
    let fail = |message: String| FileFaults::whole(name, message);
    let broken = |error: png::DecodingError| fail(format!("is not a whole PNG: {error}; expected an image"));
    let limits = png::Limits { bytes: 512 << 20 };
    let mut decoder = png::Decoder::new_with_limits(Cursor::new(content), limits);
    decoder.set_transformations(png::Transformations::IDENTITY);
    let mut reader = decoder.read_info().map_err(broken)?;
    let info = reader.info();
    let text = |keyword: &str| {
        let chunks = &info.uncompressed_latin1_text;
        chunks.iter().find(|chunk| chunk.keyword == keyword).map(|chunk| chunk.text.clone())
    };
    let reduction = text(PALETTE_KEYWORD)
        .map(|text| {
            text.parse::<Reduction>().map_err(|error| fail(format!("its text chunk `{PALETTE_KEYWORD}`: {error}")))
        })
        .transpose()?;
    let halftone = text(HALFTONE_KEYWORD)
        .map(|text| {
            text.parse::<Screen>().map_err(|error| fail(format!("its text chunk `{HALFTONE_KEYWORD}`: {error}")))
        })
        .transpose()?;
    let palette = info.palette.as_deref().unwrap_or_default().to_vec();
    if let Some(parameters) = text(SHADED_KEYWORD) {
        return Err(fail(format!(
            "is a shaded mesh, which cannot be proved; expected an image of `stimulus` or `stimuli`. It was made with {parameters}"
        )));
    }
    let recipe = text(KEYWORD)
        .ok_or_else(|| fail("has no text chunk `machband`; expected an image that machband wrote".to_owned()))?;
    let recipe: Recipe = serde_json::from_str(&recipe)
        .map_err(|error| fail(format!("its text chunk `machband` cannot be read: {error}; expected a recipe")))?;
    if let Err(faults) = recipe.stimulus.validate() {
        let faults: Vec<_> = faults.iter().map(ToString::to_string).collect();
        return Err(fail(faults.join("; ")));
    }
    let (width, height, color, depth) = (info.width, info.height, info.color_type, info.bit_depth);
    let side_max = if halftone.is_some() { 16 * SIZE_MAX } else { SIZE_MAX };
    if width == 0 || width.max(height) > side_max {
        return Err(fail(format!("has {width} × {height} pixels; expected at most {side_max} a side")));
    }
    let mut raw = light::room(reader.output_buffer_size(), content.len()).map_err(fail)?;
    reader.next_frame(&mut raw).map_err(broken)?;
    if color == png::ColorType::Indexed {
        let colors = palette.as_chunks::<3>().0;
        let codes: Option<Vec<[u8; 3]>> = raw.iter().map(|index| colors.get(usize::from(*index)).copied()).collect();
        let samples = codes.filter(|_| depth == png::BitDepth::Eight).map(|codes| Samples::Eight(codes.concat()));
        let samples = samples
            .ok_or_else(|| fail("has indices without a color; expected a palette of 8-bit indices".to_owned()))?;
        return Ok(ReadBack { recipe, reduction, halftone, image: CodeImage { width, height, samples } });
    }
    let copies = match color {
        png::ColorType::Grayscale => 3,
        png::ColorType::Rgb => 1,
        other => return Err(fail(format!("has the colour type {other:?}; expected gray or RGB"))),
    };
    let samples = match depth {
        png::BitDepth::Eight => {
            Samples::Eight(raw.iter().flat_map(|code| std::iter::repeat_n(*code, copies)).collect())
        }
        png::BitDepth::Sixteen => Samples::Sixteen(
            raw.chunks_exact(2)
                .flat_map(|pair| std::iter::repeat_n(u16::from_be_bytes([pair[0], pair[1]]), copies))
                .collect(),
        ),
        other => return Err(fail(format!("has {other:?} bits a sample; expected 8 or 16"))),
    };
    Ok(ReadBack { recipe, reduction, halftone, image: CodeImage { width, height, samples } })
}

/// Proves an image: renders its recipe again and compares every code. Says in one sentence what it is.
///
/// # Errors
/// As [`read`]; or how many codes differ, and the first of them.
pub fn prove(path: &Path) -> Result<String, FileFaults> {
    prove_content(&path.display().to_string(), &light::content(path)?)
}

/// As [`prove`], of the content of an image; `name` names it in messages.
///
/// # Errors
/// As [`prove`].
pub fn prove_content(name: &str, content: &[u8]) -> Result<String, FileFaults> {
    let read = parse(name, content)?;
    let fail = |message: String| FileFaults::whole(name, message);
    let (image, recipe) = (&read.image, &read.recipe);
    if recipe.size == 0 || recipe.size > SIZE_MAX {
        return Err(fail(format!("its recipe asks for {} pixels a side; expected 1…{SIZE_MAX}", recipe.size)));
    }
    let dots = read.halftone.map_or(1, |screen| screen.matrix.size());
    if (image.width, image.height) != (recipe.size * dots, recipe.size * dots) {
        let side = recipe.size * dots;
        return Err(fail(format!(
            "has {} × {} pixels; expected {side} a side, as its recipe says",
            image.width, image.height
        )));
    }
    let expected = read.expected().map_err(&fail)?;
    if std::mem::discriminant(&expected.samples) != std::mem::discriminant(&image.samples) {
        return Err(fail(format!("has another depth than its recipe; expected {} bits", recipe.bits)));
    }
    let mut differing = (0..image.height)
        .flat_map(|y| (0..image.width).map(move |x| (x, y)))
        .filter(|&(x, y)| image.pixel(x, y) != expected.pixel(x, y))
        .peekable();
    match differing.peek().copied() {
        None => Ok(read.sentence()),
        Some((x, y)) => {
            let (found, wanted, count) = (image.pixel(x, y), expected.pixel(x, y), differing.count());
            Err(fail(format!(
                "{count} pixels differ from the recipe, the first at ({x}, {y}), which is {found:?}; expected {wanted:?}"
            )))
        }
    }
}

impl ReadBack {
    /// What the image should be.
    fn expected(&self) -> Result<CodeImage, String> {
        let recipe = &self.recipe;
        if let Some(screen) = self.halftone {
            return Halftone::new(screen, &recipe.transfers)
                .enlarged(&recipe.linear())
                .map_err(|error| error.to_string());
        }
        let codes = recipe.codes(&recipe.quantizer());
        match self.reduction {
            None => Ok(codes),
            Some(Reduction { reducer, colors }) => reduce(&codes, &recipe.transfers, colors, reducer)
                .map(|image| image.codes())
                .map_err(|error| error.to_string()),
        }
    }

    fn sentence(&self) -> String {
        let recipe = &self.recipe;
        let transfer = match recipe.transfers.uniform() {
            Some(Transfer::Table(_)) => "measured table".to_owned(),
            _ => recipe.transfers.to_string(),
        };
        let palette = self.reduction.map_or_else(String::new, |reduction| format!(", palette {reduction}"));
        let halftone = self.halftone.map_or_else(String::new, |screen| format!(", halftone {screen}"));
        format!(
            "image of {}, {} pixels a side, {} bits, {transfer}, dither {}{palette}{halftone}: every code is as its recipe gives it",
            recipe.stimulus.kind(),
            recipe.size,
            recipe.bits,
            recipe.dither,
        )
    }
}
