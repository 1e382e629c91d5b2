"""Parts of volumes in Python's package: centre-lines, coverage, labels, body and table."""

import os
import tempfile
import unittest

import numpy as np

import tessera


def tube(shape=(80, 48, 48), radius=7.0):
    """Air in tissue: a tube along z whose middle moves sideways."""
    z, y, x = np.indices(shape)
    middle = 24 + 6 * np.sin(z / 25.0)
    air = (x - middle) ** 2 + (y - 24) ** 2 < radius**2
    air &= (z > 4) & (z < shape[0] - 5)
    return np.where(air, -950, 40).astype(np.int16)


class Lumen(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.volume = tessera.open(tube(), unit="HU", spacing=(1, 1, 1))
        cls.line = tessera.centreline(cls.volume, (24 + 6 * np.sin(8 / 25), 24, 8), (24 + 6 * np.sin(70 / 25), 24, 70))

    def test_a_line_is_the_middle_of_its_tube(self):
        x, y, z = self.line.points.T
        self.assertGreater(len(z), 50)
        self.assertLess(np.abs(y - 24).max(), 1.0)
        self.assertLess(np.abs(x - 24 - 6 * np.sin(z / 25)).max(), 1.5)
        self.assertEqual(self.line.radii.shape, z.shape)
        self.assertTrue(5 < np.median(self.line.radii) < 8)
        self.assertAlmostEqual(self.line.length, np.linalg.norm(np.diff(self.line.points, axis=0), axis=1).sum(), delta=1)

    def test_points_are_a_path(self):
        points = np.column_stack([self.line.points, self.line.radii])
        with tempfile.TemporaryDirectory() as folder:
            drawn = {}
            for name, path in (
                ("line", self.line),
                ("array", points[::6]),
                ("list", points[::6].tolist()),
                ("fortran", np.asfortranarray(points[::6])),
                ("bare", points[::6, :3]),
            ):
                out = os.path.join(folder, name + ".png")
                tessera.render_file(self.volume, out, path=path, straighten=True, across=30)
                drawn[name] = out
            with open(drawn["array"], "rb") as one, open(drawn["list"], "rb") as other, open(drawn["fortran"], "rb") as third:
                self.assertTrue(one.read() == other.read() == third.read())
            with self.assertRaisesRegex(tessera.InputError, "^path: expected a Centreline"):
                tessera.coverage(self.volume, points)
            with self.assertRaisesRegex(tessera.InputError, "^path: expected at least two points"):
                tessera.render_file(self.volume, drawn["line"], path=points[:1], straighten=True)
            for wrong in (points[:1], points[:, :2], points[0], np.full((4, 3), np.nan), [(1, 2, 3), (1, 2)], 7):
                with self.assertRaises(tessera.InputError) as refused:
                    tessera.render_file(self.volume, drawn["line"], path=wrong, straighten=True)
                self.assertIn("oint", str(refused.exception))

    def test_its_path_is_the_command_lines(self):
        self.assertEqual(self.line.path["volume"]["contentHash"], self.volume.content_hash)
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "path.json")
            self.line.save(path)
            frames = os.path.join(folder, "frames")
            tessera.film(self.volume, frames, path=path, size=(32, 24), frames="0-1", engine="native")
            tessera.film(self.volume, frames, path=self.line, size=(32, 24), frames="0-2", engine="native")
            self.assertEqual(sum(name.endswith(".png") for name in os.listdir(frames)), 3)
            seen = tessera.coverage(self.volume, self.line, every=4)
            self.assertTrue(0.5 < seen.share <= 1)
            self.assertEqual(tessera.coverage(self.volume, path, every=4), seen)
        self.assertAlmostEqual(seen.seen_mm2 / seen.wall_mm2, seen.share)
        with self.assertRaisesRegex(tessera.InputError, "another volume"):
            tessera.coverage(tessera.open(tube() + 1, unit="HU"), self.line)

    def test_every_setting_of_coverage_counts(self):
        def of(**options):
            return tessera.coverage(self.volume, self.line, every=4, **{"view_angle": 50, **options})

        plain = of()
        self.assertLess(of(size=(100, 800)).share, plain.share)
        self.assertGreater(of(size=(800, 100)).share, plain.share)
        self.assertLess(of(view_angle=20).share, plain.share)
        self.assertLess(of(farthest=6).share, plain.share)
        self.assertNotEqual(of(backwards=True), plain)
        both = of(both_ways=True)
        self.assertGreaterEqual(both.share, max(plain.share, of(backwards=True).share))
        few, many = of(smallest=200), of(smallest=1)
        self.assertLess(len(few.patches), len(many.patches))
        self.assertTrue(all(patch["area_mm2"] >= 200 for patch in few.patches))
        for patch in many.patches:
            self.assertTrue(patch["from_mm"] <= patch["along_mm"] <= patch["to_mm"])
        self.assertLessEqual(sum(patch["area_mm2"] for patch in many.patches), 1.001 * (plain.wall_mm2 - plain.seen_mm2))

    def test_wrong_requests_are_refused(self):
        inside = tuple(self.line.points[10])
        for arguments, options, words in [
            (((1, 2),), {}, "a point"),
            (((1e9, 0, 0),), {}, "a point"),
            (((500, 2, 40),), {}, "start"),
            ((inside,), {"tree": True, "end": inside}, "tree"),
            ((inside,), {"through": [inside]}, "through"),
            ((inside,), {"may_leak": True}, "may_leak"),
            ((inside,), {"spacing": 0}, "spacing"),
            ((inside,), {"generations": -1}, "generations"),
        ]:
            with self.subTest(words), self.assertRaisesRegex(tessera.InputError, words):
                tessera.centreline(self.volume, *arguments, **options)


class Parts(unittest.TestCase):
    def nrrd(self, folder, array):
        path = os.path.join(folder, "labels.nrrd")
        with open(path, "wb") as file:
            file.write(
                b"NRRD0005\ntype: uint8\ndimension: 3\nspace: left-posterior-superior\nsizes: %d %d %d\n"
                b"space directions: (1,0,0) (0,1,0) (0,0,1)\nspace origin: (0,0,0)\nencoding: raw\nendian: little\n\n"
                % array.shape[::-1]
            )
            file.write(array.tobytes())
        return path

    def test_labels_may_be_an_array(self):
        oblique = np.array([[0, 0.6, -0.8], [0, 0.8, 0.6], [1, 0, 0]])  # columns: directions of x, y and z
        values = np.arange(12 * 10 * 14, dtype=np.int16).reshape(12, 10, 14)
        volume = tessera.open(values, spacing=(1, 2, 3), origin=(5, -7, 11), direction=oblique)
        for labels in (
            np.asarray(volume) % 5,
            np.asfortranarray(np.asarray(volume) % 300).astype(np.int64),
            (np.asarray(volume) > 700)[::-1],
        ):
            read = volume.labels(labels)
            for value in (1, 4, 299):
                if value in labels:
                    self.assertTrue(np.array_equal(read.mask(value), labels == value))
        shown = tessera.render(volume, labels=np.asarray(volume) > 700, size=(40, 30), engine="mirror", samples=1)
        self.assertEqual(shown.manifest["labels"], {"labels": 1, "drawn": 1})
        self.assertFalse(np.array_equal(shown, tessera.render(volume, size=(40, 30), engine="mirror", samples=1)))
        for wrong in (labels[1:], labels * 0.5, labels.astype(int) - 1, labels.astype(int) * 70000):
            with self.assertRaisesRegex(tessera.InputError, "^labels: expected .{1,200}$"):
                tessera.render(volume, labels=wrong)

    def test_labels_have_the_place_of_their_array(self):
        values = np.arange(7 * 8 * 9, dtype=np.int16).reshape(7, 8, 9)
        wanted = values % 6 == 1  # in the array's order
        for signs in ((1, 1, 1), (-1, -1, 1), (1, 1, -1), (-1, 1, -1)):
            affine = np.diag([*(np.array(signs) * (2, 1, 3)), 1.0])
            affine[:3, 3] = (4, -9, 2)
            volume = tessera.open(values, affine=affine)
            there = np.asarray(volume) % 6 == 1
            for labels in ((wanted, affine), (there, volume.affine), (wanted[:5], affine), (there[:, ::-1], volume.affine)):
                read = volume.labels(labels).mask(1)
                if labels[0] is wanted or labels[0] is there:
                    self.assertTrue(np.array_equal(read, there), signs)
                else:
                    self.assertFalse(np.array_equal(read, there), signs)
            self.assertTrue(np.array_equal(volume.labels(volume.labels((wanted, affine))).mask(1), there))
            if signs == (1, 1, 1):
                self.assertTrue(np.array_equal(volume.labels(wanted).mask(1), there))
            else:  # of either order
                with self.assertRaisesRegex(tessera.InputError, r"^labels: expected \(array, affine\)"):
                    volume.labels(wanted)
        # A LabelMap knows its lattice, names and colours: of another volume, and of coarse levels.
        coarse = tessera.open(values[:, :, :8], spacing=(4, 2, 6), origin=(1, 0.5, 1.5))
        fine = tessera.open(np.zeros((14, 16, 16), np.int16), spacing=(2, 1, 3))
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "labels.seg.nrrd")
            with open(path, "wb") as file:
                file.write(
                    b"NRRD0005\ntype: uint8\ndimension: 3\nspace: left-posterior-superior\nsizes: 8 8 7\n"
                    b"space directions: (4,0,0) (0,2,0) (0,0,6)\nspace origin: (1,0.5,1.5)\nencoding: raw\n"
                    b"Segment0_ID:=s0\nSegment0_Name:=left lung\nSegment0_LabelValue:=3\nSegment0_Layer:=0\n"
                    b"Segment0_Color:=0.25 0.5 0.75\n\n"
                )
                file.write((np.arange(7 * 8 * 8).reshape(7, 8, 8) % 5 == 2).astype(np.uint8).tobytes().replace(b"\1", b"\3"))
            there = coarse.labels(path)
            read = fine.labels(there)
            self.assertTrue(np.array_equal(read.mask("left lung"), fine.labels(path).mask("left lung")))
            self.assertEqual([(label.value, label.name) for label in read.labels], [(3, "left lung")])
            np.testing.assert_allclose(read.labels[0].colour, (0.25, 0.5, 0.75), atol=0.003)
            self.assertGreater(read.mask("left lung").sum(), 0)
        halves = fine.labels((np.ones((14, 16, 16), bool), fine.affine), level=1)
        np.testing.assert_allclose(halves.affine, coarse.affine)
        for wrong in ((values, np.eye(3)), [[1], [1, 2]]):
            with self.assertRaisesRegex(tessera.InputError, "^labels: "):
                volume.labels(wrong)
        swapped = np.eye(4)[[2, 1, 0, 3]]  # x and z change places: shapes tell the order
        volume = tessera.open(values, affine=swapped)
        there = np.asarray(volume) % 6 == 1
        self.assertNotEqual(there.shape, wanted.shape)
        for labels in (wanted, there):
            self.assertTrue(np.array_equal(volume.labels(labels).mask(1), there))
        for masked, is_taken in ((np.ma.array(there), True), (np.ma.array(there, mask=there), False)):
            if is_taken:
                self.assertTrue(np.array_equal(volume.labels(masked).mask(1), there))
            else:
                with self.assertRaisesRegex(tessera.InputError, "masked"):
                    volume.labels(masked)
        self.assertEqual(tessera.open(np.ma.array(values)).shape, values.shape)

    def test_labels_are_arrays_on_the_volumes_lattice(self):
        values = np.zeros((20, 22, 24), np.uint8)
        values[2:9, 3:12, 4:10], values[12:18, 3:12, 4:10] = 3, 200
        volume = tessera.open(np.zeros(values.shape, np.int16))
        with tempfile.TemporaryDirectory() as folder:
            labels = volume.labels(self.nrrd(folder, values))
            np.testing.assert_array_equal(labels.values, values)
            self.assertEqual([one.value for one in labels.labels], [3, 200])
            np.testing.assert_array_equal(labels.mask(200), values == 200)
            np.testing.assert_array_equal(labels.mask(labels.labels[0].name), values == 3)
            self.assertFalse(labels.overlaps)
            self.assertEqual(volume.labels(self.nrrd(folder, values), level=1).sets.shape, volume.levels[1])
            with self.assertRaisesRegex(tessera.InputError, "a name or value"):
                labels.mask(7)
            with self.assertRaisesRegex(tessera.InputError, "nothing there"):
                volume.labels(os.path.join(folder, "none"))

    def test_a_surface_is_closed_and_encloses_its_value(self):
        z, y, x = np.indices((40, 44, 48))
        far = np.sqrt((2 * (x - 24.0)) ** 2 + (y - 22.0) ** 2 + (z - 20.0) ** 2)
        volume = tessera.open((1000 - 20 * far).astype(np.float32), spacing=(2, 1, 1), origin=(5, -3, 7))
        found = volume.surface(1000 - 20 * 12)
        radii = np.linalg.norm(found.points - [5 + 48, -3 + 22, 7 + 20], axis=1)
        self.assertLess(np.abs(radii - 12).max(), 0.25)
        self.assertAlmostEqual(found.volume_ml, 4 / 3 * np.pi * 12**3 / 1000, delta=0.1)
        a, b, c = (found.points[found.triangles[:, n]] for n in range(3))
        self.assertAlmostEqual(np.einsum("ij,ij", a, np.cross(b, c)) / 6000, found.volume_ml, delta=0.01)
        self.assertAlmostEqual(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 200, found.area_cm2, delta=0.01)
        edges = np.sort(found.triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
        _, counts = np.unique(edges, axis=0, return_counts=True)
        self.assertTrue((counts == 2).all())
        self.assertLess(len(volume.surface(760, level=1).triangles), len(found.triangles) / 2)
        self.assertEqual(volume.surface(5000).triangles.shape, (0, 3))
        for value, level in [(np.nan, 0), (0, 6), (0, -1)]:
            with self.assertRaises(tessera.InputError):
                volume.surface(value, level=level)

    def test_a_body_has_a_box(self):
        torso = tessera.phantom("torso", (64, 48, 75))
        body = torso.body()
        self.assertGreater(body.litres, 5)
        self.assertTrue(all(low < high for low, high in zip(body.low, body.high)))
        table = torso.table()
        self.assertEqual(table.mask is None, bool(table.why))
        with self.assertRaisesRegex(tessera.InputError, "HU"):
            tessera.open(np.zeros((4, 4, 4), np.int16)).body()


if __name__ == "__main__":
    unittest.main()
