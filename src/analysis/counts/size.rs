//! The largest study that is analyzed unless the user asks for more. Tests of all pairs of levels take quadratic time,
//! every simulated study has all participants, and a name is drawn in every chart.

use super::table::Counts;

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
        for factor in &self.factors {
            let (name, _) = shortened(&factor.name);
            let as_number = match factor.numbers {
                Some(_) => format!(" or, because all levels are numbers, the term num:{name}"),
                None => String::new(),
            };
            at_most(&format!("levels of {name}"), factor.levels.len(), MAX_LEVELS).map_err(|text| text + &as_number)?;
        }
        at_most("conditions", self.conditions.len(), MAX_CONDITIONS)?;
        at_most("participants", self.subjects.len(), MAX_PEOPLE)?;
        let of_factors = self.factors.iter().flat_map(|factor| std::iter::once(&factor.name).chain(&factor.levels));
        for name in of_factors.chain(&self.subjects).chain(&self.categories) {
            let (start, is_cut) = shortened(name);
            if is_cut {
                at_most(&format!("bytes of the name {start:?}…"), name.len(), MAX_NAME)?;
            }
        }
        Ok(())
    }
}

/// Returns the beginning of a name that is too long, and whether it is.
fn shortened(name: &str) -> (&str, bool) {
    let is_long = name.len() > MAX_NAME;
    (if is_long { &name[..name.floor_char_boundary(40)] } else { name }, is_long)
}
