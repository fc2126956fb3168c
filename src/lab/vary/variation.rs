//! One quantity and the values that it takes.

use std::fmt;

use super::assignment::{Assignment, Value, VaryError, split};
use crate::scene::SceneInfo;

/// Most values of one variation: a picture has no room for more.
pub const MOST_VALUES: usize = 100;

/// A list of numbers whose positive ones span this factor has a logarithmic axis.
const WIDE: f64 = 15.0;

/// How the values lie on an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// By themselves.
    Linear,
    /// By their logarithm; a zero where the value before the least would be.
    Logarithmic,
    /// One after the other.
    InOrder,
}

/// A setting or a parameter of a scene, with at least one value; none twice, numbers from the least up.
#[derive(Clone, Debug, PartialEq)]
pub struct Variation {
    values: Vec<Assignment>,
    /// How they lie on an axis.
    pub scale: Scale,
}

/// As [`Variation::parse`] reads it, value by value.
impl fmt::Display for Variation {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        let values: Vec<String> = self.values.iter().map(|value| value.value.to_string()).collect();
        write!(formatter, "{}={}", self.name(), values.join(","))
    }
}

impl Variation {
    /// Reads `NAME=a,b,c` or `NAME=from:to:lin|log:count`, of a setting or, where a built-in scene is given, of one of its
    /// parameters.
    ///
    /// # Errors
    /// No such name, values that it cannot have, or too many of them.
    pub fn parse(text: &str, scene: Option<&SceneInfo>) -> Result<Self, VaryError> {
        let (name, values) = split(text)?;
        let variation = if values.contains(':') { range(name, values, scene)? } else { list(name, values, scene)? };
        match variation.values.len() {
            count if count > MOST_VALUES => {
                Err(VaryError(format!("{name}: {count} values are more than {MOST_VALUES}")))
            }
            _ => Ok(variation),
        }
    }

    /// The values, in the order of the axis.
    pub fn values(&self) -> &[Assignment] {
        &self.values
    }

    /// What varies.
    pub fn name(&self) -> &'static str {
        self.values[0].name()
    }

    /// What varies, for an axis.
    pub fn label(&self) -> &'static str {
        self.values[0].label()
    }

    /// Where a value lies on the axis.
    pub fn place(&self, index: usize) -> f64 {
        match (self.scale, self.values[index].value) {
            (Scale::Linear, Value::Number(value)) => value,
            (Scale::Logarithmic, Value::Number(0.0)) => {
                let rest = self.values.len() - 1;
                let (least, largest) = (self.place(1), self.place(rest));
                least - (largest - least) / (rest - 1) as f64
            }
            (Scale::Logarithmic, Value::Number(value)) => value.log10(),
            _ => index as f64,
        }
    }

    /// Where a value lies on the axis that may be none of those that are varied; none where the axis has no place for it.
    pub fn place_of(&self, value: Value) -> Option<f64> {
        if let Some(index) = self.values.iter().position(|own| own.value == value) {
            return Some(self.place(index));
        }
        match (self.scale, value) {
            (Scale::Linear, Value::Number(value)) => Some(value),
            (Scale::Logarithmic, Value::Number(value)) if value > 0.0 => Some(value.log10()),
            _ => None,
        }
    }
}

fn list(name: &str, values: &str, scene: Option<&SceneInfo>) -> Result<Variation, VaryError> {
    let values = values.split(',').map(|value| Assignment::new(name, value, scene));
    let mut values = values.collect::<Result<Vec<_>, _>>()?;
    values.sort_by(|one, other| match (one.value, other.value) {
        (Value::Number(one), Value::Number(other)) => one.total_cmp(&other),
        (Value::Number(_), _) => std::cmp::Ordering::Less,
        (_, Value::Number(_)) => std::cmp::Ordering::Greater,
        _ => std::cmp::Ordering::Equal,
    });
    let again = (1..values.len()).find(|&index| values[..index].contains(&values[index]));
    if let Some(again) = again.map(|index| values[index]) {
        return Err(VaryError(format!("{again} is given twice")));
    }
    let numbers: Vec<f64> = values.iter().filter_map(|value| value.value.number()).collect();
    let scale = if numbers.len() < values.len() { Scale::InOrder } else { scale_of(&numbers) };
    Ok(Variation { values, scale })
}

/// Of a list that goes up.
fn scale_of(numbers: &[f64]) -> Scale {
    let positive = if numbers[0] == 0.0 { &numbers[1..] } else { numbers };
    match (positive.first(), positive.last()) {
        (Some(&first), Some(&last)) if first > 0.0 && last / first >= WIDE => Scale::Logarithmic,
        _ => Scale::Linear,
    }
}

fn range(name: &str, text: &str, scene: Option<&SceneInfo>) -> Result<Variation, VaryError> {
    let bad = |problem: &str| {
        VaryError(format!(
            "{name}: '{text}' {problem}; a range is from:to:lin:count or from:to:log:count, like 0.1:1:log:9"
        ))
    };
    let parts: Vec<&str> = text.split(':').collect();
    let [from, to, scale, count] = parts[..] else { return Err(bad("does not have four parts")) };
    let scale = match scale {
        "lin" => Scale::Linear,
        "log" => Scale::Logarithmic,
        _ => return Err(bad("is neither lin nor log")),
    };
    let count = count.parse::<usize>().ok().filter(|count| (2..=MOST_VALUES).contains(count));
    let Some(count) = count else { return Err(bad(&format!("has no count from 2 to {MOST_VALUES}"))) };
    let ends = [from, to].map(|end| Assignment::new(name, end, scene));
    let [from, to] = ends;
    let (from, to) = (from?, to?);
    let (Value::Number(low), Value::Number(high)) = (from.value, to.value) else {
        return Err(bad("is not of numbers"));
    };
    if low >= high {
        return Err(bad("does not go up"));
    }
    if scale == Scale::Logarithmic && low <= 0.0 {
        return Err(bad("has no logarithms: it must begin above 0"));
    }
    let inner = (1..count - 1).map(|index| {
        let share = index as f64 / (count - 1) as f64;
        let value = match scale {
            Scale::Logarithmic => low * (high / low).powf(share),
            _ => low + share * (high - low),
        };
        let value = if from.is_whole() { value.round() } else { four_digits(value) };
        Assignment { value: Value::Number(value), ..from }
    });
    let mut values: Vec<Assignment> = std::iter::once(from).chain(inner).chain([to]).collect();
    // Whole numbers may fall together.
    values.dedup();
    Ok(Variation { values, scale })
}

/// What can be read on an axis and typed again.
fn four_digits(value: f64) -> f64 {
    format!("{value:.3e}").parse().unwrap_or(value)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lab::sweep::Point;
    use crate::physics::{SETTINGS, SolverSettings};
    use crate::scene;

    fn read(text: &str) -> Vec<String> {
        let variation = Variation::parse(text, scene::find("incline")).unwrap();
        variation.values().iter().map(|value| value.value.to_string()).collect()
    }

    fn refused(text: &str) -> String {
        Variation::parse(text, scene::find("incline")).map(|variation| variation.values).unwrap_err().to_string()
    }

    #[test]
    fn lists_and_ranges_are_read() {
        assert_eq!(read("baumgarte=0.3,0.1,1"), ["0.1", "0.3", "1"]);
        assert_eq!(read("baumgarte=0.1:1:log:3"), ["0.1", "0.3162", "1"]);
        assert_eq!(read("baumgarte=0:1:lin:5"), ["0", "0.25", "0.5", "0.75", "1"]);
        assert_eq!(read("iterations=1:100:log:6"), ["1", "3", "6", "16", "40", "100"]);
        assert_eq!(read("iterations=1:3:log:9"), ["1", "2", "3"]);
        assert_eq!(read("points=1:5:lin:3"), ["1", "3", "5"]);
        assert_eq!(read("warm_starting=false,true"), ["false", "true"]);
        assert_eq!(read("correction_speed=off,3"), ["3", "None"]);
        assert_eq!(read("contacts=single_point,clipping"), ["single_point", "clipping"]);
        assert_eq!(read("integrator=gauss,euler"), ["gauss", "euler"]);
        assert_eq!(read("slop=1e-5"), ["1e-5"]);
    }

    #[test]
    fn axes_follow_the_values() {
        let scale = |text: &str| Variation::parse(text, None).unwrap().scale;
        assert_eq!(scale("iterations=1,10,100"), Scale::Logarithmic);
        assert_eq!(scale("iterations=1,2,3"), Scale::Linear);
        assert_eq!(scale("slop=0,0.001,1"), Scale::Logarithmic);
        assert_eq!(scale("slop=0,1"), Scale::Linear);
        assert_eq!(scale("slop=0,0.1,1"), Scale::Linear);
        assert_eq!(scale("correction_speed=1,100,None"), Scale::InOrder);
        assert_eq!(scale("hz=30:960:lin:5"), Scale::Linear);
        assert_eq!(scale("correction_speed=None"), Scale::InOrder);
    }

    #[test]
    fn a_zero_lies_one_value_below_the_least_where_the_axis_is_logarithmic() {
        let variation = Variation::parse("slop=0,0.001,0.01,1", None).unwrap();
        let places: Vec<f64> = (0..4).map(|index| variation.place(index)).collect();
        assert_eq!(places, [-4.5, -3.0, -2.0, 0.0]);
        let of = |value| variation.place_of(Value::Number(value));
        assert_eq!([of(0.0), of(0.1), of(-1.0)], [Some(-4.5), Some(-1.0), None]);
        let two = Variation::parse("slop=-0,0.01,0.2", None).unwrap();
        assert!(two.place(0) < two.place(1) && two.place(0).is_finite(), "{}", two.place(0));
    }

    #[test]
    fn what_cannot_be_varied_is_told_with_what_can() {
        for (text, says) in [
            ("baumgarte", "NAME=VALUE"),
            ("=1", "NAME=VALUE"),
            ("baumgarte=", "NAME=VALUE"),
            ("bumgarte=1", "there are theta, mu, points, hz, method"),
            ("baumgarte=0.1,2", "2 is out of range, must be 0 to 1"),
            ("baumgarte=NaN", "'NaN' is not a number"),
            ("baumgarte=inf", "'inf' is not a number"),
            ("baumgarte=0.1,,0.2", "'' is not a number"),
            ("baumgarte=None", "'None' is not a number"),
            ("correction_speed=often", "not a number or None"),
            ("iterations=1.5", "not a whole number"),
            ("iterations=1,0", "must be at least 1"),
            ("iterations=1e10", "not a whole number"),
            ("warm_starting=yes", "neither true nor false"),
            ("contacts=round", "there are extreme_vertices, single_point, clipping"),
            ("integrator=round", "there are euler, velocity_verlet, gauss, rattle"),
            ("theta=90", "theta: 90 is out of range, must be from 0 to 85"),
            ("points=2.5", "must be a whole number from 1 to 64"),
            ("theta=1,1", "theta=1 is given twice"),
            ("theta=0:80:log:5", "must begin above 0"),
            ("theta=0:80:lin:0", "count from 2 to 100"),
            ("theta=0:80:lin:1000000000", "count from 2 to 100"),
            ("theta=80:0:lin:4", "does not go up"),
            ("theta=0:80:4", "four parts"),
            ("theta=0:80:sin:4", "neither lin nor log"),
            ("theta=0:NaN:lin:4", "'NaN' is not a number"),
            ("contacts=clipping:single_point:lin:2", "not of numbers"),
        ] {
            let told = refused(text);
            assert!(told.contains(says), "{text}: {told}");
        }
        let many: Vec<String> = (0..101).map(|index| index.to_string()).collect();
        assert!(refused(&format!("drag={}", many.join(","))).contains("101 values are more than 100"));
    }

    /// So that a setting of a type that is not known here does not go unseen.
    #[test]
    fn every_setting_can_be_read_and_put() {
        for setting in SETTINGS {
            for (_, preset) in SolverSettings::PRESETS {
                let own = Assignment::of_settings(setting, &preset()).expect(setting.path);
                let again = Assignment::parse(&own.to_string(), None).unwrap();
                assert_eq!(again, own);
                assert_eq!(again.setting().unwrap().path, setting.path);
                let mut settings = SolverSettings::default();
                again.put_in(&mut settings);
                assert_eq!(Assignment::of_settings(setting, &settings), Some(own), "{}", setting.path);
            }
        }
    }

    #[test]
    fn no_parameter_of_a_scene_hides_a_setting() {
        for info in scene::catalog() {
            for parameter in info.parameters {
                assert!(SETTINGS.iter().all(|setting| setting.name != parameter.name), "{}", parameter.name);
            }
        }
    }

    #[test]
    fn parameters_go_to_the_scene_and_settings_to_the_solver() {
        let mut point = Point {
            scene: "incline".into(),
            parameters: Vec::new(),
            settings: SolverSettings::classic(),
            seconds: 1.0,
            series: String::new(),
        };
        for text in ["theta=45", "friction=two_tangents", "iterations=7", "restitution_speed=0.25"] {
            Assignment::parse(text, scene::find("incline")).unwrap().put(&mut point);
        }
        assert_eq!(point.parameters, [("theta".to_owned(), 45.0)]);
        let expected = SolverSettings {
            friction: crate::physics::FrictionModel::TwoTangents,
            iterations: 7,
            restitution_speed: Some(0.25),
            ..SolverSettings::classic()
        };
        assert_eq!(point.settings, expected);
    }
}
