//! Floor 12: the commands, which do the same work as the window without opening one.
//!
//! The exit status is 0 for success, 1 for a failure, and 2 for wrong usage. Errors go to stderr as `error: WHERE: what
//! is wrong; what is expected`, warnings go to stderr as `warning: WHERE: …`, and data go to stdout or the named files.

mod analyze;
mod bar;
mod calibrate;
mod compare;
mod images;
mod outputs;
mod plan;
mod predict;
#[cfg(feature = "window")]
mod run;
mod sessions;

use std::{borrow::Cow, ffi::OsString, io::Write as _, path::Path, process::ExitCode};

use clap::{CommandFactory as _, FromArgMatches as _, Parser, Subcommand};

use self::bar::{Bar, print_data, print_line};
use crate::{
    report::{
        document::{Shown, numbers::count},
        terminal::{message, printable},
    },
    store::{StoreError, Writer},
    system::{
        signals::{self, Signal},
        start_threads,
    },
    text::Cell,
    work::{self, OutPath, RequestError, told},
};

/// Measure how visible Mach bands are.
///
/// Without a command, the window opens.
#[derive(Parser)]
#[command(name = "machband", version, max_term_width = 100)]
#[command(after_help = "Example: machband simulate quick --participants 3 && machband check results/quick/data/*.csv")]
#[command(args_conflicts_with_subcommands = true)]
struct Arguments {
    /// File for what the window remembers [default: settings.toml in the user's folder for configuration].
    #[cfg(feature = "window")]
    #[arg(long, value_name = "FILE.toml")]
    config: Option<std::path::PathBuf>,
    #[command(subcommand)]
    command: Option<Command>,
}

#[derive(Subcommand)]
enum Command {
    #[cfg(feature = "window")]
    Run(run::Arguments),
    Simulate(work::simulate::Simulate),
    Check(work::Check),
    Compare(compare::Arguments),
    Plan(plan::Arguments),
    Predict(predict::Arguments),
    Analyze(analyze::Arguments),
    Calibrate(calibrate::Arguments),
    Counts(analyze::CountsArguments),
    Export(work::Export),
    Repair(work::Repair),
    Shade(images::ShadeArguments),
    Stimulus(images::StimulusArguments),
    Stimuli(images::StimuliArguments),
    Verify(work::verify::Verify),
}

/// Returns the definition of all commands and their options.
pub fn definition() -> clap::Command {
    outputs::with_force(Arguments::command())
}

/// Runs the program with the process's arguments.
pub fn main() -> ExitCode {
    ExitCode::from(run_with(std::env::args_os().collect()))
}

/// Runs the program with these arguments, of which the first is the program's name, and returns the exit status.
pub fn run_with(arguments: Vec<OsString>) -> u8 {
    if let Some(argument) = arguments.iter().find(|argument| argument.to_str().is_none()) {
        message("error", &format!("{}: is not Unicode; expected text in UTF-8", argument.to_string_lossy()));
        return 2;
    }
    let definition = definition();
    let matches = definition.clone().try_get_matches_from(&arguments);
    let matches = matches.unwrap_or_else(|error| refuse(&error, &arguments));
    let parsed = Arguments::from_arg_matches(&matches).unwrap_or_else(|error| refuse(&error, &arguments));
    let called = matches.subcommand().and_then(|(name, matches)| Some((definition.find_subcommand(name)?, matches)));
    let writer = called.map_or_else(|| Ok(Writer::default()), |(command, matches)| outputs::writer(command, matches));
    let started = start_threads().map_err(Into::into).and_then(|()| Ok(writer?));
    let status = match started.and_then(|writer| run(parsed, &writer)) {
        Ok(true) => 0,
        Ok(false) => 1,
        Err(error) => {
            let option = |field: &str| called.map_or_else(|| field.to_owned(), |(command, _)| option(command, field));
            // Each line is an error with its cause.
            message("error", &told(&error, option));
            let is_output =
                matches!(error.downcast_ref(), Some(StoreError::Occupied(_) | StoreError::Protected { .. }));
            if is_output || error.is::<RequestError>() { 2 } else { 1 }
        }
    };
    signals::received().map_or(status, Signal::status)
}

/// Returns a field of a command's request as the command line names it.
fn option(command: &clap::Command, field: &str) -> String {
    let argument = command.get_arguments().find(|argument| argument.get_id() == field);
    argument.and_then(clap::Arg::get_long).map_or_else(|| field.to_owned(), |long| format!("--{long}"))
}

/// Returns the message of an error in a request, which names its options.
fn told_of<T: work::Request>(error: &anyhow::Error) -> String {
    let command = T::augment_args(clap::Command::new("machband"));
    told(error, |field| option(&command, field))
}

/// Runs a command; `writer` writes its outputs. Returns false if it found what it was asked to refuse.
fn run(arguments: Arguments, writer: &Writer) -> anyhow::Result<bool> {
    let done = match arguments.command {
        #[cfg(feature = "window")]
        None => {
            let settings = arguments.config.or_else(|| Some(crate::system::config_folder()?.join("settings.toml")));
            crate::app::open(crate::app::Launch { request: None, settings }).map_err(Into::into)
        }
        #[cfg(not(feature = "window"))]
        None => Err(anyhow::anyhow!(
            "machband: built without a window; expected the feature `window`, or a command such as machband simulate quick"
        )),
        #[cfg(feature = "window")]
        Some(Command::Run(arguments)) => run::run(&arguments),
        Some(Command::Simulate(arguments)) => sessions::simulate(&arguments),
        Some(Command::Check(arguments)) => sessions::check(&arguments),
        Some(Command::Compare(arguments)) => return compare::run(&arguments, writer),
        Some(Command::Plan(arguments)) => plan::run(&arguments, writer),
        Some(Command::Predict(arguments)) => predict::run(&arguments, writer),
        Some(Command::Analyze(arguments)) => analyze::run(&arguments, writer),
        Some(Command::Calibrate(arguments)) => calibrate::run(&arguments, writer),
        Some(Command::Counts(arguments)) => analyze::counts(&arguments, writer),
        Some(Command::Export(arguments)) => sessions::export(&arguments),
        Some(Command::Repair(arguments)) => sessions::repair(&arguments),
        Some(Command::Shade(arguments)) => images::shade(&arguments, writer),
        Some(Command::Stimulus(arguments)) => images::stimulus(&arguments, writer),
        Some(Command::Stimuli(arguments)) => images::stimuli(&arguments, writer),
        Some(Command::Verify(arguments)) => sessions::verify(&arguments),
    };
    done.map(|()| true)
}

/// Ends the program with clap's message: help, or the error in the arguments. The error repeats arguments, which may
/// contain control characters.
fn refuse(error: &clap::Error, arguments: &[OsString]) -> ! {
    let is_harmless = |argument: &OsString| matches!(printable(&argument.to_string_lossy()), Cow::Borrowed(_));
    if !error.use_stderr() || arguments.iter().all(is_harmless) {
        error.exit();
    }
    for line in error.render().to_string().lines() {
        let _ = writeln!(std::io::stderr(), "{}", printable(line));
    }
    std::process::exit(error.exit_code())
}

fn report_written(path: &Path) -> anyhow::Result<()> {
    print_line(&format!("wrote {}", path.display()))
}

/// Formats a table as lines of text. Each column is as wide as its widest cell, numbers are right-aligned, and empty
/// columns are omitted.
fn columns(header: &[&str], rows: &[Vec<Shown>]) -> Vec<String> {
    let is_number = |cell: &Shown| *cell.value() == Cell::Missing || cell.value().as_number().is_some();
    let mut lines = vec![String::new(); rows.len() + 1];
    for (index, name) in header.iter().enumerate() {
        let cells = || rows.iter().map(|row| &row[index]);
        if cells().all(|cell| cell.is_empty()) {
            continue;
        }
        let width = cells().map(|cell| cell.chars().count()).fold(name.chars().count(), usize::max);
        let is_right = cells().all(is_number);
        for (line, cell) in lines.iter_mut().zip(std::iter::once(*name).chain(cells().map(|cell| &**cell))) {
            *line += &if is_right { format!("{cell:>width$}  ") } else { format!("{cell:<width$}  ") };
        }
    }
    lines.iter().map(|line| line.trim_end().to_owned()).collect()
}
