//! Power planning, compared with R, with Whitehead's formula and with results that must hold exactly; and `machband
//! plan` as a user's script sees it.

use std::path::Path;

use machband::{
    analysis::{
        Options, Slopes,
        power::{Effect, Plan, Power, Sampling, Shift, Slope, Test},
        terms::Terms,
    },
    experiment::{OrderedLogit, Protocol},
    statistics::Interval,
    store::definition,
};

use crate::common::{command, fails, golden_path, records, refuses, split, table, text};

const DESIGN: &str = include_str!("../golden/power.toml");

fn design() -> Protocol {
    definition::parse("power.toml", DESIGN).unwrap()
}

fn oblique(oblique: f64) -> OrderedLogit {
    OrderedLogit { oblique, ..OrderedLogit::default() }
}

fn plan(protocol: &Protocol, observer: &OrderedLogit, shifts: &[Shift], terms: Option<&str>) -> Plan {
    let terms = terms.map(|terms| terms.parse::<Terms>().unwrap());
    Plan::new(protocol, observer, shifts, &[], &Options { terms, ..Options::default() }).unwrap()
}

/// Plans the design for people who differ in the effect of the orientation by this standard deviation.
fn plan_with_slopes(observer: &OrderedLogit, sd: f64, slopes: Slopes) -> Plan {
    let slope = Slope { factor: "orientation_deg".to_owned(), sd };
    let model = Options { slopes, ..Options::default() };
    Plan::new(&design(), observer, &[], &[slope], &model).unwrap()
}

/// Returns the powers of both tests of the orientation, each by number of participants.
fn powers(plan: &Plan, participants: &[u32], sampling: &Sampling) -> [Vec<Power>; 2] {
    let powers = plan.run(participants, sampling, &|_| ());
    [Test::LikelihoodRatio, Test::Friedman].map(|test| {
        let is_asked = |power: &&Power| {
            let hypothesis = &plan.hypotheses[power.hypothesis];
            hypothesis.term.name() == "orientation_deg" && hypothesis.test == test
        };
        powers.iter().filter(is_asked).cloned().collect()
    })
}

/// Compares with `tests/golden/power.csv`: a different program with different random numbers finds the same power and the
/// same estimates, with p from studies without the effect for six people and from the χ² distribution for more, also if
/// people differ in the effect.
#[test]
fn power_matches_r() {
    let number = |text: &str| text.parse::<f64>().unwrap();
    let (_, rows) = table(&golden_path("power.csv"));
    for group in rows.chunk_by(|one, other| one[1..3] == other[1..3]) {
        let slopes = if group[0][2] == "none" { Slopes::None } else { Slopes::Independent };
        let plan = plan_with_slopes(&oblique(0.6), number(&group[0][1]), slopes);
        let mut participants: Vec<u32> = group.iter().map(|row| row[0].parse().unwrap()).collect();
        participants.dedup();
        let studies = number(&group[0][4]).min(500.0);
        let sampling = Sampling { studies: studies as u32, ..Sampling::default() };
        let all = plan.run(&participants, &sampling, &|_| ());
        let of = |term: &str, row: &[String]| {
            let test = if row[3] == "friedman" { Test::Friedman } else { Test::LikelihoodRatio };
            let index = plan.hypotheses.iter().position(|asked| asked.term.to_string() == term && asked.test == test);
            let is_asked = |power: &&Power| Some(power.hypothesis) == index && power.participants.to_string() == row[0];
            all.iter().find(is_asked).unwrap()
        };
        for row in group {
            let ours = of("orientation_deg", row);
            let (share, theirs) = (ours.share(), number(&row[5]) / number(&row[4]));
            let both = (share + theirs) / 2.0;
            let binomial = both * (1.0 - both) * (1.0 / studies + 1.0 / number(&row[4]));
            // The standard error of the level in each of the two programs, if it comes from simulated studies. Where a
            // test with one degree of freedom has a power of one half, it rises by φ(0) / (2 φ(1.96)) = 3.4 times as
            // much as its level; elsewhere by less.
            let is_simulated = row[0] == "6" && row[3] == "likelihood-ratio";
            let alpha_error = if is_simulated { (0.05_f64 * 0.95 / 999.0).sqrt() } else { 0.0 };
            let error = (binomial + 2.0 * (3.4 * alpha_error).powi(2)).sqrt();
            assert!((share - theirs).abs() <= 3.0 * error, "{row:?}: {share}");
            assert!(ours.studies as f64 == studies && ours.untested == 0, "{ours:?}");
            if row[0] == "14" {
                // Four logits: the model without them exists in every study, although its random slope must take their
                // place.
                assert_eq!(of("depth", row).found as f64, studies, "{row:?}");
            }
        }
    }
}

/// With few people who differ in an effect that is 0 on average, a model with random slopes finds it as often as α says.
/// A model without them mistakes the differences for an effect.
#[test]
fn slopes_keep_the_false_alarm_rate() {
    let rate = |slopes| {
        let plan = plan_with_slopes(&OrderedLogit::default(), 0.5, slopes);
        let [ours, _] = powers(&plan, &[8], &Sampling { studies: 300, ..Sampling::default() });
        assert_eq!(ours[0].untested, 0);
        ours[0].share()
    };
    // Of the 300 studies, and of the 300 without the effect that they are compared with.
    let error = (0.05_f64 * 0.95 * 2.0 / 300.0).sqrt();
    let (with, without) = (rate(Slopes::Independent), rate(Slopes::None));
    assert!((with - 0.05).abs() < 3.0 * error, "{with}");
    assert!(without > 0.05 + 3.0 * error, "{without}");
}

/// Whitehead (1993), Statistics in Medicine 12, 2257: the power to distinguish two groups of n/2 ordered ratings with a
/// log odds ratio of θ is Φ(|θ| √(n(1 − Σp̄³)/12) − 1.96), where p̄ are the mean proportions of the categories.
#[test]
fn power_matches_whiteheads_formula() {
    let repetitions = 150;
    let text = format!(
        "schema = 1\nname = \"two\"\n[stimulus]\nkind = \"mach-band\"\nwidth = 0.1\ndepth = 2\n[factors]\n\
         orientation_deg = [0, 45]\n[design]\nrepetitions = {repetitions}\n"
    );
    let protocol = definition::parse("two.toml", &text).unwrap();
    let observer = OrderedLogit { subject_sd: 0.0, lapse: 0.0, ..oblique(0.5) };
    let sampling = Sampling { studies: 2000, ..Sampling::default() };
    let plan = plan(&protocol, &observer, &[], None);
    let found = powers(&plan, &[1], &sampling)[0][0].share();

    // The predictor is 6/2 − 0.7 log₂(0.1/0.05) = 2.3; the thresholds are 0, 1.5, 3.5.
    let below = |threshold: f64, predictor: f64| 1.0 / (1.0 + (predictor - threshold).exp());
    let bounds = |predictor: f64| [0.0, below(0.0, predictor), below(1.5, predictor), below(3.5, predictor), 1.0];
    let (one, other) = (bounds(2.3), bounds(2.8));
    let cubes: f64 = (1..5).map(|j| ((one[j] - one[j - 1] + other[j] - other[j - 1]) / 2.0).powi(3)).sum();
    let information = 2.0 * f64::from(repetitions) * (1.0 - cubes) / 12.0;
    let z = 0.5 * information.sqrt() - 1.959_964;
    // Φ by Simpson's rule.
    let density = |x: f64| (-0.5 * x * x).exp() / std::f64::consts::TAU.sqrt();
    let step = z / 200.0;
    let simpson: f64 = (0..100)
        .map(|i| 2.0 * f64::from(i) * step)
        .map(|x| (density(x) + 4.0 * density(x + step) + density(x + 2.0 * step)) * step / 3.0)
        .sum();
    let expected = 0.5 + simpson;
    assert!((0.5..0.9).contains(&expected), "{expected}: a power that tells");
    assert!((found - expected).abs() < 0.04, "{found}, expected {expected}");
}

/// The expected values come from `binom.test(found, all)$conf.int` in R 4.2.2.
#[test]
fn intervals_of_proportions_match_r() {
    for (found, all, low, high) in [
        (0, 200, 0.0, 0.0182753403551),
        (10, 200, 0.0242341654721, 0.0900275377014),
        (166, 200, 0.770628399606, 0.879304376764),
        (200, 200, 0.981724659645, 1.0),
        (1, 1, 0.025, 1.0),
        (50, 1000, 0.0373353976047, 0.0653904879155),
    ] {
        let interval = Interval::of_proportion(found, all);
        assert!(
            (interval.low - low).abs() < 1e-11 && (interval.high - high).abs() < 1e-11,
            "{found}/{all}: {interval:?}"
        );
    }
}

#[test]
fn without_an_effect_the_false_alarm_rate_is_alpha() {
    let plan = plan(&design(), &OrderedLogit::default(), &[], None);
    assert!(plan.hypotheses.iter().all(|h| h.effect.is_some() == (h.term.name() != "orientation_deg")));
    for alpha in [0.05, 0.3] {
        let sampling = Sampling { studies: 200, alpha, ..Sampling::default() };
        let found = powers(&plan, &[4], &sampling)[0][0].found as f64;
        let sd = (200.0 * alpha * (1.0 - alpha)).sqrt();
        assert!((found - 200.0 * alpha).abs() < 3.0 * sd, "alpha {alpha}: {found} of 200");
    }
}

/// Shifting one level has exactly the same effect, on every single rating, as the equivalent observer parameter.
#[test]
fn shifting_a_level_equals_an_observer_effect() {
    let sampling = Sampling { studies: 8, ..Sampling::default() };
    let shift = |level: &str| Shift { factor: "orientation_deg".to_owned(), level: level.to_owned(), logits: 0.75 };
    let with = |observer: &OrderedLogit, shifts: &[Shift]| {
        let plan = plan(&design(), observer, shifts, None);
        (plan.run(&[3], &sampling, &|_| ()), plan.hypotheses[0].effect.clone())
    };
    let (by_parameter, truth) = with(&oblique(0.75), &[]);
    assert_eq!(with(&oblique(0.0), &[shift("45")]), (by_parameter, truth.clone()));
    let truth = truth.unwrap();
    assert_eq!((truth.logits, truth.above.as_str(), truth.below.as_str()), (Some(0.75), "45", "0"));
    // A different spelling of the level, and the opposite direction.
    let (_, other) = with(&oblique(0.0), &[shift("0.0")]);
    assert_eq!(other.map(|effect| (effect.above, effect.below)), Some(("0".to_owned(), "45".to_owned())));
}

/// True effects computed by hand from the observer's doc comment.
#[test]
fn the_true_effect_is_what_the_term_adds_to_the_predictor() {
    let bangay = definition::open("bangay2003").unwrap();
    let truths = |protocol: &Protocol, terms: Option<&str>| -> Vec<_> {
        let plan = plan(protocol, &OrderedLogit::default(), &[], terms);
        let tests = plan.hypotheses.iter().filter(|hypothesis| hypothesis.test == Test::LikelihoodRatio);
        let levels = |effect: &Effect| (effect.logits, format!("{}>{}", effect.above, effect.below));
        tests.map(|hypothesis| (hypothesis.term.to_string(), hypothesis.effect.as_ref().map(levels))).collect()
    };
    let term = |name: &str, effect: Option<(f64, &str)>| {
        (name.to_owned(), effect.map(|(logits, levels)| (Some(logits), levels.to_owned())))
    };
    let expected =
        [term("width", Some((2.8, "0.05>0.8"))), term("depth", Some((4.8, "1>inf"))), term("orientation_deg", None)];
    assert_eq!(truths(&bangay, None), expected);
    // The straight line through 6/n, with 6/5 at n = ∞, where 1/n is 0.
    let (x, y) = ([1.0, 0.5, 1.0 / 3.0, 0.25, 0.0], [6.0, 3.0, 2.0, 1.5, 1.2]);
    let mean = |values: &[f64; 5]| values.iter().sum::<f64>() / 5.0;
    let (mx, my) = (mean(&x), mean(&y));
    let products: f64 = x.iter().zip(&y).map(|(x, y)| (x - mx) * (y - my)).sum();
    let slope = products / x.iter().map(|x| (x - mx).powi(2)).sum::<f64>();
    let line = truths(&bangay, Some("num:inv_n,width"));
    assert_eq!(line[0].1.as_ref().unwrap().1, "1>inf");
    assert!((line[0].1.as_ref().unwrap().0.unwrap() - slope).abs() < 1e-8, "{line:?}, expected {slope}");
    // Parameters are additive, so there is no interaction. A step has no band at any depth, so with steps there is an
    // interaction, but it has no size in logits.
    assert_eq!(truths(&bangay, Some("width*depth")), [term("width:depth", None)]);
    let steps = definition::parse("steps.toml", &DESIGN.replace("[0.1, 0.4]", "[0, 0.4]")).unwrap();
    let step = &truths(&steps, Some("width*depth"))[0];
    assert!(step.1.as_ref().is_some_and(|(logits, _)| logits.is_none()), "{step:?}");
}

/// Returns what `machband plan` prints when it runs with this many threads.
fn succeeds(folder: &Path, line: &str, threads: &str) -> String {
    let arguments = split(&format!("plan {line}"));
    let output = command(folder, &arguments).env("RAYON_NUM_THREADS", threads).output().unwrap();
    let errors = text(&output.stderr);
    assert!(output.status.success() && errors.is_empty(), "{line}: {errors}");
    text(&output.stdout)
}

#[test]
fn the_number_of_threads_does_not_change_a_plan() {
    let folder = tempfile::tempdir().unwrap();
    let csv = |name: &str| std::fs::read_to_string(folder.path().join(name)).unwrap();
    let plan = |participants: &str, options: &str, threads| {
        let study = "quick --studies 3 --effect oblique=1 --terms orientation_deg";
        let line = format!("{study} --participants {participants} --out {options}");
        succeeds(folder.path(), &line, threads)
    };
    let one = plan("3,2,3", "one.csv", "1");
    assert_eq!(one, plan("3,2,3", "three.csv", "3"));
    assert_eq!(csv("one.csv"), csv("three.csv"));
    assert_ne!(one, plan("2", "other.csv --seed 2", "1"));
    // The result for three participants does not depend on which other numbers are planned.
    plan("3", "alone.csv", "2");
    let rows = |name: &str| {
        csv(name).lines().filter(|line| line.starts_with("quick,3,")).map(str::to_owned).collect::<Vec<_>>()
    };
    assert_eq!((rows("alone.csv"), rows("alone.csv").len()), (rows("one.csv"), 2));
}

#[test]
fn effects_null_effects_and_missing_models_are_told_apart() {
    let folder = tempfile::tempdir().unwrap();
    let line = "shaders --participants 3 --studies 40 --effect shader:gouraud=3 --out p.csv";
    let said = succeeds(folder.path(), line, "2");
    let rows = records(&folder.path().join("p.csv"));
    let cell = |row: usize, name: &str| rows[row][name].clone();
    // The mixed model and Friedman's test for shader, then for mesh.
    let first = ["term", "test", "truth", "effect_logits", "above"].map(|name| cell(0, name));
    assert_eq!((rows.len(), first), (6, ["shader", "likelihood-ratio", "effect", "3", "gouraud"].map(str::to_owned)));
    assert_eq!(["term", "truth", "power"].map(|name| cell(2, name)), ["mesh", "none", ""]);
    let share = |row, name| 100.0 * cell(row, name).parse::<f64>().unwrap();
    assert!(said.contains("Effect of shader (3 logits between gouraud and "), "{said}");
    let (power, alarms) = (share(0, "power"), share(2, "false_alarms"));
    assert!(power > 80.0 && alarms < 30.0, "{power} {alarms}");
    // The observer has no effect of any factor, so there is no power to report.
    let said = succeeds(folder.path(), "shaders --participants 2 --studies 5 --terms shader", "2");
    assert!(said.contains("No factor has an effect on this observer") && !said.contains("power  "), "{said}");
}

/// A plan does not promise what an analysis would withhold: here, the design has too few ratings for people who differ in the
/// effect of the width.
#[test]
fn a_test_that_an_analysis_withholds_has_no_power() {
    let folder = tempfile::tempdir().unwrap();
    let design = "schema = 1\nname = \"few\"\n[stimulus]\nkind = \"mach-band\"\n[factors]\nwidth = [0.1, 0.4, 0.8]\n\
                  orientation_deg = [0, 45]\n[design]\nrepetitions = 1\n";
    std::fs::write(folder.path().join("few.toml"), design).unwrap();
    let line = "few.toml --participants 6 --studies 20 --effect width:0.1=3 --out p.csv";
    let said = succeeds(folder.path(), line, "2");
    let withheld =
        "With 6 participants, 20 of 20 studies could not test width with the mixed model: the design has too few";
    assert!(said.contains(withheld), "{said}");
    let rows = records(&folder.path().join("p.csv"));
    let cell = |row: usize, name: &str| rows[row][name].clone();
    assert_eq!(
        ["term", "test", "found", "untested"].map(|name| cell(0, name)),
        ["width", "likelihood-ratio", "0", "20"]
    );
    assert_eq!([cell(1, "test"), cell(1, "untested")], ["friedman", "0"]);
}

#[test]
fn wrong_usage_is_reported() {
    let folder = tempfile::tempdir().unwrap();
    let cases = r"
        2: --participants 2 --effect oblik=1 => did you mean oblique?
        2: --participants 2 --effect oblique => 'oblique' for '--effect <NAME=VALUE>': contains no =; expected NAME=VALUE
        2: --participants 2 --effect lapse=2 => lapse 2 is outside 0…1
        2: --participants 2 --effect width=2 => the observer has no such parameter
        2: --participants 2 --effect widht:0.1=2 => no such factor; expected one of width, depth
        2: --participants 2 --effect width:0.3=2 => --effect width:0.3: no such level; expected one of 0.02
        2: --participants 2 --effect fall=1 --effect fall=2 => --effect fall=2: fall is given twice
        2: --participants 2 --slope width=inf => 'width=inf' for '--slope <FACTOR=SD>': the value is not a finite number
        2: --participants 2 --slope width=-1 => '--slope <FACTOR=SD>': the value is out of range; expected 0…1000 logits
        2: --participants 2 --terms widht => did you mean width?
        2: --participants 2 --terms width,,depth => width,,depth: an empty name
        2: --participants 2 --terms depth,num:inv_n => --terms num:inv_n: the term adds nothing to the other terms
        2: --participants 0 => outside 1…10000
        2: --participants 2 --alpha 0 => expected a number between 0 and 1
        2: => --participants";
    refuses(folder.path(), "plan quick {}", cases);
    std::fs::write(folder.path().join("bad.toml"), "schema = 1\noblique = \"much\"\n").unwrap();
    let errors = fails(folder.path(), &split("plan quick --participants 2 --observer-file bad.toml"), 1);
    assert!(errors.starts_with("error: bad.toml:2:"), "{errors}");
}

/// The preregistration says what the plan found, and ends with the commands that plan and analyze.
#[test]
fn a_preregistration_says_what_was_planned() {
    let folder = tempfile::tempdir().unwrap();
    let line = "quick --participants 2,6 --effect width:0.1=1 --studies 100 --preregistration plan.md";
    succeeds(folder.path(), line, "2");
    let text = std::fs::read_to_string(folder.path().join("plan.md")).unwrap();
    for expected in [
        "- width: ratings at 0.1 are higher than at 0.8. The effect planned for is 3.10 logits.",
        "- orientation: no effect is predicted.",
        "24 conditions, each once, which makes 24 ratings",
        "participants will be tested: the smallest number tried (2 and 6) at which the 95 % interval of the power lies at or above 80 %",
        "p below 0.05 with a higher estimate at 0.1 than at 0.8 supports the hypothesis",
        "    machband plan quick --participants 2,6 --effect width:0.1=1 --studies 100\n",
        "    machband analyze results/quick --terms width,depth,orientation_deg --link logit --slopes independent --out analysis",
    ] {
        assert!(text.contains(expected), "{expected}: {text}");
    }
    // Three studies that all find the effect are no proof that most would.
    let said = succeeds(folder.path(), "quick --participants 6 --effect width:0.1=1 --studies 3 --terms width", "2");
    assert!(said.contains("6 participants may be enough"), "{said}");
    // Without an effect, no number of participants is enough.
    let line = "quick --participants 2 --studies 100 --terms orientation_deg --preregistration none.md";
    succeeds(folder.path(), line, "2");
    let text = std::fs::read_to_string(folder.path().join("none.md")).unwrap();
    assert!(text.contains("[N] participants will be tested. No effect is planned for"), "{text}");
    fails(folder.path(), &split(&format!("plan {line}")), 2);
}
