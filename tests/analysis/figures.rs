//! Charts show what the tables say, for any names and even for unusual studies.

use std::{
    collections::BTreeSet,
    sync::{Arc, LazyLock},
};

use machband::{
    analysis::{Options, Resampling, Results, analyze, counts::MeasuredBuilder, terms::Terms},
    experiment::RatingRow,
    report::figures::{self, Figure},
    stimulus::MachBand,
};
use resvg::usvg::{self, Group, Node, Tree, fontdb, roxmltree};

/// Reads a chart as a browser would, in the font of the PNG.
fn tree(figure: &Figure) -> Tree {
    static FONTS: LazyLock<Arc<fontdb::Database>> = LazyLock::new(|| {
        let mut fonts = fontdb::Database::new();
        fonts.load_font_data(notosans::REGULAR_TTF.to_vec());
        fonts.load_font_data(notosans::BOLD_TTF.to_vec());
        Arc::new(fonts)
    });
    let options = usvg::Options { fontdb: FONTS.clone(), ..usvg::Options::default() };
    Tree::from_str(&figure.svg, &options).unwrap_or_else(|error| panic!("{}: {error}\n{}", figure.name, figure.svg))
}

/// Collects the bounding boxes of everything that is drawn, and the texts.
fn boxes(group: &Group, found: &mut Vec<(usvg::Rect, String)>) {
    for node in group.children() {
        match node {
            Node::Group(group) => boxes(group, found),
            Node::Text(text) => {
                let content: String = text.chunks().iter().map(|chunk| chunk.text()).collect();
                found.push((text.abs_bounding_box(), content));
            }
            Node::Path(path) => found.push((path.abs_stroke_bounding_box(), String::new())),
            Node::Image(_) => panic!("an image within a chart"),
        }
    }
}

/// Parses every chart and checks that all of it is on the sheet. Returns all texts.
fn check(figures: &[Figure]) -> BTreeSet<String> {
    let mut texts = BTreeSet::new();
    for figure in figures {
        let tree = tree(figure);
        let mut found = Vec::new();
        boxes(tree.root(), &mut found);
        for (place, text) in found {
            let inside = place.left() >= -0.5
                && place.top() >= -0.5
                && place.right() <= tree.size().width() + 0.5
                && place.bottom() <= tree.size().height() + 0.5;
            assert!(inside, "{}: {place:?} {text:?} is not on {:?}", figure.name, tree.size());
            texts.insert(text.trim().to_owned());
        }
        assert!(figure.caption.ends_with('.') && !figure.title.ends_with('.'), "{figure:?}");
    }
    texts
}

/// Analyzes the ratings of a design. `rating` computes a rating from the participant, the levels and the repetition.
fn results(
    factors: &[(&str, &[&str])],
    subjects: usize,
    repetitions: u32,
    options: &Options,
    rating: impl Fn(usize, &[usize], u32) -> Option<String>,
) -> Results {
    let names: Vec<&str> = factors.iter().map(|(name, _)| *name).collect();
    let mut builder = MeasuredBuilder::new(&names);
    builder.directions = vec!["orientation_deg".to_owned()];
    let cells: usize = factors.iter().map(|(_, levels)| levels.len()).product();
    for subject in 0..subjects {
        for cell in 0..cells {
            let mut rest = cell;
            let mut levels = Vec::new();
            for (_, names) in factors {
                levels.push(rest % names.len());
                rest /= names.len();
            }
            let values: Vec<&str> = factors.iter().zip(&levels).map(|((_, names), &level)| names[level]).collect();
            for repetition in 0..repetitions {
                let Some(rating) = rating(subject, &levels, repetition) else { continue };
                let seconds = 0.5 + 0.37 * ((subject * 7 + cell * 3 + repetition as usize) % 11) as f64;
                let observation = RatingRow {
                    subject: &format!("S{subject:03}"),
                    values: &values,
                    rating: &rating,
                    count: 1,
                    session: "1",
                    repetition: Some(repetition),
                    response_time_s: Some(seconds),
                    ..RatingRow::default()
                };
                builder.add(&observation).unwrap();
            }
        }
    }
    analyze(builder.finish(), options)
}

/// Returns a number that looks random but is the same in every run.
fn noise(seed: usize) -> usize {
    let mut x = (seed as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    x ^= x >> 29;
    (x.wrapping_mul(0xbf58_476d_1ce4_e5b9) >> 40) as usize
}

fn quick() -> Options {
    Options {
        resampling: Resampling { draws: 19, seed: 1 },
        parameters: Some(MachBand::PARAMETERS),
        ..Options::default()
    }
}

fn no_model() -> Options {
    Options { terms: Some(Terms::default()), ..quick() }
}

const WIDTHS: &[&str] = &["0.02", "0.1", "0.4"];
const DEPTHS: &[&str] = &["1", "2", "inf"];

/// A small version of our own design.
fn bands(subjects: usize) -> Results {
    let factors: &[(&str, &[&str])] =
        &[("orientation_deg", &["0", "45", "90", "135"]), ("width", WIDTHS), ("depth", DEPTHS)];
    results(factors, subjects, 2, &quick(), |subject, levels, repetition| {
        let jitter = noise(subject * 1000 + levels[0] * 100 + levels[1] * 10 + levels[2] + 7 * repetition as usize) % 2;
        Some((3 - (levels[1] + levels[2] + jitter + subject % 2).min(3)).to_string())
    })
}

fn named<'a>(figures: &'a [Figure], name: &str) -> &'a Figure {
    figures.iter().find(|figure| figure.name == name).unwrap()
}

/// Returns two attributes of the elements of a kind, in drawing order.
fn elements(figure: &Figure, kind: &str, fill: &str, names: [&str; 2]) -> Vec<(f64, f64)> {
    let document = roxmltree::Document::parse(&figure.svg).unwrap();
    (document.descendants())
        .filter(|node| node.has_tag_name(kind) && node.attribute("fill").is_some_and(|color| color.contains(fill)))
        .map(|node| names.map(|name| node.attribute(name).unwrap().parse().unwrap()).into())
        .collect()
}

/// Returns the centers of the circles of a color.
fn circles(figure: &Figure, color: &str) -> Vec<(f64, f64)> {
    elements(figure, "circle", color, ["cx", "cy"])
}

/// Returns the points of all lines of a width.
fn lines(figure: &Figure, width: &str) -> Vec<Vec<(f64, f64)>> {
    let document = roxmltree::Document::parse(&figure.svg).unwrap();
    let point = |text: &str| text.split_once(',').map(|(x, y)| (x.parse().unwrap(), y.parse().unwrap())).unwrap();
    (document.descendants())
        .filter(|node| node.has_tag_name("polyline") && node.attribute("stroke-width") == Some(width))
        .map(|node| node.attribute("points").unwrap().split_whitespace().map(point).collect())
        .collect()
}

const BAR: &str = "2.2";
const GRID: &str = "1.4";
const BLUE: &str = "#0072b2";

/// Checks which charts a study has. With one person, intervals are about that person’s trials.
#[test]
fn a_study_has_every_chart_that_its_data_allow() {
    for (people, expected) in [
        (6, &["figure4a", "figure4b", "proportions", "subjects", "orientation", "effects"][..]),
        (1, &["figure4a", "figure4b", "proportions", "orientation", "effects"]),
    ] {
        let all = figures::all(&bands(people));
        assert_eq!(all.iter().map(|figure| figure.name).collect::<Vec<_>>(), expected);
        let texts = check(&all);
        let title = "Ramp width (proportion of the window)";
        for text in [title, "Continuity depth n", "∞", "Mean rating", "0.02"] {
            assert!(texts.contains(text), "{text} is not in {texts:?}");
        }
        for figure in ["figure4a", "figure4b", "orientation"].map(|name| named(&all, name)) {
            assert!(!lines(figure, BAR).is_empty(), "{}", figure.name);
            let sample = if people == 1 { "; 1 participant, 72 ratings." } else { "; 6 participants, 432 ratings." };
            assert!(figure.caption.ends_with(sample), "{}", figure.caption);
            assert_eq!(figure.caption.contains("over the trials of the only participant"), people == 1);
        }
        // One point for each of the four orientations.
        assert_eq!(circles(named(&all, "orientation"), BLUE).len(), 4);
    }
}

/// The points and intervals of a single factor are at the heights of the means, and the bars are as long as the
/// proportions.
#[test]
fn charts_show_what_the_table_says() {
    let widths: &[&str] = &["0.02", "0.05", "0.1", "0.2", "0.4", "0.8"];
    let results = results(&[("width", widths)], 6, 4, &quick(), |subject, levels, repetition| {
        let chance = noise(subject * 64 + levels[0] * 8 + repetition as usize) % 4;
        Some([0, chance.min(1), chance.min(2), chance.min(3), chance, 3][levels[0]].to_string())
    });
    let (figures, table) = (figures::all(&results), &results.factors[0].levels);
    assert!(!figures.iter().any(|figure| figure.name == "figure4b"));
    let figure = named(&figures, "figure4a");
    let (points, bars) = (circles(figure, BLUE), lines(figure, BAR));
    // All ratings are 0 at the first width and 3 at the last, so there is no interval.
    assert_eq!((points.len(), bars.len(), table.len()), (6, 3 * 4, 6));
    // The lines at the categories 0…3 are the scale. Rounding leaves up to half a unit.
    let grid: Vec<f64> = lines(figure, GRID).iter().map(|line| line[0].1).collect();
    assert_eq!(grid.len(), 4);
    let is_at = |y: f64, rating: f64| (y - grid[0] - rating * (grid[3] - grid[0]) / 3.0).abs() <= 1.0;
    for ((point, bar), group) in points[1..5].iter().zip(bars.chunks(3)).zip(&table[1..5]) {
        // An interval is a bar and two caps.
        let (interval, ends) = (group.summary.interval.unwrap(), &bar[0]);
        assert!(is_at(point.1, group.summary.mean), "{point:?} {group:?}");
        assert!(is_at(ends[0].1, interval.low) && is_at(ends[1].1, interval.high), "{ends:?} {group:?}");
        assert_eq!([ends[0].0, ends[1].0], [point.0, point.0]);
    }
    // The bars come after the sheet.
    let bars = elements(named(&figures, "proportions"), "rect", "#", ["x", "height"]).split_off(1);
    let shares = table.iter().flat_map(|group| &group.summary.proportions).filter(|share| **share > 0.0);
    let shares: Vec<f64> = shares.copied().collect();
    let whole: f64 = bars.iter().filter(|(x, _)| *x == bars[0].0).map(|(_, height)| height).sum();
    assert_eq!(bars.len(), shares.len());
    for ((_, height), share) in bars.iter().zip(shares) {
        assert!((height / whole - share).abs() < 1e-3, "{height} of {whole} for {share}");
    }
}

/// Each of the two factors is on the horizontal axis once. The first line in each chart has black circles; means are
/// weighted by the number of ratings. If each condition is predicted exactly as it is rated, the predicted chart is the
/// measured chart without bars.
#[test]
fn lines_show_the_cells_of_two_factors_measured_and_predicted() {
    let factors: &[(&str, &[&str])] = &[("orientation_deg", &["0", "45"]), ("width", WIDTHS), ("depth", DEPTHS)];
    let results = results(factors, 3, 4, &no_model(), |subject, levels, repetition| {
        let rating = noise(subject * 1000 + levels[0] * 300 + levels[1] * 10 + levels[2] + 7 * repetition as usize) % 4;
        (levels[0] == 0 || repetition == 0).then(|| rating.to_string())
    });
    let expected: Vec<Option<f64>> = results.cells.iter().map(|cell| Some(cell.summary.mean)).collect();
    let (measured, predicted) = (figures::all(&results), figures::predicted(&results, &expected));
    check(&predicted);
    for (index, (name, own, other)) in [("figure4a", 1, 2), ("figure4b", 2, 1)].into_iter().enumerate() {
        let (measured, predicted) = (named(&measured, name), &predicted[index]);
        let grid: Vec<f64> = lines(measured, GRID).iter().map(|line| line[0].1).collect();
        let first = &results.measured.counts.factors[other].levels[0];
        let points = circles(measured, "#000000");
        // Three points, plus the sample in the legend.
        assert_eq!(points.len(), 4, "{name}");
        for (point, level) in points.iter().zip(&results.measured.counts.factors[own].levels) {
            let of = || results.cells.iter().filter(|g| g.names[own] == *level && g.names[other] == *first);
            let mean = of().map(|g| g.summary.mean).sum::<f64>() / of().count() as f64;
            let height = grid[0] + mean * (grid[3] - grid[0]) / 3.0;
            assert!((point.1 - height).abs() <= 1.0, "{name} {level}: {point:?} is not at {height}");
        }
        assert_eq!(predicted.name, format!("{name}_predicted"));
        assert_eq!((circles(predicted, "#000000"), lines(predicted, GRID)), (points, lines(measured, GRID)), "{name}");
        assert!(lines(predicted, BAR).is_empty() && predicted.caption.contains("vision model"));
    }
    let partly = [&[None], &expected[1..]].concat();
    assert_ne!(figures::predicted(&results, &partly), predicted);
}

#[test]
fn any_name_is_drawn_and_stays_on_the_sheet() {
    let long = "a very long name of a condition that goes on and on, variant ";
    let (first, second) = (format!("{long}1"), format!("{long}2"));
    let levels: &[&str] = &["A & B <tag>", "\"quoted\"", "it's", "]]>", "\u{1}\u{7}", "Ωμέγα 北京", &first, &second];
    let categories = ["1 <none> & nothing", "2 a little, hardly anything at all", "3 \"more\"", "4 most"];
    let results = results(
        &[("fac&tor <of> \"conditions\" that has a long name of its own", levels), ("site", &["x & y", "<z>"])],
        5,
        3,
        &quick(),
        |subject, levels, repetition| {
            let wide = noise(subject * 31 + levels[0] * 5 + levels[1] * 3 + repetition as usize);
            (levels != [2, 1]).then(|| categories[(wide % 3 + levels[0] % 2).min(3)].to_owned())
        },
    );
    let figures = figures::all(&results);
    assert_eq!(figures.len(), 5);
    // In the dark theme, no figure is a white sheet.
    for figure in &figures {
        let dark = figures::palette::on_dark(&figure.svg);
        assert!(
            figure.svg.contains("#ffffff") && dark.contains("#2a2a2a") && !dark.contains("#ffffff"),
            "{}",
            figure.name
        );
    }
    let texts = check(&figures);
    for text in ["x & y", "<z>", "A & B <tag>", "\"quoted\""] {
        assert!(texts.contains(text), "{text} is not in {texts:?}");
    }
    // Long names keep both ends, because they often differ at the end.
    for end in ["1", "2"] {
        assert!(texts.iter().any(|text| text.starts_with("a v") && text.contains('…') && text.ends_with(end)), "{end}");
    }
}

/// Designs at the limits of what is possible.
#[test]
fn odd_studies_are_drawn() {
    let rating = |subject: usize, levels: &[usize], repetition: u32| {
        Some((noise(subject * 7919 + levels.iter().sum::<usize>() * 31 + repetition as usize) % 4).to_string())
    };
    let same = |_: usize, _: &[usize], _: u32| Some("2".to_owned());
    let list = |n: usize, name: &dyn Fn(usize) -> String| (0..n).map(name).collect::<Vec<_>>();
    let many = list(30, &|level| (level * 5).to_string());
    let long = list(40, &|level| format!("condition number {level}"));
    let fine = list(60, &|level| (0.5 * level as f64).to_string());
    let [many, long, fine] = [&many, &long, &fine].map(|names| names.iter().map(String::as_str).collect::<Vec<_>>());
    let model = quick();
    let studies = [
        ("no factor", results(&[], 3, 4, &model, rating), 0),
        ("one cell", results(&[("width", &["0.1"])], 1, 1, &model, same), 2),
        ("all the same", results(&[("width", WIDTHS), ("depth", DEPTHS)], 3, 1, &model, same), 4),
        ("a single level", results(&[("width", WIDTHS), ("depth", &["1"])], 3, 2, &model, rating), 5),
        ("200 subjects", results(&[("a", &["x", "y"])], 200, 2, &no_model(), rating), 3),
        ("30 levels", results(&[("a", &many), ("b", &many)], 3, 1, &no_model(), rating), 4),
        ("40 words", results(&[("b", &long), ("a", &["1", "2"])], 3, 1, &no_model(), rating), 4),
        ("60 angles", results(&[("orientation_deg", &fine)], 3, 1, &no_model(), rating), 3),
        ("nothing", analyze(MeasuredBuilder::new(&["width"]).finish(), &model), 0),
    ];
    for (what, results, expected) in &studies {
        let figures = figures::all(results);
        let names: Vec<&str> = figures.iter().map(|figure| figure.name).collect();
        assert_eq!(names.len(), *expected, "{what}: {names:?}");
        check(&figures);
    }
}
