//! Reads PLY files (Stanford polygon files), as text and in binary.
//!
//! The reader uses the positions, normals and colors of the vertices, and the faces or triangle strips. Colors are sRGB,
//! as scanners write them: codes, or numbers from 0 to 1, or from 0 to 255 if any is above 1. Other elements and properties
//! are ignored.

use glam::DVec3;

use super::faces::{Faces, MAX_CORNERS, strip_triangles};
use crate::{
    shading::mesh::{Corner, MAX_COORDINATE},
    store::{FileErrors, table::shortened},
};

/// A type of numbers, and how many bytes one has.
#[derive(Clone, Copy)]
enum Kind {
    Signed(usize),
    Unsigned(usize),
    Real(usize),
}

impl Kind {
    fn named(name: &str) -> Result<Self, String> {
        Ok(match name {
            "char" | "int8" => Self::Signed(1),
            "short" | "int16" => Self::Signed(2),
            "int" | "int32" => Self::Signed(4),
            "uchar" | "uint8" => Self::Unsigned(1),
            "ushort" | "uint16" => Self::Unsigned(2),
            "uint" | "uint32" => Self::Unsigned(4),
            "float" | "float32" => Self::Real(4),
            "double" | "float64" => Self::Real(8),
            _ => return Err(format!("{:?} is not a type; expected one such as uchar or float", shortened(name))),
        })
    }

    /// Returns the largest number of a type without a sign, and 1 for another type.
    fn full(self) -> f64 {
        if let Self::Unsigned(size) = self { 256_f64.powi(size as i32) - 1.0 } else { 1.0 }
    }

    /// Reads a number from a word of a text.
    fn of_word(self, name: &str, word: &str) -> Result<f64, String> {
        let is_real = matches!(self, Self::Real(_));
        let number = word.parse::<f64>().ok().filter(|number| is_real || number.fract() == 0.0);
        let expected = if is_real { "a number" } else { "a whole number" };
        let number = number.ok_or_else(|| format!("{name} is {:?}; expected {expected}", shortened(word)))?;
        if matches!(self, Self::Unsigned(_)) && !(0.0..=self.full()).contains(&number) {
            return Err(format!("{name} is {number}; expected 0…{}", self.full()));
        }
        Ok(number)
    }

    /// Takes a number from the bytes; `None` if they end.
    fn of_bytes(self, rest: &mut &[u8], is_big: bool) -> Option<f64> {
        let (Self::Signed(size) | Self::Unsigned(size) | Self::Real(size)) = self;
        let bytes = rest.split_off(..size)?;
        let byte = |at: usize| u64::from(bytes[if is_big { at } else { size - 1 - at }]);
        let word = (0..size).fold(0, |word, at| word << 8 | byte(at));
        Some(match self {
            Self::Real(4) => f32::from_bits(word as u32).into(),
            Self::Real(_) => f64::from_bits(word),
            Self::Unsigned(_) => word as f64,
            Self::Signed(_) => ((word << (64 - 8 * size)) as i64 >> (64 - 8 * size)) as f64,
        })
    }
}

/// A number, or a list of numbers after their count, of every element of a kind.
struct Property {
    name: String,
    kind: Kind,
    /// The type of the count, if it is a list.
    counted: Option<Kind>,
    /// What it is, if it is used: one of [`NUMBERS`], or [`CORNERS`].
    meaning: Option<usize>,
}

/// Elements of a kind, such as vertices.
struct Element {
    name: String,
    count: usize,
    properties: Vec<Property>,
}

/// What is used of an element: the numbers of a vertex, and the list of a face.
#[derive(Default)]
struct Values {
    numbers: [Option<f64>; CORNERS],
    corners: Vec<f64>,
}

const NUMBERS: [&str; 9] = ["x", "y", "z", "nx", "ny", "nz", "red", "green", "blue"];
/// The first of the numbers that are a color.
const COLORS: usize = 6;
/// The list of a face.
const CORNERS: usize = NUMBERS.len();

impl Element {
    /// Adds a property from the words of its line.
    fn add(&mut self, types: &[&str], name: &str) -> Result<(), String> {
        let (counted, kind) = match types {
            ["list", counted, kind] => (Some(Kind::named(counted)?), Kind::named(kind)?),
            [kind] => (None, Kind::named(kind)?),
            _ => return Err(format!("{name} has no type; expected a type, or list and two types")),
        };
        let plain = name.strip_prefix("diffuse_").unwrap_or(name);
        let known = [("r", "red"), ("g", "green"), ("b", "blue")].into_iter().find(|(short, _)| *short == plain);
        let plain = known.map_or(plain, |(_, long)| long);
        let meaning = match &*self.name {
            "vertex" => NUMBERS.iter().position(|number| *number == plain),
            "face" | "tristrips" => matches!(name, "vertex_indices" | "vertex_index").then_some(CORNERS),
            _ => None,
        };
        let is_possible = match meaning {
            Some(CORNERS) => !matches!(kind, Kind::Real(_)),
            Some(COLORS..) => !matches!(kind, Kind::Signed(_) | Kind::Unsigned(4)),
            _ => true,
        };
        if !is_possible {
            let expected = "expected uchar, ushort or float colors, and whole vertex indices";
            return Err(format!("{name} has another type; {expected}"));
        }
        self.properties.push(Property { name: name.to_owned(), kind, counted, meaning });
        Ok(())
    }

    /// Reads an element, whose next number `next` returns.
    fn read<E>(&self, mut next: impl FnMut(&str, Kind) -> Result<f64, E>) -> Result<Values, E> {
        let mut values = Values::default();
        for Property { name, kind, counted, meaning } in &self.properties {
            let count = counted.map_or(Ok(1.0), |counted| next(name, counted))?;
            for _ in 0..count as usize {
                let number = next(name, *kind)?;
                match *meaning {
                    Some(CORNERS) => values.corners.push(number),
                    // The channels of a color are 0…1, or codes up to the largest one.
                    Some(at) => values.numbers[at] = Some(if at < COLORS { number } else { number / kind.full() }),
                    None => {}
                }
            }
        }
        Ok(values)
    }
}

/// Takes the first line, with the byte that ends it.
fn line_of<'a>(rest: &mut &'a [u8], end: u8) -> &'a [u8] {
    let length = rest.iter().position(|byte| *byte == end).map_or(rest.len(), |at| at + 1);
    rest.split_off(..length).unwrap_or_default()
}

/// What a header says so far.
#[derive(Default)]
struct Header {
    /// Once it is known: whether the numbers are binary, and then whether their high bytes come first.
    format: Option<Option<bool>>,
    elements: Vec<Element>,
}

impl Header {
    fn line(&mut self, line: &str) -> Result<(), String> {
        match line.split_ascii_whitespace().collect::<Vec<_>>()[..] {
            ["format", format @ ("ascii" | "binary_little_endian" | "binary_big_endian"), "1.0"] => {
                self.format = Some((format != "ascii").then_some(format == "binary_big_endian"));
            }
            ["element", name, count] => {
                let wrong = |_| format!("{:?} is not a number of elements; expected one", shortened(count));
                let count = count.parse().map_err(wrong)?;
                self.elements.push(Element { name: name.to_owned(), count, properties: Vec::new() });
            }
            ["property", ref types @ .., name] => {
                let none = "a property comes before the first element; expected an element first";
                self.elements.last_mut().ok_or(none)?.add(types, name)?;
            }
            ["ply"] | ["comment" | "obj_info", ..] | [] => {}
            _ => {
                return Err(format!(
                    "{:?} is not known; expected the header of a PLY file",
                    shortened(line.trim_end())
                ));
            }
        }
        Ok(())
    }
}

/// Reads the content of a PLY file; `file` identifies it in messages.
///
/// # Errors
/// Content that is not PLY, with its line where the file is text; coordinates that are not finite, vertices that do not
/// exist, and faces with too few corners.
pub(super) fn parse(file: &str, content: &[u8]) -> Result<Faces, FileErrors> {
    // A return alone ends a line, too.
    let end = if content.starts_with(b"ply\r") && !content.starts_with(b"ply\r\n") { b'\r' } else { b'\n' };
    let (mut header, mut rest, mut line) = (Header::default(), content, 1);
    loop {
        let text = String::from_utf8_lossy(line_of(&mut rest, end));
        if text.trim_end() == "end_header" {
            break;
        }
        header.line(&text).map_err(|message| FileErrors::at(file, (line, 1), message))?;
        if rest.is_empty() {
            return Err(FileErrors::whole(file, "its header does not end; expected a line end_header"));
        }
        line += 1;
    }
    let format = header.format.ok_or_else(|| FileErrors::whole(file, "its header says no format; expected one"))?;
    let mut mesh = Faces::default();
    for element in &header.elements {
        // Without properties, any number of elements needs no bytes.
        let (name, count) = (&element.name, if element.properties.is_empty() { 0 } else { element.count });
        for i in 0..count {
            let ended = || {
                let message = format!("ends within {name} {i} of {count}; expected as many as its header says");
                FileErrors::whole(file, message)
            };
            let values = match format {
                Some(is_big) => element.read(|_, kind| kind.of_bytes(&mut rest, is_big).ok_or_else(ended))?,
                None if rest.is_empty() => return Err(ended()),
                None => {
                    line += 1;
                    let text = String::from_utf8_lossy(line_of(&mut rest, end));
                    let mut words = text.split_ascii_whitespace();
                    let values = element.read(|name, kind| kind.of_word(name, words.next().unwrap_or_default()));
                    values.map_err(|message| FileErrors::at(file, (line, 1), message))?
                }
            };
            let added = match name.as_str() {
                "vertex" => vertex(&mut mesh, &values.numbers),
                "face" => face(&mut mesh, &values.corners),
                // −1 ends a strip.
                "tristrips" => values.corners.split(|index| *index == -1.0).try_for_each(|strip| {
                    strip_triangles(strip).iter().try_for_each(|triangle| polygon(&mut mesh, triangle))
                }),
                _ => Ok(()),
            };
            added.map_err(|message| FileErrors::whole(file, format!("{name} {i} {message}")))?;
        }
    }
    Ok(mesh)
}

fn vertex(mesh: &mut Faces, numbers: &[Option<f64>; CORNERS]) -> Result<(), String> {
    let three = |first: usize| match numbers[first..first + 3] {
        [Some(x), Some(y), Some(z)] => Some(DVec3::new(x, y, z)),
        _ => None,
    };
    let position = three(0).ok_or("has no position; expected x, y and z")?;
    // NaN does not count as within.
    if !position.to_array().iter().all(|x| x.abs() <= MAX_COORDINATE) {
        return Err("has a position that is not finite or is beyond ±1e30; expected finite numbers".to_owned());
    }
    mesh.polygons.normals.push(three(3).and_then(DVec3::try_normalize));
    mesh.position(position, three(COLORS));
    Ok(())
}

fn face(mesh: &mut Faces, list: &[f64]) -> Result<(), String> {
    if !(3..=MAX_CORNERS).contains(&list.len()) {
        return Err(format!("has {} corners; expected 3…{MAX_CORNERS}", list.len()));
    }
    polygon(mesh, list)
}

fn polygon(mesh: &mut Faces, list: &[f64]) -> Result<(), String> {
    let count = mesh.polygons.positions.len();
    if let Some(index) = list.iter().find(|index| !(**index >= 0.0 && **index < count as f64)) {
        return Err(match count {
            0 => "comes before the vertices; expected them first".to_owned(),
            _ => format!("refers to vertex {index}, which does not exist; expected 0…{}", count - 1),
        });
    }
    mesh.polygons.push(list.iter().map(|index| Corner::of(*index as u32)));
    Ok(())
}
