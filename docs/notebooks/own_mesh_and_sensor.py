# %% [markdown]
# # Your own mesh and your own sensor
#
# This notebook makes a scene of numpy arrays, describes a sensor in six lines, compares it with two that come with
# the program, shows what a beam of finite width does at edges, moves an object from scan to scan, and labels an OBJ
# file by rules. No dataset is written: scans are numpy arrays in memory.
# %%
import matplotlib.pyplot as plt
import numpy as np
import scanmill
from IPython.display import Image

plt.rcParams.update({"figure.dpi": 80, "axes.spines.top": False, "axes.spines.right": False})

# %% [markdown]
# ## A mesh of arrays
#
# A part of a scene has vertices (m, z up), triangles, and a class for all of them or for each. Two functions make
# what the hall below consists of: boxes, and bodies of revolution. Meshes of Open3D and trimesh are parts too.
# %%


def box(length, width, height):
    corners = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (0, 1)]) * [length, width, height]
    # Floor, ceiling, and four sides.
    quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]]
    return {"vertices": corners, "triangles": [t for a, b, c, d in quads for t in ([a, b, c], [a, c, d])]}


def revolve(profile, steps=48):
    turns = np.linspace(0, 2 * np.pi, steps, endpoint=False)
    vertices = [[r * np.cos(t), r * np.sin(t), z] for r, z in profile for t in turns]
    i = np.arange(len(profile) - 1)[:, None] * steps + np.arange(steps)
    j = np.arange(len(profile) - 1)[:, None] * steps + (np.arange(steps) + 1) % steps
    triangles = np.concatenate([np.stack(t, -1).reshape(-1, 3) for t in ([i, j, i + steps], [j, j + steps, i + steps])])
    return {"vertices": vertices, "triangles": triangles}


# %% [markdown]
# The walls of the hall are one part, whose triangles have different classes. A part of a class with instances, such
# as `object`, is a thing with an instance number.
# %%
faces = ["ground"] * 2 + ["structure"] * 2 + ["wall"] * 8
tank = revolve([(0.4, 0), (0.4, 0.6), (1.4, 1.2), (1.4, 3.6), (1.1, 4.1), (0, 4.4)])
hall = scanmill.Scene.from_arrays([
    {"name": "hall", **box(20, 14, 6), "class": faces, "material": "concrete"},
    {"name": "tank 1", **tank, "class": "object", "material": "metal_bare", "pose": {"position": [1, 4, 0]}},
    {"name": "tank 2", **tank, "class": "object", "material": "metal_bare", "pose": {"position": [5, 4, 0]}},
    {"name": "crate", **box(0.4, 1.6, 1.5), "class": "object", "material": "wood", "pose": {"position": [9.7, 0.5, 0]}},
    {"name": "truck", **box(2.6, 1.3, 2), "class": "other_vehicle", "pose": {"position": [2, -3, 0], "yaw_deg": 20}},
])  # fmt: skip

# %% [markdown]
# ## A sensor of your own
#
# These keys describe a sensor that exists nowhere yet: 40 rings, 720 columns, ten revolutions a second. [Use your own
# sensor](../own_sensor.md) has more, such as a unit's calibration file.
# %%
mine = scanmill.sensor(
    {
        "columns": 720,
        "rate_hz": 10,
        "elevation_deg": {"top": 16, "bottom": -24, "rings": 40},
        "range_m": [0.3, 50],
        "divergence_mrad": 8,  # the width of the beams, and
        "pulse_ns": 5,  # the length of the pulses, which only the effects below need
    },
    mount={"position": [0, 0, 1.6]},
)
start = {"position": [-5, 0, 0]}
scan = hall.scan(mine, start)
colors = hall.ontology.palette() / 255
for name, thing in hall.objects().items():
    print(f"{name}: at {thing.pose[:3, 3].tolist()} m, instances {thing.instances}")

# %% [markdown]
# The viewer of the program reads tables: a scan with its labels becomes a picture in a few lines. (A dataset of such
# scans is written by `scanmill.DatasetWriter`.)
# %%
table = scan.points(["x", "y", "z", "label"])
np.savetxt("hall.csv", table, fmt="%.6g", delimiter=",", header="x,y,z,label", comments="")
looks = {"camera": "14,26,17,2.5,0,-0.5", "point_size": 2, "hide": "structure", "size": "840x420"}
Image(scanmill.picture("hall.csv", "hall.png", ontology="scanmill", **looks))

# %% [markdown]
# ## Compare sensors
#
# The same hall, seen from the same place by an Ouster OS1-128, which turns, and by a Livox Avia, whose prisms draw a
# rosette. `scanmill list sensors` lists all that come with the program.
# %% tags=["thumbnail"]
sensors = {"mine": mine}
for name in ("os1_128", "livox_avia"):
    sensors[name] = scanmill.sensor(name, mount={"position": [0, 0, 1.6]})
scans = {name: hall.scan(sensor, start) for name, sensor in sensors.items()}

figure, axes = plt.subplots(1, 3, figsize=(10, 3.6), sharey=True, constrained_layout=True)
for axis, (name, seen) in zip(axes, scans.items()):
    x, y, z = seen.xyz.T
    angles = np.degrees([np.arctan2(y, x), np.arctan2(z, np.hypot(x, y))])
    axis.scatter(*angles, s=2, c=colors[seen.label], linewidths=0)
    axis.set(title=name, xlim=(36, -36), ylim=(-36, 36), aspect="equal", facecolor="0.1", xlabel="azimuth (deg)")
axes[0].set_ylabel("elevation (deg)")
plt.show()

# %% [markdown]
# How many points the crate gets decides whether a network can find it. The rosette is densest in its middle, where
# the crate is.
# %%
crate = hall.objects()["crate"].instances[0]
for name, seen in scans.items():
    share = np.mean(seen.instance == crate)
    print(f"{name:10} {len(seen) / 1000:4.0f} thousand points, {share:.2%} of them on the crate")

# %% [markdown]
# ## Effects: a beam has a width
#
# Without effects a beam is a line, and each point lies on a surface. `footprint` traces several rays in each beam.
# Where a beam meets the crate and the wall half a metre behind it, both returns come within one pulse, and the sensor
# reports a point between them: a mixed pixel. `range_noise` scatters all points along their beams. The picture shows
# an edge of the crate from above, with columns four times as dense as above.
# %%
wide = {"footprint": {"rays": 37}}
noise = {"range_noise": {"sigma_m": 0.02}}
effects = {"exact": [], "footprint": ["intensity", wide], "footprint and noise": ["intensity", wide, noise]}

figure, axes = plt.subplots(1, 3, figsize=(11, 3.9), sharey=True, constrained_layout=True)
for axis, (name, chosen) in zip(axes, effects.items()):
    seen = hall.scan({**mine, "columns": 2880}, {"position": [3, 0, 0]}, effects=chosen)
    x, y, z = seen.world_xyz().T
    part = (z > 0.1) & (z < 1.45)
    axis.scatter(x[part], y[part], s=8, c=colors[seen.label[part]], linewidths=0)
    axis.set(title=name, xlim=(9.4, 10.1), ylim=(0.95, 1.65), aspect="equal", facecolor="0.1", xlabel="x (m)")
axes[0].set_ylabel("y (m)")
plt.show()

# %% [markdown]
# ## Move an object
#
# `poses` places objects for one scan, as another simulator or a loop of your own moves them; `None` leaves an object
# out. Instance numbers stay the same.
# %%
truck = hall.objects()["truck"].instances[0]
figure, axis = plt.subplots(figsize=(8, 4.6))
for step in range(3):
    pose = {"position": [2 + 2.2 * step, -3 + 0.9 * step, 0], "yaw_deg": 20}
    seen = hall.scan(mine, start, time=float(step), poses={"truck": pose})
    x, y, _ = seen.world_xyz()[seen.instance == truck].T
    axis.scatter(x, y, s=4, label=f"{step} s")
    print(f"{step} s: the middle of the truck's points is at x = {x.mean():.1f} m, y = {y.mean():.1f} m")
empty = hall.scan(mine, start, poses={"truck": None})
x, y, z = empty.world_xyz().T
axis.scatter(x[z < 2], y[z < 2], s=0.5, c="0.75", linewidths=0, zorder=0, label="without it")
axis.set(xlim=(-10.2, 10.2), ylim=(-7.2, 7.2), aspect="equal", xlabel="x (m)", ylabel="y (m)")
axis.legend(loc="center left", bbox_to_anchor=(1, 0.5), markerscale=3, frameon=False)
plt.show()

# %% [markdown]
# ## Meshes in files
#
# A scene file places files of meshes, and its rules say which class and material each part has, by the part's name,
# material, size or place. This example comes with the program: a hall in an OBJ file.
# %%
example = f"{scanmill.resource_folder}/pipelines/examples/your_meshes.scene.yaml"
print(open(example).read())

# %%
files = scanmill.load_scene(example)
scan = files.scan(mine, {"position": [-6, 1, 0]})
for label, count in zip(*np.unique(scan.label, return_counts=True)):
    print(f"{files.ontology.name_of(label):8} {count / len(scan):4.0%}")

# %% [markdown]
# ## Go on
#
# [Use your own scene](../own_scene.md) describes rules and what `scanmill draft` guesses of them,
# [Python](../python.md) all that scans of arrays can do. The next notebook [trains a small
# network](train_and_judge.ipynb).
