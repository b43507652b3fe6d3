//! Visual nulling, run by simulated observers before known displays.

use machband::{
    display::matching::{
        Channel, CheckField, Doubt, Effort, Estimates, FitError, Judgement, Level, Method, Nulling, Observation,
        Pattern, Plan, PlanError, SimulatedDisplay, SimulatedObserver, check::CHECKED, estimate, picture,
    },
    light::{Bits, Quantizer, Transfer, Transfers},
};
use rand_chacha::{
    ChaCha8Rng,
    rand_core::{Rng as _, SeedableRng as _},
};

const RGB: [Channel; 3] = [Channel::Red, Channel::Green, Channel::Blue];
const TWO_PERCENT: SimulatedObserver = SimulatedObserver { threshold: 0.02, lapse: 0.0 };

fn standard(method: Method) -> Plan {
    Plan::new(&RGB, method, Pattern::Quarters, Effort::Standard)
}

fn power(gammas: [f64; 3], flare: f64) -> SimulatedDisplay {
    SimulatedDisplay { transfers: Transfers::new(gammas.map(|gamma| Transfer::gamma(gamma).unwrap())), flare }
}

fn observations(plan: &Plan, display: &SimulatedDisplay, observer: SimulatedObserver, seed: u64) -> Vec<Observation> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed ^ 0x5eed);
    let mut nulling = Nulling::new(plan.clone(), seed).unwrap();
    while let Some(stimulus) = nulling.stimulus() {
        if plan.method == Method::Staircase {
            nulling.answer(observer.judge(display, &stimulus, &mut rng)).unwrap();
        } else {
            nulling.adjust(observer.adjust(display, &stimulus, &mut rng));
            nulling.accept().unwrap();
        }
    }
    assert_eq!(nulling.progress().left_s, 0.0);
    nulling.observations().to_vec()
}

fn run(plan: &Plan, display: &SimulatedDisplay, observer: SimulatedObserver, seed: u64) -> Estimates {
    estimate(plan, &observations(plan, display, observer, seed))
}

/// Three exponents within 1.6…2.8.
fn gammas(seed: u64) -> [f64; 3] {
    let mut rng = ChaCha8Rng::seed_from_u64(seed ^ 0xd15);
    std::array::from_fn(|_| 1.6 + 1.2 * (rng.next_u64() >> 11) as f64 / (1u64 << 53) as f64)
}

/// What many runs came to, over all channels.
#[derive(Debug)]
struct Recovery {
    share_within: f64,
    worst: f64,
    rms: f64,
    bias: f64,
    /// Share of the 95 % intervals that hold the true γ.
    covered: f64,
    threshold: f64,
    /// Runs in which something was doubted.
    doubted: usize,
}

fn recovery(plan: &Plan, observer: SimulatedObserver, flare: f64, runs: u64) -> Recovery {
    let (mut errors, mut covered, mut log_threshold, mut doubted) = (Vec::new(), 0, 0.0, 0);
    for seed in 0..runs {
        let truth = gammas(seed);
        let estimates = run(plan, &power(truth, flare), observer, seed);
        doubted += usize::from(!estimates.doubts().is_empty());
        for (channel, gamma) in RGB.iter().zip(truth) {
            let fit = estimates.of(*channel).unwrap().fit.unwrap();
            errors.push(fit.gamma - gamma);
            covered += usize::from((fit.interval[0]..=fit.interval[1]).contains(&gamma));
            log_threshold += fit.threshold().ln();
        }
    }
    let number = errors.len() as f64;
    let found = Recovery {
        share_within: errors.iter().filter(|error| error.abs() <= 0.05).count() as f64 / number,
        worst: errors.iter().fold(0.0, |worst, error| error.abs().max(worst)),
        rms: (errors.iter().map(|error| error * error).sum::<f64>() / number).sqrt(),
        bias: errors.iter().sum::<f64>() / number,
        covered: covered as f64 / number,
        threshold: (log_threshold / number).exp(),
        doubted,
    };
    println!("{:?}, {observer:?}, flare {flare}: {found:.4?}", plan.method);
    found
}

/// An observer with a difference threshold of 2 %, three channels that differ, γ from 1.6 to 2.8: every channel of every
/// run within ± 0.05, in five minutes.
#[test]
fn gamma_is_recovered_within_five_minutes() {
    let plan = standard(Method::Staircase);
    assert!(plan.duration_s() <= 300.0, "{} s", plan.duration_s());
    let found = recovery(&plan, TWO_PERCENT, 0.0, 200);
    assert!(found.share_within == 1.0 && found.rms < 0.015 && found.bias.abs() < 0.003, "{found:?}");
    assert!((0.9..=0.98).contains(&found.covered), "{found:?}");
    assert!((0.016..=0.024).contains(&found.threshold), "{found:?}");
    assert!(found.doubted <= 4, "{found:?}");
}

#[test]
fn lapses_flare_and_the_slider_change_little() {
    let staircase = standard(Method::Staircase);
    let lapsing = recovery(&staircase, SimulatedObserver { lapse: 0.02, ..TWO_PERCENT }, 0.0, 100);
    assert!(lapsing.share_within >= 0.99 && lapsing.worst < 0.08 && lapsing.bias.abs() < 0.003, "{lapsing:?}");
    // A hundredth of white on everything: it drops out, and only the comparison in the dark becomes a little harder.
    let flare = recovery(&staircase, TWO_PERCENT, 0.01, 100);
    assert!(flare.share_within >= 0.99 && flare.bias.abs() < 0.003, "{flare:?}");
    let slider = standard(Method::Adjustment);
    assert!(slider.duration_s() <= 300.0);
    let slider = recovery(&slider, TWO_PERCENT, 0.0, 200);
    assert!(slider.share_within >= 0.99 && slider.bias.abs() < 0.005, "{slider:?}");
    assert!((0.9..=0.98).contains(&slider.covered), "{slider:?}");
}

/// A display with an offset is no power: the profile is still near its light, or the offset is found.
#[test]
fn an_offset_is_found_with_enough_trials() {
    let offset = Transfer::gog(2.2, 1.06, -0.06).unwrap();
    let display = SimulatedDisplay { transfers: Transfers::from(&offset), flare: 0.0 };
    let plan = Plan {
        levels: vec![
            Level::of_full(1, 4, 80),
            Level { hi: 0.25, ..Level::of_full(1, 4, 80) },
            Level::of_full(1, 2, 80),
            Level::of_full(3, 4, 40),
        ],
        ..Plan::new(&[Channel::Green], Method::Staircase, Pattern::Quarters, Effort::Thorough)
    };
    let found: Vec<_> =
        (0..20).filter_map(|seed| run(&plan, &display, TWO_PERCENT, seed).of(Channel::Green).unwrap().offset).collect();
    let mean = |of: &dyn Fn(usize) -> f64| (0..found.len()).map(of).sum::<f64>() / found.len() as f64;
    let (gamma, offset) = (mean(&|i| found[i].gamma), mean(&|i| found[i].offset));
    println!("offset found in {} of 20 long runs: gamma {gamma:.3}, offset {offset:+.4}", found.len());
    assert!(found.len() >= 10 && (-0.09..=-0.04).contains(&offset) && (gamma - 2.2).abs() < 0.1);

    // In five minutes it is not: the power takes its place. How wrong is the light then?
    let plan = standard(Method::Staircase);
    let (mut worst, mut bias) = (0.0f64, 0.0);
    for seed in 0..50 {
        let estimates = run(&plan, &display, TWO_PERCENT, seed);
        bias += estimates.of(Channel::Green).unwrap().fit.unwrap().gamma - 2.2;
        let profile = estimates.transfers().unwrap();
        for code in 0..=255 {
            let at = |transfers: &Transfers| transfers.linear_from_encoded([f64::from(code) / 255.0; 3])[1];
            worst = worst.max((at(&profile) - at(&display.transfers)).abs());
        }
    }
    println!(
        "offset −0.06 as a power, 50 runs: gamma {:+.3} above the exponent, light off by at most {worst:.4} of white",
        bias / 50.0
    );
    assert!(worst < 0.04, "{worst}");
}

#[test]
fn an_observer_who_does_not_look_is_doubted() {
    let plan = standard(Method::Staircase);
    let blind = SimulatedObserver { lapse: 1.0, ..TWO_PERCENT };
    let mut caught = 0;
    for seed in 0..50 {
        let estimates = run(&plan, &power([2.2; 3], 0.0), blind, seed);
        let doubted = RGB.iter().filter(|channel| !estimates.of(**channel).unwrap().doubts().is_empty()).count();
        caught += doubted;
    }
    println!("of 150 channels judged blindly {caught} were doubted");
    assert!(caught >= 143, "{caught} of 150 channels");

    let mut nulling = Nulling::new(plan.clone(), 1).unwrap();
    while nulling.answer(Judgement::Brighter).is_some() {}
    let estimates = estimate(&plan, nulling.observations());
    assert_eq!(estimates.transfers(), None);
    assert_eq!(estimates.of(Channel::Red).unwrap().fit, Err(FitError::OneSided));
    assert_eq!(estimates.doubts().len(), 3);
    assert_eq!(estimate(&plan, &[]).of(Channel::Blue).unwrap().fit, Err(FitError::TooFew(0)));
}

/// A display that is far from any power: the levels disagree, and each says by how much.
#[test]
fn a_display_that_is_no_power_is_told() {
    let kinked = Transfer::Table(
        machband::light::TransferTable::new(vec![0.0, 0.3, 0.5, 0.8, 1.0], vec![0.0, 0.02, 0.25, 0.5, 1.0]).unwrap(),
    );
    let display = SimulatedDisplay { transfers: kinked.into(), flare: 0.0 };
    let plan = Plan::new(&[Channel::Gray], Method::Staircase, Pattern::Quarters, Effort::Thorough);
    let estimates = run(&plan, &display, TWO_PERCENT, 3);
    let gray = estimates.of(Channel::Gray).unwrap();
    assert!(gray.doubts().iter().any(|doubt| matches!(doubt, Doubt::Disagrees(..))), "{:?}", gray.doubts());
    // Each level's own match is right all the same: the quarter at 0.5, the half at 0.8.
    for (level, code) in [(0, 127.5), (2, 204.0)] {
        let level = &gray.levels[level];
        assert!((level.code - code).abs() < 4.0 * level.code_error.max(0.5), "{level:?}");
    }
    assert!(estimates.transfers().unwrap().uniform().is_some());
    assert!(estimates.with().starts_with("visual nulling by staircase, 80 answers"), "{}", estimates.with());
}

#[test]
fn an_answer_taken_back_brings_the_same_picture() {
    for method in [Method::Staircase, Method::Adjustment] {
        let plan = Plan { row_px: 2, ..standard(method) };
        let mut nulling = Nulling::new(plan.clone(), 9).unwrap();
        let judgements = match method {
            Method::Staircase => [Judgement::Brighter, Judgement::Darker, Judgement::Same],
            Method::Adjustment => [Judgement::Matched; 3],
        };
        assert_eq!(nulling.undo(), None);
        let mut shown = Vec::new();
        for i in 0..nulling.progress().total {
            shown.push(nulling.stimulus().unwrap());
            nulling.answer(judgements[i % 3]).unwrap();
        }
        assert_eq!((nulling.stimulus(), nulling.answer(judgements[0])), (None, None));
        let answers = nulling.observations().to_vec();
        for (i, stimulus) in shown.iter().enumerate().rev() {
            assert_eq!(nulling.undo(), Some(answers[i]));
            assert_eq!(nulling.stimulus(), Some(*stimulus));
            assert_eq!(nulling.progress().done, i);
        }
        // And forward again, to the same pictures.
        for (i, stimulus) in shown.iter().enumerate() {
            assert_eq!(nulling.stimulus(), Some(*stimulus), "{method:?} {i}");
            nulling.answer(judgements[i % 3]).unwrap();
        }
        let order = |seed| -> Vec<_> {
            let mut nulling = Nulling::new(plan.clone(), seed).unwrap();
            while nulling.answer(judgements[0]).is_some() {}
            nulling.observations().iter().map(|o| (o.stimulus.channel, o.level, o.catch)).collect()
        };
        assert_eq!(order(4), order(4));
        assert_ne!(order(4), order(5));
        // The other method's answers mean nothing here.
        let mut other = Nulling::new(plan, 1).unwrap();
        let wrong = if method == Method::Staircase { Judgement::Matched } else { Judgement::Brighter };
        assert_eq!(other.answer(wrong), None);
    }
}

/// The picture has the light that the procedure counts on: the rows' mean is that of the level, columns do not differ,
/// and the patch begins and ends with a period.
#[test]
fn the_picture_is_rows_and_a_patch() {
    for row_px in [1, 2] {
        let plan = Plan { row_px, ..Plan::new(&Channel::ALL, Method::Staircase, Pattern::Quarters, Effort::Quick) };
        let mut nulling = Nulling::new(plan.clone(), 2).unwrap();
        let mut seen = 0;
        while let Some(stimulus) = nulling.stimulus() {
            let image = picture(&stimulus, 160, 120, 50);
            let period = stimulus.rows.period_px();
            let column = |x: u32| -> Vec<[u16; 3]> { (0..120).map(|y| image.pixel(x, y)).collect() };
            let (edge, middle) = (column(0), column(80));
            assert!((0..50).all(|x| column(x) == edge), "columns beside the patch are alike");
            let patch = stimulus.channel.rgb(stimulus.patch).map(u16::from);
            let inside: Vec<usize> = (0..120).filter(|y| middle[*y] == patch && edge[*y] != patch).collect();
            let rows = inside.iter().max().unwrap() / period as usize - inside.iter().min().unwrap() / period as usize;
            assert!(rows as u32 * period <= 50 && middle[0] == edge[0] && middle[119] == edge[119]);
            let whole: Vec<f64> = edge[..24 * row_px as usize]
                .iter()
                .map(|rgb| rgb.iter().map(|code| f64::from(*code)).fold(0.0, f64::max))
                .collect();
            let mean = whole.iter().sum::<f64>() / whole.len() as f64;
            assert!((mean - stimulus.rows.mean(f64::from)).abs() < 1e-9);
            seen += 1;
            nulling.answer(Judgement::Same).unwrap();
        }
        assert_eq!(seen, plan.trials());
    }
    let display = power([2.0; 3], 0.1);
    let rows = machband::display::matching::RowField { lit: 1, period: 4, row_px: 1, lo: 0, hi: 255 };
    assert!((rows.mean(|code| display.luminance(Channel::Red, code)) - 0.35).abs() < 1e-12);
}

#[test]
fn plans_that_cannot_be_run_say_why() {
    let plan = standard(Method::Staircase);
    let with = |change: &dyn Fn(&mut Plan)| {
        let mut changed = plan.clone();
        change(&mut changed);
        Nulling::new(changed, 1).map(|_| ())
    };
    assert_eq!(with(&|_| ()), Ok(()));
    assert_eq!(with(&|plan| plan.channels.clear()), Err(PlanError::Channels(Vec::new())));
    assert!(matches!(with(&|plan| plan.channels.push(Channel::Red)), Err(PlanError::Channels(_))));
    assert_eq!(with(&|plan| plan.row_px = 3), Err(PlanError::RowPx(3)));
    assert!(matches!(with(&|plan| plan.levels[0].lit = 4), Err(PlanError::Level { lit: 4, .. })));
    assert!(matches!(with(&|plan| plan.levels[0].hi = f64::NAN), Err(PlanError::Level { .. })));
    assert!(matches!(with(&|plan| plan.levels[0].trials = 1_000_000), Err(PlanError::Trials(_))));
    assert!(matches!(with(&|plan| plan.levels.clear()), Err(PlanError::Trials(_))));
    for method in [Method::Staircase, Method::Adjustment] {
        for pattern in [Pattern::Quarters, Pattern::Halves] {
            for effort in [Effort::Quick, Effort::Standard, Effort::Thorough] {
                let plan = Plan::new(&RGB, method, pattern, effort);
                assert_eq!(plan.validate(), Ok(()));
                assert!(plan.duration_s() <= if effort == Effort::Thorough { 600.0 } else { 300.0 });
            }
        }
    }
}

/// The check's patch has the rows' light where the profile is right, to half a code, and plainly not where γ is wrong by
/// 0.2.
#[test]
fn the_check_vanishes_only_where_the_profile_is_right() {
    let transfers =
        Transfers::new([Transfer::Srgb, Transfer::gamma(2.4).unwrap(), Transfer::gog(2.0, 0.9, 0.1).unwrap()]);
    let quantizer = Quantizer::new(&transfers, Bits::Eight);
    for channel in Channel::ALL {
        for (lit, period) in CHECKED {
            let field = |error| CheckField::new(&transfers, channel, [lit, period], 1, error);
            let expected = quantizer.codes([field(0.0).share() as f32; 3]).map(|code| code as u8);
            for (i, expected) in expected.into_iter().enumerate() {
                let carried = channel.index().is_none_or(|index| index == i);
                let patch = field(0.0).patch[i];
                assert_eq!(patch, if carried { expected } else { 0 });
                if carried && lit * 4 <= period * 2 {
                    assert!(field(0.2).patch[i] >= patch + 2 && field(-0.2).patch[i] <= patch - 2, "{channel} {lit}");
                }
            }
        }
    }
    let image = CheckField::new(&transfers, Channel::Gray, [1, 2], 2, 0.0).picture(64, 64, 32);
    assert_eq!((image.pixel(0, 1), image.pixel(0, 2)), ([255; 3], [0; 3]));
    assert_eq!(image.pixel(32, 32), quantizer.codes([0.5; 3]));
}
