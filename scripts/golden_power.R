# The power of one design, estimated in R: tests/golden/power.csv.
#
#   apt-get install --no-install-recommends r-base-core r-cran-ordinal
#   Rscript scripts/golden_power.R [STUDIES] > tests/golden/power.csv
#
# The observer repeats experiments/observers/paper.toml with oblique = 0.6; the design is tests/golden/power.toml. This
# script uses neither the program's code nor its random numbers.
#
# With fewer than 12 people, the likelihood ratio is compared with those of studies without the effect; otherwise with the
# chi-squared distribution. For two levels, Friedman's exact test is the sign test of the differences between the means.
#
# Where slope_sd is not 0, every person deviates at each of the two orientations by an independent normal value with this
# standard deviation. Each of these studies is analyzed with and without a random slope of the orientation,
# (1 | person:orientation_deg), which is in the model with and in the model without the effect.
suppressPackageStartupMessages(library(ordinal))
given <- commandArgs(trailingOnly = TRUE)
studies <- if (length(given)) as.integer(given[1]) else 500
design <- expand.grid(orientation_deg = c(0, 45), width = c(0.1, 0.4), depth = c(1, 3), repetition = 1:4)
predictor <- with(design, 6 / depth - 0.7 * log2(width / 0.05))

# The ratings of one study, a row each.
simulated <- function(people, oblique, slope_sd = 0) {
  do.call(rbind, lapply(seq_len(people), function(person) {
    own <- if (slope_sd > 0) rnorm(2, 0, slope_sd)[1 + (design$orientation_deg == 45)] else 0
    effect <- oblique * abs(sin(2 * design$orientation_deg * pi / 180))
    latent <- predictor + effect + rnorm(1, 0, 0.6) + own + rlogis(nrow(design))
    rating <- findInterval(latent, c(0, 1.5, 3.5))
    lapse <- runif(nrow(design)) < 0.01
    rating[lapse] <- sample(0:3, sum(lapse), replace = TRUE)
    cbind(design, person = person, rating = rating)
  }))
}
# The probability of Friedman's test.
friedman <- function(rows) {
  means <- tapply(rows$rating, list(rows$person, rows$orientation_deg), mean)
  differences <- means[, 2] - means[, 1]
  differences <- differences[differences != 0]
  if (length(differences)) binom.test(sum(differences > 0), length(differences))$p.value else 1
}
# The likelihood ratio of the orientation, given the random effects.
tested <- function(rows, random) {
  # Equal ratings as counts: the likelihood is the same, the fit faster.
  rows <- aggregate(list(count = rep(1, nrow(rows))), rows[c("orientation_deg", "width", "depth", "person", "rating")], sum)
  for (name in c("orientation_deg", "width", "depth", "person")) rows[[name]] <- factor(rows[[name]])
  rows$rating <- factor(rows$rating, ordered = TRUE)
  fit <- function(terms) {
    formula <- as.formula(paste("rating ~", terms, "+", random))
    suppressWarnings(clmm(formula, data = rows, weights = rows$count, Hess = FALSE))
  }
  found <- try({
    full <- fit("width + depth + orientation_deg")
    2 * (full$logLik - fit("width + depth")$logLik)
  }, silent = TRUE)
  if (is.numeric(found)) found else NA
}

version <- paste0(R.version.string, ", ordinal ", packageVersion("ordinal"))
cat("# Power at alpha 0.05 by ", version, ", scripts/golden_power.R.\n", sep = "")
cat("participants,slope_sd,slopes,test,studies,found\n")
line <- function(people, slope_sd, slopes, test, p)
  cat(people, ",", slope_sd, ",", slopes, ",", test, ",", sum(!is.na(p)), ",", sum(p < 0.05, na.rm = TRUE), "\n",
      sep = "")

set.seed(20240611)
for (people in c(6, 12, 16)) {
  count <- if (people < 12) 2 * studies else studies
  results <- replicate(count, {
    rows <- simulated(people, 0.6)
    c(tested(rows, "(1 | person)"), friedman(rows))
  })
  p <- if (people < 12) {
    without <- replicate(count, tested(simulated(people, 0), "(1 | person)"))
    sapply(results[1, ], function(ratio) (1 + sum(without >= ratio)) / (1 + count))
  } else {
    pchisq(results[1, ], 1, lower.tail = FALSE)
  }
  line(people, 0, "none", "likelihood-ratio", p)
  line(people, 0, "none", "friedman", results[2, ])
}

set.seed(20261124)
slope_sd <- 0.5
results <- replicate(studies, {
  rows <- simulated(14, 0.6, slope_sd)
  c(tested(rows, "(1 | person) + (1 | person:orientation_deg)"), tested(rows, "(1 | person)"))
})
line(14, slope_sd, "independent", "likelihood-ratio", pchisq(results[1, ], 1, lower.tail = FALSE))
line(14, slope_sd, "none", "likelihood-ratio", pchisq(results[2, ], 1, lower.tail = FALSE))
