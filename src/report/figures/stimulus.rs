//! A coarse picture of a stimulus.

use super::{axes::EDGE, figure::Figure, palette::Rgb, svg::WIDTH};
use crate::{
    experiment::{Factor, Protocol},
    light::{Bits, Quantizer, Transfer},
    report::{document::list, names},
};

/// Squares across and down.
const SQUARES: u32 = 64;
/// Side of a square.
const SIDE: f64 = 6.0;

/// Draws `stimulus`: that of the first condition of a definition, unless it is a file of the study that was not read.
pub fn stimulus(protocol: &Protocol) -> Option<Figure> {
    let condition = protocol.conditions().first().filter(|condition| condition.stimulus.is_drawable())?;
    let known = Some(protocol.stimulus.parameters());
    let level = |(factor, level): (&Factor, &usize)| {
        let level = names::level(known, &factor.name, &factor.levels[*level].to_string());
        format!("{} {level}", names::factor(known, &factor.name))
    };
    let levels: Vec<String> = protocol.factors.iter().zip(&condition.levels).map(level).collect();
    let which = if levels.is_empty() { String::new() } else { format!(" at {}", list(&levels)) };
    let caption = format!("The stimulus of the first condition{which}, in {SQUARES} × {SQUARES} squares.");
    let codes = condition.stimulus.codes(SQUARES, &Quantizer::new(Transfer::Srgb, Bits::Eight));
    let color = |[r, g, b]: [u16; 3]| Rgb(r as u8, g as u8, b as u8);
    let left = ((WIDTH - f64::from(SQUARES) * SIDE) / 2.0).round();
    let height = f64::from(SQUARES) * SIDE + 2.0 * EDGE;
    Some(Figure::draw("stimulus", "A stimulus".to_owned(), caption, height, |svg| {
        for x in 0..SQUARES {
            let column: Vec<Rgb> = (0..SQUARES).map(|y| color(codes.pixel(x, y))).collect();
            let (from, mut top) = (left + f64::from(x) * SIDE, EDGE);
            // Squares of one color are one rectangle.
            for run in column.chunk_by(|a, b| a == b) {
                let bottom = top + run.len() as f64 * SIDE;
                svg.rectangle((from, top), (from + SIDE, bottom), run[0]);
                top = bottom;
            }
        }
    }))
}
