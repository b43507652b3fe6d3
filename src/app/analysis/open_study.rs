//! An open study: its filters and settings, and the resulting document.

use std::sync::Arc;

use eframe::egui;

use super::{
    document::DocumentView,
    opened::{Files, Opened, SUMMARY, is_filtered},
    query::{Filters, ModelControls},
};
use crate::{
    analysis::{
        ModelError::{InfiniteDepth, NotANumber, UnknownFactor},
        Random, Slopes, analyze_with,
        counts::Exclusions,
    },
    app::ui::{
        complain, parameter, secondary, theme,
        work::{BackgroundTask, Lost, Steps},
    },
    report::{Analyzed, document::numbers::count},
    store::{
        FileError,
        ratings::{Reason, SessionRead},
    },
    work::{Analyze, RequestError, Study},
};

/// The data and its analysis.
pub struct OpenStudy {
    pub study: Arc<Study>,
    filters: Filters,
    model: ModelControls,
    /// The last requested analysis, finished or not.
    last: Option<Analyze>,
    /// How far that one is.
    state: State,
    /// What needs no model, until everything is there.
    draft: Option<Outcome>,
    /// The last finished analysis.
    shown: Option<Outcome>,
}

/// How far an analysis is. While it is not done, the results are of what was selected before.
enum State {
    Done,
    /// It is running: first a draft, which is the description of the data without a model and is there at once, then
    /// everything. The result is `None` if nothing is selected.
    Running {
        is_draft: bool,
        task: BackgroundTask<Option<Result<Outcome, RequestError>>>,
        simulated: Arc<Steps>,
    },
    /// The user stopped it.
    Stopped,
    /// Nothing is selected.
    Empty,
    /// The model that was asked for is not possible with these data, and why.
    Refused(String),
}

/// The sections that need no model, so that they are shown at once. Numbers in them are final.
const DRAFTED: [&str; 3] = ["health", "description", "agreement"];

/// The results of an analysis, and the view of its document.
struct Outcome {
    analyzed: Arc<Analyzed>,
    /// How many people gave how many ratings, and whether something is excluded.
    sample: String,
    view: DocumentView,
}

impl OpenStudy {
    pub fn new(study: Study) -> Self {
        Self {
            filters: Filters::default(),
            model: ModelControls::default(),
            last: None,
            state: State::Done,
            draft: None,
            shown: None,
            study: Arc::new(study),
        }
    }

    /// Keeps what was selected before the same files were read again, if it is still possible.
    pub fn after(self, before: Self) -> Self {
        let (old, new) = (&before.study.measured.counts, &self.study.measured.counts);
        let same = old.subjects == new.subjects && old.factors == new.factors && old.conditions == new.conditions;
        Self {
            filters: if same { before.filters } else { Filters::default() },
            model: before.model,
            // The earlier results stay until the new ones are ready.
            shown: before.shown,
            ..self
        }
    }

    /// Takes the results of computations that have finished.
    fn take_outcome(&mut self, ctx: &egui::Context) {
        if let State::Running { is_draft, task, .. } = &self.state
            && let (is_draft, Some(result)) = (*is_draft, task.poll())
        {
            self.state = State::Done;
            match result {
                Ok(Some(Ok(outcome))) => {
                    // The user may have sorted the tables of both.
                    let earlier = [&self.shown, &self.draft].into_iter().flatten();
                    let view = earlier.fold(outcome.view, |view, earlier| view.after(&earlier.view));
                    let made = Some(Outcome { view, ..outcome });
                    if is_draft {
                        self.draft = made;
                        self.start(ctx, false);
                    } else {
                        (self.shown, self.draft) = (made, None);
                    }
                }
                Ok(Some(Err(error))) => self.state = State::Refused(error.plain().to_owned()),
                Ok(None) => self.state = State::Empty,
                Err(Lost) => {
                    self.state = State::Stopped;
                    complain(ctx, "The analysis ended unexpectedly. Try other options or less data.");
                }
            }
        }
    }

    /// Begins an analysis when another one is requested; one that is still running is stopped.
    fn analyze(&mut self, ctx: &egui::Context, files: &Files) {
        let ratings = files.asked.ratings.clone().excluding(self.filters.0.clone());
        let mut request = Analyze { ratings, ..self.model.request.clone() };
        if let Some(factors) = &mut request.ratings.how.factors {
            // What names the items is not a factor beside them.
            factors.0.retain(|name| request.items.as_ref() != Some(name));
        }
        if request.random == Some(Random::None) {
            // What was chosen for random slopes is kept until there are any again.
            request.model.slopes = Slopes::default();
        }
        if self.last.as_ref() != Some(&request) {
            self.last = Some(request);
            self.draft = None;
            self.start(ctx, true);
        }
    }

    /// Starts the draft or the whole of the last requested analysis. They follow each other, so that the draft has all the
    /// threads.
    fn start(&mut self, ctx: &egui::Context, is_draft: bool) {
        let Some(request) = self.last.clone() else { return };
        let (study, simulated) = (self.study.clone(), Arc::<Steps>::default());
        let steps = simulated.clone();
        let compute = move || Outcome::new(&study, &request, is_draft, &steps);
        self.state = State::Running { is_draft, task: BackgroundTask::stoppable(ctx, compute), simulated };
    }

    /// Returns whether the results are of what was selected before.
    fn is_stale(&self) -> bool {
        !matches!(self.state, State::Done)
    }

    /// Returns whether the draft has the section at an address, or stands for what is not there yet.
    fn is_drafted(&self, section: &str) -> bool {
        self.draft.is_some() && (self.shown.is_none() || section == SUMMARY || DRAFTED.contains(&section))
    }

    /// Ends what is being computed. It begins again when the study is shown.
    pub fn pause(&mut self) {
        if matches!(self.state, State::Running { .. }) {
            (self.state, self.last, self.draft) = (State::Done, None, None);
        }
    }
}

impl Opened for OpenStudy {
    fn update(&mut self, ctx: &egui::Context, files: &Files) {
        self.take_outcome(ctx);
        self.analyze(ctx, files);
    }

    fn headings(&self) -> Vec<(&'static str, &'static str)> {
        let outcome = self.shown.as_ref().or(self.draft.as_ref());
        outcome.iter().flat_map(|outcome| outcome.view.headings()).collect()
    }

    /// Draws a line of constant height.
    fn state(&mut self, ui: &mut egui::Ui, section: &str) {
        let size = egui::vec2(ui.available_width(), theme::MESSAGE);
        let (rect, _) = ui.allocate_exact_size(size, egui::Sense::hover());
        let [left, right] =
            [egui::Layout::left_to_right, egui::Layout::right_to_left].map(|to| to(egui::Align::Center));
        let ui = &mut ui.new_child(egui::UiBuilder::new().max_rect(rect).layout(right));
        ui.set_clip_rect(rect);
        // How far it is has the right end of the line; the rest may be cut.
        match &self.state {
            State::Done => {}
            State::Running { is_draft, simulated, .. } => {
                let stop = ui.add_enabled(!is_draft, egui::Button::new("Stop").small());
                simulated.show(ui, "Analyzing", "simulated studies");
                if stop.clicked() {
                    self.state = State::Stopped;
                }
            }
            State::Stopped => {
                if ui.small_button("Continue").clicked() {
                    self.start(ui.ctx(), false);
                }
                ui.label(secondary("Stopped."));
            }
            State::Empty => {
                ui.label(secondary("No data are selected.").color(theme::ink(ui).bad))
                    .on_hover_text("Select at least one participant and at least one level of every factor.");
            }
            State::Refused(why) => {
                ui.label(secondary("This model is not possible.").color(theme::ink(ui).bad)).on_hover_text(why);
            }
        }
        let is_drafted = self.is_drafted(section);
        if let Some(outcome) = if is_drafted { &self.draft } else { &self.shown } {
            let before = if self.is_stale() && !is_drafted { "Before: " } else { "" };
            let text = format!("{before}{}", outcome.sample);
            ui.with_layout(left, |ui| ui.add(egui::Label::new(secondary(text)).truncate()));
        }
    }

    fn document(&mut self, ui: &mut egui::Ui, section: &str) -> bool {
        let (is_stale, is_drafted) = (self.is_stale(), self.is_drafted(section));
        if let Some(Outcome { view, .. }) = self.draft.as_mut().filter(|_| is_drafted) {
            // In a scope as below, so that the page keeps its place.
            let show = |ui: &mut egui::Ui| match DRAFTED.contains(&section) {
                true => view.show(ui, section),
                false => view.summary(ui, true),
            };
            return ui.scope(show).inner;
        }
        let Some(Outcome { view, .. }) = &mut self.shown else { return true };
        // Results of an earlier selection stay, dimmed, until the new ones are there.
        let show = |ui: &mut egui::Ui| {
            if is_stale {
                ui.multiply_opacity(theme::STALE);
            }
            view.show(ui, section)
        };
        ui.scope(show).inner
    }

    fn about(&self) -> (String, [&[FileError]; 2]) {
        let source = &self.study.source;
        let title = match (&source.protocol, source.files.first()) {
            (Some(protocol), _) => format!("{}: {}", protocol.name, protocol.title),
            (None, Some(file)) => file.path.file_name().unwrap_or_default().to_string_lossy().into_owned(),
            (None, None) => "No file".to_owned(),
        };
        (title, [&source.errors, &source.warnings])
    }

    fn controls(&mut self, ui: &mut egui::Ui, files: &Files) -> Option<Analyze> {
        let source = &self.study.source;
        let mut asked = files.asked.clone();
        let unfinished = source.sessions.iter().any(SessionRead::is_unfinished);
        if unfinished || source.left_out(Reason::Unfinished).0 > 0 {
            ui.checkbox(&mut asked.ratings.how.complete_only, "Exclude unfinished sessions");
        }
        let counts = &self.study.measured.counts;
        // The columns of others are named as they name them.
        let protocol = self.study.source.protocol.as_ref();
        let known = protocol.map_or(&[][..], |protocol| protocol.stimulus.parameters());
        self.filters.show(ui, counts, |factor| parameter::label(known, factor));
        if ui.add_enabled(self.filters != Filters::default(), egui::Button::new("Select everything")).clicked() {
            self.filters = Filters::default();
        }
        ui.separator();
        let refused = if let State::Refused(why) = &self.state { why } else { "" };
        self.model.show(ui, counts, &self.filters, refused);
        (asked != files.asked).then_some(asked)
    }

    fn exported(&self) -> (Option<&Analyze>, Option<&Arc<Analyzed>>) {
        // Only displayed results can be exported, not results that are still being computed.
        let outcome = self.shown.as_ref().filter(|_| !self.is_stale());
        let request = self.last.as_ref().filter(|_| !matches!(self.state, State::Empty | State::Refused(_)));
        (request, outcome.map(|outcome| &outcome.analyzed))
    }
}

impl Outcome {
    /// Analyzes the selected data; `None` if nothing is selected.
    ///
    /// # Errors
    /// The requested model is impossible.
    fn new(study: &Study, request: &Analyze, is_draft: bool, simulated: &Steps) -> Option<Result<Self, RequestError>> {
        let measured = study.measured.narrowed(&Exclusions::from(&request.ratings.how)).ok()?;
        if measured.counts.total() == 0 {
            return None;
        }
        let study = Study { source: study.source.clone(), measured };
        if let Err(error) = request.check(&study) {
            return Some(Err(error));
        }
        let mut options = request.options(&study.source);
        if is_draft {
            // A model without coefficients is none, and nothing is simulated for it.
            (options.max_coefficients, options.unchecked) = (Some(0), true);
        }
        let progress = |done: usize, all: usize| simulated.set(done as u64, all as u64);
        let results = analyze_with(study.measured, &options, &progress);
        if let Some(error @ (UnknownFactor { .. } | NotANumber { .. } | InfiniteDepth { .. })) =
            results.model.as_ref().err()
        {
            return Some(Err(RequestError::value("terms", error)));
        }
        let sample = format!(
            "{} by {}{}.",
            count(results.measured.counts.total(), "rating"),
            count(results.people() as u64, "participant"),
            if is_filtered(request) { ", filtered" } else { "" }
        );
        let analyzed = Analyzed::Ratings(study.source.into(), results.into());
        let view = DocumentView::new(analyzed.document(&analyzed.figures(), None));
        Some(Ok(Self { analyzed: analyzed.into(), sample, view }))
    }
}
