//! Reads PLY files (Stanford polygon files), as text and in binary.
//!
//! The reader uses the positions, normals and colors of the vertices, and the faces. Colors are sRGB, as scanners write
//! them. Other elements and properties are ignored.

use glam::DVec3;
use ply_rs_bw::{
    parser::{ParseError, Parser, Reader},
    ply::{Property, PropertyAccess, PropertyAccessResult},
};

use super::faces::{Faces, MAX_CORNERS};
use crate::{
    light::Transfer,
    shading::{PaintedCorner, mesh::MAX_COORDINATE},
    store::{FileError, FileErrors},
};

/// An element of any kind: the numbers that a vertex may have, and the list that a face may have.
#[derive(Default)]
struct Element {
    /// x, y, z, nx, ny, nz, red, green, blue.
    numbers: [Option<f64>; 9],
    corners: Option<Vec<i64>>,
}

const NUMBERS: [&str; 9] = ["x", "y", "z", "nx", "ny", "nz", "red", "green", "blue"];

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
        let name = name.strip_prefix("diffuse_").unwrap_or(name);
        let Some(at) = NUMBERS.iter().position(|known| *known == name) else { return PropertyAccessResult::Ignored };
        let number = match property {
            Property::Char(x) => f64::from(x),
            Property::UChar(x) => f64::from(x),
            Property::Short(x) => f64::from(x),
            Property::UShort(x) => f64::from(x),
            Property::Int(x) => f64::from(x),
            Property::UInt(x) => f64::from(x),
            Property::Float(x) => f64::from(x),
            Property::Double(x) => x,
            _ => return PropertyAccessResult::UnsupportedType,
        };
        // The channels of a color are 0…1, or codes.
        let full = match property {
            _ if at < 6 => 1.0,
            Property::UChar(_) => 255.0,
            Property::UShort(_) => 65_535.0,
            Property::Float(_) | Property::Double(_) => 1.0,
            _ => return PropertyAccessResult::UnsupportedType,
        };
        self.numbers[at] = Some(number / full);
        PropertyAccessResult::Set
    }
}

/// Reads the content of a PLY file; `file` identifies it in messages.
///
/// # Errors
/// Content that is not PLY, with its line where the file is text; coordinates that are not finite, vertices that do not
/// exist, and faces with too few corners.
pub(super) fn parse(file: &str, content: &[u8]) -> Result<Faces, FileErrors> {
    let at = |error: ParseError| {
        // The first line of the crate's text, without the number of the line, which comes before it.
        let text = error.to_string();
        let text = text.lines().next().unwrap_or_default();
        let text = text.strip_prefix("Line ").and_then(|rest| rest.split_once(": ")).map_or(text, |(_, rest)| rest);
        let message = format!("{}; expected a PLY file", text.trim_end_matches(['.', ':']));
        FileErrors(vec![match error.line() {
            Some(line) => FileError::at(file, (line.max(1), 1), message),
            None => FileError::whole(file, message),
        }])
    };
    let (parser, mut reader) = (Parser::<Element>::new(), Reader::new(content));
    let header = parser.read_header(&mut reader).map_err(at)?;
    let mut elements = parser.read_payload(&mut reader, &header).map_err(at)?;
    let mut of = |name: &str| elements.shift_remove(name).unwrap_or_default();
    let (vertices, triangles) = (of("vertex"), of("face"));
    let whole = |message: String| FileErrors::whole(file, message);

    let mut faces = Faces::default();
    let mut corners = Vec::with_capacity(vertices.len());
    for (i, Element { numbers, .. }) in vertices.iter().enumerate() {
        let three = |first: usize| match numbers[first..first + 3] {
            [Some(x), Some(y), Some(z)] => Some(DVec3::new(x, y, z)),
            _ => None,
        };
        let position = three(0).ok_or_else(|| whole(format!("vertex {i} has no position; expected x, y and z")))?;
        // NaN does not count as within.
        if !position.to_array().iter().all(|x| x.abs() <= MAX_COORDINATE) {
            let message =
                format!("the position of vertex {i} is not finite or is beyond ±1e30; expected finite numbers");
            return Err(whole(message));
        }
        let linear = |color: DVec3| {
            let channel = |code: f64| Transfer::Srgb.linear_from_encoded(if code > 0.0 { code.min(1.0) } else { 0.0 });
            DVec3::from_array(color.to_array().map(channel))
        };
        let paint = PaintedCorner { color: three(6).map_or(DVec3::ONE, linear), ..PaintedCorner::default() };
        corners.push((faces.site(position), three(3).and_then(DVec3::try_normalize), paint));
    }
    for (i, Element { corners: list, .. }) in triangles.iter().enumerate() {
        let list = list.as_deref().unwrap_or_default();
        if !(3..=MAX_CORNERS).contains(&list.len()) {
            return Err(whole(format!("face {i} has {} corners; expected 3…{MAX_CORNERS}", list.len())));
        }
        let mut of_face = Vec::with_capacity(list.len());
        for index in list {
            let corner = usize::try_from(*index).ok().and_then(|index| corners.get(index));
            of_face.push(*corner.ok_or_else(|| {
                let most = corners.len().saturating_sub(1);
                whole(format!("face {i} refers to vertex {index}, which does not exist; expected 0…{most}"))
            })?);
        }
        faces.polygons.push_painted(of_face, 0);
    }
    faces.polygons.coats.push(Default::default());
    Ok(faces)
}
