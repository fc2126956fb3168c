//! The front of what nothing beats.

/// Indices of the points that no other beats on both axes (cost, error; less is better), cheapest
/// first. Of equals the first counts.
pub fn front(points: &[(f64, f64)]) -> Vec<usize> {
    let mut order: Vec<usize> =
        (0..points.len()).filter(|&index| points[index].0.is_finite() && points[index].1.is_finite()).collect();
    order.sort_by(|&one, &other| {
        let ((cost, error), (other_cost, other_error)) = (points[one], points[other]);
        cost.total_cmp(&other_cost).then(error.total_cmp(&other_error))
    });
    let mut least = f64::INFINITY;
    order.retain(|&index| {
        let better = points[index].1 < least;
        if better {
            least = points[index].1;
        }
        better
    });
    order
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn front_is_what_no_other_point_beats() {
        let points = [(3.0, 1.0), (1.0, 4.0), (2.0, 4.0), (2.0, 2.0), (4.0, 1.0), (0.5, f64::NAN), (1.0, 5.0)];
        assert_eq!(front(&points), [1, 3, 0]);
        for (index, point) in points.iter().enumerate().filter(|(_, point)| point.1.is_finite()) {
            let beaten = front(&points).iter().any(|&other| points[other].0 <= point.0 && points[other].1 <= point.1);
            assert!(beaten, "point {index} is neither on the front nor beaten by it");
        }
        assert_eq!(front(&[]), [0_usize; 0]);
    }
}
