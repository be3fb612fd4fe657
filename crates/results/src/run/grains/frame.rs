//! The part of a frame with the spheres, their contacts and the walls.

use fdem_simulation::grains::{GrainContact, GrainPartner, SphereColumns};
use serde::{Deserialize, Serialize};

use crate::arrays::each;
use crate::fields::field::SPHERE_SCALES;
use crate::fields::quantity::Quantity;
use crate::fields::range::{Scale, SphereRanges};
use crate::fields::sphere_counts::coordination;
use crate::run::grains::columns::checked;
use crate::run::grains::walls::{Bounds, EMPTY, WallTriangle, bounds_of, is_somewhere, triangles, union};
use crate::run::packed::{Packed, Unpacked, Words, bounds, low_halves};
use crate::run::snapshot::SnapshotError;

/// Level at which the arrays are deflated, as those of elements.
const LEVEL: u8 = 1;

/// Most spheres in a frame. Of more, every second, third and so on is in it: files for ParaView have all.
pub(crate) const MOST_SPHERES: usize = 1_000_000;

/// Most contacts in a frame. Of more, those with the largest normal forces are in it.
pub(crate) const MOST_CHAINS: usize = 200_000;

/// Place of the radius in [`SPHERE_SCALES`].
const RADIUS: usize = 3;

/// Arrays with an entry for each sphere: three coordinates, the fields with a scale, two halves of the
/// number, the group, the material.
const OF_SPHERES: usize = 3 + SPHERE_SCALES.len() + 4;
/// Arrays with an entry for each contact: two halves of both spheres, the normal force.
const OF_CHAINS: usize = 5;
/// Arrays with an entry for each triangle of a wall: nine coordinates, the wall, the lines.
const OF_WALLS: usize = 11;

/// The spheres, their contacts and the walls in a frame, in a few bytes each. Numbers have 16 bits between
/// the least and the greatest of the frame, and are deflated.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct GrainFrame {
    /// Number of all spheres.
    pub(crate) whole: usize,
    /// Number of spheres in the frame.
    pub(crate) spheres: usize,
    /// Number of all contacts of the spheres.
    pub(crate) contacts: usize,
    /// Number of contacts in the frame.
    pub(crate) chains: usize,
    /// Number of these that do not lead to the centre of a sphere in the frame.
    pub(crate) loose: usize,
    /// Number of triangles of walls.
    pub(crate) triangles: usize,
    /// Whether the spheres are discs.
    pub(crate) discs: bool,
    /// Bounds of the centres, of the ends of contacts that are not centres, and of the walls.
    pub(crate) bounds: [Bounds; 3],
    /// Bounds of the surfaces of the spheres; of nothing without spheres.
    pub(crate) reach: Bounds,
    pub(crate) ranges: SphereRanges,
    pub(crate) names: GrainNames,
    /// Size of the arrays before they were deflated, bytes.
    pub(crate) size: usize,
    pub(crate) deflated: Vec<u8>,
}

/// Names of groups and walls, and the forces on the walls.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct GrainNames {
    pub(crate) groups: Vec<String>,
    pub(crate) walls: Vec<String>,
    /// N.
    pub(crate) forces: Vec<[f64; 3]>,
}

/// The arrays of a frame, decompressed.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct OpenedGrains {
    /// Centres, m.
    pub(crate) centres: Vec<[f64; 3]>,
    /// m.
    pub(crate) radii: Vec<f64>,
    /// Values of each field of [`SPHERE_SCALES`].
    pub(crate) values: Vec<Vec<f64>>,
    pub(crate) numbers: Vec<u32>,
    pub(crate) groups: Vec<u32>,
    pub(crate) materials: Vec<u32>,
    pub(crate) chains: Vec<ChainLine>,
    pub(crate) walls: Vec<WallTriangle>,
}

/// A contact as a line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ChainLine {
    /// The centre of its sphere, and that of the other one or the place of the contact, m.
    pub(crate) ends: [[f64; 3]; 2],
    /// Normal force, N.
    pub(crate) normal: f64,
}

/// Number of the second sphere of a contact that leads to a place.
const TO_PLACE: u32 = u32::MAX;

impl GrainFrame {
    /// Makes the frame of spheres, among bodies with these bounds. Without spheres and walls it is empty.
    pub(crate) fn new(spheres: &SphereColumns, bodies: Bounds) -> Result<Self, SnapshotError> {
        Self::sampled(spheres, bodies, [MOST_SPHERES, MOST_CHAINS])
    }

    /// Makes a frame with at most `most` spheres and contacts.
    pub(crate) fn sampled(
        spheres: &SphereColumns,
        bodies: Bounds,
        most: [usize; 2],
    ) -> Result<Self, SnapshotError> {
        checked(spheres)?;
        if spheres.positions.is_empty() && spheres.walls.is_empty() {
            return Ok(Self::default());
        }
        let whole = spheres.positions.len();
        let centres = [0, 1, 2].map(|axis| bounds(spheres.positions.iter().map(|position| position[axis])));
        let drawn = |&sphere: &u32| {
            let (position, radius) = (spheres.positions[sphere as usize], spheres.radii[sphere as usize]);
            (0..3).all(|axis| (centres[axis][0]..=centres[axis][1]).contains(&position[axis]))
                && radius.is_finite()
        };
        let every = whole.div_ceil(most[0].max(1)).max(1);
        let kept: Vec<u32> = (0..whole as u32).step_by(every).filter(drawn).collect();
        let reach = kept.iter().fold(EMPTY, |reach, &sphere| {
            let (position, radius) = (spheres.positions[sphere as usize], spheres.radii[sphere as usize]);
            union(reach, position.map(|x| [x - radius, x + radius]))
        });
        let walls = triangles(spheres, union(reach, bodies));
        let chains = strongest(spheres, &kept, most[1]);
        let (lines, places) = lines(spheres, &kept, &chains);
        let limits = [
            centres,
            bounds_of(places.iter().copied()),
            bounds_of(walls.iter().flat_map(|wall| wall.corners)),
        ];
        let limits = limits.map(|limits| if is_somewhere(&limits) { limits } else { [[0.0; 2]; 3] });

        let mut packed = Packed::default();
        pack_points(&mut packed, &of(&kept, &spheres.positions), &limits[0]);
        let counts = coordination(spheres);
        let scales = SPHERE_SCALES.map(|field| {
            let all = values(spheres, &counts, field.of_spheres());
            let scale = Scale::of(&all);
            packed.places(&of(&kept, &all), scale.ends);
            scale
        });
        packed.halves(&differences(&of(&kept, &spheres.numbers)));
        packed.numbers(&low_halves(&of(&kept, &spheres.groups)));
        packed.numbers(&low_halves(&of(&kept, &spheres.materials)));
        packed.halves(&differences(&lines.iter().map(|line| line[0]).collect::<Vec<_>>()));
        packed.halves(&lines.iter().map(|line| line[1]).collect::<Vec<_>>());
        let normals: Vec<f64> = chains.iter().map(|contact| contact.normal).collect();
        let of_chains = Scale::of(&normals);
        packed.places(&normals, of_chains.ends);
        pack_points(&mut packed, &places, &limits[1]);
        for corner in 0..3 {
            pack_points(
                &mut packed,
                &walls.iter().map(|wall| wall.corners[corner]).collect::<Vec<_>>(),
                &limits[2],
            );
        }
        packed.numbers(&walls.iter().map(|wall| (wall.wall & 0xffff) as u16).collect::<Vec<_>>());
        packed.numbers(&walls.iter().map(|wall| u16::from(wall.lines)).collect::<Vec<_>>());
        Ok(Self {
            whole,
            spheres: kept.len(),
            contacts: spheres.contacts.len(),
            chains: chains.len(),
            loose: places.len(),
            triangles: walls.len(),
            discs: spheres.discs.is_some(),
            bounds: limits,
            reach,
            ranges: SphereRanges { scales, chains: of_chains },
            names: GrainNames::of(spheres),
            size: packed.bytes.len(),
            deflated: miniz_oxide::deflate::compress_to_vec(&packed.bytes, LEVEL),
        })
    }

    /// Whether there are neither spheres nor walls.
    pub(crate) fn is_empty(&self) -> bool {
        self.whole == 0 && self.triangles == 0
    }

    /// Returns the bounds of the spheres and of the walls near them, which a picture shows.
    pub(crate) fn extent(&self) -> Bounds {
        let walls = self.bounds[2];
        if self.triangles == 0 {
            return self.reach;
        }
        if !is_somewhere(&self.reach) {
            return walls;
        }
        // A wall far away does not make the spheres small.
        each(|axis| {
            let ([low, high], [least, most]) = (self.reach[axis], walls[axis]);
            let size = self.reach.iter().map(|[low, high]| high - low).fold(0.0, f64::max);
            [low.min(least.max(low - 2.0 * size)), high.max(most.min(high + 2.0 * size))]
        })
    }

    /// Appends the frame to the bytes of a file: nothing but a zero, if it is empty.
    pub(crate) fn write(&self, bytes: &mut Vec<u8>) {
        if self.is_empty() {
            bytes.extend(0_u64.to_le_bytes());
            return;
        }
        // Numbers, texts and vectors of finite numbers can be written.
        let names = serde_json::to_vec(&self.names).unwrap_or_default();
        let mut own = Vec::new();
        let counts = [
            self.whole,
            self.spheres,
            self.contacts,
            self.chains,
            self.loose,
            self.triangles,
            usize::from(self.discs),
            self.size,
            names.len(),
        ];
        for count in counts {
            own.extend((count as u64).to_le_bytes());
        }
        let scales = self.ranges.scales.iter().chain([&self.ranges.chains]);
        let scales = scales.flat_map(|scale| [scale.ends, scale.usual]);
        for pair in self.bounds.into_iter().flatten().chain(self.reach).chain(scales) {
            own.extend(pair.into_iter().flat_map(f64::to_le_bytes));
        }
        own.extend(names);
        own.extend(&self.deflated);
        bytes.extend((own.len() as u64).to_le_bytes());
        bytes.extend(own);
    }

    /// Reads the bytes that [`Self::write`] has appended.
    pub(crate) fn read(words: &mut Words<'_>) -> Option<Self> {
        let size = usize::try_from(words.u64()?).ok()?;
        let (own, rest) = words.bytes.split_at_checked(size)?;
        words.bytes = rest;
        if size == 0 {
            return Some(Self::default());
        }
        let mut words = Words { bytes: own };
        let mut counts = [0; 9];
        for count in &mut counts {
            *count = usize::try_from(words.u64()?).ok()?;
        }
        let [whole, spheres, contacts, chains, loose, triangles, discs, size, text] = counts;
        let mut limits = [EMPTY; 4];
        for pair in limits.as_flattened_mut() {
            *pair = words.pair()?;
        }
        let [one, two, three, reach] = limits;
        let mut scales = [Scale::NONE; SPHERE_SCALES.len() + 1];
        for scale in &mut scales {
            *scale = Scale { ends: words.pair()?, usual: words.pair()? };
        }
        let (&of_chains, of_fields) = scales.split_last()?;
        let (names, deflated) = words.bytes.split_at_checked(text)?;
        let frame = Self {
            whole,
            spheres,
            contacts,
            chains,
            loose,
            triangles,
            discs: [false, true].get(discs).copied()?,
            bounds: [one, two, three],
            reach,
            ranges: SphereRanges { scales: of_fields.try_into().ok()?, chains: of_chains },
            names: serde_json::from_slice(names).ok()?,
            size,
            deflated: deflated.to_vec(),
        };
        frame.open().map(|_| frame)
    }

    /// Decompresses the frame; `None` if it is damaged.
    pub(crate) fn open(&self) -> Option<OpenedGrains> {
        if self.is_empty() {
            return Some(OpenedGrains::default());
        }
        let sizes = [
            (self.spheres, OF_SPHERES),
            (self.chains, OF_CHAINS),
            (self.loose, 3),
            (self.triangles, OF_WALLS),
        ];
        let expected = sizes
            .iter()
            .try_fold(0_usize, |sum, &(count, arrays)| sum.checked_add(count.checked_mul(2 * arrays)?))?;
        if expected != self.size || self.spheres > self.whole || self.loose > self.chains {
            return None;
        }
        let bytes = miniz_oxide::inflate::decompress_to_vec_with_limit(&self.deflated, self.size).ok()?;
        if bytes.len() != expected {
            return None;
        }
        let mut arrays = Unpacked::new(&bytes);
        let centres = points(&mut arrays, self.spheres, &self.bounds[0])?;
        let mut values = Vec::with_capacity(SPHERE_SCALES.len());
        for scale in &self.ranges.scales {
            values.push(arrays.places(self.spheres, scale.ends)?);
        }
        let numbers = sums(arrays.halves(self.spheres)?);
        let mut short = || Some(arrays.numbers(self.spheres)?.into_iter().map(u32::from).collect());
        let (groups, materials) = (short()?, short()?);
        let chains = self.lines(&mut arrays, &centres)?;
        let corners: [Vec<[f64; 3]>; 3] = [
            points(&mut arrays, self.triangles, &self.bounds[2])?,
            points(&mut arrays, self.triangles, &self.bounds[2])?,
            points(&mut arrays, self.triangles, &self.bounds[2])?,
        ];
        let (owners, lines) = (arrays.numbers(self.triangles)?, arrays.numbers(self.triangles)?);
        let walls = owners.iter().zip(&lines).enumerate().map(|(k, (&wall, &lines))| WallTriangle {
            corners: each(|corner| corners[corner][k]),
            wall: wall.into(),
            lines: (lines & 7) as u8,
        });
        let walls = walls.collect();
        let radii = values[RADIUS].clone();
        arrays.is_empty().then_some(OpenedGrains {
            centres,
            radii,
            values,
            numbers,
            groups,
            materials,
            chains,
            walls,
        })
    }

    fn lines(&self, arrays: &mut Unpacked<'_>, centres: &[[f64; 3]]) -> Option<Vec<ChainLine>> {
        let (first, second) = (sums(arrays.halves(self.chains)?), arrays.halves(self.chains)?);
        let normals = arrays.places(self.chains, self.ranges.chains.ends)?;
        let mut places = points(arrays, self.loose, &self.bounds[1])?.into_iter();
        let mut lines = Vec::with_capacity(self.chains);
        for ((one, other), normal) in first.into_iter().zip(second).zip(normals) {
            let end = if other == TO_PLACE { places.next()? } else { *centres.get(other as usize)? };
            lines.push(ChainLine { ends: [*centres.get(one as usize)?, end], normal });
        }
        places.next().is_none().then_some(lines)
    }
}

impl Default for GrainFrame {
    /// A frame of nothing.
    fn default() -> Self {
        Self {
            whole: 0,
            spheres: 0,
            contacts: 0,
            chains: 0,
            loose: 0,
            triangles: 0,
            discs: false,
            bounds: [[[0.0; 2]; 3]; 3],
            reach: EMPTY,
            ranges: SphereRanges::NONE,
            names: GrainNames::default(),
            size: 0,
            deflated: Vec::new(),
        }
    }
}

impl GrainNames {
    fn of(spheres: &SphereColumns) -> Self {
        let finite = |force: &[f64; 3]| force.map(|x| if x.is_finite() { x } else { 0.0 });
        Self {
            groups: spheres.group_names.clone(),
            walls: spheres.walls.iter().map(|wall| wall.name.clone()).collect(),
            forces: spheres.wall_forces.iter().map(finite).collect(),
        }
    }
}

/// Returns the values of a quantity of all spheres; the magnitudes of vectors.
fn values(spheres: &SphereColumns, counts: &[u32], quantity: Option<&Quantity>) -> Vec<f64> {
    let sizes =
        |vectors: &[[f64; 3]]| vectors.iter().map(|[x, y, z]| (x * x + y * y + z * z).sqrt()).collect();
    match quantity.map(|row| row.key) {
        Some("velocity") => sizes(&spheres.velocities),
        Some("spin") => sizes(&spheres.spins),
        Some("force") => sizes(&spheres.forces),
        Some("radius") => spheres.radii.clone(),
        _ => counts.iter().map(|&count| f64::from(count)).collect(),
    }
}

/// Returns the contacts of spheres in the frame with the largest normal forces, in their order.
fn strongest<'a>(spheres: &'a SphereColumns, kept: &[u32], most: usize) -> Vec<&'a GrainContact> {
    let is_kept = |sphere: u32| kept.len() == spheres.positions.len() || kept.binary_search(&sphere).is_ok();
    let both = |contact: &&GrainContact| {
        let other = match contact.other {
            GrainPartner::Sphere(other) => is_kept(other),
            GrainPartner::Wall(_) | GrainPartner::Facet(_) => true,
        };
        other && is_kept(contact.sphere) && contact.place.iter().all(|x| x.is_finite())
    };
    let mut contacts: Vec<&GrainContact> = spheres.contacts.iter().filter(both).collect();
    if contacts.len() > most {
        let mut order: Vec<usize> = (0..contacts.len()).collect();
        order.sort_by(|&one, &other| {
            contacts[other].normal.total_cmp(&contacts[one].normal).then(one.cmp(&other))
        });
        order.truncate(most);
        order.sort_unstable();
        contacts = order.into_iter().map(|place| contacts[place]).collect();
    }
    // Differences of the first spheres are packed.
    contacts.sort_by_key(|contact| contact.sphere);
    contacts
}

/// Returns the two spheres of each contact, by their places in the frame, or [`TO_PLACE`] for the second, and
/// the places to which those lead. A contact through a periodic boundary leads to the image of its other
/// sphere.
fn lines(spheres: &SphereColumns, kept: &[u32], chains: &[&GrainContact]) -> (Vec<[u32; 2]>, Vec<[f64; 3]>) {
    let place = |sphere: u32| kept.binary_search(&sphere).unwrap_or_default() as u32;
    let mut places = Vec::new();
    let lines = chains.iter().map(|contact| {
        let end = end_of(spheres, contact);
        match contact.other {
            GrainPartner::Sphere(other) if spheres.positions[other as usize] == end => {
                [place(contact.sphere), place(other)]
            }
            _ => {
                places.push(end);
                [place(contact.sphere), TO_PLACE]
            }
        }
    });
    (lines.collect(), places)
}

/// Returns the end of the line of a contact that begins at the centre of its sphere: the centre of the other
/// sphere, or of its image in a periodic box, or the place of the contact.
pub(super) fn end_of(spheres: &SphereColumns, contact: &GrainContact) -> [f64; 3] {
    let GrainPartner::Sphere(other) = contact.other else { return contact.place };
    let (from, to) = (spheres.positions[contact.sphere as usize], spheres.positions[other as usize]);
    let apart = each(|axis| to[axis] - from[axis]);
    let nearest = spheres.shortest(apart);
    each(|axis| if nearest[axis] == apart[axis] { to[axis] } else { from[axis] + nearest[axis] })
}

fn of<T: Copy>(kept: &[u32], all: &[T]) -> Vec<T> {
    kept.iter().map(|&sphere| all[sphere as usize]).collect()
}

/// Returns the differences of numbers, which are easier to compress if these ascend.
fn differences(numbers: &[u32]) -> Vec<u32> {
    let before = std::iter::once(&0).chain(numbers);
    numbers.iter().zip(before).map(|(number, before)| number.wrapping_sub(*before)).collect()
}

/// Returns the numbers with these differences.
fn sums(mut differences: Vec<u32>) -> Vec<u32> {
    let mut sum = 0_u32;
    for number in &mut differences {
        sum = sum.wrapping_add(*number);
        *number = sum;
    }
    differences
}

fn pack_points(packed: &mut Packed, points: &[[f64; 3]], bounds: &Bounds) {
    for (axis, &bounds) in bounds.iter().enumerate() {
        packed.places(&points.iter().map(|point| point[axis]).collect::<Vec<_>>(), bounds);
    }
}

/// Reads points. One that is nowhere is an error.
fn points(arrays: &mut Unpacked<'_>, count: usize, bounds: &Bounds) -> Option<Vec<[f64; 3]>> {
    let mut points = vec![[0.0; 3]; count];
    for (axis, &bounds) in bounds.iter().enumerate() {
        for (point, x) in points.iter_mut().zip(arrays.places(count, bounds)?) {
            point[axis] = x;
        }
    }
    points.as_flattened().iter().all(|x| x.is_finite()).then_some(points)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Spheres in a row, each of which presses the next, the last the hardest.
    fn row(count: u32) -> SphereColumns {
        let size = count as usize;
        let contact = |k: u32| GrainContact {
            sphere: k,
            other: GrainPartner::Sphere(k + 1),
            place: [0.0; 3],
            force: [0.0; 3],
            normal: f64::from(k),
            overlap: 0.0,
        };
        SphereColumns {
            numbers: (0..count).map(|k| 3 * k).collect(),
            positions: (0..count).map(|k| [f64::from(k), 0.0, 1.0]).collect(),
            radii: vec![0.5; size],
            velocities: (0..count).map(|k| [0.0, f64::from(k), 0.0]).collect(),
            spins: vec![[0.0; 3]; size],
            forces: vec![[0.0; 3]; size],
            masses: vec![1.0; size],
            materials: vec![70_000; size],
            groups: (0..count).collect(),
            contacts: (0..count - 1).map(contact).collect(),
            ..SphereColumns::default()
        }
    }

    #[test]
    fn values_come_back() {
        let frame = GrainFrame::new(&row(5), EMPTY).unwrap();
        let opened = frame.open().unwrap();
        assert_eq!(opened.numbers, [0, 3, 6, 9, 12]);
        assert_eq!(opened.centres[4], [4.0, 0.0, 1.0]);
        assert_eq!(opened.radii, [0.5; 5]);
        assert_eq!((opened.values[0][4], opened.values[4][1]), (4.0, 2.0), "speed, and number of contacts");
        let ChainLine { ends, normal } = opened.chains[2];
        assert_eq!(ends, [opened.centres[2], opened.centres[3]]);
        assert!((normal - 2.0).abs() < 1e-4 && (ends[1][0] - 3.0).abs() < 1e-4);
        assert_eq!(frame.reach, [[-0.5, 4.5], [-0.5, 0.5], [0.5, 1.5]]);
    }

    #[test]
    fn of_more_spheres_some_are_shown_and_the_strongest_contacts() {
        let frame = GrainFrame::sampled(&row(10), EMPTY, [5, 3]).unwrap();
        assert_eq!((frame.spheres, frame.whole, frame.contacts), (5, 10, 9));
        let opened = frame.open().unwrap();
        assert_eq!(opened.numbers, [0, 6, 12, 18, 24]);
        // The neighbours are not in the frame, so no contact is.
        assert!(opened.chains.is_empty());
        let opened = GrainFrame::sampled(&row(10), EMPTY, [10, 3]).unwrap().open().unwrap();
        let normals: Vec<f64> = opened.chains.iter().map(|chain| chain.normal).collect();
        assert_eq!(normals, [6.0, 7.0, 8.0]);
    }

    #[test]
    fn without_spheres_a_frame_takes_eight_bytes() {
        let frame = GrainFrame::new(&SphereColumns::default(), EMPTY).unwrap();
        let mut bytes = Vec::new();
        frame.write(&mut bytes);
        assert_eq!(bytes, [0; 8]);
        assert_eq!(GrainFrame::read(&mut Words { bytes: &bytes }), Some(frame));
    }
}
