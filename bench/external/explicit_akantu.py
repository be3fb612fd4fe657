"""Times explicit steps of Akantu (https://akantu.ch), a public finite element code in C++ with cohesive elements.

    pip install akantu==5.0.7.post1
    python explicit_akantu.py MESH STEPS [--cohesive] [--check]

MESH is a Gmsh 2.2 ASCII file of one body of triangles with 3 nodes, in the plane, in metres. The left half moves to the right with 1 m/s.
Small strains, linear elastic, plane stress, lumped mass, central differences, half of the stable time step, one thread, nothing held,
nothing written. The last word printed is the seconds of STEPS steps, without a few before them.

--cohesive: intrinsic cohesive elements (linear softening) on all edges inside. --check: also energies and momentum.
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


def renumber(mesh):
    """Gives the first two numbers to the nodes of the fewest triangles.

    Akantu 5.0.7 reads a node that it doubles where the array was before it grew. If that memory is given back, it crashes (above 50,000
    triangles); if not, only the first two nodes are lost there, unless they are not those doubled at that moment.
    """
    nodes, triangles = mesh.getNodes(), mesh.getConnectivity(aka._triangle_3)
    few = np.argsort(np.bincount(triangles.ravel()), kind="stable")[:2]
    order = np.concatenate((few, np.setdiff1d(np.arange(len(nodes)), few)))
    place = np.empty_like(order)
    place[order] = np.arange(len(order))
    nodes[:] = nodes[order]
    triangles[:] = place[triangles]


def corners(mesh):
    return mesh.getNodes()[mesh.getConnectivity(aka._triangle_3)]


def shapes(mesh):
    """Areas, and lengths of edges (one row for each of the three)."""
    a, b, c = corners(mesh).swapaxes(0, 1)
    (ux, uy), (vx, vy) = (b - a).T, (c - a).T
    return 0.5 * np.abs(ux * vy - uy * vx), np.array([np.hypot(*(p - q).T) for p, q in ((a, b), (b, c), (c, a))])


def stable(areas, edges, stiffness):
    """The stable time step. `stiffness`: of cohesive elements, or 0.

    For triangles Akantu's own rule: inscribed circle over the speed of waves. It does not look at cohesive elements. These add to the square
    of the highest frequency; half of the mass that a node has from its triangle is for each of the two at it.
    """
    speed = np.sqrt(YOUNG / (DENSITY * (1.0 - POISSON**2)))
    alone = (4.0 * areas / edges.sum(axis=0)).min() / speed
    return 2.0 / np.sqrt((2.0 / alone) ** 2 + (6.0 * stiffness * edges.max(axis=0) / (DENSITY * areas)).max())


def read_materials(stiffness):
    """Akantu takes materials from a file only. With stiffness 0 there are no cohesive elements."""
    text = f"material elastic [\n name = rock\n rho = {DENSITY}\n E = {YOUNG}\n nu = {POISSON}\n Plane_Stress = true\n]\n"
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
    mesh = aka.Mesh(2)
    mesh.read(path)
    areas, edges = shapes(mesh)
    stiffness = STIFFNESS * YOUNG / edges.mean() if cohesive else 0.0
    read_materials(stiffness)
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
    model.setTimeStep(0.5 * stable(areas, edges, stiffness))
    return mesh, model


def state(mesh, model, cohesive):
    kinetic, strain, lost = model.getEnergy("kinetic"), model.getEnergy("potential"), 0.0
    if cohesive:
        strain += model.getEnergy("reversible") + model.getEnergy("cohesive contact")
        lost = model.getEnergy("dissipated")
    momentum = (model.getMass() * model.getVelocity()).sum(axis=0)
    return (
        f"kinetic {kinetic:.6g} strain {strain:.6g} dissipated {lost:.6g} total {kinetic + strain + lost:.6g} J, "
        f"momentum {momentum[0]:.9g} {momentum[1]:.3g} kg m/s"
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
        joints = mesh.getNbElement(type=aka._cohesive_2d_4) if given.cohesive else 0
        print(mesh.getNbElement(type=aka._triangle_3), "triangles,", joints, "cohesive elements")
    print(seconds)


main()
