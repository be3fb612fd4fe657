//! Collections of ParaView: files that list files.

use std::collections::BTreeMap;
use std::sync::atomic::AtomicU64;

use fdem_io::{Centres, Packing, PieceFile, PieceFiles, ReadError, ReadOptions, Series};

/// Files by their names, without folders. The collection itself is `a`.
#[derive(Debug, Default)]
struct Files(BTreeMap<&'static str, String>);

impl PieceFiles for Files {
    fn open(&self, chain: &[String]) -> Result<PieceFile, String> {
        let place = chain.last().map_or("a", String::as_str).to_owned();
        let bytes =
            self.0.get(place.as_str()).ok_or_else(|| format!("no file {place}"))?.clone().into_bytes();
        Ok(PieceFile { place, bytes })
    }
}

impl Files {
    fn with(mut self, name: &'static str, content: impl Into<String>) -> Self {
        self.0.insert(name, content.into());
        self
    }

    fn frames(&self) -> usize {
        let series = Series::of_collection(self.0["a"].as_bytes(), self).expect("it is read");
        series.expect("it is a collection").frames()
    }

    fn read(&self, frame: usize) -> Result<Packing, ReadError> {
        let series = Series::of_collection(self.0["a"].as_bytes(), self)?.expect("it is a collection");
        series.read(frame, &ReadOptions::default(), &AtomicU64::new(0))
    }

    /// The line and the message of the error of the first frame.
    fn refused(&self) -> String {
        let error = self.read(0).expect_err("it is refused");
        format!("{:?}: {error}", error.line())
    }
}

/// A piece with points along x, and their data by name.
fn points(xs: &[f64], data: &[(&str, &[f64])]) -> String {
    let n = xs.len();
    let coordinates: Vec<_> = xs.iter().map(|x| format!("{x} 0 0.5")).collect();
    let array = |(name, values): &(&str, &[f64])| {
        let values: Vec<_> = values.iter().map(f64::to_string).collect();
        let values = values.join(" ");
        format!("<DataArray type=\"Float64\" Name=\"{name}\" format=\"ascii\">{values}</DataArray>\n")
    };
    let arrays = data.iter().map(array).collect::<Vec<_>>().concat();
    format!(
        "<VTKFile type=\"PolyData\"><PolyData>\n<Piece NumberOfPoints=\"{n}\" NumberOfVerts=\"0\" NumberOfLines=\"0\" \
         NumberOfStrips=\"0\" NumberOfPolys=\"0\"><PointData>\n{arrays}</PointData><Points>\n<DataArray type=\"Float64\" \
         NumberOfComponents=\"3\" format=\"ascii\">{}</DataArray>\n</Points></Piece></PolyData></VTKFile>",
        coordinates.join(" ")
    )
}

fn pvd(entries: &str) -> String {
    format!(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\">\n<Collection>\n{entries}</Collection></VTKFile>\n"
    )
}

fn parallel(pieces: &[&str]) -> String {
    let pieces: Vec<_> = pieces.iter().map(|piece| format!("<Piece Source=\"{piece}\"/>\n")).collect();
    let pieces = pieces.concat();
    format!("<VTKFile type='PPolyData'>\n<PPolyData GhostLevel=\"0\">\n{pieces}</PPolyData></VTKFile>")
}

/// The x of all centres; none in two dimensions.
fn xs(packing: &Packing) -> Vec<f64> {
    match &packing.centres {
        Centres::Three(centres) => centres.iter().map(|centre| centre[0]).collect(),
        Centres::Two(_) => Vec::new(),
    }
}

/// The time steps of a `.pvd` are frames; files of the same time step are parts of one, in any order.
#[test]
fn a_pvd_is_a_series() {
    let entries = "<DataSet timestep=\"0\" part=\"0\" file=\"b\"/>\n<DataSet timestep=\"0.5\" part=\"0\" file=\"c\"/>\n\
                   <DataSet timestep=\"0\" part=\"1\" file=\"d\"/>\n";
    let files = Files::default()
        .with("a", pvd(entries))
        .with("b", points(&[1.0, 2.0], &[("radius", &[0.5, 0.25])]))
        .with("c", points(&[3.0], &[("radius", &[0.75])]))
        .with("d", points(&[4.0], &[("radius", &[0.125])]));
    assert_eq!(files.frames(), 2);
    let first = files.read(0).unwrap();
    assert_eq!((xs(&first), first.radii.as_deref()), (vec![1.0, 2.0, 4.0], Some(&[0.5, 0.25, 0.125][..])));
    assert_eq!((first.frame.time, first.frame.index), (Some(0.0), 0));
    let second = files.read(1).unwrap();
    assert_eq!((xs(&second), second.frame.time, second.frame.index), (vec![3.0], Some(0.5), 1));
    // Without time steps all files are parts of one frame.
    let parts = "<DataSet file=\"b\"/><DataSet file=\"c\"/>";
    let files = files.with("a", pvd(parts));
    assert_eq!((files.frames(), xs(&files.read(0).unwrap())), (1, vec![1.0, 2.0, 3.0]));
}

/// Pieces may be collections. Empty pieces have no data, and points of other pieces are marked.
#[test]
fn pieces_are_joined_without_ghosts() {
    let blocks = "<VTKFile type=\"vtkMultiBlockDataSet\"><vtkMultiBlockDataSet><Block index=\"0\" name=\"walls\">\
                  <DataSet index=\"0\"/><DataSet index=\"1\" file=\"b\"/></Block></vtkMultiBlockDataSet></VTKFile>";
    let files = Files::default()
        .with("a", blocks)
        .with("b", parallel(&["c", "d", "e"]))
        .with("c", points(&[1.0, 2.0], &[("radius", &[0.5, 0.25]), ("vtkGhostType", &[0.0, 1.0])]))
        .with("d", points(&[], &[]))
        .with("e", points(&[2.0], &[("radius", &[0.25]), ("vtkGhostType", &[0.0])]));
    let packing = files.read(0).unwrap();
    assert_eq!((xs(&packing), packing.radii), (vec![1.0, 2.0], Some(vec![0.5, 0.25])));
}

#[test]
fn pieces_that_do_not_fit_are_refused() {
    let radius: [(&str, &[f64]); 1] = [("radius", &[0.5])];
    let files = || Files::default().with("a", parallel(&["b", "c"])).with("b", points(&[1.0], &radius));
    assert_eq!(files().refused(), "Some(4): piece c: no file c");
    assert_eq!(
        files().with("c", points(&[2.0], &[("diameter", &[1.0])])).refused(),
        "Some(4): piece c: c has the point data diameter, b has not"
    );
    assert_eq!(
        files().with("c", parallel(&["a"])).refused(),
        "Some(4): piece c: line 3: piece a: the file lists itself, or leads to itself"
    );
    assert_eq!(files().with("c", "x,y\n1,2\n").refused(), "Some(4): piece c: this is no VTK file");
    let image = "<VTKFile type=\"ImageData\"><ImageData/></VTKFile>";
    assert!(files().with("c", image).refused().contains("piece c: line 1: a VTK file of type 'ImageData'"));
    let series = pvd("<DataSet timestep=\"0\" file=\"b\"/><DataSet timestep=\"1\" file=\"b\"/>");
    assert!(files().with("c", series).refused().contains("piece c: it has 2 time steps"));
    let mesh = points(&[0.0, 1.0], &[]).replace("NumberOfPolys=\"0\"", "NumberOfPolys=\"1\"");
    assert!(files().with("c", mesh).refused().contains("piece c: it has cells"));
    let torn = points(&[1.0, 2.0], &[]).replace("NumberOfPoints=\"2\"", "NumberOfPoints=\"3\"");
    assert!(files().with("c", torn).refused().starts_with("Some(4): piece c: "));

    let lists = |content: String| Files::default().with("a", content).refused();
    assert_eq!(lists(parallel(&[])), "Some(2): the collection lists no file: there is no <Piece>");
    assert_eq!(
        lists(pvd("<DataSet timestep=\"x\" file=\"b\"/>")),
        "Some(4): timestep 'x' is not a finite number"
    );
    assert_eq!(lists(pvd("<DataSet timestep=\"1\"/>")), "Some(4): <DataSet> has no attribute file");
    assert!(lists(pvd("<DataSet")).contains("XML"));
    assert!(Series::of_collection(points(&[1.0], &[]).as_bytes(), &Files::default()).unwrap().is_none());
}
