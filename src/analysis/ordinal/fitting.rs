//! Fits models to a table of counts by maximizing their likelihoods.

use std::collections::{HashMap, HashSet};

use nalgebra::{DMatrix, DVector};

use super::{
    clm::{ClmData, Fit, FitEnd, tolerance},
    clmm::{ClmmData, Observation},
    design::{Column, Design, Standard, check_size},
    link::Link,
    model::{ModelError, ModelSpec, Note, Random, Slopes},
    random::{Loadings, RandomPart, within_part},
    search::{self, Task},
    terms::{Term, Variable},
};
use crate::analysis::{
    counts::{CountRow, Counts},
    frame::{Frame, factors_of, find_factor},
};

/// Everything about a fit that the tests need.
pub(crate) struct Fitted<'a> {
    pub(super) frame: Frame<'a>,
    pub(super) spec: ModelSpec,
    pub(super) notes: Vec<Note>,
    pub(super) x: Design,
    pub(super) clm: Fit,
    /// Standardization of the columns.
    pub(super) standard: Standard,
    /// The random part; without components if there is none.
    pub(super) random: RandomPart,
    pub(super) mixed: Option<Fit>,
}

/// How to fit a design.
#[derive(Clone, Copy, Default)]
pub(super) struct How<'a> {
    /// Whether to compute the standard errors of a mixed model, which take as long as its estimates.
    pub errors: bool,
    /// Whether only the likelihood is needed, to four decimals.
    pub rough: bool,
    /// A similar fit with errors, with whose information the search starts; `None` means the fit at whose estimates it starts.
    pub informed: Option<&'a Fitted<'a>>,
}

/// Fits a model. If the first baseline allows no finite estimates, another is used. The standard errors of a mixed model take
/// as long as its estimates and are computed only if `errors` is true.
pub(crate) fn fit_counts<'a>(counts: &'a Counts, spec: &ModelSpec, errors: bool) -> Result<Fitted<'a>, ModelError> {
    let mut spec = spec.clone();
    let (mut frame, mut notes) = Frame::new(counts, &spec)?;
    check_size(&frame, &spec.terms, spec.max_coefficients)?;
    if spec.random == Random::Subject && frame.subjects.len() < 2 {
        notes.push(Note::OneSubject);
        spec.random = Random::None;
    }
    // Differences between participants cannot be told from chance without a second rating.
    let of_subjects = frame.rows.chunk_by(|l, r| l.subject == r.subject);
    let is_repeated = of_subjects.map(|own| own.iter().map(|row| row.count).sum::<u64>()).any(|ratings| ratings > 1);
    if spec.random == Random::Subject && !is_repeated {
        notes.push(Note::OneRatingEach);
        spec.random = Random::None;
    }
    if spec.random == Random::None {
        spec.slopes = Slopes::None;
        if let Some(items) = spec.items {
            let expected = "random intercepts of at least two participants";
            return Err(ModelError::Items { items, expected });
        }
    }
    notes.extend(spec.terms.iter().filter_map(|term| with_other_baseline(&mut frame, term)));
    fit_terms(frame, spec, notes, errors)
}

/// Fits the terms of a specification to a frame. `notes` are the notes of the frame.
pub(super) fn fit_terms<'a>(
    frame: Frame<'a>,
    spec: ModelSpec,
    mut notes: Vec<Note>,
    errors: bool,
) -> Result<Fitted<'a>, ModelError> {
    let x = Design::new(&frame, &spec.terms)?.independent(&frame);
    let random = RandomPart::new(&frame, &spec, &mut notes)?;
    let plain = Fitted::plain(frame, spec, notes, x, random);
    Ok(plain.with_effects(None, How { errors, ..How::default() }))
}

/// Returns the counts for each distinct row of a design, and the standardization of its columns.
fn clm_data(frame: &Frame, link: Link, x: &Design) -> (ClmData, Standard) {
    let (conditions, row_of) = distinct_rows(frame, x, &RandomPart::default());
    let mut counts = DMatrix::zeros(conditions.len(), frame.categories.len());
    for row in &frame.rows {
        counts[(row_of[row.condition as usize], usize::from(row.rating))] += row.count as f64;
    }
    let offset = x.offset(&conditions);
    let (x, standard) = Standard::of(x.matrix(&conditions));
    (ClmData { link, x, offset, counts }, standard)
}

/// Returns one condition for each distinct row of a design and a random part, and the index of each condition's row; 0
/// for a condition that does not occur.
fn distinct_rows(frame: &Frame, design: &Design, random: &RandomPart) -> (Vec<u32>, Vec<usize>) {
    let mut rows: HashMap<Vec<u64>, usize> = HashMap::new();
    let mut conditions = Vec::new();
    let mut row_of = vec![0; frame.counts.conditions.len()];
    for condition in frame.conditions() {
        let key = design.key(condition).into_iter().chain(random.key(condition)).collect();
        row_of[condition as usize] = *rows.entry(key).or_insert_with(|| {
            conditions.push(condition);
            conditions.len() - 1
        });
    }
    (conditions, row_of)
}

/// The data of a mixed model, and the design row of each condition. If participants share effects, each design row belongs
/// to one participant, and there is a single range of observations.
pub(super) struct Layout {
    pub data: ClmmData,
    /// The design row of each condition; of no use if participants share effects.
    pub row_of: Vec<usize>,
}

/// Lays out the data of the mixed model; as if each participant had effects of their own if not `crossed`.
pub(super) fn lay_out(fitted: &Fitted, crossed: bool) -> Layout {
    let frame = &fitted.frame;
    let (conditions, row_of) = distinct_rows(frame, &fitted.x, &fitted.random);
    let mut observations: Vec<Observation> = Vec::new();
    let mut subjects = Vec::new();
    // Rows are sorted by participant. Conditions that share a design row are combined.
    for rows in frame.rows.chunk_by(|l, r| l.subject == r.subject) {
        let own = |row: &CountRow| (row_of[row.condition as usize], usize::from(row.rating), row.count);
        let mut cells: Vec<_> = rows.iter().map(own).collect();
        cells.sort_unstable();
        let first = observations.len();
        observations.extend(cells.chunk_by(|l, r| (l.0, l.1) == (r.0, r.1)).map(|cell| {
            let count = cell.iter().map(|(.., count)| *count).sum::<u64>() as f64;
            Observation { row: cell[0].0, category: cell[0].1, count }
        }));
        subjects.push(first..observations.len());
    }
    let mut design: Vec<(usize, u32)> = conditions.iter().map(|condition| (0, *condition)).collect();
    let mut people = 1;
    if crossed {
        design.clear();
        for (person, own) in subjects.iter().enumerate() {
            for row in observations[own.clone()].chunk_by_mut(|l, r| l.row == r.row) {
                design.push((person, conditions[row[0].row]));
                row.iter_mut().for_each(|observation| observation.row = design.len() - 1);
            }
        }
        people = subjects.len();
        subjects = std::iter::once(0..observations.len()).collect();
    }
    let conditions: Vec<u32> = design.iter().map(|(_, condition)| *condition).collect();
    let offset = fitted.x.offset(&conditions);
    let x = fitted.standard.apply(fitted.x.matrix(&conditions));
    let loadings = Loadings::new(&fitted.random, &design, people);
    let (link, categories) = (fitted.spec.link, frame.categories.len());
    Layout { data: ClmmData { link, categories, x, offset, loadings, observations, subjects }, row_of }
}

/// Returns, for each parameter of a model, the index of the same parameter of a similar model, if it has one. Its thresholds
/// are other ones if a category has no ratings.
fn places(fitted: &Fitted, near: &Fitted) -> Vec<Option<usize>> {
    let (own, theirs) = (fitted.frame.categories.len() - 1, near.frame.categories.len() - 1);
    let column = |column: &Column| near.x.columns.iter().position(|known| known.name == column.name);
    let thresholds = (0..own).map(|index| (own == theirs).then_some(index));
    let columns = fitted
        .x
        .columns
        .iter()
        .map(|own| column(own).map(|place| theirs + place).filter(|_| thresholds.len() == theirs));
    let psi = (0..fitted.random.parameters()).map(|index| Some(theirs + near.x.columns.len() + index));
    thresholds.clone().chain(columns).chain(psi).collect()
}

/// An estimate beyond this is not a place to start a search.
const FAR: f64 = 10.0;

/// Fits the mixed model, starting from the estimates of the model without random effects. Coefficients without a
/// finite estimate stay fixed, because their ratings are predicted perfectly for any participant.
fn fit_mixed(fitted: &Fitted, near: Option<&Fitted>, how: How<'_>) -> Option<Fit> {
    let Layout { data, .. } = lay_out(fitted, fitted.random.is_crossed());
    if fitted.infinite().any(|(index, _)| index < data.thresholds()) {
        return None;
    }
    let first_psi = data.first_psi();
    let tolerance = if how.rough { 1e3 } else { 1.0 } * tolerance(data.ratings());
    let plain = &fitted.clm;
    let start = near.and_then(|near| Some((near, near.mixed.as_ref()?))).map(|(near, fit)| {
        let places = places(fitted, near);
        let start = |index: usize, _| match places[index].map(|place| fit.parameters[place]) {
            // A deviation that was 0 may not be 0 here.
            Some(psi) if index >= first_psi && data.loadings.independent && psi.abs() < 0.1 => 0.1,
            Some(own) if index >= first_psi || !fitted.is_infinite(index) && own.abs() < FAR => own,
            _ => plain.parameters[index],
        };
        (DVector::from_fn(data.parameters(), start), &fit.modes)
    });
    let information = how.informed.or(near).and_then(|informed| informed.information_on(fitted));
    let task = Task {
        plain,
        start: start.as_ref().map(|(start, modes)| (start, *modes)),
        information: information.as_ref(),
        tolerance,
        errors: how.errors,
        rough: how.rough,
    };
    let found = search::fit(&data, task);
    if start.is_none() || found.as_ref().is_some_and(|fit| fit.end == FitEnd::Converged) {
        return found;
    }
    // The similar fit was not so similar.
    search::fit(&data, Task { start: None, information: None, rough: false, ..task }).or(found)
}

impl<'a> Fitted<'a> {
    /// Fits a design without random effects.
    fn plain(frame: Frame<'a>, spec: ModelSpec, notes: Vec<Note>, x: Design, random: RandomPart) -> Self {
        let (data, standard) = clm_data(&frame, spec.link, &x);
        Self { frame, spec, notes, x, clm: data.fit(), standard, random, mixed: None }
    }

    /// Fits the random effects, if the specification has them. The search starts at the estimates of a similar fit `near`.
    fn with_effects(mut self, near: Option<&Fitted>, how: How<'_>) -> Self {
        if self.spec.random == Random::Subject {
            self.mixed = fit_mixed(&self, near, how);
        }
        self
    }

    /// Fits a design of other columns to the same data, with the same random part.
    pub(super) fn with_columns(&self, x: Design, how: How<'_>) -> Self {
        self.refit(self.frame.clone(), x, how)
    }

    /// Fits a design to similar data, with the same random part.
    pub(super) fn refit<'b>(&self, frame: Frame<'b>, x: Design, how: How<'_>) -> Fitted<'b> {
        let x = x.independent(&frame);
        let plain = Fitted::plain(frame, self.spec.clone(), Vec::new(), x, self.random.clone());
        plain.with_effects(Some(self), how)
    }

    /// Returns the information of the mixed model on the parameters of a similar one. About a deviation that is 0 here, little is
    /// known. `None` if another parameter is not among those here.
    fn information_on(&self, similar: &Fitted) -> Option<DMatrix<f64>> {
        let mixed = self.mixed.as_ref().filter(|mixed| mixed.information.nrows() == mixed.free.len())?;
        let places = places(similar, self).into_iter().enumerate().filter(|(index, _)| !similar.is_infinite(*index));
        let free: Vec<Option<usize>> = places.map(|(_, place)| place).collect();
        let row = |place: &Option<usize>| mixed.free.iter().position(|known| Some(*known) == *place);
        let rows: Vec<Option<usize>> = free.iter().map(row).collect();
        let is_zero = |place: &Option<usize>| place.is_some_and(|place| mixed.parameters[place] == 0.0);
        let people = self.frame.subjects.len() as f64;
        let element = |i: usize, j: usize| match (rows[i], rows[j]) {
            (Some(row), Some(column)) => mixed.information[(row, column)],
            _ if i == j => people,
            _ => 0.0,
        };
        let is_known = free.iter().zip(&rows).all(|(place, row)| row.is_some() || is_zero(place));
        is_known.then(|| DMatrix::from_fn(free.len(), free.len(), element))
    }

    /// Returns the mixed model, if there is one and it did not diverge.
    pub(super) fn usable(&self) -> Option<&Fit> {
        self.mixed.as_ref().filter(|mixed| mixed.end != FitEnd::Diverged)
    }

    /// Returns the mixed model or, if there is none or it diverged, the model without random effects.
    pub(super) fn best(&self) -> &Fit {
        self.usable().unwrap_or(&self.clm)
    }

    /// Returns θ, β and ψ of a mixed model; without one, those of the model without random effects, with ψ = 0.
    pub(super) fn searched(&self, data: &ClmmData) -> DVector<f64> {
        self.best().parameters.clone().resize_vertically(data.parameters(), 0.0)
    }

    /// Returns the number of estimated parameters.
    pub fn parameters(&self) -> usize {
        let random = if self.mixed.is_some() { self.random.parameters() } else { 0 };
        self.frame.categories.len() - 1 + self.rank() + random
    }

    /// Returns the parameters that have no finite estimate, each with the direction in which it diverges.
    pub fn infinite(&self) -> impl Iterator<Item = (usize, f64)> + '_ {
        let direction = if let FitEnd::Separated(direction) = &self.clm.end { direction.as_slice() } else { &[] };
        direction.iter().copied().enumerate().filter(|(_, element)| *element != 0.0)
    }

    /// Returns whether a parameter has no finite estimate.
    pub fn is_infinite(&self, index: usize) -> bool {
        self.infinite().any(|(infinite, _)| infinite == index)
    }

    /// Returns the term to which a column belongs.
    pub fn term_of(&self, column: usize) -> &Term {
        &self.spec.terms.iter().as_slice()[self.x.columns[column].term]
    }

    /// Returns whether a variable of a term does not vary within most participants.
    pub fn is_between(&self, term: &Term) -> bool {
        factors_of(self.frame.counts, term).any(|factor| !self.frame.counts.is_within(factor))
    }

    /// Returns the smallest number of participants, and of items, at a level of a term's factors.
    pub fn least_at_level(&self, term: &Term) -> [usize; 2] {
        let (counts, items) = (self.frame.counts, self.items());
        let is_factor = |variable: &&Variable| matches!(variable, Variable::Factor(_));
        let names = term.variables.iter().filter(is_factor).map(Variable::name);
        let mut at_levels: HashMap<(usize, u32), [HashSet<u32>; 2]> = HashMap::new();
        for (factor, _) in names.filter_map(|name| counts.factor(name)) {
            for row in &self.frame.rows {
                let levels = &counts.conditions[row.condition as usize];
                let Some(level) = levels[factor] else { continue };
                let [people, shown] = at_levels.entry((factor, level)).or_default();
                people.insert(row.subject);
                shown.extend(items.and_then(|items| levels[items]));
            }
        }
        [0, 1].map(|kind| at_levels.values().map(|own| own[kind].len()).min().unwrap_or(usize::MAX))
    }

    /// Returns the index of the factor whose levels are items.
    pub fn items(&self) -> Option<usize> {
        self.frame.counts.factor(self.spec.items.as_ref()?).map(|(items, _)| items)
    }

    /// Returns the indices of the factors without levels of their own in the results: covariates and items.
    pub fn left_out(&self) -> Vec<usize> {
        let names = self.spec.covariates.iter().chain(&self.spec.items);
        names.filter_map(|name| self.frame.counts.factor(name)).map(|(factor, _)| factor).collect()
    }

    /// Returns whether a mixed model was asked for and could not be fitted, so that nothing accounts for several ratings by the
    /// same participant.
    pub fn ignores_people(&self) -> bool {
        self.spec.random == Random::Subject && self.usable().is_none()
    }

    /// Returns whether a variable of a term does not vary within items.
    pub fn is_between_items(&self, term: &Term) -> bool {
        let counts = self.frame.counts;
        let is_between = |items: usize| factors_of(counts, term).any(|factor| counts.determines(items, factor));
        self.items().is_some_and(is_between)
    }

    /// Returns whether participants may differ in an effect without a random slope of it. If nobody rated a level of a factor
    /// twice, such differences are part of the variation between ratings, for which the model allows; so they almost are in
    /// an interaction whose slope the design does not support.
    pub fn lacks_slope(&self, term: &Term) -> bool {
        let part = within_part(&self.frame, term);
        let [variable] = &part.variables[..] else { return false };
        let Ok((factor, _)) = find_factor(self.frame.counts, variable) else { return false };
        if !self.frame.counts.is_within(factor) {
            return false;
        }
        let has_slope = self.random.components.iter().any(|slope| slope.term == part);
        let mut ratings = HashMap::new();
        let mut are_twice = self.frame.rows.iter().map(|row| {
            let level = self.frame.counts.conditions[row.condition as usize][factor];
            let known = ratings.entry((row.subject, level)).or_insert(0);
            *known += row.count;
            *known > 1
        });
        let is_number = matches!(variable, Variable::Number(_));
        self.spec.slopes == Slopes::Independent && !has_slope && (is_number || are_twice.any(|is_twice| is_twice))
    }

    /// Returns the number of effects of a component of the random part, and how many of them are free, given that the means
    /// over participants or items and the coefficients of terms that vary only between them are estimated.
    pub fn degrees(&self, component: usize) -> (f64, f64) {
        let own = &self.random.components[component];
        let columns = |of: &dyn Fn(&Term) -> bool| {
            let has: Vec<bool> = self.spec.terms.iter().map(of).collect();
            self.x.columns.iter().filter(|column| has.get(column.term) == Some(&true)).count() as f64
        };
        let (people, groups) = (self.frame.subjects.len() as f64, own.number_of_groups as f64);
        if own.shared {
            return (groups, groups - 1.0 - columns(&|term| self.is_between_items(term)));
        }
        if component == 0 {
            return (people, people - 1.0 - columns(&|term| self.is_between(term)));
        }
        // An effect within participants that depends on their group has a mean in each group.
        let is_own = |term: &&Term| within_part(&self.frame, term).same(&own.term);
        let mut same = self.spec.terms.iter().filter(is_own).map(|term| columns(&|other| other == term));
        let means = same.next().map_or(1.0, |first| 1.0 + same.sum::<f64>() / first.max(1.0));
        let effects = (groups - 1.0).max(1.0);
        (people * effects, (people - means) * effects)
    }

    /// Returns the number of coefficients that can be estimated.
    pub fn rank(&self) -> usize {
        self.x.columns.len()
    }
}

/// Gives the factor of a main effect another baseline, with a note, if all ratings at its first level are in the same extreme
/// category, because the thresholds and its other coefficients would then diverge.
fn with_other_baseline(frame: &mut Frame, term: &Term) -> Option<Note> {
    let [Variable::Factor(name)] = &term.variables[..] else { return None };
    let (factor, description) = frame.counts.factor(name)?;
    let levels = frame.levels(factor);
    let category = extreme_category(frame, factor, levels[0])?;
    let level = *levels.iter().find(|level| extreme_category(frame, factor, **level).is_none())?;
    let [baseline, separated] = [level, levels[0]].map(|level| description.levels[level as usize].clone());
    let note =
        Note::Rebased { factor: name.clone(), baseline, separated, category: frame.categories[category].clone() };
    frame.set_baseline(factor, level);
    Some(note)
}

/// Returns the lowest or the highest category if it contains all ratings at a level.
fn extreme_category(frame: &Frame, factor: usize, level: u32) -> Option<usize> {
    let mut ratings = (frame.rows.iter())
        .filter(|row| frame.counts.conditions[row.condition as usize][factor] == Some(level))
        .map(|row| usize::from(row.rating));
    let first = ratings.next()?;
    ((first == 0 || first == frame.categories.len() - 1) && ratings.all(|rating| rating == first)).then_some(first)
}
