//! Palettes: what each reducer keeps, and that the result is always the same.

use std::collections::BTreeSet;

use machband::light::palette::{IndexedImage, Reducer, Reduction};
use machband::light::{CodeImage, Samples, Transfer};
use proptest::prelude::*;

fn image(width: u32, pixels: &[[u8; 3]]) -> CodeImage {
    let height = pixels.len() as u32 / width;
    CodeImage { width, height, samples: Samples::Eight(pixels.as_flattened().to_vec()) }
}

fn reduce(image: &CodeImage, transfer: &Transfer, colors: u32, reducer: Reducer) -> IndexedImage {
    machband::light::palette::reduce(image, transfer, Reduction { reducer, colors }).unwrap()
}

#[test]
fn invalid_texts_and_images_are_rejected() {
    for text in ["median-cut:0", "median-cut:257", "median-cut", "octree:8", "popularity:many"] {
        let message = text.parse::<Reduction>().unwrap_err().to_string();
        assert!(message.contains("expected popularity or median-cut, a colon and 1…256 colors"), "{message}");
    }
    let deep = CodeImage { width: 1, height: 1, samples: Samples::Sixteen(vec![0, 1, 2]) };
    let reduction = "median-cut:2".parse().unwrap();
    let error = machband::light::palette::reduce(&deep, &Transfer::Srgb, reduction).unwrap_err();
    assert!(error.contains("16-bit codes"), "{error}");
    for &reducer in Reducer::ALL {
        let empty = reduce(&image(1, &[]), &Transfer::Srgb, 4, reducer);
        assert_eq!((empty.palette.len(), empty.indices.len()), (0, 0));
    }
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

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn any_image_can_be_reduced(
        pixels in prop::collection::vec(prop::array::uniform3(prop_oneof![any::<u8>(), Just(0), Just(255)]), 1..300),
        colors in 1u32..=40, linear in any::<bool>(), which in 0usize..2,
    ) {
        let transfer = if linear { Transfer::Linear } else { Transfer::Srgb };
        let image = image(1, &pixels);
        let reduced = reduce(&image, &transfer, colors, Reducer::ALL[which]);
        prop_assert_eq!(&reduced, &reduce(&image, &transfer, colors, Reducer::ALL[which]));
        prop_assert!(!reduced.palette.is_empty() && reduced.palette.len() <= colors as usize);
        prop_assert!(reduced.palette.is_sorted_by(|a, b| a < b));
        prop_assert_eq!(reduced.indices.len(), pixels.len());
        let distinct = BTreeSet::from_iter(&pixels);
        if distinct.len() <= colors as usize {
            prop_assert!(reduced.palette.iter().eq(distinct));
            prop_assert_eq!(reduced.codes(), image);
        }
    }
}
