//! What participants do, how the levels are chosen, and the answers.

use eframe::egui::{FontId, Rect, Response, Role, Sense, Stroke, StrokeKind, TextEdit, Ui, Vec2, WidgetInfo, vec2};

use serde::Serialize;

use super::form::{DefinitionForm, LABELS, add};
use crate::{
    app::ui::{
        self, Field, parameter,
        theme::{self, Icon},
    },
    experiment::{
        CATEGORIES,
        task::{Adaptive, Defaults, Method, OptionValue, Task, TaskOption, typed},
    },
    report::names::{self, capitalized},
    stimulus::{Parameter, Stimulus},
    store::draft::{Draft, Typed},
};

/// Smallest size of the card of a task, and the side of its icon, points.
const CARD: Vec2 = vec2(112.0, 104.0);
const PICTOGRAM: f32 = 28.0;
/// The icons of the tasks, in the order of their names.
const ICONS: [Icon; Task::NAMES.len()] = [Icon::Rating, Icon::Choice, Icon::YesNo, Icon::Pair, Icon::Adjust];
/// What a list shows if there is no value.
const NONE: &str = "none";
/// The options of a task that apply only to images that follow each other.
const OF_INTERVALS: [&str; 2] = ["duration_s", "gap_s"];
/// Trials at each level of the method of constant stimuli, to begin with.
const AT_EACH_LEVEL: usize = 10;

/// Draws the fields.
pub fn show(form: &mut DefinitionForm, ui: &mut Ui) {
    let kind = form.value("task.kind", Task::default().name());
    cards(form, ui, &kind);
    let error = [form.own_error("task"), form.error("task.kind")].join("\n");
    ui::text::errors(ui, error.trim());
    let Some(default) = Task::read(&kind, &mut Defaults) else { return };
    options(form, ui, "task", Task::options(&kind), &default);
    if !form.draft.keys("task").is_empty() && form.draft.get("task.kind").is_none() {
        form.edit(|draft| draft.set("task.kind", &kind, Typed::Text));
    }
    // The options decide the usual question and answers, and whether levels can be chosen.
    let task = form.protocol.as_ref().map(|protocol| protocol.task.clone()).filter(|task| task.name() == kind);
    let task = task.unwrap_or(default);
    if task.adapts() {
        method(form, ui);
    } else {
        ui::text::errors(ui, &form.error("adaptive"));
    }
    answers(form, ui, &task);
}

fn cards(form: &mut DefinitionForm, ui: &mut Ui, kind: &str) {
    let count = Task::NAMES.len() as f32;
    let gap = ui.spacing().item_spacing.x;
    let room = ui.available_width() + gap;
    let across = (room / (CARD.x + gap)).floor().clamp(1.0, count);
    let width = (room / across - gap).floor();
    let mut chosen = None;
    ui.horizontal_wrapped(|ui| {
        for ((name, about), icon) in Task::NAMES.iter().zip(Task::ABOUT).zip(ICONS) {
            let clicked = card(ui, width, (name, icon), about.trim(), *name == kind).clicked();
            chosen = chosen.or(clicked.then_some(*name));
        }
    });
    if let Some(name) = chosen.filter(|name| *name != kind) {
        let found = varied(form);
        form.rebuild(|draft| {
            draft.set_task(name);
            begin(draft, "task", Task::options(name), found);
            if !Task::read(name, &mut Defaults).is_some_and(|task| task.adapts()) {
                draft.set_method(None);
            }
        });
    }
}

/// Draws the card of a task.
fn card(ui: &mut Ui, width: f32, (name, icon): (&str, Icon), about: &str, selected: bool) -> Response {
    let title = capitalized(name);
    let (rect, response) = ui.allocate_exact_size(vec2(width, CARD.y), Sense::click());
    let ink = theme::ink(ui);
    let edge = match () {
        () if selected => Stroke::new(2.0, ink.ink),
        () if response.hovered() => Stroke::new(1.0, ink.edge),
        () => Stroke::new(1.0, ink.line),
    };
    ui.painter().rect(rect, 6.0, ink.card, edge, StrokeKind::Inside);
    theme::focus_ring(ui, &response);
    let at = rect.min + Vec2::splat(8.0);
    icon.paint(ui.painter(), Rect::from_min_size(at, Vec2::splat(PICTOGRAM)), ink.text);
    let room = width - 16.0;
    let mut below = at + vec2(0.0, PICTOGRAM + 2.0);
    for (text, size, color) in [(title.as_str(), theme::BODY, ink.text), (about, theme::NOTE, ink.dim)] {
        let text = ui.painter().layout(text.to_owned(), FontId::proportional(size), color, room);
        let height = text.size().y;
        ui.painter_at(rect).galley(below, text, color);
        below.y += height;
    }
    response.widget_info(|| WidgetInfo::selected(Role::RadioButton, true, selected, &title));
    response.on_hover_text(about)
}

/// Draws how levels are chosen.
fn method(form: &mut DefinitionForm, ui: &mut Ui) {
    ui::section(ui, "Method");
    let title = |name: &str| match name {
        NONE => "The factors alone".to_owned(),
        name => capitalized(&parameter::method(name)),
    };
    let default = |form: &DefinitionForm| match form.draft.keys("adaptive").as_slice() {
        [] => NONE,
        _ => Method::default().name(),
    };
    let field = ["Levels chosen by", "adaptive.method", default(form), "How the level of each trial is found."];
    if let Some(chosen) = form.choice(ui, field, [NONE].into_iter().chain(Method::NAMES.iter().copied()), title) {
        let method = (chosen != NONE).then_some(chosen.as_str());
        let found = varied(form).filter(|_| form.draft.get("adaptive.parameter").is_none());
        form.rebuild(|draft| {
            draft.set_method(method);
            if let Some(method) = method {
                begin(draft, "adaptive", &Adaptive::options(method), found);
            }
        });
    }
    let chosen = form.value("adaptive.method", default(form));
    let about = Method::NAMES.iter().position(|name| *name == chosen).map(|index| Method::ABOUT[index].trim());
    ui::hint(ui, about.unwrap_or("Every combination of the factors' levels is shown equally often."));
    if chosen == NONE {
        return;
    }
    ui::text::errors(ui, &form.own_error("adaptive"));
    let Some(method) = Method::read(&chosen, &mut Defaults) else { return };
    options(form, ui, "adaptive", &Adaptive::options(&chosen), &Adaptive { method, ..Adaptive::default() });
}

/// Returns the first parameter with several suggested numbers that no factor varies, with these numbers.
fn varied(form: &DefinitionForm) -> Option<(&'static str, Vec<f64>)> {
    let numbers = |parameter: &Parameter| {
        let mut numbers: Vec<f64> = parameter.levels_hint.iter().filter_map(|level| level.parse().ok()).collect();
        numbers.retain(|number| *number > 0.0);
        numbers.sort_by(f64::total_cmp);
        numbers
    };
    let found: Vec<_> = form.free_parameters().map(|parameter| (parameter.name, numbers(parameter))).collect();
    // Two numbers are hardly a range.
    let with = |least: usize| found.iter().find(|(_, numbers)| numbers.len() >= least).cloned();
    with(3).or_else(|| with(2))
}

/// Gives the options of a table a parameter and levels to begin with, if any were found.
fn begin(draft: &mut Draft, table: &str, options: &[TaskOption], found: Option<(&str, Vec<f64>)>) {
    let Some((parameter, levels)) = found else { return };
    let texts: Vec<String> = levels.iter().map(ToString::to_string).collect();
    let is_constant = table == "adaptive" && draft.get("adaptive.method").is_some_and(|method| method == "constant");
    for option in options {
        let (text, typed) = match option.key {
            "parameter" => (parameter.to_owned(), Typed::Text),
            "levels" => (texts.join(", "), Typed::Values),
            "low" => (texts[0].clone(), Typed::Value),
            "high" | "start" => (texts[texts.len() - 1].clone(), Typed::Value),
            "trials" if is_constant => ((texts.len() * AT_EACH_LEVEL).to_string(), Typed::Value),
            _ => continue,
        };
        draft.set(&format!("{table}.{}", option.key), &text, typed);
    }
}

/// Draws the options of a table, with their values where the definition does not say them.
pub fn options(form: &mut DefinitionForm, ui: &mut Ui, table: &str, options: &[TaskOption], defaults: &impl Serialize) {
    let defaults = serde_json::to_value(defaults).unwrap_or_default();
    let at_once = table == "task" && form.value("task.shown", "") == "places";
    let opened = |option: &TaskOption| option.key.split_once('.').map(|(inner, _)| inner);
    for (i, option) in options.iter().enumerate() {
        let opens = opened(option).is_some_and(|inner| options[..i].iter().all(|before| opened(before) != Some(inner)));
        if let Some(inner) = opened(option).filter(|_| !opens)
            && form.draft.keys(&format!("{table}.{inner}")).is_empty()
        {
            continue;
        }
        // A table of its own goes with the option that opens it.
        let owner = if opens { opened(option).unwrap_or(option.key) } else { option.key };
        let keys = [&format!("{table}.{}", option.key), &format!("{table}.{owner}")];
        if !(at_once && OF_INTERVALS.contains(&option.key)) {
            control(form, ui, option, keys.map(String::as_str), &defaults);
        }
    }
}

/// Draws the control of an option.
fn control(
    form: &mut DefinitionForm,
    ui: &mut Ui,
    option: &TaskOption,
    [key, owner]: [&str; 2],
    defaults: &serde_json::Value,
) {
    let TaskOption { label, about, value, .. } = *option;
    let default = typed(defaults, option.key);
    match value {
        OptionValue::Number => form.number(ui, label, key, default, about),
        OptionValue::Optional(absent) => form.optional(ui, label, [key, owner], absent, about),
        OptionValue::Numbers(absent) => form.list(ui, label, key, [&default, absent], about),
        OptionValue::Flag => {
            let before = form.value(key, &default) == "true";
            let mut flag = before;
            let error = form.error(key);
            Field::new(label).column(LABELS).error(&error).show(ui, |ui, label| {
                ui.checkbox(&mut flag, "").labelled_by(label).on_hover_text(about);
            });
            if flag != before {
                form.edit(|draft| draft.set_flag(key, flag));
            }
        }
        OptionValue::OneOf(_) | OptionValue::Parameter(_) | OptionValue::Factor | OptionValue::Order => {
            let none = matches!(value, OptionValue::Parameter(true) | OptionValue::Factor).then_some(NONE);
            let (parameters, factors) = (form.parameters(), form.draft.factors());
            let of_factor = |factor: &String| ["blocked", "latin"].map(|kind| format!("{kind}:{factor}"));
            let orders: Vec<String> = factors.iter().flat_map(of_factor).collect();
            let names: Vec<&str> = match value {
                OptionValue::OneOf(names) => names.to_vec(),
                OptionValue::Order => ["random"].into_iter().chain(orders.iter().map(String::as_str)).collect(),
                OptionValue::Factor => factors.iter().map(String::as_str).collect(),
                _ => form.free_parameters().map(|parameter| parameter.name).collect(),
            };
            let field = [label, key, none.unwrap_or(&default), about];
            let title = |name: &str| match name.split_once(':') {
                Some(("blocked", factor)) => format!("Blocks by {}, random", names::factor(Some(parameters), factor)),
                Some((_, factor)) => format!("Blocks by {}, Latin square", names::factor(Some(parameters), factor)),
                None if value == OptionValue::Order => capitalized(name),
                None => parameter::label(parameters, name),
            };
            match form.choice(ui, field, none.into_iter().chain(names), title).as_deref() {
                None => {}
                Some(NONE) => form.rebuild(|draft| draft.remove(owner)),
                Some(chosen) => form.type_value(key, chosen, Typed::Value),
            }
        }
        OptionValue::Settings => settings(form, ui, option, key),
    }
}

/// Draws parameters of the stimulus with their values.
fn settings(form: &mut DefinitionForm, ui: &mut Ui, option: &TaskOption, key: &str) {
    let prefix = format!("{} ", option.label);
    let removed = form.rows(ui, key, [&prefix, &prefix], Typed::Value);
    let names = form.draft.keys(key);
    if let Some(name) = removed {
        let gone = if names.len() == 1 { key.to_owned() } else { format!("{key}.{name}") };
        form.rebuild(|draft| draft.remove(&gone));
    }
    let parameters = form.parameters().iter().filter(|parameter| !names.iter().any(|name| name == parameter.name));
    let mut error = form.own_error(key);
    if names.is_empty() && !error.is_empty() {
        error = "Choose a parameter in which it differs from the target.".to_owned();
    }
    let title = format!("Add to {}", option.label.to_lowercase());
    let entries = parameters.map(|parameter| (parameter, parameter.label()));
    let field = Field::new(if names.is_empty() { option.label } else { "" }).column(LABELS).error(&error);
    let chosen = field.show(ui, |ui, _| add(ui, &title, entries));
    if let Some(parameter) = chosen {
        let name = parameter.name;
        let default = Stimulus::default_of(&form.value("stimulus.kind", "")).and_then(|default| default.get(name));
        let now = form.value(&format!("stimulus.{name}"), &default.map_or(String::new(), |value| value.to_string()));
        let levels = form.draft.texts(&format!("factors.{name}")).unwrap_or_default();
        // A value that differs from those of the target.
        let differs = |level: &&&str| **level != now && !levels.iter().any(|own| own == **level);
        let value = parameter.levels_hint.iter().rev().find(differs).map_or(now.as_str(), |level| level);
        form.edit(|draft| {
            if names.is_empty() {
                draft.add_table(key);
            }
            draft.set(&format!("{key}.{name}"), value, Typed::Value);
        });
    }
}

/// Draws the question and the answers.
fn answers(form: &mut DefinitionForm, ui: &mut Ui, task: &Task) {
    ui::section(ui, "Answers");
    let scale = task.scale();
    form.text(ui, "Question", "response.question", &scale.question, "Shown next to the scale.");
    // A definition without labels or keys uses the defaults.
    let labels = || scale.categories.iter().map(|category| category.label.clone()).collect();
    let mut labels = form.draft.texts("response.labels").filter(|own| !own.is_empty()).unwrap_or_else(labels);
    let mut keys = form.draft.texts("response.keys").unwrap_or_default();
    let has_keys = task.dial().is_none();
    keys.truncate(labels.len());
    let default = |answer| scale.default_key(answer, labels.len()).map(String::from).unwrap_or_default();
    keys.extend((keys.len()..labels.len()).map(default));
    // Ratings are counted from 0, as in the data.
    let named = |answer: usize| match (has_keys, answer) {
        (false, 0) => "left end".to_owned(),
        (false, _) => "right end".to_owned(),
        _ if task.answers().is_none() => format!("rating {answer}"),
        _ => format!("answer {}", answer + 1),
    };
    let before = [labels.clone(), keys.clone()];
    let (mut removed, mut errors) = (None, Vec::new());
    for answer in 0..labels.len() {
        let shown = named(answer);
        let label = capitalized(&shown);
        let wrong = ["labels", "keys"].map(|list| form.error(&format!("response.{list}.{answer}")));
        let wrong = wrong.join("\n");
        errors.extend(wrong.lines().filter(|line| !line.is_empty()).map(|line| format!("{label}: {line}")));
        Field::new(&label).column(LABELS).show(ui, |ui, _| {
            if !wrong.trim().is_empty() {
                theme::outline_wrong(ui);
            }
            ui.horizontal(|ui| {
                if has_keys {
                    let key = TextEdit::singleline(&mut keys[answer]).id_salt(("key", answer)).desired_width(24.0);
                    let key = ui.add(key);
                    ui::text::name(ui, &key, &format!("Key for {shown}"));
                    key.on_hover_text("The key for this answer: a digit or a letter other than S.");
                }
                let width = (ui.available_width() - 100.0).clamp(120.0, 380.0);
                let label = TextEdit::singleline(&mut labels[answer]).id_salt(("label", answer)).desired_width(width);
                let label = ui.add(label);
                ui::text::name(ui, &label, &format!("Label of {shown}"));
                label.on_hover_text("What this answer means.");
                if task.answers().is_none() {
                    ui.add_enabled_ui(labels.len() > *CATEGORIES.start(), |ui| {
                        if ui::quiet(ui, Icon::Close, "", &format!("Remove {shown}")).clicked() {
                            removed = Some(answer);
                        }
                    });
                }
            });
        });
    }
    let many = labels.len() >= *CATEGORIES.end();
    let errors = errors.join("\n");
    let below = Field::new("").column(LABELS).slot().error(&errors);
    if task.answers().is_some() {
        below.show(ui, |_, _| {});
    } else {
        let added = below.show(ui, |ui, _| ui.add_enabled_ui(!many, |ui| ui::action(ui, Icon::Plus, "Category")).inner);
        if added.on_hover_text("2 to 11 categories, from the weakest to the strongest.").clicked() {
            let free = ('0'..='9').chain('a'..='z').map(String::from);
            keys.push(free.filter(|key| key != "s").find(|key| !keys.contains(key)).unwrap_or_default());
            labels.push(String::new());
        }
    }
    if let Some(answer) = removed {
        labels.remove(answer);
        keys.remove(answer);
    }
    let texts = [labels, keys].into_iter().zip(before);
    for (key, (texts, before)) in ["response.labels", "response.keys"].into_iter().zip(texts) {
        if texts != before {
            form.edit(|draft| draft.set_texts(key, &texts));
        }
        ui::text::errors(ui, &form.own_error(key));
    }
}
