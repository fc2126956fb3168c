//! The tuning constants of the direct solver and of its trees, each with its unit, its reason, and what notices a
//! change: a test of `tests/`, or a number that a scene gives.

/// Speed of a body, centre and rim together, up to which it is at rest, m/s: above what a step of gravity gives to what
/// lies, below what one sees (`resting`).
pub(super) const REST_SPEED: f64 = 0.05;

/// Products of blocks in a factorisation up to which an island is solved at rest: a wall of two hundred bodies, which one
/// substep of one sweep does not hold (`heavy_loads`: a wall of 15 rows).
pub(super) const REST_PRODUCTS: usize = 20_000;

/// Products of blocks in a factorisation up to which an island is solved in motion. Noticed by the clock alone.
pub(super) const MOTION_PRODUCTS: usize = 1_000;

/// Penalty of rows of contacts over the mass of the island, at rest: what moves in a step then is 1e-4 of what would
/// without the rows, and nothing once their impulses are right. The pivot of a body when its contacts are eliminated
/// has lost the square of that, over its share of the mass, in digits: with 1e6 a house of cards cannot be factored.
pub(super) const REST_CONTACT_PENALTY: f64 = 1e4;

/// Penalty of rows of contacts over the mass of the island, in motion: of what comes fast, so much is stopped in a
/// substep; what rests is exact, as the rows act about the impulses of before. With much more, active-set iterations do
/// not end (`joints_and_contacts`).
pub(super) const MOTION_CONTACT_PENALTY: f64 = 3.0;

/// Mass of a body over that of one that bears it from which on sweeps do not pass the load on in time (`heavy_loads`).
pub(super) const HEAVY_LOAD: f64 = 8.0;

/// Cosine of the greatest angle between what pushes a body and what keeps it from giving way: a ball that breaks through a wall
/// pushes cubes that others only touch at right angles. Noticed by the clock (`wrecking_ball`).
pub(super) const AGAINST: f64 = 0.5;

/// Products of blocks in a factorisation up to which an island of contacts alone, whose loads are heavy, is solved in
/// motion, a wall of a hundred and fifty bodies; the same over how many times heavier a load is than what bears it; and
/// that for each body, of which a tree takes two. Noticed by the clock: heaps are not to pay.
pub(super) const LOADED_PRODUCTS: usize = 8_000;
pub(super) const PRODUCTS_OF_RATIO: f64 = 20.0;
pub(super) const BODY_PRODUCTS_OF_RATIO: f64 = 0.5;

/// Products of blocks beyond those of trees that such islands may take in all before they are swept, those that they may
/// take again after a step, and for each body in it. A product takes 0.15 µs, and a body some 7 µs a step by sweeps: heaps of any
/// masses may take 150 ms once, and then 0.3 ms and a tenth longer a step. A ball that lands on a wall of 55 cubes takes 160 000,
/// on one of 105 770 000. Noticed by the clock (`heavy_loads`: heaps of unequal boxes).
pub(super) const RESERVE: f64 = 1e6;
pub(super) const INCOME_OF_STEP: f64 = 2_000.0;
pub(super) const INCOME_OF_BODY: f64 = 5.0;

/// How many times a row of bodies of which none is much heavier than the next pays for each product: without it, `heap` of 1000
/// balls took 1.6 of the time. A column of twenty cubes that lands pays a quarter of the reserve.
pub(super) const ROW_COST: usize = 20;

/// Penalty of rows of contacts over the mass of such an island: through a column of n it is as soft as an n-th
/// (`heavy_loads`).
pub(super) const LOADED_CONTACT_PENALTY: f64 = 100.0;

/// Slip at which friction of such an island has the largest impulse that it may have, m/s: with the penalty of normal
/// impulses, bodies that bear little would stick up to some µm/s, and the lines of Newton's method would end at the kink of
/// each. What rests does not slip, as impulses act about those of before (`heavy_loads`).
pub(super) const SLIP: f64 = 0.01;

/// Newton iterations in a substep of such an island at most, and products of blocks in all their factorisations; those after
/// which bounds of friction are not renewed again; and points tried along a line. A ball that lands on a wall of 105 cubes
/// takes 77, what lies two. Noticed by the clock, and by how many substeps do not end (`heavy_loads`).
pub(super) const LOADED_ITERATIONS: usize = 150;
pub(super) const LOADED_WORK: usize = 800_000;
pub(super) const BOUND_ITERATIONS: usize = 10;
pub(super) const LOADED_LINE_POINTS: usize = 32;

/// Share of the impulses of its contacts that a body may miss after so many iterations, ten times as much after as many
/// more, and at most. Noticed by the clock: the last of many rows takes a quarter of the time.
pub(super) const LATE_ITERATIONS: usize = 20;
pub(super) const LATE_SHARE: f64 = 1e-5;
pub(super) const MOST_SHARE: f64 = 1e-3;

/// How often the bounds of friction are renewed at most in a substep.
pub(super) const RENEWALS: usize = 8;

/// Share of an impulse that stops the fastest body by a row's penalty alone which is lost in rounding.
pub(super) const BALANCE_ROUNDING: f64 = 1e-12;

/// Speed of a body over that of the fastest before a substep beyond which what came out is not believed (`heavy_loads`).
pub(super) const BELIEVED_SPEED: f64 = 2.0;

/// Steps for which such an island is swept after one that was not believed, besides twice as many as the last time if that
/// was so, too. What is heavy sinks meanwhile. Noticed by the clock alone.
pub(super) const DOUBTFUL_STEPS: u32 = 1;

/// Penalty of a contact that bounces over that of one that does not: it is to part as it should in a single substep
/// (`joints_and_contacts`).
pub(super) const BOUNCE_PENALTY: f64 = 100.0;

/// Penalty of rows of joints over the mass of the lighter body. The pivot of that body when its joints are eliminated
/// has lost the square of that in digits (`joint_grid 30`, `limbs`: how far joints part).
pub(super) const JOINT_PENALTY: f64 = 1e5;

/// Gap of a joint over the rim of the smaller of its bodies from which on it starts from no impulse (`plumb monkey`: what is
/// tied so that it cannot hold).
pub(super) const TORN: f64 = 0.5;

/// Active-set iterations at rest, and in a substep in motion. What is left wrong is corrected in the next.
pub(super) const REST_ITERATIONS: usize = 12;
pub(super) const MOTION_ITERATIONS: usize = 6;

/// Active-set iterations in a substep in motion for as long as their velocities have more energy than there is: where
/// limbs hit their limits, many rows change (`pulled`: figures that are jerked about).
pub(super) const LONG_ITERATIONS: usize = 30;

/// Active-set iterations after a substep whose iterations did not end: limbs in a heap, most of which slide, seldom have
/// theirs end, and their next substep goes on from the last (`limbs`).
pub(super) const SHORT_ITERATIONS: usize = 2;

/// Where the iterations at rest fail, the next are made after as many steps as last time and as many more, up to this.
/// Noticed by the clock alone.
pub(super) const LONGEST_PAUSE: u32 = 64;

/// Speed of a body under which a step counts as having changed nothing, m/s: 0.1 mm in 100 s.
pub(super) const UNCHANGED_SPEED: f64 = 1e-6;

/// Impulse that is too small to iterate again for, over the weight of a body in a step (`resting`).
pub(super) const IMPULSE_TOLERANCE: f64 = 1e-3;

/// Share of the slope at its start at which a line search ends, and points that it tries at most: each costs a small
/// part of a factorisation. Noticed by the number of iterations alone.
pub(super) const LINE_SEARCH_SLOPE: f64 = 0.01;
pub(super) const LINE_SEARCH_POINTS: usize = 8;

/// Energy with the impulses expected over that without rows, and besides the speed of all bodies, m/s, from which on they
/// are not to be believed: what rests, hangs and turns expects what leaves it less, or little more; what a hand jams
/// somewhere expects its pull to change from substep to substep.
pub(super) const EXPECTED_GAIN: [f64; 2] = [4.0, 3.0];

/// Kinetic energy over that without rows which rounding does not explain.
pub(super) const ENERGY_ROUNDING: f64 = 1.001;

/// Change of a world inertia over its size, and displacement of a row over its arm, that a factor bears: what it then
/// solves is off by that share, and the next step makes up for it (`resting`).
pub(super) const INERTIA_CHANGE: f64 = 1e-3;
pub(super) const ARM_CHANGE: f64 = 1e-4;

/// Share of depths and gaps that is corrected in a step at rest, and fastest correction of a depth, m/s (`resting`).
pub(super) const REST_CORRECTION: f64 = 0.1;
pub(super) const REST_CORRECTION_SPEED: f64 = 0.2;

/// Shares of the depths of contacts, and of the gaps of joints, that are corrected in a substep in motion
/// (`joints_and_contacts`).
pub(super) const DEPTH_CORRECTION: f64 = 0.1;
pub(super) const GAP_CORRECTION: f64 = 0.5;

/// Turn of a body in a step from which on an island takes all substeps, rad. Limbs that lie on each other roll about
/// this fast, and their joints part no more; from 0.13 rad on some do by centimetres (`limbs`).
pub(super) const MOTION_TURN: f64 = 0.1;

/// Turns of a body in a step, rad, where joints have limits or hold more than points: from the first on rotations count and
/// joints are put together in each substep (`pulled`: figures that were jerked about come to rest), from the second on all
/// substeps are taken (`ragdolls`, `rain`: joints part by 1e-6 m up to 0.2 rad, by 1e-4 m with 0.3).
pub(super) const POSTURE_TURNS: [f64; 2] = [0.03, 0.2];

/// Turns of a body in a substep, rad, up to which what curves its way is taken in whole, and from which on not at all
/// (`pulled`: figures that are jerked about).
pub(super) const CURVING_TURNS: [f64; 2] = [0.25, 0.5];

/// Speed at which the anchors of a joint part, over what half a substep's turning gives, up to which that is taken in:
/// held ones part at that speed, a spin that is not held yet is ≥ 4 times as fast where anything is taken in
/// ([`CURVING_TURNS`]; `joining`: what spins far away).
pub(super) const JOINED_PARTING: f64 = 3.0;

/// Depth or gap, over the arm, at which surfaces count as just touching: single precision cannot tell.
pub(super) const TOUCHING: f64 = 1e-5;

/// Errors of a row at the end of a substep, m or rad, from which on the impulses of joints without contacts are mended
/// again, where joints are a tree and where they close loops, whose redundant rows add them up (`bricard`); and how often
/// at most (`machines`: how far hinges part).
pub(super) const DUAL_ERRORS: [f64; 2] = [3e-7, 1e-9];
pub(super) const DUAL_ITERATIONS: usize = 12;

/// Error of a row at its bound, m or rad, from which on it leaves it.
pub(super) const DUAL_LEFT: f64 = 1e-9;

/// How often it is told anew which limits and largest forces are met (`machines`).
pub(super) const DUAL_ACTIVE_SETS: usize = 10;

/// Share of each row's mobility that is added to it: where joints are a tree, as much as rounding; where they close
/// loops, in which rows may be redundant, so much that the factor keeps half its digits (`bricard`).
pub(super) const DUAL_SHIFTS: [f64; 2] = [1e-13, 1e-7];

/// Shares that are tried where these leave an error over [`DUAL_ACCEPTED`], m or rad (`four_bar` as it lies flat).
pub(super) const DUAL_SOFTER: [f64; 3] = [1e-5, 1e-3, 1e-1];
pub(super) const DUAL_ACCEPTED: f64 = 1e-5;

/// Into how many pieces a substep is cut at most where its impulses are not found (`hinge_chain`: the crack of a whip).
pub(super) const DUAL_PIECES: u32 = 16;

/// Speed along a row that only holds, m/s, up to which nothing is looked at, and the share of the energy at hand that such
/// rows may give: a piece in which they give more is one that turns too far (`joining`: a rod whose end flies past it).
pub(super) const DUAL_THROWN: [f64; 2] = [0.01, 0.05];

/// ω h of springs up to which they are Newmark's, and from which on Euler's (`servo` from 10 Hz to 10 kHz).
pub(super) const DUAL_STIFF: [f64; 2] = [1.0, 2.0];

/// Mobility of a row that has its impulse already: it takes no other.
pub(super) const DUAL_LOOSE: f64 = 1e200;

/// Error of a row at the start of a substep, m or rad, from which on it is corrected in the poses alone.
pub(super) const DUAL_START_ERROR: f64 = 2e-6;

/// Error, m or rad, from which on a motion with a largest force lags behind.
pub(super) const DUAL_LAG: f64 = 1e-6;

/// Products of blocks in a factorisation of the rows of joints without contacts, and of the bodies of joints that are put
/// together in the poses. Noticed by the clock alone.
pub(super) const DUAL_PRODUCTS: usize = 20_000;

/// Speed of a body up to which joints without contacts are solved as at rest, m/s: their motion is told to second order,
/// that of a step at rest to first.
pub(super) const DUAL_REST_SPEED: f64 = 1e-3;

/// Error of a joint beside contacts at the end of a substep, m or rad, from which on it is corrected in the poses alone,
/// and how often at most (`ragdolls`: how far joints part).
pub(super) const PROJECTION_ERROR: f64 = 1e-6;
pub(super) const PROJECTIONS: usize = 4;
/// Largest error before a correction, m or rad, whose remainder is not looked at: that is the square of it over an arm, and
/// up to as much as itself at a limit that the correction runs into.
pub(super) const PROJECTED: f64 = 3e-5;

/// Share of a largest force from which on a row starts at it, and rounding of one that was at it (`car`: how many
/// iterations end).
pub(super) const LIKELY_BOUND: f64 = 0.05;
pub(super) const BOUND_ROUNDING: f64 = 1e-9;

/// Rims nearer to the centre and further from it than these, m, count as there: a body without a shape has none, one that
/// is huge is not to be held to moves that nobody sees.
pub(super) const RIMS: [f64; 2] = [0.1, 10.0];
