# The power of one design, estimated in R: tests/golden/power.csv.
#
#   apt-get install --no-install-recommends r-base-core r-cran-ordinal
#   Rscript scripts/golden_power.R > tests/golden/power.csv
#
# The observer repeats experiments/observers/paper.toml with oblique = 0.6; the design is tests/golden/power.toml. This
# script uses neither the program's code nor its random numbers.
#
# With fewer than 12 people, the likelihood ratio is compared with those of studies without the effect; otherwise with the
# chi-squared distribution. For two levels, Friedman's exact test is the sign test of the differences between the means.
suppressPackageStartupMessages(library(ordinal))
set.seed(20240611)
design <- expand.grid(orientation_deg = c(0, 45), width = c(0.1, 0.4), depth = c(1, 3), repetition = 1:4)
predictor <- with(design, 6 / depth - 0.7 * log2(width / 0.05))

fit <- function(formula, rows) suppressWarnings(clmm(formula, data = rows, weights = rows$count, Hess = FALSE))

# The likelihood ratio, the estimate and the probability of Friedman's test in one study.
study <- function(people, oblique) {
  rows <- do.call(rbind, lapply(seq_len(people), function(person) {
    latent <- predictor + oblique * abs(sin(2 * design$orientation_deg * pi / 180)) + rnorm(1, 0, 0.6) + rlogis(nrow(design))
    rating <- findInterval(latent, c(0, 1.5, 3.5))
    lapse <- runif(nrow(design)) < 0.01
    rating[lapse] <- sample(0:3, sum(lapse), replace = TRUE)
    cbind(design, person = person, rating = rating)
  }))
  means <- tapply(rows$rating, list(rows$person, rows$orientation_deg), mean)
  differences <- means[, 2] - means[, 1]
  differences <- differences[differences != 0]
  friedman <- if (length(differences)) binom.test(sum(differences > 0), length(differences))$p.value else NA
  # Equal ratings as counts: the likelihood is the same, the fit faster.
  rows <- aggregate(list(count = rep(1, nrow(rows))), rows[c("orientation_deg", "width", "depth", "person", "rating")], sum)
  for (name in c("orientation_deg", "width", "depth", "person")) rows[[name]] <- factor(rows[[name]])
  rows$rating <- factor(rows$rating, ordered = TRUE)
  full <- fit(rating ~ width + depth + orientation_deg + (1 | person), rows)
  less <- fit(rating ~ width + depth + (1 | person), rows)
  c(2 * (full$logLik - less$logLik), full$beta[["orientation_deg45"]], friedman)
}

version <- paste0(R.version.string, ", ordinal ", packageVersion("ordinal"))
cat("# Power at alpha 0.05 by ", version, ", scripts/golden_power.R.\n", sep = "")
cat("participants,test,studies,found,median_estimate\n")
for (people in c(6, 12, 16)) {
  studies <- if (people < 12) 1000 else 500
  results <- replicate(studies, study(people, 0.6))
  p <- if (people < 12) {
    without <- replicate(studies, study(people, 0)[1])
    sapply(results[1, ], function(ratio) (1 + sum(without >= ratio)) / (1 + studies))
  } else {
    pchisq(results[1, ], 1, lower.tail = FALSE)
  }
  cat(people, ",likelihood-ratio,", studies, ",", sum(p < 0.05), ",", signif(median(results[2, ]), 6), "\n", sep = "")
  cat(people, ",friedman,", studies, ",", sum(results[3, ] < 0.05, na.rm = TRUE), ",\n", sep = "")
}
