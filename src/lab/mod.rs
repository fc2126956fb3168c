//! Measuring: running scenes, metrics, reference answers.
