# The power of one design when people differ in the effect, estimated in R: tests/golden/power_slopes.csv.
#
#   apt-get install --no-install-recommends r-base-core r-cran-ordinal
#   Rscript scripts/golden_power_slopes.R [STUDIES] > tests/golden/power_slopes.csv
#
# The observer and the design are those of scripts/golden_power.R, with 14 people. In addition, every person deviates at
# each of the two orientations by an independent normal value (SD 0.5). Each study is analyzed with and without a random
# slope of the orientation, (1 | person:orientation_deg); it is in the model with and in the model without the effect.
# This script uses neither the program's code nor its random numbers.
suppressPackageStartupMessages(library(ordinal))
set.seed(20261124)
given <- commandArgs(trailingOnly = TRUE)
studies <- if (length(given)) as.integer(given[1]) else 500
people <- 14
slope_sd <- 0.5
design <- expand.grid(orientation_deg = c(0, 45), width = c(0.1, 0.4), depth = c(1, 3), repetition = 1:4)
predictor <- with(design, 6 / depth - 0.7 * log2(width / 0.05) + 0.6 * abs(sin(2 * orientation_deg * pi / 180)))

fit <- function(formula, rows) suppressWarnings(clmm(formula, data = rows, weights = rows$count, Hess = FALSE))
study <- function(number) {
  rows <- do.call(rbind, lapply(seq_len(people), function(person) {
    own <- rnorm(2, 0, slope_sd)[1 + (design$orientation_deg == 45)]
    latent <- predictor + rnorm(1, 0, 0.6) + own + rlogis(nrow(design))
    rating <- findInterval(latent, c(0, 1.5, 3.5))
    lapse <- runif(nrow(design)) < 0.01
    rating[lapse] <- sample(0:3, sum(lapse), replace = TRUE)
    cbind(design, person = person, rating = rating)
  }))
  # Equal ratings as counts: the likelihood is the same, the fit faster.
  rows <- aggregate(list(count = rep(1, nrow(rows))), rows[c("orientation_deg", "width", "depth", "person", "rating")], sum)
  for (name in c("orientation_deg", "width", "depth", "person")) rows[[name]] <- factor(rows[[name]])
  rows$rating <- factor(rows$rating, ordered = TRUE)
  test <- function(full, less) c(pchisq(2 * (full$logLik - less$logLik), 1, lower.tail = FALSE), full$beta[["orientation_deg45"]])
  slopes <- try(test(fit(rating ~ width + depth + orientation_deg + (1 | person) + (1 | person:orientation_deg), rows),
                     fit(rating ~ width + depth + (1 | person) + (1 | person:orientation_deg), rows)), silent = TRUE)
  intercepts <- try(test(fit(rating ~ width + depth + orientation_deg + (1 | person), rows),
                         fit(rating ~ width + depth + (1 | person), rows)), silent = TRUE)
  if (number %% 25 == 0) message(number, " studies, ", round(proc.time()[["elapsed"]]), " s")
  c(if (is.numeric(slopes)) slopes else c(NA, NA), if (is.numeric(intercepts)) intercepts else c(NA, NA))
}

results <- sapply(seq_len(studies), study)
version <- paste0(R.version.string, ", ordinal ", packageVersion("ordinal"))
cat("# Power at alpha 0.05 by ", version, ", scripts/golden_power_slopes.R. slope_sd: the deviations of a person at each orientation.\n", sep = "")
cat("participants,slope_sd,analysis,studies,found,median_estimate\n")
line <- function(analysis, p, estimate) cat(people, ",", slope_sd, ",", analysis, ",", sum(!is.na(p)), ",", sum(p < 0.05, na.rm = TRUE), ",",
                                            signif(median(estimate, na.rm = TRUE), 6), "\n", sep = "")
line("random-slopes", results[1, ], results[2, ])
line("random-intercepts", results[3, ], results[4, ])
message("Fits that failed: ", sum(is.na(results[1, ])), " with random slopes, ", sum(is.na(results[3, ])), " with random intercepts")
message("p < 0.05 with random intercepts but not with random slopes: ", sum(results[3, ] < 0.05 & results[1, ] >= 0.05, na.rm = TRUE))
