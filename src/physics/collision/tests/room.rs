use nalgebra::{UnitQuaternion, Vector3};

use crate::physics::collision::broad::bounding_tree::BoundingBox;
use crate::physics::collision::broad::fat_box::{Extent, Placement, Room};
use crate::physics::testing::Random;

/// Exact box of a cuboid about its placement.
fn extent(half: &Vector3<f64>, placement: &Placement) -> Extent {
    let reach = placement.rotation.to_rotation_matrix().into_inner().abs() * half;
    let at = placement.position;
    Extent { bounds: BoundingBox { low: at - reach, high: at + reach }, radius: half.norm(), moves: true }
}

/// The whole point of a room: what it holds has its swept box in the fat box.
#[test]
fn what_a_room_holds_is_inside_the_fat_box() {
    let (mut random, mut held, mut left) = (Random::new(11), 0, 0);
    for round in 0..2000 {
        let half = random.vector().map(|v| 0.02 + 3.0 * v.abs());
        let radius = half.norm();
        // At 10 000 km a coordinate is rounded by 1e-9 m, the computed box likewise.
        let origin = if round % 2 == 0 { 0.0 } else { 1e7 };
        let speed = 0.2 * radius * random.unit();
        let start = Placement {
            position: Vector3::repeat(origin) + random.vector(),
            rotation: UnitQuaternion::from_scaled_axis(3.0 * random.vector()),
            travel: speed * random.vector(),
            turn: if round % 3 == 0 { 0.3 * random.unit() } else { 0.0 },
        };
        let first = extent(&half, &start);
        let fat = first.fat(&start);
        let room = Room::new(&fat, &first, &start);
        assert!(fat.contains(&first.swept(&start)));
        for _ in 0..200 {
            let far = 0.3 * random.unit() * random.unit();
            let placement = Placement {
                position: start.position + 2.0 * start.travel + far * radius * random.vector(),
                rotation: UnitQuaternion::from_scaled_axis(far * random.vector()) * start.rotation,
                travel: random.unit() * start.travel,
                turn: random.unit() * start.turn,
            };
            if room.holds(&placement) {
                held += 1;
                let swept = extent(&half, &placement).swept(&placement);
                assert!(fat.contains(&swept), "round {round}: {swept:?} in {fat:?}");
            } else {
                left += 1;
            }
        }
    }
    assert!(held > 20_000 && left > 20_000, "{held} {left}: one side is hardly tested");
}

/// A swept box holds the body throughout the step, turned by any angle up to `turn`.
#[test]
fn the_swept_box_holds_the_body_on_its_way() {
    let mut random = Random::new(3);
    for _ in 0..500 {
        let half = random.vector().map(|v| 0.02 + v.abs());
        let spin = 2.0 * random.unit() * random.vector();
        let start = Placement {
            position: random.vector(),
            rotation: UnitQuaternion::from_scaled_axis(3.0 * random.vector()),
            travel: random.vector(),
            turn: spin.norm(),
        };
        let swept = extent(&half, &start).swept(&start);
        let slack = Vector3::repeat(1e-12);
        let swept = BoundingBox { low: swept.low - slack, high: swept.high + slack };
        for share in [0.0, 0.2, 0.5, 0.9, 1.0] {
            let on_the_way = Placement {
                position: start.position + share * start.travel,
                rotation: UnitQuaternion::from_scaled_axis(share * spin) * start.rotation,
                ..start
            };
            assert!(swept.contains(&extent(&half, &on_the_way).bounds));
        }
    }
}

/// A ball that rolls where it is, or a cube that once tumbled, stays in its room whatever it turns.
#[test]
fn what_is_boxed_by_its_sphere_may_turn() {
    let still = Placement {
        position: Vector3::new(5.0, 1.0, 0.0),
        rotation: UnitQuaternion::identity(),
        travel: Vector3::zeros(),
        turn: 0.0,
    };
    let radius = Vector3::repeat(1.0);
    let ball = Extent {
        bounds: BoundingBox { low: still.position - radius, high: still.position + radius },
        radius: 1.0,
        moves: true,
    };
    let room = Room::new(&ball.fat(&still), &ball, &still);
    let rolled = Placement { rotation: UnitQuaternion::from_scaled_axis(Vector3::new(2.0, 1.0, 0.5)), ..still };
    assert!(room.holds(&rolled));
    let tumbling = Placement { turn: 1.0, ..still };
    let cube = extent(&Vector3::repeat(0.5), &tumbling);
    let room = Room::new(&cube.fat(&tumbling), &cube, &tumbling);
    assert!(room.holds(&Placement { turn: 1.0, ..rolled }));
}

/// At the very edge of a room, found by bisection, rounding must still fall on the safe side.
#[test]
fn the_edge_of_a_room_is_inside_the_fat_box() {
    let mut random = Random::new(21);
    for round in 0..400 {
        let half = random.vector().map(|v| 0.02 + v.abs());
        // Where a coordinate's last digit is worth 2e-6 m, nothing else hides it.
        let origin = if round % 2 == 0 { 0.0 } else { 1e10 };
        let start = Placement {
            position: Vector3::repeat(origin) + random.vector(),
            rotation: UnitQuaternion::from_scaled_axis(3.0 * random.vector()),
            travel: Vector3::zeros(),
            turn: 0.0,
        };
        let first = extent(&half, &start);
        let fat = first.fat(&start);
        let room = Room::new(&fat, &first, &start);
        let along = random.vector();
        let placed = |share: f64| Placement { position: start.position + share * along, ..start };
        let (mut inside, mut outside) = (0.0, 100.0);
        for _ in 0..80 {
            let middle = 0.5 * (inside + outside);
            *(if room.holds(&placed(middle)) { &mut inside } else { &mut outside }) = middle;
        }
        assert!(inside > 0.0);
        let edge = placed(inside);
        assert!(fat.contains(&extent(&half, &edge).swept(&edge)), "round {round}");
    }
}
