# Reference values for cumulative-link mixed models with random slopes from R's ordinal package: tests/golden/ordinal/slopes.csv
# and the data sets in data_slopes.csv.
#
#   apt-get install --no-install-recommends r-base-core r-cran-ordinal r-cran-lme4
#   Rscript scripts/golden_slopes.R [FOLDER]
#
# FOLDER (tests/golden/ordinal unless given) must contain the data of scripts/golden_ordinal.py. The likelihood is the
# package's Laplace approximation for arbitrary random effects. clmm stops early, so this script adds Newton steps on it,
# with extrapolated numerical derivatives. Where a standard deviation is 0, clmm found 0, the likelihood is lower on both
# sides, and the other parameters are at their optimum.
suppressPackageStartupMessages(library(ordinal))
suppressPackageStartupMessages(library(lme4))
given <- commandArgs(trailingOnly = TRUE)
folder <- if (length(given)) given[1] else "tests/golden/ordinal"

# ---- Simulated data -----------------------------------------------------------------------------------------------

RNGkind("Mersenne-Twister", "Inversion", "Rejection")
categories <- function(latent, thresholds, link)
  findInterval(latent + if (link == "logit") rlogis(length(latent)) else rnorm(length(latent)), thresholds)
data_file <- file(file.path(folder, "data_slopes.csv"), "w")
writeLines(paste0("# Simulated by scripts/golden_slopes.R, ", R.version.string, "."), data_file)
write_data <- function(name, rows, text) {
  factors <- setdiff(names(rows), c("subject", "rating"))
  counts <- aggregate(list(count = rep(1, nrow(rows))), rows[c("subject", factors, "rating")], sum)
  counts <- counts[do.call(order, c(unname(as.list(counts[c("subject", factors, "rating")])), list(method = "radix"))), ]
  writeLines(paste0("## ", name, ": ", text), data_file)
  write.csv(counts, data_file, row.names = FALSE, quote = FALSE)
}
people <- function(count) sprintf("S%02d", seq_len(count))
# An independent deviation of every person at every level.
deviations <- function(person, level, sd) {
  table <- matrix(rnorm(length(unique(person)) * length(unique(level)), 0, sd), length(unique(person)))
  table[cbind(match(person, unique(person)), match(level, unique(level)))]
}
# An intercept and a slope of every person with a given correlation.
pairs_of <- function(count, sds, correlation) {
  z <- matrix(rnorm(2 * count), count)
  cbind(sds[1] * z[, 1], sds[2] * (correlation * z[, 1] + sqrt(1 - correlation^2) * z[, 2]))
}

set.seed(11)
d <- expand.grid(trial = 1:8, width = c("a", "b", "c"), subject = people(12), stringsAsFactors = FALSE)
latent <- rnorm(12)[match(d$subject, people(12))] + deviations(d$subject, d$width, 0.8) + c(a = 0, b = 0.6, c = 1.2)[d$width]
d$rating <- categories(latent, c(-1, 0.5, 2), "logit")
write_data("slopes1", d[c("subject", "width", "rating")], "12 subjects who differ at each of three widths (SD 0.8), four categories, logit")

set.seed(12)
d <- expand.grid(trial = 1:5, depth = 1:3, width = c("a", "b"), subject = people(10), stringsAsFactors = FALSE)
latent <- 0.8 * rnorm(10)[match(d$subject, people(10))] + deviations(d$subject, d$width, 0.6) + deviations(d$subject, d$depth, 0.7) +
  c(a = 0, b = 0.5)[d$width] - 0.3 * d$depth
d$rating <- categories(latent, c(-1.2, 0.3), "probit")
write_data("slopes2", d[c("subject", "width", "depth", "rating")], "10 subjects who differ in two factors (SD 0.6 and 0.7), three categories, probit")

set.seed(13)
d <- expand.grid(trial = 1:6, x = c(0, 1, 2, 4), subject = people(16), stringsAsFactors = FALSE)
own <- pairs_of(16, c(1, 0.5), 0.5)[match(d$subject, people(16)), ]
d$rating <- categories(own[, 1] + (0.4 + own[, 2]) * (d$x - 1.75), c(-2, -0.7, 0.6, 2), "logit") + 1
write_data("slopes3", d[c("subject", "x", "rating")], "16 subjects who differ in a slope (SD 0.5, correlation 0.5), five categories, logit")

set.seed(14)
d <- do.call(rbind, lapply(people(20), function(s) {
  n <- sample(10:45, 1)
  data.frame(subject = s, side = sample(c("l", "r"), n, TRUE, c(0.6, 0.4)), x = sample(c(-1, -0.25, 0.5, 1.5), n, TRUE, c(4, 3, 2, 1)))
}))
own <- pairs_of(20, c(0.7, 0.6), -0.4)[match(d$subject, people(20)), ]
latent <- own[, 1] + own[, 2] * d$x + deviations(d$subject, d$side, 0.5) + 0.4 * (d$side == "r") + 0.3 * d$x
d$rating <- categories(latent, c(-1, 0, 0.9), "probit")
write_data("slopes4", d[c("subject", "side", "x", "rating")],
           "20 subjects with 10 to 45 ratings who differ in a factor and a slope, four categories, probit")

set.seed(15)
d <- expand.grid(trial = 1:20, width = c("a", "b", "c"), subject = people(8), stringsAsFactors = FALSE)
latent <- rnorm(8)[match(d$subject, people(8))] + deviations(d$subject, d$width, 0.7) + c(a = 0, b = 0.3, c = -0.6)[d$width]
d$rating <- categories(latent, c(-0.8, 0.9), "logit")
write_data("slopes5", d[c("subject", "width", "rating")], "8 subjects who differ at each of three widths (SD 0.7), three categories, logit")

set.seed(16)
d <- expand.grid(trial = 1:8, width = c("a", "b", "c"), subject = people(15), stringsAsFactors = FALSE)
latent <- rnorm(15)[match(d$subject, people(15))] + deviations(d$subject, d$width, 0.9) + c(a = 0, b = 0.5, c = 1)[d$width]
d$rating <- categories(latent, 0.3, "logit")
write_data("slopes6", d[c("subject", "width", "rating")], "15 subjects who differ at each of three widths (SD 0.9), two categories, logit")

set.seed(17)
d <- expand.grid(trial = 1:10, side = c("l", "r"), width = c("a", "b", "c", "d"), subject = people(16), stringsAsFactors = FALSE)
latent <- rnorm(16)[match(d$subject, people(16))] + deviations(d$subject, d$width, 0.6) + deviations(d$subject, d$side, 0.5) +
  c(a = 0, b = 0.2, c = 0.5, d = 0.9)[d$width] - 0.3 * (d$side == "r")
d$rating <- categories(latent, c(-2, -0.7, 0.5, 1.9), "logit")
write_data("slopes7", d[c("subject", "width", "side", "rating")], "16 subjects who differ in two factors (SD 0.6 and 0.5), five categories, logit")

set.seed(18)
d <- expand.grid(trial = 1:15, width = c("a", "b", "c"), subject = people(20), stringsAsFactors = FALSE)
own <- cbind(a = 0, b = 0.8 * rnorm(20), c = 1.1 * rnorm(20))
latent <- rnorm(20)[match(d$subject, people(20))] + own[cbind(match(d$subject, people(20)), match(d$width, c("a", "b", "c")))] +
  c(a = 0, b = 0.4, c = -0.5)[d$width]
d$rating <- categories(latent, c(-1.4, 0, 1.3), "logit")
write_data("slopes8", d[c("subject", "width", "rating")],
           "20 subjects who differ in two contrasts with the first width (SD 0.8 and 1.1), four categories, logit")

# Items crossed with subjects: of one width each, or shown at every width.
set.seed(19)
d <- expand.grid(item = sprintf("i%02d", 1:14), subject = people(12), stringsAsFactors = FALSE)
d$width <- ifelse(as.numeric(substr(d$item, 2, 3)) %% 2 == 1, "a", "b")
latent <- rnorm(12)[match(d$subject, people(12))] + deviations(d$subject, d$width, 0.8) + 0.8 * rnorm(14)[match(d$item, unique(d$item))] +
  c(a = 0, b = 1)[d$width]
d$rating <- categories(latent, c(-1, 0.5, 2), "logit")
write_data("slopes9", d[c("subject", "width", "item", "rating")], "12 subjects rate 14 items of one width each (SD 0.8), four categories, logit")

set.seed(20)
d <- expand.grid(trial = 1:2, x = c(0, 1, 2), side = c("l", "r"), item = sprintf("i%02d", 1:8), subject = people(9), stringsAsFactors = FALSE)
d <- d[runif(nrow(d)) < 0.8, ]
latent <- 0.9 * rnorm(9)[match(d$subject, people(9))] + deviations(d$subject, d$side, 0.6) + 0.5 * rnorm(9)[match(d$subject, people(9))] * (d$x - 1) +
  0.6 * rnorm(8)[match(d$item, unique(d$item))] + 0.5 * (d$side == "r") + 0.4 * d$x
d$rating <- categories(latent, c(-0.8, 0.4, 1.3), "probit")
write_data("slopes10", d[c("subject", "side", "x", "item", "rating")],
           "9 subjects rate 8 items on two sides at three x (SD 0.6), a fifth missing, four categories, probit")

close(data_file)

# ---- Models -------------------------------------------------------------------------------------------------------

# As in scripts/golden_ordinal.R.
natural <- function(values) {
  values <- unique(values[values != ""])
  numbers <- suppressWarnings(as.numeric(values))
  if (anyNA(numbers)) sort(values, method = "radix") else values[order(numbers)]
}
# The rows of a data set, which follow a line "## NAME: ...".
rows_of <- function(name, file) {
  lines <- readLines(file.path(folder, file))
  starts <- c(grep("^## ", lines), length(lines) + 1)
  begin <- grep(paste0("^## ", name, ": "), lines)
  lines[(begin + 1):(min(starts[starts > begin]) - 1)]
}
read <- function(name) {
  file <- if (startsWith(name, "slopes")) "data_slopes.csv" else "data.csv"
  d <- read.csv(text = rows_of(name, file), colClasses = "character")
  d$count <- as.numeric(d$count)
  d <- d[d$count > 0, ]
  d$rating <- factor(d$rating, levels = natural(d$rating), ordered = TRUE)
  for (v in setdiff(names(d), c("count", "rating"))) {
    numbers <- suppressWarnings(as.numeric(d[[v]]))
    d[[paste0("num_", v)]] <- numbers
    d[[paste0("cen_", v)]] <- numbers - weighted.mean(numbers, d$count)
    d[[v]] <- factor(d[[v]], levels = natural(d[[v]]))
  }
  d
}
sides <- function(terms) gsub(",", " + ", gsub("num:", "num_", terms))
tidy <- function(names) gsub("num_|cen_|subject:", "", names)
random <- function(terms, slopes, items = "") {
  if (items != "") return(paste(random(terms, slopes), paste0("+ (1 | ", items, ")")))
  if (slopes == "none") return("(1 | subject)")
  each <- strsplit(terms, ",")[[1]]
  numeric <- startsWith(each, "num:")
  each <- sub("num:", "cen_", each)
  if (slopes == "correlated") return(paste0("(1 + ", paste(each, collapse = " + "), " | subject)"))
  paste(c("(1 | subject)", ifelse(numeric, paste0("(0 + ", each, " | subject)"), paste0("(1 | subject:", each, ")"))), collapse = " + ")
}

# The gradient and the Hessian from central differences at two distances: the error terms of second order cancel.
derivatives <- function(likelihood, par, distance) {
  around <- function(h) ordinal:::deriv12(function(z) likelihood(par + z * distance), numeric(length(par)), delta = h)
  wide <- around(1)
  narrow <- around(0.5)
  richardson <- function(part) (4 * narrow[[part]] - wide[[part]]) / 3
  list(gradient = richardson("gradient") / distance, Hessian = richardson("Hessian") / outer(distance, distance))
}
# The inner search for the modes may end at the limits of rounding, which clmm reports; noWarn silences this.
tight <- clmm.control(gradTol = 1e-8, maxIter = 100, maxLineIter = 40, innerCtrl = "noWarn")
fit_model <- function(d, link, terms, slopes, items) {
  formula <- as.formula(paste("rating ~", sides(terms), "+", random(terms, slopes, items)))
  arguments <- list(formula, data = d, weights = d$count, link = link, control = tight)
  start <- suppressWarnings(do.call(clmm, arguments))
  rho <- do.call(clmm, c(arguments, doFit = FALSE))
  stopped <- unname(start$optRes$par)
  whole <- stopped
  free <- rep(TRUE, length(whole))
  # A standard deviation that ended at 0, or so close that the likelihood is not lower there.
  if (slopes != "correlated") for (i in (rho$dims$nfepar + 1):length(whole)) {
    zero <- replace(whole, i, 0)
    if (ordinal:::getNLA(rho, zero) <= ordinal:::getNLA(rho, whole) + 1e-7) {
      whole <- zero
      free[i] <- FALSE
    }
  }
  likelihood <- function(par) ordinal:::getNLA(rho, replace(whole, free, par))
  par <- whole[free]
  distance <- pmax(1e-3, 0.01 * abs(par))
  for (step in 1:12) {
    at <- derivatives(likelihood, par, distance)
    # Distances at which the likelihood decreases by about 0.005.
    if (all(diag(at$Hessian) > 0)) distance <- 0.1 / sqrt(diag(at$Hessian))
    if (max(abs(at$gradient)) < 2e-8 && step > 2) break
    move <- solve(at$Hessian, at$gradient)
    before <- likelihood(par)
    while (!isTRUE(likelihood(par - move) <= before + 1e-9)) move <- move / 2
    par <- par - move
  }
  at <- derivatives(likelihood, par, distance)
  closer <- derivatives(likelihood, par, distance / 2)
  errors <- sqrt(diag(solve(at$Hessian)))
  whole[free] <- par
  best <- likelihood(par)
  # Whether 0 is a maximum of the likelihood.
  for (i in which(!free)) stopifnot(ordinal:::getNLA(rho, replace(whole, i, 0.02)) > best)
  list(par = whole, free = free, errors = replace(rep(NA, length(whole)), free, errors), loglik = -best, gradient = at$gradient,
       rho = rho, start = start, agreement = max(abs(errors / sqrt(diag(solve(closer$Hessian))) - 1)), early = whole - stopped)
}

out <- file(file.path(folder, "slopes.csv"), "w")
writeLines(c(
  paste0("# R's ordinal ", packageVersion("ordinal"), ", ", R.version.string, ", by scripts/golden_slopes.R. Data *.binary: lme4 ",
         packageVersion("lme4"), "."),
  "# independent: (1 | subject), for each factor (1 | subject:factor), for each num:x (0 + x - mean(x) | subject). correlated: (1 + term | subject). items: (1 | item).",
  "data,link,terms,slopes,items,quantity,name,value"), out)
put <- function(out, key, quantity, label, value) {
  # A label with a comma is quoted.
  if (grepl(",", label)) label <- paste0("\"", label, "\"")
  writeLines(sprintf("%s,%s,%s,%.15g", key, quantity, label, signif(value, if (quantity == "loglik") 14 else 10)), out)
}
write_fit <- function(out, key, loglik, gradient, thresholds, beta, errors, parts, sd_errors) {
  put(out, key, "loglik", "", loglik)
  put(out, key, "gradient", "", gradient)
  for (j in seq_along(thresholds)) {
    put(out, key, "threshold", names(thresholds)[j], thresholds[j])
    put(out, key, "threshold_se", names(thresholds)[j], errors[j])
  }
  for (j in seq_along(beta)) {
    put(out, key, "coefficient", tidy(names(beta)[j]), beta[j])
    put(out, key, "coefficient_se", tidy(names(beta)[j]), errors[length(thresholds) + j])
  }
  for (part in parts) {
    for (j in seq_along(part$sd)) {
      put(out, key, "sd", part$names[j], part$sd[j])
      if (length(part$sd) == 1 && part$sd > 0) put(out, key, "sd_se", part$names[j], sd_errors[[part$names[j]]])
    }
    for (j in seq_along(part$sd)) for (i in seq_len(j - 1))
      put(out, key, "correlation", paste(part$names[i], part$names[j], sep = ","), part$correlation[i, j])
  }
}
record <- function(name, link, terms, slopes, items = "") {
  d <- read(name)
  began <- proc.time()[["elapsed"]]
  m <- fit_model(d, link, terms, slopes, items)
  n <- m$rho$dims$nfepar
  groups <- names(m$rho$dims$nlev.re)
  ST <- ordinal:::par2ST(m$par[-(1:n)], m$rho$ST)
  parts <- lapply(seq_along(ST), function(i) {
    covariance <- tcrossprod(ST[[i]])
    sd <- sqrt(diag(covariance))
    columns <- colnames(ST[[i]])
    # (1 | subject:width) is a slope of width.
    labels <- if (groups[i] == "subject") tidy(columns) else tidy(groups[i])
    list(names = labels, sd = unname(sd), correlation = covariance / outer(sd, sd))
  })
  sds <- unlist(lapply(parts, `[[`, "sd"))
  label <- paste(name, link, terms, slopes)
  correlations <- unlist(lapply(parts, function(part) part$correlation[lower.tri(part$correlation)]))
  several <- function(values) paste(signif(values, 3), collapse = " ")
  message(sprintf("%-50s loglik %.6f gradient %.1e, SEs at two distances agree to %.1e, clmm was off by %.1e, sd %s, cor %s, %.0f s",
                  label, m$loglik, max(abs(m$gradient)), m$agreement, max(abs(m$early)), several(sds), several(correlations),
                  proc.time()[["elapsed"]] - began))
  if (any(abs(correlations) > 0.98) || max(abs(m$gradient)) > 1e-6) {
    message("  not recorded")
    return(invisible())
  }
  sd_errors <- list()
  if (slopes != "correlated") {
    last <- m$errors[-(1:n)]
    for (i in seq_along(parts)) sd_errors[[parts[[i]]$names[1]]] <- last[i]
  }
  thresholds <- setNames(m$par[seq_along(m$start$alpha)], names(m$start$alpha))
  beta <- setNames(m$par[length(thresholds) + seq_along(m$start$beta)], names(m$start$beta))
  key <- paste0(name, ",", link, ",\"", terms, "\",", slopes, ",", items)
  # The intercept first, then the slopes in the order of the terms.
  place <- sapply(parts, function(part) match(part$names[1], c("(Intercept)", sub("num:", "", strsplit(terms, ",")[[1]]))))
  write_fit(out, key, m$loglik, max(abs(m$gradient)), thresholds, beta, m$errors, parts[order(place)], sd_errors)
  invisible(m)
}
# The same model by lme4, for two categories: P(y > first) = F(-threshold + x beta). Only with the logit link, for which
# lme4's expected curvature is the observed one: with others, its Laplace approximation is a different one.
record_binary <- function(name, terms) {
  link <- "logit"
  d <- read(name)
  d$yes <- as.numeric(d$rating == levels(d$rating)[2])
  formula <- as.formula(paste("yes ~", sides(terms), "+", random(terms, "independent")))
  m <- suppressWarnings(glmer(formula, data = d, weights = d$count, family = binomial(link), nAGQ = 1,
                              control = glmerControl(optimizer = "bobyqa", tolPwrss = 1e-13,
                                                     optCtrl = list(rhobeg = 0.05, rhoend = 1e-9, maxfun = 1e5))))
  deviance <- update(m, devFunOnly = TRUE)
  par <- unname(c(getME(m, "theta"), fixef(m)))
  distance <- rep(0.02, length(par))
  for (step in 1:4) {
    at <- derivatives(function(p) deviance(p) / 2, par, distance)
    if (step < 4) {
      par <- par - solve(at$Hessian, at$gradient)
      distance <- 0.1 * sqrt(diag(solve(at$Hessian)))
    }
  }
  errors <- sqrt(diag(solve(at$Hessian)))
  k <- length(getME(m, "theta"))
  beta <- setNames(par[-(1:k)], names(fixef(m)))
  groups <- names(getME(m, "cnms"))
  labels <- ifelse(groups == "subject", tidy(unlist(getME(m, "cnms"))), tidy(groups))
  names(groups) <- NULL
  parts <- lapply(seq_len(k), function(i) list(names = labels[i], sd = abs(par[i]), correlation = diag(1)))
  place <- match(labels, c("(Intercept)", sub("num:", "", strsplit(terms, ",")[[1]])))
  message(sprintf("%-50s loglik %.6f gradient %.1e, sd %s (lme4)", paste(name, link, terms), -deviance(par) / 2, max(abs(at$gradient)),
                  paste(signif(par[1:k], 3), collapse = " ")))
  threshold <- setNames(-beta[1], paste(levels(d$rating), collapse = "|"))
  key <- paste0(name, ".binary,", link, ",\"", terms, "\",independent,")
  write_fit(out, key, -deviance(par) / 2, max(abs(at$gradient)), threshold, beta[-1], errors[-(1:k)], parts[order(place)],
            setNames(as.list(errors[1:k]), labels))
}

# The counts as weights give the same likelihood as one row for each rating.
same_as_rows <- function(name, link, terms, slopes) {
  d <- read(name)
  formula <- as.formula(paste("rating ~", sides(terms), "+", random(terms, slopes)))
  rows <- d[rep(seq_len(nrow(d)), d$count), ]
  counted <- clmm(formula, data = d, weights = d$count, link = link, control = tight, doFit = FALSE)
  expanded <- clmm(formula, data = rows, link = link, control = tight, doFit = FALSE)
  # At the start values of the rows, with standard deviations that are not 1.
  par <- ordinal:::getPar.clmm(expanded)
  own <- -(1:expanded$dims$nfepar)
  par[own] <- par[own] * 0.7 + 0.05
  message(sprintf("%s: likelihoods of counts and of rows differ by %.1e", name,
                  ordinal:::getNLA(counted, par) - ordinal:::getNLA(expanded, par)))
}
same_as_rows("slopes2", "probit", "width,depth", "independent")
same_as_rows("slopes3", "logit", "num:x", "correlated")

record("slopes1", "logit", "width", "independent")
record("slopes1", "probit", "width", "independent")
record("slopes1", "logit", "width", "correlated")
record("slopes2", "probit", "width,depth", "independent")
record("slopes2", "logit", "width,num:depth", "independent")
record("slopes2", "probit", "width", "correlated")
record("slopes3", "logit", "num:x", "independent")
record("slopes3", "logit", "num:x", "correlated")
record("slopes3", "probit", "x", "independent")
record("slopes4", "probit", "side,num:x", "independent")
record("slopes4", "logit", "side,num:x", "independent")
record("slopes4", "probit", "num:x", "correlated")
record("slopes4", "logit", "side", "correlated")
record("slopes5", "logit", "width", "independent")
record("slopes6", "logit", "width", "independent")
record("slopes6", "probit", "width", "independent")
record("slopes7", "logit", "width,side", "independent")
record("slopes7", "probit", "side", "correlated")
record("slopes8", "logit", "width", "correlated")
record("slopes8", "probit", "width", "correlated")
record("slopes8", "logit", "width", "independent")
record("bangay", "logit", "width,depth", "independent")
record("bangay", "logit", "orientation_deg", "independent")
record("strong", "logit", "num:x", "independent")
record("strong", "probit", "x", "independent")
record("unbalanced", "probit", "shader,num:size", "independent")
record("unbalanced", "logit", "num:size", "independent")
record("spread", "logit", "group,num:x", "independent")
record("binary", "logit", "num:contrast,side", "independent")
record("binary", "logit", "side", "independent")
record("slopes9", "logit", "width", "independent", "item")
record("slopes9", "probit", "width", "none", "item")
record("slopes10", "probit", "side,num:x", "independent", "item")
record("slopes10", "logit", "side,num:x", "independent", "item")
record("slopes10", "logit", "side,x", "none", "item")
record("slopes4", "probit", "side", "independent", "x")
record("unbalanced", "logit", "num:size", "independent", "shader")
record_binary("slopes6", "width")
record_binary("binary", "side")
close(out)
warnings()
