//! The texts that participants read. A definition can replace every one of them, so that a session can run in the
//! participants' language.

use serde::{Deserialize, Serialize, Serializer, ser::SerializeStruct as _};

/// Defines the texts. A text that is marked `later` was added after the first version: it is omitted from the canonical
/// form while it is the default, so that the hashes of older definitions stay the same.
macro_rules! texts {
    ($($(#[doc = $about:literal])+ $name:ident = $default:expr $(, $later:ident)?;)*) => {
        /// The participant's texts. The program fills in the placeholders in `{…}`.
        #[derive(Clone, Debug, PartialEq, Deserialize)]
        #[serde(default, deny_unknown_fields)]
        pub struct Texts {
            $($(#[doc = $about])+ pub $name: String,)*
        }

        impl Default for Texts {
            fn default() -> Self {
                Self { $($name: $default.to_owned(),)* }
            }
        }

        impl Serialize for Texts {
            fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                let texts = [$((stringify!($name), &self.$name, is_omitted(&self.$name, $default, &[$(stringify!($later))?]))),*];
                let mut map = serializer.serialize_struct("Texts", texts.iter().filter(|text| !text.2).count())?;
                for (name, text, omitted) in texts {
                    if omitted { map.skip_field(name)? } else { map.serialize_field(name, text)? }
                }
                map.end()
            }
        }

        impl Texts {
            /// Every text: its key in a definition, where it is shown, and its default.
            pub const ALL: &[[&str; 3]] = &[$([stringify!($name), concat!($($about),+), $default]),*];

            /// Returns the key and the content of each text.
            pub fn entries(&self) -> impl Iterator<Item = (&'static str, &str)> {
                [$((stringify!($name), self.$name.as_str())),*].into_iter()
            }
        }
    };
}

fn is_omitted(text: &str, default: &str, marks: &[&str]) -> bool {
    marks == ["later"] && text == default
}

texts! {
    /// Heading of the first page.
    welcome = "Welcome";
    /// First page: the task.
    task = "You will see a dark and a bright area with a transition between them. Where the transition meets the bright area, many people see a thin line that is brighter still: a Mach band. The line is not in the image; your eye adds it.\n\nAfter each image, rate how visible the BRIGHTER band is. There is no right answer: report what you see.\n\nBetween images the screen shows one even colour while your eyes recover. Sit at the planned distance; dim the room if you can.";
    /// First page, in small print: advice on eyes and health.
    light = "If you see colors differently from most people, say so before you begin: the same experiment can be shown in gray. Nothing flickers; the screen changes from even color to image and back every few seconds. If flickering light has ever made you ill, ask before you begin, and stop with Esc whenever you feel unwell.", later;
    /// Heading of the page that shows the categories.
    categories = "The four answers";
    /// Shown below the categories, and while paused.
    keys = "Answer with the number keys (top row or number pad). Backspace takes the last answer back while the screen is even. S shows or hides the scale. Esc pauses.";
    /// Shown before the practice trials.
    practice = "First some practice. These answers are recorded, marked as practice, and not analysed.";
    /// Shown before the practice trials, above the scale.
    practice_scale = "During practice, this scale is at the lower edge of the screen. You can also click an answer.", later;
    /// Shown before the main trials.
    main = "Now the main part. Take your time; the next image comes only after your answer.";
    /// Shown before the main trials.
    main_scale = "The scale is now hidden. Press S to show it.", later;
    /// Heading of a break.
    pause_heading = "Time for a break";
    /// Shown during a break and while paused; `{done}`, `{total}` and `{minutes}` are filled in.
    break_progress = "{done} of {total} done. About {minutes} min to go.";
    /// Heading while paused.
    paused = "Paused";
    /// Shown while paused.
    paused_text = "Everything rated so far is saved. The image you were looking at will be shown again.";
    /// Button on the pause page that shows the instructions again.
    reread = "Read the instructions again", later;
    /// Button and hint to continue.
    next = "Continue";
    /// Name of the key that continues.
    next_key = "Space";
    /// Button that returns to the page before.
    previous = "Back", later;
    /// Name of the key that returns to the page before.
    previous_key = "Backspace", later;
    /// Which page of the instructions is shown; `{page}` and `{pages}` are filled in.
    page_count = "Page {page} of {pages}", later;
    /// Shown on the uniform field after a key that has no meaning; `{keys}` is filled in.
    answer_keys = "Keys: {keys}", later;
    /// Button that leaves the session.
    leave = "Leave the session";
    /// Shown when a session is resumed after an interruption; `{done}` and `{total}` are filled in.
    resumed = "Welcome back. {done} of {total} are done; the session goes on with the ones that are missing.";
    /// Heading at the end.
    thanks = "Thank you!";
    /// Heading shown after the session was left early.
    left_heading = "The session is interrupted";
    /// Shown after the session was left early.
    left = "Every answer given is saved. Start it again with the same participant and session to go on.";
    /// Shown above the plot at the end; `{x}` and `{lines}` are filled in.
    ratings = "Your mean rating by {x}, one line for each {lines}";
    /// Label of the plot's vertical axis.
    mean_rating = "mean rating", later;
    /// Heading of the part of the last page that is for the experimenter.
    experimenter = "For the experimenter", later;
    /// Shown above the path of the data.
    saved_in = "The answers are in";
    /// Button that opens the folder with the data.
    open_folder = "Open the folder";
    /// Button that closes the window.
    close = "Close";
    /// Button that returns to the first page of the program.
    back = "Back to the start";
    /// Shown at the end.
    done = "That was the last image. Your answers are saved.";
    /// Heading of the page that asks about the participant.
    about_you = "About you", later;
    /// Shown below that heading.
    about_you_text = "Answers marked with * are needed. Your answers are saved with the data of this experiment.", later;
    /// Label of the box that agrees to a text.
    agree = "I have read this and agree.", later;
    /// Shown at a question that needs an answer.
    answer_missing = "Please answer this question.", later;
    /// Shown at a text that must be agreed to.
    agreement_missing = "Please read this and tick the box. Without it, the session cannot begin.", later;
    /// Shown at a question that needs a number.
    number_expected = "Enter a number, e.g. 27.", later;
    /// Shown at an answer that a spreadsheet would take for a formula.
    letter_expected = "Begin with a letter or a digit.", later;
}
