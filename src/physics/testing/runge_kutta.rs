//! Reference solutions of ordinary differential equations.

/// The state after a time, s, of what changes so, by the classical Runge–Kutta method in that many steps.
pub fn runge_kutta<const N: usize>(
    mut state: [f64; N],
    time: f64,
    steps: u32,
    change: impl Fn([f64; N]) -> [f64; N],
) -> [f64; N] {
    let h = time / f64::from(steps);
    for _ in 0..steps {
        let at = |slope: [f64; N], by: f64| std::array::from_fn(|k| state[k] + slope[k] * by);
        let first = change(state);
        let second = change(at(first, h / 2.0));
        let third = change(at(second, h / 2.0));
        let last = change(at(third, h));
        state = std::array::from_fn(|k| state[k] + h / 6.0 * (first[k] + 2.0 * second[k] + 2.0 * third[k] + last[k]));
    }
    state
}
