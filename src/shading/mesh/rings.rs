//! The vertices around each vertex.

/// Returns, for each of `count` fans or vertices, the other vertices of its triangles, each once, in the order of the
/// triangles. Each triangle is given by the fans and the vertices of its corners.
pub fn rings(count: usize, triangles: impl Iterator<Item = ([u32; 3], [u32; 3])>) -> Vec<Vec<u32>> {
    let mut rings = vec![Vec::new(); count];
    for (fans, vertices) in triangles {
        for k in 0..3 {
            let ring = &mut rings[fans[k] as usize];
            for other in [vertices[(k + 1) % 3], vertices[(k + 2) % 3]] {
                if !ring.contains(&other) {
                    ring.push(other);
                }
            }
        }
    }
    rings
}
