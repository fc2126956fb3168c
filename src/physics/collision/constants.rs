//! The numbers that collision was tuned with. Of each: what it is, in which unit, why it is as large as that, and what
//! shows a change of it (a test by its file and name; *speed*: `peers -- speed`).

// What touches, and what gets contact points ahead.

/// Gap that counts as touching, as a share of the sum of the bounding radii: rounding could have made it of a gap of
/// zero. `sat::touching_is_a_contact_and_a_gap_is_not`.
pub(super) const CONTACT_TOLERANCE: f64 = 1e-9;
/// Share of it up to which a gap is rounded to zero where gaps are to be told exactly: rounding of places some ten radii from
/// the origin. With all of it, a column beside which a weight swings tilts until the base of each part is open by 1e-9
/// radii at one edge. `what_is_not_a_number_is_put_aside_and_the_rest_goes_on` (by `accurate`).
pub(super) const EXACT_ROUNDING: f64 = 1e-5;

/// Gap up to which surfaces that do not approach get contact points, as a share of a bounding radius: where contacts
/// last, resting bodies keep theirs though they tremble. `methods::a_gap_is_fallen_through`, *speed*.
pub(super) const SPECULATIVE_MARGIN: f64 = 0.01;

/// Longest arm about which a body turns a point of its own, m: half-spaces have no end.
/// `at_rest::what_rests_goes_along_with_its_floor`.
pub(super) const LONGEST_ARM: f64 = 1e6;

// Pairs that last, in the tree.

/// Margin of a fat box, as a share of the bounding radius. More of it means fewer updates and more pairs that do not
/// touch; measured on falling heaps and settled walls. *speed*.
pub(super) const FAT_MARGIN: f64 = 0.05;

/// Steps of travel at the present velocity that a fat box has ahead of it; the same balance. *speed*.
pub(super) const STEPS_AHEAD: f64 = 4.0;

/// Share of that margin that two bodies of which one has parts move in a step up to which it counts as lasting, so that
/// their parts are looked for with it; others are looked for in each step without. *speed*, `trees`.
pub(super) const LASTING_SHARE: f64 = 0.25;

// Contacts that last, in slots.

/// Share of the smaller bounding radius by which a pair with a curved surface may move before its manifold, of a point or
/// a line, is found anew. Where a ball touches does not turn with it: by so much the points lag behind, which is the arm at which they
/// push. A pair without points is looked at anew beyond it, too. `slide_roll`, `cones`, *speed*.
pub(super) const ROUND_RECYCLING: f64 = 1e-3;

/// Likewise of a pair of polyhedra, or one on a plane, and where a curved shape stands on its flat side: corners and edges turn with their bodies, and points that move
/// along with them are right to first order; half the square of this is what they miss. No more than
/// [`SPECULATIVE_MARGIN`]: what was beyond that margin and has no point cannot touch before the manifold is found anew.
/// `lasting_contacts::lasting_contacts_are_those_that_a_search_from_nothing_finds`, *speed*.
pub(super) const FLAT_RECYCLING: f64 = SPECULATIVE_MARGIN;

/// Share of the smaller bounding radius within which a point without a namesake takes over from an old one: as far as
/// a corner's name jumps where edges lie on edges. `at_rest::a_column_of_a_hundred_stands_for_a_minute`.
pub(super) const SUCCESSION_REACH: f64 = 0.1;

// Work of one thread at a time; results do not depend on it. *speed* on two threads.

/// Bodies that are looked at, and bodies whose new pairs are sought.
pub(super) const BODIES_A_CHUNK: usize = 256;
pub(super) const MOVED_A_CHUNK: usize = 32;
/// Slots: whole words of a bit set.
pub(super) const SLOTS_A_CHUNK: usize = 128;
/// Pairs of contacts that are found anew.
pub(super) const PAIRS_A_BLOCK: usize = 128;
/// Buckets of the sweep, each cheaper than a pair's test.
pub(super) const BUCKETS_A_BLOCK: usize = 512;

// The separating axis test and the choice of its axis.

/// An axis across edges, or the normal of a face of B, is taken only where its depth is below this share of that along
/// the best face (of A; apart: above it by the inverse), so that manifolds do not flicker between nearly equal axes.
/// `gaps::hovering_boxes_keep_their_normal_and_features`.
pub(super) const RIVAL_SHARE: f64 = 0.95;

/// Likewise below it by this share of the smaller bounding radius, for depths near zero. As above.
pub(super) const RIVAL_MARGIN: f64 = 1e-4;

/// The same where overlaps are to be told exactly: a choice of another axis than before must not make an overlap of what
/// touched. More than rounding, by which edges that lie in faces would win over these.
/// `gaps::another_axis_makes_no_overlap_where_the_least_is_asked_for`.
pub(super) const EXACT_RIVAL_MARGIN: f64 = 1e-8;
/// The same where points are looked for that carried something and are gone: as far as a forecast may tilt what lay flat.
/// `a_cone_rolls_over_the_edge_of_a_box`.
pub(super) const FACE_MARGIN: f64 = 1e-2;

/// What bounds leave out is worse by this share of the bounding radii: far more than rounding.
/// `feature_sat::depth_and_normal_are_the_least_over_all_faces_and_edges`.
pub(super) const BOUND_SLACK: f64 = 1e-9;

/// Sine of the angle under which two edges count as parallel: their cross product would be off by more than 1e-10.
/// Between parallel edges the least depth is along a face. `feature_sat::slivers_and_faces_edge_on_stay_finite`.
pub(super) const PARALLEL_SINE: f64 = 1e-6;

/// Its square, as two boxes measure it. `feature_sat::boxes_are_tested_as_hulls_are`.
pub(super) const PARALLEL_SQUARED_SINE: f64 = 1e-12;

/// Distance of a ball's centre from the nearest point of the other shape, as a share of its radius, under which the
/// direction between them is noise. `sat::known_depths`.
pub(super) const ON_SURFACE: f64 = 1e-12;

// Clipped faces.

/// Share of the smaller bounding radius by which sides of the reference face are moved outward, so that corners of
/// aligned boxes stay corners when rounding moves them across a side.
/// `manifolds::aligned_boxes_touch_in_four_corners_half_way_between_the_faces`.
pub(super) const SIDE_MARGIN: f64 = 1e-5;

/// Depths that are less than the greatest by up to this share of the smaller bounding radius count as deepest: the
/// first of them is taken, so that the choice does not flicker. `manifolds::resting_contacts_keep_their_features`.
pub(super) const NEARLY_DEEPEST: f64 = 1e-4;

/// Likewise squared distances and areas from this share of the greatest.
/// `manifolds::four_of_an_octagon_keep_its_square`.
pub(super) const NEARLY_WIDEST: f64 = 0.99;

/// A face whose deepest point has less than this share of the overlap, less [`SOUND_MARGIN`] of the smaller radius, has
/// lost to its sides what truly touches. `cones::points_lie_on_both_bodies`.
pub(super) const SOUND_SHARE: f64 = 0.9;
/// See there.
pub(super) const SOUND_MARGIN: f64 = 1e-4;

/// Squared sine of the angle under which two edges touch along a stretch, not in a point.
/// `cones::cones_side_by_side_touch_along_a_line`.
pub(super) const STRETCH_SQUARED_SINE: f64 = 1e-5;

// Shapes apart by less than the gap.

/// Share by which distances may differ that are the same to rounding.
/// `gaps::over_a_face_the_separation_is_the_distance`.
pub(super) const SAME_DISTANCE: f64 = 1e-9;

/// Squared distances of sides that cross at a right angle count for more by this share, so that of equally near ones
/// (at a common corner) the parallel ones are taken, which touch in two points.
/// `gaps::normals_turn_continuously_as_a_box_slides_off_another`.
pub(super) const CROSSING_PENALTY: f64 = 1e-4;

// Cones.

/// Corners of the polygon that stands for the base where faces are clipped, all on the rim: a base on a face is then
/// narrower by less than 1 %. `manifolds::cone_on_its_base_keeps_a_wide_stand`.
pub(super) const RIM_CORNERS: usize = 24;

/// Points of a rim that may touch a plane. `cones::cone_stands_on_four_points_lies_on_two_and_rolls_on_one`.
pub(super) const RIM_POINTS: usize = 4;

/// Sine of the tilt up to which a base faces a direction squarely: its corners then stay where they are on the body, so
/// that a cone at rest keeps its contact points. From twice that on the first corner is the foremost point of the rim,
/// which is exact for a cone that rolls on it. Between, the corners turn from one to the other. A corner at most is off
/// by 2r (1 − cos 45°) sin(tilt)/2 in depth. `cones::standing_cone_keeps_its_points_while_it_trembles`,
/// `cones::rolling_on_the_rim_moves_the_point_evenly`.
pub(super) const SQUARE_TILT: f64 = 1e-3;

/// Steps toward the nearest points of two cones before they count as near. *speed*.
pub(super) const APPROACH_STEPS: u32 = 6;
/// Steps after which they count as near if no direction yet separates them. *speed*.
pub(super) const APPROACH_TRIALS: u32 = 2;
/// Squared sine of the angle to an axis below which rounding counts in what is across it.
pub(super) const NEAR_AXIS: f64 = 1e-4;
/// Most steps of Newton's method around a flank's circle of normals; it takes about four.
/// `cone_tests::closed_forms_find_what_the_search_finds`, as all that follow here.
pub(super) const FLANK_STEPS: u32 = 12;
/// Most arcs by which a circle of normals is proved to be above a limit; mostly three.
pub(super) const CIRCLE_STEPS: u32 = 16;
/// Share of [`CONTACT_TOLERANCE`] by which a circle of normals is proved to be above its least, or nearly.
pub(super) const CIRCLE_SLACK: f64 = 0.1;
/// Arcs shorter than this make no progress around a circle, rad.
pub(super) const LEAST_ARC: f64 = 1e-13;
/// Most arcs of a rim that wait to be looked at.
pub(super) const RIM_ARCS: usize = 16;
/// Most arcs of a rim that are looked at; mostly two.
pub(super) const RIM_HALVINGS: u32 = 64;
/// Most places where rims meet.
pub(super) const RIM_MEETS: usize = 4;
/// How far the halves of an arc reach over its middle, rad: more than rounding.
pub(super) const ARC_OVERLAP: f64 = 1e-12;
/// Most steps of Newton's method between rims; it takes about four.
pub(super) const RIM_STEPS: u32 = 16;
/// Turn below which Newton's method is done, rad: it squares the error.
pub(super) const SETTLED_TURN: f64 = 1e-9;
/// Share of [`CONTACT_TOLERANCE`] that two bounds of one length may differ by.
pub(super) const SADDLE_GAP: f64 = 1e-3;
/// Samples of the depth around a flank's circle of normals, one beside each minimum.
/// `cones::depth_is_the_least_over_all_directions`, as all that follow here.
pub(super) const CIRCLE_SAMPLES: usize = 24;
/// Steps of the golden section: from two samples' distance to 1e-9 rad.
pub(super) const GOLDEN_STEPS: u32 = 42;
/// Longest step of Newton's method, rad.
pub(super) const LONGEST_TURN: f64 = 0.4;
/// Sine to within which a normal is one of a flank's own.
pub(super) const ON_FLANK: f64 = 1e-7;
/// Share of the radius to within which a normal lies in an edge's arc and a vertex is foremost.
pub(super) const ARC_ROUNDING: f64 = 1e-12;
/// Half axes of an ellipse below this share of the radius leave no direction.
pub(super) const FLAT_ELLIPSE: f64 = 1e-12;
/// Most steps of the safeguarded Newton iteration for the feet on an ellipse; it takes about five.
/// `ellipse::feet_are_all_the_nearest_points_on_either_side`.
pub(super) const FOOT_STEPS: u32 = 60;

/// Mass of a body over that of another from which on the two get contacts before they come together, in case the first is
/// stopped: the heavier pushes the other into what stops it (`heavy_loads`: a column).
pub(super) const UNEQUAL_MASSES: f64 = 8.0;

/// Near pairs of a body that stands in a row at most: what is before and behind it, and the ground. All that is behind in
/// the row pushes it, whatever each weighs (`heavy_loads`: a column of equal cubes). Where all bodies counted so, a heap of
/// boxes took 1.3 of the time.
pub(super) const PAIRS_IN_ROW: u32 = 3;

// What is fast.

/// Advances of a pair before it is taken to touch where it is then: at corners that pass each other the bound is far
/// from sharp. `fast_bodies::what_passes_beside_goes_on_as_it_was`.
pub(super) const MOST_ADVANCES: usize = 64;

/// Gap that counts as touching there, as a share of the ball that the thinner body holds: what passes beside by more is
/// not stopped. `fast_bodies::a_rod_that_spins_clear_of_a_wall_is_not_touched`.
pub(super) const IMPACT_TOLERANCE: f64 = 0.01;

/// Share of the radius of the ball that a body holds that its core has: half of what is thick may be in a wall before
/// it is held back. `fast_bodies::nothing_slides_out_of_the_corner_of_a_room`.
pub(super) const CORE_SHARE: f64 = 0.5;

/// The same of the core at which what is on joints is held: where its core does not touch yet, so that it is held in the next step
/// as well.
pub(super) const HELD_CORE_SHARE: f64 = 0.6;

// The 2009 engine's way. A change of any but the first shows in every scene with `classic`.

/// Moves for each body after which mending the order of the sweep is given up for sorting anew. *speed*.
pub(super) const MOVES_A_BODY: usize = 16;

/// Euclidean length below which a cross product of unit vectors is that of parallels: its direction would be off by
/// more than 1e-10. `vector_set::directions_are_normalised_and_zero_is_dropped`.
pub(super) const LEAST_AXIS: f64 = 1e-6;

/// Vertices within this share of the bounding radius of the farthest are extreme too.
/// `manifolds::extreme_vertices_of_a_slab_under_a_ball_are_its_far_corners`.
pub(super) const EXTREME_SHARE: f64 = 1e-3;
