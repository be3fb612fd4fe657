//! Which file is of which instant.

use std::fmt::Write;

/// A collection for ParaView: the times, s, and the files that are of them, as they are called from where the collection will be.
///
/// Written whole again whenever a file is added: it is short, and so is the moment in which there is none.
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
        let file =
            file.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;");
        // Writing to a string does not fail.
        let _ = writeln!(text, "<DataSet timestep=\"{time}\" part=\"0\" file=\"{file}\"/>");
    }
    text + "</Collection>\n</VTKFile>\n"
}
