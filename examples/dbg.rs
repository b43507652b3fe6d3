use machband::analysis::{counts::MeasuredBuilder, terms::Terms, *};
use std::collections::BTreeMap;
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let mut r = csv::Reader::from_path(&a[1]).unwrap();
    let h: Vec<String> = r.headers().unwrap().iter().map(str::to_owned).collect();
    let l = h.len() - 2;
    let mut b: BTreeMap<usize, MeasuredBuilder> = BTreeMap::new();
    for rec in r.records() {
        let rec = rec.unwrap();
        let s: usize = rec[0].parse().unwrap();
        if s > a[2].parse().unwrap() {
            break;
        }
        let c: Vec<&str> = rec.iter().collect();
        b.entry(s)
            .or_insert_with(|| MeasuredBuilder::new(&h[2..l]).with_categories(&["0", "1", "2", "3"]))
            .add_counts(c[1], &c[2..l], c[l], c[l + 1].parse().unwrap())
            .unwrap();
    }
    for (s, m) in b {
        let m = m.finish();
        let o = Options { resampling: Resampling { draws: 199, seed: 1 }, checks: false, ..Options::default() };
        let res = analyze(m, &o);
        if let Ok(rep) = &res.model {
            let t = &rep.terms[0];
            let ra = rep.model.random.as_ref();
            println!(
                "{s} lr {:.2} p {:?} draws {:?} sd {:?} slopes {:?} coef {:?} odds {:?} notes {:?}",
                t.lr.unwrap_or(f64::NAN),
                t.p,
                t.draws,
                ra.map(|r| (r.sd, r.interval)),
                ra.map(|r| r.slopes.iter().map(|s| (s.sd, s.interval)).collect::<Vec<_>>()),
                rep.model.coefficients.iter().map(|c| (c.estimate, c.se, c.interval)).collect::<Vec<_>>(),
                rep.proportional_odds.iter().map(|t| (t.lr, t.p)).collect::<Vec<_>>(),
                rep.model.notes
            );
            let _ = Terms::default();
        }
    }
}
