//! Probes as they stand in a scene file.

use bevy::math::DVec3;
use serde::{Deserialize, Serialize};

use super::usual::unless_same;
use crate::scene::body::WORLD;
use crate::scene::number::Vector;
use crate::scene::{Probe, ProbePlot, ProbePoint, ProbeSpec, ProbeSubject};

#[derive(Serialize, Deserialize)]
#[serde(rename = "Probe", deny_unknown_fields)]
pub(super) struct ProbeEntry {
    #[serde(skip_serializing_if = "Option::is_none")]
    body: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    at: Option<Vector>,
    #[serde(skip_serializing_if = "Option::is_none")]
    joint: Option<usize>,
    show: ShowEntry,
}

#[derive(Serialize, Deserialize)]
#[serde(rename = "Show", deny_unknown_fields)]
enum ShowEntry {
    Plot(ProbePlot),
    Trail,
    Tape {
        body: String,
        #[serde(skip_serializing_if = "Option::is_none")]
        at: Option<Vector>,
    },
}

impl ProbeEntry {
    /// Fails with the field that is wrong, and how.
    pub fn into_probe(self) -> Result<ProbeSpec, (&'static str, &'static str)> {
        let Self { body, at, joint, show } = self;
        if joint.is_some() && (body.is_some() || at.is_some()) {
            return Err(("joint", "give either 'joint' or 'body', not both"));
        }
        if body.is_none() && at.is_some() {
            return Err(("at", "is a point of a body: name the 'body', or 'world'"));
        }
        let point = body.map(|body| point(body, at));
        Ok(match show {
            ShowEntry::Plot(plot) => {
                let subject = match (point, joint) {
                    (Some(point), _) => ProbeSubject::Point(point),
                    (None, Some(joint)) => ProbeSubject::Joint(joint),
                    (None, None) => ProbeSubject::Scene,
                };
                Probe::Plot(subject, plot)
            }
            ShowEntry::Trail => Probe::Trail(point.ok_or(("body", "a trail is of a body: name it"))?),
            ShowEntry::Tape { body: other, at } => {
                let from = point.ok_or(("body", "a tape begins at a body: name it, or 'world'"))?;
                Probe::Tape([from, self::point(other, at)])
            }
        })
    }

    pub fn of(probe: &ProbeSpec) -> Self {
        let of_point = |point: &ProbePoint<String>, show: ShowEntry| {
            let (body, at) = entry(point);
            Self { body: Some(body), at, joint: None, show }
        };
        match probe {
            Probe::Plot(ProbeSubject::Point(point), plot) => of_point(point, ShowEntry::Plot(*plot)),
            Probe::Plot(ProbeSubject::Joint(joint), plot) => {
                Self { body: None, at: None, joint: Some(*joint), show: ShowEntry::Plot(*plot) }
            }
            Probe::Plot(ProbeSubject::Scene, plot) => {
                Self { body: None, at: None, joint: None, show: ShowEntry::Plot(*plot) }
            }
            Probe::Trail(point) => of_point(point, ShowEntry::Trail),
            Probe::Tape([from, to]) => {
                let (body, at) = entry(to);
                of_point(from, ShowEntry::Tape { body, at })
            }
        }
    }
}

fn point(body: String, at: Option<Vector>) -> ProbePoint<String> {
    ProbePoint { body: (body != WORLD).then_some(body), at: at.map_or(DVec3::ZERO, DVec3::from) }
}

fn entry(point: &ProbePoint<String>) -> (String, Option<Vector>) {
    let body = point.body.clone().unwrap_or_else(|| WORLD.to_owned());
    (body, unless_same(point.at, DVec3::ZERO).map(Into::into))
}
