//! The texts that participants read. A definition can replace every one of them, so that a session can run in the
//! participants' language.

use serde::{Deserialize, Serialize, Serializer};

/// Defines the texts. Only texts that differ from their defaults are serialized.
macro_rules! texts {
    ($($(#[doc = $about:literal])+ $name:ident = $default:expr;)*) => {
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
                let all = self.entries().zip(Self::ALL);
                serializer.collect_map(all.filter_map(|(own, [.., default])| (own.1 != *default).then_some(own)))
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

texts! {
    /// Heading of the first page.
    welcome = "Welcome";
    /// First page: the task.
    task = "You will see a dark and a bright area with a transition between them. Where the transition meets the bright area, you may see a line or band that is brighter still.\n\nAfter each image, rate how visible this BRIGHTER band is. There is no right answer: report what you see.\n\nBetween images, the screen shows one even color while your eyes recover. Sit at the planned distance, and dim the room if you can.";
    /// First page, in small print: advice on eyes and health.
    light = "If you see colors differently from most people, say so before you begin. Nothing flickers, but the screen changes between an even color and an image every few seconds. If flickering light has ever made you ill, ask before you begin. Press Esc to stop whenever you feel unwell.";
    /// Heading of the page that shows the categories.
    categories = "The answers";
    /// Shown below the categories, and while paused; `{keys}` is filled in. With keys that are not digits, it names them.
    keys = "Answer with the number keys (top row or number pad). While the screen shows one even color, Backspace undoes the last answer. S shows or hides the scale. Esc pauses.";
    /// Shown before the practice trials.
    practice = "First, some practice. These answers are recorded as practice and are not analyzed.";
    /// Shown before the practice trials, above the scale.
    practice_scale = "During practice, this scale is at the lower edge of the screen. You can also click an answer.";
    /// Shown before the main trials.
    main = "Now the main part. Take your time: the next image appears only after your answer.";
    /// Shown before the main trials.
    main_scale = "The scale is now hidden. Press S to show it.";
    /// Heading of a break.
    pause_heading = "Time for a break";
    /// Shown during a break and while paused; `{done}`, `{total}` and `{minutes}` are filled in.
    break_progress = "{done} of {total} done. About {minutes} min left.";
    /// Heading while paused.
    paused = "Paused";
    /// Shown while paused.
    paused_text = "All your answers so far are saved. The image that you were looking at will be shown again.";
    /// Button on the pause page that shows the instructions again.
    reread = "Read the instructions again";
    /// Button and hint to continue.
    next = "Continue";
    /// Name of the key that continues.
    next_key = "Space";
    /// Button that returns to the page before.
    previous = "Back";
    /// Name of the key that returns to the page before.
    previous_key = "Backspace";
    /// Shown on the uniform field after a key that has no meaning; `{keys}` is filled in.
    answer_keys = "Keys: {keys}";
    /// The keys that it names if participants set a value.
    dial_keys = "arrow keys, Enter";
    /// Button that leaves the session.
    leave = "Leave the session";
    /// Shown when a session is resumed after an interruption; `{done}` and `{total}` are filled in.
    resumed = "Welcome back. {done} of {total} images are done. The session resumes with the next one.";
    /// Heading at the end.
    thanks = "Thank you!";
    /// Heading shown after the session was left early.
    left_heading = "The session is interrupted";
    /// Shown after the session was left early.
    left = "All your answers are saved. The session can be resumed later.";
    /// Shown above the plot at the end; `{x}` and `{lines}` are filled in.
    ratings = "Your mean rating by {x}, one line for each {lines}";
    /// Label of the plot's vertical axis.
    mean_rating = "mean rating";
    /// Label of the vertical axis of the plot: the proportion of right answers.
    right = "proportion of right answers";
    /// Shown above the plot of the levels that an adaptive method chose.
    levels = "The levels that you saw, trial by trial: after right answers, the task became harder";
    /// Label of the horizontal axis of that plot.
    trial = "trial";
    /// Shown above the plot of a paired comparison.
    chosen = "How often you chose each of the images when it was compared, least often first";
    /// Label of the vertical axis of that plot.
    share = "proportion of comparisons";
    /// Heading of the part of the last page that is for the experimenter.
    experimenter = "For the experimenter";
    /// Shown above the path of the data.
    saved_in = "The answers are saved in";
    /// Button that opens the folder with the data.
    open_folder = "Open the folder";
    /// Button that closes the window.
    close = "Close";
    /// Button that returns to the first page of the program.
    back = "Back to the start";
    /// Shown at the end.
    done = "That was the last image. Your answers are saved.";
    /// Heading of the page that asks about the participant.
    about_you = "About you";
    /// Shown below that heading.
    about_you_text = "Answers marked with * are required. Your answers are saved with the data of this experiment.";
    /// Label of the box that agrees to a text.
    agree = "I have read this and agree.";
    /// The choice of those who leave out a question that is not required.
    no_answer = "no answer";
    /// Shown at a question that needs an answer.
    answer_missing = "Please answer this question.";
    /// Shown at a text that the participant must agree to.
    agreement_missing = "Please read this and check the box. Otherwise, the session cannot begin.";
    /// Shown at a question that needs a number.
    number_expected = "Enter a number, e.g. 27.";
    /// Shown at an age that no person has.
    age_expected = "Enter an age in years, from 0 to 130.";
    /// Shown at an answer that a spreadsheet would take for a formula.
    letter_expected = "Begin with a letter or a digit.";
}
