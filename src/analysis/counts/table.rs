//! The data that are kept for any number of trials: counts of ratings, pairs of repeated ratings, and response times; and the
//! participants and levels that are excluded from them on request.

use std::{
    cmp::Ordering,
    collections::{BTreeMap, BTreeSet, HashMap},
};

use crate::{analysis::levels, text::names::expected_one_of};

/// A factor of the design and its levels.
#[derive(Clone, Debug, PartialEq)]
pub struct Factor {
    /// Name of the column.
    pub name: String,
    /// Names of the levels, as written: in ascending order, with `inf` last, if all of them are numbers, or else in
    /// natural order, unless their order was declared.
    pub levels: Vec<String>,
    /// The levels as numbers, if all of them are numbers in ascending order; `inf` is infinite.
    pub numbers: Option<Vec<f64>>,
    /// Whether the levels are directions, which are circular: only if they are declared so.
    pub is_direction: bool,
}

impl Factor {
    /// Creates a factor with these levels, in this order.
    pub fn new(name: impl Into<String>, levels: Vec<String>, is_direction: bool) -> Self {
        // Numbers in another order were declared so, and are names.
        let numbers = levels::numbers_of(&levels).filter(|numbers| numbers.is_sorted());
        Self { name: name.into(), levels, numbers, is_direction }
    }

    /// Returns whether the levels can meaningfully increase.
    pub fn is_ordered(&self) -> bool {
        self.numbers.is_some() && !self.is_direction
    }
}

/// The distinct combinations of levels of some factors, in order.
#[derive(Clone, Debug)]
pub(in crate::analysis) struct Combinations {
    /// The levels of each combination; `None` if the value is missing.
    pub all: Vec<Vec<Option<u32>>>,
    /// The combination to which each condition belongs.
    pub of: Vec<usize>,
}

/// One row of the table: `count` equal ratings.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct CountRow {
    /// Index into [`Counts::subjects`].
    pub subject: u32,
    /// Index into [`Counts::conditions`].
    pub condition: u32,
    /// Index into [`Counts::categories`]; 0 is the lowest.
    pub rating: u8,
    /// Number of equal ratings, at least 1.
    pub count: u64,
}

/// Counts by participant × condition × rating. The rows are sorted and unique, regardless of the order in which they
/// were added.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Counts {
    /// Names of the participants in natural order.
    pub subjects: Vec<String>,
    /// The factors, in the order in which they were named.
    pub factors: Vec<Factor>,
    /// The distinct conditions: for each factor, the index of its level, or `None` if the value is missing.
    pub conditions: Vec<Vec<Option<u32>>>,
    /// Names of the ordered categories, starting with the lowest. A category may have no ratings.
    pub categories: Vec<String>,
    /// The rows, sorted by participant, condition and rating.
    pub rows: Vec<CountRow>,
}

/// One exclusion that was applied.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Excluded {
    /// What was excluded.
    pub what: Part,
    /// Number of its ratings. Those that are also part of an earlier exclusion are not among them.
    pub ratings: u64,
    /// Number of participants who gave them.
    pub participants: u64,
}

/// A part of the ratings.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Part {
    /// The ratings of the participant with this ID.
    Participant(String),
    /// The other levels of a factor.
    Levels {
        /// Name of the factor.
        factor: String,
        /// The levels that were kept.
        kept: Vec<String>,
    },
    /// Ratings without a value of the covariate with this name, which the model needs.
    Missing(String),
}

impl Counts {
    /// Returns the number of ratings in the table.
    pub fn total(&self) -> u64 {
        self.rows.iter().map(|row| row.count).sum()
    }

    /// Returns the factor with this name and its index.
    pub fn factor(&self, name: &str) -> Option<(usize, &Factor)> {
        self.factors.iter().enumerate().find(|(_, factor)| factor.name == name)
    }

    /// Returns the names of a condition's levels, in the order of the factors. A missing value has an empty name.
    pub fn level_names(&self, condition: u32) -> Vec<&str> {
        self.names(&(0..self.factors.len()).collect::<Vec<_>>(), &self.conditions[condition as usize])
    }

    /// Returns the combinations of the levels of some factors, given by index.
    pub(in crate::analysis) fn combinations(&self, factors: &[usize]) -> Combinations {
        let of_condition = |levels: &Vec<Option<u32>>| factors.iter().map(|&factor| levels[factor]).collect();
        let own: Vec<Vec<Option<u32>>> = self.conditions.iter().map(of_condition).collect();
        let mut all = own.clone();
        all.sort_unstable();
        all.dedup();
        let of = own.iter().map(|own| all.partition_point(|other| other < own)).collect();
        Combinations { all, of }
    }

    /// Returns the names of the levels of a combination of factors, given by index. A missing value has an empty name.
    pub(in crate::analysis) fn names(&self, factors: &[usize], levels: &[Option<u32>]) -> Vec<&str> {
        let name = |(&factor, level): (&usize, &Option<u32>)| {
            level.map_or("", |level| self.factors[factor].levels[level as usize].as_str())
        };
        factors.iter().zip(levels).map(name).collect()
    }

    /// Returns whether most participants rated at least two levels of a factor.
    pub fn is_within(&self, factor: usize) -> bool {
        2 * crossing(self, &self.rows, factor).count() > self.rows.chunk_by(|l, r| l.subject == r.subject).count()
    }

    /// Returns whether each level of a factor occurs with one level of another one, which has several. The effects of both
    /// cannot be told apart.
    pub fn determines(&self, own: usize, other: usize) -> bool {
        let mut found = HashMap::new();
        let mut all = self.conditions.iter().map(|levels| (levels[own], levels[other]));
        own != other
            && self.factors[other].levels.len() > 1
            && all.all(|(own, other)| *found.entry(own).or_insert(other) == other)
    }

    /// Returns whether other levels of one factor occur at some levels of another one, `own`, than at others.
    pub fn differs_between(&self, other: usize, own: usize) -> bool {
        let at = |level: u32| -> BTreeSet<Option<u32>> {
            let here = self.conditions.iter().filter(|levels| levels[own] == Some(level));
            here.map(|levels| levels[other]).collect()
        };
        other != own && (0..self.factors[own].levels.len() as u32).any(|level| at(level) != at(0))
    }

    /// Returns two levels of a factor between which the values of a number do not overlap, with the lower values first.
    pub fn apart(&self, number: usize, factor: usize) -> Option<[u32; 2]> {
        let numbers = self.factors[number].numbers.as_ref()?;
        let mut ranges: BTreeMap<u32, [f64; 2]> = BTreeMap::new();
        for levels in &self.conditions {
            if let (Some(level), Some(value)) = (levels[factor], levels[number]) {
                let value = numbers[value as usize];
                let [low, high] = ranges.entry(level).or_insert([value, value]);
                (*low, *high) = (low.min(value), high.max(value));
            }
        }
        let above = |[_, high]: [f64; 2]| ranges.iter().find(|(_, [low, _])| *low > high);
        ranges.iter().find_map(|(level, range)| Some([*level, *above(*range)?.0]))
    }

    /// Returns a factor among `others` that this one determines. Of two that determine each other, only the later one has
    /// such a factor.
    pub fn determined_by(&self, own: usize, others: &[usize]) -> Option<usize> {
        let is_other = |other: &usize| self.determines(own, *other) && !(own < *other && self.determines(*other, own));
        others.iter().copied().find(is_other)
    }

    /// Returns whether a factor describes the participants and not what they saw: numbers that are the same in all ratings of
    /// each participant, with at least four different ones.
    pub fn is_covariate(&self, factor: usize) -> bool {
        let levels = |rows: &[CountRow]| -> BTreeSet<Option<u32>> {
            rows.iter().map(|row| self.conditions[row.condition as usize][factor]).collect()
        };
        let mut people = self.rows.chunk_by(|l, r| l.subject == r.subject);
        self.factors[factor].is_ordered()
            && self.factors[factor].levels.len() >= LEAST_COVARIATE
            && people.all(|rows| levels(rows).len() == 1)
    }

    /// True if the order of the categories is known: they were declared, or they are numbers. Words in the order of their
    /// letters (high, low, medium) would give a result, but a wrong one.
    pub fn is_ordered(&self, declared: Option<&[String]>) -> bool {
        declared.is_some() || levels::numbers_of(&self.categories).is_some()
    }

    /// Returns the categories that look like mistakes or like codes for a missing answer, with their numbers of ratings.
    ///
    /// Mistakes are categories with less than 2 % of the ratings that are further from all others than any two usual
    /// ones from each other at least are, also as a chain; a single rating that is further from at least three
    /// others than twice their range; or one rating, or at most one in 50, between at least three whole numbers. Codes are infinite, or numbers of digits from 7 to 9 only, at least 9 or
    /// negative, that are isolated from the other categories, of which there are at least two. A positive code is
    /// further above them than they are from each other, and 9 is one only if their neighbors are 1 apart (0, 1, 3, 9
    /// is a scale). A negative one is further below them than any two neighbors are apart, and no other number is
    /// negative. −1 is also a code if the others are from 0 or more to at least 2. A full scale, such as 1…7, 0…100 or
    /// −9…9, has no such number.
    pub fn codes(&self) -> Vec<(&str, u64)> {
        let Some(numbers) = levels::numbers_of(&self.categories) else { return Vec::new() };
        let is_code = |number: f64| {
            let digits = number.abs().to_string();
            number == -1.0
                || number.is_infinite()
                || !(0.0..9.0).contains(&number) && digits.bytes().all(|byte| matches!(byte, b'7'..=b'9'))
        };
        let mut others: Vec<f64> = numbers.iter().copied().filter(|number| !is_code(*number)).collect();
        others.sort_by(f64::total_cmp);
        let (Some(&least), Some(&most)) = (others.first(), others.last()) else { return Vec::new() };
        let widest = others.windows(2).map(|pair| pair[1] - pair[0]).fold(0.0, f64::max);
        let is_isolated = |number: f64| match number {
            9.0 if widest > 1.0 => false,
            number if number.is_infinite() => true,
            number if number >= 0.0 => number - most > most - least,
            -1.0 => least >= 0.0 && most >= 2.0 && numbers.iter().all(|other| *other >= -1.0),
            number => least >= 0.0 && least - number > widest,
        };
        let codes = numbers.iter().enumerate().filter(|(_, number)| is_code(**number) && is_isolated(**number));
        let ratings = |code: usize| -> u64 {
            self.rows.iter().filter(|row| usize::from(row.rating) == code).map(|row| row.count).sum()
        };
        let mut found: Vec<usize> = codes.filter(|_| others.len() > 1).map(|(code, _)| code).collect();
        let n: Vec<u64> = (0..numbers.len()).map(ratings).collect();
        let used: Vec<usize> = (0..numbers.len()).filter(|code| n[*code] > 0 && !found.contains(code)).collect();
        let total: u64 = n.iter().sum();
        let is_common = |code: &usize| 50 * n[*code] >= total;
        let common: Vec<f64> = used.iter().filter(|code| is_common(code)).map(|code| numbers[*code]).collect();
        let step = common.windows(2).map(|pair| pair[1] - pair[0]).fold(0.0, f64::max);
        for chain in used.chunk_by(|a, b| numbers[*b] - numbers[*a] <= step + 1e-9).filter(|_| common.len() > 1) {
            found.extend(chain.iter().filter(|_| !chain.iter().any(is_common)));
        }
        if let [first, second, .., before, last] = used[..] {
            for (code, near, end) in [(first, second, last), (last, before, first)] {
                let (gap, width) = (numbers[code] - numbers[near], numbers[near] - numbers[end]);
                found.extend((n[code] == 1 && gap.abs() > 2.0 * width.abs()).then_some(code));
            }
        }
        let (whole, between): (Vec<usize>, Vec<usize>) = used.iter().partition(|code| numbers[**code].fract() == 0.0);
        let are_few = 50 * between.iter().map(|code| n[*code]).sum::<u64>() <= total.max(50);
        found.extend(between.into_iter().filter(|_| are_few && whole.len() > 2));
        found.sort_unstable();
        found.dedup();
        found.into_iter().map(|code| (self.categories[code].as_str(), n[code])).filter(|(_, n)| *n > 0).collect()
    }
}

/// Returns rows in order, one for each participant, condition and rating.
pub(super) fn summed(mut rows: Vec<CountRow>) -> Vec<CountRow> {
    rows.sort_unstable();
    rows.dedup_by(|next, own| {
        let is_same = (next.subject, next.condition, next.rating) == (own.subject, own.condition, own.rating);
        own.count += if is_same { next.count } else { 0 };
        is_same
    });
    rows
}

/// With fewer different numbers, they may be groups.
const LEAST_COVARIATE: usize = 4;

/// Returns the participants in these rows who rated at least two levels of a factor.
pub(crate) fn crossing(counts: &Counts, rows: &[CountRow], factor: usize) -> impl Iterator<Item = u32> {
    rows.chunk_by(|l, r| l.subject == r.subject).filter_map(move |own| {
        let mut levels = own.iter().filter_map(|row| counts.conditions[row.condition as usize][factor]);
        let first = levels.next();
        levels.any(|level| Some(level) != first).then_some(own[0].subject)
    })
}

/// The ratings of a study.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Measured {
    /// How often each participant gave each rating in each condition.
    pub counts: Counts,
    /// The trials whose response time or place is known. A row that stands for several ratings has none.
    pub trials: Vec<Trial>,
    /// What was excluded on request from the ratings that were read; nothing of it is in the other fields.
    pub excluded: Vec<Excluded>,
}

/// The response time and the place of a rating.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Trial {
    /// Index into [`Counts::subjects`].
    pub subject: u32,
    /// Index into [`Counts::conditions`].
    pub condition: u32,
    /// Index into [`Counts::categories`].
    pub rating: u8,
    /// The response time, if it is known.
    pub seconds: Option<f64>,
    /// Number of the session; only trials of one participant with the same number follow each other.
    pub session: u32,
    /// Place in the session, if it is known.
    pub position: Option<f64>,
    /// Number of the repetition of the condition in the session, if it is known.
    pub repetition: Option<u32>,
}

impl Measured {
    /// Returns, for each participant, the first and the second rating of each condition that the participant rated more than
    /// once, if their order is known: indices into [`Counts::categories`]. At the same place, a lower rating counts as
    /// earlier.
    pub fn retests(&self) -> Vec<Vec<[u8; 2]>> {
        let place = |trial: &Trial| trial.repetition.map(f64::from).or(trial.position);
        // Ratings without a level of some factor belong to no condition.
        let is_placed = |trial: &&Trial| place(trial).is_some() && self.counts.is_complete(trial.condition);
        let mut placed: Vec<&Trial> = self.trials.iter().filter(is_placed).collect();
        placed.sort_by(|l, r| {
            let cell = |trial: &Trial| (trial.subject, trial.condition, trial.session);
            // Places are never NaN.
            let order = cell(l).cmp(&cell(r)).then(place(l).partial_cmp(&place(r)).unwrap_or(Ordering::Equal));
            order.then(l.rating.cmp(&r.rating))
        });
        let mut retests = vec![Vec::new(); self.counts.subjects.len()];
        for cell in placed.chunk_by(|l, r| (l.subject, l.condition) == (r.subject, r.condition)) {
            if let [first, second, ..] = cell {
                retests[first.subject as usize].push([first.rating, second.rating]);
            }
        }
        retests
    }

    /// Returns the median response time in each group, in seconds. Each time goes into the group that `group_of` returns, if
    /// any.
    pub fn times_by(&self, groups: usize, group_of: impl Fn(&Trial) -> Option<usize>) -> Vec<Option<f64>> {
        let mut times = vec![Vec::new(); groups];
        for row in &self.trials {
            if let Some((group, seconds)) = group_of(row).zip(row.seconds) {
                times[group].push(seconds);
            }
        }
        times.into_iter().map(median).collect()
    }

    /// Returns the ratings without some factors, given by index: conditions that differ only in them are one.
    pub fn without_factors(&self, left_out: &[usize]) -> Self {
        let Counts { subjects, factors, categories, .. } = &self.counts;
        let kept: Vec<usize> = (0..factors.len()).filter(|factor| !left_out.contains(factor)).collect();
        let Combinations { all, of } = self.counts.combinations(&kept);
        let counts = Counts {
            subjects: subjects.clone(),
            factors: kept.iter().map(|&factor| factors[factor].clone()).collect(),
            categories: categories.clone(),
            conditions: all,
            rows: Vec::new(),
        };
        self.moved(counts, |subject, condition| Some((subject, of[condition as usize] as u32)))
    }

    /// Returns the ratings in a table without rows, with the indices of participants and conditions there that `moved` returns
    /// for those here. Ratings for which it returns none are left out.
    fn moved(&self, to: Counts, moved: impl Fn(u32, u32) -> Option<(u32, u32)>) -> Self {
        let row = |row: &CountRow| {
            let (subject, condition) = moved(row.subject, row.condition)?;
            Some(CountRow { subject, condition, ..*row })
        };
        let trial = |trial: &Trial| {
            let (subject, condition) = moved(trial.subject, trial.condition)?;
            Some(Trial { subject, condition, ..*trial })
        };
        let rows = summed(self.counts.rows.iter().filter_map(row).collect());
        let trials = self.trials.iter().filter_map(trial).collect();
        Self { counts: Counts { rows, ..to }, trials, excluded: self.excluded.clone() }
    }

    /// Returns the ratings by some participants in some conditions. Levels and participants without ratings are
    /// dropped; all categories stay.
    pub fn filtered(&self, subject: impl Fn(u32) -> bool, condition: impl Fn(&[Option<u32>]) -> bool) -> Self {
        let counts = &self.counts;
        let kept: Vec<bool> = counts.conditions.iter().map(|levels| condition(levels)).collect();
        let keep = |s: u32, c: u32| subject(s) && kept[c as usize];
        let rows = || counts.rows.iter().filter(|row| keep(row.subject, row.condition));
        let subjects = Kept::new(rows().map(|row| row.subject));
        let conditions = Kept::new(rows().map(|row| row.condition));
        let levels: Vec<Kept> = (0..counts.factors.len())
            .map(|factor| Kept::new(conditions.0.iter().filter_map(|&c| counts.conditions[c as usize][factor])))
            .collect();
        let factors = counts
            .factors
            .iter()
            .zip(&levels)
            .map(|(factor, kept)| Factor::new(&factor.name, kept.of(&factor.levels), factor.is_direction));
        let renumbered = |levels_of: &Vec<Option<u32>>| {
            levels_of.iter().zip(&levels).map(|(level, kept)| level.map(|level| kept.index(level))).collect()
        };
        let left = Counts {
            subjects: subjects.of(&counts.subjects),
            factors: factors.collect(),
            conditions: conditions.of(&counts.conditions).iter().map(renumbered).collect(),
            categories: counts.categories.clone(),
            rows: Vec::new(),
        };
        self.moved(left, |s, c| keep(s, c).then(|| (subjects.index(s), conditions.index(c))))
    }
}

/// The indices that are kept, in order.
struct Kept(Vec<u32>);

impl Kept {
    fn new(indices: impl Iterator<Item = u32>) -> Self {
        Self(indices.collect::<BTreeSet<_>>().into_iter().collect())
    }

    /// Returns the new index of an index that is kept.
    fn index(&self, old: u32) -> u32 {
        self.0.partition_point(|kept| *kept < old) as u32
    }

    /// Returns the elements of a list that are kept.
    fn of<T: Clone>(&self, all: &[T]) -> Vec<T> {
        self.0.iter().map(|&index| all[index as usize].clone()).collect()
    }
}

/// Returns the smallest response time that at least half of the times do not exceed, or `None` if there are no times.
fn median(mut times: Vec<f64>) -> Option<f64> {
    times.sort_unstable_by(f64::total_cmp);
    times.get(times.len().div_ceil(2).checked_sub(1)?).copied()
}

// The largest study that is analyzed unless the user asks for more. Tests of all pairs of levels take quadratic time,
// every simulated study has all participants, and a name is drawn in every chart.

/// Maximum number of factors. A stimulus has at most ten parameters; a term is tested for each factor.
const MAX_FACTORS: usize = 10;
/// Maximum number of levels of a factor. Factors with more, such as a response time, are measurements and not factors.
pub(in crate::analysis) const MAX_LEVELS: usize = 120;
/// Maximum number of conditions. A full crossing of 6, 5 and 4 levels has 120.
const MAX_CONDITIONS: usize = 5000;
/// Maximum number of participants.
const MAX_PEOPLE: usize = 20_000;
/// Maximum length in bytes of the name of a participant, factor, level or category.
const MAX_NAME: usize = 200;

impl Counts {
    /// Checks that the study is small enough to be analyzed within seconds.
    ///
    /// # Errors
    /// Says what is too large, and what is expected.
    pub fn check_size(&self) -> Result<(), String> {
        let at_most = |what: &str, found: usize, most: usize| match found > most {
            true => Err(format!("the number of {what} is {found}; expected at most {most}")),
            false => Ok(()),
        };
        at_most("factors", self.factors.len(), MAX_FACTORS)?;
        let of_factors = self.factors.iter().flat_map(|factor| std::iter::once(&factor.name).chain(&factor.levels));
        if let Some(long) = of_factors.chain(&self.subjects).chain(&self.categories).find(|name| name.len() > MAX_NAME)
        {
            let start = &long[..long.floor_char_boundary(40)];
            at_most(&format!("bytes of the name {start:?}…"), long.len(), MAX_NAME)?;
        }
        for factor in &self.factors {
            let as_number = match factor.numbers {
                Some(_) => format!(" or, because all levels are numbers, the term num:{}", factor.name),
                None => String::new(),
            };
            at_most(&format!("levels of {}", factor.name), factor.levels.len(), MAX_LEVELS)
                .map_err(|text| text + &as_number)?;
        }
        at_most("conditions", self.conditions.len(), MAX_CONDITIONS)?;
        at_most("participants", self.subjects.len(), MAX_PEOPLE)
    }
}

/// The word for a missing level in [`Exclusions::only`]. No level has this name.
pub const MISSING: &str = "NA";

/// What to exclude.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Exclusions {
    /// Participants to leave out.
    pub exclude: Vec<String>,
    /// Factors, each with the levels to keep. `NA` stands for a missing value.
    pub only: Vec<(String, Vec<String>)>,
}

impl Counts {
    /// Returns the number of conditions in which every factor has a value.
    pub fn complete_conditions(&self) -> u64 {
        (0..self.conditions.len() as u32).filter(|condition| self.is_complete(*condition)).count() as u64
    }

    /// Returns whether every factor has a value in a condition.
    pub(in crate::analysis) fn is_complete(&self, condition: u32) -> bool {
        self.conditions[condition as usize].iter().all(Option::is_some)
    }

    /// Returns the levels of a factor, and `NA` if it has missing values.
    pub fn selectable_levels(&self, factor: usize) -> Vec<String> {
        let is_missing = self.conditions.iter().any(|levels| levels[factor].is_none());
        self.factors[factor].levels.iter().cloned().chain(is_missing.then(|| MISSING.to_owned())).collect()
    }
}

impl Measured {
    /// Returns the ratings that are kept; the others are recorded as excluded.
    fn keeping(&self, what: Part, subject: impl Fn(u32) -> bool, levels: impl Fn(&[Option<u32>]) -> bool) -> Self {
        let counts = &self.counts;
        let is_out = |row: &&CountRow| !subject(row.subject) || !levels(&counts.conditions[row.condition as usize]);
        let out: Vec<&CountRow> = counts.rows.iter().filter(is_out).collect();
        let participants = out.iter().map(|row| row.subject).collect::<BTreeSet<_>>().len() as u64;
        let excluded = Excluded { what, ratings: out.iter().map(|row| row.count).sum(), participants };
        let mut left = self.filtered(subject, levels);
        left.excluded.push(excluded);
        left
    }

    /// Returns the ratings that have values of these factors, given by index, unless none would be left. The others are
    /// recorded as excluded.
    #[must_use]
    pub(in crate::analysis) fn complete(mut self, factors: &[usize]) -> Self {
        for &factor in factors {
            let has = |row: &&CountRow| self.counts.conditions[row.condition as usize][factor].is_some();
            let kept = self.counts.rows.iter().filter(has).count();
            if kept > 0 && kept < self.counts.rows.len() {
                let what = Part::Missing(self.counts.factors[factor].name.clone());
                self = self.keeping(what, |_| true, |levels| levels[factor].is_some());
            }
        }
        self
    }

    /// Returns the ratings without what is to be excluded. Each rating is counted once: for its participant, or else for the
    /// first factor that excludes it.
    ///
    /// # Errors
    /// A name is not known, or no ratings are left: the field of [`Exclusions`] that says so, and what is wrong.
    pub fn narrowed(&self, Exclusions { exclude, only }: &Exclusions) -> Result<Self, (&'static str, String)> {
        let known = &self.counts.subjects;
        if let Some(id) = exclude.iter().find(|id| !known.contains(id)) {
            return Err(("exclude", format!("{id} is not a participant; {}", expected_one_of(id, known))));
        }
        only.iter().try_for_each(|(name, kept)| levels(&self.counts, name, kept)).map_err(|error| ("only", error))?;
        let mut left = self.clone();
        for id in exclude {
            // Someone who is named twice is already left out.
            if let Some(index) = left.counts.subjects.iter().position(|own| own == id) {
                left = left.keeping(Part::Participant(id.clone()), |subject| subject as usize != index, |_| true);
            }
        }
        for (name, kept) in only {
            let Some((index, factor)) = left.counts.factor(name) else { continue };
            let level_of = |level: u32| factor.levels[level as usize].as_str();
            let is_kept =
                |levels: &[Option<u32>]| kept.iter().any(|own| own == levels[index].map_or(MISSING, level_of));
            left = left.keeping(Part::Levels { factor: name.clone(), kept: kept.clone() }, |_| true, is_kept);
        }
        if left.counts.total() == 0 && self.counts.total() > 0 {
            return Err(("exclude", "no ratings are left; expected to keep some participants and levels".to_owned()));
        }
        Ok(left)
    }
}

impl Counts {
    /// Checks the names of factors and of their levels.
    ///
    /// # Errors
    /// A name is not known.
    pub fn check_levels(&self, named: &[(String, Vec<String>)]) -> Result<(), String> {
        named.iter().try_for_each(|(name, own)| {
            let factor = self.factors.iter().find(|factor| factor.name == *name);
            let numbers: Vec<f64> =
                factor.iter().flat_map(|factor| &factor.levels).filter_map(|level| levels::number_of(level)).collect();
            // A number names a level however it is written: 2.0 is 2.
            let is_number = |level: &&String| levels::number_of(level).is_some_and(|number| numbers.contains(&number));
            let texts: Vec<String> = own.iter().filter(|level| !is_number(level)).cloned().collect();
            levels(self, name, &texts)
        })
    }
}

/// Checks the name of a factor and of its levels.
fn levels(counts: &Counts, name: &str, kept: &[String]) -> Result<(), String> {
    let Some((index, _)) = counts.factor(name) else {
        let known: Vec<&String> = counts.factors.iter().map(|factor| &factor.name).collect();
        return Err(format!("{name} is not a factor; {}", expected_one_of(name, &known)));
    };
    let known = counts.selectable_levels(index);
    let unknown = kept.iter().find(|level| !known.contains(level));
    unknown.map_or(Ok(()), |level| {
        let repeat = if level.contains('=') { "; repeat the option for another factor" } else { "" };
        Err(format!("{level} is not a level of {name}; {}{repeat}", expected_one_of(level, &known)))
    })
}
