//! Contact problems as text files, one a file.
//!
//! ```text
//! plumb contact problem 1
//! # what stands behind a number sign is a comment
//! bodies 1
//! 1 1 1 6 0 0 0 6 0 0 0 6 0 -0.1635 0 0 0 0
//! contacts 1
//! - 0 0 0 0 0 -0.5 0 0 1 0 0.6 0 0 0 0 0 0
//! joints 0
//! ```
//!
//! After each count, as many lines of numbers in SI units, in the world's axes, matrices column by column:
//! - a body: m⁻¹ along the three axes, I⁻¹ (9), v_free (3), ω_free (3);
//! - a contact: the indices of A and B, from 0, or `-` for what does not move; the arms from their centres of mass to the
//!   point (3, 3); n (3), unit, from A to B; μ; b (3); the impulse to start from (3), on B;
//! - a joint: A and B likewise; J of A and of B (18 each, 3 for each of v_x, v_y, v_z, ω_x, ω_y, ω_z); the least and the most
//!   that its impulse may be (`-inf` and `inf`, or it has its first row alone); b (3); the impulse to start from (3).
//!
//! What these are is told at [`ContactProblem`]. Numbers are written such that they are read back to the bit.

use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::{fs, io};

use bevy::math::{DMat3, DVec3};

use super::whole_file::write_whole;
use crate::physics::{ContactProblem, ProblemBody, ProblemContact, ProblemJoint};

/// The first line.
const HEADER: &str = "plumb contact problem 1";
/// How far the length of a normal may be from 1, and I⁻¹ from symmetric relative to its largest number.
const ROUNDED: f64 = 1e-6;

/// Why there is no contact problem, in one line that names the place.
#[derive(Debug, thiserror::Error)]
pub enum ContactProblemError {
    /// No such file or folder, or no right to read it.
    #[error("{}: cannot be read: {reason}", path.display())]
    Unreadable {
        /// The file or folder.
        path: PathBuf,
        /// What the system said.
        reason: io::Error,
    },
    /// A folder without problems.
    #[error("{}: no contact problem (.txt) here; 'plumb run SCENE --preset accurate --problems DIR' writes some", path.display())]
    NoneHere {
        /// The folder.
        path: PathBuf,
    },
    /// A file that says something else.
    #[error("{}:{line}: {problem}", path.display())]
    Malformed {
        /// The file.
        path: PathBuf,
        /// From 1.
        line: usize,
        /// What is wrong, and what would be right.
        problem: String,
    },
}

/// The problems of a folder, `.txt`, by name.
///
/// # Errors
/// The folder cannot be read, or there are none.
pub fn contact_problem_files(folder: &Path) -> Result<Vec<PathBuf>, ContactProblemError> {
    let unreadable = |reason| ContactProblemError::Unreadable { path: folder.to_owned(), reason };
    let entries: Result<Vec<_>, _> = fs::read_dir(folder).map_err(unreadable)?.collect();
    let mut paths: Vec<_> = entries.map_err(unreadable)?.into_iter().map(|entry| entry.path()).collect();
    paths.retain(|path| path.extension().is_some_and(|extension| extension == "txt"));
    paths.sort();
    if paths.is_empty() {
        return Err(ContactProblemError::NoneHere { path: folder.to_owned() });
    }
    Ok(paths)
}

/// Reads a problem.
///
/// # Errors
/// The file cannot be read or is none.
pub fn read_contact_problem(path: &Path) -> Result<ContactProblem, ContactProblemError> {
    let unreadable = |reason| ContactProblemError::Unreadable { path: path.to_owned(), reason };
    let text = fs::read_to_string(path).map_err(unreadable)?;
    let mut lines = Lines { rest: text.lines().enumerate(), line: 0 };
    parse(&mut lines).map_err(|problem| ContactProblemError::Malformed {
        path: path.to_owned(),
        line: lines.line,
        problem,
    })
}

/// Writes a problem, with a comment of one line.
///
/// # Errors
/// The file cannot be written.
pub fn write_contact_problem(path: &Path, problem: &ContactProblem, comment: &str) -> io::Result<()> {
    write_whole(path, &text(problem, comment))
}

fn text(problem: &ContactProblem, comment: &str) -> String {
    let mut row = Row(format!("{HEADER}\n# {comment}\nbodies {}\n", problem.bodies.len()));
    for body in &problem.bodies {
        row.vector(body.inverse_mass);
        row.matrix(&body.inverse_inertia);
        row.vector(body.velocity);
        row.vector(body.angular_velocity);
        row.end();
    }
    row.section("contacts", problem.contacts.len());
    for contact in &problem.contacts {
        row.bodies(contact.bodies);
        contact.arms.into_iter().chain([contact.normal]).for_each(|vector| row.vector(vector));
        row.number(contact.friction);
        row.vector(contact.bias);
        row.vector(contact.guess);
        row.end();
    }
    row.section("joints", problem.joints.len());
    for joint in &problem.joints {
        row.bodies(joint.bodies);
        joint.jacobians.as_flattened().iter().for_each(|matrix| row.matrix(matrix));
        row.number(joint.bounds.0);
        row.number(joint.bounds.1);
        row.vector(joint.bias);
        row.vector(joint.guess);
        row.end();
    }
    row.0
}

/// Text in the making.
struct Row(String);

impl Row {
    fn word(&mut self, word: &str) {
        if !self.0.ends_with('\n') {
            self.0.push(' ');
        }
        self.0.push_str(word);
    }

    /// The shorter of two forms, both of which are read back to the bit.
    fn number(&mut self, number: f64) {
        let (plain, scientific) = (number.to_string(), format!("{number:e}"));
        self.word(if plain.len() <= scientific.len() { &plain } else { &scientific });
    }

    fn vector(&mut self, vector: DVec3) {
        vector.to_array().into_iter().for_each(|number| self.number(number));
    }

    fn matrix(&mut self, matrix: &DMat3) {
        matrix.to_cols_array().into_iter().for_each(|number| self.number(number));
    }

    fn bodies(&mut self, bodies: [Option<u32>; 2]) {
        bodies.into_iter().for_each(|body| self.word(&body.map_or_else(|| "-".to_owned(), |body| body.to_string())));
    }

    fn end(&mut self) {
        self.0.push('\n');
    }

    fn section(&mut self, name: &str, count: usize) {
        // A string takes all that is written to it.
        let _ = writeln!(self.0, "{name} {count}");
    }
}

/// Lines without comments, and the number of the last.
struct Lines<'a, I: Iterator<Item = (usize, &'a str)>> {
    rest: I,
    line: usize,
}

impl<'a, I: Iterator<Item = (usize, &'a str)>> Lines<'a, I> {
    fn next(&mut self) -> Option<&'a str> {
        for (index, line) in &mut self.rest {
            self.line = index + 1;
            let said = line.split('#').next().unwrap_or_default().trim();
            if !said.is_empty() {
                return Some(said);
            }
        }
        self.line += 1;
        None
    }

    /// The count of a section.
    fn count(&mut self, name: &str) -> Result<usize, String> {
        let found = self.next().ok_or_else(|| format!("the file ends; '{name} N' is to follow"))?;
        let count = found.strip_prefix(name).and_then(|count| count.trim().parse().ok());
        count.ok_or_else(|| format!("'{}' is to be '{name} N'", shortened(found)))
    }

    /// A section: its count, and a line for each.
    fn section<T>(&mut self, name: &str, read: impl Fn(&mut Words) -> Result<T, String>) -> Result<Vec<T>, String> {
        let count = self.count(name)?;
        let mut read_line = |index: usize| {
            let line = self
                .next()
                .ok_or_else(|| format!("the file ends; line {} of {count} {name} is to follow", index + 1))?;
            let mut words = Words(line.split_ascii_whitespace());
            let read = read(&mut words)?;
            words.end()?;
            Ok(read)
        };
        (0..count).map(&mut read_line).collect()
    }
}

/// The numbers of a line.
struct Words<'a>(std::str::SplitAsciiWhitespace<'a>);

impl Words<'_> {
    /// A number; infinite where the bound of an impulse may be.
    fn bound(&mut self) -> Result<f64, String> {
        let word = self.0.next().ok_or("numbers are missing at the end of this line")?;
        let number = word.parse().ok().filter(|number: &f64| !number.is_nan());
        number.ok_or_else(|| format!("'{}' is to be a number", shortened(word)))
    }

    fn number(&mut self) -> Result<f64, String> {
        let number = self.bound()?;
        number.is_finite().then_some(number).ok_or_else(|| "a number is infinite; only bounds may be".to_owned())
    }

    fn vector(&mut self) -> Result<DVec3, String> {
        Ok(DVec3::new(self.number()?, self.number()?, self.number()?))
    }

    fn matrix(&mut self) -> Result<DMat3, String> {
        Ok(DMat3::from_cols(self.vector()?, self.vector()?, self.vector()?))
    }

    /// A and B of so many bodies.
    fn bodies(&mut self, count: usize) -> Result<[Option<u32>; 2], String> {
        let mut end = || {
            let word = self.0.next().ok_or("the bodies A and B are missing")?;
            if word == "-" {
                return Ok(None);
            }
            let body = word.parse().ok().filter(|&body: &u32| (body as usize) < count);
            body.map(Some).ok_or_else(|| {
                format!("'{}' is to be a body from 0 to {}, or '-'", shortened(word), count.saturating_sub(1))
            })
        };
        let bodies = [end()?, end()?];
        if bodies[0] == bodies[1] {
            return Err("A and B are to be two bodies, or a body and '-'".to_owned());
        }
        Ok(bodies)
    }

    fn end(mut self) -> Result<(), String> {
        self.0.next().map_or(Ok(()), |word| Err(format!("'{}' is one number too many in this line", shortened(word))))
    }
}

/// At most the first forty characters.
fn shortened(word: &str) -> String {
    word.chars().take(40).collect()
}

fn parse<'a>(lines: &mut Lines<'a, impl Iterator<Item = (usize, &'a str)>>) -> Result<ContactProblem, String> {
    match lines.next() {
        Some(HEADER) => {}
        _ => return Err(format!("the first line is to be '{HEADER}'")),
    }
    let bodies = lines.section("bodies", body)?;
    let contacts = lines.section("contacts", |words| contact(words, bodies.len()))?;
    let joints = lines.section("joints", |words| joint(words, bodies.len()))?;
    let problem = ContactProblem { bodies, contacts, joints };
    lines.next().map_or(Ok(problem), |more| Err(format!("'{}' after the last joint is to go", shortened(more))))
}

fn body(words: &mut Words) -> Result<ProblemBody, String> {
    let body = ProblemBody {
        inverse_mass: words.vector()?,
        inverse_inertia: words.matrix()?,
        velocity: words.vector()?,
        angular_velocity: words.vector()?,
    };
    if body.inverse_mass.min_element() < 0.0 || body.inverse_inertia.determinant() < 0.0 {
        return Err("an inverse mass or inertia is negative; none may be less than 0".to_owned());
    }
    let [all, crooked] = [body.inverse_inertia, body.inverse_inertia - body.inverse_inertia.transpose()]
        .map(|matrix| matrix.to_cols_array().into_iter().fold(0.0, |most: f64, number| most.max(number.abs())));
    if crooked > ROUNDED * all {
        return Err("the inverse inertia is to be symmetric".to_owned());
    }
    Ok(body)
}

fn contact(words: &mut Words, bodies: usize) -> Result<ProblemContact, String> {
    let contact = ProblemContact {
        bodies: words.bodies(bodies)?,
        arms: [words.vector()?, words.vector()?],
        normal: words.vector()?,
        friction: words.number()?,
        bias: words.vector()?,
        guess: words.vector()?,
    };
    if (contact.normal.length() - 1.0).abs() > ROUNDED {
        return Err(format!("the normal has length {}; it is to have length 1", contact.normal.length()));
    }
    if contact.friction < 0.0 {
        return Err(format!("the friction {} is to be 0 or more", contact.friction));
    }
    Ok(contact)
}

fn joint(words: &mut Words, bodies: usize) -> Result<ProblemJoint, String> {
    let joint = ProblemJoint {
        bodies: words.bodies(bodies)?,
        jacobians: [[words.matrix()?, words.matrix()?], [words.matrix()?, words.matrix()?]],
        bounds: (words.bound()?, words.bound()?),
        bias: words.vector()?,
        guess: words.vector()?,
    };
    if joint.bounds.0 > joint.bounds.1 {
        return Err(format!("the least impulse {} is to be no more than the most, {}", joint.bounds.0, joint.bounds.1));
    }
    Ok(joint)
}
