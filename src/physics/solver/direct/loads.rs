//! What an island of contacts alone keeps from step to step, and from the start of a step on, and what all of them may
//! spend; [`loaded`](super::loaded) tells of what for.

use nalgebra::Vector3;

use super::constants::{INCOME_OF_BODY, INCOME_OF_STEP, RESERVE};
use crate::physics::body::Body;
use crate::physics::constraint::row::Twist;
use crate::physics::lanes::Record;

/// What is known of an island of contacts alone.
#[derive(Clone, Default)]
pub(super) struct Loads {
    /// The greatest load that a member may bear over its own mass; none: not asked for yet.
    pub mass_ratio: Option<f64>,
    /// Where the members are a row, of each contact: the mass behind it as A has it before itself, and as B has; else empty.
    pub behind: Vec<[f64; 2]>,
    /// Whether no member touches one that is much heavier: then it is the row that is.
    pub is_row: bool,
    /// Mass of a member over that of one that bears it, the greatest, in the step at hand.
    pub ratio: f64,
    /// Whether it may take more than a tree does, and how many products of blocks more it took since they were asked for.
    pub may_spend: bool,
    pub spent: usize,
    /// Steps for which it was swept after the last that failed, and those left.
    pub pause: u32,
    pub pause_left: u32,
    /// Of members: the heaviest body that pushes each, kg, and which way.
    pub heaviest: Vec<(f64, Vector3<f64>)>,
    /// Of members: the impulses of all contacts of each, one with another, N·s.
    pub borne: Vec<f64>,
    /// Of contacts: the relative motion at the present velocities, and how it changes along the line that is searched.
    pub lines: Vec<(Twist<f64>, Twist<f64>)>,
}

/// Members and impulses of contacts as the step found them.
#[derive(Clone, Default)]
pub(crate) struct Kept {
    pub bodies: Vec<Body>,
    pub impulses: Vec<Record<f32>>,
}

/// What may be spent on heavy loads in motion, in products of blocks beyond those of trees: a reserve, and an income by
/// steps and bodies.
#[derive(Clone, Debug, Default)]
pub(crate) struct LoadAccount {
    /// What is missing of the reserve.
    spent: f64,
}

impl LoadAccount {
    /// Takes in the income of a step of so many bodies. Whether there is something to spend.
    pub fn begin_step(&mut self, bodies: usize) -> bool {
        self.spent = (self.spent - INCOME_OF_STEP - INCOME_OF_BODY * bodies as f64).max(0.0);
        self.spent < RESERVE
    }

    /// Takes off what was spent.
    pub fn spend(&mut self, products: u64) {
        self.spent += products as f64;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_spent_comes_back_with_the_steps_and_the_bodies() {
        let mut account = LoadAccount::default();
        account.spend(RESERVE as u64 - 1);
        assert!(account.begin_step(0), "there is a reserve");
        account.spend(RESERVE as u64);
        let steps = |account: &mut LoadAccount, bodies| (1..10_000).find(|_| account.begin_step(bodies)).unwrap();
        let expected = |bodies: f64| (RESERVE / (INCOME_OF_STEP + INCOME_OF_BODY * bodies)).ceil();
        let few = f64::from(steps(&mut account, 10));
        assert!((few - expected(10.0)).abs() <= 1.0, "{few} steps of ten bodies");
        account.spend(RESERVE as u64);
        let many = f64::from(steps(&mut account, 1000));
        assert!((many - expected(1000.0)).abs() <= 1.0, "{many} steps of a thousand");
    }
}
