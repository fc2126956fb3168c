//! The measurements of a run for a person to read.

use crate::lab::{ExactCounts, JointLoadMax, LimitOvershoot, Metrics, MomentumMetrics};
use crate::physics::SETTINGS;

pub(super) fn of(metrics: &Metrics) -> String {
    let rows = rows(metrics);
    let width = rows.iter().map(|(label, _)| label.chars().count()).max().unwrap_or(0) + 2;
    rows.into_iter().map(|(label, value)| format!("{label:width$}{value}\n")).collect()
}

fn rows(metrics: &Metrics) -> Vec<(String, String)> {
    let Metrics { settings, ms_per_step, energy, .. } = metrics;
    let parameters: Vec<String> = metrics.parameters.iter().map(|(name, value)| format!(" {name}={value}")).collect();
    let drift = energy
        .max_relative_drift
        .map_or_else(|| "nothing moved".into(), |drift| format!("strayed by {}", short(drift)));
    let counts = [("substeps", settings.substeps), ("iterations", settings.iterations)];
    let is_read = |name: &str| SETTINGS.iter().any(|setting| setting.name == name && setting.is_read(settings));
    let counts = counts.into_iter().filter(|(name, _)| is_read(name));
    let counts: Vec<String> = counts.map(|(name, count)| format!(", {name} {count}")).collect();
    let mut rows = vec![
        ("scene".into(), format!("{}{}", metrics.scene, parameters.concat())),
        (
            "holds".into(),
            format!("bodies {}, joints {}, contact points {}", metrics.bodies, metrics.joints, metrics.contacts),
        ),
        (
            "run".into(),
            format!(
                "{} steps of {} ms{}: {} s",
                metrics.steps,
                short(1e3 * settings.step()),
                counts.concat(),
                short(metrics.seconds)
            ),
        ),
        (
            "cost".into(),
            format!(
                "{} ms a step (median), {} ms (95 %), {} ms in all",
                short(ms_per_step.median),
                short(ms_per_step.p95),
                short(ms_per_step.total)
            ),
        ),
        ("energy".into(), format!("{} J to {} J, {drift}", short(energy.start), short(energy.end))),
        ("joint error".into(), format!("{} m at most", short(metrics.joint_error_max_m))),
    ];
    rows.extend(joints(metrics));
    rows.extend([
        ("penetration".into(), format!("{} m at most", short(metrics.penetration_max_m))),
        (
            "moved".into(),
            format!("{} m down, {} m sideways at most", short(metrics.sink_max_m), short(metrics.drift_max_m)),
        ),
    ]);
    if let Some(jitter) = metrics.jitter_m_per_s {
        rows.push(("trembles".into(), format!("at {} m/s (last second)", short(jitter))));
    }
    if let Some(error) = metrics.force_error {
        rows.push(("forces".into(), format!("off by {} of the weight they carry (last second)", short(error))));
    }
    if let Some(residual) = metrics.contact_residual {
        let (worst, last) = (short(residual.worst), short(residual.last));
        rows.push(("contacts".into(), format!("off their laws by {worst} at worst, {last} at the end")));
    }
    if let Some(ExactCounts { cuts, unsettled, jammed }) = metrics.exact {
        rows.push(("exactly".into(), format!("{cuts} cuts of steps, {unsettled} parts not settled")));
        if jammed > 0 {
            rows.push(("jammed".into(), format!("{jammed} times a sliding point has no rigid motion: it was stopped")));
        }
    }
    let MomentumMetrics { linear_max_relative_drift, angular_max_relative_drift } = metrics.momentum;
    for (kind, drift) in [("linear", linear_max_relative_drift), ("angular", angular_max_relative_drift)] {
        if let Some(drift) = drift {
            rows.push(("momentum".into(), format!("{kind}: strayed by {}", short(drift))));
        }
    }
    for truth in metrics.truth.iter().chain(&metrics.further_truths) {
        rows.push(("error".into(), format!("{} {} ({})", short(truth.error), truth.unit, truth.name)));
    }
    if let Some(reason) = &metrics.truth_unknown {
        rows.push(("error".into(), format!("unknown: {reason}")));
    }
    rows.push(("state".into(), metrics.state_hash.clone()));
    for entity in &metrics.quarantined {
        rows.push(("quarantined".into(), format!("{}: {}", entity.body, entity.reason)));
    }
    rows
}

/// What there is to say of joints besides their gaps.
fn joints(metrics: &Metrics) -> Vec<(String, String)> {
    let mut rows = Vec::new();
    // Of ball joints alone, the error says it.
    if metrics.joint_gaps.keys().any(|&kind| kind != "ball") {
        for (kind, gap) in &metrics.joint_gaps {
            let tilt = gap.tilt_rad.map_or_else(String::new, |tilt| format!(", tilted by {} rad", short(tilt)));
            rows.push(((*kind).into(), format!("parted by {} m{tilt} at most", short(gap.gap_m))));
        }
    }
    if let Some(LimitOvershoot { angle_rad, length_m }) = metrics.limit_overshoot_max {
        let of = |beyond: Option<f64>, unit: &str| beyond.map(|beyond| format!("{} {unit}", short(beyond)));
        let beyond: Vec<_> = of(angle_rad, "rad").into_iter().chain(of(length_m, "m")).collect();
        rows.push(("limits".into(), format!("overshot by {} at most", beyond.join(", "))));
    }
    if let Some(JointLoadMax { force_n, torque_n_m }) = metrics.joint_load_max {
        rows.push(("joint load".into(), format!("{} N, {} N·m at most", short(force_n), short(torque_n_m))));
    }
    if metrics.broken_joints > 0 {
        rows.push(("broken".into(), format!("{} joints in the end", metrics.broken_joints)));
    }
    rows
}

/// Four digits that count.
fn short(value: f64) -> String {
    let magnitude = value.abs();
    if value == 0.0 {
        "0".into()
    } else if (1e-3..1e5).contains(&magnitude) {
        let decimals = (3 - magnitude.log10().floor() as i32).max(0) as usize;
        let text = format!("{value:.decimals$}");
        if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').into() } else { text }
    } else {
        format!("{value:.3e}")
    }
}

#[cfg(test)]
mod tests {
    use super::short;

    #[test]
    fn numbers_keep_four_digits() {
        let shown = [0.0, 16.0 + 2.0 / 3.0, 10.0, -1234.56, 0.001, 99_999.0, 1.5e-7, 1e9].map(short);
        assert_eq!(shown, ["0", "16.67", "10", "-1235", "0.001", "99999", "1.500e-7", "1.000e9"]);
    }
}
