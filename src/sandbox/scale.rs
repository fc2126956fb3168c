//! How large all that lies over the picture is drawn: panel, tools, strip, plots.

use bevy::prelude::*;
use bevy::window::PrimaryWindow;
use bevy_egui::{EguiContext, PrimaryEguiContext};

use super::action::{CarryOut, ScaleChange};
use super::state::Notice;

/// What there is to choose from, percent.
const STEPS: [u16; 8] = [75, 90, 100, 110, 125, 150, 175, 200];

/// The least window that the interface fits into at 100 %, logical pixels.
pub(super) const LEAST_WINDOW: Vec2 = Vec2::new(640.0, 360.0);

/// How large the interface is to be, percent. It is drawn no larger than leaves it the least room that it needs.
#[derive(Resource, Clone, Copy, Debug, PartialEq, Eq)]
pub struct InterfaceScale(pub u16);

impl Default for InterfaceScale {
    fn default() -> Self {
        Self(100)
    }
}

impl InterfaceScale {
    /// The nearest that can be chosen.
    pub(super) fn nearest(percent: u16) -> Self {
        Self(STEPS.into_iter().min_by_key(|step| step.abs_diff(percent)).unwrap_or(100))
    }

    /// How large it is drawn in a window of that size, logical pixels; percent.
    pub(super) fn fitting(self, window: Vec2) -> u16 {
        let room = (window / LEAST_WINDOW).min_element().max(1.0);
        self.0.min((100.0 * room) as u16)
    }
}

pub(super) fn plugin(app: &mut App) {
    app.init_resource::<InterfaceScale>().add_systems(Update, apply.after(CarryOut));
}

/// Makes the interface larger or smaller.
pub(super) fn change(world: &mut World, change: ScaleChange) {
    let Ok(size) = world.query_filtered::<&Window, With<PrimaryWindow>>().single(world).map(Window::size) else {
        return;
    };
    let now = world.resource::<InterfaceScale>().fitting(size);
    let next = match change {
        ScaleChange::Larger => STEPS.into_iter().find(|step| *step > now),
        ScaleChange::Smaller => STEPS.into_iter().rev().find(|step| *step < now),
        ScaleChange::Normal => Some(100),
    };
    let Some(next) = next else { return };
    if InterfaceScale(next).fitting(size) < next {
        let said = format!("the window has no room for an interface at {next} %: make it larger first");
        *world.resource_mut::<Notice>() = Notice::Error(said);
        return;
    }
    world.resource_mut::<InterfaceScale>().set_if_neq(InterfaceScale(next));
}

/// From the next pass on; windows change their size, too.
fn apply(
    scale: Res<InterfaceScale>,
    window: Single<&Window, With<PrimaryWindow>>,
    mut context: Single<&mut EguiContext, With<PrimaryEguiContext>>,
) {
    context.get_mut().set_zoom_factor(f32::from(scale.fitting(window.size())) / 100.0);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_drawn_leaves_room_for_all_that_there_is() {
        for (asked, window, drawn) in [
            (200, LEAST_WINDOW, 100),
            (75, LEAST_WINDOW, 75),
            (200, 2.0 * LEAST_WINDOW, 200),
            (200, LEAST_WINDOW * Vec2::new(4.0, 1.5), 150),
            (150, LEAST_WINDOW * 0.5, 100),
        ] {
            assert_eq!(InterfaceScale(asked).fitting(window), drawn, "{asked} % in {window}");
        }
    }

    #[test]
    fn what_was_remembered_becomes_what_can_be_chosen() {
        for (remembered, chosen) in [(0, 75), (100, 100), (133, 125), (u16::MAX, 200)] {
            assert_eq!(InterfaceScale::nearest(remembered), InterfaceScale(chosen));
        }
    }
}
