//! A study's own pictures, as stimuli.

use std::sync::Arc;

use serde::{Deserialize, Serialize, Serializer, ser::SerializeMap as _};

use super::{
    drawing::Area,
    parameter::{Parameter, ParameterError, ParameterValue},
};
use crate::{
    light::{
        Bits, CodeImage, Dither, LinearImage, Quantizer, Samples, Transfer,
        image::{resampled, shares},
    },
    text::names::{expected_one_of, named},
};

named! {
    /// What reaches the screen.
    #[derive(Default)]
    ShownAs, ShownAsError {
        /// The codes of the file, whatever the display; those of a file with 16 bits are dithered down.
        Codes = "codes",
        /// The light that the file stands for, through the display profile.
        #[default]
        Display = "display",
    }
}

named! {
    /// How large a picture is on the screen.
    #[derive(Default)]
    PictureSize, PictureSizeError {
        /// One pixel of the screen for each pixel of the file.
        Pixels = "pixels",
        /// Its longer side fills the stimulus window, whose size is in degrees.
        #[default]
        Degrees = "degrees",
    }
}

/// One of the files.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct PictureFile {
    /// The path, relative to the folder of the definition.
    pub file: String,
    /// SHA-256 of the file, lowercase hexadecimal.
    pub sha256: String,
    /// The levels of the factors that the table of pictures has, in the order of its columns.
    #[serde(default)]
    pub levels: Vec<ParameterValue>,
    /// The pixels; `None` if the file was not read, as when a recorded session is read elsewhere.
    #[serde(skip)]
    pub content: Option<Arc<PictureContent>>,
}

/// The hash stands for the pixels, which may not have been read.
impl PartialEq for PictureFile {
    fn eq(&self, other: &Self) -> bool {
        (&self.file, &self.sha256, &self.levels) == (&other.file, &other.sha256, &other.levels)
    }
}

/// The pixels of a file.
#[derive(Clone, Debug)]
pub struct PictureContent {
    /// Its codes, 8 bits.
    pub codes: CodeImage,
    /// Its light.
    pub light: LinearImage,
    /// Whether the file has more than 8 bits, so that its light is dithered.
    pub is_fine: bool,
}

/// All pictures of a study.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Gallery {
    /// Which files, as a definition says: a folder, a slash, and a name in which `*` stands for any letters.
    pub files: String,
    /// What reaches the screen.
    pub show: ShownAs,
    /// How large the pictures are.
    pub size: PictureSize,
    /// Relative luminance of what a picture leaves free in its square, and of the field.
    pub background: f64,
    /// Names of the factors that the table of pictures has.
    pub factors: Vec<String>,
    /// The pictures to show, in the order of their names.
    pub pictures: Vec<PictureFile>,
    /// Pictures that only a task compares with the others.
    pub references: Vec<PictureFile>,
}

/// One of a study's own pictures, or before one is chosen, all of them.
#[derive(Clone, Debug)]
pub struct Picture {
    /// All of them.
    pub gallery: Arc<Gallery>,
    chosen: Option<usize>,
}

/// Equal files that are shown in the same way are equal pictures, whatever the others are.
impl PartialEq for Picture {
    fn eq(&self, other: &Self) -> bool {
        let shown = |of: &Self| (of.gallery.show, of.gallery.size);
        match (self.chosen(), other.chosen()) {
            (Some(one), Some(two)) => (&one.file, &one.sha256, shown(self)) == (&two.file, &two.sha256, shown(other)),
            (None, None) => self.gallery == other.gallery,
            _ => false,
        }
    }
}

/// Serializes the chosen picture alone: equal texts stand for equal pictures.
impl Serialize for Picture {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let Some(PictureFile { file, sha256, .. }) = self.chosen() else { return self.gallery.serialize(serializer) };
        let mut map = serializer.serialize_map(None)?;
        map.serialize_entry("picture", file)?;
        map.serialize_entry("sha256", sha256)?;
        map.serialize_entry("show", &self.gallery.show)?;
        map.serialize_entry("size", &self.gallery.size)?;
        map.end()
    }
}

impl<'de> Deserialize<'de> for Picture {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        #[derive(Deserialize)]
        struct One {
            picture: Option<String>,
            sha256: Option<String>,
            #[serde(flatten)]
            rest: serde_json::Map<String, serde_json::Value>,
        }
        let One { picture, sha256, rest } = One::deserialize(deserializer)?;
        let gallery: Gallery = serde_json::from_value(rest.into()).map_err(serde::de::Error::custom)?;
        let Some(file) = picture else { return Ok(gallery.into()) };
        let one = PictureFile { file, sha256: sha256.unwrap_or_default(), levels: Vec::new(), content: None };
        let picture: Self = Gallery { pictures: vec![one], ..gallery }.into();
        Ok(Self { chosen: Some(0), ..picture })
    }
}

impl From<Gallery> for Picture {
    fn from(gallery: Gallery) -> Self {
        Self { gallery: Arc::new(gallery), chosen: None }
    }
}

impl Picture {
    /// This kind's name in files.
    pub const KIND: &'static str = "image";
    /// The parameter that chooses a picture.
    pub const PICTURE: &'static str = "picture";

    /// All parameters that every such stimulus has.
    pub const PARAMETERS: &'static [Parameter] = &[Parameter {
        name: Self::PICTURE,
        unit: "",
        description: "File of the picture",
        expected: "one of the files of the definition",
        choices: &[],
        is_direction: false,
        levels_hint: &[],
    }];

    fn files(&self) -> impl Iterator<Item = &PictureFile> {
        self.gallery.pictures.iter().chain(&self.gallery.references)
    }

    fn chosen(&self) -> Option<&PictureFile> {
        self.files().nth(self.chosen?)
    }

    /// Returns each picture to show, with its own file chosen.
    pub fn each(&self) -> impl Iterator<Item = Self> {
        (0..self.gallery.pictures.len()).map(|index| Self { chosen: Some(index), ..self.clone() })
    }

    /// Returns the factors that the pictures have: the file, and those of the table, each with its levels.
    pub fn factors(&self) -> Vec<(String, Vec<ParameterValue>)> {
        let pictures = &self.gallery.pictures;
        let files = pictures.iter().map(|picture| ParameterValue::Text(picture.file.clone())).collect();
        let of_table = self.gallery.factors.iter().enumerate().map(|(index, name)| {
            let mut levels: Vec<ParameterValue> = Vec::new();
            for level in pictures.iter().filter_map(|picture| picture.levels.get(index)) {
                if !levels.contains(level) {
                    levels.push(level.clone());
                }
            }
            (name.clone(), levels)
        });
        std::iter::once((Self::PICTURE.to_owned(), files)).chain(of_table).collect()
    }

    /// Chooses a picture by its file. A level of another factor is accepted if some picture has it, and chooses nothing.
    pub(super) fn set(&mut self, name: &str, value: &ParameterValue) -> Result<(), ParameterError> {
        let text = value.to_string();
        if name == Self::PICTURE {
            let found = self.files().position(|picture| picture.file == text);
            let files: Vec<&str> = self.files().map(|picture| picture.file.as_str()).collect();
            let problem = "is not one of the pictures";
            let error = || ParameterError::new(name, &text, problem, &expected_one_of(&text, &files));
            self.chosen = Some(found.ok_or_else(error)?);
            return Ok(());
        }
        let index = self.gallery.factors.iter().position(|factor| factor == name);
        let Some(index) = index else {
            return Err(ParameterError::unknown(name, value, Self::KIND, Self::PARAMETERS));
        };
        // A row's 007 may arrive as the number 7.
        let is_it = |level: &ParameterValue| level == value || level.to_string().parse().as_ref() == Ok(value);
        let has = self.gallery.pictures.iter().filter_map(|picture| picture.levels.get(index)).any(is_it);
        let problem = "is not a level of any picture";
        has.then_some(()).ok_or_else(|| ParameterError::new(name, text, problem, "a level in the table of pictures"))
    }

    /// Returns the file of the chosen picture, or its level of a factor.
    pub(super) fn get(&self, name: &str) -> Option<ParameterValue> {
        if name == Self::PICTURE {
            return Some(ParameterValue::Text(self.chosen().map_or_else(String::new, |picture| picture.file.clone())));
        }
        let index = self.gallery.factors.iter().position(|factor| factor == name)?;
        Some(self.chosen()?.levels.get(index).cloned().unwrap_or_else(|| "".into()))
    }

    /// Returns the side of the smallest square that holds every picture pixel for pixel, if the pictures are shown so.
    pub fn side(&self) -> Option<u32> {
        let sides = self.files().filter_map(|picture| picture.content.as_ref());
        let largest = sides.map(|content| content.codes.width.max(content.codes.height)).max();
        largest.filter(|_| self.gallery.size == PictureSize::Pixels)
    }

    /// Returns whether the pixels are known.
    pub fn is_read(&self) -> bool {
        self.chosen().is_some_and(|picture| picture.content.is_some())
    }

    /// Returns the picture at the size at which it is shown in a window of `side` pixels.
    fn sized(&self, light: LinearImage, side: u32) -> LinearImage {
        let longer = light.width.max(light.height);
        if self.gallery.size == PictureSize::Pixels || longer == side {
            return light;
        }
        let scale = f64::from(side) / f64::from(longer);
        let [width, height] = [light.width, light.height].map(|n| ((f64::from(n) * scale).round() as u32).max(1));
        let at = |x, y| light.pixel(x as u32, y as u32).map(f64::from);
        let [from, to] = [[light.width, light.height], [width, height]].map(|size| size.map(|side| side as usize));
        let data = resampled(from, to, shares, at).into_flattened();
        LinearImage { width, height, data: data.into_iter().map(|light| light as f32).collect() }
    }
}

/// A square window with the picture in its middle.
impl Area for Picture {
    fn linear(&self, side: u32) -> LinearImage {
        let background = [self.gallery.background as f32; 3];
        let Some(content) = self.chosen().and_then(|picture| picture.content.as_ref()) else {
            return LinearImage::from_fn(side, side, |_, _| background);
        };
        let light = self.sized(self.gallery.show.light(content), side);
        LinearImage::from_fn(side, side, |x, y| {
            inside([light.width, light.height], side, x, y).map_or(background, |[x, y]| light.pixel(x, y))
        })
    }

    fn codes(&self, side: u32, quantizer: &Quantizer) -> CodeImage {
        let content = self.chosen().and_then(|picture| picture.content.as_ref());
        let Some(content) = content.filter(|_| quantizer.bits() == Bits::Eight) else {
            return quantizer.quantize(&self.linear(side));
        };
        let background = quantizer.codes([self.gallery.background as f32; 3]);
        let light = self.sized(self.gallery.show.light(content), side);
        let codes = match self.gallery.show {
            ShownAs::Codes => Quantizer::new(&Transfer::Srgb.into(), Bits::Eight).quantize(&light),
            ShownAs::Display if content.is_fine => quantizer.quantize_with(&light, Dither::BlueNoise, 0),
            ShownAs::Display => quantizer.quantize(&light),
        };
        let pixel = |x, y| {
            let inside = inside([codes.width, codes.height], side, x, y);
            inside.map_or(background, |[x, y]| codes.pixel(x, y)).map(|code| code as u8)
        };
        let samples = (0..side).flat_map(|y| (0..side).flat_map(move |x| pixel(x, y))).collect();
        CodeImage { width: side, height: side, samples: Samples::Eight(samples) }
    }

    fn profile(&self, size: u32) -> Vec<[f32; 3]> {
        let image = self.linear(size);
        (0..size).map(|x| image.pixel(x, size / 2)).collect()
    }
}

impl ShownAs {
    /// Returns the light of a picture; of its codes, that of an sRGB display.
    fn light(self, content: &PictureContent) -> LinearImage {
        match self {
            Self::Codes => content.codes.light(&Transfer::Srgb.into()),
            Self::Display => content.light.clone(),
        }
    }
}

/// Returns the pixel of a picture of this size at a place of the square in whose middle it is.
fn inside([width, height]: [u32; 2], side: u32, x: u32, y: u32) -> Option<[u32; 2]> {
    let offset = |n: u32| (i64::from(side) - i64::from(n)).div_euclid(2);
    let at = |place: u32, n: u32| u32::try_from(i64::from(place) - offset(n)).ok().filter(|at| *at < n);
    Some([at(x, width)?, at(y, height)?])
}
