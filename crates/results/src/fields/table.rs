//! The table of fields: every quantity of the results, in the order of files for ParaView.

use fdem_simulation::Mode;
use fdem_simulation::grains::GrainPartner;

use crate::fields::colours::SIGNED;
use crate::fields::liquid::LiquidIn;
use crate::fields::place::Place;
use crate::fields::quantity::{Ends, Number, Quantity, Shown, Span, Value};
use crate::fields::stress::von_mises;
use crate::picture::colour::{HEAT, Rgb, SEA};

/// Names of the components of vectors in space.
const SPACE: [&str; 3] = ["x", "y", "z"];

/// Names of the two elements of a joint or a contact.
const COUPLE: [&str; 2] = ["one", "other"];

/// Colours of a distance: dark where it is small.
const DISTANCE: [Rgb; 17] = {
    let (mut colours, mut k) = (HEAT, 0);
    while k < colours.len() {
        colours[k] = HEAT[colours.len() - 1 - k];
        k += 1;
    }
    colours
};

/// Entries that most rows share: one number of an element, without a unit and a sign, in files only.
const OF_ELEMENTS: Quantity = Quantity {
    key: "",
    name: "",
    about: "",
    definition: "",
    unit: "",
    sign: "",
    span: Span::NotNegative,
    place: Place::Element,
    components: &[],
    dimensions: None,
    in_files: true,
    liquid: None,
    shown: None,
    value: Value::Real(|_, _, _| f64::NAN),
};

/// Entries that the rows of nodes share: vectors.
const OF_NODES: Quantity = Quantity {
    sign: "along the axes",
    span: Span::Any,
    place: Place::Node,
    components: &SPACE,
    ..OF_ELEMENTS
};

/// Entries that the rows of joints share.
const OF_JOINTS: Quantity = Quantity { place: Place::Joint, ..OF_ELEMENTS };

/// Entries that the rows of fluid in joints share.
const OF_FLUID: Quantity = Quantity { liquid: Some(LiquidIn::Cracks), ..OF_JOINTS };

/// Entries that the rows of contacts share.
const OF_CONTACTS: Quantity = Quantity { place: Place::Contact, ..OF_ELEMENTS };

/// Entries that the rows of spheres share.
const OF_SPHERES: Quantity = Quantity { place: Place::Sphere, ..OF_ELEMENTS };

/// Entries that the rows of vectors of spheres share.
const VECTORS_OF_SPHERES: Quantity =
    Quantity { sign: "along the axes", span: Span::Any, components: &SPACE, ..OF_SPHERES };

/// Entries that the rows of contacts of spheres share.
const OF_SPHERE_CONTACTS: Quantity = Quantity { place: Place::SphereContact, ..OF_ELEMENTS };

/// Entries that the rows of walls share.
const OF_WALLS: Quantity = Quantity { place: Place::Wall, ..OF_ELEMENTS };

/// Every quantity of the results. Names, units, colours and values of fields are here and nowhere else.
pub const QUANTITIES: &[Quantity] = &[
    Quantity {
        key: "displacement",
        name: "displacement",
        about: "the displacement",
        unit: "m",
        shown: Some(Shown::Scale { ramp: &SEA, ends: Ends::FromZero, column: None }),
        value: Value::Real(|state, node, axis| state.displacement(node)[axis]),
        ..OF_NODES
    },
    Quantity {
        key: "velocity",
        name: "velocity",
        about: "the velocity, half a step before the positions",
        unit: "m/s",
        shown: Some(Shown::Scale { ramp: &SEA, ends: Ends::FromZero, column: Some("largest velocity") }),
        value: Value::Real(|state, node, axis| state.velocity(node)[axis]),
        ..OF_NODES
    },
    Quantity {
        key: "reaction",
        name: "reaction",
        about: "the force of all boundaries on the node at the beginning of the last step",
        unit: "N",
        value: Value::Real(|state, node, axis| state.reaction(node)[axis]),
        ..OF_NODES
    },
    Quantity {
        key: "pore_pressure",
        name: "pressure in pores",
        about: "the pressure of the liquid in pores; not a number where there are none",
        unit: "Pa",
        sign: "compression positive",
        span: Span::Any,
        place: Place::Node,
        liquid: Some(LiquidIn::Pores),
        shown: Some(Shown::Scale { ramp: &SIGNED, ends: Ends::Symmetric, column: None }),
        value: Value::Real(|state, node, _| state.pore_pressure(node)),
        ..OF_ELEMENTS
    },
    Quantity {
        key: "stress",
        name: "stress",
        about: "the Cauchy stress",
        unit: "Pa",
        sign: "tension positive",
        span: Span::Any,
        components: &["xx", "yy", "zz", "xy", "yz", "xz"],
        value: Value::Real(|state, element, part| state.stress(element)[part]),
        ..OF_ELEMENTS
    },
    Quantity {
        key: "principal_stress",
        name: "principal stresses",
        about: "the largest and the smallest principal stress, in two dimensions those in the plane",
        unit: "Pa",
        sign: "tension positive",
        span: Span::Any,
        components: &["max", "min"],
        value: Value::Real(|state, element, part| state.principal_stresses(element)[part]),
        ..OF_ELEMENTS
    },
    Quantity {
        key: "max_principal",
        name: "largest principal stress",
        about: "the largest principal stress, in two dimensions that in the plane",
        unit: "Pa",
        sign: "tension positive",
        span: Span::Any,
        // `principal_stress` has it.
        in_files: false,
        shown: Some(Shown::Scale { ramp: &SIGNED, ends: Ends::Symmetric, column: Some("largest tension") }),
        value: Value::Real(|state, element, _| state.principal_stresses(element)[0]),
        ..OF_ELEMENTS
    },
    Quantity {
        key: "min_principal",
        name: "smallest principal stress",
        about: "the smallest principal stress, in two dimensions that in the plane",
        unit: "Pa",
        sign: "tension positive",
        span: Span::Any,
        in_files: false,
        shown: Some(Shown::Scale { ramp: &SIGNED, ends: Ends::Symmetric, column: None }),
        value: Value::Real(|state, element, _| state.principal_stresses(element)[1]),
        ..OF_ELEMENTS
    },
    Quantity {
        key: "von_mises",
        name: "von Mises stress",
        about: "the von Mises equivalent stress",
        definition: "All three principal stresses count, in two dimensions that out of the plane too.",
        unit: "Pa",
        shown: Some(Shown::Scale {
            ramp: &HEAT,
            ends: Ends::FromZero,
            column: Some("largest von Mises stress"),
        }),
        value: Value::Real(|state, element, _| von_mises(*state.stress(element))),
        ..OF_ELEMENTS
    },
    Quantity {
        key: "max_shear",
        name: "largest shear stress",
        about: "half of the difference between the largest and the smallest principal stress, in two \
                dimensions those in the plane",
        definition: "(σ₁ - σ₃)/2, the radius of Mohr's largest circle. In two dimensions σ₁ and σ₃ are \
                     `max_principal` and `min_principal`, also in plane strain: the stress out of the plane \
                     does not count, because all cracks are across the plane.",
        unit: "Pa",
        shown: Some(Shown::Scale { ramp: &HEAT, ends: Ends::FromZero, column: None }),
        value: Value::Real(|state, element, _| {
            let [most, least] = state.principal_stresses(element);
            0.5 * (most - least)
        }),
        ..OF_ELEMENTS
    },
    Quantity {
        key: "distance_to_failure",
        name: "distance to failure",
        about: "1 without stress, 0 where the stress reaches the strength of the material; not a number \
                without a strength",
        definition: "1 - 1/F, where F is the factor by which all components of the stress can grow until \
                     they reach the envelope of Mohr and Coulomb with a tension cut-off: \
                     1/F = max(0, σ₁/f, (r √(1 + tan²φ) + m tan φ)/c) with the tensile strength f, the \
                     cohesion c, the friction angle φ, and m and r, the middle and the radius of Mohr's \
                     largest circle. 1/F is the largest share of the strength that a plane uses, the stress \
                     exposure of its action plane (Puck and Schürmann, Compos. Sci. Technol. 62 (2002) \
                     1633-1662). In two dimensions σ₁, m and r are those in the plane. The strength is \
                     that of the material, in bedded rock that of each plane by its angle to the bedding, \
                     without the scatter of `weibull_modulus`, and not that of an interface or of a joint \
                     set.",
        sign: "negative beyond the strength",
        span: Span::Any,
        shown: Some(Shown::Scale { ramp: &DISTANCE, ends: Ends::Fixed(0.0, 1.0), column: None }),
        value: Value::Real(|state, element, _| state.exposure(element).map_or(f64::NAN, |used| 1.0 - used)),
        ..OF_ELEMENTS
    },
    Quantity {
        key: "damage",
        name: "damage",
        about: "the largest damage of the joints of the element",
        span: Span::Between(0.0, 1.0),
        shown: Some(Shown::Scale { ramp: &HEAT, ends: Ends::Fixed(0.0, 1.0), column: None }),
        value: Value::Real(|state, element, _| state.damage(element)),
        ..OF_ELEMENTS
    },
    Quantity {
        key: "fluid_pressure",
        name: "pressure of the fluid",
        about: "the largest pressure of the fluid in the cracks of the element; not a number without fluid \
                there",
        unit: "Pa",
        sign: "compression positive",
        span: Span::Any,
        liquid: Some(LiquidIn::Cracks),
        // Joints have it.
        in_files: false,
        shown: Some(Shown::Scale { ramp: &SEA, ends: Ends::FromZero, column: None }),
        value: Value::Real(|state, element, _| state.fluid_pressure(element)),
        ..OF_ELEMENTS
    },
    Quantity {
        key: "body",
        name: "body",
        about: "number of the body",
        shown: Some(Shown::Number(Number::Body)),
        value: Value::Whole(|state, element, _| state.body(element).into()),
        ..OF_ELEMENTS
    },
    Quantity {
        key: "material",
        name: "material",
        about: "number of the material",
        shown: Some(Shown::Number(Number::Material)),
        value: Value::Whole(|state, element, _| state.material(element).into()),
        ..OF_ELEMENTS
    },
    Quantity {
        key: "fragment",
        name: "fragment",
        about: "number of the fragment: elements that hang together by facets have one number",
        value: Value::Whole(|state, element, _| state.fragment(element).into()),
        ..OF_ELEMENTS
    },
    Quantity {
        key: "mode",
        name: "mode of failure",
        about: "0 for tension, 1 for shear, 2 for a mixture of both; 0 for a whole joint",
        span: Span::Between(0.0, 2.0),
        value: Value::Short(|state, joint, _| match state.joint(joint).mode {
            _ if state.joint(joint).damage == 0.0 => 0,
            Mode::Tension => 0,
            Mode::Shear => 1,
            Mode::Mixed => 2,
        }),
        ..OF_JOINTS
    },
    Quantity {
        key: "broken",
        name: "broken",
        about: "1 if the joint is broken, 0 while it holds",
        span: Span::Between(0.0, 1.0),
        value: Value::Short(|state, joint, _| state.joint(joint).time.is_some().into()),
        ..OF_JOINTS
    },
    Quantity {
        key: "open_from_start",
        name: "open from the start",
        about: "1 for a joint of a set that is open from the start, which is no crack of the run",
        span: Span::Between(0.0, 1.0),
        value: Value::Short(|state, joint, _| state.joint(joint).open_from_start.into()),
        ..OF_JOINTS
    },
    Quantity {
        key: "damage",
        name: "damage",
        about: "from 0, whole, to 1, broken; the mean of its corners",
        span: Span::Between(0.0, 1.0),
        value: Value::Real(|state, joint, _| state.joint(joint).damage),
        ..OF_JOINTS
    },
    Quantity {
        key: "opening",
        name: "opening",
        about: "the mean distance of its two sides across the joint",
        unit: "m",
        sign: "negative where it is closed",
        span: Span::Any,
        value: Value::Real(|state, joint, _| state.joint(joint).opening),
        ..OF_JOINTS
    },
    Quantity {
        key: "sliding",
        name: "sliding",
        about: "the mean distance of its two sides along the joint",
        unit: "m",
        sign: "with a sign in two dimensions, the magnitude in three",
        span: Span::Any,
        value: Value::Real(|state, joint, _| state.joint(joint).sliding),
        ..OF_JOINTS
    },
    Quantity {
        key: "time_of_failure",
        name: "time of failure",
        about: "the time when it broke, 0 for joints that are open from the start; not a number while it holds",
        unit: "s",
        value: Value::Real(|state, joint, _| state.joint(joint).time.unwrap_or(f64::NAN)),
        ..OF_JOINTS
    },
    Quantity {
        key: "length",
        name: "length",
        about: "the length of the undeformed edge",
        unit: "m",
        dimensions: Some(2),
        value: Value::Real(|state, joint, _| state.joint(joint).measure),
        ..OF_JOINTS
    },
    Quantity {
        key: "area",
        name: "area",
        about: "the area of the undeformed face",
        unit: "m²",
        dimensions: Some(3),
        value: Value::Real(|state, joint, _| state.joint(joint).measure),
        ..OF_JOINTS
    },
    Quantity {
        key: "elements",
        name: "elements",
        about: "the elements on its two sides",
        components: &COUPLE,
        value: Value::Whole(|state, joint, side| state.joint(joint).elements[side].into()),
        ..OF_JOINTS
    },
    Quantity {
        key: "fluid_pressure",
        name: "pressure of the fluid",
        about: "the pressure of the fluid in it; not a number where fluid cannot enter",
        unit: "Pa",
        sign: "compression positive",
        span: Span::Any,
        value: Value::Real(|state, joint, _| state.wet_joint(joint).map_or(f64::NAN, |wet| wet.pressure)),
        ..OF_FLUID
    },
    Quantity {
        key: "aperture",
        name: "hydraulic aperture",
        about: "the aperture through which the fluid flows; not a number where fluid cannot enter",
        unit: "m",
        value: Value::Real(|state, joint, _| state.wet_joint(joint).map_or(f64::NAN, |wet| wet.aperture)),
        ..OF_FLUID
    },
    Quantity {
        key: "saturation",
        name: "saturation",
        about: "the part of it that is full of fluid; not a number where fluid cannot enter",
        span: Span::Between(0.0, 1.0),
        value: Value::Real(|state, joint, _| state.wet_joint(joint).map_or(f64::NAN, |wet| wet.saturation)),
        ..OF_FLUID
    },
    Quantity {
        key: "force",
        name: "contact force",
        about: "the force on the first element; the second has the opposite",
        unit: "N",
        sign: "along the axes",
        span: Span::Any,
        components: &SPACE,
        value: Value::Real(|state, contact, axis| state.contact_force(contact)[axis]),
        ..OF_CONTACTS
    },
    Quantity {
        key: "normal_force",
        name: "normal force",
        about: "the magnitude of the normal part of the force",
        unit: "N",
        value: Value::Real(|state, contact, _| state.contact_sizes(contact)[0]),
        ..OF_CONTACTS
    },
    Quantity {
        key: "tangential_force",
        name: "tangential force",
        about: "the magnitude of the tangential part of the force: friction",
        unit: "N",
        value: Value::Real(|state, contact, _| state.contact_sizes(contact)[1]),
        ..OF_CONTACTS
    },
    Quantity {
        key: "elements",
        name: "elements",
        about: "the two elements, the lower number first",
        components: &COUPLE,
        value: Value::Whole(|state, contact, side| state.contact_elements(contact)[side].into()),
        ..OF_CONTACTS
    },
    Quantity {
        key: "bodies",
        name: "bodies",
        about: "the bodies of the two elements",
        components: &COUPLE,
        value: Value::Whole(|state, contact, side| {
            state.body(state.contact_elements(contact)[side] as usize).into()
        }),
        ..OF_CONTACTS
    },
    Quantity {
        key: "fragments",
        name: "fragments",
        about: "the fragments of the two elements",
        components: &COUPLE,
        value: Value::Whole(|state, contact, side| {
            state.fragment(state.contact_elements(contact)[side] as usize).into()
        }),
        ..OF_CONTACTS
    },
    Quantity {
        key: "number",
        name: "number",
        about: "number of the sphere, which it keeps for the whole run",
        value: Value::Whole(|state, sphere, _| state.spheres().numbers[sphere].into()),
        ..OF_SPHERES
    },
    Quantity {
        key: "radius",
        name: "radius",
        about: "the radius",
        unit: "m",
        shown: Some(Shown::Scale { ramp: &SEA, ends: Ends::FromZero, column: None }),
        value: Value::Real(|state, sphere, _| state.spheres().radii[sphere]),
        ..OF_SPHERES
    },
    Quantity {
        key: "velocity",
        name: "velocity",
        about: "the velocity of the centre",
        unit: "m/s",
        shown: Some(Shown::Scale { ramp: &SEA, ends: Ends::FromZero, column: None }),
        value: Value::Real(|state, sphere, axis| state.spheres().velocities[sphere][axis]),
        ..VECTORS_OF_SPHERES
    },
    Quantity {
        key: "spin",
        name: "spin",
        about: "the angular velocity",
        unit: "rad/s",
        shown: Some(Shown::Scale { ramp: &SEA, ends: Ends::FromZero, column: None }),
        value: Value::Real(|state, sphere, axis| state.spheres().spins[sphere][axis]),
        ..VECTORS_OF_SPHERES
    },
    Quantity {
        key: "force",
        name: "force",
        about: "the force of all contacts on the sphere",
        unit: "N",
        shown: Some(Shown::Scale { ramp: &HEAT, ends: Ends::FromZero, column: None }),
        value: Value::Real(|state, sphere, axis| state.spheres().forces[sphere][axis]),
        ..VECTORS_OF_SPHERES
    },
    Quantity {
        key: "mass",
        name: "mass",
        about: "the mass",
        unit: "kg",
        value: Value::Real(|state, sphere, _| state.spheres().masses[sphere]),
        ..OF_SPHERES
    },
    Quantity {
        key: "coordination",
        name: "number of contacts",
        about: "the number of contacts with spheres, walls and bodies",
        shown: Some(Shown::Scale { ramp: &SEA, ends: Ends::FromZero, column: None }),
        value: Value::Whole(|state, sphere, _| state.coordination(sphere).into()),
        ..OF_SPHERES
    },
    Quantity {
        key: "group",
        name: "group",
        about: "number of the group of spheres",
        shown: Some(Shown::Number(Number::Body)),
        value: Value::Whole(|state, sphere, _| state.spheres().groups[sphere].into()),
        ..OF_SPHERES
    },
    Quantity {
        key: "material",
        name: "material",
        about: "number of the material",
        shown: Some(Shown::Number(Number::Material)),
        value: Value::Whole(|state, sphere, _| state.spheres().materials[sphere].into()),
        ..OF_SPHERES
    },
    Quantity {
        key: "force",
        name: "force of the contact",
        about: "the force on the first sphere",
        unit: "N",
        sign: "along the axes",
        span: Span::Any,
        components: &SPACE,
        value: Value::Real(|state, contact, axis| state.spheres().contacts[contact].force[axis]),
        ..OF_SPHERE_CONTACTS
    },
    Quantity {
        key: "normal_force",
        name: "normal force",
        about: "the part of the force along the normal",
        unit: "N",
        sign: "positive for pressure",
        span: Span::Any,
        value: Value::Real(|state, contact, _| state.spheres().contacts[contact].normal),
        ..OF_SPHERE_CONTACTS
    },
    Quantity {
        key: "force_chains",
        name: "normal force of contacts",
        about: "the normal force of the contacts of spheres, as lines between their centres",
        definition: "Lines lead from centre to centre, and to the place of the contact with a wall or a body. \
                     Their widths are proportional to the normal force.",
        unit: "N",
        sign: "positive for pressure",
        span: Span::Any,
        // `normal_force` has it.
        in_files: false,
        shown: Some(Shown::Scale { ramp: &HEAT, ends: Ends::FromZero, column: None }),
        value: Value::Real(|state, contact, _| state.spheres().contacts[contact].normal),
        ..OF_SPHERE_CONTACTS
    },
    Quantity {
        key: "overlap",
        name: "overlap",
        about: "the depth by which the two overlap",
        unit: "m",
        sign: "negative where adhesion holds across a gap",
        span: Span::Any,
        value: Value::Real(|state, contact, _| state.spheres().contacts[contact].overlap),
        ..OF_SPHERE_CONTACTS
    },
    Quantity {
        key: "kind",
        name: "kind of the contact",
        about: "0 with a sphere, 1 with a wall, 2 with a body",
        span: Span::Between(0.0, 2.0),
        value: Value::Short(|state, contact, _| match state.spheres().contacts[contact].other {
            GrainPartner::Sphere(_) => 0,
            GrainPartner::Wall(_) => 1,
            GrainPartner::Facet(_) => 2,
        }),
        ..OF_SPHERE_CONTACTS
    },
    Quantity {
        key: "couple",
        name: "the two",
        about: "the number of the sphere, and the number of the other sphere, of the wall, or of the facet of \
                the surface of the bodies",
        components: &COUPLE,
        value: Value::Whole(|state, contact, side| {
            let (spheres, contact) = (state.spheres(), &state.spheres().contacts[contact]);
            match contact.other {
                _ if side == 0 => spheres.numbers[contact.sphere as usize].into(),
                GrainPartner::Sphere(other) => spheres.numbers[other as usize].into(),
                GrainPartner::Wall(other) | GrainPartner::Facet(other) => other.into(),
            }
        }),
        ..OF_SPHERE_CONTACTS
    },
    Quantity {
        key: "wall",
        name: "wall",
        about: "number of the wall",
        value: Value::Whole(|_, wall, _| wall.cast_signed() as i64),
        ..OF_WALLS
    },
    Quantity {
        key: "force",
        name: "force on the wall",
        about: "the force of all spheres on the wall",
        unit: "N",
        sign: "along the axes",
        span: Span::Any,
        components: &SPACE,
        value: Value::Real(|state, wall, axis| {
            state.spheres().wall_forces.get(wall).map_or(0.0, |force| force[axis])
        }),
        ..OF_WALLS
    },
    Quantity {
        key: "material",
        name: "material",
        about: "number of the material",
        value: Value::Whole(|state, wall, _| state.spheres().walls[wall].material.into()),
        ..OF_WALLS
    },
];

/// Keys of the fields by which elements and spheres are coloured, in the order of menus and lists.
pub(crate) const SHOWN: [&str; 18] = [
    "max_principal",
    "min_principal",
    "von_mises",
    "max_shear",
    "distance_to_failure",
    "velocity",
    "displacement",
    "damage",
    "fluid_pressure",
    "pore_pressure",
    "body",
    "material",
    "spin",
    "force",
    "radius",
    "coordination",
    "group",
    "force_chains",
];
