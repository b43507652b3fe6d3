//! The answers that participants choose from.

use std::ops::RangeInclusive;

use serde::{Serialize, Serializer, ser::SerializeMap as _};

/// The possible numbers of categories of a scale: ratings are 0…1 to 0…10.
pub const CATEGORIES: RangeInclusive<usize> = 2..=11;

/// The rating scale: two to eleven categories, whose ratings count from 0.
#[derive(Clone, Debug, PartialEq)]
pub struct ResponseScale {
    /// Shown next to the scale.
    pub question: String,
    /// Categories in the order of their ratings.
    pub categories: Vec<Category>,
}

/// Serializes the scale as it appears in a definition: question, labels and keys.
impl Serialize for ResponseScale {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(3))?;
        map.serialize_entry("question", &self.question)?;
        map.serialize_entry("labels", &self.categories.iter().map(|c| &c.label).collect::<Vec<_>>())?;
        map.serialize_entry("keys", &self.categories.iter().map(|c| c.key).collect::<Vec<_>>())?;
        map.end()
    }
}

/// One possible answer.
#[derive(Clone, Debug, PartialEq)]
pub struct Category {
    /// What the answer means.
    pub label: String,
    /// The key for this answer: one digit or letter.
    pub key: char,
}

impl Category {
    /// Returns the key as participants read it: as it is written on the keyboard.
    pub fn key_name(&self) -> String {
        self.key.to_ascii_uppercase().to_string()
    }
}

impl Default for ResponseScale {
    /// The paper's four categories (Bangay §3.1).
    fn default() -> Self {
        let labels = ["No band", "Broad band", "Narrow band, indistinct boundaries", "Narrow band, clearly defined"];
        Self::new("How visible is the brighter band?", &labels, '0'..)
    }
}

impl ResponseScale {
    /// Creates a scale whose answers have these keys, as many as there are labels.
    pub fn new(question: &str, labels: &[&str], keys: impl IntoIterator<Item = char>) -> Self {
        let categories = labels.iter().zip(keys).map(|(label, key)| Category { label: (*label).to_owned(), key });
        Self { question: question.to_owned(), categories: categories.collect() }
    }

    /// Fills in `{keys}` in a text: the keys of the answers.
    pub fn fill_keys(&self, text: &str) -> String {
        text.replace("{keys}", &self.categories.iter().map(Category::key_name).collect::<Vec<_>>().join(", "))
    }

    /// Returns the key of one of `count` answers if the definition names none: that of this scale if it has as many, and
    /// otherwise the digit, and A for 10; `None` if there is no such answer.
    pub fn default_key(&self, answer: usize, count: usize) -> Option<char> {
        let own = self.categories.get(answer).filter(|_| self.categories.len() == count).map(|category| category.key);
        own.or_else(|| char::from_digit(answer as u32, *CATEGORIES.end() as u32))
    }

    /// Returns the highest rating.
    pub fn highest(&self) -> u8 {
        self.categories.len().saturating_sub(1) as u8
    }
}
