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
arrays on a graphics processor                    :func:`contacts_on_device`
axis-aligned boxes                                :func:`boxes`
a mesh of triangles or tetrahedra                 :func:`mesh`
an image whose labels are bodies                  :func:`labels`
elements that move a little between searches      :class:`Detector`
points, and other points to look around           :func:`query`
two sets of spheres, or spheres and walls         :func:`between`, :func:`walls`
a file                                            :func:`read`
a file of several frames                          :func:`frames`
code written for SciPy, ASE, matscipy or freud    :class:`KDTree`, :func:`neighbor_list`,
                                                  :meth:`Contacts.neighbor_list`
a model of bodies that deform, collide and break  :class:`Model`, :class:`Simulation`, :func:`resume`, :class:`Spheres`
many runs of a model with other values            :func:`sweep`
a folder of results of a simulation               :func:`results`
names, units and signs of results                 :func:`fields`
================================================= ====================================================

Elements that just touch count as contacts. Each couple is listed once, ``i < j``. The couples do not depend on the engine; neither the couples nor their order depend on the
number of threads. NaN, a negative radius or arrays of different lengths raise a ``ValueError`` that names the element. Other threads of Python run while a search runs, and must
not write to its arrays. Ctrl-C stops searches for contacts of spheres, boxes and labels within a fraction of a second; queries, meshes and checks are finished first. Up to 128 MB of
working memory are kept from one search to the next.
"""

from ._analysis import Analysis
from ._ase import NewPrimitiveNeighborList, neighbor_list, primitive_neighbor_list
from ._between import CrossContacts, between
from ._box import Box
from ._contacts import Contacts, Csr
from ._detector import Detector
from ._fdem import __version__
from ._fields import Field, fields
from ._kdtree import KDTree
from ._labels import LabelContacts, labels
from ._mesh import BodyContacts, MeshContacts, WallContacts, mesh, walls
from ._model import Model, material
from ._neighbors import NeighborList
from ._on_device import DeviceContacts, contacts_on_device
from ._picture import Picture
from ._query import Neighbours, query
from ._read import Frames, Mesh, Packing, frames, read
from ._results import Frame, Results, results
from ._search import boxes, contacts
from ._simulation import Simulation, resume
from ._sphere_law import SpherePairs
from ._spheres import Spheres
from ._sweep import Sweep, sweep

__all__ = [
    "Analysis",
    "BodyContacts",
    "Box",
    "Contacts",
    "CrossContacts",
    "Csr",
    "Detector",
    "DeviceContacts",
    "Field",
    "Frame",
    "Frames",
    "KDTree",
    "LabelContacts",
    "Mesh",
    "MeshContacts",
    "Model",
    "NeighborList",
    "Neighbours",
    "NewPrimitiveNeighborList",
    "Packing",
    "Picture",
    "Results",
    "Simulation",
    "SpherePairs",
    "Spheres",
    "Sweep",
    "WallContacts",
    "__version__",
    "between",
    "boxes",
    "contacts",
    "contacts_on_device",
    "fields",
    "frames",
    "labels",
    "material",
    "mesh",
    "neighbor_list",
    "primitive_neighbor_list",
    "query",
    "read",
    "results",
    "resume",
    "sweep",
    "walls",
]
