# SPDX-License-Identifier: Apache-2.0
"""The whole chain as a user runs it: mesh file, nmc-encode, nmc-decode, nmc-compare; and inputs nobody should have."""
import json
import math
import os
import pathlib
import random
import subprocess
import tempfile
import unittest

ENCODE, DECODE, COMPARE, INFO = (os.environ[name] for name in ("NMC_ENCODE", "NMC_DECODE", "NMC_COMPARE", "NMC_INFO"))
CORPUS = pathlib.Path(os.environ.get("NMC_CORPUS", pathlib.Path(__file__).resolve().parents[3] / "shared" / "corpus"))


def run(*arguments, **options):
    return subprocess.run([str(a) for a in arguments], capture_output=True, timeout=300, **options)


def write_obj(path, vertices, faces):
    with open(path, "w", encoding="ascii") as file:
        for vertex in vertices:
            file.write("v " + " ".join("%.9g" % value for value in vertex) + "\n")
        for face in faces:
            file.write("f " + " ".join(str(i + 1) for i in face) + "\n")


def bumpy_torus(rings=48, sides=32, bumps=0.04):
    """Genus 1, closed, smooth, with detail."""
    vertices, faces = [], []
    for i in range(rings):
        for j in range(sides):
            u, v = 2 * math.pi * i / rings, 2 * math.pi * j / sides
            r = 0.4 + bumps * math.sin(5 * u) * math.cos(3 * v)
            vertices.append(((1 + r * math.cos(v)) * math.cos(u), (1 + r * math.cos(v)) * math.sin(u), r * math.sin(v)))
            a, b = i * sides + j, (i + 1) % rings * sides + j
            c, d = (i + 1) % rings * sides + (j + 1) % sides, i * sides + (j + 1) % sides
            faces += [(a, b, c), (a, c, d)]
    return vertices, faces


def wavy_sheet(size=30):
    """A disk: one boundary loop."""
    vertices = [(x / size, y / size, 0.1 * math.sin(6 * x / size) * math.cos(5 * y / size))
                for y in range(size + 1) for x in range(size + 1)]
    faces = []
    for y in range(size):
        for x in range(size):
            a = y * (size + 1) + x
            faces += [(a, a + 1, a + size + 2), (a, a + size + 2, a + size + 1)]
    return vertices, faces


def painted(shape):
    """The shape with "v x y z r g b" lines: soft bands of colour."""
    vertices, faces = shape
    colors = [(0.5 + 0.4 * math.sin(4 * x), 0.5 + 0.4 * math.cos(3 * y + x), 0.6 + 0.3 * math.sin(5 * z))
              for x, y, z in vertices]
    return [tuple(v) + c for v, c in zip(vertices, colors)], faces


def bumpy_sphere(rings=40, sides=60):
    """Genus 0, closed, star-shaped, with two poles."""
    vertices, faces = [(0, 0, 1.1)], []
    for i in range(1, rings):
        for j in range(sides):
            u, v = math.pi * i / rings, 2 * math.pi * j / sides
            r = 1 + 0.1 * math.cos(3 * u) * math.sin(u) ** 2 * math.sin(4 * v)
            vertices.append((r * math.sin(u) * math.cos(v), r * math.sin(u) * math.sin(v), r * math.cos(u)))
    vertices.append((0, 0, -1.1))
    last = len(vertices) - 1
    for j in range(sides):
        k = (j + 1) % sides
        faces += [(0, 1 + j, 1 + k), (last, last - sides + k, last - sides + j)]
        for i in range(rings - 2):
            a, b = 1 + i * sides + j, 1 + i * sides + k
            faces += [(a, a + sides, b + sides), (a, b + sides, b)]
    return vertices, faces


def split(shape, times):
    """All triangles in four, `times` times; the base's vertices stay first."""
    vertices, faces = list(shape[0]), shape[1]
    for _ in range(times):
        middles, finer = {}, []

        def middle(a, b):
            edge = (min(a, b), max(a, b))
            if edge not in middles:
                middles[edge] = len(vertices)
                vertices.append(tuple((p + q) / 2 for p, q in zip(vertices[a], vertices[b])))
            return middles[edge]

        for a, b, c in faces:
            x, y, z = middle(b, c), middle(c, a), middle(a, b)
            finer += [(a, z, y), (z, b, x), (y, x, c), (x, y, z)]
        faces = finer
    return vertices, faces


def remesh(times=4):
    """A bumpy torus over 60 triangles with subdivision connectivity, with noise, in any order; and the base mesh."""
    rings, sides = 6, 5
    coarse = [(i / rings, j / sides, 0.0) for i in range(rings + 1) for j in range(sides + 1)]
    faces = []
    for i in range(rings):
        for j in range(sides):
            a, b = i * (sides + 1) + j, (i + 1) * (sides + 1) + j
            faces += [(a, b, b + 1), (a, b + 1, a + 1)]
    parameters, faces = split((coarse, faces), times)
    unit = 2 ** times
    number, vertices = {}, []
    noise = random.Random(3)

    def vertex(v):  # both seams closed
        i, j = round(parameters[v][0] * rings * unit) % (rings * unit), round(parameters[v][1] * sides * unit) % (sides * unit)
        if (i, j) not in number:
            number[i, j] = len(vertices)
            a, b = 2 * math.pi * i / (rings * unit), 2 * math.pi * j / (sides * unit)
            r = 0.4 + 0.04 * math.sin(5 * a) * math.cos(3 * b) + noise.gauss(0, 3e-4)
            vertices.append(((1 + r * math.cos(b)) * math.cos(a), (1 + r * math.cos(b)) * math.sin(a), r * math.sin(b)))
        return number[i, j]

    faces = [tuple(vertex(v) for v in face) for face in faces]
    base_number = {key: k for k, key in enumerate(sorted(k for k in number if k[0] % unit == k[1] % unit == 0))}
    base = [vertices[number[key]] for key in base_number]
    base_faces = []
    for i in range(rings):
        for j in range(sides):
            a, b, c, d = (base_number[k % rings * unit, l % sides * unit]
                          for k, l in ((i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)))
            base_faces += [(c, a, b), (a, c, d)]
    order = list(range(len(vertices)))
    noise.shuffle(order)
    shuffled = [None] * len(vertices)
    for v, place in enumerate(order):
        shuffled[place] = vertices[v]
    faces = [tuple(order[v] for v in face) for face in faces]
    noise.shuffle(faces)
    return (shuffled, faces), (base, base_faces)


class Encoding(unittest.TestCase):
    def setUp(self):
        self._folder = tempfile.TemporaryDirectory()
        self.folder = pathlib.Path(self._folder.name)

    def tearDown(self):
        leftovers = list(self.folder.glob("*.part"))
        self._folder.cleanup()
        self.assertEqual(leftovers, [], "half-written files were left")

    def encode(self, mesh, *options, expect=0):
        stream, report = self.folder / "out.nmc", self.folder / "report.json"
        done = run(ENCODE, mesh, "-o", stream, "-f", "--report", report, *options)
        self.assertEqual(done.returncode, expect, done.stderr.decode())
        return stream, json.loads(report.read_text())

    def decode_and_compare(self, mesh, stream):
        decoded = self.folder / "decoded.ply"
        done = run(DECODE, stream, "-o", decoded, "-f")
        self.assertEqual(done.returncode, 0, done.stderr.decode())
        compared = run(COMPARE, mesh, decoded, "--json")
        self.assertEqual(compared.returncode, 0, compared.stderr.decode())
        return json.loads(compared.stdout)

    def obj(self, shape, name="mesh.obj"):
        path = self.folder / name
        write_obj(path, *shape)
        return path

    def test_rms_target_holds_on_the_decoded_mesh(self):
        for name, shape in (("torus", bumpy_torus()), ("sheet", wavy_sheet())):
            with self.subTest(name):
                mesh = self.obj(shape)
                stream, report = self.encode(mesh, "--rms-error", "0.05%", "-e", "2")
                self.assertTrue(report["target"]["met"])
                self.assertEqual(report["flippedTriangles"], 0)
                measured = self.decode_and_compare(mesh, stream)
                self.assertLessEqual(measured["relativeRms"], 0.0005)
                self.assertAlmostEqual(measured["rms"], report["rmsError"], delta=0.01 * report["rmsError"])

    def test_the_sphere_as_domain_with_every_kind_of_base(self):
        mesh = self.obj(bumpy_sphere())
        for options, base in ((["--base", "6"], 6), (["--base", "12"], 12), (["--base", "40"], 40), ([], None)):
            with self.subTest(base=base):
                stream, report = self.encode(mesh, "--domain", "sphere", "--rms-error", "0.1%", "-e", "1", *options)
                self.assertTrue(report["target"]["met"])
                self.assertEqual(report["flippedTriangles"], 0)
                if base:
                    self.assertEqual(report["base"]["vertices"], base)
                self.assertLessEqual(self.decode_and_compare(mesh, stream)["relativeRms"], 0.001)

    def test_the_sphere_is_refused_for_a_torus_and_left_out_by_auto(self):
        mesh = self.obj(bumpy_torus())
        done = run(ENCODE, mesh, "-o", self.folder / "out.nmc", "--domain", "sphere", "--rms-error", "0.1%", "-e", "1")
        self.assertEqual(done.returncode, 5, done.stderr.decode())
        self.assertIn(b"genus", done.stderr)
        stream, _ = self.encode(mesh, "--domain", "auto", "--rms-error", "0.1%", "-e", "1")
        self.assertLessEqual(self.decode_and_compare(mesh, stream)["relativeRms"], 0.001)

    def test_a_remesh_is_coded_on_its_own_base_mesh(self):
        shape, base = remesh()
        mesh, base_mesh = self.obj(shape), self.obj(base, "base.obj")
        for options, size in (([], None), (["--levels", "2"], 480), (["--base", "100"], 120),
                              (["--base-mesh", base_mesh], 30), (["--base-mesh", base_mesh, "--levels", "4"], 30)):
            with self.subTest(options=options):
                stream, report = self.encode(mesh, "--domain", "input", "--rms-error", "0.05%", "-e", "1", *options)
                self.assertEqual(report["domain"], "input")
                self.assertEqual(report["flippedTriangles"], 0)
                if size:
                    self.assertEqual(report["base"]["vertices"], size)
                self.assertLessEqual(self.decode_and_compare(mesh, stream)["relativeRms"], 0.0005)
        stream, _ = self.encode(mesh, "--domain", "input", "--max-error", "0.3%", "-e", "1")
        self.assertLessEqual(self.decode_and_compare(mesh, stream)["relativeMax"], 0.003)

    def test_an_open_remesh_keeps_its_boundary(self):
        vertices, faces = split(wavy_sheet(3), 4)
        vertices = [(x, y, 0.1 * math.sin(6 * x) * math.cos(5 * y)) for x, y, _ in vertices]
        mesh = self.obj((vertices, faces))
        stream, report = self.encode(mesh, "--domain", "input", "--rms-error", "0.05%", "-e", "1")
        self.assertLess(report["base"]["vertices"], 17)
        self.assertLessEqual(self.decode_and_compare(mesh, stream)["relativeRms"], 0.0005)

    def test_auto_takes_the_input_s_own_base_mesh_where_it_is_better_only(self):
        shape, _ = remesh()
        mesh = self.obj(shape)
        sizes = {}
        for domain in ("general", "input", "auto"):
            stream, report = self.encode(mesh, "--domain", domain, "--rms-error", "0.02%", "-e", "2")
            self.assertTrue(report["target"]["met"])
            sizes[domain] = report["bytes"]
        self.assertEqual(sizes["auto"], min(sizes["general"], sizes["input"]))
        self.assertEqual(report["domain"], min(("general", "input"), key=sizes.get))
        self.assertLessEqual(self.decode_and_compare(mesh, stream)["relativeRms"], 0.0002)

    def test_a_mesh_without_a_base_mesh_of_its_own_is_refused_with_the_reason(self):
        shape, base = remesh(2)
        remeshed, base_mesh = self.obj(shape), self.obj(base, "base.obj")
        scan, other = self.obj(bumpy_sphere(), "scan.obj"), self.obj(bumpy_torus(6, 5), "other.obj")
        for mesh, options, code, reason in (
                (scan, [], 3, b"no base mesh of its own"),
                (remeshed, ["--levels", "9"], 3, b"9 times"),
                (scan, ["--base-mesh", base_mesh], 3, b"triangles are not"),
                (remeshed, ["--base-mesh", other], 3, b"is no vertex of the input"),
                (remeshed, ["--base-mesh", base_mesh, "--levels", "3"], 3, b"after 2 splits, not 3"),
                (remeshed, ["--base-mesh", self.folder / "missing.obj"], 2, b"missing.obj"),
                (remeshed, ["--base-mesh", base_mesh, "--base", "30"], 1, b"exclude"),
                (remeshed, ["--base-mesh", base_mesh, "--domain", "auto"], 1, b"--domain input")):
            with self.subTest(options=options):
                domain = [] if "--domain" in options else ["--domain", "input"]
                done = run(ENCODE, mesh, "-o", self.folder / "no.nmc", *domain, *options)
                self.assertEqual(done.returncode, code, done.stderr.decode())
                self.assertIn(reason, done.stderr)
                self.assertFalse((self.folder / "no.nmc").exists())

    def test_max_target_holds_on_the_decoded_mesh(self):
        mesh = self.obj(bumpy_torus())
        stream, _ = self.encode(mesh, "--max-error", "0.3%", "-e", "2")
        self.assertLessEqual(self.decode_and_compare(mesh, stream)["relativeMax"], 0.003)

    def test_size_target_bounds_the_file(self):
        stream, report = self.encode(self.obj(bumpy_torus()), "--size", "1500B", "-e", "2")
        self.assertLessEqual(stream.stat().st_size, 1500)
        self.assertEqual(stream.stat().st_size, report["bytes"])

    def test_real_scan_meets_its_target(self):
        mesh = CORPUS / "bimba.off"
        if not mesh.is_file():
            self.assertFalse(os.environ.get("CI"), f"{mesh} is missing")
            self.skipTest(f"{mesh} is missing")
        stream, report = self.encode(mesh, "--rms-error", "0.05%", "-e", "2")
        self.assertTrue(report["target"]["met"])
        self.assertLessEqual(self.decode_and_compare(mesh, stream)["relativeRms"], 0.0005)
        hashes = run(DECODE, stream, "--hash", "--no-output")
        self.assertEqual(hashes.returncode, 0, hashes.stderr.decode())
        self.assertIn(report["positionHash"], hashes.stdout.decode())
        self.assertIn(report["stateHash"], hashes.stdout.decode())

    def test_layers_give_better_prefixes_of_one_file(self):
        mesh = self.obj(bumpy_torus())
        stream, report = self.encode(mesh, "--rms-error", "0.02%", "-e", "1", "--layers", "3")
        errors = [layer["rmsError"] for layer in report["layers"]]
        self.assertEqual(errors[-1], min(errors))
        self.assertLess(errors[-1], 0.9 * errors[0])
        data = stream.read_bytes()
        for layer in report["layers"][:-1]:
            cut = self.folder / "cut.nmc"
            cut.write_bytes(data[:layer["endByte"]])
            decoded = self.folder / "cut.ply"
            self.assertEqual(run(DECODE, cut, "-o", decoded, "-f").returncode, 8)
            self.assertEqual(run(DECODE, cut, "-o", decoded, "-f", "--allow-partial").returncode, 0)
            compared = json.loads(run(COMPARE, mesh, decoded, "--json").stdout)
            self.assertAlmostEqual(compared["rms"], layer["rmsError"], delta=0.01 * layer["rmsError"])

    def test_regions_come_alone_and_together_they_are_the_whole(self):
        mesh = self.obj(bumpy_torus())
        options = ("--rms-error", "0.05%", "-e", "1", "--levels", "3", "--base", "100")
        plain = self.encode(mesh, *options)[0].read_bytes()
        stream, report = self.encode(mesh, *options, "--regions", "4")
        self.assertLess(len(stream.read_bytes()), len(plain) + 4 * 60)
        rows = [row for row in json.loads(run(INFO, "--json", stream).stdout)["layers"] if "region" in row]
        self.assertEqual([row["region"] for row in rows], [0, 1, 2, 3])
        errors = []
        for regions in ("2", "0,2", "0,1,2,3"):
            decoded = self.folder / "part.ply"
            self.assertEqual(run(DECODE, stream, "-o", decoded, "-f", "--regions", regions).returncode, 0)
            errors.append(json.loads(run(COMPARE, mesh, decoded, "--json").stdout)["rms"])
        self.assertEqual(errors, sorted(errors, reverse=True))
        self.assertAlmostEqual(errors[-1], report["layers"][-1]["rmsError"], delta=0.01 * errors[-1])
        coarse = run(ENCODE, mesh, "--rms-error", "5%", "-e", "1", "--levels", "1", "--regions", "4", "-f",
                     "-o", self.folder / "coarse.nmc")
        self.assertEqual(coarse.returncode, 0)
        self.assertIn("regions: none of the 4", coarse.stderr.decode())

    def test_same_bytes_with_one_and_two_threads(self):
        mesh = self.obj(bumpy_torus())
        one = self.encode(mesh, "--rms-error", "0.05%", "-e", "3", "-j", "1")[0].read_bytes()
        two = self.encode(mesh, "--rms-error", "0.05%", "-e", "3", "-j", "2")[0].read_bytes()
        self.assertEqual(one, two)

    def test_pipes_carry_mesh_and_stream(self):
        mesh = self.obj(wavy_sheet(12))
        encoded = run(ENCODE, "-", "--format", "obj", "-o", "-", "-e", "1", "--rms-error", "0.1%", "--quiet",
                      input=mesh.read_bytes())
        self.assertEqual(encoded.returncode, 0, encoded.stderr.decode())
        decoded = run(DECODE, "-", "-o", "-", "--format", "obj", input=encoded.stdout)
        self.assertEqual(decoded.returncode, 0, decoded.stderr.decode())
        self.assertIn(b"\nf ", decoded.stdout)

    def test_verify_decodes_the_finished_bytes_and_agrees(self):
        done = run(ENCODE, self.obj(wavy_sheet(12)), "-o", self.folder / "out.nmc", "-e", "1", "--rms-error", "0.1%",
                   "--verify")
        self.assertEqual(done.returncode, 0, done.stderr.decode())
        self.assertIn(b"verified: decoded again", done.stderr)

    def test_dry_run_writes_nothing(self):
        mesh = self.obj(wavy_sheet(12))
        before = sorted(self.folder.iterdir())
        done = run(ENCODE, mesh, "-e", "1", "--rms-error", "0.1%", "--dry-run")
        self.assertEqual(done.returncode, 0, done.stderr.decode())
        self.assertIn(b"nothing written", done.stderr)
        self.assertEqual(sorted(self.folder.iterdir()), before)

    def test_vertex_map_gives_an_address_for_every_vertex(self):
        shape = wavy_sheet(12)
        table = self.folder / "map.csv"
        _, report = self.encode(self.obj(shape), "-e", "1", "--rms-error", "0.1%", "--emit-map", table)
        lines = table.read_text().splitlines()
        self.assertEqual(lines[0], "vertex,base_face,u,v,height")
        self.assertEqual(len(lines), 1 + len(shape[0]))
        for line in lines[1:]:
            _, face, u, v, height = line.split(",")
            self.assertIn(int(face), range(report["base"]["triangles"]))
            self.assertGreaterEqual(min(float(u), float(v), 1 - float(u) - float(v)), -1e-9, line)
            self.assertLess(abs(float(height)), 0.05, line)

    def test_batch_goes_on_after_a_broken_file_and_says_so(self):
        meshes = self.folder / "in"
        meshes.mkdir()
        for name in ("a.obj", "c.obj"):
            write_obj(meshes / name, *wavy_sheet(8))
        (meshes / "b.ply").write_bytes(b"ply\nnonsense\n")
        (meshes / "notes.txt").write_text("not a mesh")
        done = run(ENCODE, "--batch", meshes, "--output-dir", self.folder / "out", "-e", "1", "--rms-error", "0.1%")
        self.assertEqual(done.returncode, 3, done.stderr.decode())
        self.assertEqual(sorted(p.name for p in (self.folder / "out").iterdir()), ["a.nmc", "c.nmc"])
        self.assertIn(b"2 of 3 files encoded as asked", done.stderr)

    def test_one_output_for_many_inputs_is_a_usage_error(self):
        a, b = self.obj(wavy_sheet(4), "a.obj"), self.obj(wavy_sheet(4), "b.obj")
        self.assertEqual(run(ENCODE, a, b, "-o", self.folder / "x.nmc").returncode, 1)
        other = self.folder / "sub"
        other.mkdir()
        write_obj(other / "a.obj", *wavy_sheet(4))
        done = run(ENCODE, a, other / "a.obj", "--output-dir", self.folder / "out")
        self.assertEqual(done.returncode, 1)
        self.assertIn(b"would both become", done.stderr)

    def test_limits_of_memory_and_time_end_with_their_exit_code(self):
        mesh = self.obj(bumpy_torus())
        for limit in (("--memory-limit", "150MB"), ("--timeout", "0.01")):
            done = run(ENCODE, mesh, "-o", self.folder / "out.nmc", *limit)
            self.assertEqual(done.returncode, 6, (limit, done.stderr.decode()))
            self.assertFalse((self.folder / "out.nmc").exists())

    def test_tiny_and_flat_surfaces_are_encoded(self):
        shapes = {
            "triangle": ([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1, 2)]),
            "tetrahedron": ([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)],
                            [(0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)]),
            "plane": ([(x, y, 0) for y in range(20) for x in range(20)],
                      [f for y in range(19) for x in range(19) for a in [y * 20 + x]
                       for f in ((a, a + 1, a + 21), (a, a + 21, a + 20))]),
            "far away": ([(1e7 + 0.001 * x, 2e6 + 0.001 * y, 0.0005 * math.sin(x)) for y in range(20) for x in range(20)],
                         [f for y in range(19) for x in range(19) for a in [y * 20 + x]
                          for f in ((a, a + 1, a + 21), (a, a + 21, a + 20))]),
        }
        for name, shape in shapes.items():
            with self.subTest(name):
                path = self.folder / "tiny.obj"
                with open(path, "w", encoding="ascii") as file:
                    for vertex in shape[0]:
                        file.write("v %.17g %.17g %.17g\n" % tuple(vertex))
                    for face in shape[1]:
                        file.write("f %d %d %d\n" % tuple(i + 1 for i in face))
                stream, _ = self.encode(path, "--rms-error", "0.2%", "-e", "1")
                self.assertLessEqual(self.decode_and_compare(path, stream)["relativeRms"], 0.002)

    def test_loose_triangles_get_no_more_levels_than_their_base_needs(self):
        vertices, faces = [], []
        for i in range(400):  # each is a component of its own, so the base is the surface itself
            x, y, z = 7 * (i % 20), 7 * (i // 20), 3 * math.sin(i)
            vertices += [(x, y, z), (x + 2, y, z + 1), (x, y + 2, z)]
            faces.append((3 * i, 3 * i + 1, 3 * i + 2))
        _, report = self.encode(self.obj((vertices, faces)), "-e", "1")
        self.assertTrue(report["target"]["met"])
        self.assertLessEqual(report["layers"][-1]["triangles"], 4 * len(faces))

    def test_useless_input_is_refused_with_a_reason(self):
        cases = {
            "empty.obj": "",
            "no_faces.obj": "v 0 0 0\nv 1 0 0\nv 0 1 0\n",
            "line.obj": "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n",
            "not_numbers.obj": "v nan 0 0\nv 1 0 inf\nv 0 1 0\nf 1 2 3\n",
            "bad_index.obj": "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n",
            "empty.ply": "",
            "cut.ply": "ply\nformat binary_little_endian 1.0\nelement vertex 3\n",
        }
        for name, text in cases.items():
            with self.subTest(name):
                mesh = self.folder / name
                mesh.write_text(text)
                done = run(ENCODE, mesh, "-o", self.folder / "no.nmc", "--quiet")
                self.assertEqual(done.returncode, 3, done.stderr.decode())
                self.assertIn(name, done.stderr.decode())
                self.assertGreater(len(done.stderr), 20 + len(name))
                self.assertFalse((self.folder / "no.nmc").exists())

    def test_mistakes_on_the_command_line_have_their_codes(self):
        mesh = self.obj(wavy_sheet(8))
        existing = self.folder / "exists.nmc"
        existing.write_bytes(b"precious")
        cases = [
            (1, [mesh, "--no-such-option"]),
            (1, [mesh, "--max-error", "1%", "--size", "1kB"]),
            (1, [mesh, "--max-error", "soon"]),
            (1, [mesh, "--max-error", "1mm"]),  # units of the input are not known
            (2, [self.folder / "missing.obj"]),
            (2, [mesh, "-o", existing]),
        ]
        for code, arguments in cases:
            with self.subTest(arguments=arguments):
                self.assertEqual(run(ENCODE, *arguments).returncode, code)
        self.assertEqual(existing.read_bytes(), b"precious")

    def color_psnr(self, mesh, stream):
        compared = run(COMPARE, mesh, stream, "--json")
        self.assertEqual(compared.returncode, 0, compared.stderr.decode())
        return json.loads(compared.stdout)["rgbPsnrDb"]

    def test_colours_come_back_at_the_ratio_asked_for(self):
        mesh = self.obj(painted(bumpy_torus()))
        ratios = []
        for wanted in (32, 40):
            stream, report = self.encode(mesh, "-E", "0.3%", "-e", "1", "--base", "64", "--colour", str(wanted))
            self.assertTrue(report["colors"]["met"])
            self.assertGreater(report["colors"]["bytes"], 50)
            ratios.append(self.color_psnr(mesh, stream))
            self.assertGreater(ratios[-1], wanted - 1.5)
        self.assertGreater(ratios[1], ratios[0])
        for name, mark in (("out.ply", b"property uchar red"), ("out.off", b"COFF"), ("out.glb", b"COLOR_0")):
            path = self.folder / name
            self.assertEqual(run(DECODE, stream, "-o", path, "-f").returncode, 0)
            self.assertIn(mark, path.read_bytes()[:2000])
        path = self.folder / "decoded.obj"
        self.assertEqual(run(DECODE, stream, "-o", path, "-f").returncode, 0)
        first = next(line for line in path.read_text().splitlines() if line.startswith("v "))
        self.assertEqual(len(first.split()), 7, first)

    def test_without_colours_the_stream_is_that_of_the_bare_mesh(self):
        options = ("-E", "1%", "-e", "1", "--base", "40", "--levels", "2")
        bare = self.encode(self.obj(wavy_sheet(), "bare.obj"), *options)[0].read_bytes()
        colored = self.obj(painted(wavy_sheet()), "colored.obj")
        done = run(ENCODE, colored, "-o", self.folder / "off.nmc", "--colour", "off", *options)
        self.assertEqual(done.returncode, 0)
        self.assertIn(b"vertex colours", done.stderr)
        self.assertEqual((self.folder / "off.nmc").read_bytes(), bare)

    def test_a_size_holds_geometry_and_colours(self):
        stream, report = self.encode(self.obj(painted(bumpy_torus())), "--size", "3kB", "-e", "1", "--base", "64")
        self.assertLessEqual(stream.stat().st_size, 3000)
        self.assertGreater(report["colors"]["psnrDb"], 25)

    def test_a_ratio_that_makes_no_sense_is_refused(self):
        mesh = self.obj(painted(wavy_sheet()))
        for text in ("19", "61", "much", "38dB", "nan"):
            done = run(ENCODE, mesh, "-o", self.folder / "no.nmc", "--colour", text)
            self.assertEqual(done.returncode, 1, text)
            self.assertIn(b"--colour", done.stderr)

    def test_colours_of_scans(self):
        mesh = CORPUS / "Laurana50k.ply"
        if not mesh.exists():
            self.skipTest("the corpus is not there")
        stream, report = self.encode(mesh, "--rms-error", "0.1%", "-e", "1", "--base", "200", "--levels", "3")
        ratio = self.color_psnr(mesh, stream)
        print("Laurana50k.ply: %.2f dB in %d of %d bytes" % (ratio, report["colors"]["bytes"], report["bytes"]))
        self.assertGreater(ratio, 37)


if __name__ == "__main__":
    unittest.main()
