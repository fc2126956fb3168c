//! From the text of a file to a scene.

use std::collections::HashMap;
use std::fs::File;
use std::io::Read;
use std::path::Path;

use bevy::math::{DQuat, DVec3, EulerRot};

use super::entry::{self, BodyEntry, ChildEntry, SceneEntry, ShapeEntry, USUAL_GRAVITY};
use super::joint::JointEntry;
use crate::physics::RigidBody;
use crate::scene::body::{WORLD, WORLD_PREFIX};
use crate::scene::error::Flaw;
use crate::scene::mesh::Meshes;
use crate::scene::number::{Finite, Quaternion, Vector};
use crate::scene::{
    BodySpec, ChildSpec, CompoundSpec, JointSpec, MAX_BODIES, MaterialSpec, ObjError, SceneError, SceneSpec, ShapeSpec,
    SurfaceSpec, ViewSpec, validate,
};

/// Largest scene file that is read, bytes: several times what [`MAX_BODIES`] take.
pub const MAX_FILE_BYTES: u64 = 64 << 20;

impl SceneSpec {
    /// A scene from the text of a RON file. `source` is what errors call it, a path or just a name;
    /// the scene is named after its stem, and the files it names are looked for beside it.
    ///
    /// # Errors
    /// Whatever is wrong with the text or with the scene in it.
    pub fn from_ron(text: &str, source: &str) -> Result<Self, SceneError> {
        let entry: SceneEntry = entry::options().from_str(text).map_err(|error| parse_error(&error, source))?;
        let scene = entry.into_scene(source)?;
        scene.validate_as(source)?;
        Ok(scene)
    }
}

/// The scene in the file at `path`.
pub(in crate::scene) fn read(path: &str) -> Result<SceneSpec, SceneError> {
    let unreadable = |problem: String| SceneError::Unreadable { path: path.to_owned(), problem };
    let file = File::open(path).map_err(|error| unreadable(format!("cannot be read: {error}")))?;
    if file.metadata().is_ok_and(|metadata| metadata.is_dir()) {
        return Err(unreadable("is a folder, not a scene file".to_owned()));
    }
    // One byte more than allowed tells a file that is too large from one that just fits.
    let mut bytes = Vec::new();
    let limit = MAX_FILE_BYTES + 1;
    file.take(limit).read_to_end(&mut bytes).map_err(|error| unreadable(format!("cannot be read: {error}")))?;
    if bytes.len() as u64 == limit {
        return Err(unreadable(format!("is larger than {} MiB, the limit for a scene", MAX_FILE_BYTES >> 20)));
    }
    let text = String::from_utf8(bytes).map_err(|error| {
        let line = 1 + error.as_bytes()[..error.utf8_error().valid_up_to()].iter().filter(|&&b| b == b'\n').count();
        unreadable(format!("is not UTF-8 text (line {line}); a scene is a RON text file"))
    })?;
    SceneSpec::from_ron(&text, path)
}

fn parse_error(error: &ron::error::SpannedError, source: &str) -> SceneError {
    let problem = match &error.code {
        // RON would have a number that stands for a field's name quoted.
        ron::Error::SuggestRawIdentifier(found) => format!("Expected the name of a field, found `{found}`"),
        code => code.to_string(),
    };
    SceneError::Parse {
        path: source.to_owned(),
        line: error.span.start.line,
        column: error.span.start.col,
        problem: problem.split_whitespace().collect::<Vec<_>>().join(" "),
    }
}

impl SceneEntry {
    fn into_scene(self, source: &str) -> Result<SceneSpec, SceneError> {
        if self.bodies.len() > MAX_BODIES {
            return Err(SceneError::TooManyBodies { scene: source.to_owned(), bodies: self.bodies.len() as u64 });
        }
        let flawed = |flaw: Flaw| flaw.of(source);
        let mut meshes = Meshes::new(Path::new(source).parent().unwrap_or(Path::new("")));
        let mut bodies = Vec::with_capacity(self.bodies.len());
        for (i, entry) in self.bodies.into_iter().enumerate() {
            bodies.push(entry.into_body(i, &mut meshes).map_err(flawed)?);
        }
        let name = Path::new(source).file_stem().map_or(source.into(), |stem| stem.to_string_lossy());
        let gravity = self.gravity.map_or(USUAL_GRAVITY, DVec3::from);
        let mut scene = SceneSpec { bodies, ..SceneSpec::new(name, gravity) };
        scene.view = self.view.map(|view| ViewSpec { eye: view.eye.into(), target: view.target.into() });
        add_joints(&mut scene, self.joints).map_err(flawed)?;
        for (i, entry) in self.probes.into_iter().enumerate() {
            let probe = entry.into_probe();
            scene
                .probes
                .push(probe.map_err(|(field, problem)| flawed(Flaw::new(format!("probes[{i}].{field}"), problem)))?);
        }
        Ok(scene)
    }
}

impl BodyEntry {
    fn into_body(self, index: usize, meshes: &mut Meshes) -> Result<BodySpec, Flaw> {
        if self.name == WORLD || self.name.starts_with(WORLD_PREFIX) {
            let problem = format!("'{}' is kept for what does not move; choose another", self.name);
            return Err(Flaw::new(format!("bodies[{index}].name"), problem));
        }
        let rotation = rotation_of(self.rotation, self.rotation_degrees)
            .map_err(|problem| Flaw::new(format!("bodies[{index}].rotation"), problem))?;
        let shape = match self.shape {
            Some(entry) => Some(
                entry
                    .into_shape(meshes)
                    .map_err(|(field, problem)| Flaw::new(format!("bodies[{index}].shape.{field}"), problem))?,
            ),
            None => None,
        };
        let usual = BodySpec::new(self.name, ShapeSpec::HalfSpace, self.position.map_or(DVec3::ZERO, DVec3::from));
        Ok(BodySpec {
            kind: self.kind.unwrap_or(Self::usual_kind(shape.as_ref())),
            shape,
            density: self.density.map_or(usual.density, f64::from),
            mass: self.mass.map(f64::from),
            inertia: self.inertia.map(DVec3::from),
            rotation,
            linear_velocity: self.velocity.map_or(DVec3::ZERO, DVec3::from),
            angular_velocity: self.angular_velocity.map_or(DVec3::ZERO, DVec3::from),
            force: self.force.map_or(DVec3::ZERO, DVec3::from),
            torque: self.torque.map_or(DVec3::ZERO, DVec3::from),
            material: MaterialSpec {
                friction: self.friction.map_or(usual.material.friction, f64::from),
                restitution: self.restitution.map_or(usual.material.restitution, f64::from),
            },
            layers: self.layers.unwrap_or_default(),
            sensor: self.sensor.unwrap_or_default(),
            locked: self.locked.unwrap_or_default(),
            gravity_scale: self.gravity_scale.map_or(1.0, f64::from),
            damping: (self.linear_damping.map_or(0.0, f64::from), self.angular_damping.map_or(0.0, f64::from)),
            color: self.color.map(Into::into),
            ..usual
        })
    }
}

impl BodyEntry {
    /// What a body of that shape is unless it says otherwise.
    pub(super) fn usual_kind(shape: Option<&ShapeSpec>) -> RigidBody {
        let stays = matches!(shape, Some(ShapeSpec::HalfSpace | ShapeSpec::Surface(_)));
        if stays { RigidBody::Static } else { RigidBody::Dynamic }
    }
}

/// As given in one of two ways, or why it is none.
fn rotation_of(rotation: Option<Quaternion>, degrees: Option<Vector>) -> Result<DQuat, &'static str> {
    match (rotation, degrees) {
        (Some(_), Some(_)) => Err("give either 'rotation' or 'rotation_degrees', not both"),
        (Some(rotation), None) => Ok(rotation.into()),
        (None, Some(degrees)) => Ok(rotation_about_world_axes(degrees.into())),
        (None, None) => Ok(DQuat::IDENTITY),
    }
}

/// First about x, then y, then z, all world axes.
fn rotation_about_world_axes(degrees: DVec3) -> DQuat {
    let DVec3 { x, y, z } = DVec3::from_array(degrees.to_array().map(f64::to_radians));
    DQuat::from_euler(EulerRot::XYZEx, x, y, z)
}

impl ShapeEntry {
    /// Fails with the field that is wrong, and how.
    fn into_shape(self, meshes: &mut Meshes) -> Result<ShapeSpec, (String, String)> {
        Ok(match self {
            Self::HalfSpace => ShapeSpec::HalfSpace,
            Self::Sphere { radius } => ShapeSpec::Sphere { radius: radius.into() },
            Self::Cuboid { size } => ShapeSpec::Cuboid { size: size.into() },
            Self::Capsule { radius, length } => ShapeSpec::Capsule { radius: radius.into(), length: length.into() },
            Self::Cylinder { radius, height } => ShapeSpec::Cylinder { radius: radius.into(), height: height.into() },
            Self::Cone { radius, height } => ShapeSpec::Cone { radius: radius.into(), height: height.into() },
            Self::Hull { points } => ShapeSpec::hull(points.into_iter().map(DVec3::from).collect::<Vec<_>>()),
            Self::Mesh { file, scale, pieces } => {
                let mesh = meshes.load(&file, scale.map_or(1.0, f64::from), pieces);
                let field = |error: &ObjError| if matches!(error, ObjError::Pieces(_)) { "pieces" } else { "file" };
                ShapeSpec::Mesh(mesh.map_err(|error| (field(&error).to_owned(), error.to_string()))?)
            }
            Self::Compound { children } => {
                let children: Result<_, _> =
                    children.into_iter().enumerate().map(|(index, child)| child.into_child(index, meshes)).collect();
                let made = CompoundSpec::new(children?);
                ShapeSpec::Compound(made.map_err(|error| ("children".to_owned(), error.to_string()))?)
            }
            Self::Heights { size: (x, z), rows, file, height } => {
                ShapeSpec::Surface(heights([x.into(), z.into()], rows, file, height, meshes.folder())?)
            }
            Self::Surface { file, scale, vertices, triangles, two_sided } => {
                let two_sided = two_sided.unwrap_or_default();
                let has_own = !vertices.is_empty() || !triangles.is_empty();
                let made = match file {
                    Some(_) if has_own => {
                        let problem = "give either 'file' or 'vertices' and 'triangles', not both";
                        return Err(("file".to_owned(), problem.to_owned()));
                    }
                    Some(file) => meshes
                        .load_surface(&file, scale.map_or(1.0, f64::from), two_sided)
                        .map_err(|error| ("file".to_owned(), error.to_string())),
                    None if scale.is_some() => {
                        let problem = "a scale is for a 'file'; give vertices as large as they are";
                        return Err(("scale".to_owned(), problem.to_owned()));
                    }
                    None => {
                        let vertices = vertices.into_iter().map(DVec3::from).collect();
                        let triangles = triangles.into_iter().map(|(a, b, c)| [a, b, c]).collect();
                        let made = SurfaceSpec::triangles(vertices, triangles, two_sided);
                        made.map_err(|error| ("triangles".to_owned(), error.to_string()))
                    }
                };
                ShapeSpec::Surface(made?)
            }
        })
    }
}

/// A ground of rows or of a picture; fails with the field that is wrong, and how.
fn heights(
    size: [f64; 2],
    rows: Vec<Vec<Finite>>,
    file: Option<String>,
    height: Option<(Finite, Finite)>,
    folder: &Path,
) -> Result<SurfaceSpec, (String, String)> {
    let flaw = |field: &str, problem: String| (field.to_owned(), problem);
    match (file, height) {
        (Some(_), _) if !rows.is_empty() => Err(flaw("file", "give either 'file' or 'rows', not both".to_owned())),
        (Some(_), None) => {
            Err(flaw("height", "a picture has no unit; give the heights of black and of white in m".to_owned()))
        }
        (Some(file), Some((low, high))) => {
            let made = SurfaceSpec::height_picture(&file, folder, size, [low.into(), high.into()]);
            made.map_err(|error| flaw("file", error.to_string()))
        }
        (None, Some(_)) => {
            Err(flaw("height", "a height is for a 'file'; give rows of heights as high as they are".to_owned()))
        }
        (None, None) => {
            let rows = rows.into_iter().map(|row| row.into_iter().map(f64::from).collect()).collect();
            SurfaceSpec::heights(size, rows).map_err(|error| flaw("rows", error.to_string()))
        }
    }
}

impl ChildEntry {
    /// Fails with the field that is wrong, and how.
    fn into_child(self, index: usize, meshes: &mut Meshes) -> Result<ChildSpec, (String, String)> {
        let flaw = |field: &str, problem: String| (format!("children[{index}].{field}"), problem);
        let shape =
            self.shape.into_shape(meshes).map_err(|(field, problem)| flaw(&format!("shape.{field}"), problem))?;
        let solid = match &shape {
            ShapeSpec::Hull(hull) => hull.hull().as_ref().map(|_| ()).map_err(|error| ("points", error.to_string())),
            ShapeSpec::HalfSpace | ShapeSpec::Surface(_) => {
                Err(("", "no solid; give balls, boxes, capsules, cylinders, cones, hulls or meshes".to_owned()))
            }
            ShapeSpec::Mesh(mesh) if mesh.pieces().is_some() => {
                Err(("pieces", "a compound in a compound; leave 'pieces' out".to_owned()))
            }
            ShapeSpec::Compound(_) => Err(("", "a compound in a compound; give its children instead".to_owned())),
            _ => Ok(()),
        };
        solid.map_err(|(field, problem)| flaw(format!("shape.{field}").trim_end_matches('.'), problem))?;
        let rotation = rotation_of(self.rotation, self.rotation_degrees);
        Ok(ChildSpec {
            shape,
            position: self.position.map_or(DVec3::ZERO, DVec3::from),
            rotation: rotation.map_err(|problem| flaw("rotation", problem.to_owned()))?,
        })
    }
}

/// Where a joint holds a body.
#[derive(Clone, Copy)]
enum Hold {
    /// At a point of the world, m.
    At(DVec3),
    /// At a point from the centre of mass, in the body's own axes, m.
    Anchor(DVec3),
}

fn add_joints(scene: &mut SceneSpec, entries: Vec<JointEntry>) -> Result<(), Flaw> {
    let by_name: HashMap<String, usize> =
        scene.bodies.iter().enumerate().map(|(index, body)| (body.name.clone(), index)).collect();
    for (i, entry) in entries.into_iter().enumerate() {
        let (hold_a, hold_b) = entry.holds().map_err(|problem| Flaw::new(format!("joints[{i}]"), problem))?;
        let find = |field: &str, name: &String| match by_name.get(name) {
            Some(&body) => Ok(Some(body)),
            None if name == WORLD => Ok(None),
            None => Err(Flaw::new(format!("joints[{i}].{field}"), validate::no_body(name))),
        };
        let (a, b) = (find("body_a", &entry.body_a)?, find("body_b", &entry.body_b)?);
        if a.is_none() && b.is_none() {
            let problem = "joins the world to itself; one of the two must be a dynamic body";
            return Err(Flaw::new(format!("joints[{i}].body_b"), problem));
        }
        if let (Some(only), None) | (None, Some(only)) = (a, b)
            && scene.bodies[only].kind != RigidBody::Dynamic
        {
            let problem =
                format!("neither '{}' nor the world is dynamic; one of them must be", scene.bodies[only].name);
            return Err(Flaw::new(format!("joints[{i}].body_b"), problem));
        }
        let (body_a, anchor_a) = scene.hold(a, hold_a, i);
        let (body_b, anchor_b) = scene.hold(b, hold_b, i);
        let pin = BodySpec::pin("", DVec3::ZERO);
        let joint = JointSpec { body_a, body_b, ..JointSpec::new(&pin, anchor_a, &pin, anchor_b) };
        let flawed = |(field, problem)| Flaw::new(format!("joints[{i}].{field}"), problem);
        scene.joints.push(entry.into_joint(joint).map_err(flawed)?);
    }
    Ok(())
}

impl JointEntry {
    fn holds(&self) -> Result<(Hold, Hold), &'static str> {
        match (self.at, self.anchor_a, self.anchor_b) {
            (Some(at), None, None) => Ok((Hold::At(at.into()), Hold::At(at.into()))),
            (None, Some(a), Some(b)) => Ok((Hold::Anchor(a.into()), Hold::Anchor(b.into()))),
            _ => Err("give either 'at' or both 'anchor_a' and 'anchor_b'"),
        }
    }
}

impl SceneSpec {
    /// The name and anchor of one side of joint `joint`. The world becomes a body of its own at
    /// the very point held, so that lever arms stay short however far from the origin it is.
    fn hold(&mut self, body: Option<usize>, hold: Hold, joint: usize) -> (String, DVec3) {
        match (body, hold) {
            (Some(body), Hold::At(point)) => (self.bodies[body].name.clone(), self.bodies[body].anchor(point)),
            (Some(body), Hold::Anchor(anchor)) => (self.bodies[body].name.clone(), anchor),
            (None, Hold::At(point) | Hold::Anchor(point)) => {
                let name = format!("{WORLD_PREFIX}{joint}");
                self.bodies.push(BodySpec::pin(&name, point));
                (name, DVec3::ZERO)
            }
        }
    }
}
