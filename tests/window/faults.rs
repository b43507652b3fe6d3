//! What is plugged in goes in the middle of a trial: the monitor, the display server, the graphics card.

use std::ffi::OsString;

use x11rb::{
    connection::Connection as _,
    protocol::randr::{ConnectionExt as _, ModeInfo, Rotation},
    wrapper::ConnectionExt as _,
};

use super::*;
use crate::build;

/// The monitor goes and leaves one that is smaller than the stimulus: the session waits and says why, and goes on when
/// there is room again.
#[test]
fn a_smaller_screen_pauses_the_session() {
    let Some((mut harness, planned, csv)) = Harness::with_session() else { return };
    harness.rate(&csv, pattern(0));
    harness.rate(&csv, pattern(1));
    harness.stimulus();
    resize(&harness, (640, 300));
    harness.until("the pause page", |harness| harness.see() == Sight::Page);
    harness.press("2");
    harness.press("space");
    std::thread::sleep(Duration::from_secs(1));
    assert_eq!(harness.see(), Sight::Page, "there is no room for a stimulus");
    harness.at_rest();
    harness.keep_picture("screen-smaller");
    assert_eq!(rows(&csv).len(), 2);

    resize(&harness, SCREEN);
    harness.at_rest();
    harness.keep_picture("screen-back");
    harness.resume();
    for i in 2..planned.len() {
        harness.rate(&csv, pattern(i));
    }
    harness.complete("swift");
    assert_planned_once(&rows(&csv), &planned);
    assert!(checked(&csv).contains("10 of 10 planned trials"));
}

/// Gives the screen another size, as when another monitor takes over.
fn resize(harness: &Harness, (width, height): (usize, usize)) {
    let (x, number) = x11rb::connect(Some(&harness.display)).unwrap();
    let root = x.setup().roots[number].root;
    let (w, h) = (width as u16, height as u16);
    let resources = x.randr_get_screen_resources(root).unwrap().reply().unwrap();
    let (crtc, output) = (resources.crtcs[0], resources.outputs[0]);
    let known = resources.modes.iter().find(|mode| (mode.width, mode.height) == (w, h)).map(|mode| mode.id);
    let mode = known.unwrap_or_else(|| {
        let name = format!("{w}x{h}");
        let info = ModeInfo {
            width: w,
            height: h,
            dot_clock: 60 * u32::from(w) * u32::from(h),
            htotal: w,
            vtotal: h,
            name_len: name.len() as u16,
            ..ModeInfo::default()
        };
        let mode = x.randr_create_mode(root, info, name.as_bytes()).unwrap().reply().unwrap().mode;
        x.randr_add_output_mode(output, mode).unwrap().check().unwrap();
        mode
    });
    let size = || {
        let (mm_w, mm_h) = (u32::from(w) * 254 / 960, u32::from(h) * 254 / 960);
        x.randr_set_screen_size(root, w, h, mm_w, mm_h).unwrap().check().unwrap();
    };
    let show = || {
        let time = x11rb::CURRENT_TIME;
        x.randr_set_crtc_config(crtc, time, time, 0, 0, mode, Rotation::ROTATE0, &[output]).unwrap().reply().unwrap();
    };
    // A picture fits on its screen at every moment.
    if (width, height) == SCREEN {
        size();
        show();
    } else {
        show();
        size();
    }
    x.sync().unwrap();
}

/// What the program says where window or graphics go: one sentence of ours, and no panic.
fn last_words(harness: &Harness) -> String {
    let said = harness.said();
    let errors: Vec<_> = said.lines().filter(|line| line.starts_with("error: ")).collect();
    assert!(errors.len() == 1 && !said.contains("panicked"), "{said}");
    assert!(errors[0].contains("the window was lost") && errors[0].contains("--resume"), "{said}");
    errors[0].to_owned()
}

/// The first sitting's rows are kept and it is closed; `--resume` asks for what is missing.
fn resume_to_the_end(harness: &mut Harness, planned: &[Row], done: usize) {
    let csv = harness.csv("swift");
    assert_eq!(rows(&csv).len(), done);
    assert!(harness.sidecar("swift")["sittings"][0]["ended_at"].is_string(), "the sitting was not closed");
    let definition = harness.swift();
    harness.run(&definition, &["--participant", "S001", "--resume"]);
    for i in done..planned.len() {
        harness.rate(&csv, pattern(i));
    }
    harness.complete("swift");
    assert_planned_once(&rows(&csv), planned);
    assert!(checked(&csv).contains("10 of 10 planned trials"));
}

/// The display server ends, in a trial and on a page that waits.
#[test]
fn a_display_server_that_goes_takes_nothing_with_it() {
    for in_trial in [true, false] {
        let Some((mut harness, planned, csv)) = Harness::with_session() else { return };
        for i in 0..3 {
            harness.rate(&csv, pattern(i));
        }
        harness.stimulus();
        if !in_trial {
            harness.press("Escape");
            harness.until("the pause page", |harness| harness.see() == Sight::Page);
            harness.at_rest();
        }
        for mut server in harness.servers.drain(..) {
            server.kill().unwrap();
            server.wait().unwrap();
        }
        let status = harness.wait_for_end();
        assert_eq!(status.code(), Some(1), "{}", harness.said());
        last_words(&harness);
        harness.start_servers();
        resume_to_the_end(&mut harness, &planned, 3);
    }
}

/// The graphics card answers no more.
#[test]
fn a_graphics_card_that_goes_takes_nothing_with_it() {
    let Some(mut harness) = Harness::new() else { return };
    let folders = ["/usr/lib/x86_64-linux-gnu", "/usr/lib/aarch64-linux-gnu", "/usr/lib64", "/usr/lib"];
    let library = folders.map(|folder| Path::new(folder).join("libvulkan.so.1")).into_iter().find(|path| path.exists());
    let Some(library) = library else { return build::skip("libvulkan.so.1 cannot be found") };
    let fake = harness.dir.path().join("vulkan");
    fs::create_dir(&fake).unwrap();
    if !build::library("vulkan_shim", &fake.join("libvulkan.so.1")) {
        return;
    }
    let lost = harness.dir.path().join("lost");
    harness.environment = [("LD_LIBRARY_PATH", &fake), ("MACHBAND_VULKAN", &library), ("MACHBAND_VULKAN_LOST", &lost)]
        .map(|(name, value)| (name, OsString::from(value)))
        .to_vec();
    let definition = harness.swift();
    let planned = harness.planned(&definition, 7);
    harness.run(&definition, &["--participant", "S001", "--seed", "7"]);
    let csv = harness.csv("swift");
    for i in 0..3 {
        harness.rate(&csv, pattern(i));
    }
    harness.stimulus();
    fs::write(&lost, "").unwrap();
    let status = harness.wait_for_end();
    assert_eq!(status.code(), Some(1), "{}", harness.said());
    let said = last_words(&harness);
    assert!(said.contains("the graphics card is gone"), "{said}");
    fs::remove_file(&lost).unwrap();
    resume_to_the_end(&mut harness, &planned, 3);
}
