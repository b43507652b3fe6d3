//! How much of a pixel a shape covers, exactly.

/// A point in pixels.
pub(super) type Point = [f64; 2];

/// A convex polygon, counter-clockwise.
pub(super) type Polygon = Vec<Point>;

/// The square of side 1 around a center.
pub(super) fn pixel(center: Point) -> Polygon {
    [[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]].map(|[x, y]| [center[0] + x, center[1] + y]).to_vec()
}

/// The part of a convex polygon on the left of the line from `a` to `b`; Sutherland and Hodgman 1974.
pub(super) fn left_of(polygon: &[Point], a: Point, b: Point) -> Polygon {
    let side = |p: Point| (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]);
    let mut kept = Polygon::with_capacity(polygon.len() + 1);
    for (i, &p) in polygon.iter().enumerate() {
        let q = polygon[(i + 1) % polygon.len()];
        let (at_p, at_q) = (side(p), side(q));
        if at_p >= 0.0 {
            kept.push(p);
        }
        if (at_p > 0.0 && at_q < 0.0) || (at_p < 0.0 && at_q > 0.0) {
            let t = at_p / (at_p - at_q);
            kept.push([p[0] + t * (q[0] - p[0]), p[1] + t * (q[1] - p[1])]);
        }
    }
    kept
}

/// The part of a convex polygon within another, given counter-clockwise.
pub(super) fn within(polygon: &[Point], clip: &[Point]) -> Polygon {
    (0..clip.len()).fold(polygon.to_vec(), |kept, i| left_of(&kept, clip[i], clip[(i + 1) % clip.len()]))
}

/// Area of a polygon, positive counter-clockwise.
pub(super) fn area(polygon: &[Point]) -> f64 {
    edges(polygon).map(|(p, q)| p[0] * q[1] - p[1] * q[0]).sum::<f64>() / 2.0
}

/// Area that a polygon and the disc of this radius around the origin have in common: over the edges, the triangle with
/// the origin where the edge runs inside, the sector where it runs outside.
pub(super) fn area_in_disc(polygon: &[Point], radius: f64) -> f64 {
    edges(polygon).map(|(p, q)| edge_in_disc(p, q, radius)).sum()
}

fn edges(polygon: &[Point]) -> impl Iterator<Item = (Point, Point)> {
    polygon.iter().enumerate().map(|(i, &p)| (p, polygon[(i + 1) % polygon.len()]))
}

fn edge_in_disc(p: Point, q: Point, radius: f64) -> f64 {
    let d = [q[0] - p[0], q[1] - p[1]];
    let (a, b, c) = (dot(d, d), dot(p, d), dot(p, p) - radius * radius);
    if a == 0.0 {
        return 0.0;
    }
    let discriminant = b * b - a * c;
    let point = |t: f64| [p[0] + t * d[0], p[1] + t * d[1]];
    if discriminant <= 0.0 {
        return sector(p, q, radius);
    }
    let root = discriminant.sqrt();
    // Where the edge enters and leaves the disc, kept on the edge.
    let (enter, leave) = (((-b - root) / a).clamp(0.0, 1.0), ((-b + root) / a).clamp(0.0, 1.0));
    if enter >= leave {
        return sector(p, q, radius);
    }
    let (first, last) = (point(enter), point(leave));
    sector(p, first, radius) + cross(first, last) / 2.0 + sector(last, q, radius)
}

/// Area of the sector between the directions of two points.
fn sector(p: Point, q: Point, radius: f64) -> f64 {
    radius * radius / 2.0 * cross(p, q).atan2(dot(p, q))
}

fn dot(p: Point, q: Point) -> f64 {
    p[0] * q[0] + p[1] * q[1]
}

fn cross(p: Point, q: Point) -> f64 {
    p[0] * q[1] - p[1] * q[0]
}
