//! The list of all cases.

use std::sync::LazyLock;

use crate::fluid::list::FLUID;
use crate::grains::list::GRAINS;
use crate::outcome::Case;
use crate::{
    arch, bedding, brazilian, cantilever, cavity, compliance, compression, debris, disc, excavation,
    free_crack, free_shear, ground, heaps, hertz, hole, impact, incline, rigid_heap, ring, rocking, rotation,
    shear, space, tension, wave,
};

const JOHNSON: &str = "K. L. Johnson, Contact Mechanics (1985), 4.2 and 5.6";
const WAVES: &str = "K. F. Graff, Wave Motion in Elastic Solids (1975), ch. 2";
const COHESIVE: &str = "J. Planas and M. Elices, Int. J. Fracture 51 (1991) 139–157, for the straight crack";
const BOOK: &str = "A. Munjiza, The Combined Finite-Discrete Element Method (2004)";

/// Cases of bodies that deform, and of rigid ones.
const BODIES: &[Case] = &[
    Case {
        number: 1,
        name: "waves in bars",
        what: "A piston pushes a bar (ν = 0). Its wave travels at √(E/ρ), whether or not the bar could break, and doubles the velocity of the free end. Two equal bars that meet touch for \
               2 L/c, under the stress ρ c v/2.",
        source: WAVES,
        run: wave::run,
    },
    Case {
        number: 2,
        name: "artificial compliance",
        what: "A strip with joints across it, pulled below its strength. Joints that are there from the beginning soften it to E/(1 + E/(p h)), with p = α E/h; joints that are put in where \
               the strength is reached do not.",
        source: "springs in series",
        run: compliance::run,
    },
    Case {
        number: 3,
        name: "rotation",
        what: "A block that is led through a full turn has no strain. One that flies and spins freely for a turn keeps its energy and its momenta.",
        source: "objectivity and conservation",
        run: rotation::run,
    },
    Case {
        number: 4,
        name: "uniaxial tension",
        what: "A strip is pulled apart slowly. The traction peaks at the strength, one crack opens, and it dissipates the fracture energy times its area; with the customary critical opening, \
               3 G/f, it dissipates 1.159 G.",
        source: BOOK,
        run: tension::run,
    },
    Case {
        number: 5,
        name: "shear under normal stress",
        what: "A shear box: two blocks with one row of joints, pressed and sheared. The shear stress peaks at c + σₙ tan φ and falls to σₙ tan φ, which holds on when the broken joints \
               are left to contact; the work above that is the fracture energy of sliding times the area.",
        source: "Mohr and Coulomb",
        run: shear::run,
    },
    Case {
        number: 6,
        name: "impact",
        what: "Two triangles, and two discs of many elements, collide without friction and damping, in many orientations. What they have of energy and momentum before, they have after. \
               Where the contact is much softer than the bodies, that energy is kinetic.",
        source: BOOK,
        run: impact::run,
    },
    Case {
        number: 6,
        name: "heaps of fragments",
        what: "Four heaps of triangles, squares and hexagons collide and scatter, without friction and damping. The energy after is the energy before.",
        source: "A. Munjiza, The Combined Finite-Discrete Element Method (2004), p. 51",
        run: heaps::run,
    },
    Case {
        number: 6,
        name: "debris in the plane",
        what: "A square breaks in a box that is shaken, and its fragments strike each other again and again: at full size there are 200 000 breaks, and begins and ends of contacts. The \
               energy balance holds to 1e-4 all the while.",
        source: "conservation",
        run: debris::run,
    },
    Case {
        number: 7,
        name: "block on an incline",
        what: "Below the angle of friction the block rests; above it slides with a = g (sin θ − µ cos θ).",
        source: "Coulomb",
        run: incline::run,
    },
    Case {
        number: 7,
        name: "Hertz contact",
        what: "Half a disc is pressed on a rigid plane, without friction, in plane strain. Compared are load against approach, half-width and greatest pressure.",
        source: JOHNSON,
        run: hertz::run,
    },
    Case {
        number: 8,
        name: "Brazilian disc",
        what: "A disc between two platens that move alike. Before it breaks, the stress in its centre is that of an elastic disc under two point loads; it splits along the loaded diameter, \
               at the load that its tensile strength gives. Unstructured meshes; fracture energies of 3 and 30 J/m². The cohesion is high enough that it does not shear beneath the platens first.",
        source: "G. Hondros, Aust. J. Appl. Sci. 10 (1959) 243-268",
        run: brazilian::run,
    },
    Case {
        number: 9,
        name: "uniaxial compression",
        what: "A block twice as high as wide between platens without friction, on unstructured meshes. Its strength is that of Mohr and Coulomb, 2 c cos φ/(1 - sin φ), whatever the fracture \
               energy; pressure on its sides raises it by (1 + sin φ)/(1 - sin φ) times as much.",
        source: "Mohr and Coulomb",
        run: compression::run,
    },
    Case {
        number: 10,
        name: "double cantilever beam",
        what: "Two arms are peeled apart slowly. Load and opening follow the line of linear elastic fracture mechanics, with K = P (3.46 a + 2.38 h)/h^1.5.",
        source: "B. Gross and J. E. Srawley, NASA TN D-3295 (1966)",
        run: cantilever::run,
    },
    Case {
        number: 10,
        name: "free crack in tension",
        what: "A plate with a notch is pulled apart on unstructured meshes: the crack chooses its path along their edges. E G/f² is 3, 6 or 12 elements long; the meshes are by fdem, eight of each size, and by Gmsh. Its stress intensity at growth is that of the same crack on a \
               straight line, and it dissipates the fracture energy times its projected area, as if there were no mesh. The straight crack follows linear elastic fracture mechanics, \
               with the length of its process zone.",
        source: COHESIVE,
        run: free_crack::tension,
    },
    Case {
        number: 10,
        name: "free crack in bending",
        what: "The same plate as a beam on three points.",
        source: COHESIVE,
        run: free_crack::bending,
    },
    Case {
        number: 10,
        name: "free crack in shear",
        what: "A block with a closed notch under pressure is sheared on unstructured meshes until half of its ligament is broken. A free crack needs more than the same crack on a straight \
               line, because its sides are rough and interlock under the pressure; the bounds say how much more.",
        source: "Mohr and Coulomb",
        run: free_shear::run,
    },
    Case {
        number: 11,
        name: "thick ring",
        what: "A quarter of a ring under pressure inside, in plane stress, at rest. The growth of its inner radius is Lamé's, with an error of the order of the square of the elements' size.",
        source: "S. P. Timoshenko and J. N. Goodier, Theory of Elasticity (1970), 28",
        run: ring::run,
    },
    Case {
        number: 11,
        name: "plate with a hole",
        what: "A quarter of a plate with a circular hole under tension, at rest. Displacements and stresses along the edge of the hole are Kirsch's: three times the tension across it, and                as much pressure along it.",
        source: "S. P. Timoshenko and J. N. Goodier, Theory of Elasticity (1970), 35",
        run: hole::run,
    },
    Case {
        number: 12,
        name: "objectivity",
        what: "Two discs that meet off centre, under gravity and with friction. The whole model turned by any angle does the same, turned.",
        source: "objectivity",
        run: rotation::objectivity,
    },
    Case {
        number: 13,
        name: "oblique impact",
        what: "A disc strikes a rigid plane and slides all the while. Friction changes the tangential velocity by µ times the change of the normal one, and that of the rim about the middle by                twice as much.",
        source: "W. Goldsmith, Impact (1960), ch. II; moment of inertia m R²/2",
        run: disc::oblique_impact,
    },
    Case {
        number: 14,
        name: "disc on an incline",
        what: "Where tan θ is below 3 µ a disc rolls with a = 2/3 g sin θ. Above it slides with a = g (sin θ − µ cos θ), and its rim turns with 2 µ g cos θ.",
        source: "rigid body mechanics; moment of inertia m R²/2",
        run: disc::on_an_incline,
    },
    Case {
        number: 15,
        name: "rocking block",
        what: "A slender block on one of its corners is let go at a tilt θ. Below α, the angle of its diagonal, it falls back to its base after acosh(1/(1 − θ/α))/p, p² = 3 g/(4 R); above                it turns over.",
        source: "G. W. Housner, Bull. Seismol. Soc. Am. 53 (1963) 403-417",
        run: rocking::run,
    },
    Case {
        number: 16,
        name: "waves in bars of tetrahedra",
        what: "An end of a bar in uniaxial strain is moved for 20 µs. The wave travels at √(M/ρ), with the P-wave modulus M, and the force at the end is ρ c v A.",
        source: WAVES,
        run: space::bars::waves,
    },
    Case {
        number: 16,
        name: "bar of tetrahedra at rest",
        what: "A pressure of 5 MPa on the end of a bar shortens it by p L/E; its support bears p A.",
        source: "Hooke",
        run: space::bars::rest,
    },
    Case {
        number: 16,
        name: "rods of tetrahedra that meet",
        what: "Two equal rods (ν = 0) touch for 2 L/c, under the stress ρ c v/2.",
        source: WAVES,
        run: space::bars::meeting,
    },
    Case {
        number: 17,
        name: "rotation in space",
        what: "A block that is led through a full turn about any axis has no strain. One that spins freely about its middle axis of inertia turns over, and keeps its energy and its momenta.",
        source: "L. D. Landau and E. M. Lifshitz, Mechanics (1976), 37",
        run: space::rotation::run,
    },
    Case {
        number: 18,
        name: "impact of tetrahedra",
        what: "Two tetrahedra collide with a vertex, an edge or a face first, in orientations at random, without friction and damping; and the tests of the book. Energy and momenta after are those before.",
        source: BOOK,
        run: space::impact::run,
    },
    Case {
        number: 19,
        name: "debris",
        what: "A block of tetrahedra breaks in a box that is shaken, and its fragments strike each other again and again: at full size there are a million breaks, and begins and ends of \
               contacts. The energy balance holds to 1e-4 all the while.",
        source: "conservation",
        run: space::debris::run,
    },
    Case {
        number: 20,
        name: "block on an incline in space",
        what: "A block on a plane that is inclined towards any direction: below the angle of friction it rests, above it slides straight down with a = g (sin θ − µ cos θ).",
        source: "Coulomb",
        run: space::incline::run,
    },
    Case {
        number: 20,
        name: "Hertz contact in space",
        what: "An elastic sphere is pressed on an elastic block, without friction. Compared are load against approach, radius of the contact and greatest pressure.",
        source: JOHNSON,
        run: space::hertz::run,
    },
    Case {
        number: 21,
        name: "direct tension of a prism",
        what: "A prism with joints on one plane is pulled apart along a direction aslant to all axes. The traction peaks at the strength, and the crack dissipates the fracture energy times its area. Meshes that may break everywhere are told apart.",
        source: BOOK,
        run: space::tension::run,
    },
    Case {
        number: 22,
        name: "shear under normal stress in space",
        what: "Two flat blocks with joints between them are pressed and sheared along any direction of their plane. The shear stress peaks at c + σₙ tan φ, falls to σₙ tan φ, and follows the motion when its direction changes.",
        source: "Mohr and Coulomb",
        run: space::shear::run,
    },
    Case {
        number: 23,
        name: "penny-shaped crack",
        what: "A round crack in a large block under tension opens by 8 (1 - ν²) p √(a² - r²)/(π E).",
        source: "I. N. Sneddon, Proc. R. Soc. A 187 (1946) 229-260",
        run: space::penny::run,
    },
    Case {
        number: 24,
        name: "thick sphere",
        what: "An eighth of a thick sphere under pressure inside, at rest. Displacements and stresses are those of Lamé, with an error of the order of the square of the elements' size.",
        source: "S. P. Timoshenko and J. N. Goodier, Theory of Elasticity (1970), 136",
        run: space::sphere::run,
    },
    Case {
        number: 24,
        name: "hole through a block",
        what: "A quarter of a block with a circular hole under tension, in plane strain, at rest. Displacements and stresses along the edge of the hole are Kirsch's: three times the tension \
               across it, and as much pressure along it. So are the forces on its planes of symmetry. The error is of the order of the square of the elements' size.",
        source: "S. P. Timoshenko and J. N. Goodier, Theory of Elasticity (1970), 35",
        run: space::hole::run,
    },
    Case {
        number: 25,
        name: "absorbing faces",
        what: "Plane waves leave through absorbing faces, and a block under initial stress between them stays at rest.",
        source: "J. Lysmer and R. L. Kuhlemeyer, J. Eng. Mech. Div. 95 (1969) 859-877",
        run: space::waves::absorbing,
    },
    Case {
        number: 26,
        name: "spall",
        what: "A pulse of pressure with a fast rise to s and a linear fall over the length λ is reflected at the free end of a bar. The bar first breaks at λ f/(2 s) from that end.",
        source: "J. S. Rinehart, J. Appl. Phys. 23 (1952) 1229-1233",
        run: space::waves::spall,
    },
    Case {
        number: 27,
        name: "locking",
        what: "A prism of tetrahedra under the tractions of pure bending is too stiff by a factor that depends on Poisson's ratio and on the number of cells through its width. The expected values are those measured before: a change of the elements must not go unnoticed.",
        source: "S. P. Timoshenko and J. N. Goodier, Theory of Elasticity (1970), 102",
        run: space::locking::run,
    },
    Case {
        number: 28,
        name: "thick disc under two loads",
        what: "A disc half as thick as wide. Two strips of its surface bear a pressure. The tension in its centre is less than that of a thin disc in the middle plane and more at the faces, by an amount that is known.",
        source: "S. P. Timoshenko and J. N. Goodier, Theory of Elasticity (1970), 41 and 98; G. Hondros, Aust. J. Appl. Sci. 10 (1959) 243-268",
        run: space::disc::run,
    },
    Case {
        number: 29,
        name: "compression of a cylinder",
        what: "A cylinder twice as high as wide between platens without friction, on unstructured meshes. Its strength is that of Mohr and Coulomb, 2 c cos φ/(1 - sin φ).",
        source: "Mohr and Coulomb",
        run: space::compression::run,
    },
    Case {
        number: 30,
        name: "sphere through a plate",
        what: "A sphere of steel flies through a brittle plate that is held at two sides. The energy balance holds, the momentum of sphere and plate changes by the impulse of the supports, \
               and the sphere keeps less speed than a plug without resistance would leave it.",
        source: "conservation; R. F. Recht and T. W. Ipson, J. Appl. Mech. 30 (1963) 384-390",
        run: space::perforation::run,
    },
    Case {
        number: 31,
        name: "double cantilever in space",
        what: "The arms of a slit beam are pulled apart: their compliance, and the load under which the crack grows, at several of its lengths.",
        source: "beams with the turn and shear at the front of the crack: B. Gross and J. E. Srawley, NASA TN D-3295 (1966)",
        run: space::cantilever::run,
    },
    Case {
        number: 32,
        name: "strength of a thick disc",
        what: "The disc of case 28 splits between two narrow strips that move towards each other: its strength is that of the material.",
        source: "S. P. Timoshenko and J. N. Goodier, Theory of Elasticity (1970), 41",
        run: space::brazilian::run,
    },
    Case {
        number: 33,
        name: "ground at rest",
        what: "Ground under its weight, with horizontal stresses of K₀ times the vertical one and a tectonic stress, in the plane and in space. Nothing moves, and base and sides carry the weight and \
               the thrust.",
        source: "equilibrium of a layer",
        run: ground::rest,
    },
    Case {
        number: 34,
        name: "excavation",
        what: "A round hole is excavated from a plate under two different stresses, and the forces that the core held are released slowly. The hoop stress along the edge becomes Kirsch's.",
        source: "G. Kirsch, Z. VDI 42 (1898) 797–807",
        run: excavation::kirsch,
    },
    Case {
        number: 34,
        name: "sudden excavation",
        what: "A round hole is excavated at once from a plate under pressure. Its wall comes to rest at Lamé's displacement, and damping takes half of the released force times its way.",
        source: "M. D. G. Salamon, J. South. Afr. Inst. Min. Metall. 84 (1984) 74–86",
        run: excavation::sudden,
    },
    Case {
        number: 35,
        name: "direct shear of a joint set",
        what: "Two blocks with a joint of a joint set between them are sheared under three normal stresses. A line through the peaks gives cohesion and friction of the set, one through what is left its \
               residual friction.",
        source: "Mohr and Coulomb",
        run: ground::direct_shear,
    },
    Case {
        number: 36,
        name: "plane failure",
        what: "A block lies on a plane with cohesion and friction that dips. Gravity grows until it slides: then the factor of safety of limit equilibrium is 1.",
        source: "E. Hoek and J. W. Bray, Rock Slope Engineering (1981), ch. 7",
        run: ground::plane_failure,
    },
    Case {
        number: 37,
        name: "triaxial envelope",
        what: "Blocks of rock are crushed under four pressures on their sides. A line through the strengths has the slope and the intercept of Mohr and Coulomb.",
        source: "Mohr and Coulomb",
        run: compression::envelope,
    },
    Case {
        number: 38,
        name: "arch",
        what: "A semicircular arch of 32 voussoirs without mortar stands under its weight if it is thicker than 0.1075 of its mean radius, and falls if it is thinner.",
        source: "J. Heyman, Int. J. Solids Struct. 2 (1966) 249–279, after Couplet (1730) and Milankovitch (1907)",
        run: arch::run,
    },
    Case {
        number: 39,
        name: "waves in bedded rock",
        what: "Plane waves of pressure and of shear travel along and across the bedding of a transversely isotropic rock, in the plane and in space, each at the speed of its constant.",
        source: "S. G. Lekhnitskii, Theory of Elasticity of an Anisotropic Body (1963)",
        run: bedding::waves,
    },
    Case {
        number: 39,
        name: "compression of bedded rock",
        what: "Blocks whose bedding dips by 0 to 90 degrees are crushed. Cohesion and tensile strength grow linearly with the angle to the bedding. The strength is the least of all planes: a curve                like a U, with its least where the bedding dips as Mohr and Coulomb's plane. Jaeger's plane of weakness is the case of a strength that jumps.",
        source: "J. C. Jaeger, Geol. Mag. 97 (1960) 65-72; A. Lisjak, G. Grasselli and T. Vietor, Int. J. Rock Mech. Min. Sci. 65 (2014) 96-115",
        run: bedding::compression,
    },
    Case {
        number: 40,
        name: "pressure in a line crack",
        what: "A crack in the middle of a plate, in plane strain, under the pressure of a cavity, at rest. It opens by 4 p √(l² - x²)/E', extrapolated from elements of two sizes; the work is the pressure times                the volume.",
        source: "I. N. Sneddon, Proc. R. Soc. A 187 (1946) 229-260",
        run: cavity::line,
    },
    Case {
        number: 40,
        name: "pressure in a penny-shaped crack",
        what: "The same in space: the crack opens by 8 (1 - ν²) p √(a² - r²)/(π E).",
        source: "I. N. Sneddon, Proc. R. Soc. A 187 (1946) 229-260",
        run: space::cavity::penny,
    },
    Case {
        number: 40,
        name: "gas in a hole",
        what: "A gas in the hole of a plate that swings: p V^γ does not change, and the gas has lost the work that it has done.",
        source: "energy of a gas without exchange of heat, p V/(γ - 1)",
        run: cavity::gas,
    },
    Case {
        number: 41,
        name: "free crack in space, in tension",
        what: "A notched plate of tetrahedra, in plane strain, is pulled until it is in two. Its crack chooses its surface along the faces. It grows at the K of the same crack on a flat joint set, and dissipates \
               the fracture energy times its projected area, though sliding costs ten times as much as opening. Meshes of fdem and, at full size, one of Gmsh.",
        source: COHESIVE,
        run: space::free_crack::tension,
    },
    Case {
        number: 41,
        name: "free crack in space, in bending",
        what: "The same plate as a beam on three lines.",
        source: COHESIVE,
        run: space::free_crack::bending,
    },
    Case {
        number: 41,
        name: "free crack in space, turning",
        what: "A plate whose notch is turned by 30 degrees about the direction of growth is pulled: the notch opens and slides along its front (modes I and III). The crack turns as it grows until it lies across \
               the load, and dissipates the fracture energy times its projected area.",
        source: "largest tension at the front: E. Sommer, Eng. Fract. Mech. 1 (1969) 539-546",
        run: space::free_crack::turning,
    },
    Case {
        number: 42,
        name: "rigid body that tumbles",
        what: "A free rigid box spins nearly about its middle axis, and turns over again and again, with the period of the elliptic functions; its kinetic energy stays.",
        source: "L. D. Landau and E. M. Lifshitz, Mechanics (1976), 37",
        run: space::rigid::tumbles,
    },
    Case {
        number: 42,
        name: "rigid cube on a plane",
        what: "At rest a rigid cube sinks into a rigid plane by its weight over the stiffness of the contact, and does not turn. On a slope it rests below the angle of friction, and slides above with a = g (sin θ − µ cos θ).",
        source: "Coulomb; potentials of flush faces",
        run: space::rigid::on_a_plane,
    },
    Case {
        number: 42,
        name: "rigid cubes that collide",
        what: "Pairs of rigid cubes meet in random orientations without friction and damping. Energy and momentum are the same before and after.",
        source: "conservation",
        run: space::rigid::collisions,
    },
    Case {
        number: 42,
        name: "tower of rigid cubes",
        what: "Ten rigid cubes stand on each other on a rigid plate. Tower and plate exchange the weight, the tower sinks by the sum of the elastic depths, does not lean, and comes to rest.",
        source: "statics; potentials of flush faces",
        run: space::tower::run,
    },
    Case {
        number: 42,
        name: "rigid as the limit of stiff",
        what: "A heap of 50 blocks that fall is the same, whether the blocks are rigid or a hundred times as stiff as their contacts.",
        source: "the limit of stiffness",
        run: rigid_heap::run,
    },
    Case {
        number: 42,
        name: "rigid wall of many faces",
        what: "A rigid block lands on a rigid wall and slides. It does the same on a wall whose face is cut into two triangles and on one of many: to rounding at the same depth, to the depth of the contact after a landing.",
        source: "the plane",
        run: space::rigid_wall::run,
    },
];

/// All cases, in the order of the ladder.
pub fn cases() -> &'static [Case] {
    static CASES: LazyLock<Vec<Case>> = LazyLock::new(|| [BODIES, GRAINS, FLUID].concat());
    &CASES
}
