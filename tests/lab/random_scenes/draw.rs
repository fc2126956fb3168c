//! Scenes drawn by lot.

use std::f64::consts::{PI, TAU};

use bevy::math::{DQuat, DVec3};
use plumb::physics::{DistanceLaw, JointMotor, MotorTarget};
use plumb::scene::{BodySpec, ChildSpec, CompoundSpec, JointKindSpec, JointSpec, SceneSpec, ShapeSpec, SurfaceSpec};
use rand::RngExt;
use rand::seq::IndexedRandom;
use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::SeedableRng;

/// A scene with what one must know of it to judge a run.
pub struct Drawn {
    pub spec: SceneSpec,
    /// Size of its bodies in the mean, m: lengths and speeds go with it.
    pub scale: f64,
    /// Whether motors may do work on it.
    pub is_driven: bool,
}

/// What bodies are made of in a scene.
struct Kit {
    random: Pcg64Mcg,
    scale: f64,
    shapes: Vec<Form>,
    friction: f64,
    restitution: f64,
    /// Greatest density over the least.
    ratio: f64,
    /// Whether some of them are thrown.
    throws: bool,
}

#[derive(Clone, Copy, PartialEq)]
enum Form {
    Ball,
    Cuboid,
    Capsule,
    Cylinder,
    Cone,
    Hull,
    Compound,
}

const FORMS: [Form; 7] =
    [Form::Ball, Form::Cuboid, Form::Capsule, Form::Cylinder, Form::Cone, Form::Hull, Form::Compound];

/// Up to that many bodies of some shapes over one of four grounds, none in another, in up to three columns, half of the
/// scenes with joints from each body to one before it. The same for the same seed.
pub fn scene(seed: u64, most_bodies: usize) -> Drawn {
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    let mut shapes = FORMS.to_vec();
    while shapes.len() > 1 && random.random_bool(0.6) {
        shapes.swap_remove(random.random_range(0..shapes.len()));
    }
    let mut kit = Kit {
        scale: one_of(&mut random, &[1.0, 1.0, 1.0, 0.2, 5.0]),
        friction: one_of(&mut random, &[0.0, 0.1, 0.3, 0.5, 0.8, 1.2]),
        restitution: one_of(&mut random, &[0.0, 0.0, 0.0, 0.3, 0.7]),
        ratio: one_of(&mut random, &[1.0, 1.0, 10.0, 1000.0]),
        throws: random.random(),
        random,
        shapes,
    };
    let mut spec = SceneSpec::new(format!("random {seed}"), DVec3::new(0.0, -9.81, 0.0));
    spec.bodies = kit.ground();
    let fixed = spec.bodies.len();
    let columns = kit.random.random_range(1..=3_usize);
    let count = kit.random.random_range(2..=most_bodies);
    // Where the highest of each column ends, m: above all that stands round it.
    let mut tops = vec![2.1 * kit.scale; columns];
    for index in 0..count {
        let body = kit.body(format!("body {index}"), index % columns, &mut tops);
        spec.bodies.push(body);
    }
    let mut is_driven = false;
    if kit.random.random() {
        for later in 1..count {
            let earlier = if kit.random.random_bool(0.7) { later - 1 } else { kit.random.random_range(0..later) };
            let (joint, drives) = kit.joint(&spec.bodies[fixed + earlier], &spec.bodies[fixed + later]);
            spec.joints.push(joint);
            is_driven |= drives;
        }
    }
    spec.validate().unwrap_or_else(|error| panic!("{seed}: {error}"));
    Drawn { spec, scale: kit.scale, is_driven }
}

fn one_of<T: Copy>(random: &mut Pcg64Mcg, choices: &[T]) -> T {
    *choices.choose(random).expect("there are some")
}

impl Kit {
    /// A plane, a slab, a tray or bumpy triangles.
    fn ground(&mut self) -> Vec<BodySpec> {
        let scale = self.scale;
        let slab = || {
            BodySpec::new(
                "slab",
                ShapeSpec::Cuboid { size: scale * DVec3::new(40.0, 1.0, 40.0) },
                -0.5 * scale * DVec3::Y,
            )
        };
        let parts = match self.random.random_range(0..5) {
            0 | 1 => vec![BodySpec::ground()],
            2 => vec![slab()],
            3 => {
                let sides = [DVec3::X, DVec3::NEG_X, DVec3::Z, DVec3::NEG_Z].map(|to| {
                    let size = DVec3::new(4.0, 2.0, 4.0) - 3.6 * to.abs();
                    let at = scale * (1.9 * to + DVec3::Y);
                    BodySpec::new(format!("side {to}"), ShapeSpec::Cuboid { size: scale * size }, at)
                });
                [slab()].into_iter().chain(sides).collect()
            }
            _ => {
                let (height, shift) = (one_of(&mut self.random, &[0.0, 0.1, 0.3]), self.random.random_range(0.0..TAU));
                let bump =
                    |i: usize, k: usize| scale * height * (0.7 * i as f64 + shift).sin() * (0.6 * k as f64).cos();
                let rows = (0..17).map(|k| (0..17).map(|i| bump(i, k)).collect()).collect();
                let surface = SurfaceSpec::heights([24.0 * scale; 2], rows).unwrap();
                vec![BodySpec::new("bumps", ShapeSpec::Surface(surface), DVec3::ZERO)]
            }
        };
        parts.into_iter().map(|part| part.fixed().with_material(self.friction, self.restitution)).collect()
    }

    /// On top of its column.
    fn body(&mut self, name: String, column: usize, tops: &mut [f64]) -> BodySpec {
        let scale = self.scale;
        let shape = self.shape(true);
        // A body's place is that of its centre of mass, from which no point is farther than this.
        let radius = shape.bounding_radius();
        let x = 2.2 * scale * (column as f64 - 0.5 * (tops.len() as f64 - 1.0));
        let [x, z] = [x, 0.0].map(|along| along + self.random.random_range(-0.05..0.05) * scale);
        let at = DVec3::new(x, tops[column] + radius, z);
        tops[column] = at.y + radius + 0.05 * scale;
        let density = 1000.0 * self.ratio.powf(self.random.random());
        let mut body = BodySpec { density, ..BodySpec::new(name, shape, at) }
            .with_rotation(self.rotation())
            .with_material(self.friction, self.restitution);
        if self.throws && self.random.random() {
            let [linear, angular] =
                [8.0 * scale, 15.0].map(|most| most * self.random.random::<f64>() * self.direction());
            body = body.with_velocity(linear, angular);
        }
        body
    }

    fn shape(&mut self, may_be_compound: bool) -> ShapeSpec {
        let form = one_of(&mut self.random, &self.shapes);
        let mut length = || self.scale * self.random.random_range(0.15_f64.ln()..0.8_f64.ln()).exp();
        match form {
            Form::Ball => ShapeSpec::Sphere { radius: length() / 2.0 },
            Form::Capsule => ShapeSpec::Capsule { radius: length() / 3.0, length: length() },
            Form::Cylinder => ShapeSpec::Cylinder { radius: length() / 2.0, height: length() },
            Form::Cone => ShapeSpec::Cone { radius: length() / 2.0, height: length() },
            Form::Hull => {
                let half = DVec3::new(length(), length(), length()) / 2.0;
                let corners = self.random.random_range(5..15);
                ShapeSpec::hull((0..corners).map(|_| half * self.direction()).collect::<Vec<_>>())
            }
            Form::Compound if may_be_compound && self.shapes.len() > 1 => {
                let children = self.random.random_range(2..5);
                let child = |_| ChildSpec {
                    position: 0.3 * self.scale * self.random.random::<f64>() * self.direction(),
                    rotation: self.rotation(),
                    shape: self.shape(false),
                };
                ShapeSpec::Compound(CompoundSpec::new((0..children).map(child).collect()).unwrap())
            }
            Form::Cuboid | Form::Compound => ShapeSpec::Cuboid { size: DVec3::new(length(), length(), length()) },
        }
    }

    /// With whether it may do work.
    fn joint(&mut self, a: &BodySpec, b: &BodySpec) -> (JointSpec, bool) {
        let point = 0.5 * (a.position + b.position);
        let distance = a.position.distance(b.position);
        let axis = self.direction();
        let random = &mut self.random;
        let of_lengths = |law| {
            (JointSpec { kind: JointKindSpec::Distance(law), ..JointSpec::new(a, DVec3::ZERO, b, DVec3::ZERO) }, false)
        };
        let (joint, drives) = match random.random_range(0..9) {
            0 => of_lengths(DistanceLaw::Range { min: distance, max: distance }),
            1 => of_lengths(DistanceLaw::Range { min: 0.0, max: 1.2 * distance }),
            2 => (JointSpec::at(a, b, point), false),
            3 => (JointSpec::at(a, b, point).with_swing_twist(random.random_range(0.2..1.5), [-3.1, 3.1], axis), false),
            4 => (JointSpec::of_kind(JointKindSpec::Fixed, a, b, point), false),
            form => {
                let (kind, length) =
                    if form < 7 { (JointKindSpec::Hinge, 1.0) } else { (JointKindSpec::Slider, self.scale) };
                let joint = JointSpec::of_kind(kind, a, b, point).with_axis(axis);
                match random.random_range(0..4) {
                    0 | 1 => {
                        let [least, largest] = [(); 2].map(|()| length * random.random_range(0.1..1.5));
                        (joint.with_range(-least, largest), false)
                    }
                    2 => {
                        let target = MotorTarget::Speed(length * random.random_range(-5.0..5.0));
                        let max_force = 10_f64.powf(random.random_range(0.0..3.5)) * self.scale.powi(3);
                        (joint.with_motor(JointMotor { target, max_force }), true)
                    }
                    _ => (joint, false),
                }
            }
        };
        (JointSpec { collide: self.random.random_bool(0.2), ..joint }, drives)
    }

    /// Evenly spread over the sphere.
    fn direction(&mut self) -> DVec3 {
        let (height, around) = (self.random.random_range(-1.0_f64..1.0), self.random.random_range(0.0..TAU));
        let across = (1.0 - height * height).sqrt();
        DVec3::new(across * around.cos(), height, across * around.sin())
    }

    fn rotation(&mut self) -> DQuat {
        DQuat::from_axis_angle(self.direction(), self.random.random_range(0.0..PI))
    }
}
