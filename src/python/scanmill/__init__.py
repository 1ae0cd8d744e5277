"""Labelled LiDAR datasets: read them as numpy arrays, and scan scenes from Python.

    import scanmill
    dataset = scanmill.open("out/quickstart")
    scan = dataset[0].scan()
    scan.xyz, scan.label                                    # float32 (N, 3) in m, int32 (N,)

    scene = scanmill.load_scene("town", seed=3)
    scan = scene.scan(scanmill.sensor("os1_128"), pose={"position": [0, 0, 2]})

The module scanmill.augment changes samples at random; scanmill.torch has datasets and batches for PyTorch. Errors in
files and arguments raise InputError, a ValueError. Other failures raise Error, a RuntimeError.
"""

from ._libraries import load_missing as _load_missing

_load_missing()

from ._core import Error, InputError, __version__, resource_folder, set_input_limit
from .batch import pad_batch
from .confusion import ConfusionMatrix
from .dataset import Dataset, Sample, decode, open_dataset as open
from .geometry import points_in_box, pose_matrix
from .joined import JoinedDataset
from .make import export, generate, picture, plan, verify
from .objects import Objects
from .ontology import Ontology, load_ontology as ontology
from .passes import PassWriter
from .range_image import Projection, beam_projection, range_image, spherical_projection
from .samples import SampleReader
from .scan import Scan, Stagger
from .simulate import Scene, SceneObject, load_scene, sensor
from .writer import DatasetWriter

__all__ = [
    "ConfusionMatrix",
    "Dataset",
    "DatasetWriter",
    "Error",
    "InputError",
    "JoinedDataset",
    "Objects",
    "Ontology",
    "PassWriter",
    "Projection",
    "Sample",
    "SampleReader",
    "Scan",
    "Scene",
    "SceneObject",
    "Stagger",
    "__version__",
    "beam_projection",
    "decode",
    "export",
    "generate",
    "load_scene",
    "ontology",
    "open",
    "pad_batch",
    "picture",
    "plan",
    "points_in_box",
    "pose_matrix",
    "range_image",
    "resource_folder",
    "sensor",
    "set_input_limit",
    "spherical_projection",
    "verify",
]
