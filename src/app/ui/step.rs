//! Where a page leads.

use std::convert::Infallible;

/// Where a page leads after a frame. A page that leads nowhere but back is a `Step` without a type.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Step<T = Infallible> {
    /// The page stays.
    Stay,
    /// Back to the page before.
    Back,
    /// On, with what the next page needs.
    Next(T),
}

impl<T> Step<T> {
    /// Back, or nowhere yet.
    pub fn back_if(back: bool) -> Self {
        if back { Self::Back } else { Self::Stay }
    }

    /// The same step, with something else for the next page.
    pub fn map<U>(self, next: impl FnOnce(T) -> U) -> Step<U> {
        match self {
            Self::Stay => Step::Stay,
            Self::Back => Step::Back,
            Self::Next(value) => Step::Next(next(value)),
        }
    }
}

impl Step {
    /// As the step of a page that could also lead on.
    pub fn widen<U>(self) -> Step<U> {
        self.map(|never| match never {})
    }
}
