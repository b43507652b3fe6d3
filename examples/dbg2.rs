use machband::analysis::{counts::MeasuredBuilder, terms::Terms, *};
fn main() {
    let mut r = csv::Reader::from_path("/tmp/try/a/counts.csv").unwrap();
    let h: Vec<String> = r.headers().unwrap().iter().map(str::to_owned).collect();
    let l = h.len() - 2;
    let mut b = MeasuredBuilder::new(&h[1..l]);
    for rec in r.records() {
        let rec = rec.unwrap();
        let c: Vec<&str> = rec.iter().collect();
        b.add_counts(c[0], &c[1..l], c[l], c[l + 1].parse().unwrap()).unwrap();
    }
    let m = b.finish();
    let spec = ModelSpec {
        random: Random::Subject,
        slopes: Slopes::Independent,
        ..ModelSpec::new(Terms::parse("width,depth,orientation_deg").unwrap())
    };
    let t = std::time::Instant::now();
    let rep = fit_with_tests(&m.counts, &spec).unwrap();
    println!("{:?} {:?}", t.elapsed(), rep.terms);
    let t = std::time::Instant::now();
    let f = fit(&m.counts, &spec).unwrap();
    println!("{:?} it {} grad {:e}", t.elapsed(), f.iterations, f.gradient);
}
