//! Normals of faces and of vertices.

use std::collections::HashMap;

use glam::DVec3;

use super::triangles::{Edges, Mesh, Vertex};
use crate::{
    shading::cubic::{join, root},
    system::checkpoint,
};

/// Returns Newell's normal of a polygon: it has unit length, and the polygon is counterclockwise as seen from its tip;
/// zero for a polygon without area. Shoaff §3.5. For corners that are not in one plane, it is the normal of the plane
/// that fits them best.
///
/// The corners are taken relative to the first corner and to the polygon's size because the sums as printed lose
/// precision far from the origin.
pub fn newell(corners: &[DVec3]) -> DVec3 {
    let Some(&origin) = corners.first() else { return DVec3::ZERO };
    let size = corners.iter().map(|p| (*p - origin).abs().max_element()).fold(0.0, f64::max);
    if !(size > 0.0 && size.is_finite()) {
        return DVec3::ZERO;
    }
    let at = |i: usize| (corners[i] - origin) / size;
    let mut sum = DVec3::ZERO;
    for i in 0..corners.len() {
        let (p, q) = (at(i), at(if i + 1 == corners.len() { 0 } else { i + 1 }));
        sum += DVec3::new((p.y - q.y) * (p.z + q.z), (p.z - q.z) * (p.x + q.x), (p.x - q.x) * (p.y + q.y));
    }
    // Anything smaller is rounding error.
    if sum.length() > 1e-14 { sum.normalize() } else { DVec3::ZERO }
}

/// Makes the mesh of `triangles` with averaged normals, split where faces meet at more than `crease_deg` degrees. For
/// each triangle, `faces` contains the face to which it belongs, and `normals` the unit normal of that face, or zero if
/// the face has no area; the triangles of a face are consecutive. A face counts once at each of its corners, as in
/// Shoaff, however it is cut into triangles.
pub(super) fn averaged(
    positions: &[DVec3],
    triangles: &[[u32; 3]],
    normals: &[DVec3],
    faces: &[u32],
    crease_deg: f64,
) -> Mesh {
    // Corner k of triangle t is 3t + k. Corners of one group share one normal.
    let groups: Vec<u32> = if crease_deg >= 180.0 {
        triangles.iter().flatten().copied().collect()
    } else {
        fans(triangles, normals, crease_deg)
    };
    let mut sums = vec![DVec3::ZERO; groups.len().max(positions.len())];
    let mut last = vec![u32::MAX; sums.len()];
    for (corner, group) in groups.iter().enumerate() {
        let (group, face) = (*group as usize, faces[corner / 3]);
        if std::mem::replace(&mut last[group], face) != face {
            sums[group] += normals[corner / 3];
        }
    }
    let mut vertices: Vec<Vertex> = Vec::with_capacity(positions.len());
    let mut shared = vec![u32::MAX; sums.len()];
    let mut lone: HashMap<(u32, [u64; 3]), u32> = HashMap::new();
    let mut corner = 0;
    let triangles = triangles
        .iter()
        .map(|sites| {
            sites.map(|site| {
                let (group, own) = (groups[corner], normals[corner / 3]);
                corner += 1;
                let sum = sums[group as usize];
                let mut push = |normal: DVec3| {
                    vertices.push(Vertex { position: positions[site as usize], normal, site });
                    (vertices.len() - 1) as u32
                };
                if sum.length() > 1e-9 {
                    let at = &mut shared[group as usize];
                    if *at == u32::MAX {
                        *at = push(sum.normalize());
                    }
                    return *at;
                }
                // Faces that point in opposite directions have no mean normal, so each keeps its own. A face without
                // area is never drawn, but needs some normal.
                let normal = if own == DVec3::ZERO { DVec3::Z } else { own };
                *lone.entry((group, normal.to_array().map(f64::to_bits))).or_insert_with(|| push(normal))
            })
        })
        .collect();
    Mesh { vertices, triangles, smooth: None, paint: None }
}

/// For each corner, returns the fan of faces around its site to which it belongs, identified by one of the fan's
/// corners. A fan continues across every edge at which the faces meet at no more than `crease_deg` degrees, so the two
/// triangles at such an edge share the vertices at both of its ends.
fn fans(triangles: &[[u32; 3]], normals: &[DVec3], crease_deg: f64) -> Vec<u32> {
    // The tolerance keeps the two triangles of a flat quad together at 0°.
    let least_cosine = crease_deg.max(0.0).to_radians().cos() - 1e-9;
    let mut parent: Vec<u32> = (0..triangles.len() as u32 * 3).collect();
    for edge in &Edges::among(triangles.iter().copied()).edges {
        checkpoint();
        for (i, &(t, k)) in edge.sides.iter().enumerate() {
            // Compare only with the next side. At an edge of two triangles, that is the only pair; at an edge of many,
            // it keeps the cost linear.
            let Some(&(u, l)) = edge.sides.get(i + 1) else { break };
            let (a, b) = (normals[t as usize], normals[u as usize]);
            if a == DVec3::ZERO || b == DVec3::ZERO || a.dot(b) < least_cosine {
                continue;
            }
            for end in [1, 2] {
                let site = triangles[t as usize][usize::from(k + end) % 3];
                let other = if triangles[u as usize][usize::from(l + 1) % 3] == site { 1 } else { 2 };
                join(&mut parent, t * 3 + u32::from(k + end) % 3, u * 3 + u32::from(l + other) % 3);
            }
        }
    }
    (0..parent.len() as u32).map(|corner| root(&mut parent, corner)).collect()
}

/// Given normals at one site that differ by no more than this are merged, because files contain rounded normals.
const SAME_DEG: f64 = 0.1;

/// The number of a site's normals, newest first, with which another one is compared; this keeps fans of any size fast.
const COMPARED: usize = 64;

/// Returns `mesh` with its normals replaced by the ones that are `given` for the corners of its triangles. Corners
/// without a given normal keep their own.
pub(super) fn replaced(mesh: &Mesh, given: &[[Option<DVec3>; 3]]) -> Mesh {
    let least_cosine = SAME_DEG.to_radians().cos();
    let mut vertices: Vec<Vertex> = Vec::with_capacity(mesh.vertices.len());
    let sites = mesh.vertices.iter().map(|v| v.site as usize + 1).max().unwrap_or(0);
    let mut of_site: Vec<Vec<u32>> = vec![Vec::new(); sites];
    let corner = |(corner, given): (u32, Option<DVec3>)| {
        let own = mesh.vertices[corner as usize];
        let (normal, known) = (given.unwrap_or(own.normal), &mut of_site[own.site as usize]);
        let same = |v: &&u32| vertices[**v as usize].normal.dot(normal) >= least_cosine;
        known.iter().rev().take(COMPARED).find(same).copied().unwrap_or_else(|| {
            vertices.push(Vertex { normal, ..own });
            known.push(vertices.len() as u32 - 1);
            vertices.len() as u32 - 1
        })
    };
    let corners = mesh.triangles.iter().flatten().copied().zip(given.iter().flatten().copied());
    let corners: Vec<u32> = corners.map(corner).collect();
    Mesh { vertices, triangles: corners.as_chunks().0.to_vec(), smooth: mesh.smooth, paint: mesh.paint.clone() }
}
