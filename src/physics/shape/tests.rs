use bevy::math::DVec3;

use super::*;

/// Volume, centre of mass and the three moments about it, by summing over a grid of cells of the
/// box of half extents `reach` that `inside` holds.
fn integrate(reach: DVec3, inside: impl Fn(DVec3) -> bool) -> (f64, DVec3, DVec3) {
    const CELLS: u32 = 162; // a multiple of 3: a cone's base falls between two layers
    let cell = reach * 2.0 / f64::from(CELLS);
    let middle = |index: u32| f64::from(index) + 0.5;
    let (mut count, mut first, mut second) = (0.0, DVec3::ZERO, DVec3::ZERO);
    for i in 0..CELLS {
        for j in 0..CELLS {
            for k in 0..CELLS {
                let point = DVec3::new(middle(i), middle(j), middle(k)) * cell - reach;
                if inside(point) {
                    count += 1.0;
                    first += point;
                    second += point * point;
                }
            }
        }
    }
    let volume = cell.element_product();
    let moments = DVec3::new(second.y + second.z, second.z + second.x, second.x + second.y);
    (count * volume, first / count, moments * volume)
}

pub(super) fn assert_matches_integral(collider: &Collider, reach: DVec3, inside: impl Fn(DVec3) -> bool) {
    let density = 700.0;
    let properties = collider.mass_properties(density);
    let (volume, centre, moments) = integrate(reach, inside);
    // The grid's own error: cells across the surface, under half a per cent here.
    let close = |value: f64, integral: f64| (value / integral - 1.0).abs() < 5e-3;
    assert!(close(collider.volume(), volume), "{collider:?}: volume {} against {volume}", collider.volume());
    assert!(close(properties.mass, density * volume));
    assert!(centre.length() < 5e-3 * reach.max_element(), "{collider:?}: centre of mass at {centre}");
    for axis in 0..3 {
        let (value, integral) = (properties.inertia[axis], density * moments[axis]);
        assert!(close(value, integral), "{collider:?}: moment {axis} is {value}, integral {integral}");
    }
}

#[test]
fn mass_properties_are_the_volume_integrals() {
    let radius = 0.7;
    assert_matches_integral(&Collider::sphere(radius), DVec3::splat(radius), |point| point.length() <= radius);

    let size = DVec3::new(0.4, 1.0, 2.5);
    assert_matches_integral(&Collider::cuboid(size.x, size.y, size.z), size / 2.0, |_| true);

    let (radius, height) = (0.6, 1.7);
    let reach = DVec3::new(radius, 0.75 * height, radius);
    assert_matches_integral(&Collider::cone(radius, height), reach, |point| {
        let above_base = point.y + height / 4.0;
        above_base >= 0.0 && point.x.hypot(point.z) <= radius * (1.0 - above_base / height)
    });
}

#[test]
fn moments_are_the_closed_forms() {
    let of = |collider: Collider, mass| collider.mass_properties_of_mass(mass).inertia;
    let close = |a: DVec3, b: DVec3| (a - b).abs().max_element() < 1e-12;
    // 2/5 m r² = 2/5 · 5 · 4.
    assert!(close(of(Collider::sphere(2.0), 5.0), DVec3::splat(8.0)));
    // m/12 (y² + z²) = 24/12 · (4 + 9) and so on.
    assert!(close(of(Collider::cuboid(1.0, 2.0, 3.0), 24.0), DVec3::new(26.0, 20.0, 10.0)));
    // Axis 3/10 m r² = 0.3 · 10 · 4; across 3/80 m (4 r² + h²) = 0.375 · (16 + 9).
    assert!(close(of(Collider::cone(2.0, 3.0), 10.0), DVec3::new(9.375, 12.0, 9.375)));
    assert_eq!(of(Collider::half_space(), 1.0), DVec3::INFINITY);
}

#[test]
fn bounding_sphere_holds_every_vertex_and_touches_one() {
    // A flat cone, a tall one, and one near the border where apex and base are as far.
    for (radius, height) in [(1.0, 0.2), (0.3, 2.0), (1.0, 2f64.sqrt())] {
        let collider = Collider::cone(radius, height);
        let Geometry::Cone { hull, .. } = collider.geometry() else { panic!("a cone") };
        let farthest = hull.get().vertices.iter().map(|vertex| vertex.norm()).fold(0.0, f64::max);
        assert!((farthest / collider.bounding_radius() - 1.0).abs() < 1e-12);
    }
    assert_eq!(Collider::cuboid(2.0, 3.0, 6.0).bounding_radius(), 3.5);
    assert_eq!(Collider::sphere(2.0).bounding_radius(), 2.0);
}

#[test]
fn sizes_must_be_finite_and_positive() {
    assert!(Collider::half_space().is_valid());
    assert!(Collider::cone(0.1, 1e-3).is_valid());
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(!Collider::sphere(bad).is_valid(), "radius {bad}");
        assert!(!Collider::cuboid(1.0, bad, 1.0).is_valid(), "size {bad}");
        assert!(!Collider::cone(bad, 1.0).is_valid(), "base {bad}");
        assert!(!Collider::cone(1.0, bad).is_valid(), "height {bad}");
    }
}

fn cone_hull(radius: f64, height: f64) -> Hull {
    crate::physics::shape::cone::hull(radius, height)
}

#[test]
fn hull_is_closed_convex_and_outward() {
    // The last is a needle, whose base the vertex reduction has made coarser.
    for (radius, height) in [(0.5, 1.0), (2.0, 0.1), (0.05, 1.0), (0.01, 3.0)] {
        let hull = cone_hull(radius, height);
        let scale = hull.vertices.iter().map(|vertex| vertex.norm()).fold(0.0, f64::max);
        for face in &hull.faces {
            assert!((face.normal.norm() - 1.0).abs() < 1e-12);
            assert!(face.offset > 0.0, "a normal points inward");
            for (index, vertex) in hull.vertices.iter().enumerate() {
                let height = vertex.dot(&face.normal) - face.offset;
                let on_face = face.vertices.contains(&(index as u32));
                assert!(height <= 1e-12 * scale, "not convex: vertex {index} is {height} outside");
                assert_eq!(height > -1e-9 * scale, on_face);
            }
        }
        // Euler: V − E + F = 2 holds for a closed surface only.
        assert_eq!(hull.vertices.len() + hull.faces.len(), hull.edges.len() + 2);
    }
}

#[test]
fn cone_keeps_all_its_vertices_unless_it_is_a_needle() {
    assert_eq!(cone_hull(0.5, 1.0).vertices.len(), 25);
    assert_eq!(cone_hull(0.05, 1.0).vertices.len(), 25);
    assert_eq!(cone_hull(5.0, 0.01).vertices.len(), 25);
    let needle = cone_hull(0.001, 10.0).vertices.len();
    assert!((7..25).contains(&needle), "{needle} vertices");
}

#[test]
fn edge_directions_are_unique_up_to_sign() {
    // 24 base edges in 12 opposite pairs, and 24 flanks.
    assert_eq!(cone_hull(0.5, 1.0).edge_directions.len(), 36);
}
