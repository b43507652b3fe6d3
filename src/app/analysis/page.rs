//! The page that reads and shows the data.

use std::path::PathBuf;

use eframe::egui::{self, Key};

use super::{
    open_study::OpenStudy,
    opened::{Files, Opened, Request, Shell},
    questions::Question,
    task::OpenTask,
};
use crate::{
    app::ui::{
        Field, FileKind, Step, dialog, escaped, heading, hint, paragraph, place_page, section, show_error,
        work::{BackgroundTask, Lost},
    },
    work::{Analyze, Ratings, RequestError},
};

/// The name of what opens the dialogs.
const DATA: &str = "data to analyze";

#[derive(Default)]
pub struct Analysis {
    /// The path as typed.
    typed: String,
    /// The files being read, if any.
    reading: Option<Pending>,
    /// Why the last files could not be read.
    error: Option<String>,
    /// What the last files do not say, and the user is asked.
    question: Option<Question>,
    /// The files and folders opened last, and how they are read.
    asked: Analyze,
    open: Option<(Shell, Open)>,
    /// Whether to look if the files of the open data have changed.
    returns: bool,
}

/// The data that are shown: ratings, or the answers to another task.
enum Open {
    Ratings(Box<OpenStudy>),
    Task(Box<OpenTask>),
}

impl Open {
    /// Keeps the selection and the results of the same files, read again.
    fn after(self, before: Self) -> Self {
        match (self, before) {
            (Self::Task(task), Self::Task(before)) => Self::Task(task.after(*before).into()),
            (Self::Ratings(study), Self::Ratings(before)) => Self::Ratings(study.after(*before).into()),
            (open, _) => open,
        }
    }

    fn opened(&mut self) -> &mut dyn Opened {
        match self {
            Self::Ratings(study) => &mut **study,
            Self::Task(task) => &mut **task,
        }
    }
}

type Reading = Result<(Shell, Open), String>;

/// Reads what is asked for: ratings, or the answers to another task, which are analyzed at once.
fn read(asked: &Analyze) -> Reading {
    let files = Files::of(asked.clone());
    if let Some(study) = asked.read_task().map_err(|error| error.to_string())? {
        let shell = Shell::new(files, study.files.iter().map(|(path, _)| path.clone()));
        return Ok((shell, Open::Task(OpenTask::new(study, asked).into())));
    }
    let plain = |error: anyhow::Error| match error.downcast_ref::<RequestError>() {
        Some(request) => request.plain().to_owned(),
        None => error.to_string(),
    };
    let study = asked.read_unordered().map_err(plain)?;
    let shell = Shell::new(files, study.source.files.iter().map(|file| file.path.clone()));
    Ok((shell, Open::Ratings(OpenStudy::new(study).into())))
}

/// Files that are being read.
struct Pending {
    /// Whether the files that are already open are read again.
    again: bool,
    work: BackgroundTask<Reading>,
}

impl Analysis {
    /// Looks whether the open files have changed, because the user returns to the page.
    pub fn look_again(&mut self) {
        self.returns = true;
    }

    /// Creates the page that opens a data set.
    pub fn of(ctx: &egui::Context, data_set: PathBuf) -> Self {
        let mut page = Self::default();
        page.read_new(ctx, vec![data_set]);
        page
    }

    /// Ends the computation of what is not shown; it begins again when the page is shown.
    pub fn pause(&mut self) {
        if let Some((_, Open::Ratings(study))) = &mut self.open {
            study.pause();
        }
    }

    /// Begins to read files and folders. Discards any reading that has not finished.
    fn read(&mut self, ctx: &egui::Context, asked: Analyze, again: bool) {
        self.asked = asked.clone();
        (self.error, self.question) = (None, None);
        let work = BackgroundTask::stoppable(ctx, move || read(&asked));
        self.reading = Some(Pending { again, work });
    }

    fn read_new(&mut self, ctx: &egui::Context, paths: Vec<PathBuf>) {
        self.read(ctx, of(Ratings { paths, ..Ratings::default() }), false);
    }

    /// Returns the file or folder that is open; `None` if there is none, or if there are several.
    pub fn opened(&self) -> Option<PathBuf> {
        let [path] = self.asked.ratings.paths.as_slice() else { return None };
        std::path::absolute(path).ok().filter(|_| self.open.is_some())
    }

    /// Draws the page; returns whether the user left it. `recent` are the paths that were opened recently.
    pub fn show(&mut self, ui: &mut egui::Ui, recent: &[String]) -> bool {
        let escaped = escaped(ui) && ui.memory(|memory| memory.focused().is_none());
        self.take_files(ui.ctx());
        self.take_study();
        self.look(ui.ctx());
        // While its files are read again, the study stays in view.
        let is_reading = self.reading.as_ref().is_some_and(|pending| !pending.again);
        let open = self.open.as_mut().filter(|_| !is_reading);
        let error = self.error.as_deref().unwrap_or_default();
        let step = match open {
            None => Step::back_if(self.show_start(ui, recent)),
            // Other data begin at the top.
            Some((shell, open)) => {
                let is_stale = self.reading.is_some();
                ui.push_id(&self.asked.ratings.paths, |ui| shell.show(ui, open.opened(), is_stale, error)).inner
            }
        };
        let back = match step {
            Step::Stay => false,
            Step::Back => true,
            Step::Next(request) => {
                self.follow(ui.ctx(), request);
                false
            }
        };
        back || escaped
    }

    fn take_files(&mut self, ctx: &egui::Context) {
        let dropped: Vec<PathBuf> =
            ctx.input(|input| input.raw.dropped_files.iter().map(|file| file.path().to_owned()).collect());
        let paths = if dropped.is_empty() { dialog::answer(ctx, DATA) } else { Some(dropped) };
        if let Some(paths) = paths {
            self.read_new(ctx, paths);
        }
    }

    /// Takes the data if reading has finished.
    fn take_study(&mut self) {
        let Some(pending) = &self.reading else { return };
        let Some(read) = pending.work.poll() else { return };
        let read =
            read.unwrap_or_else(|Lost| Err("The files could not be read: reading ended unexpectedly".to_owned()));
        let Some(Pending { again, .. }) = self.reading.take() else { return };
        let (before, asked) = (self.open.take(), &self.asked);
        match read {
            Ok((shell, open)) => {
                let open = match before.filter(|_| again) {
                    Some((before, old)) => (shell.after(before), open.after(old)),
                    None => (shell, open),
                };
                if let (_, Open::Ratings(open)) = &open {
                    self.question = Question::of_order(&open.study, &asked.ratings);
                }
                self.open = Some(open).filter(|_| self.question.is_none());
            }
            Err(error) if again && before.is_some() => (self.open, self.error) = (before, Some(error)),
            Err(error) => {
                self.question = Question::of_columns(&asked.ratings);
                // A missing selection is not an error before the user has seen the form.
                let is_first = self.question.is_some() && asked.ratings.how.subject.is_none();
                self.error = (!is_first).then_some(error);
            }
        }
    }

    /// Reads the open files again if they have changed while another page or window was in use.
    fn look(&mut self, ctx: &egui::Context) {
        self.returns |= ctx.input(|input| input.events.contains(&egui::Event::WindowFocused(true)));
        let Some((Shell { files, .. }, _)) = self.open.as_ref().filter(|_| self.reading.is_none()) else { return };
        if std::mem::take(&mut self.returns) && files.have_changed() {
            self.read(ctx, files.asked.clone(), true);
        }
    }

    /// Performs an action requested by the controls of the study.
    fn follow(&mut self, ctx: &egui::Context, request: Request) {
        match request {
            Request::OtherData => (self.open, self.error) = (None, None),
            Request::Read(asked) => self.read(ctx, *asked, true),
        }
    }

    /// Draws the page while no study is open.
    fn show_start(&mut self, ui: &mut egui::Ui, recent: &[String]) -> bool {
        let ctx = ui.ctx().clone();
        place_page(ui, "Analyze", |ui| {
            let back = heading(ui, "Analyze");
            if self.reading.is_some() {
                ui.horizontal(|ui| {
                    ui.spinner();
                    ui.label("Reading…");
                });
                for path in self.asked.ratings.paths.iter().take(5) {
                    hint(ui, path.display().to_string());
                }
                return back;
            }
            let named = self.question.as_mut().and_then(|question| question.show(ui));
            let is_asked = self.question.is_some();
            let mut chosen = if is_asked { None } else { self.choose(ui, recent) };
            for line in self.error.iter().flat_map(|error| error.lines()).take(20) {
                show_error(ui, line);
            }
            if is_asked {
                ui.separator();
                chosen = self.choose(ui, recent);
            }
            if let Some(ratings) = named {
                self.read(&ctx, of(ratings), false);
            }
            if let Some(path) = chosen {
                self.read_new(&ctx, vec![path]);
            }
            back
        })
    }

    /// Lists what can be analyzed; returns the file or folder to open.
    fn choose(&mut self, ui: &mut egui::Ui, recent: &[String]) -> Option<PathBuf> {
        let mut chosen = None;
        paragraph(
            ui,
            "Drop files or a folder on this window: result files, a table of counts, or any table (CSV or Excel) with one rating \
                per row. You can then identify its columns.",
        );
        ui.horizontal_wrapped(|ui| {
            for (text, ask) in [("Open files…", FileKind::Data), ("Open folder…", FileKind::Folder)] {
                if ui.button(text).clicked() {
                    dialog::ask(ui.ctx(), ask, DATA);
                }
            }
        });
        if !recent.is_empty() {
            section(ui, "Opened recently");
        }
        for path in recent {
            if ui.button(path).clicked() {
                chosen = Some(path.into());
            }
        }
        ui.add_space(6.0);
        ui.horizontal_wrapped(|ui| {
            let field = Field::new("Or enter the path of a file or folder").text(ui, &mut self.typed);
            let entered = field.lost_focus() && ui.input(|input| input.key_pressed(Key::Enter));
            let ready = !self.typed.trim().is_empty();
            if ui.add_enabled(ready, egui::Button::new("Open")).clicked() || entered && ready {
                chosen = Some(self.typed.trim().into());
            }
        });
        chosen
    }
}

/// Requests an analysis of these ratings.
fn of(ratings: Ratings) -> Analyze {
    Analyze { ratings, ..Analyze::default() }
}
