"""Augmentation changes points, boxes and poses alike, and follows from seed, sample and epoch alone."""

import copy
import unittest

import numpy as np
from support import dataset_path, random_sample

import scanmill
from scanmill.augment import Compose, DropPoints, Flip, HideIntensity, Jitter, JitterIntensity, RingErrors, Scale, Turn, generator, mix
from scanmill.geometry import transformed

RIGID = [Flip("x", 1), Flip("y", 1), Flip("y", 0), Turn(), Turn(0.3, 0.3), Scale(0.5, 2)]
NOISE = [Jitter(), DropPoints(0.5), RingErrors(0.05, 0.01), HideIntensity(), JitterIntensity()]


def apply(transform, sample, index=0):
    return transform(sample, generator(1, index))


def distances(xyz):
    return np.linalg.norm(xyz[:, None] - xyz[None], axis=-1)


class Laws(unittest.TestCase):
    def setUp(self):
        self.sample = random_sample(np.random.default_rng(1))

    def test_inputs_do_not_change(self):
        for transform in RIGID + NOISE:
            before = copy.deepcopy(self.sample)
            after = apply(transform, self.sample)
            self.assertIsNot(after, self.sample)
            self.assertEqual(set(after), set(before))
            for name, values in before.items():
                np.testing.assert_array_equal(self.sample[name], values)
                if isinstance(values, np.ndarray):
                    self.assertEqual(after[name].dtype, values.dtype, name)

    def test_points_stay_in_their_boxes(self):
        for transform in RIGID + [DropPoints(0.5), Compose(RIGID + [DropPoints(0.5)], seed=3)]:
            for index in range(10):
                after = transform(self.sample, index) if isinstance(transform, Compose) else None
                after = apply(transform, self.sample, index) if after is None else after
                for number, box in enumerate(after["boxes"]):
                    own = after["xyz"][after["own"] == number]
                    self.assertGreater(len(own), 0)
                    self.assertTrue(scanmill.points_in_box(own, box, 1e-4).all())

    def test_points_stay_where_they_are_in_the_world(self):
        before = transformed(self.sample["world_from_sensor"], self.sample["xyz"])
        for transform in RIGID:
            after = apply(transform, self.sample)
            np.testing.assert_allclose(transformed(after["world_from_sensor"], after["xyz"]), before, atol=1e-4)

    def test_columns_that_tell_of_positions_follow_them(self):
        for transform in RIGID:
            after = apply(transform, self.sample)
            np.testing.assert_allclose(after["range_true"], np.linalg.norm(after["xyz"], axis=1), rtol=1e-5)
            azimuth = np.arctan2(after["xyz"][:, 1], after["xyz"][:, 0])
            apart = np.remainder(after["azimuth"] - azimuth + np.pi, 2 * np.pi) - np.pi
            np.testing.assert_allclose(apart, 0, atol=1e-5)

    def test_velocities_lead_where_the_points_go(self):
        """Moving along the velocity and then turning is turning and then moving along the turned velocity."""
        velocity = np.stack([self.sample[f"velocity_{axis}"] for axis in "xyz"], axis=1)
        later = {
            **self.sample,
            "xyz": self.sample["xyz"] + velocity,
            "boxes": self.sample["boxes"] + np.pad(self.sample["box_velocity"], [(0, 0), (0, 4)]),
        }
        for transform in RIGID:
            after, moved = apply(transform, self.sample), apply(transform, later)
            own = np.stack([after[f"velocity_{axis}"] for axis in "xyz"], axis=1)
            np.testing.assert_allclose(after["xyz"] + own, moved["xyz"], atol=1e-4)
            np.testing.assert_allclose(after["boxes"][:, :3] + after["box_velocity"], moved["boxes"][:, :3], atol=1e-4)

    def test_distances_stay_but_for_their_scale(self):
        before = distances(self.sample["xyz"][::10].astype(np.float64))
        for transform in RIGID:
            after = apply(transform, self.sample)
            scale = after["boxes"][0, 3] / self.sample["boxes"][0, 3]
            np.testing.assert_allclose(distances(after["xyz"][::10].astype(np.float64)), before * scale, atol=1e-3)
            np.testing.assert_allclose(after["boxes"][:, 3:6], self.sample["boxes"][:, 3:6] * scale, rtol=1e-5)

    def test_mirroring_twice_changes_nothing(self):
        for axis in "xy":
            twice = apply(Flip(axis, 1), apply(Flip(axis, 1), self.sample))
            np.testing.assert_array_equal(twice["xyz"], self.sample["xyz"])
            turned = np.remainder(twice["boxes"][:, 6] - self.sample["boxes"][:, 6] + 1, 2 * np.pi) - 1
            np.testing.assert_allclose(turned, 0, atol=1e-5)

    def test_samples_without_boxes_and_without_points(self):
        bare = {name: self.sample[name][:0] for name in ("xyz", "ring", "intensity")}
        for transform in RIGID + NOISE:
            self.assertEqual(len(apply(transform, bare)["xyz"]), 0)


class Noise(unittest.TestCase):
    def setUp(self):
        self.sample = random_sample(np.random.default_rng(2), boxes=20, each=500)

    def test_jitter_has_its_size(self):
        moved = apply(Jitter(0.01, 0.02), self.sample)["xyz"] - self.sample["xyz"].astype(np.float64)
        self.assertLessEqual(np.abs(moved).max(), 0.02 + 1e-5)
        # A normal distribution that is cut at two standard deviations has 0.96 of the spread.
        self.assertAlmostEqual(moved.std(), 0.0096, delta=0.0003)

    def test_points_are_dropped_with_their_columns(self):
        shares = []
        for index in range(200):
            after = apply(DropPoints(0.6), self.sample, index)
            shares.append(1 - len(after["xyz"]) / len(self.sample["xyz"]))
            self.assertEqual(len(after["intensity"]), len(after["xyz"]))
        np.testing.assert_array_equal(after["range_true"], np.linalg.norm(after["xyz"], axis=1))
        self.assertEqual(len(after["boxes"]), 20)
        self.assertLessEqual(max(shares), 0.62)
        self.assertAlmostEqual(np.mean(shares), 0.3, delta=0.04)
        self.assertEqual(len(apply(DropPoints(0), self.sample)["xyz"]), len(self.sample["xyz"]))

    def test_errors_are_those_of_the_ring(self):
        after = apply(RingErrors(0.05, 0.01), self.sample)
        before, moved = (s["xyz"].astype(np.float64) for s in (self.sample, after))

        def angles(xyz):
            flat = np.hypot(xyz[:, 0], xyz[:, 1])
            return np.hypot(flat, xyz[:, 2]), np.arctan2(xyz[:, 2], flat), np.arctan2(xyz[:, 1], xyz[:, 0])

        farther, higher, aside = (a - b for a, b in zip(angles(moved), angles(before)))
        np.testing.assert_allclose(aside, 0, atol=1e-5)
        for ring in range(16):
            own = self.sample["ring"] == ring
            self.assertLess(np.ptp(farther[own]), 1e-4)
            self.assertLess(np.ptp(higher[own]), 1e-4)
        self.assertGreater(farther.std(), 0.01)
        self.assertGreater(higher.std(), 0.002)

    def test_a_rings_errors_do_not_depend_on_other_rings(self):
        low = {name: v[self.sample["ring"] < 5] for name, v in self.sample.items() if name in ("xyz", "ring")}
        all_rings = apply(RingErrors(), self.sample)["xyz"][self.sample["ring"] < 5]
        np.testing.assert_array_equal(apply(RingErrors(), low)["xyz"], all_rings)

    def test_wrong_figures_are_refused(self):
        for make in (
            lambda: Flip("z"),
            lambda: Flip("x", 2),
            lambda: Turn(1, 0),
            lambda: Scale(0, 1),
            lambda: Jitter(-1),
            lambda: DropPoints(1.5),
            lambda: RingErrors(-1),
            lambda: HideIntensity(2),
            lambda: JitterIntensity(gain=(0, 1)),
            lambda: JitterIntensity(gamma=(2, 1)),
            lambda: JitterIntensity(full_scale=-1),
            lambda: mix.Choice([]),
            lambda: mix.Choice([mix.LaserMix()], 2),
            lambda: mix.LaserMix([]),
            lambda: mix.LaserMix([0]),
            lambda: mix.LaserMix(elevation=(1, 0)),
            lambda: mix.PolarMix(sector=7),
            lambda: mix.PolarMix(copies=0),
            lambda: mix.PolarMix(swap=-1),
            lambda: mix.PasteInstances([1], most=0),
            lambda: mix.PasteInstances([1], min_points=0),
        ):
            with self.assertRaises(scanmill.InputError):
                make()

    def test_wrong_samples_are_refused(self):
        image = {"xyz": np.zeros((2, 2, 3), np.float32)}
        short = {"xyz": np.zeros((3, 3), np.float32), "label": np.zeros(2)}
        lone = {"xyz": np.zeros((3, 3), np.float32), "velocity_x": np.zeros(3)}
        cases = [(Turn(), image), (DropPoints(), short), (RingErrors(), short)]
        for transform, sample in [*cases, *((transform, lone) for transform in (Turn(), HideIntensity(0), JitterIntensity()))]:
            with self.assertRaises(scanmill.InputError):
                apply(transform, sample)


class Intensities(unittest.TestCase):
    """Intensities are changed in the type in which they are stored."""

    def setUp(self):
        levels = np.linspace(0, 1, 256)
        self.samples = [
            {"xyz": np.zeros((256, 3), np.float32), "intensity": (levels * most).astype(kind)}
            for kind, most in ((np.uint8, 255), (np.uint16, 65535), (np.float32, 1))
        ]

    def test_hidden_ones_are_constant(self):
        for sample in self.samples:
            hidden = apply(HideIntensity(1, 1), sample)["intensity"]
            np.testing.assert_array_equal(hidden, 1)
            self.assertEqual(hidden.dtype, sample["intensity"].dtype)
            np.testing.assert_array_equal(apply(HideIntensity(0), sample)["intensity"], sample["intensity"])
        hidden = [apply(HideIntensity(0.3), sample, index)["intensity"].max() == 0 for index in range(500)]
        self.assertAlmostEqual(np.mean(hidden), 0.3, delta=0.07)

    def test_jitter_is_a_response_curve(self):
        for sample in self.samples:
            given = sample["intensity"]
            full = float(given.max())
            np.testing.assert_allclose(apply(JitterIntensity((1, 1), (1, 1)), sample)["intensity"], given, rtol=1e-6)
            bent = apply(JitterIntensity((0.5, 0.5), (2, 2)), sample)["intensity"]
            np.testing.assert_allclose(bent, 0.5 * full * (given / full) ** 2, rtol=1e-5, atol=0.501 * (full > 1))
            brighter = apply(JitterIntensity((3, 3), (1, 1)), sample)["intensity"]
            most = full if full > 1 else np.inf
            np.testing.assert_allclose(brighter, np.minimum(3.0 * given, most), rtol=1e-6)
            for index in range(20):
                changed = apply(JitterIntensity(), sample, index)["intensity"].astype(float)
                self.assertTrue((np.diff(changed) >= 0).all())
        of_255 = {**self.samples[2], "intensity": np.array([-1, 51, 255], np.float32)}
        bent = apply(JitterIntensity((1, 1), (2, 2), full_scale=255), of_255)["intensity"]
        np.testing.assert_allclose(bent, [0, 10.2, 255], rtol=1e-6)


CLASSES = [2, 3]
AREAS = mix.LaserMix([4], elevation=(-0.6, 0.6))
UNTURNED = [mix.LaserMix(), AREAS, mix.PolarMix(), mix.PasteInstances(CLASSES, most=2)]
MIXES = [*UNTURNED, mix.PolarMix(CLASSES), mix.Choice([mix.LaserMix(), mix.PolarMix(CLASSES)], 0.7)]


def mixable(seed, boxes=8, each=50):
    """A sample whose classes and instances are those of its boxes; `origin` tells all points of all seeds apart."""
    sample = random_sample(np.random.default_rng(seed), boxes, each)
    own = sample.pop("own")
    classes = (1 + np.arange(boxes) % 3).astype(np.uint16)
    return {
        **sample,
        "key": f"town-{seed}",
        "origin": 1000 * seed + np.arange(len(own)),
        "label": classes[own],
        "target": classes[own].astype(np.int64),
        "instance": (1 + own).astype(np.uint32),
        "column": np.arange(len(own)).astype(np.uint16),
        "box_class": classes,
        "box_instance": np.arange(1, boxes + 1).astype(np.uint32),
        "box_points": np.full(boxes, each),
    }


def overlap(box, other):
    """True if a point of a grid over one of the boxes is in the other one, seen from above."""
    grid = np.stack(np.meshgrid(*[np.linspace(-0.5, 0.5, 60)] * 2), -1).reshape(-1, 2)
    for (x, y, _, length, width, _, yaw), there in ((box, other), (other, box)):
        along, across = (grid * [length, width]).T
        c, s = np.cos(yaw), np.sin(yaw)
        over = np.column_stack([x + along * c - across * s, y + along * s + across * c, np.full(len(grid), there[2])])
        if scanmill.points_in_box(over, there).any():
            return True
    return False


class Mixes(unittest.TestCase):
    def setUp(self):
        self.first, self.other = mixable(1), mixable(2)

    def mixed(self, mixes, count=10):
        return [one(self.first, self.other, generator(1, index)) for one in mixes for index in range(count)]

    def assert_same(self, sample, wanted, but=()):
        self.assertEqual(set(sample), set(wanted))
        for name in set(wanted) - set(but):
            np.testing.assert_array_equal(sample[name], wanted[name], name)

    def test_inputs_do_not_change_and_types_stay(self):
        before = copy.deepcopy((self.first, self.other))
        for after in self.mixed(MIXES):
            self.assert_same(self.first, before[0])
            self.assert_same(self.other, before[1])
            self.assertIsNot(after, self.first)
            self.assertEqual(set(after), set(self.first))
            for name, values in self.first.items():
                if name in ("key", "world_from_sensor"):
                    np.testing.assert_array_equal(after[name], values)
                else:
                    self.assertEqual(after[name].dtype, values.dtype, name)

    def test_points_come_from_one_scan_with_all_their_columns(self):
        both = {n: np.concatenate([v, self.other[n]]) for n, v in self.first.items() if isinstance(v, np.ndarray)}
        for mixes, turned in ((UNTURNED, ()), (MIXES, ("xyz", "azimuth", "velocity_x", "velocity_y"))):
            for after in self.mixed(mixes):
                rows = np.searchsorted(both["origin"], after["origin"])
                self.assertTrue(turned or len(np.unique(rows)) == len(rows))
                for name in set(both) - {"world_from_sensor", "instance", *turned}:
                    if not name.startswith("box"):
                        np.testing.assert_array_equal(after[name], both[name][rows], name)

    def test_instances_are_unique_and_in_their_boxes(self):
        for sample in (self.first, self.other):
            sample["instance"][:50] = sample["box_points"][0] = 0
        for after in self.mixed(MIXES):
            np.testing.assert_array_equal(after["instance"] == 0, after["origin"] % 1000 < 50)
            self.assertEqual(len(np.unique(after["box_instance"])), len(after["boxes"]))
            for number, box, count in zip(after["box_instance"], after["boxes"], after["box_points"]):
                own = after["instance"] == number
                self.assertEqual(own.sum(), count)
                self.assertTrue(scanmill.points_in_box(after["xyz"][own], box, 1e-3).all())
            for number in set(after["instance"]) - {0}:  # all points are from one box of one scan
                self.assertEqual(len(np.unique(after["origin"][after["instance"] == number] // 50)), 1)

    def test_areas_alternate(self):
        def area(xyz):
            up = np.arctan2(xyz[:, 2], np.hypot(xyz[:, 0], xyz[:, 1]))
            return np.clip(np.floor((up + 0.6) / 0.3), 0, 3).astype(int)

        lowest = set()
        for after in self.mixed([AREAS]):
            of_first, of_other = (area(after["xyz"][after["origin"] // 1000 == seed]) % 2 for seed in (1, 2))
            lowest.add(of_first[0])
            self.assertEqual((set(of_first), set(of_other)), ({of_first[0]}, {1 - of_first[0]}))
            for sample, parities in ((self.first, of_first), (self.other, of_other)):
                self.assertEqual(len(parities), (area(sample["xyz"]) % 2 == parities[0]).sum())
                boxes = (after["boxes"][:, np.newaxis] == sample["boxes"]).all(-1).any(0)
                np.testing.assert_array_equal(boxes, area(sample["boxes"]) % 2 == parities[0])
        self.assertEqual(lowest, {0, 1})

    def test_a_scan_mixed_with_itself_stays(self):
        for one in (mix.LaserMix(), mix.PolarMix(swap=1), mix.PasteInstances([1, 2, 3])):
            after = one(self.first, self.first, generator(1, 0))
            points, boxes = np.argsort(after["origin"]), np.argsort(after["boxes"][:, 0])
            for name in ("xyz", "origin", "label", "ring"):
                np.testing.assert_array_equal(after[name][points], self.first[name])
            for name in ("boxes", "box_class", "box_velocity"):
                wanted = self.first[name][np.argsort(self.first["boxes"][:, 0])]
                np.testing.assert_array_equal(after[name][boxes], wanted)

    def test_sectors_without_width_and_of_the_full_circle(self):
        for after in self.mixed([mix.PolarMix(sector=0, swap=1)]):
            self.assert_same(after, self.first)
        for after in self.mixed([mix.PolarMix(sector=2 * np.pi, swap=1)]):
            self.assert_same(after, self.other, but=("key", "world_from_sensor"))
        for after in self.mixed([mix.PolarMix(sector=2, swap=1)]):
            for seed, width in ((1, 2 * np.pi - 2), (2, 2)):
                azimuth = np.sort(after["azimuth"][after["origin"] // 1000 == seed])
                gaps = np.diff(azimuth, append=azimuth[:1] + 2 * np.pi)
                self.assertGreaterEqual(gaps.max(initial=0), 2 * np.pi - width if len(gaps) else 0)

    def test_copies_are_spread_over_the_circle(self):
        cut, count = self.other["label"] == 2, len(self.first["xyz"])
        for after in self.mixed([mix.PolarMix([2], copies=4, swap=0)]):
            np.testing.assert_array_equal(after["xyz"][:count], self.first["xyz"])
            for number, copied in enumerate(after["xyz"][count:].reshape(4, cut.sum(), 3)):
                turned = np.arctan2(copied[:, 1], copied[:, 0]) - self.other["azimuth"][cut]
                self.assertLess(np.ptp(np.remainder(turned - turned[0] + 1, 2 * np.pi)), 1e-5)
                self.assertEqual(np.remainder(turned[0], 2 * np.pi) // (np.pi / 2), number)

    def test_all_boxes_that_overlap_none_of_the_first_are_pasted(self):
        pasted = 0
        for seed in range(20):
            first, other = mixable(10 + seed), mixable(40 + seed)
            first["xyz"][::50] = other["boxes"][:, :3]  # points of the first scan in boxes of the other
            other["xyz"][::50] += 10  # mirror images, outside of their boxes
            after = mix.PasteInstances(CLASSES, most=100)(first, other, generator(1, seed))
            added = after["boxes"][len(first["boxes"]) :]
            pasted += len(added)
            for box, number in zip(other["boxes"], other["box_class"]):
                free = number in CLASSES and not any(overlap(box, there) for there in first["boxes"])
                self.assertEqual(free, (added == box).all(axis=1).any())
            self.assertFalse(np.isin(after["origin"], other["origin"][::50]).any())
            for box in added:
                self.assertFalse(scanmill.points_in_box(after["xyz"][after["origin"] < 40000], box).any())
            few = mix.PasteInstances(CLASSES, most=1)(first, other, generator(1, seed))
            self.assertEqual(len(few["boxes"]), len(first["boxes"]) + (len(added) > 0))
        self.assertGreater(pasted, 20)

    def test_each_beam_keeps_what_is_nearest(self):
        """The first scan has a wall at 20 m, and a post at 5 m in its last ten columns. The other one has two cars: the
        post hides a part of the nearer one, and all of the other one."""

        def scan(ranges, columns, instances, boxes):
            return {
                "xyz": np.column_stack([ranges, columns * 1e-3 * ranges, 0 * ranges]).astype(np.float32),
                "instance": instances.astype(np.uint32),
                "ring": np.zeros(len(ranges), np.uint16),
                "column": columns.astype(np.uint16),
                "boxes": np.array(boxes, np.float32).reshape(-1, 7),
                "box_class": np.ones(len(boxes), np.uint16),
                "box_instance": np.arange(1, len(boxes) + 1).astype(np.uint32),
            }

        def paste(other, **options):
            return mix.PasteInstances([1], **options)(first, other, generator(1, 0))

        first = scan(np.repeat([20.0, 5], [30, 10]), np.arange(40), np.zeros(40), [])
        cars = [[10, 0.27, 0, 1, 0.2, 1, 0], [12, 0.44, 0, 1, 0.12, 1, 0]]
        other = scan(np.repeat([10.0, 12], [15, 4]), np.arange(20, 39), np.repeat([1, 2], [15, 4]), cars)
        after = paste(other, min_points=2)
        order = np.argsort(after["column"])
        np.testing.assert_array_equal(after["column"][order], np.arange(40))
        np.testing.assert_array_equal(after["xyz"][order, 0], np.repeat([20, 10, 5], [20, 10, 10]))
        np.testing.assert_array_equal(after["boxes"], other["boxes"][:1])
        self.assert_same(paste(other, min_points=11), first)
        for every in (paste(other, min_points=2, hide=False), paste({**other, "sensor": "rear"}, min_points=2)):
            self.assertEqual((len(every["xyz"]), len(every["boxes"])), (40 + 19, 2))

    def test_samples_without_points(self):
        pose = self.first["world_from_sensor"]
        bare = {n: v[:0] if isinstance(v, np.ndarray) else v for n, v in self.first.items()}
        bare["world_from_sensor"] = pose
        for one in MIXES:
            self.assert_same(one(bare, bare, generator(1, 0)), bare)
            one(self.first, bare, generator(1, 0))
            one(bare, self.other, generator(1, 0))

    def test_unlike_samples_are_refused_by_name(self):
        for name, unlike in (
            ("intensity", {n: v for n, v in self.other.items() if n != "intensity"}),
            ("reflectance", {**self.other, "reflectance": self.other["intensity"]}),
            ("label", {**self.other, "label": self.other["label"].astype(np.uint8)}),
        ):
            for one in MIXES[:-1]:
                with self.assertRaisesRegex(scanmill.InputError, name):
                    one(self.first, unlike, generator(1, 0))
        bare = {"xyz": self.first["xyz"]}
        for one, name in ((mix.PolarMix([1], swap=0), "label"), (mix.PasteInstances([1]), "boxes")):
            with self.assertRaisesRegex(scanmill.InputError, name):
                one(bare, bare, generator(1, 0))
        for wrong in (["car"], "car", [70000]):
            for one in (mix.PolarMix, mix.PasteInstances):
                with self.assertRaisesRegex(scanmill.InputError, "id_of"):
                    one(wrong)

    def test_the_reader_mixes_another_sample_of_the_split(self):
        split = scanmill.open(dataset_path(self)).split("train")
        mixes = mix.Choice([mix.PolarMix(sector=2 * np.pi, swap=1), mix.LaserMix()])

        def read(epoch=0, **options):
            reader = scanmill.SampleReader(columns=["instance"], **options)
            return [reader(sample, epoch)["xyz"] for sample in split]

        every, once = read(), read(mix=mixes)
        composed = read(mix=mixes, transform=Compose([Turn()], 3), seed=3)
        for a, b in zip(read(mix=[mixes], transform=[Turn()], seed=3), composed):
            np.testing.assert_array_equal(a, b)
        with self.assertRaisesRegex(scanmill.InputError, r"\[Turn\(...\)\]"):
            read(transform=Turn())
        for again in (read(mix=mixes), read(mix=mixes, transform=lambda sample, key, epoch: sample)):
            for a, b in zip(once, again):
                np.testing.assert_array_equal(a, b)
        for unlike in (read(mix=mixes, seed=1), read(1, mix=mixes), read(mix=mixes, transform=Compose([Turn()]))):
            self.assertFalse(all(np.array_equal(a, b) for a, b in zip(once, unlike)))
        known = {point.tobytes() for point in np.concatenate(every)}
        for before, after in zip(every, once):
            self.assertTrue({point.tobytes() for point in after} <= known)
            self.assertFalse(np.array_equal(before, after))


class Addresses(unittest.TestCase):
    """Random numbers follow from where they are used, not from what was drawn before."""

    def setUp(self):
        self.sample = random_sample(np.random.default_rng(3))
        self.compose = Compose(RIGID + NOISE, seed=5)

    def test_the_same_again_in_any_order(self):
        forward = [self.compose(self.sample, i, e)["xyz"] for i in range(4) for e in range(3)]
        backward = [self.compose(self.sample, i, e)["xyz"] for i in (3, 2, 1, 0) for e in (2, 1, 0)][::-1]
        for a, b in zip(forward, backward):
            np.testing.assert_array_equal(a, b)

    def test_another_seed_sample_or_epoch_is_another_result(self):
        results = [
            self.compose(self.sample, 1, 0),
            self.compose(self.sample, 2, 0),
            self.compose(self.sample, 1, 1),
            self.compose(self.sample, "town-s1-drive-000001", 0),
            Compose(RIGID + NOISE, seed=6)(self.sample, 1, 0),
        ]
        firsts = {result["xyz"][:3].tobytes() for result in results}
        self.assertEqual(len(firsts), len(results))

    def test_a_transform_does_not_change_what_others_draw(self):
        with_jitter = Compose([Turn(), Jitter(0, 0)], seed=5)(self.sample, 1)
        without = Compose([Turn()], seed=5)(self.sample, 1)
        np.testing.assert_array_equal(with_jitter["xyz"], without["xyz"])


if __name__ == "__main__":
    unittest.main()
