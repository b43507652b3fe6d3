//! What the window learns from the system: whether the screen is scaled, and when keys were pressed.

use std::time::{Duration, Instant};

use eframe::egui::Key;
use machband::app::{Input, Pressed, Stamps, is_resampled};
use x11rb::protocol::randr::{GetCrtcInfoReply, ModeInfo, Rotation};

#[test]
fn a_scaled_screen_is_resampled_and_a_rotated_one_is_not() {
    let mode = ModeInfo { width: 1920, height: 1080, ..ModeInfo::default() };
    for (width, height, rotation, expected) in [
        (1920, 1080, Rotation::ROTATE0, false),
        (1080, 1920, Rotation::ROTATE90, false),
        (1080, 1920, Rotation::ROTATE270, false),
        (1920, 1080, Rotation::ROTATE90, true),
        (2880, 1620, Rotation::ROTATE0, true),
    ] {
        let shown = GetCrtcInfoReply { width, height, rotation, ..GetCrtcInfoReply::default() };
        assert_eq!(is_resampled(&mode, &shown), expected, "{width} × {height}, {rotation:?}");
    }
}

#[test]
fn each_press_is_given_once_in_its_order_and_at_its_own_time() {
    let (start, ms) = (Instant::now(), Duration::from_millis);
    let stamps = Stamps::default();
    let mut input = Input::stamped(stamps.clone());
    // The first frame puts the window's zero at 2 ms, the second at 0.5 ms, which is nearer to the truth.
    input.frame(1.0, start + ms(1002));
    input.frame(2.0, start + Duration::from_micros(2_000_500));
    for (what, at, unseen) in
        [(Pressed::Key(Key::Num1), 2103, 3), (Pressed::Click, 2104, 1), (Pressed::Key(Key::Num1), 2108, 5)]
    {
        stamps.press(what, start + ms(at), ms(unseen));
    }
    assert_eq!(input.key(Key::Num1), None, "not before the frame");
    input.frame(2.11, start + ms(2112));
    let key = |key| input.key(key).map(|press| ((press.at_s * 1e4).round(), press.uncertainty));
    let expected = [Some((21_025.0, Some(ms(3)))), None, Some((21_075.0, Some(ms(5)))), None];
    assert_eq!([Key::Num1, Key::Num2, Key::Num1, Key::Num1].map(key), expected);
    assert_eq!(input.click().and_then(|press| press.uncertainty), Some(ms(1)));
    // The next frame discards presses that have not been read.
    stamps.press(Pressed::Click, start + ms(2113), ms(1));
    input.frame(2.12, start + ms(2120));
    input.frame(2.13, start + ms(2130));
    assert_eq!(input.click(), None);
}
