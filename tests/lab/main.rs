//! Tests of scenes, measuring and the command line, one module a subject.

mod scene_builtin;
