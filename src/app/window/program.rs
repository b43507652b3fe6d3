//! The program in the window, and what happens if the graphics card or the window system is lost: saved data are on
//! disk, the sitting is closed, and a message says how to resume.

use std::{
    cell::RefCell,
    mem, panic,
    path::{Path, PathBuf},
    rc::Rc,
    sync::{Arc, OnceLock},
    thread,
};

use eframe::{AppCreator, CreationContext, egui, wgpu::DeviceLostReason};

use crate::{
    report::terminal::message,
    system::signals::{self, Ended, Signal},
};

/// Why no window could be opened, or why it was lost.
#[derive(Debug, thiserror::Error)]
pub enum WindowError {
    /// There is no display, or the window system or the graphics driver refused to open a window.
    #[error(
        "display: no window can be opened ({0}); expected a desktop session with Vulkan or OpenGL (without one, `machband simulate` runs sessions with a simulated observer)"
    )]
    Refused(String),
    /// The program was asked to end while the window was open.
    #[error("{}", ended(*signal, rows.as_deref()))]
    Ended {
        /// The signal that asked it to end.
        signal: Signal,
        /// Path of the file with the rows of the session that was running; `None` if there was no session.
        rows: Option<PathBuf>,
    },
    /// The window system or the graphics driver was lost while the window was open.
    #[error("{}", lost(reason, rows.as_deref()))]
    Lost {
        /// The reason that was given.
        reason: String,
        /// Path of the file with the rows of the running session; `None` if there is no session.
        rows: Option<PathBuf>,
    },
}

/// How a session continues whose window is gone.
const RESUME: &str = "every saved answer is on disk; to resume, use the same command with --resume, or press Resume on \
                      the page Studies";

fn ended(signal: Signal, rows: Option<&Path>) -> String {
    match rows {
        Some(rows) => {
            let ended = Ended { place: rows.display().to_string(), signal };
            format!("{ended}; {RESUME}")
        }
        None => format!("window: ended by {signal}; expected the user to close it"),
    }
}

fn lost(reason: &str, rows: Option<&Path>) -> String {
    let (place, expected) = match rows {
        Some(rows) => (rows.display().to_string(), RESUME),
        None => (
            "display".to_owned(),
            "expected a window system and graphics driver that keep running; if they do, please report this error",
        ),
    };
    format!("{place}: the window was lost ({reason}); {expected}")
}

/// A program that runs in the window.
pub trait Program: eframe::App {
    /// Ends a running session; returns the path of the file with its rows.
    fn close(&mut self) -> Option<PathBuf>;
}

/// Why the window or its graphics failed first; empty until they fail.
#[derive(Clone, Debug, Default)]
pub struct Failure(Arc<OnceLock<String>>);

thread_local! {
    /// Dropped at exit if a library ends the program itself, as Xlib does when its server is lost.
    static AT_EXIT: RefCell<Option<AtExit>> = const { RefCell::new(None) };
}

impl Failure {
    /// Returns the first reported reason.
    pub fn reason(&self) -> Option<String> {
        self.0.get().cloned()
    }

    /// Reports that the window or the graphics are lost. Only the first reason counts.
    pub fn report(&self, reason: String) {
        _ = self.0.set(reason);
    }

    /// From now on, reports panics of this thread instead of printing them. The libraries of the window panic if the
    /// graphics or the window system are lost.
    pub fn report_panics(&self) {
        let (failure, window, before) = (self.clone(), thread::current().id(), panic::take_hook());
        panic::set_hook(Box::new(move |info| {
            if thread::current().id() != window {
                return before(info);
            }
            let message = info.payload_as_str().unwrap_or("no reason given").replace('\n', " ");
            let place = info.location().map(|place| format!(", {}:{}", file_name(place.file()), place.line()));
            failure.report(format!("{}{}", message.trim(), place.unwrap_or_default()));
        }));
    }

    /// Watches for the loss of the graphics card and for its other errors.
    fn watch(&self, cc: &CreationContext<'_>) {
        let Some(state) = &cc.wgpu_render_state else { return };
        let (lost, wrong) = (self.clone(), self.clone());
        let (ctx, other) = (cc.egui_ctx.clone(), cc.egui_ctx.clone());
        state.device.set_device_lost_callback(move |reason, message| {
            // The device is also destroyed when the program ends normally.
            if reason != DeviceLostReason::Destroyed {
                lost.report(format!("the graphics card was lost: {}", message.trim()));
                ctx.request_repaint();
            }
        });
        state.device.on_uncaptured_error(Arc::new(move |error| {
            wrong.report(format!("the graphics card: {}", error.to_string().replace('\n', " ").trim()));
            other.request_repaint();
        }));
    }
}

fn file_name(path: &str) -> &str {
    path.rsplit(['/', '\\']).next().unwrap_or(path)
}

/// The program in the window. The event loop can close it when the window no longer can.
#[derive(Clone, Default)]
pub struct Shared {
    /// `None` until there is a window.
    program: Rc<RefCell<Option<Box<dyn Program>>>>,
    /// Why the window or the graphics failed.
    pub failure: Failure,
}

impl Shared {
    /// Returns a function for eframe that creates the program with `make`, once there is a window.
    pub fn creator<P: Program + 'static>(
        &self,
        make: impl FnOnce(&CreationContext<'_>) -> P + 'static,
    ) -> AppCreator<'static> {
        let shared = self.clone();
        Box::new(move |cc| {
            shared.failure.watch(cc);
            let ctx = cc.egui_ctx.clone();
            signals::wake(move || ctx.request_repaint());
            shared.program.replace(Some(Box::new(make(cc))));
            Ok(Box::new(shared))
        })
    }

    /// From now on, prints a message even if a library ends the program.
    pub fn report_at_exit(&self) {
        AT_EXIT.set(Some(AtExit(self.clone())));
    }

    /// Cancels that message, because the window ended normally or the reason is reported elsewhere.
    pub fn forget_exit(&self) {
        mem::forget(AT_EXIT.take());
    }

    /// Returns whether there has been a window.
    pub fn is_open(&self) -> bool {
        self.program.try_borrow().map_or(true, |program| program.is_some())
    }

    /// Ends a running session; returns the path of the file with its rows.
    pub fn close(&self) -> Option<PathBuf> {
        // The program is borrowed only while it draws, and a caught panic has ended the drawing.
        self.program.try_borrow_mut().ok()?.as_mut()?.close()
    }
}

impl eframe::App for Shared {
    fn ui(&mut self, ui: &mut egui::Ui, frame: &mut eframe::Frame) {
        if let Some(program) = &mut *self.program.borrow_mut() {
            program.ui(ui, frame);
        }
    }

    fn on_exit(&mut self) {
        self.close();
    }

    fn clear_color(&self, visuals: &egui::Visuals) -> [f32; 4] {
        self.program.borrow().as_ref().map_or([0.0; 4], |program| program.clear_color(visuals))
    }
}

struct AtExit(Shared);

impl Drop for AtExit {
    fn drop(&mut self) {
        let rows = self.0.close();
        let reason = self.0.failure.reason().unwrap_or_else(|| "the window system was lost".to_owned());
        message("error", &WindowError::Lost { reason, rows }.to_string());
    }
}
