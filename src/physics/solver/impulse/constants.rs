//! The tuning constants of the impulse engine, each with its unit, its reason, and what notices a change: a test of
//! `tests/`, or a number that a scene gives.

/// Updates of points and friction in one update of a contact block. The second costs no memory and lets points and
/// friction of a manifold agree: columns rock a third as much (`standing`: `stack 30`).
pub(super) const CONTACT_ROUNDS: usize = 2;

/// Most sweeps over the contacts that bounce before a substep: an impact is passed on by at least as many bodies, the rest
/// is taken away (`bouncing`: a row of balls; `cradle`).
pub(super) const IMPACT_SWEEPS: u32 = 10;

/// Updates of the points of a manifold in one update of its impact, after which they are to agree (`bouncing`: a box that
/// lands flat).
pub(super) const IMPACT_ROUNDS: usize = 6;

/// Share of its effect that a contact's push has by turning a body, below which it counts as one through the centre:
/// rounding of what balls have. Noticed by `impulse::tests`.
pub(super) const CENTRAL: f64 = 1e-10;

/// W, the whitening of what constraints do not move. A power of two rounds nothing, and squared it is lost beside any
/// inverse inertia in `f32`. Noticed by `impulse::tests`.
pub(super) const UNMOVED_WHITENING: f64 = 1.0 / (1_u64 << 40) as f64;

/// Turn up to which a body keeps the frame that rows of contacts were made for, rad. Without it softness lets columns
/// lean: see [`super::soft_step`] (`standing`: `stack 30`).
pub(super) const FRAME_TURN: f64 = 0.01;

/// Angular speed up to which a body keeps that frame, rad/s: what leans for being soft does so slowly, and what turns by
/// itself keeps its angular momentum only in the frame that it has (`methods`: momentum of free collisions).
pub(super) const FRAME_SPEED: f64 = 0.1;

/// Natural frequency of soft contacts over substeps a second. What a sweep can follow is about a quarter (Catto 2024);
/// stiffer, large walls tremble, softer, columns sink deeper (`standing`: `pyramid 40`, `stack 30`).
pub(super) const CONTACT_FREQUENCY: f64 = 0.1875;

/// Damping ratio of soft contacts: they must not bounce. Less lets them ring, more lets columns creep (`resting`).
pub(super) const CONTACT_DAMPING: f64 = 5.0;

/// Natural frequency of swept joints over substeps a second, and their damping ratio: as stiff as a sweep can follow
/// (`joint_grid`).
pub(super) const JOINT_FREQUENCY: f64 = 0.25;
pub(super) const JOINT_DAMPING: f64 = 2.0;

/// Turn of a body on swept joints in a step beyond which the soft step makes rows for each substep, rad: rows of the
/// start would be wrong by a tenth of a limb.
pub(super) const SOFT_STEP_TURN: f64 = 0.1;

/// The same of sequential impulses, rad: by then rows of the start miss 5e-5 of a limb, which nothing soft hides.
pub(super) const SEQUENTIAL_IMPULSES_TURN: f64 = 0.01;

/// The same of extended position-based dynamics, rad: what a turn θ of an arm r misses, ½ r θ², comes back as a speed.
pub(super) const XPBD_TURN: f64 = 0.01;

/// Turn of a body in a substep beyond which joints do not start from the impulses of the substep before, rad: what holds a
/// point of a body that turns by θ turns with it, and given again as it was it is wrong by more than itself from θ = π/3 on
/// (`sweeps_over_a_net_give_nothing_back_to_what_turns_by_radians_a_substep`).
pub(super) const WARM_START_TURN: f64 = 1.0;

/// Sweeps over positions in a substep of sequential impulses (`methods`: overlaps are corrected).
pub(super) const POSITION_SWEEPS: u32 = 3;

/// Share of a contact's error that an update of its position corrects. Neighbours correct it too: all of it would be too
/// much (`methods`: a column of ten stands).
pub(super) const CONTACT_SHARE: f64 = 0.1;

/// Share of a joint's error that an update of its position corrects (`joint_grid 30` ends closed).
pub(super) const JOINT_SHARE: f64 = 1.0;

/// Blocks of constraints from which on a group is worth more threads than one: a stage of fewer takes less time than
/// the others need to see it. Noticed by the clock alone.
pub(super) const PARALLEL_BLOCKS: usize = 96;

/// Bodies, and blocks of constraints, that one thread takes at a time: some microseconds of work. Noticed by the clock
/// alone.
pub(super) const CHUNK_BODIES: usize = 64;
pub(super) const CHUNK_BLOCKS: usize = 8;

/// Bodies of a group beyond which none of its islands without joints is solved directly, and bodies of an island beyond
/// which it is not: to look for them would cost more than they save. Noticed by the clock alone.
pub(super) const DIRECT_BODIES: usize = 512;

/// Newton iterations on positions when a tree begins: enough for any error that a user makes by hand.
pub(super) const TREE_START_ITERATIONS: usize = 8;

/// Separation under which the joints of a tree count as closed, m: rounding of poses of about a metre (`pendulum`).
pub(super) const TREE_CLOSED: f64 = 1e-13;

/// Turn of a body in a step from which on a tree takes all substeps, rad: a chain's energy pays for more (`chain 100`).
pub(super) const TREE_TURN: f64 = 0.05;

/// Turn of an arm in a substep, rad, up to which its joint is aimed along its arc and what the projection moved counts as
/// velocity (`an_arm_that_turns_too_far_to_be_followed_gives_no_energy`).
pub(super) const TREE_FOLLOWED: f64 = 1.0;

/// Turn of the last projection, rad, times ω²h², up to which the factor of the pose before serves with one step of
/// refinement: what is left then is its square of the impulses (`chain 1000`).
pub(super) const TREE_FACTOR_LAG: f64 = 1e-3;

/// Share of its own effect that a row of a joint gives beside it: rows that say the same are told apart by that, in
/// single precision.
pub(super) const DEPENDENT_ROWS: f64 = 1e-5;

/// Speed along a row per impulse, 1/kg or 1/(kg m²), under which nothing can move along it: what the whitening of bodies
/// that do not move leaves is far below, a world of a megaton above.
pub(super) const LEAST_MOBILITY: f64 = 1e-15;
