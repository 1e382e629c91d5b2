"""Scenes of Python's package: a mapping that refuses what scene files could not have."""

import json
import os
import pickle
import tempfile
import unittest

import tessera


class Scenes(unittest.TestCase):
    def test_a_key_and_its_path_are_the_same(self):
        scene = tessera.Scene()
        scene["shading.ambient"] = 0.5
        self.assertEqual(scene["shading"]["ambient"], 0.5)
        scene["shading"]["ambient"] = 0.25
        self.assertEqual(scene["shading.ambient"], 0.25)
        self.assertEqual(tessera.Scene(**{"shading.ambient": 0.25}), scene)

    def test_lists_grow_behind_their_last_item(self):
        scene = tessera.Scene()
        scene["isosurfaces"] = [{"value": 300}]
        scene["isosurfaces"].append({"value": 500, "opacity": 0.5})
        scene["isosurfaces"][0]["opacity"] = 0.25
        self.assertEqual([one["opacity"] for one in scene["isosurfaces"]], [0.25, 0.5])
        self.assertEqual(scene["isosurfaces"][-1]["value"], 500)

    def test_values_are_checked_when_they_are_set(self):
        scene = tessera.Scene()
        before = scene.to_json()
        for key, value, words in [
            ("shading.ambient", 7, "shading.ambient: expected"),
            ("shading.ambiant", 0.1, "nearest: \"ambient\""),
            ("mode", "mipp", "mode"),
            ("image.size", [0, 5], "image.size"),
            ("isosurfaces[4].value", 3, "an item from 0 to 0"),
            ("quality.samples", float("nan"), "scene: expected values that JSON has"),
            ("quality.samples", object(), "scene: expected values that JSON has"),
        ]:
            with self.subTest(key), self.assertRaisesRegex(tessera.InputError, words):
                scene[key] = value
        self.assertEqual(scene.to_json(), before)

    def test_json_and_files_come_back(self):
        scene = tessera.Scene({"volumes": [{"path": "/a/b.zarr", "transferFunction": "bone-1"}], "mode": "mip"})
        self.assertEqual(tessera.Scene(scene.to_json()), scene)
        self.assertEqual(tessera.Scene(scene.to_dict()), scene)
        self.assertEqual(pickle.loads(pickle.dumps(scene)), scene)
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "scene.json")
            scene.save(path)
            self.assertEqual(tessera.Scene(path), scene)
        with self.assertRaisesRegex(tessera.InputError, "modes"):
            tessera.Scene({"modes": "mip"})
        with self.assertRaises(tessera.InputError):
            tessera.Scene('{"volumes": 3}')

    def test_addresses_stay_and_paths_become_absolute(self):
        for source, path in [("https://server/a.zarr", "https://server/a.zarr"), ("b.zarr", os.path.abspath("b.zarr"))]:
            self.assertEqual(tessera.Scene(source)["volumes"][0]["path"], path)

    def test_it_is_a_mapping(self):
        scene = tessera.Scene(mode="mip")
        self.assertIn("mode", scene)
        self.assertNotIn("modes", scene)
        self.assertEqual(dict(scene)["mode"], "maximum")
        self.assertEqual(scene.get("annotations", 3), json.loads(scene.to_json()).get("annotations", 3))
        with self.assertRaises(KeyError):
            scene["no.such.key"]
        scene.update({"shading.ambient": 0.5})
        self.assertEqual(scene["shading.ambient"], 0.5)
        copy = scene.copy()
        copy["mode"] = "composite"
        self.assertEqual(scene["mode"], "maximum")

    def test_volumes_stay_as_long_as_their_scene(self):
        scene = tessera.Scene(tessera.phantom("sphere", (16, 16, 16)))
        more = tessera.Scene({"volumes": [{"path": tessera.phantom("ramp", (16, 16, 16)), "transferFunction": "auto"}]})
        for one in [scene, more, more.copy()]:
            self.assertEqual(tessera.render(one, size=(16, 12), engine="native").size, (16, 12))
        path = scene["volumes"][0]["path"]
        self.assertTrue(os.path.exists(path))
        del scene, one
        self.assertFalse(os.path.exists(path))

    def test_names_are_known(self):
        self.assertIn("bone-1", tessera.presets())
        self.assertIn("anterior", tessera.views())
        self.assertTrue(tessera.looks())
        self.assertIn("shading.ambient", tessera.scene_keys())


if __name__ == "__main__":
    unittest.main()
