//! The same analysis by command.

use std::path::PathBuf;

use crate::{
    analysis::{Link, Options, Random},
    store::ratings::Reading,
};

/// `machband analyze` of these files with these options.
pub fn analyze(paths: &[PathBuf], how: &Reading, options: &Options, out: &str) -> String {
    let mut words = vec!["machband".to_owned(), "analyze".to_owned()];
    words.extend(paths.iter().map(|path| path.display().to_string()));
    let mut say = |name: &str, value: Option<String>| {
        words.extend(value.into_iter().flat_map(|value| [name.to_owned(), value]));
    };
    say("--subject", how.subject.clone());
    say("--response", how.response.clone());
    say("--count", how.count.clone());
    say("--factors", how.factors.as_ref().map(|factors| factors.join(",")));
    say("--terms", options.terms.as_ref().map(ToString::to_string));
    say("--link", (options.link != Link::default()).then(|| options.link.to_string()));
    say("--random", (options.random == Some(Random::None)).then(|| "none".to_owned()));
    say("--quadrature", (options.quadrature != 1).then(|| options.quadrature.to_string()));
    say("--out", Some(out.to_owned()));
    words.extend(how.complete_only.then(|| "--complete-only".to_owned()));
    words.extend(options.scale.then(|| "--scale".to_owned()));
    words.iter().map(|word| quoted(word)).collect::<Vec<_>>().join(" ")
}

/// A word as a POSIX shell takes it.
fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_alphanumeric() || "-_./:,=@%+".contains(c);
    let is_plain = !word.is_empty() && word.chars().all(plain);
    if is_plain { word.to_owned() } else { format!("'{}'", word.replace('\'', r"'\''")) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::terms::Terms;

    #[test]
    fn only_what_differs_from_the_default_is_said() {
        let paths = [PathBuf::from("results/tiny"), PathBuf::from("it's here.csv")];
        let plain = analyze(&paths[..1], &Reading::default(), &Options::default(), "out");
        assert_eq!(plain, "machband analyze results/tiny --out out");
        let how = Reading { response: Some("score".to_owned()), complete_only: true, ..Reading::default() };
        let terms = Terms::parse("width*num:inv_n").ok();
        let options = Options { terms, link: Link::Probit, scale: true, ..Options::default() };
        assert_eq!(
            analyze(&paths, &how, &options, "out"),
            r"machband analyze results/tiny 'it'\''s here.csv' --response score --terms width,num:inv_n,width:num:inv_n --link probit --out out --complete-only --scale"
        );
    }
}
