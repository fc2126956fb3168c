//! What `--vary` asks of `plumb chart` and `plumb map`.

use clap::Args;

use crate::lab::vary::{Assignment, Candidate, MEASURES, Measure, Study, Variation, VaryError};
use crate::scene;

use super::outcome::CommandError;
use super::settings::SettingsArguments;

/// What varies, on which settings, and what is drawn of it.
#[derive(Args)]
pub(super) struct VaryArguments {
    /// Vary a setting of docs/settings.md or a parameter of the scene: NAME=a,b,c or NAME=from:to:lin|log:count. A chart
    /// varies one thing, a map two; one more gives a curve or a panel for each of its values
    #[arg(long, value_name = "NAME=VALUES")]
    pub vary: Vec<String>,
    /// Compare with some of the settings changed, a curve or a panel more; may be repeated
    #[arg(long, value_name = "NAME=VALUE,…", requires = "vary")]
    pub compare: Vec<String>,
    /// What to draw, a column of points.csv: error, cost, drift, sink, joint_error … A chart draws a panel for each, a
    /// map writes it into its cells [default: error,cost of a chart]
    #[arg(long, value_name = "NAME", value_delimiter = ',', value_parser = Measure::find)]
    pub measure: Vec<&'static Measure>,
    /// Time to simulate, s [default: the scene's own]
    #[arg(long, value_name = "T", requires = "vary", allow_negative_numbers = true)]
    pub seconds: Option<f64>,
    /// Settings are compared with the charts' methods unless they are given here.
    #[command(flatten)]
    pub settings: SettingsArguments,
}

impl VaryArguments {
    /// Whether anything is varied; settings go with that only.
    pub fn is_given(&self) -> Result<bool, CommandError> {
        if self.vary.is_empty() && self.settings.is_given() {
            return Err(CommandError::Usage(
                "settings are chosen here with --vary only: add --vary NAME=VALUES".into(),
            ));
        }
        Ok(!self.vary.is_empty())
    }

    /// The study of one scene and the `N` variations of its axes.
    pub fn study<const N: usize>(
        &self,
        scenes: &[String],
        parameters: &[(String, f64)],
    ) -> Result<(Study, [Variation; N]), CommandError> {
        let [scene] = scenes else {
            return Err(CommandError::Usage("--vary is of one scene: name exactly one with it".into()));
        };
        let mut varied = self.variations(scene)?;
        let further = match varied.len().checked_sub(N) {
            Some(0) => None,
            Some(1) => varied.pop(),
            _ => {
                let (these, more) = if N == 1 { ("one --vary", "two") } else { ("two --vary", "three") };
                return Err(CommandError::Usage(format!(
                    "{these} make the axes of this picture, and {more} are the most"
                )));
            }
        };
        let candidates = self.candidates(scene, further.as_ref())?;
        let mut study = Study::new(scene, parameters, candidates, self.seconds)?;
        self.refuse_what_is_fixed(&study, &varied)?;
        let all: Vec<&Variation> = varied.iter().collect();
        study.check(&all)?;
        if self.are_methods(further.as_ref()) {
            study.keep_those_that_read(&all);
        }
        Ok((study, varied.try_into().expect("as many as there are axes")))
    }

    fn variations(&self, scene: &str) -> Result<Vec<Variation>, CommandError> {
        let info = scene::find(scene);
        let read = |text: &String| Variation::parse(text, info).map_err(|error| told("--vary", text, &error));
        let varied = self.vary.iter().map(read).collect::<Result<Vec<_>, _>>()?;
        match twice(varied.iter().map(Variation::name)) {
            Some(name) => Err(CommandError::Usage(format!("{name} is varied twice: vary something else"))),
            None => Ok(varied),
        }
    }

    /// Whether the charts' methods are compared: nobody said what is.
    fn are_methods(&self, further: Option<&Variation>) -> bool {
        further.is_none() && self.compare.is_empty() && !self.settings.is_given()
    }

    fn candidates(&self, scene: &str, further: Option<&Variation>) -> Result<Vec<Candidate>, CommandError> {
        if self.are_methods(further) {
            return Ok(Candidate::methods());
        }
        let base = Candidate::new(self.settings.name(), self.settings.resolve()?);
        let mut candidates = vec![base.clone()];
        for text in &self.compare {
            let read =
                |part| Assignment::parse(part, scene::find(scene)).map_err(|error| told("--compare", text, &error));
            candidates.push(base.changed(&text.split(',').map(read).collect::<Result<Vec<_>, _>>()?));
        }
        let Some(further) = further else { return Ok(candidates) };
        let with = |candidate: &Candidate| -> Vec<Candidate> {
            let changed = further.values().iter().map(|value| candidate.changed(&[*value]));
            let is_alone = candidates.len() == 1;
            let name = |changed: Candidate| match is_alone {
                true => changed,
                false => Candidate { name: format!("{}, {}", candidate.name, changed.name), ..changed },
            };
            changed.map(name).collect()
        };
        Ok(candidates.iter().flat_map(with).collect())
    }

    /// Nothing has two values.
    fn refuse_what_is_fixed(&self, study: &Study, varied: &[Variation]) -> Result<(), CommandError> {
        let compared = study.candidates.iter().flat_map(|candidate| &candidate.with);
        let mut fixed: Vec<&str> = self.settings.set.iter().chain(compared).map(Assignment::name).collect();
        fixed.extend(study.parameters.iter().map(|(name, _)| name.as_str()));
        let changed = |candidate: &Candidate| twice(candidate.with.iter().map(Assignment::name));
        if let Some(name) = study.candidates.iter().find_map(changed) {
            return Err(CommandError::Usage(format!("{name} is changed to two values at once: leave one out")));
        }
        match varied.iter().map(Variation::name).find(|name| fixed.contains(name)) {
            Some(name) => {
                Err(CommandError::Usage(format!("{name} is varied and given a value besides: leave one out")))
            }
            None => Ok(()),
        }
    }
}

/// The first that came before.
fn twice(mut names: impl Iterator<Item = &'static str>) -> Option<&'static str> {
    let mut known = Vec::new();
    names.find(|name| {
        let is_known = known.contains(name);
        known.push(*name);
        is_known
    })
}

fn told(option: &str, text: &str, error: &VaryError) -> CommandError {
    CommandError::Usage(format!("{option} {text}: {error}"))
}

/// What a chart draws where nothing is said: error and cost.
pub(super) fn usual_measures() -> Vec<&'static Measure> {
    MEASURES.iter().filter(|measure| ["error", "cost"].contains(&measure.name)).collect()
}
