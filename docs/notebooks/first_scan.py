# %% [markdown]
# # A first scan
#
# This notebook makes three labelled scans of a town, looks at them, reads them as numpy arrays, and compares them
# with the noise-free truth. It takes a few seconds, and needs the program `scanmill`, its Python package and
# matplotlib.
# %%
import matplotlib.pyplot as plt
import numpy as np
import scanmill
from IPython.display import Image

plt.rcParams.update({"figure.dpi": 80, "axes.spines.top": False, "axes.spines.right": False})


# %% [markdown]
# ## Make a dataset
#
# A pipeline says what is scanned, from where, by which sensor, and how the dataset is written. Here an HDL-64E on the
# roof of a car drives through the town of seed 3; another seed is another town. `effects` is the noise: `sensor` are
# the effects that the file of the HDL-64E lists. [The keys](../keys.md) have all settings.
# %%
drive = {
    "scenes": [{"scene": "town", "seeds": [3]}],
    "trajectories": [{"name": "drive", "along": "turns", "speed": 9, "every_m": 14, "frames": 3}],
    "sensors": [{"name": "top", "preset": "hdl_64e", "mount": {"position": [0, 0, 1.73]}}],
    "vehicle": {"scene": "vehicle", "returns": "drop"},  # the car hides a part of the lowest rings
    "motion": "per_column",  # the car drives during a revolution
    "method": "ray_tracing",
    "effects": ["sensor", "reflectance_variation"],
    "output": {"objects": True, "formats": ["pcd"]},
}
dataset = scanmill.generate(drive, "noisy", quiet=True)

# %% [markdown]
# ## Look at it
#
# The command `scanmill view noisy` opens a window; `picture` needs no display. Colours are classes, and boxes state
# which part of an object the sensor sees.
# %% tags=["thumbnail"]
Image(scanmill.picture(dataset, "town.png", size="840x470"))

# %% [markdown]
# ## Read it
#
# A dataset is a sequence of samples, and a sample has a scan of each sensor. Columns are numpy arrays: besides `xyz`
# (m, x forward, y left, z up) there are the class, the object, the intensity, the ring and column of the beam, and
# the time.
# %%
scan = dataset[1].scan()
print(f"{len(dataset)} samples, about {len(scan) / 1000:.0f} thousand points in the second one")
for name in ("xyz", *scan.names):
    print(f"{name:10} {str(scan[name].dtype):8} {scan[name].min():8.1f} to {scan[name].max():.1f}")

# %% [markdown]
# ## Points of each class
#
# The dataset's ontology knows the names and colours of the classes. Vegetation and ground take most of the beams, and
# people few of them: note the logarithmic axis.
# %%
ids, counts = np.unique(scan.label, return_counts=True)
order = [i for i in np.argsort(counts) if counts[i] >= 10]
colors = dataset.ontology.palette() / 255

plt.figure(figsize=(8, 5))
plt.barh([dataset.ontology.name_of(ids[i]) for i in order], counts[order], color=colors[ids[order]], log=True)
plt.xlabel("points in the scan")
plt.show()

# %% [markdown]
# ## The range image
#
# Each beam has a pixel, so the image has no holes and no collisions; a pixel without a colour is a beam without a
# return. The lasers of an HDL-64E look in different azimuths: each row is shifted by that of its laser ("destaggered"),
# which makes upright things upright. Column 0 looks forward and is put in the middle.
# %%
pixels = scanmill.beam_projection(scan)
distance = pixels.image(scan.range, fill=np.nan)
classes = pixels.image(colors[scan.label], fill=1)

figure, axes = plt.subplots(2, 1, figsize=(11, 3.6), sharex=True, constrained_layout=True)
around = {"extent": (180, -180, 64, 0), "aspect": "auto", "interpolation": "nearest"}
shown = axes[0].imshow(np.roll(distance, scan.columns // 2, axis=1), cmap="viridis_r", norm="log", **around)
axes[1].imshow(np.roll(classes, scan.columns // 2, axis=1), **around)
axes[0].set(ylabel="ring", title="range")
axes[1].set(ylabel="ring", title="class", xticks=range(180, -181, -45))
axes[1].set_xlabel("azimuth (deg): 0 is forward, 90 is left")
figure.colorbar(shown, ax=axes[0], label="m", ticks=[5, 10, 20, 50, 100], format="%d")
plt.show()

# %% [markdown]
# ## Boxes
#
# Each object has its exact box, the number of its points, and the part of it that is visible: the beams that hit it,
# divided by those that would hit it if nothing stood in front of it.
# %%
objects = dataset[1].objects()
users = np.isin(objects.class_names, ["car", "truck", "bus", "motorcycle", "bicycle", "rider", "pedestrian"])
near = objects.select(users & (objects.points >= 30) & (np.linalg.norm(objects.centers, axis=1) < 40))
print("class         x (m)   y (m)  length (m)  visible")
for name, box, visible in zip(near.class_names, near.boxes(), near.visibility):
    print(f"{name:11} {box[0]:7.1f} {box[1]:7.1f} {box[3]:11.1f} {visible:8.0%}")

# %%
figure, axis = plt.subplots(figsize=(11, 5.2))
axis.scatter(*scan.xyz[:, :2].T, s=0.7, c=colors[scan.label], linewidths=0)
for x, y, _, length, width, _, yaw in near.boxes():
    box = plt.Rectangle((x - length / 2, y - width / 2), length, width, angle=np.degrees(yaw), rotation_point="center")
    axis.add_patch(box)
    box.set(fill=False, edgecolor="black", linewidth=1.5)
axis.set(xlim=(-28, 36), ylim=(-11, 17), aspect="equal", xlabel="x, forward (m)", ylabel="y, left (m)")
plt.show()

# %% [markdown]
# ## Noise and truth
#
# Noise never moves a beam: the same pipeline without effects is the noise-free reference, and ring and column match the
# two beam by beam. A real beam is wide, though (`footprint`), and may report another surface than its middle ray hits.
# %%
exact = scanmill.generate(drive, "exact", set={"effects": None}, quiet=True)[1].scan()

beams, exact_beams = (s.ring.astype(int) * s.columns + s.column for s in (scan, exact))
_, rows, exact_rows = np.intersect1d(beams, exact_beams, return_indices=True)
error = scan.range[rows] - exact.range[exact_rows]
truth = exact.label[exact_rows]
print(f"{len(rows) / len(exact_beams):.0%} of the beams that hit something have a return")
print(f"{(scan.label[rows] != truth).mean():.1%} of these report another class than the middle of the beam hits")

# %% [markdown]
# On roads and cars the error of the range is that of the receiver and of its unequal lasers: a few centimetres. Beams
# have a width, too, so in trees and at edges a part of a beam hits something else, and the return may come from
# there: these are the errors above 10 cm.
# %%
figure, (left, right) = plt.subplots(1, 2, figsize=(11, 3.2), constrained_layout=True)
for name in ["road", "sidewalk", "wall", "car", "vegetation", "tree"]:
    own = error[truth == dataset.ontology.id_of(name)]
    color = colors[dataset.ontology.id_of(name)]
    right.barh(name, (np.abs(own) > 0.1).mean() * 100, color=color)
    if name in ("road", "car", "tree"):
        bins = np.arange(-10, 10.1, 0.5)
        left.hist(own * 100, bins, density=True, histtype="step", color=color, linewidth=2, label=name)
left.set(xlabel="error of the range (cm)", ylabel="density (1/cm)")
left.legend(frameon=False)
right.set(xlabel="points with an error above 10 cm (%)")
plt.show()

# %% [markdown]
# ## Go on
#
# [Python](../python.md) describes all of the package, [Choose the noise](../noise.md) the effects. The next notebooks
# scan [your own mesh with your own sensor](own_mesh_and_sensor.ipynb), and [train a small
# network](train_and_judge.ipynb).
