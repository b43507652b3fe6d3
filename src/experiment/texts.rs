//! What a participant reads. Every text can be replaced by the definition, so that a session can run in the
//! participants' language.

use serde::{Deserialize, Serialize};

macro_rules! texts {
    ($($(#[$meta:meta])* $name:ident = $default:expr;)*) => {
        /// The participant's texts; `{…}` places are filled in by the program.
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

/// The text on color and light unless the definition has its own.
const LIGHT: &str = "If you see colors differently from most people, say so before you begin: the same experiment can be shown in gray. Nothing flickers; the screen changes from even color to image and back every few seconds. If flickering light has ever made you ill, ask before you begin, and stop with Esc whenever you feel unwell.";

fn is_light_default(light: &str) -> bool {
    light == LIGHT
}

texts! {
    /// Heading of the first page.
    welcome = "Welcome";
    /// First page: what the task is.
    task = "You will see a dark and a bright area with a transition between them. Where the transition meets the bright area, many people see a thin line that is brighter still: a Mach band. The line is not in the image; your eye adds it.\n\nAfter each image, rate how visible the BRIGHTER band is. There is no right answer: report what you see.\n\nBetween images the screen shows one even colour while your eyes recover. Sit at the planned distance; dim the room if you can.";
    /// First page, in small: what concerns eyes and health. Not part of what a definition was known by before it was
    /// there.
    #[serde(skip_serializing_if = "is_light_default")]
    light = LIGHT;
    /// Heading of the page that shows the categories.
    categories = "The four answers";
    /// Below the categories.
    keys = "Answer with the number keys (top row or number pad). Backspace takes the last answer back while the screen is even. S shows or hides the scale. Esc pauses.";
    /// Before practice trials.
    practice = "First some practice. These answers are recorded, marked as practice, and not analysed.";
    /// Before the main trials.
    main = "Now the main part. Take your time; the next image comes only after your answer.";
    /// Heading of a break.
    pause_heading = "Time for a break";
    /// A break; `{done}`, `{total}` and `{minutes}` are filled in.
    break_progress = "{done} of {total} done. About {minutes} min to go.";
    /// Heading while paused.
    paused = "Paused";
    /// While paused.
    paused_text = "Everything rated so far is saved. The image you were looking at will be shown again.";
    /// Button and hint to continue.
    next = "Continue";
    /// Name of the key that continues.
    next_key = "Space";
    /// Button that leaves the session.
    leave = "Leave the session";
    /// When a session is resumed after an interruption; `{done}` and `{total}` are filled in.
    resumed = "Welcome back. {done} of {total} are done; the session goes on with the ones that are missing.";
    /// Heading at the end.
    thanks = "Thank you!";
    /// Heading of a session that was left before its end.
    left_heading = "The session is interrupted";
    /// When it was left.
    left = "Every answer given is saved. Start it again with the same participant and session to go on.";
    /// Above the plot at the end; `{x}` and `{lines}` are filled in.
    ratings = "Your mean rating by {x}, one line for each {lines}";
    /// Above the path of the data.
    saved_in = "The answers are in";
    /// Button.
    open_folder = "Open the folder";
    /// Button that closes the window.
    close = "Close";
    /// Button that leads to the first page of the program.
    back = "Back to the start";
    /// At the end.
    done = "That was the last image. Your answers are saved.";
}
