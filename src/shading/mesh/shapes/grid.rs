//! A sheet of triangles, flat or bent.

use glam::DVec3;

use crate::shading::mesh::{Mesh, MeshError, build::MOST};

/// Largest jitter: beyond a quarter of a cell a triangle could turn over.
pub const MOST_JITTER: f64 = 0.24;

/// A sheet of `columns` by `rows` cells of two triangles each over −1…1 in x and y, seen from +z, with z = `height`(x,
/// y). Its places are moved along x and y by up to `jitter` of a cell (at most `MOST_JITTER`), those on the border
/// along it only; always the same way. Without jitter every two triangles that share an edge are a parallelogram.
///
/// # Errors
/// [`MeshError::NoTriangles`] without columns or rows, [`MeshError::TooMany`], [`MeshError::NotFinite`] for a height.
pub fn jittered_grid(
    columns: usize,
    rows: usize,
    jitter: f64,
    height: impl Fn(f64, f64) -> f64,
) -> Result<Mesh, MeshError> {
    if columns == 0 || rows == 0 {
        return Err(MeshError::NoTriangles);
    }
    let places = columns.saturating_add(1).saturating_mul(rows.saturating_add(1));
    if places > MOST {
        return Err(MeshError::TooMany { positions: places, faces: columns.saturating_mul(rows).saturating_mul(2) });
    }
    let jitter = if jitter > 0.0 { jitter.min(MOST_JITTER) } else { 0.0 };
    let along = |step: usize, steps: usize, at: u64| {
        let moved = if step == 0 || step == steps { 0.0 } else { jitter * noise(at) };
        (step as f64 + moved) / steps as f64 * 2.0 - 1.0
    };
    let mut positions = Vec::with_capacity((columns + 1) * (rows + 1));
    for row in 0..=rows {
        for column in 0..=columns {
            let at = 2 * positions.len() as u64;
            let (x, y) = (along(column, columns, at), along(row, rows, at + 1));
            positions.push(DVec3::new(x, y, height(x, y)));
        }
    }
    let site = |column: usize, row: usize| (row * (columns + 1) + column) as u32;
    let mut triangles = Vec::with_capacity(columns * rows * 2);
    for row in 0..rows {
        for column in 0..columns {
            let [a, b] = [site(column, row), site(column + 1, row)];
            let [c, d] = [site(column + 1, row + 1), site(column, row + 1)];
            triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    Mesh::new(&positions, &triangles, 180.0)
}

/// −1…1, the same for the same number, without pattern (SplitMix64).
fn noise(at: u64) -> f64 {
    let mut z = at.wrapping_add(1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    (z ^ (z >> 31)) as f64 / u64::MAX as f64 * 2.0 - 1.0
}
