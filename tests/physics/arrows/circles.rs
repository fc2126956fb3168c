//! Files as nodes, imports as arrows, and the circles among them. Tests are left out.

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::fmt;

use super::tree::{Mention, Tree};

/// From file to file, with the names that are imported. A file that imports from itself has no arrow for that.
pub struct Arrows<'a> {
    files: &'a [String],
    to: BTreeMap<usize, BTreeMap<usize, BTreeSet<String>>>,
}

/// Files of which each imports from each other, directly or round a corner.
pub struct Circle<'a> {
    files: Vec<&'a str>,
    /// The shortest way round, its first file last again.
    shortest: Vec<Arrow<'a>>,
    arrows: Vec<Arrow<'a>>,
}

struct Arrow<'a> {
    from: &'a str,
    to: &'a str,
    names: Vec<&'a str>,
}

/// Glob imports of this crate's own names, as a message each.
pub fn globs(tree: &Tree) -> Vec<String> {
    let is_refused = |mention: &&Mention| mention.is_glob && !mention.is_test && tree.is_inside(mention);
    let file = |mention: &Mention| &tree.files[tree.modules[mention.module].file];
    let found = tree.mentions.iter().filter(is_refused);
    found.map(|mention| format!("src/{}: {}::*", file(mention), mention.path.join("::"))).collect()
}

impl<'a> Arrows<'a> {
    pub fn of(tree: &'a Tree) -> Self {
        let mut to: BTreeMap<usize, BTreeMap<usize, BTreeSet<String>>> = BTreeMap::new();
        for mention in tree.mentions.iter().filter(|mention| !mention.is_test) {
            let from = tree.modules[mention.module].file;
            for file in tree.files_of(mention).into_iter().filter(|&file| file != from) {
                to.entry(from).or_default().entry(file).or_default().insert(mention.path.join("::"));
            }
        }
        Self { files: &tree.files, to }
    }

    /// Every circle, each with all files that belong to it.
    pub fn circles(&'a self) -> Vec<Circle<'a>> {
        let reached: BTreeMap<usize, BTreeSet<usize>> =
            self.to.keys().map(|&file| (file, self.reached(file))).collect();
        let mut seen = BTreeSet::new();
        let mut circles = Vec::new();
        for (&file, others) in &reached {
            if others.contains(&file) && !seen.contains(&file) {
                let comes_back = |other: &usize| reached.get(other).is_some_and(|back| back.contains(&file));
                let members: BTreeSet<usize> = others.iter().copied().filter(comes_back).collect();
                circles.push(self.circle(&members));
                seen.extend(members);
            }
        }
        circles
    }

    /// All files that a file imports from, directly or not; itself among them where it is in a circle.
    fn reached(&self, file: usize) -> BTreeSet<usize> {
        let mut reached = BTreeSet::new();
        let mut open = vec![file];
        while let Some(next) = open.pop() {
            open.extend(self.next(next).filter(|&it| reached.insert(it)));
        }
        reached
    }

    fn next(&self, file: usize) -> impl Iterator<Item = usize> {
        self.to.get(&file).into_iter().flat_map(|to| to.keys().copied())
    }

    fn circle(&'a self, members: &BTreeSet<usize>) -> Circle<'a> {
        let shortest = members.iter().map(|&file| self.way_back(file)).min_by_key(Vec::len).unwrap();
        let among = |&from: &usize| {
            let to = self.next(from).filter(|to| members.contains(to));
            to.map(move |to| self.arrow(from, to))
        };
        Circle {
            files: members.iter().map(|&file| self.files[file].as_str()).collect(),
            shortest: shortest.windows(2).map(|pair| self.arrow(pair[0], pair[1])).collect(),
            arrows: members.iter().flat_map(among).collect(),
        }
    }

    /// The shortest way from a file of a circle back to it.
    fn way_back(&self, file: usize) -> Vec<usize> {
        let mut came_from = BTreeMap::new();
        let mut open = VecDeque::from([file]);
        while !came_from.contains_key(&file) {
            let at = open.pop_front().expect("the file is in a circle");
            for next in self.next(at) {
                came_from.entry(next).or_insert_with(|| {
                    open.push_back(next);
                    at
                });
            }
        }
        let mut way = vec![file];
        while way.len() == 1 || way.last() != Some(&file) {
            way.push(came_from[way.last().unwrap()]);
        }
        way.reverse();
        way
    }

    fn arrow(&'a self, from: usize, to: usize) -> Arrow<'a> {
        let names = self.to[&from][&to].iter().map(String::as_str).collect();
        Arrow { from: &self.files[from], to: &self.files[to], names }
    }
}

impl fmt::Display for Circle<'_> {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        writeln!(f, "{} files import each other in a circle. The shortest way round:", self.files.len())?;
        for arrow in &self.shortest {
            writeln!(f, "    {arrow}")?;
        }
        if self.arrows.len() > self.shortest.len() {
            writeln!(f, "All arrows among them:")?;
            for arrow in &self.arrows {
                writeln!(f, "    {arrow}")?;
            }
        }
        Ok(())
    }
}

impl fmt::Display for Arrow<'_> {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "src/{} → src/{}: {}", self.from, self.to, self.names.join(", "))
    }
}
