# SPDX-License-Identifier: Apache-2.0
"""Running the project's programs: where they are, and how long and how large they ran."""

import concurrent.futures
import json
import os
import subprocess
import sys
import threading
import time
from dataclasses import dataclass

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
RESULTS = os.path.join(ROOT, "bench", "results")
CORPUS = os.environ.get("NMC_CORPUS", os.path.join(os.path.dirname(ROOT), "shared", "corpus"))

# The closed scans on which rate and distortion are judged.
CLOSED_SCANS = ["horse.ply", "igea.ply", "armadillo.obj", "nefertiti.obj", "dilo.off", "amo.off", "bimba.off",
                "rockerArm.ply", "Hand1.off", "skull.obj", "botijo.obj", "fertility.obj", "dragon_100k.obj"]

MESH_ENDINGS = (".ply", ".obj", ".stl", ".off", ".glb", ".gltf")


@dataclass
class Run:
    """How a program ended. `peak_bytes` is its largest resident size."""
    exit_code: int
    seconds: float
    cpu_seconds: float
    peak_bytes: int
    output: str
    errors: str
    timed_out: bool = False

    @property
    def last_error_line(self):
        lines = [line for line in self.errors.splitlines() if line.strip()]
        return lines[-1].strip() if lines else ""


def run(command, timeout=None):
    """Runs `command` to its end and measures this one process (not its siblings)."""
    start = time.monotonic()
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, errors="replace")
    texts = {}
    readers = [threading.Thread(target=lambda name=name, pipe=pipe: texts.__setitem__(name, pipe.read()))
               for name, pipe in (("out", process.stdout), ("err", process.stderr))]
    for reader in readers:
        reader.start()
    timed_out = threading.Event()

    def stop():
        timed_out.set()
        process.kill()

    timer = threading.Timer(timeout, stop) if timeout else None
    if timer:
        timer.start()
    _, status, usage = os.wait4(process.pid, 0)
    if timer:
        timer.cancel()
    for reader in readers:
        reader.join()
    process.returncode = os.waitstatus_to_exitcode(status)
    scale = 1 if sys.platform == "darwin" else 1024
    return Run(process.returncode, time.monotonic() - start, usage.ru_utime + usage.ru_stime, usage.ru_maxrss * scale,
               texts["out"], texts["err"], timed_out.is_set())


class Programs:
    """The programs of one build tree."""

    def __init__(self, build):
        self.build = build

    def path(self, name):
        for folder in ("encoder", "decoder", "bench/peers", "bench/grow", ""):
            candidate = os.path.join(self.build, folder, name)
            if os.access(candidate, os.X_OK) and not os.path.isdir(candidate):
                return candidate
        sys.exit(f"{name} is not in {self.build}: build it first (cmake --build {self.build})")

    def compare(self, original, result, samples=0):
        """nmc-compare as a dictionary; None where it refuses."""
        command = [self.path("nmc-compare"), original, result, "--json"]
        if samples:
            command += ["--samples", str(samples)]
        compared = run(command)
        return json.loads(compared.output) if compared.exit_code == 0 else None


def in_parallel(measure, tasks, jobs):
    """Yields measure(task) as they are done, `jobs` at once. The programs they start do the work, so threads do."""
    with concurrent.futures.ThreadPoolExecutor(max(jobs, 1)) as pool:
        for done in concurrent.futures.as_completed([pool.submit(measure, task) for task in tasks]):
            yield done.result()


def default_build():
    return os.environ.get("NMC_BUILD", os.path.join(ROOT, "build"))


def corpus_meshes():
    """The names of all meshes of the corpus, small files first, so that a table fills quickly."""
    names = [name for name in os.listdir(CORPUS) if name.lower().endswith(MESH_ENDINGS)]
    return sorted(names, key=lambda name: (os.path.getsize(os.path.join(CORPUS, name)), name))


def corpus_path(name):
    return name if os.path.sep in name else os.path.join(CORPUS, name)


def machine():
    """One line for tables of times."""
    model = "unknown processor"
    try:
        with open("/proc/cpuinfo", encoding="ascii", errors="replace") as file:
            model = next((line.split(":", 1)[1].strip() for line in file if line.startswith("model name")), model)
    except OSError:
        pass
    return f"{model}, {os.cpu_count()} threads"


def revision():
    """The commit the programs were built from, with a mark where the tree has other changes."""
    described = subprocess.run(["git", "-C", ROOT, "describe", "--always", "--dirty"], capture_output=True, text=True,
                               check=False)
    return described.stdout.strip() or "unknown"
