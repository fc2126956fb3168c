//! Every field of [`SolverSettings`], applied at once.
//!
//! [`FIELDS`] says how each is shown; the widget follows from its type. A unit test holds the
//! list equal to the fields that the type has.

use std::ops::RangeInclusive;

use bevy::prelude::*;
use bevy::reflect::enums::{DynamicEnum, Enum};
use bevy::reflect::structs::Struct;
use bevy::reflect::{PartialReflect, ReflectMut};
use bevy_egui::egui;

use crate::physics::SolverSettings;

/// How a field of [`SolverSettings`] is shown.
struct Field {
    /// Its name in the type.
    name: &'static str,
    /// What the panel calls it.
    label: &'static str,
    /// Unit, after the number.
    unit: &'static str,
    /// Range of the slider.
    slider: RangeInclusive<f64>,
    /// What may be typed; contains the slider's range.
    limits: RangeInclusive<f64>,
    /// Whether the slider is logarithmic.
    logarithmic: bool,
    /// Value that an optional number starts at when it is switched on.
    when_on: f64,
    /// What it is.
    about: &'static str,
}

impl Field {
    /// A choice or a switch.
    const fn choice(name: &'static str, label: &'static str, about: &'static str) -> Self {
        Self { name, label, unit: "", slider: 0.0..=1.0, limits: 0.0..=1.0, logarithmic: false, when_on: 0.0, about }
    }

    /// A number.
    const fn number(
        name: &'static str,
        label: &'static str,
        unit: &'static str,
        slider: RangeInclusive<f64>,
        limits: RangeInclusive<f64>,
        about: &'static str,
    ) -> Self {
        Self { name, label, unit, slider, limits, logarithmic: false, when_on: 0.0, about }
    }

    /// An optional number that starts at `value` when it is switched on.
    const fn or_none(mut self, value: f64) -> Self {
        self.when_on = value;
        self
    }

    /// Lets the slider span decades.
    const fn logarithmic(mut self) -> Self {
        self.logarithmic = true;
        self
    }
}

/// Groups of fields in the order of the panel.
const FIELDS: &[(&str, &[Field])] = &[
    (
        "Time",
        &[
            Field::number(
                "hz",
                "steps per second",
                " Hz",
                10.0..=1000.0,
                1.0..=1e9,
                "Steps per second; the step is h = 1/hz.",
            )
            .logarithmic(),
            Field::number(
                "substeps",
                "substeps",
                "",
                1.0..=32.0,
                1.0..=4096.0,
                "Equal parts a step is cut into. Collision is found once a step; contact depths, joints and rows are \
                 brought up to date each substep.",
            ),
            Field::choice(
                "integrator",
                "integrator",
                "How velocities become poses.\n\nEuler: v += h a, then x += h v with the new v; one solve a \
                 substep.\nVelocity Verlet: kick by h/2, drift by h, kick by h/2; two solves a \
                 substep.\nOf the exact method only: Gauss, of order 8 or 6, implicit; Rattle, of order 2.",
            ),
        ],
    ),
    (
        "Rows",
        &[
            Field::choice(
                "method",
                "method",
                "How contacts and joints are solved.\n\nSoft Step: impulses with soft constraints, then without, in \
                 each substep (Catto 2024); trees of joints exactly.\nSequential Impulses: on velocities, then positions \
                 on their own (Catto 2006); wants 10 iterations and a slop.\nXpbd: positions of small substeps \
                 (Müller et al. 2020); wants 8 substeps or more.\nProjected Gauss Seidel: on force-level rows (Catto \
                 2005).\nPrimed Gauss Seidel: the same, with conjugate residuals where sweeps are slow (Morales et al. \
                 2008).\nNonsmooth Conjugate Gradient: conjugate directions from the same sweeps (Silcowitz et al. \
                 2010).\nExact: joint forces solved directly, in stages of an integrator that converges.",
            ),
            Field::number(
                "iterations",
                "iterations",
                "",
                1.0..=100.0,
                1.0..=100_000.0,
                "Sweeps over all rows in each substep.",
            )
            .logarithmic(),
            Field::choice(
                "warm_starting",
                "warm starting",
                "Whether contact rows start from the forces of the substep before, points found again by feature, \
                 instead of from zero.",
            ),
            Field::choice(
                "fitted_effort",
                "fitted effort",
                "Whether islands at rest are solved directly, once a step, where their bodies make a tree or nearly one \
                 (columns, walls, arches), and not at all while nothing changes; and whether what joints hold takes half \
                 the substeps while it turns slowly. Of the soft step only.",
            ),
            Field::choice(
                "precision",
                "precision",
                "Scalar of rows and solver; poses are 64-bit either way.\n\nF32: single, on quantities relative to \
                 each body.\nF64: double.",
            ),
            Field::number(
                "baumgarte",
                "position repair",
                "",
                0.0..=1.0,
                0.0..=1.0,
                "Share of a position error that one substep aims to remove (Baumgarte's β·h, ODE's error reduction \
                 parameter).",
            ),
            Field::number(
                "correction_speed",
                "repair speed limit",
                " m/s",
                0.0..=10.0,
                0.0..=1e6,
                "Greatest speed at which a contact or joint mends a position error. Off: no limit.",
            )
            .or_none(3.0),
            Field::number(
                "drag",
                "drag",
                " 1/s",
                0.0..=5.0,
                0.0..=1e6,
                "Drag on every body: v ← v/(1 + c h), ω likewise.",
            ),
        ],
    ),
    (
        "Contacts",
        &[
            Field::choice(
                "contacts",
                "contact points",
                "How contact points are found.\n\nExtreme Vertices: those of each shape toward the other, all with \
                 the same depth (the 2009 engine's).\nClipping: the incident face clipped to the reference face, each \
                 point with its own depth; at most 4.",
            ),
            Field::number("slop", "slop", " m", 0.0..=0.05, 0.0..=10.0, "Depth that contacts leave alone."),
            Field::choice(
                "friction",
                "friction",
                "How friction is solved.\n\nOff: no friction rows.\nOne Tangent: along the slip at the start of the \
                 step, |λ| ≤ μ m_c g (the 2009 engine's).\nTwo Tangents: bounded by μ times the contact's own normal \
                 force, updated each sweep.",
            ),
            Field::number(
                "restitution_speed",
                "bounce above",
                " m/s",
                0.0..=5.0,
                0.0..=1e6,
                "Approach speed above which contacts bounce. Off: no contact bounces.",
            )
            .or_none(0.5),
        ],
    ),
    (
        "Collision",
        &[
            Field::choice(
                "broad_phase",
                "broad phase",
                "How pairs that may touch are found, of force-level methods only.\n\nSweep And Sort: \
                 bounding spheres along x, in each step (the 2009 engine's).\nBounding Tree: a tree of boxes a little \
                 larger than their bodies, whose cost follows what moves.",
            ),
            Field::choice("prune_y", "prune on y", "Whether sweep and sort also prunes on y."),
            Field::number(
                "axis_epsilon",
                "axis merging ε",
                "",
                0.0..=0.5,
                0.0..=0.5,
                "Of extreme-vertex contacts: L1 distance within which two candidate axes of the separating axis test count \
                 as one.",
            )
            .logarithmic(),
            Field::choice("merge_opposite_axes", "merge ±axes", "Of extreme-vertex contacts: whether n and −n count as one candidate axis."),
            Field::number(
                "contact_lag",
                "contact lag",
                " steps",
                0.0..=1.0,
                0.0..=1.0,
                "Steps by which the solver's contacts lag behind the poses: 0, or 1 as in the 2009 engine's threaded \
                 loop.",
            ),
            Field::number(
                "sleep_speed",
                "sleep below",
                " m/s",
                0.0..=0.5,
                0.0..=1e6,
                "Speed under which a body counts as calm. Bodies that touch or are joined sleep once all have been calm \
                 for half a second, until something disturbs them. Off: nothing sleeps.",
            )
            .or_none(0.02),
            Field::number(
                "threads",
                "threads",
                "",
                1.0..=16.0,
                1.0..=1024.0,
                "Most threads a step uses, the calling one included; results do not depend on it.",
            ),
        ],
    ),
];

pub(super) fn show(InMut(ui): InMut<egui::Ui>, mut settings: ResMut<SolverSettings>) {
    let mut edited = *settings;
    presets(ui, &mut edited);
    for (group, fields) in FIELDS {
        ui.add_space(4.0);
        ui.weak(*group);
        egui::Grid::new(group).num_columns(2).spacing([8.0, 4.0]).min_col_width(112.0).show(ui, |ui| {
            for field in *fields {
                let value = edited.field_mut(field.name).expect("a test holds FIELDS to the type's fields");
                ui.label(field.label).on_hover_text(field.about);
                widget(ui, field, value);
                ui.end_row();
            }
        });
    }
    settings.set_if_neq(edited.with_method(edited.method));
}

/// Number of fields in which two settings differ.
fn differences(one: &SolverSettings, other: &SolverSettings) -> usize {
    let fields = FIELDS.iter().flat_map(|(_, fields)| fields.iter());
    let differs = |field: &&Field| match (one.field(field.name), other.field(field.name)) {
        (Some(one), Some(other)) => one.reflect_partial_eq(other) != Some(true),
        _ => false,
    };
    fields.filter(differs).count()
}

/// The preset, by index, that the settings differ from in the fewest fields; of several the first.
fn nearest_preset(settings: &SolverSettings) -> usize {
    let from_preset = |&index: &usize| {
        let (_, preset) = SolverSettings::PRESETS[index];
        differences(&preset(), settings)
    };
    (0..SolverSettings::PRESETS.len()).min_by_key(from_preset).unwrap_or_default()
}

/// One button per preset, and whether the settings differ from the nearest.
fn presets(ui: &mut egui::Ui, settings: &mut SolverSettings) {
    let base = nearest_preset(settings);
    let (name, preset) = SolverSettings::PRESETS[base];
    let modified = preset() != *settings;
    ui.horizontal(|ui| {
        ui.label("preset");
        for (index, (name, preset)) in SolverSettings::PRESETS.into_iter().enumerate() {
            if ui.selectable_label(index == base && !modified, name).clicked() {
                *settings = preset();
            }
        }
        if modified {
            ui.colored_label(ui.visuals().warn_fg_color, format!("{name}, modified"));
            if ui.small_button("⟲").on_hover_text(format!("back to {name}")).clicked() {
                *settings = preset();
            }
        }
    });
}

/// The widget for a value of a type that settings are made of.
fn widget(ui: &mut egui::Ui, field: &Field, value: &mut dyn PartialReflect) {
    if let Some(value) = value.try_downcast_mut::<f64>() {
        number(ui, field, value);
    } else if let Some(value) = value.try_downcast_mut::<u32>() {
        whole_number(ui, field, value);
    } else if let Some(value) = value.try_downcast_mut::<bool>() {
        ui.checkbox(value, "").on_hover_text(field.about);
    } else if let Some(value) = value.try_downcast_mut::<Option<f64>>() {
        ui.horizontal(|ui| {
            let mut on = value.is_some();
            ui.checkbox(&mut on, "").on_hover_text(field.about);
            *value = on.then(|| value.unwrap_or(field.when_on));
            match value {
                Some(value) => number(ui, field, value),
                None => drop(ui.weak("off")),
            }
        });
    } else if let ReflectMut::Enum(value) = value.reflect_mut() {
        choice(ui, field, value);
    }
}

fn number(ui: &mut egui::Ui, field: &Field, value: &mut f64) {
    let slider = egui::Slider::new(value, field.slider.clone())
        .suffix(field.unit)
        .logarithmic(field.logarithmic)
        .smallest_positive(1e-4)
        .clamping(egui::SliderClamping::Never)
        .update_while_editing(false)
        .max_decimals(4);
    ui.add(slider).on_hover_text(field.about);
    if !value.is_finite() {
        *value = *field.slider.start();
    }
    *value = value.clamp(*field.limits.start(), *field.limits.end());
}

fn whole_number(ui: &mut egui::Ui, field: &Field, value: &mut u32) {
    let mut real = f64::from(*value);
    let slider = egui::Slider::new(&mut real, field.slider.clone())
        .suffix(field.unit)
        .logarithmic(field.logarithmic)
        .clamping(egui::SliderClamping::Never)
        .update_while_editing(false)
        .integer();
    ui.add(slider).on_hover_text(field.about);
    *value = real.round().clamp(*field.limits.start(), *field.limits.end()) as u32;
}

/// Any enum of unit variants, so that a method added to the solver is in the panel too.
fn choice(ui: &mut egui::Ui, field: &Field, value: &mut dyn Enum) {
    let names = value.get_represented_enum_info().map_or(&[][..], |info| info.variant_names());
    let mut chosen = value.variant_index();
    egui::ComboBox::from_id_salt(field.name)
        .selected_text(spaced(value.variant_name()))
        .width(150.0)
        .show_ui(ui, |ui| {
            for (index, name) in names.iter().enumerate() {
                ui.selectable_value(&mut chosen, index, spaced(name));
            }
        })
        .response
        .on_hover_text(field.about);
    if chosen != value.variant_index() {
        value.apply(&DynamicEnum::new(names[chosen], ()));
    }
}

/// `VelocityVerlet` as `Velocity Verlet`.
fn spaced(variant: &str) -> String {
    let mut text = String::with_capacity(variant.len() + 4);
    for letter in variant.chars() {
        if letter.is_uppercase() && !text.is_empty() {
            text.push(' ');
        }
        text.push(letter);
    }
    text
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use bevy::reflect::{TypeInfo, Typed};

    use super::*;
    use crate::physics::Integrator;

    fn all_fields() -> impl Iterator<Item = &'static Field> {
        FIELDS.iter().flat_map(|(_, fields)| fields.iter())
    }

    #[test]
    fn every_setting_has_exactly_one_widget() {
        let TypeInfo::Struct(info) = SolverSettings::type_info() else { panic!("settings are a struct") };
        let fields: BTreeSet<_> = info.field_names().iter().copied().collect();
        let shown: BTreeSet<_> = all_fields().map(|field| field.name).collect();
        assert_eq!(shown, fields);
        assert_eq!(all_fields().count(), fields.len(), "a field is shown twice");
    }

    #[test]
    fn whatever_the_widgets_allow_is_valid() {
        for field in all_fields() {
            for bound in [field.limits.start(), field.limits.end(), field.slider.start(), field.slider.end()] {
                let mut settings = SolverSettings::default();
                let value = settings.field_mut(field.name).unwrap();
                if let Some(value) = value.try_downcast_mut::<f64>() {
                    *value = *bound;
                } else if let Some(value) = value.try_downcast_mut::<u32>() {
                    *value = *bound as u32;
                } else if let Some(value) = value.try_downcast_mut::<Option<f64>>() {
                    *value = Some(*bound);
                }
                assert_eq!(settings.validate(), Ok(()), "{} at {bound}", field.name);
            }
        }
    }

    /// Draws every widget without a window, with the pointer nowhere: nothing may change, and no
    /// type of field may be without a widget.
    #[test]
    fn drawing_changes_nothing() {
        let context = egui::Context::default();
        for (_, preset) in SolverSettings::PRESETS {
            let mut settings = preset();
            let _ = context.run_ui(egui::RawInput::default(), |ui| {
                for field in all_fields() {
                    let before = ui.min_rect();
                    ui.push_id(field.name, |ui| widget(ui, field, settings.field_mut(field.name).unwrap()));
                    assert_ne!(ui.min_rect(), before, "{} has no widget for its type", field.name);
                }
            });
            assert_eq!(settings, preset());
        }
    }

    #[test]
    fn modified_settings_go_by_the_nearest_preset() {
        let name = |settings: SolverSettings| SolverSettings::PRESETS[nearest_preset(&settings)].0;
        let vary = |settings: SolverSettings| SolverSettings {
            hz: 240.0,
            substeps: 7,
            iterations: 20,
            threads: 3,
            drag: 0.5,
            ..settings
        };
        for (preset, settings) in SolverSettings::PRESETS {
            assert_eq!(differences(&settings(), &settings()), 0);
            assert_eq!(differences(&vary(settings()), &settings()), 5);
            assert_eq!(name(settings()), preset);
            assert_eq!(name(vary(settings())), preset);
        }
    }

    #[test]
    fn a_choice_is_applied_by_its_variant_name() {
        let mut integrator = Integrator::Euler;
        integrator.apply(&DynamicEnum::new("VelocityVerlet", ()));
        assert_eq!(integrator, Integrator::VelocityVerlet);
        assert_eq!(spaced("VelocityVerlet"), "Velocity Verlet");
        assert_eq!(spaced("F32"), "F32");
    }
}
