//! The cases of fluid in cracks.

use super::{breakdown, flow, invariants, kgd, penny, walls};
use crate::outcome::Case;

const KGD: &str = "A. P. Bunger, E. Detournay and D. I. Garagash, Int. J. Fracture 134 (2005) 175-190; J. I. Adachi and E. Detournay, Int. J. Numer. Anal. Meth. Geomech. 26 (2002) 579-604";

const SAVITSKI: &str = "A. A. Savitski and E. Detournay, Int. J. Solids Struct. 39 (2002) 6311-6337";

/// All cases of fluid in cracks. `fdem validate fluid` chooses them by their names.
pub(crate) const FLUID: &[Case] = &[
    Case {
        number: 49,
        name: "fluid: steady flow",
        what: "Flow between rigid walls: a chain of cells, two apertures in series, and four branches that cross.",
        source: "P. A. Witherspoon et al., Water Resour. Res. 16 (1980) 1016-1024",
        run: flow::steady,
    },
    Case {
        number: 49,
        name: "fluid: transient flow",
        what: "A step of the pressure that spreads by diffusion, the front in an empty crack at a constant rate, and flow away from a point.",
        source: "J. Crank, The Mathematics of Diffusion (1975), 3.3; continuity",
        run: flow::transient,
    },
    Case {
        number: 49,
        name: "fluid: leak-off",
        what: "Carter's leak-off from cells with rigid walls, in steps of any size.",
        source: "R. D. Carter, appendix of G. C. Howard and C. R. Fast, Drill. Prod. Pract. API (1957) 261-270",
        run: flow::leak_off,
    },
    Case {
        number: 50,
        name: "fluid: line crack",
        what: "A fluid at a constant pressure opens a crack in a plate of ten times its length by 4 p √(l² - x²)/E', without elements' size.",
        source: "I. N. Sneddon, Proc. R. Soc. A 187 (1946) 229-260",
        run: walls::line,
    },
    Case {
        number: 50,
        name: "fluid: hole under pressure",
        what: "A fluid in a hole makes it larger as Lamé says, and leaves it as it is where its pressure is that of the ground.",
        source: "S. P. Timoshenko and J. N. Goodier, Theory of Elasticity (1970), 28",
        run: walls::hole,
    },
    Case {
        number: 50,
        name: "fluid: breakdown of a borehole",
        what: "A fluid is pumped into a hole in ground under two stresses, with one pressure in the hole and its cracks, and ten elements in the zone of softening. Its largest pressure until cracks run away is 3 σ_h - σ_H + f.",
        source: "B. Haimson and C. Fairhurst, Soc. Petrol. Eng. J. 7 (1967) 310-318",
        run: breakdown::run,
    },
    Case {
        number: 51,
        name: "fluid: plane crack, toughness",
        what: "A fluid of low viscosity drives a crack along a straight line through a large plate in plane strain, for 10 s with scaled masses. Length, opening and pressure at the source are those of linear elastic fracture mechanics: worst values in the middle third of the time.",
        source: KGD,
        run: kgd::toughness,
    },
    Case {
        number: 51,
        name: "fluid: plane crack, viscosity",
        what: "The same where the work of the flow is far above that of fracture, with an empty tip of the size of an element.",
        source: KGD,
        run: kgd::viscosity,
    },
    Case {
        number: 51,
        name: "fluid: plane crack, leak-off",
        what: "The plane crack in the toughness regime, of which some 40 % of the fluid leaks off.",
        source: "balance of the volume, with the crack of linear elastic fracture mechanics and Carter's leak-off",
        run: kgd::leak_off,
    },
    Case {
        number: 51,
        name: "fluid: free crack",
        what: "The plane crack in the toughness regime on unstructured meshes, along whose edges it chooses its path.",
        source: KGD,
        run: kgd::free,
    },
    Case {
        number: 52,
        name: "fluid: round crack, toughness",
        what: "A fluid of low viscosity drives a round crack on a plane through a large block, for 10 s with scaled masses. Radius, opening and pressure are those of linear elastic fracture mechanics.",
        source: SAVITSKI,
        run: penny::toughness,
    },
    Case {
        number: 52,
        name: "fluid: round crack, viscosity",
        what: "The same where the work of the flow is far above that of fracture.",
        source: SAVITSKI,
        run: penny::viscosity,
    },
    Case {
        number: 53,
        name: "fluid: invariants",
        what: "A crack that a fluid drives is the same to the last bit on one thread and on two, and after a saved state; without injection it is that of a run without fluid.",
        source: "determinism",
        run: invariants::run,
    },
];
