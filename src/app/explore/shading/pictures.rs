//! Draws the two images of a comparison, on the CPU or on the graphics card of the window. Redraws them only if
//! something has changed.

use std::{sync::Arc, time::Instant};

use eframe::{
    egui::{self, Color32, ColorImage, TextureHandle, TextureId},
    egui_wgpu::RenderState,
    wgpu,
};

use super::comparison::Comparison;
use crate::{
    app::ui::pixels::{self, Canvas},
    light::{CodeImage, Samples},
    shading::{
        Encoder, Frame, Prepared, Surface,
        gpu::{self, Gpu, GpuError},
    },
    stimulus::Shot,
};

/// The processor that draws the images.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DrawnBy {
    Cpu,
    Gpu,
}

/// The CPU, and the graphics card if it can draw.
pub struct Drawer {
    /// Textures for the images that the CPU draws, left and right.
    canvases: [Canvas; 2],
    gpu: Result<WindowGpu, String>,
    /// The processor to use if both can draw.
    pub wanted: DrawnBy,
}

impl Drawer {
    /// Uses the window's graphics card if it has one. A software adapter is no faster than the CPU, so the CPU is then
    /// preferred.
    pub fn new(state: Option<&RenderState>) -> Drawer {
        let gpu = match state {
            Some(state) => WindowGpu::new(state).map_err(|error| error.to_string()),
            None => Err("no graphics adapter".to_owned()),
        };
        let is_fast = gpu.as_ref().is_ok_and(|gpu| gpu.info.device_type != wgpu::DeviceType::Cpu);
        Drawer { canvases: Default::default(), gpu, wanted: if is_fast { DrawnBy::Gpu } else { DrawnBy::Cpu } }
    }

    /// Returns the processor that draws.
    pub fn by(&self) -> DrawnBy {
        if self.gpu.is_ok() { self.wanted } else { DrawnBy::Cpu }
    }

    /// Returns the name of the processor that draws.
    pub fn name(&self) -> String {
        match self.by() {
            DrawnBy::Cpu => "CPU".to_owned(),
            DrawnBy::Gpu => self.gpu_name().unwrap_or_default(),
        }
    }

    /// Returns the name of the graphics card, or the reason why it cannot draw.
    pub fn gpu_name(&self) -> Result<String, &str> {
        self.gpu.as_ref().map(WindowGpu::name).map_err(String::as_str)
    }

    /// Draws one side; `which` is 0 for left and 1 for right.
    fn draw(&mut self, ctx: &egui::Context, which: usize, shot: &Shot<'_>) -> Picture {
        if self.by() == DrawnBy::Gpu
            && let Ok(gpu) = &mut self.gpu
        {
            match gpu.draw(shot) {
                Ok((picture, ms)) => return Picture { image: Image::Gpu(picture), ms },
                // From now on, the CPU draws, and the page says why.
                Err(error) => self.gpu = Err(error.to_string()),
            }
        }
        let started = Instant::now();
        let mut pixels =
            ColorImage::filled([shot.frame.width, shot.frame.height].map(|side| side as usize), Color32::BLACK);
        let encoder = Encoder::new(&shot.transfers.channels()[0]);
        let prepared = Prepared::new(&shot.frame, &shot.shade);
        prepared.codes(&encoder, bytemuck::cast_slice_mut(&mut pixels.pixels));
        let ms = ms_since(started);
        let pixels = Arc::new(pixels);
        let texture = self.canvases[which].put(ctx, "shading", pixels.clone());
        Picture { image: Image::Cpu(pixels, texture), ms }
    }
}

/// The picture of one side.
pub struct Picture {
    image: Image,
    /// Drawing time, ms.
    pub ms: f64,
}

/// An image in the memory of the CPU or of the graphics card.
enum Image {
    Cpu(Arc<ColorImage>, TextureHandle),
    Gpu(GpuPicture),
}

impl Picture {
    /// Returns the picture's texture in egui.
    pub fn id(&self) -> TextureId {
        match &self.image {
            Image::Cpu(_, texture) => texture.id(),
            Image::Gpu(picture) => picture.id,
        }
    }

    /// Returns the picture's codes; `None` if they cannot be read back from the graphics card.
    pub fn codes(&self) -> Option<CodeImage> {
        match &self.image {
            Image::Cpu(pixels, _) => {
                let [width, height] = pixels.size.map(|side| side as u32);
                let codes = pixels.pixels.iter().flat_map(|pixel| [pixel.r(), pixel.g(), pixel.b()]).collect();
                Some(CodeImage { width, height, samples: Samples::Eight(codes) })
            }
            Image::Gpu(GpuPicture { texture, state, .. }) => gpu::codes(&state.device, &state.queue, texture).ok(),
        }
    }
}

/// Both pictures of a comparison at a size.
pub struct Pictures {
    /// The comparison that they show.
    pub compared: Comparison,
    /// The surface that they show.
    pub surface: Arc<Surface>,
    by: DrawnBy,
    /// A number that increases whenever either image changes.
    pub edition: u64,
    /// The surface on the screen, in linear light.
    pub frame: Frame,
    /// Time to transform and light the vertices, ms.
    pub frame_ms: f64,
    /// The left and the right picture.
    pub sides: [Picture; 2],
}

impl Pictures {
    /// Returns the pictures of `compared`, or `before` if it is up to date.
    pub fn updated(
        ctx: &egui::Context,
        before: Option<Pictures>,
        drawer: &mut Drawer,
        surface: &Arc<Surface>,
        compared: &Comparison,
        size: [u32; 2],
    ) -> Pictures {
        let edition = before.as_ref().map_or(0, |before| before.edition + 1);
        let is_right = |p: &Pictures| {
            [p.frame.width, p.frame.height] == size
                && (Arc::ptr_eq(&p.surface, surface), p.by, &p.compared) == (true, drawer.by(), compared)
        };
        // Old images are dropped before new ones are drawn, because they occupy memory on the card.
        if let Some(before) = before.filter(is_right) {
            return before;
        }
        let started = Instant::now();
        let frame = compared.scene.frame(surface, size[0], size[1]);
        let frame_ms = ms_since(started);
        let sides = [0, 1].map(|which| drawer.draw(ctx, which, &compared.shot(&compared.sides[which], &frame)));
        let (compared, surface, by) = (compared.clone(), surface.clone(), drawer.by());
        Pictures { compared, surface, by, edition, frame, frame_ms, sides }
    }
}

/// The difference between two images, and the version of the images that it was computed from.
pub struct Difference {
    edition: u64,
    factor: u8,
    pub codes: CodeImage,
    /// The difference as a texture.
    pub texture: TextureHandle,
}

impl Difference {
    /// Returns the difference of `pictures` times `factor`, or `before` if it is up to date; `None` if an image cannot
    /// be read back from the graphics card.
    pub fn updated(ctx: &egui::Context, before: Option<Self>, pictures: &Pictures, factor: u8) -> Option<Difference> {
        if let Some(before) = before.filter(|d| d.edition == pictures.edition && d.factor == factor) {
            return Some(before);
        }
        let [left, right] = &pictures.sides;
        let codes =
            combined(&left.codes()?, &right.codes()?, |_, left, right| left.abs_diff(right).saturating_mul(factor));
        let texture = pixels::texture_of(ctx, "difference", &codes);
        Some(Difference { edition: pictures.edition, factor, codes, texture })
    }
}

/// Returns the left image up to a column and the right image from that column on, as at the divider.
pub fn divided([left, right]: [&CodeImage; 2], column: u32) -> CodeImage {
    combined(left, right, |x, left, right| if x < column { left } else { right })
}

fn combined(left: &CodeImage, right: &CodeImage, code: impl Fn(u32, u8, u8) -> u8) -> CodeImage {
    let (a, b) = (left.bytes().unwrap_or_default(), right.bytes().unwrap_or_default());
    let row = left.width.max(1) as usize * 3;
    let codes = a.iter().zip(b).enumerate().map(|(i, (a, b))| code((i % row / 3) as u32, *a, *b)).collect();
    CodeImage { width: left.width, height: left.height, samples: Samples::Eight(codes) }
}

fn ms_since(started: Instant) -> f64 {
    started.elapsed().as_secs_f64() * 1e3
}

struct WindowGpu {
    state: RenderState,
    gpu: Gpu,
    info: wgpu::AdapterInfo,
}

/// A picture in the memory of the card. It is registered with egui until it is dropped.
struct GpuPicture {
    texture: wgpu::Texture,
    id: TextureId,
    state: RenderState,
}

impl WindowGpu {
    /// Returns the card that draws the window.
    ///
    /// # Errors
    /// If its device cannot run the shaders.
    fn new(state: &RenderState) -> Result<WindowGpu, GpuError> {
        let gpu = Gpu::new(&state.device, &state.queue)?;
        Ok(WindowGpu { state: state.clone(), gpu, info: state.adapter.get_info() })
    }

    /// Returns the name of the card and of its graphics interface.
    fn name(&self) -> String {
        format!("{}, {:?}", self.info.name, self.info.backend)
    }

    /// Draws a shot; returns the picture and the time in milliseconds.
    ///
    /// # Errors
    /// If the frame is too large for the card, or if the driver fails.
    fn draw(&mut self, shot: &Shot<'_>) -> Result<(GpuPicture, f64), GpuError> {
        let started = Instant::now();
        let texture = self.gpu.draw(&shot.frame, &shot.shade, &shot.transfers.channels()[0])?;
        let ms = ms_since(started);
        let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
        let mut renderer = self.state.renderer.write();
        let id = renderer.register_native_texture(&self.state.device, &view, wgpu::FilterMode::Nearest);
        Ok((GpuPicture { texture, id, state: self.state.clone() }, ms))
    }
}

impl Drop for GpuPicture {
    fn drop(&mut self) {
        self.state.renderer.write().free_texture(&self.id);
    }
}
