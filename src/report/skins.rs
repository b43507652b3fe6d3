//! Skins that display the blocks of a document: an HTML page, which is a single file that opens anywhere without a
//! network, and text for a terminal. The window's skin is in `app/analysis`.

use std::cell::Cell;

use maud::{DOCTYPE, Markup, PreEscaped, html as markup};

use crate::report::{
    document::{Block, Document, Section, TextTable, whole},
    figures::Figure,
    study::Provenance,
};

const STYLE: &str = include_str!("style.css");
/// Maximum number of rows of a table on a page; the CSV files contain all of them.
const MAX_ROWS: usize = 2000;
/// A table with more rows is collapsed under its caption.
const MANY_ROWS: usize = 24;
/// Text to copy is collapsed if it has more lines than this.
const MANY_LINES: usize = 12;

/// Renders a document as an HTML page.
pub fn html(document: &Document, provenance: &Provenance) -> String {
    let Document { title, subtitle, sections } = document;
    let figures = Cell::new(0);
    let page = markup! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta name="color-scheme" content="light";
                meta name="generator" content={ "machband " (env!("CARGO_PKG_VERSION")) };
                title { (title) }
                style { (PreEscaped(STYLE)) }
            }
            body {
                header {
                    h1 { (title) }
                    p {
                        (subtitle) " · made " (provenance.made_at.strftime("%Y-%m-%d").to_string())
                        " with machband " (env!("CARGO_PKG_VERSION"))
                    }
                }
                nav aria-label="Contents" {
                    ol { @for section in sections { li { a href={ "#" (section.id) } { (section.heading) } } } }
                }
                main {
                    @for section in sections {
                        section id=(section.id) {
                            h2 { (section.heading) }
                            @for run in section.blocks.chunk_by(|a, b| is_figure(a) && is_figure(b)) {
                                @if is_figure(&run[0]) {
                                    div.figures { @for block in run { (block_markup(block, &figures)) } }
                                } @else {
                                    (block_markup(&run[0], &figures))
                                }
                            }
                        }
                    }
                }
            }
        }
    };
    page.into_string()
}

fn is_figure(block: &Block) -> bool {
    matches!(block, Block::Figure(_))
}

/// Renders a block; `figures` is the number of the last figure.
fn block_markup(block: &Block, figures: &Cell<u32>) -> Markup {
    markup! {
        @match block {
            Block::Heading(text) => h3 { (text) },
            Block::Text(text) => p { (text) },
            Block::Note(text) => p.note { (text) },
            Block::Warning(text) => p.warning { (text) },
            Block::List(items) => ul { @for item in items { li { (linked(item)) } } },
            Block::Code(text) => (folded(text.lines().count() > MANY_LINES, "Show", markup! { pre { code { (text) } } })),
            Block::Table(table) => (table_markup(table)),
            Block::Figure(figure) => (figure_markup(figure, figures)),
        }
    }
}

/// Renders text, with an address at its end as a link.
fn linked(text: &str) -> Markup {
    let (before, address) = text.find("https://").map_or((text, ""), |at| text.split_at(at));
    markup! {
        (before)
        @if !address.is_empty() { a href=(address) { (address) } }
    }
}

/// Collapses long content under a summary line.
fn folded(is_long: bool, line: &str, content: Markup) -> Markup {
    if is_long {
        markup! { details { summary { (line) } (content) } }
    } else {
        content
    }
}

/// Renders a table. Its first column names the rows, and it scrolls sideways on a narrow page.
fn table_markup(table: &TextTable) -> Markup {
    let TextTable { caption, header, texts, rows } = table;
    let class = |column: usize| (column >= *texts).then_some("number");
    let body = markup! {
        div.scroll {
            table {
                caption { (caption) }
                thead { tr { @for (column, name) in header.iter().enumerate() { th scope="col" class=[class(column)] { (name) } } } }
                tbody {
                    @for row in rows.iter().take(MAX_ROWS) {
                        tr {
                            @for (column, cell) in row.iter().enumerate() {
                                @if column == 0 { th scope="row" class=[class(column)] { (**cell) } }
                                @else { td class=[class(column)] { (**cell) } }
                            }
                        }
                    }
                }
            }
        }
        @if rows.len() > MAX_ROWS {
            p.note { "Only the first " (whole(MAX_ROWS as u64)) " of " (whole(rows.len() as u64)) " rows are shown." }
        }
    };
    folded(rows.len() > MANY_ROWS, &format!("{caption} – {} rows", rows.len()), body)
}

fn figure_markup(figure: &Figure, figures: &Cell<u32>) -> Markup {
    figures.set(figures.get() + 1);
    markup! {
        figure {
            div.scroll { (PreEscaped(&figure.svg)) }
            figcaption { strong { "Figure " (figures.get()) ". " (figure.title) "." } " " (figure.caption) }
        }
    }
}

/// Renders a section as HTML without a page around it, for notebooks.
pub fn fragment(section: &Section) -> String {
    let figures = Cell::new(0);
    markup! { @for block in &section.blocks { (block_markup(block, &figures)) } }.into_string()
}

/// Renders a section as text with one line per paragraph, which the terminal wraps. Tables and charts are omitted
/// because they are in files.
pub fn terminal(section: &Section) -> Vec<String> {
    let mut lines = Vec::new();
    for block in &section.blocks {
        match block {
            Block::Text(text) | Block::Note(text) | Block::Code(text) => lines.push(text.clone()),
            Block::Heading(text) => lines.push(format!("{text}:")),
            Block::Warning(text) => lines.push(format!("warning: {text}")),
            Block::List(items) => lines.extend(items.iter().map(|item| format!("- {item}"))),
            Block::Table(_) | Block::Figure(_) => {}
        }
    }
    lines
}
