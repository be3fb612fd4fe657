//! The cases of spheres and walls.

use super::{
    adhesion, chain, collapse, conservation, hopper, impacts, oblique, rolling, round_robin, silo, walls,
};
use crate::outcome::Case;

const CHUNG: &str = "Y. C. Chung and J. Y. Ooi, Granular Matter 13 (2011) 643-656";
const ROLLING: &str = "J. Ai, J.-F. Chen, J. M. Rotter and J. Y. Ooi, Powder Technology 206 (2011) 269-282";

/// All cases of spheres and walls. `fdem validate grains` chooses them by their names.
pub(crate) const GRAINS: &[Case] = &[
    Case {
        number: 43,
        name: "grains: elastic impact",
        what: "Two spheres meet, and a sphere meets a rigid plane, along the normal. Largest force, overlap and duration are Hertz's. Tests 1 and 2 of Chung and Ooi.",
        source: CHUNG,
        run: impacts::elastic,
    },
    Case {
        number: 43,
        name: "grains: restitution",
        what: "A sphere meets a plane along the normal, with forces that cannot pull. The speed after over that before is the coefficient of restitution, with the laws of Hertz and of Hooke. Test 3 of Chung and Ooi.",
        source: CHUNG,
        run: impacts::restitution,
    },
    Case {
        number: 43,
        name: "grains: oblique impact",
        what: "Spheres with friction meet a plane or each other at angles and with spins. Where they slide, friction is a force of the size µ F at the distance of the contact from the centre; where they stick for some time, the published curves are compared. Tests 4 to 8 of Chung and Ooi.",
        source: CHUNG,
        run: oblique::run,
    },
    Case {
        number: 43,
        name: "grains: energy of an oblique impact",
        what: "Elastic impacts at all angles do not gain energy: the force across the normal falls with the contact. At 76 degrees and with the friction 0.5 it loses the work of sliding.",
        source: "C. Thornton, S. J. Cummins and P. W. Cleary, Powder Technology 233 (2013) 30-46",
        run: oblique::energies,
    },
    Case {
        number: 44,
        name: "grains: rest on a plane",
        what: "A sphere falls on a plane and comes to rest. Its force is its weight, and its overlap that of Hertz.",
        source: "K. L. Johnson, Contact Mechanics (1985), 4.2",
        run: impacts::rest,
    },
    Case {
        number: 44,
        name: "grains: rolling to rest",
        what: "A sphere rolls on a plane with a rolling friction of 0.1. It slows down by 5/7 µ g, and stays where it has stopped.",
        source: ROLLING,
        run: rolling::to_rest,
    },
    Case {
        number: 44,
        name: "grains: sphere on a slope",
        what: "A sphere rests where the tangent of the slope is below both coefficients, of friction and of rolling friction. Otherwise it slides or rolls as a rigid body does.",
        source: ROLLING,
        run: rolling::on_a_slope,
    },
    Case {
        number: 44,
        name: "grains: sliding to rolling",
        what: "A sphere slides on a plane and rolls from the time 2 v/(7 µ g) on, with 5/7 of its speed.",
        source: "rigid body mechanics; moment of inertia 2 m R²/5",
        run: rolling::slide_to_roll,
    },
    Case {
        number: 44,
        name: "grains: twisting to rest",
        what: "A sphere that spins about the normal slows down by 5/2 µ g/R, and stays at rest.",
        source: ROLLING,
        run: rolling::twisting,
    },
    Case {
        number: 44,
        name: "grains: sphere in a turning tube",
        what: "A tube that turns lifts a sphere to the angle at which its weight overcomes rolling friction, or friction.",
        source: "rigid body mechanics",
        run: walls::tube,
    },
    Case {
        number: 44,
        name: "grains: walls of triangles and discs",
        what: "Spheres roll, slide, fall and bounce on a wall of coplanar triangles, over edges and corners, and on a disc. They do the same as on a plane, to rounding.",
        source: "the plane",
        run: walls::of_triangles,
    },
    Case {
        number: 44,
        name: "grains: sphere in a cone",
        what: "A sphere rolls down the inside of a cone with 5/7 g sin θ, straight to its vertex.",
        source: "rigid body mechanics; moment of inertia 2 m R²/5",
        run: walls::cone,
    },
    Case {
        number: 45,
        name: "grains: adhesion",
        what: "Two soft spheres are led together and apart. They jump into contact at the overlap 0, and part beyond it; the largest pull is 3/2 π w R.",
        source: "K. L. Johnson, K. Kendall and A. D. Roberts, Proc. R. Soc. A 324 (1971) 301-313",
        run: adhesion::run,
    },
    Case {
        number: 45,
        name: "grains: chain of spheres",
        what: "A chain of spheres under pressure swings with the frequencies of equal masses and springs, whose stiffness is Hertz's. A column of ten spheres at rest transmits their weights.",
        source: "V. F. Nesterenko, Dynamics of Heterogeneous Materials (2001), ch. 1",
        run: chain::run,
    },
    Case {
        number: 46,
        name: "grains: conservation",
        what: "Spheres that collide keep their momentum and, without damping, their energy. In a collapse the weight loses what is dissipated, stored and moved. The results are the same for all numbers of threads, and after a saved state.",
        source: "conservation",
        run: conservation::run,
    },
    Case {
        number: 47,
        name: "grains: column collapse",
        what: "A column of spheres collapses on a plane: its reach follows from its height over its radius. Rolling friction makes the deposit steeper.",
        source: "G. Lube, H. E. Huppert, R. S. J. Sparks and M. A. Hallworth, J. Fluid Mech. 508 (2004) 175-199; Y. C. Zhou, B. H. Xu, A. B. Yu and P. Zulli, Phys. Rev. E 64 (2001) 021301",
        run: collapse::run,
    },
    Case {
        number: 47,
        name: "grains: pressure in a silo",
        what: "Walls with friction bear a part of the weight in a silo whose bottom sinks a little. The ratio of the pressures, found with a bed as high as wide, gives the load on the bottom of a higher one.",
        source: "H. A. Janssen, Z. Ver. Dtsch. Ing. 39 (1895) 1045-1049",
        run: silo::run,
    },
    Case {
        number: 47,
        name: "grains: hopper",
        what: "A hopper empties through its cone, somewhat faster than through a hole in a flat bottom, and as fast with half of the time step.",
        source: "W. A. Beverloo, H. A. Leniger and J. van de Velde, Chem. Eng. Sci. 15 (1961) 260-269",
        run: hopper::run,
    },
    Case {
        number: 48,
        name: "grains: round robin",
        what: "The three cases of a comparison of codes, with its data beside the project: pairs and overlaps of its bed, the time of the first impact, and results at two time steps.",
        source: "M. Dosta et al., Comput. Phys. Commun. 296 (2024) 109066",
        run: round_robin::run,
    },
];
