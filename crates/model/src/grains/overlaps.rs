//! Spheres that overlap each other, walls or bodies at the beginning.

use fdem_io::numbers::{brief, grouped};
use fdem_mesh::Corners;
use fdem_simulation::grains::{
    Clump, Domain, Insertion, Spheres, Wall, WallShape, spheres_in_box, worst_in_body, worst_on_wall,
    worst_overlap,
};

use crate::grains::spheres::place;
use crate::prepared::SphereGroup;
use crate::shapes::placed::Placed;
use crate::text::document::{Document, Table};
use crate::text::fault::Fault;

/// Depth of an overlap over the smaller radius up to which it is accepted: packings of other programs are
/// under pressure.
const ACCEPTED: f64 = 0.05;

/// Places along an axis at which regions of insertions are looked at.
const PLACES: usize = 9;

/// Spheres at the beginning, and their groups.
pub(crate) struct Beginning<'a> {
    pub(crate) spheres: &'a Spheres,
    pub(crate) clumps: &'a [Clump],
    pub(crate) insertions: &'a [Insertion],
    pub(crate) groups: &'a [SphereGroup],
    pub(crate) discs: bool,
    pub(crate) document: &'a Document<'a>,
}

impl Beginning<'_> {
    /// The table of a sphere.
    fn table(&self, sphere: u32) -> usize {
        self.spheres.groups.get(sphere as usize).map_or(0, |group| *group as usize)
    }

    /// A sphere in messages.
    fn words(&self, sphere: u32) -> String {
        let name = &self.groups[self.table(sphere)].name;
        let noun = if self.discs { "disc" } else { "sphere" };
        let at = place(self.spheres.positions[sphere as usize], self.discs);
        format!("{noun} {} of [[grains]] \"{name}\", at {at} m,", grouped(u64::from(sphere)))
    }

    fn fault(&self, sphere: u32, message: String, help: &str) -> Fault {
        let span = self.document.value(Table::of("grains", self.table(sphere)), "name");
        Fault::at(span, message).label("these spheres").help(help)
    }

    /// Reports the deepest overlap of two spheres.
    pub(crate) fn among_spheres(&self, faults: &mut Vec<Fault>) {
        match worst_overlap(&self.spheres.positions, &self.spheres.radii, self.clumps, 0) {
            Ok(Some(([first, second], share))) if share > ACCEPTED => {
                let smaller = [first, second]
                    .map(|of| self.spheres.radii[of as usize])
                    .into_iter()
                    .fold(f64::MAX, f64::min);
                let message = format!(
                    "{} overlaps {} by {} m, {} of the smaller radius",
                    self.words(first),
                    self.words(second).trim_end_matches(','),
                    brief(share * smaller),
                    percent(share)
                );
                faults.push(self.fault(second, message, "spheres begin without overlap: move them apart"));
            }
            Ok(_) => {}
            Err(why) => {
                let span = self.document.value(Table::of("grains", 0), "name");
                faults.push(Fault::at(span, format!("spheres cannot be searched for overlaps: {why}")));
            }
        }
    }

    /// Reports for each wall the sphere that is deepest in it.
    pub(crate) fn on_walls(&self, walls: &[Wall], faults: &mut Vec<Fault>) {
        for wall in walls {
            let Some((sphere, share)) =
                worst_on_wall(&wall.shape, &self.spheres.positions, &self.spheres.radii)
            else {
                continue;
            };
            if share <= ACCEPTED {
                continue;
            }
            let (words, name) = (self.words(sphere), &wall.name);
            let message = if share > 1.0 {
                format!("{words} is on the wrong side of [[wall]] \"{name}\"")
            } else {
                format!("{words} overlaps [[wall]] \"{name}\" by {} of its radius", percent(share))
            };
            let help = "move the wall or the spheres; the normal of a plane points to the spheres";
            faults.push(self.fault(sphere, message, help));
        }
    }

    /// Reports the first sphere outside of the domain along an axis that does not repeat.
    pub(crate) fn outside(&self, domain: Option<Domain>, faults: &mut Vec<Fault>) {
        let Some(domain) = domain else { return };
        let is_out = |place: &[f64; 3]| {
            (0..3).any(|axis| {
                !domain.periodic[axis] && !(domain.low[axis]..=domain.high[axis]).contains(&place[axis])
            })
        };
        let Some(sphere) = self.spheres.positions.iter().position(is_out) else { return };
        let message = format!("{} is outside of the box of [domain]", self.words(sphere as u32));
        faults.push(self.fault(sphere as u32, message, "make the box larger, or move the spheres"));
    }

    /// Reports for each body the sphere that is deepest in it.
    pub(crate) fn in_bodies<const D: usize, const N: usize>(
        &self,
        placed: &[Placed<D, N>],
        faults: &mut Vec<Fault>,
    ) where
        [[f64; D]; N]: Corners<D, N>,
    {
        let Spheres { positions, radii, .. } = self.spheres;
        let largest = radii.iter().copied().fold(0.0, f64::max);
        for body in placed {
            let [low, high] = fdem_mesh::bounds(body.piece.nodes.iter().copied());
            let corner =
                |of: [f64; D], without: f64| [0, 1, 2].map(|axis| of.get(axis).copied().unwrap_or(without));
            let limits = [corner(low, f64::NEG_INFINITY), corner(high, f64::INFINITY)];
            self.coming_into(body, limits, faults);
            let near = spheres_in_box(limits, positions, radii);
            if near.is_empty() {
                continue;
            }
            let centres: Vec<[f64; 3]> =
                near.iter().map(|&sphere| standing::<D>(positions[sphere as usize])).collect();
            let of_near: Vec<f64> = near.iter().map(|&sphere| radii[sphere as usize]).collect();
            let surface = surface(body, 2.0 * largest);
            let Some((number, share)) = worst_in_body(surface, &centres, &of_near) else { continue };
            if share <= ACCEPTED {
                continue;
            }
            let sphere = near[number as usize];
            let (words, name) = (self.words(sphere), &body.name);
            let message = if share > 1.0 {
                format!("{words} is inside of the body \"{name}\"")
            } else {
                format!("{words} overlaps the body \"{name}\" by {} of its radius", percent(share))
            };
            faults.push(self.fault(sphere, message, "move the body or the spheres"));
        }
    }
}

impl Beginning<'_> {
    /// Places in the region of an insertion for the centres of its largest spheres: a grid.
    fn places(&self, of: &Insertion) -> Vec<[f64; 3]> {
        let largest = of.radii.iter().copied().fold(0.0, f64::max);
        let [low, high] = of.region;
        let along = |axis: usize, place: usize| {
            let share = place as f64 / (PLACES - 1) as f64;
            low[axis] + largest + share * (high[axis] - low[axis] - 2.0 * largest)
        };
        let layers = if self.discs { 1 } else { PLACES };
        (0..PLACES * PLACES * layers)
            .map(|k| {
                let [i, j, l] = [k % PLACES, k / PLACES % PLACES, k / (PLACES * PLACES)];
                [along(0, i), along(1, j), if self.discs { 0.0 } else { along(2, l) }]
            })
            .collect()
    }

    /// Reports insertions whose region reaches into a body. `limits`: of the body, m.
    fn coming_into<const D: usize, const N: usize>(
        &self,
        body: &Placed<D, N>,
        limits: [[f64; 3]; 2],
        faults: &mut Vec<Fault>,
    ) where
        [[f64; D]; N]: Corners<D, N>,
    {
        for (index, of) in self.insertions.iter().enumerate() {
            let places = self.places(of);
            let near = spheres_in_box(limits, &places, &vec![0.0; places.len()]);
            if near.is_empty() {
                continue;
            }
            let centres: Vec<[f64; 3]> =
                near.iter().map(|&place| standing::<D>(places[place as usize])).collect();
            let smallest = of.radii.iter().copied().fold(f64::MAX, f64::min);
            let worst = worst_in_body(surface(body, smallest), &centres, &vec![smallest; centres.len()]);
            if worst.is_some_and(|(_, share)| share > 1.0) {
                let message = format!(
                    "[[insertion]] \"{}\": its region reaches into the body \"{}\", where spheres would come in",
                    of.name, body.name
                );
                let span = self.document.key(Table::of("insertion", index), "within");
                faults.push(
                    Fault::at(span, message)
                        .label("reaches into a body")
                        .help("make the region smaller, or move it or the body"),
                );
            }
        }
    }

    /// Reports insertions whose spheres find no place beside walls that stay: they would wait forever.
    pub(crate) fn without_room(&self, walls: &[Wall], faults: &mut Vec<Fault>) {
        let stays = |wall: &&Wall| {
            let is_simple = !matches!(wall.shape, WallShape::Mesh { .. });
            let is_still = wall.velocity == [0.0; 3] && wall.rotation.is_none() && wall.path.is_empty();
            is_simple && is_still && wall.servo.is_none()
        };
        for (index, of) in self.insertions.iter().enumerate() {
            let least = of.radii.iter().copied().fold(f64::MAX, f64::min);
            let mut places = self.places(of);
            for wall in walls.iter().filter(stays) {
                places.retain(|&place| worst_on_wall(&wall.shape, &[place], &[least]).is_none());
                if places.is_empty() {
                    let message = format!(
                        "[[insertion]] \"{}\": its spheres find no place beside [[wall]] \"{}\"",
                        of.name, wall.name
                    );
                    let span = self.document.key(Table::of("insertion", index), "within");
                    let help = "move the region or the wall; the normal of a plane points to the spheres";
                    faults.push(Fault::at(span, message).label("no free place").help(help));
                    break;
                }
            }
        }
    }
}

fn percent(share: f64) -> String {
    format!("{} %", brief((1000.0 * share).round() / 10.0))
}

/// A point in space; one of the plane in the plane of the last two axes.
fn standing<const D: usize>(at: [f64; 3]) -> [f64; 3] {
    if at.len() == D { at } else { [0.0, at[0], at[1]] }
}

/// The surface of a body; that of a flat one is drawn out along the first axis by `wide`, m, to both sides.
fn surface<const D: usize, const N: usize>(body: &Placed<D, N>, wide: f64) -> Vec<[[f64; 3]; 3]> {
    let mut triangles = Vec::new();
    for facet in &body.piece.outline {
        let corners = facet.map(|node| body.piece.nodes[node as usize]);
        let point = |corner: usize, along: f64| {
            let of = corners[corner];
            if D == 3 { [of[0], of[1], of[D - 1]] } else { [along, of[0], of[1]] }
        };
        if D == 3 {
            triangles.push([point(0, 0.0), point(1, 0.0), point(D - 1, 0.0)]);
            continue;
        }
        let [a, b] = [0, 1].map(|corner| [-wide, wide].map(|along| point(corner, along)));
        triangles.extend([[a[0], b[0], b[1]], [a[0], b[1], a[1]]]);
    }
    triangles
}
