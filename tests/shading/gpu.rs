//! Compares the shaders on a graphics card, often a software renderer, with the plain f64 reference.

use std::io::Write as _;

use glam::DVec3;
use machband::{
    light::{Bits, CodeImage, Depth, LinearImage, Quantizer, Transfer, TransferTable},
    shading::{
        Correction, Frame, FrameVertex, Lamp, LampPosition, Lighting, Mesh, Reference, Scene, Shade, Shader, Specular,
        Surface, View, coverage,
        gpu::{self, Gpu, GpuError},
        lighting::{Facets, Microfacets},
        shapes,
    },
};

use crate::grid;

/// Returns a device for the best card of these backends. If there is no card, returns `None`, or panics if
/// `MACHBAND_REQUIRE_GPU` is set.
pub fn device(
    backends: wgpu::Backends,
    limits: impl FnOnce(&wgpu::Adapter) -> wgpu::Limits,
) -> Option<(String, wgpu::Device, wgpu::Queue)> {
    let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle_from_env();
    descriptor.backends = backends;
    let options = wgpu::RequestAdapterOptions::default();
    let adapter = match pollster::block_on(wgpu::Instance::new(descriptor).request_adapter(&options)) {
        Ok(adapter) => adapter,
        Err(error) => {
            assert!(std::env::var_os("MACHBAND_REQUIRE_GPU").is_none(), "{error}, and one is required");
            // Not with `eprintln!`, because the test harness captures it.
            let _ = writeln!(std::io::stderr(), "SKIPPED: a test of the graphics card: {error}");
            return None;
        }
    };
    let descriptor = wgpu::DeviceDescriptor { required_limits: limits(&adapter), ..Default::default() };
    let (device, queue) = pollster::block_on(adapter.request_device(&descriptor)).unwrap();
    Some((adapter.get_info().name, device, queue))
}

/// A graphics card, with everything needed to draw images with it.
struct Card {
    name: String,
    device: wgpu::Device,
    queue: wgpu::Queue,
    gpu: Gpu,
}

impl Card {
    /// Draws `frame`, shaded by `shade`, as 8-bit codes for a display with `transfer`.
    fn image(&mut self, frame: &Frame, shade: &Shade, transfer: &Transfer) -> Result<CodeImage, GpuError> {
        let texture = self.gpu.draw(frame, shade, transfer)?;
        gpu::codes(&self.device, &self.queue, &texture)
    }
}

fn card(backend: wgpu::Backends) -> Option<Card> {
    let (name, device, queue) = device(backend, wgpu::Adapter::limits)?;
    Some(Card { gpu: Gpu::new(&device, &queue).unwrap(), name, device, queue })
}

/// Makes a wavy sheet: it is open, both of its sides are visible, and some of its folds hide others.
fn sheet() -> Mesh {
    let (places, triangles) = grid(14, 14.0, 0.35, 3);
    let places: Vec<DVec3> = places.iter().map(|p| p.extend(2.5 * (0.9 * p.x).sin() + (0.6 * p.y).cos())).collect();
    Mesh::new(&places, &triangles, 180.0).unwrap()
}

fn colored() -> Lighting {
    let mut lighting = Lighting::standard();
    lighting.material.color = DVec3::new(0.9, 0.5, 0.2);
    lighting.ambient = DVec3::new(0.5, 0.7, 1.0);
    lighting.lamps = vec![
        Lamp { intensity: DVec3::new(0.8, 0.8, 0.3), ..Lamp::directional(DVec3::new(-0.4, 0.6, 0.7)) },
        Lamp {
            position: LampPosition::Point { position: DVec3::new(1.5, -0.5, 2.0), attenuation: [0.5, 0.1, 0.15] },
            intensity: DVec3::new(0.3, 0.5, 0.9),
        },
    ];
    lighting
}

fn frames() -> Vec<(&'static str, Frame)> {
    let frame = |mesh, view: View, lighting: Lighting| {
        Frame::new(&Surface::new(mesh), &view, &lighting, DVec3::new(0.02, 0.2, 0.05))
    };
    let wide = View { width: 151, height: 117, distance: 3.0, ..View::square(1) }.rotated([-40.0, 10.0, 30.0]);
    vec![
        ("cube", frame(shapes::cube(), View::square(96).rotated([25.0, -35.0, 0.0]), Lighting::standard())),
        ("blob", frame(shapes::blob(313), View::square(160).rotated([20.0, 30.0, 0.0]), Lighting::standard())),
        ("sheet", frame(sheet(), wide, colored())),
        // Most of it is outside the window.
        ("near", frame(shapes::blob(100), View { fill: 4.0, distance: 1.5, ..View::square(120) }, colored())),
    ]
}

/// Makes a square whose sides run through pixel centers: half of these pixels belong to it.
fn square() -> (&'static str, Frame) {
    let view = View { fill: 36.0 * 3f64.sqrt() / 65.0, ..View::square(65) };
    let frame = Frame::new(&Surface::new(shapes::cube()), &view, &Lighting::standard(), DVec3::ZERO);
    assert!(frame.vertices.iter().all(|v| v.screen == v.screen.trunc() + 0.5));
    ("square", frame)
}

/// Gives each triangle of `frame` a light of its own that encodes the triangle's number.
fn numbered(mut frame: Frame) -> Frame {
    let mut vertices: Vec<FrameVertex> = Vec::new();
    for (t, triangle) in frame.triangles.iter_mut().enumerate() {
        let id = t + 1;
        let light = DVec3::new((id & 255) as f64, (id >> 8 & 255) as f64, (id >> 16) as f64) / 255.0;
        triangle.vertices = triangle.vertices.map(|v| {
            vertices.push(FrameVertex { light, ..frame.vertices[v as usize] });
            (vertices.len() - 1) as u32
        });
    }
    frame.vertices = vertices;
    frame.background = DVec3::ZERO;
    frame
}

fn coverage_agrees(backend: wgpu::Backends) {
    let Some(mut card) = card(backend) else { return };
    for (name, frame) in frames().into_iter().chain([square()]) {
        let image = card.image(&numbered(frame.clone()), &Shade::new(Shader::Gouraud), &Transfer::Linear).unwrap();
        let theirs = image
            .bytes()
            .unwrap()
            .chunks_exact(3)
            .map(|c| (u32::from(c[0]) | u32::from(c[1]) << 8 | u32::from(c[2]) << 16).wrapping_sub(1));
        let ours = coverage::visible(&frame);
        let covered = ours.iter().filter(|id| **id != coverage::NONE).count();
        assert!(covered > ours.len() / 6, "{name}: {covered} pixels only");
        let wrong: Vec<_> = ours.iter().zip(theirs).enumerate().filter(|(_, (a, b))| **a != *b).collect();
        assert!(wrong.is_empty(), "{} {name}: {:?}", card.name, &wrong[..wrong.len().min(20)]);
    }
}

fn shades() -> Vec<Shade> {
    let strips = [(1, 1.0 / 3.0), (2, 0.2), (3, 0.05), (3, 1.0), (9, 0.15), (32, 0.33), (0, 0.2), (2, 0.0)];
    let mut shades = crate::shades(&strips);
    let corrections =
        Correction::ALL.iter().flat_map(|vertex| Correction::ALL.iter().map(move |other| (vertex, other)));
    for (&vertex, &reweight) in corrections {
        shades.extend(Shader::ALL.iter().map(|shader| Shade { vertex, reweight, ..Shade::new(*shader) }));
        for shader in [Shader::Gouraud, Shader::Patch] {
            for (depth, boundary) in [(Depth::Infinite, 0.2), (Depth::Finite(2), 1.0 / 3.0), (Depth::Finite(5), 0.1)] {
                shades.push(Shade { depth, boundary, vertex, reweight, ..Shade::new(shader) });
            }
        }
    }
    shades
}

/// Returns the largest difference between codes and the pixel where it occurs.
fn compare(card: &mut Card, frame: &Frame, light: &LinearImage, shade: &Shade, transfer: &Transfer) -> (u8, usize) {
    let expected = Quantizer::new(transfer, Bits::Eight).quantize(light);
    let image = card.image(frame, shade, transfer).unwrap();
    let differences = expected.bytes().unwrap().iter().zip(image.bytes().unwrap()).map(|(a, b)| a.abs_diff(*b));
    let (at, most) = differences.enumerate().max_by_key(|(_, d)| *d).unwrap();
    (most, at / 3)
}

fn shaders_agree(backend: wgpu::Backends) {
    let Some(mut card) = card(backend) else { return };
    let mut errors = Vec::new();
    for (name, frame) in frames() {
        for shade in shades() {
            let light = Reference::new(&frame, &shade).image();
            let (most, at) = compare(&mut card, &frame, &light, &shade, &Transfer::Srgb);
            let [x, y] = [at as u32 % frame.width, at as u32 / frame.width];
            if most > 1 {
                errors.push(format!("{name}: {most} at {x},{y}: {shade:?}"));
            }
        }
    }
    assert!(errors.is_empty(), "{}: {} faults\n{}", card.name, errors.len(), errors.join("\n"));
}

fn lights_agree(backend: wgpu::Backends) {
    let Some(mut card) = card(backend) else { return };
    let beckmann = Microfacets { facets: Facets::Beckmann, slope: 0.2, index: DVec3::new(20.0, 1.5, 3.0) };
    let gaussian = Microfacets { facets: Facets::Gaussian { c1: 2.0 }, slope: 0.1, ..beckmann };
    let models = [
        (Specular::Phong, 200.0),
        (Specular::Blinn, 60.0),
        (Specular::CookTorrance(beckmann), 1.0),
        (Specular::CookTorrance(gaussian), 1.0),
    ];
    for (name, mut frame) in frames() {
        for (model, shininess) in models {
            frame.lighting.material.specular_model = model;
            frame.lighting.material.shininess = shininess;
            frame.lighting.material.specular_color = DVec3::new(1.0, 0.8, 0.6);
            let shade = Shade::new(Shader::Phong);
            let light = Reference::new(&frame, &shade).image();
            let (most, at) = compare(&mut card, &frame, &light, &shade, &Transfer::Srgb);
            assert!(most <= 1, "{} {name} {model:?}: {most} at {at}", card.name);
        }
    }
}

fn transfers_agree(backend: wgpu::Backends) {
    let Some(mut card) = card(backend) else { return };
    let table = TransferTable::new(vec![0.0, 0.1, 0.35, 0.6, 1.0], vec![0.0, 0.004, 0.1, 0.4, 1.0]).unwrap();
    let frame = &frames()[2].1;
    let shade = Shade::new(Shader::Patch);
    let light = Reference::new(frame, &shade).image();
    for transfer in [
        Transfer::Linear,
        Transfer::Srgb,
        Transfer::Gamma(1.8),
        Transfer::Gamma(2.2),
        Transfer::Gamma(3.0),
        Transfer::Table(table),
        Transfer::gog(2.2, 1.05, -0.05).unwrap(),
    ] {
        let (most, _) = compare(&mut card, frame, &light, &shade, &transfer);
        assert!(most <= 1, "{} {transfer}: {most}", card.name);
    }
}

fn paint_agrees(backend: wgpu::Backends) {
    let Some(mut card) = card(backend) else { return };
    let surface = Surface::new(crate::files::painted_torus());
    for distance in [f64::INFINITY, 2.0] {
        let frame = Scene { distance, specular: 0.3, ..Scene::default() }.frame(&surface, 160, 160);
        for shader in [Shader::Gouraud, Shader::Patch, Shader::Phong, Shader::C1Phong] {
            let shade = Shade::new(shader);
            let light = Reference::new(&frame, &shade).image();
            let (most, at) = compare(&mut card, &frame, &light, &shade, &Transfer::Srgb);
            assert!(most <= 1, "{} {shader} from {distance}: {most} at {at}", card.name);
        }
    }
}

macro_rules! on_both {
    ($($check:ident: $vulkan:ident, $gl:ident;)*) => {
        $(#[test]
        fn $vulkan() {
            $check(wgpu::Backends::VULKAN);
        }

        #[test]
        fn $gl() {
            $check(wgpu::Backends::GL);
        })*
    };
}

on_both! {
    coverage_agrees: coverage_on_vulkan, coverage_on_gl;
    shaders_agree: shaders_on_vulkan, shaders_on_gl;
    lights_agree: lights_on_vulkan, lights_on_gl;
    transfers_agree: transfers_on_vulkan, transfers_on_gl;
    paint_agrees: paint_on_vulkan, paint_on_gl;
}

#[test]
fn frames_that_are_too_large_are_errors() {
    let Some(mut card) = card(wgpu::Backends::all()) else { return };
    let surface = Surface::new(shapes::cube());
    let shade = Shade::new(Shader::Phong);
    let mut image = |view: View, lighting: Lighting| {
        card.image(&Frame::new(&surface, &view, &lighting, DVec3::ONE), &shade, &Transfer::Srgb)
    };
    let wide = View { width: 100_000, ..View::square(2) };
    assert!(matches!(image(wide, Lighting::standard()), Err(GpuError::TooLarge { size: 100_000, .. })));
    let many = Lighting { lamps: vec![Lamp::directional(DVec3::Z); 65], ..Lighting::standard() };
    assert!(matches!(image(View::square(8), many), Err(GpuError::TooLarge { size: 65, .. })));
    let mut empty = Frame::new(&surface, &View::square(8), &Lighting::standard(), DVec3::ONE);
    empty.triangles.clear();
    empty.vertices.clear();
    assert!(card.image(&empty, &shade, &Transfer::Srgb).unwrap().bytes().unwrap().iter().all(|code| *code == 255));
}

#[test]
fn a_device_without_storage_is_an_error() {
    let limits = wgpu::Limits::downlevel_webgl2_defaults();
    let Some((_, device, queue)) = device(wgpu::Backends::all(), |_| limits) else { return };
    assert!(matches!(Gpu::new(&device, &queue), Err(GpuError::NoStorage(0))));
}
