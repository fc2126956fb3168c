//! What the next body is to be.

use bevy::math::DVec3;
use bevy::prelude::*;

use super::hills::Hills;
use super::mesh_form::MeshForm;
use crate::sandbox::state::report;
use crate::scene::{BodySpec, ShapeSpec, SurfaceForm};

/// What [`SandboxAction::SpawnBody`](crate::sandbox::SandboxAction::SpawnBody) makes.
#[derive(Resource, Clone, Debug, PartialEq)]
pub struct Blueprint {
    /// Shape with its sizes, m.
    pub shape: ShapeSpec,
    /// How heavy it is.
    pub weight: Weight,
    /// What the shape is of where it is a hilly ground, or was when it last was one.
    pub hills: Hills,
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
        Self {
            shape: ShapeSpec::Cuboid { size: DVec3::splat(0.5) },
            weight: Weight::Density(1000.0),
            hills: Hills::default(),
        }
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

    /// A body of it at the origin: one that cannot move is fixed.
    pub(super) fn body(&self, name: String) -> BodySpec {
        let body = BodySpec::new(name, self.shape.clone(), DVec3::ZERO);
        match self.weight {
            _ if matches!(self.shape, ShapeSpec::Surface(_)) => body.fixed(),
            Weight::Density(density) => BodySpec { density, ..body },
            Weight::Mass(mass) => body.with_mass(mass),
        }
    }
}

/// What bodies of a shape are called, before a number is added.
pub(super) fn noun_of(shape: &ShapeSpec) -> &str {
    match shape {
        ShapeSpec::Sphere { .. } => "ball",
        ShapeSpec::Cuboid { .. } => "box",
        ShapeSpec::Capsule { .. } => "capsule",
        ShapeSpec::Cylinder { .. } => "cylinder",
        ShapeSpec::Cone { .. } => "cone",
        ShapeSpec::HalfSpace => "ground",
        ShapeSpec::Hull(_) => "block",
        ShapeSpec::Compound(_) => "compound",
        ShapeSpec::Mesh(mesh) => stem(mesh.file()),
        ShapeSpec::Surface(surface) => match surface.form() {
            SurfaceForm::Heights { .. } => "hills",
            SurfaceForm::File { file, .. } | SurfaceForm::Picture { file, .. } => stem(file),
            SurfaceForm::Triangles { .. } => "surface",
        },
    }
}

/// The name of a mesh or picture without folder, ending and `plumb:`.
pub fn stem(file: &str) -> &str {
    let name = file.rsplit(['/', '\\', ':']).next().unwrap_or(file);
    name.strip_suffix(".obj").or(name.strip_suffix(".png")).unwrap_or(name)
}

/// Makes the next body of a mesh: one that comes with Plumb, or an OBJ file. Whether it is one now.
pub fn choose_mesh(world: &mut World, file: &str, scale: f64, form: MeshForm) -> bool {
    let outcome = form.load(file, scale).map(|shape| {
        world.resource_mut::<Blueprint>().shape = shape;
    });
    let is_chosen = outcome.is_ok();
    if let Err(reason) = outcome {
        report(world, Err(reason));
    }
    is_chosen
}

/// Makes the next body a hilly ground.
pub fn choose_hills(world: &mut World, hills: Hills) {
    match hills.surface() {
        Ok(surface) => {
            let mut blueprint = world.resource_mut::<Blueprint>();
            blueprint.shape = ShapeSpec::Surface(surface);
            blueprint.hills = hills;
        }
        Err(reason) => report(world, Err(reason)),
    }
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
