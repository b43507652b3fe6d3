//! Profile-likelihood intervals: the values at which the likelihood ratio against the best value stays below a limit,
//! with all other parameters at their best values for that value.

use super::{
    design::Design,
    fitting::{Fitted, How},
};
use crate::statistics::Interval;

/// A shift of the most extreme condition by this much on the scale of the link is as good as infinite.
const FAR: f64 = 40.0;

/// With this number of ratings for each parameter and [`MANY_PEOPLE`], the profile is that of a normal distribution, to the
/// digits that are shown.
const MANY_PER_PARAMETER: u64 = 10_000;
/// Number of participants from which the profile may be normal.
const MANY_PEOPLE: usize = 100;

fn is_normal(full: &Fitted) -> bool {
    full.frame.total() >= MANY_PER_PARAMETER * full.parameters() as u64 && full.frame.subjects.len() >= MANY_PEOPLE
}

/// Returns the likelihood ratio against the model in which the coefficient of a column is 0 or, with another column, equal to
/// that one's; `None` too if a profile is normal, because its standard error then says the same.
pub(super) fn ratio_at_zero(full: &Fitted, column: usize, other: Option<usize>) -> Option<f64> {
    let joined = other.map(|other| full.x.joined(column, other));
    if is_normal(full) { None } else { ratio(full, joined.as_ref().unwrap_or(&full.x), column, 0.0) }
}

/// Returns the interval of the coefficient of a column. `limit` is the largest likelihood ratio; `se` is where the search
/// begins. An end is infinite if no finite value is excluded. `None` if the profile cannot be computed.
pub(super) fn interval(full: &Fitted, column: usize, estimate: f64, se: f64, limit: f64) -> Option<Interval> {
    if is_normal(full) {
        return Interval::around(estimate, Some(se), limit.sqrt());
    }
    let ratio = |value: f64| ratio(full, &full.x, column, value);
    // On the scale of the link, whatever the unit of a number is.
    let far = FAR / full.standard.scales[column];
    let [low, high] = [-se, se].map(|step| end(&ratio, estimate, step, limit, far));
    Some(Interval { low: low?, high: high? })
}

/// Finds the value in the direction of `step` at which the ratio reaches the limit. A distance above `far` is as good as
/// infinite. The root of the ratio is almost linear, so its inverse is interpolated.
fn end(ratio: &impl Fn(f64) -> Option<f64>, estimate: f64, step: f64, limit: f64, far: f64) -> Option<f64> {
    let wanted = limit.sqrt();
    let at = |distance: f64| estimate + step.signum() * distance;
    // The nearest distances known to be inside and outside, with the roots of their ratios.
    let (mut inside, mut outside) = ((0.0, 0.0), None::<(f64, f64)>);
    let mut distance = step.abs() * wanted;
    for _ in 0..25 {
        let root = ratio(at(distance))?.sqrt();
        if (root - wanted).abs() < 2e-3 * wanted {
            break;
        }
        if root < wanted {
            inside = (distance, root);
        } else {
            outside = Some((distance, root));
        }
        if distance > far && outside.is_none() {
            return Some(step.signum() * f64::INFINITY);
        }
        distance = match outside {
            Some((far, far_root)) => {
                let share = (wanted - inside.1) / (far_root - inside.1);
                inside.0 + (far - inside.0) * share.clamp(0.05, 0.95)
            }
            // Extrapolate, but not more than threefold.
            None => distance * (wanted / root.max(1e-3)).clamp(1.2, 3.0),
        };
    }
    Some(at(distance))
}

/// Returns the likelihood ratio against the model with a given value of the coefficient of a column.
fn ratio(full: &Fitted, x: &Design, column: usize, value: f64) -> Option<f64> {
    full.ratio(&full.with_columns(x.held(&full.standard, &[(column, value)]), How::default()))
}
