"""Which of N bodies touch? Contact detection on NumPy arrays, exact and in time proportional to N.

>>> import fdem
>>> positions = [[0.0, 0.0], [1.0, 0.0], [5.0, 5.0]]
>>> contacts = fdem.contacts(positions, radii=[0.5, 0.6, 0.5])
>>> contacts.pairs.tolist()
[[0, 1]]
>>> contacts.overlap.round(3).tolist()
[0.1]

================================================= ====================================================
you have                                          use
================================================= ====================================================
spheres, discs, or points with a cut-off          :func:`contacts`
axis-aligned boxes                                :func:`boxes`
a mesh of triangles or tetrahedra                 :func:`mesh`
an image whose labels are bodies                  :func:`labels`
elements that move a little between searches      :class:`Detector`
points, and other points to look around           :func:`query`
a file                                            :func:`read`
code written for SciPy, ASE, matscipy or freud    :class:`KDTree`, :func:`neighbor_list`,
                                                  :meth:`Contacts.neighbor_list`
================================================= ====================================================

Touching counts. Each couple comes once, ``i < j``. Results do not depend on the engine, and neither they nor their order on the number of threads.
NaN, a negative radius, arrays of unlike length: a ``ValueError`` that names the element. While a search runs, other threads of Python go on, and must not
write to its arrays. Ctrl-C ends searches for contacts, of spheres, boxes and labels, within a fraction of a second; queries, meshes and checks are finished first. The
working memory of the last search, up to 128 MB, is kept for the next.
"""

from ._analysis import Analysis
from ._ase import neighbor_list
from ._box import Box
from ._contacts import Contacts, Csr, boxes, contacts
from ._detector import Detector
from ._fdem import __version__
from ._labels import LabelContacts, labels
from ._mesh import BodyContacts, MeshContacts, mesh
from ._neighbors import NeighborList
from ._query import KDTree, Neighbours, query
from ._read import Mesh, Packing, read

__all__ = [
    "Analysis",
    "BodyContacts",
    "Box",
    "Contacts",
    "Csr",
    "Detector",
    "KDTree",
    "LabelContacts",
    "Mesh",
    "MeshContacts",
    "NeighborList",
    "Neighbours",
    "Packing",
    "__version__",
    "boxes",
    "contacts",
    "labels",
    "mesh",
    "neighbor_list",
    "query",
    "read",
]
