//! The rows on which a model is fitted: complete rows with the categories and levels that occur in them.

use std::collections::BTreeSet;

use super::{
    counts::{CountRow, Counts, Factor},
    ordinal::{
        ModelError, ModelSpec, Note,
        terms::{Term, Variable},
    },
};

/// The rows of a table that have all values that the terms need.
#[derive(Clone, Debug)]
pub(super) struct Frame<'a> {
    pub counts: &'a Counts,
    /// The rows, with `subject` and `rating` renumbered to the values that occur.
    pub rows: Vec<CountRow>,
    /// The participants that occur, as in the table.
    pub subjects: Vec<u32>,
    /// Names of the categories that occur, starting with the lowest.
    pub categories: Vec<String>,
    /// For each factor, the levels that occur: the baseline, and the others in natural order.
    levels: Vec<Vec<u32>>,
}

impl<'a> Frame<'a> {
    /// Selects the complete rows for these terms and items. Also returns notes on what was excluded.
    ///
    /// # Errors
    /// Returns a [`ModelError`] if a name is unknown, if no rows remain or if all ratings are the same.
    pub fn new(counts: &'a Counts, spec: &ModelSpec) -> Result<(Self, Vec<Note>), ModelError> {
        let needed = needed_factors(counts, spec)?;
        let mut notes = Vec::new();
        let mut rows = counts.rows.clone();
        rows.retain(|row| row.count > 0);
        for &factor in &needed {
            let missing = |row: &CountRow| counts.conditions[row.condition as usize][factor].is_none();
            let lost: u64 = rows.iter().filter(|row| missing(row)).map(|row| row.count).sum();
            if lost > 0 {
                rows.retain(|row| !missing(row));
                notes.push(Note::MissingValues { factor: counts.factors[factor].name.clone(), ratings: lost });
            }
        }
        if rows.is_empty() {
            return Err(ModelError::NoRatings);
        }
        let subjects = renumber(&mut rows, |row| &mut row.subject);
        let categories = used_categories(counts, &mut rows, &mut notes)?;
        let levels = (0..counts.factors.len()).map(|factor| present_levels(counts, &rows, factor)).collect();
        Ok((Self { counts, rows, subjects, categories, levels }, notes))
    }

    /// Returns the frame with other ratings by the same participants in the same conditions, or `None` if they are all
    /// the same. The ratings are numbered as in this frame.
    pub fn with_ratings(&self, mut rows: Vec<CountRow>) -> Option<Self> {
        let used = renumber(&mut rows, |row| &mut row.rating);
        let categories: Vec<String> = used.iter().map(|&index| self.categories[index as usize].clone()).collect();
        (categories.len() > 1).then(|| Self { rows, categories, ..self.clone() })
    }

    /// Returns the number of ratings in the frame.
    pub fn total(&self) -> u64 {
        self.rows.iter().map(|row| row.count).sum()
    }

    /// Returns the mean over the ratings of numbers that belong to the conditions.
    pub fn mean(&self, of_condition: impl Fn(usize) -> f64) -> f64 {
        let sum: f64 = self.rows.iter().map(|row| row.count as f64 * of_condition(row.condition as usize)).sum();
        sum / self.total() as f64
    }

    /// Returns the conditions that occur.
    pub fn conditions(&self) -> Vec<u32> {
        let mut occurs = vec![false; self.counts.conditions.len()];
        self.rows.iter().for_each(|row| occurs[row.condition as usize] = true);
        (0..).zip(occurs).filter_map(|(condition, occurs)| occurs.then_some(condition)).collect()
    }

    /// Makes `level`, which must occur, the baseline of a factor.
    pub fn set_baseline(&mut self, factor: usize, level: u32) {
        let place = self.levels[factor].iter().position(|own| *own == level).unwrap_or(0);
        self.levels[factor][..=place].rotate_right(1);
    }

    /// Returns the levels of a factor that occur, starting with the baseline.
    pub fn levels(&self, factor: usize) -> &[u32] {
        &self.levels[factor]
    }

    /// Returns the numbers of a factor's levels, or their reciprocals if `inverse`. The value is 0 for levels that do
    /// not occur.
    pub fn numbers(&self, index: usize, inverse: bool) -> Result<Vec<f64>, ModelError> {
        let factor = &self.counts.factors[index];
        let mut values = vec![0.0; factor.levels.len()];
        for &level in &self.levels[index] {
            values[level as usize] = level_number(factor, &factor.levels[level as usize], inverse)?;
        }
        Ok(values)
    }
}

/// Returns the number of a factor's level, or its reciprocal if `inverse`.
fn level_number(factor: &Factor, level: &str, inverse: bool) -> Result<f64, ModelError> {
    let number = super::levels::number_of(level);
    match if inverse { number.map(f64::recip) } else { number } {
        Some(value) if value.is_finite() => Ok(value),
        Some(_) if !inverse && factor.name == "depth" => Err(ModelError::InfiniteDepth { name: factor.name.clone() }),
        _ => Err(ModelError::NotANumber { factor: factor.name.clone(), level: level.to_owned() }),
    }
}

/// Returns the index of the factor that a variable names, and true if the variable means the factor's reciprocal.
pub(crate) fn find_factor(counts: &Counts, variable: &Variable) -> Result<(usize, bool), ModelError> {
    if let Some((index, _)) = counts.factor(variable.name()) {
        return Ok((index, false));
    }
    if let (Variable::Number(name), Some((index, _))) = (variable, counts.factor("depth"))
        && name == "inv_n"
    {
        return Ok((index, true));
    }
    let known = counts.factors.iter().map(|factor| factor.name.clone()).collect();
    Err(ModelError::UnknownFactor { name: variable.name().to_owned(), known })
}

/// Returns the indices of the factors of a term. Those that are not in the table are left out.
pub(super) fn factors_of(counts: &Counts, term: &Term) -> impl Iterator<Item = usize> {
    term.variables.iter().filter_map(|variable| Some(find_factor(counts, variable).ok()?.0))
}

fn needed_factors(counts: &Counts, spec: &ModelSpec) -> Result<BTreeSet<usize>, ModelError> {
    let items = spec.items.clone().map(Variable::Factor);
    let variables = spec.terms.iter().flat_map(|term| &term.variables).chain(&items);
    variables.map(|variable| find_factor(counts, variable).map(|(index, _)| index)).collect()
}

/// Renumbers an index to the values that occur, and returns those values in order.
fn renumber<T: Copy + Ord + TryFrom<usize>>(rows: &mut [CountRow], field: impl Fn(&mut CountRow) -> &mut T) -> Vec<T> {
    let mut present: Vec<T> = rows.iter_mut().map(|row| *field(row)).collect();
    present.sort_unstable();
    present.dedup();
    for row in rows {
        let value = field(row);
        // A new number is never larger than the old one.
        *value = T::try_from(present.partition_point(|other| other < value)).unwrap_or(*value);
    }
    present
}

/// Removes the categories that have no ratings, with a note, and returns the names of the others.
fn used_categories(counts: &Counts, rows: &mut [CountRow], notes: &mut Vec<Note>) -> Result<Vec<String>, ModelError> {
    let used = renumber(rows, |row| &mut row.rating);
    let names: Vec<String> = used.iter().map(|&index| counts.categories[index as usize].clone()).collect();
    if used.len() < 2 {
        return Err(ModelError::NoVariation { category: names.concat() });
    }
    let empty: Vec<&str> =
        counts.categories.iter().map(String::as_str).filter(|&own| !names.iter().any(|n| n == own)).collect();
    if let [others @ .., last] = &empty[..] {
        let or = if others.is_empty() { "" } else { " or " };
        notes.push(Note::EmptyCategory { category: format!("{}{or}{last}", others.join(", ")) });
    }
    Ok(names)
}

fn present_levels(counts: &Counts, rows: &[CountRow], factor: usize) -> Vec<u32> {
    let levels: BTreeSet<u32> =
        rows.iter().filter_map(|row| counts.conditions[row.condition as usize][factor]).collect();
    levels.into_iter().collect()
}
