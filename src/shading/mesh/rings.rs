//! The vertices around each vertex.

/// For each fan or vertex, the other vertices of its triangles, each once, in the order of the triangles.
pub struct Rings {
    others: Vec<u32>,
    /// Where each ring begins and ends in `others`.
    ranges: Vec<(u32, u32)>,
}

impl Rings {
    /// Collects the rings of `count` fans. Each triangle is given by the fans and the vertices of its corners.
    pub fn new(count: usize, triangles: impl Iterator<Item = ([u32; 3], [u32; 3])> + Clone) -> Rings {
        // First, the place that each fan may need: two others per triangle.
        let mut ranges = vec![(0, 0); count];
        for fan in triangles.clone().flat_map(|(fans, _)| fans) {
            ranges[fan as usize].1 += 2;
        }
        let mut total = 0;
        for range in &mut ranges {
            let most = range.1;
            *range = (total, total);
            total += most;
        }
        let mut others = vec![0; total as usize];
        for (fans, vertices) in triangles {
            for k in 0..3 {
                let (start, end) = &mut ranges[fans[k] as usize];
                for other in [vertices[(k + 1) % 3], vertices[(k + 2) % 3]] {
                    if !others[*start as usize..*end as usize].contains(&other) {
                        others[*end as usize] = other;
                        *end += 1;
                    }
                }
            }
        }
        Rings { others, ranges }
    }

    /// Returns the ring of a fan.
    pub fn of(&self, fan: usize) -> &[u32] {
        let (start, end) = self.ranges[fan];
        &self.others[start as usize..end as usize]
    }
}
