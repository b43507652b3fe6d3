//! The participants' texts and the scripts in which the window can show them.

use std::collections::BTreeSet;

use unicode_script::{Script, UnicodeScript as _};

use super::{definition::Definition, faults::DefinitionError};

impl Definition {
    /// Returns every text that participants read, with its place in the definition, or that of its question.
    pub fn participant_texts(&self) -> impl Iterator<Item = (String, &str)> {
        let texts = self.instructions.entries().map(|(key, text)| (format!("instructions.{key}"), text));
        let question = ("response.question".to_owned(), self.response.question.as_str());
        let labels = self.response.categories.iter().enumerate();
        let labels = labels.map(|(i, category)| (format!("response.labels.{i}"), category.label.as_str()));
        let fields = self.participant.0.iter().flat_map(|field| {
            let texts = [&field.spec.label, &field.spec.text].into_iter().filter_map(|text| text.as_deref());
            let texts = texts.chain(field.options().into_iter().map(|(_, shown)| shown));
            texts.map(|text| (format!("participant.{}", field.name), text))
        });
        texts.chain([question]).chain(labels).chain(fields)
    }

    /// Returns the letters in the participants' texts for which the window's own font is not made: those of scripts
    /// other than Latin, Greek and Cyrillic.
    pub fn foreign_letters(&self) -> BTreeSet<char> {
        let own = [Script::Latin, Script::Greek, Script::Cyrillic, Script::Common, Script::Inherited];
        let letters = self.participant_texts().flat_map(|(_, text)| text.chars());
        letters.filter(|c| !own.contains(&c.script())).collect()
    }

    /// Returns an error for the title and for each of the participants' texts that the window cannot show.
    pub(super) fn script_errors(&self) -> Vec<DefinitionError> {
        let error = |(path, text): (String, &str)| {
            let (letter, why) = text.chars().find_map(|c| Some((c, refusal(c.script())?)))?;
            let name = letter.script().full_name().replace('_', " ");
            let message = format!(
                "the text contains {letter:?} of the script {name}, which {why}; expected a script that is written from left to right"
            );
            Some(DefinitionError { path, message })
        };
        let title = ("title".to_owned(), self.title.as_str());
        std::iter::once(title).chain(self.participant_texts()).filter_map(error).collect()
    }
}

/// Returns why the window cannot show a script, if it cannot. Its layout shapes letters, so that the scripts of India and
/// of Southeast Asia are shown correctly, but it writes only from left to right.
fn refusal(script: Script) -> Option<&'static str> {
    match script {
        Script::Adlam
        | Script::Arabic
        | Script::Hanifi_Rohingya
        | Script::Hebrew
        | Script::Mandaic
        | Script::Mende_Kikakui
        | Script::Nko
        | Script::Samaritan
        | Script::Syriac
        | Script::Thaana => Some("is written from right to left"),
        Script::Mongolian => Some("is written from top to bottom"),
        _ => None,
    }
}
