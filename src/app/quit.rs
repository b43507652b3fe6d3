//! The question before the window is closed during a session.

use eframe::egui::{Context, Frame, Id, Modal, ViewportCommand};

use super::{
    session::Runner,
    ui::{
        primary,
        theme::{GAP, MARGIN},
    },
};

/// Width of the question, points.
const WIDTH: f32 = 480.0;

/// The state of the question.
#[derive(Default)]
pub struct Quit {
    asked: bool,
    agreed: bool,
}

impl Quit {
    /// Handles a request to close the window, and draws the question if there is one. Closing the window a second time
    /// answers it. While an answer is only in memory, the window cannot be closed, because it would be lost.
    pub fn show(&mut self, ctx: &Context, session: Option<&mut Runner>) {
        let requested = ctx.input(|input| input.viewport().close_requested());
        let Some(session) = session.filter(|session| session.is_running()) else {
            self.asked = false;
            return;
        };
        let again = requested && self.asked;
        if requested && (session.is_unsaved() || !(again || self.agreed)) {
            ctx.send_viewport_cmd(ViewportCommand::CancelClose);
            self.asked = !session.is_unsaved();
            session.pause(ctx);
        }
        if !self.asked {
            return;
        }
        let frame = Frame::popup(&ctx.global_style()).inner_margin(MARGIN);
        let modal = Modal::new(Id::unique("quit")).frame(frame).show(ctx, |ui| {
            ui.set_width(WIDTH.min(ctx.content_rect().width() - 4.0 * MARGIN));
            ui.heading("Quit during the session?");
            ui.label(session.how_to_resume());
            ui.add_space(GAP);
            let stay = primary(ui, "Continue the session", true, "Esc");
            (stay, ui.button("Quit").clicked())
        });
        let (stay, quit) = modal.inner;
        if stay || modal.should_close() {
            self.asked = false;
        } else if quit {
            self.agreed = true;
            ctx.send_viewport_cmd(ViewportCommand::Close);
        }
    }
}
