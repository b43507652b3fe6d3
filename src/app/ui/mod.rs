//! Elements that all pages share. The look of fields, notes, plots and pages is defined only here.
//!
//! | file | contents |
//! |---|---|
//! | [`theme`] | colors, sizes, the palette of plots |
//! | [`text`] | paragraphs, hints, notes, errors; the extent of a session |
//! | [`page`] | pages, their headings, main buttons and keys; navigation |
//! | [`fonts`] | fonts of the system for texts in other scripts |
//! | [`fields`] | labeled controls; reading typed numbers |
//! | [`mod@parameter`] | the control of a stimulus parameter |
//! | [`side_bar`], [`status`] | the places of the program; the line with its messages |
//! | [`history`] | undo and redo |
//! | [`dialog`] | the desktop's file dialogs, the Browse button |
//! | [`figure`] | figures of the report |
//! | [`plot`], [`own_plot`] | static plots and their legends; the plot of one participant's answers |
//! | [`saving`] | the button that writes a file, and its question before it replaces one |
//! | [`pixels`] | pictures, one pixel of the image for each pixel of the screen; the logo |
//! | [`platform`] | the monitor, and what the window system reports about it |
//! | [`work`] | long computations on separate threads |

pub mod dialog;
pub mod fields;
pub mod figure;
pub mod fonts;
pub mod history;
pub mod own_plot;
pub mod page;
pub mod parameter;
pub mod pixels;
pub mod platform;
pub mod plot;
pub mod saving;
pub mod side_bar;
pub mod status;
pub mod text;
pub mod theme;
pub mod work;

pub use crate::{display::Monitor, store::settings::ScreenFields, work::today};
pub use dialog::{FileKind, browse};
pub use fields::{Field, entry, number};
pub use history::History;
pub use page::{
    Bench, Step, action, ask, begin_frame, end_frame, entered, escaped, fit_window, folded, footer, heading, keyed,
    main_action, menu, modal, neutral_primary, notice, page, page_from, paged, pinned, place_page, primary, quiet,
    release_focus, shortcut, tool_page,
};
pub use parameter::parameter;
pub use platform::window_px;
pub use plot::{legend, still_plot};
pub use saving::{Saving, full, open, saved};
pub use side_bar::{Place, SideDialog, side_bar};
pub use status::{complain, say, status_line};
pub use text::{describe, extent, hint, note, paragraph, secondary, section, show_error, signed, tick};
