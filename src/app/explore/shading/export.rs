//! Exports the view as a PNG file.

use std::path::{Path, PathBuf};

use eframe::egui;
use serde_json::{Value, json};

use super::{
    canvas::{FACTOR, Layer, ViewSettings},
    comparison::Comparison,
    measures::{SHORTER_SIDE_DEG, SIDE_PX},
};
use crate::{
    app::ui::{Field, Saving},
    light::CodeImage,
    store::{self, StoreError},
};

/// The state of the export controls.
#[derive(Default)]
pub struct Export {
    /// The name that the user typed; `None` for the suggested one.
    typed: Option<String>,
    saving: Saving,
}

impl Export {
    /// Draws the controls. `view` is called when the user exports; it returns the pixels and parameters of the view.
    pub fn show(
        &mut self,
        ui: &mut egui::Ui,
        compared: &Comparison,
        view: impl FnOnce() -> Option<(CodeImage, Value)>,
    ) {
        let mut name = self.typed.clone().unwrap_or_else(|| suggested(compared));
        let width = ui.available_width();
        if Field::new("Export to").width(width).text(ui, &mut name).changed() {
            *self = Self { typed: Some(name.clone()).filter(|name| !name.trim().is_empty()), ..Self::default() };
        }
        let path = PathBuf::from(name.trim());
        self.saving.export(ui, "Export", &path, &["png"], |writer, _| {
            let not_ready = || StoreError::Protected {
                path: path.clone(),
                what: "this view is not ready yet; try again in a moment".to_owned(),
            };
            let (image, parameters) = view().ok_or_else(not_ready)?;
            store::image::write_shaded(writer, &path, &image, &compared.transfer.clone().into(), &parameters)
        });
        self.saving.show(ui);
    }
}

/// Returns the parameters of the view, for the exported file. `full_scale` is the difference, in times threshold, with
/// the last color of the map.
pub fn parameters(compared: &Comparison, settings: &ViewSettings, size: [u32; 2], full_scale: Option<f64>) -> Value {
    let mut all = compared.describe();
    all["size"] = json!(size);
    let column = settings.column(size[0]);
    all["view"] = match settings.layer {
        Layer::Split => json!({"show": "split", "right_from_column": column}),
        Layer::Difference => json!({"show": "difference of codes", "factor": FACTOR}),
        Layer::Visible => json!({
            "show": "visible difference from the smooth surface",
            "right_from_column": column,
            "shorter_side_deg": SHORTER_SIDE_DEG,
            "judged_from_px": [SIDE_PX, SIDE_PX],
            "full_scale": full_scale,
        }),
    };
    all["program"] = json!(concat!("machband ", env!("CARGO_PKG_VERSION")));
    all
}

/// Returns a file name that says what is compared.
fn suggested(compared: &Comparison) -> String {
    let title = compared.mesh.title();
    let stem = Path::new(&title).file_stem().unwrap_or_default().to_string_lossy();
    let [left, right] = compared.sides.map(|side| side.shader);
    format!("{stem}-{left}-{right}.png")
}
