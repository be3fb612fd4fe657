"""Times spheres in fdem and in LAMMPS (https://www.lammps.org), a public code in C++, by turns.

    apt-get install lammps
    cargo build --release -p fdem-bench --bin grains
    python bench/external/grains_lammps.py [--fdem PROGRAM] [--lammps lmp] [--rounds 5] [--steps 1000] [--cases chute,tube]
        [--laws hooke,hertz] [--simd avx512,avx2] [--folder FOLDER]

Both programs begin with the same spheres, on one thread. The chute is that of `bench/in.chute` of LAMMPS: 32,000 spheres in a box that
repeats along x and y, the lowest held, gravity at 26 degrees; its spheres are prepared by fdem. In the tube, 30,000 spheres with diameters
from 0.9 to 1.1 settle on a floor. Hooke: `gran/hooke/history 2000 NULL 50 NULL 0.5 0`. Hertz: the same friction, and a modulus with about
the same overlaps. Each round runs all programs once; after 200 steps that are not timed, STEPS steps are. Times are those of the
processor, which count on a machine that is not quiet: LAMMPS' "Loop time" times its "CPU use".

It prints a table: medians in millions of sphere-steps a second, and the median of the ratios of the rounds.
"""

import argparse
import pathlib
import re
import statistics
import subprocess
import sys

YOUNG, POISSON = 56_250.0, 0.25
# Normal and tangential stiffness of LAMMPS' laws and their damping: as fdem's in `bench/src/bin/grains/case.rs`. That of Hertz is its damping at
# an overlap of 0.01, in the unit of LAMMPS' law.
SHEAR = YOUNG / (2.0 * (1.0 + POISSON))
LAWS = {
    "hooke": "gran/hooke/history 2000.0 NULL 50.0 NULL 0.5 0",
    "hertz": f"gran/hertz/history {4.0 * SHEAR / (3.0 * (1.0 - POISSON))} {4.0 * SHEAR / (2.0 - POISSON)} 1100.0 NULL 0.5 0",
}
RADIUS = {"tube": 12.3}
UNCOUNTED = 200


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--fdem", default="target/release/grains")
    parser.add_argument("--lammps", default="lmp")
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--steps", type=int, default=1000)
    parser.add_argument("--cases", default="chute,tube")
    parser.add_argument("--laws", default="hooke,hertz")
    parser.add_argument("--simd", default="avx512,avx2", help="those that the processor lacks are left out")
    parser.add_argument("--folder", default="target/grains", type=pathlib.Path)
    return parser.parse_args()


def script(case, law, data, steps):
    """The input of LAMMPS."""
    lines = [
        "units lj",
        "atom_style sphere",
        f"boundary {'p p fs' if case == 'chute' else 'f f fs'}",
        "newton off",
        "comm_modify vel yes",
        f"read_data {data}",
        f"pair_style {LAWS[law]}",
        "pair_coeff * *",
        "neighbor 0.1 bin",
        "neigh_modify every 1 delay 0",
        "timestep 0.0001",
    ]
    if case == "chute":
        lines += [
            "group bottom type 2",
            "group active subtract all bottom",
            "neigh_modify exclude group bottom bottom",
            "fix weight all gravity 1.0 chute 26.0",
            "fix floor bottom freeze",
            "fix move active nve/sphere",
        ]
    else:
        wall = LAWS[law].removeprefix("gran/")
        lines += [
            "fix weight all gravity 1.0 vector 0 0 -1",
            f"fix floor all wall/gran {wall} zplane 0.0 NULL",
            f"fix tube all wall/gran {wall} zcylinder {RADIUS[case]}",
            "fix move all nve/sphere",
        ]
    return "\n".join([*lines, "thermo 100000", f"run {UNCOUNTED}", f"run {steps}", ""])


def run(command):
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"{' '.join(map(str, command))}: {done.stderr or done.stdout}")
    return done.stdout


def lammps(program, file):
    text = run([program, "-in", file, "-log", "none"])
    loop = re.findall(r"Loop time of (\S+) on 1 procs", text)[-1]
    use = re.findall(r"(\S+)% CPU use", text)[-1]
    return float(loop) * float(use) / 100.0


def fdem(program, case, law, data, steps, level):
    command = [program, "--case", case, "--law", law, "--from", data, "--steps", steps, "--rounds", 1]
    return float(run([*command, "--simd", level, "--seconds"]))


def processor():
    with open("/proc/cpuinfo") as file:
        lines = file.read().splitlines()
    name = next(line.split(": ")[1] for line in lines if line.startswith("model name"))
    flags = next(line.split() for line in lines if line.startswith("flags"))
    return name, flags


def main():
    options = arguments()
    name, flags = processor()
    has = {"avx512": "avx512f" in flags, "avx2": "avx2" in flags, "portable": True}
    levels = [level for level in options.simd.split(",") if has.get(level, False)]
    options.folder.mkdir(parents=True, exist_ok=True)
    version = re.search(r"- (.*)", run([options.lammps, "-h"]))[1].strip()
    print(f"{name}; one thread; LAMMPS {version}; {options.rounds} rounds of {options.steps} steps\n")
    heading = ["case", "law", "LAMMPS", *[f"fdem, {level}" for level in levels], *[f"ratio, {level}" for level in levels]]
    print("| " + " | ".join(heading) + " |")
    print("|" + "|".join(["---", "---", *["--:"] * (len(heading) - 2)]) + "|", flush=True)
    for case in options.cases.split(","):
        data = options.folder / f"{case}.data"
        if not data.exists():
            run([options.fdem, "--case", case, "--prepare", data])
        with open(data) as file:
            count = int(next(line for line in file if line.endswith(" atoms\n")).split()[0])
        for law in options.laws.split(","):
            file = options.folder / f"{case}-{law}.in"
            file.write_text(script(case, law, data, options.steps))
            times = {program: [] for program in ["LAMMPS", *levels]}
            for _ in range(options.rounds):
                times["LAMMPS"].append(lammps(options.lammps, file))
                for level in levels:
                    times[level].append(fdem(options.fdem, case, law, data, options.steps, level))
            speed = {key: 1e-6 * count * options.steps / statistics.median(values) for key, values in times.items()}
            ratios = [
                statistics.median(theirs / ours for theirs, ours in zip(times["LAMMPS"], times[level]))
                for level in levels
            ]
            cells = [case, law, *[f"{speed[key]:.2f}" for key in ["LAMMPS", *levels]], *[f"{x:.2f}" for x in ratios]]
            print("| " + " | ".join(cells) + " |", flush=True)


if __name__ == "__main__":
    main()
