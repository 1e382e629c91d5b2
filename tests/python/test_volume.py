"""Volumes of Python's package: arrays and paths in, levels and boxes out."""

import copy
import gc
import itertools
import os
import pickle
import shutil
import subprocess
import sys
import tempfile
import threading
import types
import unittest
import unittest.mock

import numpy as np

import tessera


def ramp(shape, dtype=np.int16):
    """Numbers that tell their place."""
    z, y, x = np.indices(shape)
    return (x + 7 * y + 31 * z).astype(dtype)


class Arrays(unittest.TestCase):
    def test_every_type_comes_back(self):
        for name in "bool int8 uint8 int16 uint16 int32 uint32 int64 uint64 float16 float32 float64".split():
            for order in "<>" if name in ("int16", "int32", "float16", "float64") else "<":
                with self.subTest(name=name, order=order):
                    dtype = np.dtype(name).newbyteorder(order)
                    array = (ramp((5, 6, 7), np.int64) % 100).astype(dtype)
                    volume = tessera.open(array)
                    self.assertEqual(volume.shape, (5, 6, 7))
                    np.testing.assert_array_equal(volume.level(0), array.astype(volume.dtype))

    def test_any_layout_is_read_where_it_lies(self):
        whole = ramp((40, 41, 42))
        layouts = {
            "fortran": np.asfortranarray(whole),
            "transposed": whole.T,
            "backwards": whole[::-1, :, ::-1],
            "steps": whole[::2, 1::3, ::2],
            "broadcast": np.broadcast_to(whole[0], (33, 41, 42)),
            "read only": whole[:20],
        }
        layouts["read only"].setflags(write=False)
        for name, array in layouts.items():
            with self.subTest(name):
                np.testing.assert_array_equal(np.asarray(tessera.open(array)), array)

    def test_any_order_of_axes_of_any_type_is_the_same_volume(self):
        values = (ramp((70, 35, 66), np.int64) % 250).astype(np.float64)
        values[0, 0, 0] = 250
        for name, step in [("bool", -1), ("int16", 1), (">f2", 2), ("uint64", -2)]:
            expected = values.astype(name)
            plain = tessera.open(expected).content_hash
            for axes in itertools.permutations(range(3)):
                with self.subTest(name=name, axes=axes, step=step):
                    memory = np.zeros([expected.shape[axis] * abs(step) for axis in axes], expected.dtype)
                    view = memory[::step, ::step, ::step].transpose(np.argsort(axes))
                    view[...] = expected
                    self.assertEqual(tessera.open(view).content_hash, plain)

    def test_numbers_that_are_none_are_found_in_any_order(self):
        array = np.asfortranarray(ramp((40, 33, 34), np.float32))
        array[35, 1, 2] = np.nan
        volume = tessera.open(array)
        self.assertEqual(volume.level(0)[35, 1, 2], 0)
        self.assertIn("1 voxels without a number", " ".join(volume.notes))

    def test_numbers_that_float32_cannot_hold_are_told_of(self):
        for name in ("float64", "int64", "uint32"):
            array = (ramp((40, 33, 34), np.int64) % 250).astype(name)
            self.assertNotIn("float32", " ".join(tessera.open(array).notes))
            array[35, 1, 2] = (1 << 24) + 1
            notes = " ".join(tessera.open(array).notes)
            self.assertIn("the largest change is 1, 1 in 2^24", notes)

    def test_orientation_moves_voxels_and_not_places(self):
        array = ramp((8, 9, 10))
        direction = np.array([[0, -1, 0], [0, 0, -1], [1, 0, 0]], dtype=float)
        volume = tessera.open(array, spacing=(0.5, 0.7, 2), origin=(10, 20, 30), direction=direction)
        given = np.eye(4)
        given[:3, :3] = direction * [0.5, 0.7, 2]
        given[:3, 3] = (10, 20, 30)
        values, inverse = volume.level(0), np.linalg.inv(given)
        for index in [(0, 0, 0), (3, 1, 2), tuple(n - 1 for n in volume.shape[::-1])]:
            x, y, z = index
            place = volume.affine @ [x, y, z, 1]
            i, j, k = np.rint(inverse @ place)[:3].astype(int)
            self.assertEqual(values[z, y, x], array[k, j, i])
        self.assertTrue(np.all(np.diag(volume.affine)[:3] > 0))

    def test_affine_and_parts_of_it_are_the_same(self):
        array = ramp((4, 5, 6))
        parts = tessera.open(array, spacing=(0.5, 0.75, 2), origin=(-3, 4, 5))
        whole = tessera.open(array, affine=parts.affine)
        np.testing.assert_allclose(whole.affine, parts.affine)
        self.assertEqual(whole.spacing, (0.5, 0.75, 2.0))
        self.assertEqual(whole.origin, (-3.0, 4.0, 5.0))
        np.testing.assert_allclose(whole.direction, np.eye(3))

    def test_images_of_others_say_their_place(self):
        array = ramp((8, 9, 10))
        direction = np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1]], dtype=float)
        expected = tessera.open(array, spacing=(0.5, 0.7, 2), origin=(10, 20, 30), direction=direction)

        class Itk:
            GetSpacing = staticmethod(lambda: (0.5, 0.7, 2.0))
            GetOrigin = staticmethod(lambda: (10.0, 20.0, 30.0))
            GetDirection = staticmethod(lambda: tuple(direction.ravel()))

        class Nibabel:
            dataobj = array.T
            affine = np.eye(4)

        Nibabel.affine[:3, :3] = np.diag([-1, -1, 1]) @ (direction * [0.5, 0.7, 2])
        Nibabel.affine[:3, 3] = (-10, -20, 30)
        images = [Nibabel()]
        try:
            import nibabel

            images.append(nibabel.Nifti1Image(array.T, Nibabel.affine))
        except ImportError:
            pass
        module = types.ModuleType("SimpleITK")
        module.GetArrayViewFromImage = lambda image: array
        with unittest.mock.patch.dict(sys.modules, {"SimpleITK": module}):
            for image in [*images, Itk()]:
                volume = tessera.open(image)
                np.testing.assert_allclose(volume.affine, expected.affine, atol=1e-5)
                np.testing.assert_array_equal(volume.level(0), expected.level(0))
                with self.assertRaisesRegex(tessera.InputError, "spacing"):
                    tessera.open(image, spacing=(1, 1, 1))
                # as labels, too, whatever the order of the volume's voxels
                read = expected.labels(image).values
                np.testing.assert_array_equal(read, expected.level(0))

    def test_a_path_may_be_given_its_unit(self):
        values = np.where(np.hypot(*np.indices((12, 24, 24))[1:] - 12.0) < 9, 60, -1000).astype(np.int16)
        with tempfile.TemporaryDirectory() as folder:
            name = os.path.join(folder, "a.nrrd")
            with open(name, "wb") as file:
                file.write(
                    b"NRRD0004\ntype: short\ndimension: 3\nspace: left-posterior-superior\nsizes: 24 24 12\nendian: little\n"
                    b"space directions: (1,0,0) (0,1,0) (0,0,2)\nencoding: raw\n\n" + values.tobytes()
                )
            self.assertEqual(tessera.open(name).unit, "")
            with self.assertRaisesRegex(tessera.InputError, "HU"):
                tessera.open(name).body()
            volume = tessera.open(name, unit="HU")
            self.assertEqual(volume.unit, "HU")
            self.assertGreater(volume.body().litres, 0)
            self.assertEqual(pickle.loads(pickle.dumps(volume)).unit, "HU")
            drawn = tessera.render(volume, preset="bone-1", size=(20, 16), engine="native")
            self.assertEqual(drawn.manifest["scene"]["volumes"][0]["unit"], "HU")
            other = tessera.open(values, unit="HU")
            with self.assertRaisesRegex(tessera.InputError, "^unit: .*HU"):
                tessera.open(other.path, unit="SUVbw")

    def test_one_value_is_a_number(self):
        volume = tessera.open(ramp((6, 7, 8)))
        self.assertIsInstance(volume[1, 2, 3], np.integer)
        self.assertEqual({volume[1, 2, 3]: "it"}, {48: "it"})

    def test_values_have_slope_and_intercept(self):
        array = ramp((6, 6, 6), np.uint16)
        volume = tessera.open(array, slope=2, intercept=-1000, unit="HU")
        np.testing.assert_array_equal(volume.level(0), 2.0 * array - 1000)
        np.testing.assert_array_equal(volume.level(0, stored=True), array)
        self.assertEqual((volume.unit, volume.dtype), ("HU", np.float32))
        self.assertEqual(volume.range, (-1000.0, 2.0 * array.max() - 1000))

    def test_values_without_a_number_become_the_lowest(self):
        array = ramp((6, 6, 6), np.float32)
        array[1, 2, 3], array[0, 0, 0] = np.nan, np.inf
        volume = tessera.open(array)
        expected = np.where(np.isfinite(array), array, np.nanmin(array))
        np.testing.assert_array_equal(volume.level(0), expected)
        self.assertIn("2 voxels without a number", " ".join(volume.notes))

    def test_what_is_no_volume_is_refused(self):
        masked = np.ma.masked_array(np.zeros((2, 2, 2)), mask=True)
        for bad, words in [
            (np.zeros((4, 4)), "three axes"),
            (np.zeros((2, 2, 2, 2)), "three axes"),
            (np.zeros((0, 2, 2)), "at least one voxel"),
            (np.zeros((2, 2, 2), complex), "complex128"),
            (np.zeros((2, 2, 2), object), "object"),
            (np.zeros((2, 2, 2), "U3"), "numbers"),
            (np.zeros((2, 2, 2), [("a", int)]), "numbers"),
            (masked, "mask"),
        ]:
            with self.subTest(words), self.assertRaisesRegex(tessera.InputError, words):
                tessera.open(bad)
        for options in [
            {"spacing": (1, 1)},
            {"spacing": (1, 1, 0)},
            {"spacing": (1, np.nan, 1)},
            {"direction": np.eye(3) * 2},
            {"affine": np.zeros((4, 4))},
            {"affine": np.eye(4), "origin": (0, 0, 0)},
            {"unit": "x" * 20},
            {"slope": 0},
            {"series": 2},
            {"ram": "lots"},
            {"ram": "1KiB"},
            {"progress": 3},
        ]:
            with self.subTest(options), self.assertRaises(tessera.InputError):
                tessera.open(ramp((4, 4, 4)), **options)

    def test_an_import_holds_no_second_copy(self):
        program = (
            "import resource, numpy as np, tessera\n"
            "a = np.zeros((256, 512, 512), np.int16); a[:] = np.arange(512, dtype=np.int16)\n"
            "before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss\n"
            "v = tessera.open(a, ram='48MiB')\n"
            "print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before)\n"
        )
        grown = int(subprocess.run([sys.executable, "-c", program], check=True, stdout=subprocess.PIPE).stdout)
        self.assertLess(grown, 110 << 10, "KiB; the array has 128 MiB")

    def test_its_temporary_store_goes_with_it(self):
        with tempfile.TemporaryDirectory() as folder:
            program = (
                "import numpy as np, tessera, os\n"
                "v = tessera.open(np.zeros((8, 8, 8), np.int16)); assert os.path.exists(v.path)\n"
                "w = tessera.open(np.zeros((8, 8, 8), np.int16)); path = w.path; del w\n"
                "assert not os.path.exists(path)\n"
                "if os.fork() == 0:\n    del v; os._exit(0)\n"
                "os.wait(); assert os.path.exists(v.path), 'a child took it'\n"
                "import builtins; builtins.kept = v\n"
            )
            subprocess.run([sys.executable, "-c", program], check=True, env={**os.environ, "TMPDIR": folder})
            self.assertEqual(os.listdir(folder), [])


class Words(unittest.TestCase):
    """What a caller gets wrong is named, with what was expected: never a list of signatures."""

    def test_sources(self):
        array = ramp((4, 5, 6))
        volume = tessera.open(array)
        for call, words in [
            (lambda: tessera.open(None), "source: expected a path, an array or an image, found NoneType"),
            (lambda: tessera.open(5), "source: .* found int"),
            (lambda: tessera.open(array, unit=None), "unit: expected text .* found None"),
            (lambda: tessera.open(array, unit="\u00b5m"), "unit: expected text of printable ASCII"),
            (lambda: tessera.open(array, unit="\udc80"), "unit: expected text of printable ASCII"),
            (lambda: tessera.open(array, slope="x"), "slope: expected a number, found 'x'"),
            (lambda: tessera.open(array, intercept=None), "intercept: expected a number, found None"),
            (lambda: tessera.open(array, spacing=(1, 1, -1)), "spacing: expected lengths above 0"),
            (lambda: tessera.open(volume, spacing=(1, 1, 1)), "spacing: .* found for a volume that is open"),
            (lambda: tessera.open(volume, unit="HU"), "unit: .* found for a volume that is open"),
            (lambda: tessera.open(volume, series=2), "series: .* found for a volume that is open"),
            (lambda: tessera.phantom("torso", (10, 10)), "size: expected voxels along x, y and z"),
            (lambda: tessera.phantom("torso", 10), "size: expected voxels"),
            (lambda: tessera.phantom("torso", (10.5, 10, 10)), "size: expected a whole number, found 10.5"),
            (lambda: tessera.phantom("torso", (10**12, 1, 1)), "size: .* found 1000000000000"),
            (lambda: volume.surface("a"), "value: expected a number, found 'a'"),
            (lambda: tessera.Scene(5), "scene: expected a path, .* found int"),
        ]:
            with self.subTest(words), self.assertRaisesRegex(tessera.InputError, words):
                call()

    def test_boxes_levels_and_indices(self):
        volume = tessera.open(ramp((4, 5, 6)))
        for box, words in [
            (((0.5, 1.7), (0, 1), (0, 1)), "box: expected"),
            (((0, 10**12), (0, 1), (0, 1)), "0 to 4 along z, found 0 to 1000000000000"),
            (((0, 1), (0, 1), (3, 3)), "0 to 6 along x, found 3 to 3"),
        ]:
            with self.subTest(words), self.assertRaisesRegex(tessera.InputError, words):
                volume.read(box)
        for level in ["0", 0.5, None, -1, 6]:
            with self.subTest(level), self.assertRaisesRegex(tessera.InputError, "level: expected"):
                volume.level(level)
        for index in [None, 1.5, True, "x", [0, 1], np.array([1, 2]), volume.level(0) > 3, (..., ...), (0, 0, 0, 0)]:
            with self.subTest(repr(index)), self.assertRaises(IndexError):
                volume[index]
        np.testing.assert_array_equal(volume[np.int64(-1), np.array(2)], volume.level(0)[-1, 2])

    def test_options_may_be_bytes(self):
        picture = tessera.render(ramp((4, 5, 6)), size=(8, 6), engine=b"native")
        self.assertEqual(picture.manifest["engine"], "native")

    def test_a_path_may_be_bytes(self):
        phantom = tessera.phantom("sphere", (8, 8, 8))
        self.assertEqual(tessera.open(os.fsencode(phantom.path)).content_hash, phantom.content_hash)
        with self.assertRaisesRegex(tessera.InputError, "/no: expected a file or folder"):
            tessera.open(b"/no")


class AsAnArray(unittest.TestCase):
    """What numpy and the copy module take for granted."""

    def test_what_has_an_array_is_one(self):
        array = ramp((4, 5, 6))

        class Interface:
            __array_interface__ = array.__array_interface__

        class Method:
            def __array__(self, dtype=None, copy=None):
                return array

        class Subclass(np.ndarray):
            pass

        for source in [Interface(), Method(), array.view(Subclass), memoryview(array), array.tolist()]:
            with self.subTest(type(source).__name__):
                np.testing.assert_array_equal(tessera.open(source).level(0), array)

    def test_copies_are_the_volume_itself(self):
        volume = copy.copy(tessera.open(ramp((4, 5, 6))))  # the first one is gone
        gc.collect()
        np.testing.assert_array_equal(volume.level(0), ramp((4, 5, 6)))
        self.assertIs(copy.deepcopy({"a": volume})["a"], volume)
        scene = copy.deepcopy(tessera.Scene(tessera.phantom("sphere", (16, 16, 16))))
        gc.collect()
        self.assertEqual(tessera.render(scene, size=(8, 6), engine="native").size, (8, 6))

    def test_numpys_words(self):
        volume = tessera.open(ramp((4, 5, 6)))
        self.assertEqual((volume.ndim, volume.size, len(volume)), (3, 120, 4))
        self.assertEqual(np.mean(volume), ramp((4, 5, 6)).mean())
        self.assertEqual(np.asarray(volume, dtype=np.float64).dtype, np.float64)
        with self.assertRaises(ValueError):
            volume.__array__(copy=False)
        picture = tessera.render(volume, size=(8, 6), engine="native")
        self.assertTrue(np.shares_memory(np.asarray(picture), picture.pixels))
        self.assertFalse(np.shares_memory(picture.__array__(copy=True), picture.pixels))
        with self.assertRaises(ValueError):
            picture.__array__(np.float64, copy=False)
        self.assertIs(copy.copy(picture), picture)
        with self.assertRaisesRegex(TypeError, "pixels"):
            pickle.dumps(picture)

    def test_parts_with_arrays_are_compared_as_objects(self):
        surface = tessera.phantom("sphere", (16, 16, 16)).surface(500)
        self.assertEqual(surface, surface)
        self.assertEqual(len({surface}), 1)

    def test_an_array_may_change_and_go_while_others_are_read(self):
        array = ramp((64, 64, 64))
        volumes = []

        def work():
            mine = array.copy()
            volumes.append(tessera.open(mine))
            mine[:] = 0

        threads = [threading.Thread(target=work) for _ in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        gc.collect()
        for volume in volumes:
            np.testing.assert_array_equal(volume.level(0), array)


class Reading(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.array = ramp((70, 50, 45))
        cls.volume = tessera.open(cls.array)

    def test_boxes_are_those_of_the_array(self):
        for box in [((0, 70), (0, 50), (0, 45)), ((31, 33), (5, 6), (0, 45)), ((69, 70), (49, 50), (44, 45))]:
            (z0, z1), (y0, y1), (x0, x1) = box
            np.testing.assert_array_equal(self.volume.read(box), self.array[z0:z1, y0:y1, x0:x1])

    def test_indices_mean_what_they_mean_for_arrays(self):
        for index in [
            3, -1, slice(None), (slice(2, 40, 3), 4), (Ellipsis, 7), (slice(None, None, -1), slice(5, 2, -1), -3),
            (slice(10, 10),), (1, 2, 3), (slice(60, 5, -7), Ellipsis, slice(-4, None)),
        ]:
            with self.subTest(index):
                np.testing.assert_array_equal(self.volume[index], self.array[index])
        for index in [70, (0, 0, 0, 0), -71]:
            with self.assertRaises(IndexError):
                self.volume[index]

    def test_levels_are_means_of_the_one_before(self):
        self.assertEqual(self.volume.levels[:2], ((70, 50, 45), (35, 25, 23)))
        self.assertEqual(len(self.volume.levels), 6)
        fine = self.array[:70, :50, :44].reshape(35, 2, 25, 2, 22, 2).mean(axis=(1, 3, 5))
        self.assertLessEqual(np.abs(self.volume.level(1)[:, :, :22] - fine).max(), 0.5)

    def test_wrong_boxes_and_levels_are_refused(self):
        for box in [((0, 71), (0, 1), (0, 1)), ((0, 0), (0, 1), (0, 1)), ((-1, 1), (0, 1), (0, 1)), (1, 2), "all"]:
            with self.subTest(box), self.assertRaises(tessera.InputError):
                self.volume.read(box)
        for level in [-1, 6]:
            with self.assertRaises(tessera.InputError):
                self.volume.level(level)

    def test_histogram_is_numpys(self):
        counts, edges = self.volume.histogram()
        expected, places = np.histogram(self.array, bins=64)
        np.testing.assert_array_equal(counts, expected)
        np.testing.assert_allclose(edges, places, rtol=1e-5)

    def test_histogram_ascends_though_the_slope_falls(self):
        volume = tessera.open(self.array, slope=-2, intercept=5)
        counts, edges = volume.histogram()
        np.testing.assert_allclose(edges, np.histogram(volume.level(0), bins=64)[1], rtol=1e-5)
        np.testing.assert_array_equal(counts, self.volume.histogram()[0][::-1])

    def test_the_same_content_has_the_same_hash(self):
        self.assertEqual(tessera.open(self.array).content_hash, self.volume.content_hash)
        self.assertNotEqual(tessera.open(self.array + 1).content_hash, self.volume.content_hash)

    def test_other_processes_read_it(self):
        def mean(volume):
            return float(volume.level(0).mean())

        other = pickle.loads(pickle.dumps(self.volume))
        self.assertEqual((other.path, mean(other)), (self.volume.path, mean(self.volume)))
        reading, writing = os.pipe()
        if os.fork() == 0:  # as a pool of workers does
            try:
                os.write(writing, repr(mean(self.volume)).encode())
            finally:
                os._exit(0)
        os.close(writing)
        with os.fdopen(reading) as answer:
            self.assertEqual(answer.read(), repr(mean(self.volume)))
        os.wait()
        self.assertTrue(os.path.exists(self.volume.path))

    def test_an_array_outlives_its_volume(self):
        volume = tessera.open(self.array)
        level = volume.level(2)
        before = level.copy()
        del volume
        gc.collect()
        np.testing.assert_array_equal(level, before)


class Paths(unittest.TestCase):
    def test_files_are_imported_to_the_cache(self):
        with tempfile.TemporaryDirectory() as folder:
            array = ramp((9, 10, 11))
            array.tofile(os.path.join(folder, "a.raw"))
            name = os.path.join(folder, "a.json")
            with open(name, "w") as file:
                file.write('{"data": "a.raw", "extent": [11, 10, 9], "type": "int16", "spacing": [1, 2, 3]}')
            told = []
            volume = tessera.open(name, progress=lambda stage, share: told.append((stage, share)))
            np.testing.assert_array_equal(volume.level(0), array)
            self.assertEqual(volume.spacing, (1.0, 2.0, 3.0))
            self.assertTrue(told and told[-1][1] == 1)
            self.assertEqual(tessera.open(volume).path, volume.path)
            self.assertEqual(tessera.open(volume.path).content_hash, volume.content_hash)
            with self.assertRaisesRegex(tessera.InputError, "series"):
                tessera.open(volume.path, series=2)
            for source in (name, array, volume):
                for slip, near in [("serie", "series"), ("spaceing", "spacing"), ("afine", "affine"), ("file_levl", "file_level")]:
                    said = f"^{slip}: expected an argument of tessera.open.., found an unknown one; nearest: {near}$"
                    with self.subTest(slip), self.assertRaisesRegex(tessera.InputError, said):
                        tessera.open(source, **{slip: 2})
                with self.assertRaisesRegex(tessera.InputError, "^foo: expected an argument of tessera.open.., found an unknown one$"):
                    tessera.open(source, foo=1)
            with self.assertRaisesRegex(tessera.InputError, "^serie: .*tessera.phases.*nearest: series$"):
                tessera.phases(name, serie=2)

    def test_phases_are_listed_and_opened(self):
        times = np.stack([ramp((4, 5, 6)) + 300 * time for time in range(3)]).astype("<i2")
        header = (
            "NRRD0004\ntype: short\ndimension: 4\nspace: left-posterior-superior\nsizes: 6 5 4 3\nendian: little\n"
            "space directions: (1,0,0) (0,1,0) (0,0,2) none\nkinds: domain domain domain time\nencoding: raw\n\n"
        )
        with tempfile.TemporaryDirectory() as folder:
            name = os.path.join(folder, "beat.nrrd")
            with open(name, "wb") as file:
                file.write(header.encode() + times.tobytes())
            self.assertEqual(tessera.phases(name), ["time 1", "time 2", "time 3"])
            for phase in (1, 2, 3):
                np.testing.assert_array_equal(tessera.open(name, phase=phase).level(0), times[phase - 1])
            frames = os.path.join(os.path.dirname(name), "frames")
            tessera.film(name, frames, phase="all", slice="axial", size=(16, 12))
            self.assertEqual(len([one for one in os.listdir(frames) if one.endswith(".png")]), 3)
            with self.assertRaisesRegex(tessera.InputError, "--phase N"):
                tessera.open(name)
            with self.assertRaisesRegex(tessera.InputError, "between 1 and 3"):
                tessera.open(name, phase=4)
        sphere = tessera.phantom("sphere", (16, 16, 16))
        self.assertEqual(tessera.phases(sphere.path), [])
        with self.assertRaisesRegex(tessera.InputError, "nothing there"):
            tessera.phases("/no/such/place")

    def test_names_need_not_be_unicode(self):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(os.fsencode(folder), b"\xff\xfe.zarr")
            sphere = tessera.phantom("sphere", (16, 16, 16))
            shutil.copytree(os.fsencode(sphere), path)
            volume = tessera.open(os.fsdecode(path))
            self.assertEqual(os.fsencode(volume), path)
            picture = tessera.render(volume, size=(16, 12), engine="native")
            picture.save(os.fsdecode(path + b".png"))
            self.assertTrue(os.path.exists(path + b".png"))
            with self.assertRaisesRegex(tessera.InputError, "nothing there"):
                tessera.open(os.fsdecode(path + b"no"))

    def test_what_cannot_be_opened_says_why(self):
        with self.assertRaisesRegex(tessera.InputError, "expected a file or folder, found nothing there"):
            tessera.open("/no/such/place")
        with self.assertRaises(tessera.InputError):
            tessera.open(__file__)
        with self.assertRaises(ValueError):
            tessera.open("/no/such/place")
        with self.assertRaises(RuntimeError):
            tessera.open("/no/such/place")
        with self.assertRaisesRegex(tessera.InputError, "origin"):
            tessera.open(__file__, origin=(0, 0, 0))


if __name__ == "__main__":
    unittest.main()
