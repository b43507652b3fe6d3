//! What the fields of a session remember, suggest and check.

use std::{path::Path, rc::Rc};

use super::{
    form::{Checked, SessionForm},
    page::Studies,
};
use crate::{
    app::ui::{self, Monitor, ScreenFields},
    store::{
        definition,
        settings::{Settings, remember},
    },
};

impl Studies {
    /// Fills the form with the remembered values.
    pub(super) fn recall(&mut self, settings: &Settings, monitor: &Monitor) {
        // A relative path would lead to other sessions when the program starts in another folder.
        self.form.results = ui::full(Path::new(settings.results.trim())).display().to_string();
        if !settings.study.is_empty() {
            self.choose_experiment(settings.study.clone());
        }
        self.form.screen = settings.screen.clone();
        if settings.screen.monitor != monitor.title() {
            self.form.screen.screen_width_cm.clear();
        }
        self.suggest();
    }

    /// Updates the remembered values. What the program suggests is not remembered.
    pub(super) fn remember(&self, settings: &mut Settings, monitor: &Monitor, checked: &Checked) {
        let SessionForm { screen, results, experiment, .. } = &self.form;
        let absolute = |text: &str| ui::full(Path::new(text.trim())).display().to_string();
        settings.results = absolute(results);
        settings.screen =
            ScreenFields { monitor: monitor.title(), profile: absolute(&screen.profile), ..screen.clone() };
        if screen.distance_cm == self.planned_cm {
            settings.screen.distance_cm.clear();
        }
        if checked.protocol.is_none() {
            return;
        }
        let is_file = definition::built_in(Path::new(experiment)).is_none();
        settings.study.clone_from(experiment);
        // The order of the studies stays while the user chooses among them.
        if is_file && !settings.recent.experiments.contains(&settings.study) {
            remember(&mut settings.recent.experiments, &settings.study);
        }
    }

    /// Fills empty fields, and replaces a participant that the program suggested for other results.
    fn suggest(&mut self) {
        let subject = &mut self.form.cell.subject;
        let is_typed = !subject.is_empty() && *subject != self.suggested;
        if !is_typed {
            subject.clear();
        }
        self.suggested = self.form.suggest();
    }

    /// Checks the form if something in it has changed.
    pub(super) fn check(&mut self, monitor: &Monitor) -> Rc<Checked> {
        if let Some((form, seen, checked)) = &self.checked
            && *form == self.form
            && seen == monitor
        {
            return checked.clone();
        }
        let before = self.checked.as_ref().map(|(form, ..)| form);
        let moved =
            before.is_none_or(|form| form.experiment != self.form.experiment || form.results != self.form.results);
        if moved || self.form.screen.distance_cm.is_empty() {
            self.suggest();
        }
        let mut checked = self.form.check(monitor);
        let known = checked.display.as_ref().and_then(|display| display.screen_width_cm);
        if let Some(width) = known.filter(|_| self.form.screen.width_is_assumed()) {
            // A profile that knows the screen's width is better than an assumption.
            self.form.screen.screen_width_cm = width.to_string();
            checked = self.form.check(monitor);
        }
        if let Some(protocol) = &checked.protocol {
            self.planned_cm = protocol.viewing.distance_cm.to_string();
        }
        let checked = Rc::new(checked);
        self.checked = Some((self.form.clone(), monitor.clone(), checked.clone()));
        checked
    }
}
