//! Tests of the window: picking and dragging, without a display and with one.
