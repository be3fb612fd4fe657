"""Times explicit steps of Akantu (https://akantu.ch), a public finite element code in C++ with cohesive elements.

    pip install akantu==5.0.7.post1
    python explicit_akantu.py MESH STEPS [--cohesive] [--check]

MESH is a Gmsh 2.2 ASCII file of one body of triangles with 3 nodes, in the plane, or of tetrahedra with 4, in metres. The left half moves to the right with 1 m/s.
Small strains, linear elastic, plane stress in the plane, lumped mass, central differences, half of the stable time step, one thread, nothing held,
nothing written. The last word printed is the seconds of STEPS steps, without a few before them.

--cohesive: intrinsic cohesive elements (linear softening) on all edges or faces inside. --check: also energies and momentum.
"""

import argparse
import ctypes
import os
import tempfile
import time

# Before anything that starts threads.
os.environ["OMP_NUM_THREADS"] = "1"

import akantu as aka  # noqa: E402
import numpy as np  # noqa: E402

YOUNG, POISSON, DENSITY = 30e9, 0.25, 2700.0
STRENGTH, FRACTURE_ENERGY = 5e6, 100.0
# Stiffness of a cohesive element before its strength is reached, in Young's moduli per length of an edge.
STIFFNESS = 10.0
UNCOUNTED = 5


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("mesh")
    parser.add_argument("steps", type=int)
    parser.add_argument("--cohesive", action="store_true")
    parser.add_argument("--check", action="store_true")
    return parser.parse_args()


def keep_memory():
    """Tells glibc to give no memory back: no pages fetched anew in every step, and see `renumber`."""
    mallopt = getattr(ctypes.CDLL(None), "mallopt", None)
    if mallopt is not None:
        trim_threshold, mmap_max = -1, -4
        mallopt(trim_threshold, 2**31 - 1)
        mallopt(mmap_max, 0)


def dimensions(path):
    """Dimensions of the elements of a Gmsh file: the first of them tells."""
    with open(path) as file:
        while next(file).strip() != "$Elements":
            pass
        next(file)
        return {"2": 2, "4": 3}[next(file).split()[1]]


def kinds(mesh):
    """Akantu's kinds of the elements and of the cohesive elements between them."""
    if mesh.getNodes().shape[1] == 2:
        return aka._triangle_3, aka._cohesive_2d_4
    return aka._tetrahedron_4, aka._cohesive_3d_6


def renumber(mesh):
    """Gives the first two numbers to the nodes of the fewest elements.

    Akantu 5.0.7 reads a node that it doubles where the array was before it grew. If that memory is given back, it crashes (above 50,000
    triangles); if not, only the first two nodes are lost there, unless they are not those doubled at that moment.
    """
    nodes, elements = mesh.getNodes(), mesh.getConnectivity(kinds(mesh)[0])
    few = np.argsort(np.bincount(elements.ravel()), kind="stable")[:2]
    order = np.concatenate((few, np.setdiff1d(np.arange(len(nodes)), few)))
    place = np.empty_like(order)
    place[order] = np.arange(len(order))
    nodes[:] = nodes[order]
    elements[:] = place[elements]


def corners(mesh):
    return mesh.getNodes()[mesh.getConnectivity(kinds(mesh)[0])]


def shapes(mesh):
    """Areas or volumes of the elements, and lengths of edges or areas of faces (one row for each facet)."""
    places = corners(mesh)
    dimension, count = places.shape[2], places.shape[1]
    edges = places[:, 1:] - places[:, :1]
    measures = np.abs(np.linalg.det(edges)) / (2.0 if dimension == 2 else 6.0)
    facets = []
    for left_out in range(count):
        sides = places[:, [k for k in range(count) if k != left_out]]
        along = sides[:, 1:] - sides[:, :1]
        gram = np.linalg.det(along @ along.swapaxes(1, 2))
        facets.append(np.sqrt(gram) / (1.0 if dimension == 2 else 2.0))
    return measures, np.array(facets)


def stable(measures, facets, stiffness):
    """The stable time step. `stiffness`: of cohesive elements, or 0.

    For the elements Akantu's own rule: the diameter of the inscribed circle or sphere over the speed of waves. It does not look at cohesive elements. These add to
    the square of the highest frequency; a node has an equal share of the mass of its element for each of the facets at it.
    """
    dimension = len(facets) - 1
    alone_in_space = (1.0 - POISSON) / ((1.0 + POISSON) * (1.0 - 2.0 * POISSON))
    speed = np.sqrt(YOUNG / DENSITY * (1.0 / (1.0 - POISSON**2) if dimension == 2 else alone_in_space))
    alone = (2.0 * dimension * measures / facets.sum(axis=0)).min() / speed
    joints = dimension * (dimension + 1) * stiffness * facets.max(axis=0) / (DENSITY * measures)
    return 2.0 / np.sqrt((2.0 / alone) ** 2 + joints.max())


def read_materials(dimension, stiffness):
    """Akantu takes materials from a file only. With stiffness 0 there are no cohesive elements."""
    plane = " Plane_Stress = true\n" if dimension == 2 else ""
    text = f"material elastic [\n name = rock\n rho = {DENSITY}\n E = {YOUNG}\n nu = {POISSON}\n{plane}]\n"
    if stiffness > 0.0:
        text += f"material cohesive_bilinear [\n name = joints\n sigma_c = {STRENGTH}\n G_c = {FRACTURE_ENERGY}\n"
        text += f" beta = 1\n penalty = {stiffness}\n delta_0 = {STRENGTH / stiffness}\n]\n"
    with tempfile.NamedTemporaryFile("w", suffix=".dat") as file:
        file.write(text)
        file.flush()
        aka.parseInput(file.name)


def build(path, cohesive):
    """The mesh has to live as long as the model."""
    aka.debug.setDebugLevel(aka.dblError)
    mesh = aka.Mesh(dimensions(path))
    mesh.read(path)
    measures, facets = shapes(mesh)
    # The edge of an even face of the same area, in space.
    lengths = facets if len(facets) == 3 else np.sqrt(4.0 / np.sqrt(3.0) * facets)
    stiffness = STIFFNESS * YOUNG / lengths.mean() if cohesive else 0.0
    read_materials(len(facets) - 1, stiffness)
    if cohesive:
        renumber(mesh)
        before = corners(mesh)
        model = aka.SolidMechanicsModelCohesive(mesh)
        model.initFull(_analysis_method=aka._explicit_lumped_mass, _is_extrinsic=False)
        if (corners(mesh) != before).any():
            raise SystemExit("Akantu has moved nodes when it doubled them")
    else:
        model = aka.SolidMechanicsModel(mesh)
        model.initFull(_analysis_method=aka._explicit_lumped_mass)
    model.assembleMassLumped()
    x = mesh.getNodes()[:, 0]
    model.getVelocity()[:, 0] = x < 0.5 * (x.min() + x.max())
    model.setTimeStep(0.5 * stable(measures, facets, stiffness))
    return mesh, model


def state(mesh, model, cohesive):
    kinetic, strain, lost = model.getEnergy("kinetic"), model.getEnergy("potential"), 0.0
    if cohesive:
        strain += model.getEnergy("reversible") + model.getEnergy("cohesive contact")
        lost = model.getEnergy("dissipated")
    momentum = (model.getMass() * model.getVelocity()).sum(axis=0)
    return (
        f"kinetic {kinetic:.6g} strain {strain:.6g} dissipated {lost:.6g} total {kinetic + strain + lost:.6g} J, "
        f"momentum {' '.join(f'{part:.9g}' for part in momentum)} kg m/s"
    )


def advance(model, steps):
    for _ in range(steps):
        model.solveStep()


def main():
    given = arguments()
    keep_memory()
    mesh, model = build(given.mesh, given.cohesive)
    if given.check:
        print("start:", state(mesh, model, given.cohesive))
    advance(model, UNCOUNTED)
    clock = time.perf_counter()
    advance(model, given.steps)
    seconds = time.perf_counter() - clock
    if given.check:
        print("end:", state(mesh, model, given.cohesive))
        element, joint = kinds(mesh)
        joints = mesh.getNbElement(type=joint) if given.cohesive else 0
        print(mesh.getNbElement(type=element), "elements,", joints, "cohesive elements")
    print(seconds)


main()
