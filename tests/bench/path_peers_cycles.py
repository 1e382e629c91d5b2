# tests/bench/path_peers_cycles.py: a scene of path_peers.py by Blender's Cycles, without a window:
#   blender -b --factory-startup -P path_peers_cycles.py -- SCENE.json
# Writes a picture for each number of samples, float32 grey, top row first, and CPU and wall seconds of rendering to
# the JSON's "times".
import json
import math
import os
import sys
import time

import bpy
import numpy as np
from mathutils import Matrix, Vector

with open(sys.argv[sys.argv.index("--") + 1], encoding="utf-8") as file:
    given = json.load(file)
bpy.ops.wm.read_factory_settings(use_empty=True)
scene = bpy.context.scene

volume = bpy.data.volumes.new("grid")
volume.filepath = given["vdb"]
volume.render.space = "WORLD"  # the grid's numbers are extinctions per mm
if hasattr(volume.render, "precision"):
    volume.render.precision = "FULL"
body = bpy.data.objects.new("grid", volume)
body.matrix_world = Matrix(given["patientFromIndex"])
scene.collection.objects.link(body)
material = bpy.data.materials.new("medium")
material.use_nodes = True
nodes = material.node_tree.nodes
nodes.clear()
medium = nodes.new("ShaderNodeVolumePrincipled")
medium.inputs["Color"].default_value = [given["albedo"]] * 3 + [1]
medium.inputs["Absorption Color"].default_value = [0, 0, 0, 1]
medium.inputs["Density"].default_value = 1
medium.inputs["Density Attribute"].default_value = "density"
medium.inputs["Anisotropy"].default_value = 0
material.node_tree.links.new(medium.outputs["Volume"], nodes.new("ShaderNodeOutputMaterial").inputs["Volume"])
volume.materials.append(material)


def turned(right, up, back, place):
    axes = Matrix((right, up, back)).transposed().to_4x4()
    axes.translation = place
    return axes


view = given["camera"]
camera = bpy.data.cameras.new("camera")
camera.type = "ORTHO"
camera.ortho_scale = view["height"]  # of square pictures
camera.clip_end = 1e5
eye = bpy.data.objects.new("camera", camera)
back = Vector(view["back"])
eye.matrix_world = turned(view["right"], view["up"], back, Vector(view["focal"]) + 2000 * back)
scene.collection.objects.link(eye)
scene.camera = eye

sun = bpy.data.lights.new("sun", "SUN")
sun.energy = math.pi  # irradiance at right angles
sun.angle = 0
lamp = bpy.data.objects.new("sun", sun)
lamp.rotation_mode = "QUATERNION"
lamp.rotation_quaternion = Vector(view["towardsLight"]).to_track_quat("Z", "Y")
scene.collection.objects.link(lamp)
scene.world = bpy.data.worlds.new("dark")
scene.world.color = (0, 0, 0)

scene.render.engine = "CYCLES"
cycles = scene.cycles
cycles.device = "CPU"
cycles.use_adaptive_sampling = False
cycles.use_denoising = False
cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0
cycles.light_sampling_threshold = 0
cycles.pixel_filter_type = "BOX"
cycles.max_bounces = cycles.volume_bounces = given["bounces"] - 1
cycles.volume_step_rate = given["stepRate"]
cycles.volume_max_steps = 65536
render = scene.render
render.threads_mode = "FIXED"
render.threads = given["threads"]
render.resolution_x = render.resolution_y = given["size"]
render.resolution_percentage = 100
render.use_persistent_data = True
render.image_settings.file_format = "OPEN_EXR"
render.image_settings.color_depth = "32"
given["times"] = {}  # the least of the seeds'
for seed in given["seeds"]:
    for samples in given["samples"]:
        cycles.samples = samples
        cycles.seed = seed
        render.filepath = given["out"] + ".exr"
        cpu, wall = sum(os.times()[:2]), time.time()
        bpy.ops.render.render(write_still=True)
        took = [sum(os.times()[:2]) - cpu, time.time() - wall]
        given["times"][samples] = min(given["times"].get(samples, took), took)
        picture = bpy.data.images.load(render.filepath, check_existing=False)
        picture.colorspace_settings.name = "Non-Color"
        pixels = np.array(picture.pixels[:], dtype=np.float32).reshape(given["size"], given["size"], 4)[::-1, :, 1]
        pixels.tofile(f"{given['out']}-{samples}-{seed}.f32")
        bpy.data.images.remove(picture)
with open(given["out"] + ".json", "w", encoding="utf-8") as file:
    json.dump(given, file)
