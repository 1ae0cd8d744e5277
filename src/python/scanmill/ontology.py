"""The classes of a dataset or a scene, and look-up tables for labels."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from typing import Any, Union

import numpy as np
from numpy.typing import NDArray

from ._core import InputError
from .words import advice

# The classes of one train id: the name of a class, or names of several classes.
Group = Union[str, Sequence[str]]

LABELS = 65536  # number of values that a label can have


def load_ontology(name_or_path: str | os.PathLike[str]) -> Ontology:
    """Returns the ontology of a file, or of one that comes with the program: "scanmill", "semantic_kitti", "nuscenes",
    "kitti", "carla", "cityscapes", "nyu40", "scannet" or "asprs". Raises InputError for an unknown name and a damaged file."""
    from .simulate import Scene  # imports this module

    # Scenes read ontologies, and need a triangle.
    part = {"class": "unlabeled", "vertices": np.eye(3), "triangles": [[0, 1, 2]]}
    return Scene.from_arrays([part], labels=os.fspath(name_or_path)).ontology


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

    def classes(self) -> list[dict[str, Any]]:
        """Returns the classes, as in a manifest: maps of id, name, color, thing and aliases."""
        rows = zip(self.ids.tolist(), self.names, self.colors.tolist(), self.things.tolist())
        return [
            {"id": i, "name": name, "color": color, "thing": thing, "aliases": self._aliases_of(i)}
            for i, name, color, thing in rows
        ]

    def _aliases_of(self, class_id: int) -> list[str]:
        return [alias for alias, i in self._ids.items() if i == class_id and alias not in self.names]

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


def common_ontology(ontologies: Sequence[Ontology]) -> tuple[Ontology, list[NDArray[np.int32] | None]]:
    """Returns an ontology with the classes of all, and for each of them a table (65536,) from its labels to common ids;
    None if it is equal to the common one. JoinedDataset states which classes are one."""
    common: list[dict[str, Any]] = []
    class_of: dict[str, dict[str, Any]] = {}  # the common class of each name
    tables: list[NDArray[np.int32] | None] = []
    for ontology in ontologies:
        own = ontology.classes()
        partners = _partners(own, common, class_of)
        used = {c["id"] for c in [*common, *own]}
        taken = {c["id"] for c in common}
        table = np.zeros(LABELS, np.int32)
        for c in own:
            joined = partners.get(c["name"])
            if joined is None:
                joined = {**c, "id": min(set(range(LABELS)) - used) if c["id"] in taken else c["id"]}
                used.add(joined["id"])
                common.append(joined)
            joined["aliases"] = [*joined["aliases"], *c["aliases"], c["name"]]
            class_of[c["name"]] = joined
            table[c["id"]] = joined["id"]
        tables.append(table)
    for c in common:  # a name of one class is no alias of another one
        c["aliases"] = [alias for alias in dict.fromkeys(c["aliases"]) if class_of.get(alias, c) is c]
    result = Ontology({"name": " + ".join(dict.fromkeys(o.name for o in ontologies)), "classes": common})
    same = [o.names == result.names and np.array_equal(o.ids, result.ids) for o in ontologies]
    return result, [None if equal else table for equal, table in zip(same, tables)]


def _partners(
    own: list[dict[str, Any]], common: list[dict[str, Any]], class_of: Mapping[str, dict[str, Any]]
) -> dict[str, dict[str, Any]]:
    """Returns the classes of `common` that are the same as classes of `own`, by the names of the latter."""
    partners = {c["name"]: other for c in own for other in common if c["name"] == other["name"]}
    known = [(c, class_of[c["name"]]) for c in own if c["name"] in class_of]
    pairs = [
        (c, other)
        for c in _narrow(own, common)
        for other in _narrow(common, own)
        if c["name"] in other["aliases"] or other["name"] in c["aliases"]
    ]
    alone = [p for p in pairs if sum(c is p[0] for c, _ in pairs) == sum(other is p[1] for _, other in pairs) == 1]
    for c, other in [*known, *alone]:
        if c["name"] not in partners and not any(other is partner for partner in partners.values()):
            partners[c["name"]] = other
    return partners


def _narrow(classes: list[dict[str, Any]], others: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Returns the classes whose aliases are names of at most one of the others."""
    names = {other["name"] for other in others}
    return [c for c in classes if len(names.intersection(c["aliases"])) < 2]
