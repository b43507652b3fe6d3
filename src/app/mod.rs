//! Floor 6: the window.
/// How the window starts.
#[derive(Default)]
pub struct Launch {}
/// Opens.
pub fn open(_: Launch) -> Result<(), std::fmt::Error> { Ok(()) }
