# The power of one design, estimated in R: tests/golden/power.csv.
#
#   apt-get install --no-install-recommends r-base-core r-cran-ordinal
#   Rscript scripts/golden_power.R > tests/golden/power.csv
#
# The observer repeats experiments/observers/paper.toml with oblique = 0.6; the design is tests/golden/power.toml. This
# script uses neither the program's code nor its random numbers.
suppressPackageStartupMessages(library(ordinal))
set.seed(20240611)
studies <- 1000
design <- expand.grid(orientation_deg = c(0, 45), width = c(0.1, 0.4), depth = c(1, 3), repetition = 1:4)
predictor <- with(design, 6 / depth - 0.7 * log2(width / 0.05) + 0.6 * abs(sin(2 * orientation_deg * pi / 180)))

study <- function(people) {
  rows <- do.call(rbind, lapply(seq_len(people), function(person) {
    latent <- predictor + rnorm(1, 0, 0.6) + rlogis(nrow(design))
    rating <- findInterval(latent, c(0, 1.5, 3.5))
    lapse <- runif(nrow(design)) < 0.01
    rating[lapse] <- sample(0:3, sum(lapse), replace = TRUE)
    cbind(design, person = person, rating = rating)
  }))
  for (name in c("orientation_deg", "width", "depth", "person")) rows[[name]] <- factor(rows[[name]])
  rows$rating <- factor(rows$rating, ordered = TRUE)
  full <- suppressWarnings(clmm(rating ~ width + depth + orientation_deg + (1 | person), data = rows))
  less <- suppressWarnings(clmm(rating ~ width + depth + (1 | person), data = rows))
  p <- pchisq(2 * (full$logLik - less$logLik), 1, lower.tail = FALSE)
  means <- tapply(as.numeric(rows$rating), list(rows$person, rows$orientation_deg), mean)
  c(p, friedman.test(means)$p.value, full$beta[["orientation_deg45"]])
}

version <- paste0(R.version.string, ", ordinal ", packageVersion("ordinal"))
cat("# Power at alpha 0.05 by ", version, ", scripts/golden_power.R.\n", sep = "")
cat("participants,test,studies,found,median_estimate\n")
for (people in c(3, 6)) {
  results <- replicate(studies, study(people))
  found <- rowSums(results[1:2, ] < 0.05, na.rm = TRUE)
  cat(people, ",likelihood-ratio,", studies, ",", found[1], ",", signif(median(results[3, ]), 6), "\n", sep = "")
  cat(people, ",friedman,", studies, ",", found[2], ",\n", sep = "")
}
