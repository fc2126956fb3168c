//! The tools beside the picture.

use std::sync::LazyLock;

use bevy::math::DVec3;
use bevy::prelude::*;
use bevy_egui::{EguiContexts, egui};

use super::buttons::tooltip;
use super::icons::{self, Icon};
use super::strip::STRIP_HEIGHT;
use crate::sandbox::state::Covered;
use crate::sandbox::{Blueprint, CurrentScene, JoinKind, MeshForm, SandboxAction, Tool};
use crate::scene::ShapeSpec;

/// Side of a button, and of one where there is no room for all in so many columns, points.
const BUTTON: f32 = 30.0;
const SMALL_BUTTON: f32 = 24.0;
const COLUMNS: usize = 4;
const SPACING: f32 = 3.0;
const MARGIN: f32 = 8.0;
/// Where there is room beside the tools in two columns, points from the left.
pub(in crate::sandbox) const BESIDE_TOOLS: f32 = 2.0 * (BUTTON + SPACING) + 4.0 * MARGIN;
/// Room at the top, for what is said there.
const TOP: f32 = 52.0;

/// Shapes that a button takes in hand: the name, the picture, and what each starts as.
pub(super) const SHAPES: [(&str, Icon, ShapeSpec); 5] = [
    ("ball", icons::BALL, ShapeSpec::Sphere { radius: 0.25 }),
    ("box", icons::BOX, ShapeSpec::Cuboid { size: DVec3::splat(0.5) }),
    ("capsule", icons::CAPSULE, ShapeSpec::Capsule { radius: 0.2, length: 0.4 }),
    ("cylinder", icons::CYLINDER, ShapeSpec::Cylinder { radius: 0.25, height: 0.4 }),
    ("cone", icons::CONE, ShapeSpec::Cone { radius: 0.25, height: 0.6 }),
];
/// The mesh that has a button.
const GEM: &str = "plumb:gem.obj";

/// What a button takes in hand.
enum Choice {
    /// Nothing: it is done at once.
    Action(SandboxAction),
    Tool(Tool),
    Shape(ShapeSpec),
    Gem,
    Joint(JoinKind),
}

struct Entry {
    icon: Icon,
    name: &'static str,
    choice: Choice,
}

/// The buttons, in the order of the toolbar.
static ENTRIES: LazyLock<Vec<Entry>> = LazyLock::new(entries);

fn entries() -> Vec<Entry> {
    let tool = |tool: Tool, icon| {
        let name = Tool::ALL.iter().find(|(other, ..)| *other == tool).map_or("", |(_, name, _)| name);
        Entry { icon, name, choice: Choice::Tool(tool) }
    };
    let icon_of = |kind| match kind {
        JoinKind::Ball => icons::BALL_JOINT,
        JoinKind::Hinge => icons::HINGE,
        JoinKind::Slider => icons::SLIDER,
        JoinKind::Fixed => icons::FIXED,
        JoinKind::Rod => icons::ROD,
        JoinKind::Rope => icons::ROPE,
        JoinKind::Spring => icons::SPRING,
    };
    let mut all = vec![
        tool(Tool::Drag, icons::DRAG),
        tool(Tool::Move, icons::MOVE),
        tool(Tool::Turn, icons::TURN),
        tool(Tool::Scale, icons::SCALE),
        tool(Tool::Push, icons::PUSH),
        tool(Tool::Throw, icons::THROW),
        tool(Tool::Bar, icons::BAR),
    ];
    all.extend(SHAPES.map(|(name, icon, shape)| Entry { icon, name, choice: Choice::Shape(shape) }));
    all.push(Entry { icon: icons::GEM, name: "gem", choice: Choice::Gem });
    all.extend(JoinKind::ALL.map(|(kind, name, _)| Entry { icon: icon_of(kind), name, choice: Choice::Joint(kind) }));
    all.extend([tool(Tool::Pin, icons::PIN), tool(Tool::Cut, icons::CUT), tool(Tool::Measure, icons::MEASURE)]);
    for (name, icon, action) in
        [("photo", icons::PHOTO, SandboxAction::Screenshot), ("help", icons::HELP, SandboxAction::ToggleHelp)]
    {
        all.push(Entry { icon, name, choice: Choice::Action(action) });
    }
    all
}

pub(super) fn show(
    mut contexts: EguiContexts,
    scene: Option<Res<CurrentScene>>,
    tool: Res<Tool>,
    mut blueprint: ResMut<Blueprint>,
    mut kind: ResMut<JoinKind>,
    covered: Res<Covered>,
    mut actions: MessageWriter<SandboxAction>,
) -> Result {
    if scene.is_none() {
        return Ok(());
    }
    let context = contexts.ctx_mut()?;
    let entries = &*ENTRIES;
    let [panel, plots] = covered.in_points(context);
    let room = context.content_rect().height() - TOP - STRIP_HEIGHT - plots - 3.0 * MARGIN;
    let beside = context.content_rect().width() - panel - 4.0 * MARGIN;
    let size = (room / entries.len().div_ceil(COLUMNS) as f32 - SPACING).clamp(SMALL_BUTTON, BUTTON);
    let [most_rows, most_columns] = [room, beside].map(|room| ((room / (size + SPACING)) as usize).max(1));
    // Rather over the plots than over the panel.
    let rows = most_rows.min(entries.len().div_ceil(2)).max(entries.len().div_ceil(most_columns));
    let area = egui::Area::new(egui::Id::new("tools")).fixed_pos([MARGIN, TOP]).constrain(false);
    area.show(context, |ui| {
        egui::Frame::popup(ui.style()).inner_margin(4.0).show(ui, |ui| {
            ui.spacing_mut().item_spacing = egui::Vec2::splat(SPACING);
            let columns = entries.len().div_ceil(rows);
            for row in entries.chunks(columns) {
                ui.horizontal(|ui| {
                    for entry in row {
                        let is_chosen = is_chosen(&entry.choice, *tool, &blueprint, *kind);
                        if button(ui, entry, is_chosen, size).clicked() {
                            take(&entry.choice, &mut blueprint, &mut kind, &mut actions);
                        }
                    }
                });
            }
        });
    });
    Ok(())
}

fn is_chosen(choice: &Choice, tool: Tool, blueprint: &Blueprint, kind: JoinKind) -> bool {
    match choice {
        Choice::Action(_) => false,
        Choice::Tool(own) => tool == *own,
        Choice::Shape(shape) => tool == Tool::Add && is_alike(shape, &blueprint.shape),
        Choice::Gem => tool == Tool::Add && is_gem(&blueprint.shape),
        Choice::Joint(own) => tool == Tool::Join && kind == *own,
    }
}

/// Whether two shapes are of a kind.
pub(super) fn is_alike(one: &ShapeSpec, other: &ShapeSpec) -> bool {
    std::mem::discriminant(one) == std::mem::discriminant(other)
}

fn is_gem(shape: &ShapeSpec) -> bool {
    matches!(shape, ShapeSpec::Mesh(mesh) if mesh.file() == GEM)
}

fn take(
    choice: &Choice,
    blueprint: &mut ResMut<Blueprint>,
    kind: &mut ResMut<JoinKind>,
    actions: &mut MessageWriter<SandboxAction>,
) {
    let tool = match choice {
        Choice::Action(action) => {
            actions.write(action.clone());
            return;
        }
        Choice::Tool(tool) => *tool,
        Choice::Shape(shape) => {
            // One of that kind keeps its size.
            if !is_alike(shape, &blueprint.shape) {
                blueprint.shape = shape.clone();
            }
            Tool::Add
        }
        Choice::Gem => {
            if !is_gem(&blueprint.shape) {
                actions.write(SandboxAction::ChooseMesh { file: GEM.into(), scale: 0.5, form: MeshForm::Hull });
            }
            Tool::Add
        }
        Choice::Joint(own) => {
            kind.set_if_neq(*own);
            Tool::Join
        }
    };
    actions.write(SandboxAction::ChooseTool(tool));
}

fn button(ui: &mut egui::Ui, entry: &Entry, is_chosen: bool, size: f32) -> egui::Response {
    let (square, response) = ui.allocate_exact_size(egui::Vec2::splat(size), egui::Sense::click());
    let visuals = ui.style().interact_selectable(&response, is_chosen);
    ui.painter().rect_filled(square, 4.0, visuals.weak_bg_fill);
    icons::paint(ui.painter(), entry.icon, square.shrink(4.0), visuals.text_color());
    response.widget_info(|| egui::WidgetInfo::selected(egui::WidgetType::Button, true, is_chosen, entry.name));
    // Beside the tools, not over those below.
    let mut tip = egui::Tooltip::for_enabled(&response);
    tip.popup = tip.popup.align(egui::RectAlign::RIGHT_START);
    tip.show(|ui| _ = ui.label(about(entry)));
    response
}

fn about(entry: &Entry) -> String {
    let of_tool = |tool: Tool| tooltip(&SandboxAction::ChooseTool(tool));
    match &entry.choice {
        Choice::Action(action) => tooltip(action),
        Choice::Tool(tool) => format!("{}\n{}", of_tool(*tool), tool.about()),
        Choice::Shape(_) | Choice::Gem => {
            format!("add a {}: {}\nits size is in 'Build'", entry.name, of_tool(Tool::Add))
        }
        Choice::Joint(kind) => {
            let about = JoinKind::ALL.iter().find(|(other, ..)| other == kind).map_or("", |(_, _, about)| about);
            format!("join by a {}: {about}\n{}", entry.name, of_tool(Tool::Join))
        }
    }
}
