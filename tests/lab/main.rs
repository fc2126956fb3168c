//! Tests of scenes, measuring and the command line, one module a subject.

mod accurate;
mod accurate_contact;
mod command_line;
mod export;
mod heavy;
mod joint_errors;
mod joint_metrics;
mod machines;
mod metrics;
mod race;
mod recording;
mod references;
mod run;
mod scene_builtin;
mod scene_errors;
mod scene_format;
mod scene_meshes;
mod scene_overlap;
mod scene_parts;
mod settings_page;
mod stability;
mod standing;
mod sweeps;
mod the_2009_engine;
mod truth;
mod varying;
