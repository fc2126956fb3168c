//! From a scene to the text of a file that reads back to it, bit by bit.

use std::collections::HashMap;
use std::path::{self, Component, MAIN_SEPARATOR, Path, PathBuf};

use bevy::math::{DQuat, DVec3};
use ron::ser::PrettyConfig;

use super::entry::{self, BodyEntry, ChildEntry, SceneEntry, ShapeEntry, USUAL_GRAVITY, ViewEntry};
use super::joint::JointEntry;
use super::probe::ProbeEntry;
use super::usual::unless_same;
use crate::scene::body::WORLD;
use crate::scene::error::Flaw;
use crate::scene::number::{Finite, Fraction, NonNegative, Positive};
use crate::scene::{
    BodySpec, ChildSpec, JointSpec, ProbePoint, ProbeSpec, SceneError, SceneSpec, ShapeSpec, SurfaceForm, SurfaceSpec,
};

impl SceneSpec {
    /// The scene as the text of a RON file, one body or joint a line, without what is at its
    /// default. [`from_ron`](Self::from_ron) makes the same scene of it, bit by bit, but for its
    /// name: that is the file's.
    ///
    /// Bodies that stand for the world in a joint (as `from_ron` makes them) are written as such.
    /// Files of meshes and pictures are named relative to `folder`, where the text is to be kept; without one, by
    /// their absolute paths.
    ///
    /// # Errors
    /// What [`validate`](Self::validate) finds, or the path of a file that is not Unicode.
    pub fn to_ron(&self, folder: Option<&Path>) -> Result<String, SceneError> {
        self.validate()?;
        let entry = SceneEntry::of(self, folder).map_err(|flaw| flaw.of(&self.name))?;
        // Scene, list, element: deeper down, all on one line.
        let layout = PrettyConfig::new().depth_limit(2).new_line("\n");
        let text = entry::options().to_string_pretty(&entry, layout);
        Ok(text.expect("a scene's entries are plain structures") + "\n")
    }
}

impl SceneEntry {
    fn of(scene: &SceneSpec, folder: Option<&Path>) -> Result<Self, Flaw> {
        let by_name: HashMap<&str, &BodySpec> = scene.bodies.iter().map(|body| (body.name.as_str(), body)).collect();
        let mut bodies = Vec::with_capacity(scene.bodies.len());
        for (index, body) in scene.bodies.iter().enumerate().filter(|(_, body)| !body.stands_for_world()) {
            let entry = BodyEntry::of(body, folder);
            bodies.push(entry.map_err(|problem| Flaw::new(format!("bodies[{index}].shape.file"), problem))?);
        }
        Ok(Self {
            gravity: unless_same(scene.gravity, USUAL_GRAVITY).map(Into::into),
            bodies,
            joints: scene.joints.iter().map(|joint| joint_entry(joint, &by_name)).collect(),
            view: scene.view.map(|view| ViewEntry { eye: view.eye.into(), target: view.target.into() }),
            probes: scene.probes.iter().map(|probe| probe_entry(probe, &by_name)).collect(),
        })
    }
}

impl BodyEntry {
    fn of(body: &BodySpec, folder: Option<&Path>) -> Result<Self, String> {
        let usual = BodySpec::new("", ShapeSpec::HalfSpace, DVec3::ZERO);
        let usual_kind = BodyEntry::usual_kind(body.shape.as_ref());
        let vector = |vector: DVec3| unless_same(vector, DVec3::ZERO).map(Into::into);
        let (linear_damping, angular_damping) = body.damping;
        Ok(Self {
            name: body.name.clone(),
            kind: (body.kind != usual_kind).then_some(body.kind),
            shape: body.shape.as_ref().map(|shape| ShapeEntry::of(shape, folder)).transpose()?,
            density: unless_same(body.density, usual.density).map(Positive::of_valid),
            mass: body.mass.map(Positive::of_valid),
            inertia: body.inertia.map(Into::into),
            position: vector(body.position),
            rotation: unless_same(body.rotation, DQuat::IDENTITY).map(Into::into),
            rotation_degrees: None,
            velocity: vector(body.linear_velocity),
            angular_velocity: vector(body.angular_velocity),
            force: vector(body.force),
            torque: vector(body.torque),
            friction: unless_same(body.material.friction, usual.material.friction).map(NonNegative::of_valid),
            restitution: unless_same(body.material.restitution, usual.material.restitution).map(Fraction::of_valid),
            layers: (body.layers != usual.layers).then_some(body.layers),
            sensor: body.sensor.then_some(true),
            locked: (body.locked != usual.locked).then_some(body.locked),
            gravity_scale: unless_same(body.gravity_scale, usual.gravity_scale).map(Finite::of_valid),
            linear_damping: unless_same(linear_damping, usual.damping.0).map(NonNegative::of_valid),
            angular_damping: unless_same(angular_damping, usual.damping.1).map(NonNegative::of_valid),
            color: body.color.map(Into::into),
        })
    }
}

impl ShapeEntry {
    fn of(shape: &ShapeSpec, folder: Option<&Path>) -> Result<Self, String> {
        Ok(match shape {
            ShapeSpec::HalfSpace => Self::HalfSpace,
            ShapeSpec::Sphere { radius } => Self::Sphere { radius: Positive::of_valid(*radius) },
            ShapeSpec::Cuboid { size } => Self::Cuboid { size: (*size).into() },
            ShapeSpec::Capsule { radius, length } => {
                Self::Capsule { radius: Positive::of_valid(*radius), length: Positive::of_valid(*length) }
            }
            ShapeSpec::Cylinder { radius, height } => {
                Self::Cylinder { radius: Positive::of_valid(*radius), height: Positive::of_valid(*height) }
            }
            ShapeSpec::Cone { radius, height } => {
                Self::Cone { radius: Positive::of_valid(*radius), height: Positive::of_valid(*height) }
            }
            ShapeSpec::Hull(hull) => Self::Hull { points: hull.points().iter().map(|&point| point.into()).collect() },
            ShapeSpec::Mesh(mesh) => Self::Mesh {
                file: file_of(mesh.file(), mesh.path(), folder)?,
                scale: unless_same(mesh.scale(), 1.0).map(Positive::of_valid),
                pieces: mesh.most_pieces(),
            },
            ShapeSpec::Compound(compound) => {
                let children = compound.children().iter().map(|child| ChildEntry::of(child, folder));
                Self::Compound { children: children.collect::<Result<_, _>>()? }
            }
            ShapeSpec::Surface(surface) => Self::of_surface(surface, folder)?,
        })
    }

    fn of_surface(surface: &SurfaceSpec, folder: Option<&Path>) -> Result<Self, String> {
        let two_sided = surface.is_two_sided().then_some(true);
        Ok(match surface.form() {
            SurfaceForm::Heights { size: [x, z], rows } => Self::Heights {
                size: (Positive::of_valid(*x), Positive::of_valid(*z)),
                rows: rows.iter().map(|row| row.iter().map(|&height| Finite::of_valid(height)).collect()).collect(),
                file: None,
                height: None,
            },
            SurfaceForm::Picture { file, path, size: [x, z], height: [low, high] } => Self::Heights {
                size: (Positive::of_valid(*x), Positive::of_valid(*z)),
                rows: Vec::new(),
                file: Some(file_of(file, path.as_deref(), folder)?),
                height: Some((Finite::of_valid(*low), Finite::of_valid(*high))),
            },
            SurfaceForm::File { file, path, scale } => Self::Surface {
                file: Some(file_of(file, path.as_deref(), folder)?),
                scale: unless_same(*scale, 1.0).map(Positive::of_valid),
                vertices: Vec::new(),
                triangles: Vec::new(),
                two_sided,
            },
            SurfaceForm::Triangles { vertices, triangles } => Self::Surface {
                file: None,
                scale: None,
                vertices: vertices.iter().map(|&vertex| vertex.into()).collect(),
                triangles: triangles.iter().map(|&[a, b, c]| (a, b, c)).collect(),
                two_sided,
            },
        })
    }
}

impl ChildEntry {
    fn of(ChildSpec { shape, position, rotation }: &ChildSpec, folder: Option<&Path>) -> Result<Self, String> {
        Ok(Self {
            shape: ShapeEntry::of(shape, folder)?,
            position: unless_same(*position, DVec3::ZERO).map(Into::into),
            rotation: unless_same(*rotation, DQuat::IDENTITY).map(Into::into),
            rotation_degrees: None,
        })
    }
}

/// A joint, its bodies by the names that the file has for them.
fn joint_entry(joint: &JointSpec, bodies: &HashMap<&str, &BodySpec>) -> JointEntry {
    let hold = |name: &String, anchor: DVec3| match bodies[name.as_str()] {
        // A sum with 0 would lose the sign of −0.
        world if world.stands_for_world() && anchor == DVec3::ZERO => (WORLD.to_owned(), world.position),
        world if world.stands_for_world() => (WORLD.to_owned(), world.point(anchor)),
        _ => (name.clone(), anchor),
    };
    let (body_a, anchor_a) = hold(&joint.body_a, joint.anchor_a);
    let (body_b, anchor_b) = hold(&joint.body_b, joint.anchor_b);
    JointEntry::of(joint, [body_a, body_b], [anchor_a, anchor_b])
}

/// A probe, what stands for the world in a joint being the world.
fn probe_entry(probe: &ProbeSpec, bodies: &HashMap<&str, &BodySpec>) -> ProbeEntry {
    let point = |point: &ProbePoint<String>| {
        let held = point.body.as_ref().map(|name| bodies[name.as_str()]).filter(|body| body.stands_for_world());
        Some(held.map_or_else(|| point.clone(), |world| ProbePoint { body: None, at: world.point(point.at) }))
    };
    ProbeEntry::of(&probe.map(point, |joint| Some(*joint)).unwrap_or_else(|| probe.clone()))
}

/// What a scene in `folder` calls the file of a mesh or a picture.
fn file_of(name: &str, path: Option<&Path>, folder: Option<&Path>) -> Result<String, String> {
    let Some(file) = path else { return Ok(name.to_owned()) };
    let named = folder.and_then(|folder| relative(file, folder));
    // A path that cannot be made absolute is kept as it is: so the file was found.
    let named = named.unwrap_or_else(|| path::absolute(file).unwrap_or_else(|_| file.to_owned()));
    let name = named.to_str().ok_or_else(|| format!("the path '{}' is not Unicode; rename it", named.display()))?;
    // The separator that every system understands.
    Ok(if MAIN_SEPARATOR == '/' { name.to_owned() } else { name.replace(MAIN_SEPARATOR, "/") })
}

/// A file as seen from a folder; none where either is missing or they have no root in common.
fn relative(file: &Path, folder: &Path) -> Option<PathBuf> {
    let folder = if folder == Path::new("") { Path::new(".") } else { folder };
    let (file, folder) = (file.canonicalize().ok()?, folder.canonicalize().ok()?);
    let common = file.components().zip(folder.components()).take_while(|(a, b)| a == b).count();
    let up = folder.components().skip(common).map(|_| Component::ParentDir);
    (common > 0).then(|| up.chain(file.components().skip(common)).collect())
}
