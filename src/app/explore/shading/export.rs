//! The view as a file.

use std::path::PathBuf;

use eframe::egui;
use serde_json::{Value, json};

use super::{
    bands::{SHORTER_SIDE_DEG, predicted_size},
    comparison::{Comparison, MeshChoice},
    look::{Look, Show},
};
use crate::{app::theme, light::CodeImage, store};

/// The field, and what was said of the last file.
#[derive(Default)]
pub struct Export {
    /// What was typed; `None` for the name that suggests itself.
    typed: Option<String>,
    said: Option<Result<String, String>>,
    /// A file that exists and may be written over if asked again.
    standing: Option<PathBuf>,
}

impl Export {
    /// Draws it. `view` gives the view's pixels and parameters when they are wanted.
    pub fn show(
        &mut self,
        ui: &mut egui::Ui,
        compared: &Comparison,
        look: &Look,
        view: impl FnOnce() -> Option<(CodeImage, Value)>,
    ) {
        let mut name = self.typed.clone().unwrap_or_else(|| suggested(compared, look));
        let label = ui.label("Export to");
        let field =
            ui.add(egui::TextEdit::singleline(&mut name).desired_width(ui.available_width())).labelled_by(label.id);
        if field.changed() {
            self.typed = Some(name.clone()).filter(|name| !name.trim().is_empty());
            self.said = None;
            self.standing = None;
        }
        let path = PathBuf::from(name.trim());
        let again = self.standing.as_ref() == Some(&path);
        if ui.button(if again { "Write over it" } else { "Export PNG" }).clicked() {
            if path.exists() && !again {
                self.said = Some(Err(format!("{} exists already; expected a new name", path.display())));
                self.standing = Some(path);
            } else {
                let written = view().ok_or_else(|| "this view is not there yet; try again in a moment".to_owned());
                let written = written.and_then(|(image, parameters)| {
                    store::image::write_shaded(&path, &image, &compared.transfer.clone().into(), &parameters)
                        .map_err(|error| error.to_string())
                });
                self.said = Some(written.map(|()| format!("Written to {}", path.display())));
                self.standing = None;
            }
        }
        match &self.said {
            Some(Ok(text)) => _ = ui.add(egui::Label::new(theme::quiet(text)).wrap()),
            Some(Err(text)) => theme::fault(ui, text),
            None => {}
        }
    }
}

/// The view's parameters; `most` is the strength that is lightest and darkest in a map of predicted bands.
pub fn parameters(compared: &Comparison, look: &Look, size: [u32; 2], drawn_by: &str, most: Option<f64>) -> Value {
    let mut all = compared.describe();
    all["size"] = json!(size);
    all["drawn_by"] = json!(drawn_by);
    all["view"] = match look.show {
        Show::Split => json!({"show": "split", "right_from_column": look.column(size[0])}),
        Show::Difference => json!({"show": "difference of codes", "factor": look.factor}),
        Show::Creases => json!({"show": "creases", "right_from_column": look.column(size[0])}),
        Show::Bands => json!({
            "show": "predicted bands",
            "right_from_column": look.column(size[0]),
            "shorter_side_deg": SHORTER_SIDE_DEG,
            "predicted_from_px": predicted_size(size),
            "full_scale": most,
        }),
    };
    all["program"] = json!(concat!("machband ", env!("CARGO_PKG_VERSION")));
    all
}

/// A name that says what is seen.
fn suggested(compared: &Comparison, look: &Look) -> String {
    let mesh = match &compared.mesh {
        MeshChoice::Named(shape, vertices) if shape.has_vertices() => format!("{shape}-{vertices}"),
        other => other.title().trim_end_matches(".obj").to_owned(),
    };
    let [left, right] = compared.sides.map(|side| {
        let shade = side.shade;
        let mut name = shade.shader.name().to_owned();
        if side.has_strip() {
            name += &format!("-{}-{}", shade.depth, (shade.boundary * 1000.0).round() / 1000.0);
        }
        name
    });
    let shaders = match (look.show, look.divider) {
        (Show::Difference, _) => format!("{left}-minus-{right}"),
        (_, divider) if divider <= 0.0 => right,
        (_, divider) if divider >= 1.0 => left,
        _ => format!("{left}-{right}"),
    };
    let what = match look.show {
        Show::Split | Show::Difference => "",
        Show::Creases => "-creases",
        Show::Bands => "-bands",
    };
    format!("{mesh}-{shaders}{what}.png")
}
