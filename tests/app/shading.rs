//! Tests the shading demo without a display, and compares what it draws with the images that the shaders compute. The
//! predicted bands of the gallery and of the demo agree with the library, and the window does not wait for them.

use eframe::egui::{self, PointerButton, Pos2, Rect, Vec2};
use egui_kittest::kittest::{NodeT as _, Queryable as _};
use machband::{
    app::{App, Launch, explore::shading::Comparison},
    light::{Bits, CodeImage, Quantizer, Transfer},
    shading::{Shader, Surface, image},
    stimulus::{MachBand, Stimulus, ViewingConditions, Visible},
};

use crate::window::{Window, builder, choose, click, home, type_into, value, wait_for};

/// Opens the page with rendering; `None` if there is no graphics adapter.
fn open_with_pixels(scale: f32) -> Option<Window> {
    if !crate::common::has_graphics() {
        return None;
    }
    let builder = builder([1000.0, 800.0], 1.0 / 60.0).with_pixels_per_point(scale);
    let mut window = builder.wgpu().build_eframe(|cc| App::new(cc, Launch::default()));
    window.set_render_cursor(false);
    window.run_steps(3);
    click(&mut window, "Shading");
    window.remove_cursor();
    window.run_steps(4);
    Some(window)
}

fn picture(window: &Window) -> Rect {
    window.get_by_label_contains("Surface: ").rect()
}

/// The picture's pixels on the screen, row by row.
fn pixels(window: &mut Window) -> Vec<[u8; 3]> {
    let scale = window.ctx.pixels_per_point();
    let rect = picture(window) * scale;
    let shot = window.render().unwrap();
    let at = |x: u32, y: u32| {
        let [r, g, b, _] = shot.get_pixel(rect.min.x.round() as u32 + x, rect.min.y.round() as u32 + y).0;
        [r, g, b]
    };
    let (width, height) = (rect.width().round() as u32, rect.height().round() as u32);
    (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| at(x, y)).collect()
}

fn drag(window: &mut Window, from: Pos2, to: Pos2, button: PointerButton) {
    let press = |pos, pressed| egui::Event::PointerButton { pos, button, pressed, modifiers: Default::default() };
    window.hover_at(from);
    window.step();
    window.event(press(from, true));
    window.step();
    for i in 1..=4 {
        window.hover_at(from.lerp(to, i as f32 / 4.0));
        window.step();
    }
    window.event(press(to, false));
    window.run_steps(2);
    window.remove_cursor();
    window.run_steps(2);
}

fn expected(compared: &Comparison, transfer: &Transfer, which: usize, width: u32, height: u32) -> CodeImage {
    let frame = compared.scene.frame(&Surface::new(compared.mesh.mesh().unwrap().mesh), width, height);
    Quantizer::new(&transfer.clone().into(), Bits::Eight).quantize(&image(&frame, &compared.sides[which]))
}

/// Compares both halves at the start and with another shader on the right, also with a display profile.
#[test]
fn each_half_shows_exactly_the_image_of_its_shader() {
    let folder = tempfile::tempdir().unwrap();
    let profile = folder.path().join("screen.toml");
    std::fs::write(&profile, "schema = 1\nname = \"Left\"\ntransfer = \"gamma:1.8\"\n").unwrap();
    for (scale, path, transfer) in [(1.0, "", Transfer::Srgb), (1.5, profile.to_str().unwrap(), Transfer::Gamma(1.8))] {
        let Some(mut window) = open_with_pixels(scale) else { return };
        click(&mut window, "Display");
        type_into(&mut window, "Display profile", path);
        click(&mut window, "Shading");
        window.remove_cursor();
        window.run_steps(4);
        let mut compared = Comparison::default();
        for (shader, title) in [(Shader::Patch, "Patch"), (Shader::Flat, "Flat")] {
            choose(&mut window, "Right shader", title);
            compared.sides[1].shader = shader;
            window.get_by_label_contains(&format!("Gouraud on the left, {title} on the right"));
            let rect = picture(&window) * scale;
            let (width, height) = (rect.width().round() as u32, rect.height().round() as u32);
            let [left, right] = [0, 1].map(|which| expected(&compared, &transfer, which, width, height));
            let column = width.div_ceil(2);
            let mut differing = 0;
            // The divider and its handle cover part of the picture.
            let mark = (12.0 * scale) as u32;
            for (i, shown) in pixels(&mut window).iter().enumerate() {
                let (x, y) = (i as u32 % width, i as u32 / width);
                let want = if x < column { left.pixel(x, y) } else { right.pixel(x, y) };
                assert!(
                    x.abs_diff(column) < mark || shown.map(u16::from) == want,
                    "{title}, ({x}, {y}) at scale {scale}: {shown:?}, not {want:?}"
                );
                differing += u32::from(left.pixel(x, y) != right.pixel(x, y));
            }
            assert!(differing > width, "the two halves are the same");
        }
    }
}

#[test]
fn dragging_rotates_the_mesh_moves_the_light_and_draws_the_line() {
    let Some(mut window) = open_with_pixels(1.0) else { return };
    let mut before = pixels(&mut window);
    let rect = picture(&window);
    let from = rect.center() + Vec2::new(-120.0, -60.0);
    let turned = |window: &Window| {
        value(window, "Rotate about y").replace('−', "-").trim_end_matches('°').parse::<f64>().unwrap()
    };
    let angle = turned(&window);
    drag(&mut window, from, from + Vec2::new(60.0, 0.0), PointerButton::Primary);
    assert!((turned(&window) - angle).abs() > 3.0);
    let mut check = |window: &mut Window, what: &str| {
        let after = pixels(window);
        assert!(before.iter().zip(&after).filter(|(a, b)| a != b).count() > 1000, "{what} changed nothing");
        before = after;
    };
    check(&mut window, "turning the mesh");
    let light = value(&window, "Light, degrees to the right");
    drag(&mut window, from, from + Vec2::new(60.0, 0.0), PointerButton::Secondary);
    assert_ne!(value(&window, "Light, degrees to the right"), light);
    check(&mut window, "moving the light");
    window.get_by_label("Scan line").click();
    window.run_steps(2);
    window.get_by_label("Plot: light along the scan line");
    window.get_by_label("Plot: slope, light per pixel along the scan line");
    let angle = turned(&window);
    drag(&mut window, from, from + Vec2::new(60.0, 30.0), PointerButton::Primary);
    assert_eq!(turned(&window), angle, "drawing a scan line rotates nothing");
}

#[test]
fn a_file_without_a_mesh_is_explained_and_the_mesh_stays() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = page_of("Shading", [1000.0, 800.0]);
    let mesh = value(&window, "Shape of the mesh");
    let bad = folder.path().join("bad.obj");
    std::fs::write(&bad, "v 0 0 0\nv 1 0 0\nv 0 1 nan\nf 1 2 9\n").unwrap();
    let places =
        |window: &Window| ["Open the file", "Light, right"].map(|label| window.get_by_label(label).rect().top());
    let before = places(&window);
    for path in [folder.path().join("none.obj"), bad] {
        type_into(&mut window, "Mesh file", &path.display().to_string());
        click(&mut window, "Open the file");
        window.get_by_label_contains("expected");
        assert_eq!(value(&window, "Shape of the mesh"), mesh);
        assert_eq!(places(&window), before);
    }
    let good = folder.path().join("good.obj");
    std::fs::write(&good, "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n").unwrap();
    type_into(&mut window, "Mesh file", &good.display().to_string());
    click(&mut window, "Open the file");
    assert!(window.query_by_label_contains("cannot be opened").is_none());
    assert_eq!(value(&window, "Shape of the mesh"), "good.obj");
    // Neither an error nor a mesh without a choice of vertices moves anything.
    assert_eq!(places(&window), before);
    click(&mut window, "Undo");
    assert_eq!([value(&window, "Shape of the mesh"), value(&window, "Mesh file")], [mesh, String::new()]);
}

fn page_of(page: &str, size: [f32; 2]) -> Window {
    let mut window = home(size, 1.0 / 60.0);
    click(&mut window, page);
    window.remove_cursor();
    window.run_steps(2);
    window
}

fn text(window: &Window, beginning: &str) -> String {
    let node = window.get_by_label_contains(beginning);
    node.accesskit_node().label().or_else(|| node.value()).unwrap()
}

/// The expected sentence for a stimulus in a window of 10°.
fn sentence(stimulus: &Stimulus, size: u32) -> String {
    let Visible::Ramp(bands) = ViewingConditions::new(10.0).visible(&[stimulus], Some(size)).unwrap().remove(0) else {
        panic!("no ramp")
    };
    format!("{:.1} times the threshold. The dark band is at {:.1}.", bands.bright, bands.dark)
}

#[test]
fn the_gallery_marks_both_ends_of_a_ramp_and_none_of_a_step() {
    let mut window = page_of("Stimuli", [1100.0, 860.0]);
    let ramp = |width| Stimulus::MachBand(MachBand { width, ..MachBand::default() });
    assert!(text(&window, "The bright band, which").ends_with(&sentence(&ramp(0.4), 512)));
    let set_width = |window: &mut Window, width: f64| {
        window.query_all_by_label("Width").find(|node| node.value().is_some()).unwrap().set_value_accesskit(width);
        window.run_steps(3);
    };
    // The dark plateau is on the left.
    set_width(&mut window, 0.1);
    let marks = text(&window, "Plot: light, ");
    let places: Vec<&str> = marks.trim_start_matches("Plot: light, predicted bands: ").split(", ").collect();
    assert_eq!(places.len(), 2, "{marks}");
    for (word, end) in [("dark", -0.05), ("bright", 0.05)] {
        let place =
            places.iter().find_map(|place| place.strip_prefix(word)).unwrap_or_else(|| panic!("{word}: {marks}"));
        let place: f64 = place.trim_start_matches(" at ").parse().unwrap();
        assert!((place - end).abs() < 0.015, "{word}: {marks}");
    }
    set_width(&mut window, 0.0);
    assert_eq!(text(&window, "Plot: light, "), "Plot: light, no predicted band");
    assert!(text(&window, "The bright band, which").ends_with(&sentence(&ramp(0.0), 512)));
}

#[test]
fn the_demo_predicts_without_waiting() {
    let mut window = page_of("Shading", [900.0, 800.0]);
    // The page has been drawn several times without waiting for the prediction, which moves nothing.
    window.get_by_label("Difference from the smooth surface: computing…");
    let before = picture(&window);
    wait_for(&mut window, "what people can just see");
    let told = text(&window, "what people can just see");
    let numbers: Vec<f64> = told.split(' ').filter_map(|word| word.trim_end_matches('.').parse().ok()).collect();
    let [gouraud, c1] = numbers[..] else { panic!("{told}") };
    assert!(c1 < gouraud, "{told}");
    assert_eq!(picture(&window), before);
}
