"""Archives of strangers: what they state is checked before it costs."""

import io
import resource
import struct
import unittest
import zipfile

import numpy as np

import scanmill
from scanmill.npz import read_npz


def npz_of(members, compression=zipfile.ZIP_DEFLATED):
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", compression) as archive:
        for name, content in members.items():
            archive.writestr(name, content)
    return out.getvalue()


def npy_of(header, content=b"", version=b"\x01\x00"):
    header = header.encode() + b"\n"
    return b"\x93NUMPY" + version + struct.pack("<H", len(header)) + header + content


def peak():
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024


class Npz(unittest.TestCase):
    def expect_refused(self, archive, *words):
        before = peak()
        with self.assertRaises(scanmill.InputError) as refused:
            read_npz(archive, "a.tar: the voxels")
        self.assertTrue(str(refused.exception).startswith("a.tar: the voxels: "), refused.exception)
        for word in words:
            self.assertIn(word, str(refused.exception))
        self.assertLess(peak() - before, 200 << 20)

    def test_reads_what_numpy_writes(self):
        arrays = {
            "label": np.arange(24, dtype=np.uint16).reshape(2, 3, 4),
            "size": np.array(0.2),
            "flags": np.asfortranarray([[True, False, True], [False, False, True]]),
            "none": np.zeros((0, 3)),
        }
        for save in (np.savez, np.savez_compressed):
            file = io.BytesIO()
            save(file, **arrays)
            read = read_npz(file.getvalue(), "x")
            self.assertEqual(list(read), list(arrays))
            for name, values in arrays.items():
                self.assertEqual(read[name].dtype, values.dtype)
                np.testing.assert_array_equal(read[name], values)
                self.assertTrue(read[name].flags.writeable)

    def test_of_more_than_it_may_state_is_refused(self):
        zeros = bytes(64 << 20)
        bomb = npz_of({f"{i}.npy": zeros for i in range(20)})
        stated, most = 20 * len(zeros), (1 << 30) + 64 * len(bomb)
        self.expect_refused(bomb, f"states {stated} bytes", f"{len(bomb)} bytes", f"at most {most}")

    def test_of_other_compression_is_refused(self):
        for compression in (zipfile.ZIP_BZIP2, zipfile.ZIP_LZMA):
            self.expect_refused(npz_of({"a.npy": npy_of("{}")}, compression), "a.npy", "deflate")

    def test_that_lies_about_its_sizes_is_refused(self):
        archive = npz_of({"a.npy": npy_of("{'descr': '<f8', 'fortran_order': False, 'shape': (9,), }", bytes(72))})
        place = archive.rindex(b"PK\x01\x02") + 24
        self.expect_refused(archive[:place] + struct.pack("<I", 20) + archive[place + 4 :])

    def test_of_arrays_that_state_more_than_they_hold_is_refused(self):
        for shape in ("(1000000000000,)", "(3,)", "(10**9, 10**9, 10**9)", "(-1,)", f"({2**62},)", f"({2**80},)", "x"):
            header = f"{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}, }}"
            self.expect_refused(npz_of({"a.npy": npy_of(header, bytes(16))}))

    def test_of_anything_but_arrays_of_numbers_is_refused(self):
        file = io.BytesIO()
        np.savez(file, a=np.array([{}], dtype=object))
        self.expect_refused(file.getvalue(), "objects of Python")
        whole = npz_of({"a.npy": npy_of("{'descr': '<f8', 'fortran_order': False, 'shape': (9,), }", bytes(72))})
        for damaged in (b"", b"PK\x03\x04", bytes(100), whole[:-30], whole[:40] + bytes(20) + whole[60:]):
            self.expect_refused(damaged)
        for content in (b"", b"\x93NUMPY", npy_of("{}"), npy_of("{", version=b"\x09\x00"), b"text"):
            self.expect_refused(npz_of({"a.npy": content}))


if __name__ == "__main__":
    unittest.main()
