"""Times explicit steps of Kratos Multiphysics (https://github.com/KratosMultiphysics/Kratos), a public finite element code in C++.

    pip install KratosMultiphysics==10.4.4 KratosStructuralMechanicsApplication==10.4.4
    python explicit_kratos.py MESH STEPS [--check]

MESH is a Gmsh 2.2 ASCII file of one body of triangles with 3 nodes, in the plane, in metres. The left half moves to the right with 1 m/s.
Small strains, linear elastic, plane stress, lumped mass, central differences, half of the stable time step, one thread, nothing held,
nothing written. The last word printed is the seconds of STEPS steps, without a few before them.

--check: also energies and momentum.
"""

import argparse
import os
import time

# Before anything that starts threads.
os.environ["OMP_NUM_THREADS"] = "1"

import KratosMultiphysics as kratos  # noqa: E402
import KratosMultiphysics.StructuralMechanicsApplication as structural  # noqa: E402
import numpy as np  # noqa: E402

YOUNG, POISSON, DENSITY = 30e9, 0.25, 2700.0
UNCOUNTED = 5


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("mesh")
    parser.add_argument("steps", type=int)
    parser.add_argument("--check", action="store_true")
    return parser.parse_args()


def read(path):
    """Coordinates, and the nodes of triangles, counted from 0."""
    with open(path) as file:
        lines = iter(file.read().splitlines())
    nodes, triangles, index = [], [], {}
    for line in lines:
        if line == "$Nodes":
            for _ in range(int(next(lines))):
                words = next(lines).split()
                index[words[0]] = len(nodes)
                nodes.append((float(words[1]), float(words[2])))
        elif line == "$Elements":
            for _ in range(int(next(lines))):
                words = next(lines).split()
                if words[1] == "2":
                    triangles.append([index[word] for word in words[-3:]])
    return np.array(nodes), np.array(triangles)


def stable(nodes, triangles):
    """The stable time step: inscribed circle over the speed of waves, as in `explicit_akantu.py`."""
    a, b, c = nodes[triangles].swapaxes(0, 1)
    (ux, uy), (vx, vy) = (b - a).T, (c - a).T
    around = sum(np.hypot(*(p - q).T) for p, q in ((a, b), (b, c), (c, a)))
    speed = np.sqrt(YOUNG / (DENSITY * (1.0 - POISSON**2)))
    return (2.0 * np.abs(ux * vy - uy * vx) / around).min() / speed


def fill(part, nodes, triangles):
    for variable in (
        kratos.DISPLACEMENT,
        kratos.VELOCITY,
        kratos.ACCELERATION,
        kratos.REACTION,
        kratos.VOLUME_ACCELERATION,
        kratos.NODAL_MASS,
        kratos.FORCE_RESIDUAL,
        kratos.RESIDUAL_VECTOR,
        structural.MIDDLE_VELOCITY,
    ):
        part.AddNodalSolutionStepVariable(variable)
    part.SetBufferSize(2)
    rock = part.CreateNewProperties(1)
    rock[kratos.YOUNG_MODULUS], rock[kratos.POISSON_RATIO] = YOUNG, POISSON
    rock[kratos.DENSITY], rock[kratos.THICKNESS] = DENSITY, 1.0
    rock[kratos.CONSTITUTIVE_LAW] = structural.LinearElasticPlaneStress2DLaw()
    for number, (x, y) in enumerate(nodes.tolist()):
        part.CreateNewNode(number + 1, x, y, 0.0)
    for number, corners in enumerate((triangles + 1).tolist()):
        part.CreateNewElement("SmallDisplacementElement2D3N", number + 1, corners, rock)


def build(path):
    """The model has to live as long as the part."""
    kratos.Logger.GetDefaultOutput().SetSeverity(kratos.Logger.Severity.WARNING)
    kratos.ParallelUtilities.SetNumThreads(1)
    nodes, triangles = read(path)
    model = kratos.Model()
    part = model.CreateModelPart("body")
    fill(part, nodes, triangles)
    utility = kratos.VariableUtils()
    for component, reaction in (
        (kratos.DISPLACEMENT_X, kratos.REACTION_X),
        (kratos.DISPLACEMENT_Y, kratos.REACTION_Y),
        (kratos.DISPLACEMENT_Z, kratos.REACTION_Z),
    ):
        utility.AddDof(component, reaction, part)
    information = part.ProcessInfo
    information[kratos.DOMAIN_SIZE] = 2
    information[kratos.COMPUTE_LUMPED_MASS_MATRIX] = True
    information[kratos.DELTA_TIME] = 0.5 * stable(nodes, triangles)
    middle = 0.5 * (nodes[:, 0].min() + nodes[:, 0].max())
    for node in part.Nodes:
        if node.X0 < middle:
            node.SetSolutionStepValue(kratos.VELOCITY_X, 1.0)
    # Its step is the one given, never another; no reactions, nothing to number again, the mesh stays where it was.
    scheme = structural.ExplicitCentralDifferencesScheme(1.0, 1.0, 0.0)
    strategy = structural.MechanicalExplicitStrategy(part, scheme, False, False, False)
    strategy.SetEchoLevel(0)
    strategy.Initialize()
    return model, part, strategy


def advance(part, strategy, steps):
    information = part.ProcessInfo
    for _ in range(steps):
        information[kratos.STEP] += 1
        part.CloneTimeStep(information[kratos.TIME] + information[kratos.DELTA_TIME])
        strategy.InitializeSolutionStep()
        strategy.SolveSolutionStep()
        strategy.FinalizeSolutionStep()


def state(part, strategy):
    """Goes one step on: Kratos knows the velocities of the time of the displacements after the step from there."""
    density = [element.CalculateOnIntegrationPoints(kratos.STRAIN_ENERGY, part.ProcessInfo)[0] for element in part.Elements]
    strain = np.dot(density, [element.GetGeometry().Area() for element in part.Elements])
    advance(part, strategy, 1)
    mass = np.array([node.GetValue(kratos.NODAL_MASS) for node in part.Nodes])
    velocity = np.array([node.GetSolutionStepValue(kratos.VELOCITY) for node in part.Nodes])
    kinetic, momentum = 0.5 * mass @ (velocity**2).sum(axis=1), mass @ velocity
    return f"kinetic {kinetic:.6g} strain {strain:.6g} total {kinetic + strain:.6g} J, momentum {momentum[0]:.9g} {momentum[1]:.3g} kg m/s"


def main():
    given = arguments()
    model, part, strategy = build(given.mesh)
    if given.check:
        print("start:", state(part, strategy))
    advance(part, strategy, UNCOUNTED)
    clock = time.perf_counter()
    advance(part, strategy, given.steps)
    seconds = time.perf_counter() - clock
    if given.check:
        print("end:", state(part, strategy))
    print(seconds)


main()
