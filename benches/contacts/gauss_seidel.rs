//! Nonsmooth block Gauss–Seidel (Jean & Moreau 1987; Acary, Brémond & Huber 2018, NSGS): contact after contact, each solved
//! exactly with all others held.

use nalgebra::{Matrix2, Vector2, Vector3, Vector6};
use plumb::physics::ContactProblem;

use crate::natural_map::Impulses;
use crate::points::{Law, Point, given, local, points};
use crate::watch::Watch;

/// Bisections of the bracket of a contact's slip: to the last bit.
const MOST_HALVINGS: u32 = 200;

/// Sweeps until the watch says that it is enough.
pub fn solve(problem: &ContactProblem, start: &Impulses, watch: &mut Watch) {
    let points = points(problem);
    let inverses: Vec<_> = points.iter().map(|point| point.mobility.try_inverse().unwrap_or_default()).collect();
    let mut impulses = local(&points, start);
    let mut z = vec![Vector6::zeros(); problem.bodies.len()];
    points.iter().zip(&impulses).for_each(|(point, impulse)| point.apply(&mut z, impulse));
    while watch.goes_on(|| given(&points, &impulses)) {
        for ((point, inverse), impulse) in points.iter().zip(&inverses).zip(&mut impulses) {
            if !point.is_movable() {
                continue;
            }
            // u without its own impulse.
            let free = point.velocity(&z) - point.mobility * *impulse;
            let next = match point.law {
                Law::Joint => -(inverse * free),
                Law::Bounded(..) => point.project(&Vector3::new(-free.x / point.mobility.m11, 0.0, 0.0)),
                Law::Contact(friction) => {
                    let held = -(inverse * free);
                    one_contact(point, friction, &free, &held)
                }
            };
            point.apply(&mut z, &(next - *impulse));
            *impulse = next;
        }
    }
}

/// The impulse of one contact with W = Ĵ Ĵᵀ and u = W r + q: none where it opens, `held` where that is in the cone, else one
/// that slides, r_t = −(S + αI)⁻¹ b with the least α ≥ 0 at which |r_t| = μ r_n. S and b are W and q with r_n taken out by
/// u_n = 0. (Bonnefon & Daviet 2011 solve the same equation as a quartic of α.)
fn one_contact(point: &Point, friction: f64, free: &Vector3<f64>, held: &Vector3<f64>) -> Vector3<f64> {
    let w = &point.mobility;
    if free.x >= 0.0 {
        return Vector3::zeros();
    }
    if friction == 0.0 {
        return Vector3::new(-free.x / w.m11, 0.0, 0.0);
    }
    if Vector2::new(held.y, held.z).norm() <= friction * held.x {
        return *held;
    }
    let coupling = Vector2::new(w.m21, w.m31);
    let schur = Matrix2::new(w.m22, w.m23, w.m32, w.m33) - coupling * coupling.transpose() / w.m11;
    let wanted = Vector2::new(free.y, free.z) - coupling * (free.x / w.m11);
    let eigen = schur.symmetric_eigen();
    let turned = eigen.eigenvectors.tr_mul(&wanted);
    let slide = |alpha: f64| {
        let scaled = Vector2::from_fn(|row, _| -turned[row] / (eigen.eigenvalues[row] + alpha));
        let across = eigen.eigenvectors * scaled;
        Vector3::new(-(free.x + coupling.dot(&across)) / w.m11, across.x, across.y)
    };
    let excess = |r: &Vector3<f64>| Vector2::new(r.y, r.z).norm() - friction * r.x;
    let (mut low, mut high) = (0.0, schur.trace().max(f64::MIN_POSITIVE));
    while excess(&slide(high)) > 0.0 && high.is_finite() {
        (low, high) = (high, 4.0 * high);
    }
    for _ in 0..MOST_HALVINGS {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            break;
        }
        if excess(&slide(middle)) > 0.0 { low = middle } else { high = middle }
    }
    slide(high)
}
