//! Checks `[[grains]]`, `[spheres]` and `[domain]` before anything is meshed.

use crate::bodies::materials;
use crate::grains::spheres::{radius_fault, spin_fault};
use crate::grains::{coming_checks, wall_checks};
use crate::text::document::{Document, Table};
use crate::text::fault::Fault;
use crate::text::file::{
    ClumpOrientation, Domain, DomainAxis, DomainServo, GrainRegion, Grains, ModelFile, SphereLaw,
};

/// Checks all tables of spheres and walls.
pub(crate) fn check(file: &ModelFile, document: &Document<'_>, dimensions: u8, faults: &mut Vec<Fault>) {
    let is_named = |table| document.has(Table::one(table), "");
    let are_spheres = is_named("grains") || is_named("insertion");
    if !is_named("body") && !are_spheres {
        let end = document.root().span().end;
        let message = "the file lacks the key \"body\" (Bodies), and has no [[grains]] and no [[insertion]]";
        faults.push(Fault::at(end..end, message).label("needs a [[body]], [[grains]] or an [[insertion]]"));
    }
    if !file.has_spheres() {
        for table in ["wall", "spheres", "domain", "delete"] {
            if is_named(table) && !are_spheres {
                let message =
                    format!("\"{table}\" is for spheres, and there are no [[grains]] and no [[insertion]]");
                faults.push(Fault::at(document.key(Table::one(table), ""), message).label("no effect"));
            }
        }
        return;
    }
    for (index, grains) in file.grains.iter().enumerate() {
        let table = Table::of("grains", index);
        let place = GrainPlace { grains, table, document, dimensions };
        if let Err(help) = materials::number(file, &grains.material) {
            faults.push(materials::unknown(document.value(table, "material"), &grains.material, help));
        }
        place.amount(faults);
        place.region(faults);
        place.radius(faults);
        place.motion(faults);
        place.clump(file, faults);
    }
    coming_checks::check(file, document, dimensions, faults);
    wall_checks::check(file, document, dimensions, faults);
    check_law(file, document, faults);
    if let Some(domain) = &file.domain {
        check_domain(file, domain, document, faults);
    }
}

/// A table of spheres.
struct GrainPlace<'a> {
    grains: &'a Grains,
    table: Table,
    document: &'a Document<'a>,
    dimensions: u8,
}

impl GrainPlace<'_> {
    fn title(&self) -> String {
        format!("[[grains]] \"{}\"", self.grains.name)
    }

    fn at_key(&self, key: &str, message: impl Into<String>) -> Fault {
        Fault::at(self.document.key(self.table, key), message)
    }

    /// There is one amount, with the keys that it needs and no others.
    fn amount(&self, faults: &mut Vec<Fault>) {
        let (grains, title) = (self.grains, self.title());
        let amounts = grains.amounts();
        let amount = match amounts[..] {
            [amount] => amount,
            [] => {
                faults.push(
                    self.at_key("name", format!("{title} has no spheres"))
                        .label("these spheres")
                        .help("give it one of count, fraction, at, file"),
                );
                return;
            }
            [first, second, ..] => {
                faults.push(
                    self.at_key(second, format!("{title} has both {first} and {second}"))
                        .label("take one of them")
                        .help("write a second [[grains]] for other spheres"),
                );
                return;
            }
        };
        let is_packed = ["count", "fraction"].contains(&amount);
        let is_clump = grains.clump.is_some();
        let has = |key: &str| self.document.has(self.table, key);
        let keys = [
            ("within", grains.within.is_some(), is_packed, is_packed),
            ("radius", grains.radius.is_some(), amount != "file", amount != "file" && !is_clump),
            ("clump", is_clump, amount != "file", false),
            ("gap", has("gap"), is_packed, false),
            ("seed", has("seed"), amount != "file", false),
            ("translate", grains.translate.is_some(), amount == "file", false),
            ("scale", grains.scale.is_some(), amount == "file" || has("within.surface"), false),
        ];
        for (key, is_given, may, must) in keys {
            if is_given && !may {
                let message = format!("{title}: \"{key}\" does not go with {amount}");
                faults.push(self.at_key(key, message).label("take it out"));
            }
            if !is_given && must {
                let message = format!("{title} lacks the key \"{key}\", which {amount} needs");
                faults.push(self.at_key(amount, message).label(format!("needs {key}")));
            }
        }
    }

    /// The region is one, fits the dimensions, and has an inside.
    fn region(&self, faults: &mut Vec<Fault>) {
        let Some(region) = &self.grains.within else { return };
        let title = self.title();
        let wanted = if self.dimensions == 2 {
            "{ min = [x, y], max = [x, y] } or { disc = … }"
        } else {
            "{ min = [x, y, z], max = [x, y, z] }, { cylinder = … }, { ball = … } or { surface = … }"
        };
        match region.given()[..] {
            [(_, 0)] => {}
            [(_, of)] if of == self.dimensions => {}
            [(key, _)] => {
                let message = format!("{title}: a {key} is no region in {} dimensions", self.dimensions);
                let fault = self.at_key(&format!("within.{key}"), message);
                faults.push(fault.label("not in this model").help(format!("write within = {wanted}")));
                return;
            }
            ref given => {
                let which = given.get(1).map_or("within".to_owned(), |(key, _)| format!("within.{key}"));
                let message = format!("{title}: \"within\" is one region");
                faults.push(
                    self.at_key(&which, message)
                        .label("one of them")
                        .help(format!("write within = {wanted}")),
                );
                return;
            }
        }
        if let Some((key, message)) = degenerate(region) {
            faults.push(
                self.at_key(&format!("within.{key}"), format!("{title}: {message}")).label("no inside"),
            );
        }
    }

    /// The radii are possible.
    fn radius(&self, faults: &mut Vec<Fault>) {
        let Some(radius) = &self.grains.radius else { return };
        faults.extend(radius_fault(radius, &self.title(), self.document.value(self.table, "radius")));
    }

    /// The spin has the form that the dimensions require.
    fn motion(&self, faults: &mut Vec<Fault>) {
        let Some(spin) = self.grains.spin else { return };
        faults.extend(spin_fault(spin, self.dimensions, self.document.value(self.table, "spin")));
    }

    /// The keys of clumps go together, fit the dimensions and the domain.
    fn clump(&self, file: &ModelFile, faults: &mut Vec<Fault>) {
        let (grains, title) = (self.grains, self.title());
        if let (Some(_), None) = (grains.orientation, &grains.clump) {
            let message = format!("{title}: \"orientation\" goes with clump");
            faults.push(self.at_key("orientation", message).label("without clump"));
            return;
        }
        let rates = file.domain.as_ref().and_then(|domain| domain.strain_rate.as_ref());
        let is_strained = rates.is_some_and(|rates| rates.0.iter().any(|rate| *rate != 0.0));
        let has_servo = file.domain.as_ref().is_some_and(|domain| domain.servo.is_some());
        for (key, grows) in [("strain_rate", is_strained), ("servo", has_servo)] {
            if grains.clump.is_some() && grows {
                let message = format!("{title}: clumps cannot follow a [domain] with a {key}");
                let fault = self.at_key("clump", message).label("does not follow the domain");
                faults.push(fault.help(format!("take {key} out, or write single spheres")));
            }
        }
        let is_right = match grains.orientation {
            None | Some(ClumpOrientation::Random(_)) => true,
            Some(ClumpOrientation::Plane(_)) => self.dimensions == 2,
            Some(ClumpOrientation::Space(_)) => self.dimensions == 3,
        };
        if !is_right {
            let help = if self.dimensions == 2 {
                "write \"random\", or one number: degrees, counter-clockwise"
            } else {
                "write \"random\", or [x, y, z]: the axis, as long as the degrees about it"
            };
            let span = self.document.value(self.table, "orientation");
            let message = format!("\"orientation\" of clumps in {} dimensions", self.dimensions);
            faults.push(Fault::at(span, message).label("is not of this form").help(help));
        }
    }
}

/// The key of a region without inside, and a message.
fn degenerate(region: &GrainRegion) -> Option<(&'static str, &'static str)> {
    if let Some(cylinder) = &region.cylinder {
        return (cylinder.from == cylinder.to).then_some(("cylinder", "the cylinder has no length"));
    }
    match (&region.min, &region.max) {
        (Some(min), Some(max)) => {
            let is_flat = min.0.iter().zip(&max.0).any(|(min, max)| max <= min);
            is_flat.then_some(("max", "each component of max has to be above that of min"))
        }
        (Some(_), None) => Some(("min", "the region lacks max")),
        (None, Some(_)) => Some(("max", "the region lacks min")),
        (None, None) => None,
    }
}

/// The law has the keys that it needs, and no others.
fn check_law(file: &ModelFile, document: &Document<'_>, faults: &mut Vec<Fault>) {
    let (options, table) = (&file.spheres, Table::one("spheres"));
    let is_hooke = options.law == SphereLaw::Hooke;
    if is_hooke && options.stiffness.is_none() {
        faults.push(
            Fault::at(document.value(table, "law"), "the law \"hooke\" needs a stiffness, N/m")
                .label("needs stiffness")
                .help("such as stiffness = 1e5: so stiff that overlaps stay below 1 % of a radius"),
        );
    }
    for (key, given) in
        [("stiffness", options.stiffness.is_some()), ("tangential_ratio", options.tangential_ratio.is_some())]
    {
        if given && !is_hooke {
            faults.push(
                Fault::at(document.key(table, key), format!("\"{key}\" goes with law = \"hooke\""))
                    .label("no effect")
                    .help("the law \"hertz\" has the moduli of the materials"),
            );
        }
    }
    for (index, interface) in file.interface.iter().enumerate() {
        if is_hooke && interface.adhesion.is_some_and(|adhesion| adhesion > 0.0) {
            let span = document.key(Table::of("interface", index), "adhesion");
            faults.push(
                Fault::at(span, "\"adhesion\" goes with law = \"hertz\"")
                    .label("not with \"hooke\"")
                    .help("write law = \"hertz\" in [spheres], or take adhesion out"),
            );
        }
    }
}

/// The domain has an inside, axes that exist, and rates along axes that repeat.
fn check_domain(file: &ModelFile, domain: &Domain, document: &Document<'_>, faults: &mut Vec<Fault>) {
    let table = Table::one("domain");
    let (low, high) = domain.limits.split_at(domain.limits.len() / 2);
    if low.iter().zip(high).any(|(low, high)| high <= low) {
        faults.push(
            Fault::at(document.value(table, "box"), "the box of the domain is turned inside out").help(
                "a box is [xmin, ymin, xmax, ymax], in three dimensions [xmin, ymin, zmin, xmax, ymax, zmax]",
            ),
        );
    }
    let axes = domain.limits.len() / 2;
    if axes == 2
        && let Some(place) = domain.periodic.iter().position(|axis| *axis == DomainAxis::Z)
    {
        let span = document.entry(table, "periodic", place);
        faults.push(Fault::at(span, "a model in two dimensions has no axis z").label("not in this model"));
    }
    if !domain.periodic.is_empty() && !file.body.is_empty() {
        faults.push(
            Fault::at(document.key(table, "periodic"), "a domain that repeats is for spheres without bodies")
                .label("there are bodies")
                .help("take periodic out, or the bodies"),
        );
    }
    let repeats =
        |axis: usize| domain.periodic.contains(&[DomainAxis::X, DomainAxis::Y, DomainAxis::Z][axis]);
    let rates = domain.strain_rate.iter().flat_map(|rates| rates.0.iter().take(3).enumerate());
    for (axis, _) in rates.filter(|(axis, rate)| **rate != 0.0 && !repeats(*axis)) {
        let name = ["x", "y", "z"][axis];
        faults.push(
            Fault::at(
                document.entry(table, "strain_rate", axis),
                format!("the domain does not repeat along {name}, and cannot have a strain rate there"),
            )
            .label("0 here")
            .help(format!("add \"{name}\" to periodic, or move walls")),
        );
    }
    if let Some(servo) = &domain.servo {
        check_servo(domain, servo, document, faults);
    }
}

/// The servo of a domain has pressures, along axes that repeat and have no strain rate at the same time.
fn check_servo(domain: &Domain, servo: &DomainServo, document: &Document<'_>, faults: &mut Vec<Fault>) {
    let table = Table::one("domain");
    let pressures = servo.pressures();
    if pressures == [None; 3] {
        faults.push(
            Fault::at(document.key(table, "servo"), "the servo of the domain has no pressure")
                .label("no effect")
                .help(
                    "write servo = { x = …, y = …, z = …, rate = … }, with a pressure along one axis or more",
                ),
        );
    }
    let axes = [("x", DomainAxis::X), ("y", DomainAxis::Y), ("z", DomainAxis::Z)];
    for ((axis, (name, word)), _) in
        axes.into_iter().enumerate().zip(pressures).filter(|(_, of)| of.is_some())
    {
        let at = document.key(table, &format!("servo.{name}"));
        if !domain.periodic.contains(&word) {
            let message =
                format!("the domain does not repeat along {name}, and cannot keep up a pressure there");
            let fault = Fault::at(at.clone(), message).label("does not repeat");
            faults.push(fault.help(format!("add \"{name}\" to periodic, or give a wall a servo")));
        }
        let rate = domain.strain_rate.as_ref().and_then(|rates| rates.0.get(axis)).copied().unwrap_or(0.0);
        if rate != 0.0 && domain.strain_from == 0.0 {
            let message =
                format!("the domain has a pressure and a strain rate along {name} at the same time");
            let fault = Fault::at(at, message).label("or the rate of strain_rate");
            faults
                .push(fault.help("give strain_from, the time at which the strain rate follows the pressure"));
        }
    }
}

/// Keys with lists of coordinates: their tables, the number of their components, and the number that a model
/// in `d` dimensions has.
pub(crate) fn lengths(file: &ModelFile, d: usize) -> Vec<(Table, String, usize, usize)> {
    let mut lengths = Vec::new();
    for (index, grains) in file.grains.iter().enumerate() {
        let table = Table::of("grains", index);
        let within = grains.within.as_ref();
        let wrong = grains.at.iter().flatten().find(|point| point.0.len() != d);
        let of_clump = grains.clump.iter().flatten().map(|sphere| &sphere.at).find(|at| at.0.len() != d);
        for (key, vector) in [
            ("at", wrong),
            ("clump", of_clump),
            ("translate", grains.translate.as_ref()),
            ("velocity", grains.velocity.as_ref()),
            ("within.min", within.and_then(|within| within.min.as_ref())),
            ("within.max", within.and_then(|within| within.max.as_ref())),
            ("within.disc.centre", within.and_then(|within| Some(&within.disc.as_ref()?.centre))),
            ("within.ball.centre", within.and_then(|within| Some(&within.ball.as_ref()?.centre))),
        ] {
            lengths.extend(vector.map(|vector| (table, key.to_owned(), vector.0.len(), d)));
        }
    }
    lengths.extend(coming_checks::lengths(file, d));
    lengths.extend(wall_checks::lengths(file, d));
    if let Some(domain) = &file.domain {
        let table = Table::one("domain");
        lengths.push((table, "box".to_owned(), domain.limits.len(), 2 * d));
        let rates = domain.strain_rate.as_ref();
        lengths.extend(rates.map(|rates| (table, "strain_rate".to_owned(), rates.0.len(), d)));
    }
    lengths
}
