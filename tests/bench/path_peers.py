#!/usr/bin/env python3
# tests/bench/path_peers.py: error against CPU time of paths beside Blender's Cycles and POV-Ray, in turns, on volumes
# that all three read: a grid of extinctions, one albedo, an even phase function, one directional light, no sky, a
# parallel camera. docs/measurements/paths.md has what came of it.
#
#   python3 tests/bench/path_peers.py --build build/release --work /tmp/peers ct.zarr:bone torso.zarr:soft-tissue
#
# Programs that are not installed are left out, with a sentence; the grids need Python's numpy and pyopenvdb.
# Debian: apt-get install --no-install-recommends blender povray python3-numpy python3-openvdb (and /usr/bin/python3).
#
# Error: rms over all pixels against a converged picture of Tessera's, once the other program's mean is scaled to it.
# So a wrong brightness counts for nobody, and the ratio of means tells whether the scene is the same. Noise: from two
# seeds. The error has the bias of steps, too, which no number of samples takes away.
import argparse
import json
import math
import os
import resource
import shutil
import subprocess
import sys
import time

HERE = os.path.dirname(os.path.abspath(__file__))


def run(command, **more):
    """CPU and wall seconds of a program and its output."""
    before, start = resource.getrusage(resource.RUSAGE_CHILDREN), time.time()
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False, **more)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    if done.returncode:
        sys.exit(f"{command[0]}: expected exit status 0, found {done.returncode}:\n{done.stdout[-2000:]}")
    cpu = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return cpu, time.time() - start, done.stdout


def read_grid(path):
    """Extinctions [z][y][x], and patient space from indices, 4x4."""
    with open(path, encoding="utf-8") as file:
        fields = json.load(file)
    axes = np.array(fields["direction"]).reshape(3, 3) * np.array(fields["spacing"])
    matrix = np.vstack([np.column_stack([axes, fields["origin"]]), [0, 0, 0, 1]]).tolist()
    values = np.fromfile(os.path.join(os.path.dirname(path), fields["data"]), "<f4")
    return values.reshape(fields["extent"][::-1]), matrix


def write_vdb(values, path):
    import pyopenvdb
    grid = pyopenvdb.FloatGrid()
    grid.copyFromArray(np.ascontiguousarray(values.transpose(2, 1, 0)), tolerance=0.0)
    grid.name = "density"
    pyopenvdb.write(path, grids=[grid])


def write_df3(values, path):
    with open(path, "wb") as file:
        file.write(np.array(values.shape[::-1], ">u2").tobytes())
        file.write(np.round(values / values.max() * 65535).astype(">u2").tobytes())


def picture(path, size):
    return np.fromfile(path, np.float32).reshape(size, size).astype(np.float64)


class Volume:
    def __init__(self, name, preset, options):
        self.options = options
        self.title = f"{os.path.basename(name)}, {preset}"
        self.base = os.path.join(options.work, f"{os.path.basename(name)}-{preset}")
        grid = self.base + ".json"
        run([options.tool, "--store", name, "--preset", preset, "--edge", str(options.edge),
             "--per-voxel", str(options.per_voxel), "--grid", grid])
        for old in (".vdb", ".df3"):
            if os.path.exists(self.base + old):
                os.remove(self.base + old)
        run([options.tessera, "import", grid, self.base + ".zarr", "--force", "-q"])
        self.values, self.matrix = read_grid(grid)
        self.most = float(self.values.max())

    def tessera(self, samples, seed, bounces):
        """CPU and wall seconds, the picture, its camera."""
        out = self.base + f"-t{samples}-{seed}-{bounces}.f32"
        o = self.options
        told = run([o.tool, "--store", self.base + ".zarr", "--picture", out, "--size", str(o.size), "--samples",
                    str(samples), "--seed", str(seed), "--bounces", str(bounces), "--albedo", str(o.albedo),
                    "--most", str(self.most), "--threads", str(o.threads)])[2]
        view = json.loads(told)
        return view["cpu"], view["wall"], picture(out, o.size), view

    def cycles(self, view, bounces, samples, step_rate):
        """(name, CPU and wall seconds, pictures of two seeds) for each number of samples."""
        o = self.options
        vdb = self.base + ".vdb"
        if not os.path.exists(vdb):
            write_vdb(self.values, vdb)
        out = self.base + f"-cycles-{bounces}-{step_rate}"
        matrix = np.array(self.matrix)
        matrix[:3, 3] -= matrix[:3, :3] @ np.full(3, 0.5)  # Cycles has the middle of voxel i at i + 0.5
        scene = {"vdb": vdb, "patientFromIndex": matrix.tolist(), "albedo": o.albedo, "camera": view,
                 "bounces": bounces,
                 "threads": o.threads, "size": o.size, "samples": [1] + samples, "seeds": [1, 2], "stepRate": step_rate,
                 "out": out}
        with open(out + "-scene.json", "w", encoding="utf-8") as file:
            json.dump(scene, file)
        run(["blender", "-b", "--factory-startup", "-P", os.path.join(HERE, "path_peers_cycles.py"), "--",
             out + "-scene.json"])
        with open(out + ".json", encoding="utf-8") as file:
            times = json.load(file)["times"]
        # The first picture of a seed reads the volume, which is not counted.
        return [(f"Cycles, {n} samples", *times[f"{n}"],
                 [picture(f"{out}-{n}-{seed}.f32", o.size) for seed in (1, 2)]) for n in samples]

    def povray(self, view, method, samples, rays):
        """The same, of one setting."""
        o = self.options
        df3 = self.base + ".df3"
        if not os.path.exists(df3):
            write_df3(self.values, df3)
        v = lambda a: "<" + ",".join(f"{x:.9g}" for x in a) + ">"
        m = np.array(self.matrix)
        shape = np.array(self.values.shape[::-1])
        axes = m[:3, :3] * shape  # of the box that POV-Ray has from 0 to 1
        corner = m[:3, 3]  # POV-Ray has the middle of voxel i at i
        back, focal = np.array(view["back"]), np.array(view["focal"])
        rows = ",".join(f"{x:.9g}" for x in [*axes[:, 0], *axes[:, 1], *axes[:, 2], *corner])
        pattern = f'density_file df3 "{df3}" interpolate 1 color_map {{ [0 rgb 0] [1 rgb 1] }}'
        sampling = f"method {method} " + (f"intervals {samples} samples 1, 1" if method == 1
                                          else f"intervals 1 samples {samples}, {samples}")
        text = f"""#version 3.7;
global_settings {{ assumed_gamma 1 }}
background {{ rgb 0 }}
camera {{ orthographic location {v(focal + 2000 * back)} direction {v(-back)}
  right {v(view["height"] * np.array(view["right"]))} up {v(view["height"] * np.array(view["up"]))} }}
light_source {{ {v(focal + 4000 * np.array(view["towardsLight"]))} rgb 0.25 // irradiance pi over 4 pi
  parallel point_at {v(focal)} media_attenuation on media_interaction on }}
box {{ 0, 1 pigment {{ rgbt 1 }} hollow
  interior {{ media {{ scattering {{ 1, rgb {o.albedo * self.most:.9g} extinction {1 / o.albedo:.9g} }} {sampling}
    density {{ {pattern} }} }} }}
  matrix <{rows}> }}
"""
        out = self.base + f"-pov-{method}-{samples}-{rays}"
        with open(out + ".pov", "w", encoding="utf-8") as file:
            file.write(text)
        more = ["+A0.0", "+AM1", f"+R{rays}"] if rays > 1 else ["-A"]
        cpu, wall, _ = run(["povray", f"+I{out}.pov", f"+O{out}.ppm", "+FP16", "File_Gamma=1", f"+W{o.size}",
                            f"+H{o.size}", f"+WT{o.threads}", "-D", "-GA", *more])
        with open(out + ".ppm", "rb") as file:
            data = file.read()
        pixels = np.frombuffer(data[-o.size * o.size * 6:], ">u2").reshape(o.size, o.size, 3)[:, :, 1] / 65535.0
        return f"POV-Ray, method {method}, {samples} samples, {rays}x{rays} rays", cpu, wall, [pixels]


def compare(volume, bounces, peers):
    """Prints rows; of each program's settings the least ratios of CPU seconds to equal error, and to equal noise."""
    o = volume.options
    a, b = volume.tessera(o.samples, 1, bounces), volume.tessera(o.samples, 2, bounces)
    truth = [volume.tessera(o.converged, seed, bounces)[2] for seed in (11, 12)]
    error_of_truth = math.sqrt(np.mean((truth[0] - truth[1]) ** 2)) / 2
    truth = (truth[0] + truth[1]) / 2
    noise = math.sqrt(np.mean((a[2] - b[2]) ** 2) / 2)
    cost = noise ** 2 * min(a[0], b[0])
    print(f"| {volume.title}, {bounces} | paths, {o.samples} samples | {min(a[0], b[0]):.2f} | "
          f"{min(a[1], b[1]):.2f} | 1 | {noise:.5f} | {noise:.5f} | 1 | 1 |")
    best = {}
    for name, cpu, wall, seen in peers(a[3]):
        ratio = seen[0].mean() / truth.mean()
        error = math.sqrt(max(np.mean((seen[0] / ratio - truth) ** 2) - error_of_truth ** 2, 1e-20))
        gains = [cpu * error ** 2 / cost, math.nan]
        noise = math.nan  # POV-Ray has no seed
        if len(seen) == 2:
            noise = math.sqrt(np.mean((seen[0] - seen[1]) ** 2) / 2) / ratio
            gains[1] = cpu * noise ** 2 / cost
        print(f"| | {name} | {cpu:.2f} | {wall:.2f} | {ratio:.3f} | {error:.5f} | {noise:.5f} | {gains[0]:.1f} | "
              f"{gains[1]:.1f} |", flush=True)
        program = name.split(",")[0]
        best[program] = np.fmin(best.get(program, [math.nan, math.nan]), gains)
    return best


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("volumes", nargs="+", metavar="STORE:PRESET")
    parser.add_argument("--build", default="build/release")
    parser.add_argument("--tessera", default="", help="the program (default: that of the build)")
    parser.add_argument("--work", required=True, help="folder for files")
    parser.add_argument("--edge", type=int, default=192, help="voxels along an axis, at most")
    parser.add_argument("--per-voxel", type=float, default=0,
                        help="scale extinctions to this greatest optical depth of a voxel; 0: as the function has them")
    parser.add_argument("--size", type=int, default=128)
    parser.add_argument("--samples", type=int, default=64)
    parser.add_argument("--converged", type=int, default=1024)
    parser.add_argument("--cycles", default="16,64", help="samples")
    parser.add_argument("--step-rates", default="1")
    parser.add_argument("--povray", default="3:30:1,1:60:1", help="method:samples:rays across a pixel")
    parser.add_argument("--albedo", type=float, default=0.8)
    parser.add_argument("--threads", type=int, default=2)
    o = parser.parse_args()
    o.tool = os.path.join(o.build, "path_peer")
    o.tessera = o.tessera or os.path.join(o.build, "tessera")
    os.makedirs(o.work, exist_ok=True)
    there = {name: shutil.which(name) for name in ("blender", "povray")}
    for name, path in there.items():
        if not path:
            print(f"{name} is not installed: left out.")
    try:
        import pyopenvdb  # noqa: F401
    except ImportError:
        there["blender"] = None
        print("Python's pyopenvdb is not installed: Cycles is left out.")
    if not any(there.values()):
        return
    print(f"{o.size}x{o.size}, {o.threads} threads, load {os.getloadavg()[0]:.1f}\n")
    print("| volume, scatterings | way | CPU s | wall s | mean | error | noise | time to equal error | to equal noise "
          "|")
    print("|---|---|---|---|---|---|---|---|---|")
    gains = {}
    for given in o.volumes:
        volume = Volume(*given.rsplit(":", 1), o)

        def cycles(view, bounces):
            for rate in o.step_rates.split(","):
                yield from volume.cycles(view, bounces, [int(n) for n in o.cycles.split(",")], float(rate))

        def one_scattering(view):
            if there["blender"]:
                yield from cycles(view, 1)
            if there["povray"]:
                for setting in o.povray.split(","):
                    yield volume.povray(view, *(int(n) for n in setting.split(":")))

        for program, gain in compare(volume, 1, one_scattering).items():
            gains.setdefault(program + ", one scattering", []).append(gain)
        if there["blender"]:
            for program, gain in compare(volume, 8, lambda view: cycles(view, 8)).items():
                gains.setdefault(program + ", eight", []).append(gain)
    print()
    for program, all_of in gains.items():
        means = np.exp(np.mean(np.log(all_of), axis=0))
        print(f"{program}: CPU time to equal error {means[0]:.1f} times as long, to equal noise {means[1]:.1f} "
              f"(its best settings, geometric mean of {len(all_of)})")
    print(f"load {os.getloadavg()[0]:.1f}")


if __name__ == "__main__":
    try:
        import numpy as np
    except ImportError:
        sys.exit("Python's numpy is not installed: nothing is compared.")
    main()
