//! Frame intervals as a picture.

use super::{
    axes::{Panel, plain, ticks},
    palette::{AXIS, BLUE, GRID, Stroke, VERMILION},
    svg::{Anchor, Font, Svg, WIDTH},
};
use crate::display::frames::Refresh;

const TEXT: f64 = 13.0;
const HEIGHT: f64 = 360.0;

/// Every interval over its frame, and a line where the screen's refresh is, as SVG.
#[must_use]
pub fn intervals(intervals_us: &[u32], refresh: Option<Refresh>) -> String {
    let refresh_ms = refresh.map(|refresh| refresh.seconds() * 1e3);
    let longest = intervals_us.iter().copied().max().unwrap_or(0);
    let high = 1.05 * (f64::from(longest) * 1e-3).max(refresh_ms.unwrap_or(0.0)).max(0.01);
    let panel = Panel { left: 70.0, right: WIDTH - 20.0, top: 20.0, bottom: HEIGHT - 50.0, low: 0.0, high };
    let of_refresh =
        refresh.map_or_else(String::new, |refresh| format!("; the line is the refresh, {:.3} Hz", refresh.hz()));
    let description = format!("frames 1 to {}{of_refresh}", intervals_us.len());
    Svg::draw(HEIGHT, "Intervals between frames", &description, |svg| {
        for ms in ticks(0.0, high, 7) {
            let y = panel.y(ms);
            svg.line(&[(panel.left, y), (panel.right, y)], GRID);
            svg.text(&plain(ms), (panel.left - 8.0, y), Font::new(TEXT, Anchor::End));
        }
        if let Some(ms) = refresh_ms {
            svg.line(&[(panel.left, panel.y(ms)), (panel.right, panel.y(ms))], Stroke::new(VERMILION, 1.0));
        }
        let last = intervals_us.len().max(2) as f64 - 1.0;
        for (frame, us) in intervals_us.iter().enumerate() {
            svg.circle((panel.x(frame as f64 / last), panel.y(f64::from(*us) * 1e-3)), 1.6, BLUE);
        }
        svg.line(&[(panel.left, panel.bottom), (panel.right, panel.bottom)], AXIS);
        svg.text(&description, (panel.left, HEIGHT - 24.0), Font::new(TEXT, Anchor::Start));
        let middle = (18.0, (panel.top + panel.bottom) / 2.0);
        svg.text("interval, ms", middle, Font::new(TEXT, Anchor::Middle).upright());
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_interval_is_a_point_within_the_axes() {
        let lengths = [16_667, 16_600, 33_333, 16_700];
        let svg = intervals(&lengths, Refresh::from_hz(60.0).ok());
        let document = resvg::usvg::roxmltree::Document::parse(&svg).unwrap();
        let heights: Vec<f64> = (document.descendants().filter(|node| node.has_tag_name("circle")))
            .map(|node| node.attribute("cy").unwrap().parse().unwrap())
            .collect();
        assert_eq!(heights.len(), lengths.len());
        assert!(heights.iter().all(|y| (20.0..=310.0).contains(y)), "{heights:?}");
        // Twice as long is twice as high above the axis, to the rounding of the numbers.
        assert!(((310.0 - heights[2]) / (310.0 - heights[0]) - 2.0).abs() < 1e-3);
    }
}
