//! How visible the difference between two pictures is, and that between a picture and what its codes were rounded from.

use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
};

use serde::Serialize;

use super::{Encoded, Encoding, Luminances, RequestError, Watcher};
use crate::{
    light::{Bits, CodeImage, Dither, Levels, LinearImage, Quantizer, Samples, Transfer, Transfers, reaches},
    report::terminal::printable,
    shading::crease,
    stimulus::ViewingConditions,
    store::{
        self, StoreError,
        image::{MAX_PIXELS, Picture},
    },
    system::{checkpoint, entries, found},
    text::number::{positive, within},
    vision::{DifferenceMap, Place, SRGB_WEIGHTS, VisionError, unrounded},
};

/// Number of places that are named.
const PLACES: usize = 10;
/// How far apart these are at least, degrees.
const APART_DEG: f64 = 0.5;
/// From this difference between their mean luminances on, a caller is told about it, percent.
const BRIGHTER_PERCENT: f64 = 5.0;

/// Which pictures are compared, and how they are seen.
#[derive(Clone, Debug, PartialEq, clap::Args, Serialize)]
pub struct Compare {
    /// The picture to judge: an opaque PNG, or a folder of them.
    #[arg(value_name = "FILE.png|DIR")]
    pub picture: PathBuf,
    /// The picture that it should look like, of the same size; or a folder of pictures of the same names.
    #[arg(value_name = "REFERENCE.png|DIR", required_unless_present = "steps", conflicts_with = "steps")]
    pub reference: Option<PathBuf>,
    /// Judge the steps between the picture's own codes, without a reference: how visible it is that they are not the
    /// smooth picture that they were rounded from.
    #[arg(long)]
    pub steps: bool,
    /// Width of the picture in degrees of visual angle; required, unless there are pixels per degree.
    #[arg(long = "window", value_name = "DEG", value_parser = positive)]
    pub window_deg: Option<f64>,
    /// Pixels per degree of visual angle, in place of the width.
    #[arg(long, value_name = "PX", value_parser = positive, conflicts_with = "window_deg")]
    pub ppd: Option<f64>,
    #[command(flatten)]
    #[serde(flatten)]
    pub luminances: Luminances,
    #[command(flatten)]
    #[serde(flatten)]
    pub encoding: Encoding,
    /// Picture of the same size that is white where differences count, and black where they do not.
    #[arg(long, value_name = "FILE.png", conflicts_with = "steps")]
    pub mask: Option<PathBuf>,
    /// The largest difference that is accepted, in times threshold; with more, the exit status is 1.
    #[arg(long, value_name = "V", value_parser = within(0.0, 1e6))]
    pub max: Option<f64>,
    /// Also accept pictures of more than 4096 × 4096 pixels. This needs more time and memory.
    #[arg(long)]
    pub large: bool,
}

/// A picture that a caller has in memory.
#[derive(Clone, Debug)]
pub enum Given {
    /// Codes that mean what the request says, by default sRGB.
    Codes(CodeImage),
    Light(LinearImage),
}

/// How visible the difference between two pictures is.
#[derive(Clone, Debug, Serialize)]
pub struct Compared {
    pub picture: String,
    pub reference: String,
    /// For a gaze at the place where the difference is most visible, in times threshold.
    pub times_threshold: f64,
    /// For a gaze at the middle of the picture.
    pub center: f64,
    /// The places where it is most visible, the most visible first.
    pub places: Vec<Place>,
    #[serde(flatten)]
    pub viewing: ViewingConditions,
    /// Mean luminance of the picture over that of the reference. The eye adapts to it, so it is not part of the
    /// difference.
    pub mean_ratio: f64,
    /// What the codes mean, and what says so.
    pub light: String,
    /// Times threshold for a gaze at each place.
    #[serde(skip)]
    pub map: DifferenceMap,
}

/// How visible the steps between a picture's codes are.
#[derive(Clone, Debug, Serialize)]
pub struct Steps {
    pub picture: String,
    /// The visible difference from the smoothest picture with these codes, in times threshold.
    pub steps: f64,
    /// The visible difference of a picture of more than 8 bits from itself in 8 bits without dither.
    pub rounded: Option<f64>,
    /// The same with blue-noise dither, whose grain is a visible difference too; of a picture of fewer than
    /// 16 bits, the smoothest picture is dithered.
    pub dithered: f64,
    #[serde(flatten)]
    pub viewing: ViewingConditions,
    /// What the codes mean, and what says so.
    pub light: String,
    /// The number of bits of the codes that are judged.
    pub bits: u32,
    /// The number of bits of a code in the file.
    #[serde(skip)]
    pub file_bits: u32,
    /// True if most changes between neighboring pixels are larger than a step, so that they count as edges.
    #[serde(skip)]
    pub is_edges: bool,
    /// The picture in 8 bits with blue-noise dither, and what its codes mean.
    #[serde(skip)]
    pub picture_dithered: CodeImage,
    #[serde(skip)]
    pub transfers: Transfers,
    /// True if the primaries are sRGB's.
    #[serde(skip)]
    pub is_srgb: bool,
}

/// The name of two pictures, and how they compare.
pub type Pair = (String, anyhow::Result<Compared>);

/// A picture as light.
struct Lit {
    name: String,
    /// Its size `[across, down]`, pixels, and the luminance of each pixel in cd/m².
    size: [u32; 2],
    cd_m2: Vec<f64>,
    light: String,
}

impl Compare {
    /// Compares two pictures: those given, or otherwise those of the request.
    ///
    /// # Errors
    /// A picture cannot be read, they differ in size, or they cannot be judged, for example because a place has no
    /// light.
    pub fn pair(&self, given: Option<[Given; 2]>, watcher: &dyn Watcher) -> anyhow::Result<Compared> {
        let encoded = self.encoded(watcher)?;
        let [shown, reference] = match given {
            Some([shown, reference]) => {
                [(shown, "picture"), (reference, "reference")].map(|(it, name)| self.given(it, name, &encoded))
            }
            None => {
                let reference = self.reference()?;
                let read = |path| self.read(path, &encoded);
                let (shown, reference) = rayon::join(|| read(&self.picture), || read(reference));
                [shown?, reference?]
            }
        };
        self.compared(shown, reference, &encoded)
    }

    /// True if the request names folders.
    ///
    /// # Errors
    /// The file system does not say.
    pub fn is_folder(&self) -> std::io::Result<bool> {
        Ok(found(&self.picture)?.is_some_and(|found| found.is_dir()))
    }

    /// Compares the pictures in two folders in pairs by name; the watcher learns the number of pairs, and what else is in the
    /// folders. Each pair has its own result or error, in the order of their names.
    ///
    /// # Errors
    /// A folder cannot be read, or there are no pictures. That a picture has no counterpart is the error of its pair.
    pub fn folders(&self, watcher: &dyn Watcher) -> anyhow::Result<Vec<Pair>> {
        let encoded = self.encoded(watcher)?;
        let folders = [self.picture.as_path(), self.reference()?];
        // The names of pictures, and in which folders they are.
        let mut all: BTreeMap<String, [bool; 2]> = BTreeMap::new();
        for (place, folder) in folders.into_iter().enumerate() {
            let [pictures, others] = pictures(folder)?;
            pictures.into_iter().for_each(|name| all.entry(name).or_default()[place] = true);
            if !others.is_empty() {
                let others = others.join(", ");
                let others = printable(&others);
                watcher.warn(&format!("{}: only PNG files are compared, not {others}", folder.display()));
            }
        }
        if all.is_empty() {
            anyhow::bail!("{}: contains no PNG; expected pictures", self.picture.display());
        }
        let one = |(done, (name, are_there)): (u64, (&String, &[bool; 2]))| {
            let compare = || {
                if let Some((folder, _)) = folders.iter().zip(are_there).find(|(_, is_there)| !**is_there) {
                    let (folder, name) = (folder.display(), printable(name));
                    anyhow::bail!("{folder}: lacks {name}; expected the same names in both folders");
                }
                let [shown, reference] = folders.map(|folder| self.read(&folder.join(name), &encoded));
                self.compared(shown?, reference?, &encoded)
            };
            // A map for every pair would not fit into memory.
            let found = compare().map(|found| Compared { map: DifferenceMap::default(), ..found });
            watcher.progress(done, all.len() as u64);
            (name.clone(), found)
        };
        // One after the other, since each pair keeps all threads busy.
        Ok((1..).zip(&all).map(one).collect())
    }

    /// Judges the steps between the codes of a picture: the one given, or otherwise that of the request.
    ///
    /// # Errors
    /// As for [`Compare::pair`].
    pub fn steps(&self, given: Option<CodeImage>, watcher: &dyn Watcher) -> anyhow::Result<Steps> {
        let encoded = self.encoded(watcher)?;
        let (name, picture) = match given {
            Some(codes) => ("picture".to_owned(), encoded.given(codes)),
            None => (self.picture.display().to_string(), self.picture(&self.picture, &encoded)?),
        };
        watcher.stage("smoothing");
        let CodeImage { width, height, .. } = picture.codes;
        let size = [width as usize, height as usize];
        let levels = Levels::of(&picture.codes, picture.significant_bits);
        let (smooth, is_edges) = smooth(&picture, levels);
        let quantizer = Quantizer::new(&picture.transfers, Bits::Eight);
        let shown = picture.codes.light(&picture.transfers);
        // A picture of 16 bits is what it is; its steps in 8 bits are what dither would hide.
        let source = if levels.bits == 16 { &shown } else { &smooth };
        let dithered = quantizer.quantize_with(source, Dither::BlueNoise, 0);
        let viewing = self.viewing(&encoded, width);
        let cd_m2 = |image: &LinearImage| viewing.luminances(image, picture.weights);
        let of_codes = |codes: &CodeImage| cd_m2(&codes.light(&picture.transfers));
        let rounded = (levels.bits > 8).then(|| of_codes(&quantizer.quantize(source)));
        let (shown, reference, target) = (cd_m2(&shown), cd_m2(&smooth), cd_m2(source));
        let grain = of_codes(&dithered);
        watcher.stage("comparing");
        let judge = viewing.judge(size, &reference).map_err(|error| wrong(&name, &error))?;
        let largest = |shown: &[f64], reference: &[f64]| {
            let difference = judge.difference(shown, reference, None).map_err(|error| wrong(&name, &error))?;
            Ok::<f64, anyhow::Error>(difference.map().largest())
        };
        Ok(Steps {
            steps: largest(&shown, &reference)?,
            rounded: rounded.map(|rounded| largest(&rounded, &target)).transpose()?,
            dithered: largest(&grain, &target)?,
            viewing,
            light: picture.origin.to_owned(),
            bits: levels.bits,
            file_bits: picture.bits,
            is_edges,
            is_srgb: picture.is_srgb(),
            picture: name,
            picture_dithered: dithered,
            transfers: picture.transfers,
        })
    }

    /// Reads the display profile, once the size of the picture is known.
    fn encoded(&self, watcher: &dyn Watcher) -> anyhow::Result<Encoded> {
        if self.window_deg.is_none() && self.ppd.is_none() {
            let message = "is missing; expected the width of the picture in degrees";
            return Err(RequestError::value("window_deg", message).unless("ppd").into());
        }
        self.encoding.read(watcher)
    }

    fn reference(&self) -> Result<&Path, RequestError> {
        let missing = || RequestError::value("reference", "is missing; expected a picture or a folder");
        self.reference.as_deref().ok_or_else(missing)
    }

    fn pixels(&self) -> u64 {
        if self.large { u64::MAX } else { MAX_PIXELS }
    }

    fn picture(&self, path: &Path, encoded: &Encoded) -> Result<Picture, StoreError> {
        let transfers = encoded.is_given.then_some(&encoded.transfers);
        Ok(encoded.shows(store::image::read_picture(path, transfers, self.pixels())?))
    }

    fn read(&self, path: &Path, encoded: &Encoded) -> anyhow::Result<Lit> {
        Ok(self.of_picture(&path.display().to_string(), &self.picture(path, encoded)?, encoded))
    }

    fn of_picture(&self, name: &str, picture: &Picture, encoded: &Encoded) -> Lit {
        self.lit(name, &picture.codes.light(&picture.transfers), picture.weights, picture.origin, encoded)
    }

    /// Returns a picture in memory as light.
    fn given(&self, given: Given, name: &str, encoded: &Encoded) -> Lit {
        match given {
            Given::Codes(codes) => self.of_picture(name, &encoded.given(codes), encoded),
            Given::Light(image) => self.lit(name, &image, SRGB_WEIGHTS, "given as light", encoded),
        }
    }

    fn lit(&self, name: &str, image: &LinearImage, weights: [f64; 3], light: &str, encoded: &Encoded) -> Lit {
        let cd_m2 = self.viewing(encoded, image.width).luminances(image, weights);
        Lit { name: name.to_owned(), size: [image.width, image.height], cd_m2, light: light.to_owned() }
    }

    fn viewing(&self, encoded: &Encoded, width_px: u32) -> ViewingConditions {
        let of_ppd = self.ppd.map(|ppd| f64::from(width_px) / ppd);
        let window_deg = self.window_deg.or(of_ppd).unwrap_or(ViewingConditions::WINDOW_DEG);
        encoded.viewing(window_deg, &self.luminances)
    }

    fn compared(&self, shown: Lit, reference: Lit, encoded: &Encoded) -> anyhow::Result<Compared> {
        checkpoint();
        let size = shown.size;
        if size != reference.size {
            let [a, b] = [size, reference.size].map(|[width, height]| format!("{width} × {height}"));
            let (name, reference) = (printable(&shown.name), printable(&reference.name));
            anyhow::bail!("{name}: has {a} pixels, but {reference} has {b}; expected pictures of one size");
        }
        let viewing = self.viewing(encoded, size[0]);
        let share = self.mask.as_deref().map(|path| self.share(path, size)).transpose()?;
        let size = size.map(|side| side as usize);
        let (mine, theirs) = (shown.cd_m2, reference.cd_m2);
        let light = if shown.light == reference.light {
            shown.light
        } else {
            format!("{}; reference: {}", shown.light, reference.light)
        };
        let sum = |light: &[f64]| match &share {
            None => light.iter().sum::<f64>(),
            Some(share) => light.iter().zip(share).map(|(light, share)| light * share).sum(),
        };
        let mean_ratio = sum(&mine) / sum(&theirs);
        let judged = || {
            let judge = viewing.judge(size, &theirs)?;
            let difference = judge.difference(&mine, &theirs, share.as_deref())?;
            Ok((difference.map(), difference.center()))
        };
        let is_lit = |light: &[f64]| light.iter().all(|light| *light > 0.0 && light.is_finite());
        let at_fault = || if is_lit(&mine) && !is_lit(&theirs) { &reference.name } else { &shown.name };
        let (map, center) = judged().map_err(|error| wrong(at_fault(), &error))?;
        Ok(Compared {
            picture: shown.name,
            reference: reference.name,
            // The middle lies between pixels.
            times_threshold: map.largest().max(center),
            center,
            places: map.peaks(PLACES, APART_DEG * size[0] as f64 / viewing.window_deg),
            viewing,
            mean_ratio,
            light,
            map,
        })
    }

    /// Reads how far differences count at each pixel, 0…1.
    fn share(&self, path: &Path, [width, height]: [u32; 2]) -> anyhow::Result<Vec<f64>> {
        // Its codes are not light.
        let mask = store::image::read_picture(path, Some(&Transfer::Srgb.into()), self.pixels())?;
        let CodeImage { width: across, height: down, .. } = mask.codes;
        if (across, down) != (width, height) {
            let message = format!("{} has {across} × {down} pixels; expected {width} × {height}", path.display());
            return Err(RequestError::new("mask", message).into());
        }
        let most = f64::from((1_u32 << mask.codes.bits()) - 1);
        let wrong = |message: &str| RequestError::new("mask", format!("{} {message}", path.display()));
        let of = |i: u32| match mask.codes.pixel(i % width, i / width) {
            [r, g, b] if r == g && g == b => Ok(f64::from(g) / most),
            _ => Err(wrong("has colors; expected black, gray and white")),
        };
        let share = (0..width * height).map(of).collect::<Result<Vec<f64>, _>>()?;
        if share.iter().all(|share| *share == 0.0) {
            return Err(wrong("selects no pixel; expected white where differences count").into());
        }
        Ok(share)
    }
}

impl Compared {
    /// Says if one picture is brighter as a whole, which is not judged.
    pub fn note(&self) -> Option<String> {
        let percent = 100.0 * (self.mean_ratio - 1.0);
        (percent.abs() > BRIGHTER_PERCENT).then(|| {
            format!("mean luminance {percent:+.0} %: the eye adapts to the mean, which is not part of the difference")
        })
    }

    /// Draws the map; `crease::color` goes from no difference to the largest one, or to the threshold if that is larger.
    pub fn picture_of_map(&self) -> CodeImage {
        let most = self.times_threshold.max(1.0);
        let code = |times: &f64| crease::color(times / most).map(|encoded| (encoded * 255.0).round() as u8);
        let [width, height] = self.map.size.map(|side| side as u32);
        CodeImage { width, height, samples: Samples::Eight(self.map.enlarged().iter().flat_map(code).collect()) }
    }
}

impl Steps {
    /// Returns how visible the steps of the picture in 8 bits are.
    pub fn in_8_bits(&self) -> f64 {
        self.rounded.unwrap_or(self.steps)
    }

    /// True if these are below threshold.
    pub fn is_below(&self) -> bool {
        self.in_8_bits() < 1.0
    }

    /// Says what is unusual about the codes.
    pub fn note(&self) -> Option<String> {
        let Self { bits, file_bits, .. } = self;
        let bits =
            (bits < file_bits).then(|| format!("its {file_bits} bits hold codes of {bits} bits, which are judged"));
        let edges = "most changes between neighboring pixels exceed one code: they are taken as edges and not judged";
        let edges = (self.is_edges && self.is_below()).then(|| edges.to_owned());
        let notes: Vec<String> = bits.into_iter().chain(edges).collect();
        (!notes.is_empty()).then(|| notes.join("; "))
    }
}

fn wrong(name: &str, error: &VisionError) -> anyhow::Error {
    anyhow::anyhow!("{}: {error}", printable(name))
}

/// Returns the light of the smoothest picture that has the codes of this one, and whether most changes of a channel are
/// edges.
fn smooth(picture: &Picture, levels: Levels) -> (LinearImage, bool) {
    let CodeImage { width, height, samples } = &picture.codes;
    let size = [*width as usize, *height as usize];
    let level = |code: u32| f64::from(levels.level(code));
    let codes: Vec<f64> = match samples {
        Samples::Eight(codes) => codes.iter().map(|code| level(u32::from(*code))).collect(),
        Samples::Sixteen(codes) => codes.iter().map(|code| level(u32::from(*code))).collect(),
    };
    let own = [0, 1, 2].map(|channel| codes.iter().skip(channel).step_by(3).copied().collect::<Vec<f64>>());
    let mut smooth: Vec<(Vec<f64>, bool)> = Vec::new();
    for k in 0..3 {
        // Gray is smoothed once.
        smooth.push(if k > 0 && own[k] == own[0] {
            smooth[0].clone()
        } else {
            let (reaches, is_edges) = reaches(&own[k], size[0]);
            (unrounded(&own[k], size, |level: f64| reaches[level as usize]), is_edges)
        });
    }
    let transfers: &[Transfer; 3] = picture.transfers.channels();
    let light = |k: usize, value: f64| transfers[k].linear_from_encoded(levels.encoded(value).clamp(0.0, 1.0)) as f32;
    let data = (0..own[0].len()).flat_map(|i| [0, 1, 2].map(|k| light(k, smooth[k].0[i]))).collect();
    (LinearImage { width: *width, height: *height, data }, smooth.iter().any(|(_, is_edges)| *is_edges))
}

/// Returns the names of the PNG files in a folder, and of what else is visible in it.
fn pictures(folder: &Path) -> anyhow::Result<[Vec<String>; 2]> {
    if !found(folder)?.is_some_and(|found| found.is_dir()) {
        anyhow::bail!("{}: is not a folder, but the other one is; expected two folders", folder.display());
    }
    let pictures = store::image::listed(folder)?;
    let name = |path: &PathBuf| path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let all = entries(folder)?;
    let others = all.iter().filter(|path| !pictures.contains(path)).map(name).filter(|name| !name.starts_with('.'));
    Ok([pictures.iter().map(name).collect(), others.collect()])
}
