//! Charts: what they show is what the tables say, whatever the names and however odd the study.

use std::{
    collections::BTreeSet,
    sync::{Arc, LazyLock},
};

use machband::{
    analysis::{Options, Results, analyze, counts::MeasuredBuilder, terms::Terms},
    experiment::RatingRow,
    report::figures::{self, Figure},
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

/// Boxes of everything that is drawn, and the texts.
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

/// Parses every chart and looks whether all of it is on the sheet. Returns all texts.
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

/// Ratings of a design: `rating` of subject, levels and repetition.
fn results(
    factors: &[(&str, &[&str])],
    subjects: usize,
    repetitions: u32,
    options: &Options,
    rating: impl Fn(usize, &[usize], u32) -> Option<String>,
) -> Results {
    let names: Vec<&str> = factors.iter().map(|(name, _)| *name).collect();
    let mut builder = MeasuredBuilder::new(&names);
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
                    place: Some(("1", repetition)),
                    response_time_s: Some(seconds),
                };
                builder.add(&observation).unwrap();
            }
        }
    }
    analyze(builder.finish(), options)
}

/// A number that looks random, the same in every run.
fn noise(seed: usize) -> usize {
    let mut x = (seed as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    x ^= x >> 29;
    (x.wrapping_mul(0xbf58_476d_1ce4_e5b9) >> 40) as usize
}

fn no_model() -> Options {
    Options { terms: Some(Terms::default()), ..Options::default() }
}

const WIDTHS: &[&str] = &["0.02", "0.1", "0.4"];
const DEPTHS: &[&str] = &["1", "2", "inf"];

/// Our own design, small.
fn bands(subjects: usize) -> Results {
    let factors: &[(&str, &[&str])] =
        &[("orientation_deg", &["0", "45", "90", "135"]), ("width", WIDTHS), ("depth", DEPTHS)];
    results(factors, subjects, 2, &Options::default(), |subject, levels, repetition| {
        let jitter = noise(subject * 1000 + levels[0] * 100 + levels[1] * 10 + levels[2] + 7 * repetition as usize) % 2;
        Some((3 - (levels[1] + levels[2] + jitter + subject % 2).min(3)).to_string())
    })
}

fn named<'a>(figures: &'a [Figure], name: &str) -> &'a Figure {
    figures.iter().find(|figure| figure.name == name).unwrap()
}

/// Centres of the circles of a color, in the order they are drawn.
fn circles(figure: &Figure, color: &str) -> Vec<(f64, f64)> {
    let document = roxmltree::Document::parse(&figure.svg).unwrap();
    (document.descendants())
        .filter(|node| node.has_tag_name("circle") && node.attribute("fill") == Some(color))
        .map(|node| ["cx", "cy"].map(|name| node.attribute(name).unwrap().parse().unwrap()).into())
        .collect()
}

/// Lines of a width.
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

#[test]
fn a_study_of_bands_has_every_chart() {
    let all = figures::all(&bands(6));
    let names: Vec<&str> = all.iter().map(|figure| figure.name).collect();
    assert_eq!(names, ["figure4a", "figure4b", "proportions", "subjects", "orientation", "effects", "times"]);
    let texts = check(&all);
    for text in ["Ramp width (proportion of the window)", "Continuity depth n", "∞", "Mean visibility rating", "0.02"]
    {
        assert!(texts.contains(text), "{text} is not in {texts:?}");
    }
    assert!(named(&all, "figure4a").caption.ends_with("; 6 participants, 432 ratings."));
}

/// The points of a single factor: at the height of the means, at the place of the logarithm of the level.
#[test]
fn points_are_where_the_table_has_them() {
    let widths: &[&str] = &["0.02", "0.05", "0.1", "0.2", "0.4", "0.8"];
    let results = results(&[("width", widths)], 6, 4, &Options::default(), |subject, levels, repetition| {
        let rating = match levels[0] {
            0 => 0,
            5 => 3,
            level => (noise(subject * 64 + level * 8 + repetition as usize) % 4).min(level),
        };
        Some(rating.to_string())
    });
    let figures = figures::all(&results);
    let figure = named(&figures, "figure4a");
    let (points, table) = (circles(figure, BLUE), &results.factors[0].levels);
    assert_eq!((points.len(), table.len()), (6, 6));
    // Lines at the categories 0…3 are the scale; half a unit is what rounding leaves.
    let grid: Vec<f64> = lines(figure, GRID).iter().map(|line| line[0].1).collect();
    assert_eq!(grid.len(), 4);
    let height = |rating: f64| grid[0] + rating * (grid[3] - grid[0]) / 3.0;
    let across = |width: f64| points[0].0 + (points[5].0 - points[0].0) * (width / 0.02).ln() / 40_f64.ln();
    let bars = lines(figure, BAR);
    for (index, (point, group)) in points.iter().zip(table).enumerate() {
        assert!((point.1 - height(group.summary.mean)).abs() <= 1.0, "{point:?} {group:?}");
        assert!((point.0 - across(widths[index].parse().unwrap())).abs() <= 1.0, "{point:?} {group:?}");
        // A bar and its two caps.
        let interval = group.summary.interval.unwrap();
        let ends = [bars[3 * index][0], bars[3 * index][1]];
        assert!((ends[0].1 - height(interval.low)).abs() <= 1.0 && (ends[1].1 - height(interval.high)).abs() <= 1.0);
        assert_eq!([ends[0].0, ends[1].0], [point.0, point.0]);
    }
    assert!(!figures.iter().any(|figure| figure.name == "figure4b"));
}

/// Of the two factors each is across once; the first line of either is drawn in black circles.
#[test]
fn lines_are_the_cells_of_two_factors() {
    let results = bands(6);
    let figures = figures::all(&results);
    for (name, own, other) in [("figure4a", 1, 2), ("figure4b", 2, 1)] {
        let figure = named(&figures, name);
        let grid: Vec<f64> = lines(figure, GRID).iter().map(|line| line[0].1).collect();
        let first = &results.measured.counts.factors[other].levels[0];
        let points = circles(figure, "#000000");
        // Three points and the sample in the legend.
        assert_eq!(points.len(), 4, "{name}");
        for (point, level) in points.iter().zip(&results.measured.counts.factors[own].levels) {
            let of: Vec<_> =
                results.cells.iter().filter(|g| g.names[own] == *level && g.names[other] == *first).collect();
            let n: u64 = of.iter().map(|g| g.summary.n).sum();
            let mean = of.iter().map(|g| g.summary.n as f64 * g.summary.mean).sum::<f64>() / n as f64;
            let height = grid[0] + mean * (grid[3] - grid[0]) / 3.0;
            assert!((point.1 - height).abs() <= 1.0, "{name} {level}: {point:?} is not at {height}");
        }
    }
}

/// Where each condition is predicted as it is rated, the predicted chart has the measured one's points, without bars; the
/// number of ratings weighs both alike.
#[test]
fn a_perfect_prediction_is_drawn_where_the_ratings_are() {
    let factors: &[(&str, &[&str])] = &[("orientation_deg", &["0", "45"]), ("width", WIDTHS), ("depth", DEPTHS)];
    let uneven = results(factors, 3, 4, &no_model(), |subject, levels, repetition| {
        let rating = noise(subject * 1000 + levels[0] * 300 + levels[1] * 10 + levels[2] + 7 * repetition as usize) % 4;
        (levels[0] == 0 || repetition == 0).then(|| rating.to_string())
    });
    let one = results(&factors[1..2], 3, 4, &no_model(), |subject, levels, repetition| {
        Some((noise(subject * 64 + levels[0] * 8 + repetition as usize) % 4).to_string())
    });
    for (results, color, names) in [(&uneven, "#000000", &["figure4a", "figure4b"][..]), (&one, BLUE, &["figure4a"])] {
        let expected: Vec<Option<f64>> = results.cells.iter().map(|cell| Some(cell.summary.mean)).collect();
        let (measured, predicted) = (figures::all(results), figures::predicted(results, &expected));
        assert_eq!(predicted.len(), names.len());
        check(&predicted);
        for (name, predicted) in names.iter().zip(&predicted) {
            let measured = named(&measured, name);
            assert_eq!(predicted.name, format!("{name}_predicted"));
            assert_eq!(circles(predicted, color), circles(measured, color), "{name}");
            assert_eq!(lines(predicted, GRID), lines(measured, GRID), "{name}");
            assert!(lines(predicted, BAR).is_empty() && predicted.caption.contains("model of vision"));
        }
        let mut partly = expected.clone();
        partly[0] = None;
        assert_ne!(figures::predicted(results, &partly), predicted);
    }
}

/// Lengths of the bars of a chart of proportions are the proportions.
#[test]
fn bars_are_as_long_as_the_proportions() {
    let results = results(&[("dose", &["1", "2", "3"])], 4, 5, &Options::default(), |subject, levels, repetition| {
        Some((noise(subject * 100 + levels[0] * 10 + repetition as usize) % 4).to_string())
    });
    let figures = figures::all(&results);
    let document = roxmltree::Document::parse(&named(&figures, "proportions").svg).unwrap();
    let number = |node: &roxmltree::Node<'_, '_>, name: &str| node.attribute(name).unwrap().parse::<f64>().unwrap();
    // After the sheet and the four samples of the legend.
    let bars: Vec<(f64, f64)> = (document.descendants().filter(|node| node.has_tag_name("rect")).skip(5))
        .map(|node| (number(&node, "y"), number(&node, "width")))
        .collect();
    let expected: Vec<f64> = (results.factors[0].levels.iter())
        .flat_map(|group| group.summary.proportions.iter().copied().filter(|share| *share > 0.0))
        .collect();
    let whole: f64 = bars.iter().filter(|(y, _)| *y == bars[0].0).map(|(_, width)| width).sum();
    assert_eq!(bars.len(), expected.len());
    for ((_, width), share) in bars.iter().zip(expected) {
        assert!((width / whole - share).abs() < 1e-3, "{width} of {whole} for {share}");
    }
}

#[test]
fn one_person_has_no_intervals_and_no_effects() {
    let all = figures::all(&bands(1));
    let names: Vec<&str> = all.iter().map(|figure| figure.name).collect();
    assert_eq!(names, ["figure4a", "figure4b", "proportions", "subjects", "orientation", "times"]);
    check(&all);
    for name in ["figure4a", "figure4b", "orientation"] {
        let figure = named(&all, name);
        assert_eq!(lines(figure, BAR).len(), 0, "{name}");
        assert!(figure.caption.contains("one participant"), "{}", figure.caption);
    }
    assert!(!lines(named(&figures::all(&bands(2)), "figure4a"), BAR).is_empty());
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
        &Options::default(),
        |subject, levels, repetition| {
            let wide = noise(subject * 31 + levels[0] * 5 + levels[1] * 3 + repetition as usize);
            (levels != [2, 1]).then(|| categories[(wide % 3 + levels[0] % 2).min(3)].to_owned())
        },
    );
    let figures = figures::all(&results);
    assert_eq!(figures.len(), 6);
    let texts = check(&figures);
    for text in ["x & y", "<z>", "A & B <tag>", "\"quoted\"", "no ratings"] {
        assert!(texts.contains(text), "{text} is not in {texts:?}");
    }
}

/// Designs at the edge of what there can be.
#[test]
fn odd_studies_are_drawn() {
    let rating = |subject: usize, levels: &[usize], repetition: u32| {
        Some((noise(subject * 7919 + levels.iter().sum::<usize>() * 31 + repetition as usize) % 4).to_string())
    };
    let same = |_: usize, _: &[usize], _: u32| Some("2".to_owned());
    let many: Vec<String> = (0..30).map(|level| format!("{}", level * 5)).collect();
    let many: Vec<&str> = many.iter().map(String::as_str).collect();
    let words: Vec<String> = (0..40).map(|level| format!("condition number {level}")).collect();
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    let fine: Vec<String> = (0..60).map(|level| format!("{}", 0.5 * f64::from(level))).collect();
    let fine: Vec<&str> = fine.iter().map(String::as_str).collect();
    let model = Options::default();
    let studies = [
        ("no factor", results(&[], 3, 4, &model, rating), 2),
        ("one cell", results(&[("width", &["0.1"])], 1, 1, &model, same), 4),
        ("all the same", results(&[("width", WIDTHS), ("depth", DEPTHS)], 3, 1, &model, same), 5),
        ("a single level", results(&[("width", WIDTHS), ("depth", &["1"])], 3, 2, &model, rating), 6),
        ("200 subjects", results(&[("a", &["x", "y"])], 200, 2, &no_model(), rating), 4),
        ("30 levels", results(&[("a", &many), ("b", &many)], 3, 1, &no_model(), rating), 5),
        ("40 words", results(&[("b", &words), ("a", &["1", "2"])], 3, 1, &no_model(), rating), 5),
        ("60 angles", results(&[("orientation_deg", &fine)], 3, 1, &no_model(), rating), 5),
        ("nothing", analyze(MeasuredBuilder::new(&["width"]).finish(), &model), 0),
    ];
    for (what, results, expected) in &studies {
        let figures = figures::all(results);
        let names: Vec<&str> = figures.iter().map(|figure| figure.name).collect();
        assert_eq!(names.len(), *expected, "{what}: {names:?}");
        check(&figures);
    }
    // More lines than can be told apart are thinned, and the caption says so.
    assert!(named(&figures::all(&studies[5].1), "figure4a").caption.contains("(12 of 30 are drawn)"));
}

/// Everyone rates the last level 3 and the first 0: no finite estimate.
#[test]
fn endless_effects_are_arrows() {
    let levels: &[&str] = &["a", "b", "c", "d"];
    let results = results(&[("kind", levels)], 6, 4, &Options::default(), |subject, levels, repetition| {
        let free = noise(subject * 17 + levels[0] * 5 + repetition as usize) % 3;
        Some(if levels[0] == 3 { 3 } else { free }.to_string())
    });
    let figures = figures::all(&results);
    check(&figures);
    let effects = named(&figures, "effects");
    assert!(effects.caption.contains("no finite estimate"), "{}", effects.caption);
    // Two estimates at circles, one arrow.
    assert_eq!(circles(effects, BLUE).len(), 2);
    assert_eq!(effects.svg.matches("<polygon").count(), 1);
}

/// Coefficients of factors, numbers and interactions by the names of their levels, whatever these are.
#[test]
fn effects_are_named_by_their_levels() {
    let terms = Terms::parse("kind,num:num,kind:num:num,site").unwrap();
    let options = Options { terms: Some(terms), ..Options::default() };
    let kinds: &[&str] = &["a", "a:b", "b"];
    let results = results(
        &[("kind", kinds), ("num", &["1", "2", "3"]), ("site", &["-1", "inf"])],
        5,
        3,
        &options,
        |subject, levels, repetition| {
            Some(
                (noise(subject * 97 + levels[0] * 31 + levels[1] * 7 + levels[2] + 5 * repetition as usize) % 4)
                    .to_string(),
            )
        },
    );
    let figures = figures::all(&results);
    let effects = named(&figures, "effects");
    let document = roxmltree::Document::parse(&effects.svg).unwrap();
    let texts: Vec<String> = (document.descendants().filter(|node| node.has_tag_name("text")))
        .map(|node| node.text().unwrap_or_default().trim().to_owned())
        .skip_while(|text| text != "Shift of the ratings (logit units)")
        .skip(1)
        .collect();
    let expected =
        ["kind (against a)", "a:b", "b", "num", "site (against −1)", "∞", "kind × num", "a:b × num", "b × num"];
    assert_eq!(texts, expected);
}

#[test]
fn images_are_sharp_complete_and_always_the_same() {
    let results = bands(6);
    let figures = figures::all(&results);
    assert_eq!(figures::all(&results), figures);
    for figure in &figures {
        let bytes = figure.png().unwrap();
        assert_eq!(figure.png().unwrap(), bytes);
        let mut decoder = png::Decoder::new(std::io::Cursor::new(&bytes));
        decoder.set_transformations(png::Transformations::EXPAND);
        let mut reader = decoder.read_info().unwrap();
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut pixels).unwrap();
        assert_eq!(info.width, 1600, "{}", figure.name);
        assert_eq!(info.color_type, png::ColorType::Rgb);
        assert_eq!(info.height, (2.0 * tree(figure).size().height()).ceil() as u32, "{}", figure.name);
        let dark = |index: usize| pixels[3 * index..3 * index + 3].iter().any(|channel| *channel < 160);
        let (width, height) = (info.width as usize, info.height as usize);
        let count = (0..width * height).filter(|&index| dark(index)).count() as f64 / (width * height) as f64;
        assert!((0.005..0.5).contains(&count), "{}: {count} of the pixels are dark", figure.name);
        // Text at the left, as in the SVG: it needs a font.
        let label = (0..height).flat_map(|y| (0..130).map(move |x| y * width + x)).filter(|&index| dark(index)).count();
        assert!(label > 500, "{}: no text at the left, {label}", figure.name);
        let edge = (0..width * height).filter(|index| {
            let (x, y) = (index % width, index / width);
            x < 6 || y < 6 || x + 6 >= width || y + 6 >= height
        });
        let cut: Vec<_> = edge.filter(|&index| pixels[3 * index] < 255).map(|i| (i % width, i / width)).collect();
        assert!(cut.is_empty(), "{}: cut at the edge, {:?}", figure.name, cut[0]);
    }
}
