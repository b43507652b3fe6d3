//! Gamma by eye, its check and the steps of equal brightness, driven without a display.

use std::path::Path;

use eframe::egui::Key;
use egui_kittest::kittest::{NodeT as _, Queryable as _};
use machband::{
    display::{
        Channel, DisplayProfile, LuminanceRange,
        matching::{Match, MatchSettings},
        steps::{csv, steps},
    },
    light::{Transfer, Transfers},
    store::{matches, profile},
};
use rand_chacha::{ChaCha8Rng, rand_core::SeedableRng as _};

use super::{
    eye::matched_code,
    window::{Window, click, home, press, take_picture, type_into},
};

const GAMMAS: [f64; 3] = [1.9, 2.2, 2.5];

fn tool(name: &str) -> Window {
    let mut window = home([1000.0, 800.0], 1.0 / 30.0);
    click(&mut window, "Measure…");
    click(&mut window, name);
    window
}

/// The match on the screen, by its description; `None` while there is none.
fn shown(window: &Window) -> Option<Match> {
    let label = window.query_by_label_contains("rows lit in ")?.accesskit_node().label()?;
    let channel = Channel::ALL.into_iter().find(|channel| label.contains(&format!("in {channel};")))?;
    let code = label.rsplit(' ').next()?.parse().ok()?;
    Some(Match { channel, rows: MatchSettings::default().rows(), code })
}

fn next(window: &mut Window) -> Option<Match> {
    for _ in 0..40 {
        if let Some(shown) = shown(window) {
            return Some(shown);
        }
        if window.query_by_label("Result").is_some() {
            return None;
        }
        window.step();
    }
    panic!("no picture came");
}

fn begin(window: &mut Window, file: &Path) {
    type_into(window, "Keep the measurements in", file.to_str().unwrap());
    // The slider's least number of matches.
    let slider = window.query_all_by_label("Matches of each channel").find(|node| node.value().is_some());
    slider.unwrap().focus();
    window.step();
    (0..10).for_each(|_| press(window, Key::ArrowLeft));
    window.get_by_label_contains("6 matches, about 1 min");
    click(window, "Begin");
}

/// Matches the square on the screen as an observer would.
fn adjust(window: &mut Window, now: Match, rng: &mut ChaCha8Rng) {
    let display = Transfers::new(GAMMAS.map(Transfer::Gamma));
    let wanted = i32::from(matched_code(&display, &now, 0.004, rng));
    for _ in 0..60 {
        let away = wanted - i32::from(next(window).unwrap().code);
        press(
            window,
            match away {
                10.. => Key::PageUp,
                1.. => Key::ArrowRight,
                0 => break,
                ..=-10 => Key::PageDown,
                _ => Key::ArrowLeft,
            },
        );
        window.step();
    }
    press(window, Key::Enter);
    window.step();
}

#[test]
fn an_observer_at_the_keys_gets_the_gamma_of_the_screen() {
    let folder = tempfile::tempdir().unwrap();
    let (csv, toml) = (folder.path().join("new/matches.csv"), folder.path().join("left.toml"));
    let mut rng = ChaCha8Rng::seed_from_u64(2);
    let mut window = tool("Gamma by eye");
    window.get_by_label_contains("30 matches, about 5 min");
    take_picture(&mut window, "display_by_eye");
    // Too few channels are told at once.
    click(&mut window, "red, green, blue");
    window.get_by_label_contains("expected red, green and blue, or gray");
    click(&mut window, "red, green, blue");
    begin(&mut window, &csv);
    // Too early: no picture yet.
    press(&mut window, Key::Enter);
    for given in 0.. {
        let Some(now) = next(&mut window) else { break };
        if given == 0 {
            take_picture(&mut window, "display_match");
        }
        adjust(&mut window, now, &mut rng);
        if given == 2 {
            // Taken back, the match comes again as it was accepted. A pause keeps what was done.
            press(&mut window, Key::Backspace);
            assert_eq!(next(&mut window).unwrap().channel, now.channel);
            press(&mut window, Key::Escape);
            window.run_steps(2);
            window.get_by_label_contains("Paused after 2 of 6");
            click(&mut window, "Back");
            click(&mut window, "Gamma by eye");
            click(&mut window, "Resume");
        }
    }
    // The gamma and, of only two matches, a word on how well it is known.
    assert!(window.get_all_by_label_contains("Red: gamma").count() >= 1);
    assert!(window.get_all_by_label_contains("Blue: gamma").count() >= 1);
    take_picture(&mut window, "display_by_eye_result");
    click(&mut window, "Check on the screen…");
    window.get_by_label_contains("examples of a wrong profile");
    press(&mut window, Key::Escape);
    window.run_steps(3);
    type_into(&mut window, "Measured by", "N. N.");
    type_into(&mut window, "Save as", toml.to_str().unwrap());
    click(&mut window, "Save the profile");
    window.get_by_label_contains("Saved as");

    let saved = profile::open(&toml).unwrap();
    for (transfer, gamma) in saved.transfers.channels().iter().zip(GAMMAS) {
        let Transfer::Gamma(found) = transfer else { panic!("{transfer}") };
        assert!((found - gamma).abs() < 0.06, "{found} for {gamma}");
    }
    let measured = saved.measured.unwrap();
    assert_eq!(measured.by.as_deref(), Some("N. N."));
    assert_eq!(measured.with.as_deref(), Some("matching by eye, 6 matches"));
    assert!(measured.on.is_some());

    let text = std::fs::read_to_string(&csv).unwrap();
    assert_eq!(text.lines().count(), 1 + 6 + 2, "every match is kept, the one taken back too: {text}");
    assert_eq!(matches::open(&csv).unwrap().len(), 6);
    let faults = matches::parse("m.csv", &text.replace(",red,", ",rot,")).unwrap_err().to_string();
    assert!(faults.contains("expected r, g, b or gray"), "{faults}");
    // Of a staircase, which there was once, no match counts.
    let staircase = text.replace(",matched,", ",brighter,");
    assert!(matches::parse("m.csv", &staircase).unwrap().is_empty());
    // Half a row, which a power cut leaves, is dropped, and the next one follows the last whole one.
    std::fs::write(&csv, &text[..text.len() - 5]).unwrap();
    let (mut file, done) = matches::MatchFile::resume(&csv).unwrap();
    assert_eq!(done.len(), 5);
    file.accept(6, &done[0], 1.0).unwrap();
    assert_eq!(matches::open(&csv).unwrap().len(), 6);
    assert!(matches::MatchFile::resume(&csv).is_err(), "it is open");
}

#[test]
fn the_check_and_the_steps_can_be_seen() {
    let mut window = tool("Check the gamma");
    take_picture(&mut window, "display_check");
    for label in
        ["gray, 1 of 4 rows", "red, 1 of 2 rows", "blue, 3 of 4 rows", "green, wrong by −0.2", "blue, wrong by +0.2"]
    {
        assert!(window.query_by_label(label).is_some(), "{label}");
    }
    click(&mut window, "Pairs of rows (interlaced pictures, row inversion)");
    press(&mut window, Key::Escape);
    window.run_steps(3);

    click(&mut window, "Steps of equal brightness");
    window.get_by_label_contains("A wedge of 13 uniform bars");
    window.get_by_label_contains("Black was not measured");
    take_picture(&mut window, "display_steps");
    type_into(&mut window, "Number of steps n", "4");
    window.get_by_label_contains("A wedge of 5 uniform bars");
    type_into(&mut window, "Lowest intensity I₀, black over white", "2");
    window.get_by_label_contains("is not between 0 and 1");
    type_into(&mut window, "Lowest intensity I₀, black over white", "0.01");
    click(&mut window, "Copy as CSV");
    window.get_by_label_contains("Copied.");
    type_into(&mut window, "Number of steps n", "200");
    window.get_by_label_contains("8 bits are too few here");
    press(&mut window, Key::Escape);
    window.run_steps(3);
    window.get_by_label("Steps of equal brightness");
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
