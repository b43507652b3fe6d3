//! The page: title, contents, sections, figures in their places.

use maud::{DOCTYPE, Markup, PreEscaped, html};

use crate::report::study::{
    Repetition, agreement, cautions, description, design, health, methods, model, ranks, references, repeat,
    summary::{Summary, summary},
    times, vision,
};
use crate::{
    analysis::Results,
    report::{
        figures::Figure,
        prediction::{Predicted, Unpredicted},
    },
    store::ratings::Source,
};

const STYLE: &str = include_str!("style.css");
/// End of the names of figures that the model of vision predicts; the rest is that of the measured one.
const PREDICTED: &str = "_predicted";
/// Longest title that tabs and search results show.
const TITLE_CHARACTERS: usize = 60;

/// A section: address, heading, content.
struct Section {
    id: &'static str,
    heading: &'static str,
    content: Markup,
}

/// The whole page.
pub(crate) fn page(
    source: &Source,
    results: &Results,
    figures: &[Figure],
    predicted: &Result<Predicted, Unpredicted>,
    how: &Repetition,
) -> Markup {
    let (title, subtitle) = titles(source);
    let sections = sections(source, results, figures, predicted, how);
    html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta name="color-scheme" content="light";
                meta name="generator" content={ "machband " (how.version) };
                title { (shortened(&title)) }
                style { (PreEscaped(STYLE)) }
            }
            body {
                header {
                    h1 { (title) }
                    p { (subtitle) " · made " (how.made_at.strftime("%Y-%m-%d").to_string()) " with machband " (how.version) }
                }
                nav aria-label="Contents" {
                    ol { @for section in &sections { li { a href={ "#" (section.id) } { (section.heading) } } } }
                }
                main {
                    @for section in sections {
                        section id=(section.id) {
                            h2 { (section.heading) }
                            (section.content)
                        }
                    }
                }
            }
        }
    }
}

/// The page's title and the line below it.
fn titles(source: &Source) -> (String, String) {
    match &source.protocol {
        Some(protocol) if !protocol.title.trim().is_empty() => {
            (protocol.title.clone(), format!("Experiment {}", protocol.name))
        }
        Some(protocol) => (protocol.name.clone(), format!("Experiment {}", protocol.name)),
        None => ("Analysis of ratings".to_owned(), "No definition of an experiment".to_owned()),
    }
}

fn shortened(title: &str) -> String {
    if title.chars().count() <= TITLE_CHARACTERS {
        return title.to_owned();
    }
    let start: String = title.chars().take(TITLE_CHARACTERS).collect();
    format!("{}…", start.rsplit_once(' ').map_or(start.as_str(), |(words, _)| words))
}

fn sections(
    source: &Source,
    results: &Results,
    figures: &[Figure],
    predicted: &Result<Predicted, Unpredicted>,
    how: &Repetition,
) -> Vec<Section> {
    let section = |id, heading, content| Section { id, heading, content };
    let of = |place: Place| drawn(&figures.iter().filter(|figure| Place::of(figure) == place).collect::<Vec<_>>());
    let beside = drawn(&beside(figures));
    let methods = methods::methods(source, results, predicted.as_ref().ok(), &how.version);
    vec![
        section("summary", "Summary", summary_section(source, results)),
        section("design", "Design", design::section(source, results)),
        section("health", "Health of the data", health::section(source, results)),
        section("description", "Description", description::section(results, of(Place::Description))),
        section("model", "Model", model::section(results, of(Place::Model))),
        section("tests", "Rank tests", ranks::section(results)),
        section("agreement", "Agreement", agreement::section(results)),
        section("vision", "What the model of vision predicts", vision::section(source, results, predicted, beside)),
        section("times", "Response times", times::section(results, of(Place::Times))),
        section("methods", "Methods, ready to paste", html! { @for text in &methods.paragraphs { p { (text) } } }),
        section("references", "References", references::section(methods.cited)),
        section("repeat", "Repeat this analysis", repeat::section(source, results, how)),
    ]
}

fn summary_section(source: &Source, results: &Results) -> Markup {
    let Summary { lead, findings, cautions: all } = summary(source, results);
    let loud = cautions::simulated(source, results);
    html! {
        @if let Some(sentence) = &loud { p.loud { (sentence) } }
        p.lead { (lead.join(" ")) }
        @if !findings.is_empty() { ul { @for finding in &findings { li { (finding) } } } }
        @let others: Vec<&String> = all.iter().filter(|caution| Some(*caution) != loud.as_ref()).collect();
        @if !others.is_empty() {
            h3 { "To bear in mind" }
            ul { @for caution in others { li { (caution) } } }
        }
    }
}

/// Where a figure belongs.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Place {
    Description,
    Model,
    Times,
    Vision,
}

impl Place {
    fn of(figure: &Figure) -> Self {
        match figure.name {
            name if name.ends_with(PREDICTED) => Self::Vision,
            name if name.contains("time") => Self::Times,
            name if name.contains("model") || name.contains("effect") => Self::Model,
            _ => Self::Description,
        }
    }
}

/// Predicted figures, each after the measured one.
fn beside(figures: &[Figure]) -> Vec<&Figure> {
    let measured = |predicted: &Figure| {
        let name = predicted.name.strip_suffix(PREDICTED)?;
        figures.iter().find(|figure| figure.name == name)
    };
    let predicted = figures.iter().filter(|figure| Place::of(figure) == Place::Vision);
    predicted.flat_map(|figure| measured(figure).into_iter().chain([figure])).collect()
}

fn drawn(figures: &[&Figure]) -> Markup {
    html! {
        @if !figures.is_empty() {
            div.figures {
                @for figure in figures {
                    figure.wide[figure.wide] {
                        div.scroll { (PreEscaped(inline(&figure.svg))) }
                        figcaption { strong { (figure.title) "." } " " (figure.caption) }
                    }
                }
            }
        }
    }
}

/// A drawing as part of the page: from its root element on, without what makes it a file of its own.
fn inline(svg: &str) -> &str {
    svg.find("<svg").map_or("", |root| &svg[root..])
}
