//! Numbers in texts.

/// A number in a text, with the minus sign of print.
pub fn signed(number: &str) -> String {
    number.replace('-', "−")
}
