"""Readers of shards see every sample once, whatever the numbers of ranks, workers and shards."""

import itertools
import tarfile
import tempfile
import unittest
from pathlib import Path

import numpy as np
from support import FakeShards

import scanmill
from scanmill.augment import generator
from scanmill.shards import Reading, _keys_in, share

SIZES = [[5], [1], [0], [3, 0, 4], [1] * 7, [10, 1, 1, 1], [4] * 12, [0, 0, 9, 2]]


def read_all(shards, readers, shuffle=0, epoch=0):
    """What each reader sees."""
    options = {"readers": readers, "shuffle": shuffle, "rng": lambda p: generator(1, 0, epoch, p)}
    return [list(Reading(shards, reader=reader, **options)) for reader in range(readers)]


class Readers(unittest.TestCase):
    def test_see_every_sample_once(self):
        for sizes, readers, shuffle in itertools.product(SIZES, [1, 2, 3, 5, 8, 16, 33], [0, 1, 2, 4, 100]):
            shards = FakeShards(sizes)
            with self.subTest(sizes=sizes, readers=readers, shuffle=shuffle):
                seen = [key for own in read_all(shards, readers, shuffle) for key in own]
                self.assertEqual(sorted(seen), shards.all())

    def test_take_whole_shards_where_there_are_enough(self):
        for own in read_all(FakeShards([4] * 12), 5, shuffle=1):
            parts = [key.split("-")[0] for key in own]
            self.assertTrue(all(parts.count(part) == 4 for part in parts))

    def test_take_even_parts_where_there_are_few(self):
        for sizes, readers in itertools.product(SIZES, [5, 8, 16, 33]):
            if len(sizes) >= readers:
                continue
            counts = [len(own) for own in read_all(FakeShards(sizes), readers)]
            self.assertLessEqual(max(counts) - min(counts), 1)

    def test_without_shuffling_keep_the_order(self):
        shards = FakeShards([3, 0, 4])
        self.assertEqual(read_all(shards, 1)[0], [key for s in range(3) for key in shards.keys(s)])

    def test_shuffle_anew_each_epoch_and_the_same_each_time(self):
        shards = FakeShards([20] * 6)
        first, again, later = (read_all(shards, 2, 50, epoch) for epoch in (0, 0, 1))
        self.assertEqual(first, again)
        self.assertNotEqual(first, later)
        self.assertNotEqual(first[0], sorted(first[0]))
        # Shards too come in another order, so that ranks see other ones.
        self.assertNotEqual(sorted(first[0]), sorted(later[0]))

    def test_mix_samples_of_different_shards(self):
        order = [int(key[1]) for key in read_all(FakeShards([50] * 6), 1, 100)[0]]
        changes = np.count_nonzero(np.diff(order))
        self.assertGreater(changes, 100)

    def test_parts_follow_each_other(self):
        self.assertEqual(share([3, 0, 4], 2, 0), [(0, 0, 3)])
        self.assertEqual(share([3, 0, 4], 2, 1), [(2, 0, 4)])
        self.assertEqual(share([7], 2, 1), [(0, 3, 7)])
        for reader in (-1, 2):
            with self.assertRaises(scanmill.InputError):
                share([1], 2, reader)


class Files(unittest.TestCase):
    def test_with_headers_that_state_more_than_they_hold_are_refused(self):
        with tempfile.TemporaryDirectory() as folder:
            shard = Path(folder) / "a.tar"
            for kind in (tarfile.REGTYPE, tarfile.GNUTYPE_LONGNAME, tarfile.XHDTYPE, tarfile.GNUTYPE_SPARSE):
                for size in (2**33, 10**12, 2**62, 2**80):
                    header = tarfile.TarInfo("a.top.pcd")
                    header.type, header.size = kind, size
                    shard.write_bytes(header.tobuf(tarfile.GNU_FORMAT) + bytes(1024))
                    with self.assertRaisesRegex(scanmill.InputError, "a.tar: cannot be read as a shard"):
                        _keys_in(str(shard))


if __name__ == "__main__":
    unittest.main()
