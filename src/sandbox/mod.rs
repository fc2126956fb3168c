//! The window: picture, camera, drag, panel.
