"""The classes of a dataset or a scene, and look-up tables for labels."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Union

import numpy as np
from numpy.typing import NDArray

from ._core import InputError
from .words import advice

# The classes of one train id: the name of a class, or names of several classes.
Group = Union[str, Sequence[str]]

LABELS = 65536  # number of values that a label can have


class Ontology:
    """The classes of labels. Class 0 is always "unlabeled".

    Attributes, with K classes in the order of the ontology:
      name    name of the ontology
      ids     int32 (K,), as in the column `label`
      names   K strings
      colors  uint8 (K, 3): red, green, blue
      things  bool (K,): True if objects of the class are countable and have instance ids
    """

    def __init__(self, classes: Mapping[str, Any]) -> None:
        """`classes`: the value of the key `ontology` in a manifest."""
        self.name: str = classes["name"]
        listed = classes["classes"]
        self.ids: NDArray[np.int32] = np.array([c["id"] for c in listed], np.int32)
        self.names: tuple[str, ...] = tuple(c["name"] for c in listed)
        self.colors: NDArray[np.uint8] = np.array([c["color"] for c in listed], np.uint8).reshape(-1, 3)
        self.things: NDArray[np.bool_] = np.array([c["thing"] for c in listed], bool)
        self._ids: dict[str, int] = {}
        for c in listed:
            for alias in c.get("aliases", []):
                self._ids.setdefault(alias, c["id"])
        self._ids.update((c["name"], c["id"]) for c in listed)
        self._names = {c["id"]: c["name"] for c in listed}

    def __len__(self) -> int:
        return len(self.names)

    def __repr__(self) -> str:
        return f"<Ontology {self.name}: {len(self)} classes>"

    def id_of(self, name: str) -> int:
        """Returns the id of the class with this name or alias. Raises InputError, which suggests a similar name, if
        there is no such class."""
        if name not in self._ids:
            raise InputError(f"the ontology {self.name} has no class '{name}'{advice(name, self.names)}")
        return self._ids[name]

    def name_of(self, class_id: int) -> str:
        """Returns the name of the class with this id. Raises InputError if there is no such class."""
        if int(class_id) not in self._names:
            raise InputError(f"the ontology {self.name} has no class {class_id}")
        return self._names[int(class_id)]

    def train_ids(self, groups: Sequence[Group] | None = None, ignore: int = 255) -> NDArray[Any]:
        """Returns a table (65536,) from labels to train ids: table[scan.label] are the classes that a network learns.

        Train ids start at 0, in the order of `groups`: each group is the name (or alias) of a class, or a list of
        names. The default is one group for each class except "unlabeled", in the order of the ontology. Labels in no
        group get the train id `ignore`. The table is uint8 if `ignore` is below 256, otherwise int32. Raises
        InputError for an unknown name, for a name that is given twice, and if there are more groups than `ignore`.
        """
        wanted = [name for name, i in zip(self.names, self.ids) if i != 0] if groups is None else list(groups)
        if not len(wanted) <= ignore < LABELS:
            raise InputError(f"ignore must be from {len(wanted)} to {LABELS - 1}, above all train ids")
        table = np.full(LABELS, ignore, np.uint8 if ignore < 256 else np.int32)
        seen: set[int] = set()
        for train_id, group in enumerate(wanted):
            for name in [group] if isinstance(group, str) else group:
                class_id = self.id_of(name)
                if class_id in seen:
                    raise InputError(f"the class '{self.name_of(class_id)}' has two train ids")
                seen.add(class_id)
                table[class_id] = train_id
        return table

    def palette(self) -> NDArray[np.uint8]:
        """Returns a table (65536, 3) from labels to red, green, blue; black for labels without a class."""
        table = np.zeros((LABELS, 3), np.uint8)
        table[self.ids] = self.colors
        return table
