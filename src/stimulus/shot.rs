//! What can be seen of a shaded mesh, and its description.

use glam::{DVec2, DVec3};
use serde_json::{Value, json};

use crate::{
    light::LinearImage,
    shading::{Frame, Scene, Shade, Shading, Specular, image, lighting::Microfacets},
};

/// Returns every setting of a scene, so that anyone can reproduce it.
pub fn describe_scene(scene: &Scene) -> Value {
    let mut all = json!({
        "rotate_deg": scene.rotate_deg,
        "light": scene.light.to_array(),
        "color": scene.color.to_array(),
        "ambient": scene.ambient,
        "diffuse": scene.diffuse,
        "specular": scene.specular,
        "highlight": scene.highlight.name(),
        "shininess": scene.shininess,
        "background": scene.background,
        "fill": scene.fill,
        "distance": if scene.distance.is_finite() { json!(scene.distance) } else { json!("inf") },
    });
    if let Specular::CookTorrance(Microfacets { c1, slope, index }) =
        scene.highlight.model(scene.shininess, scene.mirrors)
    {
        all["facet_slope"] = json!(slope);
        all["facet_index"] = json!(index.x);
        if let Some(c1) = c1 {
            all["facet_c1"] = json!(c1);
        }
    }
    all
}

/// Returns the picture of a frame, limited to the range from black to white, as a display emits it.
pub fn emitted(frame: &Frame, shade: &Shade) -> LinearImage {
    let mut image = image(frame, shade);
    // NaN becomes black, as on the screen.
    image.data.iter_mut().for_each(|light| *light = if *light > 0.0 { light.min(1.0) } else { 0.0 });
    image
}

/// Divides the line from `from` to `to`, in pixels from the top left, into `count` equal segments and returns the light at
/// the center of each, or `None` where there is no surface.
pub fn along(frame: &Frame, shade: &Shade, [from, to]: [DVec2; 2], count: usize) -> Vec<Option<DVec3>> {
    let line = to - from;
    let mut nearest: Vec<Option<(f64, usize, [f64; 3])>> = vec![None; count];
    for triangle in 0..frame.triangles.len() {
        let corners = frame.corners(triangle);
        let across = corners.map(|v| (v.screen - from).perp_dot(line));
        if across.iter().all(|a| *a > 0.0) || across.iter().all(|a| *a < 0.0) {
            continue;
        }
        // Visit only the segments that the triangle can cover.
        let along = corners.map(|v| (v.screen - from).dot(line) / line.length_squared() * count as f64);
        let (low, high) = along.iter().fold((f64::INFINITY, 0.0_f64), |(l, h), a| (l.min(*a), h.max(*a)));
        for (i, found) in nearest.iter_mut().enumerate().take((high as usize).saturating_add(1)).skip(low as usize) {
            let w = frame.weights(triangle, from.lerp(to, (i as f64 + 0.5) / count as f64));
            if !w.iter().all(|w| *w >= 0.0) {
                continue;
            }
            let depth = w[0] * corners[0].depth + w[1] * corners[1].depth + w[2] * corners[2].depth;
            if found.is_none_or(|(other, ..)| depth < other) {
                *found = Some((depth, triangle, w));
            }
        }
    }
    let shading = Shading::new(frame, shade);
    nearest.into_iter().map(|found| found.map(|(_, t, w)| shading.light(t, w))).collect()
}
