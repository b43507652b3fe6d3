//! Tables that scroll sideways where the page is narrow.

use maud::{Markup, html};

/// How a column is set.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    /// Words, from the left.
    Text,
    /// Numbers, to the right.
    Number,
    /// Hashes, paths and other names of machines.
    Code,
}

/// A column: its head and its kind.
pub(crate) type Column<'a> = (&'a str, Kind);

/// Most rows that a page shows of one table; all of them are in the CSV files beside it.
const MOST_ROWS: usize = 2000;
/// Above so many rows, a table waits behind its caption until it is asked for.
const MANY_ROWS: usize = 24;

/// A table, whose first column names the rows. A long one is folded.
pub(crate) fn table<R>(caption: &str, columns: &[Column<'_>], rows: R) -> Markup
where
    R: IntoIterator<Item = Vec<String>>,
    R::IntoIter: ExactSizeIterator,
{
    let rows = rows.into_iter();
    let (all, folded) = (rows.len(), rows.len() > MANY_ROWS);
    let body = html! {
        div.scroll {
            table {
                caption { (caption) }
                thead { tr { @for (name, kind) in columns { th scope="col" class=[class(*kind)] { (name) } } } }
                tbody { @for row in rows.take(MOST_ROWS) { (line(columns, &row)) } }
            }
        }
        @if all > MOST_ROWS {
            p.note { "The first " (MOST_ROWS) " of " (crate::report::document::numbers::whole(all as u64)) " rows." }
        }
    };
    if folded {
        html! { details { summary { (caption) " – " (all) " rows" } (body) } }
    } else {
        body
    }
}

fn line(columns: &[Column<'_>], row: &[String]) -> Markup {
    html! {
        tr {
            @for (index, (cell, (_, kind))) in row.iter().zip(columns).enumerate() {
                @if index == 0 { th scope="row" class=[class(*kind)] { (cell) } }
                @else { td class=[class(*kind)] { (cell) } }
            }
        }
    }
}

fn class(kind: Kind) -> Option<&'static str> {
    match kind {
        Kind::Text => None,
        Kind::Number => Some("number"),
        Kind::Code => Some("code"),
    }
}
