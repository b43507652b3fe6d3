//! Reads Wavefront OBJ files.
//!
//! The reader supports vertices (`v`), also with colors (`v x y z red green blue`, sRGB from 0 to 1, as in PLY files, or
//! from 0 to 255 if any is above 1), normals (`vn`) and faces (`f`) with any number of corners, with positive and relative
//! indices. All objects and groups form one mesh. Everything else (texture coordinates, lines, materials, smoothing groups, curved surfaces) is ignored.

use std::borrow::Cow;

use glam::DVec3;

use super::faces::{Faces, MAX_CORNERS};
use crate::{
    shading::mesh::{Corner, MAX_COORDINATE},
    store::{FileErrors, table::shortened},
};

/// Reads the content of an OBJ file; `file` identifies it in messages.
///
/// # Errors
/// Reports the first error, with its line and column: content that is not text, numbers or indices that cannot be
/// read, coordinates that are not finite, vertices and normals that do not exist, and faces with too few corners.
pub(super) fn parse(file: &str, content: &[u8]) -> Result<Faces, FileErrors> {
    // A byte order mark is not part of the first line.
    let content = content.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(content);
    let end = if content.contains(&b'\n') { b'\n' } else { b'\r' };
    let mut lines: Vec<(usize, Cow<'_, [u8]>)> = Vec::new();
    for (number, line) in (1..).zip(content.split(|byte| *byte == end)) {
        match lines.last_mut() {
            Some((_, before)) if is_continued(before) => {
                let start = before.trim_ascii_end().len() - 1;
                before.to_mut().splice(start.., line.iter().copied());
            }
            _ => lines.push((number, line.into())),
        }
    }
    if let Some((number, _)) = lines.iter().find(|(_, line)| line.contains(&0)) {
        return Err(FileErrors::at(file, (*number, 1), "is not text; expected an OBJ file"));
    }
    let count = |wanted: &[u8]| lines.iter().filter(|(_, line)| keyword(line) == wanted).count();
    let mut reader = Reader { counts: [count(b"v"), count(b"vn")], ..Reader::default() };
    lines.iter().try_for_each(|(number, line)| reader.line(file, *number, line))?;
    Ok(reader.faces)
}

/// Returns whether the statement of a line that is read continues in the next line; a comment does not.
fn is_continued(line: &[u8]) -> bool {
    is_read(keyword(line)) && line.trim_ascii_end().ends_with(b" \\") && !line.contains(&b'#')
}

fn is_read(keyword: &[u8]) -> bool {
    matches!(keyword, b"v" | b"vn" | b"f")
}

fn keyword(line: &[u8]) -> &[u8] {
    line.trim_ascii_start().split(u8::is_ascii_whitespace).next().unwrap_or_default()
}

#[derive(Default)]
struct Reader {
    /// Number of vertices and normals in the whole file, because a face may come before the vertices and normals it
    /// uses.
    counts: [usize; 2],
    faces: Faces,
}

impl Reader {
    fn line(&mut self, file: &str, number: usize, line: &[u8]) -> Result<(), FileErrors> {
        let keyword = keyword(line);
        if !is_read(keyword) {
            return Ok(());
        }
        let text = std::str::from_utf8(line).map_err(|error| {
            let column = String::from_utf8_lossy(&line[..error.valid_up_to()]).chars().count() + 1;
            FileErrors::at(file, (number, column), "is not UTF-8 text; expected numbers")
        })?;
        // A comment may follow the numbers.
        let words = text.split_ascii_whitespace().skip(1);
        let words = words.take_while(|word| !word.starts_with('#'));
        let words: Vec<&str> = words.take(MAX_CORNERS + 1).collect();
        let read = match keyword {
            b"v" => self.vertex(text, &words),
            b"vn" => three_numbers(text, &words).map(|normal| {
                self.faces.polygons.normals.push(normal.try_normalize());
                if normal.try_normalize().is_none() {
                    self.faces.ignored.insert("normals that are zero or not finite were estimated");
                }
            }),
            _ => self.face(text, &words),
        };
        read.map_err(|(word, message)| {
            let offset = (word.as_ptr() as usize).saturating_sub(text.as_ptr() as usize);
            let column = text.get(..offset).unwrap_or_default().chars().count() + 1;
            FileErrors::at(file, (number, column), message)
        })
    }

    /// Reads `x y z`, perhaps followed by a weight, which only curves use, or a color.
    fn vertex<'a>(&mut self, text: &'a str, words: &[&'a str]) -> Result<(), Fault<'a>> {
        let vertex = three_numbers(text, words)?;
        if let Some((_, word)) =
            vertex.to_array().iter().zip(words).find(|(x, _)| x.is_nan() || x.abs() > MAX_COORDINATE)
        {
            let what = "is not finite or is beyond ±1e30; expected a finite coordinate";
            return Err((word, format!("{:?} {what}", shortened(word))));
        }
        let color = words.get(3..).filter(|color| color.len() >= 3);
        self.faces.position(vertex, color.map(|color| three_numbers(text, color)).transpose()?);
        Ok(())
    }

    fn face<'a>(&mut self, text: &'a str, words: &[&'a str]) -> Result<(), Fault<'a>> {
        if !(3..=MAX_CORNERS).contains(&words.len()) {
            let more = if words.len() > MAX_CORNERS { " or more" } else { "" };
            let message = format!("the number of corners is {}{more}; expected 3…{MAX_CORNERS}", words.len());
            return Err((text.trim_ascii_start(), message));
        }
        for &word in words {
            let mut parts = word.split('/');
            let vertex = self.index(word, 0, parts.next().unwrap_or_default())?;
            let texture = parts.next().unwrap_or_default();
            let normal = parts.next().filter(|normal| !normal.is_empty());
            if parts.next().is_some() || !(texture.is_empty() || texture.parse::<i64>().is_ok()) {
                return Err(not_a_corner(word));
            }
            let normal = match normal {
                Some(index) if self.counts[1] == 0 && index.parse::<i64>().is_ok() => {
                    self.faces.ignored.insert("normals were ignored that faces name but the file does not have");
                    None
                }
                normal => normal.map(|normal| self.index(word, 1, normal)).transpose()?,
            };
            self.faces.polygons.corners.push(Corner { normal, ..Corner::of(vertex) });
        }
        self.faces.polygons.push([]);
        Ok(())
    }

    /// Returns the index, counted from 0, that `text` refers to. `text` is a part of `word`.
    fn index<'a>(&self, word: &'a str, kind: usize, text: &str) -> Result<u32, Fault<'a>> {
        let given: i64 = text.parse().map_err(|_| not_a_corner(word))?;
        let (above, count) =
            ([self.faces.polygons.positions.len(), self.faces.polygons.normals.len()][kind], self.counts[kind]);
        // Indices count up from 1, or back from -1.
        let found = usize::try_from(given.unsigned_abs()).unwrap_or(usize::MAX);
        let problem = match given {
            0 => "; expected an index from 1, or -1 for the last one".to_owned(),
            ..0 if found <= above => return Ok((above - found) as u32),
            ..0 => format!(" ({above} so far); expected -1 for the last one, or an index from 1"),
            _ if found <= count => return Ok((found - 1) as u32),
            _ => format!("; expected 1…{count}"),
        };
        let name = ["vertex", "normal"][kind];
        Err((word, format!("{name} {given} does not exist{problem}")))
    }
}

/// A word of a line, and what is wrong with it.
type Fault<'a> = (&'a str, String);

fn three_numbers<'a>(text: &'a str, words: &[&'a str]) -> Result<DVec3, Fault<'a>> {
    let [x, y, z, ..] = words else {
        let message = format!("the line has too few numbers ({}); expected three", words.len());
        return Err((text.trim_ascii_start(), message));
    };
    let number = |word: &&'a str| {
        let wrong = |_| (*word, format!("{:?} is not a number; expected one", shortened(word)));
        word.parse().map_err(wrong)
    };
    Ok(DVec3::new(number(x)?, number(y)?, number(z)?))
}

fn not_a_corner(word: &str) -> Fault<'_> {
    (word, format!("{:?} is not a corner of a face; expected 1, 1/1, 1//1 or 1/1/1", shortened(word)))
}
