//! Draws the two images of a comparison, only if something has changed, and measures them. The visible difference from the
//! smooth surface is computed on a separate thread while nothing is dragged. Light and its slope along a line are computed
//! by the shaders rather than from pixels.

use eframe::egui::{self, Pos2, TextureHandle, TextureId};
use egui_plot::Line;
use glam::{DVec2, DVec3};

use super::comparison::Comparison;
use crate::{
    app::ui::{describe, hint, pixels, still_plot, theme::ink},
    light::{Bits, CodeImage, Quantizer, Samples, Transfers},
    shading::{Frame, Shade, Surface, crease, image},
    stimulus::{Judged, ViewingConditions, along, emitted},
    vision::luminance,
};

/// The picture of one side.
pub struct Picture {
    /// Its codes.
    pub codes: CodeImage,
    texture: TextureHandle,
}

impl Picture {
    pub fn new(ctx: &egui::Context, codes: CodeImage) -> Self {
        Self { texture: pixels::texture(ctx, "shading", &codes), codes }
    }

    /// Returns the picture's texture in egui.
    pub fn id(&self) -> TextureId {
        self.texture.id()
    }
}

/// What determines both pictures.
#[derive(Clone, PartialEq)]
pub struct Wanted {
    pub compared: Comparison,
    /// The number of meshes that were loaded so far: the content of a file may have changed.
    pub loaded: usize,
    /// The transfer functions of the display.
    pub transfers: Transfers,
    pub size: [u32; 2],
}

/// Both pictures of a comparison at a size.
pub struct Pictures {
    /// What they show.
    pub wanted: Wanted,
    /// The surface on the screen, in linear light.
    pub frame: Frame,
    /// The left and the right picture.
    pub sides: [Picture; 2],
}

impl Pictures {
    pub fn new(ctx: &egui::Context, surface: &Surface, wanted: Wanted) -> Self {
        let Wanted { compared, transfers, size: [width, height], .. } = &wanted;
        let frame = compared.scene.frame(surface, *width, *height);
        let quantizer = Quantizer::new(transfers, Bits::Eight);
        let sides = compared.sides.map(|side| Picture::new(ctx, quantizer.quantize(&image(&frame, &side))));
        Self { wanted, frame, sides }
    }
}

/// Returns the left image up to a column and the right image from that column on, as at the divider.
pub fn divided([left, right]: [&CodeImage; 2], column: u32) -> CodeImage {
    let row = left.width.max(1) as usize * 3;
    let is_left = |i: usize| i % row < 3 * column as usize;
    let both = left.bytes().into_iter().flatten().zip(right.bytes().into_iter().flatten()).enumerate();
    let codes = both.map(|(i, (left, right))| if is_left(i) { *left } else { *right }).collect();
    CodeImage { width: left.width, height: left.height, samples: Samples::Eight(codes) }
}

/// Side of the square image used for predictions, pixels, which shows the whole mesh: the prediction does not depend on the
/// room for the picture. A larger image would take longer and change it little.
const SIDE_PX: u32 = ViewingConditions::PICTURE_PX;

/// How visible the difference of both sides from the smooth surface is.
pub struct Measured {
    /// The largest difference, times threshold.
    pub largest: [f64; 2],
    pub maps: [Picture; 2],
    /// The difference with the last color of the maps.
    pub full_scale: f64,
}

/// The color of a map beside the mesh, encoded.
const BESIDE: [f64; 3] = [0.2; 3];

/// Judges how visible the difference from the smooth surface is.
pub fn visible(
    ctx: &egui::Context,
    surface: &Surface,
    Wanted { compared, size, .. }: &Wanted,
) -> Result<Measured, String> {
    let frame = compared.scene.frame(surface, SIDE_PX, SIDE_PX).unpainted();
    let viewing = ViewingConditions::new(ViewingConditions::WINDOW_DEG);
    let judged = Judged::known(&frame);
    let judge = |side: &Shade| {
        let found = judged.difference(&viewing, &emitted(&frame, side));
        found.map_err(|error| error.to_string())?.ok_or_else(|| "the smooth surface is not known".to_owned())
    };
    let sides = [judge(&compared.sides[0])?, judge(&compared.sides[1])?];
    let full_scale = sides.iter().map(|side| side.largest).fold(1.0, f64::max);
    let maps = sides.each_ref().map(|side| {
        let (times, [across, down]) = (side.map.enlarged(), *size);
        // The square is in the middle of the picture.
        let shorter = across.min(down).max(1);
        let from = |place: u32, side: u32| {
            let place = place.checked_sub((side - shorter) / 2)? * SIDE_PX / shorter;
            (place < SIDE_PX).then_some(place as usize)
        };
        let color = |x: u32, y: u32| {
            let pixel = from(x, across).zip(from(y, down)).map(|(x, y)| y * SIDE_PX as usize + x);
            let shown = pixel.filter(|pixel| judged.shown[*pixel]);
            let color = shown.map_or(BESIDE, |pixel| crease::color(times[pixel] / full_scale));
            color.map(|encoded| (encoded * 255.0).round() as u8)
        };
        let codes = (0..down).flat_map(|y| (0..across).map(move |x| (x, y))).flat_map(|(x, y)| color(x, y));
        Picture::new(ctx, CodeImage { width: across, height: down, samples: Samples::Eight(codes.collect()) })
    });
    Ok(Measured { largest: sides.map(|side| side.largest), maps, full_scale })
}

/// Samples per pixel of the scan line, and the maximum number of samples.
const DENSITY: f64 = 4.0;
const MAX_SAMPLES: f64 = 4096.0;

/// A curve in pieces; there are gaps where the line does not cross the surface.
type Curve = Vec<Vec<[f64; 2]>>;

/// The curves of both sides. The horizontal axis is the distance from the start of the line in pixels.
pub struct Scan {
    light: [Curve; 2],
    slope: [Curve; 2],
}

impl Scan {
    /// Returns the curves along a line.
    pub fn new(pictures: &Pictures, line: [Pos2; 2]) -> Self {
        let frame = &pictures.frame;
        let size = DVec2::new(f64::from(frame.view.width), f64::from(frame.view.height));
        let ends = line.map(|end| DVec2::new(f64::from(end.x), f64::from(end.y)) * size);
        let length = ends[0].distance(ends[1]);
        let count = (length * DENSITY).clamp(0.0, MAX_SAMPLES) as usize;
        let light = pictures.wanted.compared.sides.map(|side| {
            let lights = along(frame, &side, ends, count);
            let at = |i: usize, light: DVec3| {
                [(i as f64 + 0.5) / count as f64 * length, luminance(light.as_vec3().to_array())]
            };
            let points: Vec<_> = lights.into_iter().enumerate().map(|(i, light)| Some(at(i, light?))).collect();
            let pieces = points.split(Option::is_none).filter(|piece| !piece.is_empty());
            pieces.map(|piece| piece.iter().flatten().copied().collect()).collect::<Curve>()
        });
        let slope = light.each_ref().map(|curve| curve.iter().map(|piece| slopes(piece)).collect());
        Self { light, slope }
    }

    /// Draws both plots side by side in the remaining space of the page.
    pub fn show(&self, ui: &mut egui::Ui, titles: &[String; 2]) {
        let spacing = ui.spacing().item_spacing.x;
        let size = egui::vec2((ui.available_width() - spacing) / 2.0, ui.available_height());
        ui.horizontal(|ui| {
            for (what, curves) in [("light", &self.light), ("slope, light per pixel", &self.slope)] {
                ui.allocate_ui(size, |ui| ui.vertical(|ui| plot(ui, what, titles, curves)));
            }
        });
    }
}

fn plot(ui: &mut egui::Ui, what: &str, titles: &[String; 2], curves: &[Curve; 2]) {
    hint(ui, format!("{what}, along the scan line"));
    let sides = ink(ui).sides();
    let plot = still_plot(ui, what, ["pixels from the ring", ""])
        .width(ui.available_width())
        .height(ui.available_height())
        .y_axis_min_width(44.0);
    let plot = plot.show(ui, |plot| {
        for ((pieces, color), title) in curves.iter().zip(sides).zip(titles) {
            for piece in pieces {
                plot.line(Line::new(title.clone(), piece.clone()).color(color).width(1.5));
            }
        }
    });
    describe(&plot.response, &format!("Plot: {what} along the scan line"));
}

/// Returns the slope between each pair of neighboring points, placed at their midpoint.
fn slopes(points: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let slope = |pair: &[[f64; 2]]| (pair[1][1] - pair[0][1]) / (pair[1][0] - pair[0][0]);
    points.windows(2).map(|pair| [(pair[0][0] + pair[1][0]) / 2.0, slope(pair)]).collect()
}
