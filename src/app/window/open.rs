//! Opens the window.

use std::sync::Arc;

use eframe::{
    CreationContext, NativeOptions,
    egui::{self, ViewportBuilder},
    egui_wgpu::WgpuSetup,
    wgpu::DeviceDescriptor,
};

use super::{
    event_loop,
    input::{Input, Stamps},
    program::{Program, Shared, WindowError},
};
use crate::app::ui::logo;

/// Size of the window at first, points. It fits a screen of 1366 × 768 pixels with its bars.
const SIZE: egui::Vec2 = egui::vec2(1280.0, 700.0);
/// Minimum size of the window outside sessions, points.
pub const MIN_SIZE: egui::Vec2 = egui::vec2(520.0, 360.0);

/// Opens the window; returns when it is closed. `make` creates the program that runs in it.
///
/// # Errors
/// [`WindowError`] if there is no display or no graphics, or if one of them is lost.
pub fn open<P: Program + 'static>(
    fullscreen: bool,
    make: impl FnOnce(&CreationContext<'_>, Input) -> P + 'static,
) -> Result<(), WindowError> {
    let set = |name| std::env::var_os(name).is_some_and(|value| !value.is_empty());
    if cfg!(target_os = "linux") && !set("DISPLAY") && !set("WAYLAND_DISPLAY") {
        return Err(WindowError::NoDisplay);
    }
    let stamps = Stamps::default();
    let input = Input::stamped(stamps.clone());
    event_loop::run(options(fullscreen), stamps, Shared::new(|cc| Box::new(make(cc, input))))
}

fn options(fullscreen: bool) -> NativeOptions {
    let mut options = NativeOptions {
        viewport: ViewportBuilder::default()
            .with_title("machband")
            .with_inner_size(SIZE)
            .with_app_id("machband")
            .with_icon(logo::icon())
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
