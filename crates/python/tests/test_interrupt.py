"""The interpreter runs while a search runs, and Ctrl-C stops searches and other long work."""

import gc
import signal
import subprocess
import sys
import textwrap
import threading
import time

import numpy as np
import pytest
from conftest import couples, gas

import fdem

LONG = {
    # Hundreds of millions of couples.
    "rows": "fdem.contacts(rng.random((400_000, 3)), cutoff=0.15, engine='rows', threads={threads})",
    "periodic": "fdem.contacts(rng.random((200_000, 3)), cutoff=0.2, box=[1, 1, 1], periodic=True, threads={threads})",
    # 10^12 comparisons.
    "direct": "fdem.contacts(rng.random((1_000_000, 3)), cutoff=0.01, engine='direct', threads={threads})",
}


@pytest.mark.skipif(sys.platform == "win32", reason="a process cannot send itself Ctrl-C there")
@pytest.mark.parametrize("engine", LONG)
@pytest.mark.parametrize("threads", [1, None])
def test_ctrl_c_ends_a_search(engine, threads):
    program = f"""
        import sys, threading, os, signal, time
        import numpy as np, fdem
        # A shell starts programs in its background with Ctrl-C ignored, and Python does not change that.
        signal.signal(signal.SIGINT, signal.default_int_handler)
        rng = np.random.default_rng(0)
        few = rng.random((5000, 3))
        def interrupt():
            time.sleep(0.5)
            os.kill(os.getpid(), signal.SIGINT)
        threading.Thread(target=interrupt, daemon=True).start()
        try:
            {LONG[engine].format(threads=threads)}
        except KeyboardInterrupt:
            # A search that was stopped does not disturb the next one.
            found = fdem.contacts(few, cutoff=0.1)
            assert found.verify(50) == 50
            print("interrupted")
    """
    run = subprocess.run([sys.executable, "-c", textwrap.dedent(program)], capture_output=True, text=True, timeout=120)
    assert run.returncode == 0, run.stderr
    assert run.stdout == "interrupted\n"


FINE = """
[model]
end_time = 1
[[body]]
name = "b"
material = "m"
mesh_size = 0.0005
fine = true
rectangle = { min = [0, 0], max = [1, 1] }
[[material]]
name = "m"
density = 2000
youngs_modulus = 1e7
poissons_ratio = 0.2
"""

OTHERS = {
    # A question to a tree, which takes a minute and stops at once.
    "tree": (
        "tree = fdem.KDTree(np.random.default_rng(0).random((2_000_000, 3)))",
        "tree.count_neighbors(tree, np.linspace(0.01, 0.3, 30))",
    ),
    # Millions of triangles, which are meshed to the end in the background.
    "model": (f"text = {FINE!r}", "fdem.Model.from_toml(text)"),
}


@pytest.mark.skipif(sys.platform == "win32", reason="a process cannot send itself Ctrl-C there")
@pytest.mark.parametrize("work", OTHERS)
def test_ctrl_c_ends_other_work(work):
    setup, call = OTHERS[work]
    program = f"""
import os, signal, threading, time
import numpy as np, fdem
signal.signal(signal.SIGINT, signal.default_int_handler)
{setup}
at = []
def interrupt():
    time.sleep(1)
    at.append(time.perf_counter())
    os.kill(os.getpid(), signal.SIGINT)
threading.Thread(target=interrupt, daemon=True).start()
try:
    {call}
except KeyboardInterrupt:
    # A small part of a second, but for a machine that is busy.
    assert time.perf_counter() - at[0] < 10
    print("interrupted", flush=True)
    os._exit(0)
"""
    run = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=120)
    assert run.returncode == 0, run.stderr
    assert run.stdout == "interrupted\n"


@pytest.mark.skipif(sys.platform == "win32", reason="signals are others there")
def test_a_handler_that_does_not_raise_does_not_end_a_search():
    called = []
    before = signal.signal(signal.SIGALRM, lambda *_: called.append(time.perf_counter()))
    try:
        signal.setitimer(signal.ITIMER_REAL, 0.005)
        positions = gas(300_000, 40, 3)[0]
        signal.setitimer(signal.ITIMER_REAL, 0.01)
        found = fdem.contacts(positions, cutoff=1.0, threads=1)
        while not called:
            time.sleep(0.01)
    finally:
        signal.signal(signal.SIGALRM, before)
    assert found.verify(20) == 20


def test_other_threads_run_meanwhile():
    positions = gas(400_000, 60, 3)[0]
    ticks, done = [], threading.Event()

    def tick():
        while not done.is_set():
            ticks.append(time.perf_counter())
            time.sleep(0.001)

    thread = threading.Thread(target=tick)
    thread.start()
    begin = time.perf_counter()
    fdem.contacts(positions, cutoff=1.0, threads=1)
    end = time.perf_counter()
    done.set()
    thread.join()
    # With the lock held there would be none between the first and the last moment.
    assert sum(begin < moment < end for moment in ticks) > 3


@pytest.mark.parametrize("looks", [True, False])
def test_the_search_for_cycles_is_left_as_it_was(looks):
    tree = fdem.KDTree(gas(3000, 10, 3)[0])
    before = gc.isenabled()
    try:
        (gc.enable if looks else gc.disable)()
        assert tree.query_pairs(1.0) and gc.isenabled() is looks
        assert len(tree.query_ball_tree(tree, 1.0)) == 3000 and gc.isenabled() is looks
    finally:
        (gc.enable if before else gc.disable)()


def test_searches_at_the_same_time():
    sets = [gas(20_000, 10, 3, seed)[0] for seed in range(6)]
    expected = [couples(fdem.contacts(positions, cutoff=1.0)) for positions in sets]
    found = [None] * len(sets)

    def search(k):
        for _ in range(3):
            found[k] = couples(fdem.contacts(sets[k], cutoff=1.0))

    threads = [threading.Thread(target=search, args=(k,)) for k in range(len(sets))]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert found == expected


@pytest.mark.skipif(not hasattr(__import__("os"), "fork"), reason="there are no forks")
def test_a_process_that_has_searched_can_be_forked():
    program = """
        import multiprocessing, numpy as np, fdem
        positions = np.random.default_rng(0).random((50_000, 3)) * 40
        expected = len(fdem.contacts(positions, cutoff=1.0))
        def again(_):
            return len(fdem.contacts(positions, cutoff=1.0, threads=2))
        with multiprocessing.get_context("fork").Pool(2) as pool:
            assert pool.map(again, range(4)) == [expected] * 4
    """
    run = subprocess.run(
        [sys.executable, "-W", "error", "-c", textwrap.dedent(program)], capture_output=True, text=True, timeout=60
    )
    assert run.returncode == 0, run.stderr
