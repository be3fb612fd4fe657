//! Checks `[[insertion]]` and `[[delete]]` before anything is meshed.

use fdem_io::numbers::brief;

use crate::bodies::materials;
use crate::grains::spheres::{radius_fault, sizes, spin_fault};
use crate::text::document::{Document, Table};
use crate::text::fault::Fault;
use crate::text::file::{BoxRegion, Domain, ModelFile, SphereInsertion};

/// Checks all insertions and all boxes that remove spheres.
pub(crate) fn check(file: &ModelFile, document: &Document<'_>, dimensions: u8, faults: &mut Vec<Fault>) {
    for (index, insertion) in file.insertion.iter().enumerate() {
        let table = Table::of("insertion", index);
        if let Err(help) = materials::number(file, &insertion.material) {
            let span = document.value(table, "material");
            faults.push(materials::unknown(span, &insertion.material, help));
        }
        let place = ComingPlace { insertion, table, document, dimensions };
        place.amount(faults);
        place.rate(faults);
        place.region(faults);
        place.domain(file.domain.as_ref(), faults);
        if let Some(spin) = insertion.spin {
            faults.extend(spin_fault(spin, dimensions, document.value(table, "spin")));
        }
    }
    for (index, removal) in file.delete.iter().enumerate() {
        let table = Table::of("delete", index);
        let title = format!("[[delete]] \"{}\"", removal.name);
        flat(&removal.within, &title, (document, table), faults);
        if let Some(until) = removal.until
            && until <= removal.from
        {
            let message = format!(
                "{title} ends at {} s, and begins at {} s: it removes nothing",
                brief(until),
                brief(removal.from)
            );
            faults.push(Fault::at(document.value(table, "until"), message).label("write until above from"));
        }
    }
}

/// A box has an inside. Returns whether it has.
fn flat(
    within: &BoxRegion,
    title: &str,
    (document, table): (&Document<'_>, Table),
    faults: &mut Vec<Fault>,
) -> bool {
    let is_flat = within.is_flat();
    if is_flat {
        let message = format!("{title}: each component of max has to be above that of min");
        faults.push(Fault::at(document.key(table, "within.max"), message).label("no inside"));
    }
    is_flat
}

/// A table of spheres that come in.
struct ComingPlace<'a> {
    insertion: &'a SphereInsertion,
    table: Table,
    document: &'a Document<'a>,
    dimensions: u8,
}

impl ComingPlace<'_> {
    fn title(&self) -> String {
        format!("[[insertion]] \"{}\"", self.insertion.name)
    }

    fn at_key(&self, key: &str, message: impl Into<String>) -> Fault {
        Fault::at(self.document.key(self.table, key), message)
    }

    /// There is a number or a mass.
    fn amount(&self, faults: &mut Vec<Fault>) {
        let title = self.title();
        match (self.insertion.count, self.insertion.mass) {
            (Some(_), None) | (None, Some(_)) => {}
            (None, None) => faults.push(
                self.at_key("name", format!("{title} has no spheres"))
                    .label("these spheres")
                    .help("give it one of count, mass"),
            ),
            (Some(_), Some(_)) => faults.push(
                self.at_key("mass", format!("{title} has both count and mass"))
                    .label("take one of them")
                    .help("write a second [[insertion]] for other spheres"),
            ),
        }
    }

    /// There is one rate at most.
    fn rate(&self, faults: &mut Vec<Fault>) {
        if self.insertion.rate.is_some() && self.insertion.mass_rate.is_some() {
            let message = format!("{} has both rate and mass_rate", self.title());
            faults.push(self.at_key("mass_rate", message).label("take one of them"));
        }
    }

    /// The radii are possible, and the region has room for the largest sphere.
    fn region(&self, faults: &mut Vec<Fault>) {
        let (title, within) = (self.title(), &self.insertion.within);
        let is_flat = flat(within, &title, (self.document, self.table), faults);
        let sizes = sizes(&self.insertion.radius);
        let span = self.document.value(self.table, "radius");
        if let Some(fault) = radius_fault(&self.insertion.radius, &title, span.clone()) {
            faults.push(fault);
            return;
        }
        let [_, largest] = sizes.range();
        let has_room = within.min.0.iter().zip(&within.max.0).all(|(min, max)| max - min >= 2.0 * largest);
        if !is_flat && !has_room {
            let message =
                format!("{title}: a sphere of radius {} m has no room in its region", brief(largest));
            faults.push(
                Fault::at(span, message)
                    .label("too large")
                    .help("spheres come in as a whole within the region: make it larger, or them smaller"),
            );
        }
    }

    /// The region is in the domain, and the domain does not grow.
    fn domain(&self, domain: Option<&Domain>, faults: &mut Vec<Fault>) {
        let Some(domain) = domain else { return };
        let (title, within) = (self.title(), &self.insertion.within);
        let axes = usize::from(self.dimensions);
        if domain.limits.len() != 2 * axes || within.min.0.len() != axes || within.max.0.len() != axes {
            return;
        }
        let (low, high) = domain.limits.split_at(axes);
        let is_in = (0..axes).all(|axis| within.min.0[axis] >= low[axis] && within.max.0[axis] <= high[axis]);
        if !is_in {
            faults.push(
                self.at_key("within", format!("{title}: its region reaches out of the box of the [domain]"))
                    .label("reaches out of the domain")
                    .help("move the region, or make the domain larger"),
            );
        }
        if domain.strain_rate.iter().flat_map(|rates| &rates.0).any(|rate| *rate != 0.0) {
            let message = format!("{title}: spheres cannot come in while the [domain] has a strain_rate");
            let help = "take strain_rate out, or begin with all spheres as [[grains]]";
            faults.push(self.at_key("within", message).label("does not follow the domain").help(help));
        }
    }
}

/// Keys with lists of coordinates: their tables, the number of their components, and the number that a model
/// in `d` dimensions has.
pub(crate) fn lengths(file: &ModelFile, d: usize) -> Vec<(Table, String, usize, usize)> {
    let mut lengths = Vec::new();
    for (index, insertion) in file.insertion.iter().enumerate() {
        let table = Table::of("insertion", index);
        for (key, vector) in [
            ("within.min", Some(&insertion.within.min)),
            ("within.max", Some(&insertion.within.max)),
            ("velocity", insertion.velocity.as_ref()),
        ] {
            lengths.extend(vector.map(|vector| (table, key.to_owned(), vector.0.len(), d)));
        }
    }
    for (index, removal) in file.delete.iter().enumerate() {
        let table = Table::of("delete", index);
        for (key, vector) in [("within.min", &removal.within.min), ("within.max", &removal.within.max)] {
            lengths.push((table, key.to_owned(), vector.0.len(), d));
        }
    }
    lengths
}
