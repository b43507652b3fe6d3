//! Frame intervals as a picture.

use std::fmt::Write as _;

use crate::display::frames::Refresh;

/// Size of the picture.
const WIDTH: f64 = 900.0;
const HEIGHT: f64 = 360.0;
/// Room for the axes: left, right, top, bottom.
const MARGINS: [f64; 4] = [70.0, 20.0, 20.0, 50.0];

/// Every interval over its frame, and a line where the screen's refresh is, as SVG.
#[must_use]
pub fn svg(intervals_us: &[u32], refresh: Option<Refresh>) -> String {
    let [left, right, top, bottom] = MARGINS;
    let longest = intervals_us.iter().copied().max().unwrap_or(0);
    let refresh_ms = refresh.map(|refresh| refresh.seconds() * 1e3);
    let step = step(f64::from(longest).max(refresh_ms.unwrap_or(0.0) * 1e3) * 1.05e-3);
    let high = step * 5.0;
    let count = intervals_us.len().max(2) as f64;
    let x = |frame: f64| left + (WIDTH - left - right) * (frame - 1.0) / (count - 1.0);
    let y = |ms: f64| top + (HEIGHT - top - bottom) * (1.0 - ms / high);
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {HEIGHT}\" font-family=\"Noto Sans, sans-serif\" font-size=\"13\">\n<rect width=\"{WIDTH}\" height=\"{HEIGHT}\" fill=\"#fff\"/>\n"
    );
    // Writing to memory does not fail.
    for tick in 0..=5 {
        let ms = f64::from(tick) * step;
        let at = y(ms);
        let _ = writeln!(
            svg,
            "<path d=\"M{left} {at:.2}H{:.2}\" stroke=\"#ddd\"/><text x=\"{:.2}\" y=\"{:.2}\" text-anchor=\"end\">{}</text>",
            WIDTH - right,
            left - 8.0,
            at + 4.5,
            (ms * 1e3).round() / 1e3
        );
    }
    if let Some(ms) = refresh_ms {
        let at = y(ms);
        let _ = writeln!(svg, "<path d=\"M{left} {at:.2}H{:.2}\" stroke=\"#d55e00\"/>", WIDTH - right);
    }
    for (frame, us) in (1..).zip(intervals_us) {
        let _ = writeln!(
            svg,
            "<circle cx=\"{:.2}\" cy=\"{:.2}\" r=\"1.6\" fill=\"#0072b2\"/>",
            x(f64::from(frame)),
            y(f64::from(*us) * 1e-3)
        );
    }
    let what = refresh.map_or_else(String::new, |refresh| format!("; the line is the refresh, {:.3} Hz", refresh.hz()));
    let _ = write!(
        svg,
        "<text x=\"{left}\" y=\"{:.2}\">frame 1 to {}{what}</text>\n<text transform=\"translate(18 {:.2}) rotate(-90)\" text-anchor=\"middle\">interval, ms</text>\n</svg>\n",
        HEIGHT - 18.0,
        intervals_us.len(),
        (top + HEIGHT - bottom) / 2.0
    );
    svg
}

/// A fifth of the axis: 1, 2 or 5 times a power of ten.
fn step(high: f64) -> f64 {
    let least = (high / 5.0).max(1e-3);
    let power = 10_f64.powf(least.log10().floor());
    [1.0, 2.0, 5.0, 10.0].into_iter().map(|factor| factor * power).find(|step| *step >= least).unwrap_or(least)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_interval_is_a_point_within_the_axes() {
        let intervals = [16_667, 16_600, 33_333, 16_700];
        let svg = svg(&intervals, Refresh::from_hz(60.0).ok());
        let number = |line: &str, name: &str| -> f64 {
            let rest = &line[line.find(name).unwrap() + name.len() + 2..];
            rest[..rest.find('"').unwrap()].parse().unwrap()
        };
        let points: Vec<_> = svg.lines().filter(|line| line.starts_with("<circle")).collect();
        assert_eq!(points.len(), intervals.len());
        let heights: Vec<f64> = points.iter().map(|line| number(line, "cy")).collect();
        assert!(heights.iter().all(|y| (20.0..=310.0).contains(y)), "{heights:?}");
        // Twice as long is twice as high above the axis, to the rounding of the numbers.
        assert!(((310.0 - heights[2]) / (310.0 - heights[0]) - 2.0).abs() < 1e-3);
        assert_eq!((step(21.0), step(4.9), step(100.0)), (5.0, 1.0, 20.0));
    }
}
