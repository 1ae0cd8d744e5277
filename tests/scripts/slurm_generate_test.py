"""scripts/slurm_generate on a real cluster of two nodes, started for the test on this machine: the dataset is the one
that a single machine makes, also where tasks die, are told to end or lose their node.

    SCANMILL=/path/to/scanmill python3 slurm_generate_test.py     the program in place of build/release/scanmill

Ends with 77, which ctest takes for skipped, where Slurm is not installed.
"""

import ctypes
import getpass
import hashlib
import os
import re
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = os.environ.get("SCANMILL", str(ROOT / "build/release/scanmill"))
SKIPPED = 77
NODES = ("n1", "n2")
PATIENCE_S = 120

# A third of a second a frame on one core: long enough to die in.
PIPELINE = f"""
name: cluster
scenes: [{{scene: "{ROOT}/scenes/primitives.yaml"}}]
trajectories: [{{name: past, waypoints: [[-4, 0, 0], [4, 0, 0]], speed: 5, every_m: 0.5, frames: 12}}]
sensors: [{{name: top, preset: os1_128, mount: {{position: [0, 0, 1.9]}}}}]
method: ray_tracing
effects: [sensor, footprint: {{rays: 61}}]
output: {{shard_samples: 1, formats: [pcd]}}
"""

# Requeued jobs wait until the credentials of their earlier start have expired: 5 s is the least that Slurm takes.
CONFIGURATION = """
ClusterName=scanmill
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={ports[0]}
CommunicationParameters=NoInAddrAny,NoCtldInAddrAny
SlurmUser={user}
SlurmdUser={user}
AuthType=auth/munge
CredType=cred/munge
AuthInfo=socket={folder}/munge.socket,cred_expire=5
StateSaveLocation={folder}/state
SlurmctldPidFile={folder}/slurmctld.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdSpoolDir={folder}/%n
SlurmdPidFile={folder}/%n.pid
SlurmdLogFile={folder}/%n.log
SlurmdParameters=config_overrides
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
JobCompType=jobcomp/none
MpiDefault=none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
SchedulerType=sched/builtin
SchedulerParameters=sched_interval=1,batch_sched_delay=0
ReturnToService=1
KillWait=5
NodeName={nodes[0]} NodeHostname=localhost NodeAddr=127.0.0.1 Port={ports[1]} CPUs=1
NodeName={nodes[1]} NodeHostname=localhost NodeAddr=127.0.0.1 Port={ports[2]} CPUs=1
PartitionName=all Nodes=ALL Default=YES
"""


def free_ports(count):
    """Ports of the loopback that nobody listens on, all different."""
    sockets = [socket.socket() for _ in range(count)]
    for s in sockets:
        s.bind(("127.0.0.1", 0))
    ports = [s.getsockname()[1] for s in sockets]
    for s in sockets:
        s.close()
    return ports


def prctl(option, value):
    ctypes.CDLL(None, use_errno=True).prctl(option, value, 0, 0, 0)


def die_with_parent():
    prctl(1, signal.SIGKILL)  # PR_SET_PDEATHSIG


def adopt_orphans():
    prctl(36, 1)  # PR_SET_CHILD_SUBREAPER


def children():
    return [int(pid) for pid in Path(f"/proc/self/task/{os.getpid()}/children").read_text().split()]


def wait_until(what, holds):
    """The first value of `holds()` that is true."""
    end = time.monotonic() + PATIENCE_S
    while time.monotonic() < end:
        value = holds()
        if value:
            return value
        time.sleep(0.02)
    raise AssertionError(f"waited {PATIENCE_S} s in vain: {what}")


class Cluster:
    """munged, slurmctld and a slurmd for each node, of this user; all that they write and need lies in one folder."""

    def __init__(self, folder):
        self.folder = folder
        self.daemons = []
        os.environ["SLURM_CONF"] = str(folder / "slurm.conf")

    def __enter__(self):
        adopt_orphans()
        try:
            self.start()
        except BaseException:
            self.stop()
            raise
        return self

    def __exit__(self, *_):
        self.stop()

    def start(self):
        folder = self.folder
        folder.chmod(0o755)  # munged wants its socket to be within everybody's reach
        for name in ("state", *NODES):
            (folder / name).mkdir()
        host = socket.gethostname().split(".")[0]
        (folder / "slurm.conf").write_text(
            CONFIGURATION.format(host=host, folder=folder, user=getpass.getuser(), ports=free_ports(3), nodes=NODES))
        # A container may have no control groups, which newer releases look for; older ones do not know this key's value.
        version = subprocess.run(["slurmd", "-V"], check=True, capture_output=True, text=True).stdout
        if tuple(map(int, re.findall(r"\d+", version)[:2])) >= (23, 11):
            (folder / "cgroup.conf").write_text("CgroupPlugin=disabled\n")
        subprocess.run(["mungekey", "--create", f"--keyfile={folder}/munge.key"], check=True)
        self.run_daemon("munged", "--foreground", f"--key-file={folder}/munge.key", f"--socket={folder}/munge.socket",
                        f"--pid-file={folder}/munged.pid", f"--seed-file={folder}/munged.seed",
                        f"--log-file={folder}/munged.log")
        wait_until("munged listens", lambda: self.all_live() and (folder / "munge.socket").exists())
        self.run_daemon("slurmctld", "-D", "-c")
        for node in NODES:
            self.run_daemon("slurmd", "-D", "-N", node)
        wait_until("the nodes are idle", lambda: self.all_live() and self.idle_nodes() == len(NODES))

    def run_daemon(self, *command):
        with open(self.folder / "output", "a") as output:
            self.daemons.append(subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=output, stderr=output,
                                                 start_new_session=True, preexec_fn=die_with_parent))

    def all_live(self):
        for daemon in self.daemons:
            if daemon.poll() is not None:
                raise AssertionError(f"{daemon.args[0]} ended with {daemon.returncode}:\n{self.output()}")
        return True

    def output(self):
        texts = [self.folder / "output", *sorted(self.folder.glob("*.log"))]
        return "\n".join(f"{file.name}:\n{file.read_text()[-3000:]}" for file in texts if file.exists())

    @staticmethod
    def idle_nodes():
        said = subprocess.run(["sinfo", "--noheader", "--Node", "--format=%t"], capture_output=True, text=True)
        return said.stdout.split().count("idle")

    def stop(self):
        for daemon in reversed(self.daemons):
            daemon.terminate()
            try:
                daemon.wait(10)
            except subprocess.TimeoutExpired:
                daemon.kill()
                daemon.wait()
        # Jobs have processes that outlive the daemons, and these have children in turn.
        while left := children():
            for pid in left:
                os.kill(pid, signal.SIGKILL)
                os.waitpid(pid, 0)


def slurm(*command):
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def job(name):
    """What Slurm knows of a job, as key -> value."""
    return dict(word.split("=", 1) for word in slurm("scontrol", "show", "job", name).split() if "=" in word)


def shards_in(folder):
    return list(folder.rglob("*.tar"))


def sums(folder):
    """The SHA-256 of every file, hidden ones included."""
    return {str(file.relative_to(folder)): hashlib.sha256(file.read_bytes()).hexdigest()
            for file in sorted(folder.rglob("*")) if file.is_file()}


def process_of(folder, worker):
    """The id of the program that makes a worker's part of a dataset; None: there is none."""
    for entry in Path("/proc").iterdir():
        try:
            words = (entry / "cmdline").read_bytes().decode(errors="replace").split("\0")
        except OSError:
            continue
        if str(folder) in words and "--worker" in words and words[words.index("--worker") + 1] == str(worker):
            return int(entry.name)
    return None


def submit(*arguments, program=PROGRAM):
    return subprocess.run([ROOT / "scripts/slurm_generate", *map(str, arguments)], capture_output=True, text=True,
                          env={**os.environ, "SCANMILL": program})


class Usage(unittest.TestCase):
    def expect_refused(self, word, *arguments, code=2, program=PROGRAM):
        done = submit(*arguments, program=program)
        self.assertEqual(done.returncode, code, done.stderr)
        self.assertIn(word, done.stderr)

    def test_says_what_is_missing(self):
        pipeline = ROOT / "pipelines/quickstart.yaml"
        self.expect_refused("no pipeline absent.yaml", "absent.yaml", "--out", "x", "--array", 2)
        self.expect_refused("the pipeline comes first", "--out", "x", "--array", 2, pipeline)
        self.expect_refused("--out DIR is missing", pipeline, "--array", 2)
        self.expect_refused("--out needs a value", pipeline, "--array", 2, "--out")
        for array in ("", "0", "0-3", "4%", "many"):
            self.expect_refused(f"this is '{array}'", pipeline, "--out", "x", f"--array={array}")
        self.expect_refused("no program /absent/scanmill", pipeline, "--out", "x", "--array", 2, code=1,
                            program="/absent/scanmill")


    def test_refuses_control_characters(self):
        pipeline = ROOT / "pipelines/quickstart.yaml"
        for control in ("\n", "\x1b[2J", "\r", "\x7f", "\u009b2J"):
            for arguments in ((f"absent{control}", "--out", "x"), (pipeline, "--out", f"x{control}"),
                              (pipeline, f"--out={control}x"), (pipeline, "--out", "x", "--comment", control)):
                done = submit(*arguments, "--array", 2)
                self.assertEqual(done.returncode, 2, done.stderr)
                self.assertIn("has control characters", done.stderr)
                self.assertNotIn(control, done.stderr.rstrip("\n"))
            self.expect_refused("has control characters", pipeline, "--out", "x", "--array", 2,
                                program=f"/absent{control}")
        with tempfile.TemporaryDirectory(suffix="\n") as folder:
            done = subprocess.run([ROOT / "scripts/slurm_generate", pipeline, "--out", "x", "--array", "2"], cwd=folder,
                                  capture_output=True, text=True)
            self.assertEqual(done.returncode, 2, done.stderr)
        self.expect_refused("no pipeline Stra\u00dfe.yaml", "Stra\u00dfe.yaml", "--out", "x", "--array", 2)


class OnACluster(unittest.TestCase):
    TASKS = 3
    folder = None  # of pipelines and datasets

    @classmethod
    def setUpClass(cls):
        cls.folder.mkdir()
        cls.pipeline = cls.folder / "a pipeline.yaml"
        cls.pipeline.write_text(PIPELINE)
        whole = cls.folder / "whole"
        subprocess.run([PROGRAM, "generate", cls.pipeline, "-o", whole, "--quiet"], check=True, capture_output=True)
        cls.expected = sums(whole)

    def setUp(self):
        self.out = self.folder / self.id().rsplit(".", 1)[1]

    def submit(self, *more, program=PROGRAM):
        """The ids of the two jobs."""
        done = submit(self.pipeline, "--out", self.out, "--array", self.TASKS, "--time", 10, *more, program=program)
        self.assertEqual(done.returncode, 0, done.stderr)
        cancel = re.search(r"^cancel: (scancel (\d+) (\d+))$", done.stdout, re.MULTILINE)
        self.assertTrue(cancel, done.stdout)
        self.cancel = cancel[1].split()
        return cancel[2], cancel[3]

    def logs(self):
        folder = Path(f"{self.out}.logs")
        return "\n".join(f"{file.name}:\n{file.read_text()}" for file in sorted(folder.iterdir()))

    def expect_end(self, name, state):
        """Waits until a job is over, in the state that is expected."""
        def ended():
            now = job(name)["JobState"]
            return now if now not in ("PENDING", "RUNNING", "COMPLETING") else None
        self.assertEqual(wait_until(f"job {name} ends", ended), state, self.logs())

    def expect_whole(self, merge):
        self.expect_end(merge, "COMPLETED")
        self.assertEqual(sums(self.out), self.expected)

    def wait_for_shards(self):
        wait_until("there is a shard", lambda: shards_in(self.out))

    def test_makes_what_one_machine_makes(self):
        tasks, merge = self.submit()
        self.expect_whole(merge)
        for i in range(self.TASKS):
            self.assertEqual(job(f"{tasks}_{i}")["Restarts"], "0", self.logs())

    def test_refusals_leave_no_folder_behind(self):
        out = self.out / "deep" / "data"
        done = submit(self.pipeline, "--out", out, "--array", 1002)
        self.assertEqual(done.returncode, 2, done.stderr)
        self.assertIn("at most 1001 tasks (MaxArraySize): give --array 1001 or less", done.stderr)
        done = submit(self.pipeline, "--out", out, "--array", 2, "--partition=absent")
        self.assertEqual(done.returncode, 1, done.stderr)
        self.assertFalse(self.out.exists())

    def test_tasks_that_die_or_are_told_to_end_are_queued_again(self):
        tasks, merge = self.submit()
        self.wait_for_shards()
        os.kill(wait_until("worker 0 works", lambda: process_of(self.out, 0)), signal.SIGKILL)
        wait_until("worker 1 works", lambda: process_of(self.out, 1))
        slurm("scancel", "--batch", "--signal=TERM", f"{tasks}_1")
        self.expect_whole(merge)
        self.assertEqual([job(f"{tasks}_{i}")["Restarts"] for i in range(self.TASKS)], ["1", "1", "0"], self.logs())
        self.assertIn("exit code 137, start 1 of 3", self.logs())
        self.assertIn("exit code 143, start 1 of 3", self.logs())

    def test_tasks_of_a_node_that_fails_go_to_another(self):
        lost, other = NODES
        self.addCleanup(lambda: wait_until("the node is back", lambda: Cluster.idle_nodes() == len(NODES)))
        self.addCleanup(slurm, "scontrol", "update", f"NodeName={lost}", "State=RESUME")
        tasks, merge = self.submit()
        self.wait_for_shards()
        there = slurm("squeue", "--noheader", f"--nodelist={lost}", "--states=RUNNING", "--format=%i").split()
        slurm("scontrol", "update", f"NodeName={lost}", "State=DOWN", "Reason=test")
        self.expect_whole(merge)
        self.assertEqual(len(there), 1, self.logs())
        self.assertEqual(job(there[0])["Restarts"], "1", self.logs())
        self.assertEqual(job(there[0])["NodeList"], other)

    def test_cancelled_tasks_stay_so_and_the_same_command_goes_on(self):
        tasks, merge = self.submit()
        self.wait_for_shards()
        slurm(*self.cancel)
        for name in (*(f"{tasks}_{i}" for i in range(self.TASKS)), merge):
            self.expect_end(name, "CANCELLED")
        kept = {file: file.stat().st_mtime_ns for file in shards_in(self.out)}
        self.assertLess(len(kept), len(self.expected) - 1)
        _, merge = self.submit()
        self.expect_whole(merge)
        times = [file.stat().st_mtime_ns for file in shards_in(self.out)]
        for file, made in kept.items():
            self.assertIn(made, times, f"{file} was made again")

    def test_a_task_that_always_fails_is_started_three_times(self):
        tasks, merge = self.submit(program=shutil.which("false"))
        self.expect_end(merge, "CANCELLED")
        self.expect_end(f"{tasks}_0", "FAILED")
        self.assertEqual(job(f"{tasks}_0")["Restarts"], "2", self.logs())


def main():
    # A test that is told to end stops its cluster, too.
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    os.environ["PATH"] += ":/usr/sbin:/sbin"
    needed = ("munged", "mungekey", "slurmctld", "slurmd", "sbatch", "scontrol")
    missing = [name for name in needed if not shutil.which(name)]
    if missing:
        print(f"left out: {', '.join(missing)}; Debian has them in munge, slurmctld, slurmd and slurm-client")
        done = unittest.main(exit=False, defaultTest="Usage").result
        return SKIPPED if done.wasSuccessful() else 1
    with tempfile.TemporaryDirectory(prefix="slurm") as folder, Cluster(Path(folder)) as cluster:
        OnACluster.folder = cluster.folder / "50%j of 'it'"  # what a shell and Slurm's patterns would stumble over
        done = unittest.main(exit=False).result
        if not done.wasSuccessful():
            print(cluster.output(), file=sys.stderr)
    return 0 if done.wasSuccessful() else 1


if __name__ == "__main__":
    sys.exit(main())
