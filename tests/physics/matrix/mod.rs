//! What every method must do: one file a property, each with a table of what it expects of every method and why.
//!
//! A new method is a variant of [`Engine`]; the tables then do not compile until each states what it expects of it.

mod friction;
mod gap;
mod gyroscopic;
mod joints;
mod momentum;
mod quarantine;
mod springs;
mod threads;

use bevy::reflect::{TypeInfo, Typed};
use plumb::prelude::*;

/// A method with the settings that it is meant for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Engine {
    /// `pgs` as in 2009.
    Classic,
    /// `pgs` with the settings that hold best.
    Steady,
    /// `cg_pgs`.
    Primed,
    /// `nncg`.
    Nonsmooth,
    /// `soft_step`.
    Game,
    /// `sequential_impulses`.
    Sequential,
    /// `xpbd`.
    Xpbd,
    /// `exact`.
    Accurate,
}

use Engine::*;

pub const ENGINES: [Engine; 8] = [Classic, Steady, Primed, Nonsmooth, Game, Sequential, Xpbd, Accurate];

impl Engine {
    pub fn settings(self) -> SolverSettings {
        match self {
            Classic => SolverSettings::classic(),
            Steady => SolverSettings::steady(),
            Primed => SolverSettings { method: Method::PrimedGaussSeidel, ..SolverSettings::steady() },
            Nonsmooth => SolverSettings { method: Method::NonsmoothConjugateGradient, ..SolverSettings::steady() },
            Game => SolverSettings::game(),
            Sequential => SolverSettings::sequential_impulses(),
            Xpbd => SolverSettings::xpbd(),
            Accurate => SolverSettings::accurate(),
        }
    }
}

#[test]
fn every_method_and_every_preset_is_in_the_matrix() {
    let TypeInfo::Enum(methods) = Method::type_info() else { unreachable!("methods are a choice") };
    let tested: Vec<String> = ENGINES.iter().map(|engine| format!("{:?}", engine.settings().method)).collect();
    // Sweeps in joint space are on their way out.
    for method in methods.variant_names().iter().filter(|method| **method != "JointSpace") {
        assert!(tested.iter().any(|known| known == method), "the method {method} is not in the matrix");
    }
    for (name, preset) in SolverSettings::PRESETS {
        assert!(ENGINES.iter().any(|engine| engine.settings() == preset()), "the preset {name} is not in the matrix");
    }
}
