//! A program for comparison of frame times: an empty window.

use std::{
    error::Error,
    sync::Arc,
    time::{Instant, UNIX_EPOCH},
};

use eframe::wgpu;
use winit::{
    application::ApplicationHandler,
    dpi::PhysicalSize,
    event::WindowEvent,
    event_loop::{ActiveEventLoop, ControlFlow, EventLoop},
    window::{Window, WindowId},
};

/// The size of machband's own window.
const SIZE: [u32; 2] = [1100, 860];
/// Frames to skip before counting.
const WARM_UP: usize = 30;

struct Open {
    window: Arc<Window>,
    surface: wgpu::Surface<'static>,
    device: wgpu::Device,
    queue: wgpu::Queue,
}

struct Bare {
    open: Option<Open>,
    frames: usize,
    first: Option<f64>,
    last: Option<Instant>,
    intervals: Vec<f64>,
}

impl Open {
    fn new(events: &ActiveEventLoop) -> Result<Open, Box<dyn Error>> {
        let size = PhysicalSize::new(SIZE[0], SIZE[1]);
        let window = Arc::new(events.create_window(Window::default_attributes().with_inner_size(size))?);
        let instance = wgpu::Instance::default();
        let surface = instance.create_surface(window.clone())?;
        let wanted = wgpu::RequestAdapterOptions { compatible_surface: Some(&surface), ..Default::default() };
        let adapter = pollster::block_on(instance.request_adapter(&wanted))?;
        let (device, queue) = pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor::default()))?;
        let config = surface.get_default_config(&adapter, SIZE[0], SIZE[1]).ok_or("the surface has no format")?;
        // machband uses the same frame latency.
        surface.configure(&device, &wgpu::SurfaceConfiguration { desired_maximum_frame_latency: 1, ..config });
        Ok(Open { window, surface, device, queue })
    }

    /// Clears the window; returns whether there was a surface to clear.
    fn clear(&self) -> bool {
        use wgpu::CurrentSurfaceTexture::{Suboptimal, Success};
        let (Success(texture) | Suboptimal(texture)) = self.surface.get_current_texture() else { return false };
        let view = texture.texture.create_view(&wgpu::TextureViewDescriptor::default());
        let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let ops = wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::BLACK), store: wgpu::StoreOp::Store };
        let attachment = wgpu::RenderPassColorAttachment { view: &view, depth_slice: None, resolve_target: None, ops };
        encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            color_attachments: &[Some(attachment)],
            ..Default::default()
        });
        self.queue.submit([encoder.finish()]);
        self.queue.present(texture);
        true
    }
}

impl ApplicationHandler for Bare {
    fn resumed(&mut self, events: &ActiveEventLoop) {
        match Open::new(events) {
            Ok(open) => self.open.insert(open).window.request_redraw(),
            Err(fault) => {
                eprintln!("error: {fault}");
                std::process::exit(1);
            }
        }
        events.set_control_flow(ControlFlow::Poll);
    }

    fn window_event(&mut self, events: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        let (WindowEvent::RedrawRequested, Some(open)) = (event, &self.open) else { return };
        if open.clear() {
            let now = Instant::now();
            self.first.get_or_insert_with(|| UNIX_EPOCH.elapsed().as_ref().map_or(0.0, |since| since.as_secs_f64()));
            if let Some(last) = self.last.replace(now) {
                self.intervals.push((now - last).as_secs_f64());
            }
        }
        if self.intervals.len() >= WARM_UP + self.frames {
            events.exit();
        }
        open.window.request_redraw();
    }
}

/// The cost of an empty frame: a window that only clears itself, without egui.
///
/// Prints `RESULT`, the time when the first frame was submitted (seconds since 1970), and every interval in seconds.
pub fn bare_window(frames: usize) -> Result<(), Box<dyn Error>> {
    let mut bare = Bare { open: None, frames, first: None, last: None, intervals: Vec::new() };
    EventLoop::new()?.run_app(&mut bare)?;
    print!("RESULT {:.6}", bare.first.unwrap_or_default());
    for interval in bare.intervals.iter().skip(WARM_UP) {
        print!(" {interval:.6}");
    }
    println!();
    Ok(())
}
