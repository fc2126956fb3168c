//! Which joints form trees, and that the work is linear.

use super::{Assembly, NONE, partition};
use crate::physics::testing::Random;

#[test]
fn work_grows_with_the_joints_only() {
    let random = &mut Random::new(11);
    let star = |n, random: &mut Random| Assembly::tree(n, random, |_, _| 0);
    let caterpillar = |n, random: &mut Random| Assembly::tree(n, random, |body, _| body.saturating_sub(4) / 4 * 4);
    for assembly in [star(1000, random), star(2000, random), caterpillar(2000, random)] {
        let trees = assembly.trees();
        let [tree] = &trees[..] else { panic!("one component") };
        let links = tree.joints.iter().filter(|joint| joint.next != NONE).count();
        // Each joint is eliminated once, by constant work for the one link or hub above it.
        assert!(links + tree.branches.len() <= tree.joints.len());
        assert!(tree.hubs.len() <= tree.moving());
    }
}

#[test]
fn loops_are_left_over_and_pins_do_not_join() {
    // 0–1–2 in a loop; 3–4 twice joined; 5–6 and 7 on the same static body 8; 9 alone with itself.
    let joints = [[0, 1], [1, 2], [2, 0], [3, 4], [4, 3], [5, 6], [8, 5], [7, 8], [9, 9], [8, 10]];
    let moves = [true, true, true, true, true, true, true, true, false, true, false];
    let partition = partition(&joints, &moves);
    assert_eq!(partition.left_over, [0, 1, 2, 3, 4]);
    let of_trees: Vec<Vec<u32>> = partition
        .trees
        .iter()
        .map(|tree| {
            let mut joints = tree.joints().to_vec();
            joints.sort_unstable();
            joints
        })
        .collect();
    assert_eq!(of_trees, [vec![5, 6], vec![7]]);
    assert_eq!(partition.trees[0].moving(), 2);
    assert_eq!(partition.trees[0].bodies().len(), 3);
}
