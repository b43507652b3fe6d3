//! The texts that participants read. A definition can replace every one of them, so that a session can run in the
//! participants' language.

use serde::{Deserialize, Serialize};

macro_rules! texts {
    ($($(#[$meta:meta])* $name:ident = $default:expr;)*) => {
        /// The participant's texts. The program fills in the placeholders in `{…}`.
        #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
        #[serde(default, deny_unknown_fields)]
        pub struct Texts {
            $($(#[$meta])* pub $name: String,)*
        }

        impl Default for Texts {
            fn default() -> Self {
                Self { $($name: $default.to_owned(),)* }
            }
        }
    };
}

/// The default text on color vision and flickering light.
const LIGHT: &str = "If you see colors differently from most people, say so before you begin: the same experiment can be shown in gray. Nothing flickers; the screen changes from even color to image and back every few seconds. If flickering light has ever made you ill, ask before you begin, and stop with Esc whenever you feel unwell.";

fn is_light_default(light: &str) -> bool {
    light == LIGHT
}

texts! {
    /// Heading of the first page.
    welcome = "Welcome";
    /// First page: the task.
    task = "You will see a dark and a bright area with a transition between them. Where the transition meets the bright area, many people see a thin line that is brighter still: a Mach band. The line is not in the image; your eye adds it.\n\nAfter each image, rate how visible the BRIGHTER band is. There is no right answer: report what you see.\n\nBetween images the screen shows one even colour while your eyes recover. Sit at the planned distance; dim the room if you can.";
    /// First page, in small print: advice on eyes and health. Files omit the default, so that definitions written
    /// before this text existed keep their hashes.
    #[serde(skip_serializing_if = "is_light_default")]
    light = LIGHT;
    /// Heading of the page that shows the categories.
    categories = "The four answers";
    /// Shown below the categories.
    keys = "Answer with the number keys (top row or number pad). Backspace takes the last answer back while the screen is even. S shows or hides the scale. Esc pauses.";
    /// Shown before the practice trials.
    practice = "First some practice. These answers are recorded, marked as practice, and not analysed.";
    /// Shown before the main trials.
    main = "Now the main part. Take your time; the next image comes only after your answer.";
    /// Heading of a break.
    pause_heading = "Time for a break";
    /// Shown during a break; `{done}`, `{total}` and `{minutes}` are filled in.
    break_progress = "{done} of {total} done. About {minutes} min to go.";
    /// Heading while paused.
    paused = "Paused";
    /// Shown while paused.
    paused_text = "Everything rated so far is saved. The image you were looking at will be shown again.";
    /// Button and hint to continue.
    next = "Continue";
    /// Name of the key that continues.
    next_key = "Space";
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
}
