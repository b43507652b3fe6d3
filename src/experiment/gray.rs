//! The same experiment without color.

use super::protocol::Protocol;
use crate::stimulus::ParameterValue;

impl Protocol {
    /// The experiment in gray, for an observer who sees colors differently from most people: a yellow of equal light in
    /// red and green has another luminance for each kind of color deficiency, a gray has the same for all.
    ///
    /// It is an experiment of its own: its name ends in `-gray`, so that its data stand in a folder of their own and are
    /// not taken for the other's. `None` where it is gray already, or where color is what varies.
    #[must_use]
    pub fn in_gray(&self) -> Option<Self> {
        let gray = ParameterValue::from("gray");
        let color = self.stimulus.get("color")?;
        let varies = self.factors.iter().any(|factor| factor.name.starts_with("color"));
        if color == gray || varies {
            return None;
        }
        let mut copy = self.clone();
        copy.stimulus.set("color", &gray).ok()?;
        copy.name += "-gray";
        copy.title += " (gray)";
        // A second color would still be one.
        copy.stimulus.validate().ok().map(|()| copy)
    }
}
