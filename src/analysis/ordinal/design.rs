//! The design matrix of a model's terms. It has no intercept, because the thresholds take its place.
//!
//! Columns are coded and named as in R's `model.matrix` with treatment contrasts. The name of a factor's column is the
//! factor followed by the level (`width0.05`). In an interaction, a factor has contrasts if the term without this
//! factor is also in the model; otherwise, it has a column for each level.

use nalgebra::{DMatrix, DVector, DVectorView};

use super::{
    model::ModelError,
    terms::{Term, TermPart, Terms, Variable},
};
use crate::analysis::frame::{Frame, find_factor};

/// One column of a design matrix.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Column {
    /// The coefficient's name, as in R.
    pub name: String,
    /// What the name consists of, one part for each variable of the term.
    pub parts: Vec<TermPart>,
    /// Index of the term among those of the model.
    pub term: usize,
    /// The value for each condition of the table; 0 for conditions that are not in the frame.
    values: Vec<f64>,
}

/// The design columns of a list of terms.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Design {
    pub columns: Vec<Column>,
    /// Columns that were dropped because they are combinations of others.
    pub dropped: Vec<Column>,
    /// A shift with a given size, for each condition of the table: columns whose coefficients are not estimated.
    offset: Option<Vec<f64>>,
}

/// Returns whether these are the parts of a contrast of a level with the baseline, in the main effect of a factor.
pub(super) fn is_level(parts: &[TermPart], factor: &str, level: &str) -> bool {
    let is_factor = |variable: &Variable| matches!(variable, Variable::Factor(name) if name == factor);
    matches!(parts, [part] if is_factor(&part.variable) && part.level.as_deref() == Some(level))
}

impl Design {
    /// Creates the columns of these terms for the conditions of a frame.
    ///
    /// # Errors
    /// Returns a [`ModelError`] if a variable is unknown or is used as a number but has a level that is not one.
    pub fn new(frame: &Frame, terms: &Terms) -> Result<Self, ModelError> {
        let mut columns = Vec::new();
        for (index, term) in terms.iter().enumerate() {
            for parts in term_parts(frame, terms, term)? {
                let name = parts.iter().map(ToString::to_string).collect::<Vec<_>>().join(":");
                columns.push(Column {
                    name,
                    values: products(frame, &parts, &frame.counts.conditions, Coding::Treatment)?,
                    parts,
                    term: index,
                });
            }
        }
        Ok(Self { columns, dropped: Vec::new(), offset: None })
    }

    /// Returns the matrix with one row for each of these conditions.
    pub fn matrix(&self, conditions: &[u32]) -> DMatrix<f64> {
        DMatrix::from_fn(conditions.len(), self.columns.len(), |row, column| {
            self.columns[column].values[conditions[row] as usize]
        })
    }

    /// Returns a key that is equal for conditions with the same row.
    pub fn key(&self, condition: u32) -> Vec<u64> {
        let columns = self.columns.iter().map(|column| &column.values).chain(&self.offset);
        columns.map(|values| (values[condition as usize] + 0.0).to_bits()).collect()
    }

    /// Returns the shift with a given size for each of these conditions.
    pub fn offset(&self, conditions: &[u32]) -> DVector<f64> {
        let value = |condition: &u32| self.offset.as_ref().map_or(0.0, |offset| offset[*condition as usize]);
        DVector::from_iterator(conditions.len(), conditions.iter().map(value))
    }

    /// Returns the design in which the coefficient of column `a` is the difference from that of column `b`.
    pub fn joined(&self, a: usize, b: usize) -> Self {
        let mut joined = self.clone();
        let other = self.columns[a].values.clone();
        joined.columns[b].values.iter_mut().zip(other).for_each(|(value, other)| *value += other);
        joined
    }

    /// Returns the design in which some columns, given by index, have the given coefficients. What they add is centered as
    /// the columns were, so that the thresholds of a fit to these are a good start, whatever the origin of a number.
    pub(super) fn held(&self, standard: &Standard, coefficients: &[(usize, f64)]) -> Self {
        let mut held = self.clone();
        let conditions = self.columns.first().map_or(0, |column| column.values.len());
        let offset = held.offset.get_or_insert_with(|| vec![0.0; conditions]);
        for &(column, coefficient) in coefficients {
            let added = |value: &f64| coefficient * (value - standard.centers[column]);
            offset.iter_mut().zip(&self.columns[column].values).for_each(|(sum, value)| *sum += added(value));
        }
        let mut index = 0..;
        held.columns.retain(|_| index.next().is_none_or(|index| coefficients.iter().all(|(held, _)| *held != index)));
        held
    }

    /// Returns the design in sum contrasts, in which the columns of a main effect stand for the mean effect over the levels of
    /// the other factors; they have other names, because their coefficients mean something else.
    pub fn in_sum_contrasts(&self, frame: &Frame) -> Result<Self, ModelError> {
        let mut design = self.clone();
        for column in &mut design.columns {
            column.values = products(frame, &column.parts, &frame.counts.conditions, Coding::Sum)?;
            column.name.push('~');
        }
        Ok(design)
    }

    /// Returns the matrix with one row for each of these combinations of the levels of all factors, rated or not. The numbers of
    /// the factors in `at_means`, given by index, are their means over the ratings.
    pub fn at(
        &self,
        frame: &Frame,
        combinations: &[Vec<Option<u32>>],
        at_means: &[usize],
    ) -> Result<DMatrix<f64>, ModelError> {
        let values = |column: &Column| products(frame, &column.parts, combinations, Coding::AtMeans(at_means));
        let columns = self.columns.iter().map(values).collect::<Result<Vec<_>, _>>()?;
        Ok(DMatrix::from_vec(combinations.len(), columns.len(), columns.concat()))
    }

    /// Returns the design with the columns that were dropped.
    pub fn with_dropped(&self) -> Self {
        let mut design = self.clone();
        design.columns.append(&mut design.dropped);
        design.columns.sort_by_key(|column| column.term);
        design
    }

    /// Returns the design without the columns of a term, given by index. Columns that were dropped are no combinations of the
    /// rest, perhaps.
    pub fn without_columns(&self, term: usize) -> Self {
        let mut design = self.with_dropped();
        design.columns.retain(|column| column.term != term);
        design
    }

    /// Keeps only the columns that are not combinations of an intercept and the columns before them.
    #[must_use]
    pub fn independent(self, frame: &Frame) -> Self {
        let conditions = frame.conditions();
        let own = self.matrix(&conditions);
        let mut span = Span::with_constant(conditions.len());
        let mut kept = own.column_iter().map(|column| span.add(column));
        let (columns, dropped) = self.columns.into_iter().partition(|_| kept.next() == Some(true));
        Self { columns, dropped, offset: self.offset }
    }
}

/// Checks the number of coefficients before any column is made.
///
/// # Errors
/// [`ModelError::TooManyCoefficients`].
pub(crate) fn check_size(frame: &Frame, terms: &Terms, most: usize) -> Result<(), ModelError> {
    let columns = |variable: &Variable| match variable {
        Variable::Number(_) => 1,
        Variable::Factor(name) => {
            let levels = frame.counts.factor(name).map_or(0, |(index, _)| frame.levels(index).len());
            levels.saturating_sub(1).max(1)
        }
    };
    let of_term = |term: &Term| term.variables.iter().map(columns).fold(1, usize::saturating_mul);
    let coefficients = terms.iter().map(of_term).fold(0, usize::saturating_add);
    if coefficients > most { Err(ModelError::TooManyCoefficients { coefficients, most }) } else { Ok(()) }
}

/// Returns what each column of a term stands for. The levels of the first factor vary fastest.
fn term_parts(frame: &Frame, terms: &Terms, term: &Term) -> Result<Vec<Vec<TermPart>>, ModelError> {
    let mut columns = vec![Vec::new()];
    for (position, variable) in term.variables.iter().enumerate() {
        let mut rest = term.clone();
        rest.variables.remove(position);
        let has_contrasts = rest.variables.is_empty() || terms.has(&rest);
        let (index, inverse) = find_factor(frame.counts, variable)?;
        let levels: Vec<Option<String>> = match variable {
            Variable::Number(_) => frame.numbers(index, inverse).map(|_| vec![None])?,
            Variable::Factor(_) => (frame.levels(index).iter().skip(usize::from(has_contrasts)))
                .map(|&level| Some(frame.counts.factors[index].levels[level as usize].clone()))
                .collect(),
        };
        let parts = levels.into_iter().map(|level| TermPart { variable: variable.clone(), level });
        let before = columns;
        columns = parts
            .flat_map(|part| before.iter().map(move |own| [&own[..], std::slice::from_ref(&part)].concat()))
            .collect();
    }
    Ok(columns)
}

/// How the value of a column follows from the levels of its factors.
#[derive(Clone, Copy, PartialEq)]
enum Coding<'a> {
    /// 1 at the level of a factor, or the number.
    Treatment,
    /// The same, but the numbers of these factors, given by index, are their means over the ratings.
    AtMeans(&'a [usize]),
    /// A factor is −1 at its baseline, and a number is a difference from the mean of its levels.
    Sum,
}

/// Returns the product of a column's variables for each combination of the levels of all factors.
fn products(
    frame: &Frame,
    parts: &[TermPart],
    combinations: &[Vec<Option<u32>>],
    coding: Coding<'_>,
) -> Result<Vec<f64>, ModelError> {
    let mut products = vec![1.0; combinations.len()];
    for part in parts {
        let (index, inverse) = find_factor(frame.counts, &part.variable)?;
        let levels = frame.levels(index);
        let of_levels: Vec<f64> = match &part.level {
            Some(own) => {
                let is_baseline = |level: u32| coding == Coding::Sum && levels.first() == Some(&level);
                let names = (0..).zip(&frame.counts.factors[index].levels);
                names.map(|(level, name)| f64::from(i8::from(name == own) - i8::from(is_baseline(level)))).collect()
            }
            None => {
                let mut numbers = frame.numbers(index, inverse)?;
                match coding {
                    Coding::AtMeans(factors) if factors.contains(&index) => {
                        let level = |condition: usize| frame.counts.conditions[condition][index];
                        let mean = frame.mean(|own| level(own).map_or(0.0, |level| numbers[level as usize]));
                        numbers.fill(mean);
                    }
                    Coding::Sum => {
                        let sum: f64 = levels.iter().map(|&level| numbers[level as usize]).sum();
                        numbers.iter_mut().for_each(|number| *number -= sum / levels.len() as f64);
                    }
                    _ => {}
                }
                numbers
            }
        };
        for (product, levels) in products.iter_mut().zip(combinations) {
            *product *= levels[index].map_or(0.0, |level| of_levels[level as usize]);
        }
    }
    Ok(products)
}

/// A column counts as a combination of the columns before it if less than this share of it remains after projection.
/// This is R's tolerance.
const SPAN_TOLERANCE: f64 = 1e-7;

/// A vector space, with an orthonormal basis.
pub(crate) struct Span {
    pub basis: Vec<DVector<f64>>,
}

impl Span {
    /// Creates the span of a constant.
    pub fn with_constant(rows: usize) -> Self {
        Self { basis: vec![DVector::from_element(rows, 1.0 / (rows as f64).sqrt())] }
    }

    /// Adds a column. Returns false if it is a combination of the columns before it.
    pub fn add(&mut self, column: DVectorView<f64>) -> bool {
        let column = column.clone_owned();
        // Project twice, because a single Gram–Schmidt pass loses orthogonality if columns are nearly dependent.
        let once = &column - self.project(&column);
        let rest = &once - self.project(&once);
        // A constant is part of the span, so only the variation counts: a year and its days vary little about a large mean.
        let varied = column.add_scalar(-column.mean()).norm();
        let is_new = varied > 1e-12 * column.norm() && rest.norm() >= SPAN_TOLERANCE * varied;
        if is_new {
            self.basis.push(rest.normalize());
        }
        is_new
    }

    /// Returns the part of a vector that lies within the span.
    pub fn project(&self, vector: &DVector<f64>) -> DVector<f64> {
        let mut part = DVector::zeros(vector.len());
        for direction in &self.basis {
            part.axpy(direction.dot(vector), direction, 1.0);
        }
        part
    }
}

/// The number that was subtracted from each column, and the number by which it was divided. Contrasts (columns of zeros
/// and ones) are unchanged.
#[derive(Clone, Debug)]
pub(super) struct Standard {
    centers: DVector<f64>,
    pub scales: DVector<f64>,
}

impl Standard {
    /// Centers and scales the columns of a matrix.
    pub fn of(x: DMatrix<f64>) -> (DMatrix<f64>, Self) {
        let columns = x.ncols();
        let mut standard = Self { centers: DVector::zeros(columns), scales: DVector::from_element(columns, 1.0) };
        for (index, column) in x.column_iter().enumerate() {
            let (center, is_contrast) = (column.mean(), column.iter().all(|value| *value == 0.0 || *value == 1.0));
            let scale = column.add_scalar(-center).amax();
            if !is_contrast && scale > 0.0 {
                (standard.centers[index], standard.scales[index]) = (center, scale);
            }
        }
        (standard.apply(x), standard)
    }

    /// Scales and centers other rows of the same columns.
    pub fn apply(&self, mut x: DMatrix<f64>) -> DMatrix<f64> {
        for (index, mut column) in x.column_iter_mut().enumerate() {
            column.add_scalar_mut(-self.centers[index]);
            column /= self.scales[index];
        }
        x
    }
}

/// Returns the matrix that converts θ, β and any further parameters from standardized columns to the scale of the data.
pub(super) fn to_data_scale(standard: &Standard, thresholds: usize, size: usize) -> DMatrix<f64> {
    let mut matrix = DMatrix::identity(size, size);
    for column in 0..standard.scales.len() {
        let index = thresholds + column;
        matrix[(index, index)] = 1.0 / standard.scales[column];
        for threshold in 0..thresholds {
            matrix[(threshold, index)] = standard.centers[column] / standard.scales[column];
        }
    }
    matrix
}
