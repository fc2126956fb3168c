//! The tuning constants of the cone solver. They are without unit unless one is given; what each is for is what its
//! change would spoil. `cone::tests` bounds the steps of all of them, and the cost of
//! `heap`, `limbs` and `pile` by `accurate` shows it.

/// A residual of so many roundings of the largest |λ|/ρ may be nothing else.
pub(super) const ROUNDINGS: f64 = 16.0;
/// Speed, m/s, at which points that no motion obeys come together at least.
pub(super) const LEAST_JAM: f64 = 1e-6;
/// Newton iterations after which a solve ends.
pub(super) const MOST_STEPS: u32 = 600;
/// Points up to which a residual is relative to no more than this share of the fastest point's speed: their last digits cost
/// little, and what rests beside something fast, or itself rolls fast, adds up what is left over. Seen by:
/// `few_points_end_as_near_to_their_laws_however_fast_they_came`.
pub(super) const FEW_POINTS: usize = 40;
pub(super) const SHARE_OF_FEW: f64 = 0.01;
/// Residual, m/s, that is enough where it falls no more: points that are redundant and contradict each other by that much,
/// as forecasts of gaps do, take hundreds of iterations for each further digit.
pub(super) const ENOUGH_RESIDUAL: f64 = 1e-8;
/// Proximal points without a residual less by a tenth after which it falls no more.
pub(super) const STALLED: u32 = 3;
/// The same where it is not enough,
pub(super) const PATIENCE: u32 = 30;
/// and above this residual, m/s: mostly there is no solution near, as where joints come straight between two that hold them,
/// or a ball is wedged between bricks. *speed*, `limbs` with a figure that is pulled by 800 N, `wrecking_ball`.
pub(super) const FAR: f64 = 1e-4;
pub(super) const FAR_PATIENCE: u32 = 8;
/// Residual, m/s, above which a solve that did not end well begins once more, from what is wedged.
pub(super) const WEDGED: f64 = 1e-4;

/// Sweeps of Gauss–Seidel with which a solve ends whose time is over.
pub(super) const LATE_SWEEPS: u32 = 50;

/// Share of the right-hand side that the defect of a linear system may be,
pub(super) const SOLVED: f64 = 1e-10;
/// and refinements after which it may be more.
pub(super) const MOST_REFINEMENTS: u32 = 4;

/// Halvings of a step in the line search.
pub(super) const HALVINGS: i32 = 2;
/// Share of |F| that a step leaves from which on it is poor.
pub(super) const POOR_GAIN: f64 = 0.85;
/// Poor steps after which a softer problem is cheaper.
pub(super) const MOST_POOR: u32 = 3;

/// Proximal points at most.
pub(super) const PROXIMAL_POINTS: u32 = 150;
/// Newton iterations for one proximal point at most.
pub(super) const PROXIMAL_ITERATIONS: u32 = 15;
/// A proximal point is reached when no |F|/ρ is more than this share of the residual.
pub(super) const PROXIMAL_ACCURACY: f64 = 0.1;
/// Compliance ε that the proximal points begin with, as a share of 1/ρ,
pub(super) const FIRST_SOFTNESS: f64 = 0.1;
/// and that of the first from a guess: near enough to a solution, a few iterations are all, and they end far below what is
/// asked for. 1e-4 is faster, but what rests creeps. Seen by: `what_is_not_a_number_is_put_aside_and_the_rest_goes_on`.
pub(super) const GUESSED_SOFTNESS: f64 = 1e-5;
/// ε of joints over that of contacts: they neither part nor slide, so that no step is too long for them, and redundant
/// ones need the fewer proximal points the smaller it is.
pub(super) const JOINT_SOFTNESS: f64 = 0.01;
/// Mobility of a joint over what it is without turns of its bodies from which on its compliance grows no more with it. On a
/// slider that is far out bodies would turn about levers of many times their size, were they not kept from it by other rows.
/// With a compliance for such turns the first proximal points have joints part faster than anything lands, and the last are
/// still far off (`a_slider_that_is_far_out_bears_an_impact`; joints of scenes drawn by lot part by 0.3 mm).
pub(super) const LEVER: f64 = 10.0;
/// The least ε of joints.
pub(super) const LEAST_JOINT_SOFTNESS: f64 = 1e-8;
/// Factor on ε after a proximal point that was reached within so many iterations.
pub(super) const SOFTNESS_FALLS: [(u32, f64); 4] = [(1, 0.01), (3, 0.1), (8, 0.2), (PROXIMAL_ITERATIONS, 0.4)];
/// Factor on ε after one that was not.
pub(super) const SOFTNESS_RISE: f64 = 4.0;
/// ε that the next proximal points do not fall below, over that of the one that was not reached: most others as stiff would
/// not be either. Without it half of a heap's iterations are made for such,
pub(super) const MISSED_SOFTNESS: f64 = 2.0;
/// and factor on that bound for each that is reached.
pub(super) const MISSED_FADES: f64 = 0.5;
/// The least ε.
pub(super) const LEAST_SOFTNESS: f64 = 1e-7;
/// ε from which on the compliance is so large that any step is good.
pub(super) const MOST_SOFTNESS: f64 = 10.0;
