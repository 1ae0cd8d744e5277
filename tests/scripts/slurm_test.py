"""The array of jobs that docs/scale.md submits, on a real Slurm cluster of two nodes that the test starts on this machine:
the dataset is the one that a single process makes, also where a task dies.

    SCANMILL=/path/to/scanmill python3 slurm_test.py     the program in place of build/release/scanmill

Ends with 77, which ctest takes for skipped, where Slurm is not installed.
"""

import ctypes
import getpass
import os
import re
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

from support import PROGRAM, ROOT, tree, wait_until

SKIPPED = 77
NODES = ("n1", "n2")

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


def shards_in(folder):
    return list(folder.rglob("*.tar"))


def processes_of(folder):
    """The ids of the programs that make a dataset in this folder."""
    found = []
    for entry in Path("/proc").iterdir():
        try:
            words = (entry / "cmdline").read_bytes().decode(errors="replace").split("\0")
        except OSError:
            continue
        if words[0] == PROGRAM and str(folder) in words:
            found.append(int(entry.name))
    return found


class OnACluster(unittest.TestCase):
    folder = None  # of pipelines and datasets

    def test_an_array_makes_what_one_process_makes(self):
        self.folder.mkdir()
        pipeline = self.folder / "pipeline.yaml"
        pipeline.write_text(PIPELINE)
        whole, shared = self.folder / "whole", self.folder / "shared"
        subprocess.run([PROGRAM, "generate", pipeline, "-o", whole, "--quiet"], check=True, capture_output=True)
        array = slurm("sbatch", "--parsable", "--array=0-3", "--time=10", f"--output={self.folder}/%a.log", "--wrap",
                      f"{PROGRAM} generate {pipeline} -o {shared} --workers auto --quiet").strip()
        wait_until("there is a shard", lambda: shards_in(shared))
        os.kill(wait_until("a task works", lambda: processes_of(shared))[0], signal.SIGKILL)
        wait_until("the array ends", lambda: not slurm("squeue", "--noheader", "--name=wrap").strip())
        logs = "\n".join(file.read_text() for file in self.folder.glob("*.log"))
        self.assertEqual(tree(shared), tree(whole), f"array {array}:\n{logs}")


def main():
    # A test that is told to end stops its cluster, too.
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    os.environ["PATH"] += ":/usr/sbin:/sbin"
    needed = ("munged", "mungekey", "slurmctld", "slurmd", "sbatch", "scontrol")
    missing = [name for name in needed if not shutil.which(name)]
    if missing:
        print(f"left out: {', '.join(missing)}; Debian has them in munge, slurmctld, slurmd and slurm-client")
        return SKIPPED
    with tempfile.TemporaryDirectory(prefix="slurm") as folder, Cluster(Path(folder)) as cluster:
        OnACluster.folder = cluster.folder / "datasets"
        done = unittest.main(exit=False).result
        if not done.wasSuccessful():
            print(cluster.output(), file=sys.stderr)
    return 0 if done.wasSuccessful() else 1


if __name__ == "__main__":
    sys.exit(main())
