//! Recognises the format of a mesh file.

use crate::foreign::BYTE_ORDER_MARK;
use crate::mesh::cursor;
use crate::mesh::format::MeshFormat;
use crate::mesh::{stl, triangles};

impl MeshFormat {
    /// The format by the content of a file, otherwise by its extension; `None` if neither is that of a mesh.
    ///
    /// # Cost
    /// Reads the first lines only.
    pub fn of(bytes: &[u8], name: &str) -> Option<Self> {
        let bytes = bytes.strip_prefix(BYTE_ORDER_MARK).unwrap_or(bytes);
        by_content(bytes).or_else(|| by_name(name))
    }
}

fn by_name(name: &str) -> Option<MeshFormat> {
    let extension = name.rsplit_once('.')?.1.to_ascii_lowercase();
    Some(match extension.as_str() {
        "msh" => MeshFormat::Gmsh,
        "stl" => MeshFormat::Stl,
        "obj" => MeshFormat::Obj,
        "ply" => MeshFormat::Ply,
        "vtk" => MeshFormat::Vtk,
        "vtu" | "vtp" => MeshFormat::VtkXml,
        "inp" => MeshFormat::Abaqus,
        _ => return None,
    })
}

/// Number of bytes of leading comments that are searched for the first significant line.
const HEAD: usize = 1 << 16;

fn by_content(bytes: &[u8]) -> Option<MeshFormat> {
    if stl::is_binary(bytes) {
        return Some(MeshFormat::Stl);
    }
    let head = &bytes[..bytes.len().min(HEAD)];
    let mut lines = head.split(|&byte| byte == b'\n').map(<[u8]>::trim_ascii).filter(|line| !line.is_empty());
    let first = lines.clone().next()?;
    let starts = |word: &[u8]| first.len() >= word.len() && first[..word.len()].eq_ignore_ascii_case(word);
    if triangles::is_header(first) {
        return Some(MeshFormat::Triangles);
    }
    if first == b"ply" {
        return Some(MeshFormat::Ply);
    }
    if starts(b"# vtk DataFile") {
        return Some(MeshFormat::Vtk);
    }
    if starts(b"<?xml") || starts(b"<VTKFile") || starts(b"<!--") {
        return memchr::memmem::find(head, b"<VTKFile").map(|_| MeshFormat::VtkXml);
    }
    if starts(b"$") {
        let sections = [&b"$MeshFormat"[..], b"$NOD", b"$Comments", b"$PhysicalNames"];
        return sections.contains(&first).then_some(MeshFormat::Gmsh);
    }
    if starts(b"solid") && first.get(5).is_none_or(u8::is_ascii_whitespace) {
        let next = lines.nth(1).unwrap_or(b"");
        let facet = |line: &[u8]| {
            ["facet", "endsolid"].iter().any(|word| line.to_ascii_lowercase().starts_with(word.as_bytes()))
        };
        return (next.is_empty() || facet(next)).then_some(MeshFormat::Stl);
    }
    if starts(b"*") {
        let keyword = lines.find(|line| !line.starts_with(b"**"))?;
        let letter = keyword.get(1).is_some_and(u8::is_ascii_alphabetic);
        return (keyword.starts_with(b"*") && letter).then_some(MeshFormat::Abaqus);
    }
    let statement = |line: &[u8]| {
        let mut words = cursor::words(line);
        words.next() == Some(b"v")
            && words.by_ref().take(3).filter(|word| cursor::float(word).is_ok()).count() == 3
    };
    let keywords = [&b"mtllib"[..], b"o", b"g", b"v", b"vn", b"vt", b"usemtl", b"s"];
    let first = lines.clone().find(|line| !line.starts_with(b"#"))?;
    let keyword = cursor::words(first).next()?;
    (keywords.contains(&keyword) && lines.any(statement)).then_some(MeshFormat::Obj)
}
