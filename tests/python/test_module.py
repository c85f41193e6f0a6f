"""The Python module: the same meshes as the program's, as arrays; errors; stopping."""
import copy
import filecmp
import math
import os
import pathlib
import re
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

    def test_cells_of_second_order_in_the_order_of_vtk(self):
        # Corners of each node in the middle of an edge, as VTK's documentation numbers them.
        edges = {"hexahedron20": "01 12 23 30 45 56 67 74 04 15 26 37", "wedge15": "01 12 20 34 45 53 03 14 25",
                 "pyramid13": "01 12 23 30 04 14 24 34", "tetra10": "01 12 20 03 13 23"}
        mesh = self.mesher.generate(mortise.cylinder(2, 0.7), level=5, second_order=True)
        cells = mesh.cells()
        self.assertEqual(set(cells), set(edges))
        for name, nodes in cells.items():
            pairs = numpy.array([[int(a), int(b)] for a, b in edges[name].split()])
            points = mesh.points[nodes]
            corners = nodes.shape[1] - len(pairs)
            middle = 0.5 * (points[:, pairs[:, 0]] + points[:, pairs[:, 1]])
            length = numpy.linalg.norm(points[:, pairs[:, 0]] - points[:, pairs[:, 1]], axis=2)
            self.assertLess((numpy.linalg.norm(points[:, corners:] - middle, axis=2) / length).max(), 0.2)

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
        self.assertRegex(repr(second.check()), "^<mortise.CheckReport: valid, volume 2, area 10, Euler characteristic 2, components 1>$")

    def test_size_formulas(self):
        x, y, z = mortise.coordinates()
        sizes = [self.mesher.generate(self.ball, level=4, size_formula=formula).report.leaves
                 for formula in ("0.05 + 0.1*abs(x)", 0.05 + 0.1 * abs(x), lambda x, y, z: 0.05 + 0.1 * abs(x))]
        self.assertEqual(sizes[0], sizes[1])
        self.assertEqual(sizes[0], sizes[2])
        self.assertGreater(len(sizes[0]), 5)
        with self.assertRaisesRegex(TypeError, "option 'size_formula': expected a formula"):
            self.mesher.generate(self.ball, level=4, size_formula=[1])

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

    def test_solids(self):
        plate = mortise.box((0, 0, 0), (6, 4, 0.5)).named("plate")
        hole = mortise.cylinder(radius=0.5, height=0.5).named("hole")
        part = plate - hole.translate((1.5, 2, 0)) - hole.translate((4.5, 2, 0))
        mesh = self.mesher.generate(part, level=6)
        self.assertTrue(mesh.check().valid)
        self.assertAlmostEqual(mesh.check().volume, 12 - math.pi / 4, delta=0.01)
        self.assertEqual(mesh.surface_names[-1], "hole")
        self.assertEqual(mesh.region_names, ["solid"])
        both = self.mesher.generate({"steel": part, "resin": mortise.box((0, 0, 0), (6, 4, 1))}, level=5)
        self.assertEqual(both.region_names, ["steel", "resin"])
        self.assertAlmostEqual(sum(both.check().region_volume), 24, places=9)
        named = mortise.Model(part, region="body")
        self.assertEqual(named.regions, ["body"])
        self.assertEqual(list(named.solids), ["body"])
        self.assertEqual(list(self.mesher.generate(named.solids["body"] & mortise.half_space((3, 0, 0), (1, 0, 0)),
                                                   level=4).report.warnings), [])

    def volume(self, solid, level=5):
        check = self.mesher.generate(solid, level=level).check()
        self.assertTrue(check.valid)
        return check.volume

    def test_kinds_of_solids(self):
        quarter = mortise.box((0, 0, -9), (9, 9, 9))
        self.assertAlmostEqual(self.volume(mortise.sphere(1, (2, 2, 0)) & quarter), 4 / 3 * math.pi, delta=0.02)
        self.assertAlmostEqual(self.volume(mortise.frustum(2, 1, 3)), math.pi * 7, delta=0.1)
        self.assertAlmostEqual(self.volume(mortise.torus(2, 0.5), 6), math.pi ** 2, delta=0.1)
        corners = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
        faces = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]
        self.assertAlmostEqual(self.volume(mortise.polyhedron(corners, faces)), 1 / 6, places=9)
        square = [(0, 0), (4, 0), (4, 4), (0, 4)]
        inner = [(1, 1), (3, 1), (3, 3), (1, 3)]
        frame = mortise.extrude(square, 2, holes=[inner], name="frame")
        self.assertAlmostEqual(self.volume(frame), 24, places=9)
        across = mortise.extrude(square, 1, holes=[[(2, 1), (9, 1), (9, 3), (2, 3)]])
        self.assertAlmostEqual(self.volume(across), 12, places=8)
        self.assertAlmostEqual(self.volume(copy.deepcopy(frame)), 24, places=9)
        self.assertTrue(all(name.startswith("frame_") for name in self.mesher.generate(frame, level=4).surface_names))
        self.assertAlmostEqual(self.volume(mortise.extrude(square, 3, scale=0.5)), 16 * (1 + 0.5 + 0.25), places=6)
        self.assertAlmostEqual(self.volume(mortise.extrude(square, 3, scale=(0.5, 1))), 48 * 0.75, places=6)
        self.assertAlmostEqual(self.volume(mortise.rod((0, 0, 0), (0, 0, 5), 1)), math.pi * (5 + 4 / 3), delta=0.4)
        self.assertAlmostEqual(self.volume(mortise.rod((0, 0, 0), (0.1, 0, 0), 1, end_radius=0.5)), math.pi * 4 / 3, delta=0.1)
        nodes = numpy.array([[0, 0, 0], [4, 0, 0], [0, 4, 0], [0, 0, 4]])
        edges = numpy.array([[0, 1], [0, 2], [0, 3], [1, 2], [2, 3], [3, 1]])
        for radius in (0.5, numpy.linspace(0.4, 0.6, len(edges))):
            check = self.mesher.generate(mortise.lattice(nodes, edges, radius), level=6).check()
            self.assertEqual((check.components, check.euler_characteristic), (1, -4))
        self.assertAlmostEqual(self.volume(sum(mortise.box((2 * i, 0, 0), (2 * i + 1, 1, 1)) for i in range(3))), 3, places=9)
        self.assertAlmostEqual(self.volume(mortise.revolve([(1, 0), (2, 0), (2, 1)]), 6), math.pi * 5 / 3, delta=0.02)
        hull = mortise.csg("hull() { sphere(1); translate([3, 0, 0]) sphere(1); }")
        self.assertAlmostEqual(self.volume(hull), math.pi * (4 / 3 + 3), delta=0.2)
        cubes = mortise.unite(mortise.box((i, 0, 0), (i + 0.5, 1, 1)) for i in range(5))
        self.assertAlmostEqual(self.volume(cubes), 2.5, places=8)
        self.assertAlmostEqual(self.volume(mortise.intersect([cubes, ~mortise.box((-1, -1, -1), (2.25, 2, 2))])), 1.25,
                               places=9)
        turn = numpy.array([[0, -1, 0, 5], [1, 0, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]])
        moved = self.mesher.generate(mortise.box((0, 0, 0), (2, 1, 1)).transform(turn), level=3)
        self.assertTrue(numpy.allclose(moved.points.min(axis=0), [4, 0, 0]))
        sized = self.mesher.generate(mortise.sphere(1).sized(0.05), level=4)
        self.assertGreater(sized.report.finest_level, 4)

    def test_formulas(self):
        x, y, z = mortise.coordinates()
        ball = mortise.implicit(numpy.sqrt(x**2 + y**2 + z * z) - 1)
        self.assertAlmostEqual(self.volume(ball), 4 / 3 * math.pi, delta=0.02)
        same = mortise.implicit(lambda x, y, z: x**2 + y**2 + z**2 - numpy.float64(1))
        self.assertAlmostEqual(self.volume(same), 4 / 3 * math.pi, delta=0.02)
        text = mortise.implicit("max(abs(x), abs(y), abs(z)) - 1", bounds=((-2, -2, 0), (2, 2, 2)))
        self.assertAlmostEqual(self.volume(text), 4, places=6)
        # Every operator and function, against numpy's own: |f - value| <= 0.1 where x, y, z are near a point.
        at = numpy.array([0.7, -0.4, 1.3])
        cases = [lambda x, y, z: x + y - 2 * z, lambda x, y, z: 1 - x / (z + 3) + 2 / z, lambda x, y, z: -x**3 + 2**y,
                 lambda x, y, z: +abs(y) % 0.3, lambda x, y, z: x % -2 + y % 0.3, lambda x, y, z: 1 % y + x % z, lambda x, y, z: numpy.mod(z, y),
                 lambda x, y, z: x * numpy.array(2.0), lambda x, y, z: numpy.sin(x) + numpy.cos(y) * numpy.tan(z / 2),
                 lambda x, y, z: numpy.arcsin(x) + numpy.arccos(y) + numpy.arctan(z) + numpy.arctan2(y, x),
                 lambda x, y, z: numpy.exp(y) + numpy.log(z) + numpy.hypot(x, z) + numpy.square(y),
                 lambda x, y, z: numpy.minimum(x, y) + numpy.maximum(y, 0.1) + numpy.clip(z, 0, 1),
                 lambda x, y, z: numpy.floor(z) + numpy.ceil(z) + numpy.sign(y) + numpy.reciprocal(x),
                 lambda x, y, z: numpy.sinh(x) + numpy.cosh(y) + numpy.tanh(z) + numpy.tanh(500 * x) + numpy.tanh(-500 * y),
                 lambda x, y, z: numpy.cbrt(x - 1) + numpy.cbrt(y) + numpy.deg2rad(90 * z) + numpy.rad2deg(x) / 50 + numpy.log2(z) - numpy.log10(x),
                 lambda x, y, z: sum([x, y, z]) * numpy.float32(2) + numpy.negative(z) ** 2]
        for case in cases:
            value = float(case(*at))
            near = mortise.implicit(numpy.maximum(numpy.abs(case(x, y, z) - value) - 0.1,
                                                  numpy.sqrt((x - at[0])**2 + (y - at[1])**2 + (z - at[2])**2) - 0.01))
            self.assertAlmostEqual(self.volume(near) / (4 / 3 * math.pi * 1e-6), 1, delta=0.03)
        blend = mortise.smin(x, mortise.smax(y, z, width=0.5), 1.5) + mortise.smoothstep(low=-1, high=z, a=0.25)
        self.assertIn("smax(y, z, 0.5)", str(blend))
        ball, other = numpy.sqrt(x**2 + y**2 + z**2) - 1, numpy.sqrt((x - 1.7)**2 + y**2 + z**2) - 0.9
        by_hand = numpy.minimum(ball, other) - numpy.maximum(0.6 - abs(ball - other), 0)**2 / 2.4
        self.assertAlmostEqual(self.volume(mortise.implicit(mortise.smin(ball, other, 0.6))), self.volume(mortise.implicit(by_hand)), places=6)
        with self.assertRaisesRegex(TypeError, "smin: expected three numbers or formulas"):
            mortise.smin(x, "y", 1)
        total = x
        for _ in range(50000):
            total = total + 1
        self.assertTrue(str(total).endswith("v50000"))
        self.assertLess(len(repr(total)), 500)
        del total
        for wrong, said in ((lambda: numpy.arctanh(x), "numpy.arctanh is no function"), (lambda: max(x, y), "numpy.maximum of two"), (lambda: x == y, "neither true nor false"),
                            (lambda: 1 if x else 0, "neither true nor false"), (lambda: x + "1", "unsupported"),
                            (lambda: mortise.implicit(lambda x, y, z: None), "expected a formula")):
            with self.assertRaisesRegex(TypeError, said):
                wrong()
        with self.assertRaisesRegex(ValueError, "finite"):
            x * math.inf

    def test_solids_that_are_none(self):
        with self.assertRaisesRegex(mortise.Error, "sphere: radius is -1"):
            mortise.sphere(-1)
        with self.assertRaisesRegex(mortise.Error, "the solid is empty"):
            self.mesher.generate(mortise.sphere(1) - mortise.sphere(2))
        with self.assertRaisesRegex(ValueError, "there are 1 points"):
            mortise.polyhedron([[0, 0, 0]], [[0, 1, 2]])
        with self.assertRaisesRegex(mortise.Error, "edge 0 ends at point 1; there are 1 points"):
            mortise.lattice([[0, 0, 0]], [[0, 1]], 1)
        with self.assertRaisesRegex(ValueError, "edge 0 ends at point -1; expected"):
            mortise.lattice([[0, 0, 0]], [[0, -1]], 1)
        with self.assertRaisesRegex(ValueError, "one for each of the 1 edges"):
            mortise.lattice([[0, 0, 0], [1, 0, 0]], [[0, 1]], [1, 2])
        with self.assertRaisesRegex(ValueError, "count x 2 whole numbers"):
            mortise.lattice([[0, 0, 0], [1, 0, 0]], [[0., 1.]], 1)
        with self.assertRaises(TypeError):
            1 + mortise.sphere(1)
        with self.assertRaisesRegex(mortise.Error, "'q'"):
            mortise.implicit("x^2 + q")
        with self.assertRaisesRegex(ValueError, "a matrix of 3 x 3"):
            mortise.sphere(1).transform([[1, 0], [0, 1]])
        for wrong in ({"a": 3}, {}, {1: mortise.sphere(1)}, 3):
            with self.assertRaisesRegex(TypeError, "a dict of regions' names"):
                self.mesher.generate(wrong)
            with self.assertRaisesRegex(TypeError, "a dict of regions' names"):
                mortise.summarize(wrong)
        with self.assertRaisesRegex(TypeError, "a dict of regions' names"):
            mortise.Model({"a": 3})
        with self.assertRaises(TypeError):
            pow(mortise.coordinates()[0], 2, 3)
        for outline in ([], [(0, 0)], [(0, 0), (1, 0)]):
            with self.assertRaisesRegex(ValueError, "has no area"):
                mortise.extrude(outline, 1)
            with self.assertRaisesRegex(ValueError, "has no area"):
                mortise.revolve([(1, 0), (2, 0), (2, 1)], holes=[outline])
        # Triangles that are turned, or do not close, as in a file.
        corners = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
        with self.assertWarnsRegex(UserWarning, "turned over"):
            turned = mortise.polyhedron(corners, [[0, 2, 1], [0, 3, 1], [0, 3, 2], [1, 2, 3]])
        self.assertAlmostEqual(self.volume(turned, 4), 1 / 6, places=9)
        outside_in = mortise.polyhedron(corners, [[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]])
        self.assertAlmostEqual(self.volume(outside_in, 4), 1 / 6, places=9)
        with self.assertRaises(mortise.Error):
            mortise.polyhedron(corners, [[0, 2, 1], [0, 1, 3]])
        with self.assertRaisesRegex(ValueError, "whole numbers"):
            mortise.polyhedron(corners, [[0., 2., 1.], [0., 1., 3.], [1., 2., 3.], [2., 0., 3.]])
        with self.assertWarnsRegex(UserWarning, "size"):
            mortise.csg("union() { cube([1, 1, 1]); sphere(r = 0); }")

    def test_quality_and_features(self):
        mesh = self.mesher.generate(mortise.cylinder(1, 2).named("pin"), level=5, quality=True)
        quality = mesh.report.quality
        self.assertEqual(sum(shape.count for shape in quality.shapes), len(mesh.report.scaled_jacobians))
        self.assertAlmostEqual(min(shape.minimum for shape in quality.shapes), mesh.report.scaled_jacobians.min(),
                               places=6)
        self.assertEqual(len(quality.shapes[0].histogram), 20)
        self.assertGreater(quality.angles.minimum, 17)
        self.assertLess(quality.mesh_to_model.maximum, 0.01)
        self.assertEqual([figures.name for figures in quality.surfaces], mesh.surface_names)
        self.assertEqual(len(quality.worst), 10)
        curves = mesh.report.features.curves
        self.assertEqual(len(curves), 2)
        for curve in curves:
            self.assertTrue(curve.closed)
            self.assertAlmostEqual(curve.length, 2 * math.pi, delta=0.05)
            self.assertTrue(numpy.allclose(numpy.linalg.norm(mesh.points[curve.nodes][:, :2], axis=1), 1, atol=1e-6))
        self.assertEqual(mesh.report.features.corners, [])
        self.assertIsNone(self.mesher.generate(self.ball, level=3).report.quality)

    def test_all_members_of_reports(self):
        for header, name in (("mesher", "MeshReport"), ("mesher", "LayerFigures"), ("mesher", "MissedFeature"),
                             ("mesher", "StageTime"), ("mesher", "MeshEstimate"), ("mesher", "ModelSummary"),
                             ("check", "CheckReport"), ("check", "Defect"), ("quality", "QualityReport"),
                             ("quality", "WorstElement"), ("quality", "ElementShape"), ("quality", "AngleFigures"),
                             ("quality", "DistanceFigures"), ("quality", "ModelCorner"), ("quality", "FeatureCurve"),
                             ("quality", "FeatureCorner"), ("quality", "SurfaceFigures")):
            text = (SOURCE / "include" / "mortise" / (header + ".hpp")).read_text()
            body = re.search(r"^struct " + name + r" \{\n(.*?)^\};", text, re.MULTILINE | re.DOTALL).group(1)
            body = re.sub(r"//.*", "", body)
            members = re.findall(r"^    [\w:<>, ]+? ((?:\w+(?: = \w+)?, )*\w+)(?:\{[^}]*\})?(?: = [\w:.-]+)?;", body, re.MULTILINE)
            members = [member.split()[0] for several in members for member in several.split(", ")]
            self.assertGreater(len(members), 1, name)
            for member in members:
                self.assertTrue(hasattr(getattr(mortise, name), member), name + "." + member)

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
