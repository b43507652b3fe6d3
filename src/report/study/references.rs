//! The literature behind the methods.

use maud::{Markup, html};

/// A publication.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Reference {
    /// Names as a text cites them, `McCullagh (1980)`.
    pub short: &'static str,
    /// The entry, without the address.
    pub entry: &'static str,
    /// Digital object identifier or other address.
    pub address: Option<&'static str>,
}

macro_rules! references {
    ($($name:ident: $short:literal, $entry:literal $(, $address:literal)?;)*) => {
        $(pub(crate) const $name: Reference =
            Reference { short: $short, entry: $entry, address: first(&[$($address)?]) };)*
    };
}

const fn first(addresses: &[&'static str]) -> Option<&'static str> {
    if addresses.is_empty() { None } else { Some(addresses[0]) }
}

references! {
    BANGAY: "Bangay",
        "Bangay, S. Methods of Reducing the Visibility of Mach Bands during Gouraud Shading. Rhodes University.";
    BARTEN: "Barten (2003)",
        "Barten, P. G. J. (2003). Formula for the contrast sensitivity of the human eye. Proceedings of SPIE, 5294, 231–238.",
        "https://doi.org/10.1117/12.537476";
    BURKNER: "Bürkner & Vuorre (2019)",
        "Bürkner, P.-C., & Vuorre, M. (2019). Ordinal regression models in psychology: A tutorial. Advances in Methods and Practices in Psychological Science, 2(1), 77–101.",
        "https://doi.org/10.1177/2515245918823199";
    CHRISTENSEN: "Christensen (2022)",
        "Christensen, R. H. B. (2022). ordinal – Regression Models for Ordinal Data. R package version 2022.11-16.",
        "https://CRAN.R-project.org/package=ordinal";
    COHEN: "Cohen (1968)",
        "Cohen, J. (1968). Weighted kappa: Nominal scale agreement with provision for scaled disagreement or partial credit. Psychological Bulletin, 70(4), 213–220.",
        "https://doi.org/10.1037/h0026256";
    EFRON: "Efron & Tibshirani (1993)",
        "Efron, B., & Tibshirani, R. J. (1993). An Introduction to the Bootstrap. Chapman & Hall.",
        "https://doi.org/10.1201/9780429246593";
    FRIEDMAN: "Friedman (1937)",
        "Friedman, M. (1937). The use of ranks to avoid the assumption of normality implicit in the analysis of variance. Journal of the American Statistical Association, 32(200), 675–701.",
        "https://doi.org/10.1080/01621459.1937.10503522";
    HAYES: "Hayes & Krippendorff (2007)",
        "Hayes, A. F., & Krippendorff, K. (2007). Answering the call for a standard reliability measure for coding data. Communication Methods and Measures, 1(1), 77–89.",
        "https://doi.org/10.1080/19312450709336664";
    HOLM: "Holm (1979)",
        "Holm, S. (1979). A simple sequentially rejective multiple test procedure. Scandinavian Journal of Statistics, 6(2), 65–70.";
    KENDALL: "Kendall & Babington Smith (1939)",
        "Kendall, M. G., & Babington Smith, B. (1939). The problem of m rankings. The Annals of Mathematical Statistics, 10(3), 275–287.",
        "https://doi.org/10.1214/aoms/1177732186";
    KRIPPENDORFF: "Krippendorff (2019)",
        "Krippendorff, K. (2019). Content Analysis: An Introduction to Its Methodology (4th ed.). SAGE.",
        "https://doi.org/10.4135/9781071878781";
    LANDIS: "Landis & Koch (1977)",
        "Landis, J. R., & Koch, G. G. (1977). The measurement of observer agreement for categorical data. Biometrics, 33(1), 159–174.",
        "https://doi.org/10.2307/2529310";
    LIDDELL: "Liddell & Kruschke (2018)",
        "Liddell, T. M., & Kruschke, J. K. (2018). Analyzing ordinal data with metric models: What could possibly go wrong? Journal of Experimental Social Psychology, 79, 328–348.",
        "https://doi.org/10.1016/j.jesp.2018.08.009";
    LIU: "Liu & Pierce (1994)",
        "Liu, Q., & Pierce, D. A. (1994). A note on Gauss–Hermite quadrature. Biometrika, 81(3), 624–629.",
        "https://doi.org/10.1093/biomet/81.3.624";
    MCCULLAGH: "McCullagh (1980)",
        "McCullagh, P. (1980). Regression models for ordinal data. Journal of the Royal Statistical Society: Series B, 42(2), 109–142.",
        "https://doi.org/10.1111/j.2517-6161.1980.tb01109.x";
    MORRONE: "Morrone & Burr (1988)",
        "Morrone, M. C., & Burr, D. C. (1988). Feature detection in human vision: A phase-dependent energy model. Proceedings of the Royal Society of London B, 235(1280), 221–245.",
        "https://doi.org/10.1098/rspb.1988.0073";
    NILI: "Nili et al. (2014)",
        "Nili, H., Wingfield, C., Walther, A., Su, L., Marslen-Wilson, W., & Kriegeskorte, N. (2014). A toolbox for representational similarity analysis. PLoS Computational Biology, 10(4), e1003553.",
        "https://doi.org/10.1371/journal.pcbi.1003553";
    STREITBERG: "Streitberg & Röhmel (1986)",
        "Streitberg, B., & Röhmel, J. (1986). Exact distributions for permutation and rank tests: An introduction to some recently published algorithms. Statistical Software Newsletter, 12(1), 10–17.";
    WILCOXON: "Wilcoxon (1945)",
        "Wilcoxon, F. (1945). Individual comparisons by ranking methods. Biometrics Bulletin, 1(6), 80–83.",
        "https://doi.org/10.2307/3001968";
}

/// The list, by name, each once.
pub(crate) fn section(mut used: Vec<Reference>) -> Markup {
    used.sort_unstable_by_key(|reference| reference.entry);
    used.dedup();
    html! {
        ul.references {
            @for reference in used {
                li {
                    (reference.entry)
                    @if let Some(address) = reference.address { " " a href=(address) { (address) } }
                }
            }
        }
    }
}
