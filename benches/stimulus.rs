//! Cost of one stimulus: 1024 × 1024 pixels, 8-bit RGB (3 MiB), sRGB, compared with filling the same amount of memory.
//!
//! Peers, as reported and not measured here: stimupy 1.2.0 takes 62–100 ms for a step or Cornsweet image of this size (it
//! has no Mach-band ramp). Results and how to repeat them: `benches/README.md`.

use divan::counter::BytesCount;
use divan::{Bencher, black_box};
use machband::light::{Bits, Depth, Quantizer, Transfer};
use machband::stimulus::{MachBand, ParameterValue, Stimulus, StimulusColor};

const SIZE: u32 = 1024;
const BYTES: usize = SIZE as usize * SIZE as usize * 3;

fn main() {
    divan::main();
}

fn quantizer() -> Quantizer {
    Quantizer::new(&Transfer::Srgb.into(), Bits::Eight)
}

/// The stimulus of the target, at several orientations.
fn band(orientation_deg: f64) -> MachBand {
    MachBand { width: 0.4, depth: Depth::Finite(3), orientation_deg, ..MachBand::default() }
}

fn bench_codes(bencher: Bencher<'_, '_>, stimulus: impl Into<Stimulus>) {
    let (stimulus, quantizer) = (stimulus.into(), quantizer());
    bencher.counter(BytesCount::new(BYTES)).bench(|| black_box(&stimulus).codes(SIZE, &quantizer));
}

/// Memory allocated and freed every time, as for a stimulus.
#[divan::bench_group(sample_count = 200, sample_size = 1)]
mod codes {
    use super::*;

    /// The baseline for all others.
    #[divan::bench]
    fn fill(bencher: Bencher<'_, '_>) {
        bencher.counter(BytesCount::new(BYTES)).bench(|| vec![black_box(137u8); BYTES]);
    }

    /// The same in preallocated memory.
    #[divan::bench]
    fn fill_again(bencher: Bencher<'_, '_>) {
        let mut codes = vec![1u8; BYTES];
        bencher.counter(BytesCount::new(BYTES)).bench_local(|| black_box(&mut codes).fill(black_box(137)));
    }

    #[divan::bench(args = [0.0, 33.0, 45.0, 89.0, 89.9, 90.0])]
    fn orientation(bencher: Bencher<'_, '_>, orientation_deg: f64) {
        bench_codes(bencher, band(orientation_deg));
    }

    #[divan::bench(args = ["1", "32", "inf"])]
    fn depth_at_33(bencher: Bencher<'_, '_>, depth: &str) {
        let depth = depth.parse().expect("a depth");
        bench_codes(bencher, MachBand { depth, ..band(33.0) });
    }

    /// Three channels of different weight, full range: as many steps as there can be.
    #[divan::bench]
    fn most_steps_at_33(bencher: Bencher<'_, '_>) {
        let color = "1,0.9,0.8".parse::<StimulusColor>().expect("weights within 0…1");
        bench_codes(bencher, MachBand { low: 0.0, high: 1.0, color, ..band(33.0) });
    }

    /// From color to color.
    #[divan::bench(args = ["rgb", "hsv", "lab"])]
    fn two_colors_at_33(bencher: Bencher<'_, '_>, space: &str) {
        let color_high = Some("hsv:200,0.8,1".parse().expect("a color"));
        let space = space.parse().expect("a space");
        bench_codes(bencher, MachBand { color_high, space, ..band(33.0) });
    }

    #[divan::bench(args = ["chevreul", "cornsweet", "shaded-cylinder"])]
    fn other_kinds_at_33(bencher: Bencher<'_, '_>, kind: &str) {
        let mut stimulus = Stimulus::default_of(kind).expect("a kind");
        stimulus.set("orientation_deg", &ParameterValue::Number(33.0)).expect("an orientation");
        bench_codes(bencher, stimulus);
    }
}

/// Every pixel computed separately, as in the definition.
#[divan::bench_group(sample_count = 20, sample_size = 1)]
mod reference {
    use super::*;

    #[divan::bench]
    fn linear_at_33(bencher: Bencher<'_, '_>) {
        let band = Stimulus::from(band(33.0));
        bencher.bench(|| black_box(&band).linear(SIZE));
    }

    #[divan::bench]
    fn linear_and_quantize_at_33(bencher: Bencher<'_, '_>) {
        let (band, quantizer) = (Stimulus::from(band(33.0)), quantizer());
        bencher.counter(BytesCount::new(BYTES)).bench(|| quantizer.quantize(&black_box(&band).linear(SIZE)));
    }

    #[divan::bench(args = [Bits::Eight, Bits::Sixteen])]
    fn new_quantizer(bencher: Bencher<'_, '_>, bits: Bits) {
        bencher.bench(|| Quantizer::new(black_box(&Transfer::Srgb.into()), bits));
    }
}
