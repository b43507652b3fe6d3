//! How the demo shows what it compares: none of this changes a picture.

use eframe::egui::Pos2;

/// What is shown of the two pictures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Show {
    /// One on either side of the divider.
    Split,
    /// How far they are apart, amplified.
    Difference,
    /// The creases of each on its side of the divider.
    Creases,
    /// The bands that the model of vision predicts, of each on its side of the divider.
    Bands,
}

/// What dragging on the picture moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Hand {
    /// The mesh turns.
    Mesh,
    /// The light moves.
    Light,
    /// A new scan line is drawn.
    Line,
}

/// The view's own settings.
#[derive(Clone, Debug, PartialEq)]
pub struct Look {
    /// What is shown.
    pub show: Show,
    /// What a drag moves.
    pub hand: Hand,
    /// Where the divider is, as a share of the picture's width.
    pub divider: f64,
    /// How often the difference is amplified.
    pub factor: u8,
    /// Whether the scan line is shown, with its plots.
    pub scan: bool,
    /// Its ends, as shares of the picture's width and height.
    pub line: [Pos2; 2],
}

impl Default for Look {
    fn default() -> Self {
        Self {
            show: Show::Split,
            hand: Hand::Mesh,
            divider: 0.5,
            factor: 16,
            scan: false,
            line: [Pos2::new(0.2, 0.45), Pos2::new(0.8, 0.45)],
        }
    }
}

impl Look {
    /// First column of the right picture.
    pub fn column(&self, width: u32) -> u32 {
        (self.divider.clamp(0.0, 1.0) * f64::from(width)).round() as u32
    }
}
