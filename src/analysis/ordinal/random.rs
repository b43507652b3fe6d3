//! The random part of a model: which effects vary between participants, and how they enter each design row.
//!
//! The independent form is R's `(1 | subject) + (1 | subject:width) + (0 + x | subject)`: an intercept, a deviation of
//! each participant at each level of a factor, and a slope on a number about its mean. The correlated form is
//! `(1 + width | subject)`: an intercept and the contrasts of the factors, with all their covariances. Items add `(1 | item)`
//! to the independent form: effects that all participants share.

use std::collections::{BTreeMap, BTreeSet};

use super::{
    arrow::Blocks,
    design::Design,
    model::{ModelError, ModelSpec, Note, Random, Slopes},
    terms::{Term, Terms, Variable},
};
use crate::analysis::{
    counts::crossing,
    frame::{Frame, factors_of, find_factor},
};

/// A random slope needs on average this many ratings per participant and level; with fewer, it cannot be told apart
/// from the variation between ratings.
const RATINGS_PER_EFFECT: u64 = 2;
/// Maximum number of random effects per participant: the time for a fit grows with the cube.
const MAX_EFFECTS: usize = 150;
/// Maximum number of random effects of all participants and items together, if there are items.
const MAX_CROSSED: usize = 1000;
/// Maximum number of correlated effects; 10 have 55 variances and covariances.
const MAX_CORRELATED: usize = 10;

/// Effects that share a standard deviation: one for each group of conditions.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Component {
    /// Name of the term, or of the contrast if the effects are correlated; empty for the intercept.
    pub name: String,
    /// The term; without variables for the intercept.
    pub term: Term,
    /// The group of each condition of the table.
    groups: Vec<usize>,
    pub number_of_groups: usize,
    /// The weight of the effect in each condition, divided by `unit`.
    values: Vec<f64>,
    /// Size of the values on the scale of the data.
    pub unit: f64,
    /// True for items: all participants share the effects.
    pub shared: bool,
}

/// The random part of a model.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct RandomPart {
    pub correlated: bool,
    /// The intercept, followed by the slopes.
    pub components: Vec<Component>,
}

impl Component {
    /// Creates a component with the given values, scaled to at most 1.
    fn new(name: String, term: Term, mut values: Vec<f64>, groups: Vec<usize>, number_of_groups: usize) -> Self {
        let unit = values.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
        let unit = if unit > 0.0 { unit } else { 1.0 };
        values.iter_mut().for_each(|value| *value /= unit);
        Self { name, term, groups, number_of_groups, values, unit, shared: false }
    }
}

impl RandomPart {
    /// Determines the random part that a specification asks for and that the design supports, with a note for each
    /// slope that it does not.
    pub fn new(frame: &Frame, spec: &ModelSpec, notes: &mut Vec<Note>) -> Result<Self, ModelError> {
        if spec.random == Random::None {
            return Ok(Self::default());
        }
        let intercept = independent(frame, &Term { variables: Vec::new() })?;
        let mut part = Self { correlated: false, components: vec![intercept] };
        match spec.slopes {
            Slopes::None => {}
            Slopes::Independent => part.add_independent(frame, &spec.terms, notes)?,
            Slopes::Correlated => part.add_correlated(frame, &spec.terms)?,
        }
        if let Some(items) = &spec.items {
            let of_items = independent(frame, &Term::factor(items))?;
            part.components.push(Component { name: items.clone(), shared: true, ..of_items });
            part.check_items(spec, items, frame.subjects.len())?;
        }
        Ok(part)
    }

    fn add_independent(&mut self, frame: &Frame, terms: &Terms, notes: &mut Vec<Note>) -> Result<(), ModelError> {
        let mut own: Vec<(u64, Component)> = Vec::new();
        for term in terms.iter() {
            let part = within_part(frame, term);
            if part.variables.is_empty() || own.iter().any(|(_, other)| other.term.same(&part)) {
                continue;
            }
            let component = independent(frame, &part)?;
            // The deviation of someone who rated one level is not an effect besides the intercept.
            let crossing: BTreeSet<u32> =
                factors_of(frame.counts, &part).flat_map(|own| crossing(frame.counts, &frame.rows, own)).collect();
            let rows = frame.rows.iter().filter(|row| crossing.contains(&row.subject));
            let of_subjects: BTreeSet<(u32, usize)> =
                rows.map(|row| (row.subject, component.groups[row.condition as usize])).collect();
            own.push((of_subjects.len() as u64, component));
        }
        // The order of the terms must not decide which of them has a slope: those with the fewest effects come first, and of
        // those with equally many, all or none have one.
        let mut by_size: Vec<usize> = (0..own.len()).collect();
        by_size.sort_by_key(|&place| own[place].0);
        let (mut effects, mut groups) = (frame.subjects.len() as u64, 1);
        let mut is_supported = vec![false; own.len()];
        for same in by_size.chunk_by(|a, b| own[*a].0 == own[*b].0) {
            effects += same.iter().map(|&place| own[place].0).sum::<u64>();
            groups += same.iter().map(|&place| own[place].1.number_of_groups).sum::<usize>();
            if frame.total() < RATINGS_PER_EFFECT * effects || groups > MAX_EFFECTS {
                break;
            }
            same.iter().for_each(|&place| is_supported[place] = true);
        }
        for ((_, component), is_supported) in own.into_iter().zip(is_supported) {
            if is_supported {
                self.components.push(component);
            } else {
                notes.push(Note::NoSlope { term: component.name, of: component.term });
            }
        }
        Ok(())
    }

    fn add_correlated(&mut self, frame: &Frame, terms: &Terms) -> Result<(), ModelError> {
        let main = terms.iter().filter(|term| term.is_main()).map(|term| within_part(frame, term));
        let own = Terms::new(main.filter(Term::is_main));
        let design = Design::new(frame, &own)?.independent(frame);
        let effects = 1 + design.columns.len();
        if effects > MAX_CORRELATED {
            return Err(ModelError::TooManySlopes { effects, most: MAX_CORRELATED });
        }
        let conditions: Vec<u32> = (0..frame.counts.conditions.len() as u32).collect();
        for (column, values) in design.columns.iter().zip(design.matrix(&conditions).column_iter()) {
            let mut values: Vec<f64> = values.iter().copied().collect();
            if values.iter().any(|value| *value != 0.0 && *value != 1.0) {
                center(frame, &mut values);
            }
            let term = Term { variables: column.parts.iter().map(|part| part.variable.clone()).collect() };
            self.components.push(Component::new(column.name.clone(), term, values, vec![0; conditions.len()], 1));
        }
        self.correlated = self.components.len() > 1;
        Ok(())
    }

    fn check_items(&self, spec: &ModelSpec, items: &str, people: usize) -> Result<(), ModelError> {
        let error = |expected: &'static str| Err(ModelError::Items { items: items.to_owned(), expected });
        let mut variables = spec.terms.iter().flat_map(|term| &term.variables);
        match self.effects() {
            _ if variables.any(|variable| variable.name() == items) => error("a column that no term uses"),
            _ if self.correlated => error("independent random slopes"),
            (_, 0 | 1) => error("at least two items"),
            (own, items) if own * people + items > MAX_CROSSED => {
                error("at most 1000 random effects of participants and items together")
            }
            _ => Ok(()),
        }
    }

    /// Returns whether participants share effects.
    pub fn is_crossed(&self) -> bool {
        self.components.iter().any(|component| component.shared)
    }

    /// Returns the number of effects of each participant, and that of those that all participants share.
    pub fn effects(&self) -> (usize, usize) {
        let groups = |shared: bool| {
            self.components.iter().filter(move |c| c.shared == shared).map(|c| c.number_of_groups).sum::<usize>()
        };
        (groups(false), groups(true))
    }

    /// Returns the number of parameters ψ.
    pub fn parameters(&self) -> usize {
        self.elements().count()
    }

    /// Returns, for each ψ, the number by which it is divided to convert it to the scale of the data.
    pub fn units(&self) -> Vec<f64> {
        self.elements().map(|(row, _)| self.components[row].unit).collect()
    }

    /// Returns the row and the column of each ψ in the Cholesky factor of the covariance, column by column: only those on
    /// the diagonal if the effects are independent.
    pub fn elements(&self) -> impl Iterator<Item = (usize, usize)> + use<> {
        let (size, correlated) = (self.components.len(), self.correlated);
        let rows = move |column| column..if correlated { size } else { column + 1 };
        (0..size).flat_map(move |column| rows(column).map(move |row| (row, column)))
    }

    /// Returns a key that is equal for conditions with the same effects.
    pub fn key(&self, condition: u32) -> impl Iterator<Item = u64> + '_ {
        let at = condition as usize;
        self.components.iter().flat_map(move |c| [c.groups[at] as u64, (c.values[at] + 0.0).to_bits()])
    }
}

/// Returns the variables of a term of which any participant rated several levels.
pub(super) fn within_part(frame: &Frame, term: &Term) -> Term {
    let is_within = |factor| crossing(frame.counts, &frame.rows, factor).next().is_some();
    let is_own = |variable: &&Variable| find_factor(frame.counts, variable).is_ok_and(|(own, _)| is_within(own));
    Term { variables: term.variables.iter().filter(is_own).cloned().collect() }
}

/// Creates the deviations at each combination of a term's levels, multiplied by the term's numbers about their means.
fn independent(frame: &Frame, term: &Term) -> Result<Component, ModelError> {
    let counts = frame.counts;
    let mut values = vec![1.0; counts.conditions.len()];
    let mut keys: Vec<Vec<Option<u32>>> = vec![Vec::new(); counts.conditions.len()];
    for variable in &term.variables {
        let (factor, inverse) = find_factor(counts, variable)?;
        match variable {
            Variable::Factor(_) => {
                keys.iter_mut().zip(&counts.conditions).for_each(|(key, levels)| key.push(levels[factor]));
            }
            Variable::Number(_) => {
                let numbers = frame.numbers(factor, inverse)?;
                let number = |levels: &Vec<Option<u32>>| levels[factor].map_or(0.0, |level| numbers[level as usize]);
                let mut own: Vec<f64> = counts.conditions.iter().map(number).collect();
                center(frame, &mut own);
                values.iter_mut().zip(own).for_each(|(value, own)| *value *= own);
            }
        }
    }
    let places: BTreeMap<&Vec<Option<u32>>, usize> =
        frame.conditions().iter().map(|c| (&keys[*c as usize], 0)).collect();
    let places: BTreeMap<_, usize> = places.into_keys().zip(0..).collect();
    let groups = keys.iter().map(|key| places.get(key).copied().unwrap_or(0)).collect();
    Ok(Component::new(term.to_string(), term.clone(), values, groups, places.len()))
}

/// Subtracts the mean over all ratings. Conditions that do not occur, which may lack the number, have the value 0.
fn center(frame: &Frame, values: &mut [f64]) {
    let mean = frame.mean(|condition| values[condition]);
    let mut centered = vec![0.0; values.len()];
    frame.conditions().into_iter().for_each(|c| centered[c as usize] = values[c as usize] - mean);
    values.copy_from_slice(&centered);
}

/// How the standardized effects of a participant enter each design row: each row has a fixed number of slots, each slot
/// belongs to one effect, and its weight is a sum of parameters times values. If participants share effects, these are the
/// effects of all participants, one after the other, followed by the shared ones, and each row belongs to one participant.
#[derive(Clone, Debug)]
pub(super) struct Loadings {
    /// Effects that are related only through the others: those of different participants, or those of a participant at
    /// different levels of the component with the most of them, which come first.
    pub blocks: Blocks,
    /// Number of parameters ψ.
    pub parameters: usize,
    pub slots_per_row: usize,
    /// The effect of each slot, row by row.
    slots: Vec<usize>,
    /// The contribution of each parameter, row by row.
    entries: Vec<Entry>,
    /// The parameters that are standard deviations, whose sign does not matter.
    pub deviations: Vec<usize>,
    /// True if every parameter is a standard deviation, so that each may be 0 by itself.
    pub independent: bool,
}

/// A contribution to the weight of a slot: a parameter times a value.
#[derive(Clone, Copy, Debug)]
pub(super) struct Entry {
    pub slot: usize,
    pub parameter: usize,
    pub value: f64,
}

impl Loadings {
    /// Lays out the effects of `people` participants for the design rows: the index of the participant, and the condition.
    pub fn new(part: &RandomPart, rows: &[(usize, u32)], people: usize) -> Self {
        let components = &part.components;
        let (own, shared) = part.effects();
        let (mut slots, mut entries) = (Vec::new(), Vec::new());
        let largest = (0..components.len()).max_by_key(|&place| components[place].number_of_groups).unwrap_or(0);
        let is_first = |place: usize| place == largest && !part.is_crossed() && !part.correlated;
        // Where the effects of each component begin.
        let mut firsts = vec![0; components.len()];
        let mut order: Vec<usize> = (0..components.len()).filter(|&place| !components[place].shared).collect();
        order.sort_by_key(|&place| !is_first(place));
        let mut next = 0;
        for place in order {
            firsts[place] = next;
            next += components[place].number_of_groups;
        }
        for (person, condition) in rows.iter().map(|(person, condition)| (*person, *condition as usize)) {
            for (place, component) in components.iter().enumerate() {
                let first = if component.shared { people * own } else { person * own + firsts[place] };
                slots.push(first + component.groups[condition]);
            }
            entries.extend(part.elements().enumerate().map(|(parameter, (row, column))| Entry {
                slot: column,
                parameter,
                value: components[row].values[condition],
            }));
        }
        let blocks = match components.get(largest).filter(|_| is_first(largest)) {
            Some(component) => {
                let number = component.number_of_groups;
                Blocks { number, size: 1, rest: own - number }
            }
            None => Blocks { number: people, size: own, rest: shared },
        };
        let elements: Vec<(usize, usize)> = part.elements().collect();
        let is_deviation = |parameter: &usize| elements[*parameter].0 == elements[*parameter].1;
        Self {
            blocks,
            slots_per_row: components.len(),
            slots,
            entries,
            deviations: (0..elements.len()).filter(is_deviation).collect(),
            independent: !part.correlated,
            parameters: elements.len(),
        }
    }

    pub fn effects(&self) -> usize {
        self.blocks.number * self.blocks.size + self.blocks.rest
    }

    pub fn entries(&self, row: usize) -> &[Entry] {
        &self.entries[row * self.parameters..(row + 1) * self.parameters]
    }

    /// Returns the effect of each slot with its weight, row by row.
    pub fn weights(&self, psi: &[f64]) -> Vec<(usize, f64)> {
        let mut weights: Vec<(usize, f64)> = self.slots.iter().map(|&effect| (effect, 0.0)).collect();
        let rows = weights.chunks_mut(self.slots_per_row.max(1)).zip(self.entries.chunks(self.parameters.max(1)));
        for (weights, entries) in rows {
            for entry in entries {
                weights[entry.slot].1 += psi[entry.parameter] * entry.value;
            }
        }
        weights
    }
}
