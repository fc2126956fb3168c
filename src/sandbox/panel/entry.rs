//! Lines in which something is typed that may turn out to be wrong.

use bevy_egui::egui;

/// What was typed and cannot be taken, in one line: kept till the notice shows it.
#[derive(Clone, Debug, Default, PartialEq)]
struct Refused(String);

/// Says that what was typed is not taken.
pub(super) fn refuse(context: &egui::Context, reason: String) {
    context.data_mut(|data| data.insert_temp(egui::Id::NULL, Refused(reason)));
}

/// What was refused since the last call.
pub(super) fn take_refused(context: &egui::Context) -> Option<String> {
    context.data_mut(|data| data.remove_temp::<Refused>(egui::Id::NULL)).map(|Refused(reason)| reason)
}

/// A number as it is typed, with or without its unit; what is none is refused.
pub(super) fn number(context: &egui::Context, text: &str, suffix: &str) -> Option<f64> {
    let bare = text.trim().trim_end_matches(suffix.trim()).trim().replace('−', "-");
    let number = bare.parse().ok().filter(|number: &f64| !number.is_nan());
    if number.is_none() {
        refuse(context, format!("'{}' is not a number: the value stays as it was", text.trim()));
    }
    number
}

/// How a line was left.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Left {
    ByEnter,
    Otherwise,
}

/// Whether what was typed and entered is still to be judged. Until it is found good the line keeps the focus: what is
/// typed next mends it, and does not act as keys do.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Entered(bool);

impl Entered {
    /// The line; tells whether it was left just now, and how.
    pub fn show(&mut self, ui: &mut egui::Ui, id: egui::Id, line: egui::TextEdit) -> Option<Left> {
        let response = ui.add(line.id(id));
        if !response.lost_focus() {
            return None;
        }
        if !ui.input(|input| input.key_pressed(egui::Key::Enter)) {
            return Some(Left::Otherwise);
        }
        response.request_focus();
        self.0 = true;
        Some(Left::ByEnter)
    }

    /// What was entered is good: the line is left.
    pub fn accept(&mut self, context: &egui::Context, id: egui::Id) {
        if std::mem::take(&mut self.0) {
            context.memory_mut(|memory| memory.surrender_focus(id));
        }
    }
}
