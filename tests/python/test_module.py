"""The Python module: the same meshes as the program's, as arrays; errors; stopping."""
import filecmp
import math
import os
import pathlib
import signal
import subprocess
import tempfile
import threading
import time
import unittest
import weakref

import numpy

import mortise

SOURCE = pathlib.Path(__file__).parents[2]
BRACKET = SOURCE / "assets" / "models" / "bracket.csg"
BALL = "sphere(r = 1);"


def volumes(mesh):
    """By the divergence theorem over the facets, in numpy alone."""
    facets = mesh.facets
    p = mesh.points[facets.nodes]
    first, second = p[:, 2] - p[:, 0], p[:, 3] - p[:, 1]
    middle = p.mean(axis=1)
    is_triangle = facets.nodes[:, 2] == facets.nodes[:, 3]
    middle[is_triangle] = p[is_triangle, :3].mean(axis=1)
    flux = (numpy.cross(first, second) * middle).sum(axis=1) / 6
    outer = facets.outside == 0
    return flux[outer].sum()


class Module(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.mesher = mortise.Mesher()
        cls.ball = mortise.parse_model(BALL, "csg", "ball.csg")

    def test_estimate(self):
        guess = self.mesher.estimate(self.ball, level=5)
        self.assertTrue(guess.is_exact)
        self.assertEqual(guess.nodes, len(self.mesher.generate(self.ball, level=5).points))

    def test_arrays(self):
        mesh = self.mesher.generate(self.ball, level=5)
        self.assertEqual(mesh.points.shape[1], 3)
        self.assertEqual(mesh.hexahedra.nodes.shape, (len(mesh.hexahedra), 8))
        self.assertEqual(mesh.tetrahedra.nodes.shape, (len(mesh.tetrahedra), 4))
        self.assertEqual(mesh.facets.nodes.shape, (len(mesh.facets), 4))
        self.assertLess(mesh.hexahedra.nodes.max(), len(mesh.points))
        self.assertEqual(set(mesh.hexahedra.region), {1})
        self.assertEqual(len(mesh.region_names), 1)
        self.assertEqual(len(mesh.surface_names), 1)
        distance = numpy.linalg.norm(mesh.points, axis=1)
        on_face = mesh.model_dimension == 2
        self.assertLess(abs(distance[on_face] - 1).max(), 1e-6)
        self.assertLess(distance[mesh.model_dimension == 3].max(), 1)
        check = mesh.check()
        self.assertTrue(check.valid)
        self.assertAlmostEqual(check.volume, 4 / 3 * math.pi, delta=0.02)
        self.assertAlmostEqual(volumes(mesh), check.volume, places=4)
        jacobians = mesh.report.scaled_jacobians
        count = sum(len(block) for block in (mesh.hexahedra, mesh.wedges, mesh.pyramids, mesh.tetrahedra))
        self.assertEqual(len(jacobians), count)
        self.assertGreater(jacobians.min(), 0.19)

    def test_arrays_outlive_the_mesh(self):
        mesh = self.mesher.generate(self.ball, level=4)
        for get in (lambda m: m.hexahedra.nodes, lambda m: m.facets.nodes, lambda m: m.report.scaled_jacobians,
                    lambda m: m.points):
            other = self.mesher.generate(self.ball, level=3)
            alive = weakref.ref(other)
            array = get(other)
            del other
            self.assertIsNotNone(alive())
            del array
            self.assertIsNone(alive())
        points, nodes = mesh.points, mesh.tetrahedra.nodes
        total, highest = points.sum(), nodes.max()
        del mesh
        self.mesher.generate(self.ball, level=4)
        self.assertEqual(points.sum(), total)
        self.assertEqual(nodes.max(), highest)
        with self.assertRaises(ValueError):
            points[0, 0] = 1

    def test_cells_in_the_order_of_vtk(self):
        mesh = self.mesher.generate(self.ball, level=4, layers=2)
        cells = mesh.cells()
        self.assertEqual(set(cells), {"hexahedron", "wedge", "pyramid", "tetra"})
        wedges = mesh.points[cells["wedge"]]
        # VTK's documentation: the first triangle's normal points away from the second one.
        normal = numpy.cross(wedges[:, 1] - wedges[:, 0], wedges[:, 2] - wedges[:, 0])
        up = wedges[:, 3:].mean(axis=1) - wedges[:, :3].mean(axis=1)
        self.assertTrue(((normal * up).sum(axis=1) < 0).all())
        self.assertTrue((numpy.sort(cells["wedge"]) == numpy.sort(mesh.wedges.nodes)).all())

    def test_the_same_file_as_the_program(self):
        with tempfile.TemporaryDirectory() as folder:
            ours, theirs = pathlib.Path(folder, "a.vtu"), pathlib.Path(folder, "b.vtu")
            mesh = self.mesher.generate(mortise.read_model(BRACKET), level=5, refine=1, min_angle=20)
            mesh.write(ours)
            subprocess.run([os.environ["MORTISE"], str(BRACKET), "-o", str(theirs), "--level", "5", "--refine",
                            "1", "--min-angle", "20", "--quiet"], check=True)
            self.assertTrue(filecmp.cmp(ours, theirs, shallow=False))
            again = mortise.read_mesh(ours)
            self.assertTrue((again.points == mesh.points).all())
            self.assertEqual(again.surface_names, mesh.surface_names)
            mesh.write_picture(pathlib.Path(folder, "a.png"), 300, 200)
            mesh.write_picture(pathlib.Path(folder, "b.png"), cut="z", at=0.5)
            mesh.write_features(pathlib.Path(folder, "a.vtp"))
            with self.assertRaisesRegex(mortise.Error, "has no features"):
                again.write_features(pathlib.Path(folder, "b.vtp"))
            with self.assertRaisesRegex(ValueError, "expected 'x', 'y' or 'z'"):
                mesh.write_picture(pathlib.Path(folder, "c.png"), cut="w")
            self.assertGreater(pathlib.Path(folder, "a.png").stat().st_size, 1000)

    def test_options(self):
        box = mortise.parse_model("cube([2, 1, 1]);", "csg")
        mesh = self.mesher.generate(
            box, size=0.25, tetrahedra=True, sizes=[((0, 0, 0), 0.1, 0.5)], named_sizes={"cube1_xmax": 0.2},
            box=((-1, -1, -1), (1.5, 2, 2)))
        self.assertAlmostEqual(mesh.check().volume, 1.5, places=9)
        self.assertEqual(len(mesh.hexahedra), 0)
        self.assertIn("box_xmax", mesh.surface_names)
        layered = self.mesher.generate(box, level=4, layers={"count": 2, "first": 0.01, "growth": 1.5,
                                                             "on": ["cube1_xmin"]})
        self.assertEqual(layered.report.layers.elements, 2 * layered.report.layers.facets)
        self.assertEqual(layered.report.layers.bare, 0)
        second = self.mesher.generate(box, level=3, second_order=True)
        self.assertEqual(second.hexahedra.middles.shape, (len(second.hexahedra), 12))
        with self.assertRaisesRegex(mortise.Error, "first order"):
            second.cells()

    def test_periodic(self):
        sheet = mortise.parse_model("gyroid(size = [3, 3, 3], period = 1, thickness = 0.2);", "csg")
        mesh = self.mesher.generate(sheet, level=4, box=((0, 0, 0), (1, 1, 1)), periodic="xyz")
        self.assertEqual([list(pair.shift) for pair in mesh.periodic], [[1, 0, 0], [0, 1, 0], [0, 0, 1]])
        for pair in mesh.periodic:
            self.assertEqual(len(pair), len(pair.nodes))
            self.assertGreater(len(pair), 50)
            gap = mesh.points[pair.nodes] - mesh.points[pair.originals] - pair.shift
            self.assertLess(abs(gap).max(), 1e-12)
        self.assertEqual(len(self.mesher.generate(self.ball, level=3).periodic), 0)

    def test_summary(self):
        summary = mortise.summarize(mortise.read_model(str(BRACKET)))
        self.assertIn("cube1_xmin", summary.surfaces)
        low, high = summary.bounds
        self.assertLess(low[0], high[0])

    def test_errors(self):
        with self.assertRaisesRegex(mortise.Error, "cannot be read") as caught:
            mortise.read_model("no_such_file.csg")
        self.assertEqual(caught.exception.exit_code, 6)
        with self.assertRaisesRegex(mortise.Error, "a.csg:1:") as caught:
            mortise.parse_model("cubes([1, 1]);", "csg", "a.csg")
        self.assertEqual(caught.exception.exit_code, 2)
        with self.assertRaisesRegex(mortise.Error, "level 99 is out of range") as caught:
            self.mesher.generate(self.ball, level=99)
        self.assertEqual(caught.exception.exit_code, 1)
        self.assertIsInstance(caught.exception, RuntimeError)
        with self.assertRaisesRegex(TypeError, "there is no option 'levle'; there are progress, level, "):
            self.mesher.generate(self.ball, levle=4)
        with self.assertRaisesRegex(TypeError, "option 'level': expected a whole number, not 'six'"):
            self.mesher.generate(self.ball, level="six")
        with self.assertRaisesRegex(TypeError, "option 'layers' has no member 'height'"):
            self.mesher.generate(self.ball, layers={"count": 1, "height": 3})
        for layers, said in ((2.5, "expected a whole number, or a dict"), ("3", "expected a whole number"),
                             ({3: 4, "count": 1}, "names of members"), ({"first": 0.1}, "a member 'count'")):
            with self.assertRaisesRegex(TypeError, "option 'layers': " + ".*" + said):
                self.mesher.generate(self.ball, layers=layers)
        with self.assertRaisesRegex(TypeError, "option 'progress'"):
            self.mesher.generate(self.ball, progress=3)

    def test_progress(self):
        seen = []
        self.mesher.generate(self.ball, level=4, progress=lambda stage, share: seen.append((stage, share)))
        self.assertIn("octree", [stage for stage, _ in seen])
        shares = [share for _, share in seen]
        self.assertEqual(shares, sorted(shares))
        with self.assertRaisesRegex(mortise.Error, "interrupted"):
            self.mesher.generate(self.ball, level=4, progress=lambda stage, share: stage != "classify")

        def fail(stage, share):
            raise KeyError(stage)

        with self.assertRaises(KeyError):
            self.mesher.generate(self.ball, level=4, progress=fail)
        # After all that the mesher works.
        self.assertTrue(self.mesher.generate(self.ball, level=3).check().valid)

    def test_numbers_of_numpy(self):
        mesh = self.mesher.generate(self.ball, level=numpy.int64(4), layers=numpy.int32(2))
        self.assertEqual(mesh.report.layers.elements, 2 * mesh.report.layers.facets)

    def test_fork(self):
        self.mesher.generate(self.ball, level=3)
        child = os.fork()
        if child == 0:
            try:
                mortise.generate(self.ball, level=3)
            except mortise.Error as error:
                os._exit(7 if "forked" in str(error) else 8)
            os._exit(0)
        self.assertEqual(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), 7)

    def test_interrupt(self):
        gyroid = mortise.parse_model("sin(x)*cos(y) + sin(y)*cos(z) + sin(z)*cos(x)", "formula")
        timer = threading.Timer(1.0, os.kill, (os.getpid(), signal.SIGINT))
        timer.start()
        start = time.monotonic()
        with self.assertRaises(KeyboardInterrupt):
            self.mesher.generate(gyroid, level=10, box=((0, 0, 0), (40, 40, 40)))
        self.assertLess(time.monotonic() - start, 30)
        timer.join()


if __name__ == "__main__":
    unittest.main()
