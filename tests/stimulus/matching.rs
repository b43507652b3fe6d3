//! Gamma matching by eye, performed by simulated observers on known displays.

use machband::{
    display::{
        Channel,
        matching::{CHECKED, ChannelGamma, Match, MatchSettings, Matching, Rows, estimate},
    },
    light::{Bits, Quantizer, Transfer, Transfers},
};
use rand_chacha::{
    ChaCha8Rng,
    rand_core::{Rng as _, SeedableRng as _},
};

use super::common::eye::matched_code;

const RGB: [Channel; 3] = [Channel::Red, Channel::Green, Channel::Blue];

fn power(gammas: [f64; 3]) -> Transfers {
    Transfers::new(gammas.map(|gamma| Transfer::gamma(gamma).unwrap()))
}

/// Returns all matches of a run. With the probability `lapse`, the observer leaves the square at its starting value.
fn run(settings: &MatchSettings, display: &Transfers, lapse: f64, seed: u64) -> Vec<Match> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed ^ 0x5eed);
    let mut matching = Matching::new(settings, seed, Vec::new()).unwrap();
    while let Some(shown) = matching.shown() {
        let code = matched_code(display, &shown, 0.02, &mut rng);
        if (rng.next_u64() >> 11) as f64 / (1u64 << 53) as f64 >= lapse {
            matching.adjust(code);
        }
        matching.accept().unwrap();
    }
    assert_eq!(matching.remaining_s(), 0.0);
    matching.done().to_vec()
}

/// Returns three exponents in 1.6…2.8.
fn gammas(seed: u64) -> [f64; 3] {
    let mut rng = ChaCha8Rng::seed_from_u64(seed ^ 0xd15);
    std::array::from_fn(|_| 1.6 + 1.2 * (rng.next_u64() >> 11) as f64 / (1u64 << 53) as f64)
}

fn found(matches: &[Match], channel: Channel) -> ChannelGamma {
    estimate(matches).into_iter().find(|(one, _)| *one == channel).unwrap().1.unwrap()
}

/// An observer with a difference threshold of 2 % matches three different channels with γ from 1.6 to 2.8. Within five
/// minutes, γ is found to within ±0.05, and the intervals from the spread of the matches cover it as often as they
/// claim.
#[test]
fn gamma_is_recovered_within_five_minutes() {
    let settings = MatchSettings::default();
    assert!(settings.duration_s() <= 300.0, "{} s", settings.duration_s());
    let (mut errors, mut covered, mut warned) = (Vec::new(), 0, 0);
    for seed in 0..200 {
        let truth = gammas(seed);
        let matches = run(&settings, &power(truth), 0.0, seed);
        for (channel, gamma) in RGB.into_iter().zip(truth) {
            let one = found(&matches, channel);
            errors.push(one.gamma - gamma);
            covered += usize::from((one.interval[0]..=one.interval[1]).contains(&gamma));
            warned += usize::from(one.warning().is_some());
        }
    }
    let number = errors.len() as f64;
    let within = errors.iter().filter(|error| error.abs() <= 0.05).count() as f64 / number;
    let rms = (errors.iter().map(|error| error * error).sum::<f64>() / number).sqrt();
    let bias = errors.iter().sum::<f64>() / number;
    let covered = covered as f64 / number;
    assert!(within >= 0.99 && rms < 0.02 && bias.abs() < 0.005, "{within} within 0.05, rms {rms}, bias {bias}");
    assert!((0.9..=0.98).contains(&covered) && warned <= 4, "{covered} covered, {warned} warned");
}

#[test]
fn matches_can_be_undone_and_runs_resumed() {
    let settings = MatchSettings { row_px: 2, ..MatchSettings::default() };
    let mut matching = Matching::new(&settings, 9, Vec::new()).unwrap();
    assert_eq!(matching.undo(), None);
    let mut shown = Vec::new();
    while let Some(now) = matching.shown() {
        shown.push(now);
        matching.adjust(now.code.wrapping_add(7));
        matching.accept().unwrap();
    }
    assert_eq!((matching.accept(), shown.len()), (None, settings.total()));
    let done = matching.done().to_vec();
    for (i, one) in done.iter().enumerate().rev() {
        assert_eq!((matching.undo(), matching.shown()), (Some(*one), Some(*one)));
        assert_eq!(matching.done().len(), i);
        // A resumed run continues with the same pictures.
        let resumed = Matching::new(&settings, 9, done[..i].to_vec()).unwrap();
        assert_eq!(resumed.shown(), Some(shown[i]));
    }
    let first = |seed| Matching::new(&settings, seed, Vec::new()).unwrap().shown();
    assert!((0..20).any(|seed| first(seed) != Some(shown[0])));
}

/// Columns do not differ, the mean of the rows is the share that the match assumes, and the patch begins and ends with
/// a period.
#[test]
fn the_picture_has_rows_and_a_patch() {
    for (row_px, period) in [(1, 4), (2, 2)] {
        let settings = MatchSettings { row_px, period, channels: vec![Channel::Gray], ..MatchSettings::default() };
        let shown = Matching::new(&settings, 2, Vec::new()).unwrap().shown().unwrap();
        let image = shown.rows.picture(shown.channel, shown.channel.rgb(shown.code), [120; 2], 50);
        let column = |x: u32| -> Vec<u16> { (0..120).map(|y| image.pixel(x, y)[0]).collect() };
        let (edge, middle) = (column(0), column(60));
        assert!((0..35).all(|x| column(x) == edge), "columns next to the patch are alike");
        let inside: Vec<usize> = (0..120).filter(|y| middle[*y] != edge[*y]).collect();
        let (first, last) = (inside[0], inside[inside.len() - 1] + 1);
        let period = shown.rows.period_px() as usize;
        assert!(first % period == 0 && last % period == 0 && last - first <= 50);
        assert!(inside.iter().all(|y| middle[*y] == u16::from(shown.code)));
        let lit = edge[..5 * period * 2].iter().filter(|code| **code == 255).count();
        assert_eq!(lit as f64 / (10 * period) as f64, shown.rows.share());
    }
}

/// The patch of the check has the light of the rows, to half a code, if the profile is right, and clearly different
/// light if γ is wrong by 0.2.
#[test]
fn the_check_patch_vanishes_only_if_the_profile_is_right() {
    let transfers =
        Transfers::new([Transfer::Srgb, Transfer::gamma(2.4).unwrap(), Transfer::gog(2.0, 0.9, 0.1).unwrap()]);
    let quantizer = Quantizer::new(&transfers, Bits::Eight);
    for channel in Channel::ALL {
        for (lit, period) in CHECKED {
            let rows = Rows { lit, period, row_px: 1 };
            let patch_of = |error| rows.check_patch(&transfers, channel, error);
            let expected = quantizer.codes([rows.share() as f32; 3]).map(|code| code as u8);
            for (i, expected) in expected.into_iter().enumerate() {
                let carried = channel.rgb(1)[i] == 1;
                let patch = patch_of(0.0)[i];
                assert_eq!(patch, if carried { expected } else { 0 });
                if carried && lit * 4 <= period * 2 {
                    assert!(patch_of(0.2)[i] >= patch + 2 && patch_of(-0.2)[i] <= patch - 2, "{channel} {lit}");
                }
            }
        }
    }
    let rows = Rows { lit: 1, period: 2, row_px: 2 };
    let patch = rows.check_patch(&transfers, Channel::Gray, 0.0);
    let image = rows.picture(Channel::Gray, patch, [64, 64], 32);
    assert_eq!((image.pixel(0, 1), image.pixel(0, 2)), ([255; 3], [0; 3]));
    assert_eq!(image.pixel(32, 32), quantizer.codes([0.5; 3]));
}
