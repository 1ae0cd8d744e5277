"""Counts right and wrong predictions, for the intersection over union of classes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._core import InputError


class ConfusionMatrix:
    """Counts how many points of each class were taken for which class.

        confusion = ConfusionMatrix(["road", "car"])
        confusion.add(sample["target"], predicted)
        print(confusion, confusion.miou)

    Attributes, with K classes:
      classes  K names, in the order of the train ids
      ignore   train id of points that are not evaluated
      matrix   int64 (K, K): row: train id of the target, column: of the prediction
    """

    def __init__(self, classes: Sequence[str], ignore: int = 255) -> None:
        self.classes = tuple(classes)
        self.ignore = ignore
        self.matrix: NDArray[np.int64] = np.zeros((len(self.classes), len(self.classes)), np.int64)

    def add(self, target: ArrayLike, predicted: ArrayLike) -> None:
        """Adds points: arrays or tensors in the CPU's memory, of one shape. Points of which the target or the
        prediction is `ignore` do not count. Raises InputError for other shapes, and for numbers that are no train
        ids."""
        truth, answer = np.asarray(target), np.asarray(predicted)
        if truth.shape != answer.shape:
            raise InputError(f"target and predicted must have one shape, not {truth.shape} and {answer.shape}")
        counted = (truth != self.ignore) & (answer != self.ignore)
        truth, answer, size = truth[counted].astype(np.int64), answer[counted].astype(np.int64), len(self.classes)
        for name, values in (("target", truth), ("predicted", answer)):
            if values.size and not 0 <= values.min() <= values.max() < size:
                span = f"{values.min()} to {values.max()}"
                raise InputError(f"{name} has numbers from {span}, but there are {size} classes")
        self.matrix += np.bincount(truth * size + answer, minlength=size * size).reshape(size, size)

    def iou(self) -> NDArray[np.float64]:
        """Returns the intersection over union of each class, (K,): points that are right, divided by all points that
        are of the class or are taken for it. NaN for classes without such points."""
        right = np.diag(self.matrix)
        union = self.matrix.sum(0) + self.matrix.sum(1) - right
        return np.divide(right, union, out=np.full(len(right), np.nan), where=union > 0)

    @property
    def miou(self) -> float:
        """The mean of iou() over the classes that targets have; NaN without points."""
        present = self.matrix.sum(1) > 0
        return float(self.iou()[present].mean()) if present.any() else float("nan")

    @property
    def accuracy(self) -> float:
        """The share of the points that are right; NaN without points."""
        return float(np.trace(self.matrix) / self.matrix.sum()) if self.matrix.any() else float("nan")

    def __str__(self) -> str:
        """Returns a table: points, and intersection over union in percent, of each class and of all."""
        rows = [*zip(self.classes, self.matrix.sum(1), self.iou()), ("mean", self.matrix.sum(), self.miou)]
        width = max(len(name) for name, _, _ in rows)
        return "\n".join(f"{name:{width}} {points:12} {100 * iou:6.1f} %" for name, points, iou in rows)
