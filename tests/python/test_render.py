"""Pictures of Python's package: the program's, as arrays; stopped, by several threads, and as files."""

import os
import re
import struct
import subprocess
import sys
import tempfile
import threading
import time
import unittest
import zlib

import numpy as np

import tessera
from tessera import _picture, _words

PROGRAM = os.environ.get("TESSERA_PROGRAM", "")


def decoded(png):
    """The pixels of a PNG file without filters, and its manifest."""
    at, data, head, text = 8, b"", None, ""
    while at < len(png):
        (length,), kind = struct.unpack(">I", png[at : at + 4]), png[at + 4 : at + 8]
        body = png[at + 8 : at + 8 + length]
        if kind == b"IHDR":
            head = struct.unpack(">IIBB", body[:10])
        elif kind == b"IDAT":
            data += body
        elif kind == b"tEXt" and body.startswith(b"Description"):
            text = body.split(b"\0", 1)[1].decode("ascii")
        at += 12 + length
    width, height, _, kind = head
    channels = {2: 3, 6: 4}[kind]
    rows = np.frombuffer(zlib.decompress(data), np.uint8).reshape(height, 1 + width * channels)
    assert not rows[:, 0].any()
    return rows[:, 1:].reshape(height, width, channels), text


class Pictures(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.torso = tessera.phantom("torso", (64, 48, 75))
        cls.options = {"size": (80, 60), "engine": "native", "no_check": True}

    def render(self, what=None, **options):
        return tessera.render(self.torso if what is None else what, **{**self.options, **options})

    def test_pixels_are_linear_premultiplied_and_not_copied(self):
        picture = self.render()
        pixels = picture.pixels
        self.assertEqual((pixels.shape, pixels.dtype), ((60, 80, 4), np.float32))
        self.assertTrue(np.shares_memory(pixels, picture.pixels))
        self.assertFalse(pixels.flags.writeable)
        self.assertGreater(pixels[..., 3].max(), 0.5)
        alone = picture.pixels
        before = alone.copy()
        del picture, pixels
        np.testing.assert_array_equal(alone, before)

    def test_files_have_the_pixels_of_srgb(self):
        for background in ["black", "#336699", "transparent"]:
            picture = self.render(background=background)
            with tempfile.TemporaryDirectory() as folder:
                path = os.path.join(folder, "a.png")
                picture.save(path)
                with open(path, "rb") as file:
                    pixels, manifest = decoded(file.read())
                np.testing.assert_array_equal(pixels, picture.srgb())
                self.assertIn("not for diagnosis", manifest)
                for name in ["a.tif", "a.exr"]:
                    picture.save(os.path.join(folder, name))
                with self.assertRaises(tessera.InputError):
                    picture.save(os.path.join(folder, "a.bmp"))
            np.testing.assert_array_equal(decoded(picture._repr_png_())[0], picture.srgb())
            self.assertEqual(picture.srgb().shape[2], 4 if background == "transparent" else 3)

    @unittest.skipUnless(PROGRAM, "no program")
    def test_it_is_the_picture_of_the_command_line(self):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "a.png")
            words = ["--size", "80x60", "--engine", "native", "--no-check", "--view", "left", "--preset", "soft-tissue"]
            subprocess.run([PROGRAM, "-q", "render", self.torso.path, "-o", path, *words], check=True)
            with open(path, "rb") as file:
                pixels, _ = decoded(file.read())
        np.testing.assert_array_equal(self.render(view="left", preset="soft-tissue").srgb(), pixels)

    def test_scenes_options_and_keys_mean_the_same(self):
        expected = self.render(mode="mip", window=(100, 900)).pixels
        scene = tessera.Scene(self.torso, mode="mip", window=[100, 900])
        np.testing.assert_array_equal(self.render(scene).pixels, expected)
        np.testing.assert_array_equal(self.render(scene.to_dict()).pixels, expected)
        np.testing.assert_array_equal(self.render(self.torso, scene={"mode": "mip", "window": [100, 900]}).pixels, expected)
        np.testing.assert_array_equal(self.render(set={"mode": "mip", "window": [100, 900]}).pixels, expected)
        with tempfile.TemporaryDirectory() as folder:
            scene.save(os.path.join(folder, "a.json"))
            np.testing.assert_array_equal(self.render(os.path.join(folder, "a.json")).pixels, expected)
        self.assertEqual(self.render(**{"shading.ambient": 0.5}).scene["shading"]["ambient"], 0.5)

    def test_an_array_is_drawn_as_its_volume_is(self):
        values = self.torso.level(0)
        volume = tessera.open(values, affine=self.torso.affine, unit="HU")
        np.testing.assert_array_equal(self.render(volume).pixels, self.render(self.torso).pixels)
        # turned about, the same voxels are at the same places
        flipped = values[:, ::-1, ::-1]
        affine = self.torso.affine.copy()
        affine[:3, 3] += affine[:3, 0] * (values.shape[2] - 1) + affine[:3, 1] * (values.shape[1] - 1)
        affine[:3, :2] *= -1
        turned = tessera.open(flipped, affine=affine, unit="HU")
        np.testing.assert_allclose(self.render(turned).pixels, self.render(self.torso).pixels, atol=1e-5)

    def test_annotations_lie_over_srgb_and_files(self):
        words = {"title": "A torso", "scale_bar": True, "size": (320, 240)}
        plain, picture = self.render(size=(320, 240)), self.render(**words)
        np.testing.assert_array_equal(picture.pixels, plain.pixels)
        self.assertFalse(np.array_equal(picture.srgb(), plain.srgb()))
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "a.png")
            picture.save(path)
            with open(path, "rb") as file:
                np.testing.assert_array_equal(decoded(file.read())[0], picture.srgb())
            picture.save(os.path.join(folder, "a.pdf"))
            with open(os.path.join(folder, "a.pdf"), "rb") as file:
                self.assertEqual(file.read(4), b"%PDF")
            scene = tessera.Scene(self.torso)
            notes = tessera.render_file(
                scene, path, panel="front,left", size=(64, 48), gap=2, columns=2, engine="native", no_check=True
            )
            self.assertIn("wrote", " ".join(notes))
            with open(path, "rb") as file:
                self.assertEqual(decoded(file.read())[0].shape[:2], (48, 130))

    def test_layers_come_as_arrays(self):
        picture = self.render(light="cinematic", samples=2, layers="all", size=(24, 18))
        shapes = {name: layer.shape for name, layer in picture.layers.items()}
        self.assertEqual(shapes, {"albedo": (18, 24, 3), "normal": (18, 24, 3), "depth": (18, 24), "error": (18, 24, 4)})
        self.assertGreater(picture.layers["depth"].max(), 10)
        self.assertEqual(self.render().layers, {})
        with tempfile.TemporaryDirectory() as folder:
            picture.save(os.path.join(folder, "a.exr"))
            with open(os.path.join(folder, "a.exr"), "rb") as file:
                self.assertIn(b"depth.Z", file.read(2000))

    @unittest.skipUnless(PROGRAM, "no program")
    def test_options_that_are_not_here_are_options_of_the_program(self):
        done = subprocess.run([PROGRAM, "render", "--help"], stdout=subprocess.PIPE, text=True, check=True)
        words = set(re.findall(r"--[a-z][a-z-]+", done.stdout))
        for name in [*_picture._OF_FILES, *set(_picture._NOT_HERE) - {"version", "quiet", "verbose"}]:
            with self.subTest(name):
                self.assertIn("--" + name.replace("_", "-"), words)
                with self.assertRaisesRegex(tessera.InputError, name):
                    self.render(**{name: 1})

    def test_errors_are_those_of_the_command_line(self):
        for options, words in [
            ({"preset": "bone1"}, "bone-1"),
            ({"max_eror": 1}, "^max_eror: expected an argument of tessera.render.*; nearest: max_error$"),
            ({"size": (0, 5)}, "--size"),
            ({"view": "sideways"}, "--view"),
            ({"engine": "march3"}, "--engine"),
            ({"ram": "1KiB"}, "--ram"),
            ({"slice": "axial:100000"}, "--slice"),
            ({"output": "a.png"}, "Picture.save"),
            ({"panel": "front"}, "render_file"),
            ({"shading.ambiant": 1}, "nearest: \"ambient\""),
            ({"layers": "depth"}, "--layers"),
        ]:
            with self.subTest(options), self.assertRaisesRegex(tessera.InputError, words):
                self.render(**options)
        with self.assertRaisesRegex(tessera.InputError, "nothing there"):
            self.render("/no/such/scan")

    def test_misspelt_arguments_name_the_nearest(self):
        own = set(_words.arguments_of(tessera._tessera.options_of_render())) - set(_picture._NOT_HERE)
        for name in sorted(own):
            for slip in (name + "q", name[:-1] if len(name) > 4 else name[0] + "q" + name[1:]):
                if slip in own:
                    continue
                with self.subTest(slip):
                    call = tessera.render_file if name in _picture._OF_FILES else tessera.render
                    where = ("x.zarr", "a.png") if name in _picture._OF_FILES else ("x.zarr",)
                    with self.assertRaises(tessera.InputError) as refused:
                        call(*where, **{slip: 1})
                    said = str(refused.exception)
                    self.assertTrue(said.startswith(f"{slip}: expected an argument of tessera.{call.__name__}()"), said)
                    self.assertRegex(said, "; nearest: [a-z_]+$")
                    self.assertNotIn("--", said)

    def test_blank_pictures_say_so(self):
        picture = self.render(isosurface="9000", mode="isosurface")
        self.assertIn("the picture is blank", " ".join(picture.notes))

    def test_a_progress_function_gets_stages_and_stops(self):
        told = []
        self.render(size=(300, 300), progress=lambda stage, share: told.append((stage, share)))
        self.assertTrue(told)
        self.assertTrue(all(0 <= share <= 1 and stage for stage, share in told))

        class Enough(Exception):
            pass

        def raises(stage, share):
            raise Enough(stage)

        long = {"size": (1500, 1500), "light": "cinematic", "samples": 4096}
        for function, error in [(raises, Enough), (lambda stage, share: False, tessera.Cancelled)]:
            began = time.monotonic()
            with self.assertRaises(error):
                self.render(progress=function, **long)
            self.assertLess(time.monotonic() - began, 10)
        self.assertEqual(threading.active_count(), 1)

    def test_threads_draw_at_once(self):
        expected = self.render().pixels
        found = {}

        def draw(n):
            found[n] = self.render(ram="256MiB").pixels

        threads = [threading.Thread(target=draw, args=(n,)) for n in range(2)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        for n in range(2):
            np.testing.assert_array_equal(found[n], expected)

    def test_other_threads_go_on_meanwhile(self):
        counted, stop = [0], threading.Event()

        def count():
            while not stop.is_set():
                counted[0] += 1
                time.sleep(0.001)

        thread = threading.Thread(target=count)
        thread.start()
        self.render(size=(400, 400))
        stop.set()
        thread.join()
        self.assertGreater(counted[0], 5)

    def test_budgets_are_of_the_call(self):
        picture = self.render(ram="200MiB", gpu_memory="64MiB")
        budgets = picture.manifest["budgets"]
        self.assertEqual(budgets["ram"]["limitBytes"], 200 << 20)
        self.assertEqual(budgets["gpuMemory"]["limitBytes"], 64 << 20)
        for small in [{"ram": "1MiB"}, {"gpu_memory": "1KiB"}]:
            with self.subTest(small), self.assertRaises(tessera.OverBudget) as caught:
                self.render(**small)
            self.assertIsInstance(caught.exception, tessera.InputError)
            self.assertIsInstance(caught.exception, MemoryError)
        with self.assertRaises(tessera.InputError) as caught:
            self.render(ram="much")
        self.assertNotIsInstance(caught.exception, tessera.OverBudget)

    def test_films_are_folders_of_frames(self):
        with tempfile.TemporaryDirectory() as folder:
            frames = os.path.join(folder, "frames")
            tessera.film(self.torso, frames, turn=360, frames=3, size=(32, 24), engine="native")
            self.assertEqual(len([name for name in os.listdir(frames) if name.endswith(".png")]), 3)
            with self.assertRaises(tessera.InputError):
                tessera.film(self.torso, frames, size=(32, 24))


if __name__ == "__main__":
    unittest.main()
