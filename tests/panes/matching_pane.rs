//! Gamma by eye, its check and the steps of equal brightness, driven without a display.

use std::path::Path;

use eframe::egui::{self, Key};
use egui_kittest::{Harness, kittest::NodeT as _, kittest::Queryable as _};
use machband::{
    app::{App, Launch},
    display::{
        DisplayProfile, LuminanceRange,
        matching::{Channel, Judgement, NullingStimulus, RowField, SimulatedDisplay, SimulatedObserver},
        steps::{csv, steps},
    },
    light::{Transfer, Transfers},
    store::{matches, profile},
};
use rand_chacha::{ChaCha8Rng, rand_core::SeedableRng as _};

fn harness() -> Harness<'static, App> {
    let mut harness = Harness::builder()
        .with_size([1000.0, 800.0])
        .with_pixels_per_point(1.0)
        .with_step_dt(1.0 / 30.0)
        .build_eframe(|cc| App::new(cc, Launch::default()));
    harness.run_steps(3);
    harness.get_by_label("Measure…").click();
    harness.run_steps(3);
    harness
}

fn open(harness: &mut Harness<'static, App>, tool: &str) {
    harness.get_by_label(tool).click();
    harness.run_steps(3);
}

fn press(harness: &mut Harness<'static, App>, key: Key) {
    harness.key_press(key);
    harness.step();
}

fn click(harness: &mut Harness<'static, App>, label: &str) {
    let node = harness.get_by_label(label);
    node.scroll_to_me();
    harness.run_steps(3);
    harness.get_by_label(label).click();
    harness.run_steps(3);
}

fn type_into(harness: &mut Harness<'static, App>, label: &str, text: &str) {
    let field = |harness: &Harness<'static, App>| {
        harness.query_all_by_label(label).find(|node| node.value().is_some()).map(|node| node.focus())
    };
    field(harness).unwrap();
    harness.step();
    harness.key_press_modifiers(egui::Modifiers::COMMAND, Key::A);
    harness.step();
    harness.query_all_by_label(label).find(|node| node.value().is_some()).unwrap().type_text(text);
    harness.run_steps(2);
    // The keyboard belongs to the page again.
    press(harness, Key::Enter);
}

/// What the picture says of itself; `None` while there is none.
fn stimulus(harness: &Harness<'static, App>) -> Option<NullingStimulus> {
    let node = harness.query_by_label_contains("Rows in ")?;
    let label = node.accesskit_node().label()?;
    let channel = Channel::ALL.into_iter().find(|channel| label.contains(&format!("in {channel}:")))?;
    let numbers: Vec<u32> = label
        .split(|c: char| !c.is_ascii_digit())
        .filter(|part| !part.is_empty())
        .map(|n| n.parse().unwrap())
        .collect();
    let [lit, period, hi, lo, patch] = numbers[..] else { panic!("{label}") };
    let rows = RowField { lit, period, row_px: 1, lo: lo as u8, hi: hi as u8 };
    Some(NullingStimulus { channel, rows, patch: patch as u8 })
}

fn next_stimulus(harness: &mut Harness<'static, App>) -> Option<NullingStimulus> {
    for _ in 0..40 {
        if let Some(stimulus) = stimulus(harness) {
            return Some(stimulus);
        }
        if harness.query_by_label_contains("Gamma by eye: the result").is_some() {
            return None;
        }
        harness.step();
    }
    panic!("no picture came");
}

/// From the tools to the first picture.
fn begin(harness: &mut Harness<'static, App>, method: &str, profile: &Path) {
    open(harness, "Gamma by eye");
    harness.get_by_label_contains("120 trials, about 5 minutes");
    click(harness, method);
    click(harness, "few");
    type_into(harness, "Save the profile as", &profile.display().to_string());
    click(harness, "Next");
    harness.get_by_label_contains("Every answer is kept in");
    click(harness, "Begin");
}

const GAMMAS: [f64; 3] = [1.9, 2.2, 2.5];

#[test]
fn an_observer_at_the_keys_gets_the_gamma_of_the_screen() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("left.toml");
    let display = SimulatedDisplay { transfers: Transfers::new(GAMMAS.map(Transfer::Gamma)), flare: 0.0 };
    let observer = SimulatedObserver { threshold: 0.004, lapse: 0.0 };
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let mut harness = harness();
    begin(&mut harness, "brighter or darker", &path);
    // Too early: no picture yet.
    press(&mut harness, Key::ArrowUp);
    let mut given = 0;
    while let Some(shown) = next_stimulus(&mut harness) {
        if given == 3 {
            // Taken back: the picture before comes again. And a pause keeps the picture.
            press(&mut harness, Key::Backspace);
            let again = next_stimulus(&mut harness).unwrap();
            press(&mut harness, Key::Escape);
            harness.run_steps(2);
            harness.get_by_label_contains("2 of 42 done");
            press(&mut harness, Key::Space);
            assert_eq!(next_stimulus(&mut harness), Some(again));
            given = 100;
            continue;
        }
        let brighter = observer.judge(&display, &shown, &mut rng) == Judgement::Brighter;
        press(&mut harness, if brighter { Key::ArrowUp } else { Key::D });
        given += 1;
    }
    harness.get_by_label_contains("Red: gamma");
    harness.get_by_label_contains("Blue: gamma");
    // A wrong key takes nothing away at once.
    press(&mut harness, Key::Escape);
    harness.run_steps(2);
    harness.get_by_label_contains("The profile is not saved");
    click(&mut harness, "Check on the screen…");
    harness.get_by_label_contains("what wrong looks like");
    press(&mut harness, Key::Escape);
    harness.run_steps(3);
    type_into(&mut harness, "Measured by", "N. N.");
    click(&mut harness, "Save and use");
    harness.get_by_label_contains("Saved as");

    let saved = profile::open(&path).unwrap();
    for (transfer, gamma) in saved.transfers.channels().iter().zip(GAMMAS) {
        let Transfer::Gamma(found) = transfer else { panic!("{transfer}") };
        assert!((found - gamma).abs() < 0.05, "{found} for {gamma}");
    }
    let measured = saved.measured.unwrap();
    assert_eq!(measured.by.as_deref(), Some("N. N."));
    assert_eq!(measured.with.as_deref(), Some("visual nulling by staircase, 42 answers"));
    assert!(measured.on.is_some());

    let file = folder.path().join("left-nulling.csv");
    let text = std::fs::read_to_string(&file).unwrap();
    assert_eq!(text.lines().count(), 1 + 42 + 2, "every answer is kept, the one taken back too: {text}");
    assert_eq!(matches::open(&file).unwrap().len(), 42);
    let broken = text.replace(",red,", ",rot,");
    let faults = matches::parse("answers", &broken).unwrap_err().to_string();
    assert!(faults.contains("expected r, g, b or gray"), "{faults}");
}

#[test]
fn the_slider_matches_by_arrows_and_enter() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("right.toml");
    let display = SimulatedDisplay { transfers: Transfers::new(GAMMAS.map(Transfer::Gamma)), flare: 0.0 };
    let observer = SimulatedObserver { threshold: 0.004, lapse: 0.0 };
    let mut rng = ChaCha8Rng::seed_from_u64(2);
    let mut harness = harness();
    // A name of another kind, and too few channels, are told at once.
    open(&mut harness, "Gamma by eye");
    click(&mut harness, "green");
    harness.get_by_label_contains("needs red, green and blue, or gray");
    press(&mut harness, Key::Escape);
    harness.run_steps(3);
    begin(&mut harness, "adjust until it vanishes", &path);
    while let Some(shown) = next_stimulus(&mut harness) {
        let wanted = observer.adjust(&display, &shown, &mut rng);
        while let Some(now) = next_stimulus(&mut harness).filter(|now| now.patch != wanted) {
            let away = i32::from(wanted) - i32::from(now.patch);
            press(
                &mut harness,
                match away {
                    10.. => Key::PageUp,
                    1.. => Key::ArrowRight,
                    ..=-10 => Key::PageDown,
                    _ => Key::ArrowLeft,
                },
            );
            harness.step();
        }
        press(&mut harness, Key::Enter);
        harness.step();
    }
    click(&mut harness, "Save and use");
    let saved = profile::open(&path).unwrap();
    for (transfer, gamma) in saved.transfers.channels().iter().zip(GAMMAS) {
        let Transfer::Gamma(found) = transfer else { panic!("{transfer}") };
        assert!((found - gamma).abs() < 0.05, "{found} for {gamma}");
    }
    // The next run has a file of its own.
    assert_eq!(matches::open(&folder.path().join("right-nulling.csv")).unwrap().len(), 12);
    open(&mut harness, "Gamma by eye");
    type_into(&mut harness, "Save the profile as", &path.display().to_string());
    harness.get_by_label_contains("right-nulling.csv, and a matching that was left cannot be gone on with");
    harness.get_by_label_contains("right-nulling-2.csv.");
    click(&mut harness, "Next");
    assert!(folder.path().join("right-nulling-2.csv").exists());
}

#[test]
fn the_check_and_the_steps_can_be_looked_at() {
    let mut harness = harness();
    open(&mut harness, "Check the gamma");
    for label in
        ["gray, 1 of 4 rows", "red, 1 of 2 rows", "blue, 3 of 4 rows", "green, wrong by −0.2", "blue, wrong by +0.2"]
    {
        assert!(harness.query_by_label(label).is_some(), "{label}");
    }
    click(&mut harness, "Pairs of rows (interlaced pictures, row inversion)");
    press(&mut harness, Key::Escape);
    harness.run_steps(3);

    open(&mut harness, "Steps of equal brightness");
    harness.get_by_label_contains("A wedge of 13 uniform bars");
    harness.get_by_label_contains("Black was not measured");
    type_into(&mut harness, "Number of steps n", "4");
    harness.get_by_label_contains("A wedge of 5 uniform bars");
    type_into(&mut harness, "Lowest intensity I₀, black over white", "2");
    harness.get_by_label_contains("is not between 0 and 1");
    type_into(&mut harness, "Lowest intensity I₀, black over white", "0.01");
    click(&mut harness, "Copy as CSV");
    harness.get_by_label_contains("Copied.");
    type_into(&mut harness, "Number of steps n", "200");
    harness.get_by_label_contains("8 bits are too few here");
    press(&mut harness, Key::Escape);
    harness.run_steps(3);
    harness.get_by_label("Steps of equal brightness");
}

/// Shoaff's steps: the same ratio from each to the next, from black to white, with the screen's black taken off before
/// codes are made.
#[test]
fn steps_have_one_ratio_and_the_codes_of_the_profile() {
    let range = LuminanceRange { black_cd_m2: 0.5, white_cd_m2: 250.0 };
    let profile = DisplayProfile {
        transfers: Transfer::gamma(2.2).unwrap().into(),
        luminance: Some(range),
        ..DisplayProfile::default()
    };
    let i0 = range.lowest_intensity();
    let made = steps(&profile, i0, 8).unwrap();
    assert_eq!((made.len(), made[0].codes, made[8].codes), (9, [0; 3], [255; 3]));
    for pair in made.windows(2) {
        assert!((pair[1].intensity / pair[0].intensity - (1.0 / i0).powf(1.0 / 8.0)).abs() < 1e-9);
    }
    for step in &made {
        // An independent way to the code: cd/m² above black, over the range, to the power of 1/γ.
        let cd_m2 = step.cd_m2.unwrap();
        let expected = (((cd_m2 - 0.5) / 249.5).max(0.0).powf(1.0 / 2.2) * 255.0).round();
        assert_eq!(f64::from(step.codes[1]), expected, "{step:?}");
        assert_eq!(step.nearest, step.level, "{step:?}");
        assert!((step.emitted / step.intensity).ln().abs() < 0.15, "{step:?}");
    }
    assert!(steps(&profile, i0, 200).unwrap().iter().any(|step| step.nearest != step.level));
    assert!(steps(&profile, 1.0, 8).is_err() && steps(&profile, i0, 0).is_err());
    assert_eq!(csv(&made).lines().nth(9), Some("8,1.00000000,250.000000,255,255,255,1.00000000,8"));
}
