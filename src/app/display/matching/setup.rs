//! What to match, how often, and where the answers go.

use std::{
    path::PathBuf,
    time::{SystemTime, UNIX_EPOCH},
};

use eframe::egui::{self, Key};

use super::{proceeds, tool, trial::Trials};
use crate::{
    app::theme,
    display::{
        Viewing,
        matching::{Channel, Effort, Method, Nulling, Pattern, Plan},
    },
    experiment::session_seed,
    store::matches::{NullingFile, beside},
};

/// Periods a degree from which on rows of full contrast blend: near the limit of sight, 50 to 60.
const BLEND_PER_DEG: f64 = 40.0;

/// The fields.
pub struct Setup {
    /// Red, green, blue, gray.
    channels: [bool; 4],
    method: Method,
    pattern: Pattern,
    effort: Effort,
    pairs: bool,
    path: String,
    refused: Option<String>,
}

/// Where the fields lead.
pub enum Go {
    Stay,
    Back,
    Begin(Box<Trials>),
}

impl Default for Setup {
    fn default() -> Self {
        Self {
            channels: [true, true, true, false],
            method: Method::Staircase,
            pattern: Pattern::Quarters,
            effort: Effort::Standard,
            pairs: false,
            path: "display.toml".to_owned(),
            refused: None,
        }
    }
}

impl Setup {
    /// Where the profile is to go.
    pub fn path(&self) -> PathBuf {
        PathBuf::from(self.path.trim())
    }

    /// Draws the fields.
    pub fn show(&mut self, ui: &mut egui::Ui, viewing: Option<&Viewing>) -> Go {
        let (mut back, mut begin) = (false, false);
        let plan = self.plan();
        let fault = self.fault(&plan);
        tool(ui, "Gamma by eye", &mut back, |ui| {
            ui.label("Without a photometer: a field of rows of full and no light has a light that is known. A square is matched to it by eye, and from several matches follows gamma.");
            ui.add_space(8.0);
            self.fields(ui);
            ui.add_space(8.0);
            ui.label(format!("{} trials, about {:.0} minutes.", plan.trials(), (plan.duration_s() / 60.0).ceil()));
            ui.label(distance_sentence(viewing, plan.longest_period_px()));
            ui.add_space(12.0);
            for text in fault.iter().chain(&self.refused) {
                theme::fault(ui, text);
            }
            begin = theme::primary(ui, "Next", fault.is_none(), "Space");
        });
        begin |= proceeds(ui);
        if back || ui.input(|input| input.key_pressed(Key::Escape)) {
            return Go::Back;
        }
        if !begin || fault.is_some() {
            return Go::Stay;
        }
        match self.begin(plan) {
            Ok(trials) => Go::Begin(Box::new(trials)),
            Err(message) => {
                self.refused = Some(message);
                Go::Stay
            }
        }
    }

    fn fields(&mut self, ui: &mut egui::Ui) {
        ui.horizontal_wrapped(|ui| {
            ui.label("Channels");
            for (channel, chosen) in Channel::ALL.iter().zip(&mut self.channels) {
                ui.checkbox(chosen, channel.to_string());
            }
        });
        choice(
            ui,
            "Method",
            &mut self.method,
            &[(Method::Staircase, "brighter or darker"), (Method::Adjustment, "adjust until it vanishes")],
        );
        choice(
            ui,
            "Rows lit",
            &mut self.pattern,
            &[
                (Pattern::Quarters, "one of four, and half"),
                (Pattern::Halves, "half only: blends from nearer, tells less"),
            ],
        );
        choice(
            ui,
            "Trials",
            &mut self.effort,
            &[(Effort::Quick, "few"), (Effort::Standard, "standard"), (Effort::Thorough, "twice as many")],
        );
        ui.checkbox(&mut self.pairs, "Pairs of rows (interlaced pictures, row inversion)");
        ui.horizontal_wrapped(|ui| {
            let label = ui.label("Save the profile as");
            ui.add(egui::TextEdit::singleline(&mut self.path).desired_width(360.0)).labelled_by(label.id);
        });
        ui.add(egui::Label::new(theme::quiet(self.answers_sentence())).wrap());
    }

    /// Where the answers go, and that those of an earlier time are not gone on with.
    fn answers_sentence(&self) -> String {
        let (earlier, next) = beside(&self.path());
        let next = next.display();
        match earlier {
            None => format!("The answers go into {next}."),
            Some(earlier) => format!(
                "Answers of an earlier time stay in {}, and a matching that was left cannot be gone on with: it begins anew, and the answers go into {next}.",
                earlier.display()
            ),
        }
    }

    fn plan(&self) -> Plan {
        let chosen: Vec<Channel> =
            Channel::ALL.into_iter().zip(self.channels).filter_map(|(channel, on)| on.then_some(channel)).collect();
        let row_px = if self.pairs { 2 } else { 1 };
        Plan { row_px, ..Plan::new(&chosen, self.method, self.pattern, self.effort) }
    }

    fn fault(&self, plan: &Plan) -> Option<String> {
        let [red, green, blue, gray] = self.channels;
        if !(gray || red && green && blue) {
            return Some("A profile needs red, green and blue, or gray.".to_owned());
        }
        if self.path().extension().is_none_or(|extension| extension != "toml") {
            return Some("The profile's name does not end in .toml; expected a file such as display.toml.".to_owned());
        }
        plan.validate().err().map(|error| format!("{error}."))
    }

    fn begin(&self, plan: Plan) -> Result<Trials, String> {
        let now = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |time| time.as_nanos() as u64);
        let seed = session_seed(now);
        let nulling = Nulling::new(plan, seed).map_err(|error| error.to_string())?;
        let file = NullingFile::create_beside(&self.path(), seed).map_err(|error| error.to_string())?;
        Ok(Trials::new(nulling, file))
    }
}

/// A choice of one, its name before it.
fn choice<T: Copy + PartialEq>(ui: &mut egui::Ui, name: &str, chosen: &mut T, all: &[(T, &str)]) {
    ui.horizontal_wrapped(|ui| {
        ui.label(name);
        for (value, text) in all {
            ui.radio_value(chosen, *value, *text);
        }
    });
}

/// From where rows of this period blend.
pub fn distance_sentence(viewing: Option<&Viewing>, period_px: u32) -> String {
    let otherwise = "Nearer than that, half close your eyes or take off your glasses, until no rows are seen.";
    let Some(viewing) = viewing else {
        return format!("Sit so far back that the rows, {period_px} pixels from one to the next, blend. {otherwise}");
    };
    let per_deg = viewing.px_per_degree() / f64::from(period_px.max(1));
    let needed_cm = viewing.distance_cm() * BLEND_PER_DEG / per_deg;
    let from = viewing.distance_cm();
    let counted = format!("periods of rows ({period_px} pixels each) to a degree");
    if per_deg >= BLEND_PER_DEG {
        return format!("From {from:.0} cm there are {per_deg:.0} {counted}: the rows blend.");
    }
    format!(
        "From {from:.0} cm there are {per_deg:.0} {counted}, and the rows may be seen; from {needed_cm:.0} cm on they blend. {otherwise}"
    )
}
