//! Headless system tests of the physics plugin, one module a subject.

mod arrows;
mod smoke;
