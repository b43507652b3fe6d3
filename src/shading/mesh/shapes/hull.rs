//! The convex hull of points on a sphere, which is their Delaunay triangulation there.

use glam::DVec3;

/// Why points have no hull.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum HullError {
    /// Not a body.
    #[error("{0} points have no convex hull with a volume; expected at least 4 that are not in one plane")]
    Flat(usize),
    /// A point lies within the hull of the others, or twice in the same place.
    #[error("point {0} is no corner of the convex hull; expected different points on a sphere")]
    Inside(usize),
}

/// The triangles of the convex hull of `points`, which all lie on one sphere; counter-clockwise from outside, two fewer
/// than twice as many as there are points. In time O(N log N).
///
/// Points are inserted one by one. Each cuts the triangle under it in three; then edges are flipped as long as a
/// neighbor's plane has the new point outside. With points on a sphere this always reaches the hull. The order makes
/// it fast: rounds of doubling size, each through the points from one to the next, so that the triangle under a point
/// is a few steps away from the last.
///
/// # Errors
/// [`HullError`].
pub fn hull(points: &[DVec3]) -> Result<Vec<[u32; 3]>, HullError> {
    let first = tetrahedron(points).ok_or(HullError::Flat(points.len()))?;
    let mut hull = Hull::new(points, first);
    for point in insertion_order(points) {
        if !first.contains(&point) {
            hull.insert(point).ok_or(HullError::Inside(point as usize))?;
        }
    }
    Ok(hull.triangles)
}

/// Four points that are well apart: the first three counter-clockwise as seen from beyond them, the fourth below.
fn tetrahedron(points: &[DVec3]) -> Option<[u32; 4]> {
    let farthest = |distance: &dyn Fn(DVec3) -> f64| {
        let (at, most) = points.iter().map(|p| distance(*p)).enumerate().max_by(|a, b| a.1.total_cmp(&b.1))?;
        (most > 1e-9).then_some(at)
    };
    let a = *points.first()?;
    let b_at = farthest(&|p| p.distance(a))?;
    let along = (points[b_at] - a).normalize();
    let c_at = farthest(&|p| (p - a).reject_from_normalized(along).length())?;
    let normal = along.cross(points[c_at] - a).normalize();
    let d_at = farthest(&|p| (p - a).dot(normal).abs())?;
    let [b, c, d] = [b_at, c_at, d_at].map(|at| at as u32);
    Some(if (points[d_at] - a).dot(normal) < 0.0 { [0, b, c, d] } else { [0, c, b, d] })
}

/// Rounds of doubling size, chosen without pattern; within each, bands from pole to pole, there and back.
fn insertion_order(points: &[DVec3]) -> Vec<u32> {
    let rounds = usize::BITS - points.len().leading_zeros();
    let round = |i: u32| {
        let mixed = u64::from(i).wrapping_add(1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
        let mixed = (mixed ^ (mixed >> 32)).wrapping_mul(0xD6E8_FEB8_6659_FD93);
        rounds - (mixed ^ (mixed >> 32)).trailing_zeros().min(rounds)
    };
    let mut order: Vec<(u32, u32, f64, u32)> = (0..points.len() as u32)
        .map(|i| {
            let (p, round) = (points[i as usize], round(i));
            let bands = 2f64.powf(f64::from(round) / 2.0);
            let band = ((p.z + 1.0) / 2.0 * bands) as u32;
            let around = p.y.atan2(p.x);
            (round, band, if band.is_multiple_of(2) { around } else { -around }, i)
        })
        .collect();
    order.sort_unstable_by(|a, b| (a.0, a.1).cmp(&(b.0, b.1)).then(a.2.total_cmp(&b.2)).then(a.3.cmp(&b.3)));
    order.into_iter().map(|key| key.3).collect()
}

/// A hull in the making.
struct Hull<'a> {
    points: &'a [DVec3],
    /// A place inside, for good.
    middle: DVec3,
    triangles: Vec<[u32; 3]>,
    /// What lies across the edge opposite each corner.
    across: Vec<[u32; 3]>,
    /// The triangle last made, where the search for the next starts.
    last: u32,
}

impl<'a> Hull<'a> {
    fn new(points: &'a [DVec3], [a, b, c, d]: [u32; 4]) -> Self {
        let middle = [a, b, c, d].iter().map(|i| points[*i as usize]).sum::<DVec3>() / 4.0;
        let triangles = vec![[a, b, c], [a, d, b], [b, d, c], [c, d, a]];
        // Opposite corner by corner: [abc]: bc → 2, ca → 3, ab → 1, and so on.
        let across = vec![[2, 3, 1], [2, 0, 3], [3, 0, 1], [1, 0, 2]];
        Hull { points, middle, triangles, across, last: 0 }
    }

    /// Adds a point; none if it lies under the surface.
    fn insert(&mut self, point: u32) -> Option<()> {
        let p = self.points[point as usize];
        let under = self.find(p)?;
        if self.height(under, p) <= 0.0 {
            return None;
        }
        let [a, b, c] = self.triangles[under as usize];
        let [over_a, over_b, over_c] = self.across[under as usize];
        let (second, third) = (self.triangles.len() as u32, self.triangles.len() as u32 + 1);
        // The new point is the first corner of each.
        self.triangles[under as usize] = [point, b, c];
        self.across[under as usize] = [over_a, second, third];
        self.triangles.extend([[point, c, a], [point, a, b]]);
        self.across.extend([[over_b, third, under], [over_c, under, second]]);
        self.reconnect(over_b, under, second);
        self.reconnect(over_c, under, third);
        let mut doubtful = vec![under, second, third];
        while let Some(triangle) = doubtful.pop() {
            let beyond = self.across[triangle as usize][0];
            if self.height(beyond, p) > 0.0 {
                self.flip(triangle, beyond);
                doubtful.extend([triangle, beyond]);
            }
        }
        self.last = under;
        Some(())
    }

    /// How far `p` is above a triangle's plane, times twice the triangle's area.
    fn height(&self, triangle: u32, p: DVec3) -> f64 {
        let [a, b, c] = self.triangles[triangle as usize].map(|i| self.points[i as usize]);
        (b - a).cross(c - a).dot(p - a)
    }

    /// The triangle that the ray from the middle through `p` meets: across whichever edge has `p` on its other side,
    /// until none has.
    fn find(&self, p: DVec3) -> Option<u32> {
        let mut at = self.last;
        // Rounding could make the walk go in a circle; no walk is longer than there are triangles.
        for step in 0..self.triangles.len() + 3 {
            let corners = self.triangles[at as usize].map(|i| self.points[i as usize] - self.middle);
            // Starting at a different edge each time breaks circles too.
            let next = (0..3)
                .map(|k| (k + step) % 3)
                .find(|k| corners[(k + 1) % 3].cross(corners[(k + 2) % 3]).dot(p - self.middle) < 0.0);
            match next {
                Some(k) => at = self.across[at as usize][k],
                None => return Some(at),
            }
        }
        (0..self.triangles.len() as u32).max_by(|a, b| self.height(*a, p).total_cmp(&self.height(*b, p)))
    }

    /// Makes `triangle` know `new` where it knew `old`.
    fn reconnect(&mut self, triangle: u32, old: u32, new: u32) {
        for at in &mut self.across[triangle as usize] {
            if *at == old {
                *at = new;
            }
        }
    }

    /// Turns the edge between the triangles (p, b, c) and (d, c, b) into p–d: they become (p, b, d) and (p, d, c).
    fn flip(&mut self, near: u32, far: u32) {
        let [p, b, c] = self.triangles[near as usize];
        let [_, over_b, over_c] = self.across[near as usize];
        let k = self.across[far as usize].iter().position(|t| *t == near).unwrap_or(0);
        let d = self.triangles[far as usize][k];
        // From d on, the far triangle goes d, c, b.
        let (over_c_far, over_b_far) = (self.across[far as usize][(k + 1) % 3], self.across[far as usize][(k + 2) % 3]);
        self.triangles[near as usize] = [p, b, d];
        self.across[near as usize] = [over_c_far, far, over_c];
        self.triangles[far as usize] = [p, d, c];
        self.across[far as usize] = [over_b_far, over_b, near];
        self.reconnect(over_c_far, far, near);
        self.reconnect(over_b, near, far);
    }
}
