//! What the next body is to be.

use std::path::Path;

use bevy::math::DVec3;
use bevy::prelude::*;

use crate::sandbox::state::report;
use crate::scene::{BodySpec, MeshSpec, ShapeSpec, builtin_meshes};

/// What [`SandboxAction::SpawnBody`](crate::sandbox::SandboxAction::SpawnBody) makes.
#[derive(Resource, Clone, Debug, PartialEq)]
pub struct Blueprint {
    /// Shape with its sizes, m.
    pub shape: ShapeSpec,
    /// How heavy it is.
    pub weight: Weight,
}

/// How a body's mass is given.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Weight {
    /// kg/m³.
    Density(f64),
    /// kg.
    Mass(f64),
}

impl Default for Blueprint {
    fn default() -> Self {
        Self { shape: ShapeSpec::Cuboid { size: DVec3::splat(0.5) }, weight: Weight::Density(1000.0) }
    }
}

impl Blueprint {
    /// kg.
    pub fn mass(&self) -> f64 {
        match self.weight {
            Weight::Density(density) => density * self.shape.volume(),
            Weight::Mass(mass) => mass,
        }
    }

    /// What bodies of it are called, before a number is added.
    pub(super) fn noun(&self) -> &str {
        match &self.shape {
            ShapeSpec::Sphere { .. } => "ball",
            ShapeSpec::Cuboid { .. } => "box",
            ShapeSpec::Capsule { .. } => "capsule",
            ShapeSpec::Cylinder { .. } => "cylinder",
            ShapeSpec::Cone { .. } => "cone",
            ShapeSpec::HalfSpace => "ground",
            ShapeSpec::Hull(_) => "block",
            ShapeSpec::Compound(_) => "compound",
            ShapeSpec::Surface(_) => "surface",
            ShapeSpec::Mesh(mesh) => stem(mesh.file()),
        }
    }

    /// A body of it at the origin.
    pub(super) fn body(&self, name: String) -> BodySpec {
        let body = BodySpec::new(name, self.shape.clone(), DVec3::ZERO);
        match self.weight {
            Weight::Density(density) => BodySpec { density, ..body },
            Weight::Mass(mass) => body.with_mass(mass),
        }
    }
}

/// The name of a mesh without folder, ending and `plumb:`.
pub fn stem(file: &str) -> &str {
    let name = file.rsplit(['/', '\\', ':']).next().unwrap_or(file);
    name.strip_suffix(".obj").unwrap_or(name)
}

/// Makes the next body a mesh: one that comes with Plumb, or an OBJ file. Whether it is one now.
pub fn choose_mesh(world: &mut World, file: &str, scale: f64) -> bool {
    let outcome = load_mesh(file, scale).map(|mesh| {
        world.resource_mut::<Blueprint>().shape = ShapeSpec::Mesh(mesh);
    });
    let is_chosen = outcome.is_ok();
    if let Err(reason) = outcome {
        report(world, Err(reason));
    }
    is_chosen
}

fn load_mesh(file: &str, scale: f64) -> Result<MeshSpec, String> {
    if !(scale.is_finite() && scale > 0.0) {
        return Err(format!("{file}: a scale must be greater than 0, is {scale}"));
    }
    let is_builtin = builtin_meshes().any(|name| name == file);
    // A scene that is saved elsewhere still finds it.
    let path = if is_builtin { file.into() } else { std::path::absolute(file).map_err(|error| error.to_string())? };
    MeshSpec::load(&path.to_string_lossy(), Path::new(""), scale).map_err(|error| error.to_string())
}

#[cfg(test)]
mod tests {
    use super::stem;

    #[test]
    fn a_mesh_is_called_by_its_bare_name() {
        for file in ["plumb:rock.obj", "rock.obj", "/home/me/rock.obj", "C:\\meshes\\rock.obj", "rock"] {
            assert_eq!(stem(file), "rock");
        }
    }
}
