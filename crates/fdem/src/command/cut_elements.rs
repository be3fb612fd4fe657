//! Contacts of elements that are cut into triangles or tetrahedra when they are read: one contact for each
//! couple of elements of the file.

use fdem_contact::Couple;
use fdem_contact::discretised::BodyContact;
use fdem_contact::narrow::{Contact, Measure};

/// Combines the contacts of parts of elements to one for each couple, sorted. Couples have the numbers of the
/// elements of the files, and contacts of parts of one element are left out. `pairs`: the contacts of these
/// elements as bodies, where there are others than depths.
///
/// Parts of an element have no volume in common, so that lengths, areas and volumes are sums. Point and
/// normal are means, weighted by them, and those of the common face of solids that only touch. Of the depths
/// of a sphere in several parts the largest counts, with its point and normal.
pub(crate) fn combined<const D: usize>(
    mut contacts: Vec<(Couple, Contact<D>)>,
    pairs: &[BodyContact<D>],
) -> Vec<(Couple, Contact<D>)> {
    contacts.retain(|(couple, _)| couple.i != couple.j);
    contacts.sort_by_key(|(couple, _)| *couple);
    let of_couples = contacts.chunk_by(|a, b| a.0 == b.0);
    of_couples.map(|of_couple| (of_couple[0].0, combined_contact(of_couple, pairs))).collect()
}

fn combined_contact<const D: usize>(
    contacts: &[(Couple, Contact<D>)],
    pairs: &[BodyContact<D>],
) -> Contact<D> {
    let (couple, first) = contacts[0];
    let depths = contacts.iter().filter_map(|(_, contact)| match contact.measure {
        Measure::Depth(depth) => Some((depth, contact)),
        _ => None,
    });
    if let Some((_, deepest)) = depths.reduce(|a, b| if b.0 > a.0 { b } else { a }) {
        return *deepest;
    }
    let found = pairs.binary_search_by_key(&[couple.i, couple.j], |pair| pair.bodies);
    let (Ok(place), true) = (found, contacts.len() > 1) else { return first };
    let BodyContact { overlap, shared, point, normal, .. } = pairs[place];
    // Areas of surfaces in one plane count as boundary that is shared.
    let is_shared = |measure: Measure| D > 2 && matches!(measure, Measure::Area(_));
    let mut kinds = contacts.iter().map(|(_, contact)| contact.measure);
    let coplanar = kinds.clone().any(is_shared) && overlap == 0.0;
    let measure = match kinds.find(|&measure| !is_shared(measure)).filter(|_| !coplanar) {
        Some(Measure::Gap(_)) => Measure::Gap(overlap),
        Some(Measure::Depth(_)) => Measure::Depth(overlap),
        Some(Measure::Length(_)) => Measure::Length(overlap),
        Some(Measure::Area(_)) => Measure::Area(overlap),
        Some(Measure::Volume(_)) => Measure::Volume(overlap),
        None => Measure::Area(shared),
    };
    Contact { point, normal, measure }
}

/// Counts the couples of each contact of bodies again. `bodies_of`: the bodies of a couple.
pub(crate) fn count_couples<const D: usize>(
    bodies: &mut [BodyContact<D>],
    contacts: &[(Couple, Contact<D>)],
    bodies_of: impl Fn(Couple) -> [u32; 2],
) {
    for contact in bodies.iter_mut() {
        contact.couples = 0;
    }
    for &(couple, _) in contacts {
        let [a, b] = bodies_of(couple);
        let pair = [a.min(b), a.max(b)];
        if let Ok(place) = bodies.binary_search_by_key(&pair, |contact| contact.bodies) {
            bodies[place].couples += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fdem_contact::discretised::gather;

    fn contact(x: f64, measure: Measure) -> Contact<3> {
        Contact { point: [x, 0.0, 0.0], normal: [0.0, 0.0, 1.0], measure }
    }

    #[test]
    fn contacts_of_parts_are_combined() {
        let couple = Couple { i: 0, j: 7 };
        let of = |contacts: &[Contact<3>]| {
            let as_bodies: Vec<_> = contacts.iter().map(|&contact| ([0, 7], contact)).collect();
            let contacts = contacts.iter().map(|&contact| (couple, contact)).collect();
            let found = combined(contacts, &gather(&as_bodies).expect("memory"));
            assert_eq!(found.len(), 1);
            (found[0].1.measure, found[0].1.point[0])
        };
        let volumes = [contact(1.0, Measure::Volume(1.0)), contact(5.0, Measure::Volume(3.0))];
        assert_eq!(of(&volumes), (Measure::Volume(4.0), 4.0));
        let touching = [contact(1.0, Measure::Volume(0.0)), contact(3.0, Measure::Volume(0.0))];
        assert_eq!(of(&touching), (Measure::Volume(0.0), 2.0));
        let depths = [contact(1.0, Measure::Depth(0.1)), contact(2.0, Measure::Depth(0.3))];
        assert_eq!(of(&depths), (Measure::Depth(0.3), 2.0));
        let crossing = [contact(1.0, Measure::Area(2.0)), contact(2.0, Measure::Length(0.5))];
        assert_eq!(of(&crossing), (Measure::Length(0.5), 2.0));
        let coplanar = [contact(1.0, Measure::Area(2.0)), contact(2.0, Measure::Length(0.0))];
        assert_eq!(of(&coplanar), (Measure::Area(2.0), 1.0));
    }

    #[test]
    fn couples_stay_apart_and_parts_of_one_element_are_none() {
        let all = [[3, 4], [0, 2], [1, 1], [0, 2], [0, 1]];
        let contacts = all.map(|[i, j]| (Couple { i, j }, contact(0.0, Measure::Volume(1.0))));
        let as_bodies: Vec<_> =
            contacts.iter().map(|(couple, contact)| ([couple.i, couple.j], *contact)).collect();
        let found = combined(contacts.to_vec(), &gather(&as_bodies).expect("memory"));
        let couples: Vec<[u32; 2]> = found.iter().map(|(couple, _)| [couple.i, couple.j]).collect();
        assert_eq!(couples, [[0, 1], [0, 2], [3, 4]]);
        assert_eq!(found[1].1.measure, Measure::Volume(2.0));
    }
}
