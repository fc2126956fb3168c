//! Impacts: what bounces, by a law of pairs.
//!
//! Of the pairs that touch and come together, the one that does so fastest bounces as if it were alone with what does
//! not bounce: its points get u⁺ = −e u⁻ along their normals (Newton's law, point by point), friction within its cone,
//! joints and the contacts that rest hold. That makes others come together; again, until none does. So an impact passes
//! through a row of balls from one to the next, as it does through real ones, whose contact times do not overlap if
//! there is any gap between them.

use nalgebra::Vector3;

use super::super::mechanism::Motion;
use super::flight::TOUCHING;
use super::kernel::{Kernel, View};
use super::sites::{Pairing, Site, Sites};
use crate::physics::contact::rebound;

/// Approach up to which nothing bounces, m/s: from there bounces go on for another 2e/(1 − e) times 1e-5 s.
pub(super) const LEAST_BOUNCE: f64 = 1e-4;
/// Impacts of a group at one time, for each of its pairs, until what is left is stopped.
const MOST_A_PAIR: usize = 100;

/// The impacts of a moment.
#[derive(Default)]
pub(super) struct Impacts {
    pub kernel: Kernel,
    held: Vec<Site>,
    gains: Vec<f64>,
    joint_gains: Vec<Vector3<f64>>,
}

/// Fastest approach of a pair's sites that touch, m/s; negative if all part.
pub(super) fn approach(sites: &[Site], motion: &[Motion]) -> f64 {
    let touching = sites.iter().filter(|site| site.gap <= TOUCHING);
    touching.map(|site| -site.opening(motion)).fold(f64::NEG_INFINITY, f64::max)
}

impl Impacts {
    /// Takes the velocities over all impacts that are due; if nothing may bounce, all is stopped. `note` is told what
    /// each solve pushed, N·s.
    pub fn pass(
        &mut self,
        view: View,
        pairings: &[Pairing],
        sites: &Sites,
        least: f64,
        may_bounce: bool,
        motion: &mut [Motion],
        mut note: impl FnMut(&[Site], &Kernel),
    ) {
        let mut count = 0;
        let most = if may_bounce { MOST_A_PAIR * pairings.len() } else { 0 };
        loop {
            let bouncing = pairings.iter().enumerate().filter(|(_, pairing)| pairing.surface.restitution > 0.0);
            let approaches = bouncing.map(|(index, _)| (index, approach(sites.of(index), motion)));
            let first = approaches.filter(|(_, speed)| *speed > least).max_by(|a, b| a.1.total_cmp(&b.1));
            let Some((first, _)) = first else { return };
            let ends = count >= most;
            let is_held = |site: &&Site| {
                let pairing = site.pairing as usize;
                site.gap <= TOUCHING && (ends || pairing == first || pairings[pairing].surface.restitution == 0.0)
            };
            self.held.clear();
            self.held.extend(sites.list.iter().filter(is_held).cloned());
            self.kernel.set(view, motion, self.held.iter());
            self.gains.clear();
            let restitution = pairings[first].surface.restitution;
            let gain = |site: &Site| {
                let bounces = !ends && site.pairing as usize == first;
                if bounces { -rebound(restitution, -site.opening(motion), 0.0) } else { 0.0 }
            };
            self.gains.extend(self.held.iter().map(gain));
            self.joint_gains.clear();
            self.joint_gains.resize(view.links.len(), Vector3::zeros());
            let impulses = &mut self.kernel.impulses;
            impulses.contacts.clear();
            impulses.contacts.resize(self.held.len(), Vector3::zeros());
            impulses.joints.clear();
            impulses.joints.resize(view.links.len(), Vector3::zeros());
            self.kernel.solve(motion, &self.gains, &self.joint_gains);
            note(&self.held, &self.kernel);
            count += 1;
            if ends {
                return;
            }
        }
    }
}
