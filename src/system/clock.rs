//! The clock of the system, which may be set to any time.

use std::time::{Duration, SystemTime, UNIX_EPOCH};

use jiff::{Timestamp, civil::Date, tz::TimeZone};

/// The beginning of the year 0: RFC 3339 has years of four digits.
const FIRST: Timestamp = Timestamp::constant(-62_167_219_200, 0);
/// The beginning of the year 9999: a session that begins then still ends before the year 10000.
const LAST: Timestamp = Timestamp::constant(253_370_764_800, 0);

/// Returns the time of the clock; `None` if it is not in the years 0 to 9998.
fn read() -> Option<Timestamp> {
    Timestamp::try_from(SystemTime::now()).ok().filter(|now| (FIRST..=LAST).contains(now))
}

/// Returns the time of the clock. If the clock is before the year 0 or after the year 9998, returns the first or last
/// time in these years: a session that is already running must not end because of it.
pub fn now() -> Timestamp {
    read().unwrap_or(if SystemTime::now() < UNIX_EPOCH { FIRST } else { LAST })
}

/// Returns today's date in UTC.
pub fn today() -> Date {
    TimeZone::UTC.to_datetime(now()).date()
}

/// Checks the clock before a session begins, because its times would be wrong.
///
/// # Errors
/// The clock is before the year 0 or after the year 9998.
pub fn check_clock() -> Result<(), ClockError> {
    read().map(drop).ok_or(ClockError)
}

/// The clock shows a time that a session cannot record.
#[derive(Debug, thiserror::Error)]
#[error("clock: the system's time is before the year 0 or after the year 9998; expected the current date")]
pub struct ClockError;

/// Returns the time that is `earlier` than `time`, or the first possible time.
pub fn before(time: Timestamp, earlier: Duration) -> Timestamp {
    time.checked_sub(earlier).unwrap_or(Timestamp::MIN)
}

/// Returns the time that is `later` than `time`, or the last possible time.
pub fn after(time: Timestamp, later: Duration) -> Timestamp {
    time.checked_add(later).unwrap_or(Timestamp::MAX)
}
