//! Frames in three dimensions against brute force.

use std::collections::BTreeSet;

use fdem_simulation::{Crack, Mesh, Mode, Snapshot};

use crate::fields::Field;
use crate::fields::field::line_of_keys;
use crate::run::SnapshotError;
use crate::run::frame::{CrackKind, FrameError};
use crate::space::facets::{FACETS, Marks, WITHOUT, edge};
use crate::space::{Shell, SpaceFrame};

#[test]
fn facets_and_edges_fit_together() {
    for (facet, corners) in FACETS.iter().enumerate() {
        let missing = (0..4).find(|corner| !corners.contains(corner)).unwrap();
        assert_eq!(WITHOUT[missing], facet);
    }
    for (number, [a, b]) in [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]].into_iter().enumerate() {
        assert_eq!((edge(a, b), edge(b, a)), (number, number));
    }
    let mut marks = Marks::default();
    marks.see(2);
    marks.mark(0, true, false);
    marks.mark(5, false, true);
    assert!(marks.any_seen() && marks.seen(2) && marks.angular(0) && marks.between(5));
    assert_eq!(marks.0.count_ones(), 3);
}

/// A box of `cells` cubes of edge 1 along each axis, each of six tetrahedra around its diagonal, in two
/// materials.
fn cuboid(cells: [usize; 3]) -> Mesh<3, 4> {
    let number = |at: [usize; 3]| ((at[2] * (cells[1] + 1) + at[1]) * (cells[0] + 1) + at[0]) as u32;
    let mut mesh = Mesh::default();
    for k in 0..=cells[2] {
        for j in 0..=cells[1] {
            mesh.nodes.extend((0..=cells[0]).map(|i| [i as f64, j as f64, k as f64]));
        }
    }
    for cell in 0..cells.iter().product() {
        let cell = [cell % cells[0], cell / cells[0] % cells[1], cell / cells[0] / cells[1]];
        for (order, odd) in [
            ([0, 1, 2], false),
            ([1, 2, 0], false),
            ([2, 0, 1], false),
            ([0, 2, 1], true),
            ([1, 0, 2], true),
            ([2, 1, 0], true),
        ] {
            let mut at = cell;
            let mut element = [number(at); 4];
            for (corner, axis) in (1..).zip(order) {
                at[axis] += 1;
                element[corner] = number(at);
            }
            if odd {
                element.swap(0, 1);
            }
            mesh.elements.push(element);
            mesh.bodies.push(0);
            mesh.materials.push(u32::from(cell[0] > 0));
        }
    }
    mesh
}

/// A snapshot of a mesh in which every element has its own nodes.
fn separate(mesh: &Mesh<3, 4>) -> Snapshot<3, 4> {
    let count = mesh.elements.len();
    let positions: Vec<[f64; 3]> =
        mesh.elements.iter().flatten().map(|&node| mesh.nodes[node as usize]).collect();
    let moving = |position: &[f64; 3]| [position[0], -position[1], 0.0];
    Snapshot {
        step: 7,
        time: 0.25,
        displacements: positions.iter().map(moving).collect(),
        velocities: vec![[3.0, 0.0, 4.0]; positions.len()],
        positions,
        elements: (0..count as u32).map(|element| [0, 1, 2, 3].map(|corner| 4 * element + corner)).collect(),
        stresses: (0..count).map(|element| [element as f64, 0.0, -5.0, 0.0, 2.0, 0.0]).collect(),
        damage: vec![0.5; count],
        bodies: mesh.bodies.clone(),
        materials: mesh.materials.clone(),
        fragments: (0..count as u32).map(|element| element % 3).collect(),
        ..Snapshot::default()
    }
}

fn crack(elements: [u32; 2], mode: Mode) -> Crack<3> {
    Crack {
        corners: [[0.0; 3]; 3],
        elements,
        damage: 1.0,
        mode,
        opening: 1e-3,
        sliding: 0.0,
        time: Some(0.1),
        measure: 0.5,
        open_from_start: false,
        softens: None,
        dissipated: 1.0,
    }
}

/// Vertices of a facet, ascending.
fn vertices(mesh: &Mesh<3, 4>, element: usize, facet: usize) -> [u32; 3] {
    let mut vertices = FACETS[facet].map(|corner| mesh.elements[element][corner]);
    vertices.sort_unstable();
    vertices
}

/// Numbers below `most`, the same on every machine.
fn numbers(most: u32) -> impl Iterator<Item = u32> {
    let mut state = 12_345_u32;
    std::iter::repeat_with(move || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) % most
    })
}

/// All couples of elements with a facet in common, by comparing all with all.
fn couples(mesh: &Mesh<3, 4>) -> Vec<([u32; 2], [usize; 2])> {
    let mut couples = Vec::new();
    for i in 0..mesh.elements.len() {
        for j in i + 1..mesh.elements.len() {
            for k in 0..16 {
                if vertices(mesh, i, k / 4) == vertices(mesh, j, k % 4) {
                    couples.push(([i as u32, j as u32], [k / 4, k % 4]));
                }
            }
        }
    }
    couples
}

#[test]
fn joints_that_hold_are_in_frames() {
    let mesh = cuboid([2, 2, 2]);
    let mut snapshot = separate(&mesh);
    let couples = couples(&mesh);
    let all = couples.iter().map(|([a, b], [facet, _])| {
        let corners = FACETS[*facet].map(|corner| mesh.elements[*a as usize][corner]);
        let corners = corners.map(|node| mesh.nodes[node as usize]);
        Crack { corners, damage: 0.0, time: None, ..crack([*a, *b], Mode::Tension) }
    });
    let mut joints: Vec<Crack<3>> = all.collect();
    // Half of them soften.
    snapshot.cracks = joints.split_off(joints.len() / 2);
    snapshot.cracks.iter_mut().for_each(|joint| joint.damage = 0.5);
    snapshot.intact = Some(joints);
    // Joints beside an element that is not drawn are not shown.
    snapshot.positions[4 * 3 + 1][2] = f64::NAN;
    let shown = |joints: &[Crack<3>]| -> Vec<_> {
        let shown = joints.iter().filter(|joint| !joint.elements.contains(&3));
        shown.map(|joint| joint.corners).collect()
    };
    let expected = [shown(snapshot.intact.as_deref().unwrap()), shown(&snapshot.cracks)];
    assert!(expected.iter().all(|joints| joints.len() > 10) && expected.concat().len() < couples.len());
    let frame = SpaceFrame::new(&snapshot, &Shell::new(&mesh, &[])).unwrap();
    assert_eq!(SpaceFrame::from_bytes(&frame.to_bytes()).as_ref(), Ok(&frame));
    let opened = frame.open().unwrap();
    for (found, expected) in [opened.intact, opened.softening].iter().zip(&expected) {
        let far = found.as_flattened().as_flattened().iter().zip(expected.as_flattened().as_flattened());
        assert!(found.len() == expected.len() && far.into_iter().all(|(a, b)| (a - b).abs() < 1e-4));
    }
    assert!(opened.cracks.is_empty() && frame.others[1] > 0.0 && frame.others[2] > 0.0);
}

#[test]
fn what_is_seen_is_what_brute_force_finds() {
    let mesh = cuboid([3, 3, 2]);
    let shell = Shell::new(&mesh, &[]);
    assert_eq!(shell.outside(), 2 * (2 * 9 + 4 * 6));
    let couples = couples(&mesh);
    for (share, lost) in [(0, None), (5, None), (2, Some(40)), (1, Some(3))] {
        let mut snapshot = separate(&mesh);
        let picked =
            couples.iter().zip(numbers(10)).filter(|(_, number)| *number < 10 / (share + 1) && share > 0);
        let modes = [Mode::Tension, Mode::Shear, Mode::Mixed];
        snapshot.cracks =
            picked.map(|((elements, _), number)| crack(*elements, modes[number as usize % 3])).collect();
        // Joints that are open from the start are seen as cracks are.
        snapshot.cracks.iter_mut().skip(2).step_by(5).for_each(|crack| crack.open_from_start = true);
        // Joints that hold are not seen.
        snapshot.cracks.iter_mut().step_by(4).for_each(|crack| crack.time = None);
        if let Some(lost) = lost {
            snapshot.positions[4 * lost + 1][2] = f64::NAN;
        }
        let drawn = |element: u32| Some(element as usize) != lost;
        let broken: BTreeSet<[u32; 2]> =
            snapshot.cracks.iter().filter(|crack| crack.time.is_some()).map(|crack| crack.elements).collect();

        let mut expected = BTreeSet::new();
        for element in (0..mesh.elements.len()).filter(|&element| drawn(element as u32)) {
            for facet in 0..4 {
                let beside = couples.iter().find(|(elements, facets)| {
                    (0..2).any(|side| elements[side] as usize == element && facets[side] == facet)
                });
                let hidden = beside.is_some_and(|(elements, _)| {
                    elements.iter().all(|&element| drawn(element)) && !broken.contains(elements)
                });
                if !hidden {
                    expected.insert((element, facet));
                }
            }
        }
        let frame = SpaceFrame::new(&snapshot, &shell).unwrap();
        let opened = frame.open().unwrap();
        let found: BTreeSet<(usize, usize)> =
            opened.facets().map(|facet| (opened.numbers[facet.element] as usize, facet.facet)).collect();
        assert_eq!(found, expected);
        let elements: BTreeSet<u32> = opened.numbers.iter().copied().collect();
        assert_eq!(elements.len(), opened.numbers.len());
        assert_eq!(elements.len(), mesh.elements.len() - usize::from(lost.is_some()));
        let seen = broken.iter().filter(|elements| elements.iter().all(|&element| drawn(element))).count();
        assert_eq!(opened.cracks.len(), seen);
        let is_open = |crack: &&crate::space::opened::OpenedCrack| crack.kind == CrackKind::Open;
        let open = snapshot.cracks.iter().filter(|crack| {
            crack.open_from_start
                && crack.time.is_some()
                && crack.elements.iter().all(|&element| drawn(element))
        });
        assert_eq!(opened.cracks.iter().filter(is_open).count(), open.count());
        for crack in &opened.cracks {
            let elements = crack.facets.map(|(element, _)| opened.numbers[element]);
            assert!(broken.contains(&elements));
            // Nothing has moved: both sides are at the same place, corner by corner.
            assert_eq!(crack.sides[0], crack.sides[1]);
            assert_eq!(crack.middle(), crack.sides[0]);
        }
        // A joint beside an element that is not drawn is not shown as a crack.
        let shown = broken.into_iter().filter(|elements| elements.iter().all(|&element| drawn(element)));
        edges_are_as_brute_force_finds(&mesh, &opened, &expected, &shown.collect());
    }
}

/// Compares lines and traces with those found from all elements around each edge: those that hold together by
/// facets at the edge are a chain, and the surface goes from the facet at one end of the chain to that at the
/// other.
fn edges_are_as_brute_force_finds(
    mesh: &Mesh<3, 4>,
    opened: &crate::space::opened::OpenedSpace,
    seen: &BTreeSet<(usize, usize)>,
    broken: &BTreeSet<[u32; 2]>,
) {
    let is_crack = |(element, facet): (usize, usize)| {
        broken.iter().any(|pair| {
            pair.contains(&(element as u32)) && {
                let other = if pair[0] as usize == element { pair[1] } else { pair[0] } as usize;
                (0..4).any(|k| vertices(mesh, other, k) == vertices(mesh, element, facet))
            }
        })
    };
    let drawn: BTreeSet<u32> = opened.numbers.iter().copied().collect();
    let next = |element: usize, facet: usize, ends: [u32; 2]| {
        let mut at = (element, facet);
        loop {
            let has = |k: &usize| *k != at.1 && ends.iter().all(|end| vertices(mesh, at.0, *k).contains(end));
            let turned = (at.0, (0..4).find(has).unwrap());
            if seen.contains(&turned) {
                return turned;
            }
            let key = vertices(mesh, turned.0, turned.1);
            at = (0..mesh.elements.len())
                .filter(|&other| other != turned.0 && drawn.contains(&(other as u32)))
                .flat_map(|other| (0..4).map(move |k| (other, k)))
                .find(|&(other, k)| vertices(mesh, other, k) == key)
                .unwrap();
        }
    };
    let normal = |(element, facet): (usize, usize)| {
        let [a, b, c] = FACETS[facet].map(|corner| mesh.nodes[mesh.elements[element][corner] as usize]);
        let [u, v] = [b, c].map(|end| [0, 1, 2].map(|axis| end[axis] - a[axis]));
        let n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
        let length = n.iter().map(|x| x * x).sum::<f64>().sqrt();
        n.map(|x| x / length)
    };
    let mut angles = 0;
    for facet in opened.facets() {
        let element = opened.numbers[facet.element] as usize;
        for k in 0..3 {
            let ends = [k, (k + 1) % 3].map(|k| mesh.elements[element][FACETS[facet.facet][k]]);
            let other = next(element, facet.facet, ends);
            let [one, two] = [normal((element, facet.facet)), normal(other)];
            let cosine: f64 = (0..3).map(|axis| one[axis] * two[axis]).sum();
            assert_eq!(facet.angular[k], cosine < 30_f64.to_radians().cos(), "{element} {ends:?}");
            assert_eq!(facet.between[k], mesh.materials[element] != mesh.materials[other.0]);
            angles += usize::from(facet.angular[k]);
        }
    }
    assert!(angles > 0);
    for crack in &opened.cracks {
        for side in 0..2 {
            let (place, facet) = crack.facets[side];
            let element = opened.numbers[place] as usize;
            for k in 0..3 {
                let ends = [k, (k + 1) % 3].map(|k| {
                    let is = |node: &&u32| {
                        let there = mesh.nodes[**node as usize];
                        (0..3).all(|axis| (there[axis] - crack.sides[side][k][axis]).abs() < 1e-3)
                    };
                    *mesh.elements[element].iter().find(is).unwrap()
                });
                assert_eq!(crack.traces[side][k], !is_crack(next(element, facet, ends)));
            }
        }
    }
}

#[test]
fn a_frame_has_the_values_of_its_elements() {
    let mesh = cuboid([4, 3, 3]);
    let mut snapshot = separate(&mesh);
    let of_couple = couples(&mesh)[30].0;
    snapshot.cracks = vec![crack(of_couple, Mode::Mixed)];
    snapshot.stresses[9] = [f64::NAN; 6];
    snapshot.bodies[5] = 70_001;
    let shell = Shell::new(&mesh, &[]);
    let frame = SpaceFrame::new(&snapshot, &shell).unwrap();
    let opened = frame.open().unwrap();
    assert_eq!((frame.step(), frame.time(), frame.areas, frame.fragments), (7, 0.25, [0.0, 0.0, 0.5], 3));
    assert!(opened.solid && opened.surface < opened.numbers.len());
    assert_eq!(opened.cracks[0].opening, 1e-3);
    for (place, &number) in opened.numbers.iter().enumerate() {
        let element = number as usize;
        for (corner, node) in mesh.elements[element].iter().enumerate() {
            for axis in 0..3 {
                let difference = opened.corners[place][corner][axis] - mesh.nodes[*node as usize][axis];
                assert!(difference.abs() <= 0.5 * 4.0 / 65_534.0 + 1e-12);
            }
        }
        assert_eq!(opened.bodies[place], snapshot.bodies[element]);
        assert_eq!(opened.fragments[place], number % 3);
        assert_eq!(opened.materials[place], mesh.materials[element]);
        let value = |field: Field| opened.values[field.scale().unwrap()][place];
        assert_eq!(value(Field::VELOCITY), 5.0);
        assert_eq!(value(Field::DAMAGE), 0.5);
        let [largest, least] = snapshot.principal_stresses(element);
        if element == 9 {
            assert!(value(Field::MAX_PRINCIPAL).is_nan());
        } else {
            assert!((value(Field::MAX_PRINCIPAL) - largest).abs() < 0.01);
            assert!((value(Field::MIN_PRINCIPAL) - least).abs() < 0.01);
        }
    }
    let surface = SpaceFrame::with_inside(&snapshot, &shell, mesh.elements.len() - 1).unwrap();
    let only = surface.open().unwrap();
    assert!(!only.solid && only.numbers.len() == opened.surface && surface.facets == frame.facets);
    assert_eq!(only.facets().collect::<Vec<_>>(), opened.facets().collect::<Vec<_>>());
    assert_eq!((surface.scales, surface.bounds), (frame.scales, frame.bounds));
}

#[test]
fn damaged_frames_are_refused() {
    let mesh = cuboid([2, 2, 3]);
    let mut snapshot = separate(&mesh);
    let couples = couples(&mesh);
    snapshot.cracks = couples.iter().step_by(3).map(|(elements, _)| crack(*elements, Mode::Shear)).collect();
    let frame = SpaceFrame::new(&snapshot, &Shell::new(&mesh, &[])).unwrap();
    let bytes = frame.to_bytes();
    assert_eq!(SpaceFrame::from_bytes(&bytes), Ok(frame));
    assert_eq!(SpaceFrame::from_bytes(&[]), Err(FrameError::NotAFrame));
    assert_eq!(SpaceFrame::from_bytes(b"fdemfrm4"), Err(FrameError::NotAFrame));
    let head = 8 + line_of_keys().len();
    for length in head..bytes.len() {
        assert_eq!(SpaceFrame::from_bytes(&bytes[..length]), Err(FrameError::Damaged), "{length}");
    }
    // Changed bytes give another frame or an error, never a panic; the counts and the compressed arrays are
    // checked.
    for (place, number) in (8..bytes.len()).zip(numbers(255)) {
        let mut other = bytes.clone();
        other[place] ^= number as u8 + 1;
        let _ = SpaceFrame::from_bytes(&other);
    }
    for count in 2..11 {
        let mut other = bytes.clone();
        other[head + 8 * count] ^= 1;
        let fragments = count == 7;
        assert_eq!(SpaceFrame::from_bytes(&other).is_err(), !fragments && count != 2, "{count}");
    }
}

#[test]
fn snapshots_that_contradict_themselves_are_refused() {
    let mesh = cuboid([1, 1, 1]);
    let shell = Shell::new(&mesh, &[]);
    let good = separate(&mesh);
    let refused = |change: &dyn Fn(&mut Snapshot<3, 4>)| {
        let mut snapshot = good.clone();
        change(&mut snapshot);
        SpaceFrame::new(&snapshot, &shell).err()
    };
    assert_eq!(refused(&|_| {}), None);
    assert!(matches!(
        refused(&|snapshot| {
            snapshot.damage.pop();
        }),
        Some(SnapshotError::Length { .. })
    ));
    assert!(matches!(
        refused(&|snapshot| snapshot.elements[2][3] = 99),
        Some(SnapshotError::Node { element: 2, .. })
    ));
    for elements in [[0, 77], [77, 0], [0, 0]] {
        let found = refused(&|snapshot| snapshot.cracks = vec![crack(elements, Mode::Tension)]);
        assert_eq!(found, Some(SnapshotError::Crack { elements }));
    }
    let other = Shell::new(&cuboid([1, 1, 2]), &[]);
    assert!(matches!(
        SpaceFrame::new(&good, &other),
        Err(SnapshotError::Length { found: 12, expected: 6, .. })
    ));
    // Elements that are twice in the mesh, or have a node twice, end no walk in a circle.
    let mut odd = mesh.clone();
    odd.elements[1] = odd.elements[0];
    odd.elements[2][1] = odd.elements[2][0];
    let mut snapshot = separate(&odd);
    snapshot.positions[7] = [f64::INFINITY; 3];
    assert!(SpaceFrame::new(&snapshot, &Shell::new(&odd, &[])).unwrap().open().is_ok());
}
