//! MAT-files of MATLAB, level 5, as `save -v6` and `-v7` write them (MathWorks, *MAT-File Format*): real numbers, cells
//! and structures. No crate that reads structures was found that never panics on a damaged file.

use std::io::Read as _;

use flate2::read::ZlibDecoder;

/// Most bytes of a file, and of all that is unpacked from it.
pub(super) const MAX_BYTES: u64 = 32 << 20;
/// How deep cells and structures may stand in each other.
const MAX_DEPTH: usize = 16;

const DAMAGED: &str = "is a damaged MAT-file; expected one that MATLAB can load";

/// The types of data elements that are not numbers.
const MATRIX: u32 = 14;
const COMPRESSED: u32 = 15;

/// The value of a variable.
pub(super) enum Value {
    /// Column by column.
    Numbers(Vec<f64>),
    /// A cell array, or an array of structures.
    List(Vec<Self>),
    Fields(Vec<(String, Self)>),
    /// Text, an object, a sparse matrix.
    Other,
}

impl Value {
    pub fn field(&self, name: &str) -> Option<&Self> {
        let Self::Fields(fields) = self else { return None };
        fields.iter().find(|(one, _)| one == name).map(|(_, value)| value)
    }

    /// Returns the numbers of a field.
    pub fn numbers(&self, name: &str) -> Option<&[f64]> {
        match self.field(name) {
            Some(Self::Numbers(numbers)) => Some(numbers),
            _ => None,
        }
    }
}

/// Returns true for the first bytes of a MAT-file of any level that has a header.
pub(super) fn is_mat(bytes: &[u8]) -> bool {
    bytes.starts_with(b"MATLAB ")
}

/// Reads the variables of a file, with their names.
///
/// # Errors
/// The file is damaged, or of level 7.3, which is HDF5.
pub(super) fn variables(bytes: &[u8]) -> Result<Value, String> {
    if !bytes.starts_with(b"MATLAB 5.0") {
        return Err("is a MAT-file of another version; expected one that was saved with save -v7".to_owned());
    }
    let (is_big, content) = match (bytes.get(126..128), bytes.get(128..)) {
        (Some(b"IM"), Some(content)) => (false, content),
        (Some(b"MI"), Some(content)) => (true, content),
        _ => return Err(DAMAGED.to_owned()),
    };
    let (mut elements, mut found, mut left) = (Elements { rest: content, is_big }, Vec::new(), MAX_BYTES);
    while !elements.rest.is_empty() {
        let (kind, data) = elements.next()?;
        let mut unpacked = Vec::new();
        let (kind, data) = if kind == COMPRESSED {
            let read = ZlibDecoder::new(data).take(left + 1).read_to_end(&mut unpacked).map_err(|_| DAMAGED)? as u64;
            let unpacks_to_more = || format!("unpacks to more than {} MiB; expected a calibration", MAX_BYTES >> 20);
            left = left.checked_sub(read).ok_or_else(unpacks_to_more)?;
            Elements { rest: &unpacked, is_big }.next()?
        } else {
            (kind, data)
        };
        if kind == MATRIX {
            found.push(Elements { rest: data, is_big }.array(0)?);
        }
    }
    Ok(Value::Fields(found))
}

/// The data elements in a part of a file.
struct Elements<'a> {
    rest: &'a [u8],
    /// True if the most significant byte of a number comes first.
    is_big: bool,
}

impl<'a> Elements<'a> {
    fn take(&mut self, length: usize) -> Result<&'a [u8], String> {
        let (taken, rest) = self.rest.split_at_checked(length).ok_or(DAMAGED)?;
        self.rest = rest;
        Ok(taken)
    }

    fn word(&mut self) -> Result<u32, String> {
        let bytes = self.take(4)?;
        Ok(self.each(bytes, u32::from_le_bytes).first().copied().unwrap_or_default())
    }

    /// Converts each `N` bytes, least significant first.
    fn each<const N: usize, T>(&self, bytes: &[u8], of: impl Fn([u8; N]) -> T) -> Vec<T> {
        let ordered = |chunk: &[u8; N]| {
            let mut chunk = *chunk;
            if self.is_big {
                chunk.reverse();
            }
            of(chunk)
        };
        bytes.as_chunks().0.iter().map(ordered).collect()
    }

    /// Returns the type and the data of the next element. At most four bytes stand in the tag itself.
    fn next(&mut self) -> Result<(u32, &'a [u8]), String> {
        let tag = self.word()?;
        if tag >> 16 > 0 {
            let data = self.take(4)?.get(..(tag >> 16) as usize).ok_or(DAMAGED)?;
            return Ok((tag & 0xffff, data));
        }
        let length = self.word()? as usize;
        let data = self.take(length)?;
        // Elements start at multiples of eight bytes, but for what follows a compressed one.
        let padding = if tag == COMPRESSED { 0 } else { length.next_multiple_of(8) - length };
        self.rest = self.rest.get(padding..).unwrap_or_default();
        Ok((tag, data))
    }

    /// Returns the integers of the next element.
    fn integers(&mut self) -> Result<Vec<usize>, String> {
        let (_, data) = self.next()?;
        Ok(self.each(data, |bytes| u32::from_le_bytes(bytes) as usize))
    }

    /// Reads the content of an array's element: the name and the value.
    fn array(&mut self, depth: usize) -> Result<(String, Value), String> {
        // An empty field.
        if self.rest.is_empty() {
            return Ok((String::new(), Value::Other));
        }
        let class = self.integers()?.first().ok_or(DAMAGED)? & 0xff;
        let count = self.integers()?.iter().try_fold(1_usize, |count, one| count.checked_mul(*one)).ok_or(DAMAGED)?;
        let name = String::from_utf8_lossy(self.next()?.1).into_owned();
        let value = match class {
            _ if depth == MAX_DEPTH => return Err(DAMAGED.to_owned()),
            1 => Value::List((0..count).map(|_| self.inner(depth)).collect::<Result<_, _>>()?),
            2 => {
                let width = *self.integers()?.first().filter(|width| **width > 0).ok_or(DAMAGED)?;
                let named = |bytes: &[u8]| String::from_utf8_lossy(bytes).trim_end_matches('\0').to_owned();
                let names: Vec<String> = self.next()?.1.chunks(width).map(named).collect();
                if names.is_empty() {
                    return Ok((name, Value::Other));
                }
                let mut list = Vec::new();
                for _ in 0..count {
                    let fields = names.iter().map(|name| Ok((name.clone(), self.inner(depth)?)));
                    list.push(Value::Fields(fields.collect::<Result<_, String>>()?));
                }
                if count == 1 { list.remove(0) } else { Value::List(list) }
            }
            6..=15 => {
                let (kind, data) = self.next()?;
                let numbers = self.numbers(kind, data)?;
                if numbers.len() != count {
                    return Err(DAMAGED.to_owned());
                }
                Value::Numbers(numbers)
            }
            _ => Value::Other,
        };
        Ok((name, value))
    }

    fn inner(&mut self, depth: usize) -> Result<Value, String> {
        match self.next()? {
            (MATRIX, rest) => Ok(Self { rest, is_big: self.is_big }.array(depth + 1)?.1),
            _ => Err(DAMAGED.to_owned()),
        }
    }

    /// MATLAB stores whole numbers in the smallest type that holds them.
    fn numbers(&self, kind: u32, data: &[u8]) -> Result<Vec<f64>, String> {
        Ok(match kind {
            1 => self.each(data, |bytes| f64::from(i8::from_le_bytes(bytes))),
            2 => self.each(data, |bytes| f64::from(u8::from_le_bytes(bytes))),
            3 => self.each(data, |bytes| f64::from(i16::from_le_bytes(bytes))),
            4 => self.each(data, |bytes| f64::from(u16::from_le_bytes(bytes))),
            5 => self.each(data, |bytes| f64::from(i32::from_le_bytes(bytes))),
            6 => self.each(data, |bytes| f64::from(u32::from_le_bytes(bytes))),
            7 => self.each(data, |bytes| f64::from(f32::from_le_bytes(bytes))),
            9 => self.each(data, f64::from_le_bytes),
            12 => self.each(data, |bytes| i64::from_le_bytes(bytes) as f64),
            13 => self.each(data, |bytes| u64::from_le_bytes(bytes) as f64),
            _ => return Err(DAMAGED.to_owned()),
        })
    }
}
