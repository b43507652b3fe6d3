//! Opens the window and runs eframe's event loop, and timestamps keys and clicks before it passes them on.

use std::{
    mem::ManuallyDrop,
    panic::{self, AssertUnwindSafe},
    sync::{Arc, Mutex, Once, PoisonError},
    time::{Duration, Instant},
};

use eframe::{
    CreationContext, EframeWinitApplication, NativeOptions, UserEvent,
    egui::{self, Key, ViewportBuilder},
    egui_wgpu::WgpuSetup,
    wgpu::DeviceDescriptor,
};
use winit::{
    application::ApplicationHandler,
    event::{DeviceEvent, DeviceId, ElementState, StartCause, WindowEvent},
    event_loop::{ActiveEventLoop, EventLoop},
    keyboard::PhysicalKey,
    window::WindowId,
};

use super::{
    input::{Input, Pressed, Stamps},
    program::{Program, Shared, WindowError},
};
use crate::{app::ui::pixels, system::signals};

/// Size of the window at first, points. It fits a screen of 1366 × 768 pixels with its bars.
const SIZE: egui::Vec2 = egui::vec2(1280.0, 700.0);
/// Minimum size of the window outside sessions, points.
pub const MIN_SIZE: egui::Vec2 = egui::vec2(520.0, 360.0);

/// Opens the window; returns when it is closed. `make` creates the program that runs in it.
///
/// # Errors
/// [`WindowError::Refused`] if there is no display, or with the reason that the window system or the graphics driver gave;
/// [`WindowError::Lost`] if one of them was lost while the window was open; [`WindowError::Ended`] after a signal.
pub fn open<P: Program + 'static>(
    fullscreen: bool,
    make: impl FnOnce(&CreationContext<'_>, Input) -> P + 'static,
) -> Result<(), WindowError> {
    let set = |name| std::env::var_os(name).is_some_and(|value| !value.is_empty());
    if cfg!(target_os = "linux") && !set("DISPLAY") && !set("WAYLAND_DISPLAY") {
        return Err(WindowError::Refused("neither DISPLAY nor WAYLAND_DISPLAY is set".to_owned()));
    }
    let refused = |error: &dyn std::fmt::Display| WindowError::Refused(error.to_string());
    listen_to_log();
    let events = EventLoop::<UserEvent>::with_user_event().build().map_err(|error| refused(&error))?;
    let (program, stamps) = (Shared::default(), Stamps::default());
    let failure = program.failure.clone();
    signals::watch();
    failure.report_panics();
    program.report_at_exit();
    let input = Input::stamped(stamps.clone());
    let creator = program.creator(|cc| make(cc, input));
    let inner = eframe::create_native("machband", options(fullscreen), creator, &events);
    // After a failure, the handler is not dropped, because dropping it would call a window system or a graphics card
    // that was lost.
    let mut handler = ManuallyDrop::new(Handler {
        inner,
        program,
        stamps,
        polled: None,
        idle_since: None,
        unseen_since: Instant::now(),
    });
    let ran = panic::catch_unwind(AssertUnwindSafe(|| events.run_app(&mut *handler)));
    match &ran {
        Err(_) => failure.report(UNKNOWN.to_owned()),
        Ok(Err(error)) if handler.program.is_open() => failure.report(error.to_string()),
        Ok(_) => {}
    }
    handler.program.forget_exit();
    if let Some(reason) = failure.reason() {
        let rows = handler.program.close();
        return Err(WindowError::Lost { reason, rows });
    }
    let rows = ManuallyDrop::into_inner(handler).program.close();
    if let Some(signal) = signals::received() {
        return Err(WindowError::Ended { signal, rows });
    }
    if let Ok(Err(error)) = ran {
        return Err(refused(&error));
    }
    // eframe reports the reason for stopping only in its log.
    match LOGGED.lock().unwrap_or_else(PoisonError::into_inner).take() {
        Some(reason) => Err(WindowError::Refused(reason)),
        None => Ok(()),
    }
}

fn options(fullscreen: bool) -> NativeOptions {
    let mut options = NativeOptions {
        viewport: ViewportBuilder::default()
            .with_title("machband")
            .with_inner_size(SIZE)
            .with_app_id("machband")
            .with_icon(pixels::icon())
            .with_min_inner_size(MIN_SIZE)
            .with_fullscreen(fullscreen),
        // egui's dither would add noise to every pixel, including the stimulus.
        dithering: false,
        ..Default::default()
    };
    // Requests the limits of the graphics card, because a weak card may not reach eframe's defaults.
    if let WgpuSetup::CreateNew(setup) = &mut options.wgpu_options.wgpu_setup {
        setup.device_descriptor = Arc::new(|adapter| DeviceDescriptor {
            label: Some("machband"),
            required_limits: adapter.limits(),
            ..Default::default()
        });
    }
    // Only one frame in flight, so that an image reaches the screen as soon as the system allows.
    options.wgpu_options.surface.desired_maximum_frame_latency = Some(1);
    options
}

/// The reason of a panic that another thread began; one of this thread is reported with its message.
const UNKNOWN: &str = "no reason given";

/// If the loop wakes after at least this time, it was idle, and the events that it finds have just woken it.
const MIN_IDLE: Duration = Duration::from_micros(500);

/// Timestamps keys and clicks, and passes all events to eframe.
struct Handler<'a> {
    inner: EframeWinitApplication<'a>,
    /// The program in the window, which is closed if the window is lost.
    program: Shared,
    stamps: Stamps,
    /// When this iteration finished reading events and began to draw; `None` until then.
    polled: Option<Instant>,
    /// When the last iteration ended.
    idle_since: Option<Instant>,
    /// When events were last read before this iteration, or when they woke an idle loop.
    unseen_since: Instant,
}

impl<'a> Handler<'a> {
    /// Passes an event to eframe. Once the window or the graphics are lost, or a signal asks the program to end, closes
    /// the session and ends the loop.
    fn forward(&mut self, events: &ActiveEventLoop, to: impl FnOnce(&mut EframeWinitApplication<'a>)) {
        let failure = &self.program.failure;
        if failure.reason().is_none() && panic::catch_unwind(AssertUnwindSafe(|| to(&mut self.inner))).is_err() {
            failure.report(UNKNOWN.to_owned());
        }
        if failure.reason().is_some() || signals::received().is_some() {
            self.program.close();
            events.exit();
        }
    }

    /// Begins an iteration. Its events have arrived since the previous iteration read events, or have just woken an
    /// idle loop.
    fn wake(&mut self, now: Instant) {
        let slept = self.idle_since.is_some_and(|since| now.saturating_duration_since(since) > MIN_IDLE);
        self.unseen_since = if slept { now } else { self.polled.take().unwrap_or(now) };
        self.polled = None;
    }

    fn stamp(&mut self, event: &WindowEvent) {
        let now = Instant::now();
        let pressed = match event {
            WindowEvent::RedrawRequested => {
                self.polled.get_or_insert(now);
                return;
            }
            WindowEvent::KeyboardInput { event, is_synthetic: false, .. }
                if event.state == ElementState::Pressed && !event.repeat =>
            {
                key(event.physical_key).map(Pressed::Key)
            }
            WindowEvent::MouseInput { state: ElementState::Released, .. } => Some(Pressed::Click),
            _ => None,
        };
        if let Some(pressed) = pressed {
            self.stamps.press(pressed, now, now.saturating_duration_since(self.unseen_since));
        }
    }
}

/// Returns the key at a position, for digits and letters only, because only these can be answers.
fn key(physical: PhysicalKey) -> Option<Key> {
    let PhysicalKey::Code(code) = physical else { return None };
    let name = format!("{code:?}");
    let short = ["Digit", "Numpad", "Key"].iter().find_map(|kind| name.strip_prefix(kind));
    short.filter(|short| short.len() == 1).and_then(Key::from_name)
}

impl ApplicationHandler<UserEvent> for Handler<'_> {
    fn new_events(&mut self, events: &ActiveEventLoop, cause: StartCause) {
        self.wake(Instant::now());
        self.forward(events, |inner| inner.new_events(events, cause));
    }

    fn window_event(&mut self, events: &ActiveEventLoop, window: WindowId, event: WindowEvent) {
        self.stamp(&event);
        self.forward(events, |inner| inner.window_event(events, window, event));
    }

    fn about_to_wait(&mut self, events: &ActiveEventLoop) {
        self.forward(events, |inner| inner.about_to_wait(events));
        let now = Instant::now();
        self.polled.get_or_insert(now);
        self.idle_since = Some(now);
    }

    fn resumed(&mut self, events: &ActiveEventLoop) {
        self.forward(events, |inner| inner.resumed(events));
    }

    fn user_event(&mut self, events: &ActiveEventLoop, event: UserEvent) {
        self.forward(events, |inner| inner.user_event(events, event));
    }

    fn device_event(&mut self, events: &ActiveEventLoop, device: DeviceId, event: DeviceEvent) {
        self.forward(events, |inner| inner.device_event(events, device, event));
    }

    fn exiting(&mut self, events: &ActiveEventLoop) {
        self.forward(events, |inner| inner.exiting(events));
    }
}

/// The reason why eframe stopped, from its log.
static LOGGED: Mutex<Option<String>> = Mutex::new(None);
/// The text that precedes the reason in eframe's log.
const REASON_PREFIX: &str = "Exiting because of error: ";

struct Listener;

impl log::Log for Listener {
    fn enabled(&self, metadata: &log::Metadata<'_>) -> bool {
        metadata.level() == log::Level::Error && metadata.target().starts_with("eframe")
    }

    fn log(&self, record: &log::Record<'_>) {
        if self.enabled(record.metadata())
            && let Some(reason) = record.args().to_string().strip_prefix(REASON_PREFIX)
        {
            *LOGGED.lock().unwrap_or_else(PoisonError::into_inner) = Some(reason.to_owned());
        }
    }

    fn flush(&self) {}
}

fn listen_to_log() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        // A program that has set its own logger keeps it and can find the reason there.
        if log::set_logger(&Listener).is_ok() {
            log::set_max_level(log::LevelFilter::Error);
        }
    });
}
