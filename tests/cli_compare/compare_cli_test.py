# SPDX-License-Identifier: Apache-2.0
"""nmc-compare and nmc-render as a user meets them: output, files, messages, exit codes."""

import json
import math
import os
import subprocess
import tempfile
import unittest

COMPARE, RENDER = os.environ["NMC_COMPARE"], os.environ["NMC_RENDER"]
ENCODE = os.environ.get("NMC_ENCODE")


def off_square(height, half=False):
    """The unit square at z = height as an OFF file, or one of its two triangles."""
    faces = ["3 0 1 2"] + ([] if half else ["3 0 2 3"])
    return f"OFF\n4 {len(faces)} 0\n0 0 {height}\n1 0 {height}\n1 1 {height}\n0 1 {height}\n" + "\n".join(faces) + "\n"


def off_sphere(splits):
    """The octahedron with every triangle cut into four `splits` times, on the unit sphere, slightly dented."""
    points = [(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)]
    faces = [(0, 2, 4), (2, 1, 4), (1, 3, 4), (3, 0, 4), (2, 0, 5), (1, 2, 5), (3, 1, 5), (0, 3, 5)]
    for _ in range(splits):
        middle = {}

        def between(a, b):
            key = (min(a, b), max(a, b))
            if key not in middle:
                total = [x + y for x, y in zip(points[a], points[b])]
                length = math.sqrt(sum(x * x for x in total))
                middle[key] = len(points)
                points.append(tuple(x / length for x in total))
            return middle[key]

        finer = []
        for a, b, c in faces:
            ab, bc, ca = between(a, b), between(b, c), between(c, a)
            finer += [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
        faces = finer
    dented = [tuple(x * (1 + 0.05 * math.sin(5 * point[0]) * math.sin(4 * point[1])) for x in point) for point in points]
    lines = ["OFF", f"{len(points)} {len(faces)} 0"]
    lines += [" ".join(f"{x:.9g}" for x in point) for point in dented]
    lines += ["3 " + " ".join(map(str, face)) for face in faces]
    return "\n".join(lines) + "\n"


class CommandLine(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)

    def file(self, name, text=None):
        path = os.path.join(self.folder.name, name)
        if text is not None:
            with open(path, "w", encoding="ascii") as file:
                file.write(text)
        return path

    def run_tool(self, *command):
        return subprocess.run(command, capture_output=True, text=True, check=False)

    def test_json_holds_the_figures_in_units_and_relative_to_the_original(self):
        run = self.run_tool(COMPARE, self.file("a.off", off_square(0)), self.file("b.off", off_square(0.5)), "--json")
        self.assertEqual(run.returncode, 0, run.stderr)
        report = json.loads(run.stdout)
        self.assertEqual(report["schema"], "nmc-compare-v1")
        self.assertAlmostEqual(report["rms"], 0.5)
        self.assertAlmostEqual(report["relativeMax"], 0.5 / 2 ** 0.5)
        self.assertAlmostEqual(report["psnrDb"], 9.0309, places=3)
        self.assertEqual(report["original"]["triangles"], 2)
        self.assertEqual(report["originalToResult"]["vertices"], 4)

    def test_equal_surfaces_have_no_psnr_in_json(self):
        path = self.file("a.off", off_square(0))
        report = json.loads(self.run_tool(COMPARE, path, path, "--json").stdout)
        self.assertEqual(report["max"], 0)
        self.assertIsNone(report["psnrDb"])

    def test_text_shows_both_directions(self):
        run = self.run_tool(COMPARE, self.file("a.off", off_square(0)), self.file("b.off", off_square(0, half=True)))
        self.assertEqual(run.returncode, 0, run.stderr)
        maximum = next(line.split() for line in run.stdout.splitlines() if line.startswith("max"))
        self.assertAlmostEqual(float(maximum[3]), 0.5 ** 0.5, places=5)
        self.assertEqual(float(maximum[4]), 0)

    def test_samples_are_as_many_as_asked(self):
        path = self.file("a.off", off_square(0))
        report = json.loads(self.run_tool(COMPARE, path, path, "--json", "--samples", "1234").stdout)
        self.assertEqual(report["originalToResult"]["samples"], 1234)

    def test_heatmaps_are_written_as_mesh_and_as_picture(self):
        a, b = self.file("a.off", off_square(0)), self.file("b.off", off_square(0.1))
        for name, start in (("h.ply", b"ply\n"), ("h.png", b"\x89PNG")):
            path = self.file(name)
            run = self.run_tool(COMPARE, a, b, "--heatmap", path)
            self.assertEqual(run.returncode, 0, run.stderr)
            with open(path, "rb") as file:
                self.assertTrue(file.read().startswith(start))

    def test_a_heatmap_of_another_kind_is_refused_before_any_work(self):
        path = self.file("a.off", off_square(0))
        run = self.run_tool(COMPARE, path, path, "--heatmap", self.file("h.txt"))
        self.assertEqual(run.returncode, 1)
        self.assertEqual(run.stdout, "")

    def test_render_writes_a_picture(self):
        path = self.file("picture.png")
        run = self.run_tool(RENDER, "--original", self.file("a.off", off_square(0)), "--result",
                            self.file("b.off", off_square(0.1)), "-o", path, "--size", "100", "--view", "0", "0", "1")
        self.assertEqual(run.returncode, 0, run.stderr)
        self.assertGreater(os.path.getsize(path), 1000)

    @unittest.skipUnless(ENCODE, "nmc-encode is not in this build")
    def test_a_stream_is_measured_as_the_mesh_it_decodes_to_and_prefix_by_prefix(self):
        original, stream = self.file("sphere.off", off_sphere(4)), self.file("sphere.nmc")
        run = self.run_tool(ENCODE, original, "-o", stream, "--rms-error", "0.05%", "--quiet")
        self.assertEqual(run.returncode, 0, run.stderr)
        whole = json.loads(self.run_tool(COMPARE, original, stream, "--json").stdout)
        self.assertLessEqual(whole["relativeRms"], 0.0005 * 1.001)
        layers = json.loads(self.run_tool(COMPARE, original, stream, "--layers", "--json").stdout)["layers"]
        self.assertEqual(layers[-1]["endByte"], os.path.getsize(stream))
        self.assertAlmostEqual(layers[-1]["rms"], whole["rms"])
        for layer in layers:
            if "statedRms" in layer:
                self.assertAlmostEqual(layer["rms"] / layer["statedRms"], 1, delta=0.05)

        with open(stream, "rb") as file:
            content = file.read()
        cut = self.file("cut.nmc")
        with open(cut, "wb") as file:
            file.write(content[:layers[0]["endByte"]])
        first = json.loads(self.run_tool(COMPARE, original, cut, "--json").stdout)
        self.assertAlmostEqual(first["rms"], layers[0]["rms"])
        for size, code in ((0, 8), (20, 8)):
            with open(cut, "wb") as file:
                file.write(content[:size])
            self.assertEqual(self.run_tool(COMPARE, original, cut).returncode, code)

    def test_layers_need_a_stream(self):
        path = self.file("a.off", off_square(0))
        self.assertEqual(self.run_tool(COMPARE, path, path, "--layers").returncode, 1)

    def test_exit_codes(self):
        good = self.file("a.off", off_square(0))
        broken = self.file("broken.off", "OFF\n4 1 0\n0 0 0\n")
        empty = self.file("empty.off", "OFF\n0 0 0\n")
        no_stream = self.file("no.nmc", "ply\nformat ascii 1.0\n" + 200 * "comment\n")
        for code, command in ((1, [COMPARE]), (1, [COMPARE, good, good, "--no-such-option"]),
                              (2, [COMPARE, good, self.file("missing.ply")]), (3, [COMPARE, good, broken]),
                              (3, [COMPARE, good, empty]), (3, [COMPARE, good, no_stream]),
                              (2, [COMPARE, good, self.file("missing.nmc")]),
                              (2, [COMPARE, good, good, "--heatmap", "/nowhere/at/all.ply"]),
                              (2, [RENDER, "--original", good, "--result", good, "-o", "/nowhere/at/all.png"]),
                              (0, [COMPARE, "--help"]), (0, [RENDER, "--help"])):
            with self.subTest(command=command):
                run = self.run_tool(*command)
                self.assertEqual(run.returncode, code, run.stderr)
                if code:
                    self.assertNotEqual(run.stderr, "")


if __name__ == "__main__":
    unittest.main()
