//! Cells that a spreadsheet would run.

use std::borrow::Cow;

/// The text of a cell as a spreadsheet may open it: one that would be taken for a formula (it begins with `=`, `+`, `-`,
/// `@`, a tab or a carriage return, and is no number) has an apostrophe before it, which makes it text.
#[must_use]
pub fn inert(cell: &str) -> Cow<'_, str> {
    if is_formula(cell) { Cow::Owned(format!("'{cell}")) } else { Cow::Borrowed(cell) }
}

/// Whether a spreadsheet would compute a cell instead of showing it.
#[must_use]
pub fn is_formula(cell: &str) -> bool {
    cell.starts_with(['=', '+', '-', '@', '\t', '\r']) && cell.parse::<f64>().is_err()
}

#[cfg(test)]
mod tests {
    use super::inert;

    #[test]
    fn formulas_are_text_and_numbers_stay_numbers() {
        for formula in ["=1+1", "+cmd|' /C calc'!A0", "-2+3", "@SUM(A1)", "\t=1", "\r=1", "-", "=", "-1,5"] {
            assert_eq!(inert(formula), format!("'{formula}"));
        }
        for plain in ["", "-1.5", "+2", "-1e-3", "-inf", "a=b", "1-2", "'=1", "S001", "ä"] {
            assert_eq!(inert(plain), plain);
        }
    }
}
