//! The list of files by time.

use std::fmt::Write;

use super::appended::escaped;

/// Makes a ParaView collection from times, in s, and the names of the files of these times relative to the
/// collection.
///
/// It is written again whenever a file is added: it is short, so the moment in which it does not exist is
/// short too.
///
/// # Example
/// ```
/// let collection = fdem_io::pvd([(0.0, "mesh_0000.vtu"), (0.25, "mesh_0001.vtu")]);
/// assert!(collection.contains(r#"<DataSet timestep="0.25" part="0" file="mesh_0001.vtu"/>"#));
/// ```
pub fn pvd<'a>(files: impl IntoIterator<Item = (f64, &'a str)>) -> String {
    let mut text = String::from(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\" byte_order=\"LittleEndian\">\n<Collection>\n",
    );
    for (time, file) in files {
        let file = escaped(file);
        // Writing to a string cannot fail.
        let _ = writeln!(text, "<DataSet timestep=\"{time}\" part=\"0\" file=\"{file}\"/>");
    }
    text + "</Collection>\n</VTKFile>\n"
}
