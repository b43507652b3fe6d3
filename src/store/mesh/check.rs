//! Looks at an OBJ file line by line before it is parsed: says where a fault is, and keeps what makes the mesh.

use std::fmt::Write as _;

use glam::DVec3;

use crate::{
    shading::mesh::LARGEST_COORDINATE,
    store::{FileFault, FileFaults},
};

/// Most corners of a face: cutting it into triangles takes their square.
const MOST_CORNERS: usize = 4096;

/// Most faults told of one file.
const MOST_FAULTS: usize = 20;

/// The places, normals and faces of `content`, one statement a line, all indices counted from 1. Normal 1 is (0, 0, 0)
/// and stands for none.
///
/// # Errors
/// The first faults, each with its line and column.
pub(super) fn checked(file: &str, content: &[u8]) -> Result<String, FileFaults> {
    Checker::new(file).check(content)
}

/// Line and column, from 1.
type Position = (usize, usize);

struct Checker<'a> {
    file: &'a str,
    /// Places, normals and faces only, by indices from 1; normal 1 stands for none.
    clean: String,
    places: i64,
    normals: i64,
    /// The place or normal with the highest index that a face names before it exists.
    ahead: [Option<(i64, Position)>; 2],
    faults: Vec<FileFault>,
}

/// What an index counts.
const COUNTED: [&str; 2] = ["place", "normal"];

impl<'a> Checker<'a> {
    fn new(file: &'a str) -> Self {
        Checker { file, clean: "vn 0 0 0\n".to_owned(), places: 0, normals: 0, ahead: [None; 2], faults: Vec::new() }
    }

    fn check(mut self, content: &[u8]) -> Result<String, FileFaults> {
        // A byte order mark.
        let content = content.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(content);
        let end = if content.contains(&b'\n') { b'\n' } else { b'\r' };
        let mut lines = content.split(|byte| *byte == end).enumerate();
        while let Some((number, line)) = lines.next() {
            if line.contains(&0) {
                // Nothing else about it is of use.
                self.faults.clear();
                self.fault((number + 1, 1), "is not text; expected an OBJ file".to_owned());
                return Err(FileFaults(self.faults));
            }
            // A line may go on after a backslash.
            let mut joined = Vec::new();
            let mut next = line;
            while let Some(begun) = next.trim_ascii_end().strip_suffix(b"\\") {
                joined.extend_from_slice(begun);
                joined.push(b' ');
                next = lines.next().map_or(&[][..], |(_, line)| line);
            }
            if joined.is_empty() {
                self.line(number + 1, line);
            } else {
                joined.extend_from_slice(next);
                self.line(number + 1, &joined);
            }
            if self.faults.len() >= MOST_FAULTS {
                break;
            }
        }
        // Had it been broken off, what they name could follow.
        if self.faults.len() < MOST_FAULTS {
            for (kind, count) in [self.places, self.normals].into_iter().enumerate() {
                if let Some((index, position)) = self.ahead[kind]
                    && index > count
                {
                    self.no_such(kind, index, count, position);
                }
            }
            self.faults.sort_by_key(|fault| fault.position);
        }
        if self.faults.is_empty() { Ok(self.clean) } else { Err(FileFaults(self.faults)) }
    }

    fn fault(&mut self, position: Position, message: String) {
        self.faults.push(FileFault { file: self.file.to_owned(), position: Some(position), message });
    }

    fn no_such(&mut self, kind: usize, index: i64, count: i64, position: Position) {
        let name = COUNTED[kind];
        let message = if count == 0 {
            format!("{name} {index} does not exist, the file has no {name}s; expected a corner without one")
        } else {
            format!("{name} {index} does not exist; expected 1…{count}")
        };
        self.fault(position, message);
    }

    fn line(&mut self, number: usize, line: &[u8]) {
        let keyword = line.trim_ascii_start().split(u8::is_ascii_whitespace).next().unwrap_or_default();
        if !matches!(keyword, b"v" | b"vn" | b"f") {
            return;
        }
        let text = match std::str::from_utf8(line) {
            Ok(text) => text,
            Err(error) => {
                let column = String::from_utf8_lossy(&line[..error.valid_up_to()]).chars().count() + 1;
                self.fault((number, column), "is not UTF-8 text; expected numbers".to_owned());
                return;
            }
        };
        let statement = Statement { number, text };
        // A comment may follow.
        let words: Vec<&str> = text
            .split_ascii_whitespace()
            .skip(1)
            .take_while(|word| !word.starts_with('#'))
            .take(MOST_CORNERS + 1)
            .collect();
        let outcome = match keyword {
            b"v" => self.place(&statement, &words),
            b"vn" => self.normal(&statement, &words),
            _ => self.face(&statement, &words),
        };
        if let Err((position, message)) = outcome {
            self.fault(position, message);
        }
    }

    fn place(&mut self, statement: &Statement, words: &[&str]) -> Result<(), (Position, String)> {
        // Counted even if wrong: the indices after it stay right.
        self.places += 1;
        let mut place = statement.three_numbers(words)?;
        // x y z w, or x y z red green blue.
        let kept = if let [_, _, _, weight] = words {
            let w = statement.number(weight)?;
            if w == 0.0 || !w.is_finite() {
                let message = format!("{} is no weight; expected a finite number that is not 0", shown(weight));
                return Err((statement.position(weight), message));
            }
            place = place.map(|x| x / w);
            4
        } else {
            3
        };
        if let Some(k) = place.iter().position(|x| x.is_nan() || x.abs() > LARGEST_COORDINATE) {
            return Err((
                statement.position(words[k]),
                format!("{} is not a finite coordinate; expected one within ±1e30", shown(words[k])),
            ));
        }
        self.keep("v", words.iter().take(kept));
        Ok(())
    }

    fn normal(&mut self, statement: &Statement, words: &[&str]) -> Result<(), (Position, String)> {
        self.normals += 1;
        let normal = DVec3::from_array(statement.three_numbers(words)?);
        if normal.try_normalize().is_some() {
            self.keep("vn", words.iter().take(3));
        } else {
            self.keep("vn", ["0"; 3].iter());
        }
        Ok(())
    }

    fn keep<'w>(&mut self, keyword: &str, words: impl Iterator<Item = &'w &'w str>) {
        self.clean.push_str(keyword);
        for word in words {
            self.clean.push(' ');
            self.clean.push_str(word);
        }
        self.clean.push('\n');
    }

    fn face(&mut self, statement: &Statement, words: &[&str]) -> Result<(), (Position, String)> {
        if !(3..=MOST_CORNERS).contains(&words.len()) {
            let more = if words.len() > MOST_CORNERS { "or more " } else { "" };
            let message = format!("a face has {} {more}corners; expected 3…{MOST_CORNERS}", words.len());
            return Err((statement.start(), message));
        }
        self.clean.push('f');
        for word in words {
            let mut parts = word.split('/');
            let place = self.index(statement, word, 0, parts.next().unwrap_or_default())?;
            let texture = parts.next().unwrap_or_default();
            let normal = parts.next().unwrap_or_default();
            if parts.next().is_some() || !(texture.is_empty() || texture.parse::<i64>().is_ok()) {
                return Err(statement.no_corner(word));
            }
            // Normal 1 is none, so theirs follow.
            let normal = if normal.is_empty() { 1 } else { self.index(statement, word, 1, normal)?.saturating_add(1) };
            // Writing to a string cannot fail.
            let _ = write!(self.clean, " {place}//{normal}");
        }
        self.clean.push('\n');
        Ok(())
    }

    /// The index, from 1, that `text`, a part of `word`, means.
    fn index(&mut self, statement: &Statement, word: &str, kind: usize, text: &str) -> Result<i64, (Position, String)> {
        let given: i64 = text.parse().map_err(|_| statement.no_corner(word))?;
        let (count, name) = ([self.places, self.normals][kind], COUNTED[kind]);
        let index = if given < 0 { given.saturating_add(count + 1) } else { given };
        let position = || statement.position(word);
        if given == 0 {
            return Err((position(), format!("{name} 0 does not exist; expected an index from 1, or -1 for the last")));
        }
        if index < 1 {
            let message =
                format!("{name} {given} does not exist, there are {count} above; expected -1 for the last, or 1…");
            return Err((position(), message));
        }
        // The file may give it further down.
        if index > count && self.ahead[kind].is_none_or(|(highest, _)| index > highest) {
            self.ahead[kind] = Some((index, position()));
        }
        Ok(index)
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

    fn start(&self) -> Position {
        self.position(self.text.trim_ascii_start())
    }

    fn three_numbers(&self, words: &[&str]) -> Result<[f64; 3], (Position, String)> {
        let [x, y, z, ..] = words else {
            return Err((self.start(), format!("has {} numbers; expected three", words.len())));
        };
        Ok([self.number(x)?, self.number(y)?, self.number(z)?])
    }

    fn number(&self, word: &str) -> Result<f64, (Position, String)> {
        word.parse().map_err(|_| (self.position(word), format!("{} is not a number; expected one", shown(word))))
    }

    fn no_corner(&self, word: &str) -> (Position, String) {
        let message = format!("{} is no corner of a face; expected 1, 1/1, 1//1 or 1/1/1", shown(word));
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
