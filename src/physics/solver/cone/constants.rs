//! The tuning constants of the cone solver. They are without unit unless one is given; what each is for is what its
//! change would spoil. `cone::tests` bounds the steps of all of them, and the chart of `accurate` on `pile` and `limbs`
//! shows their cost.

/// Compliance ε of a Newton or interior step, as a share of 1/ρ: small against the smallest share that mass ratios of
/// 10⁶ leave, large against rounding. Seen by: sticking redundant points in `cone::tests`.
pub(super) const SOFTNESS: f64 = 1e-8;
/// A residual of so many roundings of the largest |λ|/ρ may be nothing else.
pub(super) const ROUNDINGS: f64 = 16.0;
/// Steps of all kinds after which a solve ends.
pub(super) const MOST_STEPS: u32 = 600;
/// Steps of all kinds after which [`ENOUGH_RESIDUAL`] is enough: in heaps with loops of joints each further digit may
/// take a hundred.
pub(super) const ENOUGH_STEPS: u32 = 150;
/// Residual, m/s, that is enough then.
pub(super) const ENOUGH_RESIDUAL: f64 = 1e-8;

/// Newton iterations at most; from a near guess it takes two or three.
pub(super) const NEWTON_ITERATIONS: u32 = 12;
/// From the second iteration on, each has to bring the norm of the residual down to this share.
pub(super) const NEWTON_GAIN: f64 = 0.7;
/// Factor by which the first iteration may raise it: the active set may change at once.
pub(super) const NEWTON_FIRST_LOSS: f64 = 1e3;

/// Proximal points at most: from a guess, before the interior point is asked, and after it.
pub(super) const PROXIMAL_POINTS: [u32; 2] = [12, 100];
/// Newton iterations for one proximal point; more than that and a softer problem is cheaper.
pub(super) const PROXIMAL_ITERATIONS: u32 = 15;
/// Halvings of a step in the line search.
pub(super) const HALVINGS: u32 = 5;
/// A proximal point is reached when its remaining equation moves no contact by more than this share of the residual.
pub(super) const PROXIMAL_ACCURACY: f64 = 0.05;
/// Compliance ε that the proximal points begin with, as a share of 1/ρ.
pub(super) const FIRST_SOFTNESS: f64 = 0.1;
/// ε of joints over that of contacts: they neither part nor slide, so that no step is too long for them, and redundant
/// ones need the fewer proximal points the smaller it is.
pub(super) const JOINT_SOFTNESS: f64 = 0.01;
/// Factor on ε after a proximal point that was reached.
pub(super) const SOFTNESS_FALL: f64 = 0.3;
/// Factor on ε after one that was not.
pub(super) const SOFTNESS_RISE: f64 = 5.0;
/// The least ε.
pub(super) const LEAST_SOFTNESS: f64 = 1e-6;
/// An ε that failed is tried again when the floor under ε, which falls by this factor a point, has come down to it.
pub(super) const FLOOR_DECAY: f64 = 0.8;
/// ε from which on the compliance is so large that any step is good.
pub(super) const MOST_SOFTNESS: f64 = 10.0;
/// Factor by which a proximal point may raise the residual.
pub(super) const PROXIMAL_LOSS: f64 = 10.0;
/// Proximal points without a residual less by a tenth after which it ends.
pub(super) const PATIENCE: u32 = 60;
/// ε below which Newton iterations on the rigid problem are tried.
pub(super) const NEARLY_RIGID: f64 = 0.02;

/// Steps of the interior point at most.
pub(super) const INTERIOR_STEPS: u32 = 30;
/// Share of the way to the cone's boundary that a step may go.
pub(super) const TO_BOUNDARY: f64 = 0.99;
/// Least share of the product that one step aims at.
pub(super) const LEAST_CENTRING: f64 = 1e-3;
/// The same while y is far from û.
pub(super) const FAR_CENTRING: f64 = 0.5;
/// y is far from û where the gap's energy is more than this share of the product.
pub(super) const FAR_GAP: f64 = 0.1;
/// A step shorter than this share is short.
pub(super) const SHORT_STEP: f64 = 0.01;
/// Short steps in a row that are the end.
pub(super) const SHORT_STEPS: u32 = 3;
/// Newton iterations on the law itself are tried once the product is down to this share of the first,
pub(super) const NEWTON_PRODUCT: f64 = 1e-3;
/// and then at each such share of the residual.
pub(super) const NEWTON_AGAIN: f64 = 0.1;
