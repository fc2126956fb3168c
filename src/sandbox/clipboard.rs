//! What was copied: the system's clipboard where there is one, else the program's own.

use std::sync::Mutex;

use bevy::prelude::*;

/// A text that was copied.
#[derive(Resource, Default)]
pub struct Clipboard {
    own: Option<String>,
    system: Option<Mutex<arboard::Clipboard>>,
}

impl Clipboard {
    /// That of the system, if there is one: what other programs copied can be pasted then, and the other way round.
    pub(super) fn of_system() -> Self {
        Self { own: None, system: arboard::Clipboard::new().ok().map(Mutex::new) }
    }

    /// Copies a text.
    pub fn set(&mut self, text: String) {
        if let Some(Ok(system)) = self.system.as_mut().map(Mutex::get_mut) {
            // Its own is kept in any case.
            system.set_text(text.clone()).ok();
        }
        self.own = Some(text);
    }

    /// What was copied last.
    pub fn get(&mut self) -> Option<String> {
        let system = self.system.as_mut().and_then(|system| system.get_mut().ok()?.get_text().ok());
        system.or_else(|| self.own.clone())
    }
}

pub(super) fn plugin(app: &mut App) {
    app.init_resource::<Clipboard>();
}
