//! Headless system tests of the physics plugin, one module a subject.

mod allocations;
mod arrows;
mod at_rest;
mod classic;
mod cones;
mod determinism;
mod endurance;
mod exact;
mod far;
mod fast_bodies;
mod free_motion;
mod friction;
mod gradients;
mod hulls;
mod impact;
mod joints_and_contacts;
mod lasting_contacts;
mod messages;
mod methods;
mod pendulum;
mod public_face;
mod quarantine;
mod resting;
mod rig;
mod sleeping;
mod transforms;
