//! Dither and halftone, compared with the published matrices and algorithm and with their defining properties: only the
//! two enclosing codes occur, the mean light is right, and there is no noise where none is needed. Palettes: what each
//! reducer keeps, and that the result is always the same.

use std::collections::BTreeSet;

use machband::light::{
    Bits, CodeImage, Dither, DitherMatrix, LinearImage, Quantizer, Samples, Thresholds, Transfer, Transfers,
    dither::{MASK_SIZE, Screen, enlarged},
    palette::{IndexedImage, Reducer, Reduction},
};

use super::transfers;

/// Returns every kind of dither with a seed, the random kind with several.
fn dithers() -> Vec<(Dither, u64)> {
    let random = [1, 2, 99].map(|seed| (Dither::Random, seed));
    let ordered = DitherMatrix::ALL.iter().copied().map(Dither::Ordered);
    [Dither::BlueNoise].into_iter().chain(ordered).map(|dither| (dither, 1)).chain(random).collect()
}

// Matrices.

/// The 8 × 8 table as printed in Wikipedia, *Ordered dithering* (revision of 2024), after Bayer 1973.
const BAYER_8: [[u16; 8]; 8] = [
    [0, 32, 8, 40, 2, 34, 10, 42],
    [48, 16, 56, 24, 50, 18, 58, 26],
    [12, 44, 4, 36, 14, 46, 6, 38],
    [60, 28, 52, 20, 62, 30, 54, 22],
    [3, 35, 11, 43, 1, 33, 9, 41],
    [51, 19, 59, 27, 49, 17, 57, 25],
    [15, 47, 7, 39, 13, 45, 5, 37],
    [63, 31, 55, 23, 61, 29, 53, 21],
];

#[test]
fn matrices_match_the_published_ones() {
    assert_eq!(DitherMatrix::Bayer8.ranks(), BAYER_8.concat());
    assert_eq!(DitherMatrix::Bayer2.ranks(), [0, 2, 3, 1]);
    assert_eq!(DitherMatrix::Bayer4.ranks(), [0, 8, 2, 10, 12, 4, 14, 6, 3, 11, 1, 9, 15, 7, 13, 5]);
    // Shoaff §2.1.2 compares S(x, y) with D[x mod n][y mod n]: x picks the printed row.
    let printed = [[6, 8, 4], [1, 0, 3], [5, 2, 7]];
    for (x, row) in (0..).zip(printed) {
        for (y, rank) in (0..).zip(row) {
            assert_eq!(DitherMatrix::Clustered3.rank(x, y), rank);
            assert_eq!(DitherMatrix::Clustered3.rank(x + 30, y + 3), rank);
        }
    }
    for (x, y) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
        assert_eq!(DitherMatrix::Clustered2.rank(x, y), DitherMatrix::Bayer2.rank(y, x));
    }
}

// Thresholds.

/// Returns the thresholds of the first `size` × `size` pixels, row by row.
fn thresholds(dither: Dither, size: u32) -> Vec<f64> {
    let mut rows = Thresholds::new(dither, 1, size).unwrap();
    (0..size).flat_map(|y| rows.row(y).to_vec()).collect()
}

/// Each rank occurs once. The tests of the mask's generator, in `tools`, check how the blue-noise mask is made.
#[test]
fn thresholds_are_spread_over_the_open_interval() {
    for (dither, _) in dithers().into_iter().filter(|(dither, _)| *dither != Dither::Random) {
        let period = if let Dither::Ordered(matrix) = dither { matrix.size() } else { MASK_SIZE };
        let mut all = thresholds(dither, period);
        let mut rows = Thresholds::new(dither, 1, 200).unwrap();
        let first = rows.row(5)[3];
        assert_eq!(first, rows.row(5 + 9 * period)[3 + period as usize], "{dither} repeats");
        all.sort_unstable_by(f64::total_cmp);
        let count = all.len() as f64;
        // Each of the equal parts of (0, 1) contains one threshold; none is at an end.
        assert!((0..).zip(&all).all(|(i, t)| *t > 0.0 && (t * count).floor() == f64::from(i)), "{dither}");
    }
    assert!(Thresholds::new(Dither::None, 1, 7).is_none());
}

/// ChaCha8 and its use are pinned: another order would make different stimuli from the same seed. The four numbers come
/// from a Python script that implements ChaCha8 after Bernstein and the seed expansion of rand_core 0.10.
#[test]
fn random_thresholds_are_pinned_and_stratified() {
    let mut rows = Thresholds::new(Dither::Random, 1, 1024).unwrap();
    let found = [(0, 0), (1, 0), (5, 2), (1023, 1023)].map(|(x, y)| rows.row(y)[x]);
    assert_eq!(
        found,
        [0.291_022_424_142_283_85, 0.182_426_453_153_311_74, 0.417_578_606_495_226_27, 0.093_375_676_420_691_89]
    );
    let mut orders = BTreeSet::new();
    for seed in 0..4 {
        let mut rows = Thresholds::new(Dither::Random, seed, 256).unwrap();
        for tile in [(0, 0), (1, 0), (0, 1), (2, 7), (63, 200)] {
            let order: Vec<u32> =
                (0..16).map(|i| (rows.row(4 * tile.1 + i / 4)[(4 * tile.0 + i % 4) as usize] * 16.0) as u32).collect();
            assert!(BTreeSet::from_iter(order.clone()).into_iter().eq(0..16), "seed {seed}, tile {tile:?}");
            for first in [0, 2, 8, 10] {
                let quarters = BTreeSet::from([0, 1, 4, 5].map(|place| order[first + place] / 4));
                assert!(quarters.into_iter().eq(0..4), "seed {seed}, tile {tile:?}");
            }
            orders.insert(order);
        }
    }
    assert_eq!(orders.len(), 20, "every seed and tile has its own order");
}

// Decisions.

/// The definition, using only public parts: the result is the upper of the two enclosing codes if and only if p > t.
/// Light within a rounding error of a code's own light gets that code.
fn by_definition(quantizer: &Quantizer, channel: usize, linear: f32, threshold: f64) -> u16 {
    let channel = quantizer.channel(channel);
    let level = |code: u16| channel.linear(code) as f32;
    let near = channel.code(linear);
    let lower = if level(near) > linear { near - 1 } else { near };
    if lower == quantizer.bits().max_code() || linear <= level(lower).next_up() {
        return lower;
    }
    let (low, high, light) = (f64::from(level(lower)), f64::from(level(lower + 1)), f64::from(linear));
    let is_upper = linear >= level(lower + 1).next_down() || (light - low) / (high - low) > threshold;
    lower + u16::from(is_upper)
}

/// Red, green and blue share a pixel's threshold; each has its own transfer function.
#[test]
fn every_pixel_follows_the_definition() {
    // The sides are not multiples of any period.
    let (width, height) = (131, 71);
    let image = LinearImage::from_fn(width, height, |x, y| {
        let level = (x as f32 + 0.37 * y as f32) / 160.0;
        [level, 0.9 * level, level * level]
    });
    let gamma = Transfer::Gamma(2.2);
    let differing = Transfers::new([Transfer::Srgb, Transfer::Linear, gamma.clone()]);
    let eight = transfers().into_iter().map(Transfers::from).chain([differing]).map(|t| (t, Bits::Eight));
    for (transfers, bits) in eight.chain([(gamma.into(), Bits::Sixteen)]) {
        let quantizer = Quantizer::new(&transfers, bits);
        for (dither, seed) in dithers() {
            let codes = quantizer.quantize_with(&image, dither, seed);
            assert_eq!((codes.width, codes.height), (width, height));
            let mut rows = Thresholds::new(dither, seed, width).unwrap();
            for (x, y) in (0..width * height).map(|i| (i % width, i / width)) {
                let (light, threshold) = (image.pixel(x, y), rows.row(y)[x as usize]);
                let expected = [0, 1, 2].map(|i| by_definition(&quantizer, i, light[i], threshold));
                assert_eq!(codes.pixel(x, y), expected, "{transfers} {bits} {dither} ({x}, {y})");
            }
        }
    }
}

// Halftone.

/// Returns the mean light of each level: level c·n² + r has r dots of the code c + 1, and the others have the code c.
fn levels(Screen { matrix, bits }: Screen, transfer: &Transfer) -> Vec<f64> {
    let (dots, max) = (matrix.size().pow(2), 2u32.pow(bits) - 1);
    let light = |code: u32| transfer.linear_from_encoded(f64::from(code.min(max)) / f64::from(max));
    let mean = |level: u32| {
        let (code, lit) = (level / dots, f64::from(level % dots) / f64::from(dots));
        (1.0 - lit) * light(code) + lit * light(code + 1)
    };
    (0..=dots * max).map(mean).collect()
}

/// From each level to the next, the next dot in the order of the matrix gets the next code.
#[test]
fn every_level_has_its_cell() {
    for (&matrix, bits) in DitherMatrix::ALL.iter().flat_map(|matrix| (1..=8).map(move |bits| (matrix, bits))) {
        let (n, max) = (matrix.size(), 2u32.pow(bits) - 1);
        if n * n * max > 4096 {
            continue;
        }
        let screen = Screen { matrix, bits };
        let lights = levels(screen, &Transfer::Srgb);
        let image = LinearImage::from_fn(lights.len() as u32, 1, |x, _| [lights[x as usize] as f32; 3]);
        let dots = enlarged(&image, screen, &Transfer::Srgb.into());
        assert_eq!((dots.width, dots.height), (n * image.width, n));
        for (x, y) in (0..dots.width).flat_map(|x| (0..n).map(move |y| (x, y))) {
            let (level, rank) = (x / n, u32::from(matrix.rank(x, y)));
            let code = level / (n * n) + u32::from(rank < level % (n * n));
            assert_eq!(
                dots.pixel(x, y),
                [(f64::from(code) * 255.0 / f64::from(max)).round() as u16; 3],
                "{screen} {level}"
            );
        }
    }
    for text in ["clustered2:0", "bayer2:9", "bayer3:1", "clustered3", "clustered3:"] {
        let error = text.parse::<Screen>().unwrap_err().to_string();
        assert!(error.contains("expected bayer2, bayer4") && error.contains("1…8 bits"), "{error}");
    }
}

/// Each channel has its own transfer function.
#[test]
fn every_value_gets_the_nearest_level() {
    let image = LinearImage::from_fn(23, 11, |x, y| {
        let (u, v) = (x as f32 / 22.0, y as f32 / 10.0);
        [u, v, 0.7 * (1.0 - u) + 0.1 * v]
    });
    let transfers = Transfers::new([Transfer::Srgb, transfers().pop().unwrap(), Transfer::Gamma(2.2)]);
    for (matrix, bits) in [(DitherMatrix::Clustered3, 1), (DitherMatrix::Clustered2, 3), (DitherMatrix::Bayer4, 4)] {
        let (screen, n, max) = (Screen { matrix, bits }, matrix.size(), 2f64.powi(bits as i32) - 1.0);
        let dots = enlarged(&image, screen, &transfers);
        for (channel, transfer) in transfers.channels().iter().enumerate() {
            let levels = levels(screen, transfer);
            for (x, y) in (0..23 * 11).map(|i| (i % 23, i / 23)) {
                let light = |i: u32| {
                    let code = dots.pixel(x * n + i % n, y * n + i / n)[channel];
                    transfer.linear_from_encoded((f64::from(code) * max / 255.0).round() / max)
                };
                let mean = (0..n * n).map(light).sum::<f64>() / f64::from(n * n);
                let off = |light: &f64| (light - f64::from(image.pixel(x, y)[channel])).abs();
                let least = levels.iter().map(off).fold(f64::MAX, f64::min);
                assert!(off(&mean) <= least + 1e-7, "{transfer} {screen} ({x}, {y})");
            }
        }
        let odd = LinearImage::from_fn(3, 1, |x, _| [[f32::NAN, -1.0, 2.0][x as usize]; 3]);
        let dots = enlarged(&odd, screen, &transfers);
        assert!((0..3 * n).all(|x| (0..n).all(|y| dots.pixel(x, y) == [if x < 2 * n { 0 } else { 255 }; 3])));
        assert_eq!(enlarged(&LinearImage::new(0, 3), screen, &transfers).bytes(), Some(&[][..]));
    }
}

fn image(width: u32, pixels: &[[u8; 3]]) -> CodeImage {
    let height = pixels.len() as u32 / width;
    CodeImage { width, height, samples: Samples::Eight(pixels.as_flattened().to_vec()) }
}

fn reduce(image: &CodeImage, transfer: &Transfer, colors: u32, reducer: Reducer) -> IndexedImage {
    machband::light::palette::reduce(image, &transfer.clone().into(), Reduction { reducer, colors }).unwrap()
}

/// An example small enough to compute by hand.
#[test]
fn each_reducer_does_what_its_name_says() {
    let pixels = [(10, 5), (12, 4), (100, 3), (201, 1)].map(|(red, count)| vec![[red, 0, 0]; count]).concat();
    let of = |colors, reducer| reduce(&image(1, &pixels), &Transfer::Linear, colors, reducer);
    assert_eq!(of(2, Reducer::Popularity).palette, [[10, 0, 0], [12, 0, 0]]);
    // Of 13 pixels, the middle one is a 12. It is nearer to the cut before it (5 | 8) than to the cut after it (9 | 4).
    // The mean of 4·12, 3·100 and 201 is 68.6.
    assert_eq!(of(2, Reducer::MedianCut).palette, [[10, 0, 0], [69, 0, 0]]);
    // Among equally frequent colors, the lowest are kept.
    let even = image(1, &[[3, 0, 0], [1, 0, 0], [2, 0, 0]]);
    assert_eq!(reduce(&even, &Transfer::Srgb, 2, Reducer::Popularity).palette, [[1, 0, 0], [2, 0, 0]]);
    // An image with no more colors keeps them, in ascending order.
    let kept = reduce(&even, &Transfer::Srgb, 3, Reducer::MedianCut);
    assert_eq!((kept.palette, kept.indices), (vec![[1, 0, 0], [2, 0, 0], [3, 0, 0]], vec![2, 0, 1]));
}

/// The palette from one machine is pinned; every other machine must produce the same.
#[test]
fn palettes_are_the_same_everywhere() {
    // Uses only whole numbers, so that the image itself cannot differ.
    let pixels: Vec<[u8; 3]> = (0..64u32 * 64)
        .map(|i| {
            let (x, y) = (i % 64, i / 64);
            [4 * x, 4 * y, (x * y) / 16].map(|code| code as u8)
        })
        .collect();
    let palette = |reducer| {
        let reduced = reduce(&image(64, &pixels), &Transfer::Linear, 6, reducer);
        reduced.palette.iter().map(|[r, g, b]| format!("{r:02x}{g:02x}{b:02x}")).collect::<Vec<_>>().join(" ")
    };
    assert_eq!(palette(Reducer::Popularity), "000000 000400 000800 000c00 001000 001400");
    assert_eq!(palette(Reducer::MedianCut), "1e3e07 3ebe2e 5e3e16 9e3e26 bebe8d de3e35");
}
