"""Labels become train ids and colours by tables."""

import unittest

import numpy as np
from support import CLASSES

import scanmill

ONTOLOGY = scanmill.Ontology(CLASSES)


class OntologyTest(unittest.TestCase):
    def test_names_and_aliases_have_ids(self):
        self.assertEqual(ONTOLOGY.id_of("road"), 7)
        self.assertEqual(ONTOLOGY.id_of("street"), 7)
        self.assertEqual(ONTOLOGY.name_of(300), "truck")
        self.assertEqual(len(ONTOLOGY), 4)
        np.testing.assert_array_equal(ONTOLOGY.things, [False, False, True, True])
        with self.assertRaisesRegex(scanmill.InputError, "did you mean 'truck'"):
            ONTOLOGY.id_of("truk")
        with self.assertRaises(scanmill.InputError):
            ONTOLOGY.name_of(8)

    def test_a_name_comes_before_the_same_alias_of_another_class(self):
        classes = [*CLASSES["classes"], {"id": 9, "name": "street", "color": [0, 0, 0], "thing": False}]
        self.assertEqual(scanmill.Ontology({**CLASSES, "classes": classes}).id_of("street"), 9)

    def test_all_classes_but_unlabeled_have_a_train_id(self):
        table = ONTOLOGY.train_ids()
        self.assertEqual((table.shape, table.dtype), ((65536,), np.uint8))
        np.testing.assert_array_equal(table[[0, 7, 3, 300, 8, 65535]], [255, 0, 1, 2, 255, 255])

    def test_lists_become_one_train_id(self):
        table = ONTOLOGY.train_ids([["car", "truck"], "street"], ignore=9)
        np.testing.assert_array_equal(table[[3, 300, 7, 0]], [0, 0, 1, 9])
        self.assertEqual(ONTOLOGY.train_ids(["car"], ignore=300).dtype, np.int32)

    def test_wrong_train_ids_are_refused(self):
        for names, ignore in [(["car", "car"], 255), (["car", ["road", "street"]], 255), (["bike"], 255)]:
            with self.subTest(names=names), self.assertRaises(scanmill.InputError):
                ONTOLOGY.train_ids(names, ignore)
        for ignore in (2, -1, 65536):
            with self.subTest(ignore=ignore), self.assertRaises(scanmill.InputError):
                ONTOLOGY.train_ids(None, ignore)

    def test_colours(self):
        palette = ONTOLOGY.palette()
        np.testing.assert_array_equal(palette[[7, 300, 8]], [[128, 64, 128], [0, 0, 200], [0, 0, 0]])


if __name__ == "__main__":
    unittest.main()
