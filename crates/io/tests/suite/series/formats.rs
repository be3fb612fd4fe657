//! One packing of three spheres in every format.

use std::io::{Cursor, Write};

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use fdem_io::PackingFormat;

pub(crate) const CENTRES: [[f64; 3]; 3] = [[0.5, 1.0, 1.5], [2.0, 2.25, 2.5], [3.0, -1.0, 0.0]];
pub(crate) const RADII: [f64; 3] = [0.5, 0.25, 1.0];

/// The text formats.
pub(crate) const FILES: [(PackingFormat, &str); 11] = [
    (PackingFormat::Text, "x,y,z,radius\n0.5,1,1.5,0.5\n2,2.25,2.5,0.25\n3,-1,0,1\n"),
    (PackingFormat::Text, "#format x_y_z_r_matId\n0.5 1 1.5 0.5 1\n2 2.25 2.5 0.25 1\n3 -1 0 1 1\n"),
    (
        PackingFormat::LammpsDump,
        "ITEM: TIMESTEP\n10\nITEM: NUMBER OF ATOMS\n3\nITEM: BOX BOUNDS pp ff pp\n0 4\n-2 2\n0 4\nITEM: ATOMS id type x y z radius\n\
         1 1 0.5 1 1.5 0.5\n2 1 2 2.25 2.5 0.25\n3 1 3 -1 0 1\n",
    ),
    (
        PackingFormat::LammpsDump,
        "ITEM: TIMESTEP\n10\nITEM: NUMBER OF ATOMS\n3\nITEM: BOX BOUNDS xy xz yz pp ff pp\n0 6 2\n0 4 0\n0 4 0\nITEM: ATOMS id xs ys zs diameter\n\
         1 0 0.25 0.375 1\n2 0.21875 0.5625 0.625 0.5\n3 0.875 -0.25 0 2\n",
    ),
    (
        PackingFormat::LammpsData,
        "a title\n\n3 atoms\n1 atom types\n\n0 4 xlo xhi\n-2 2 ylo yhi\n0 4 zlo zhi\n\nAtoms # sphere\n\n\
         1 1 1 2500 0.5 1 1.5\n2 1 0.5 2500 2 2.25 2.5\n3 1 2 2500 3 -1 0\n",
    ),
    (
        PackingFormat::Xyz,
        "3\nProperties=species:S:1:pos:R:3:radius:R:1 Lattice=\"4 0 0 0 4 0 0 0 4\" pbc=\"T F T\" Time=0.5\n\
         Si 0.5 1 1.5 0.5\nSi 2 2.25 2.5 0.25\nSi 3 -1 0 1\n",
    ),
    (
        PackingFormat::Mercury,
        "3 0.5 0 -2 0 4 2 4\n0.5 1 1.5 0 0 0 0.5 0 0 0 0 0 0 0\n2 2.25 2.5 0 0 0 0.25 0 0 0 0 0 0 0\n3 -1 0 0 0 0 1 0 0 0 0 0 0 0\n",
    ),
    (
        PackingFormat::Vtk,
        "# vtk DataFile Version 3.0\ntitle\nASCII\nDATASET POLYDATA\nFIELD FieldData 1\nTIME 1 1 double\n2.5\nPOINTS 3 double\n\
         0.5 1 1.5 2 2.25 2.5 3 -1 0\nVERTICES 3 6\n1 0 1 1 1 2\nPOINT_DATA 3\nVECTORS velocity float\n0 0 0 0 0 0 0 0 0\nSCALARS radius double 1\n\
         LOOKUP_TABLE default\n0.5 0.25 1\n",
    ),
    (
        PackingFormat::Vtk,
        "# vtk DataFile Version 5.1\ntitle\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 3 float\n0.5 1 1.5 2 2.25 2.5 3 -1 0\nCELLS 4 3\n\
         OFFSETS vtktypeint64\n0 1 2 3\nCONNECTIVITY vtktypeint64\n0 1 2\nCELL_TYPES 3\n1 1 1\nPOINT_DATA 3\nFIELD FieldData 2\n\
         velocity 3 3 double\n0 0 0 0 0 0 0 0 0\nradius 1 3 double\n0.5\n0.25\n1\n",
    ),
    (
        PackingFormat::VtkXml,
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"LittleEndian\">\n<PolyData>\n\
         <Piece NumberOfPoints=\"1\" NumberOfVerts=\"1\"><Points><DataArray type=\"Float64\" NumberOfComponents=\"3\">0.5 1 1.5</DataArray></Points>\
         <Verts><DataArray type=\"Int32\" Name=\"connectivity\">0</DataArray><DataArray type=\"Int32\" Name=\"offsets\">1</DataArray></Verts>\
         <PointData><DataArray type=\"Float32\" Name=\"Radius\">0.5</DataArray></PointData></Piece>\n\
         <Piece NumberOfPoints=\"2\"><Points><DataArray type=\"Float64\" NumberOfComponents=\"3\">2 2.25 2.5 3 -1 0</DataArray></Points>\
         <PointData><DataArray type=\"Float32\" Name=\"Radius\">0.25 1</DataArray></PointData></Piece>\n</PolyData>\n</VTKFile>\n",
    ),
    (
        PackingFormat::VtkXml,
        "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\">\n<UnstructuredGrid>\n\
         <Piece NumberOfPoints=\"3\" NumberOfCells=\"0\"><Points><DataArray type=\"Float64\" NumberOfComponents=\"3\">0.5 1 1.5 2 2.25 2.5 3 -1 0\
         </DataArray></Points><Cells><DataArray type=\"Int32\" Name=\"connectivity\"/><DataArray type=\"Int32\" Name=\"offsets\"/>\
         <DataArray type=\"UInt8\" Name=\"types\"/></Cells><PointData><DataArray type=\"Float64\" Name=\"diameter\">1 0.5 2</DataArray></PointData></Piece>\n\
         </UnstructuredGrid>\n</VTKFile>\n",
    ),
];

/// VTU files as bytes: in base64, appended raw, and compressed with zlib.
pub(crate) fn vtu() -> Vec<(&'static str, Vec<u8>)> {
    let bytes = |values: &[f64]| values.iter().flat_map(|value| value.to_le_bytes()).collect::<Vec<u8>>();
    let arrays = [bytes(&CENTRES.concat()), bytes(&RADII)];
    let with_length = |data: &[u8]| [&(data.len() as u32).to_le_bytes(), data].concat();
    let packed = |data: &[u8]| {
        let mut encoder = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::default());
        encoder.write_all(data).unwrap();
        let block = encoder.finish().unwrap();
        let head = [1, data.len() as u32, 0, block.len() as u32].map(u32::to_le_bytes).concat();
        (head, block)
    };
    let file = |compressor: &str, arrays: [(String, String); 2], appended: &[u8]| {
        let [(points, points_data), (radii, radii_data)] = arrays;
        let start = format!(
            "<VTKFile type=\"UnstructuredGrid\" version=\"0.1\" byte_order=\"LittleEndian\"{compressor}><UnstructuredGrid>\n\
             <Piece NumberOfPoints=\"3\" NumberOfCells=\"0\"><Points><DataArray type=\"Float64\" NumberOfComponents=\"3\" {points}>{points_data}</DataArray></Points>\
             <PointData><DataArray type=\"Float64\" Name=\"radius\" {radii}>{radii_data}</DataArray></PointData></Piece></UnstructuredGrid>\n"
        );
        let data = if appended.is_empty() {
            Vec::new()
        } else {
            [b"<AppendedData encoding=\"raw\">_", appended, b"</AppendedData>"].concat()
        };
        [start.as_bytes(), &data, b"</VTKFile>\n"].concat()
    };
    let binary = |text: String| ("format=\"binary\"".to_owned(), text);
    let inline = file("", arrays.each_ref().map(|data| binary(STANDARD.encode(with_length(data)))), b"");
    let zlib = arrays.each_ref().map(|data| {
        let (head, block) = packed(data);
        binary(STANDARD.encode(head) + &STANDARD.encode(block))
    });
    let zlib = file(" compressor=\"vtkZLibDataCompressor\"", zlib, b"");
    let blocks = arrays.each_ref().map(|data| with_length(data));
    let at = |offset: usize| (format!("format=\"appended\" offset=\"{offset}\""), String::new());
    let appended = file("", [at(0), at(blocks[0].len())], &blocks.concat());
    vec![("base64", inline), ("zlib", zlib), ("appended", appended)]
}

/// An archive of arrays: name, values, columns (1 for an array of one axis).
pub(crate) fn npz(arrays: &[(&str, &[f64], usize)]) -> Vec<u8> {
    let mut archive = zip::ZipWriter::new(Cursor::new(Vec::new()));
    for (at, (name, values, width)) in arrays.iter().enumerate() {
        let method = [zip::CompressionMethod::Stored, zip::CompressionMethod::Deflated][at % 2];
        let options = zip::write::SimpleFileOptions::default().compression_method(method);
        archive.start_file(format!("{name}.npy"), options).unwrap();
        let rows = values.len() / width;
        let shape = if *width == 1 { format!("({rows},)") } else { format!("({rows}, {width})") };
        let header = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}, }}\n");
        archive.write_all(b"\x93NUMPY\x01\x00").unwrap();
        archive.write_all(&(header.len() as u16).to_le_bytes()).unwrap();
        archive.write_all(header.as_bytes()).unwrap();
        for value in *values {
            archive.write_all(&value.to_le_bytes()).unwrap();
        }
    }
    archive.finish().unwrap().into_inner()
}

pub(crate) fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::default());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}

pub(crate) fn zstd(bytes: &[u8]) -> Vec<u8> {
    ruzstd::encoding::compress_to_vec(bytes, ruzstd::encoding::CompressionLevel::Fastest)
}
