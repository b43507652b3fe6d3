//! Reads an OBJ file line by line into polygons; every fault has its place.

use std::collections::HashMap;

use glam::DVec3;

use crate::{
    shading::{Polygons, mesh::LARGEST_COORDINATE},
    store::{FileFault, FileFaults},
};

/// Most corners of a face: cutting it into triangles takes their square.
const MOST_CORNERS: usize = 4096;

/// Most faults reported of one file.
const MOST_FAULTS: usize = 20;

/// The distinct positions in the order in which faces use them, and the faces.
///
/// # Errors
/// The first faults, each with its line and column.
pub(super) fn polygons(file: &str, content: &[u8]) -> Result<(Vec<DVec3>, Polygons), FileFaults> {
    let mut reader = Reader { file, ..Reader::default() };
    reader.lines(content);
    // After an early end, what faces name could have followed.
    if reader.faults.len() < MOST_FAULTS {
        reader.check_indices();
        reader.faults.sort_by_key(|fault| fault.position);
    }
    if reader.faults.is_empty() { Ok(reader.polygons()) } else { Err(FileFaults(reader.faults)) }
}

/// Line and column, from 1.
type Position = (usize, usize);

/// What is wrong, and where.
type Fault = (Position, String);

#[derive(Default)]
struct Reader<'a> {
    file: &'a str,
    vertices: Vec<DVec3>,
    /// `None` for one that is zero or not finite.
    normals: Vec<Option<DVec3>>,
    /// The corners of all faces, each with its vertex and its normal, from 0.
    corners: Vec<(usize, Option<usize>)>,
    /// Where each face ends in `corners`.
    ends: Vec<usize>,
    /// The highest vertex and the highest normal, from 1, that a face names before it exists.
    ahead: [Option<(usize, Position)>; 2],
    faults: Vec<FileFault>,
}

/// What an index counts.
const COUNTED: [&str; 2] = ["vertex", "normal"];

impl Reader<'_> {
    fn lines(&mut self, content: &[u8]) {
        // A byte order mark.
        let content = content.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(content);
        let end = if content.contains(&b'\n') { b'\n' } else { b'\r' };
        let mut lines = content.split(|byte| *byte == end).zip(1..);
        while let Some((line, number)) = lines.next() {
            if line.contains(&0) {
                // Nothing else about it is of use.
                self.faults.clear();
                self.fault(((number, 1), "is not text; expected an OBJ file".to_owned()));
                return;
            }
            // A backslash at its end continues a line.
            let mut joined = Vec::new();
            let mut next = line;
            while let Some(begun) = next.trim_ascii_end().strip_suffix(b"\\") {
                joined.extend_from_slice(begun);
                joined.push(b' ');
                next = lines.next().map_or(&[][..], |(line, _)| line);
            }
            let read = if joined.is_empty() {
                self.line(number, line)
            } else {
                joined.extend_from_slice(next);
                self.line(number, &joined)
            };
            if let Err(fault) = read {
                self.fault(fault);
            }
            if self.faults.len() >= MOST_FAULTS {
                return;
            }
        }
    }

    fn fault(&mut self, (position, message): Fault) {
        self.faults.push(FileFault { file: self.file.to_owned(), position: Some(position), message });
    }

    fn line(&mut self, number: usize, line: &[u8]) -> Result<(), Fault> {
        let keyword = line.trim_ascii_start().split(u8::is_ascii_whitespace).next().unwrap_or_default();
        if !matches!(keyword, b"v" | b"vn" | b"f") {
            return Ok(());
        }
        let text = std::str::from_utf8(line).map_err(|error| {
            let column = String::from_utf8_lossy(&line[..error.valid_up_to()]).chars().count() + 1;
            ((number, column), "is not UTF-8 text; expected numbers".to_owned())
        })?;
        let statement = Statement { number, text };
        // A comment may follow.
        let words = text.split_ascii_whitespace().skip(1).take_while(|word| !word.starts_with('#'));
        let words: Vec<&str> = words.take(MOST_CORNERS + 1).collect();
        match keyword {
            b"v" => {
                let vertex = statement.vertex(&words);
                // Counted even if wrong, so that the indices after it stay right.
                self.vertices.push(*vertex.as_ref().unwrap_or(&DVec3::ZERO));
                vertex.map(drop)
            }
            b"vn" => {
                let normal = statement.three_numbers(&words);
                self.normals.push(normal.as_ref().ok().and_then(|normal| normal.try_normalize()));
                normal.map(drop)
            }
            _ => self.face(&statement, &words),
        }
    }

    fn face(&mut self, statement: &Statement<'_>, words: &[&str]) -> Result<(), Fault> {
        if !(3..=MOST_CORNERS).contains(&words.len()) {
            let more = if words.len() > MOST_CORNERS { "or more " } else { "" };
            let message = format!("a face has {} {more}corners; expected 3…{MOST_CORNERS}", words.len());
            return Err((statement.position(statement.text.trim_ascii_start()), message));
        }
        for word in words {
            let mut parts = word.split('/');
            let vertex = self.index(statement, word, 0, parts.next().unwrap_or_default())?;
            let texture = parts.next().unwrap_or_default();
            let normal = parts.next().filter(|normal| !normal.is_empty());
            if parts.next().is_some() || !(texture.is_empty() || texture.parse::<i64>().is_ok()) {
                return Err(statement.not_a_corner(word));
            }
            let normal = normal.map(|normal| self.index(statement, word, 1, normal)).transpose()?;
            self.corners.push((vertex, normal));
        }
        self.ends.push(self.corners.len());
        Ok(())
    }

    /// The index, from 0, that `text`, a part of `word`, means.
    fn index(&mut self, statement: &Statement<'_>, word: &str, kind: usize, text: &str) -> Result<usize, Fault> {
        let given: i64 = text.parse().map_err(|_| statement.not_a_corner(word))?;
        let (count, name) = ([self.vertices.len(), self.normals.len()][kind], COUNTED[kind]);
        let fail = |message: String| Err((statement.position(word), format!("{name} {given} does not exist{message}")));
        // Indices count from 1, or back from -1.
        let found = usize::try_from(given.unsigned_abs()).unwrap_or(usize::MAX);
        match given {
            0 => fail("; expected an index from 1, or -1 for the last".to_owned()),
            ..0 if found > count => fail(format!(", there are {count} above; expected -1 for the last, or 1…")),
            ..0 => Ok(count - found),
            _ => {
                // The file may give it further down.
                if found > count && self.ahead[kind].is_none_or(|(highest, _)| found > highest) {
                    self.ahead[kind] = Some((found, statement.position(word)));
                }
                Ok(found - 1)
            }
        }
    }

    fn check_indices(&mut self) {
        for (kind, count) in [self.vertices.len(), self.normals.len()].into_iter().enumerate() {
            let Some((index, position)) = self.ahead[kind].filter(|(index, _)| *index > count) else { continue };
            let name = COUNTED[kind];
            let message = match (kind, count) {
                (1, 0) => format!("normal {index} does not exist, the file has none; expected a corner without one"),
                _ => format!("{name} {index} does not exist; expected 1…{count}"),
            };
            self.fault((position, message));
        }
    }

    /// Vertices in exactly one position are one.
    fn polygons(self) -> (Vec<DVec3>, Polygons) {
        let mut positions = Vec::new();
        let mut sites = HashMap::new();
        let mut polygons = Polygons::default();
        let mut start = 0;
        for end in self.ends {
            polygons.push(self.corners[start..end].iter().map(|(vertex, normal)| {
                // −0 is 0.
                let position = self.vertices[*vertex] + DVec3::ZERO;
                let site = *sites.entry(position.to_array().map(f64::to_bits)).or_insert_with(|| {
                    positions.push(position);
                    (positions.len() - 1) as u32
                });
                (site, normal.and_then(|normal| self.normals[normal]))
            }));
            start = end;
        }
        (positions, polygons)
    }
}

/// One statement.
struct Statement<'a> {
    number: usize,
    text: &'a str,
}

impl Statement<'_> {
    /// Where `word`, a part of the text, begins.
    fn position(&self, word: &str) -> Position {
        let offset = (word.as_ptr() as usize).saturating_sub(self.text.as_ptr() as usize);
        (self.number, self.text.get(..offset).unwrap_or_default().chars().count() + 1)
    }

    /// `x y z`, `x y z w` or `x y z red green blue`.
    fn vertex(&self, words: &[&str]) -> Result<DVec3, Fault> {
        let mut vertex = self.three_numbers(words)?;
        if let [_, _, _, weight] = words {
            let w = self.number(weight)?;
            if w == 0.0 || !w.is_finite() {
                let message = format!("{} is not a weight; expected a finite number that is not 0", shown(weight));
                return Err((self.position(weight), message));
            }
            vertex /= w;
        }
        match vertex.to_array().iter().position(|x| x.is_nan() || x.abs() > LARGEST_COORDINATE) {
            Some(k) => Err((
                self.position(words[k]),
                format!("{} is not a finite coordinate; expected one within ±1e30", shown(words[k])),
            )),
            None => Ok(vertex),
        }
    }

    fn three_numbers(&self, words: &[&str]) -> Result<DVec3, Fault> {
        let [x, y, z, ..] = words else {
            let start = self.position(self.text.trim_ascii_start());
            return Err((start, format!("has {} numbers; expected three", words.len())));
        };
        Ok(DVec3::new(self.number(x)?, self.number(y)?, self.number(z)?))
    }

    fn number(&self, word: &str) -> Result<f64, Fault> {
        word.parse().map_err(|_| (self.position(word), format!("{} is not a number; expected one", shown(word))))
    }

    fn not_a_corner(&self, word: &str) -> Fault {
        let message = format!("{} is not a corner of a face; expected 1, 1/1, 1//1 or 1/1/1", shown(word));
        (self.position(word), message)
    }
}

/// A word as a message shows it.
fn shown(word: &str) -> String {
    if word.chars().count() > 30 {
        format!("{:?}…", word.chars().take(30).collect::<String>())
    } else {
        format!("{word:?}")
    }
}
