//! Tests of the window: picking and dragging, without a display and with one.

mod actions;
mod building;
mod chart;
mod dragging;
mod eyes;
mod files;
mod film;
mod following;
mod ghosts;
mod joint_kinds;
mod keys;
mod monkey;
mod motors;
mod pace;
mod panel;
mod picture;
mod pictures;
mod probes;
mod redo;
mod rough_hands;
mod stage;
mod startup;
mod sweep;
mod timeline;
mod why;
mod window;
