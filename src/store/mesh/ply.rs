//! Reads PLY files (Stanford polygon files), as text and in binary.
//!
//! The reader uses the positions, normals and colors of the vertices, and the faces or triangle strips. Colors are sRGB,
//! as scanners write them: codes, or numbers from 0 to 1, or from 0 to 255 if any is above 1. Other elements and properties
//! are ignored.

use std::io::ErrorKind;

use glam::DVec3;
use ply_rs_bw::{
    parser::{ParseError, Parser, Reader},
    ply::{ElementDef, Encoding, Property, PropertyAccess, PropertyAccessResult, PropertyType, ScalarType},
};

use super::faces::{Faces, Listed, MAX_CORNERS, strip_triangles};
use crate::{
    shading::mesh::MAX_COORDINATE,
    store::{FileError, FileErrors, table::shortened},
};

/// An element of any kind: the numbers that a vertex may have, and the list that a face may have.
#[derive(Default)]
struct Element {
    /// x, y, z, nx, ny, nz, red, green, blue.
    numbers: [Option<f64>; 9],
    corners: Option<Vec<i64>>,
}

const NUMBERS: [&str; 9] = ["x", "y", "z", "nx", "ny", "nz", "red", "green", "blue"];

/// The first of the numbers that are a color.
const COLORS: usize = 6;

/// Returns the place of a property in [`NUMBERS`].
fn place(name: &str) -> Option<usize> {
    let name = match name.strip_prefix("diffuse_").unwrap_or(name) {
        "r" => "red",
        "g" => "green",
        "b" => "blue",
        name => name,
    };
    NUMBERS.iter().position(|known| *known == name)
}

impl PropertyAccess for Element {
    fn new() -> Element {
        Element::default()
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        if matches!(name, "vertex_indices" | "vertex_index") {
            self.corners = match property {
                Property::ListChar(list) => Some(list.into_iter().map(i64::from).collect()),
                Property::ListUChar(list) => Some(list.into_iter().map(i64::from).collect()),
                Property::ListShort(list) => Some(list.into_iter().map(i64::from).collect()),
                Property::ListUShort(list) => Some(list.into_iter().map(i64::from).collect()),
                Property::ListInt(list) => Some(list.into_iter().map(i64::from).collect()),
                Property::ListUInt(list) => Some(list.into_iter().map(i64::from).collect()),
                _ => return PropertyAccessResult::UnsupportedType,
            };
            return PropertyAccessResult::Set;
        }
        let Some(at) = place(name) else { return PropertyAccessResult::Ignored };
        // The channels of a color are 0…1, or codes up to the largest one.
        let (number, full) = match property {
            Property::UChar(x) => (f64::from(x), 255.0),
            Property::UShort(x) => (f64::from(x), 65_535.0),
            Property::Float(x) => (f64::from(x), 1.0),
            Property::Double(x) => (x, 1.0),
            Property::Char(x) if at < COLORS => (f64::from(x), 1.0),
            Property::Short(x) if at < COLORS => (f64::from(x), 1.0),
            Property::Int(x) if at < COLORS => (f64::from(x), 1.0),
            Property::UInt(x) if at < COLORS => (f64::from(x), 1.0),
            _ => return PropertyAccessResult::UnsupportedType,
        };
        self.numbers[at] = Some(if at < COLORS { number } else { number / full });
        PropertyAccessResult::Set
    }
}

/// Reads an element from its line, in which space stands between the numbers: the crate's own reader refuses `nan`, `.5` and
/// `5.`.
///
/// # Errors
/// Says what is wrong.
fn of_line(line: &str, definition: &ElementDef) -> Result<Element, String> {
    let mut words = line.split_ascii_whitespace();
    let mut next = |name: &str, is_whole: bool| {
        let word = words.next().unwrap_or_default();
        let number = word.parse::<f64>().ok().filter(|number| !is_whole || number.fract() == 0.0);
        let expected = if is_whole { "a whole number" } else { "a number" };
        number.ok_or_else(|| format!("{name} is {:?}; expected {expected}", shortened(word)))
    };
    let is_real = |kind: &ScalarType| matches!(kind, ScalarType::Float | ScalarType::Double);
    let mut element = Element::new();
    for (name, property) in &definition.properties {
        let property = match &property.data_type {
            PropertyType::Scalar(kind) => {
                let number = next(name, !is_real(kind))?;
                let most = if *kind == ScalarType::UChar { 255.0 } else { 65_535.0 };
                if matches!(kind, ScalarType::UChar | ScalarType::UShort) && !(0.0..=most).contains(&number) {
                    return Err(format!("{name} is {number}; expected 0…{most}"));
                }
                match kind {
                    ScalarType::UChar => Property::UChar(number as u8),
                    ScalarType::UShort => Property::UShort(number as u16),
                    ScalarType::Float | ScalarType::Double => Property::Double(number),
                    _ => Property::Int(number as i32),
                }
            }
            PropertyType::List(_, kind) => {
                let count = next(name, true)? as usize;
                let list = (0..count).map(|_| next(name, !is_real(kind))).collect::<Result<Vec<f64>, _>>()?;
                if is_real(kind) {
                    Property::ListDouble(list)
                } else {
                    Property::ListInt(list.into_iter().map(|number| number as i32).collect())
                }
            }
        };
        if matches!(element.set_property(name, property), PropertyAccessResult::UnsupportedType) {
            return Err(format!(
                "{name} has another type; expected uchar, ushort or float colors, and whole vertex indices"
            ));
        }
    }
    Ok(element)
}

/// Takes the first line, with the byte that ends it.
fn line_of<'a>(rest: &mut &'a [u8], end: u8) -> &'a [u8] {
    let length = rest.iter().position(|byte| *byte == end).map_or(rest.len(), |at| at + 1);
    rest.split_off(..length).unwrap_or_default()
}

/// Reads the content of a PLY file; `file` identifies it in messages.
///
/// # Errors
/// Content that is not PLY, with its line where the file is text; coordinates that are not finite, vertices that do not
/// exist, and faces with too few corners.
pub(super) fn parse(file: &str, content: &[u8]) -> Result<Faces, FileErrors> {
    let at = |line: Option<usize>, error: ParseError| {
        // The first line of the crate's text, without the number of the line, which comes before it.
        let text = error.to_string();
        let text = text.lines().next().unwrap_or_default();
        let text = text.strip_prefix("Line ").and_then(|rest| rest.split_once(": ")).map_or(text, |(_, rest)| rest);
        let message = format!("{}; expected a PLY file", text.trim_end_matches(['.', ':']));
        FileErrors(vec![match line {
            Some(line) => FileError::at(file, (line.max(1), 1), message),
            None => FileError::whole(file, message),
        }])
    };
    // A return alone ends a line, too.
    let end = if content.starts_with(b"ply\r") && !content.starts_with(b"ply\r\n") { b'\r' } else { b'\n' };
    let (mut header, mut rest) = (String::new(), content);
    while !rest.is_empty() && !header.ends_with("\nend_header\n") {
        let own = String::from_utf8_lossy(line_of(&mut rest, end));
        // The crate's own reader wants single spaces.
        header += &own.split_whitespace().collect::<Vec<_>>().join(" ");
        header.push('\n');
    }
    let (parser, mut reader) = (Parser::<Element>::new(), Reader::new(header.as_bytes()));
    let header = parser.read_header(&mut reader).map_err(|error| at(error.line(), error))?;
    let mut line = reader.line();
    let mut mesh = Listed::default();
    // One element after the other: an element needs much more memory than what it becomes.
    for (name, definition) in &header.elements {
        // Without properties, any number of elements needs no bytes.
        let count = if definition.properties.is_empty() { 0 } else { definition.count };
        for i in 0..count {
            let ended = || {
                let message = format!("ends within {name} {i} of {count}; expected as many as its header says");
                FileErrors::whole(file, message)
            };
            let wrong = |error: ParseError| match error.kind() {
                ErrorKind::UnexpectedEof => ended(),
                _ => at(None, error),
            };
            let element = match header.encoding {
                Encoding::Ascii if rest.is_empty() => return Err(ended()),
                Encoding::Ascii => {
                    let element = of_line(&String::from_utf8_lossy(line_of(&mut rest, end)), definition)
                        .map_err(|message| FileErrors::at(file, (line, 1), message))?;
                    line += 1;
                    element
                }
                Encoding::BinaryLittleEndian => {
                    parser.read_little_endian_element(&mut rest, definition).map_err(wrong)?
                }
                Encoding::BinaryBigEndian => parser.read_big_endian_element(&mut rest, definition).map_err(wrong)?,
            };
            let wrong = |message| FileErrors::whole(file, format!("{name} {i} {message}"));
            match name.as_str() {
                "vertex" => vertex(&mut mesh, &element).map_err(wrong)?,
                "face" => face(&mut mesh, &element.corners.unwrap_or_default()).map_err(wrong)?,
                // −1 ends a strip.
                "tristrips" => element.corners.unwrap_or_default().split(|index| *index == -1).try_for_each(|strip| {
                    strip_triangles(strip).iter().try_for_each(|triangle| polygon(&mut mesh, triangle)).map_err(wrong)
                })?,
                _ => {}
            }
        }
    }
    Ok(mesh.faces())
}

fn vertex(mesh: &mut Listed, Element { numbers, .. }: &Element) -> Result<(), String> {
    let three = |first: usize| match numbers[first..first + 3] {
        [Some(x), Some(y), Some(z)] => Some(DVec3::new(x, y, z)),
        _ => None,
    };
    let position = three(0).ok_or("has no position; expected x, y and z")?;
    // NaN does not count as within.
    if !position.to_array().iter().all(|x| x.abs() <= MAX_COORDINATE) {
        return Err("has a position that is not finite or is beyond ±1e30; expected finite numbers".to_owned());
    }
    mesh.normals.push(three(3).and_then(DVec3::try_normalize));
    mesh.vertex(position, three(COLORS));
    Ok(())
}

fn face(mesh: &mut Listed, list: &[i64]) -> Result<(), String> {
    if !(3..=MAX_CORNERS).contains(&list.len()) {
        return Err(format!("has {} corners; expected 3…{MAX_CORNERS}", list.len()));
    }
    polygon(mesh, list)
}

fn polygon(mesh: &mut Listed, list: &[i64]) -> Result<(), String> {
    for index in list {
        let vertex = usize::try_from(*index).ok().filter(|vertex| *vertex < mesh.vertices.len());
        let vertex = vertex.ok_or_else(|| match mesh.vertices.len() {
            0 => "comes before the vertices; expected them first".to_owned(),
            count => format!("refers to vertex {index}, which does not exist; expected 0…{}", count - 1),
        })?;
        mesh.corners.push((vertex, Some(vertex)));
    }
    mesh.ends.push(mesh.corners.len());
    Ok(())
}
