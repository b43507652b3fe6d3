//! The analysis as files: what `machband analyze` writes, and the command that does the same.

use std::{
    path::{Path, PathBuf},
    sync::Arc,
};

use eframe::egui;
use jiff::Timestamp;

use crate::{
    analysis::{Link, Options, Random, Results},
    app::ui::{
        Ask, Dialog, hint, outcome, quiet,
        work::{Progress, Work},
    },
    report::{Provenance, Study, study::shell_command, write_all},
    store::ratings::ReadOptions,
};

/// The field, and what came of the last export.
pub struct Export {
    folder: String,
    dialog: Dialog,
    work: Option<(PathBuf, Work<Result<usize, String>>)>,
    outcome: Option<Result<String, String>>,
    /// A folder with files in it, which may be written into if asked again.
    occupied: Option<PathBuf>,
}

/// What is to be written.
pub struct Exported<'a> {
    /// What was read.
    pub study: &'a Arc<Study>,
    /// What was made of it.
    pub results: &'a Arc<Results>,
    /// What the filters left, as a phrase; empty where that is everything.
    pub filter: String,
    /// The command that does the same without filters.
    pub command: String,
}

impl Export {
    /// For the results of these files.
    pub fn new(paths: &[PathBuf]) -> Self {
        let name = paths.first().and_then(|path| path.file_stem()).map(|name| name.to_string_lossy().into_owned());
        let name = name.filter(|name| !name.is_empty()).unwrap_or_else(|| "machband".to_owned());
        Self {
            folder: format!("{name}-analysis"),
            dialog: Dialog::default(),
            work: None,
            outcome: None,
            occupied: None,
        }
    }

    /// The folder as it is typed.
    pub fn folder(&self) -> &str {
        self.folder.trim()
    }

    /// Draws it; there is nothing to write while nothing is shown.
    pub fn show(&mut self, ui: &mut egui::Ui, exported: Option<Exported<'_>>) {
        self.take_outcome(ui.ctx());
        let label = ui.label("Export to the folder");
        let width = ui.available_width();
        let field = ui.add(egui::TextEdit::singleline(&mut self.folder).desired_width(width)).labelled_by(label.id);
        let mut changed = field.changed();
        ui.horizontal_wrapped(|ui| {
            let folder = PathBuf::from(self.folder());
            let again = self.occupied.as_ref() == Some(&folder);
            let ready = exported.is_some() && self.work.is_none() && !folder.as_os_str().is_empty();
            let text = if again { "Write into it" } else { "Export" };
            if ui.add_enabled(ready, egui::Button::new(text)).clicked()
                && let Some(exported) = &exported
            {
                self.start(ui.ctx(), folder, again, exported);
            }
            changed |= self.dialog.browse(ui, Ask::Folder, "Choose the folder to export to…", &mut self.folder);
            if self.work.is_some() {
                ui.spinner();
                ui.label(quiet("Writing…"));
            }
        });
        if changed {
            (self.outcome, self.occupied) = (None, None);
        }
        if let Some(Exported { filter, .. }) = exported.filter(|exported| !exported.filter.is_empty()) {
            hint(ui, format!("The export has what is shown: {filter}."));
        }
        self.dialog.missing_fault(ui);
        outcome(ui, self.outcome.as_ref());
    }

    fn take_outcome(&mut self, ctx: &egui::Context) {
        let Some((folder, work)) = &self.work else { return };
        self.outcome = Some(match work.poll() {
            Progress::Going => return,
            Progress::Done(files) => files.map(|files| format!("{files} files written to {}", folder.display())),
            Progress::Lost => Err("The export ended unexpectedly; expected files in the folder".to_owned()),
        });
        self.work = None;
        ctx.request_repaint();
    }

    fn start(&mut self, ctx: &egui::Context, folder: PathBuf, again: bool, exported: &Exported<'_>) {
        let has_files = folder.read_dir().is_ok_and(|mut entries| entries.next().is_some());
        if has_files && !again {
            let text = format!("{} has files in it, which may be replaced; expected a new folder", folder.display());
            self.outcome = Some(Err(text));
            self.occupied = Some(folder);
            return;
        }
        (self.outcome, self.occupied) = (None, None);
        let (study, results, to) = (exported.study.clone(), exported.results.clone(), folder.clone());
        let mut command = exported.command.clone();
        if !exported.filter.is_empty() {
            // A comment of the shell: no command filters.
            command += &format!(" # filtered in the window: {}", exported.filter);
        }
        self.work = Some((folder, Work::start(ctx, move || write(&study, &results, &command, &to))));
    }
}

/// Writes everything that `machband analyze` writes; the number of files.
fn write(study: &Study, results: &Results, command: &str, folder: &Path) -> Result<usize, String> {
    // The report is about the ratings that the results are of.
    let shown = Study { source: study.source.clone(), measured: results.measured.clone() };
    let made = Provenance::new(command, Timestamp::now());
    let written = write_all(&shown, results, &made, folder, false).map_err(|error| error.to_string())?;
    Ok(written.files.len())
}

/// `machband analyze` of these files with these options; only what differs from the default is named.
pub fn command(paths: &[PathBuf], read_options: &ReadOptions, options: &Options, out: &str) -> String {
    let mut words = vec!["analyze".to_owned()];
    words.extend(paths.iter().map(|path| path.display().to_string()));
    let mut option = |name: &str, value: Option<String>| {
        words.extend(value.into_iter().flat_map(|value| [name.to_owned(), value]));
    };
    option("--subject", read_options.subject.clone());
    option("--response", read_options.response.clone());
    option("--count", read_options.count.clone());
    option("--factors", read_options.factors.as_ref().map(|factors| factors.join(",")));
    option("--terms", options.terms.as_ref().map(ToString::to_string));
    option("--link", (options.link != Link::default()).then(|| options.link.to_string()));
    option("--random", (options.random == Some(Random::None)).then(|| "none".to_owned()));
    option("--quadrature", (options.quadrature != 1).then(|| options.quadrature.to_string()));
    option("--out", Some(out.to_owned()));
    words.extend(read_options.complete_only.then(|| "--complete-only".to_owned()));
    words.extend(options.scale.then(|| "--scale".to_owned()));
    shell_command(words)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::terms::Terms;

    #[test]
    fn only_what_differs_from_the_default_is_named() {
        let paths = [PathBuf::from("results/tiny"), PathBuf::from("is here.csv")];
        let plain = command(&paths[..1], &ReadOptions::default(), &Options::default(), "out");
        assert_eq!(plain, "machband analyze results/tiny --out out");
        let read_options =
            ReadOptions { response: Some("score".to_owned()), complete_only: true, ..ReadOptions::default() };
        let terms = Terms::parse("width*num:inv_n").ok();
        let options = Options { terms, link: Link::Probit, scale: true, ..Options::default() };
        assert_eq!(
            command(&paths, &read_options, &options, "out"),
            "machband analyze results/tiny 'is here.csv' --response score --terms 'width,num:inv_n,width:num:inv_n' \
             --link probit --out out --complete-only --scale"
        );
    }
}
