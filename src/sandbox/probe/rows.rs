//! What can be plotted of something, as rows of buttons.

use bevy::prelude::*;
use bevy_egui::egui;

use super::reader::{Reader, Watched, WatchedPoint, WatchedSubject};
use crate::scene::{MAX_PROBES, Probe, ProbePlot, ProbePoint, ProbeSubject, Probes};

const PLACE: [ProbePlot; 3] = [ProbePlot::X, ProbePlot::Y, ProbePlot::Z];
const VELOCITY: [ProbePlot; 4] = [ProbePlot::VelocityX, ProbePlot::VelocityY, ProbePlot::VelocityZ, ProbePlot::Speed];
const ENERGY: [ProbePlot; 3] = [ProbePlot::KineticEnergy, ProbePlot::PotentialEnergy, ProbePlot::Energy];
const CONTACT: [ProbePlot; 4] =
    [ProbePlot::ContactForceX, ProbePlot::ContactForceY, ProbePlot::ContactForceZ, ProbePlot::ContactForce];
const LOAD: [ProbePlot; 2] = [ProbePlot::Force, ProbePlot::Torque];

/// A button that is lit while there is that probe.
pub fn toggle(ui: &mut egui::Ui, probes: &mut ResMut<Probes>, probe: Watched, label: &str, about: &str) {
    let is_on = probes.0.contains(&probe);
    let is_full = !is_on && probes.0.len() >= MAX_PROBES;
    let button = ui.add_enabled(!is_full, egui::Button::new(label).selected(is_on));
    let full = format!("there are {MAX_PROBES} probes already: take some away");
    if button.on_hover_text(about).on_disabled_hover_text(full).clicked() {
        match is_on {
            true => probes.0.retain(|there| *there != probe),
            false => probes.0.push(probe),
        }
    }
}

fn row(
    ui: &mut egui::Ui,
    probes: &mut ResMut<Probes>,
    subject: WatchedSubject,
    (title, plots, about): (&str, &[ProbePlot], &str),
) {
    ui.label(title).on_hover_text(about);
    ui.horizontal(|ui| {
        for plot in plots {
            toggle(ui, probes, Probe::Plot(subject, *plot), plot.label(), about);
        }
    });
    ui.end_row();
}

fn grid(ui: &mut egui::Ui, id: &str, rows: impl FnOnce(&mut egui::Ui)) {
    egui::Grid::new(id).num_columns(2).spacing([8.0, 4.0]).show(ui, rows);
}

/// Of a body: its centre of mass, and what it has as a whole.
pub fn body(ui: &mut egui::Ui, probes: &mut ResMut<Probes>, body: Entity) {
    let subject = ProbeSubject::Point(ProbePoint::center(body));
    grid(ui, "of the body", |ui| {
        row(ui, probes, subject, ("position", &PLACE, "of the center of mass, m"));
        row(ui, probes, subject, ("velocity", &VELOCITY, "of the center of mass, m/s"));
        row(ui, probes, subject, ("turning", &[ProbePlot::Spin], "angular speed, rad/s"));
        row(ui, probes, subject, ("energy", &ENERGY, "kinetic, potential (0 at the world's origin), and their sum, J"));
        let about = "sum of the forces of all contacts on the body, mean over the step, N. While it is read, what rests is \
                     solved in every step, not left as it is: that may change the last bits";
        row(ui, probes, subject, ("contacts", &CONTACT, about));
    });
}

/// Of a point of a body.
pub fn point(ui: &mut egui::Ui, probes: &mut ResMut<Probes>, point: WatchedPoint) {
    let subject = ProbeSubject::Point(point);
    grid(ui, "of the point", |ui| {
        row(ui, probes, subject, ("position", &PLACE, "of the very point of the body that was clicked, m"));
        row(ui, probes, subject, ("velocity", &VELOCITY, "of the very point of the body that was clicked, m/s"));
    });
}

/// Of a joint.
pub fn joint(ui: &mut egui::Ui, probes: &mut ResMut<Probes>, reader: &Reader, joint: Entity) {
    let subject = ProbeSubject::Joint(joint);
    grid(ui, "of the joint", |ui| {
        row(ui, probes, subject, ("load", &LOAD, "what the joint carries: force, N, and torque about its point, N·m"));
        if reader.axis_of(joint).is_some() {
            row(ui, probes, subject, ("stands at", &[ProbePlot::Coordinate], "along or about its axis, m or °"));
        }
        row(ui, probes, subject, ("apart", &[ProbePlot::Gap], "by how far what it holds is apart, m"));
    });
}

/// Of the whole scene.
pub fn scene(ui: &mut egui::Ui, probes: &mut ResMut<Probes>) {
    let subject = ProbeSubject::Scene;
    grid(ui, "of the scene", |ui| {
        row(
            ui,
            probes,
            subject,
            ("energy", &ENERGY, "of all bodies: kinetic, potential (0 at the origin), their sum, J"),
        );
        let errors = [ProbePlot::Gap, ProbePlot::Overlap];
        row(ui, probes, subject, ("errors", &errors, "largest gap of a joint and largest depth of a contact, m"));
        let costs = [ProbePlot::StepTime, ProbePlot::Contacts];
        row(ui, probes, subject, ("cost", &costs, "wall-clock time of a step, s, and contact points"));
    });
}

/// The menu of something that is shown, on a right click: to plot that.
pub fn offer(response: &egui::Response, probes: &mut ResMut<Probes>, offered: &[Watched]) {
    if offered.is_empty() {
        return;
    }
    response.context_menu(|ui| {
        for probe in offered {
            if let Probe::Plot(_, plot) = probe {
                toggle(ui, probes, *probe, &format!("plot {}", plot.label()), "as a probe");
            }
        }
    });
}
