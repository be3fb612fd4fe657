//! Forces between spheres by a law of the caller, in each step.
//!
//! They act on spheres as walls do ([`Outer`]), and their work is external work: the balance cannot know the
//! energy that a law of the caller stores.

use std::fmt;

use serde::{Deserialize, Serialize};

use crate::columns::{GrainContact, GrainPartner};
use crate::error::GrainError;
use crate::run::balls::{Ball, Balls};
use crate::run::cell::RunBox;
use crate::run::lists::Lists;
use crate::run::on_walls::Outer;
use crate::sphere_law::{SphereLaw, SphereLawOptions, SpherePairs};
use crate::vector::{Vector, cross, dot, minus, plus, times};

/// The memory of a law of the caller in a saved run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct SavedLaw {
    options: SphereLawOptions,
    spheres: Vec<[u32; 2]>,
    memory: Vec<f64>,
}

/// The law of the caller, if there is one.
#[derive(Default)]
pub(crate) struct ByProgram {
    law: Option<SphereLaw>,
    pub(crate) options: SphereLawOptions,
    /// The couples of the last step.
    pairs: SpherePairs,
    /// Where the forces of these act, and from the second sphere to the first, m.
    arms: Vec<[Vector; 2]>,
    /// A saved run had a law, which the caller must set again.
    is_missing: bool,
    /// Work of the last step, J.
    pub(crate) work: f64,
}

impl fmt::Debug for ByProgram {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "ByProgram({:?})", self.options)
    }
}

impl ByProgram {
    /// Sets the law. After a saved run was taken over, it must be the law of that run.
    ///
    /// # Errors
    /// [`GrainError::Law`] if it keeps another number of columns, or acts in another way, than that of the
    /// saved run.
    pub(crate) fn set(&mut self, law: SphereLaw, options: SphereLawOptions) -> Result<(), GrainError> {
        if self.is_missing && options != self.options {
            let SphereLawOptions { reach, columns, replaces } = self.options;
            return Err(GrainError::Law(format!(
                "the law of the run that is continued has reach {reach:e} m, {columns} columns of memory, and acts \
                 {} the law of the model",
                if replaces { "in place of" } else { "besides" }
            )));
        }
        if !self.is_missing {
            (self.pairs, self.arms) = (SpherePairs::default(), Vec::new());
        }
        (self.law, self.options, self.is_missing) = (Some(law), options, false);
        Ok(())
    }

    /// Takes over the law itself from the run that this one continues.
    pub(crate) fn keep(&mut self, before: &mut Self) {
        if self.is_missing && self.options == before.options {
            self.law = before.law.take();
            self.is_missing = self.law.is_none();
        }
    }

    /// Takes the law away.
    pub(crate) fn clear(&mut self) {
        *self = Self::default();
    }

    /// Whether there is a law, or one to be set again.
    pub(crate) fn is_there(&self) -> bool {
        self.law.is_some() || self.is_missing
    }

    pub(crate) fn saved(&self) -> Option<SavedLaw> {
        let SpherePairs { spheres, memory, .. } = &self.pairs;
        let saved = || SavedLaw { options: self.options, spheres: spheres.clone(), memory: memory.clone() };
        self.is_there().then(saved)
    }

    /// Takes the memory of a saved run over.
    pub(crate) fn take(&mut self, saved: Option<SavedLaw>) {
        let Some(SavedLaw { options, spheres, memory }) = saved else { return self.clear() };
        let pairs = SpherePairs { spheres, memory, ..SpherePairs::default() };
        // A law that has been set for this run before stays, if it is the same.
        let law = self.law.take().filter(|_| self.options == options);
        *self = Self { is_missing: law.is_none(), law, options, pairs, ..Self::default() };
    }

    /// Computes the forces of a step at a time, s.
    ///
    /// # Errors
    /// [`GrainError::Law`]: the law fails, or its result is no number for each couple, or it must be set
    /// again.
    pub(crate) fn press(
        &mut self,
        (balls, lists, cell): (&Balls, &Lists, Option<&RunBox>),
        [time, step]: [f64; 2],
        outer: &mut Vec<Outer>,
    ) -> Result<(), GrainError> {
        if self.is_missing {
            let why = "the run that is continued has a law of a program: set it again";
            return Err(GrainError::Law(why.to_owned()));
        }
        let Some(law) = &mut self.law else { return Ok(()) };
        let before = std::mem::take(&mut self.pairs);
        let places = near(balls, lists, cell, self.options.reach);
        self.pairs = SpherePairs { time, step, ..SpherePairs::default() };
        self.arms.clear();
        for &(_, [one, two]) in &places {
            self.arms.push(add(
                &mut self.pairs,
                [&balls.list[one as usize], &balls.list[two as usize]],
                cell,
            ));
        }
        let count = self.pairs.spheres.len();
        self.pairs.memory = remembered(&self.pairs.spheres, &before, self.options.columns);
        self.pairs.forces = vec![[0.0; 3]; count];
        self.pairs.moments = vec![[0.0; 3]; count];
        if count > 0 {
            law(&mut self.pairs).map_err(GrainError::Law)?;
        }
        check(&self.pairs, (count, self.options.columns), balls.are_discs())?;
        self.work = 0.0;
        for (pair, (_, [one, two])) in places.into_iter().enumerate() {
            let (force, moment) = (self.pairs.forces[pair], self.pairs.moments[pair]);
            if (force, moment) == ([0.0; 3], [0.0; 3]) {
                continue;
            }
            let overlap = self.pairs.overlaps[pair];
            for (place, sign) in [(one, 1.0), (two, -1.0)] {
                let ball = &balls.list[place as usize];
                // From the centre to where the force acts.
                let arm = times(-sign * (ball.radius - 0.5 * overlap), self.pairs.normals[pair]);
                let force = times(sign, force);
                let moment = plus(cross(arm, force), times(sign, moment));
                let external = step * (dot(force, ball.velocity) + dot(moment, ball.spin));
                self.work += external;
                outer.push(Outer { place, force, moment, dissipated: 0.0, external });
            }
        }
        Ok(())
    }

    /// Force times distance of the centres of all couples along each axis in the last step, J.
    pub(crate) fn virial(&self) -> Vector {
        let mut sum = [0.0; 3];
        for (force, [_, apart]) in self.pairs.forces.iter().zip(&self.arms) {
            sum = plus(sum, [force[0] * apart[0], force[1] * apart[1], force[2] * apart[2]]);
        }
        sum
    }

    /// Adds the forces of the last step to the contacts of spheres, which are in ascending order. `ranks`:
    /// numbers of all spheres, ascending.
    pub(crate) fn add_to(&self, contacts: &mut Vec<GrainContact>, ranks: &[u32]) {
        let pairs = &self.pairs;
        let rank = |number: u32| ranks.binary_search(&number).ok().map(|rank| rank as u32);
        let mut apart = Vec::new();
        for (pair, &force) in pairs.forces.iter().enumerate() {
            let [one, two] = pairs.spheres[pair];
            let (Some(sphere), Some(other)) = (rank(one), rank(two)) else { continue };
            if force == [0.0; 3] {
                continue;
            }
            let (other, normal) = (GrainPartner::Sphere(other), dot(force, pairs.normals[pair]));
            match contacts.binary_search_by_key(&(sphere, other), |of| (of.sphere, of.other)) {
                Ok(known) => {
                    contacts[known].force = plus(contacts[known].force, force);
                    contacts[known].normal += normal;
                }
                Err(_) => apart.push(GrainContact {
                    sphere,
                    other,
                    place: self.arms[pair][0],
                    force,
                    normal,
                    overlap: pairs.overlaps[pair],
                }),
            }
        }
        contacts.extend(apart);
        contacts.sort_by_key(|of| (of.sphere, of.other));
    }
}

/// The couples of spheres that are at most `reach` apart, m: their numbers, ascending, and their places.
fn near(balls: &Balls, lists: &Lists, cell: Option<&RunBox>, reach: f64) -> Vec<([u32; 2], [u32; 2])> {
    let is_near = |pair: &&[u32; 2]| {
        let [one, two] = pair.map(|place| &balls.list[place as usize]);
        let apart = apart(one, two, cell);
        let most = one.radius + two.radius + reach;
        dot(apart, apart) < most * most
    };
    let numbered = |&pair: &[u32; 2]| (pair.map(|place| balls.list[place as usize].number), pair);
    let mut near: Vec<_> = lists.pairs.iter().filter(is_near).map(numbered).collect();
    near.sort_unstable();
    near
}

/// From the second sphere, or its nearest image, to the first, m.
fn apart(one: &Ball, two: &Ball, cell: Option<&RunBox>) -> Vector {
    let apart = minus(one.position, two.position);
    cell.map_or(apart, |cell| cell.shortest(apart))
}

/// Adds a couple. Returns where its force acts, and from the second sphere to the first, m.
fn add(pairs: &mut SpherePairs, [one, two]: [&Ball; 2], cell: Option<&RunBox>) -> [Vector; 2] {
    let apart = apart(one, two, cell);
    let distance = dot(apart, apart).sqrt();
    let normal = if distance > 0.0 { times(1.0 / distance, apart) } else { [1.0, 0.0, 0.0] };
    let overlap = one.radius + two.radius - distance;
    let [near, far] = [one.radius - 0.5 * overlap, two.radius - 0.5 * overlap];
    let rates = cell.map_or([0.0; 3], RunBox::rates);
    let drift = [rates[0] * apart[0], rates[1] * apart[1], rates[2] * apart[2]];
    let turning = cross(normal, plus(times(near, one.spin), times(far, two.spin)));
    pairs.spheres.push([one.number, two.number]);
    pairs.materials.push([one.material, two.material]);
    pairs.radii.push([one.radius, two.radius]);
    pairs.masses.push([one.mass, two.mass]);
    pairs.normals.push(normal);
    pairs.overlaps.push(overlap);
    pairs.velocities.push(plus(plus(minus(one.velocity, two.velocity), drift), turning));
    pairs.spins.push([one.spin, two.spin]);
    [minus(one.position, times(near, normal)), apart]
}

/// The memory of couples, one row after the other. `before`: those of the last step, in the same order.
fn remembered(spheres: &[[u32; 2]], before: &SpherePairs, columns: usize) -> Vec<f64> {
    let mut memory = vec![0.0; spheres.len() * columns];
    if columns == 0 {
        return memory;
    }
    let mut rest = before.spheres.iter().zip(before.memory.chunks(columns)).peekable();
    for (pair, row) in spheres.iter().zip(memory.chunks_mut(columns)) {
        while rest.next_if(|(known, _)| *known < pair).is_some() {}
        if let Some((_, known)) = rest.next_if(|(known, _)| *known == pair) {
            row.copy_from_slice(known);
        }
    }
    memory
}

/// Checks the result of a law for a number of couples with these columns of memory. `flat`: the spheres are
/// discs.
fn check(pairs: &SpherePairs, (count, columns): (usize, usize), flat: bool) -> Result<(), GrainError> {
    let SpherePairs { forces, moments, memory, .. } = pairs;
    for (what, found, expected) in [
        ("forces", forces.len(), count),
        ("moments", moments.len(), count),
        ("numbers of memory", memory.len(), count * columns),
    ] {
        if found != expected {
            return Err(GrainError::Law(format!("it has returned {found} {what} instead of {expected}")));
        }
    }
    for (pair, [one, two]) in pairs.spheres.iter().enumerate() {
        let row = &memory[pair * columns..(pair + 1) * columns];
        let mut all = forces[pair].iter().chain(&moments[pair]).chain(row);
        if let Some(value) = all.find(|value| !value.is_finite()) {
            return Err(GrainError::Law(format!("it gives spheres {one} and {two} a value of {value}")));
        }
        let ([.., z], [about_x, about_y, _]) = (forces[pair], moments[pair]);
        if flat && [z, about_x, about_y] != [0.0; 3] {
            let why = format!("it moves discs {one} and {two} out of their plane");
            return Err(GrainError::Law(why));
        }
    }
    Ok(())
}
