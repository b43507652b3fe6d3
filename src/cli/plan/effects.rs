//! The grammar of `--effect`: `NAME=VALUE` is a parameter of the observer, `FACTOR:LEVEL=LOGITS` an effect of a level.

use crate::{
    analysis::power::Shift,
    cli::UsageError,
    experiment::{OrderedLogit, Protocol},
    light::names::expected_one_of,
    store::observer,
};

/// Most logits that a level can add: far beyond the whole scale.
const MOST_LOGITS: f64 = 1000.0;

/// An observer with the effects that were asked for, and those that it has no parameter for.
pub(super) fn apply(
    observer: OrderedLogit,
    effects: &[String],
    protocol: &Protocol,
) -> Result<(OrderedLogit, Vec<Shift>), UsageError> {
    let mut observer = observer;
    let mut shifts: Vec<Shift> = Vec::new();
    let mut names: Vec<&str> = Vec::new();
    for effect in effects {
        let fault = |message: &str| UsageError(format!("--effect {effect}: {message}"));
        let (name, value) = effect
            .rsplit_once('=')
            .ok_or_else(|| fault("no = in it; expected NAME=VALUE or FACTOR:LEVEL=LOGITS, such as oblique=0.5"))?;
        let (name, number) = (name.trim(), value.trim().parse::<f64>().ok().filter(|value| value.is_finite()));
        let value = number.ok_or_else(|| fault("the value is not a finite number; expected one such as 0.5"))?;
        if names.contains(&name) {
            return Err(fault(&format!("{name} is given twice; expected each effect once")));
        }
        names.push(name);
        match name.split_once(':') {
            Some(_) if value.abs() > MOST_LOGITS => {
                return Err(fault(&format!("expected {}…{MOST_LOGITS} logits", -MOST_LOGITS)));
            }
            Some((factor, level)) => {
                shifts.push(Shift { factor: factor.trim().to_owned(), level: level.trim().to_owned(), logits: value })
            }
            None => observer = with(&observer, name, value, protocol).map_err(|message| fault(&message))?,
        }
    }
    Ok((observer, shifts))
}

/// The observer with another value of one parameter, checked as its file would be.
fn with(observer: &OrderedLogit, name: &str, value: f64, protocol: &Protocol) -> Result<OrderedLogit, String> {
    let mut table = toml::Table::try_from(observer).map_err(|error| error.to_string())?;
    match table.get_mut(name) {
        Some(parameter) if parameter.is_float() => *parameter = value.into(),
        _ => return Err(unknown(name, &table, protocol)),
    }
    table.insert("schema".to_owned(), 1.into());
    observer::parse("--effect", &table.to_string())
        .map_err(|faults| faults.0.into_iter().map(|fault| fault.message).collect::<Vec<_>>().join("; "))
}

fn unknown(name: &str, table: &toml::Table, protocol: &Protocol) -> String {
    if let Some(factor) = protocol.factors.iter().find(|factor| factor.name == name) {
        let levels: Vec<String> = factor.levels.iter().map(ToString::to_string).collect();
        return format!(
            "{name} is a factor; expected {name}:LEVEL=LOGITS with one of the levels {}",
            levels.join(", ")
        );
    }
    let known: Vec<&str> = table.iter().filter(|(_, value)| value.is_float()).map(|(name, _)| name.as_str()).collect();
    let factors: Vec<&str> = protocol.factors.iter().map(|factor| factor.name.as_str()).collect();
    format!(
        "no such parameter of the observer; {}; or FACTOR:LEVEL with one of the factors {}",
        expected_one_of(name, &known),
        factors.join(", ")
    )
}
