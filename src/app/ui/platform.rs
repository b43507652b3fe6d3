//! The monitor that shows the window, what the user types about it, and what the window system reports, in particular
//! whether codes reach the screen unchanged.
//!
//! X11 reports most of this through RandR. The preflight asks the person at the screen about everything else.

use eframe::egui;
use x11rb::{
    connection::Connection as _,
    protocol::{
        randr::{self, ConnectionExt as _, ModeInfo},
        xproto::ConnectionExt as _,
    },
    rust_connection::RustConnection,
};

use crate::{display::Monitor, store::settings::ScreenFields};

/// The properties of a screen; `None` for those that the system does not report.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Platform {
    /// `X11`, `Wayland`, or the name of the operating system.
    pub window_system: &'static str,
    /// Whether there is a compositor between the window and the screen.
    pub composited: Option<bool>,
    /// Whether the graphics card leaves codes unchanged: its gamma ramps are straight.
    pub ramps_straight: Option<bool>,
    /// Whether the system resamples the image on its way to the screen.
    pub resampled: Option<bool>,
    /// Width and height of the current mode, pixels.
    pub mode_px: Option<[u32; 2]>,
    /// Native width and height of the screen, pixels.
    pub own_px: Option<[u32; 2]>,
    /// Width of the display area in cm, as reported by the screen.
    pub width_cm: Option<f64>,
    /// Whether the screen supports variable refresh.
    pub variable_refresh: Option<bool>,
    /// Whether the screen supports high dynamic range.
    pub hdr: Option<bool>,
}

impl Platform {
    /// Returns what the system reports about a monitor.
    pub fn of(monitor: &Monitor) -> Self {
        let set = |name| std::env::var_os(name).is_some_and(|value| !value.is_empty());
        match () {
            () if !cfg!(target_os = "linux") => Self { window_system: std::env::consts::OS, ..Self::default() },
            // On Wayland, the compositor is the window system.
            () if set("WAYLAND_DISPLAY") => {
                Self { window_system: "Wayland", composited: Some(true), ..Self::default() }
            }
            // X11 does not support high dynamic range.
            () if set("DISPLAY") => {
                let known = Self { window_system: "X11", hdr: Some(false), ..Self::default() };
                known.clone().ask_x11(monitor).unwrap_or(known)
            }
            () => Self { window_system: "none", ..Self::default() },
        }
    }

    /// Adds what the X server reports; `None` if the server does not answer.
    fn ask_x11(mut self, monitor: &Monitor) -> Option<Self> {
        let (x, number) = RustConnection::connect(None).ok()?;
        let root = x.setup().roots.get(number)?.root;
        let manager = x.intern_atom(false, format!("_NET_WM_CM_S{number}").as_bytes()).ok()?.reply().ok()?.atom;
        let owner = x.get_selection_owner(manager).ok()?.reply().ok()?.owner;
        self.composited = Some(owner != x11rb::NONE);
        let resources = x.randr_get_screen_resources_current(root).ok()?.reply().ok()?;
        for output in resources.outputs {
            let info = x.randr_get_output_info(output, resources.config_timestamp).ok()?.reply().ok()?;
            // A monitor without a name matches every output.
            let is_named = |wanted: &String| wanted.as_bytes() == info.name;
            if info.crtc == x11rb::NONE || !monitor.name.as_ref().is_none_or(is_named) {
                continue;
            }
            let mode = |id: u32| resources.modes.iter().find(|mode| mode.id == id);
            if info.num_preferred > 0 {
                self.own_px = info.modes.first().and_then(|id| mode(*id)).map(px);
            }
            self.width_cm = (info.mm_width > 0).then(|| f64::from(info.mm_width) / 10.0);
            self.variable_refresh = vrr_capable(&x, output);
            let crtc = x.randr_get_crtc_info(info.crtc, resources.config_timestamp).ok()?.reply().ok()?;
            if let Some(mode) = mode(crtc.mode) {
                self.mode_px = Some(px(mode));
                self.resampled = Some(is_resampled(mode, &crtc));
            }
            let ramps = x.randr_get_crtc_gamma(info.crtc).ok()?.reply().ok()?;
            let ramps = [ramps.red, ramps.green, ramps.blue];
            self.ramps_straight = ramps.iter().try_fold(true, |all, ramp| Some(all && is_straight(ramp)?));
            break;
        }
        Some(self)
    }
}

fn px(mode: &ModeInfo) -> [u32; 2] {
    [mode.width.into(), mode.height.into()]
}

/// Returns whether the visible part of the desktop differs in size from the mode, so that it is scaled.
pub fn is_resampled(mode: &ModeInfo, crtc: &randr::GetCrtcInfoReply) -> bool {
    let turned =
        crtc.rotation.contains(randr::Rotation::ROTATE90) || crtc.rotation.contains(randr::Rotation::ROTATE270);
    let (width, height) = if turned { (mode.height, mode.width) } else { (mode.width, mode.height) };
    (width, height) != (crtc.width, crtc.height)
}

/// Returns whether the driver says that the output supports variable refresh.
fn vrr_capable(x: &RustConnection, output: randr::Output) -> Option<bool> {
    let property = x.intern_atom(true, b"vrr_capable").ok()?.reply().ok()?.atom;
    if property == x11rb::NONE {
        return None;
    }
    let kind = x11rb::protocol::xproto::AtomEnum::ANY;
    let reply = x.randr_get_output_property(output, property, kind, 0, 1, false, false).ok()?.reply().ok()?;
    reply.data.first().map(|value| *value != 0)
}

/// Returns whether a gamma ramp leaves every code unchanged; `None` if there is no ramp. A ramp that is dark
/// throughout, as on virtual screens, does not count.
fn is_straight(ramp: &[u16]) -> Option<bool> {
    let last = ramp.len().checked_sub(1).filter(|last| *last > 0 && ramp[*last] > 0)?;
    let off = |(i, value): (usize, &u16)| (f64::from(*value) - i as f64 / last as f64 * f64::from(u16::MAX)).abs();
    // One 8-bit code corresponds to 257 steps of a ramp.
    Some(ramp.iter().enumerate().map(off).fold(0.0, f64::max) < 257.0)
}

impl Monitor {
    /// Returns the monitor that shows the window now; without a window, as in tests, a monitor of the size of the page.
    pub fn current(ctx: &egui::Context, frame: &eframe::Frame) -> Self {
        let Some(monitor) = frame.winit_window().and_then(|window| window.current_monitor()) else {
            let (width_px, height_px) = window_px(ctx);
            return Self {
                name: None,
                width_px,
                height_px,
                refresh_hz: None,
                scale: f64::from(ctx.pixels_per_point()),
            };
        };
        Self {
            name: monitor.name(),
            width_px: monitor.size().width,
            height_px: monitor.size().height,
            refresh_hz: monitor.refresh_rate_millihertz().map(|mhz| f64::from(mhz) / 1000.0),
            scale: monitor.scale_factor(),
        }
    }
}

/// Returns the width and height of the window's content in physical pixels.
pub fn window_px(ctx: &egui::Context) -> (u32, u32) {
    let size = ctx.content_rect().size() * ctx.pixels_per_point();
    (size.x.round() as u32, size.y.round() as u32)
}

impl ScreenFields {
    /// Returns whether the screen's width is assumed rather than measured or typed.
    pub fn width_is_assumed(&self) -> bool {
        self.screen_width_cm.trim().is_empty()
    }
}
