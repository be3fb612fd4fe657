//! One run on many ranks, with the results of one.
//!
//! Each rank owns nodes, and has every element, joint and couple that acts on them. It computes these exactly
//! as their other owners do, and adds up the forces on its nodes in the order of the whole model. Therefore
//! only motions of nodes travel, once a step; where joints are inserted or break, the owner of a vertex also
//! sends how it has come apart. Energies are exact sums (`sum.rs`), which do not depend on who adds them up.
//!
//! A [`Simulation`](crate::Simulation) on a rank is one of a part of the model, with local numbers in the
//! order of those of the whole model. `links.rs` has the messages of a step. `spread.rs` divides the nodes
//! among ranks, and gives each rank its elements: at the beginning, when elements may have come near those of
//! other ranks, and when the work is not even. `piece.rs` has the transferred data, and `assemble.rs` makes a
//! part of it. `gather.rs` has the whole for results and checkpoints, and `separated.rs`
//! joints whose two sides are on different ranks. `forecast.rs` predicts all this for a
//! number of ranks, without them.

mod assemble;
pub(crate) mod distributed;
pub(crate) mod forecast;
pub(crate) mod gather;
pub(crate) mod leader;
pub(crate) mod links;
pub(crate) mod part;
mod piece;
mod separated;
mod spread;
