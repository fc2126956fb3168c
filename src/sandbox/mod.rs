//! The window: picture, camera, drag, building, panel.
//!
//! Keys ([`controls::BINDINGS`]) and the buttons of the panel write the same [`SandboxAction`]s,
//! carried out in one place; the panel shows [`CurrentScene`], [`Playback`] and [`Notice`], and works
//! on the physics resources themselves.
//!
//! A frame: `PreUpdate` picks and reads keys; before the fixed loop the camera's [`RenderOrigin`]
//! and the drag's target are brought up to date; the fixed loop steps; `Update` carries out
//! actions and gives new bodies their meshes; `PostUpdate` runs camera and panel.
//!
//! [`RenderOrigin`]: crate::physics::RenderOrigin

mod action;
mod aimed;
mod any_joint;
mod axes;
mod box_select;
mod build;
mod camera;
mod carry_out;
mod clipboard;
mod commands;
pub mod controls;
mod drag;
mod dropping;
mod files;
mod film;
mod follow;
mod ghost;
mod gizmos;
mod glyphs;
mod ground;
mod handles;
mod headless;
mod held;
mod help;
mod highlight;
mod in_front;
mod joint_click;
mod joint_readings;
mod light;
mod looked_at;
mod meshes;
mod monkey;
mod motor_keys;
mod panel;
mod playback;
mod plots;
mod plugin;
mod pointer;
mod probe;
mod quality;
mod recent;
mod recordings;
mod reload;
mod scale;
mod screenshot;
mod sky;
mod snap;
mod state;
mod timeline;
mod tool;
mod tools;
mod watch;
mod why;
mod window;
mod window_memory;
mod without_ground;

pub use action::{SandboxAction, ScaleChange};
pub use build::{Blueprint, Hills, JoinKind, JointChange, MeshForm, Placement, Weight};
pub use clipboard::Clipboard;
pub use commands::{SandboxCommandError, film, monkey};
pub use film::{FilmError, Filmed, shoot};
pub use ghost::{Apart, GhostChoice, GhostReading, GhostReadings, Ghosts, MOST_GHOSTS, Reading};
pub use gizmos::ShownGizmos;
pub use headless::Hands;
pub use monkey::{Failure, Played, play};
pub use panel::{ChartSource, Page, PanelOpen, PanelWidth};
pub use playback::StepBudget;
pub use plugin::SandboxPlugin;
pub use probe::{Row, Track, Tracks};
pub use recent::RecentFiles;
pub use scale::InterfaceScale;
pub use snap::Snap;
pub use state::{CurrentScene, Notice, Picked, Playback, Selection, ShowsPlots};
pub use timeline::{ShownStep, Timeline};
pub use tool::Tool;
pub use why::ColorBy;
pub use window::{Launch, LaunchError, launch};
pub use window_memory::{MemoryFile, ViewOfScene, WindowMemory};
