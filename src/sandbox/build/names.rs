//! What bodies and joints are called.

use std::collections::{HashMap, HashSet};

use bevy::prelude::*;

use crate::physics::RigidBody;

/// What the user knows a body by.
pub fn name_of(world: &World, body: Entity) -> String {
    world.get::<Name>(body).map_or_else(|| body.to_string(), ToString::to_string)
}

/// Names that no body has, for those that are called so: of a name that is taken, what is before its number, with the least
/// number that is free.
pub fn unique_names<'a>(world: &mut World, wanted: impl Iterator<Item = &'a str>) -> Vec<String> {
    let mut names = world.query_filtered::<&Name, With<RigidBody>>();
    let mut taken: HashSet<String> = names.iter(world).map(|name| name.as_str().to_owned()).collect();
    let mut numbers: HashMap<String, u64> = HashMap::new();
    let unique = |name: &str| {
        if taken.insert(name.to_owned()) {
            return name.to_owned();
        }
        let noun = without_number(name);
        let number = numbers.entry(noun.to_owned()).or_insert(1);
        loop {
            *number += 1;
            let numbered = format!("{noun} {number}");
            if taken.insert(numbered.clone()) {
                return numbered;
            }
        }
    };
    wanted.map(unique).collect()
}

/// What is before the number at the end of a name.
fn without_number(name: &str) -> &str {
    let noun = name.trim_end_matches(|letter: char| letter.is_ascii_digit());
    if noun.len() < name.len() { noun.strip_suffix(' ').filter(|noun| !noun.is_empty()).unwrap_or(name) } else { name }
}

/// The noun, or with the least number that makes it a name no body has: what is saved is told
/// apart by names.
pub fn unique_name(world: &mut World, noun: &str) -> String {
    let mut names = world.query_filtered::<&Name, With<RigidBody>>();
    let taken: HashSet<&str> = names.iter(world).map(Name::as_str).collect();
    let numbered = (2_u64..).map(|number| format!("{noun} {number}"));
    std::iter::once(noun.to_owned()).chain(numbered).find(|name| !taken.contains(name.as_str())).expect("a free number")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn copies_count_on() {
        let mut world = World::new();
        for name in ["box", "box 2", "R2"] {
            world.spawn((RigidBody::Static, Name::new(name)));
        }
        let wanted = ["box", "box 2", "ball", "ball", "R2", "2"];
        let unique = unique_names(&mut world, wanted.into_iter());
        assert_eq!(unique, ["box 3", "box 4", "ball", "ball 2", "R2 2", "2"]);
    }
}
