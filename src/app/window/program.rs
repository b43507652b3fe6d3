//! The program in the window, and the response to the loss of the graphics card or the window system: recorded data are
//! on disk, the sitting is closed, and a message says how to resume.

use std::{
    cell::{Cell, RefCell},
    io::Write as _,
    mem, panic,
    path::{Path, PathBuf},
    rc::Rc,
    sync::{Arc, Mutex, PoisonError},
};

use eframe::{AppCreator, CreationContext, egui, wgpu::DeviceLostReason};

/// Why there is no window.
#[derive(Debug, thiserror::Error)]
pub enum WindowError {
    /// No display to open a window on.
    #[error(
        "display: no window can be opened, since neither DISPLAY nor WAYLAND_DISPLAY is set; expected a desktop session (without one, `machband simulate` runs sessions with a simulated observer)"
    )]
    NoDisplay,
    /// The window system or the graphics driver refused.
    #[error(
        "display: no window can be opened ({0}); expected a desktop session with Vulkan or OpenGL (without one, `machband simulate` runs sessions with a simulated observer)"
    )]
    Refused(String),
    /// The window system or the graphics driver was lost while the window was open.
    #[error("{}", lost(reason, rows.as_deref()))]
    Lost {
        /// The reason they gave.
        reason: String,
        /// Path of the rows of the running session.
        rows: Option<PathBuf>,
    },
}

fn lost(reason: &str, rows: Option<&Path>) -> String {
    let (place, expected) = match rows {
        Some(rows) => (
            rows.display().to_string(),
            "every saved answer is on disk; to resume, expected the same command with --resume, or Home with the same \
                participant and session",
        ),
        None => ("display".to_owned(), "expected a window system and graphics driver that keep running"),
    };
    format!("{place}: the window was lost ({reason}); {expected}")
}

/// What runs in the window.
pub trait Program: eframe::App {
    /// Ends a running session; returns the file of its rows.
    fn close(&mut self) -> Option<PathBuf>;
}

/// Why the window or its graphics failed, once they have.
#[derive(Clone, Debug, Default)]
pub struct Failure(Arc<Mutex<Option<String>>>);

thread_local! {
    /// The message of the last panic of this thread, where panics are caught.
    static PANIC: RefCell<Option<String>> = const { RefCell::new(None) };
    static CAUGHT: Cell<bool> = const { Cell::new(false) };
    /// Dropped at exit if a library ends the program itself, as Xlib does when its server is lost.
    static AT_EXIT: RefCell<Option<AtExit>> = const { RefCell::new(None) };
}

impl Failure {
    /// The first reason that was reported.
    pub fn reason(&self) -> Option<String> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Window or graphics are lost.
    pub fn report(&self, reason: String) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(reason);
    }

    /// The libraries of the window panic if the graphics or the window system are lost. From now on, panics of this
    /// thread are kept for [`Failure::report_panic`] and not printed.
    pub fn catch_panics() {
        CAUGHT.set(true);
        let before = panic::take_hook();
        panic::set_hook(Box::new(move |info| {
            if !CAUGHT.get() {
                return before(info);
            }
            let message = info.payload_as_str().unwrap_or("no reason given").replace('\n', " ");
            let place = info.location().map(|place| format!(", {}:{}", file_name(place.file()), place.line()));
            PANIC.set(Some(format!("{}{}", message.trim(), place.unwrap_or_default())));
        }));
    }

    /// Records a caught panic. If the graphics card was lost before, that is the reason.
    pub fn report_panic(&self) {
        self.report(PANIC.take().unwrap_or_else(|| "no reason given".to_owned()));
    }

    /// Watches for the loss of the graphics card and its other errors.
    fn watch(&self, cc: &CreationContext<'_>) {
        let Some(state) = &cc.wgpu_render_state else { return };
        let (lost, wrong) = (self.clone(), self.clone());
        let (ctx, other) = (cc.egui_ctx.clone(), cc.egui_ctx.clone());
        state.device.set_device_lost_callback(move |reason, message| {
            // The normal end of the program destroys it, too.
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

/// The program in the window, which the event loop can close if the window no longer can.
#[derive(Clone)]
pub struct Shared {
    program: Rc<RefCell<Option<Box<dyn Program>>>>,
    make: Rc<Cell<Option<Make>>>,
    failure: Failure,
}

type Make = Box<dyn FnOnce(&CreationContext<'_>) -> Box<dyn Program>>;

impl Shared {
    /// A program that is created when there is a window.
    pub fn new(make: impl FnOnce(&CreationContext<'_>) -> Box<dyn Program> + 'static) -> Self {
        Self { program: Rc::default(), make: Rc::new(Cell::new(Some(Box::new(make)))), failure: Failure::default() }
    }

    /// Whether window or graphics are lost.
    pub fn failure(&self) -> &Failure {
        &self.failure
    }

    /// Makes the program.
    pub fn creator(&self) -> AppCreator<'static> {
        let shared = self.clone();
        Box::new(move |cc| {
            shared.failure.watch(cc);
            shared.program.replace(shared.make.take().map(|make| make(cc)));
            Ok(Box::new(shared))
        })
    }

    /// From now on, the program does not end without a message.
    pub fn report_at_exit(&self) {
        AT_EXIT.set(Some(AtExit(self.clone())));
    }

    /// The window has ended normally, or the reason is reported elsewhere.
    pub fn forget_exit(&self) {
        mem::forget(AT_EXIT.take());
    }

    /// Whether there has been a window.
    pub fn is_open(&self) -> bool {
        self.program.try_borrow().map_or(true, |program| program.is_some())
    }

    /// Ends a running session; returns the file of its rows.
    pub fn close(&self) -> Option<PathBuf> {
        // Borrowed only while drawing, which a caught panic has ended.
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
        // If stderr is closed, the exit status still reports the error.
        let _ = writeln!(std::io::stderr(), "error: {}", WindowError::Lost { reason, rows });
    }
}
