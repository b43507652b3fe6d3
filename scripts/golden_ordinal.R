# Reference values for the ordinal models from R's ordinal package: tests/golden/ordinal/models.csv and tests.csv.
#
#   apt-get install --no-install-recommends r-base-core r-cran-ordinal
#   Rscript scripts/golden_ordinal.R
#
# The data come from scripts/golden_ordinal.py. clmm stops early, so this script adds Newton steps on clmm's likelihood.
suppressPackageStartupMessages(library(ordinal))
folder <- "tests/golden/ordinal"

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
  d <- read.csv(text = rows_of(name, "data.csv"), colClasses = "character")
  d$count <- as.numeric(d$count)
  d <- d[d$count > 0, ]
  d$rating <- factor(d$rating, levels = natural(d$rating), ordered = TRUE)
  for (v in setdiff(names(d), c("count", "rating"))) {
    d[[paste0("num_", v)]] <- suppressWarnings(as.numeric(d[[v]]))
    d[[v]] <- factor(d[[v]], levels = natural(d[[v]]))
  }
  if ("depth" %in% names(d)) d$num_inv_n <- 1 / d$num_depth
  d
}
# "num:x" in --terms is the column num_x here; R calls its coefficient x.
sides <- function(terms) if (terms == "") "1" else gsub(",", " + ", gsub("num:", "num_", terms))
tidy <- function(names) gsub("num_", "", names)
back <- function(term) gsub("num_", "num:", term)

models <- file(file.path(folder, "models.csv"), "w")
tests <- file(file.path(folder, "tests.csv"), "w")
versions <- paste0("# R's ordinal ", packageVersion("ordinal"), ", ", R.version.string, ", by scripts/golden_ordinal.R.")
writeLines(c(versions, "# nodes: 0 is clm, 1 is clmm by Laplace's approximation. gradient: the largest that R ended with.",
             "data,link,terms,nodes,quantity,name,value"), models)
writeLines(c(versions, "# location: likelihood ratio against the model without the term.",
             "data,link,terms,nodes,test,term,lr,df,p"), tests)

# Newton steps on the package's likelihood, with its numerical derivatives, starting where clmm ended. With one random
# intercept, clmm computes the curvature for Laplace's approximation one step before the mode. Its code for arbitrary
# random effects (useMatrix) computes it at the mode and is used here.
finish <- function(m, rho) {
  laplace <- rho$nAGQ == 1
  likelihood <- function(par) {
    n <- length(par)
    if (laplace) ordinal:::getNLA(rho, c(par[-n], exp(par[n]))) else ordinal:::getNAGQ.ssr(rho, par)
  }
  par <- unname(c(m$alpha, m$beta, log(as.numeric(m$ST[[1]]))))
  for (step in 1:4) {
    d <- ordinal:::deriv12(likelihood, x = par, delta = 5e-4)
    if (step < 4) par <- par - solve(d$Hessian, d$gradient)
  }
  n <- length(m$alpha)
  sd <- exp(par[length(par)])
  m$alpha[] <- par[1:n]
  if (length(m$beta)) m$beta[] <- par[n + seq_along(m$beta)]
  m$ST[[1]][] <- sd
  m$logLik <- -likelihood(par)
  m$gradient[] <- d$gradient
  m$Hessian[] <- d$Hessian
  m
}
fit_once <- function(d, link, terms, nodes) {
  location <- paste("rating ~", sides(terms))
  if (nodes == 0) {
    arguments <- list(as.formula(location), data = d, weights = d$count, link = link,
                      control = clm.control(gradTol = 1e-10, maxIter = 200))
    do.call(clm, arguments)
  } else {
    control <- function(matrix) clmm.control(gradTol = 1e-8, maxIter = 200, maxLineIter = 100, method = "nlminb", useMatrix = matrix)
    arguments <- list(as.formula(paste(location, "+ (1 | subject)")), data = d, weights = d$count, link = link, nAGQ = nodes)
    rho <- do.call(clmm, c(arguments, doFit = FALSE, control = list(control(nodes == 1))))
    rho$nAGQ <- nodes
    finish(do.call(clmm, c(arguments, control = list(control(FALSE)))), rho)
  }
}
record <- function(name, link, terms, nodes = 0) {
  d <- read(name)
  factors <- unique(unlist(strsplit(terms, "[,:]")))
  for (v in intersect(factors, names(d))) d <- d[!is.na(d[[v]]), ]
  d <- droplevels(d)
  m <- fit_once(d, link, terms, nodes)
  key <- paste0(name, ",", link, ",\"", terms, "\",", nodes)
  put <- function(quantity, label, value) writeLines(sprintf("%s,%s,%s,%.15g", key, quantity, label, signif(value, if (quantity == "loglik") 14 else 10)), models)
  put("loglik", "", as.numeric(m$logLik))
  put("gradient", "", max(abs(m$gradient)))
  v <- vcov(m)
  # The parameters in vcov: thresholds, coefficients, and the log of the standard deviation.
  se <- sqrt(diag(v))
  thresholds <- m$alpha
  for (j in seq_along(thresholds)) {
    put("threshold", names(thresholds)[j], thresholds[j])
    put("threshold_se", names(thresholds)[j], se[j])
  }
  beta <- m$beta[!is.na(m$beta)]
  for (j in seq_along(beta)) {
    put("coefficient", tidy(names(beta)[j]), beta[j])
    put("coefficient_se", tidy(names(beta)[j]), se[length(thresholds) + j])
  }
  if (nodes > 0) {
    sd <- as.numeric(m$ST[[1]])
    put("sd", "", sd)
    # The last parameter is log(sd).
    put("sd_se", "", sd * se[length(se)])
  }
  test <- function(kind, term, lr, df) {
    writeLines(sprintf("%s,%s,\"%s\",%.10g,%d,%.10g", key, kind, back(term), lr, as.integer(df), pchisq(lr, df, lower.tail = FALSE)), tests)
  }
  if (terms != "") for (term in strsplit(terms, ",")[[1]]) {
    all <- strsplit(terms, ",")[[1]]
    inside <- function(other) other != term && all(strsplit(term, "(?<!num):", perl = TRUE)[[1]] %in% strsplit(other, "(?<!num):", perl = TRUE)[[1]])
    if (any(sapply(all, inside))) next
    rest <- paste(all[all != term], collapse = ",")
    without <- fit_once(d, link, rest, nodes)
    test("location", term, 2 * as.numeric(m$logLik - without$logLik), m$edf - without$edf)
  }
}

record("bangay", "logit", "width,depth,orientation_deg")
record("bangay", "probit", "width,depth")
record("bangay", "logit", "num:width,num:inv_n,num:width:num:inv_n")
record("bangay", "logit", "width,num:inv_n,width:num:inv_n")
record("bangay", "logit", "width,depth,orientation_deg", 1)
record("alike", "logit", "width,depth,orientation_deg")
record("alike", "probit", "depth")
record("unbalanced", "logit", "shader,size")
record("unbalanced", "probit", "shader,num:size")
record("unbalanced", "probit", "shader,num:size", 1)
record("binary", "logit", "num:contrast,side")
record("binary", "probit", "contrast")
record("binary", "logit", "num:contrast,side", 1)
record("gaps", "logit", "width,depth")
record("gaps", "logit", "depth,bound")
record("gaps", "logit", "width,depth,width:depth")
record("strong", "logit", "num:x")
record("strong", "logit", "x", 1)
record("spread", "logit", "group,num:x")
record("large", "logit", "num:year")
record("large", "probit", "year")
close(models)
close(tests)
warnings()
