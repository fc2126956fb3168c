//! The tuning constants of the exact method, by the file that reads them.

// The integrators of mechanisms: `gauss`, `lockstep`, `rattle`.

/// Iterations over the stages of [`gauss`](super::gauss) at most.
pub(super) const GAUSS_ITERATIONS: usize = 40;
/// Sweeps over the stages at most in which `gauss` solves the linear equations of all of them.
pub(super) const COUPLING_SWEEPS: usize = 16;
/// Share of the first sweep's change that ends them.
pub(super) const COUPLED: f64 = 0.03;
/// Iterations of [`lockstep`](super::lockstep) at most: what takes more is stiff, and left to `gauss`.
pub(super) const LOCKSTEP_ITERATIONS: usize = 24;
/// Newton iterations of [`rattle`](super::rattle) at most.
pub(super) const RATTLE_ITERATIONS: usize = 40;
/// Change in the last iteration over the square of the change in the first one, 1/m or 1/rad, that ends the
/// iterations. The first change is the error of continuing the step before, which has half the order of the step
/// itself, so that this is a small part of the step's own error. Seen by: energy in the truths of `chain` and `top`.
pub(super) const CHANGE_OVER_SQUARE: f64 = 1e-10;
/// Change of a turn, rad, or of a displacement, m, that ends the iterations in any case.
pub(super) const LEAST_CHANGE: f64 = 1e-18;
/// Change in the last iteration, m or rad, from which on `gauss` has not converged although it got no smaller.
pub(super) const GAUSS_UNCONVERGED: f64 = 1e-9;
/// Share of a change that an iteration with a factor that is kept leaves, from which on λ creeps along rows that are nearly
/// redundant,
pub(super) const CREEPING_SHARE: f64 = 0.9;
/// and change, m or rad, below which that is the end of the iterations. Seen by:
/// `a_figure_on_strings_begins_without_many_cuts`.
pub(super) const CREEPING_CHANGE: f64 = 1e-8;
/// Change in the last iteration from which on `lockstep` has not converged.
pub(super) const LOCKSTEP_UNCONVERGED: f64 = 1e-13;
/// Change, m or rad, in an iteration up to which the next one keeps the factor of rows that may be redundant.
pub(super) const KEEPS_FACTOR: f64 = 1e-6;
/// Share of the right side left by the method of multipliers up to which rows are redundant or not, and none nearly so.
pub(super) const CLEAR: f64 = 1e-5;
/// Share of the right side that ends the method of multipliers where a later iteration makes good what is left.
pub(super) const ENOUGH_OF_A_CORRECTION: f64 = 1e-3;
/// Change, m or rad, that no shorter iteration mends: the step is given up.
pub(super) const DIVERGED: f64 = 1e3;
/// How far from 1 the square of a rotation's norm may be before it is normalised.
pub(super) const NORMAL: f64 = 1e-14;
/// Factor on the softness of a spring at its largest force, along it: any that makes it no stiffness of weight.
pub(super) const SLACK: f64 = 1e9;
/// h²K over the inertia below which the geometric stiffness K is left out of the iteration matrix.
pub(super) const GAUSS_SOFT: f64 = 0.3;
/// The same from which on Radau's method takes the steps: ω²h² of oscillations that three stages do not resolve.
pub(super) const UNRESOLVED: f64 = 100.0;
/// ω²h² of bodies about the line of a joint's pull up to which `lockstep` is tried.
pub(super) const LOCKSTEP_SOFT: f64 = 3.0;
/// Share of a change that an iteration of `lockstep` leaves to the next from which on it factors the rows again, at the
/// poses that the stages have by then.
pub(super) const SLOW_ITERATION: f64 = 0.35;
/// How often it does so at most.
pub(super) const MOST_FACTORS: u32 = 4;
/// Turn of a step, rad, up to which the series of `lockstep` are exact to rounding.
pub(super) const SERIES_TURN: f64 = 0.8;

// Rows and their factor: `rows`, `projection`.

/// Least and largest share of its trace that is added to each block on the diagonal where rows may be redundant.
pub(super) const SHIFTS: [f64; 2] = [1e-10, 1e-3];
/// Iterations of the method of multipliers at least and at most: each leaves ε/(σ² + ε) of the error along a singular
/// value σ. Seen by: `bricard` and `andrews`, whose order is lost with the least.
pub(super) const MULTIPLIER_ITERATIONS: [usize; 2] = [6, 32];
/// Share of the residual that an iteration of the method of multipliers leaves from which on it ends: rounding, or rows
/// that contradict each other.
pub(super) const MULTIPLIER_STALLED: f64 = 0.9;
/// Iterations of the projection of positions at most.
pub(super) const PROJECTION_ITERATIONS: usize = 60;
/// Error of a joint over the length of its arms that rounding leaves.
pub(super) const JOINT_ROUNDING: f64 = 4e-16;
/// Turn, rad, that a projection takes levers to be resolved to. By trial: with 1e-4 a sheet of 30 × 30 joints parts,
/// with 3e-3 four-bar loops lose energy as they pass flat poses.
pub(super) const PROJECTED_TURN: f64 = 1e-3;
/// Share of the errors that an iteration leaves from which on the next one has the rows of the pose it led to.
pub(super) const SLOW_PROJECTION: f64 = 0.8;
/// Share left with such rows from which on the projection ends.
pub(super) const STUCK_PROJECTION: f64 = 0.95;
/// Displacement of a member, m or rad, from where rows were factored up to which velocities are projected with them:
/// near a singular pose the rows of another pose say too little of where it is singular, and errors grow.
pub(super) const STALE_ROWS: f64 = 1e-6;
/// Shortest share of a step in the line search of a projection.
pub(super) const SHORTEST_SHARE: f64 = 1e-3;
/// Range between limits of one coordinate, m or rad, from which on they never hold together: more than both may be
/// overshot by, [`TOUCHING`]. Seen by: `a_range_of_no_width_holds`.
pub(super) const NARROW_RANGE: f64 = 1e-6;
/// Softness of the rows of a spring where only rigid joints are to hold, 1/kg.
pub(super) const LOOSE: f64 = 1e200;

// Steps and their division: `stepper`, `mechanism`.

/// A step is divided into 2 to this power substeps at most.
pub(super) const MOST_DIVISIONS: u32 = 12;
/// Evaluations of all rows that a step may take, whatever the number of joints. Hard steps take some hundred.
pub(super) const MOST_EVALUATIONS: u32 = 500;
/// Evaluations times joints that a step may take: few joints may take more evaluations.
pub(super) const MOST_JOINT_EVALUATIONS: u64 = 200_000;
/// The same for a step with limits or other bounded rows, where each event takes some hundred. Seen by: parts of
/// `hinge_chain` with limits that are not settled.
pub(super) const MOST_EVENT_EVALUATIONS: u64 = 1_000_000;
/// A step is divided into 2 to this power substeps where they are Euler's.
pub(super) const EULER_DIVISIONS: u32 = 6;
/// Turn of a free body in a substep, rad: at twice that, a box that flips over its middle axis keeps no digit for a
/// second.
pub(super) const LONGEST_TURN: f64 = 0.8;
/// Substeps in a row that must converge before longer ones are tried.
pub(super) const CONVERGED_BEFORE_LONGER: u32 = 8;
/// Error of a joint after the projection that is reported, m. Near poses where ways to move branch a millionth may be
/// left: no linear step tells which to take.
pub(super) const PARTED: f64 = 1e-5;
/// ωt of a spring in a kick of length t that is softened: kicks and free motion in turn are stable for ω2t up to 2, and
/// a body may have two springs.
pub(super) const KICKED_SPRING: f64 = 0.7;

// Rows with bounds: `row_mode`, `active_set`, `bounded_rows`, `event_stepper`.

/// τ with which a motor with a largest force comes back to where it is to be, s: many steps, so that it is not stiff, and
/// long enough for weak ones to brake in. Seen by: `a_motor_that_lagged_comes_back_to_its_place`.
pub(super) const RETURN_TIME: f64 = 0.2;
/// Overlap of a limit that is left as it is, m or rad.
pub(super) const STOPPED_OVERLAP: f64 = 1e-11;
/// Approach of a limit, or wrong speed of a boxed row, that is left as it is, m/s or rad/s.
pub(super) const STOPPED_SPEED: f64 = 1e-11;
/// Speed up to which a limit that touches rests, and a boxed row has the speed that it wants, m/s or rad/s.
pub(super) const RESTING_SPEED: f64 = 1e-9;
/// Iterations over which rows hold at most, and two for each row that may.
pub(super) const ACTIVE_SET_ITERATIONS: usize = 30;
/// Of these, those in a row that do not lessen the number of contradictions before rows change one by one.
pub(super) const ACTIVE_SET_PATIENCE: usize = 3;
/// Turn, rad, that impacts and accelerations take levers to be resolved to. Where a loop is nearly at a singular pose, a
/// row that a longer turn hides keeps a speed, so that its joint parts at each event, and events follow each other without
/// end. Seen by: `a_limit_beside_a_loop_that_is_nearly_flat_takes_few_events`.
pub(super) const EVENT_TURN: f64 = 1e-5;
/// Error of λ or w that is none, as a share of the largest there is.
pub(super) const ACTIVE_SET_ERROR: f64 = 1e-9;
/// Acceleration of a row that is none, m/s² or rad/s²: what differences leave of users' velocity terms.
pub(super) const NO_ACCELERATION: f64 = 1e-10;
/// Projections of positions at most that put limits back: each may bring others over.
pub(super) const MOST_PUT_BACK: u32 = 4;
/// Events in a substep, after which nothing bounces and the rest of it goes by Euler's steps.
pub(super) const MOST_EVENTS: u32 = 1_000;
/// Time from an event to the next one, as a share of a substep, that counts as none.
pub(super) const SHORTEST_EVENT: f64 = 1e-9;
/// Smooth motion, as a share of a substep, that is too short for what limits knock off each other to fly.
pub(super) const CHATTER_TIME: f64 = 1e-3;
/// Such motions in a row after which slow limits stay together. Seen by: `limits_that_knock_each_other_off_come_to_rest`.
pub(super) const MOST_CHATTERS: u32 = 8;
/// Time that is left of a substep, as a share of it, that is none.
pub(super) const NO_TIME: f64 = 1e-12;

// Contact: `contact`.

/// Gap up to which surfaces touch, m.
pub(super) const TOUCHING: f64 = 1e-9;
/// Approach up to which nothing bounces, m/s: from there bounces go on for another 2e/(1 − e) times 1e-5 s.
pub(super) const LEAST_BOUNCE: f64 = 1e-4;
/// Impacts at one time, for each pair of a group, until the approaches that remain are stopped.
pub(super) const IMPACTS_OF_A_PAIR: usize = 100;
/// Forecasts of a smooth step at most.
pub(super) const MOST_FORECASTS: usize = 40;
/// Share of the least error of a forecast so far from which on one is better,
pub(super) const PROGRESS: f64 = 0.8;
/// and forecasts in a row that are none better after which the step is too long for them.
pub(super) const FORECAST_PATIENCE: u32 = 6;
/// Error of rows, over the least so far, from which on a forecast throws bodies away, so that the step is too long,
pub(super) const THROWN: f64 = 30.0;
/// and the least such error, m or rad.
pub(super) const LEAST_THROWN: f64 = 1e-3;
/// |θ| at most with which forecasts are mixed: what two of them say is no more than a guess where contacts come and go.
pub(super) const MOST_MIXED: f64 = 3.0;
/// Error of a forecast, m, that is none.
pub(super) const FORECAST_ERROR: f64 = 1e-13;
/// Error of a forecast, m, that is accepted where it falls no more.
pub(super) const STALLED_ERROR: f64 = 1e-9;
/// The same where features come and go: as faces tilt on each other, a pair touches at an edge in one forecast and at a
/// corner in the next, which no forecast has both. As much as [`MISSED`].
pub(super) const FLICKERING_ERROR: f64 = 1e-6;
/// Forecasts in a row that do not halve the least error, after which that is the one to accept.
pub(super) const FLICKERING_STALLS: u32 = 1;
/// Overlap at the end of a forecast, m, from which on contact points that it did not hold are held.
pub(super) const UNFORESEEN: f64 = 1e-7;
/// How often a step is done again for pairs that were not looked for when it began.
pub(super) const MOST_UNFORESEEN: u32 = 8;
/// How far from where a contact point has gone, as a share of the smaller body's radius and beyond the way of the bodies past
/// each other, one of the same name is the same,
pub(super) const SAME_NAME: f64 = 0.3;
/// and how far at most one of another name is.
pub(super) const SAME_PLACE: f64 = 0.005;
/// Cosine of the angle up to which a point met on the way is held along its pair's normal at the start.
pub(super) const SAME_PLANE: f64 = 0.95;
/// A limit is taken into a forecast where it would close at that many times its present speed, or at that speed, m/s or
/// rad/s: of those far from their stops the bias would be the measure of all residuals.
pub(super) const FORESEEN_SPEEDS: f64 = 4.0;
pub(super) const FORESEEN_SPEED: f64 = 1.0;
/// Residual of a solve times its length, m, up to which a step counts as solved.
pub(super) const UNSOLVED: f64 = 1e-7;
/// Cosine of the angle between the normal of the least overlap and that of a face whose points stand for it, at least,
/// how far both may differ in depth, as a share of it, and what rounding makes of that, as a share of the smaller radius.
/// Seen by: `a_cone_rolls_over_the_edge_of_a_box`.
pub(super) const NEARLY_THE_SAME: f64 = 1.0 - 2e-4;
pub(super) const SAME_DEPTH: f64 = 1e-3;
pub(super) const ROUNDED_DEPTH: f64 = 1e-11;
/// Overlap within which the time of a landing is found, m.
pub(super) const LANDED: f64 = 1e-11;
/// Overlap of contact points that are held, m, for which a smooth step is cut short.
pub(super) const MISSED: f64 = 1e-6;
/// Kinetic energy that rounding and order may make in a smooth step, as a share of what there is. Seen by: energy on
/// `pile` and `dominoes`.
pub(super) const ENERGY_GAINED: f64 = 3e-3;
/// The same of an impact. Seen by: `impacts_of_joined_bodies_give_no_energy`.
pub(super) const ENERGY_OF_IMPACT: f64 = 1e-9;
/// The same of a step of a mechanism, beyond which its equations were solved for another motion than the one that goes on. Seen by:
/// `accurate_keeps_to_its_laws_where_it_once_did_not`.
pub(super) const ENERGY_OF_ANOTHER: f64 = 0.03;
/// Kinetic energy over mass that counts as none, J/kg: that of 1.4e-4 m/s, with which [`FLICKERING_ERROR`] is closed in 7 ms.
/// With less, heaps that come to rest are cut to pieces in each step.
pub(super) const NO_ENERGY: f64 = 1e-8;
/// Smooth steps are not cut to less than this share of a substep for either.
pub(super) const SHORTEST_STEP: f64 = 1.0 / 256.0;
/// Longest share of a substep that goes by one forecast alone.
pub(super) const ROUGH_STEP: f64 = 1.0 / 16.0;
/// Factor by which a smooth step may be longer than the one before, at first: what could not be foreseen is mostly over
/// after a short one.
pub(super) const FIRST_GROWTH: f64 = 64.0;
/// Factor on that for each smooth step that has to be cut.
pub(super) const GROWTH_AFTER_CUT: f64 = 0.25;
/// The least that it falls to.
pub(super) const LEAST_GROWTH: f64 = 1.25;
/// Landings in a substep after which nothing bounces.
pub(super) const MOST_LANDINGS: u32 = 1_000;
/// Smooth steps tried to find the time of one landing.
pub(super) const MOST_TRIALS: usize = 80;
/// Share of the largest number of a row by which it may differ from that which a solver is set to. Loads of twenty bodies on each
/// other are the impulses of some m/s in a step, so that what comes of it is at most a tenth of what rests may miss.
pub(super) const SAME_ROWS: f64 = 1e-12;
/// Residual of a contact point that is asked for, m/s,
pub(super) const TOLERANCE: f64 = 1e-10;
/// the share of it that is asked for of velocities where no body is faster than that, m/s: what is left over would add up from
/// step to step until it has to be solved for again (*speed*, `pyramid`; `what_rests_is_seldom_solved_anew`),
pub(super) const STILL_SHARE: f64 = 0.1;
pub(super) const STILL_SPEED: f64 = 1e-6;
/// and the one where the work of a step is spent.
pub(super) const ROUGH_TOLERANCE: f64 = 1e-5;
/// How far bodies go at most that rest, m, surfaces as well as centres: as exactly as a landing is found ([`LANDED`]),
pub(super) const REST_WAY: f64 = 1e-11;
/// and how long they are to go no further, s. Seen by: `a_rod_that_leans_by_little_falls`.
pub(super) const REST_TIME: f64 = 0.5;
/// Residual, m/s, that is enough where points contradict each other.
pub(super) const SETTLED: f64 = 1e-8;
/// Residual, m/s, up to which what a solve could not get below is not tried again for some time.
pub(super) const WORTH_STALLING: f64 = 1e-5;
/// Residual that is asked for in a first forecast, m/s,
pub(super) const FORECAST_TOLERANCE: f64 = 1e-4;
/// less by the square of the fastest speed up to this one, m/s,
pub(super) const SLOW_SPEED: f64 = 1e-3;
/// and share of a forecast's error, over the step, that is asked for in the next.
pub(super) const FORECAST_SHARE: f64 = 0.02;
/// Factorisations that a step may take here, whatever the number of points.
pub(super) const MOST_FACTORISATIONS: u32 = 1_000;
/// Factorisations times points that a step may take: the hardest of `limbs` took a quarter of a million; few points may
/// take more factorisations. After that no forecast is mended.
pub(super) const MOST_POINT_FACTORISATIONS: u64 = 1_500_000;
/// Slip from which on a contact point slides, m/s.
pub(super) const SLIDING: f64 = 1e-6;
/// Factorisations of a group and step that pass whatever the time: small groups need no more, and are not to suffer from a
/// large one that was solved before them.
pub(super) const LATE_FACTORISATIONS: u32 = 16;
/// Factorisations of each solve that do once these are made.
pub(super) const LATE_SOLVE: u32 = 2;
