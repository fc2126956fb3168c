//! What the next body is of its mesh: how large, and its hull, its pieces or its surface.

use bevy_egui::egui;

use super::buttons::toggle;
use super::let_go::once_let_go;
use super::theme::Quantity;
use crate::physics::Compound;
use crate::sandbox::{MeshForm, SandboxAction};
use crate::scene::{MOST_PIECES, ShapeSpec};

/// Factors on a mesh.
const SCALES: std::ops::RangeInclusive<f64> = 1e-4..=1e4;

/// What the widgets hold while it is being changed.
#[derive(Default)]
pub(super) struct MeshRows {
    scale: Option<f64>,
    pieces: Option<u32>,
}

impl MeshRows {
    /// Of a shape that is of a mesh file; none of others. What is asked for.
    pub fn show(&mut self, ui: &mut egui::Ui, shape: &ShapeSpec) -> Option<SandboxAction> {
        let (file, scale, form) = MeshForm::of(shape)?;
        let scaled = ui.horizontal(|ui| {
            ui.label("scale");
            let speed = 0.01 * self.scale.unwrap_or(scale);
            let scaled = once_let_go(ui, scale, &mut self.scale, |edited| {
                egui::DragValue::new(edited).range(SCALES).speed(speed).max_decimals(4)
            });
            ui.weak(match shape {
                ShapeSpec::Mesh(mesh) => format!("{} across", Quantity::text(2.0 * mesh.hull().bounding_radius(), "m")),
                ShapeSpec::Surface(surface) => format!("{} triangles", surface.mesh().triangles().len()),
                _ => String::new(),
            });
            scaled
        });
        let formed = ui.horizontal(|ui| self.form(ui, form, shape.compound()));
        let (scaled, formed) = (scaled.inner, formed.inner);
        let is_asked = scaled.is_some() || formed.is_some();
        is_asked.then(|| SandboxAction::ChooseMesh {
            file: file.into(),
            scale: scaled.unwrap_or(scale),
            form: formed.unwrap_or(form),
        })
    }

    fn form(&mut self, ui: &mut egui::Ui, form: MeshForm, pieces: Option<&Compound>) -> Option<MeshForm> {
        ui.spacing_mut().item_spacing.x = 2.0;
        ui.label("as");
        let mut asked = None;
        let choices = [
            ("hull", MeshForm::Hull, "what is spanned about it: fast, but a bowl holds nothing"),
            (
                "pieces",
                MeshForm::Pieces(MeshForm::USUAL_PIECES),
                "cut in convex pieces, which takes a moment: what is hollow stays hollow",
            ),
            (
                "surface",
                MeshForm::Surface { two_sided: false },
                "its very triangles, fixed: what others stand on; it has no mass",
            ),
        ];
        for (name, choice, about) in choices {
            let is_chosen = std::mem::discriminant(&form) == std::mem::discriminant(&choice);
            if ui.selectable_label(is_chosen, name).on_hover_text(about).clicked() && !is_chosen {
                asked = Some(choice);
            }
        }
        ui.add_space(6.0);
        match form {
            MeshForm::Hull => {}
            MeshForm::Pieces(most) => {
                let most = once_let_go(ui, most, &mut self.pieces, |edited| {
                    egui::DragValue::new(edited).prefix("at most ").range(2..=MOST_PIECES).speed(0.1)
                });
                asked = asked.or(most.map(MeshForm::Pieces));
                let made = pieces.map_or(0, |pieces| pieces.children().len());
                ui.weak(format!(" makes {made}")).on_hover_text("so many pieces come near enough to it");
            }
            MeshForm::Surface { two_sided } => {
                let about = "whether the backs of its triangles are solid, too";
                if ui.add(toggle(ui, two_sided, "two-sided")).on_hover_text(about).clicked() {
                    asked = Some(MeshForm::Surface { two_sided: !two_sided });
                }
            }
        }
        asked
    }
}
