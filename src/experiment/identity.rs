//! The identifiers of a participant and a session.

/// Maximum length of an identifier: a file name with two of them must fit every file system.
const MAX_LENGTH: usize = 40;

/// The participant and the session of a data file. Both identifiers match `[A-Za-z0-9]+` and have at most 40
/// characters, so they can be part of a file name on any system and of a Psych-DS or BIDS keyword.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Identity {
    subject: String,
    session: String,
}

impl Identity {
    /// Checks both identifiers. The error names the first one that is not valid.
    pub fn new(subject: &str, session: &str) -> Result<Self, String> {
        Ok(Self { subject: Self::check_subject(subject)?, session: Self::check_session(session)? })
    }

    /// Checks a participant identifier alone.
    pub fn check_subject(id: &str) -> Result<String, String> {
        check("participant", id, "S001")
    }

    /// Checks a session identifier alone.
    pub fn check_session(id: &str) -> Result<String, String> {
        check("session", id, "1")
    }

    /// Returns the participant's identifier.
    pub fn subject(&self) -> &str {
        &self.subject
    }

    /// Returns the session's identifier.
    pub fn session(&self) -> &str {
        &self.session
    }

    /// Returns the participant's row in a counterbalancing square: the number at the end of the identifier, counted
    /// from 0 (`S001` → 0, `P12` → 11). If there is no such number, it is a hash that is the same on every machine.
    pub fn counterbalance_row(&self) -> u64 {
        let digits = self.subject.len() - self.subject.trim_end_matches(|c: char| c.is_ascii_digit()).len();
        match self.subject[self.subject.len() - digits..].parse::<u64>() {
            Ok(number) => number.saturating_sub(1),
            Err(_) => fnv1a(self.subject.as_bytes()),
        }
    }
}

/// Returns the 64-bit FNV-1a hash. It is public and fixed, whereas the standard library's hash may change between
/// versions.
pub(super) fn fnv1a(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3))
}

fn check(what: &str, id: &str, example: &str) -> Result<String, String> {
    if (1..=MAX_LENGTH).contains(&id.len()) && id.chars().all(|c| c.is_ascii_alphanumeric()) {
        return Ok(id.to_owned());
    }
    let shown: String = id.chars().take(MAX_LENGTH + 8).collect();
    Err(format!(
        "{what} {shown:?} is not allowed; expected letters A–Z, a–z and digits only, at most 40, such as {example}"
    ))
}
