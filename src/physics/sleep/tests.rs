use super::*;

/// Steps until one that moves so fast, m/s by step, may sleep; none within 200.
fn steps_until_it_rests(speed: impl Fn(u64) -> f64) -> Option<u64> {
    let motion = |step: u64| Motion { speed: speed(step - 100), ..Motion::default() };
    let mut calm = Calm::default();
    (100..300).find(|&step| calm.observe(motion(step), false, 0.1, step, 30)).map(|step| step - 100)
}

#[test]
fn it_rests_after_a_delay_without_a_restless_step_or_a_gain_of_speed() {
    assert_eq!(steps_until_it_rests(|_| 0.0), Some(30));
    assert_eq!(steps_until_it_rests(|_| 0.0999), Some(30));
    assert_eq!(steps_until_it_rests(|_| 0.1), None);
    assert_eq!(steps_until_it_rests(|step| if step == 20 { 0.1 } else { 0.0 }), Some(50));
    assert_eq!(steps_until_it_rests(|step| 0.1 / (1.0 + step as f64)), Some(30), "slower and slower, from the limit");
    // At 60 Hz 0.1 % of the limit a step is 3 % in the delay: more than it may gain.
    assert_eq!(steps_until_it_rests(|step| 1e-4 * step as f64), None);
    assert_eq!(steps_until_it_rests(|step| 1e-5 * step as f64), Some(30));
}

#[test]
fn what_turns_back_on_a_spring_does_not_rest() {
    // As fast 15 steps before it turns as 15 after.
    let motion = |step: u64| {
        let along = 1e-3 * (step as f64 - 15.0);
        Motion { speed: along.abs(), velocities: [along * Vector3::x(), Vector3::zeros()] }
    };
    for is_sprung in [false, true] {
        let mut calm = Calm::default();
        let rests = (0..=30).any(|step| calm.observe(motion(step), is_sprung, 0.1, step, 30));
        assert_eq!(rests, !is_sprung);
    }
}

#[test]
fn no_point_of_a_body_is_faster_than_its_speed() {
    let mut body = Body { radius: 2.0, ..Body::new(Entity::PLACEHOLDER) };
    body.linear = Vector3::new(3.0, 0.0, 4.0);
    body.angular = Vector3::new(0.0, 0.6, 0.8);
    assert!((Motion::of(&body).speed - (5.0 + 2.0)).abs() < 1e-12);
    // A rod without a shape, 12 kg and 2 m long: I = m l²/12 across, k = l/√12.
    body = Body { radius: 0.0, mass: 12.0, inverse_inertia_body: Vector3::new(0.25, 10.0, 0.25), ..body };
    assert!((Motion::of(&body).speed - (5.0 + 1.0 / 3.0_f64.sqrt())).abs() < 1e-12);
    body.inverse_inertia_body = Vector3::zeros();
    assert!((Motion::of(&body).speed - 5.0).abs() < 1e-12);
}
