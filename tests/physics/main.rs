//! Headless system tests of the physics plugin, one module a subject.

mod smoke;

mod arrows;
