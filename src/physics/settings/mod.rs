//! Every number and choice of the step: what each is ([`choices`], [`solver_settings`]), which method reads it, and what
//! a user wrote of them ([`written`]). The docs of the fields and choices are also the panel's and the command line's
//! help: the macros of [`described`] keep them as text.

mod choices;
mod described;
mod solver_settings;
mod written;

pub use choices::{ContactModel, ExactIntegrator, FrictionModel, Integrator, Method, Precision};
pub use described::{Choice, Choices};
pub use solver_settings::{
    ExactSettings, Gravity, ImpulseSettings, SETTINGS, Setting, SettingsError, SolverSettings, SweepSettings,
};
pub(crate) use solver_settings::{contacts_are_of_2009, contacts_last};
pub use written::WrittenSettings;
