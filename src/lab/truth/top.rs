//! A free body with three different moments of inertia (Euler 1758; Landau and Lifshitz,
//! Mechanics, §37), started with ω₃ = 0: its angular velocity in body axes is
//! ω₁ = ω₁(0)/k′ dn u, ω₂ = ω₂(0) sn u, ω₃ = −A₃ cn u with u = K + p t.

use bevy::math::DVec3;

use crate::scene::{SceneSpec, ShapeSpec};

use super::answer::Truth;
use super::bodies::dynamic;
use super::elliptic::{jacobi, quarter_period};
use crate::lab::simulation::Sample;

pub(super) fn truth(scene: &SceneSpec) -> Option<Truth> {
    let index = *dynamic(scene).first()?;
    let body = &scene.bodies[index];
    let Some(ShapeSpec::Cuboid { size }) = body.shape else { return None };
    let inertia = DVec3::splat(size.length_squared()) - size * size; // × m/12, which cancels
    let start = body.rotation.inverse() * body.angular_velocity;
    let motion = FreeTop::new(inertia, start)?;
    let distance = move |sample: &Sample| {
        let state = sample.bodies[index];
        Some((state.rotation.inverse() * state.angular).distance(motion.angular_velocity(sample.time)))
    };
    // A box that points elsewhere altogether does not do what a top does.
    let spin = start.length();
    // The phase p t, up to 100 rad, and K, which a nudge of 1e-3 makes 10 rad long, are known to a
    // few roundings; ω turns by less than itself in a radian.
    let truth = Truth::largest("angular velocity in body axes", "rad/s", distance).with_uncertainty(1e-13 * spin);
    Some(truth.failing_above(spin))
}

struct FreeTop {
    amplitude: DVec3,
    /// p, rad/s.
    rate: f64,
    complement: f64,
}

impl FreeTop {
    /// For moments I₁ < I₂ < I₃ and a start in the plane ω₃ = 0 with both other parts positive.
    fn new(inertia: DVec3, start: DVec3) -> Option<Self> {
        let DVec3 { x: i1, y: i2, z: i3 } = inertia;
        if !(i1 < i2 && i2 < i3 && start.x > 0.0 && start.y > 0.0 && start.z == 0.0) {
            return None;
        }
        // 2E I₃ − L² and L² − 2E I₁, written out so that nothing cancels.
        let first = i1 * (i3 - i1) * start.x * start.x;
        let second = i2 * (i3 - i2) * start.y * start.y;
        let tilt = i2 * (i2 - i1) * start.y * start.y;
        let complement = (first / (first + second)).sqrt();
        let third = (tilt / (i3 * (i3 - i1))).sqrt();
        Some(Self {
            amplitude: DVec3::new(start.x / complement, start.y, third),
            rate: ((i2 - i1) * (first + second) / (i1 * i2 * i3)).sqrt(),
            complement,
        })
    }

    fn angular_velocity(&self, time: f64) -> DVec3 {
        let u = quarter_period(self.complement) + self.rate * time;
        let functions = jacobi(u, self.complement);
        self.amplitude * DVec3::new(functions.dn, functions.sn, functions.cn)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Euler's equations, classical Runge–Kutta, through the first flip of the scene's own body.
    #[test]
    fn angular_velocity_follows_eulers_equations() {
        let inertia = DVec3::new(0.40, 1.04, 1.36);
        let mut omega = DVec3::new(0.01, 10.0, 0.0);
        let top = FreeTop::new(inertia, omega).unwrap();
        let slope = |omega: DVec3| (inertia * omega).cross(omega) / inertia;
        let step = 1e-4;
        let mut lowest = omega.y;
        for n in 0..30_000 {
            let time = f64::from(n) * step;
            let error = top.angular_velocity(time).distance(omega);
            // Rounding, 1e-15 a step; near the middle axis a slip grows by e^(6 t).
            assert!(error < 1e-9, "at {time}: {error:e}");
            let k1 = slope(omega);
            let k2 = slope(omega + 0.5 * step * k1);
            let k3 = slope(omega + 0.5 * step * k2);
            let k4 = slope(omega + step * k3);
            omega += step / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
            lowest = lowest.min(omega.y);
        }
        assert!(lowest < -9.9, "it never flipped");
    }

    #[test]
    fn other_starts_have_no_answer_here() {
        assert!(FreeTop::new(DVec3::new(1.0, 2.0, 3.0), DVec3::new(1.0, 1.0, 0.1)).is_none());
        assert!(FreeTop::new(DVec3::new(2.0, 1.0, 3.0), DVec3::new(1.0, 1.0, 0.0)).is_none());
    }
}
