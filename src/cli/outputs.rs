//! Guards the inputs and outputs of every command. Both follow from the types of its options, so a new command is
//! guarded too.

use std::{any::TypeId, path::PathBuf};

use clap::{Arg, ArgAction, ArgMatches, Command, ValueHint};

use crate::{
    store::{self, StoreError, Writer, ratings::with_files},
    system::found,
    work::{FittedPath, NewFolder, OutPath},
};

/// Name of the option that makes a [`FittedPath`] an output.
const FIT: &str = "fit";
/// Name of the option that allows a command to replace existing files.
const FORCE: &str = "force";

/// Adds `--force` to every command that has an [`OutPath`]. In every command, a negative number is a value.
pub(super) fn with_force(command: Command) -> Command {
    command.mut_subcommands(|command| {
        let command = command.allow_negative_numbers(true);
        if !command.get_arguments().any(is_of::<OutPath>) {
            return command;
        }
        let force = Arg::new(FORCE).long(FORCE).action(ArgAction::SetTrue);
        command.arg(force.help("Replace existing files; inputs and the files of sessions are never replaced"))
    })
}

fn is_of<T: 'static>(argument: &Arg) -> bool {
    argument.get_value_parser().type_id() == TypeId::of::<T>()
}

/// Returns the writer for one call of a command, once all its outputs are known to be writable.
///
/// # Errors
/// The same errors as [`Writer::check`].
pub(super) fn writer(command: &Command, matches: &ArgMatches) -> Result<Writer, StoreError> {
    let (mut inputs, mut files, mut folders) = (Vec::new(), Vec::new(), Vec::new());
    let is_fit = command.get_arguments().any(|argument| argument.get_id() == FIT) && matches.contains_id(FIT);
    for argument in command.get_arguments() {
        let is_folder = argument.get_value_hint() == ValueHint::DirPath;
        let reads_folders = argument.get_value_names().unwrap_or_default().iter().any(|name| name.contains("DIR"));
        let paths = values(argument, matches, PathBuf::clone);
        // Text arguments can also be paths.
        let paths = paths.chain(values(argument, matches, |text: &String| PathBuf::from(text)));
        // A built-in definition may have the same name as a folder.
        inputs.extend(paths.filter(|path| {
            reads_folders || found(path).map_or(true, |found| found.is_some_and(|found| found.is_file()))
        }));
        let fitted = values(argument, matches, |path: &FittedPath| path.to_path_buf());
        if is_fit { &mut files } else { &mut inputs }.extend(fitted);
        let written = values(argument, matches, |path: &OutPath| path.to_path_buf());
        if is_folder { &mut folders } else { &mut files }.extend(written);
        folders.extend(values(argument, matches, |path: &NewFolder| path.to_path_buf()));
    }
    let force = matches!(matches.try_get_one::<bool>(FORCE), Ok(Some(true)));
    // Without `--force`, no existing file is replaced anyway.
    let writer = Writer::new(if force { with_pictures(with_files(inputs)?)? } else { inputs }, force);
    folders.iter().try_for_each(|folder| writer.check_folder(folder))?;
    writer.check(files.iter().map(PathBuf::as_path))?;
    Ok(writer)
}

/// Returns these paths and the pictures in each one that is a folder.
fn with_pictures(mut paths: Vec<PathBuf>) -> Result<Vec<PathBuf>, StoreError> {
    for path in paths.clone() {
        paths.extend(store::image::listed(&path)?);
    }
    Ok(paths)
}

/// Returns the paths in the values of an argument, if they have this type.
fn values<'a, T: Clone + Send + Sync + 'static>(
    argument: &Arg,
    matches: &'a ArgMatches,
    path: impl Fn(&T) -> PathBuf + 'a,
) -> impl Iterator<Item = PathBuf> + 'a {
    let found = matches.try_get_many::<T>(argument.get_id().as_str()).ok().flatten();
    found.into_iter().flatten().map(path)
}
