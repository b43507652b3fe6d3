//! The fields of a definition, in the order of its file.

use std::path::Path;

use eframe::egui::{Align, Button, CollapsingHeader, Rect, Ui, Vec2};

use super::{
    form::{DefinitionForm, LABELS, add},
    task,
};
use crate::{
    app::ui::{self, Field, FileKind, theme::Icon},
    experiment::{Design, ParticipantField, Plan, Recovery, SessionRules, Texts, ViewingPlan},
    report::names::capitalized,
    stimulus::{
        KINDS, Stimulus, catalog,
        picture::{Picture, PictureSize, ShownAs},
    },
    store::draft::Typed,
};

/// Draws a part of the form.
type Part = fn(&mut DefinitionForm, &mut Ui);

/// The parts of the form, in their order.
pub const PARTS: [(&str, Part); 10] = [
    ("Study", study),
    ("Task", task::show),
    ("Stimulus", stimulus),
    ("Factors", factors),
    ("Trials", |form, ui| task::options(form, ui, "design", Design::OPTIONS, &Design::default())),
    ("Timing", timing),
    ("Viewing", |form, ui| task::options(form, ui, "viewing", ViewingPlan::OPTIONS, &ViewingPlan::default())),
    ("Participant", participant),
    ("Session and plan", session),
    ("Texts", texts),
];

/// Draws all fields, and scrolls to a part.
pub fn show(form: &mut DefinitionForm, ui: &mut Ui, wanted: Option<usize>) {
    for (i, (name, part)) in PARTS.iter().enumerate() {
        if wanted == Some(i) {
            let top = ui.cursor().min;
            ui.scroll_to_rect(Rect::from_min_size(top, Vec2::ZERO), Some(Align::TOP));
        }
        ui::section(ui, *name);
        part(form, ui);
    }
}

fn study(form: &mut DefinitionForm, ui: &mut Ui) {
    form.text(ui, "Name", "name", "", "The name of the file, the experiment and its data: a–z, 0–9 and hyphens.");
    form.text(ui, "Title", "title", "", "One line that describes the experiment.");
}

fn stimulus(form: &mut DefinitionForm, ui: &mut Ui) {
    let title = |kind: &str| match catalog::entry(kind) {
        Some(entry) => entry.title.to_owned(),
        None if kind == Picture::KIND => "Pictures of your own".to_owned(),
        None => kind.to_owned(),
    };
    let kinds = KINDS.iter().copied().chain([Picture::KIND]);
    if let Some(kind) = form.choice(ui, ["Kind", "stimulus.kind", "", "What participants see."], kinds, title) {
        form.rebuild(|draft| draft.set_kind(&kind));
    }
    let kind = form.value("stimulus.kind", "");
    if kind == Picture::KIND {
        return pictures(form, ui);
    }
    let Some(default) = Stimulus::default_of(&kind) else { return };
    if let Some(entry) = catalog::entry(&kind) {
        ui::hint(ui, entry.about);
    }
    ui::text::errors(ui, &form.own_error("stimulus"));
    let factors = form.draft.factors();
    let adapted = ["adaptive.parameter", "adaptive.second.parameter"].map(|key| form.value(key, ""));
    for parameter in default.parameters() {
        let varied_by = [("Factors", &factors[..]), ("Method", &adapted)];
        let is_varied = |(_, names): &(&str, &[String])| names.iter().any(|name| name == parameter.name);
        if let Some((part, _)) = varied_by.into_iter().find(is_varied) {
            let varies = |ui: &mut Ui, _| ui.horizontal(|ui| ui.label(ui::secondary(format!("varies; see {part}"))));
            Field::new(&parameter.label()).column(LABELS).show(ui, varies);
            continue;
        }
        let key = format!("stimulus.{}", parameter.name);
        let before = form.value(&key, &default.get(parameter.name).map_or_else(String::new, |value| value.to_string()));
        let mut text = before.clone();
        ui::parameter(ui, LABELS, parameter, &mut text, Some(&form.error(&key)));
        if text != before {
            form.type_value(&key, &text, Typed::Value);
        }
    }
}

fn pictures(form: &mut DefinitionForm, ui: &mut Ui) {
    let about = "A folder beside the definition, a slash, and a name in which * stands for any letters: pictures/*.png";
    form.text(ui, "Files", "stimulus.files", "", about);
    Field::new("").column(LABELS).show(ui, |ui, _| {
        let mut folder = String::new();
        if ui::browse(ui, FileKind::Folder, "Choose a folder of pictures…", &mut folder) {
            let beside = Path::new(&folder).strip_prefix(&form.draft.folder).unwrap_or(Path::new(&folder));
            form.type_value("stimulus.files", &beside.join("*.png").display().to_string(), Typed::Text);
        }
    });
    let is_wrong = form.errors.iter().any(|error| error.key.starts_with("stimulus"));
    let protocol = form.protocol.as_ref().filter(|_| !is_wrong);
    if let Some(Stimulus::Image(picture)) = protocol.map(|protocol| &protocol.stimulus) {
        let (count, factors) = (picture.gallery.pictures.len(), &picture.gallery.factors);
        let levels = if factors.is_empty() { "they have no other levels".to_owned() } else { factors.join(", ") };
        ui::hint(
            ui,
            format!("{count} pictures; levels from pictures.csv: {levels}. The data record each picture's SHA-256."),
        );
    } else {
        ui::hint(
            ui,
            "Choose PNG files: opaque, with 8 or 16 bits. A table pictures.csv beside them gives them levels of factors.",
        );
    }
    ui::text::errors(ui, &form.own_error("stimulus"));
    let shown = "Display: the file's light. Codes: the file's codes, whatever the display.";
    let size = "Pixels: one for one. Degrees: the longer side fills the stimulus window.";
    for (label, key, names, about) in
        [("Shown", "stimulus.show", ShownAs::NAMES, shown), ("Size", "stimulus.size", PictureSize::NAMES, size)]
    {
        let field = [label, key, names[names.len() - 1], about];
        if let Some(chosen) = form.choice(ui, field, names.iter().copied(), ToOwned::to_owned) {
            form.type_value(key, &chosen, Typed::Text);
        }
    }
}

fn factors(form: &mut DefinitionForm, ui: &mut Ui) {
    let has_pictures = form.value("stimulus.kind", "") == Picture::KIND;
    if has_pictures && form.draft.factors().is_empty() {
        return ui::hint(ui, "The table pictures.csv gives pictures the levels of factors.");
    }
    ui::hint(ui, "Every combination of their levels is a condition. Separate levels with commas: 0.02, 0.05, 0.1");
    ui::text::errors(ui, &form.own_error("factors"));
    if let Some(name) = form.rows(ui, "factors", ["Levels of ", ""], Typed::Values) {
        form.rebuild(|draft| draft.remove(&format!("factors.{name}")));
    }
    // Pictures bring their factors.
    let free = form.free_parameters().filter(|_| !has_pictures).map(|parameter| (parameter, parameter.label()));
    if let Some(parameter) = add(ui, "Add a factor", free) {
        let quoted = |level: &&str| if level.contains(',') { format!("\"{level}\"") } else { (*level).to_owned() };
        let levels = parameter.levels_hint.iter().map(quoted).collect::<Vec<_>>().join(", ");
        form.edit(|draft| draft.set(&format!("factors.{}", parameter.name), &levels, Typed::Values));
    }
}

fn timing(form: &mut DefinitionForm, ui: &mut Ui) {
    task::options(form, ui, "recovery", Recovery::OPTIONS, &Recovery::default());
    let about = "Duration of each stimulus. The uniform field follows until it is rated.";
    form.optional(ui, "Stimulus, s", ["presentation.duration_s", "presentation"], "until it is rated", about);
}

/// What a session asks about the participant.
fn participant(form: &mut DefinitionForm, ui: &mut Ui) {
    ui::hint(ui, "What a session asks before its first page. Answers to choose from are separated by commas.");
    ui::text::errors(ui, &form.own_error("participant"));
    let names = form.draft.keys("participant");
    names.iter().for_each(|name| question(form, ui, name));
    let is_new = |name: &str| !name.is_empty() && !names.iter().any(|other| other == name);
    let known = ParticipantField::known_names().filter(|name| is_new(name)).map(str::to_owned);
    let mut added = add(ui, "Add a question", known.map(|name| (name.clone(), capitalized(&name))));
    let mut own = form.value(OWN, "");
    ui.horizontal_wrapped(|ui| {
        let field = Field::new("Or one of your own, named").width(150.0).hint("dominant_eye");
        if field.text(ui, &mut own).on_hover_text("Its column in participants.tsv.").changed() {
            form.keep_typed(OWN, &own);
        }
        let is_name = is_new(&own) && own.chars().all(|c| c.is_ascii_alphanumeric() || c == '_');
        if ui.add_enabled(is_name, Button::new("Add")).clicked() {
            added = Some(own);
        }
    });
    if let Some(name) = added {
        form.rebuild(|draft| {
            draft.add_table(&format!("participant.{name}"));
            if name == "consent" {
                let text = "You can stop at any time, without giving a reason.";
                draft.set("participant.consent.text", text, Typed::Text);
            }
        });
    }
}

/// The key of what is typed as the name of a question that is not there yet.
const OWN: &str = "name of a question";
/// The kinds of questions of one's own.
const ANSWERS: [&str; 3] = ["any text", "a number", "one of several"];

/// Draws a question.
fn question(form: &mut DefinitionForm, ui: &mut Ui, name: &str) {
    let key = format!("participant.{name}");
    let own = !ParticipantField::known_names().any(|known| known == name);
    let shown = capitalized(&name.replace('_', " "));
    let draft = &form.draft;
    let choices = draft.texts(&format!("{key}.choices")).unwrap_or_default();
    let asked = ParticipantField { name: name.to_owned(), choices, ..ParticipantField::default() };
    let flag = |part: &str| draft.get(&format!("{key}.{part}"));
    let is_consent = flag("text").is_some();
    let was_required = flag("required").as_deref() != Some("false");
    let kind_before = match (flag("number").as_deref(), flag("choices").is_some()) {
        (Some("true"), _) => ANSWERS[1],
        (_, true) => ANSWERS[2],
        _ => ANSWERS[0],
    };
    let (mut required, mut kind) = (was_required, kind_before);
    let error = form.own_error(&key);
    let removed = Field::new(&shown).column(LABELS).slot().error(&error).show(ui, |ui, _| {
        ui.horizontal_wrapped(|ui| {
            if own {
                let title = format!("Answers to {shown}");
                Field::new("").named(&title).width(130.0).choice(ui, &mut kind, &ANSWERS, |kind| (*kind).to_owned());
            }
            if !is_consent {
                let check = ui.checkbox(&mut required, "required");
                ui::text::name(ui, &check, &format!("{shown} is required"));
            }
            ui::quiet(ui, Icon::Close, "", &format!("Remove {shown}")).clicked()
        })
        .inner
    });
    if is_consent {
        form.lines(ui, "", &format!("{key}.text"), "", "The text to agree to.");
    } else {
        let label = if own { "What the participant reads".to_owned() } else { asked.label() };
        form.line(ui, &format!("Label of {shown}"), &format!("{key}.label"), Typed::Text, &label);
        let choices = asked.choices();
        if !choices.is_empty() {
            let usual = if own { "left, right, unknown".to_owned() } else { choices.join(", ") };
            form.line(ui, &format!("Answers of {shown}"), &format!("{key}.choices"), Typed::Values, &usual);
        }
    }
    if kind != kind_before {
        form.rebuild(|draft| {
            ["number", "choices"].iter().for_each(|part| draft.remove(&format!("{key}.{part}")));
            match kind {
                "a number" => draft.set_flag(&format!("{key}.number"), true),
                "one of several" => draft.set(&format!("{key}.choices"), "yes, no", Typed::Values),
                _ => {}
            }
        });
    }
    if required != was_required {
        form.edit(|draft| draft.set_flag(&format!("{key}.required"), required));
    }
    if removed {
        form.rebuild(|draft| draft.remove(&key));
    }
}

fn session(form: &mut DefinitionForm, ui: &mut Ui) {
    task::options(form, ui, "plan", Plan::OPTIONS, &Plan::default());
    task::options(form, ui, "session", SessionRules::OPTIONS, &SessionRules::default());
}

fn texts(form: &mut DefinitionForm, ui: &mut Ui) {
    ui::folded(ui, CollapsingHeader::new("What participants read"), |ui| {
        ui::hint(ui, "In the participants' language. The program fills in the words in braces.");
        for [name, about, default] in Texts::ALL {
            let label = capitalized(&name.replace('_', " "));
            let key = format!("instructions.{name}");
            form.lines(ui, &label, &key, default, about.trim());
        }
    });
}
