//! Stages in which fluids are there, and in which injections and surfaces of pores act.

use std::ops::Range;

use crate::text::document::{Document, Table};
use crate::text::fault::{Fault, suggestion};
use crate::text::file::ModelFile;

/// The number of the stage that a key `from_stage` names, the first without the key; `None` if no stage has
/// the name.
pub(crate) fn first_stage(file: &ModelFile, from_stage: Option<&str>) -> Option<usize> {
    from_stage.map_or(Some(0), |name| file.stage.iter().position(|stage| stage.name == name))
}

/// Reports a key `from_stage` of a table that names no stage.
pub(crate) fn check_from_stage(
    file: &ModelFile,
    table: Table,
    from_stage: Option<&str>,
    document: &Document<'_>,
    faults: &mut Vec<Fault>,
) {
    if let (Some(name), None) = (from_stage, first_stage(file, from_stage)) {
        faults.push(unknown(file, name, document.value(table, "from_stage")));
    }
}

/// A stage that is named and that is not there.
fn unknown(file: &ModelFile, name: &str, span: Range<usize>) -> Fault {
    let names: Vec<&str> = file.stage.iter().map(|stage| stage.name.as_str()).collect();
    Fault::at(span, format!("there is no stage \"{name}\"")).label("unknown stage").help(suggestion(
        name,
        &names,
        "[[stage]]",
    ))
}

/// Whether things act in a stage, by its number, of a fluid that is there from the stage `first` on; `None`
/// before it. `all`: the names of the stages in which each acts, all of them without names.
pub(crate) fn act<'a>(
    file: &ModelFile,
    first: Option<usize>,
    stage: usize,
    all: impl Iterator<Item = Option<&'a [String]>>,
) -> Option<Vec<bool>> {
    first.filter(|first| *first <= stage)?;
    let name = &file.stage[stage].name;
    Some(all.map(|stages| stages.is_none_or(|stages| stages.contains(name))).collect())
}

/// The stages in which an injection or a surface of pores acts.
pub(crate) struct Times<'a> {
    pub(crate) table: Table,
    /// "[[injection]] "name"".
    pub(crate) title: &'a str,
    pub(crate) stages: Option<&'a [String]>,
    /// The table whose `from_stage` says where it can begin: "[fluid]".
    pub(crate) begin: &'static str,
}

impl Times<'_> {
    /// Reports unknown stages, and those before the `first` one in which it can act.
    pub(crate) fn check(
        &self,
        file: &ModelFile,
        first: Option<usize>,
        document: &Document<'_>,
        faults: &mut Vec<Fault>,
    ) {
        let &Self { table, title, stages, begin } = self;
        for (entry, name) in stages.iter().copied().flatten().enumerate() {
            let span = document.entry(table, "stages", entry);
            match file.stage.iter().position(|stage| stage.name == *name) {
                None => faults.push(unknown(file, name, span)),
                Some(stage) if first.is_some_and(|first| stage < first) => faults.push(
                    Fault::at(span, format!("{title}: {begin} begins after the stage \"{name}\""))
                        .label("too early")
                        .help(format!("name a later stage, or an earlier one in from_stage of {begin}")),
                ),
                Some(_) => {}
            }
        }
        if stages.is_some_and(<[_]>::is_empty) {
            let message = format!("{title} acts in no stage");
            faults.push(Fault::at(document.value(table, "stages"), message).label("empty"));
        }
    }
}
