"""`scanmill generate` where processes die and disks fail: an unfinished dataset never looks finished, errors say what
failed and why, and the same command with --resume gives, byte for byte, the dataset of a run that nothing disturbed.

    SCANMILL=/path/to/scanmill python3 faults_test.py     the program in place of build/release/scanmill
    FAULTS_KILLS=200 ...                                  in place of 12 kills a test, and as many more failing calls
    CXX=...                                               what builds failing_calls.cpp, in place of g++

What it fills, hides and makes read-only are mounts of its own, which end with it; where it may not mount, those tests
are left out. Datasets lie in memory (/dev/shm) unless TMPDIR names a folder.
"""

import collections
import ctypes
import errno
import os
import random
import re
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest
from pathlib import Path

from support import HIDDEN, PROGRAM, ROOT, tree, wait_until

HERE = Path(__file__).resolve().parent
KILLS = int(os.environ.get("FAULTS_KILLS", "12"))
PATIENCE_S = 60
SEED = 20261123
MANIFEST = "manifest.json"

PIPELINE = """
name: {name}
scenes: [{{scene: "{root}/scenes/primitives.yaml"}}]
trajectories: [{{name: past, waypoints: [[-4, 0, 0], [4, 0, 0]], speed: 5, every_m: 0.001, frames: {frames}}}]
sensors:
  - {{name: top, columns: {columns}, rate_hz: 10, range_m: [0.5, 90], mount: {{position: [0, 0, 1.9]}},
     elevation_deg: {{top: 10, bottom: -20, rings: {rings}}}}}
method: ray_tracing
effects: [intensity]
output: {{shard_samples: {per_shard}, formats: [pcd]}}
"""

# What a failing call may say, by the kind that failing_calls.cpp gives it. EINTR may be overcome.
ERRORS = {
    "open": ("ENOSPC", "EACCES", "EROFS", "EMFILE", "EINTR"),
    "open-to-read": ("EIO", "EMFILE", "ESTALE"),
    "read": ("EIO", "short", "EINTR"),
    "write": ("ENOSPC", "EIO", "short", "EINTR", "EDQUOT"),
    "truncate": ("EIO", "EROFS"),
    "fsync": ("EIO", "ENOSPC", "EDQUOT", "EINTR"),
    "rename": ("ENOSPC", "EIO", "EROFS", "EACCES", "EXDEV"),
    "mkdir": ("ENOSPC", "EROFS", "EACCES"),
    "close": ("EIO", "ENOSPC", "EINTR"),
    "link": ("EPERM",),
    "unlink": ("EIO", "EROFS", "EACCES"),
    "flock": ("ENOLCK", "EIO", "EINTR"),
    "stat": ("EIO", "ESTALE"),
}
CHANGES = ("open", "write", "truncate", "fsync", "rename", "mkdir", "link", "unlink")

Done = collections.namedtuple("Done", "code said peak_bytes")


def libc(call, *arguments):
    library = ctypes.CDLL(None, use_errno=True)
    if getattr(library, call)(*arguments) != 0:
        number = ctypes.get_errno()
        raise OSError(number, os.strerror(number), call)


def leave_mounts_to_others():
    """Mounts of this process are its own from now on. False where it may not mount."""
    new_mounts, new_user = 0x00020000, 0x10000000  # CLONE_NEWNS, CLONE_NEWUSER
    user, group = os.getuid(), os.getgid()
    try:
        if user == 0:
            libc("unshare", new_mounts)
        else:
            libc("unshare", new_mounts | new_user)
            Path("/proc/self/setgroups").write_text("deny")
            Path("/proc/self/uid_map").write_text(f"0 {user} 1")
            Path("/proc/self/gid_map").write_text(f"0 {group} 1")
        return not os.system("mount --make-rprivate / && mount -t tmpfs none /mnt && umount /mnt")
    except OSError:
        return False


def mount(*arguments):
    subprocess.run(["mount", *map(str, arguments)], check=True)


def enlarge(disk, options):
    """As the kernel sees it: mount(8) repeats options of old, which it does not take from all users."""
    remount = 32  # MS_REMOUNT
    libc("mount", b"none", bytes(disk), b"tmpfs", remount, options.encode())


def unmount(folder):
    subprocess.run(["umount", "--lazy", str(folder)], check=True)


def differences(found, expected):
    names = sorted(name for name in {*found, *expected} if found.get(name, "absent") != expected.get(name, "absent"))
    words = ("is not there" if name not in found else "is one too many" if name not in expected else "differs"
             for name in names)
    told = [f"{name} {word}" for name, word in zip(names, words)]
    return ", ".join(told[:4]) + (f" and {len(told) - 4} more" if len(told) > 4 else "")


def spread(things, most):
    """So many of them at most, evenly spread, the first and the last among them."""
    if len(things) <= most:
        return list(things)
    return [things[round(i * (len(things) - 1) / (most - 1))] for i in range(most)]


class Running:
    """A process of the program; it is killed where a test ends before it does."""

    def __init__(self, *arguments, env=None, limits=()):
        # What Python ignores itself, SIGXFSZ among it, is as a shell would have it.
        self.said = tempfile.TemporaryFile("w+")
        self.process = subprocess.Popen(
            [PROGRAM, *map(str, arguments)], stdin=subprocess.DEVNULL, stdout=self.said, stderr=self.said,
            env={**os.environ, **(env or {})}, restore_signals=True,
            preexec_fn=lambda: [resource.setrlimit(kind, (value, value)) for kind, value in limits])

    def __enter__(self):
        return self

    def __exit__(self, *_):
        if self.process.returncode is None:
            self.send(signal.SIGKILL)
            self.process.wait()
        self.said.close()

    def send(self, number):
        # Not once it has been waited for: its id may be another's by then.
        if self.process.returncode is None:
            os.kill(self.process.pid, number)

    def runs(self):
        if self.process.returncode is None:
            pid, status, usage = os.wait4(self.process.pid, os.WNOHANG)
            if pid != 0:
                self.process.returncode = os.waitstatus_to_exitcode(status)
                self.peak_bytes = usage.ru_maxrss * 1024
        return self.process.returncode is None

    def done(self):
        if self.process.returncode is None:
            # Without a time limit of its own: waiting by wait4 is what tells how much memory it took.
            alarm = time.monotonic() + PATIENCE_S
            pause = 0.0005
            while self.runs():
                if time.monotonic() > alarm:
                    self.send(signal.SIGKILL)
                    raise AssertionError(f"{self.process.args} hangs")
                time.sleep(pause)
                pause = min(pause * 1.2, 0.01)
        self.said.seek(0)
        return Done(self.process.returncode, self.said.read(), self.peak_bytes)


def scanmill(*arguments, **more):
    with Running(*arguments, **more) as running:
        return running.done()


class Faults(unittest.TestCase):
    folder = None  # where everything lies
    shim = None
    mounts = False

    @classmethod
    def setUpClass(cls):
        cls.place = Path(tempfile.mkdtemp(dir=cls.folder))
        cls.wholes = {}
        cls.finals = {}
        cls.verified = {}

    def setUp(self):
        self.random = random.Random(SEED)
        begin = time.monotonic()
        self.addCleanup(lambda: print(f"{time.monotonic() - begin:.1f} s", end=" ", file=sys.stderr))
        self.parent = Path(tempfile.mkdtemp(dir=self.place))  # nothing but the dataset is to be found beside it
        self.out = self.parent / "out"
        self.wrong = []  # of many cases, not the first one only
        # What is mounted or stopped in it goes first: cleanups run last in, first out.
        self.addCleanup(shutil.rmtree, self.parent, ignore_errors=True)

    def tearDown(self):
        if self.wrong:
            most = 5 * KILLS
            many = f"\n... and {len(self.wrong) - most} more" if len(self.wrong) > most else ""
            self.fail(f"{len(self.wrong)} wrong:\n" + "\n".join(self.wrong[:most]) + many)

    @classmethod
    def pipeline(cls, frames=6, per_shard=2, columns=64, rings=8, name="small"):
        file = cls.place / f"{name}-{frames}-{per_shard}-{columns}-{rings}.yaml"
        file.write_text(PIPELINE.format(root=ROOT, **{key: value for key, value in locals().items() if key != "cls"}))
        return file

    def whole(self, pipeline):
        """Its dataset as nothing disturbs it: folder, tree and seconds."""
        if pipeline not in self.wholes:
            folder = self.place / f"{pipeline.stem}-whole"
            begin = time.monotonic()
            done = scanmill("generate", pipeline, "-o", folder, "--quiet")
            seconds = time.monotonic() - begin
            self.assertEqual(done.code, 0, done.said)
            parts = self.place / f"{pipeline.stem}-parts"
            done = scanmill("generate", pipeline, "-o", parts, "--quiet", "--worker", 0, "--workers", 1)
            self.assertEqual(done.code, 0, done.said)
            self.wholes[pipeline] = (folder, tree(folder), seconds)
            # All names that files ever get, and what these are to hold.
            self.finals[pipeline] = {**tree(parts), **tree(folder)}
            self.finals[pipeline][f"{HIDDEN}/replaced.json"] = self.finals[pipeline][MANIFEST]
        return self.wholes[pipeline]

    def note(self, case, wrong):
        for what in wrong:
            self.wrong.append(f"{case}: {what}".replace(str(self.parent), "…"))

    def halves(self, out):
        """What bears a final name without being, to the last byte, what is to have it."""
        if not out.exists():
            return []
        return [f"{name} has a final name and is not whole" for name, digest in tree(out).items()
                if digest is not None and ".partial-" not in name and not name.endswith("lock")
                and digest not in [final.get(name) for final in self.finals.values()]]

    def wrong_in(self, out, expected, hidden=True):
        """What keeps a dataset from being the whole one."""
        if not out.exists():
            return [f"no {out}"]
        found = tree(out, hidden)
        different = differences(found, expected)
        wrong = [different] if different else []
        wrong += self.wrong_verified(out, found)
        if hidden and sorted(os.listdir(out.parent)) != [out.name]:
            wrong.append(f"beside it: {sorted(os.listdir(out.parent))}")
        return wrong

    def wrong_verified(self, out, found):
        """What `verify` says of a folder: of the same bytes it was asked once."""
        bytes_ = tuple(found.items())
        if bytes_ not in self.verified:
            done = scanmill("verify", out, "--quiet")
            self.verified[bytes_] = [] if done.code == 0 else [f"verify: exit code {done.code}: {done.said.strip()}"]
        return self.verified[bytes_]

    def wrong_resumed(self, pipeline, out=None, expected=None):
        """Likewise, after --resume."""
        out = out or self.out
        done = scanmill("generate", pipeline, "-o", out, "--resume", "--quiet")
        if done.code != 0:
            return [f"--resume: exit code {done.code}: {done.said.strip()}"]
        return [f"after --resume: {what}" for what in self.wrong_in(out, expected or self.whole(pipeline)[1])]

    def need_mounts(self):
        if not self.mounts:
            self.skipTest("nothing may be mounted here")

    def need_shim(self):
        if not self.shim:
            self.skipTest("no compiler for failing_calls.cpp")

    def faulty(self, kind, at, does="EIO", stay="", folder=None):
        return {"LD_PRELOAD": str(self.shim), "FAULT_FOLDER": str(folder or self.parent), "FAULT_KIND": kind,
                "FAULT_AT": str(at), "FAULT_DO": does, "FAULT_STAY": stay, "FAULT_REPORT": str(self.place / "calls")}

    def calls(self):
        """What the shim has counted and struck."""
        lines = (line.split(" ", 1) for line in (self.place / "calls").read_text().splitlines())
        return {key: int(value) if value.isdigit() else value for key, value in lines}

    def empty(self):
        for path in self.parent.iterdir():
            shutil.rmtree(path) if path.is_dir() and not path.is_symlink() else path.unlink()


class Kills(Faults):
    """SIGKILL, which no process sees coming."""

    def kill(self, *arguments, after_s=None, when=None):
        """Its exit code: it may have ended before. `when` holds after a while, or the process ends."""
        with Running(*arguments) as running:
            end = time.monotonic() + PATIENCE_S
            while when is not None and running.runs() and not when() and time.monotonic() < end:
                pass
            time.sleep(after_s)
            running.send(signal.SIGKILL)
            return running.done().code

    def moments(self, seconds):
        """How long to wait, and for what first: from the start to the end, and as many around the end."""
        moved = lambda: os.path.exists(self.out / "train")
        for i in range(KILLS - KILLS // 3):
            yield seconds * (i + self.random.random()) / (KILLS - KILLS // 3), None
        for _ in range(KILLS // 3):
            yield self.random.uniform(0, 0.006), moved

    def test_at_any_moment_then_resumed(self):
        pipeline = self.pipeline(frames=120, per_shard=4)
        _, expected, seconds = self.whole(pipeline)
        command = ("generate", pipeline, "-o", self.out, "--resume", "--quiet", "--threads", 2)
        killed = 0
        for after_s, when in self.moments(seconds):
            self.empty()
            codes = [self.kill(*command, after_s=after_s, when=when)]
            wrong = self.halves(self.out)
            for _ in range(self.random.randrange(3)):
                codes.append(self.kill(*command, after_s=self.random.uniform(0, seconds)))
                wrong += self.halves(self.out)
            killed += codes.count(-signal.SIGKILL)
            wrong += [f"exit code {code}" for code in codes if code not in (0, -signal.SIGKILL)]
            behind = "shards are moved" if when else "the start"
            self.note(f"killed {after_s * 1000:.1f} ms after {behind}, codes {codes}",
                      wrong + self.wrong_resumed(pipeline))
        self.assertGreater(killed, KILLS // 2)

    def count_calls(self, *command):
        done = scanmill(*command, env=self.faulty("write", 0))
        self.assertEqual(done.code, 0, done.said)
        return [(kind, at) for kind in CHANGES for at in range(1, self.calls()[kind] + 1)]

    def test_before_and_after_each_call_that_changes_files_then_resumed(self):
        self.need_shim()
        pipeline = self.pipeline()
        expected = self.whole(pipeline)[1]
        command = ("generate", pipeline, "-o", self.out, "--quiet", "--threads", 1)
        cases = [(does, *call) for call in self.count_calls(*command) for does in ("kill", "kill-after")]
        for does, kind, at in spread(cases, 3 * KILLS):
            self.empty()
            code = scanmill(*command, env=self.faulty(kind, at, does)).code
            wrong = [] if code == -signal.SIGKILL else [f"exit code {code}"]
            wrong += self.halves(self.out)
            self.note(f"{does} {kind} {at}", wrong + self.wrong_resumed(pipeline))

    def test_while_an_older_dataset_is_replaced(self):
        """It stays until the new one is whole. Then shards are moved: a dataset that is neither has no manifest, and
        the same command again, or --resume, gives the new one."""
        self.need_shim()
        older, newer = self.pipeline(frames=10, name="older"), self.pipeline(name="newer")
        old_folder, old, _ = self.whole(older)
        new = self.whole(newer)[1]
        command = ("generate", newer, "-o", self.out, "--quiet", "--threads", 1, "--overwrite")
        shutil.copytree(old_folder, self.out)
        cases = [(does, *call) for call in self.count_calls(*command) for does in ("kill", "kill-after")]
        self.assertEqual(self.wrong_in(self.out, new), [])
        between = 0
        for i, (does, kind, at) in enumerate(spread(cases, 5 * KILLS // 2)):
            self.empty()
            shutil.copytree(old_folder, self.out)
            code = scanmill(*command, env=self.faulty(kind, at, does)).code
            wrong = [] if code == -signal.SIGKILL else [f"exit code {code}"]
            wrong += self.halves(self.out)
            visible = tree(self.out, hidden=False)
            old_is_whole = visible == old
            if MANIFEST in visible:
                if not old_is_whole and visible != new:
                    wrong.append(f"neither old ({differences(visible, old)}) nor new ({differences(visible, new)})")
                wrong += self.wrong_verified(self.out, tree(self.out))
            else:
                between += 1
                if not self.wrong_verified(self.out, tree(self.out)):
                    wrong.append("verify is content without a manifest")
            again = "--resume" if i % 2 == 0 else "--overwrite"
            done = scanmill("generate", newer, "-o", self.out, "--quiet", again)
            if again == "--resume" and done.code == 2 and old_is_whole and "has a complete dataset" in done.said:
                # Nothing had been begun.
                if tree(self.out, hidden=False) != old:
                    wrong.append("a refused --resume has changed the old dataset")
                done = scanmill("generate", newer, "-o", self.out, "--quiet", "--overwrite")
            if done.code != 0:
                wrong.append(f"{again}: exit code {done.code}: {done.said.strip()}")
            self.note(f"{does} {kind} {at}, then {again}", wrong + self.wrong_in(self.out, new))
        self.assertGreater(between, 0)


class FailingCalls(Faults):
    """Each call by which a dataset is made, one after the other: how else would one know?"""

    def judge(self, done, error, out, last, *older, told=True):
        """What is wrong about how a run ended in which a call has failed."""
        wrong = self.halves(out)
        if done.code == 0:
            if "another process completes the dataset, or scanmill merge" in done.said and not (out / MANIFEST).exists():
                return wrong  # it is told, and docs/scale.md says so: without locks nobody knows who is the last
            return wrong + [f"exit code 0, but {what}" for what in self.wrong_in(out, last, hidden=False)]
        if done.code not in (1, 2):
            return wrong + [f"exit code {done.code}: {done.said.strip()}"]
        if (out / MANIFEST).exists() and (visible := tree(out, hidden=False)) not in (last, *older):
            wrong.append(f"has a manifest and is no whole dataset: {differences(visible, last)}")
        said = done.said.strip()
        if not told:
            return wrong
        if error == "short":
            wrong.append(f"a call that does half of its work is no error: {said}")
        elif os.strerror(getattr(errno, error)) not in said:
            wrong.append(f"does not say why ({error}): {said}")
        if str(out) not in said:
            wrong.append(f"does not name a file or folder: {said}")
        return wrong

    def expect_overcome(self, prepare, command, recover, last_whole, most, *older):
        """`prepare` makes what is there before, `recover` are the commands of which the first that is not refused ends
        the dataset, which is `last_whole` then; `older`: what else may lie there whole."""
        self.need_shim()
        self.empty()
        prepare()
        done = scanmill(*command, env=self.faulty("write", 0))
        self.assertEqual(done.code, 0, done.said)
        calls = self.calls()
        cases = []
        for kind, errors in ERRORS.items():
            for at in range(1, calls[kind] + 1):
                # A disk that stays full or broken, and one that does so once.
                cases += [(kind, at, error, stay) for error in errors
                          for stay in (("",) if error in ("EINTR", "EXDEV") else ("", "disk"))]
        if most < len(cases):
            # Of each kind the same share, with another error and place each time.
            cases = [case for kind in ERRORS
                     for own in [[case for case in cases if case[0] == kind]] if own
                     for case in spread(own, max(2, round(most * len(own) / len(cases))))]
        for kind, at, error, stay in cases:
            self.empty()
            prepare()
            done = scanmill(*command, env=self.faulty(kind, at, error, stay))
            struck = self.calls().get("struck", "none")
            # Where nobody can tell what is there, it may be taken for absent; halves of reads are the library's matter.
            told = kind != "stat" and (kind, error) != ("read", "short")
            wrong = self.judge(done, error, self.out, last_whole, *older, told=told)
            for again in recover:
                last = scanmill(*again)
                if last.code == 0:
                    break
            if last.code != 0:
                wrong.append(f"{again[0]} again: exit code {last.code}: {last.said.strip()}")
            else:
                wrong += [f"after it went on: {what}" for what in self.wrong_in(self.out, last_whole)]
            self.note(f"{kind} {at} of {calls[kind]} {error}{' for good' if stay else ''} ({struck})", wrong)

    def generate(self, pipeline, *more):
        return ("generate", pipeline, "-o", self.out, "--quiet", "--threads", 1, *more)

    def test_in_a_new_dataset(self):
        pipeline = self.pipeline()
        self.expect_overcome(lambda: None, self.generate(pipeline), [self.generate(pipeline, "--resume")],
                             self.whole(pipeline)[1], 4 * KILLS)

    def test_in_a_dataset_that_is_resumed(self):
        pipeline = self.pipeline()
        self.need_shim()
        killed = self.place / "killed"
        env = self.faulty("rename", 4, "kill", folder=killed)
        code = scanmill("generate", pipeline, "-o", killed, "--quiet", "--threads", 1, env=env).code
        self.assertEqual(code, -signal.SIGKILL)
        self.expect_overcome(lambda: shutil.copytree(killed, self.out), self.generate(pipeline, "--resume"),
                             [self.generate(pipeline, "--resume")], self.whole(pipeline)[1], 2 * KILLS)

    def test_while_an_older_dataset_is_replaced(self):
        older, newer = self.pipeline(frames=4, name="older"), self.pipeline(name="newer")
        folder = self.whole(older)[0]
        # Refused where the old one is whole and nothing has been begun.
        again = [self.generate(newer, "--resume"), self.generate(newer, "--overwrite")]
        self.expect_overcome(lambda: shutil.copytree(folder, self.out), self.generate(newer, "--overwrite"), again,
                             self.whole(newer)[1], 2 * KILLS, self.whole(older)[1])

    def test_in_a_dataset_that_is_shared(self):
        pipeline = self.pipeline()
        command = self.generate(pipeline, "--workers", "auto")
        self.expect_overcome(lambda: None, command, [command, ("merge", self.out)], self.whole(pipeline)[1], KILLS)

    def test_in_a_merge(self):
        pipeline = self.pipeline()
        parts = self.place / "parts"
        if not parts.exists():
            done = scanmill("generate", pipeline, "-o", parts, "--quiet", "--worker", 0, "--workers", 1)
            self.assertEqual(done.code, 0, done.said)
        self.expect_overcome(lambda: shutil.copytree(parts, self.out), ("merge", self.out), [("merge", self.out),
                             self.generate(pipeline, "--resume")], self.whole(pipeline)[1], KILLS)

    def test_files_as_large_as_a_limit_allows(self):
        """ulimit -f: the kernel sends SIGXFSZ, which ends processes that are not prepared."""
        pipeline = self.pipeline()
        folder, expected, _ = self.whole(pipeline)
        sizes = sorted({path.stat().st_size for path in folder.rglob("*") if path.is_file()})
        for limit in (0, 10, 100, 1000, *(size + more for size in sizes for more in (-1, 0))):
            self.empty()
            done = scanmill(*self.generate(pipeline), limits=[(resource.RLIMIT_FSIZE, limit)])
            if limit >= sizes[-1]:
                wrong = [] if done.code == 0 else [f"exit code {done.code}: {done.said}"]
            else:
                wrong = [] if done.code == 1 else [f"exit code {done.code}"]
                if limit >= 1000:  # else what it says is cut off as well
                    wrong += self.judge(done, "EFBIG", self.out, expected)
            self.note(f"ulimit of {limit} bytes", wrong + self.wrong_resumed(pipeline))


class Folders(Faults):
    """The output folder fills up, goes, or becomes another's."""

    def test_disk_that_is_full(self):
        self.need_mounts()
        pipeline = self.pipeline(columns=256)
        folder, expected, _ = self.whole(pipeline)
        pages = sum(-(-path.stat().st_size // 4096) + 1 for path in folder.rglob("*"))
        limits = [f"size={4 * size}k" for size in spread(range(1, pages + 8), 6 if KILLS < 100 else 60)]
        # As full: no file can be made.
        limits += [f"nr_inodes={count}" for count in range(2, 12, 2 if KILLS < 100 else 1)]
        failed = 0
        for limit in limits:
            disk = Path(tempfile.mkdtemp(dir=self.place))
            mount("-t", "tmpfs", "-o", limit, "none", disk)
            try:
                out = disk / "out"
                done = scanmill("generate", pipeline, "-o", out, "--quiet", "--threads", 1)
                wrong = self.halves(out)
                if done.code == 0:
                    wrong += [f"exit code 0, but {what}" for what in self.wrong_in(out, expected)]
                else:
                    failed += 1
                    wrong += [] if "No space left on device" in done.said else ["does not say that no space is left"]
                    wrong += [] if str(disk) in done.said else ["names no file"]
                    wrong += [] if done.code in (1, 2) else [f"exit code {done.code}"]
                    wrong += [done.said.strip()] if wrong else []
                enlarge(disk, "size=64m,nr_inodes=1000")
                self.note(limit, wrong + self.wrong_resumed(pipeline, out))
            finally:
                unmount(disk)
        self.assertGreater(failed, len(limits) // 2)

    def stop_within(self, pipeline, kind, at, *more):
        """A process that has stopped before its at-th call of a kind."""
        env = self.faulty(kind, at, "stop")
        running = Running("generate", pipeline, "-o", self.out, "--quiet", "--threads", 1, *more, env=env)
        self.addCleanup(running.__exit__)
        state = Path(f"/proc/{running.process.pid}/stat")
        wait_until("it stops", lambda: not running.runs() or state.read_text().rsplit(")", 1)[1].split()[0] == "T")
        self.assertTrue(running.runs(), f"it has not stopped at {kind} {at}")
        return running

    def go_on(self, running, expected):
        """What is wrong about how it ends."""
        running.send(signal.SIGCONT)
        done = running.done()
        if done.code == 0:
            return [f"exit code 0, but {what}" for what in self.wrong_in(self.out, expected, hidden=False)]
        wrong = [] if done.code in (1, 2) else [f"exit code {done.code}"]
        wrong += [] if str(self.out) in done.said else ["names no file"]
        return wrong + ([done.said.strip()] if wrong else [])

    def while_it_runs(self, happens, *more, touched=lambda: [], refused=None, until_renamed=False):
        """`happens` between any two calls before the dataset is whole; afterwards --resume makes it whole, or may
        refuse to in so many words."""
        self.need_shim()
        pipeline = self.pipeline()
        expected = self.whole(pipeline)[1]
        self.assertEqual(scanmill("generate", pipeline, "-o", self.out, "--quiet", "--threads", 1, *more,
                                  env=self.faulty("write", 0)).code, 0)
        calls = self.calls()
        # The last flush comes behind the manifest.
        last = {kind: calls[kind] - (kind == "fsync") for kind in ("open", "write", "fsync", "rename", "mkdir")}
        last["rename"] -= until_renamed  # what is removed between the last look and that is as if it went afterwards
        first = {"mkdir": 2, "open": 2, "write": 2}  # before these there is no folder, or no lock
        # When folders are flushed, behind the renaming of a file: what comes next finds things changed. Then others.
        cases = [("fsync", at) for at in range(2, last["fsync"] + 1, 2)]
        others = [(kind, at) for kind in last for at in range(first.get(kind, 1), last[kind] + 1)]
        cases += spread([case for case in others if case not in cases], KILLS) if KILLS > 20 else []
        for kind, at in cases:
            self.empty()
            running = self.stop_within(pipeline, kind, at, *more)
            struck = self.calls()["struck"]
            happens()
            wrong = self.go_on(running, expected) + touched()
            if self.out.is_symlink():
                self.out.unlink()
            wrong += self.halves(self.out)
            wrong += [what for what in self.wrong_resumed(pipeline) if refused is None or refused not in what]
            self.note(f"before {struck}", wrong)

    def test_folder_that_is_removed(self):
        self.while_it_runs(lambda: shutil.rmtree(self.out))

    def test_hidden_folder_that_is_removed(self):
        # Nothing tells any more that shards which are at their places are of this program.
        self.while_it_runs(lambda: shutil.rmtree(self.out / HIDDEN, ignore_errors=True),
                           refused="exists and is not empty")

    def test_shard_that_is_removed(self):
        def remove():
            for shard in (HIDDEN, "."):
                (self.out / shard / "train/train-000000.tar").unlink(missing_ok=True)
        self.while_it_runs(remove, until_renamed=True)

    def move_away(self):
        """To where nobody writes; what was moved there before is gone."""
        away = self.place / "away"
        shutil.rmtree(away, ignore_errors=True)
        self.out.rename(away)
        return away

    def test_folder_that_is_moved_away(self):
        """Where it is then it can be resumed, as well as where it was."""
        def wrong():
            home = self.place / "home"
            shutil.rmtree(home, ignore_errors=True)
            home.mkdir()
            (self.place / "away").rename(home / "out")
            return [f"where it was moved to: {what}" for what in self.wrong_resumed(self.pipeline(), home / "out")]
        self.while_it_runs(self.move_away, touched=wrong)

    def test_folder_that_becomes_a_link(self):
        """Nobody knows whose it is then: nothing may be changed there."""
        elsewhere = Path(tempfile.mkdtemp(dir=self.place)) / "dataset"
        other = self.whole(self.pipeline(frames=10, name="older"))[0]
        shutil.copytree(other, elsewhere)

        def replace():
            self.move_away()
            self.out.symlink_to(elsewhere)

        def touched():
            different = differences(tree(elsewhere), tree(other))
            shutil.rmtree(elsewhere)
            shutil.copytree(other, elsewhere)
            return [f"elsewhere: {different[:400]}"] if different else []
        self.while_it_runs(replace, touched=touched)

    def test_folder_that_becomes_read_only(self):
        """By a mount: root may write what has no permission to be written."""
        self.need_mounts()
        self.need_shim()
        pipeline = self.pipeline()
        self.whole(pipeline)
        self.assertEqual(scanmill("generate", pipeline, "-o", self.out, "--quiet", "--threads", 1,
                                  env=self.faulty("write", 0)).code, 0)
        calls = self.calls()
        cases = [(kind, at) for kind in ("open", "mkdir", "rename") for at in range(2, calls[kind] + 1)]
        for kind, at in spread(cases, KILLS // 2):
            self.empty()
            running = self.stop_within(pipeline, kind, at)
            mount("--bind", self.out, self.out)
            try:
                mount("-o", "remount,bind,ro", self.out)
                running.send(signal.SIGCONT)
                again = scanmill("generate", pipeline, "-o", self.out, "--quiet", "--resume")
                wrong = self.halves(self.out)
                for who, done in (("it", running.done()), ("--resume", again)):
                    # It renames through a folder that it opened before, to which this mount does not apply.
                    if who == "it" and done.code == 0 and kind == "rename" and (self.out / MANIFEST).is_file():
                        continue
                    told = "Read-only file system" in done.said and str(self.out) in done.said
                    if done.code not in (1, 2) or not told:
                        wrong.append(f"{who}: exit code {done.code}: {done.said.strip()}")
            finally:
                unmount(self.out)
            self.note(f"before {kind} {at}", wrong + self.wrong_resumed(pipeline))


class Resources(Faults):
    """Memory that a container or a shell limits."""

    def test_limit_of_a_container_is_kept_or_refused(self):
        """Its files are ours here: nobody's memory is limited, so that what the program does by itself is seen."""
        self.need_mounts()
        pipeline = self.pipeline(frames=8, per_shard=1, columns=2048, rings=128)
        expected = self.whole(pipeline)[1]
        refused = 0
        many = (1, 16, 64, 128, 192, 256, 512, 1024)
        for version, file, limits in (("2", "memory.max", many), ("1", "memory/memory.limit_in_bytes", many[1:4])):
            mount("-t", "tmpfs", "none", "/sys/fs/cgroup")
            try:
                limit_file = Path("/sys/fs/cgroup") / file
                limit_file.parent.mkdir(exist_ok=True)
                for mebibytes in limits:
                    self.empty()
                    limit_file.write_text(f"{mebibytes << 20}\n")
                    done = scanmill("generate", pipeline, "-o", self.out, "--quiet", "--threads", 16)
                    wrong = []
                    if done.code == 2:
                        refused += 1
                        wrong += [] if "memory" in done.said else [f"does not say why: {done.said.strip()}"]
                        wrong += [f"made {self.out}"] if self.out.exists() else []
                    else:
                        wrong += [] if done.code == 0 else [f"exit code {done.code}: {done.said.strip()}"]
                        wrong += self.wrong_in(self.out, expected)
                        if done.peak_bytes > mebibytes << 20:
                            wrong.append(f"took {done.peak_bytes >> 20} MiB")
                    self.note(f"version {version}, {mebibytes} MiB", wrong)
            finally:
                unmount("/sys/fs/cgroup")
        self.assertGreater(refused, 0)

    def test_address_space_that_is_limited(self):
        """ulimit -v: memory that is asked for is not there. An error, or the same bytes; never a crash."""
        pipeline = self.pipeline(frames=8, columns=1024, rings=64)
        expected = self.whole(pipeline)[1]
        needed = None
        for mebibytes in (4096, 2048, *range(1000, 250, -50 if KILLS < 100 else -5)):
            self.empty()
            done = scanmill("generate", pipeline, "-o", self.out, "--quiet", "--threads", 2,
                            limits=[(resource.RLIMIT_AS, mebibytes << 20)])
            if done.code == 127:
                break  # not even its libraries can be loaded
            wrong = self.halves(self.out)
            if done.code == 0:
                needed = mebibytes
                wrong += self.wrong_in(self.out, expected)
            elif done.code not in (1, 2):
                wrong.append(f"exit code {done.code}: {done.said.strip()[-300:]}")
            elif not re.search("memory|Resource temporarily unavailable", done.said):
                wrong.append(f"does not say that memory is short: {done.said.strip()}")
            if done.code != 0 and self.out.exists():
                wrong += self.wrong_resumed(pipeline)
            self.note(f"{mebibytes} MiB", wrong)
        self.assertIsNotNone(needed)


def build_shim(folder):
    compiler = shutil.which(os.environ.get("CXX", "g++"))
    if not compiler:
        return None
    shim = folder / "failing_calls.so"
    subprocess.run([compiler, "-std=c++20", "-shared", "-fPIC", "-O1", "-Wall", "-Wextra", "-Wconversion",
                    HERE / "failing_calls.cpp", "-o", shim], check=True)
    return shim


def main():
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    memory = Path("/dev/shm")
    at = None if "TMPDIR" in os.environ or not os.access(memory, os.W_OK) else memory
    Faults.mounts = leave_mounts_to_others()
    with tempfile.TemporaryDirectory(prefix="faults", dir=at) as folder:
        Faults.folder = Path(folder).resolve()
        Faults.shim = build_shim(Faults.folder)
        return 0 if unittest.main(exit=False).result.wasSuccessful() else 1


if __name__ == "__main__":
    sys.exit(main())
